//! Up to 64 rays that have the sign and place of their longest axis in common.

use crate::frusta::Frusta;
use crate::lanes::{Codes, F, LANES, RayLanes, TURN, U, W, WIDE, WideMask, abs, dot, rows3};
use crate::rays::{HitCode, Rays};
use fearless_simd::prelude::*;

/// The most rays of a bundle.
pub const RAYS: usize = GROUPS * WIDE;
/// The most groups of a bundle.
pub const GROUPS: usize = 4;

/// Rays of one longest axis, in groups of [`WIDE`].
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Bundle {
    pub(crate) o: [[f32; RAYS]; 3],
    pub(crate) d: [[f32; RAYS]; 3],
    pub(crate) inv: [[f32; RAYS]; 3],
    pub(crate) shear: [[f32; RAYS]; 3],
    pub(crate) start: [f32; RAYS],
    pub(crate) last: [u32; RAYS],
    /// The best t so far; negative for a ray that is done with, or none.
    pub t: [f32; RAYS],
    /// What was hit there.
    pub code: [u32; RAYS],
    /// Of which class each is.
    pub(crate) class: [u32; RAYS],
    /// Bit k is set if the direction is negative along axis k.
    octant: [u32; RAYS],
    /// How many rays.
    pub len: usize,
    pub(crate) turn: [usize; 3],
    /// What holds them.
    pub(crate) frusta: Frusta,
}

impl Bundle {
    /// A bundle of no rays.
    pub fn new() -> Bundle {
        Bundle {
            o: [[0.0; RAYS]; 3],
            d: [[0.0; RAYS]; 3],
            inv: [[0.0; RAYS]; 3],
            shear: [[0.0; RAYS]; 3],
            start: [0.0; RAYS],
            last: [0; RAYS],
            t: [0.0; RAYS],
            code: [0; RAYS],
            class: [NO_CLASS; RAYS],
            octant: [0; RAYS],
            len: 0,
            turn: TURN[2],
            frusta: Frusta::default(),
        }
    }

