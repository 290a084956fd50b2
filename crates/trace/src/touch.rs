//! Which trees a moved surface can have changed, and how they are made anew.
//!
//! By the definition of a hit (see `reflet-accel`) a ray's answer can differ only if it hit a
//! surface that changed, or passes the new box of one no later than its hit; a shadow ray's only if
//! it was free and passes a new box, or was blocked and passes an old one. So a tree of which no
//! segment does is exact: the same surfaces give the same bits.

use crate::camera;
use crate::grid::TileRect;
use crate::grow::{TraceScratch, Tracer};
use crate::lighting;
use crate::mirror;
use crate::trees::{Level, Trees};
use fearless_simd::dispatch;
use reflet_accel::{Rays, brute};
use reflet_pack::{Aabb, LightId, SurfaceId};

/// Surfaces that moved, appeared, vanished or changed shape.
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// Which, ascending.
    pub surfaces: Vec<SurfaceId>,
    /// Where each was; empty boxes left out.
    pub old: Vec<Aabb>,
    /// Where each is; empty boxes left out.
    pub new: Vec<Aabb>,
}

impl Moved {
    fn contains(&self, surface: SurfaceId) -> bool {
        self.surfaces.binary_search(&surface).is_ok()
    }
}

fn passes(rays: &Rays, row: usize, end: f32, boxes: &[Aabb]) -> bool {
    let o = [0, 1, 2].map(|k| rays.origin[k][row]);
    let d = [0, 1, 2].map(|k| rays.dir[k][row]);
    boxes.iter().any(|b| brute::enter(o, d, b).is_some_and(|entry| entry <= end))
}

/// Memory of one thread for finding touched trees.
#[derive(Default)]
pub struct TouchScratch {
    touched: Vec<Vec<bool>>,
    pixels: Vec<u16>,
    grown: Trees,
    terms: Vec<f32>,
    next: Rays,
}

impl Tracer<'_> {
    /// Makes those trees of a tile's sample anew that `moved` can have changed, and gives their
    /// number. Shadows of the lights in `relit` are not looked at: [`Tracer::revise`] makes them
    /// anew at all nodes.
    pub fn retrace(
        &self,
        (rect, sample): (TileRect, u32),
        moved: &Moved,
        relit: &[LightId],
        trees: &mut Trees,
        (s, t): (&mut TraceScratch, &mut TouchScratch),
    ) -> usize {
        self.find_touched((rect, sample), moved, relit, trees, (s, t));
        trees.fit_lights(self.columns.lights.len());
        t.pixels.clear();
        let roots = t.touched[0].iter().enumerate();
        t.pixels.extend(roots.filter(|(_, touched)| **touched).map(|(row, _)| row as u16));
        if t.pixels.is_empty() {
            return 0;
        }
        prune(trees, &t.touched);
        self.grow_some((rect, sample), &t.pixels, &mut t.grown, s);
        graft(trees, &t.grown, &t.pixels);
        t.pixels.len()
    }

    /// Marks the nodes of touched trees, level by level, by replaying all in the scene of now. Where
    /// a surface changed that finds anything, but then the node's code says that it is touched.
    fn find_touched(
        &self,
        (rect, sample): (TileRect, u32),
        moved: &Moved,
        relit: &[LightId],
        trees: &Trees,
        (s, t): (&mut TraceScratch, &mut TouchScratch),
    ) {
        camera::rays(&self.columns.view, rect, sample, &mut s.known.rays);
        t.touched.resize_with(trees.levels.len().max(1), Vec::new);
        for (depth, level) in trees.levels.iter().enumerate() {
            s.replayed += level.len() as u64;
            s.tested += level.len() as u64;
            s.known.replay(self.columns, &level.code);
            dispatch!(self.accel.level(), simd => s.known.find(simd, &self.columns.geometry));
            let mut touched = std::mem::take(&mut t.touched[depth]);
            touched.clear();
            touched.extend((0..level.len()).map(|row| {
                let hit = level.code[row].prim().map(|prim| self.columns.surface_of(prim));
                hit.is_some_and(|surface| moved.contains(surface))
                    || passes(&s.known.rays, row, s.known.hits.t[row], &moved.new)
            }));
            self.touch_shadows(moved, relit, level, &mut touched, (s, t));
            t.touched[depth] = touched;
            let empty = Level::default();
            let below = trees.levels.get(depth + 1).unwrap_or(&empty);
            dispatch!(self.accel.level(), simd => mirror::reflect(
                simd, &s.known.rays, &s.known.points, &level.code, &below.parent, &mut t.next
            ));
            std::mem::swap(&mut s.known.rays, &mut t.next);
        }
        // A tree is touched as a whole: first up to the roots, then down to all of it.
        for depth in (1..trees.levels.len()).rev() {
            let (above, below) = t.touched.split_at_mut(depth);
            for (row, parent) in trees.levels[depth].parent.iter().enumerate() {
                above[depth - 1][usize::from(*parent)] |= below[0][row];
            }
        }
        for depth in 1..trees.levels.len() {
            let (above, below) = t.touched.split_at_mut(depth);
            for (row, parent) in trees.levels[depth].parent.iter().enumerate() {
                below[0][row] = above[depth - 1][usize::from(*parent)];
            }
        }
    }

    fn touch_shadows(
        &self,
        moved: &Moved,
        relit: &[LightId],
        level: &Level,
        touched: &mut [bool],
        (s, t): (&mut TraceScratch, &mut TouchScratch),
    ) {
        for (i, terms) in level.light.iter().enumerate() {
            let id = LightId(i as u32);
            if i >= self.columns.lights.len() || relit.binary_search(&id).is_ok() {
                continue;
            }
            let place = self.columns.light_place(id);
            t.terms.clear();
            t.terms.resize(level.len(), 0.0);
            let (points, out) = (&s.known.points, &mut t.terms);
            let (shadow, rows) = (&mut s.shadow, &mut s.shadow_rows);
            dispatch!(self.accel.level(), simd => lighting::aim(
                simd, &place, points, &level.code, out, shadow, rows
            ));
            s.tested += s.shadow_rows.len() as u64;
            for (ray, row) in s.shadow_rows.iter().enumerate() {
                let row = usize::from(*row);
                if !touched[row] {
                    let free = terms[row] != 0.0;
                    let boxes = if free { &moved.new } else { &moved.old };
                    touched[row] = passes(&s.shadow, ray, s.shadow.t_max[ray], boxes);
                }
            }
        }
    }
}

