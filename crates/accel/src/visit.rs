//! The visit of a node by one ray: which of its eight children the ray meets, nearest first.

use crate::blocks::Blocks;
use crate::lanes::{F, LANES, V3, greater, lesser};
use crate::order::Packed;
use crate::prefetch::prefetch;
use crate::slab::LEAVE;
use crate::tree::{Child, Node, Tree};
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

/// Puts a key onto the part of a stack from `bottom` to `top` that is in order, the farthest lowest;
/// gives the new top.
#[inline(always)]
pub fn insert(keys: &mut [Key], bottom: usize, top: usize, key: Key) -> usize {
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
pub fn entry_of(key: Key) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

/// What the box test needs of one ray, in all lanes.
#[derive(Clone, Copy)]
pub struct Slabs<S: Simd> {
    /// The origin.
    pub o: V3<S>,
    /// 1 / direction.
    pub inv: V3<S>,
    /// For each axis, which row of a node holds the faces that the ray meets first.
    pub near: [usize; 3],
}

/// Children that a ray has still to visit.
pub struct Stack<'a> {
    /// Where they are kept.
    pub keys: &'a mut [Key],
    /// How many there are.
    pub top: usize,
}

impl Stack<'_> {
    /// The topmost child that is entered before `end`; all above it are dropped.
    #[inline(always)]
    pub fn pop(&mut self, bottom: usize, end: f32) -> Option<Key> {
        while self.top > bottom {
            self.top -= 1;
            let next = self.keys[self.top];
            if entry_of(next) <= end {
                return Some(next);
            }
        }
        None
    }
}

/// Holds a ray that ends at `end` against the boxes of a node's children. Gives the nearest child
/// that it meets, if any; the others go onto the stack, the farthest lowest.
#[inline(always)]
pub fn visit<S: Simd>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    index: usize,
    ray: &Slabs<S>,
    end: F<S>,
    stack: &mut Stack<'_>,
) -> Option<Key> {
    let node = &tree.nodes[index];
    let mut entry = F::splat(simd, 0.0);
    let mut exit = F::splat(simd, f32::INFINITY);
    for k in 0..3 {
        let row = ray.near[k];
        let first = (node.faces(simd, row) - ray.o[k]) * ray.inv[k];
        let last = (node.faces(simd, row ^ Node::HI) - ray.o[k]) * ray.inv[k];
        entry = greater(simd, first, entry);
        exit = lesser(simd, last, exit);
    }
    // An equal entry may still hold a tie with a lower id.
    let exit = lesser(simd, exit * LEAVE, end);
    let mut bits = entry.simd_le(exit).to_bitmask() as u32;
    if bits == 0 {
        return None;
    }
    let entries = entry.as_slice();
    let lane = bits.trailing_zeros() as usize % LANES;
    bits &= bits - 1;
    let mut nearest = key(entries[lane], node.child(lane));
    let bottom = stack.top;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize % LANES;
        bits &= bits - 1;
        let other = key(entries[lane], node.child(lane));
        let more = nearest.max(other);
        nearest = nearest.min(other);
        stack.top = insert(stack.keys, bottom, stack.top, more);
        ask_for(tree, blocks, Child(more as u32));
    }
    Some(nearest)
}

/// Asks for what a child is.
#[inline(always)]
pub fn ask_for(tree: &Tree, blocks: &Blocks, child: Child) {
    match child.target() {
        Ok(index) => prefetch(&tree.nodes, index),
        Err((ShapeKind::Sphere, block)) => prefetch(&blocks.spheres.blocks, block),
        Err((ShapeKind::Quad, block)) => prefetch(&blocks.quads.blocks, block),
        Err((ShapeKind::Solid, block)) => prefetch(&blocks.solids.blocks, block),
        Err((ShapeKind::Copy, block)) => prefetch(&blocks.copies, block),
        Err((_, block)) => prefetch(&blocks.triangles.blocks, block),
    }
}

/// Room for what is still to be visited: where it is entered, by its bits, what it is, and the node
/// that it is a child of.
pub struct Todo<'a> {
    entries: &'a mut [u32],
    children: &'a mut [u32],
    parents: &'a mut [u32],
}

impl<'a> Todo<'a> {
    /// The columns that there are.
    pub const COLUMNS: usize = 3;

    /// Uses as much room as there is, a third for each.
    pub fn new(room: &'a mut [u32]) -> Todo<'a> {
        let third = room.len() / Self::COLUMNS;
        let (entries, rest) = room.split_at_mut(third);
        let (children, parents) = rest.split_at_mut(third);
        Todo { entries, children, parents }
    }

    /// The room from `bottom` on.
    #[inline(always)]
    pub fn above(&mut self, bottom: usize) -> Todo<'_> {
        Todo {
            entries: &mut self.entries[bottom..],
            children: &mut self.children[bottom..],
            parents: &mut self.parents[bottom..],
        }
    }

    /// Writes eight children of a node; what counts of them is packed.
    #[inline(always)]
    pub fn put(&mut self, at: usize, parent: usize, packed: &Packed) {
        self.parents[at..at + LANES].fill(parent as u32);
        self.entries[at..at + LANES].copy_from_slice(&packed.entries);
        self.children[at..at + LANES].copy_from_slice(&packed.children);
    }

    /// Where a child is entered.
    #[inline(always)]
    pub fn entry(&self, at: usize) -> f32 {
        f32::from_bits(self.entries[at])
    }

    /// A child.
    #[inline(always)]
    pub fn child(&self, at: usize) -> Child {
        Child(self.children[at])
    }

    /// The node that it is a child of.
    #[inline(always)]
    pub fn parent(&self, at: usize) -> usize {
        self.parents[at] as usize
    }
}
