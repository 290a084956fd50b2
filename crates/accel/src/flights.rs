//! Rays through the tree, each on its own way and many at once: all whose next step is a node, then
//! all whose next step is a leaf.
//!
//! What a ray does next never steers a branch: the children that it meets are sorted and packed in
//! registers, the next one is found on its stack by one comparison in lanes, and each ray is put on
//! the list of what it needs next. So nothing is mispredicted, and while the memory that one ray
//! needs is on its way, the others go on. (Wald et al., "Interactive Rendering with Coherent Ray
//! Tracing", 2001, hide latency so within a packet; here the rays need have nothing in common.
//! Barringer and Akenine-Möller, "Dynamic Ray Stream Traversal", SIGGRAPH 2014, keep lists, too.)

use crate::blocks::Blocks;
use crate::bundle::{Bundle, RAYS};
use crate::bvh::test_any_kind;
use crate::count::{self, Counter};
use crate::lanes::{F, LANES};
use crate::order::{self, Packed};
use crate::prefetch::Ahead;
use crate::rays::Question;
use crate::slab::LEAVE;
use crate::tree::{Child, Tree};
use fearless_simd::prelude::*;

use crate::lanes::{greater, lesser};

/// How many rays are under way at once.
const FLIGHTS: usize = 32;

/// A list is worked off once it has more rays than this: few rays leave gaps that more would fill.
const FEW: usize = 8;

/// A list of flights; lengths are kept apart.
type List = [u8; FLIGHTS];

/// What rays under way have still to visit: where they enter it, and what it is.
#[derive(Default)]
pub struct Stacks {
    entries: Vec<f32>,
    children: Vec<u32>,
}

impl Stacks {
    /// Makes room for a tree.
    pub fn fit(&mut self, tree: &Tree) {
        let len = FLIGHTS * room(tree);
        if self.entries.len() < len {
            self.entries.resize(len, 0.0);
            self.children.resize(len, 0);
        }
    }
}

/// What one ray needs: the end of its stack, what all nodes on its way may leave there, and as
/// much as is written at once.
fn room(tree: &Tree) -> usize {
    LANES * (tree.depth + 3)
}

/// Where rays under way are.
struct Flights {
    /// Which ray of the bundle.
    slot: [u8; FLIGHTS],
    /// What it visits next.
    next: [Child; FLIGHTS],
    /// Where the top of its stack is.
    top: [u32; FLIGHTS],
    /// For each axis, which row of a node holds the faces that the ray meets first.
    near: [[u8; 4]; FLIGHTS],
    /// Those at a node, those at a leaf, and those that are done.
    lists: [List; 3],
    /// How many they are.
    counts: [usize; 3],
}

const NODES: usize = 0;
const LEAVES: usize = 1;
const DONE: usize = 2;

/// On which list a ray is put, by the kind of what it visits next.
const LIST_OF: [u8; Child::KINDS] = {
    let mut list = [NODES as u8; Child::KINDS];
    let mut kind = Child::KINDS / 2;
    while kind < Child::KINDS {
        list[kind] = LEAVES as u8;
        kind += 1;
    }
    list[Child::NONE.kind()] = DONE as u8;
    list
};

/// Follows those rays of the bundle whose bits are set in `todo` to their closest hit, or to any.
#[inline(never)]
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    tree: (&Tree, &Blocks),
    (bundle, todo): (&mut Bundle, u64),
    question: Question,
    stacks: &mut Stacks,
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || fly(simd, tree, (bundle, todo), question, stacks, counter),
    );
}

#[inline(always)]
fn fly<S: Simd, C: Counter>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    (bundle, mut todo): (&mut Bundle, u64),
    question: Question,
    stacks: &mut Stacks,
    counter: &mut C,
) {
    let room = room(tree);
    let ahead = Ahead::of(tree, blocks);
    let mut f = Flights {
        slot: [0; FLIGHTS],
        next: [Child::ROOT; FLIGHTS],
        top: [0; FLIGHTS],
        near: [[0; 4]; FLIGHTS],
        lists: [[0; FLIGHTS]; 3],
        counts: [0, 0, FLIGHTS],
    };
    for i in 0..FLIGHTS {
        f.lists[DONE][i] = i as u8;
        let bottom = i * room;
        // Nothing is entered as early as what lies at the bottom, so that it is always found.
        stacks.entries[bottom..bottom + LANES].fill(f32::NEG_INFINITY);
        stacks.children[bottom..bottom + LANES].fill(Child::NONE.0);
    }
    loop {
        if f.counts[DONE] > 0 && todo != 0 {
            start(&mut f, bundle, &mut todo, room);
        }
        let (nodes, leaves) = (f.counts[NODES], f.counts[LEAVES]);
        if nodes + leaves == 0 {
            return;
        }
        if nodes > FEW || (leaves <= FEW && nodes >= leaves) {
            let list = f.lists[NODES];
            f.counts[NODES] = 0;
            for i in list.iter().take(nodes) {
                counter.node();
                visit(simd, tree, bundle, &mut f, usize::from(*i) % FLIGHTS, stacks);
            }
            for i in list.iter().take(nodes) {
                go_on(simd, bundle, &mut f, usize::from(*i) % FLIGHTS, stacks, &ahead);
            }
        } else {
            let mut list = f.lists[LEAVES];
            f.counts[LEAVES] = 0;
            let mut rest = 0;
            for j in 0..leaves.min(FLIGHTS) {
                let i = usize::from(list[j]) % FLIGHTS;
                let slot = usize::from(f.slot[i]) % RAYS;
                let Err(leaf) = f.next[i].target() else { continue };
                counter.kernel(|| count::prims_of(blocks, leaf.0, leaf.1));
                let ray = bundle.splat(simd, slot);
                let before = (bundle.t[slot], bundle.code[slot]);
                let end = F::splat(simd, before.0);
                let found = test_any_kind(simd, blocks, leaf, &ray, before, end);
                (bundle.t[slot], bundle.code[slot]) = found;
                if question == Question::Any && found != before {
                    f.put(i, DONE);
                } else {
                    list[rest % FLIGHTS] = i as u8;
                    rest += 1;
                }
            }
            for i in list.iter().take(rest) {
                go_on(simd, bundle, &mut f, usize::from(*i) % FLIGHTS, stacks, &ahead);
            }
        }
    }
}

