//! Where rays meet surfaces, which way a surface faces, and in which tile of a pattern a point is.

use super::scene::{Checker, Shape};
use super::vec3::Vec3;

/// The surface that a ray leaves, and whether it was hit from its inside (spheres only).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    pub surface: usize,
    pub inside: bool,
}

/// The smallest `t > 0` at which `base + t * dir` meets `shape`; `dir` is of length 1.
pub fn root(shape: &Shape, base: Vec3, dir: Vec3) -> Option<f64> {
    match *shape {
        Shape::Sphere { center, radius } => {
            let from_center = base - center;
            let along = from_center.dot(dir);
            let aside = from_center - dir * along;
            let discriminant = radius * radius - aside.dot(aside);
            if discriminant < 0.0 {
                return None;
            }
            let half_chord = discriminant.sqrt();
            [-along - half_chord, -along + half_chord].into_iter().find(|t| *t > 0.0)
        }
        Shape::Plane { point, normal } => flat_root(point, normal, base, dir),
        Shape::Quad { corner, u, v } => {
            let t = flat_root(corner, u.cross(v), base, dir)?;
            let (s, r) = coordinates(base + dir * t - corner, u, v);
            ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&r)).then_some(t)
        }
        Shape::Triangle { a, b, c } => {
            let t = flat_root(a, (b - a).cross(c - a), base, dir)?;
            let (s, r) = coordinates(base + dir * t - a, b - a, c - a);
            (s >= 0.0 && r >= 0.0 && s + r <= 1.0).then_some(t)
        }
    }
}

/// The root that a ray can have with the very surface that it leaves: the far side of a sphere
/// seen from inside, and nothing else.
pub fn root_of_departure(shape: &Shape, inside: bool, base: Vec3, dir: Vec3) -> Option<f64> {
    match *shape {
        // The roots are 0, which is the ray's own origin, and this one.
        Shape::Sphere { center, .. } if inside => {
            Some(-2.0 * (base - center).dot(dir)).filter(|t| *t > 0.0)
        }
        _ => None,
    }
}

/// Where the ray meets the plane through `point`.
fn flat_root(point: Vec3, normal: Vec3, base: Vec3, dir: Vec3) -> Option<f64> {
    let t = (point - base).dot(normal) / dir.dot(normal);
    (t.is_finite() && t > 0.0).then_some(t)
}

/// `(s, r)` with `d = s u + r v`, for a `d` in the plane of `u` and `v`.
fn coordinates(d: Vec3, u: Vec3, v: Vec3) -> (f64, f64) {
    let n = u.cross(v);
    let nn = n.dot(n);
    (d.cross(v).dot(n) / nn, u.cross(d).dot(n) / nn)
}

/// The unit normal as the surface gives it, not turned to anyone.
pub fn own_normal(shape: &Shape, p: Vec3) -> Vec3 {
    match *shape {
        Shape::Sphere { center, .. } => (p - center).unit(),
        Shape::Plane { normal, .. } => normal.unit(),
        Shape::Quad { u, v, .. } => u.cross(v).unit(),
        Shape::Triangle { a, b, c } => (b - a).cross(c - a).unit(),
    }
}

/// Which of the two materials a checker shows at `p` on a flat `shape`.
pub fn tile(shape: &Shape, checker: &Checker, p: Vec3) -> usize {
    let origin = match *shape {
        Shape::Plane { point, .. } => point,
        Shape::Quad { corner, .. } => corner,
        Shape::Triangle { a, .. } => a,
        Shape::Sphere { .. } => unreachable!("a checker lies on flat surfaces only"),
    };
    let normal = own_normal(shape, p);
    let x = (checker.xdir - normal * checker.xdir.dot(normal)).unit();
    let y = normal.cross(x);
    let d = p - origin;
    let sum = (d.dot(x) / checker.size[0]).floor() + (d.dot(y) / checker.size[1]).floor();
    if sum.rem_euclid(2.0) == 0.0 { checker.even } else { checker.odd }
}
