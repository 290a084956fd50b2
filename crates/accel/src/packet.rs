//! Rays in lanes against few primitives: infinite planes, and scenes too small for a tree.

use crate::blocks::{Block, Blocks};
use crate::lanes::{F, LANES, PerLane, RayLanes, U};
use crate::rays::{HitCode, Rays};
use crate::slab::enter;
use fearless_simd::prelude::*;

/// The best hit so far, a ray a lane.
#[derive(Clone, Copy)]
struct Best<S: Simd> {
    t: F<S>,
    code: U<S>,
}

/// Tests all rays against all of `blocks`; `t` and `code` hold the best so far, and are updated.
#[inline(always)]
pub fn closest<S: Simd>(
    simd: S,
    blocks: &Blocks,
    rays: &Rays,
    t: &mut [f32],
    code: &mut [HitCode],
) {
    for first in (0..rays.len()).step_by(LANES) {
        let ray = RayLanes::load(simd, rays, first);
        let lanes = first..first + LANES;
        let mut codes = [0; LANES];
        for (c, h) in codes.iter_mut().zip(&code[lanes.clone()]) {
            *c = h.0;
        }
        let mut best =
            Best { t: ray.ends(simd, &t[lanes.clone()]), code: U::from_slice(simd, &codes) };
        best = closest_of(simd, &blocks.spheres, &ray, best);
        best = closest_of(simd, &blocks.planes, &ray, best);
        best = closest_of(simd, &blocks.quads, &ray, best);
        best = closest_of(simd, &blocks.triangles, &ray, best);
        // Rays that can hit nothing keep their end as it was given.
        let hit = !best.code.simd_eq(0u32);
        let ends = F::from_slice(simd, &t[lanes.clone()]);
        hit.select(best.t, ends).store_slice(&mut t[lanes.clone()]);
        for (h, c) in code[lanes].iter_mut().zip(best.code.as_slice()) {
            *h = HitCode(*c);
        }
    }
}

#[inline(always)]
fn closest_of<S: Simd, B: Block>(
    simd: S,
    blocks: &[B],
    ray: &RayLanes<S, PerLane<S>>,
    mut best: Best<S>,
) -> Best<S> {
    for block in blocks {
        for lane in 0..block.used() {
            let c = block.test_one(simd, ray, lane);
            if (c.hit & c.t.simd_le(best.t)).any_true() {
                let (entry, passes) = enter(simd, ray, &block.box_of(simd, lane));
                let t = entry.simd_gt(c.t).select(entry, c.t);
                let wins = t.simd_lt(best.t) | (t.simd_eq(best.t) & c.code.simd_lt(best.code));
                let take = c.hit & passes & wins;
                best.t = take.select(t, best.t);
                best.code = take.select(c.code, best.code);
            }
        }
    }
    best
}

/// Marks the rays that hit any of `blocks` before their end.
#[inline(always)]
pub fn any<S: Simd>(simd: S, blocks: &Blocks, rays: &Rays, occluded: &mut [bool]) {
    for first in (0..rays.len()).step_by(LANES) {
        let ray = RayLanes::load(simd, rays, first);
        let lanes = first..(first + LANES).min(rays.len());
        let ends = ray.ends(simd, &rays.t_max[first..first + LANES]);
        let mut hit = [false; LANES];
        any_of(simd, &blocks.spheres, &ray, ends, &mut hit);
        any_of(simd, &blocks.planes, &ray, ends, &mut hit);
        any_of(simd, &blocks.quads, &ray, ends, &mut hit);
        any_of(simd, &blocks.triangles, &ray, ends, &mut hit);
        for (o, h) in occluded[lanes].iter_mut().zip(hit) {
            *o |= h;
        }
    }
}

#[inline(always)]
fn any_of<S: Simd, B: Block>(
    simd: S,
    blocks: &[B],
    ray: &RayLanes<S, PerLane<S>>,
    ends: F<S>,
    hit: &mut [bool; LANES],
) {
    for block in blocks {
        for lane in 0..block.used() {
            let c = block.test_one(simd, ray, lane);
            let before = c.hit & c.t.simd_lt(ends);
            if before.any_true() {
                let (entry, passes) = enter(simd, ray, &block.box_of(simd, lane));
                let bits = (before & passes & entry.simd_lt(ends)).to_bitmask();
                for (i, h) in hit.iter_mut().enumerate() {
                    *h |= bits >> i & 1 == 1;
                }
            }
        }
    }
}
