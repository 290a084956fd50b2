//! A bundle of rays through the list and the tree: boxes against the bundle's frustum, eight at a
//! time; then each primitive that it may hit against the frusta of its groups; and the groups that
//! are left, eight rays in lanes, against the primitive.

use crate::blocks::{Block, Blocks, Shelf};
use crate::bundle::Bundle;
use crate::copies::{CopyBlock, PlacedTriangles};
use crate::count::{self, Counter};
use crate::kernels::Candidate;
use crate::lanes::{F, LANES, RayLanes, U, splat3};
use crate::prefetch::prefetch;
use crate::rays::Question;
use crate::slab::{BoxLanes, enter};
use crate::tree::{Child, Node, Tree};
use crate::visit::{Key, entry_of, insert, key};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// Tests the bundle against all of a list.
#[inline(always)]
pub fn cast_at_list<S: Simd, C: Counter>(
    simd: S,
    list: &Blocks,
    bundle: &mut Bundle,
    question: Question,
    stack: &mut [Key],
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
        walk_copy(simd, copy, bundle, question, stack, counter);
    }
}

/// Follows the bundle through the tree.
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
        || walk(simd, tree, bundle, question, stack, counter),
    );
}

/// What a bundle can be followed through.
trait Space<S: Simd>: Copy {
    /// A node, and the boxes of its children.
    fn node<'a>(self, simd: S, index: usize) -> (&'a Node, BoxLanes<S>)
    where
        Self: 'a;

    /// Asks for what a child is.
    fn ask_for(self, child: Child);

    /// Tests the bundle against a leaf. `keys` is what is left of the stack.
    fn test<C: Counter>(
        self,
        simd: S,
        leaf: (ShapeKind, usize),
        bundle: &mut Bundle,
        question: Question,
        keys: &mut [Key],
        counter: &mut C,
    );
}

/// The scene's tree.
impl<S: Simd> Space<S> for (&Tree, &Blocks) {
    #[inline(always)]
    fn node<'a>(self, simd: S, index: usize) -> (&'a Node, BoxLanes<S>)
    where
        Self: 'a,
    {
        let node = &self.0.nodes[index];
        let boxes = BoxLanes {
            lo: [node.faces(simd, 0), node.faces(simd, 1), node.faces(simd, 2)],
            hi: [node.faces(simd, 4), node.faces(simd, 5), node.faces(simd, 6)],
        };
        (node, boxes)
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
        (kind, block): (ShapeKind, usize),
        bundle: &mut Bundle,
        question: Question,
        keys: &mut [Key],
        counter: &mut C,
    ) {
        let blocks = self.1;
        match kind {
            ShapeKind::Sphere => {
                test_apart(simd, &blocks.spheres, block, bundle, question, counter)
            }
            // Planes are never in a tree.
            ShapeKind::Plane => {}
            ShapeKind::Quad => test_apart(simd, &blocks.quads, block, bundle, question, counter),
            ShapeKind::Triangle => {
                test_apart(simd, &blocks.triangles, block, bundle, question, counter)
            }
            ShapeKind::Solid => test_apart(simd, &blocks.solids, block, bundle, question, counter),
            ShapeKind::Copy => {
                walk_copy(simd, &blocks.copies[block], bundle, question, keys, counter)
            }
        }
    }
}

