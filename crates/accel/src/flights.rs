//! Rays through the tree, each on its own way and many at once: all whose next step is a node, then
//! all whose next step is a leaf.
//!
//! What a ray does next never steers a branch: the children that it meets are sorted and packed in
//! registers, the next one is found on its stack by one comparison in lanes, and each ray is put on
//! the list of what it needs next. So nothing is mispredicted, and while the memory that one ray
//! needs is on its way, the others go on. (Wald et al., "Interactive Rendering with Coherent Ray
//! Tracing", 2001, hide latency so within a packet; here the rays need have nothing in common.
//! Barringer and Akenine-Möller, "Dynamic Ray Stream Traversal", SIGGRAPH 2014, keep lists, too.)

use crate::blocks::{Block, Blocks, Shelf};
use crate::bundle::{Bundle, RAYS};
use crate::copies::CopyBlock;
use crate::count::{self, Counter};
use crate::lanes::{F, LANES, RayLanes, U, greater, lesser};
use crate::order::{self, Packed};
use crate::prefetch::{Ahead, prefetch};
use crate::rays::Question;
use crate::slab::{BoxLanes, LEAVE, enter};
use crate::through;
use crate::tree::{Child, Node, Tree};
use crate::visit::Key;
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// How many rays are under way at once.
const FLIGHTS: usize = 32;

/// A list is worked off once it has more rays than this: few rays leave gaps that more would fill.
const FEW: usize = 8;

/// Some of the rays under way; how many is kept apart.
type List = [u8; FLIGHTS];

/// How many lists there are: one a kind of child.
const LISTS: usize = Child::KINDS;
/// The list of rays at a node.
const NODES: usize = 0;
/// The list of rays that have nothing more to visit.
const DONE: usize = Child::NONE.kind();

/// Room for what all rays may have still to visit; a power of two, so that a place can be told to
/// lie within by a mask. No more is touched than a tree needs.
const ROOM: usize = 1 << 16;

/// Where the second column begins. Were the two a multiple of 4096 bytes apart, loads of the one
/// would wait for stores into the other.
const CHILDREN: usize = ROOM + 520;

/// What rays under way have still to visit: where they enter it, by its bits, and what it is.
pub struct Stacks {
    words: Box<[u32; CHILDREN + ROOM + LANES]>,
    /// How much of each column a ray has.
    share: usize,
}

impl Default for Stacks {
    fn default() -> Self {
        match vec![0; CHILDREN + ROOM + LANES].try_into() {
            Ok(words) => Stacks { words, share: 0 },
            Err(_) => unreachable!("they are so many"),
        }
    }
}

impl Stacks {
    /// Shares the room out for a tree. Shares lie close to each other: in a cache of few ways they
    /// would else compete for the same lines.
    ///
    /// # Panics
    /// If the tree has more than 250 levels; one of binned branches has at most a hundred.
    pub fn fit(&mut self, tree: &Tree) {
        // The end of a stack, what all nodes on the way may leave there, and what is written at
        // once.
        let share = LANES * (tree.depth + 3);
        if share == self.share {
            return;
        }
        assert!(share * FLIGHTS <= ROOM, "a tree of {} levels", tree.depth);
        self.share = share;
        for bottom in (0..FLIGHTS).map(|i| i * share) {
            // Nothing is entered as early as what lies at the bottom: it is always found.
            self.words[bottom..bottom + LANES].fill(f32::NEG_INFINITY.to_bits());
            self.words[CHILDREN + bottom..][..LANES].fill(Child::NONE.0);
        }
    }

    /// Where the eight from some place on are entered.
    #[inline(always)]
    fn entries<S: Simd>(&self, simd: S, at: u32) -> F<S> {
        let first = at as usize % ROOM;
        F::from_bits(U::from_slice(simd, &self.words[first..first + LANES]))
    }

    /// What is at a place.
    #[inline(always)]
    fn child(&self, at: u32) -> Child {
        Child(self.words[CHILDREN + at as usize % ROOM])
    }

