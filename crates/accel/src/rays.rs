//! Streams of rays, and what they hit.

use crate::lanes::WIDE;
use reflet_pack::PrimId;

/// What a ray hit, or what it leaves: a primitive, and from which side.
///
/// 0 is nothing; otherwise twice the primitive's id plus 2, plus 1 if a closed shape was hit from
/// the inside. So codes are ordered as ids are, and a tie can be decided on codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct HitCode(pub u32);

impl HitCode {
    /// No primitive.
    pub const NONE: HitCode = HitCode(0);
    /// That of the first primitive, hit from outside.
    pub const FIRST: HitCode = HitCode(2);
    /// One more than the greatest id that a code can hold.
    pub const MAX_PRIMS: usize = (u32::MAX >> 1) as usize - 1;

    /// The code of a primitive hit from outside, or of one with two equal sides.
    #[inline]
    pub fn outside(prim: PrimId) -> HitCode {
        HitCode((prim.0 + 1) << 1)
    }

    /// The same primitive, hit from the inside.
    #[inline]
    pub fn inward(self) -> HitCode {
        HitCode(self.0 | 1)
    }

    /// Whether nothing was hit.
    #[inline]
    pub fn is_none(self) -> bool {
        self.0 == 0
    }

    /// What was hit.
    #[inline]
    pub fn prim(self) -> Option<PrimId> {
        (self.0 >> 1).checked_sub(1).map(PrimId)
    }

    /// Whether it is a closed shape, hit from the inside.
    #[inline]
    pub fn is_inside(self) -> bool {
        self.0 & 1 == 1
    }
}

/// A stream of rays as columns. Directions are unit vectors. A ray with a NaN, an infinite origin
/// or a zero or infinite direction hits nothing.
#[derive(Clone, Debug, Default)]
pub struct Rays {
    /// Origins: x, y, z.
    pub origin: [Vec<f32>; 3],
    /// Unit directions: x, y, z.
    pub dir: [Vec<f32>; 3],
    /// Where each ray begins: only hits whose kernel's t lies above it count. 0 unless it is written.
    pub t_min: Vec<f32>,
    /// Where each ray ends: only hits with t below it count; may be infinite.
    pub t_max: Vec<f32>,
    /// The surface that each leaves, whose root at the origin does not count.
    pub last: Vec<HitCode>,
    len: usize,
}

impl Rays {
    /// Appends a ray.
    #[inline]
    pub fn push(&mut self, origin: [f32; 3], dir: [f32; 3], t_max: f32, last: HitCode) {
        self.truncate_padding();
        for k in 0..3 {
            self.origin[k].push(origin[k]);
            self.dir[k].push(dir[k]);
        }
        self.t_min.push(0.0);
        self.t_max.push(t_max);
        self.last.push(last);
        self.len += 1;
    }

    /// Appends row `i` of another stream.
    #[inline]
    pub fn push_from(&mut self, other: &Rays, i: usize) {
        let at = |c: &[Vec<f32>; 3]| [c[0][i], c[1][i], c[2][i]];
        self.push(at(&other.origin), at(&other.dir), other.t_max[i], other.last[i]);
        self.t_min[self.len - 1] = other.t_min[i];
    }

    /// Makes `len` rays of zeros, to be written in place; the columns are padded to whole lanes.
    pub fn resize(&mut self, len: usize) {
        self.len = len;
        self.pad();
    }

    /// Empties the stream, keeping its memory.
    pub fn clear(&mut self) {
        self.len = 0;
        self.truncate_padding();
    }

    /// How many rays there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Pads all columns to whole lanes with rays that hit nothing.
    pub fn pad(&mut self) {
        let padded = self.len.next_multiple_of(WIDE);
        for k in 0..3 {
            self.origin[k].resize(padded, 0.0);
            self.dir[k].resize(padded, 0.0);
            self.dir[k][self.len..].fill(0.0);
        }
        self.t_min.resize(padded, 0.0);
        self.t_max.resize(padded, 0.0);
        self.last.resize(padded, HitCode::NONE);
    }

    fn truncate_padding(&mut self) {
        for k in 0..3 {
            self.origin[k].truncate(self.len);
            self.dir[k].truncate(self.len);
        }
        self.t_min.truncate(self.len);
        self.t_max.truncate(self.len);
        self.last.truncate(self.len);
    }
}

/// What a stream of rays hit, as columns padded to whole lanes.
#[derive(Clone, Debug, Default)]
pub struct Hits {
    /// Distances; the ray's own `t_max` where nothing was hit.
    pub t: Vec<f32>,
    /// What was hit.
    pub code: Vec<HitCode>,
}

/// Rays counted where they enter this crate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Rays whose closest hit was asked for.
    pub closest: u64,
    /// Rays of which it was asked whether they hit anything.
    pub any: u64,
}

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Which hit is closest.
    Closest,
    /// Whether there is any.
    Any,
}
