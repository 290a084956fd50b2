//! Whether a segment of a tree meets a volume: never no where a ray would have hit.

use crate::trees::Level;
use fearless_simd::prelude::*;
use reflet_accel::HitCode;
use reflet_accel::lanes::{F, LANES, M, V3, abs, dot, load3, splat3, sub};
use reflet_pack::lights::{LightPlace, Reach};
use reflet_pack::{Aabb, Volume};
use std::ops::Range;

/// Slack, relative to the coordinates and lengths at hand: 128 units in the last place (2^-24). A
/// kept point lies within about 8 of its ray; the ray leaves within 16 of the point before it; the
/// kernels take a surface for up to 8 larger than it is, and the arithmetic here adds as many.
const SLACK: f32 = 1.0 / 131_072.0;

/// Eight segments from `a` along `e` as far as `end` times its length; `size` bounds the coordinates
/// of both ends.
pub(crate) struct Segments<S: Simd> {
    a: V3<S>,
    e: V3<S>,
    end: F<S>,
    size: F<S>,
    /// How thick they are: capsules, if it is not 0.
    radius: F<S>,
}

impl<S: Simd> Segments<S> {
    /// From `a` to `b`; from `a` on in the direction `b` where `away`.
    #[inline(always)]
    fn new(simd: S, a: V3<S>, b: V3<S>, away: M<S>) -> Self {
        let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
        let inf = F::splat(simd, f32::INFINITY);
        let mut e = sub(b, a);
        for k in 0..3 {
            e[k] = away.select(b[k], e[k]);
        }
        let far = away.select(zero, norm(b));
        Segments { a, e, end: away.select(inf, one), size: norm(a) + far, radius: zero }
    }

    /// Capsules from `a` to `b`.
    #[inline(always)]
    pub(crate) fn thick(simd: S, a: V3<S>, b: V3<S>, radius: F<S>) -> Self {
        let none = F::splat(simd, 0.0).simd_gt(0.0);
        Segments { radius, ..Segments::new(simd, a, b, none) }
    }

    #[inline(always)]
    fn meet(&self, simd: S, volume: &Volume) -> M<S> {
        match volume {
            Volume::Nothing => F::splat(simd, 0.0).simd_gt(0.0),
            Volume::Ball { center, radius } => self.meet_ball(simd, *center, *radius),
            Volume::Box(bounds) => self.meet_box(simd, bounds),
        }
    }

    /// By the distance of the centre from the segment.
    #[inline(always)]
    pub(crate) fn meet_ball(&self, simd: S, center: [f32; 3], radius: f32) -> M<S> {
        let zero = F::splat(simd, 0.0);
        let c = splat3(simd, center);
        let r = F::splat(simd, radius);
        let f = sub(c, self.a);
        let along = dot(f, self.e) / dot(self.e, self.e);
        let along = along.simd_gt(zero).select(along, zero); // 0, too, for a segment of no length
        let along = along.simd_lt(self.end).select(along, self.end);
        let way = [f[0] - along * self.e[0], f[1] - along * self.e[1], f[2] - along * self.e[2]];
        let size = self.size + norm(c) + r + self.radius;
        let reach = r + self.radius + size * F::splat(simd, SLACK);
        // What is not a number meets.
        !dot(way, way).simd_gt(reach * reach)
    }

    /// By slabs (Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986).
    #[inline(always)]
    fn meet_box(&self, simd: S, b: &Aabb) -> M<S> {
        let (lo, hi) = (splat3(simd, b.lo), splat3(simd, b.hi));
        let slack = (self.size + norm(lo) + norm(hi) + self.radius) * F::splat(simd, SLACK);
        let slack = slack + self.radius;
        let mut entry = F::splat(simd, 0.0);
        let mut exit = self.end;
        for k in 0..3 {
            let inv = F::splat(simd, 1.0) / self.e[k];
            let first = (lo[k] - slack - self.a[k]) * inv;
            let last = (hi[k] + slack - self.a[k]) * inv;
            let negative = inv.simd_lt(F::splat(simd, 0.0));
            let (near, far) = (negative.select(last, first), negative.select(first, last));
            entry = near.simd_gt(entry).select(near, entry);
            exit = far.simd_lt(exit).select(far, exit);
        }
        !entry.simd_gt(exit)
    }
}

/// The sum of the absolute coordinates.
#[inline(always)]
fn norm<S: Simd>(v: V3<S>) -> F<S> {
    abs(v[0]) + abs(v[1]) + abs(v[2])
}

/// Where the rays of a level begin.
#[derive(Clone, Copy)]
pub(crate) enum Begin<'a> {
    /// All in one point.
    Eye([f32; 3]),
    /// Where the parents of its nodes are, in these columns.
    Above(&'a [Vec<f32>; 3]),
}

