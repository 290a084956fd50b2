//! Surfaces around an axis: the quadrics, as one equation, and the torus.

use super::polynomial::real_roots;
use super::scene::Shape;
use super::vec3::Vec3;

/// The points with `|q - z w|^2 = a z^2 + b z + c` for a z of the range; q is from the origin, w is
/// the axis of length 1, z = q.w.
#[derive(Clone, Copy, Debug)]
pub struct Quadric {
    pub origin: Vec3,
    pub axis: Vec3,
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub range: [f64; 2],
}

impl Quadric {
    /// That of a shape, with the z's of its caps.
    pub fn of(shape: &Shape) -> Option<(Quadric, Vec<f64>)> {
        let (origin, axis, [a, b, c], range, caps) = match *shape {
            Shape::Cylinder { base, axis, radius, height, caps } => {
                let ends = if caps { vec![0.0, height] } else { Vec::new() };
                (base, axis, [0.0, 0.0, radius * radius], [0.0, height], ends)
            }
            Shape::Cone { apex, axis, radius, height, caps } => {
                let slope = radius / height;
                let ends = if caps { vec![height] } else { Vec::new() };
                (apex, axis, [slope * slope, 0.0, 0.0], [0.0, height], ends)
            }
            Shape::Paraboloid { vertex, axis, radius, height, caps } => {
                let ends = if caps { vec![height] } else { Vec::new() };
                (vertex, axis, [0.0, radius * radius / height, 0.0], [0.0, height], ends)
            }
            Shape::Hyperboloid { center, axis, radius, waist, height, caps } => {
                let ends = if caps { vec![-height, height] } else { Vec::new() };
                let a = (radius * radius - waist * waist) / (height * height);
                (center, axis, [a, 0.0, waist * waist], [-height, height], ends)
            }
            _ => return None,
        };
        Some((Quadric { origin, axis: axis.unit(), a, b, c, range }, caps))
    }

    /// The radius squared at z.
    pub fn square(&self, z: f64) -> f64 {
        (self.a * z + self.b) * z + self.c
    }

    /// All roots along the ray within the range; of a ray that leaves the body, all but its own
    /// origin.
    pub fn roots(&self, base: Vec3, dir: Vec3, leaves: bool) -> Vec<f64> {
        // From the point of the ray that is nearest to the origin, where the least cancels.
        let from_origin = base - self.origin;
        let shift = if leaves { 0.0 } else { -from_origin.dot(dir) / dir.dot(dir) };
        let q = from_origin + dir * shift;
        let (z, dz) = (q.dot(self.axis), dir.dot(self.axis));
        let (aside, daside) = (q - self.axis * z, dir - self.axis * dz);
        let square = daside.dot(daside) - self.a * dz * dz;
        let half = aside.dot(daside) - dz * (self.a * z + 0.5 * self.b);
        // A ray that leaves the body starts on it.
        let one = if leaves { 0.0 } else { aside.dot(aside) - self.square(z) };
        let mut roots = quadratic(square, half, one);
        if leaves {
            roots.retain(|t| *t != 0.0);
        }
        roots.retain(|t| (self.range[0]..=self.range[1]).contains(&(z + t * dz)));
        roots.iter().map(|t| t + shift).collect()
    }

    /// Across the body at p, away from the axis.
    pub fn outward(&self, p: Vec3) -> Vec3 {
        let q = p - self.origin;
        let z = q.dot(self.axis);
        (q - self.axis * z - self.axis * (self.a * z + 0.5 * self.b)).unit()
    }
}

/// The roots of a t^2 + 2 b t + c.
pub fn quadratic(a: f64, b: f64, c: f64) -> Vec<f64> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    // The sum of two numbers of one sign cancels nothing.
    let sum = -(b + discriminant.sqrt().copysign(b));
    if sum == 0.0 {
        // t^2, or along the axis of a cylinder nothing at all.
        return if a == 0.0 { Vec::new() } else { vec![0.0] };
    }
    let mut roots = vec![c / sum];
    if a != 0.0 {
        roots.push(sum / a);
    }
    roots
}

/// All roots with a torus around `axis` (of length 1); of a ray that leaves it, all but its own
/// origin.
pub fn torus_roots(
    [major, minor]: [f64; 2],
    axis: Vec3,
    from_center: Vec3,
    dir: Vec3,
    leaves: bool,
) -> Vec<f64> {
    let dd = dir.dot(dir);
    let shift = if leaves { 0.0 } else { -from_center.dot(dir) / dd };
    let q = from_center + dir * shift;
    // A ray that passes the ball around the torus has no root.
    if !leaves && q.length() > major + minor {
        return Vec::new();
    }
    let (z, dz) = (q.dot(axis), dir.dot(axis));
    // (|q|^2 + R^2 - r^2)^2 = 4 R^2 (|q|^2 - z^2), with |q|^2 = one + 2 half t + dd t^2.
    let (one, half) = (q.dot(q), q.dot(dir));
    let g = one + major * major - minor * minor;
    let k = 4.0 * major * major;
    let c = [
        if leaves { 0.0 } else { g * g - k * (one - z * z) },
        4.0 * g * half - 2.0 * k * (half - z * dz),
        4.0 * half * half + 2.0 * g * dd - k * (dd - dz * dz),
        4.0 * half * dd,
        dd * dd,
    ];
    let roots = if leaves { real_roots(&c[1..]) } else { real_roots(&c) };
    roots.iter().map(|t| t + shift).collect()
}
