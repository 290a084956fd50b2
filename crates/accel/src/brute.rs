//! The definition of a hit, in scalar code: every primitive, one after the other.
//!
//! Slow on purpose, and written apart from the lanes: all other ways are held against it.

use crate::rays::HitCode;
use crate::slab::LEAVE;
use crate::solid::{self, Leaves};
use reflet_pack::copies::facing;
use reflet_pack::{Aabb, Geometry, PrimId, ShapeKind};

type V = [f32; 3];

fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Where a ray enters a box (at least 0), if it passes it.
#[inline]
pub fn enter(o: V, d: V, b: &Aabb) -> Option<f32> {
    let (mut entry, mut exit) = (0.0f32, f32::INFINITY);
    for k in 0..3 {
        let inv = 1.0 / d[k];
        let (near, far) = if inv < 0.0 { (b.hi[k], b.lo[k]) } else { (b.lo[k], b.hi[k]) };
        let (near, far) = ((near - o[k]) * inv, (far - o[k]) * inv);
        entry = if near > entry { near } else { entry };
        exit = if far < exit { far } else { exit };
    }
    (entry <= exit * LEAVE).then_some(entry)
}

/// Where one ray hits one primitive, with the box test, and from which side.
#[inline]
pub fn hit(
    g: &Geometry,
    prim: PrimId,
    (o, d, t_min): (V, V, f32),
    last: HitCode,
) -> Option<(f32, HitCode)> {
    let (slot, which) = g.slot_of(prim);
    let (kind, row) = g.shape[slot.index()];
    let row = row as usize;
    let mut bounds = g.bounds[slot.index()];
    let code = HitCode::outside(prim);
    let left = HitCode(last.0 & !1) == code;
    let (t, code) = match kind {
        ShapeKind::Sphere => {
            let r = g.spheres.radius[row];
            let l = sub(g.spheres.center.get(row), o);
            let b = dot(l, d);
            let across = [l[0] - b * d[0], l[1] - b * d[1], l[2] - b * d[2]];
            let disc = r * r - dot(across, across);
            if disc.is_nan() || disc < 0.0 {
                return None;
            }
            let root = disc.sqrt();
            let (near, far) = (b - root, b + root);
            if near > t_min && !left {
                (near, code)
            } else if far > t_min && (!left || last.is_inside()) {
                (far, code.inward())
            } else {
                return None;
            }
        }
        ShapeKind::Plane => {
            let n = g.planes.normal.get(row);
            (dot(n, sub(g.planes.point.get(row), o)) / dot(n, d), code)
        }
        ShapeKind::Quad => {
            let points = g.quads.points(row);
            let n = g.quads.normal.get(row);
            let s = points.map(|p| sheared(d, sub(p, o)));
            let edges = [edge(s[0], s[1]), edge(s[1], s[2]), edge(s[2], s[3]), edge(s[3], s[0])];
            let (neg, pos) = (edges.iter().any(|e| *e < 0.0), edges.iter().any(|e| *e > 0.0));
            if neg == pos {
                return None;
            }
            (dot(n, sub(points[0], o)) / dot(n, d), code)
        }
        ShapeKind::Triangle => (triangle((o, d), g.triangles.points(row))?, code),
        ShapeKind::Copy => {
            let points = g.copies[row].triangle(which);
            if !bounds.is_empty() {
                bounds = facing(points).1;
            }
            (triangle((o, d), points)?, code)
        }
        ShapeKind::Solid => {
            let leaves = if left { Leaves::This } else { Leaves::Another };
            let (t, outward) = solid::hit(&g.solids.rows[row], (o, d), t_min, leaves)?;
            (t, if outward { code.inward() } else { code })
        }
    };
    let has_one_root = !matches!(kind, ShapeKind::Sphere | ShapeKind::Solid);
    if has_one_root && left || !above(t, t_min) {
        return None;
    }
    let entry = enter(o, d, &bounds)?;
    Some((if entry > t { entry } else { t }, code))
}

/// The distance of a triangle, wherever its plane is met inside.
fn triangle((o, d): (V, V), points: [V; 3]) -> Option<f32> {
    let [a, b, c] = points.map(|p| sheared(d, sub(p, o)));
    let e = [edge(c, b), edge(a, c), edge(b, a)];
    let det = e[0] + e[1] + e[2];
    if (e.iter().any(|e| *e < 0.0) && e.iter().any(|e| *e > 0.0)) || det == 0.0 {
        return None;
    }
    Some((e[0] * a[2] + e[1] * b[2] + e[2] * c[2]) / det)
}

fn sheared(d: V, v: V) -> V {
    let size = d.map(f32::abs);
    let turn = |v: V| {
        if size[0] >= size[1] && size[0] >= size[2] {
            [v[1], v[2], v[0]]
        } else if size[1] >= size[2] {
            [v[2], v[0], v[1]]
        } else {
            v
        }
    };
    let (d, v) = (turn(d), turn(v));
    [v[0] - d[0] / d[2] * v[2], v[1] - d[1] / d[2] * v[2], 1.0 / d[2] * v[2]]
}

fn edge(p: V, q: V) -> f32 {
    p[0] * q[1] - p[1] * q[0]
}

/// Whether `t > t_min`; a NaN is not above anything.
fn above(t: f32, t_min: f32) -> bool {
    t > t_min
}

/// The closest hit of one ray with the kernel's t above `t_min` and t below `t_max`, or `t_max` and no code.
pub fn closest(
    g: &Geometry,
    (o, d): (V, V),
    (t_min, t_max): (f32, f32),
    last: HitCode,
) -> (f32, HitCode) {
    let mut best = (t_max, HitCode::NONE);
    let dd = dot(d, d);
    let oo = o[0].abs() + o[1].abs() + o[2].abs();
    let castable = dd > 0.0 && dd < f32::INFINITY && oo < f32::INFINITY;
    if !castable {
        return best;
    }
    for prim in (0..g.prims()).map(PrimId) {
        if let Some((t, code)) = hit(g, prim, (o, d, t_min), last)
            && t < best.0
        {
            best = (t, code);
        }
    }
    best
}
