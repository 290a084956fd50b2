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
use crate::entry_points::EntryPoints;
use crate::lanes::{F, LANES, RayLanes, TURN, U, greater, lesser};
use crate::order;
use crate::prefetch::{Ahead, prefetch};
use crate::rays::{HitCode, Question};
use crate::slab::{BoxLanes, LEAVE, enter};
use crate::stacks::{STACKS, Stacks};
use crate::through::{self, Key};
use crate::tree::{Child, Node, Tree};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// How many rays are under way at once.
const FLIGHTS: usize = STACKS;

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

/// No row of a stream.
const NO_ROW: u32 = u32::MAX;

/// What rays are followed through and what is asked of them; the same for a whole stream.
pub struct Course<'a> {
    tree: &'a Tree,
    blocks: &'a Blocks,
    question: Question,
    ahead: Ahead,
}

impl<'a> Course<'a> {
    /// Through a tree whose leaves are such blocks.
    pub fn new(tree: &'a Tree, blocks: &'a Blocks, question: Question) -> Course<'a> {
        Course { tree, blocks, question, ahead: Ahead::of(tree, blocks) }
    }
}

/// Rays that are to set off.
pub struct Departure<'a> {
    /// Where they are.
    pub bundle: &'a Bundle,
    /// Which of it, a bit each.
    pub rays: u64,
    /// The row of the bundle's first ray.
    pub first: usize,
    /// Where they begin; at the root if not told.
    pub points: Option<&'a EntryPoints>,
}

/// Where what rays hit is written.
pub type Out<'a> = (&'a mut [f32], &'a mut [HitCode]);

/// The rays themselves, a column a number.
struct Flying {
    o: [[f32; FLIGHTS]; 3],
    d: [[f32; FLIGHTS]; 3],
    inv: [[f32; FLIGHTS]; 3],
    shear: [[f32; FLIGHTS]; 3],
    start: [f32; FLIGHTS],
    last: [u32; FLIGHTS],
    /// The longest axis.
    axis: [u8; FLIGHTS],
    /// The best t so far.
    t: [f32; FLIGHTS],
    /// What was hit there.
    code: [u32; FLIGHTS],
    /// Which row of the stream each is.
    row: [u32; FLIGHTS],
}

/// Rays under way. They stay so from one bundle to the next, until [`Flights::land`].
pub struct Flights {
    rays: Flying,
    stacks: Stacks,
    /// What each visits next.
    next: [Child; FLIGHTS],
    /// Where the top of its stack is.
    top: [u32; FLIGHTS],
    /// For each axis, where the row of a node begins that holds the faces which the ray meets
    /// first; and its octant.
    near: [[u8; 4]; FLIGHTS],
    /// Which rays need what next.
    lists: [List; LISTS],
    /// How many they are.
    counts: [usize; LISTS],
    /// What kernels have found.
    found: Found,
}

/// What kernels have found, by place in a list.
struct Found {
    t: [[f32; LANES]; FLIGHTS],
    code: [[u32; LANES]; FLIGHTS],
}

impl Default for Flights {
    fn default() -> Flights {
        let mut counts = [0; LISTS];
        counts[DONE] = FLIGHTS;
        let column = [0.0; FLIGHTS];
        Flights {
            rays: Flying {
                o: [column; 3],
                d: [column; 3],
                inv: [column; 3],
                shear: [column; 3],
                start: column,
                last: [0; FLIGHTS],
                axis: [0; FLIGHTS],
                t: column,
                code: [0; FLIGHTS],
                row: [NO_ROW; FLIGHTS],
            },
            stacks: Stacks::default(),
            next: [Child::NONE; FLIGHTS],
            top: [0; FLIGHTS],
            near: [[0; 4]; FLIGHTS],
            lists: [std::array::from_fn(|i| i as u8); LISTS],
            counts,
            found: Found { t: [[0.0; LANES]; FLIGHTS], code: [[0; LANES]; FLIGHTS] },
        }
    }
}

impl Flights {
    /// Makes room for the paths through a tree. No ray is under way.
    pub fn fit(&mut self, tree: &Tree) {
        self.stacks.fit(tree);
    }