/// Marks those nodes of a level, among `rows`, whose ray meets any of `volumes`.
#[inline(always)]
pub(crate) fn paths<S: Simd>(
    simd: S,
    begin: Begin<'_>,
    (level, rows): (&Level, Range<usize>),
    volumes: &[Volume],
    touched: &mut [bool],
) {
    for first in rows.clone().step_by(LANES) {
        let some = first..(first + LANES).min(rows.end);
        let a = match begin {
            Begin::Above(columns) => gather(simd, columns, &level.parent[some.clone()]),
            Begin::Eye(eye) => splat3(simd, eye),
        };
        let b = ends(simd, level, first);
        let away = missed(simd, &level.code[some.clone()]);
        let segments = Segments::new(simd, a, b, away);
        mark(meeting(simd, &segments, volumes), &mut touched[some]);
    }
}

/// Marks those nodes of a level, among `rows`, whose shadow ray to a light was free and meets any of
/// the new volumes, or was blocked and meets any of the old ones.
#[inline(always)]
pub(crate) fn shadows<S: Simd>(
    simd: S,
    (level, rows): (&Level, Range<usize>),
    (light, terms): (&LightPlace, &[f32]),
    (old, new): (&[Volume], &[Volume]),
    touched: &mut [bool],
) {
    for first in rows.clone().step_by(LANES) {
        let some = first..(first + LANES).min(rows.end);
        let term = lanes(simd, &terms[some.clone()]);
        let is_zero = term.simd_eq(0.0);
        let is_negative = term.to_bits().simd_eq((-0.0f32).to_bits());
        let within = (1u32 << some.len()) - 1;
        let free = !(is_zero.to_bitmask() as u32) & within;
        let blocked = is_negative.to_bitmask() as u32 & within;
        if free | blocked == 0 {
            continue;
        }
        // A ray that leaves above its point ends with the others, so the capsule of that radius around
        // the way from the point holds it and the way up.
        let radius = lanes(simd, &level.lift[some.clone()]);
        let segments = to_light(simd, ends(simd, level, first), light, radius);
        let mut lanes = 0;
        if free != 0 {
            lanes |= free & meeting(simd, &segments, new);
        }
        if blocked != 0 {
            lanes |= blocked & meeting(simd, &segments, old);
        }
        mark(lanes, &mut touched[some]);
    }
}

/// From `a` to a light, so thick.
#[inline(always)]
pub(crate) fn to_light<S: Simd>(
    simd: S,
    a: V3<S>,
    light: &LightPlace,
    radius: F<S>,
) -> Segments<S> {
    let far = F::splat(simd, f32::from(u8::from(light.reach == Reach::Far)));
    let away = far.simd_gt(0.0);
    Segments { radius, ..Segments::new(simd, a, splat3(simd, light.at), away) }
}

/// The lanes that meet any of `volumes`, a bit each.
#[inline(always)]
fn meeting<S: Simd>(simd: S, segments: &Segments<S>, volumes: &[Volume]) -> u32 {
    let mut lanes = 0;
    for volume in volumes {
        lanes |= segments.meet(simd, volume).to_bitmask() as u32;
    }
    lanes
}

fn mark(lanes: u32, touched: &mut [bool]) {
    if lanes == 0 {
        return;
    }
    for (lane, touched) in touched.iter_mut().enumerate() {
        *touched |= lanes >> lane & 1 == 1;
    }
}

/// The lanes of rays that hit nothing.
#[inline(always)]
fn missed<S: Simd>(simd: S, codes: &[HitCode]) -> M<S> {
    let mut lanes = [1.0; LANES];
    for (lane, code) in lanes.iter_mut().zip(codes) {
        *lane = if code.is_none() { 1.0 } else { 0.0 };
    }
    F::from_slice(simd, &lanes).simd_gt(0.0)
}

/// Where the rays of eight rows from `first` on ended; zeros beyond the level.
#[inline(always)]
fn ends<S: Simd>(simd: S, level: &Level, first: usize) -> V3<S> {
    let end = first + LANES;
    if end <= level.len() {
        let at = &level.at;
        return load3(simd, [&at[0][first..end], &at[1][first..end], &at[2][first..end]]);
    }
    let at = &level.at;
    [lanes(simd, &at[0][first..]), lanes(simd, &at[1][first..]), lanes(simd, &at[2][first..])]
}

/// Up to eight numbers of a column, then zeros.
#[inline(always)]
fn lanes<S: Simd>(simd: S, column: &[f32]) -> F<S> {
    if column.len() == LANES {
        return F::from_slice(simd, column);
    }
    let mut lanes = [0.0; LANES];
    lanes[..column.len()].copy_from_slice(column);
    F::from_slice(simd, &lanes)
}

/// Some rows of three columns.
#[inline(always)]
fn gather<S: Simd>(simd: S, columns: &[Vec<f32>; 3], rows: &[u16]) -> V3<S> {
    let mut lanes = [[0.0; LANES]; 3];
    for (lane, row) in rows.iter().enumerate() {
        for (lanes, column) in lanes.iter_mut().zip(columns) {
            lanes[lane] = column[usize::from(*row)];
        }
    }
    load3(simd, [&lanes[0], &lanes[1], &lanes[2]])
}
