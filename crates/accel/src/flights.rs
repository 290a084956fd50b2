//! Several rays through the tree at once, each on its own way: for rays that find little of what
//! they need in the cache.

use crate::blocks::Blocks;
use crate::bundle::{Bundle, RAYS};
use crate::bvh::test_any_kind;
use crate::count::{self, Counter};
use crate::lanes::{F, LANES};
use crate::rays::Question;
use crate::through;
use crate::tree::{Child, Tree};
use crate::visit::{Key, Slabs, Stack, ask_for, key, visit};
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

/// The stack that [`cast`] needs for a tree of so many levels.
pub fn stack_len(depth: usize) -> usize {
    FLIGHTS * LANES * (depth + 2)
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
    let mut rest = Stack { keys: stack, top: flight.top };
    let mut next = None;
    match Child(flight.next as u32).target() {
        Ok(index) => {
            counter.node();
            let (o, inv) = bundle.slabs(simd, slot);
            let slabs = Slabs { o, inv, near: flight.near };
            next = visit(simd, (tree, blocks), index, &slabs, end, &mut rest);
        }
        Err((ShapeKind::Copy, block)) => {
            let ray = (&bundle.splat(simd, slot), flight.near);
            let before = flight.found;
            let (copy, keys) = (&blocks.copies[block], &mut rest.keys[rest.top..]);
            flight.found = through::cast(simd, copy, ray, question, before, keys, counter);
            if question == Question::Any && flight.found != before {
                return false;
            }
        }
        Err(leaf) => {
            counter.kernel(|| count::prims_of(blocks, leaf.0, leaf.1));
            let ray = bundle.splat(simd, slot);
            let before = flight.found;
            flight.found = test_any_kind(simd, blocks, leaf, &ray, before, end);
            if question == Question::Any && flight.found != before {
                return false;
            }
        }
    }
    let next = next.or_else(
        #[inline(always)]
        || rest.pop(flight.bottom, flight.found.0),
    );
    flight.top = rest.top;
    let Some(next) = next else { return false };
    ask_for(tree, blocks, Child(next as u32));
    flight.next = next;
    true
}