    /// Takes the rows of `rays` from `first` on, as many as there are and have room. Gives the class
    /// of all, if they fill the bundle and have one in common.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, rays: &Rays, first: usize) -> Option<u32> {
        self.len = RAYS.min(rays.len() - first);
        let (zero, one) = (W::splat(simd, 0.0), W::splat(simd, 1.0));
        let code = |code: u32| Codes::<S>::splat(simd, code);
        let mut common = self.len == RAYS;
        for at in (0..self.len).step_by(WIDE) {
            let row = first + at;
            let (o, d): ([W<S>; 3], [W<S>; 3]) =
                (rows3(simd, &rays.origin, row), rows3(simd, &rays.dir, row));
            let end = W::from_slice(simd, &rays.t_max[row..row + WIDE]);
            let inv = [one / d[0], one / d[1], one / d[2]];
            let axes = Axes::of(d);
            let [first, second, third] = axes.turned(d);
            let class = axes.class(simd, third, is_castable(simd, o, d, end));
            let negative = |k: usize| inv[k].simd_lt(zero).select(code(1 << k), code(0));
            let octant = negative(0) | negative(1) | negative(2);
            let lanes = at..at + WIDE;
            octant.store_slice(&mut self.octant[lanes.clone()]);
            class.store_slice(&mut self.class[lanes.clone()]);
            common &= class.simd_eq(code(self.class[0])).all_true();
            for k in 0..3 {
                o[k].store_slice(&mut self.o[k][lanes.clone()]);
                d[k].store_slice(&mut self.d[k][lanes.clone()]);
                inv[k].store_slice(&mut self.inv[k][lanes.clone()]);
            }
            let shear = [first / third, second / third, axes.pick(inv[0], inv[1], inv[2])];
            for (to, shear) in self.shear.iter_mut().zip(shear) {
                shear.store_slice(&mut to[lanes.clone()]);
            }
            self.start[lanes.clone()].copy_from_slice(&rays.t_min[row..row + WIDE]);
            end.store_slice(&mut self.t[lanes.clone()]);
            self.code[lanes.clone()].fill(HitCode::NONE.0);
            for (last, code) in self.last[lanes].iter_mut().zip(&rays.last[row..row + WIDE]) {
                *last = code.0;
            }
        }
        (common && self.class[0] != NO_CLASS).then_some(self.class[0])
    }

    /// Writes what all rays have hit.
    #[inline(always)]
    pub fn write(&self, t: &mut [f32], code: &mut [HitCode]) {
        t.copy_from_slice(&self.t[..self.len]);
        for (to, from) in code.iter_mut().zip(&self.code[..self.len]) {
            *to = HitCode(*from);
        }
    }

    /// Takes some of another bundle's rays.
    pub fn select(&mut self, from: &Bundle, slots: &[u8]) {
        self.len = slots.len();
        let padded = self.len.next_multiple_of(WIDE);
        // The last ray once more in lanes that are left over: no frustum grows by it.
        for i in 0..padded {
            let slot = usize::from(slots[i.min(slots.len() - 1)]) % RAYS;
            for k in 0..3 {
                self.o[k][i] = from.o[k][slot];
                self.d[k][i] = from.d[k][slot];
                self.inv[k][i] = from.inv[k][slot];
                self.shear[k][i] = from.shear[k][slot];
            }
            self.start[i] = from.start[slot];
            self.t[i] = from.t[slot];
            self.code[i] = from.code[slot];
            self.last[i] = from.last[slot];
            self.class[i] = from.class[slot];
            self.octant[i] = from.octant[slot];
        }
    }

    /// The classes of all rays.
    #[inline(always)]
    pub fn classes(&self) -> &[u32] {
        &self.class[..self.len]
    }

    /// Whether a ray can hit anything, or anything more.
    #[inline(always)]
    pub fn is_castable(&self, slot: usize) -> bool {
        self.class[slot] != NO_CLASS && self.t[slot] > 0.0
    }

    /// A bit for each ray that can hit anything, or anything more.
    #[inline(always)]
    pub fn castable<S: Simd>(&self, simd: S) -> u64 {
        let zero = W::splat(simd, 0.0);
        let none = Codes::<S>::splat(simd, NO_CLASS);
        let mut all = 0;
        for at in (0..RAYS).step_by(WIDE) {
            let t = W::from_slice(simd, &self.t[at..at + WIDE]);
            let class = Codes::<S>::from_slice(simd, &self.class[at..at + WIDE]);
            let can = t.simd_gt(zero) & !class.simd_eq(none);
            all |= can.to_bitmask() << at;
        }
        // The rest is left over from rays before.
        all & (u64::MAX >> (RAYS - self.len))
    }

    /// One ray in all lanes.
    #[inline(always)]
    pub fn splat<S: Simd>(&self, simd: S, slot: usize) -> RayLanes<S> {
        let slot = slot % RAYS;
        let at = |c: &[f32; RAYS]| F::splat(simd, c[slot]);
        let turn = TURN[(self.class[slot] >> 1) as usize % 3];
        RayLanes {
            o: [at(&self.o[0]), at(&self.o[1]), at(&self.o[2])],
            d: [at(&self.d[0]), at(&self.d[1]), at(&self.d[2])],
            start: at(&self.start),
            inv: [at(&self.inv[0]), at(&self.inv[1]), at(&self.inv[2])],
            last: U::splat(simd, self.last[slot]),
            turn,
            shear: [at(&self.shear[0]), at(&self.shear[1]), at(&self.shear[2])],
            turned: [at(&self.o[turn[0]]), at(&self.o[turn[1]]), at(&self.o[turn[2]])],
        }
    }

    /// The octant of a ray's direction: bit k is set if it is negative along axis k.
    #[inline(always)]
    pub fn octant(&self, slot: usize) -> usize {
        self.octant[slot % RAYS] as usize % LANES
    }

    /// Whether rays that are looked at as a sample start far from each other or run apart.
    #[inline(always)]
    pub fn is_scattered(&self, apart: f32, spread: f32) -> bool {
        let mut scattered = false;
        for j in self.samples() {
            let (way, turn) = self.between(j);
            scattered |= turn > spread || way > apart;
        }
        scattered
    }

    /// Whether most rays of the sample start far from the first: nothing holds such rays together.
    #[inline(always)]
    pub fn is_strewn(&self, apart: f32) -> bool {
        let mut far = 0;
        for j in self.samples() {
            far += u32::from(self.between(j).0 > apart);
        }
        far > 1 && self.len > LANES
    }

    #[inline(always)]
    fn samples(&self) -> [usize; 3] {
        [self.len / 3, self.len / 2 + self.len / 6, self.len - 1]
    }

    /// How far a ray starts from the first, and how far it runs from its direction, summed over the
    /// axes.
    #[inline(always)]
    fn between(&self, j: usize) -> (f32, f32) {
        let (mut way, mut turn) = (0.0, 0.0);
        for k in 0..3 {
            way += (self.o[k][0] - self.o[k][j]).abs();
            turn += (self.d[k][0] - self.d[k][j]).abs();
        }
        (way, turn)
    }

    /// The number of groups.
    #[inline(always)]
    pub fn groups(&self) -> usize {
        self.len.div_ceil(WIDE)
    }

    /// A group as kernels see it.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, simd: S, group: usize) -> RayLanes<S, W<S>> {
        let first = group % GROUPS * WIDE;
        let at = |c: &[f32; RAYS]| W::from_slice(simd, &c[first..first + WIDE]);
        let turn = self.turn;
        RayLanes {
            o: [at(&self.o[0]), at(&self.o[1]), at(&self.o[2])],
            d: [at(&self.d[0]), at(&self.d[1]), at(&self.d[2])],
            start: at(&self.start),
            inv: [at(&self.inv[0]), at(&self.inv[1]), at(&self.inv[2])],
            last: Codes::<S>::from_slice(simd, &self.last[first..first + WIDE]),
            turn,
            shear: [at(&self.shear[0]), at(&self.shear[1]), at(&self.shear[2])],
            turned: [at(&self.o[turn[0]]), at(&self.o[turn[1]]), at(&self.o[turn[2]])],
        }
    }
}

