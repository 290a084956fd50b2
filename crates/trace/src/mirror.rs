//! Which nodes reflect, and where to.

use crate::interact::Interactions;
use fearless_simd::prelude::*;
use reflet_accel::lanes::{F, LANES, V3, dot, load3};
use reflet_accel::{HitCode, Rays};

/// How far a ray rises at least over the triangle of a smooth mesh that it leaves, as a part of its
/// length: below it could meet the triangle beside.
const RISE: f32 = 1e-3;

/// Writes the mirrored rays of the rows in `rows` (ascending) into `out`: v = 2 (u.n) n - u with
/// u = -d, normalised truly at each bounce, since what is off unit length grows with every other. Where
/// that dips below the triangle of a smooth mesh, the nearest direction just above.
#[inline(always)]
pub fn reflect<S: Simd>(
    simd: S,
    rays: &Rays,
    points: &Interactions,
    codes: &[HitCode],
    rows: &[u16],
    out: &mut Rays,
) {
    out.resize(rows.len());
    for (chunk, first) in rows.chunks(LANES).zip((0..).step_by(LANES)) {
        let d = gather(simd, &rays.dir, chunk);
        let n = gather(simd, &points.n, chunk);
        let start = gather(simd, &points.start, chunk);
        let along = dot(d, n);
        let twice = along + along;
        let v = [d[0] - twice * n[0], d[1] - twice * n[1], d[2] - twice * n[2]];
        let length = dot(v, v).sqrt();
        let mut v = [v[0] / length, v[1] / length, v[2] / length];
        if !points.facing[0].is_empty() {
            let facing = gather(simd, &points.facing, chunk);
            let flat = facing[0].simd_eq(n[0]) & facing[1].simd_eq(n[1]) & facing[2].simd_eq(n[2]);
            let height = dot(v, facing);
            let dips = height.simd_lt(RISE) & !flat;
            let lift = F::splat(simd, RISE) - height;
            let w = [v[0] + lift * facing[0], v[1] + lift * facing[1], v[2] + lift * facing[2]];
            let length = dot(w, w).sqrt();
            for k in 0..3 {
                v[k] = dips.select(w[k] / length, v[k]);
            }
        }
        for k in 0..3 {
            let lanes = first..first + LANES;
            start[k].store_slice(&mut out.origin[k][lanes.clone()]);
            v[k].store_slice(&mut out.dir[k][lanes]);
        }
        for (lane, row) in chunk.iter().enumerate() {
            out.t_max[first + lane] = f32::INFINITY;
            out.last[first + lane] = codes[usize::from(*row)];
        }
    }
    out.pad();
}

/// The rows of three columns, a lane each. (A function: closures are not inlined into kernels.)
#[inline(always)]
fn gather<S: Simd>(simd: S, columns: &[Vec<f32>; 3], rows: &[u16]) -> V3<S> {
    let mut lanes = [[0.0; LANES]; 3];
    for (lane, row) in rows.iter().enumerate() {
        let row = usize::from(*row);
        for k in 0..3 {
            lanes[k][lane] = columns[k][row];
        }
    }
    load3(simd, [&lanes[0], &lanes[1], &lanes[2]])
}