    /// Sets off with rays of a bundle, and follows rays under way until all of these have found a
    /// place. `keys` is room for rays that go through copies of meshes.
    pub fn take_off<S: Simd, C: Counter>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        from: Departure<'_>,
        (t, code): Out<'_>,
        keys: &mut [Key],
        counter: &mut C,
    ) {
        let Departure { bundle, rays: mut todo, first, points } = from;
        while todo != 0 {
            let (mut started, mut count) = ([0; FLIGHTS], 0);
            while todo != 0 && self.counts[DONE] > 0 {
                let slot = todo.trailing_zeros() as usize % RAYS;
                todo &= todo - 1;
                self.counts[DONE] -= 1;
                let flight = self.lists[DONE][self.counts[DONE] % FLIGHTS];
                let i = usize::from(flight) % FLIGHTS;
                self.rays.write(i, (&mut *t, &mut *code));
                self.start(bundle, slot, i, first);
                match points {
                    Some(points) => {
                        self.enter_at(points, slot, i);
                        started[count % FLIGHTS] = flight;
                        count += 1;
                    }
                    None => {
                        self.next[i] = Child::ROOT;
                        self.put(i, NODES);
                    }
                }
            }
            // Apart, since a load of what has just been stored in parts would wait for it.
            for flight in &started[..count.min(FLIGHTS)] {
                self.go_on(simd, usize::from(*flight) % FLIGHTS, &course.ahead);
            }
            if todo != 0 {
                self.step(simd, course, keys, counter);
            }
        }
    }

    /// Follows all rays to their ends.
    pub fn land<S: Simd, C: Counter>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        out: Out<'_>,
        keys: &mut [Key],
        counter: &mut C,
    ) {
        while self.counts[DONE] < FLIGHTS {
            self.step(simd, course, keys, counter);
        }
        let (t, code) = out;
        for i in 0..FLIGHTS {
            self.rays.write(i, (&mut *t, &mut *code));
        }
    }

    /// Makes a ray of the bundle ready to set off.
    #[inline(always)]
    fn start(&mut self, bundle: &Bundle, slot: usize, i: usize, first: usize) {
        let r = &mut self.rays;
        for k in 0..3 {
            r.o[k][i] = bundle.o[k][slot];
            r.d[k][i] = bundle.d[k][slot];
            r.inv[k][i] = bundle.inv[k][slot];
            r.shear[k][i] = bundle.shear[k][slot];
        }
        r.start[i] = bundle.start[slot];
        r.last[i] = bundle.last[slot];
        r.axis[i] = (bundle.class[slot] >> 1) as u8;
        r.t[i] = bundle.t[slot];
        r.code[i] = bundle.code[slot];
        r.row[i] = (first + slot) as u32;
        self.near[i] = Node::near_of(bundle.octant(slot));
        self.top[i] = (i * self.stacks.share + LANES) as u32;
    }

    /// Puts a ray's entry points onto its stack.
    #[inline(always)]
    fn enter_at(&mut self, points: &EntryPoints, slot: usize, i: usize) {
        for (entry, child) in points.of(slot) {
            self.stacks.push(self.top[i], entry, child);
            self.top[i] += 1;
        }
    }

    /// Works off the list of most rays, more or less.
    #[inline(always)]
    fn step<S: Simd, C: Counter>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        keys: &mut [Key],
        counter: &mut C,
    ) {
        let (mut kind, mut leaves) = (ShapeKind::Sphere, 0);
        for each in ShapeKind::ALL {
            let count = self.counts[Child::block(each, 0).kind()];
            if count > leaves {
                (kind, leaves) = (each, count);
            }
        }
        let nodes = self.counts[NODES];
        if nodes > FEW || (leaves <= FEW && nodes >= leaves) {
            visit_all(simd, course, self, counter);
            return;
        }
        let blocks = course.blocks;
        match kind {
            ShapeKind::Sphere => test_all(simd, &blocks.spheres, kind, (course, self), counter),
            // Planes are never in a tree.
            ShapeKind::Plane => {}
            ShapeKind::Quad => test_all(simd, &blocks.quads, kind, (course, self), counter),
            ShapeKind::Triangle => test_all(simd, &blocks.triangles, kind, (course, self), counter),
            ShapeKind::Solid => test_all(simd, &blocks.solids, kind, (course, self), counter),
            ShapeKind::Copy => go_through(simd, &blocks.copies, (course, self), keys, counter),
        }
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

    /// Takes from a ray's stack what it visits next: the topmost that it enters before its end.
    #[inline(always)]
    fn go_on<S: Simd>(&mut self, simd: S, i: usize, ahead: &Ahead) {
        let end = F::splat(simd, self.rays.t[i]);
        let mut top = self.top[i];
        let met = loop {
            top = top.wrapping_sub(LANES as u32);
            let met = self.stacks.entries(simd, top).simd_le(end).to_bitmask() as u32;
            if met != 0 {
                break met;
            }
        };
        top += met.ilog2();
        let next = self.stacks.child(top);
        (self.top[i], self.next[i]) = (top, next);
        ahead.ask_for(next);
        self.put(i, next.kind());
    }
}

impl Flying {
    /// One ray in all lanes.
    #[inline(always)]
    fn splat<S: Simd>(&self, simd: S, i: usize) -> RayLanes<S> {
        let at = |c: &[f32; FLIGHTS]| F::splat(simd, c[i]);
        let turn = TURN[usize::from(self.axis[i]) % 3];
        RayLanes {
            o: [at(&self.o[0]), at(&self.o[1]), at(&self.o[2])],
            d: [at(&self.d[0]), at(&self.d[1]), at(&self.d[2])],
            start: at(&self.start),
            inv: [at(&self.inv[0]), at(&self.inv[1]), at(&self.inv[2])],
            last: U::splat(simd, self.last[i]),
            turn,
            shear: [at(&self.shear[0]), at(&self.shear[1]), at(&self.shear[2])],
            turned: [at(&self.o[turn[0]]), at(&self.o[turn[1]]), at(&self.o[turn[2]])],
        }
    }

