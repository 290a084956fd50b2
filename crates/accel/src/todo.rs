//! What bundles have still to visit.

use crate::lanes::LANES;
use crate::order::Packed;
use crate::tree::Child;

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