/// Takes the nodes of touched trees out, but for the roots, which keep their rows.
fn prune(trees: &mut Trees, touched: &[Vec<bool>]) {
    let mut renumbered: Vec<u16> = (0..trees.levels[0].len() as u16).collect();
    for (level, touched) in trees.levels.iter_mut().zip(touched).skip(1) {
        let mut keep = touched.iter().map(|t| !t);
        let mut rows = Vec::with_capacity(level.len());
        let mut kept = 0u16;
        for (parent, t) in level.parent.iter_mut().zip(touched) {
            rows.push(kept);
            if !t {
                *parent = renumbered[usize::from(*parent)];
                kept += 1;
            }
        }
        level.retain(|| keep.next().unwrap_or(true));
        renumbered = rows;
    }
}

/// Puts the trees of some pixels in their places.
fn graft(trees: &mut Trees, grown: &Trees, pixels: &[u16]) {
    let slots: Vec<u16> = grown
        .palette
        .iter()
        .map(|slot| {
            let known = trees.palette.iter().position(|s| s == slot);
            let index = known.unwrap_or_else(|| {
                trees.palette.push(*slot);
                trees.palette.len() - 1
            });
            index as u16 + 1
        })
        .collect();
    let slot = |s: u16| if s == 0 { 0 } else { slots[usize::from(s) - 1] };
    for (row, pixel) in pixels.iter().enumerate() {
        trees.levels[0].replace(usize::from(*pixel), &grown.levels[0], row, slot);
    }
    let mut parents: Vec<u16> = pixels.to_vec();
    for (depth, new) in grown.levels.iter().enumerate().skip(1) {
        if trees.levels.len() == depth {
            trees.levels.push(Level::default());
        }
        let level = &mut trees.levels[depth];
        let first = level.len() as u16;
        level.append(new, slot, |parent| parents[usize::from(parent)]);
        parents = (first..level.len() as u16).collect();
    }
    while trees.levels.last().is_some_and(Level::is_empty) {
        trees.levels.pop();
    }
}
