//! Rows of surfaces and primitives: blank ones, and how a shape fills them.

use crate::bounds::Aabb;
use crate::geometry::{Geometry, SHAPE_KINDS, ShapeKind};
use crate::ids::{PrimId, SurfaceId};
use crate::materials::Materials;
use crate::packer::f32s;
use crate::solids::Solid;
use crate::surfaces::{Paint, Surfaces};
use crate::view::unit;
use glam::{DAffine3, DMat3, DVec3};
use reflet_scene::{Key, Mesh};
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
        let prim = PrimId(self.len() as u32);
        let row = match kind {
            ShapeKind::Sphere => {
                self.spheres.center.push([0.0; 3]);
                self.spheres.radius.push(1.0);
                self.spheres.prim.push(prim);
                self.spheres.prim.len()
            }
            ShapeKind::Plane => {
                self.planes.point.push([0.0; 3]);
                self.planes.normal.push([0.0; 3]);
                self.planes.prim.push(prim);
                self.planes.prim.len()
            }
            ShapeKind::Quad => {
                self.quads.corners.iter_mut().for_each(|c| c.push([0.0; 3]));
                self.quads.normal.push([0.0; 3]);
                self.quads.prim.push(prim);
                self.quads.prim.len()
            }
            ShapeKind::Triangle => {
                self.triangles.corners.iter_mut().for_each(|c| c.push([0.0; 3]));
                self.triangles.normal.push([0.0; 3]);
                self.triangles.prim.push(prim);
                self.triangles.prim.len()
            }
            ShapeKind::Solid => {
                self.solids.rows.push(Solid::BLANK);
                self.solids.prim.push(prim);
                self.solids.prim.len()
            }
        };
        self.shape.push((kind, row as u32 - 1));
        self.surface.push(surface);
        self.bounds.push(Aabb::EMPTY);
    }

    pub(crate) fn truncate(
        &mut self,
        prims: usize,
        [spheres, planes, quads, triangles, solids]: [usize; SHAPE_KINDS],
    ) {
        self.spheres.center.truncate(spheres);
        self.spheres.radius.truncate(spheres);
        self.spheres.prim.truncate(spheres);
        self.planes.point.truncate(planes);
        self.planes.normal.truncate(planes);
        self.planes.prim.truncate(planes);
        self.quads.corners.iter_mut().for_each(|c| c.truncate(quads));
        self.quads.normal.truncate(quads);
        self.quads.prim.truncate(quads);
        self.triangles.corners.iter_mut().for_each(|c| c.truncate(triangles));
        self.triangles.normal.truncate(triangles);
        self.triangles.prim.truncate(triangles);
        self.solids.rows.truncate(solids);
        self.solids.prim.truncate(solids);
        self.shape.truncate(prims);
        self.surface.truncate(prims);
        self.bounds.truncate(prims);
    }

    /// How many rows there are of each kind.
    pub(crate) fn rows_by_kind(&self) -> [usize; SHAPE_KINDS] {
        [
            self.spheres.prim.len(),
            self.planes.prim.len(),
            self.quads.prim.len(),
            self.triangles.prim.len(),
            self.solids.prim.len(),
        ]
    }

    pub(crate) fn row_of(&self, prim: usize) -> usize {
        self.shape[prim].1 as usize
    }

    /// Appends a sphere that wears nothing, and gives its id: primitives without a scene, to cast
    /// rays at. One whose radius is not above 0, or that has a number that is not finite, is no
    /// rays' to hit.
    pub fn push_sphere(&mut self, center: [f32; 3], radius: f32) -> PrimId {
        let prim = self.len();
        self.push_blank(ShapeKind::Sphere, SurfaceId(prim as u32));
        self.place_sphere(prim, center, radius);
        if !(radius > 0.0 && center.iter().chain([&radius]).all(|x| x.is_finite())) {
            self.bounds[prim] = Aabb::EMPTY;
        }
        PrimId(prim as u32)
    }

    /// Appends a triangle that wears nothing, and gives its id. One without an area, or with a
    /// corner that is not finite, is no rays' to hit.
    pub fn push_triangle(&mut self, corners: [[f32; 3]; 3]) -> PrimId {
        let prim = self.len();
        self.push_blank(ShapeKind::Triangle, SurfaceId(prim as u32));
        self.set_triangle(prim, corners, None);
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            self.bounds[prim] = Aabb::EMPTY;
        }
        PrimId(prim as u32)
    }

    pub(crate) fn place_sphere(&mut self, prim: usize, c: [f32; 3], r: f32) {
        let row = self.row_of(prim);
        self.spheres.center.set(row, c);
        self.spheres.radius[row] = r;
        // The box of the sphere that the kernels see: rounded centre and radius.
        let (c, r) = (c.map(f64::from), f64::from(r));
        self.bounds[prim] = Aabb::outward(c.map(|x| x - r), c.map(|x| x + r));
    }

    /// `normal` is that of the unrounded corners, if there are any.
    pub(crate) fn set_triangle(
        &mut self,
        prim: usize,
        points: [[f32; 3]; 3],
        normal: Option<DVec3>,
    ) {
        let row = self.row_of(prim);
        for (column, p) in self.triangles.corners.iter_mut().zip(points) {
            column.set(row, p);
        }
        let [a, b, c] = points.map(|p| DVec3::from_array(p.map(f64::from)));
        let normal = normal.unwrap_or_else(|| (b - a).cross(c - a));
        let has_area = normal.length() > 0.0;
        self.triangles.normal.set(row, if has_area { f32s(unit(normal)) } else { [0.0; 3] });
        // A placement may flatten a triangle of a mesh: it is no longer there.
        self.bounds[prim] = if has_area { Aabb::of_points(&points) } else { Aabb::EMPTY };
    }

    /// Places the triangles of a mesh: each vertex once in `f64`, so that neighbours share it. `to`
    /// moves them on.
    pub(crate) fn set_mesh(&mut self, first: usize, mesh: &Mesh, to: Option<&DAffine3>) {
        let turn = rotation(mesh.rotate);
        let placed: Vec<[f32; 3]> = mesh
            .data
            .positions
            .iter()
            .map(|p| {
                let p = DVec3::from_array(p.map(f64::from)) * mesh.scale;
                let placed = turn * p + mesh.translate;
                f32s(to.map_or(placed, |to| to.transform_point3(placed)))
            })
            .collect();
        for (i, t) in mesh.data.triangles.iter().enumerate() {
            self.set_triangle(first + i, t.map(|v| placed[v as usize]), None);
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