impl Default for Bundle {
    fn default() -> Self {
        Bundle::new()
    }
}

/// The class of a ray is twice its longest axis, plus 1 if it runs backward along that; this one
/// can hit nothing.
pub const NO_CLASS: u32 = 6;

/// The longest axis of each ray; of equal ones the first.
pub struct Axes<S: Simd> {
    is_x: WideMask<S>,
    /// Unless it is x.
    is_y: WideMask<S>,
}

impl<S: Simd> Axes<S> {
    /// Of directions.
    #[inline(always)]
    pub fn of(d: [W<S>; 3]) -> Axes<S> {
        let size = [abs(d[0]), abs(d[1]), abs(d[2])];
        Axes {
            is_x: size[0].simd_ge(size[1]) & size[0].simd_ge(size[2]),
            is_y: size[1].simd_ge(size[2]),
        }
    }

    /// What belongs to the longest axis.
    #[inline(always)]
    pub fn pick(&self, x: W<S>, y: W<S>, z: W<S>) -> W<S> {
        self.is_x.select(x, self.is_y.select(y, z))
    }

    /// Vectors with the longest axis third, as [`TURN`] has it.
    #[inline(always)]
    pub fn turned(&self, v: [W<S>; 3]) -> [W<S>; 3] {
        let [x, y, z] = v;
        [self.pick(y, z, x), self.pick(z, x, y), self.pick(x, y, z)]
    }

    /// The classes of rays with such components along their longest axes.
    #[inline(always)]
    pub fn class(&self, simd: S, longest: W<S>, castable: WideMask<S>) -> Codes<S> {
        let code = |code: u32| Codes::<S>::splat(simd, code);
        let axis = self.is_x.select(code(0), self.is_y.select(code(2), code(4)));
        let sign = longest.simd_lt(W::splat(simd, 0.0)).select(code(1), code(0));
        castable.select(axis | sign, code(NO_CLASS))
    }
}

/// Which rays can hit anything at all.
#[inline(always)]
pub fn is_castable<S: Simd>(simd: S, o: [W<S>; 3], d: [W<S>; 3], end: W<S>) -> WideMask<S> {
    let (zero, inf) = (W::splat(simd, 0.0), W::splat(simd, f32::INFINITY));
    dot(d, d).simd_gt(zero)
        & dot(d, d).simd_lt(inf)
        & (abs(o[0]) + abs(o[1]) + abs(o[2])).simd_lt(inf)
        & end.simd_gt(zero)
}
