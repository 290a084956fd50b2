//! Streams of rays on their way to the structures: as bundles where rays run together, else one by
//! one. What is chosen never shows in a hit.

use crate::blocks::Blocks;
use crate::bundle::{Bundle, NO_CLASS, RAYS};
use crate::count::Counter;
use crate::entry_points::EntryPoints;
use crate::flights::{Course, Departure, Flights, Out};
use crate::lanes::LANES;
use crate::rays::{HitCode, Question, Rays};
use crate::regroup::{Regrouped, WINDOW};
use crate::through::Key;
use crate::tile;
use crate::todo::Todo;
use crate::tree::Tree;
use fearless_simd::prelude::*;
use std::ops::Range;

/// What rays are cast at.
#[derive(Clone, Copy)]
pub struct Structures<'a> {
    /// What every ray is tested against.
    pub list: &'a Blocks,
    /// What the tree's leaves hold.
    pub leaves: &'a Blocks,
    /// The tree; empty if all is in the list.
    pub tree: &'a Tree,
    /// How rays go through the tree.
    pub way: Way,
    /// What its leaves stand for.
    pub below: Below,
}

/// The trees of meshes below a tree whose leaves are copies.
#[derive(Clone, Copy, Debug, Default)]
pub struct Below {
    /// The levels of the deepest.
    pub depth: usize,
    /// The nodes of all, once for each copy.
    pub nodes: usize,
}

/// How rays go through a tree. Hits do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Way {
    /// As suits the rays and the tree.
    #[default]
    Auto,
    /// In bundles, culled by their frusta.
    Bundles,
    /// Each on its own, many under way at once.
    Singly,
}

/// Memory of one thread.
#[derive(Default)]
pub struct Memory {
    legs: Legs,
    regrouped: Regrouped,
}

/// What rays are on their way with.
#[derive(Default)]
struct Legs {
    taken: Box<Bundle>,
    some: Box<Bundle>,
    /// For single rays through copies of meshes.
    keys: Vec<Key>,
    /// For bundles.
    todo: Vec<u32>,
    flights: Option<Box<Flights>>,
    points: Option<Box<EntryPoints>>,
}

/// Casts all rays; `t` and `code` hold their ends and no code, and get their hits.
#[inline(always)]
pub fn cast<S: Simd, C: Counter>(
    simd: S,
    what: Structures<'_>,
    rays: &Rays,
    question: Question,
    (t, code): (&mut [f32], &mut [HitCode]),
    memory: &mut Memory,
    counter: &mut C,
) {
    let has_tree = !what.tree.nodes.is_empty();
    if what.list.is_empty() && !has_tree {
        return;
    }
    let limits = Limits::of(what, question);
    let Memory { legs, regrouped } = memory;
    legs.fit(what);
    let regroups = has_tree && question == Question::Any && what.way == Way::Auto;
    for first in (0..rays.len()).step_by(WINDOW) {
        let window = first..rays.len().min(first + WINDOW);
        if regroups
            && legs.run_apart(simd, limits, (rays, window.clone()))
            && regrouped.sort(simd, rays, window.clone(), limits.spread)
        {
            let Regrouped { rays: sorted, t, code: found, .. } = &mut *regrouped;
            let (window_of, out) = ((&*sorted, 0..sorted.len()), (&mut t[..], &mut found[..]));
            legs.cast(simd, (what, limits), window_of, question, out, counter);
            regrouped.put_back(&mut code[window]);
        } else {
            let out = (&mut *t, &mut *code);
            legs.cast(simd, (what, limits), (rays, window), question, out, counter);
        }
    }
}

impl Legs {
    /// Makes room for ways through a tree.
    fn fit(&mut self, what: Structures<'_>) {
        let Legs { keys, todo, .. } = self;
        let below = what.below.depth;
        keys.resize(keys.len().max(LANES * (below + 2)), 0);
        // Of each column, what all nodes on the way may leave, and what is written at once.
        let room = Todo::COLUMNS * LANES * (what.tree.depth + below + 3);
        todo.resize(todo.len().max(room), 0);
    }

    /// Whether most bundles of a window would have to be left for single rays; by a sample.
    #[inline(always)]
    fn run_apart<S: Simd>(
        &mut self,
        simd: S,
        limits: Limits,
        (rays, window): (&Rays, Range<usize>),
    ) -> bool {
        const SAMPLES: usize = 8;
        let bundles = window.len() / RAYS;
        let mut apart = 0;
        for i in 0..SAMPLES.min(bundles) {
            let first = window.start + i * bundles / SAMPLES.min(bundles) * RAYS;
            let bundle = &mut self.taken;
            apart += usize::from(if bundle.take(simd, rays, first).is_some() {
                bundle.bound(simd, Question::Any);
                !limits.hold(bundle)
            } else {
                bundle.is_scattered(limits.apart, limits.spread)
            });
        }
        2 * apart > SAMPLES
    }

    /// Casts the rays of a window.
    #[inline(never)]
    fn cast<S: Simd, C: Counter>(
        &mut self,
        simd: S,
        what: (Structures<'_>, Limits),
        window: (&Rays, Range<usize>),
        question: Question,
        out: Out<'_>,
        counter: &mut C,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.cast_window(simd, what, window, question, out, counter),
        );
    }

