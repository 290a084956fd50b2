//! Pixel filters through the binary: how much of a pixel an edge covers, by hand.

mod oracle;

use oracle::binary::rendered;
use oracle::hand::{ROUNDING, grey};

/// The greatest difference between the share of `at` below any place and the place itself, in 0..1:
/// the star discrepancy of so many numbers (Niederreiter, "Random Number Generation and Quasi-Monte
/// Carlo Methods", 1992, theorem 2.6).
fn discrepancy(mut at: Vec<f64>) -> f64 {
    at.sort_by(f64::total_cmp);
    let n = at.len() as f64;
    let off = at.iter().enumerate().map(|(i, x)| (x - (i as f64 + 0.5) / n).abs());
    off.fold(0.0, f64::max) + 0.5 / n
}

/// A pixel from 0 to 1 along an axis that is white before `edge`. Before it lies that part of the
/// weight of
/// - a box: edge;
/// - a tent: all but half of `(3/2 - edge)^2`, or half of `(edge + 1/2)^2` below the centre;
/// - a gaussian of sigma 1/2, cut at two of them: of its 95.449974 % those within half a sigma
///   (38.292492 %) or one (68.268949 %), and half of the rest.
const EDGES: [(f64, &str, f64); 10] = [
    (0.75, "box", 0.75),
    (0.75, "tent", 1.0 - 0.75 * 0.75 / 2.0),
    (0.75, "gaussian", 0.5 + 0.38292492 / 0.95449974 / 2.0),
    (1.0, "box", 1.0),
    (1.0, "tent", 1.0 - 0.5 * 0.5 / 2.0),
    (1.0, "gaussian", 0.5 + 0.68268949 / 0.95449974 / 2.0),
    (0.25, "gaussian", 0.5 - 0.38292492 / 0.95449974 / 2.0),
    (-0.25, "box", 0.0),
    (-0.25, "tent", 0.25 * 0.25 / 2.0),
    (1.5, "gaussian", 1.0),
];

#[test]
fn an_edge_covers_what_the_filter_says() {
    const SAMPLES: usize = 4000;
    // A filter moves positions without letting one pass another, so as many lie before the edge as
    // even positions lie below the filter's share: off by their discrepancy at most, and by one
    // position that rounding moves over the edge. Positions are centred by the error of their mean,
    // which is at most their variation, 2 for filters that reach from -1/2 to 3/2, times the
    // discrepancy (Koksma's inequality, theorem 2.9 there); where they move that far, as much of the
    // weight passes the edge, since no filter weighs more than 1 a pixel's width. The mean of ones
    // and zeros rounds once.
    let held = |axis: &str, step: f64, wall: &dyn Fn(f64) -> String| {
        let even = (0..SAMPLES).map(|i| (0.5 + i as f64 * step).fract()).collect();
        let bound = 3.0 * discrepancy(even) + 1.0 / SAMPLES as f64 + ROUNDING;
        // The filters above are told apart by it.
        assert!(bound < 0.008, "{bound}");
        for (edge, filter, share) in EDGES {
            let script = format!(
                "image(#{{ width: 3, height: 3, samples: {SAMPLES}, filter: \"{filter}\" }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ eye: [0.5, -0.5, 1], look_at: [0.5, -0.5, 0], ortho: 3 }});
quad(#{{ {}, material: material(#{{ ambient: 1 }}) }});",
                wall(edge)
            );
            let name = format!("{axis}-{filter}-{}", edge * 100.0);
            let got = rendered(&name, &script).picture.at(1, 1)[0];
            assert!((got - share).abs() <= bound, "{name}: {got} is not {share} within {bound}");
        }
    };
    held("across", 0.7548776662466927, &|edge| {
        format!("corner: [-9, -9, 0], u: [{:?}, 0, 0], v: [0, 18, 0]", 9.0 + edge)
    });
    // y is downward in the picture.
    held("downward", 0.5698402909980532, &|edge| {
        format!("corner: [-9, {:?}, 0], u: [18, 0, 0], v: [0, 9, 0]", -edge)
    });
}

#[test]
fn one_position_is_the_centre() {
    for filter in ["box", "tent", "gaussian"] {
        let script = format!(
            "image(#{{ width: 1, height: 1, filter: \"{filter}\" }});
camera(#{{ eye: [0, 0, 1], look_at: [0, 0, 0], ortho: 1 }});
quad(#{{ corner: [-0.001, -0.001, 0], u: [0.002, 0, 0], v: [0, 0.002, 0],
    material: material(#{{ ambient: 3 }}) }});"
        );
        let picture = rendered(&format!("centre-{filter}"), &script).picture;
        assert_eq!(picture.at(0, 0), grey(3.0), "{filter}");
    }
}
