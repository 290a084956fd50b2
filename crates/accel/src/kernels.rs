//! One test a shape. Each gives t, whether the ray hits, and the hit's code, before the box test.

use crate::blocks::Pick;
use crate::lanes::{F, Floats, LANES, RayLanes, WIDE, dot, sub};
use crate::solid::{self, Leaves};
use crate::solids::{self, Asked, HALF, Rows};
use fearless_simd::prelude::*;
use reflet_pack::Solid;

/// What a kernel answers.
#[derive(Clone, Copy)]
pub struct Candidate<S: Simd, V: Floats<S> = F<S>> {
    /// The distance; anything where `hit` is false.
    pub t: V,
    /// Whether there is a root in front of the ray.
    pub hit: V::Mask,
    /// The primitive's code, with the inside bit.
    pub code: V::Bits,
}

/// Spheres in lanes, or one in all lanes.
#[derive(Clone, Copy)]
pub struct SphereLanes<S: Simd, V: Floats<S>> {
    /// Centres.
    pub center: [V; 3],
    /// Radii.
    pub radius: V,
    /// Codes.
    pub code: V::Bits,
}

/// Sphere: the discriminant as r² - |l - (l.d) d|², which does not cancel at long range (Haines et
/// al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, ch. 7).
///
/// The near root counts if it is in front and the ray does not leave this sphere; else the far root,
/// if the ray does not leave it on its outside.
#[inline(always)]
pub fn sphere<S: Simd, V: Floats<S>>(
    simd: S,
    ray: &RayLanes<S, V>,
    s: &SphereLanes<S, V>,
) -> Candidate<S, V> {
    let zero = V::splat(simd, 0.0);
    let l = sub(s.center, ray.o);
    let b = dot(l, ray.d);
    let across = [l[0] - b * ray.d[0], l[1] - b * ray.d[1], l[2] - b * ray.d[2]];
    let disc = s.radius * s.radius - dot(across, across);
    let meets = disc.simd_ge(zero);
    let root = disc.sqrt();
    let (near, far) = (b - root, b + root);
    // The surface left apart from its side, and that side.
    let other = !(ray.last & !1u32).simd_eq(s.code);
    let from_inside = ray.last.simd_eq(s.code | 1u32);
    let near_counts = near.simd_gt(ray.start) & other;
    let far_counts = far.simd_gt(ray.start) & (other | from_inside);
    Candidate {
        t: near_counts.select(near, far),
        hit: meets & (near_counts | far_counts),
        code: near_counts.select(s.code, s.code | 1u32),
    }
}

/// Planes in lanes, or one in all lanes.
#[derive(Clone, Copy)]
pub struct PlaneLanes<S: Simd, V: Floats<S>> {
    /// A point of each.
    pub point: [V; 3],
    /// Unit normals.
    pub normal: [V; 3],
    /// Codes.
    pub code: V::Bits,
}

/// Plane: n.(point - o) / n.d.
#[inline(always)]
pub fn plane<S: Simd, V: Floats<S>>(
    _simd: S,
    ray: &RayLanes<S, V>,
    p: &PlaneLanes<S, V>,
) -> Candidate<S, V> {
    let t = dot(p.normal, sub(p.point, ray.o)) / dot(p.normal, ray.d);
    let hit = t.simd_gt(ray.start) & !(ray.last & !1u32).simd_eq(p.code);
    Candidate { t, hit, code: p.code }
}

/// Quads in lanes, or one in all lanes.
#[derive(Clone, Copy)]
pub struct QuadLanes<S: Simd, V: Floats<S>> {
    /// Corners in order around, the rays' longest axis third.
    pub corners: [[V; 3]; 4],
    /// The first corner, axes as they are.
    pub point: [V; 3],
    /// Unit normals, axes as they are.
    pub normal: [V; 3],
    /// Codes.
    pub code: V::Bits,
}

/// Quad: inside by the signs of four watertight edge functions, t by its plane.
#[inline(always)]
pub fn quad<S: Simd, V: Floats<S>>(
    simd: S,
    ray: &RayLanes<S, V>,
    q: &QuadLanes<S, V>,
) -> Candidate<S, V> {
    let zero = V::splat(simd, 0.0);
    let o = ray.turned;
    let a = sheared(ray, sub(q.corners[0], o));
    let b = sheared(ray, sub(q.corners[1], o));
    let c = sheared(ray, sub(q.corners[2], o));
    let d = sheared(ray, sub(q.corners[3], o));
    let edges = [edge(a, b), edge(b, c), edge(c, d), edge(d, a)];
    let mut any_neg = edges[0].simd_lt(zero);
    let mut any_pos = edges[0].simd_gt(zero);
    for e in &edges[1..] {
        any_neg |= e.simd_lt(zero);
        any_pos |= e.simd_gt(zero);
    }
    let inside = !(any_neg & any_pos) & (any_neg | any_pos) & !(ray.last & !1u32).simd_eq(q.code);
    if !inside.any_true() {
        return Candidate { t: zero, hit: inside, code: q.code };
    }
    let t = dot(q.normal, sub(q.point, ray.o)) / dot(q.normal, ray.d);
    Candidate { t, hit: inside & t.simd_gt(ray.start), code: q.code }
}

