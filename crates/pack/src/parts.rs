//! What a surface is made of, in `f64`: one part a primitive, put into the scene by the places of
//! the groups and instances that hold it.

use crate::bounds::Aabb;
use crate::copies::faced;
use crate::geometry::{Geometry, ShapeKind};
use crate::packer::f32s;
use crate::solids::{Form, Solid};
use crate::view::unit;
use glam::{DAffine3, DMat3, DVec3};
use reflet_scene::{
    Caps, Cone, Cuboid, Cylinder, Disc, Ellipsoid, Hyperboloid, Key, Paraboloid, Place, Plane,
    Quad, Scene, Sphere, Torus, Triangle,
};

/// One primitive of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Plane {
        point: DVec3,
        normal: DVec3,
    },
    /// Corners in order around.
    Quad {
        points: [DVec3; 4],
        normal: DVec3,
    },
    Triangle {
        points: [DVec3; 3],
        normal: DVec3,
    },
    /// A form in its own coordinates, and its way into the scene.
    Solid {
        form: Form,
        world: DAffine3,
    },
}

/// Where a surface's patterns begin, and its own normal if it is flat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub origin: DVec3,
    pub normal: Option<DVec3>,
}

/// The parts of a surface other than a mesh, as it stands in its own coordinates.
pub(crate) fn parts(scene: &Scene, key: Key) -> Option<(Vec<Part>, Anchor)> {
    let curved = |origin| Anchor { origin, normal: None };
    let flat = |origin, normal| Anchor { origin, normal: Some(normal) };
    if let Some(Sphere { center, radius }) = scene.get(key) {
        return Some((vec![Part::Sphere { center, radius }], curved(center)));
    }
    if let Some(Plane { point, normal }) = scene.get(key) {
        return Some((vec![Part::Plane { point, normal }], flat(point, normal)));
    }
    if let Some(q) = scene.get::<Quad>(key) {
        let points = [q.corner, q.corner + q.u, q.corner + q.u + q.v, q.corner + q.v];
        let normal = q.normal();
        return Some((vec![Part::Quad { points, normal }], flat(q.corner, normal)));
    }
    if let Some(t) = scene.get::<Triangle>(key) {
        let normal = t.normal();
        let part = Part::Triangle { points: [t.a, t.b, t.c], normal };
        return Some((vec![part], flat(t.a, normal)));
    }
    if let Some(Disc { center, normal, radius }) = scene.get(key) {
        let part = disc(&upright(center, normal), 0.0, radius);
        return Some((vec![part], flat(center, normal)));
    }
    if let Some(cuboid) = scene.get::<Cuboid>(key) {
        let [min, max] = cuboid.corners();
        return Some((faces(min, max).to_vec(), curved(min)));
    }
    if let Some(Ellipsoid { center, radii }) = scene.get(key) {
        let world = DAffine3::from_mat3_translation(DMat3::from_diagonal(radii), center);
        return Some((vec![Part::Solid { form: Form::BALL, world }], curved(center)));
    }
    if let Some(Torus { center, axis, major, minor }) = scene.get(key) {
        let form = Form::Torus { major, minor };
        let world = upright(center, axis);
        return Some((vec![Part::Solid { form, world }], curved(center)));
    }
    revolved(scene, key)
}

/// The quadrics of revolution: the wall, then its caps.
fn revolved(scene: &Scene, key: Key) -> Option<(Vec<Part>, Anchor)> {
    let (origin, axis, profile, z, caps);
    if let Some(Cylinder { base, axis: a, radius: r, height: h, caps: c }) = scene.get(key) {
        (origin, axis, profile, z, caps) = (base, a, [r * r, 0.0, 0.0], [0.0, h], c);
    } else if let Some(Cone { apex, axis: a, radius: r, height: h, caps: c }) = scene.get(key) {
        let slope = r / h;
        (origin, axis, profile, z, caps) = (apex, a, [0.0, 0.0, slope * slope], [0.0, h], c);
    } else if let Some(Paraboloid { vertex, axis: a, radius: r, height: h, caps: c }) =
        scene.get(key)
    {
        (origin, axis, profile, z, caps) = (vertex, a, [0.0, r * r / h, 0.0], [0.0, h], c);
    } else {
        let Hyperboloid { center, axis: a, radius: r, waist, height: h, caps: c } =
            scene.get(key)?;
        let growth = (r * r - waist * waist) / (h * h);
        (origin, axis, profile, z, caps) = (center, a, [waist * waist, 0.0, growth], [-h, h], c);
    }
    let world = upright(origin, axis);
    let mut parts = vec![Part::Solid { form: Form::Revolved { profile, z }, world }];
    if caps == Caps::Closed {
        let radius = |z: f64| (profile[0] + profile[1] * z + profile[2] * z * z).sqrt();
        // A pointed end has no cap.
        parts
            .extend(z.into_iter().filter(|z| radius(*z) > 0.0).map(|z| disc(&world, z, radius(z))));
    }
    Some((parts, Anchor { origin, normal: None }))
}

/// The disc across the axis of `world` at z.
fn disc(world: &DAffine3, z: f64, radius: f64) -> Part {
    let m = world.matrix3;
    let world = DAffine3::from_mat3_translation(
        DMat3::from_cols(m.x_axis * radius, m.y_axis * radius, m.z_axis),
        world.translation + m.z_axis * z,
    );
    Part::Solid { form: Form::Disc, world }
}

