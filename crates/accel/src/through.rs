//! One ray through a copy of a mesh.

use crate::blocks::Block;
use crate::copies::{CopyBlock, PlacedTriangles};
use crate::count::{self, Counter};
use crate::lanes::{F, LANES, RayLanes, greater, lesser};
use crate::rays::Question;
use crate::slab::LEAVE;
use crate::tree::{Child, Node};
use fearless_simd::prelude::*;

/// Children still to be visited: where the ray enters them, as the upper half, and what they are.
/// An entry is not negative, so its bits are ordered as it is.
pub type Key = u64;

/// The key of a child.
#[inline(always)]
fn key(entry: f32, child: Child) -> Key {
    u64::from(entry.to_bits()) << 32 | u64::from(child.0)
}

/// Puts a key onto the part of a stack from `bottom` to `top` that is in order, the farthest lowest;
/// gives the new top.
#[inline(always)]
fn insert(keys: &mut [Key], bottom: usize, top: usize, key: Key) -> usize {
    let mut at = top;
    while at > bottom && keys[at - 1] < key {
        keys[at] = keys[at - 1];
        at -= 1;
    }
    keys[at] = key;
    top + 1
}

/// Where the child of a key is entered.
#[inline(always)]
fn entry_of(key: Key) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

/// The better of `found` and the closest hit of a ray (in all lanes) in a copy, or any. `near` says
/// for each axis which row of a node holds the faces that the ray meets first; `keys` is what is
/// left of the stack. (Not inlined: it is rare, and would make the code around it long.)
#[inline(never)]
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    copy: &CopyBlock,
    (ray, near): (&RayLanes<S>, [usize; 3]),
    question: Question,
    found: (f32, u32),
    keys: &mut [Key],
    counter: &mut C,
) -> (f32, u32) {
    if copy.mesh.tree.nodes.is_empty() || copy.bounds().is_empty() {
        return found;
    }
    simd.vectorize(
        #[inline(always)]
        || walk(simd, copy, (ray, near), question, found, keys, counter),
    )
}

#[inline(always)]
fn walk<S: Simd, C: Counter>(
    simd: S,
    copy: &CopyBlock,
    (ray, near): (&RayLanes<S>, [usize; 3]),
    question: Question,
    mut found: (f32, u32),
    keys: &mut [Key],
    counter: &mut C,
) -> (f32, u32) {
    let mut placed = PlacedTriangles::default();
    let mut top = 1;
    keys[0] = key(0.0, Child::ROOT);
    while top > 0 {
        top -= 1;
        if entry_of(keys[top]) > found.0 {
            continue;
        }
        let end = F::splat(simd, found.0);
        match Child(keys[top] as u32).target() {
            Ok(index) => {
                counter.node();
                let node = &copy.mesh.tree.nodes[index];
                let (entry, bits) = meet(simd, copy, node, (ray, near), end);
                top = push(node, entry.as_slice(), bits, (keys, top));
            }
            Err((_, block)) => {
                let block_of = &copy.mesh.blocks.triangles.blocks[block];
                counter.kernel(LANES, || count::prims_of(block_of.codes()));
                let before = found;
                found = test(simd, copy, block, ray, (found, end), &mut placed);
                if question == Question::Any && found != before {
                    return found;
                }
            }
        }
    }
    found
}

/// Where the ray enters a node's children, and which of them it meets before `end`.
#[inline(always)]
fn meet<S: Simd>(
    simd: S,
    copy: &CopyBlock,
    node: &Node,
    (ray, near): (&RayLanes<S>, [usize; 3]),
    end: F<S>,
) -> (F<S>, u32) {
    let boxes = copy.children(simd, node);
    let mut entry = F::splat(simd, 0.0);
    let mut exit = F::splat(simd, f32::INFINITY);
    for (k, row) in near.into_iter().enumerate() {
        let is_low = row < Node::HI;
        let (first, last) =
            if is_low { (boxes.lo[k], boxes.hi[k]) } else { (boxes.hi[k], boxes.lo[k]) };
        entry = greater(simd, (first - ray.o[k]) * ray.inv[k], entry);
        exit = lesser(simd, (last - ray.o[k]) * ray.inv[k], exit);
    }
    // An equal entry may still hold a tie with a lower id.
    let exit = lesser(simd, exit * LEAVE, end);
    (entry, entry.simd_le(exit).to_bitmask() as u32)
}

/// Puts children onto the stack, the farthest lowest; gives its top.
#[inline(always)]
fn push(node: &Node, entries: &[f32], mut bits: u32, (keys, bottom): (&mut [Key], usize)) -> usize {
    let mut top = bottom;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize % LANES;
        bits &= bits - 1;
        top = insert(keys, bottom, top, key(entries[lane], node.child(lane)));
    }
    top
}

/// The better of `best` and the closest hit in a leaf, its triangles put into the scene.
#[inline(always)]
fn test<S: Simd>(
    simd: S,
    copy: &CopyBlock,
    block: usize,
    ray: &RayLanes<S>,
    (mut best, end): ((f32, u32), F<S>),
    placed: &mut PlacedTriangles,
) -> (f32, u32) {
    copy.place_leaf(block, placed);
    let c = placed.block().test(simd, ray);
    let mut bits = (c.hit & c.t.simd_le(end)).to_bitmask();
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize % LANES;
        bits &= bits - 1;
        let code = c.code.as_slice()[lane];
        if let Some(t) = placed.enter(ray, lane, c.t.as_slice()[lane])
            && (t < best.0 || (t == best.0 && code < best.1))
        {
            best = (t, code);
        }
    }
    best
}
