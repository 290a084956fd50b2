//! Streams of rays on their way to the structures: as bundles where rays run together, else one by
//! one. What is chosen never shows in a hit.

use crate::blocks::Blocks;
use crate::build::Tree;
use crate::bundle::{Bundle, NO_CLASS, RAYS};
use crate::bvh::{self, Key};
use crate::lanes::LANES;
use crate::rays::{HitCode, Question, Rays};
use crate::tile;
use fearless_simd::prelude::*;

/// What rays are cast at.
#[derive(Clone, Copy)]
pub struct Structures<'a> {
    /// What every ray is tested against.
    pub list: &'a Blocks,
    /// What the tree's leaves hold.
    pub leaves: &'a Blocks,
    /// The tree; empty if all is in the list.
    pub tree: &'a Tree,
}

/// Memory of one thread.
#[derive(Default)]
pub struct Memory {
    taken: Box<Bundle>,
    some: Box<Bundle>,
    stack: Vec<Key>,
}

/// Casts all rays; `t` and `code` hold their ends and no code, and get their hits.
#[inline(always)]
pub fn cast<S: Simd>(
    simd: S,
    what: Structures<'_>,
    rays: &Rays,
    question: Question,
    (t, code): (&mut [f32], &mut [HitCode]),
    memory: &mut Memory,
) {
    let has_tree = !what.tree.nodes.is_empty();
    if what.list.is_empty() && !has_tree {
        return;
    }
    let Memory { taken, some, stack } = memory;
    let deepest = LANES * (what.tree.depth + 1);
    stack.resize(stack.len().max(deepest), 0);
    for first in (0..rays.len()).step_by(RAYS) {
        if taken.take(simd, rays, first).is_some() {
            taken.bound(simd, question);
            cast_bundle(simd, what, question, taken, stack);
        } else if what.list.is_empty() && taken.is_scattered(*APART * what.tree.extent, *SPREAD) {
            bvh::cast(simd, (what.tree, what.leaves), taken, question, stack);
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
                    cast_bundle(simd, what, question, some, stack);
                    for (i, slot) in slots.iter().enumerate() {
                        let slot = usize::from(*slot) % RAYS;
                        (taken.t[slot], taken.code[slot]) = (some.t[i], some.code[i]);
                    }
                }
            }
        }
        let len = taken.len;
        t[first..first + len].copy_from_slice(&taken.t[..len]);
        for (to, from) in code[first..first + len].iter_mut().zip(&taken.code[..len]) {
            *to = HitCode(*from);
        }
    }
}

#[inline(never)]
fn tune(name: &str, default: f32) -> f32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}
static SPREAD: std::sync::LazyLock<f32> = std::sync::LazyLock::new(|| tune("SPREAD", 0.25));
static APART: std::sync::LazyLock<f32> = std::sync::LazyLock::new(|| tune("APART", 0.02));

/// Casts a bundle of one class.
#[inline(always)]
fn cast_bundle<S: Simd>(
    simd: S,
    what: Structures<'_>,
    question: Question,
    bundle: &mut Bundle,
    stack: &mut [Key],
) {
    tile::cast_at_list(simd, what.list, bundle, question);
    let leaves = (what.tree, what.leaves);
    if !what.tree.nodes.is_empty() {
        let (slopes, origins) = bundle.spread(what.tree.extent);
        if slopes < *SPREAD && origins < *APART && bundle.len > LANES {
            tile::cast(simd, leaves, bundle, question, stack);
        } else {
            bvh::cast(simd, leaves, bundle, question, stack);
        }
    }
}
