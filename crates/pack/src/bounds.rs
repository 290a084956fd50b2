//! Outward-rounded boxes, and the volumes of surfaces.

/// An axis-aligned box, part of the definition of a hit: a ray hits a primitive only if it passes
/// the primitive's own box (see `reflet-accel`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least x, y, z.
    pub lo: [f32; 3],
    /// The greatest x, y, z.
    pub hi: [f32; 3],
}

impl Aabb {
    /// The box of nothing: no ray passes it, and it is neutral in [`Aabb::union`].
    pub const EMPTY: Aabb = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };
    /// The box of everything.
    pub const INFINITE: Aabb = Aabb { lo: [f32::NEG_INFINITY; 3], hi: [f32::INFINITY; 3] };

    /// How far a box is padded beyond its contents, as a part of its longest edge. The edge
    /// functions of a triangle err by about 4 units in the last place (2^-24) of its size; twice
    /// that, so that a box never cuts a crack between two triangles that share an edge.
    const PAD: f64 = 1.0 / 2_097_152.0;

    /// The box from `lo` to `hi`, padded by 2^-21 of its longest edge and rounded outward.
    pub fn outward(lo: [f64; 3], hi: [f64; 3]) -> Aabb {
        let edge = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
        let pad = edge * Self::PAD;
        Aabb { lo: lo.map(|x| round_down(x - pad)), hi: hi.map(|x| round_up(x + pad)) }
    }

    /// The box of a set of points in `f32`.
    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a [f32; 3]>) -> Aabb {
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points {
            for k in 0..3 {
                lo[k] = lo[k].min(f64::from(p[k]));
                hi[k] = hi[k].max(f64::from(p[k]));
            }
        }
        if lo[0] > hi[0] { Aabb::EMPTY } else { Aabb::outward(lo, hi) }
    }

    /// The least box that holds both.
    pub fn union(&self, other: &Aabb) -> Aabb {
        let mut out = *self;
        for k in 0..3 {
            out.lo[k] = if other.lo[k] < out.lo[k] { other.lo[k] } else { out.lo[k] };
            out.hi[k] = if other.hi[k] > out.hi[k] { other.hi[k] } else { out.hi[k] };
        }
        out
    }

    /// Whether nothing is inside.
    #[inline]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|k| self.lo[k] > self.hi[k])
    }
}

/// A volume that holds all of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Volume {
    /// The surface is not in the picture.
    Nothing,
    /// A sphere is its own volume.
    Ball {
        /// Its centre.
        center: [f32; 3],
        /// Its radius.
        radius: f32,
    },
    /// The box of anything else.
    Box(Aabb),
}

/// The greatest `f32` not above `x`.
pub fn round_down(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) > x { y.next_down() } else { y }
}

/// The least `f32` not below `x`.
pub fn round_up(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) < x { y.next_up() } else { y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn boxes_hold_what_they_are_made_of(lo in prop::array::uniform3(-1e6..1e6f64), edge in prop::array::uniform3(0.0..1e3f64)) {
            let hi = [lo[0] + edge[0], lo[1] + edge[1], lo[2] + edge[2]];
            let b = Aabb::outward(lo, hi);
            for k in 0..3 {
                prop_assert!(f64::from(b.lo[k]) <= lo[k] && f64::from(b.hi[k]) >= hi[k]);
            }
        }
    }
}
