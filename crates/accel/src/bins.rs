//! Where a branch of the tree is best cut in two, by bins on all three axes. (Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", RT 2007.)

use crate::items::{Item, center};
use crate::lanes::{F, LANES, M, U, greater, lesser};
use fearless_simd::prelude::*;
use fearless_simd::{f32x4, mask32x4};

/// Added to a small number, this leaves its nearest integer in the lowest bits.
const TO_BITS: f32 = 12_582_912.0;

/// Which bin an item is in, by twice its centre.
#[derive(Clone, Copy, Debug)]
pub struct Grid<const N: usize> {
    least: [f32; LANES],
    scale: [f32; LANES],
    /// 0 on axes on which centres differ, else infinite: no cut there is worth anything.
    penalty: [f32; 4],
}

impl<const N: usize> Grid<N> {
    /// For such centres ([`crate::items::centers`]).
    #[inline(always)]
    pub fn new(centers: &Item) -> Grid<N> {
        let rows = &centers.lanes;
        let mut grid = Grid { least: *rows, scale: [0.0; LANES], penalty: [f32::INFINITY; 4] };
        // The bits of tags are those of tiny numbers, which many machines multiply very slowly: from
        // here on they are infinite.
        (grid.least[Item::SLOT], grid.least[Item::KIND]) = (f32::INFINITY, f32::INFINITY);
        for k in 0..3 {
            let extent = -(rows[k] + rows[k + 4]);
            // Not a number when the extent overflows: such scenes are halved by count.
            if extent > 0.0 && extent.is_finite() {
                let scale = N as f32 * (1.0 - 1e-6) / extent;
                if scale.is_finite() {
                    (grid.scale[k], grid.penalty[k]) = (scale, 0.0);
                }
            }
        }
        grid
    }

    /// Whether an item is left of a border: by the same steps as [`Bins::fill`] finds its bin.
    #[inline(always)]
    pub fn is_left(&self, item: &Item, (axis, border): (usize, usize)) -> bool {
        let axis = axis % 4;
        let center = item.lanes[axis] - item.lanes[axis + 4];
        let place = (center - self.least[axis]) * self.scale[axis] - 0.499_999 + TO_BITS;
        let place = if place > TO_BITS { place } else { TO_BITS };
        place < TO_BITS + border as f32
    }
}

/// What is in each bin of each axis: the box, and as its first tag the bits of how many.
#[derive(Clone, Copy)]
pub struct Bins<const N: usize> {
    axes: [[Item; N]; 3],
}

/// Where a branch is cut.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// The axis, and the first bin of the right side.
    pub border: (usize, usize),
    /// How many are on the left side.
    pub left: usize,
    /// The boxes of both sides.
    pub bounds: [Item; 2],
}

/// An empty bin.
const EMPTY: Item = {
    let mut lanes = Item::NOTHING.lanes;
    (lanes[Item::SLOT], lanes[Item::KIND]) = (0.0, 0.0);
    Item { lanes }
};

/// The lanes of tags.
#[inline(always)]
fn tags<S: Simd>(simd: S) -> M<S> {
    M::from_slice(simd, &[0, 0, 0, -1, 0, 0, 0, -1])
}

/// The union of the boxes of two bins, and the sum of their tags.
#[inline(always)]
fn join<S: Simd>(simd: S, a: F<S>, b: F<S>) -> F<S> {
    let tag = F::from_bits(a.to_bits() + b.to_bits());
    tags(simd).select(tag, lesser(simd, a, b))
}

impl<const N: usize> Bins<N> {
    /// Nothing in any.
    pub const EMPTY: Bins<N> = Bins { axes: [[EMPTY; N]; 3] };

    /// Of some items.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // An axis each, of two columns at once.
    pub fn fill<S: Simd>(simd: S, grid: &Grid<N>, items: &[Item]) -> Bins<N> {
        let mut bins = Bins::EMPTY;
        let (least, scale) = (F::from_slice(simd, &grid.least), F::from_slice(simd, &grid.scale));
        // Added to the bits of a bin: one more.
        let one = U::from_slice(simd, &[0, 0, 0, 1, 0, 0, 0, 0]);
        for item in items {
            let rows = item.load(simd);
            let place = (center(simd, rows) - least) * scale - 0.499_999 + TO_BITS;
            // Where a centre is no number, that is the first bin.
            let place = greater(simd, place, F::splat(simd, TO_BITS));
            let place = place.to_bits() & (N as u32 - 1);
            let place = place.as_slice();
            // Of tags those of the bin are the lesser ones.
            let rows = tags(simd).select(F::splat(simd, f32::INFINITY), rows);
            for k in 0..3 {
                let bin = &mut bins.axes[k][place[k] as usize % N];
                let more = F::from_bits(bin.load(simd).to_bits() + one);
                lesser(simd, rows, more).store_slice(&mut bin.lanes);
            }
        }
        bins
    }