    #[inline(always)]
    fn cast_window<S: Simd, C: Counter>(
        &mut self,
        simd: S,
        (what, limits): (Structures<'_>, Limits),
        (rays, window): (&Rays, Range<usize>),
        question: Question,
        (t, code): Out<'_>,
        counter: &mut C,
    ) {
        let Legs { taken, some, keys, todo, flights, points } = self;
        let course = Course::new(what.tree, what.leaves, question);
        let mut flying = false;
        for first in window.step_by(RAYS) {
            // Those rays that go through the tree alone.
            let mut alone = 0;
            if taken.take(simd, rays, first).is_some() {
                taken.bound(simd, question);
                if !cast_bundle(simd, (what, limits), question, taken, todo, counter) {
                    alone = taken.castable(simd);
                }
            } else if what.list.is_empty()
                && (taken.is_strewn(limits.strewn)
                    || taken.is_scattered(limits.apart, limits.spread))
            {
                alone = taken.castable(simd);
            } else {
                let mut slots = [[0u8; RAYS]; NO_CLASS as usize + 1];
                let mut counts = [0; NO_CLASS as usize + 1];
                for (slot, class) in taken.classes().iter().enumerate() {
                    let class = *class as usize % slots.len();
                    slots[class][counts[class] % RAYS] = slot as u8;
                    counts[class] += 1;
                }
                for (slots, count) in slots.iter().zip(counts).take(NO_CLASS as usize) {
                    if count > 0 {
                        let slots = &slots[..count];
                        some.select(taken, slots);
                        some.bound(simd, question);
                        let through =
                            cast_bundle(simd, (what, limits), question, some, todo, counter);
                        for (i, slot) in slots.iter().enumerate() {
                            let slot = usize::from(*slot) % RAYS;
                            (taken.t[slot], taken.code[slot]) = (some.t[i], some.code[i]);
                            alone |= u64::from(!through && taken.is_castable(slot)) << slot;
                        }
                    }
                }
            }
            let rows = first..first + taken.len;
            taken.write(&mut t[rows.clone()], &mut code[rows]);
            if alone != 0 {
                let flights = flights.get_or_insert_default();
                if !std::mem::replace(&mut flying, true) {
                    flights.fit(what.tree);
                }
                let out = (&mut *t, &mut *code);
                let points = if taken.is_strewn(limits.strewn) {
                    None
                } else {
                    let points = points.get_or_insert_default();
                    points.find(simd, what.tree, (taken, alone), counter)
                };
                let from = Departure { bundle: taken, rays: alone, first, points };
                flights.take_off(simd, &course, from, out, keys, counter);
            }
        }
        if let (true, Some(flights)) = (flying, flights) {
            flights.land(simd, &course, (t, code), keys, counter);
        }
    }
}

/// How far apart the rays of a bundle may start, summed over the axes, and how far its slopes may
/// spread. Found by measuring; only time depends on it.
#[derive(Clone, Copy)]
struct Limits {
    apart: f32,
    spread: f32,
    /// From where on rays that start so far apart have nothing in common.
    strewn: f32,
}

impl Limits {
    fn of(what: Structures<'_>, question: Question) -> Limits {
        let tree = what.tree;
        match what.way {
            Way::Auto => {}
            Way::Bundles => {
                let all = f32::INFINITY;
                return Limits { apart: all, spread: all, strewn: all };
            }
            Way::Singly => {
                return Limits { apart: -1.0, spread: -1.0, strewn: f32::INFINITY };
            }
        }
        // The fewer nodes there are, the less a wide bundle visits in vain.
        let nodes = tree.nodes.len() + what.below.nodes;
        let ease = (4096.0 / nodes.max(1) as f32).sqrt();
        let spread = match question {
            Question::Closest => 0.5,
            // A ray alone stops at its first hit, a bundle only at the last ray's.
            Question::Any => 0.08,
        };
        Limits {
            apart: 0.02 * ease * tree.extent,
            spread: spread * ease,
            strewn: 0.05 * tree.extent,
        }
    }

    /// Whether a bundle is narrow enough to be followed as one.
    #[inline(always)]
    fn hold(&self, bundle: &Bundle) -> bool {
        let (slopes, origins) = bundle.spread();
        slopes < self.spread && origins < self.apart && bundle.len > LANES
    }
}

/// Casts a bundle of one class; `false` if its rays are yet to go through the tree, each alone.
#[inline(always)]
fn cast_bundle<S: Simd, C: Counter>(
    simd: S,
    (what, limits): (Structures<'_>, Limits),
    question: Question,
    bundle: &mut Bundle,
    room: &mut [u32],
    counter: &mut C,
) -> bool {
    tile::cast_at_list(simd, what.list, bundle, question, Todo::new(room), counter);
    if what.tree.nodes.is_empty() {
        return true;
    }
    let runs = limits.hold(bundle);
    if runs {
        let tree = (what.tree, what.leaves);
        tile::cast(simd, tree, bundle, question, Todo::new(room), counter);
    }
    runs
}
