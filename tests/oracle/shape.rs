//! Where rays meet surfaces, and which way a surface faces.

use super::quadric::{Quadric, quadratic, torus_roots};
use super::scene::Shape;
use super::vec3::{Vec3, v3};

/// The part of a shape that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// The curved part.
    Body,
    /// A flat part: a whole flat surface (0), a cap (its place among the caps from below), or a
    /// face of a cuboid (0 to 5: at min x, max x, min y and so on), or a triangle of a mesh.
    Flat(usize),
}

/// The smallest `t > 0` at which `base + t * dir` meets `shape`, and where; `dir` of any length.
/// Of a ray that leaves a flat part, that part does not count; of one that leaves the body, the
/// root at its own origin does not.
pub fn root(shape: &Shape, base: Vec3, dir: Vec3, leaves: Option<Part>) -> Option<(f64, Part)> {
    let off_body = leaves == Some(Part::Body);
    let mut found: Vec<(f64, Part)> = Vec::new();
    let flat = |i: usize, t: Option<f64>| t.map(|t| (t, Part::Flat(i)));
    match *shape {
        Shape::Sphere { center, radius } => {
            let radii = Vec3::splat(radius);
            body(&mut found, ball_roots(center, radii, base, dir, off_body));
        }
        Shape::Ellipsoid { center, radii } => {
            body(&mut found, ball_roots(center, radii, base, dir, off_body));
        }
        Shape::Plane { point, normal } => {
            found.extend(flat(0, flat_root(point, normal, base, dir)))
        }
        Shape::Quad { corner, u, v } => {
            let t = flat_root(corner, u.cross(v), base, dir).filter(|t| {
                let (s, r) = coordinates(base + dir * *t - corner, u, v);
                (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&r)
            });
            found.extend(flat(0, t));
        }
        Shape::Triangle { a, b, c } => {
            let t = flat_root(a, (b - a).cross(c - a), base, dir).filter(|t| {
                let (s, r) = coordinates(base + dir * *t - a, b - a, c - a);
                s >= 0.0 && r >= 0.0 && s + r <= 1.0
            });
            found.extend(flat(0, t));
        }
        Shape::Disc { center, normal, radius } => {
            found.extend(flat(0, disc_root(center, normal, radius, base, dir)));
        }
        Shape::Cuboid { min, max } => {
            for face in 0..6 {
                found.extend(flat(face, face_root(min, max, face, base, dir)));
            }
        }
        Shape::Mesh { mesh } => {
            let roots = mesh.roots(base, dir);
            found.extend(roots.into_iter().map(|(t, i)| (t, Part::Flat(i))));
        }
        Shape::Torus { center, axis, major, minor } => {
            let size = [major, minor];
            body(&mut found, torus_roots(size, axis.unit(), base - center, dir, off_body));
        }
        Shape::Cylinder { .. }
        | Shape::Cone { .. }
        | Shape::Paraboloid { .. }
        | Shape::Hyperboloid { .. } => {
            let (quadric, caps) = Quadric::of(shape).expect("a quadric");
            body(&mut found, quadric.roots(base, dir, off_body));
            for (i, z) in caps.iter().enumerate() {
                let (center, radius) =
                    (quadric.origin + quadric.axis * *z, quadric.square(*z).sqrt());
                found.extend(flat(i, disc_root(center, quadric.axis, radius, base, dir)));
            }
        }
    }
    found
        .into_iter()
        .filter(|(t, part)| *t > 0.0 && (*part == Part::Body || Some(*part) != leaves))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

fn body(found: &mut Vec<(f64, Part)>, roots: Vec<f64>) {
    found.extend(roots.into_iter().map(|t| (t, Part::Body)));
}

/// The roots with an ellipsoid: those with the ball of radius 1 where `radii` are 1.
fn ball_roots(center: Vec3, radii: Vec3, base: Vec3, dir: Vec3, leaves: bool) -> Vec<f64> {
    let shrunk = |v: Vec3| v.zip(radii, |x, r| x / r);
    let (from_center, dir) = (shrunk(base - center), shrunk(dir));
    let dd = dir.dot(dir);
    if leaves {
        return vec![-2.0 * from_center.dot(dir) / dd];
    }
    let shift = -from_center.dot(dir) / dd;
    let aside = from_center + dir * shift;
    quadratic(dd, 0.0, aside.dot(aside) - 1.0).into_iter().map(|t| t + shift).collect()
}

fn disc_root(center: Vec3, normal: Vec3, radius: f64, base: Vec3, dir: Vec3) -> Option<f64> {
    let t = flat_root(center, normal, base, dir)?;
    ((base + dir * t - center).length() <= radius).then_some(t)
}

fn face_root(min: Vec3, max: Vec3, face: usize, base: Vec3, dir: Vec3) -> Option<f64> {
    let (across, corner) = (face / 2, if face.is_multiple_of(2) { min } else { max });
    let t = (corner[across] - base[across]) / dir[across];
    let p = base + dir * t;
    let inside = (0..3).filter(|i| *i != across).all(|i| (min[i]..=max[i]).contains(&p[i]));
    (t.is_finite() && inside).then_some(t)
}

/// Where the ray meets the plane through `point`.
fn flat_root(point: Vec3, normal: Vec3, base: Vec3, dir: Vec3) -> Option<f64> {
    let t = (point - base).dot(normal) / dir.dot(normal);
    (t.is_finite() && t > 0.0).then_some(t)
}

/// `(s, r)` with `d = s u + r v`, for a `d` in the plane of `u` and `v`.
pub fn coordinates(d: Vec3, u: Vec3, v: Vec3) -> (f64, f64) {
    let n = u.cross(v);
    let nn = n.dot(n);
    (d.cross(v).dot(n) / nn, u.cross(d).dot(n) / nn)
}

/// The unit normal as the surface gives it, not turned to anyone.
pub fn own_normal(shape: &Shape, part: Part, p: Vec3) -> Vec3 {
    match (*shape, part) {
        (Shape::Sphere { center, .. }, _) => (p - center).unit(),
        (Shape::Ellipsoid { center, radii }, _) => {
            (p - center).zip(radii, |x, r| x / (r * r)).unit()
        }
        (Shape::Plane { normal, .. } | Shape::Disc { normal, .. }, _) => normal.unit(),
        (Shape::Quad { u, v, .. }, _) => u.cross(v).unit(),
        (Shape::Triangle { a, b, c }, _) => (b - a).cross(c - a).unit(),
        (Shape::Mesh { mesh }, Part::Flat(i)) => mesh.flat_normal(i),
        (Shape::Cuboid { .. }, Part::Flat(face)) => {
            let mut n = Vec3::ZERO;
            n.0[face / 2] = if face % 2 == 0 { -1.0 } else { 1.0 };
            n
        }
        (Shape::Torus { center, axis, major, .. }, _) => {
            let (q, w) = (p - center, axis.unit());
            let aside = q - w * q.dot(w);
            // From the nearest point of the ring in the middle of the tube.
            (q - aside.unit() * major).unit()
        }
        (_, Part::Body) => Quadric::of(shape).expect("a quadric").0.outward(p),
        (_, Part::Flat(cap)) => {
            let (quadric, caps) = Quadric::of(shape).expect("a quadric");
            // The last cap closes the top; one before it, the bottom.
            if cap + 1 == caps.len() { quadric.axis } else { -quadric.axis }
        }
    }
}

/// Where the patterns of a shape start.
pub fn origin(shape: &Shape) -> Vec3 {
    match *shape {
        Shape::Plane { point, .. } => point,
        Shape::Mesh { mesh } => mesh.place.translate,
        Shape::Quad { corner, .. } => corner,
        Shape::Triangle { a, .. } => a,
        Shape::Cuboid { min, .. } => min,
        Shape::Cylinder { base, .. } => base,
        Shape::Cone { apex, .. } => apex,
        Shape::Paraboloid { vertex, .. } => vertex,
        Shape::Sphere { center, .. }
        | Shape::Disc { center, .. }
        | Shape::Hyperboloid { center, .. }
        | Shape::Ellipsoid { center, .. }
        | Shape::Torus { center, .. } => center,
    }
}

/// Whether the shape is one flat surface.
pub fn is_flat(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Plane { .. } | Shape::Quad { .. } | Shape::Triangle { .. } | Shape::Disc { .. }
    )
}

/// `p` put onto the flat part that it is a point of: there, cells that the part lies in the face of
/// are not left to rounding.
pub fn put_onto(shape: &Shape, part: Part, p: Vec3) -> Vec3 {
    match (*shape, part) {
        (_, Part::Body) | (Shape::Mesh { .. }, _) => p,
        (Shape::Cuboid { min, max }, Part::Flat(face)) => {
            let mut q = p;
            q.0[face / 2] = if face % 2 == 0 { min } else { max }[face / 2];
            q
        }
        (_, Part::Flat(cap)) => {
            let n = own_normal(shape, part, p);
            let o = Quadric::of(shape).map_or_else(
                || origin(shape),
                |(quadric, caps)| quadric.origin + quadric.axis * caps[cap],
            );
            p - n * n.dot(p - o)
        }
    }
}

/// The unit vector across `w` that starts the count of angles, and of x on discs.
pub fn x_across(w: Vec3, xdir: Vec3) -> Vec3 {
    let across = |d: Vec3| d - w * d.dot(w);
    let x = across(xdir);
    if x.length() > 1e-6 * xdir.length() { x.unit() } else { across(v3(0.0, 1.0, 0.0)).unit() }
}
