//! The box test: the one slab routine.

use crate::lanes::{F, M, RayLanes, V3, greater, lesser};
use fearless_simd::prelude::*;

/// How much later than its own arithmetic a ray leaves a box, as a factor. Each plane's t errs by
/// at most 3 units in the last place (2^-24), and a triangle's edge functions by about 4 more of
/// the distance; 16 cover both, so that a box never cuts what its kernel would hit at an edge.
pub const LEAVE: f32 = 1.0 + 1.0 / 1_048_576.0;

/// Boxes in lanes, or one in all lanes.
#[derive(Clone, Copy)]
pub struct BoxLanes<S: Simd> {
    /// The least x, y, z.
    pub lo: V3<S>,
    /// The greatest x, y, z.
    pub hi: V3<S>,
}

/// Where rays enter boxes (at least 0), and whether they pass them.
///
/// A plane that contains the ray gives a NaN (0 times infinity), which no comparison takes: the ray
/// is not bounded by it.
#[inline(always)]
pub fn enter<S: Simd>(simd: S, ray: &RayLanes<S>, b: &BoxLanes<S>) -> (F<S>, M<S>) {
    let zero = F::splat(simd, 0.0);
    let mut entry = zero;
    let mut exit = F::splat(simd, f32::INFINITY);
    for k in 0..3 {
        let is_negative = ray.inv[k].simd_lt(zero);
        let near = (is_negative.select(b.hi[k], b.lo[k]) - ray.o[k]) * ray.inv[k];
        let far = (is_negative.select(b.lo[k], b.hi[k]) - ray.o[k]) * ray.inv[k];
        entry = greater(simd, near, entry);
        exit = lesser(simd, far, exit);
    }
    (entry, entry.simd_le(exit * LEAVE))
}
