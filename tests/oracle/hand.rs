//! What cases worked out by hand need: scenes of a few pixels, and the roundings that they may have.

use super::binary::{Rendered, rendered};
use super::vec3::Vec3;

/// The relative error of one operation in f32, rounded to nearest.
pub const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// The same in all three channels.
pub fn grey(x: f64) -> Vec3 {
    Vec3::splat(x)
}

/// The picture of one pixel, seen from z = 1 down to the origin, with `settings` and `things`.
pub fn ahead(name: &str, settings: &str, things: &str) -> Vec3 {
    let script = format!(
        "image(#{{ width: 1, height: 1 }});
settings(#{{ {settings} }});
camera(#{{ eye: [0, 0, 1], look_at: [0, 0, 0] }});
{things}"
    );
    rendered(name, &script).picture.at(0, 0)
}

/// A square picture of `n` x `n` pixels by the classic view: from (0, 0, 2) through the window
/// `edge` x `edge`, so that a surface in z = 0 is met at the window's own points.
pub fn classic(name: &str, n: usize, edge: f64, things: &str) -> Rendered {
    let script = format!(
        "image(#{{ width: {n}, height: {n} }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ viewpoint: [0, 0, 2], window: [{edge:?}, {edge:?}] }});
{things}"
    );
    rendered(name, &script)
}

/// Holds each channel to `want` within so many roundings; a 0 must be met exactly.
pub fn within(got: Vec3, want: Vec3, roundings: f64) {
    for i in 0..3 {
        let error = (got[i] - want[i]).abs();
        let bound = roundings * ROUNDING * want[i].abs();
        assert!(error <= bound, "{got:?} is not {want:?}: off by {error:.2e}");
    }
}