/// Triangles in lanes, or one in all lanes.
#[derive(Clone, Copy)]
pub struct TriangleLanes<S: Simd, V: Floats<S>> {
    /// Corners, the rays' longest axis third.
    pub corners: [[V; 3]; 3],
    /// Codes.
    pub code: V::Bits,
}

/// Triangle: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013. A function
/// of an edge is the exact negative of its neighbour's, and 0 counts as inside for both, so a ray at
/// a shared edge hits one of the two at least. Both sides count.
#[inline(always)]
pub fn triangle<S: Simd, V: Floats<S>>(
    simd: S,
    ray: &RayLanes<S, V>,
    tri: &TriangleLanes<S, V>,
) -> Candidate<S, V> {
    let zero = V::splat(simd, 0.0);
    let o = ray.turned;
    let (pa, pb, pc) = (sub(tri.corners[0], o), sub(tri.corners[1], o), sub(tri.corners[2], o));
    let (a, b, c) = (sheared(ray, pa), sheared(ray, pb), sheared(ray, pc));
    let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
    let any_neg = u.simd_lt(zero) | v.simd_lt(zero) | w.simd_lt(zero);
    let any_pos = u.simd_gt(zero) | v.simd_gt(zero) | w.simd_gt(zero);
    let inside = !(any_neg & any_pos) & !(ray.last & !1u32).simd_eq(tri.code);
    // One ray hits one of eight about as often as none, which is dear to foresee.
    if V::LEN > LANES && !inside.any_true() {
        return Candidate { t: zero, hit: inside, code: tri.code };
    }
    let det = u + v + w;
    let t = (u * a[2] + v * b[2] + w * c[2]) / det;
    let hit = inside & !det.simd_eq(zero) & t.simd_gt(ray.start);
    Candidate { t, hit, code: tri.code }
}

/// Solids: those lanes of `asked`, in `f64`, gathered to four at once ([`solids::hit`]). One alone is
/// asked in scalar code ([`solid::hit`]), of which lanes are a copy.
#[inline(always)]
pub fn solids<S: Simd, V: Floats<S>>(
    simd: S,
    ray: &RayLanes<S, V>,
    (rows, pick): (&[Solid; LANES], Pick),
    (code, asked): (V::Bits, V::Mask),
) -> Candidate<S, V> {
    let (mut t, mut outward) = ([f32::NAN; WIDE], [0.0; WIDE]);
    let (o, d) = (ray.o, ray.d);
    let o = [o[0].as_slice(), o[1].as_slice(), o[2].as_slice()];
    let d = [d[0].as_slice(), d[1].as_slice(), d[2].as_slice()];
    let (codes, last, start) = (code.as_slice(), ray.last.as_slice(), ray.start.as_slice());
    let mut bits = asked.to_bitmask();
    while bits != 0 {
        let mut lanes = [0; HALF];
        let mut len = 0;
        while bits != 0 && len < HALF {
            lanes[len] = bits.trailing_zeros() as usize % V::LEN;
            bits &= bits - 1;
            len += 1;
        }
        let row = |lane: usize| match pick {
            Pick::Each => &rows[lane],
            Pick::One(row) => &rows[row],
        };
        let leaves = |lane: usize| last[lane] & !1 == codes[lane];
        if len == 1 {
            let k = lanes[0];
            let own = ([o[0][k], o[1][k], o[2][k]], [d[0][k], d[1][k], d[2][k]]);
            let leaves = if leaves(k) { Leaves::This } else { Leaves::Another };
            if let Some((at, runs_outward)) = solid::hit(row(k), own, start[k], leaves) {
                (t[k], outward[k]) = (at, f32::from(u8::from(runs_outward)));
            }
            continue;
        }
        let mut question = Asked::default();
        for (i, &k) in lanes[..len].iter().enumerate() {
            for axis in 0..3 {
                question.o[axis][i] = o[axis][k];
                question.d[axis][i] = d[axis][k];
            }
            question.start[i] = start[k];
            question.what[i] = if leaves(k) { solids::ANOTHER_ROOT } else { solids::A_ROOT };
        }
        let rows = match pick {
            Pick::Each => Rows::Each([row(lanes[0]), row(lanes[1]), row(lanes[2]), row(lanes[3])]),
            Pick::One(row) => Rows::One(&rows[row]),
        };
        let found = solids::hit(simd, &rows, &question);
        for (i, &k) in lanes[..len].iter().enumerate() {
            (t[k], outward[k]) = (found.t[i], found.outward[i]);
        }
    }
    let t = V::from_slice(simd, &t[..V::LEN]);
    let outward = V::from_slice(simd, &outward[..V::LEN]).simd_gt(0.0);
    Candidate { t, hit: t.simd_eq(t), code: outward.select(code | 1u32, code) }
}

/// `p` (relative to the ray's origin, the longest axis third) in the space where the ray is the
/// third axis.
#[inline(always)]
fn sheared<S: Simd, V: Floats<S>>(ray: &RayLanes<S, V>, p: [V; 3]) -> [V; 3] {
    [p[0] - ray.shear[0] * p[2], p[1] - ray.shear[1] * p[2], ray.shear[2] * p[2]]
}

/// On which side of the ray the edge from `p` to `q` passes.
#[inline(always)]
fn edge<S: Simd, V: Floats<S>>(p: [V; 3], q: [V; 3]) -> V {
    p[0] * q[1] - p[1] * q[0]
}