/// The tree of a copy's mesh.
impl<S: Simd> Space<S> for &CopyBlock {
    #[inline(always)]
    fn node<'a>(self, simd: S, index: usize) -> (&'a Node, BoxLanes<S>)
    where
        Self: 'a,
    {
        let node = &self.mesh.tree.nodes[index];
        (node, self.children(simd, node))
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
        (_, block): (ShapeKind, usize),
        bundle: &mut Bundle,
        question: Question,
        _: &mut [Key],
        counter: &mut C,
    ) {
        let frame = &self.mesh.blocks.triangles.frames[block];
        let (_, mut prims) = bundle.meet(simd, &self.around(simd, frame));
        if prims == 0 {
            return;
        }
        let mut placed = PlacedTriangles::default();
        self.place_leaf(block, &mut placed);
        while prims != 0 {
            let lane = prims.trailing_zeros() as usize % LANES;
            prims &= prims - 1;
            let b = placed.bounds(lane);
            let own = BoxLanes { lo: splat3(simd, b.lo), hi: splat3(simd, b.hi) };
            test_lane(simd, (placed.block(), lane), &own, bundle, question, counter);
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
    keys: &mut [Key],
    counter: &mut C,
) {
    if copy.mesh.tree.nodes.is_empty() || copy.bounds().is_empty() {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || walk(simd, copy, bundle, question, keys, counter),
    );
}

#[inline(always)]
fn walk<S: Simd, W: Space<S>, C: Counter>(
    simd: S,
    space: W,
    bundle: &mut Bundle,
    question: Question,
    stack: &mut [Key],
    counter: &mut C,
) {
    let mut top = 0;
    let mut index = 0;
    loop {
        counter.node();
        let (node, boxes) = space.node(simd, index);
        let (entry, mut bits) = bundle.meet(simd, &boxes);
        let entries = entry.as_slice();
        let bottom = top;
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            top = insert(stack, bottom, top, key(entries[lane], node.child(lane)));
            space.ask_for(node.child(lane));
        }
        index = loop {
            if top == 0 {
                return;
            }
            top -= 1;
            if entry_of(stack[top]) > bundle.end() {
                continue;
            }
            match Child(stack[top] as u32).target() {
                Ok(node) => break node,
                Err(leaf) => {
                    space.test(simd, leaf, bundle, question, &mut stack[top..], counter);
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
        || test(simd, shelf, block, bundle, question, counter),
    );
}

#[inline(always)]
fn test<S: Simd, B: Block, C: Counter>(
    simd: S,
    shelf: &Shelf<B>,
    block: usize,
    bundle: &mut Bundle,
    question: Question,
    counter: &mut C,
) {
    let (frame, block) = (&shelf.frames[block], &shelf.blocks[block]);
    let (_, mut prims) = bundle.meet(simd, &frame.boxes(simd));
    while prims != 0 {
        let lane = prims.trailing_zeros() as usize % LANES;
        prims &= prims - 1;
        let own = frame.box_of(simd, lane);
        test_lane(simd, (block, lane), &own, bundle, question, counter);
    }
}

/// Tests the bundle against one lane of a block, which has this own box.
#[inline(always)]
fn test_lane<S: Simd, B: Block, C: Counter>(
    simd: S,
    (block, lane): (&B, usize),
    own: &BoxLanes<S>,
    bundle: &mut Bundle,
    question: Question,
    counter: &mut C,
) {
    let mut groups = bundle.meeting(simd, own);
    while groups != 0 {
        let group = groups.trailing_zeros() as usize % LANES;
        groups &= groups - 1;
        counter.kernel(|| count::rays_of(bundle, group));
        let ray = bundle.lanes(simd, group);
        let c = block.test_one(simd, &ray, lane);
        take(simd, bundle, group, (&ray, &c, own), question);
    }
}

/// Notes where a group's rays hit a primitive of this box, where that is nearer than before.
#[inline(always)]
fn take<S: Simd>(
    simd: S,
    bundle: &mut Bundle,
    group: usize,
    (ray, c, own): (&RayLanes<S>, &Candidate<S>, &BoxLanes<S>),
    question: Question,
) {
    let at = group * LANES..(group + 1) * LANES;
    let best = F::from_slice(simd, &bundle.t[at.clone()]);
    if (c.hit & c.t.simd_le(best)).any_true() {
        let (entry, passes) = enter(simd, ray, own);
        let t = entry.simd_gt(c.t).select(entry, c.t);
        let code = U::from_slice(simd, &bundle.code[at.clone()]);
        let wins = t.simd_lt(best) | (t.simd_eq(best) & c.code.simd_lt(code));
        let take = c.hit & passes & wins;
        let t = match question {
            Question::Closest => t,
            // One hit is enough.
            Question::Any => F::splat(simd, -1.0),
        };
        let best = take.select(t, best);
        best.store_slice(&mut bundle.t[at.clone()]);
        take.select(c.code, code).store_slice(&mut bundle.code[at]);
        bundle.shorten(simd, group, best);
    }
}
