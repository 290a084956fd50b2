//! One ray through the tree: eight boxes, then eight primitives at a time.

use crate::blocks::{Block, Blocks};
use crate::build::{Child, Tree};
use crate::lanes::{F, LANES, RayLanes, Uniform, is_castable, load3};
use crate::rays::{HitCode, Rays};
use crate::slab::{BoxLanes, enter};
use fearless_simd::prelude::*;
use reflet_pack::ShapeKind;

/// Children still to be visited, with where the ray enters them.
#[derive(Default)]
pub struct Stack(Vec<(f32, Child)>);

/// Follows each ray to its closest hit; `t` and `code` hold the best so far, and are updated.
#[inline(always)]
pub fn closest<S: Simd>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    rays: &Rays,
    (t, code): (&mut [f32], &mut [HitCode]),
    stack: &mut Stack,
) {
    for i in (0..rays.len()).filter(|i| is_castable(rays, *i)) {
        let ray = RayLanes::splat(simd, rays, i);
        let mut best = (t[i], code[i].0);
        walk(simd, tree, &ray, best.0, stack, |kind, block, _| {
            best = match kind {
                ShapeKind::Sphere => closest_in(simd, &blocks.spheres[block], &ray, best),
                ShapeKind::Plane => closest_in(simd, &blocks.planes[block], &ray, best),
                ShapeKind::Quad => closest_in(simd, &blocks.quads[block], &ray, best),
                ShapeKind::Triangle => closest_in(simd, &blocks.triangles[block], &ray, best),
            };
            Some(best.0)
        });
        (t[i], code[i]) = (best.0, HitCode(best.1));
    }
}

#[inline(always)]
fn closest_in<S: Simd, B: Block>(
    simd: S,
    block: &B,
    ray: &RayLanes<S, Uniform>,
    mut best: (f32, u32),
) -> (f32, u32) {
    let c = block.test(simd, ray);
    let end = F::splat(simd, best.0);
    let near = c.hit & c.t.simd_le(end);
    if near.any_true() {
        let (entry, passes) = enter(simd, ray, &block.frame().boxes(simd));
        let t = entry.simd_gt(c.t).select(entry, c.t);
        let mut bits = (near & passes & t.simd_le(end)).to_bitmask();
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            let found = (t.as_slice()[lane], c.code.as_slice()[lane]);
            if found.0 < best.0 || (found.0 == best.0 && found.1 < best.1) {
                best = found;
            }
        }
    }
    best
}

/// Marks the rays that hit anything before their end.
#[inline(always)]
pub fn any<S: Simd>(
    simd: S,
    (tree, blocks): (&Tree, &Blocks),
    rays: &Rays,
    occluded: &mut [bool],
    stack: &mut Stack,
) {
    for i in (0..rays.len()).filter(|i| is_castable(rays, *i)) {
        if occluded[i] {
            continue;
        }
        let ray = RayLanes::splat(simd, rays, i);
        let end = rays.t_max[i];
        let mut hit = false;
        walk(simd, tree, &ray, end, stack, |kind, block, end| {
            hit = match kind {
                ShapeKind::Sphere => any_in(simd, &blocks.spheres[block], &ray, end),
                ShapeKind::Plane => any_in(simd, &blocks.planes[block], &ray, end),
                ShapeKind::Quad => any_in(simd, &blocks.quads[block], &ray, end),
                ShapeKind::Triangle => any_in(simd, &blocks.triangles[block], &ray, end),
            };
            (!hit).then_some(end)
        });
        occluded[i] = hit;
    }
}

#[inline(always)]
fn any_in<S: Simd, B: Block>(simd: S, block: &B, ray: &RayLanes<S, Uniform>, end: f32) -> bool {
    let c = block.test(simd, ray);
    let end = F::splat(simd, end);
    let near = c.hit & c.t.simd_lt(end);
    if !near.any_true() {
        return false;
    }
    let (entry, passes) = enter(simd, ray, &block.frame().boxes(simd));
    (near & passes & entry.simd_lt(end)).any_true()
}

/// Visits the blocks that the ray may hit before `end`, nearest boxes first. `visit` gives the new
/// end, or `None` to stop.
#[inline(always)]
fn walk<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &RayLanes<S, Uniform>,
    mut end: f32,
    stack: &mut Stack,
    mut visit: impl FnMut(ShapeKind, usize, f32) -> Option<f32>,
) {
    if tree.nodes.is_empty() {
        return;
    }
    let stack = &mut stack.0;
    stack.clear();
    let mut index = 0;
    loop {
        let node = &tree.nodes[index];
        let boxes = BoxLanes {
            lo: load3(simd, [&node.lo[0], &node.lo[1], &node.lo[2]]),
            hi: load3(simd, [&node.hi[0], &node.hi[1], &node.hi[2]]),
        };
        let (entry, passes) = enter(simd, ray, &boxes);
        let mut bits = (passes & entry.simd_le(F::splat(simd, end))).to_bitmask();
        let first = stack.len();
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            let found = (entry.as_slice()[lane], node.child[lane]);
            // Farthest at the bottom.
            let mut at = stack.len();
            stack.push(found);
            while at > first && stack[at - 1].0 < found.0 {
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at] = found;
        }
        index = loop {
            let Some((entry, child)) = stack.pop() else { return };
            // An equal entry may still hold a tie with a lower id.
            if entry > end {
                continue;
            }
            match child.target() {
                Ok(node) => break node,
                Err((kind, block)) => match visit(kind, block, end) {
                    Some(new_end) => end = new_end,
                    None => return,
                },
            }
        };
    }
}