    /// Writes eight.
    #[inline(always)]
    fn put(&mut self, at: u32, entries: &[u32; LANES], children: &[u32; LANES]) {
        let first = at as usize % ROOM;
        self.words[first..first + LANES].copy_from_slice(entries);
        self.words[CHILDREN + first..CHILDREN + first + LANES].copy_from_slice(children);
    }
}

/// Where rays under way are.
struct Flights {
    /// Which ray of the bundle.
    slot: [u8; FLIGHTS],
    /// What it visits next.
    next: [Child; FLIGHTS],
    /// Where the top of its stack is.
    top: [u32; FLIGHTS],
    /// For each axis, which row of a node holds the faces that the ray meets first; and its octant.
    near: [[u8; 4]; FLIGHTS],
    /// Which rays need what next.
    lists: [List; LISTS],
    /// How many they are.
    counts: [usize; LISTS],
}

/// Follows those rays of the bundle whose bits are set in `todo` to their closest hit, or to any.
/// `keys` is room for those that go through copies of meshes.
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    (bundle, mut todo): (&mut Bundle, u64),
    question: Question,
    (stacks, keys): (&mut Stacks, &mut [Key]),
    counter: &mut C,
) {
    let ahead = Ahead::of(tree, blocks);
    let mut f = Flights::new();
    loop {
        if todo != 0 && f.counts[DONE] > 0 {
            f.start(bundle, &mut todo, stacks.share);
        }
        let (mut kind, mut leaves) = (ShapeKind::Sphere, 0);
        for each in ShapeKind::ALL {
            let count = f.counts[Child::block(each, 0).kind()];
            if count > leaves {
                (kind, leaves) = (each, count);
            }
        }
        let nodes = f.counts[NODES];
        if nodes + leaves == 0 {
            return;
        }
        let at = (question, &mut f, &mut *bundle);
        let way = (&mut *stacks, &ahead);
        if nodes > FEW || (leaves <= FEW && nodes >= leaves) {
            visit_all(simd, tree, at, way, counter);
            continue;
        }
        match kind {
            ShapeKind::Sphere => test_all(simd, &blocks.spheres, kind, at, way, counter),
            // Planes are never in a tree.
            ShapeKind::Plane => {}
            ShapeKind::Quad => test_all(simd, &blocks.quads, kind, at, way, counter),
            ShapeKind::Triangle => test_all(simd, &blocks.triangles, kind, at, way, counter),
            ShapeKind::Solid => test_all(simd, &blocks.solids, kind, at, way, counter),
            ShapeKind::Copy => go_through(simd, &blocks.copies, at, way, keys, counter),
        }
    }
}

impl Flights {
    fn new() -> Flights {
        let mut f = Flights {
            slot: [0; FLIGHTS],
            next: [Child::ROOT; FLIGHTS],
            top: [0; FLIGHTS],
            near: [[0; 4]; FLIGHTS],
            lists: [[0; FLIGHTS]; LISTS],
            counts: [0; LISTS],
        };
        f.lists[DONE] = std::array::from_fn(|i| i as u8);
        f.counts[DONE] = FLIGHTS;
        f
    }

    #[inline(always)]
    fn put(&mut self, flight: usize, list: usize) {
        let list = list % LISTS;
        let count = self.counts[list];
        self.lists[list][count % FLIGHTS] = flight as u8;
        self.counts[list] = count + 1;
    }

    /// Takes all from a list.
    #[inline(always)]
    fn take(&mut self, list: usize) -> (List, usize) {
        (self.lists[list], std::mem::take(&mut self.counts[list]).min(FLIGHTS))
    }

    /// Sets off with the next rays in place of those that are done.
    fn start(&mut self, bundle: &Bundle, todo: &mut u64, share: usize) {
        while *todo != 0 && self.counts[DONE] > 0 {
            let slot = todo.trailing_zeros() as usize % RAYS;
            *todo &= *todo - 1;
            self.counts[DONE] -= 1;
            let i = usize::from(self.lists[DONE][self.counts[DONE] % FLIGHTS]) % FLIGHTS;
            self.slot[i] = slot as u8;
            let [x, y, z] = bundle.near(slot);
            self.near[i] = [x as u8, y as u8, z as u8, bundle.octant(slot) as u8];
            self.top[i] = (i * share + LANES) as u32;
            self.next[i] = Child::ROOT;
            self.put(i, NODES);
        }
    }
}

