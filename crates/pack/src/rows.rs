//! Rows of surfaces and primitives: blank ones, and how a shape fills them.

use crate::bounds::Aabb;
use crate::copies::{MeshCopy, World, facing, put};
use crate::geometry::{Geometry, SHAPE_KINDS, ShapeKind};
use crate::ids::{PrimId, SurfaceId};
use crate::materials::Materials;
use crate::solids::Solid;
use crate::surfaces::{Paint, Surfaces};
use glam::{DAffine3, DMat3, DVec3};
use reflet_scene::{Key, Mesh, MeshData};
use std::sync::Arc;

impl Surfaces {
    pub(crate) fn push_blank(
        &mut self,
        key: Key,
        first: PrimId,
        prims: u32,
        mesh: Option<Arc<Mesh>>,
    ) {
        self.key.push(key);
        self.paint.push(Paint::plain(Materials::GREY_MATT));
        self.first_prim.push(first);
        self.prims.push(prims);
        self.visible.push(true);
        self.mesh.push(mesh);
        self.moved_by.push(None);
        self.smooth.push(None);
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.key.truncate(n);
        for paint in self.paint.split_off(n.min(self.paint.len())) {
            self.count_tint(&paint, usize::wrapping_sub);
        }
        self.first_prim.truncate(n);
        self.prims.truncate(n);
        self.visible.truncate(n);
        self.mesh.truncate(n);
        self.moved_by.truncate(n);
        self.truncate_smooth(n);
    }
}

impl Geometry {
    pub(crate) fn push_blank(&mut self, kind: ShapeKind, surface: SurfaceId) {
        let row = match kind {
            ShapeKind::Sphere => {
                self.spheres.center.push([0.0; 3]);
                self.spheres.radius.push(1.0);
                self.spheres.len()
            }
            ShapeKind::Plane => {
                self.planes.point.push([0.0; 3]);
                self.planes.normal.push([0.0; 3]);
                self.planes.len()
            }
            ShapeKind::Quad => {
                self.quads.corners.iter_mut().for_each(|c| c.push([0.0; 3]));
                self.quads.normal.push([0.0; 3]);
                self.quads.len()
            }
            ShapeKind::Triangle => {
                self.triangles.corners.iter_mut().for_each(|c| c.push([0.0; 3]));
                self.triangles.normal.push([0.0; 3]);
                self.triangles.len()
            }
            ShapeKind::Solid => {
                self.solids.rows.push(Solid::BLANK);
                self.solids.len()
            }
            ShapeKind::Copy => self.copies.len(),
        };
        self.shape.push((kind, row as u32 - 1));
        self.surface.push(surface);
        self.bounds.push(Aabb::EMPTY);
    }

    /// Appends all triangles of a mesh in one slot, put into the scene by `world`.
    pub(crate) fn push_copy(&mut self, surface: SurfaceId, copy: MeshCopy) {
        let slot = self.len();
        self.runs.note_copy(slot, PrimId(self.prims()), copy.len());
        self.copies.push(copy);
        self.push_blank(ShapeKind::Copy, surface);
    }

    pub(crate) fn truncate(
        &mut self,
        slots: usize,
        [spheres, planes, quads, triangles, solids, copies]: [usize; SHAPE_KINDS],
    ) {
        self.spheres.center.truncate(spheres);
        self.spheres.radius.truncate(spheres);
        self.planes.point.truncate(planes);
        self.planes.normal.truncate(planes);
        self.quads.corners.iter_mut().for_each(|c| c.truncate(quads));
        self.quads.normal.truncate(quads);
        self.triangles.corners.iter_mut().for_each(|c| c.truncate(triangles));
        self.triangles.normal.truncate(triangles);
        self.solids.rows.truncate(solids);
        self.copies.truncate(copies);
        self.shape.truncate(slots);
        self.surface.truncate(slots);
        self.bounds.truncate(slots);
        self.runs.truncate(slots);
    }

    /// How many rows there are of each kind.
    pub(crate) fn rows_by_kind(&self) -> [usize; SHAPE_KINDS] {
        [
            self.spheres.len(),
            self.planes.len(),
            self.quads.len(),
            self.triangles.len(),
            self.solids.len(),
            self.copies.len(),
        ]
    }

    pub(crate) fn row_of(&self, slot: usize) -> usize {
        self.shape[slot].1 as usize
    }

