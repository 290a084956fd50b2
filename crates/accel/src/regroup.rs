//! Rays that end at one place, in the order in which they are seen from there.
//!
//! Shadow rays come as the pixels do whose points they leave. Neighbours among these may lie far
//! apart in depth, and then a bundle of them is wide wherever it is not at the light. In the
//! picture that the light would see they have other neighbours, and these run together. So rays are
//! sorted by cells of that picture, a cube map, along a Z-order curve (Morton, "A Computer Oriented
//! Geodetic Data Base", 1966), cast, and their answers put back. A counting sort and a copy of each
//! column cost little beside what bundles save.

use crate::bundle::{Axes, NO_CLASS, RAYS, is_castable};
use crate::lanes::{Codes, W, WIDE, abs, greater, lesser, rows3};
use crate::rays::{HitCode, Rays};
use fearless_simd::prelude::*;
use std::ops::Range;

/// How many rays are put in order at once: a column of so many stays in a cache of the second level.
pub const WINDOW: usize = 1 << 16;

/// So few rays have hardly other neighbours.
const FEW: usize = 8 * RAYS;

/// How many cells a side of the cube map has at most, as a power of two.
const MAX_BITS: u32 = 7;

/// A window of a stream in another order, and room to find it.
#[derive(Default)]
pub struct Regrouped {
    /// The rays in order.
    pub rays: Rays,
    /// Their ends, to become what they hit.
    pub t: Vec<f32>,
    /// What they hit.
    pub code: Vec<HitCode>,
    /// Which row of the window each is.
    rows: Vec<u32>,
    /// By rows of the window: the slopes, and the class, later the cell.
    slopes: [Vec<f32>; 2],
    cells: Vec<u32>,
    /// Where each cell begins.
    begins: Vec<u32>,
}

/// What a window's rays look like from their end.
struct View {
    /// The least and greatest of each slope.
    slopes: [[f32; 2]; 2],
    /// How many faces of the cube map they are on.
    faces: u32,
}

impl Regrouped {
    /// Puts the rays of a window, which begins at a multiple of [`WIDE`], in order, if they end at
    /// one place and bundles of them would then be expected to spread by less than `spread`.
    #[inline(never)]
    pub fn sort<S: Simd>(
        &mut self,
        simd: S,
        rays: &Rays,
        window: Range<usize>,
        spread: f32,
    ) -> bool {
        simd.vectorize(
            #[inline(always)]
            || {
                if window.len() < FEW {
                    return false;
                }
                let view = self.look(simd, rays, window.clone());
                let Some(view) = view.filter(|view| view.spread(window.len()) < spread) else {
                    return false;
                };
                self.find_order(simd, &view, window.len());
                self.copy(rays, window);
                true
            },
        )
    }

    /// Puts what was hit into the rows of the stream that the window is from.
    pub fn put_back(&self, code: &mut [HitCode]) {
        for (row, found) in self.rows.iter().zip(&self.code) {
            code[*row as usize] = *found;
        }
    }

