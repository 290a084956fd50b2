//! Pixels to rays.

use crate::grid::TileRect;
use reflet_accel::{HitCode, Rays};
use reflet_pack::view::View;

/// Where sample `i` lies within its pixel: an additive recurrence whose steps are the powers of the
/// inverse plastic number (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
/// Sample 0 is the centre.
pub fn position(i: u32) -> [f64; 2] {
    let frac = |x: f64| x - x.floor();
    let i = f64::from(i);
    [frac(0.5 + i * 0.754_877_666_246_692_7), frac(0.5 + i * 0.569_840_290_998_053_2)]
}

/// The camera rays of one sample of a tile, row by row.
pub fn rays(view: &View, rect: TileRect, sample: u32, rays: &mut Rays) {
    let [a, b] = position(sample);
    rays.resize(rect.pixels());
    let mut i = 0;
    for y in rect.y..rect.y + rect.height {
        for x in rect.x..rect.x + rect.width {
            let d = view.direction(f64::from(x) + a, f64::from(y) + b);
            for (column, d) in rays.dir.iter_mut().zip(d) {
                column[i] = d;
            }
            i += 1;
        }
    }
    for (column, eye) in rays.origin.iter_mut().zip(view.eye) {
        column[..i].fill(eye);
    }
    rays.t_max[..i].fill(f32::INFINITY);
    rays.last[..i].fill(HitCode::NONE);
}
