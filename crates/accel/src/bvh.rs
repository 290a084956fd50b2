//! One ray through the tree: eight boxes, then eight primitives at a time.

use crate::blocks::{Block, Blocks, Shelf};
use crate::bundle::Bundle;
use crate::copies::CopyBlock;
use crate::count::{self, Counter};
use crate::lanes::{F, LANES, RayLanes};
use crate::rays::Question;
use crate::slab::enter;
use crate::tree::{Child, Tree};
use crate::visit::{Key, Slabs, Stack, visit, visit_copy};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

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

/// A ray in all lanes; for each axis, which row of a node holds the faces that it meets first.
type Lone<'a, S> = (&'a RayLanes<S>, [usize; 3]);

/// What a ray can be followed through.
trait Space<S: Simd>: Copy {
    /// Visits a node ([`visit`]).
    fn visit(
        self,
        simd: S,
        index: usize,
        slabs: &Slabs<S>,
        end: F<S>,
        stack: &mut Stack<'_>,
    ) -> Option<Key>;

    /// The better of `found` and the closest hit in a leaf, or any. `keys` is what is left of the
    /// stack.
    #[allow(clippy::too_many_arguments)]
    fn test<C: Counter>(
        self,
        simd: S,
        leaf: (ShapeKind, usize),
        ray: Lone<'_, S>,
        question: Question,
        found: ((f32, u32), F<S>),
        keys: &mut [Key],
        counter: &mut C,
    ) -> (f32, u32);
}

/// The scene's tree.
impl<S: Simd> Space<S> for (&Tree, &Blocks) {
    #[inline(always)]
    fn visit(
        self,
        simd: S,
        index: usize,
        slabs: &Slabs<S>,
        end: F<S>,
        stack: &mut Stack<'_>,
    ) -> Option<Key> {
        visit(simd, self, index, slabs, end, stack)
    }

    #[inline(always)]
    fn test<C: Counter>(
        self,
        simd: S,
        leaf: (ShapeKind, usize),
        ray: Lone<'_, S>,
        question: Question,
        (found, end): ((f32, u32), F<S>),
        keys: &mut [Key],
        counter: &mut C,
    ) -> (f32, u32) {
        if let (ShapeKind::Copy, block) = leaf {
            return walk_copy(simd, &self.1.copies[block], ray, question, found, keys, counter);
        }
        counter.kernel(|| count::prims_of(self.1, leaf.0, leaf.1));
        test_any_kind(simd, self.1, leaf, ray.0, found, end)
    }
}

/// The tree of a copy's mesh.
impl<S: Simd> Space<S> for &CopyBlock {
    #[inline(always)]
    fn visit(
        self,
        simd: S,
        index: usize,
        slabs: &Slabs<S>,
        end: F<S>,
        stack: &mut Stack<'_>,
    ) -> Option<Key> {
        visit_copy(simd, self, index, slabs, end, stack)
    }

    #[inline(always)]
    fn test<C: Counter>(
        self,
        simd: S,
        (kind, block): (ShapeKind, usize),
        (ray, _): Lone<'_, S>,
        _: Question,
        (mut best, end): ((f32, u32), F<S>),
        _: &mut [Key],
        counter: &mut C,
    ) -> (f32, u32) {
        counter.kernel(|| count::prims_of(&self.mesh.blocks, kind, block));
        let placed = self.triangles(block);
        let c = placed.test(simd, ray);
        let mut bits = (c.hit & c.t.simd_le(end)).to_bitmask();
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            if let Some(t) = placed.enter(ray, lane, c.t.as_slice()[lane]) {
                best = better(best, (t, c.code.as_slice()[lane]));
            }
        }
        best
    }
}

/// Follows a ray through a copy. (Not inlined: it is rare, and would make the common walk long.)
#[inline(never)]
pub fn walk_copy<S: Simd, C: Counter>(
    simd: S,
    copy: &CopyBlock,
    ray: Lone<'_, S>,
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
        || walk(simd, copy, ray, question, found, keys, counter),
    )
}

/// The better of `found` and the closest hit in the tree, or any.
#[inline(always)]
fn walk<S: Simd, W: Space<S>, C: Counter>(
    simd: S,
    space: W,
    (ray, near): Lone<'_, S>,
    question: Question,
    mut found: (f32, u32),
    stack: &mut [Key],
    counter: &mut C,
) -> (f32, u32) {
    let slabs = Slabs { o: ray.o, inv: ray.inv, near };
    let mut stack = Stack { keys: stack, top: 0 };
    let mut end = F::splat(simd, found.0);
    let mut index = 0;
    'node: loop {
        counter.node();
        let mut next = match space.visit(simd, index, &slabs, end, &mut stack) {
            Some(nearest) => nearest,
            None => match stack.pop(0, found.0) {
                Some(next) => next,
                None => return found,
            },
        };
        loop {
            match Child(next as u32).target() {
                Ok(node) => {
                    index = node;
                    continue 'node;
                }
                Err(leaf) => {
                    let before = found;
                    let keys = &mut stack.keys[stack.top..];
                    found =
                        space.test(simd, leaf, (ray, near), question, (found, end), keys, counter);
                    if found != before {
                        if question == Question::Any {
                            return found;
                        }
                        end = F::splat(simd, found.0);
                    }
                }
            }
            next = match stack.pop(0, found.0) {
                Some(next) => next,
                None => return found,
            };
        }
    }
}

/// The better of `best` and the closest hit in a block of any kind.
#[inline(always)]
pub fn test_any_kind<S: Simd>(
    simd: S,
    blocks: &Blocks,
    (kind, block): (ShapeKind, usize),
    ray: &RayLanes<S>,
    best: (f32, u32),
    end: F<S>,
) -> (f32, u32) {
    match kind {
        ShapeKind::Sphere => test(simd, &blocks.spheres, block, ray, best, end),
        // Planes are never in a tree, and copies are walked through.
        ShapeKind::Plane | ShapeKind::Copy => best,
        ShapeKind::Quad => test(simd, &blocks.quads, block, ray, best, end),
        ShapeKind::Triangle => test(simd, &blocks.triangles, block, ray, best, end),
        ShapeKind::Solid => test(simd, &blocks.solids, block, ray, best, end),
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
            best = better(best, (t.as_slice()[lane], c.code.as_slice()[lane]));
        }
    }
    best
}

/// The nearer of two hits; of equal ones the one with the lower id.
#[inline(always)]
fn better(best: (f32, u32), found: (f32, u32)) -> (f32, u32) {
    if found.0 < best.0 || (found.0 == best.0 && found.1 < best.1) { found } else { best }
}