/// Visits the nodes that rays need next.
#[inline(never)]
fn visit_all<S: Simd, C: Counter>(
    simd: S,
    tree: &Tree,
    (_, f, bundle): (Question, &mut Flights, &mut Bundle),
    (stacks, ahead): (&mut Stacks, &Ahead),
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (list, count) = f.take(NODES);
            for flight in &list[..count] {
                counter.node();
                visit(simd, &tree.nodes, bundle, f, usize::from(*flight) % FLIGHTS, stacks);
            }
            // Apart, since a load of what has just been stored in two parts would wait for it.
            for flight in &list[..count] {
                go_on(simd, bundle, f, usize::from(*flight) % FLIGHTS, stacks, ahead);
            }
        },
    );
}

/// Holds a ray against the boxes of a node's children; those that it meets go onto its stack, the
/// farthest lowest.
#[inline(always)]
fn visit<S: Simd>(
    simd: S,
    nodes: &[Node],
    bundle: &Bundle,
    f: &mut Flights,
    i: usize,
    stacks: &mut Stacks,
) {
    let node = &nodes[f.next[i].0 as usize];
    let slot = usize::from(f.slot[i]) % RAYS;
    let (o, inv) = bundle.slabs(simd, slot);
    let near = f.near[i];
    let mut entry = F::splat(simd, 0.0);
    let mut exit = F::splat(simd, f32::INFINITY);
    for k in 0..3 {
        let row = usize::from(near[k]);
        let first = (node.faces(simd, row) - o[k]) * inv[k];
        let last = (node.faces(simd, row ^ Node::HI) - o[k]) * inv[k];
        entry = greater(simd, first, entry);
        exit = lesser(simd, last, exit);
    }
    // An equal entry may still hold a tie with a lower id.
    let exit = lesser(simd, exit * LEAVE, F::splat(simd, bundle.t[slot]));
    let order = node.order(usize::from(near[3]));
    let met: Packed = order::pack(simd, entry, entry.simd_le(exit), node.children(), order);
    let top = f.top[i];
    stacks.put(top, &met.entries, &met.children);
    f.top[i] = top + met.count;
}

/// Tests the blocks of one kind that rays need next.
#[inline(never)]
fn test_all<S: Simd, B: Block, C: Counter>(
    simd: S,
    shelf: &Shelf<B>,
    kind: ShapeKind,
    (question, f, bundle): (Question, &mut Flights, &mut Bundle),
    (stacks, ahead): (&mut Stacks, &Ahead),
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (list, count) = f.take(Child::block(kind, 0).kind());
            let mut found = Found { t: [[0.0; LANES]; FLIGHTS], code: [[0; LANES]; FLIGHTS] };
            let (mut near, mut hitting) = ([0u8; FLIGHTS], 0);
            for (j, flight) in list[..count].iter().enumerate() {
                let i = usize::from(*flight) % FLIGHTS;
                let (slot, block) = (usize::from(f.slot[i]) % RAYS, f.next[i].index());
                counter.kernel(LANES, || count::prims_of(shelf.blocks[block].codes()));
                let c = shelf.blocks[block].test(simd, &bundle.splat(simd, slot));
                let is_near = c.hit & c.t.simd_le(F::splat(simd, bundle.t[slot]));
                // No comparison takes a NaN.
                let t = is_near.select(c.t, F::splat(simd, f32::NAN));
                t.store_slice(&mut found.t[j % FLIGHTS]);
                c.code.store_slice(&mut found.code[j % FLIGHTS]);
                near[hitting % FLIGHTS] = j as u8;
                hitting += usize::from(is_near.any_true());
            }
            let near = &near[..hitting.min(FLIGHTS)];
            // Only those few need their boxes.
            for j in near {
                let i = usize::from(list[usize::from(*j) % FLIGHTS]) % FLIGHTS;
                prefetch(&shelf.frames, f.next[i].index());
            }
            let mut done = 0u32;
            for j in near {
                let j = usize::from(*j) % FLIGHTS;
                let i = usize::from(list[j]) % FLIGHTS;
                let slot = usize::from(f.slot[i]) % RAYS;
                let before = (bundle.t[slot], bundle.code[slot]);
                let ray = bundle.splat(simd, slot);
                let own = shelf.frames[f.next[i].index()].boxes(simd);
                let after = better(simd, &ray, &own, (&found.t[j], &found.code[j]), before);
                if after != before {
                    (bundle.t[slot], bundle.code[slot]) = after;
                    done |= u32::from(question == Question::Any) << i;
                }
            }
            for flight in &list[..count] {
                let i = usize::from(*flight) % FLIGHTS;
                if done >> i & 1 == 1 {
                    f.put(i, DONE);
                } else {
                    go_on(simd, bundle, f, i, stacks, ahead);
                }
            }
        },
    );
}

