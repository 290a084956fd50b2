//! A bundle of rays through the list and the tree: the boxes of a node against the bundle's frustum,
//! eight at once; those of a leaf against the frusta of its groups, two groups at once; and then each
//! primitive against the groups that may hit it, sixteen rays at once.

use crate::blocks::{Block, Blocks, Frame, Shelf};
use crate::bundle::{Bundle, GROUPS, RAYS};
use crate::copies::{CopyBlock, PlacedTriangles};
use crate::count::{self, Counter};
use crate::lanes::{Codes, F, LANES, RayLanes, W, WIDE, splat3};
use crate::order;
use crate::prefetch::prefetch;
use crate::rays::Question;
use crate::slab::{BoxLanes, enter};
use crate::todo::Todo;
use crate::tree::{Child, Node, Tree};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// Tests the bundle against all of a list.
#[inline(always)]
pub fn cast_at_list<S: Simd, C: Counter>(
    simd: S,
    list: &Blocks,
    bundle: &mut Bundle,
    question: Question,
    mut todo: Todo<'_>,
    counter: &mut C,
) {
    for block in 0..list.spheres.blocks.len() {
        test_apart(simd, &list.spheres, block, bundle, question, counter);
    }
    for block in 0..list.planes.blocks.len() {
        test_apart(simd, &list.planes, block, bundle, question, counter);
    }
    for block in 0..list.quads.blocks.len() {
        test_apart(simd, &list.quads, block, bundle, question, counter);
    }
    for block in 0..list.triangles.blocks.len() {
        test_apart(simd, &list.triangles, block, bundle, question, counter);
    }
    for block in 0..list.solids.blocks.len() {
        test_apart(simd, &list.solids, block, bundle, question, counter);
    }
    for copy in &list.copies {
        walk_copy(simd, copy, bundle, question, todo.above(0), counter);
    }
}

/// Follows the bundle through the tree.
#[inline(never)]
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    tree: (&Tree, &Blocks),
    bundle: &mut Bundle,
    question: Question,
    todo: Todo<'_>,
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || walk(simd, tree, bundle, question, todo, counter),
    );
}

/// What a bundle can be followed through.
trait Space<S: Simd>: Copy {
    /// A node, and the boxes of its children with the axes in such an order.
    fn node<'a>(self, simd: S, index: usize, turn: [usize; 3]) -> (&'a Node, BoxLanes<F<S>>)
    where
        Self: 'a;

    /// Asks for what a child is.
    fn ask_for(self, child: Child);

    /// Tests the bundle against a leaf: its kind, its block, and the node that it is a child of.
    /// `todo` is what is left of the room.
    fn test<C: Counter>(
        self,
        simd: S,
        leaf: (ShapeKind, usize, usize),
        bundle: &mut Bundle,
        question: Question,
        todo: Todo<'_>,
        counter: &mut C,
    );
}

/// The scene's tree.
impl<S: Simd> Space<S> for (&Tree, &Blocks) {
    #[inline(always)]
    fn node<'a>(self, simd: S, index: usize, turn: [usize; 3]) -> (&'a Node, BoxLanes<F<S>>)
    where
        Self: 'a,
    {
        let node = &self.0.nodes[index];
        let rows = |first: usize| {
            [
                node.faces(simd, first + turn[0]),
                node.faces(simd, first + turn[1]),
                node.faces(simd, first + turn[2]),
            ]
        };
        (node, BoxLanes { lo: rows(0), hi: rows(Node::HI) })
    }

    #[inline(always)]
    fn ask_for(self, child: Child) {
        let (tree, blocks) = self;
        match child.target() {
            Ok(index) => prefetch(&tree.nodes, index),
            Err((ShapeKind::Sphere, block)) => ask_for(&blocks.spheres, block),
            Err((ShapeKind::Quad, block)) => ask_for(&blocks.quads, block),
            Err((ShapeKind::Solid, block)) => ask_for(&blocks.solids, block),
            Err((ShapeKind::Copy, block)) => prefetch(&blocks.copies, block),
            Err((_, block)) => ask_for(&blocks.triangles, block),
        }
    }

    #[inline(always)]
    fn test<C: Counter>(
        self,
        simd: S,
        (kind, block, parent): (ShapeKind, usize, usize),
        bundle: &mut Bundle,
        question: Question,
        todo: Todo<'_>,
        counter: &mut C,
    ) {
        let blocks = self.1;
        let above = (&self.0.nodes[parent], Child::block(kind, block));
        match kind {
            ShapeKind::Sphere => {
                test_leaf(simd, (&blocks.spheres, block, above), bundle, question, counter)
            }
            // Planes are never in a tree.
            ShapeKind::Plane => {}
            ShapeKind::Quad => {
                test_leaf(simd, (&blocks.quads, block, above), bundle, question, counter)
            }
            ShapeKind::Triangle => {
                test_leaf(simd, (&blocks.triangles, block, above), bundle, question, counter)
            }
            ShapeKind::Solid => {
                test_leaf(simd, (&blocks.solids, block, above), bundle, question, counter)
            }
            ShapeKind::Copy => {
                walk_copy(simd, &blocks.copies[block], bundle, question, todo, counter)
            }
        }
    }
}

