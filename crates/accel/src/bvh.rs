//! One ray through the tree: eight boxes, then eight primitives at a time.

use crate::blocks::{Block, Blocks, Shelf};
use crate::build::{Child, Tree};
use crate::lanes::{F, LANES, RayLanes, load3};
use crate::rays::{HitCode, Question, Rays};
use crate::slab::{enter, enter_sorted};
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

/// Follows row `i` of `rays` to its closest hit, or to any; `best` holds t and code of the best so
/// far, and is updated.
#[inline(never)]
pub fn cast<S: Simd>(
    simd: S,
    tree: (&Tree, &Blocks),
    ray: (&Rays, usize),
    question: Question,
    best: &mut (f32, HitCode),
    stack: &mut [Key],
) {
    simd.vectorize(
        #[inline(always)]
        || walk(simd, tree, ray, question, best, stack),
    );
}

#[inline(always)]
fn walk<S: Simd>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    (rays, i): (&Rays, usize),
    question: Question,
    best: &mut (f32, HitCode),
    stack: &mut [Key],
) {
    let ray = RayLanes::splat(simd, rays, i);
    let [nx, ny, nz] = [0, 1, 2].map(|k| usize::from(1.0 / rays.dir[k][i] < 0.0));
    let mut found = (best.0, best.1.0);
    let mut end = F::splat(simd, found.0);
    let mut top = 0;
    let mut index = 0;
    'node: loop {
        let node = &tree.nodes[index];
        let sides = [&node.lo, &node.hi];
        let near = load3(simd, [&sides[nx][0], &sides[ny][1], &sides[nz][2]]);
        let far = load3(simd, [&sides[1 - nx][0], &sides[1 - ny][1], &sides[1 - nz][2]]);
        let (entry, passes) = enter_sorted(simd, (&ray.o, &ray.inv), &near, &far);
        // An equal entry may still hold a tie with a lower id.
        let mut bits = (passes & entry.simd_le(end)).to_bitmask() as u32;
        let entries = entry.as_slice();
        let mut next = None;
        if bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            let mut first = key(entries[lane], node.child[lane]);
            if bits != 0 {
                // The nearest goes on at once, the others onto the stack, the farthest lowest.
                let bottom = top;
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize % LANES;
                    bits &= bits - 1;
                    let other = key(entries[lane], node.child[lane]);
                    let (less, more) = if other < first { (other, first) } else { (first, other) };
                    first = less;
                    let mut at = top;
                    while at > bottom && stack[at - 1] < more {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = more;
                    top += 1;
                }
            }
            next = Some(first);
        }
        loop {
            let key = match next.take() {
                Some(key) => key,
                None => loop {
                    if top == 0 {
                        *best = (found.0, HitCode(found.1));
                        return;
                    }
                    top -= 1;
                    if entry_of(stack[top]) <= found.0 {
                        break stack[top];
                    }
                },
            };
            match Child(key as u32).target() {
                Ok(node) => {
                    index = node;
                    continue 'node;
                }
                Err((kind, block)) => {
                    let before = found;
                    found = match kind {
                        ShapeKind::Sphere => test(simd, &blocks.spheres, block, &ray, found, end),
                        // Planes are never in a tree.
                        ShapeKind::Plane => found,
                        ShapeKind::Quad => test(simd, &blocks.quads, block, &ray, found, end),
                        ShapeKind::Triangle => {
                            test(simd, &blocks.triangles, block, &ray, found, end)
                        }
                    };
                    if found != before {
                        if question == Question::Any {
                            *best = (found.0, HitCode(found.1));
                            return;
                        }
                        end = F::splat(simd, found.0);
                    }
                }
            }
        }
    }
}

/// The better of `best` and the closest hit in a block.
#[inline(always)]
fn test<S: Simd, B: Block>(
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
