//! The (u, v) of a point of a surface.

use super::quadric::Quadric;
use super::scene::Shape;
use super::shape::{Part, coordinates, x_across};
use super::vec3::{Vec3, v3};
use std::f64::consts::{PI, TAU};

const XDIR: Vec3 = v3(1.0, 0.0, 0.0);

/// The (u, v) of `p` on a part of `shape`; of a plane, which has no ends, lengths.
pub fn uv(shape: &Shape, part: Part, p: Vec3) -> (f64, f64) {
    match (*shape, part) {
        (Shape::Plane { point, normal }, _) => {
            let (q, n) = (p - point, normal.unit());
            let x = x_across(n, XDIR);
            (q.dot(x), q.dot(n.cross(x)))
        }
        (Shape::Mesh { mesh }, Part::Flat(i)) => mesh.uv(i, p),
        (Shape::Quad { corner, u, v }, _) => coordinates(p - corner, u, v),
        (Shape::Triangle { a, b, c }, _) => coordinates(p - a, b - a, c - a),
        (Shape::Disc { center, normal, radius }, _) => on_disc(normal.unit(), radius, p - center),
        (Shape::Sphere { center, radius }, _) => on_ball((p - center) / radius),
        (Shape::Ellipsoid { center, radii }, _) => on_ball((p - center).zip(radii, |x, r| x / r)),
        (Shape::Torus { center, axis, major, .. }, _) => {
            let (q, w) = (p - center, axis.unit());
            let z = q.dot(w);
            (around(w, q), turns(z.atan2((q - w * z).length() - major)))
        }
        (Shape::Cuboid { min, max }, Part::Flat(face)) => {
            let s = (p - min).zip(max - min, |x, l| x / l);
            match face {
                0 => (s[2], s[1]),
                1 => (1.0 - s[2], s[1]),
                2 => (s[0], s[2]),
                3 => (s[0], 1.0 - s[2]),
                4 => (1.0 - s[0], s[1]),
                _ => (s[0], s[1]),
            }
        }
        (_, Part::Body) => {
            let (quadric, _) = Quadric::of(shape).expect("a quadric");
            let q = p - quadric.origin;
            let [z0, z1] = quadric.range;
            (around(quadric.axis, q), (q.dot(quadric.axis) - z0) / (z1 - z0))
        }
        (_, Part::Flat(cap)) => {
            let (quadric, caps) = Quadric::of(shape).expect("a quadric");
            let center = quadric.origin + quadric.axis * caps[cap];
            let radius = quadric.square(caps[cap]).sqrt();
            // Both caps as discs across the axis: what is right on the one is right on the other.
            on_disc(quadric.axis, radius, p - center)
        }
    }
}

fn on_disc(normal: Vec3, radius: f64, q: Vec3) -> (f64, f64) {
    let x = x_across(normal, XDIR);
    let y = normal.cross(x);
    (0.5 + 0.5 * q.dot(x) / radius, 0.5 + 0.5 * q.dot(y) / radius)
}

fn on_ball(q: Vec3) -> (f64, f64) {
    (turns((-q[2]).atan2(q[0])), 0.5 + q[1].clamp(-1.0, 1.0).asin() / PI)
}

/// The angle around an axis, counter-clockwise seen from its tip, in turns.
fn around(w: Vec3, q: Vec3) -> f64 {
    let x = x_across(w, XDIR);
    turns(q.dot(w.cross(x)).atan2(q.dot(x)))
}

/// An angle of -pi to pi as turns, from 0 to 1.
fn turns(angle: f64) -> f64 {
    let turns = angle / TAU;
    if turns < 0.0 { turns + 1.0 } else { turns }
}