/// The turn that brings z to `axis`, and x to the scene's x as far as it lies across.
fn upright(origin: DVec3, axis: DVec3) -> DAffine3 {
    let z = unit(axis);
    let x = across(DVec3::X, z).unwrap_or(DVec3::Y);
    DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), origin)
}

/// The unit vector along the part of `v` across the unit vector `n`, if there is any to speak of.
pub(crate) fn across(v: DVec3, n: DVec3) -> Option<DVec3> {
    let rest = v - n * v.dot(n);
    (rest.length() > 1e-9 * v.length()).then(|| unit(rest))
}

/// The six faces of a box, seen from outside with u to the right and v up; those across y have u
/// along x.
fn faces(min: DVec3, max: DVec3) -> [Part; 6] {
    let [(x0, y0, z0), (x1, y1, z1)] = [(min.x, min.y, min.z), (max.x, max.y, max.z)];
    let face = |normal: DVec3, points: [[f64; 3]; 4]| Part::Quad {
        points: points.map(DVec3::from_array),
        normal,
    };
    [
        face(-DVec3::X, [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]]),
        face(DVec3::X, [[x1, y0, z1], [x1, y0, z0], [x1, y1, z0], [x1, y1, z1]]),
        face(-DVec3::Y, [[x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]]),
        face(DVec3::Y, [[x0, y1, z1], [x1, y1, z1], [x1, y1, z0], [x0, y1, z0]]),
        face(-DVec3::Z, [[x1, y0, z0], [x0, y0, z0], [x0, y1, z0], [x1, y1, z0]]),
        face(DVec3::Z, [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]]),
    ]
}

impl Part {
    /// The part as `to` moves it.
    pub fn moved(self, to: &DAffine3) -> Part {
        let p = |v: DVec3| to.transform_point3(v);
        match self {
            Part::Sphere { center, radius } => match uniform(&to.matrix3) {
                Some(scale) => Part::Sphere { center: p(center), radius: radius * scale },
                None => {
                    let ball = DMat3::from_diagonal(DVec3::splat(radius));
                    let world = *to * DAffine3::from_mat3_translation(ball, center);
                    Part::Solid { form: Form::BALL, world }
                }
            },
            Part::Plane { point, normal } => {
                Part::Plane { point: p(point), normal: turned(to, normal) }
            }
            Part::Quad { points, normal } => {
                Part::Quad { points: points.map(p), normal: turned(to, normal) }
            }
            Part::Triangle { points, normal } => {
                Part::Triangle { points: points.map(p), normal: turned(to, normal) }
            }
            Part::Solid { form, world } => Part::Solid { form, world: *to * world },
        }
    }

    /// Whose rows it is one of.
    pub fn kind(&self) -> ShapeKind {
        match self {
            Part::Sphere { .. } => ShapeKind::Sphere,
            Part::Plane { .. } => ShapeKind::Plane,
            Part::Quad { .. } => ShapeKind::Quad,
            Part::Triangle { .. } => ShapeKind::Triangle,
            Part::Solid { .. } => ShapeKind::Solid,
        }
    }
}

/// A normal as `to` turns it.
fn turned(to: &DAffine3, normal: DVec3) -> DVec3 {
    to.matrix3.inverse().transpose() * normal
}

/// The factor by which a matrix scales all lengths, if it does nothing else but turn. (Rotations are
/// orthogonal to some units in the last place, 2^-53.)
fn uniform(m: &DMat3) -> Option<f64> {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let square = x.dot(x);
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * square;
    let alike = near(y.dot(y), square) && near(z.dot(z), square);
    let right = near(x.dot(y), 0.0) && near(y.dot(z), 0.0) && near(z.dot(x), 0.0);
    (alike && right).then(|| square.sqrt())
}

/// The way of points that a place puts elsewhere.
pub(crate) fn affine(place: &Place) -> DAffine3 {
    let turn = crate::rows::rotation(place.rotate);
    DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(place.scale), place.translate)
}

impl Geometry {
    /// Writes a part into a slot's row, which is of its kind.
    pub(crate) fn set_part(&mut self, slot: usize, part: &Part) {
        match *part {
            Part::Sphere { center, radius } => self.place_sphere(slot, f32s(center), radius as f32),
            Part::Plane { point, normal } => {
                let row = self.row_of(slot);
                self.planes.point.set(row, f32s(point));
                self.planes.normal.set(row, f32s(unit(normal)));
                self.bounds[slot] = Aabb::INFINITE;
            }
            Part::Quad { points, normal } => {
                let row = self.row_of(slot);
                let points = points.map(f32s);
                for (column, p) in self.quads.corners.iter_mut().zip(points) {
                    column.set(row, p);
                }
                self.quads.normal.set(row, f32s(unit(normal)));
                self.bounds[slot] = Aabb::of_points(&points);
            }
            Part::Triangle { points, normal } => {
                let points = points.map(f32s);
                self.set_triangle(slot, points, faced(points, normal));
            }
            Part::Solid { form, world } => {
                let row = self.row_of(slot);
                (self.solids.rows[row], self.bounds[slot]) = Solid::new(form, &world);
            }
        }
    }
}