/// Follows rays through the copies of meshes that they need next, one after the other.
#[inline(never)]
fn go_through<S: Simd, C: Counter>(
    simd: S,
    copies: &[CopyBlock],
    (question, f, bundle): (Question, &mut Flights, &mut Bundle),
    (stacks, ahead): (&mut Stacks, &Ahead),
    keys: &mut [Key],
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (list, count) = f.take(Child::block(ShapeKind::Copy, 0).kind());
            for flight in &list[..count] {
                let i = usize::from(*flight) % FLIGHTS;
                let slot = usize::from(f.slot[i]) % RAYS;
                let before = (bundle.t[slot], bundle.code[slot]);
                let (copy, ray) = (&copies[f.next[i].index()], bundle.splat(simd, slot));
                let ray = (&ray, bundle.near(slot));
                let after = through::cast(simd, copy, ray, question, before, keys, counter);
                (bundle.t[slot], bundle.code[slot]) = after;
                if after != before && question == Question::Any {
                    f.put(i, DONE);
                } else {
                    go_on(simd, bundle, f, i, stacks, ahead);
                }
            }
        },
    );
}

/// What kernels have found, by flight.
struct Found {
    t: [[f32; LANES]; FLIGHTS],
    code: [[u32; LANES]; FLIGHTS],
}

/// The better of `best` and what a kernel has found where the ray passes its own box.
#[inline(always)]
fn better<S: Simd>(
    simd: S,
    ray: &RayLanes<S>,
    own: &BoxLanes<F<S>>,
    (t, code): (&[f32; LANES], &[u32; LANES]),
    mut best: (f32, u32),
) -> (f32, u32) {
    let (entry, passes) = enter(simd, ray, own);
    let t = F::from_slice(simd, t);
    let t = entry.simd_gt(t).select(entry, t);
    let mut bits = (passes & t.simd_le(F::splat(simd, best.0))).to_bitmask();
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize % LANES;
        bits &= bits - 1;
        let found = (t.as_slice()[lane], code[lane]);
        if found.0 < best.0 || (found.0 == best.0 && found.1 < best.1) {
            best = found;
        }
    }
    best
}

/// Takes from a ray's stack what it visits next: the topmost that it enters before its end.
#[inline(always)]
fn go_on<S: Simd>(
    simd: S,
    bundle: &Bundle,
    f: &mut Flights,
    i: usize,
    stacks: &Stacks,
    ahead: &Ahead,
) {
    let end = F::splat(simd, bundle.t[usize::from(f.slot[i]) % RAYS]);
    let mut top = f.top[i];
    let met = loop {
        top = top.wrapping_sub(LANES as u32);
        let met = stacks.entries(simd, top).simd_le(end).to_bitmask() as u32;
        if met != 0 {
            break met;
        }
    };
    top += met.ilog2();
    let next = stacks.child(top);
    (f.top[i], f.next[i]) = (top, next);
    f.put(i, ahead.ask_for(next));
}
