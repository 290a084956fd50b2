//! Where in the tree each ray of a bundle sets out alone.
//!
//! Rays that start near each other but run apart have the upper levels of the tree in common still,
//! and so have any rays its very first. A node that many of a bundle visit is held against sixteen
//! of them at once, child by child; below it each goes alone, from its own entry points. (Benthin,
//! Wald, Woop, Ernst and Mark, "Combining Single and Packet-Ray Tracing for Arbitrary Ray
//! Distributions on the Intel MIC Architecture", IEEE TVCG 2012, change over so from packets to
//! single rays. The name is from Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm",
//! SIGGRAPH 2005, who have one for all rays of a frustum.)

use crate::bundle::{Bundle, GROUPS, RAYS};
use crate::count::Counter;
use crate::lanes::{LANES, W, WIDE, splat3};
use crate::slab::{BoxLanes, enter_before};
use crate::tree::{Child, Node, Tree};
use fearless_simd::prelude::*;

/// A node that fewer rays of a bundle visit is left to each of them.
const MANY: u32 = RAYS as u32 / 2;

/// The most entry points of a bundle: a bit each in a word.
pub const POINTS: usize = u64::BITS as usize;

/// The entry points of a bundle.
pub struct EntryPoints {
    /// What each is.
    child: [Child; POINTS],
    /// Which rays meet its box.
    rays: [u64; POINTS],
    /// Where they enter it.
    entry: [[f32; RAYS]; POINTS],
    /// How far each is from the rays, more or less.
    far: [f32; POINTS],
    count: usize,
    /// Of each ray those that it meets, as bits, by their places in `order`.
    of: [u64; RAYS],
    /// The points, the farthest first.
    order: [u8; POINTS],
}

impl Default for EntryPoints {
    fn default() -> Self {
        EntryPoints {
            child: [Child::NONE; POINTS],
            rays: [0; POINTS],
            entry: [[0.0; RAYS]; POINTS],
            far: [0.0; POINTS],
            count: 0,
            of: [0; RAYS],
            order: [0; POINTS],
        }
    }
}

impl EntryPoints {
    /// Finds those of some rays of a bundle; none if each had better begin at the root.
    #[inline(never)]
    pub fn find<S: Simd, C: Counter>(
        &mut self,
        simd: S,
        tree: &Tree,
        (bundle, rays): (&Bundle, u64),
        counter: &mut C,
    ) -> Option<&EntryPoints> {
        if rays.count_ones() < MANY {
            return None;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                (self.child[0], self.rays[0], self.far[0]) = (Child::ROOT, rays, 0.0);
                self.count = 1;
                let mut at = 0;
                while at < self.count {
                    let (child, rays) = (self.child[at], self.rays[at]);
                    let opens = child.kind() < Child::KINDS / 2
                        && rays.count_ones() >= MANY
                        && self.count + LANES <= POINTS;
                    if opens {
                        counter.node();
                        self.open(simd, &tree.nodes[child.index()], bundle, at);
                    } else {
                        at += 1;
                    }
                }
                self.set_order();
            },
        );
        Some(self)
    }

    /// Puts the children of a node where it was, and at the end.
    #[inline(always)]
    fn open<S: Simd>(&mut self, simd: S, node: &Node, bundle: &Bundle, at: usize) {
        let rays = self.rays[at];
        let mut met = [[0u16; GROUPS]; LANES];
        let mut entries = [[0.0; RAYS]; LANES];
        for g in 0..GROUPS {
            if rays >> (g * WIDE) & 0xffff == 0 {
                continue;
            }
            let lanes = g * WIDE..(g + 1) * WIDE;
            let ray = bundle.lanes(simd, g);
            let end = W::from_slice(simd, &bundle.t[lanes.clone()]);
            for lane in 0..LANES {
                let b = node.bounds(lane);
                let own = BoxLanes { lo: splat3(simd, b.lo), hi: splat3(simd, b.hi) };
                let (entry, passes) = enter_before(simd, &ray, &own, end);
                met[lane][g] = passes.to_bitmask() as u16;
                entry.store_slice(&mut entries[lane][lanes.clone()]);
            }
        }
        self.rays[at] = 0;
        let mut to = at;
        for lane in 0..LANES {
            let met = met[lane];
            let met = u64::from(met[0])
                | u64::from(met[1]) << 16
                | u64::from(met[2]) << 32
                | u64::from(met[3]) << 48;
            let met = met & rays;
            if met == 0 {
                continue;
            }
            let b = node.bounds(lane);
            let first = met.trailing_zeros() as usize % RAYS;
            let mut far = 0.0;
            for k in 0..3 {
                far += (0.5 * (b.lo[k] + b.hi[k]) - bundle.o[k][first]).abs();
            }
            self.child[to] = node.child(lane);
            self.rays[to] = met;
            self.entry[to] = entries[lane];
            self.far[to] = far;
            to = if to == at { self.count } else { to + 1 };
        }
        self.count = self.count.max(to);
    }

    /// Brings them into an order and tells each ray its own.
    #[inline(always)]
    fn set_order(&mut self) {
        let mut keys = [0u64; POINTS];
        let mut n = 0;
        for i in 0..self.count {
            let key = u64::from(self.far[i].to_bits()) << 32 | i as u64;
            let mut at = n;
            while at > 0 && keys[at - 1] < key {
                keys[at] = keys[at - 1];
                at -= 1;
            }
            keys[at] = key;
            n += 1;
        }
        self.of = [0; RAYS];
        for (rank, key) in keys[..n].iter().enumerate() {
            let i = *key as usize % POINTS;
            self.order[rank] = i as u8;
            let mut rays = self.rays[i];
            while rays != 0 {
                self.of[rays.trailing_zeros() as usize % RAYS] |= 1 << rank;
                rays &= rays - 1;
            }
        }
    }

    /// Those of a ray, the farthest first: where it enters each, and what it is.
    #[inline(always)]
    pub fn of(&self, slot: usize) -> impl Iterator<Item = (f32, Child)> {
        let mut points = self.of[slot % RAYS];
        std::iter::from_fn(move || {
            if points == 0 {
                return None;
            }
            let i = usize::from(self.order[points.trailing_zeros() as usize % POINTS]) % POINTS;
            points &= points - 1;
            Some((self.entry[i][slot % RAYS], self.child[i]))
        })
    }
}
