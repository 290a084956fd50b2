//! A ray as every kernel sees it: eight rays in lanes, or one ray in all lanes.

use crate::rays::{HitCode, Rays};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8, u32x8};

/// How many rays or primitives a kernel tests at once.
pub const LANES: usize = 8;
/// `f32` lanes.
pub type F<S> = f32x8<S>;
/// `u32` lanes.
pub type U<S> = u32x8<S>;
/// Yes or no, a lane each.
pub type M<S> = mask32x8<S>;

/// x, y, z in lanes.
pub type V3<S> = [F<S>; 3];

/// One vector in all lanes. (`array::map` is not inlined, which costs more than what it maps.)
#[inline(always)]
pub fn splat3<S: Simd>(simd: S, v: [f32; 3]) -> V3<S> {
    [F::splat(simd, v[0]), F::splat(simd, v[1]), F::splat(simd, v[2])]
}

/// Three columns' worth of lanes.
#[inline(always)]
pub fn load3<S: Simd>(simd: S, v: [&[f32]; 3]) -> V3<S> {
    [F::from_slice(simd, v[0]), F::from_slice(simd, v[1]), F::from_slice(simd, v[2])]
}

/// The eight rows from `first` on of three columns.
#[inline(always)]
pub fn rows3<S: Simd>(simd: S, c: &[Vec<f32>; 3], first: usize) -> V3<S> {
    let end = first + LANES;
    load3(simd, [&c[0][first..end], &c[1][first..end], &c[2][first..end]])
}

/// The dot product, summed from x to z.
#[inline(always)]
pub fn dot<S: Simd>(a: V3<S>, b: V3<S>) -> F<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a - b`.
#[inline(always)]
pub fn sub<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// How a ray's longest axis is brought to the third place (Woop, Benthin and Wald, "Watertight
/// Ray/Triangle Intersection", JCGT 2013).
pub trait Permute<S: Simd>: Copy {
    /// `v` with its axes turned so that the ray's longest is the third.
    fn permute(&self, v: V3<S>) -> V3<S>;
}

/// All lanes are one ray.
#[derive(Clone, Copy)]
pub struct Uniform {
    third: usize,
}

impl<S: Simd> Permute<S> for Uniform {
    #[inline(always)]
    fn permute(&self, v: V3<S>) -> V3<S> {
        match self.third {
            0 => [v[1], v[2], v[0]],
            1 => [v[2], v[0], v[1]],
            _ => v,
        }
    }
}

/// Each lane is a ray.
#[derive(Clone, Copy)]
pub struct PerLane<S: Simd> {
    is_x: M<S>,
    is_y: M<S>,
}

impl<S: Simd> Permute<S> for PerLane<S> {
    #[inline(always)]
    fn permute(&self, v: V3<S>) -> V3<S> {
        let turn = |x, y, z| self.is_x.select(x, self.is_y.select(y, z));
        [turn(v[1], v[2], v[0]), turn(v[2], v[0], v[1]), turn(v[0], v[1], v[2])]
    }
}

/// Rays in lanes, with all that kernels need more than once.
#[derive(Clone, Copy)]
pub struct RayLanes<S: Simd, P> {
    /// Origins.
    pub o: V3<S>,
    /// Unit directions.
    pub d: V3<S>,
    /// Where the rays begin.
    pub start: F<S>,
    /// 1 / direction by true division.
    pub inv: V3<S>,
    /// Whether the direction is negative, per axis: the far side of a box comes first.
    pub neg: [M<S>; 3],
    /// Codes of the surfaces left, the inside bit cleared.
    pub last: U<S>,
    /// Whether the surface is left on its inside.
    pub last_inside: M<S>,
    /// The longest axis.
    pub axis: P,
    /// How far x and y shear per unit of the longest axis, and its own scale.
    pub shear: V3<S>,
}

impl<S: Simd, P: Permute<S>> RayLanes<S, P> {
    #[inline(always)]
    fn new(simd: S, o: V3<S>, d: V3<S>, start: F<S>, code: U<S>, axis: P) -> Self {
        let zero = F::splat(simd, 0.0);
        let one = F::splat(simd, 1.0);
        let inv = [one / d[0], one / d[1], one / d[2]];
        let turned = axis.permute(d);
        RayLanes {
            o,
            d,
            start,
            inv,
            neg: [inv[0].simd_lt(zero), inv[1].simd_lt(zero), inv[2].simd_lt(zero)],
            last: code & !1u32,
            last_inside: (code & 1u32).simd_eq(1u32),
            axis,
            shear: [turned[0] / turned[2], turned[1] / turned[2], one / turned[2]],
        }
    }
}

impl<S: Simd> RayLanes<S, PerLane<S>> {
    /// The eight rays from `first` on.
    #[inline(always)]
    pub fn load(simd: S, rays: &Rays, first: usize) -> Self {
        let (o, d) = (rows3(simd, &rays.origin, first), rows3(simd, &rays.dir, first));
        let mut codes = [0; LANES];
        for (c, l) in codes.iter_mut().zip(&rays.last[first..first + LANES]) {
            *c = l.0;
        }
        let size = [abs(d[0]), abs(d[1]), abs(d[2])];
        let is_x = size[0].simd_ge(size[1]) & size[0].simd_ge(size[2]);
        let is_y = size[1].simd_ge(size[2]);
        let start = F::from_slice(simd, &rays.t_min[first..first + LANES]);
        Self::new(simd, o, d, start, U::from_slice(simd, &codes), PerLane { is_x, is_y })
    }

    /// The rays' ends; -1 for rays that can hit nothing.
    #[inline(always)]
    pub fn ends(&self, simd: S, t_max: &[f32]) -> F<S> {
        let dd = dot(self.d, self.d);
        let oo = abs(self.o[0]) + abs(self.o[1]) + abs(self.o[2]);
        let inf = F::splat(simd, f32::INFINITY);
        let ok = dd.simd_gt(0.0) & dd.simd_lt(inf) & oo.simd_lt(inf);
        ok.select(F::from_slice(simd, t_max), F::splat(simd, -1.0))
    }
}

impl<S: Simd> RayLanes<S, Uniform> {
    /// Ray `i` in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, rays: &Rays, i: usize) -> Self {
        let d = [rays.dir[0][i], rays.dir[1][i], rays.dir[2][i]];
        let size = [d[0].abs(), d[1].abs(), d[2].abs()];
        let third = if size[0] >= size[1] && size[0] >= size[2] {
            0
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        let o = splat3(simd, [rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]]);
        let d = splat3(simd, d);
        let start = F::splat(simd, rays.t_min[i]);
        Self::new(simd, o, d, start, U::splat(simd, rays.last[i].0), Uniform { third })
    }
}

/// Whether ray `i` can hit anything at all, as [`RayLanes::ends`] has it.
#[inline(always)]
pub fn is_castable(rays: &Rays, i: usize) -> bool {
    let d = [rays.dir[0][i], rays.dir[1][i], rays.dir[2][i]];
    let dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let oo = rays.origin[0][i].abs() + rays.origin[1][i].abs() + rays.origin[2][i].abs();
    dd > 0.0 && dd < f32::INFINITY && oo < f32::INFINITY
}

/// The code of a primitive in a lane of a block that holds none: no ray hits it.
pub const NO_PRIM: HitCode = HitCode::NONE;

#[inline(always)]
/// The absolute value: the sign bit cleared.
pub fn abs<S: Simd>(x: F<S>) -> F<S> {
    F::from_bits(x.to_bits() & 0x7fff_ffffu32)
}
