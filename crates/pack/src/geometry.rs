//! What rays are intersected with: one structure of arrays a kind of shape, rows in key order.

use crate::bounds::Aabb;
use crate::ids::{PrimId, SurfaceId};
use crate::solids::Solids;

/// Three columns: x, y, z.
#[derive(Clone, Debug, Default)]
pub struct Columns3 {
    /// Along x.
    pub x: Vec<f32>,
    /// Along y.
    pub y: Vec<f32>,
    /// Along z.
    pub z: Vec<f32>,
}

impl Columns3 {
    /// Row `i`.
    #[inline]
    pub fn get(&self, i: usize) -> [f32; 3] {
        [self.x[i], self.y[i], self.z[i]]
    }

    pub(crate) fn set(&mut self, i: usize, v: [f32; 3]) {
        (self.x[i], self.y[i], self.z[i]) = (v[0], v[1], v[2]);
    }

    pub(crate) fn push(&mut self, v: [f32; 3]) {
        self.x.push(v[0]);
        self.y.push(v[1]);
        self.z.push(v[2]);
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.x.truncate(n);
        self.y.truncate(n);
        self.z.truncate(n);
    }
}

/// Spheres.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// Centres.
    pub center: Columns3,
    /// Radii, above 0.
    pub radius: Vec<f32>,
    /// Which primitive each is.
    pub prim: Vec<PrimId>,
}

/// Infinite planes.
#[derive(Clone, Debug, Default)]
pub struct Planes {
    /// A point of each.
    pub point: Columns3,
    /// Unit normals.
    pub normal: Columns3,
    /// Which primitive each is.
    pub prim: Vec<PrimId>,
}

/// Parallelograms.
#[derive(Clone, Debug, Default)]
pub struct Quads {
    /// The corners in order around: corner, corner + u, corner + u + v, corner + v.
    pub corners: [Columns3; 4],
    /// Unit normals along u x v.
    pub normal: Columns3,
    /// Which primitive each is.
    pub prim: Vec<PrimId>,
}

/// Triangles: those of the script and those of all meshes.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// The three corners.
    pub corners: [Columns3; 3],
    /// Unit normals along (b - a) x (c - a).
    pub normal: Columns3,
    /// Which primitive each is.
    pub prim: Vec<PrimId>,
}

/// The kinds of primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ShapeKind {
    /// A row of [`Spheres`].
    Sphere,
    /// A row of [`Planes`].
    Plane,
    /// A row of [`Quads`].
    Quad,
    /// A row of [`Triangles`].
    Triangle,
    /// A row of [`Solids`].
    Solid,
}

/// How many kinds there are.
pub const SHAPE_KINDS: usize = 5;

impl ShapeKind {
    /// All kinds, each at the index that it is as a number.
    pub const ALL: [ShapeKind; SHAPE_KINDS] = [
        ShapeKind::Sphere,
        ShapeKind::Plane,
        ShapeKind::Quad,
        ShapeKind::Triangle,
        ShapeKind::Solid,
    ];
}

/// All primitives.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// Spheres.
    pub spheres: Spheres,
    /// Infinite planes.
    pub planes: Planes,
    /// Parallelograms.
    pub quads: Quads,
    /// Triangles.
    pub triangles: Triangles,
    /// Curved shapes and discs.
    pub solids: Solids,
    /// By [`PrimId`]: which kind, and which row of its columns.
    pub shape: Vec<(ShapeKind, u32)>,
    /// By [`PrimId`]: the surface that it belongs to.
    pub surface: Vec<SurfaceId>,
    /// By [`PrimId`]: its own box; [`Aabb::EMPTY`] when it is invisible, [`Aabb::INFINITE`] for a
    /// plane.
    pub bounds: Vec<Aabb>,
}

impl Geometry {
    /// How many primitives there are, visible or not.
    pub fn len(&self) -> usize {
        self.shape.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.shape.is_empty()
    }

    /// Whether rays can hit the primitive at all.
    pub fn is_visible(&self, prim: PrimId) -> bool {
        !self.bounds[prim.index()].is_empty()
    }
}

impl Spheres {
    pub(crate) fn row(&self, i: usize) -> ([f32; 3], f32) {
        (self.center.get(i), self.radius[i])
    }
}

impl Quads {
    /// The four corners of row `i`.
    pub fn points(&self, i: usize) -> [[f32; 3]; 4] {
        [0, 1, 2, 3].map(|k| self.corners[k].get(i))
    }
}

impl Triangles {
    /// The three corners of row `i`.
    pub fn points(&self, i: usize) -> [[f32; 3]; 3] {
        [0, 1, 2].map(|k| self.corners[k].get(i))
    }
}