    /// Writes what a ray has hit, if there is one.
    #[inline(always)]
    fn write(&mut self, i: usize, (t, code): Out<'_>) {
        let row = std::mem::replace(&mut self.row[i], NO_ROW) as usize;
        if let (Some(t), Some(code)) = (t.get_mut(row), code.get_mut(row)) {
            (*t, *code) = (self.t[i], HitCode(self.code[i]));
        }
    }
}

/// Visits the nodes that rays need next.
#[inline(never)]
fn visit_all<S: Simd, C: Counter>(simd: S, course: &Course<'_>, f: &mut Flights, counter: &mut C) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (list, count) = f.take(NODES);
            for flight in &list[..count] {
                counter.node();
                visit(simd, &course.tree.nodes, f, usize::from(*flight) % FLIGHTS);
            }
            // Apart, since a load of what has just been stored in two parts would wait for it.
            for flight in &list[..count] {
                f.go_on(simd, usize::from(*flight) % FLIGHTS, &course.ahead);
            }
        },
    );
}

/// Holds a ray against the boxes of a node's children; those that it meets go onto its stack, the
/// farthest lowest.
#[inline(always)]
fn visit<S: Simd>(simd: S, nodes: &[Node], f: &mut Flights, i: usize) {
    let node = &nodes[f.next[i].0 as usize];
    let (r, [near @ .., octant]) = (&f.rays, f.near[i]);
    let mut entry = F::splat(simd, 0.0);
    let mut exit = F::splat(simd, f32::INFINITY);
    for (k, near) in near.into_iter().enumerate() {
        let (row, opposite) = Node::near_and_far(near);
        let (o, inv) = (F::splat(simd, r.o[k][i]), F::splat(simd, r.inv[k][i]));
        entry = greater(simd, (node.faces_of(simd, row) - o) * inv, entry);
        exit = lesser(simd, (node.faces_of(simd, opposite) - o) * inv, exit);
    }
    // An equal entry may still hold a tie with a lower id.
    let exit = lesser(simd, exit * LEAVE, F::splat(simd, r.t[i]));
    let order = node.order(usize::from(octant));
    let met = order::pack(simd, entry, entry.simd_le(exit), node.children(), order);
    f.stacks.put(f.top[i], &met.entries, &met.children);
    f.top[i] += met.count;
}

/// Tests the blocks of one kind that rays need next.
#[inline(never)]
fn test_all<S: Simd, B: Block, C: Counter>(
    simd: S,
    shelf: &Shelf<B>,
    kind: ShapeKind,
    (course, f): (&Course<'_>, &mut Flights),
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (list, count) = f.take(Child::block(kind, 0).kind());
            let (mut near, mut hitting) = ([0u8; FLIGHTS], 0);
            for (j, flight) in list[..count].iter().enumerate() {
                let i = usize::from(*flight) % FLIGHTS;
                let block = &shelf.blocks[f.next[i].index()];
                counter.kernel(LANES, || count::prims_of(block.codes()));
                let c = block.test(simd, &f.rays.splat(simd, i));
                let is_near = c.hit & c.t.simd_le(F::splat(simd, f.rays.t[i]));
                // No comparison takes a NaN.
                let t = is_near.select(c.t, F::splat(simd, f32::NAN));
                t.store_slice(&mut f.found.t[j % FLIGHTS]);
                c.code.store_slice(&mut f.found.code[j % FLIGHTS]);
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
                let before = (f.rays.t[i], f.rays.code[i]);
                let ray = f.rays.splat(simd, i);
                let own = shelf.frames[f.next[i].index()].boxes(simd);
                let after = better(simd, &ray, &own, (&f.found.t[j], &f.found.code[j]), before);
                if after != before {
                    (f.rays.t[i], f.rays.code[i]) = after;
                    done |= u32::from(course.question == Question::Any) << i;
                }
            }
            for flight in &list[..count] {
                let i = usize::from(*flight) % FLIGHTS;
                if done >> i & 1 == 1 {
                    f.put(i, DONE);
                } else {
                    f.go_on(simd, i, &course.ahead);
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
    (course, f): (&Course<'_>, &mut Flights),
    keys: &mut [Key],
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let question = course.question;
            let (list, count) = f.take(Child::block(ShapeKind::Copy, 0).kind());
            for flight in &list[..count] {
                let i = usize::from(*flight) % FLIGHTS;
                let before = (f.rays.t[i], f.rays.code[i]);
                let (copy, ray) = (&copies[f.next[i].index()], f.rays.splat(simd, i));
                let ray = (&ray, Node::near_rows(usize::from(f.near[i][3])));
                let after = through::cast(simd, copy, ray, question, before, keys, counter);
                (f.rays.t[i], f.rays.code[i]) = after;
                if after != before && question == Question::Any {
                    f.put(i, DONE);
                } else {
                    f.go_on(simd, i, &course.ahead);
                }
            }
        },
    );
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