    /// With those of other items.
    #[inline(always)]
    pub fn join<S: Simd>(&mut self, simd: S, other: &Bins<N>) {
        for (mine, others) in self.axes.iter_mut().zip(&other.axes) {
            for (bin, other) in mine.iter_mut().zip(others) {
                join(simd, other.load(simd), bin.load(simd)).store_slice(&mut bin.lanes);
            }
        }
    }

    /// How many are left of a border.
    pub fn left(&self, (axis, border): (usize, usize)) -> usize {
        self.axes[axis][..border].iter().map(Item::count).sum()
    }

    /// The cut of the least expected cost, of equal ones that with the fewest bins on the left, and
    /// then that of the first axis; `None` if there is none with items on both sides.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // A bin each, of three axes at once.
    pub fn cut<S: Simd>(&self, simd: S, grid: &Grid<N>) -> Option<Cut> {
        let mut right = [f32x4::splat(simd, 0.0); N];
        let mut sums = [EMPTY.load(simd); 3];
        for i in (1..N).rev() {
            for k in 0..3 {
                sums[k] = join(simd, self.axes[k][i].load(simd), sums[k]);
            }
            right[i] = costs(simd, sums);
        }
        let penalty = f32x4::from_slice(simd, &grid.penalty);
        let mut best = f32x4::splat(simd, f32::INFINITY);
        let mut borders = f32x4::splat(simd, 0.0);
        let mut sums = [EMPTY.load(simd); 3];
        for i in 1..N {
            for k in 0..3 {
                sums[k] = join(simd, self.axes[k][i - 1].load(simd), sums[k]);
            }
            let cost = costs(simd, sums) + right[i] + penalty;
            let better: mask32x4<S> = cost.simd_lt(best);
            best = better.select(cost, best);
            borders = better.select(f32x4::splat(simd, i as f32), borders);
        }
        let (best, borders) = (best.as_slice(), borders.as_slice());
        let mut axis = 0;
        for k in 1..3 {
            if (best[k], borders[k]) < (best[axis], borders[axis]) {
                axis = k;
            }
        }
        let border = borders[axis] as usize;
        if border == 0 {
            return None;
        }
        let (left, right) = self.axes[axis].split_at(border);
        let bounds = [joined(simd, left), joined(simd, right)];
        Some(Cut { border: (axis, border), left: bounds[0].count(), bounds })
    }
}

/// All of some bins.
#[inline(always)]
fn joined<S: Simd>(simd: S, bins: &[Item]) -> Item {
    let mut all = EMPTY.load(simd);
    for bin in bins {
        all = join(simd, bin.load(simd), all);
    }
    Item::store(all)
}

/// What one side costs on each axis, not a number if it is empty: the area of the box times the
/// number of blocks, which are tested whole.
#[inline(always)]
fn costs<S: Simd>(simd: S, sums: [F<S>; 3]) -> f32x4<S> {
    let (a, b, c) = (edges(simd, sums[0]), edges(simd, sums[1]), edges(simd, sums[2]));
    let (low, high) = (a.zip_low(c), a.zip_high(c));
    let (low_b, high_b) = (b.zip_low(b), b.zip_high(b));
    let (x, y) = (low.zip_low(low_b), low.zip_high(low_b));
    let (z, count) = (high.zip_low(high_b), high.zip_high(high_b));
    let area = x * y + y * z + z * x;
    let blocks: f32x4<S> = ((count.to_bits() + (LANES as u32 - 1)) >> LANES.ilog2()).to_float();
    area * blocks
}

/// The edges of a bin's box, negated, and its count.
#[inline(always)]
fn edges<S: Simd>(simd: S, bin: F<S>) -> f32x4<S> {
    let (low, high) = simd.split_f32x8(bin);
    low + high
}