    /// Appends a sphere that wears nothing, and gives its id: primitives without a scene, to cast
    /// rays at. One whose radius is not above 0, or that has a number that is not finite, is no
    /// rays' to hit.
    pub fn push_sphere(&mut self, center: [f32; 3], radius: f32) -> PrimId {
        let (slot, prim) = (self.len(), PrimId(self.prims()));
        self.push_blank(ShapeKind::Sphere, SurfaceId(slot as u32));
        self.place_sphere(slot, center, radius);
        if !(radius > 0.0 && center.iter().chain([&radius]).all(|x| x.is_finite())) {
            self.bounds[slot] = Aabb::EMPTY;
        }
        prim
    }

    /// Appends a triangle that wears nothing, and gives its id. One without an area, or with a
    /// corner that is not finite, is no rays' to hit.
    pub fn push_triangle(&mut self, corners: [[f32; 3]; 3]) -> PrimId {
        let (slot, prim) = (self.len(), PrimId(self.prims()));
        self.push_blank(ShapeKind::Triangle, SurfaceId(slot as u32));
        self.set_triangle(slot, corners, facing(corners));
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            self.bounds[slot] = Aabb::EMPTY;
        }
        prim
    }

    /// Appends a triangle of a mesh in the file's own coordinates, with its box whatever its area:
    /// put into the scene, it may have one.
    pub fn push_candidate(&mut self, corners: [[f32; 3]; 3]) {
        let slot = self.len();
        self.push_blank(ShapeKind::Triangle, SurfaceId(slot as u32));
        self.set_triangle(slot, corners, ([0.0; 3], Aabb::of_points(&corners)));
    }

    pub(crate) fn place_sphere(&mut self, slot: usize, c: [f32; 3], r: f32) {
        let row = self.row_of(slot);
        self.spheres.center.set(row, c);
        self.spheres.radius[row] = r;
        // The box of the sphere that the kernels see: rounded centre and radius.
        let (c, r) = (c.map(f64::from), f64::from(r));
        self.bounds[slot] = Aabb::outward(c.map(|x| x - r), c.map(|x| x + r));
    }

    pub(crate) fn set_triangle(
        &mut self,
        slot: usize,
        points: [[f32; 3]; 3],
        (normal, bounds): ([f32; 3], Aabb),
    ) {
        let row = self.row_of(slot);
        for (column, p) in self.triangles.corners.iter_mut().zip(points) {
            column.set(row, p);
        }
        self.triangles.normal.set(row, normal);
        self.bounds[slot] = bounds;
    }

    /// Puts a mesh where it is, in slots from `first` on.
    pub(crate) fn place_mesh(&mut self, first: usize, data: &MeshData, world: &World) {
        match self.shape.get(first) {
            Some((ShapeKind::Copy, row)) => {
                let copy = &mut self.copies[*row as usize];
                copy.world = *world;
                self.bounds[first] = copy.bounds();
            }
            _ => self.set_mesh(first, data, world),
        }
    }

    /// Stores the triangles of a mesh in slots from `first` on: each vertex once, so that neighbours
    /// share it.
    fn set_mesh(&mut self, first: usize, data: &MeshData, world: &World) {
        let placed: Vec<[f32; 3]> = data.positions.iter().map(|p| put(world, *p)).collect();
        for (slot, t) in (first..).zip(&data.triangles) {
            let points = t.map(|v| placed[v as usize]);
            self.set_triangle(slot, points, facing(points));
        }
    }
}

/// About x, then y, then z, counter-clockwise seen from the tips of the axes. Right angles are exact.
pub(crate) fn rotation(degrees: DVec3) -> DMat3 {
    let [x, y, z] = degrees.to_array().map(sin_cos);
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, x.1, x.0), DVec3::new(0.0, -x.0, x.1));
    let about_y = DMat3::from_cols(DVec3::new(y.1, 0.0, -y.0), DVec3::Y, DVec3::new(y.0, 0.0, y.1));
    let about_z = DMat3::from_cols(DVec3::new(z.1, z.0, 0.0), DVec3::new(-z.0, z.1, 0.0), DVec3::Z);
    about_z * about_y * about_x
}

fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarters = libm::round(degrees / 90.0);
    let rest = (degrees - quarters * 90.0).to_radians();
    let (s, c) = (libm::sin(rest), libm::cos(rest));
    match quarters.rem_euclid(4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// How the normals of a mesh's file turn into the scene, but for their length.
pub(crate) fn normal_turn(mesh: &Mesh, to: Option<&DAffine3>) -> [[f64; 3]; 3] {
    let own = rotation(mesh.rotate) * mesh.scale;
    let all = to.map_or(own, |to| to.matrix3 * own);
    let m = all.inverse().transpose();
    [0, 1, 2].map(|k| [m.x_axis[k], m.y_axis[k], m.z_axis[k]])
}
