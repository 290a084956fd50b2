//! Several rays through the tree at once, each on its own way: for rays that find little of what
//! they need in the cache.

use crate::blocks::Blocks;
use crate::build::{Child, Node, Tree};
use crate::bundle::{Bundle, RAYS};
use crate::bvh::{Key, entry_of, key, test};
use crate::count::{self, Counter};
use crate::lanes::{F, LANES, greater, lesser};
use crate::prefetch::prefetch;
use crate::rays::Question;
use crate::slab::LEAVE;
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// How many rays are under way at once: while the node or block that one of them needs next is on
/// its way from memory, the others go on. (Wald et al., "Interactive Rendering with Coherent Ray
/// Tracing", 2001, hide latency so within a packet; here the rays need have nothing in common.)
const FLIGHTS: usize = 6;

/// A ray under way.
#[derive(Clone, Copy, Default)]
struct Flight {
    /// Which ray of the bundle.
    slot: usize,
    /// For each axis, which row of a node holds the faces that the ray meets first.
    near: [usize; 3],
    /// The best t and code so far.
    found: (f32, u32),
    /// What it visits next.
    next: Key,
    /// Where its part of the stack begins, and where its top is.
    bottom: usize,
    top: usize,
}

/// Follows each ray of the bundle to its closest hit, or to any.
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
        || fly(simd, tree, bundle, question, stack, counter),
    );
}

/// The stack that [`cast`] needs for a tree.
pub fn stack_len(tree: &Tree) -> usize {
    FLIGHTS * LANES * (tree.depth + 1)
}

#[inline(always)]
fn fly<S: Simd, C: Counter>(
    simd: S,
    tree: (&Tree, &Blocks),
    bundle: &mut Bundle,
    question: Question,
    stack: &mut [Key],
    counter: &mut C,
) {
    let mut flights = [Flight::default(); FLIGHTS];
    let mut count = 0;
    let mut slot = 0;
    let room = stack.len() / FLIGHTS;
    for (i, flight) in flights.iter_mut().enumerate() {
        flight.bottom = i * room;
        if flight.start(bundle, &mut slot) {
            count += 1;
        }
    }
    while count > 0 {
        let mut i = 0;
        while i < count {
            let flight = &mut flights[i % FLIGHTS];
            if step(simd, tree, bundle, question, flight, stack, counter) {
                i += 1;
                continue;
            }
            (bundle.t[flight.slot % RAYS], bundle.code[flight.slot % RAYS]) = flight.found;
            if !flight.start(bundle, &mut slot) {
                count -= 1;
                flights.swap(i % FLIGHTS, count % FLIGHTS);
            }
        }
    }
}

impl Flight {
    /// Sets off with the next ray from `slot` on that can hit anything, if there is one.
    #[inline(always)]
    fn start(&mut self, bundle: &Bundle, slot: &mut usize) -> bool {
        while *slot < bundle.len {
            let i = *slot % RAYS;
            *slot += 1;
            if bundle.is_castable(i) {
                self.slot = i;
                self.near = bundle.near(i);
                self.found = (bundle.t[i], bundle.code[i]);
                self.next = key(0.0, Child::ROOT);
                self.top = self.bottom;
                return true;
            }
        }
        false
    }
}

/// Visits a node or a block; `false` if that was the last.
#[inline(always)]
fn step<S: Simd, C: Counter>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    bundle: &Bundle,
    question: Question,
    flight: &mut Flight,
    stack: &mut [Key],
    counter: &mut C,
) -> bool {
    let slot = flight.slot;
    let end = F::splat(simd, flight.found.0);
    let mut next = None;
    match Child(flight.next as u32).target() {
        Ok(index) => {
            counter.node();
            let node = &tree.nodes[index];
            let (o, inv) = bundle.slabs(simd, slot);
            let mut entry = F::splat(simd, 0.0);
            let mut exit = F::splat(simd, f32::INFINITY);
            for k in 0..3 {
                let first = (node.faces(simd, flight.near[k]) - o[k]) * inv[k];
                let last = (node.faces(simd, flight.near[k] ^ Node::HI) - o[k]) * inv[k];
                entry = greater(simd, first, entry);
                exit = lesser(simd, last, exit);
            }
            // An equal entry may still hold a tie with a lower id.
            let exit = lesser(simd, exit * LEAVE, end);
            let mut bits = entry.simd_le(exit).to_bitmask() as u32;
            let entries = entry.as_slice();
            if bits != 0 {
                let lane = bits.trailing_zeros() as usize % LANES;
                bits &= bits - 1;
                let mut nearest = key(entries[lane], node.child(lane));
                // The nearest goes on at once, the others onto the stack, the farthest lowest.
                let (bottom, mut top) = (flight.top, flight.top);
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize % LANES;
                    bits &= bits - 1;
                    let other = key(entries[lane], node.child(lane));
                    let more = nearest.max(other);
                    nearest = nearest.min(other);
                    let mut at = top;
                    while at > bottom && stack[at - 1] < more {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = more;
                    top += 1;
                }
                flight.top = top;
                next = Some(nearest);
            }
        }
        Err((kind, block)) => {
            counter.kernel(|| count::prims_of(blocks, kind, block));
            let ray = bundle.splat(simd, slot);
            let before = flight.found;
            let found = match kind {
                ShapeKind::Sphere => test(simd, &blocks.spheres, block, &ray, before, end),
                // Planes are never in a tree.
                ShapeKind::Plane => before,
                ShapeKind::Quad => test(simd, &blocks.quads, block, &ray, before, end),
                ShapeKind::Triangle => test(simd, &blocks.triangles, block, &ray, before, end),
                ShapeKind::Solid => test(simd, &blocks.solids, block, &ray, before, end),
            };
            flight.found = found;
            if question == Question::Any && found != before {
                return false;
            }
        }
    }
    let next = match next {
        Some(next) => next,
        None => loop {
            if flight.top == flight.bottom {
                return false;
            }
            flight.top -= 1;
            let next = stack[flight.top];
            if entry_of(next) <= flight.found.0 {
                break next;
            }
        },
    };
    match Child(next as u32).target() {
        Ok(index) => prefetch(&tree.nodes, index),
        Err((ShapeKind::Sphere, block)) => prefetch(&blocks.spheres.blocks, block),
        Err((ShapeKind::Quad, block)) => prefetch(&blocks.quads.blocks, block),
        Err((ShapeKind::Solid, block)) => prefetch(&blocks.solids.blocks, block),
        Err((_, block)) => prefetch(&blocks.triangles.blocks, block),
    }
    flight.next = next;
    true
}
