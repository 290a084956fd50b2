//! The box test: the one slab routine.

use crate::lanes::{Floats, RayLanes, greater, lesser};
use fearless_simd::prelude::*;

/// How much later than its own arithmetic a ray leaves a box, as a factor. Each plane's t errs by
/// at most 3 units in the last place (2^-24), and a triangle's edge functions by about 4 more of
/// the distance; 16 cover both, so that a box never cuts what its kernel would hit at an edge.
pub const LEAVE: f32 = 1.0 + 1.0 / 1_048_576.0;

/// Boxes in lanes, or one in all lanes.
#[derive(Clone, Copy)]
pub struct BoxLanes<V> {
    /// The least x, y, z.
    pub lo: [V; 3],
    /// The greatest x, y, z.
    pub hi: [V; 3],
}

/// Where rays enter boxes (at least 0), and whether they pass them.
///
/// A plane that contains the ray gives a NaN (0 times infinity), which no comparison takes: the ray
/// is not bounded by it.
#[inline(always)]
pub fn enter<S: Simd, V: Floats<S>>(
    simd: S,
    ray: &RayLanes<S, V>,
    b: &BoxLanes<V>,
) -> (V, V::Mask) {
    enter_before(simd, ray, b, V::splat(simd, f32::INFINITY))
}

/// The same of rays that end, where those that enter a box later do not pass it. One that enters it
/// just where it ends does: what it has hit there may tie with a lower id.
#[inline(always)]
pub fn enter_before<S: Simd, V: Floats<S>>(
    simd: S,
    ray: &RayLanes<S, V>,
    b: &BoxLanes<V>,
    end: V,
) -> (V, V::Mask) {
    let zero = V::splat(simd, 0.0);
    let mut entry = zero;
    let mut exit = end;
    for k in 0..3 {
        let is_negative = ray.inv[k].simd_lt(zero);
        let near = (is_negative.select(b.hi[k], b.lo[k]) - ray.o[k]) * ray.inv[k];
        let far = (is_negative.select(b.lo[k], b.hi[k]) - ray.o[k]) * ray.inv[k];
        entry = greater(simd, near, entry);
        exit = lesser(simd, far, exit);
    }
    (entry, entry.simd_le(exit * LEAVE))
}
