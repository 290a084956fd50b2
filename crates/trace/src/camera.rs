//! Pixels to rays.

use crate::grid::TileRect;
use reflet_accel::{HitCode, Rays};
use reflet_pack::view::View;

/// The camera rays through one position in each pixel of a tile, row by row.
pub fn rays(view: &View, rect: TileRect, position: [f64; 2], rays: &mut Rays) {
    some_rays(view, rect, position, 0..rect.pixels() as u16, rays);
}

/// The same for some of a tile's pixels, which are numbered row by row.
pub(crate) fn some_rays(
    view: &View,
    rect: TileRect,
    [a, b]: [f64; 2],
    pixels: impl ExactSizeIterator<Item = u16>,
    rays: &mut Rays,
) {
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
