//! Streams of rays on their way to the structures: as bundles where rays run together, else one by
//! one. What is chosen never shows in a hit.

use crate::blocks::Blocks;
use crate::build::Tree;
use crate::bundle::{self, Bundle, NO_CLASS, RAYS, Rows};
use crate::bvh::{self, Key};
use crate::lanes::LANES;
use crate::order::Order;
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
    bundle: Box<Bundle>,
    stack: Vec<Key>,
    order: Order,
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
    let Memory { bundle, stack, order } = memory;
    stack.resize(stack.len().max(LANES * (what.tree.depth + 1)), 0);
    let mut by_class = [[0u32; RAYS]; NO_CLASS as usize];
    let sorted = order.sort(what.tree, rays);
    let mut first = 0;
    while first < rays.len() {
        let len = RAYS.min(rays.len() - first);
        let common = if sorted.is_none() && len == RAYS { common(simd, rays, first) } else { None };
        if let Some(class) = common {
            bundle.load(simd, rays, Rows::All(first), class, question);
            cast_bundle(simd, what, rays, question, (t, code), (bundle, stack));
        } else {
            let mut counts = [0; NO_CLASS as usize + 1];
            for i in first..first + len {
                let row = sorted.map_or(i, |s| s[i] as usize);
                let class = usize::from(bundle::class(rays, row));
                if class < usize::from(NO_CLASS) {
                    by_class[class][counts[class]] = row as u32;
                    counts[class] += 1;
                }
            }
            for class in 0..NO_CLASS {
                let rows = &by_class[usize::from(class)][..counts[usize::from(class)]];
                if !rows.is_empty() {
                    bundle.load(simd, rays, Rows::Some(rows), class, question);
                    cast_bundle(simd, what, rays, question, (t, code), (bundle, stack));
                }
            }
        }
        first += len;
    }
}

/// The class of the rows of a whole bundle, if they have one in common.
#[inline(always)]
fn common<S: Simd>(simd: S, rays: &Rays, first: usize) -> Option<u8> {
    let class = bundle::common_class(simd, rays, first)?;
    for g in 1..LANES {
        if bundle::common_class(simd, rays, first + g * LANES) != Some(class) {
            return None;
        }
    }
    Some(class)
}

#[inline(never)]
fn tune(name: &str, default: f32) -> f32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}
static SPREAD: std::sync::LazyLock<f32> = std::sync::LazyLock::new(|| tune("SPREAD", 0.25));
static APART: std::sync::LazyLock<f32> = std::sync::LazyLock::new(|| tune("APART", 0.02));

#[inline(always)]
fn cast_bundle<S: Simd>(
    simd: S,
    what: Structures<'_>,
    rays: &Rays,
    question: Question,
    (t, code): (&mut [f32], &mut [HitCode]),
    (bundle, stack): (&mut Bundle, &mut [Key]),
) {
    tile::cast_at_list(simd, what.list, bundle, question);
    let leaves = (what.tree, what.leaves);
    if !what.tree.nodes.is_empty() {
        let (slopes, origins) = bundle.spread(what.tree.extent);
        if slopes < *SPREAD && origins < *APART && bundle.len > LANES {
            tile::cast(simd, leaves, bundle, question, stack);
        } else {
            for i in 0..bundle.len {
                let mut best = (bundle.t[i], HitCode(bundle.code[i]));
                if best.0 > 0.0 {
                    bvh::cast(simd, leaves, (rays, bundle.row[i] as usize), question, &mut best, stack);
                    (bundle.t[i], bundle.code[i]) = (best.0, best.1.0);
                }
            }
        }
    }
    for i in 0..bundle.len {
        let row = bundle.row[i] as usize;
        (t[row], code[row]) = (bundle.t[i], HitCode(bundle.code[i]));
    }
}
