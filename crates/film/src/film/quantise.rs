//! A palette for the colours of a film: exact where they are few, else by splitting boxes of
//! colours (after Heckbert's median cut, SIGGRAPH 1982, but the box and the axis of the greatest
//! squared error are split, at the mean, as Wu does in Graphics Gems II). All in integers.

use rayon::prelude::*;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Colours, and which of them stands for another.
pub(super) struct Palette {
    colours: Vec<[u8; 3]>,
    lookup: Lookup,
}

enum Lookup {
    Exact(HashMap<[u8; 3], u8>),
    /// By [`bin`].
    Bins(Vec<u8>),
}

const BINS: usize = 1 << 16;

/// 5 bits of red, 6 of green, 5 of blue.
pub(super) fn bin([r, g, b]: [u8; 3]) -> usize {
    (usize::from(r >> 3) << 11) | (usize::from(g >> 2) << 5) | usize::from(b >> 3)
}

/// The colours that fell into one bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: u64,
    sums: [u64; 3],
}

impl Bin {
    fn mean(&self, axis: usize) -> u64 {
        (2 * self.sums[axis] + self.count) / (2 * self.count)
    }
}

/// A box: some of the bins, and where it is best split.
struct Cell {
    bins: Vec<u16>,
    /// The greatest squared error of an axis.
    error: u128,
    axis: usize,
    total: Bin,
}

impl Cell {
    fn new(bins: Vec<u16>, all: &[Bin]) -> Self {
        let mut total = Bin::default();
        let mut squares = [0_u128; 3];
        for bin in bins.iter().map(|&index| &all[usize::from(index)]) {
            total.count += bin.count;
            for (axis, square) in squares.iter_mut().enumerate() {
                total.sums[axis] += bin.sums[axis];
                // The spread within a bin is left out: it cannot be split.
                *square += u128::from(bin.sums[axis]).pow(2) / u128::from(bin.count);
            }
        }
        let errors: [u128; 3] = std::array::from_fn(|axis| {
            let mean = u128::from(total.sums[axis]).pow(2) / u128::from(total.count);
            squares[axis].saturating_sub(mean)
        });
        let axis = (0..3).max_by_key(|&axis| errors[axis]).unwrap_or(0);
        let error = if bins.len() > 1 { errors[axis] } else { 0 };
        Self { bins, error, axis, total }
    }

    /// The bins below the mean along the axis, and the others; `None` if one side were empty.
    fn split(&self, all: &[Bin]) -> Option<[Self; 2]> {
        let axis = self.axis;
        let (below, above): (Vec<u16>, Vec<u16>) = self.bins.iter().partition(|&&index| {
            let bin = &all[usize::from(index)];
            // bin mean < cell mean, without division.
            u128::from(bin.sums[axis]) * u128::from(self.total.count)
                < u128::from(self.total.sums[axis]) * u128::from(bin.count)
        });
        if below.is_empty() || above.is_empty() {
            return None;
        }
        Some([Self::new(below, all), Self::new(above, all)])
    }
}

/// The colours that a palette is to stand for, counted as they come.
pub(super) struct Colours {
    /// Each by itself while they are few.
    exact: Option<HashMap<[u8; 3], u8>>,
    list: Vec<[u8; 3]>,
    bins: Vec<Bin>,
    last: Option<[u8; 3]>,
}

impl Default for Colours {
    fn default() -> Self {
        let bins = vec![Bin::default(); BINS];
        Self { exact: Some(HashMap::new()), list: Vec::new(), bins, last: None }
    }
}

impl Colours {
    /// One pixel more.
    pub(super) fn add(&mut self, colour: [u8; 3]) {
        let bin = &mut self.bins[bin(colour)];
        bin.count += 1;
        for (sum, value) in bin.sums.iter_mut().zip(colour) {
            *sum += u64::from(value);
        }
        if self.last == Some(colour) {
            return;
        }
        self.last = Some(colour);
        let Some(exact) = &mut self.exact else { return };
        let next = self.list.len();
        if let Entry::Vacant(place) = exact.entry(colour) {
            if next == 256 {
                self.exact = None;
                return;
            }
            place.insert(next as u8);
            self.list.push(colour);
        }
    }

