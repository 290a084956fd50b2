//! One ray through the tree: eight boxes, then eight primitives at a time.

use crate::blocks::{Block, Blocks, Shelf};
use crate::bundle::{Bundle, RAYS};
use crate::count::{self, Counter};
use crate::lanes::{F, LANES, RayLanes};
use crate::rays::Question;
use crate::slab::enter;
use crate::through;
use crate::tree::{Child, Tree};
use crate::visit::{Key, Slabs, Stack, visit};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// Follows those rays of the bundle whose bits are set in `todo` to their closest hit, or to any, one
/// after the other. Where rays take much the same way through a small tree, it is foreseen so well
/// that nothing beats it.
#[inline(never)]
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    tree: (&Tree, &Blocks),
    (bundle, mut todo): (&mut Bundle, u64),
    question: Question,
    stack: &mut [Key],
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            while todo != 0 {
                let slot = todo.trailing_zeros() as usize % RAYS;
                todo &= todo - 1;
                let best = (bundle.t[slot], bundle.code[slot]);
                let ray = bundle.splat(simd, slot);
                let near = bundle.near(slot);
                let best = walk(simd, tree, (&ray, near), question, best, stack, counter);
                (bundle.t[slot], bundle.code[slot]) = best;
            }
        },
    );
}

/// The better of `found` and the closest hit in the tree, or any. `near` says for each axis which
/// row of a node holds the faces that the ray meets first.
#[inline(always)]
fn walk<S: Simd, C: Counter>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    (ray, near): (&RayLanes<S>, [usize; 3]),
    question: Question,
    mut found: (f32, u32),
    stack: &mut [Key],
    counter: &mut C,
) -> (f32, u32) {
    let slabs = Slabs { o: ray.o, inv: ray.inv, near };
    let mut stack = Stack { keys: stack, top: 0 };
    let mut end = F::splat(simd, found.0);
    let mut index = 0;
    'node: loop {
        counter.node();
        let mut next = match visit(simd, (tree, blocks), index, &slabs, end, &mut stack) {
            Some(nearest) => nearest,
            None => match stack.pop(0, found.0) {
                Some(next) => next,
                None => return found,
            },
        };
        loop {
            match Child(next as u32).target() {
                Ok(node) => {
                    index = node;
                    continue 'node;
                }
                Err(leaf) => {
                    let before = found;
                    if let (ShapeKind::Copy, block) = leaf {
                        let (copy, keys) = (&blocks.copies[block], &mut stack.keys[stack.top..]);
                        let ray = (ray, near);
                        found = through::cast(simd, copy, ray, question, found, keys, counter);
                    } else {
                        counter.kernel(LANES, || count::prims_of(blocks.codes(leaf.0, leaf.1)));
                        found = test_any_kind(simd, blocks, leaf, ray, found, end);
                    }
                    if found != before {
                        if question == Question::Any {
                            return found;
                        }
                        end = F::splat(simd, found.0);
                    }
                }
            }
            next = match stack.pop(0, found.0) {
                Some(next) => next,
                None => return found,
            };
        }
    }
}

/// The better of `best` and the closest hit in a block of any kind.
#[inline(always)]
pub fn test_any_kind<S: Simd>(
    simd: S,
    blocks: &Blocks,
    (kind, block): (ShapeKind, usize),
    ray: &RayLanes<S>,
    best: (f32, u32),
    end: F<S>,
) -> (f32, u32) {
    match kind {
        ShapeKind::Sphere => test(simd, &blocks.spheres, block, ray, best, end),
        // Planes are never in a tree, and copies are gone through.
        ShapeKind::Plane | ShapeKind::Copy => best,
        ShapeKind::Quad => test(simd, &blocks.quads, block, ray, best, end),
        ShapeKind::Triangle => test(simd, &blocks.triangles, block, ray, best, end),
        ShapeKind::Solid => test(simd, &blocks.solids, block, ray, best, end),
    }
}

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