/// The tree of a copy's mesh.
impl<S: Simd> Space<S> for &CopyBlock {
    #[inline(always)]
    fn node<'a>(self, simd: S, index: usize, turn: [usize; 3]) -> (&'a Node, BoxLanes<F<S>>)
    where
        Self: 'a,
    {
        let node = &self.mesh.tree.nodes[index];
        (node, turned(self.children(simd, node), turn))
    }

    #[inline(always)]
    fn ask_for(self, child: Child) {
        match child.target() {
            Ok(index) => prefetch(&self.mesh.tree.nodes, index),
            Err((_, block)) => ask_for(&self.mesh.blocks.triangles, block),
        }
    }

    #[inline(always)]
    fn test<C: Counter>(
        self,
        simd: S,
        (_, block, _): (ShapeKind, usize, usize),
        bundle: &mut Bundle,
        question: Question,
        _: Todo<'_>,
        counter: &mut C,
    ) {
        let frame = &self.mesh.blocks.triangles.frames[block];
        let around = turned(self.around(simd, frame), bundle.turn);
        let mut met = bundle.meet_by_group(simd, &around);
        if met == 0 {
            return;
        }
        let mut placed = PlacedTriangles::default();
        self.place_leaf(block, &mut placed);
        while met != 0 {
            let (group, lane) = first_of(&mut met);
            let b = placed.bounds(lane);
            let own = BoxLanes { lo: splat3(simd, b.lo), hi: splat3(simd, b.hi) };
            test_lane(simd, (placed.block(), lane), &own, (bundle, group), question, counter);
        }
    }
}

/// Follows the bundle through a copy. (Not inlined: it is rare, and would make the common walk
/// long.)
#[inline(never)]
fn walk_copy<S: Simd, C: Counter>(
    simd: S,
    copy: &CopyBlock,
    bundle: &mut Bundle,
    question: Question,
    todo: Todo<'_>,
    counter: &mut C,
) {
    if copy.mesh.tree.nodes.is_empty() || copy.bounds().is_empty() {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || walk(simd, copy, bundle, question, todo, counter),
    );
}

#[inline(always)]
fn walk<S: Simd, P: Space<S>, C: Counter>(
    simd: S,
    space: P,
    bundle: &mut Bundle,
    question: Question,
    mut todo: Todo<'_>,
    counter: &mut C,
) {
    let octant = bundle.octant(0);
    let mut top = 0;
    let mut index = 0;
    loop {
        counter.node();
        let (node, boxes) = space.node(simd, index, bundle.turn);
        let (entry, meets) = bundle.meet(simd, &boxes);
        let met = order::pack(simd, entry, meets, node.children(), node.order(octant));
        todo.put(top, index, &met);
        for i in top..top + met.count as usize {
            space.ask_for(todo.child(i));
        }
        top += met.count as usize;
        index = loop {
            if top == 0 {
                return;
            }
            top -= 1;
            if todo.entry(top) > bundle.end() {
                continue;
            }
            match todo.child(top).target() {
                Ok(node) => break node,
                Err(leaf) => {
                    let leaf = (leaf.0, leaf.1, todo.parent(top));
                    space.test(simd, leaf, bundle, question, todo.above(top), counter);
                }
            }
        };
    }
}

#[inline(always)]
fn ask_for<B: Block>(shelf: &Shelf<B>, block: usize) {
    prefetch(&shelf.frames, block);
    prefetch(&shelf.blocks, block);
}

/// Boxes with the axes in another order.
#[inline(always)]
fn turned<S: Simd>(b: BoxLanes<F<S>>, t: [usize; 3]) -> BoxLanes<F<S>> {
    let turn = |v: [F<S>; 3]| [v[t[0]], v[t[1]], v[t[2]]];
    BoxLanes { lo: turn(b.lo), hi: turn(b.hi) }
}

/// Takes the first group and primitive from what [`Bundle::meet_by_group`] gives.
#[inline(always)]
fn first_of(met: &mut u32) -> (usize, usize) {
    let first = met.trailing_zeros() as usize;
    *met &= *met - 1;
    (first / LANES % GROUPS, first % LANES)
}

/// Tests the bundle against a block. (Not inlined: a copy for each caller would double the build.)
#[inline(never)]
fn test_apart<S: Simd, B: Block, C: Counter>(
    simd: S,
    shelf: &Shelf<B>,
    block: usize,
    bundle: &mut Bundle,
    question: Question,
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (frame, block) = (&shelf.frames[block], &shelf.blocks[block]);
            let met = bundle.meet_by_group(simd, &frame.turned(simd, bundle.turn));
            test_groups(simd, (frame, block), (bundle, met), question, counter);
        },
    );
}

