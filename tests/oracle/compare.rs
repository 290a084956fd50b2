//! The promised tolerance, and a report that helps to find what breaks it.

use super::scene::Scene;
use super::view::{Picture, relative_error, stable};
use std::fmt::Write as _;

/// A pixel is right within this, relative to max(1, value).
pub const RIGHT_WITHIN: f64 = 1e-3;

/// The share of stable pixels that must be right.
pub const SHARE: f64 = 0.999;

/// How a picture of a scene compares with the oracle's own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Verdict {
    pub pixels: usize,
    pub stable: usize,
    pub wrong: usize,
}

/// Holds `got` against the oracle's picture of `scene`: `Err` with a report unless at least
/// [`SHARE`] of the stable pixels are right and none of all pixels is non-finite.
pub fn compare(scene: &Scene, want: &Picture, got: &Picture) -> Result<Verdict, String> {
    if (got.width, got.height) != (want.width, want.height) {
        return Err(format!("{} x {} pixels in the picture", got.width, got.height));
    }
    let mask = stable(scene, want);
    let mut worst: Vec<(f64, usize)> = Vec::new();
    let mut not_finite = 0;
    for (i, (w, g)) in want.pixels.iter().zip(&got.pixels).enumerate() {
        let error = relative_error(*w, *g);
        if !g.is_finite() {
            not_finite += 1;
            worst.push((f64::INFINITY, i));
        } else if mask[i] && error > RIGHT_WITHIN {
            worst.push((error, i));
        }
    }
    let verdict = Verdict {
        pixels: mask.len(),
        stable: mask.iter().filter(|s| **s).count(),
        wrong: worst.len(),
    };
    if not_finite == 0 && worst.len() as f64 <= (1.0 - SHARE) * verdict.stable as f64 {
        return Ok(verdict);
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut report = format!("{verdict:?}, {not_finite} not finite; the worst:\n");
    for (error, i) in worst.iter().take(8) {
        let (x, y) = (i % want.width, i / want.width);
        let (w, g) = (want.pixels[*i].0, got.pixels[*i].0);
        writeln!(report, "  ({x}, {y}) off by {error:.2e}: want {w:?}, got {g:?}").expect("text");
    }
    Err(report)
}
