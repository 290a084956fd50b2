//! What single rays have still to visit.

use crate::entry_points::POINTS;
use crate::lanes::{F, LANES, U};
use crate::tree::{Child, Tree};
use fearless_simd::prelude::*;

/// How many stacks there are.
pub const STACKS: usize = 32;

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
    pub share: usize,
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
    /// If the tree has more than 240 levels; one of binned branches has at most a hundred.
    pub fn fit(&mut self, tree: &Tree) {
        // The end of a stack, what all nodes on the way may leave there, and what is written at
        // once; below these, entry points.
        let share = LANES * (tree.depth + 3) + POINTS;
        if share == self.share {
            return;
        }
        assert!(share * STACKS <= ROOM, "a tree of {} levels", tree.depth);
        self.share = share;
        for bottom in (0..STACKS).map(|i| i * share) {
            // Nothing is entered as early as what lies at the bottom: it is always found.
            self.words[bottom..bottom + LANES].fill(f32::NEG_INFINITY.to_bits());
            self.words[CHILDREN + bottom..][..LANES].fill(Child::NONE.0);
        }
    }

    /// Where the eight from some place on are entered.
    #[inline(always)]
    pub fn entries<S: Simd>(&self, simd: S, at: u32) -> F<S> {
        let first = at as usize % ROOM;
        F::from_bits(U::from_slice(simd, &self.words[first..first + LANES]))
    }

    /// What is at a place.
    #[inline(always)]
    pub fn child(&self, at: u32) -> Child {
        Child(self.words[CHILDREN + at as usize % ROOM])
    }

    /// Writes one.
    #[inline(always)]
    pub fn push(&mut self, at: u32, entry: f32, child: Child) {
        let at = at as usize % ROOM;
        self.words[at] = entry.to_bits();
        self.words[CHILDREN + at] = child.0;
    }

    /// Writes eight.
    #[inline(always)]
    pub fn put(&mut self, at: u32, entries: &[u32; LANES], children: &[u32; LANES]) {
        let first = at as usize % ROOM;
        self.words[first..first + LANES].copy_from_slice(entries);
        self.words[CHILDREN + first..CHILDREN + first + LANES].copy_from_slice(children);
    }
}
