//! What rays are intersected with: one structure of arrays a kind of shape, rows in key order.

use crate::bounds::Aabb;
use crate::copies::{MeshCopy, Runs};
use crate::ids::{PrimId, Slot, SurfaceId};
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

    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
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
}

/// Infinite planes.
#[derive(Clone, Debug, Default)]
pub struct Planes {
    /// A point of each.
    pub point: Columns3,
    /// Unit normals.
    pub normal: Columns3,
}

/// Parallelograms.
#[derive(Clone, Debug, Default)]
pub struct Quads {
    /// The corners in order around: corner, corner + u, corner + u + v, corner + v.
    pub corners: [Columns3; 4],
    /// Unit normals along u x v.
    pub normal: Columns3,
}

/// Triangles: those of the script, and those of meshes that are not copies.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// The three corners.
    pub corners: [Columns3; 3],
    /// Unit normals along (b - a) x (c - a).
    pub normal: Columns3,
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
    /// A row of [`Geometry::copies`]: all triangles of a mesh.
    Copy,
}

/// How many kinds there are.
pub const SHAPE_KINDS: usize = 6;

impl ShapeKind {
    /// All kinds, each at the index that it is as a number.
    pub const ALL: [ShapeKind; SHAPE_KINDS] = [
        ShapeKind::Sphere,
        ShapeKind::Plane,
        ShapeKind::Quad,
        ShapeKind::Triangle,
        ShapeKind::Solid,
        ShapeKind::Copy,
    ];
}

/// All primitives. Columns that all kinds have are in [`Slot`]s: one a primitive, but one for all
/// triangles of a mesh's copy.
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
    /// Meshes of which no triangle is stored.
    pub copies: Vec<MeshCopy>,
    /// By [`Slot`]: which kind, and which row of its columns.
    pub shape: Vec<(ShapeKind, u32)>,
    /// By [`Slot`]: the surface that it belongs to.
    pub surface: Vec<SurfaceId>,
    /// By [`Slot`]: its own box, or one around those of a copy's triangles; [`Aabb::EMPTY`] when it
    /// is invisible, [`Aabb::INFINITE`] for a plane.
    pub bounds: Vec<Aabb>,
    pub(crate) runs: Runs,
}

impl Geometry {
    /// How many slots there are, visible or not.
    pub fn len(&self) -> usize {
        self.shape.len()
    }

    /// All slots.
    pub fn slots(&self) -> impl Iterator<Item = Slot> + use<> {
        (0..self.len() as u32).map(Slot)
    }

    /// How many primitives there are, visible or not.
    pub fn prims(&self) -> u32 {
        self.runs.first_of(Slot(self.len() as u32)).0
    }

    /// Where a primitive is, and which of that slot's primitives it is: 0 but in a copy.
    #[inline]
    pub fn slot_of(&self, prim: PrimId) -> (Slot, usize) {
        self.runs.slot_of(prim)
    }

    /// The primitive in a slot; of a copy the first.
    #[inline]
    pub fn first_prim(&self, slot: Slot) -> PrimId {
        self.runs.first_of(slot)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.shape.is_empty()
    }

    /// The corners of a triangle, stored or not.
    pub fn triangle(&self, prim: PrimId) -> Option<[[f32; 3]; 3]> {
        let (slot, which) = self.slot_of(prim);
        match *self.shape.get(slot.index())? {
            (ShapeKind::Triangle, row) => Some(self.triangles.points(row as usize)),
            (ShapeKind::Copy, row) => Some(self.copies[row as usize].triangle(which)),
            _ => None,
        }
    }

    /// Whether rays can hit what is in a slot at all.
    #[inline]
    pub fn is_visible(&self, slot: Slot) -> bool {
        !self.bounds[slot.index()].is_empty()
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

impl Spheres {
    pub(crate) fn len(&self) -> usize {
        self.radius.len()
    }
}

impl Planes {
    /// How many there are, visible or not.
    pub fn len(&self) -> usize {
        self.point.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.point.is_empty()
    }
}

impl Quads {
    pub(crate) fn len(&self) -> usize {
        self.normal.len()
    }
}

impl Triangles {
    pub(crate) fn len(&self) -> usize {
        self.normal.len()
    }
}
