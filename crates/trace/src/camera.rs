//! Pixels to rays.

use crate::grid::TileRect;
use reflet_accel::{HitCode, Rays};
use reflet_pack::Filter;
use reflet_pack::filter::place;
use reflet_pack::view::View;

/// Where sample `i` lies within its pixel: an additive recurrence whose steps are the powers of the
/// inverse plastic number (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
/// The filter spreads them by its weights; sample 0 is the centre.
pub fn position(filter: Filter, i: u32) -> [f64; 2] {
    let frac = |x: f64| x - x.floor();
    let i = f64::from(i);
    let even = [frac(0.5 + i * 0.754_877_666_246_692_7), frac(0.5 + i * 0.569_840_290_998_053_2)];
    even.map(|u| place(filter, u))
}

/// The camera rays of one sample of a tile, row by row.
pub fn rays(view: &View, rect: TileRect, sample: u32, rays: &mut Rays) {
    some_rays(view, rect, sample, 0..rect.pixels() as u16, rays);
}

/// The camera rays of one sample of some of a tile's pixels, which are numbered row by row.
pub(crate) fn some_rays(
    view: &View,
    rect: TileRect,
    sample: u32,
    pixels: impl ExactSizeIterator<Item = u16>,
    rays: &mut Rays,
) {
    let [a, b] = position(view.filter, sample);
    let len = pixels.len();
    rays.resize(len);
    for (i, pixel) in pixels.enumerate() {
        let pixel = u32::from(pixel);
        let (x, y) = (rect.x + pixel % rect.width, rect.y + pixel / rect.width);
        let (o, d) = view.ray(f64::from(x) + a, f64::from(y) + b);
        for k in 0..3 {
            rays.origin[k][i] = o[k];
            rays.dir[k][i] = d[k];
        }
    }
    rays.t_max[..len].fill(f32::INFINITY);
    rays.last[..len].fill(HitCode::NONE);
}