    /// At most `most` colours (1..=256) for them.
    pub(super) fn palette(self, most: usize) -> Palette {
        if let Some(exact) = self.exact.filter(|_| self.list.len() <= most) {
            return Palette { colours: self.list, lookup: Lookup::Exact(exact) };
        }
        let bins = self.bins;
        let used = (0..=u16::MAX).filter(|&index| bins[usize::from(index)].count > 0);
        let mut cells = vec![Cell::new(used.collect(), &bins)];
        while cells.len() < most {
            let worst = (0..cells.len())
                .filter(|&cell| cells[cell].error > 0)
                .max_by_key(|&cell| (cells[cell].error, std::cmp::Reverse(cell)));
            let Some(worst) = worst else { break };
            match cells[worst].split(&bins) {
                Some([below, above]) => {
                    cells[worst] = below;
                    cells.push(above);
                }
                None => cells[worst].error = 0,
            }
        }
        let mut lookup = vec![0; BINS];
        for (index, cell) in cells.iter().enumerate() {
            for &bin in &cell.bins {
                lookup[usize::from(bin)] = index as u8;
            }
        }
        let mean = |cell: &Cell| std::array::from_fn(|axis| cell.total.mean(axis) as u8);
        Palette { colours: cells.iter().map(mean).collect(), lookup: Lookup::Bins(lookup) }
    }
}

impl Palette {
    pub(super) fn colours(&self) -> &[[u8; 3]] {
        &self.colours
    }

    /// Whether every colour stands for itself.
    pub(super) fn is_exact(&self) -> bool {
        matches!(self.lookup, Lookup::Exact(_))
    }

    /// For every [`bin`], the index of the colour nearest to its middle; also for those that no
    /// colour of the film is in.
    pub(super) fn nearest(&self) -> Vec<u8> {
        let near = |bin: usize| {
            let middle = [bin >> 11 << 3 | 4, (bin >> 5 & 63) << 2 | 2, (bin & 31) << 3 | 4];
            let distance = |colour: &[u8; 3]| -> i64 {
                let axes = colour.iter().zip(middle);
                axes.map(|(value, middle)| (i64::from(*value) - middle as i64).pow(2)).sum()
            };
            let nearest =
                self.colours.iter().enumerate().min_by_key(|(_, colour)| distance(colour));
            nearest.map_or(0, |(index, _)| index as u8)
        };
        (0..BINS).into_par_iter().map(near).collect()
    }

    /// The index of the colour that stands for `colour`, one of those that the palette was made of.
    pub(super) fn index(&self, colour: [u8; 3]) -> u8 {
        match &self.lookup {
            Lookup::Exact(indices) => indices.get(&colour).copied().unwrap_or(0),
            Lookup::Bins(lookup) => lookup[bin(colour)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(colours: impl Iterator<Item = [u8; 3]>, most: usize) -> Palette {
        let mut all = Colours::default();
        colours.for_each(|colour| all.add(colour));
        all.palette(most)
    }

    #[test]
    fn few_colours_are_exact() {
        let colours: Vec<[u8; 3]> = (0..=255).map(|i| [i, 255 - i, i / 2]).collect();
        let palette = of(colours.iter().chain(&colours).copied(), 256);
        assert_eq!(palette.colours(), colours);
        for colour in colours {
            assert_eq!(palette.colours()[usize::from(palette.index(colour))], colour);
        }
    }

    #[test]
    fn many_colours_stay_near() {
        let colours: Vec<[u8; 3]> = (0..40_000_u32)
            .map(|i| [(i % 200) as u8, (i / 200) as u8, ((i % 200 + i / 200) / 2) as u8])
            .collect();
        for most in [2, 16, 255, 256] {
            let palette = of(colours.iter().copied(), most);
            assert_eq!(palette.colours().len(), most);
            let error: f64 = colours
                .iter()
                .map(|&colour| {
                    let near = palette.colours()[usize::from(palette.index(colour))];
                    let square =
                        |axis: usize| (f64::from(near[axis]) - f64::from(colour[axis])).powi(2);
                    square(0) + square(1) + square(2)
                })
                .sum::<f64>()
                / colours.len() as f64;
            // A plane of 200 x 200 cut into n squares of side 200/sqrt(n): each axis has a mean
            // squared error of side^2/12, and the third, their mean, half of that. Twice that is
            // allowed for boxes that are not squares, and 2 for the rounding to bins.
            let ideal = 40_000.0 / most as f64 / 12.0 * 2.5;
            assert!(error <= 2.0 * ideal + 2.0, "{most}: {error} against {ideal}");
        }
    }
}
