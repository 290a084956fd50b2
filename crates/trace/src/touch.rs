//! The trees that a moved surface can have changed, made anew.
//!
//! By the definition of a hit (see `reflet-accel`) a ray's answer can differ only if it hit a
//! surface that changed, or meets the new shape of one no later than its hit; a shadow ray's only if
//! it was free and meets a new shape, or was blocked and meets an old one. So a tree of which no
//! segment does is exact: the same surfaces give the same bits. Segments run between kept points,
//! with more slack than these were rounded by (see `segment`).

use crate::capsule::{self, Capsules, To};
use crate::grid::TileRect;
use crate::grow::{TraceScratch, Tracer, place};
use crate::mirror;
use crate::segment::{self, Begin};
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
    near: Vec<bool>,
    /// The level-0 rows of touched trees, and their pixels.
    roots: Vec<u16>,
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
        self.find_origins((rect, sample), s);
        if trees.points == Points::Dropped {
            self.locate((rect, sample), trees, (s, t));
        }
        self.find_touched(moved, relit, trees, (s, t));
        trees.fit_lights(self.columns.lights.len());
        t.roots.clear();
        t.pixels.clear();
        let roots = t.touched[0].iter().enumerate();
        t.roots.extend(roots.filter(|(_, touched)| **touched).map(|(row, _)| row as u16));
        if t.roots.is_empty() {
            return 0;
        }
        let pixels = &trees.levels[0].parent;
        t.pixels.extend(t.roots.iter().map(|row| pixels[usize::from(*row)]));
        prune(trees, &t.touched, &mut t.rows);
        t.grown.palette.clone_from(&trees.palette);
        self.grow_some((rect, sample), &t.pixels, Points::Kept, &mut t.grown, s);
        graft(trees, &mut t.grown, &t.roots);
        Capsules::find(trees, self.begin(&s.origins));
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
        self.known_rays((rect, sample), trees, s);
        for depth in 0..trees.levels.len() {
            let (level, below) = trees.levels[depth..].split_at_mut(1);
            let level = &mut level[0];
            s.replayed += level.len() as u64;
            let below = below.first().map_or(&[][..], |below| &below.parent);
            dispatch!(self.accel.level(), simd => {
                s.known.replay(simd, self.columns, &level.code);
                let (rays, points) = (&s.known.rays, &s.known.points);
                mirror::reflect(simd, rays, points, &level.code, below, &mut t.next);
            });
            place(level, &s.known);
            std::mem::swap(&mut s.known.rays, &mut t.next);
        }
        trees.points = Points::Kept;
        Capsules::find(trees, self.begin(&s.origins));
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
        let moved_here = t.moved_slots.contains(&true);
        t.touched.resize_with(trees.levels.len().max(1), Vec::new);
        for (depth, level) in trees.levels.iter().enumerate() {
            let touched = &mut t.touched[depth];
            touched.clear();
            touched.resize(level.len(), false);
            if moved_here {
                for (touched, slot) in touched.iter_mut().zip(&level.slot) {
                    *touched = t.moved_slots[usize::from(*slot)];
                }
            }
            let above = depth.checked_sub(1).map(|above| &trees.levels[above]);
            let from = above.map_or(self.begin(&s.origins), |above| Begin::Above(&above.at));
            dispatch!(self.accel.level(), simd => {
                level.capsules.near(simd, To::Ends, [&moved.new, &[]], &mut t.near);
                for rows in capsule::flagged(&t.near, level.len()) {
                    s.tested += rows.len() as u64;
                    segment::paths(simd, from, (level, rows), &moved.new, touched);
                }
            });
            for (i, terms) in level.light.iter().enumerate() {
                let id = LightId(i as u32);
                if i >= self.columns.lights.len() || relit.binary_search(&id).is_ok() {
                    continue;
                }
                let light = &self.columns.light_place(id);
                let volumes = (&moved.old[..], &moved.new[..]);
                dispatch!(self.accel.level(), simd => {
                    let both = [volumes.0, volumes.1];
                    level.capsules.near(simd, To::Light(light), both, &mut t.near);
                    for rows in capsule::flagged(&t.near, level.len()) {
                        s.tested += rows.len() as u64;
                        segment::shadows(simd, (level, rows), (light, terms), volumes, touched);
                    }
                });
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

/// Puts trees, numbered by the same palette, in the places of some roots.
fn graft(trees: &mut Trees, grown: &mut Trees, roots: &[u16]) {
    std::mem::swap(&mut trees.palette, &mut grown.palette);
    for (row, root) in roots.iter().enumerate() {
        trees.levels[0].replace(usize::from(*root), &grown.levels[0], row);
    }
    let mut first_above = 0;
    for (depth, new) in grown.levels.iter().enumerate().skip(1) {
        if trees.levels.len() == depth {
            trees.levels.push(Level::default());
        }
        let level = &mut trees.levels[depth];
        let first = level.len() as u16;
        level.append(new, |parent| match depth {
            1 => roots[usize::from(parent)],
            _ => first_above + parent,
        });
        first_above = first;
    }
    while trees.levels.last().is_some_and(Level::is_empty) {
        trees.levels.pop();
    }
}
