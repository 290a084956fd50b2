//! The trees that a moved surface can have changed, made anew.
//!
//! By the definition of a hit (see `reflet-accel`) a ray's answer can differ only if it hit a
//! surface that changed, or meets the new shape of one no later than its hit; a shadow ray's only if
//! it was free and meets a new shape, or was blocked and meets an old one. So a tree of which no
//! segment does is exact: the same surfaces give the same bits. Segments run between kept points,
//! with more slack than these were rounded by (see `segment`).

use crate::camera;
use crate::grid::TileRect;
use crate::grow::{TraceScratch, Tracer, place};
use crate::mirror;
use crate::segment;
use crate::trees::{Level, Points, Trees};
use fearless_simd::dispatch;
use reflet_accel::Rays;
use reflet_pack::{LightId, SurfaceId, Volume};

/// Surfaces that moved, appeared, vanished or changed shape.
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// Which, ascending.
    pub surfaces: Vec<SurfaceId>,
    /// Where each was, if anywhere.
    pub old: Vec<Volume>,
    /// Where each is, if anywhere.
    pub new: Vec<Volume>,
}

impl Moved {
    fn contains(&self, surface: SurfaceId) -> bool {
        self.surfaces.binary_search(&surface).is_ok()
    }
}

/// Memory of one thread for finding touched trees.
#[derive(Default)]
pub struct TouchScratch {
    touched: Vec<Vec<bool>>,
    /// Of each slot of a tile, whether its surface moved; 0 is a miss.
    moved_slots: Vec<bool>,
    pixels: Vec<u16>,
    rows: [Vec<u16>; 2],
    grown: Trees,
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
        if trees.points == Points::Dropped {
            self.locate((rect, sample), trees, (s, t));
        }
        self.find_touched(moved, relit, trees, (s, t));
        trees.fit_lights(self.columns.lights.len());
        t.pixels.clear();
        let roots = t.touched[0].iter().enumerate();
        t.pixels.extend(roots.filter(|(_, touched)| **touched).map(|(row, _)| row as u16));
        if t.pixels.is_empty() {
            return 0;
        }
        prune(trees, &t.touched, &mut t.rows);
        self.grow_some((rect, sample), &t.pixels, &mut t.grown, s);
        graft(trees, &t.grown, &t.pixels);
        t.pixels.len()
    }

    /// Finds where the rays of trees ended by replaying them in the scene of now. Below a surface
    /// that changed that finds anything, but then the trees are touched.
    fn locate(
        &self,
        (rect, sample): (TileRect, u32),
        trees: &mut Trees,
        (s, t): (&mut TraceScratch, &mut TouchScratch),
    ) {
        camera::rays(&self.columns.view, rect, sample, &mut s.known.rays);
        for depth in 0..trees.levels.len() {
            let (level, below) = trees.levels[depth..].split_at_mut(1);
            let level = &mut level[0];
            s.replayed += level.len() as u64;
            let below = below.first().map_or(&[][..], |below| &below.parent);
            dispatch!(self.accel.level(), simd => {
                s.known.replay(simd, &self.columns.geometry, &level.code);
                let (rays, points) = (&s.known.rays, &s.known.points);
                mirror::reflect(simd, rays, points, &level.code, below, &mut t.next);
            });
            place(level, &s.known);
            std::mem::swap(&mut s.known.rays, &mut t.next);
        }
        trees.points = Points::Kept;
    }

    /// Marks the nodes of touched trees, level by level.
    fn find_touched(
        &self,
        moved: &Moved,
        relit: &[LightId],
        trees: &Trees,
        (s, t): (&mut TraceScratch, &mut TouchScratch),
    ) {
        t.moved_slots.clear();
        t.moved_slots.push(false);
        t.moved_slots.extend(trees.palette.iter().map(|slot| moved.contains(slot.surface)));
        t.touched.resize_with(trees.levels.len().max(1), Vec::new);
        for (depth, level) in trees.levels.iter().enumerate() {
            let touched = &mut t.touched[depth];
            touched.clear();
            touched.extend(level.slot.iter().map(|slot| t.moved_slots[usize::from(*slot)]));
            let above = depth.checked_sub(1).map(|above| &trees.levels[above]);
            let from = (self.columns.view.eye, above);
            dispatch!(self.accel.level(), simd => segment::paths(simd, from, level, &moved.new, touched));
            s.tested += level.len() as u64;
            for (i, terms) in level.light.iter().enumerate() {
                let id = LightId(i as u32);
                if i < self.columns.lights.len() && relit.binary_search(&id).is_err() {
                    let at = self.columns.light_place(id).at;
                    let volumes = (&moved.old[..], &moved.new[..]);
                    dispatch!(self.accel.level(), simd => segment::shadows(simd, level, (at, terms), volumes, touched));
                    s.tested += level.len() as u64;
                }
            }
        }
        if !t.touched.iter().take(trees.levels.len()).flatten().any(|touched| *touched) {
            return;
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
}

/// Takes the nodes of touched trees out, but for the roots, which keep their rows. `rows` is memory:
/// where each row of a level has gone.
fn prune(trees: &mut Trees, touched: &[Vec<bool>], [above, rows]: &mut [Vec<u16>; 2]) {
    above.clear();
    above.extend(0..trees.levels[0].len() as u16);
    for (level, touched) in trees.levels.iter_mut().zip(touched).skip(1) {
        rows.clear();
        let mut kept = 0u16;
        for (parent, touched) in level.parent.iter_mut().zip(touched) {
            rows.push(kept);
            *parent = above[usize::from(*parent)];
            kept += u16::from(!touched);
        }
        if usize::from(kept) < level.len() {
            level.remove(touched);
        }
        std::mem::swap(above, rows);
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
