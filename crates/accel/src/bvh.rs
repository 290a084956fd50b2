//! One ray through the tree: eight boxes, then eight primitives at a time.

use crate::blocks::{Block, Shelf};
use crate::lanes::{F, LANES, RayLanes};
use crate::slab::enter;
use fearless_simd::prelude::*;

/// The better of `best` and the closest hit in a block.
#[inline(always)]
pub fn test<S: Simd, B: Block>(
    simd: S,
    shelf: &Shelf<B>,
    block: usize,
    ray: &RayLanes<S>,
    mut best: (f32, u32),
    end: F<S>,
) -> (f32, u32) {
    let c = shelf.blocks[block].test(simd, ray);
    let near = c.hit & c.t.simd_le(end);
    if near.any_true() {
        let (entry, passes) = enter(simd, ray, &shelf.frames[block].boxes(simd));
        let t = entry.simd_gt(c.t).select(entry, c.t);
        let mut bits = (near & passes & t.simd_le(end)).to_bitmask();
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            let found = (t.as_slice()[lane], c.code.as_slice()[lane]);
            if found.0 < best.0 || (found.0 == best.0 && found.1 < best.1) {
                best = found;
            }
        }
    }
    best
}