impl Flights {
    #[inline(always)]
    fn put(&mut self, flight: usize, list: usize) {
        let count = self.counts[list];
        self.lists[list][count % FLIGHTS] = flight as u8;
        self.counts[list] = count + 1;
    }
}

/// Sets off with the next rays in place of those that are done.
#[inline(always)]
fn start(f: &mut Flights, bundle: &Bundle, todo: &mut u64, room: usize) {
    while *todo != 0 && f.counts[DONE] > 0 {
        let slot = todo.trailing_zeros() as usize % RAYS;
        *todo &= *todo - 1;
        f.counts[DONE] -= 1;
        let i = usize::from(f.lists[DONE][f.counts[DONE] % FLIGHTS]) % FLIGHTS;
        f.slot[i] = slot as u8;
        let [x, y, z] = bundle.near(slot);
        let octant = bundle.octant(slot);
        f.near[i] = [x as u8, y as u8, z as u8, octant as u8];
        f.top[i] = (i * room + LANES) as u32;
        f.next[i] = Child::ROOT;
        f.put(i, NODES);
    }
}

/// Holds a ray against the boxes of a node's children; those that it meets go onto its stack, the
/// farthest lowest.
#[inline(always)]
fn visit<S: Simd>(
    simd: S,
    tree: &Tree,
    bundle: &Bundle,
    f: &mut Flights,
    i: usize,
    stacks: &mut Stacks,
) {
    let node = &tree.nodes[f.next[i].0 as usize];
    let slot = usize::from(f.slot[i]) % RAYS;
    let (o, inv) = bundle.slabs(simd, slot);
    let [x, y, z, octant] = f.near[i].map(usize::from);
    let mut entry = F::splat(simd, 0.0);
    let mut exit = F::splat(simd, f32::INFINITY);
    for (k, row) in [x, y, z].into_iter().enumerate() {
        let first = (node.faces(simd, row) - o[k]) * inv[k];
        let last = (node.faces(simd, row ^ crate::tree::Node::HI) - o[k]) * inv[k];
        entry = greater(simd, first, entry);
        exit = lesser(simd, last, exit);
    }
    // An equal entry may still hold a tie with a lower id.
    let exit = lesser(simd, exit * LEAVE, F::splat(simd, bundle.t[slot]));
    let met = entry.simd_le(exit);
    let Packed { entries, children, count } =
        order::pack(simd, entry, met, node.children(), node.order(octant));
    let top = f.top[i] as usize;
    stacks.entries[top..top + LANES].copy_from_slice(&entries);
    stacks.children[top..top + LANES].copy_from_slice(&children);
    f.top[i] += count;
}

/// Takes from a ray's stack what it visits next: the topmost that it enters before its end.
#[inline(always)]
fn go_on<S: Simd>(
    simd: S,
    bundle: &Bundle,
    f: &mut Flights,
    i: usize,
    stacks: &mut Stacks,
    ahead: &Ahead,
) {
    let end = F::splat(simd, bundle.t[usize::from(f.slot[i]) % RAYS]);
    let mut top = f.top[i] as usize;
    let mut met;
    loop {
        top -= LANES;
        let entries = F::from_slice(simd, &stacks.entries[top..top + LANES]);
        met = entries.simd_le(end).to_bitmask() as u32;
        if met != 0 {
            break;
        }
    }
    top += met.ilog2() as usize;
    let next = Child(stacks.children[top]);
    f.top[i] = top as u32;
    f.next[i] = next;
    ahead.ask_for(next);
    f.put(i, usize::from(LIST_OF[next.kind()]) % 3);
}
