//! Rays as every kernel sees them: eight in lanes, or one in all lanes.

use crate::rays::HitCode;
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, f32x16, mask32x8, u32x8};

/// How many primitives a ray is tested against at once.
pub const LANES: usize = 8;
/// How many rays a primitive is tested against at once.
pub const WIDE: usize = 16;
/// The lanes of [`WIDE`].
pub type W<S> = f32x16<S>;
/// `f32` lanes.
pub type F<S> = f32x8<S>;
/// The `u32` lanes beside those of [`W`].
pub type Codes<S> = <W<S> as SimdFloat<S>>::Bits;
/// Yes or no, beside those of [`W`].
pub type WideMask<S> = <W<S> as SimdBase<S>>::Mask;
/// `u32` lanes.
pub type U<S> = u32x8<S>;
/// Yes or no, a lane each.
pub type M<S> = mask32x8<S>;

/// `f32` lanes of any number, with as many `u32` lanes beside them.
pub trait Floats<S: Simd>:
    SimdFloat<S, Element = f32, Bits: SimdInt<S, Element = u32, Mask = <Self as SimdBase<S>>::Mask>>
    + SimdBase<S, Mask: Select<Self> + Select<<Self as SimdFloat<S>>::Bits>>
{
}

impl<S: Simd> Floats<S> for F<S> {}
impl<S: Simd> Floats<S> for W<S> {}

/// x, y, z in lanes.
pub type V3<S> = [F<S>; 3];

/// One vector in all lanes. (`array::map` is not inlined, which costs more than what it maps.)
#[inline(always)]
pub fn splat3<S: Simd, V: Floats<S>>(simd: S, v: [f32; 3]) -> [V; 3] {
    [V::splat(simd, v[0]), V::splat(simd, v[1]), V::splat(simd, v[2])]
}

/// Three columns' worth of lanes.
#[inline(always)]
pub fn load3<S: Simd, V: Floats<S>>(simd: S, v: [&[f32]; 3]) -> [V; 3] {
    [V::from_slice(simd, v[0]), V::from_slice(simd, v[1]), V::from_slice(simd, v[2])]
}

/// The rows from `first` on of three columns.
#[inline(always)]
pub fn rows3<S: Simd, V: Floats<S>>(simd: S, c: &[Vec<f32>; 3], first: usize) -> [V; 3] {
    let end = first + V::LEN;
    load3(simd, [&c[0][first..end], &c[1][first..end], &c[2][first..end]])
}

/// The dot product, summed from x to z.
#[inline(always)]
pub fn dot<S: Simd, V: Floats<S>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a - b`.
#[inline(always)]
pub fn sub<S: Simd, V: Floats<S>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The order of the axes that brings the ray's longest to the third place and keeps their
/// handedness (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013).
pub const TURN: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// Rays of one longest axis in lanes, or one ray in all lanes, with all that kernels need more than
/// once.
#[derive(Clone, Copy)]
pub struct RayLanes<S: Simd, V: Floats<S> = F<S>> {
    /// Origins.
    pub o: [V; 3],
    /// Unit directions.
    pub d: [V; 3],
    /// Where the rays begin.
    pub start: V,
    /// 1 / direction by true division.
    pub inv: [V; 3],
    /// The codes of the surfaces that the rays leave.
    pub last: V::Bits,
    /// The axes in the order that has the longest third, one of [`TURN`].
    pub turn: [usize; 3],
    /// How far x and y shear per unit of the longest axis, and its own scale.
    pub shear: [V; 3],
    /// The origins with the longest axis third.
    pub turned: [V; 3],
}

/// `a` where it is greater, else `b`: also where either is a NaN, and where both are zeros. Where
/// the machine has one instruction of just this meaning, that is what is used.
#[inline(always)]
pub fn greater<S: Simd, V: Floats<S>>(simd: S, a: V, b: V) -> V {
    if has_max(simd) { a.max(b) } else { a.simd_gt(b).select(a, b) }
}

/// `a` where it is less, else `b`; see [`greater`].
#[inline(always)]
pub fn lesser<S: Simd, V: Floats<S>>(simd: S, a: V, b: V) -> V {
    if has_max(simd) { a.min(b) } else { a.simd_lt(b).select(a, b) }
}

/// Whether max and min are x86's MAXPS and MINPS, which give the second operand unless the first
/// wins. Known when compiled.
#[inline(always)]
fn has_max<S: Simd>(simd: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        use fearless_simd::Level;
        let level = simd.level();
        matches!(level, Level::Sse2(_) | Level::Sse4_2(_) | Level::Avx2(_) | Level::Avx512(_))
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        let _ = simd;
        false
    }
}

/// The code of a primitive in a lane of a block that holds none: no ray hits it.
pub const NO_PRIM: HitCode = HitCode::NONE;

/// The absolute value: the sign bit cleared.
#[inline(always)]
pub fn abs<S: Simd, V: Floats<S>>(x: V) -> V {
    V::from_bits(x.to_bits() & 0x7fff_ffffu32)
}
