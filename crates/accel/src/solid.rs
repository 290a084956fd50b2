//! What solids are to rays: roots in `f64`, in the solid's own coordinates, in scalar code. That is the
//! definition; [`crate::solids`] does the same in lanes.

use reflet_pack::{Form, Solid};

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + s b`.
fn along(a: V, s: f64, b: V) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn wide(v: [f32; 3]) -> V {
    [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]
}

/// Where a point of the scene lies in a solid's own coordinates.
fn to_local(solid: &Solid, p: V) -> V {
    let row = |r: &[f64; 4]| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
    [row(&solid.local[0]), row(&solid.local[1]), row(&solid.local[2])]
}

/// A direction of the scene in a solid's own coordinates.
fn turn_to_local(solid: &Solid, d: V) -> V {
    let row = |r: &[f64; 4]| r[0] * d[0] + r[1] * d[1] + r[2] * d[2];
    [row(&solid.local[0]), row(&solid.local[1]), row(&solid.local[2])]
}

/// Whether a ray leaves the primitive that it is tested against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaves {
    /// It does: the root at its origin does not count.
    This,
    /// It does not.
    Another,
}

/// The nearest root above `t_min` of a ray, and whether the ray runs outward there (of a disc: along
/// its normal).
///
/// A ray that leaves the solid lies on it by definition: the constant term of its polynomial is 0,
/// so the root at its origin drops out exactly, and the others are those of the polynomial that is
/// left.
#[inline(never)]
pub fn hit(
    solid: &Solid,
    (o, d): ([f32; 3], [f32; 3]),
    t_min: f32,
    leaves: Leaves,
) -> Option<(f32, bool)> {
    let (o, d) = (to_local(solid, wide(o)), turn_to_local(solid, wide(d)));
    let dd = dot(d, d);
    if !(dd > 0.0 && dd < f64::INFINITY) {
        return None;
    }
    // From where the ray comes closest to the solid's middle, nothing cancels.
    let shift = if leaves == Leaves::This { 0.0 } else { -dot(o, d) / dd };
    let near = along(o, shift, d);
    let mut roots = Roots::default();
    match solid.form {
        Form::Disc => disc(o, d, leaves, &mut roots),
        Form::Revolved { profile, z } => revolved((near, d), profile, z, leaves, &mut roots),
        Form::Torus { major, minor } => torus((near, d), dd, (major, minor), leaves, &mut roots),
    }
    let shift = if solid.form == Form::Disc { 0.0 } else { shift };
    for root in &roots.t[..roots.len] {
        let t = (root + shift) as f32;
        if t > t_min {
            let outward = dot(gradient(&solid.form, along(near, *root, d)), d) > 0.0;
            return Some((t, outward));
        }
    }
    None
}

/// Up to four roots, ascending.
#[derive(Default)]
struct Roots {
    t: [f64; 4],
    len: usize,
}

impl Roots {
    /// A root above all before it.
    fn push(&mut self, t: f64) {
        if self.len < 4 {
            self.t[self.len] = t;
            self.len += 1;
        }
    }
}

fn disc(o: V, d: V, leaves: Leaves, roots: &mut Roots) {
    let t = -o[2] / d[2];
    let p = along(o, t, d);
    if leaves == Leaves::Another && p[0] * p[0] + p[1] * p[1] <= 1.0 {
        roots.push(t);
    }
}

/// x^2 + y^2 - a - b z - c z^2 = 0, by the form of the quadratic formula that does not cancel (Press
/// et al., "Numerical Recipes", section 5.6).
fn revolved((o, d): (V, V), [a, b, c]: V, z: [f64; 2], leaves: Leaves, roots: &mut Roots) {
    let square = d[0] * d[0] + d[1] * d[1] - c * d[2] * d[2];
    let half = o[0] * d[0] + o[1] * d[1] - (c * o[2] + 0.5 * b) * d[2];
    let mut take = |t: f64| {
        let at = o[2] + t * d[2];
        if at >= z[0] && at <= z[1] {
            roots.push(t);
        }
    };
    if leaves == Leaves::This {
        take(-2.0 * half / square);
        return;
    }
    let constant = o[0] * o[0] + o[1] * o[1] - a - (b + c * o[2]) * o[2];
    let disc = half * half - square * constant;
    if disc.is_nan() || disc < 0.0 {
        return;
    }
    let q = if half < 0.0 { disc.sqrt() - half } else { -disc.sqrt() - half };
    let (first, second) = (q / square, constant / q);
    let (near, far) = if first < second { (first, second) } else { (second, first) };
    take(near);
    take(far);
}

/// The quartic of a torus (Hanrahan, "A Survey of Ray-Surface Intersection Algorithms", in "An
/// Introduction to Ray Tracing", 1989), within the ball around it.
fn torus((o, d): (V, V), dd: f64, (major, minor): (f64, f64), leaves: Leaves, roots: &mut Roots) {
    let reach = major + minor;
    let (od, oo) = (dot(o, d), dot(o, o));
    let middle = -od / dd;
    let half = (reach * reach * (1.0 + 1e-9) - (oo - od * od / dd)) / dd;
    if half.is_nan() || half <= 0.0 {
        return;
    }
    let (low, high) = (middle - half.sqrt(), middle + half.sqrt());
    let g = oo + major * major - minor * minor;
    let across = 4.0 * major * major;
    let flat = |a: V, b: V| a[0] * b[0] + a[1] * b[1];
    let constant = if leaves == Leaves::This { 0.0 } else { g * g - across * flat(o, o) };
    let quartic = [
        constant,
        4.0 * od * g - 2.0 * across * flat(o, d),
        2.0 * dd * g + 4.0 * od * od - across * flat(d, d),
        4.0 * dd * od,
        dd * dd,
    ];
    let mut found = [0.0; 4];
    let len = match leaves {
        Leaves::Another => find_roots(&quartic, low, high, &mut found),
        Leaves::This => find_roots(&quartic[1..], low, high, &mut found),
    };
    found[..len].iter().for_each(|t| roots.push(*t));
}

/// The roots of a polynomial (coefficients from the constant term up) between `low` and `high`,
/// ascending, found between those of its derivative. A root that only touches zero may be missed.
fn find_roots(p: &[f64], low: f64, high: f64, out: &mut [f64; 4]) -> usize {
    let degree = p.len() - 1;
    if degree == 1 {
        let t = -p[0] / p[1];
        out[0] = t;
        return usize::from(t >= low && t <= high);
    }
    let mut derivative = [0.0; 4];
    for (k, to) in derivative[..degree].iter_mut().enumerate() {
        *to = (k + 1) as f64 * p[k + 1];
    }
    let mut turns = [0.0; 4];
    let count = find_roots(&derivative[..degree], low, high, &mut turns);
    let (mut len, mut from) = (0, low);
    let mut value = evaluate(p, from);
    for to in turns[..count].iter().copied().chain([high]) {
        let next = evaluate(p, to);
        if (value < 0.0) != (next < 0.0) && len < 4 {
            out[len] = between(p, (from, value), to);
            len += 1;
        }
        (from, value) = (to, next);
    }
    len
}

fn evaluate(p: &[f64], t: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// Newton's method ends where a step is at most this part of the two ends' sizes: the error that is
/// left is about the square of the last step's. (There is a root within as many steps as the
/// polynomial's degree.) To ask for a step that changes nothing would cost five times as many, since
/// rounding moves the last digits to and fro.
pub(crate) const CLOSE: f64 = 1.0 / (1_u64 << 48) as f64;

/// The one root between two ends at which a polynomial has different signs: Newton's method, with a
/// halving wherever that would leave the interval.
fn between(p: &[f64], (mut low, at_low): (f64, f64), mut high: f64) -> f64 {
    let rises = at_low < 0.0;
    let close = CLOSE * (low.abs() + high.abs());
    let mut t = 0.5 * (low + high);
    for _ in 0..64 {
        let (mut value, mut slope) = (0.0, 0.0);
        for c in p.iter().rev() {
            slope = slope * t + value;
            value = value * t + c;
        }
        if (value < 0.0) == rises {
            low = t;
        } else {
            high = t;
        }
        let step = t - value / slope;
        if (step - t).abs() <= close {
            return step;
        }
        t = if step > low && step < high { step } else { 0.5 * (low + high) };
    }
    t
}

/// How the function that is 0 on a form grows, in the form's coordinates; outward.
fn gradient(form: &Form, p: V) -> V {
    match *form {
        Form::Disc => [0.0, 0.0, 1.0],
        Form::Revolved { profile: [_, b, c], .. } => [p[0], p[1], -0.5 * b - c * p[2]],
        Form::Torus { major, .. } => {
            let ring = (p[0] * p[0] + p[1] * p[1]).sqrt();
            let inward = 1.0 - major / ring;
            [p[0] * inward, p[1] * inward, p[2]]
        }
    }
}

/// Half of the function that is 0 on a form, scaled as [`gradient`] is.
fn value(form: &Form, p: V) -> f64 {
    match *form {
        Form::Disc => p[2],
        Form::Revolved { profile: [a, b, c], .. } => {
            0.5 * (p[0] * p[0] + p[1] * p[1] - a - (b + c * p[2]) * p[2])
        }
        Form::Torus { major, minor } => {
            let ring = (p[0] * p[0] + p[1] * p[1]).sqrt() - major;
            0.5 * (ring * ring + p[2] * p[2] - minor * minor)
        }
    }
}

/// Where a ray meets a solid: the point that lies t along it, brought onto the solid along the
/// gradient, and the unit normal there, outward; both in the scene's coordinates.
pub fn point(solid: &Solid, (o, d): ([f32; 3], [f32; 3]), t: f32) -> ([f32; 3], [f32; 3]) {
    let mut p = along(wide(o), f64::from(t), wide(d));
    let mut normal = outward(solid, p);
    for _ in 0..2 {
        let size = dot(normal, normal);
        if size > 0.0 {
            p = along(p, -value(&solid.form, to_local(solid, p)) / size, normal);
            normal = outward(solid, p);
        }
    }
    let length = dot(normal, normal).sqrt();
    // A cone's apex has no normal: the ray is sent back.
    let normal = if length > 0.0 { normal.map(|x| x / length) } else { wide(d).map(|x| -x) };
    (p.map(|x| x as f32), normal.map(|x| x as f32))
}

/// The gradient at a point of the scene, in its coordinates.
fn outward(solid: &Solid, p: V) -> V {
    let g = gradient(&solid.form, to_local(solid, p));
    let m = &solid.local;
    [0, 1, 2].map(|k| m[0][k] * g[0] + m[1][k] * g[1] + m[2][k] * g[2])
}
