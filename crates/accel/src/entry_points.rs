//! Where in the tree each ray of a bundle sets out alone.
//!
//! Rays that start near each other but run apart have the upper levels of the tree in common still.
//! A node that many of a bundle visit is held against sixteen of them at once, child by child; below
//! it each goes alone, from its own entry points. Rays that are strewn begin at the root. (Benthin,
//! Wald, Woop, Ernst and Mark, "Combining Single and Packet-Ray Tracing for Arbitrary Ray
//! Distributions on the Intel MIC Architecture", IEEE TVCG 2012, change over so from packets to
//! single rays. The name is from Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm",
//! SIGGRAPH 2005, who have one for all rays of a frustum.)

use crate::bundle::{Bundle, RAYS};
use crate::count::Counter;
use crate::lanes::{LANES, W, WIDE, splat3};
use crate::slab::{BoxLanes, enter_before};
use crate::tree::{Child, Node, Tree};
use fearless_simd::prelude::*;
use reflet_pack::Aabb;

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
        let mut entries = [[0.0; RAYS]; LANES];
        let met = meet(simd, node, (bundle, self.rays[at]), &mut entries);
        self.rays[at] = 0;
        let mut to = at;
        for (lane, (met, entry)) in met.into_iter().zip(&entries).enumerate() {
            if met != 0 {
                self.child[to] = node.child(lane);
                self.rays[to] = met;
                self.entry[to] = *entry;
                self.far[to] = far(&node.bounds(lane), bundle, met);
                to = if to == at { self.count } else { to + 1 };
            }
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

/// Which of some rays of a bundle meet each child of a node, and where they enter it.
#[inline(always)]
fn meet<S: Simd>(
    simd: S,
    node: &Node,
    (bundle, rays): (&Bundle, u64),
    entries: &mut [[f32; RAYS]; LANES],
) -> [u64; LANES] {
    let mut all = [0; LANES];
    for first in (0..RAYS).step_by(WIDE) {
        if rays >> first & u64::from(u16::MAX) == 0 {
            continue;
        }
        let group = first..first + WIDE;
        let (ray, end) =
            (bundle.lanes(simd, first / WIDE), W::from_slice(simd, &bundle.t[group.clone()]));
        for (lane, (met, to)) in all.iter_mut().zip(&mut *entries).enumerate() {
            let b = node.bounds(lane);
            let own = BoxLanes { lo: splat3(simd, b.lo), hi: splat3(simd, b.hi) };
            let (entry, passes) = enter_before(simd, &ray, &own, end);
            *met |= passes.to_bitmask() << first;
            entry.store_slice(&mut to[group.clone()]);
        }
    }
    for met in &mut all {
        *met &= rays;
    }
    all
}

/// How far a box is from rays that start near each other: from the first, axis by axis, to its middle.
#[inline(always)]
fn far(b: &Aabb, bundle: &Bundle, rays: u64) -> f32 {
    let first = rays.trailing_zeros() as usize % RAYS;
    let along = |k: usize| (0.5 * (b.lo[k] + b.hi[k]) - bundle.o[k][first]).abs();
    along(0) + along(1) + along(2)
}
