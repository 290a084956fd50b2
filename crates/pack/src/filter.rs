//! Where the positions of a pixel lie, and how a filter bends them.
//!
//! Source: Ernst, Stamminger, Greiner, "Filter Importance Sampling", IEEE Symposium on Interactive Ray
//! Tracing 2006: positions that are spread as the filter's weights are all count the same. So a pixel
//! is the plain mean of samples of its own, whatever the filter; no other pixel needs to know them.

use crate::packer::spread;
use reflet_scene::{Filter, Image, Spread};
use std::f64::consts::SQRT_2;

/// How far a filter reaches from the pixel's centre, in pixels, along each axis: as far as the centres
/// of its neighbours, so that whoever compares pixels with their neighbours sees all edges that it
/// reaches.
pub const REACH: f64 = 1.0;

/// The standard deviation of the gaussian, in pixels; it is cut at two of them.
pub const SIGMA: f64 = 0.5;

/// `erf(REACH / (SIGMA sqrt(2)))`: the share of a gaussian that is left.
const KEPT: f64 = 0.954_499_736_103_641_6;

/// The centre of a pixel.
const CENTRE: [f64; 2] = [0.5, 0.5];

/// Where in a pixel its trees begin, in pixels from its upper left corner. Samples everywhere: an
/// additive recurrence whose steps are the powers of the inverse plastic number (Roberts, "The
/// Unreasonable Effectiveness of Quasirandom Sequences", 2018), bent by the filter, and moved so that
/// their mean is the centre: the picture stays where it is whatever their number. Where samples are
/// spent at edges, first the centre, by whose tree edges are judged.
pub fn positions(image: &Image) -> Vec<[f64; 2]> {
    let frac = |x: f64| x - x.floor();
    let bent = |i: u32| {
        let i = f64::from(i);
        [0.754_877_666_246_692_7, 0.569_840_290_998_053_2]
            .map(|step| place(image.filter, frac(0.5 + i * step)))
    };
    let mut samples: Vec<[f64; 2]> = (0..image.samples).map(bent).collect();
    let sum = samples.iter().fold([0.0; 2], |[x, y], [a, b]| [x + a, y + b]);
    let mean = sum.map(|x| x / f64::from(image.samples));
    for at in &mut samples {
        *at = [0, 1].map(|k| at[k] + 0.5 - mean[k]);
    }
    if spread(*image) == Spread::Edges {
        samples.insert(0, CENTRE);
    }
    samples
}

/// Where on one axis a position lies of which the share `u` of the filter's weight lies to the left,
/// `0 <= u < 1`; in pixels from the pixel's left or upper edge. `1 / 2` is the centre, whatever the
/// filter.
pub fn place(filter: Filter, u: f64) -> f64 {
    let half = u - 0.5;
    let share = 2.0 * half.abs();
    let distance = match filter {
        Filter::Box => return u,
        // The weight to the right of x is (1 - x)^2 / 2.
        Filter::Tent => REACH * (1.0 - (1.0 - share).sqrt()),
        Filter::Gaussian => inverse_erf(share * KEPT) * SIGMA * SQRT_2,
    };
    0.5 + distance.min(REACH).copysign(half)
}

/// The `z` of `erf(z) = y`, for `0 <= y <= KEPT`. Newton's steps from 0 stay below the root, since erf
/// is concave there; they end where rounding does not let them grow any more.
fn inverse_erf(y: f64) -> f64 {
    let mut z = 0.0;
    // Eight are needed at most, and one to see the end.
    for _ in 0..16 {
        let slope = std::f64::consts::FRAC_2_SQRT_PI * libm::exp(-z * z);
        let next = z + (y - libm::erf(z)) / slope;
        if next <= z {
            break;
        }
        z = next;
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_lie_around_the_centre() {
        for (filter, samples) in Filter::ALL.into_iter().flat_map(|f| (1..70).map(move |n| (f, n)))
        {
            let image = Image { samples, filter, ..Image::default() };
            let everywhere = positions(&image);
            let mean =
                |k: usize| everywhere.iter().map(|at| at[k]).sum::<f64>() / f64::from(samples);
            // Sums of n numbers below 2: an ulp of 2 n at each step, twice.
            let within = 4.0 * f64::from(samples) * f64::EPSILON;
            assert!(
                [0, 1].iter().all(|k| (mean(*k) - 0.5).abs() <= within),
                "{filter:?} {samples}"
            );
            let at_edges = positions(&Image { spread: Spread::Edges, ..image });
            assert_eq!(at_edges[0], [0.5, 0.5]);
            assert_eq!(at_edges[usize::from(samples > 1)..], everywhere);
        }
    }

    #[test]
    fn the_middle_is_the_centre_and_a_box_changes_nothing() {
        for filter in Filter::ALL {
            assert_eq!(place(filter, 0.5).to_bits(), 0.5f64.to_bits());
        }
        for i in 0..1000 {
            let u = f64::from(i) / 1000.0;
            assert_eq!(place(Filter::Box, u).to_bits(), u.to_bits());
        }
    }

    #[test]
    fn positions_are_symmetric_ascending_and_within_reach() {
        for filter in Filter::ALL {
            let at: Vec<f64> = (0..1024).map(|i| place(filter, f64::from(i) / 1024.0)).collect();
            assert!(at.windows(2).all(|pair| pair[0] < pair[1]), "{filter:?}");
            assert!((0.5 - REACH..0.5 + REACH).contains(&at[0]));
            assert!((0.5 - REACH..0.5 + REACH).contains(&at[1023]));
            // The halves of a pixel mirror each other, but for the rounding at 1/2 + x, at most two
            // halves of an ulp of 1.5.
            let mirrored = |i: usize| (at[i] + at[1024 - i] - 1.0).abs() <= 2.0 * f64::EPSILON;
            assert!((1..1024).all(mirrored), "{filter:?}");
        }
    }

    #[test]
    fn the_gaussian_is_inverted_to_its_last_digits() {
        assert_eq!(KEPT.to_bits(), libm::erf(REACH / (SIGMA * SQRT_2)).to_bits());
        for i in 0..=4096 {
            let y = KEPT * f64::from(i) / 4096.0;
            // A step from below ends within rounding of erf itself: two ulp of 1.
            assert!((libm::erf(inverse_erf(y)) - y).abs() <= 2.0 * f64::EPSILON, "{y}");
        }
    }
}