/// Tests the bundle against a leaf, the child of a node. Where more primitives would have to be held
/// against groups than there are rays that meet the box at all, each of these goes alone, against
/// all primitives at once: so a bundle may be wide and still waste little.
#[inline(never)]
fn test_leaf<S: Simd, B: Block, C: Counter>(
    simd: S,
    (shelf, index, (parent, child)): (&Shelf<B>, usize, (&Node, Child)),
    bundle: &mut Bundle,
    question: Question,
    counter: &mut C,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (frame, block) = (&shelf.frames[index], &shelf.blocks[index]);
            let met = bundle.meet_by_group(simd, &frame.turned(simd, bundle.turn));
            if met.count_ones() > FEW {
                let rays = bundle.meet_one(simd, met, &parent.bounds_of(child));
                if rays.count_ones() < met.count_ones() {
                    test_rays(simd, (shelf, index), (bundle, rays), question, counter);
                    return;
                }
            }
            test_groups(simd, (frame, block), (bundle, met), question, counter);
        },
    );
}

/// Tests those groups and primitives of a block that [`Bundle::meet_by_group`] gives.
#[inline(always)]
fn test_groups<S: Simd, B: Block, C: Counter>(
    simd: S,
    (frame, block): (&Frame, &B),
    (bundle, mut met): (&mut Bundle, u32),
    question: Question,
    counter: &mut C,
) {
    while met != 0 {
        let (group, lane) = first_of(&mut met);
        let own = frame.box_of(simd, lane);
        test_lane(simd, (block, lane), &own, (bundle, group), question, counter);
    }
}

/// So many tests of groups are sooner made than rays are looked for.
const FEW: u32 = 3;

/// Tests some of the bundle's rays against a block, one after the other.
#[inline(always)]
fn test_rays<S: Simd, B: Block, C: Counter>(
    simd: S,
    (shelf, index): (&Shelf<B>, usize),
    (bundle, rays): (&mut Bundle, u64),
    question: Question,
    counter: &mut C,
) {
    let mut changed = 0u64;
    let mut bits = rays;
    while bits != 0 {
        let slot = bits.trailing_zeros() as usize % RAYS;
        bits &= bits - 1;
        counter.kernel(LANES, || count::prims_of(shelf.blocks[index].codes()));
        let ray = bundle.splat(simd, slot);
        let before = (bundle.t[slot], bundle.code[slot]);
        let after = test_ray(simd, shelf, index, &ray, before);
        if after != before {
            bundle.t[slot] = match question {
                Question::Closest => after.0,
                // One hit is enough.
                Question::Any => -1.0,
            };
            bundle.code[slot] = after.1;
            changed |= 1 << slot;
        }
    }
    for group in 0..GROUPS {
        let first = group * WIDE;
        if changed >> first & ((1 << WIDE) - 1) != 0 {
            let t = W::from_slice(simd, &bundle.t[first..first + WIDE]);
            bundle.shorten(group, t);
        }
    }
}

/// The better of `best` and the closest hit of one ray in a block.
#[inline(always)]
fn test_ray<S: Simd, B: Block>(
    simd: S,
    shelf: &Shelf<B>,
    block: usize,
    ray: &RayLanes<S>,
    mut best: (f32, u32),
) -> (f32, u32) {
    let end = F::splat(simd, best.0);
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

/// Tests a group against one lane of a block, which has this own box, and notes where its rays hit
/// nearer than before.
#[inline(always)]
fn test_lane<S: Simd, B: Block, C: Counter>(
    simd: S,
    (block, lane): (&B, usize),
    own: &BoxLanes<W<S>>,
    (bundle, group): (&mut Bundle, usize),
    question: Question,
    counter: &mut C,
) {
    counter.kernel(WIDE, || count::rays_of(bundle, group));
    let ray = bundle.lanes(simd, group);
    let c = block.test_one(simd, &ray, lane);
    let first = group % GROUPS * WIDE;
    let best = W::from_slice(simd, &bundle.t[first..first + WIDE]);
    if (c.hit & c.t.simd_le(best)).any_true() {
        let (entry, passes) = enter(simd, &ray, own);
        let t = entry.simd_gt(c.t).select(entry, c.t);
        let code = Codes::<S>::from_slice(simd, &bundle.code[first..first + WIDE]);
        let wins = t.simd_lt(best) | (t.simd_eq(best) & c.code.simd_lt(code));
        let take = c.hit & passes & wins;
        let t = match question {
            Question::Closest => t,
            // One hit is enough.
            Question::Any => W::splat(simd, -1.0),
        };
        let best = take.select(t, best);
        best.store_slice(&mut bundle.t[first..first + WIDE]);
        take.select(c.code, code).store_slice(&mut bundle.code[first..first + WIDE]);
        bundle.shorten(group, best);
    }
}