    /// Finds how the rays are seen from their end, if that is one place.
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, rays: &Rays, window: Range<usize>) -> Option<View> {
        let padded = window.len().next_multiple_of(WIDE);
        self.slopes.iter_mut().for_each(|c| c.resize(padded, 0.0));
        self.cells.resize(padded, 0);
        let first = window.start;
        let apex =
            [0, 1, 2].map(|k| rays.origin[k][first] + rays.t_max[first] * rays.dir[k][first]);
        let splat = |x: f32| W::splat(simd, x);
        let (zero, inf) = (splat(0.0), splat(f32::INFINITY));
        let (mut lo, mut hi) = ([inf; 2], [zero - inf; 2]);
        let mut faces = 0;
        for at in (0..padded).step_by(WIDE) {
            let row = window.start + at;
            let (o, d): ([W<S>; 3], [W<S>; 3]) =
                (rows3(simd, &rays.origin, row), rows3(simd, &rays.dir, row));
            let end = W::from_slice(simd, &rays.t_max[row..row + WIDE]);
            let axes = Axes::of(d);
            let [first, second, third] = axes.turned(d);
            let castable = is_castable(simd, o, d, end);
            let class = axes.class(simd, third, castable);
            let mut stray = zero;
            for k in 0..3 {
                stray = greater(simd, abs(o[k] + end * d[k] - splat(apex[k])), stray);
            }
            let near = stray.simd_lt(end * (1.0 / 64.0)) & end.simd_lt(inf);
            if !(near | !castable).all_true() {
                return None;
            }
            for (k, slope) in [first / third, second / third].into_iter().enumerate() {
                slope.store_slice(&mut self.slopes[k][at..at + WIDE]);
                lo[k] = lesser(simd, castable.select(slope, inf), lo[k]);
                hi[k] = greater(simd, castable.select(slope, zero - inf), hi[k]);
            }
            class.store_slice(&mut self.cells[at..at + WIDE]);
            faces |= 1u32 << (self.cells[at] % 32);
        }
        let range = |k: usize| [lo[k].reduce_min(), hi[k].reduce_max()];
        let faces = (faces & ((1 << NO_CLASS) - 1)).count_ones();
        (faces > 0).then(|| View { slopes: [range(0), range(1)], faces })
    }

    /// Finds which row comes where.
    #[inline(always)]
    fn find_order<S: Simd>(&mut self, simd: S, view: &View, len: usize) {
        let bits = (len.ilog2() / 2 - 1).min(MAX_BITS);
        let side = (1u32 << bits) as f32;
        // Its lowest bits are those of an integer that is added to it.
        const WHOLE: f32 = (1u32 << 23) as f32;
        let most = W::splat(simd, side - 1.0);
        let zero = W::splat(simd, 0.0);
        for at in (0..self.cells.len()).step_by(WIDE) {
            let lanes = at..at + WIDE;
            let mut cell = Codes::<S>::from_slice(simd, &self.cells[lanes.clone()]) << (2 * bits);
            for k in 0..2 {
                let [lo, hi] = view.slopes[k];
                let slope = W::from_slice(simd, &self.slopes[k][lanes.clone()]);
                let scaled =
                    (slope - W::splat(simd, lo)) * (side / (hi - lo).max(f32::MIN_POSITIVE));
                // A NaN becomes the one or the other.
                let scaled = lesser(simd, greater(simd, scaled, zero), most);
                let x = (scaled + W::splat(simd, WHOLE)).to_bits() & 0xffu32;
                let x = (x | (x << 4)) & 0x0f0fu32;
                let x = (x | (x << 2)) & 0x3333u32;
                let x = (x | (x << 1)) & 0x5555u32;
                cell |= x << k as u32;
            }
            cell.store_slice(&mut self.cells[lanes]);
        }
        let cells = &self.cells[..len];
        self.begins.clear();
        self.begins.resize((NO_CLASS as usize + 1) << (2 * bits), 0);
        for cell in cells {
            self.begins[*cell as usize] += 1;
        }
        let mut sum = 0;
        for begin in &mut self.begins {
            sum += std::mem::replace(begin, sum);
        }
        self.rows.resize(len, 0);
        for (row, cell) in cells.iter().enumerate() {
            let place = &mut self.begins[*cell as usize];
            self.rows[*place as usize] = row as u32;
            *place += 1;
        }
    }

    /// Copies the rays into their order.
    #[inline(always)]
    fn copy(&mut self, rays: &Rays, window: Range<usize>) {
        let sorted = &mut self.rays;
        sorted.resize(window.len());
        for k in 0..3 {
            gather(&mut sorted.origin[k], &rays.origin[k][window.clone()], &self.rows);
            gather(&mut sorted.dir[k], &rays.dir[k][window.clone()], &self.rows);
        }
        gather(&mut sorted.t_min, &rays.t_min[window.clone()], &self.rows);
        gather(&mut sorted.t_max, &rays.t_max[window.clone()], &self.rows);
        gather(&mut sorted.last, &rays.last[window], &self.rows);
        self.t.clear();
        self.t.extend_from_slice(&sorted.t_max);
        self.code.clear();
        self.code.resize(self.t.len(), HitCode::NONE);
    }
}

impl View {
    /// How far the slopes of a bundle of one of `len` rays spread, summed over both, if rays lie
    /// evenly.
    fn spread(&self, len: usize) -> f32 {
        let [u, v] = self.slopes.map(|[lo, hi]| hi - lo);
        let share = RAYS as f32 * self.faces as f32 / len as f32;
        2.0 * (u * v * share).sqrt()
    }
}

#[inline(always)]
fn gather<T: Copy>(to: &mut [T], from: &[T], rows: &[u32]) {
    for (to, row) in to.iter_mut().zip(rows) {
        *to = from[*row as usize];
    }
}
