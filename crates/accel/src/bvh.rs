//! One ray through the tree: eight boxes, then eight primitives at a time.

use crate::blocks::{Block, Blocks, Shelf};
use crate::build::{Child, Node, Tree};
use crate::bundle::Bundle;
use crate::count::{self, Counter};
use crate::lanes::{F, LANES, RayLanes, greater, lesser};
use crate::prefetch::prefetch;
use crate::rays::Question;
use crate::slab::{LEAVE, enter};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// Children still to be visited: where the ray enters them, as the upper half, and what they are.
/// An entry is not negative, so its bits are ordered as it is.
pub type Key = u64;

/// The key of a child.
#[inline(always)]
pub fn key(entry: f32, child: Child) -> Key {
    u64::from(entry.to_bits()) << 32 | u64::from(child.0)
}

/// Where the child of a key is entered.
#[inline(always)]
pub fn entry_of(key: Key) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

/// Follows each ray of the bundle to its closest hit, or to any, one after the other.
#[inline(never)]
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    tree: (&Tree, &Blocks),
    bundle: &mut Bundle,
    question: Question,
    stack: &mut [Key],
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for slot in 0..bundle.len {
                let best = (bundle.t[slot], bundle.code[slot]);
                if bundle.is_castable(slot) {
                    let ray = bundle.splat(simd, slot);
                    let near = bundle.near(slot);
                    let best = walk(simd, tree, (&ray, near), question, best, stack, counter);
                    (bundle.t[slot], bundle.code[slot]) = best;
                }
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
    let mut end = F::splat(simd, found.0);
    let zero = F::splat(simd, 0.0);
    let (mut top, mut index) = (0, 0);
    'node: loop {
        counter.node();
        let node = &tree.nodes[index];
        let mut entry = zero;
        let mut exit = F::splat(simd, f32::INFINITY);
        for (k, row) in near.into_iter().enumerate() {
            let first = (node.faces(simd, row) - ray.o[k]) * ray.inv[k];
            let last = (node.faces(simd, row ^ Node::HI) - ray.o[k]) * ray.inv[k];
            entry = greater(simd, first, entry);
            exit = lesser(simd, last, exit);
        }
        // An equal entry may still hold a tie with a lower id.
        let exit = lesser(simd, exit * LEAVE, end);
        let mut bits = entry.simd_le(exit).to_bitmask() as u32;
        let entries = entry.as_slice();
        let mut next;
        if bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            next = key(entries[lane], node.child(lane));
            // The nearest goes on at once, the others onto the stack, the farthest lowest.
            let bottom = top;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize % LANES;
                bits &= bits - 1;
                let other = key(entries[lane], node.child(lane));
                let more = next.max(other);
                next = next.min(other);
                let mut at = top;
                while at > bottom && stack[at - 1] < more {
                    stack[at] = stack[at - 1];
                    at -= 1;
                }
                stack[at] = more;
                top += 1;
                match Child(more as u32).target() {
                    Ok(index) => prefetch(&tree.nodes, index),
                    Err((ShapeKind::Sphere, block)) => prefetch(&blocks.spheres.blocks, block),
                    Err((ShapeKind::Quad, block)) => prefetch(&blocks.quads.blocks, block),
                    Err((ShapeKind::Solid, block)) => prefetch(&blocks.solids.blocks, block),
                    Err((_, block)) => prefetch(&blocks.triangles.blocks, block),
                }
            }
        } else {
            loop {
                if top == 0 {
                    return found;
                }
                top -= 1;
                if entry_of(stack[top]) <= found.0 {
                    next = stack[top];
                    break;
                }
            }
        }
        loop {
            match Child(next as u32).target() {
                Ok(node) => {
                    index = node;
                    continue 'node;
                }
                Err((kind, block)) => {
                    let before = found;
                    counter.kernel(|| count::prims_of(blocks, kind, block));
                    found = match kind {
                        ShapeKind::Sphere => test(simd, &blocks.spheres, block, ray, found, end),
                        // Planes are never in a tree.
                        ShapeKind::Plane => found,
                        ShapeKind::Quad => test(simd, &blocks.quads, block, ray, found, end),
                        ShapeKind::Triangle => {
                            test(simd, &blocks.triangles, block, ray, found, end)
                        }
                        ShapeKind::Solid => test(simd, &blocks.solids, block, ray, found, end),
                    };
                    if found != before {
                        if question == Question::Any {
                            return found;
                        }
                        end = F::splat(simd, found.0);
                    }
                }
            }
            loop {
                if top == 0 {
                    return found;
                }
                top -= 1;
                if entry_of(stack[top]) <= found.0 {
                    next = stack[top];
                    break;
                }
            }
        }
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
