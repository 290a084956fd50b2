//! Up to 64 rays that have the sign and place of their longest axis in common, and the frusta that
//! hold them.
//!
//! With W the way along the longest axis, each ray stays within u = s W: the frustum of a bundle is
//! an interval of such slopes for each of the two other axes, from a box of origins. A box beside
//! that, behind it or beyond the ends of all rays is hit by none of them. (Reshetov, Soupikov and
//! Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005, cull so for rays of one origin.)
//! Shadow rays that end at one light are culled from their ends, where their frustum is narrow.
//!
//! A frustum is only ever left out of where the definition has no hit. A ray that passes a box by
//! the slab test comes as near to it, in exact arithmetic, as 2^-19 of the way to it: that, and the
//! rounding here, is what `SLACK` and the margin cover.

use crate::tree::Node;
use crate::lanes::{F, LANES, M, RayLanes, TURN, U, abs, dot, greater, lesser, rows3};
use crate::rays::{HitCode, Question, Rays};
use crate::slab::BoxLanes;
use fearless_simd::prelude::*;

/// The most rays of a bundle.
pub const RAYS: usize = LANES * LANES;

/// How much wider a frustum is than the slopes of its rays.
const SLACK: f32 = 1.0 / 32_768.0;

/// What the product of a way and a reciprocal may lose by underflow.
const UNDERFLOW: f32 = 1e-30;

/// Rays of one longest axis, in groups of [`LANES`].
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Bundle {
    o: [[f32; RAYS]; 3],
    d: [[f32; RAYS]; 3],
    inv: [[f32; RAYS]; 3],
    shear: [[f32; RAYS]; 3],
    start: [f32; RAYS],
    last: [u32; RAYS],
    /// The best t so far; negative for a ray that is done with, or none.
    pub t: [f32; RAYS],
    /// What was hit there.
    pub code: [u32; RAYS],
    /// Of which class each is.
    class: [u32; RAYS],
    /// How many rays.
    pub len: usize,
    turn: [usize; 3],
    /// The sign of the longest axis.
    sign: f32,
    /// The frustum of each group.
    groups: Columns,
    /// The frustum of all.
    whole: Columns,
    /// Whether the frustum's apex is where rays end.
    apex: Apex,
}

/// Where a frustum narrows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Apex {
    /// At the rays' origins; t bounds it.
    Origins,
    /// At their common end; its way from there bounds it.
    Ends,
}

/// Frusta in lanes, as memory.
#[derive(Clone, Default)]
#[repr(C, align(32))]
struct Columns {
    /// The least and greatest slope of the two lesser axes.
    slope: [[[f32; LANES]; 2]; 2],
    /// The box of apices, longest axis third.
    lo: [[f32; LANES]; 3],
    hi: [[f32; LANES]; 3],
    /// The least 1 / |direction| along the longest axis.
    inv: [f32; LANES],
    /// The greatest t, or way along the longest axis.
    end: [f32; LANES],
    /// How far rays may stray from the frustum.
    margin: [f32; LANES],
}

/// Frusta in lanes, or one in all lanes.
#[derive(Clone, Copy)]
struct Frusta<S: Simd> {
    slope: [[F<S>; 2]; 2],
    lo: [F<S>; 3],
    hi: [F<S>; 3],
    inv: F<S>,
    end: F<S>,
    margin: F<S>,
}

impl Columns {
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> Frusta<S> {
        let at = |c: &[f32; LANES]| F::from_slice(simd, c);
        Frusta {
            slope: [
                [at(&self.slope[0][0]), at(&self.slope[0][1])],
                [at(&self.slope[1][0]), at(&self.slope[1][1])],
            ],
            lo: [at(&self.lo[0]), at(&self.lo[1]), at(&self.lo[2])],
            hi: [at(&self.hi[0]), at(&self.hi[1]), at(&self.hi[2])],
            inv: at(&self.inv),
            end: at(&self.end),
            margin: at(&self.margin),
        }
    }
}

/// Where the frusta enter boxes at the earliest (at least 0), and whether rays in them may hit what
/// is inside. `lo` and `hi` have the longest axis third.
#[inline(always)]
fn meet<S: Simd>(simd: S, f: &Frusta<S>, sign: f32, lo: [F<S>; 3], hi: [F<S>; 3]) -> (F<S>, M<S>) {
    let zero = F::splat(simd, 0.0);
    // Along the longest axis: the least and greatest way from the apices.
    let (first, last) = if sign > 0.0 {
        (lo[2] - f.hi[2], hi[2] - f.lo[2])
    } else {
        (f.lo[2] - hi[2], f.hi[2] - lo[2])
    };
    let entry = greater(simd, first * f.inv, zero);
    let mut out = entry.simd_gt(f.end) | last.simd_lt(zero - f.margin);
    for k in 0..2 {
        let above = lo[k] - f.hi[k];
        let below = hi[k] - f.lo[k];
        let [least, most] = f.slope[k];
        let top = greater(simd, most * first, most * last);
        let bottom = lesser(simd, least * first, least * last);
        // A NaN (0 times infinity) leaves nothing out.
        out |= (above - top).simd_gt(f.margin) | (bottom - below).simd_gt(f.margin);
    }
    (entry, !out)
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
            len: 0,
            turn: TURN[2],
            sign: 1.0,
            groups: Columns::default(),
            whole: Columns::default(),
            apex: Apex::Origins,
        }
    }

    /// Takes the rows of `rays` from `first` on, as many as there are and have room. Gives the class
    /// of all, if they fill the bundle and have one in common.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, rays: &Rays, first: usize) -> Option<u32> {
        self.len = RAYS.min(rays.len() - first);
        let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
        let inf = F::splat(simd, f32::INFINITY);
        let none = U::splat(simd, NO_CLASS);
        let mut common = self.len == RAYS;
        for at in (0..self.len).step_by(LANES) {
            let row = first + at;
            let (o, d) = (rows3(simd, &rays.origin, row), rows3(simd, &rays.dir, row));
            let end = F::from_slice(simd, &rays.t_max[row..row + LANES]);
            let inv = [one / d[0], one / d[1], one / d[2]];
            let size = [abs(d[0]), abs(d[1]), abs(d[2])];
            // The longest axis; of equal ones the first.
            let is_x = size[0].simd_ge(size[1]) & size[0].simd_ge(size[2]);
            let is_y = size[1].simd_ge(size[2]);
            let third = is_x.select(d[0], is_y.select(d[1], d[2]));
            let second = is_x.select(d[2], is_y.select(d[0], d[1]));
            let first = is_x.select(d[1], is_y.select(d[2], d[0]));
            let castable = dot(d, d).simd_gt(zero)
                & dot(d, d).simd_lt(inf)
                & (abs(o[0]) + abs(o[1]) + abs(o[2])).simd_lt(inf)
                & end.simd_gt(zero);
            let axis =
                is_x.select(U::splat(simd, 0), is_y.select(U::splat(simd, 2), U::splat(simd, 4)));
            let sign = third.simd_lt(zero).select(U::splat(simd, 1), U::splat(simd, 0));
            let class = castable.select(axis | sign, none);
            let lanes = at..at + LANES;
            class.store_slice(&mut self.class[lanes.clone()]);
            common &= class.simd_eq(U::splat(simd, self.class[0])).all_true();
            for k in 0..3 {
                o[k].store_slice(&mut self.o[k][lanes.clone()]);
                d[k].store_slice(&mut self.d[k][lanes.clone()]);
                inv[k].store_slice(&mut self.inv[k][lanes.clone()]);
            }
            (first / third).store_slice(&mut self.shear[0][lanes.clone()]);
            (second / third).store_slice(&mut self.shear[1][lanes.clone()]);
            (one / third).store_slice(&mut self.shear[2][lanes.clone()]);
            F::from_slice(simd, &rays.t_min[row..row + LANES])
                .store_slice(&mut self.start[lanes.clone()]);
            end.store_slice(&mut self.t[lanes.clone()]);
            U::splat(simd, HitCode::NONE.0).store_slice(&mut self.code[lanes.clone()]);
            for (last, code) in self.last[lanes].iter_mut().zip(&rays.last[row..row + LANES]) {
                *last = code.0;
            }
        }
        (common && self.class[0] != NO_CLASS).then_some(self.class[0])
    }

    /// Takes some of another bundle's rays.
    pub fn select(&mut self, from: &Bundle, slots: &[u8]) {
        self.len = slots.len();
        let padded = self.len.next_multiple_of(LANES);
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

    /// One ray in all lanes.
    #[inline(always)]
    pub fn splat<S: Simd>(&self, simd: S, slot: usize) -> RayLanes<S> {
        let slot = slot % RAYS;
        let at = |c: &[f32; RAYS]| F::splat(simd, c[slot]);
        RayLanes {
            o: [at(&self.o[0]), at(&self.o[1]), at(&self.o[2])],
            d: [at(&self.d[0]), at(&self.d[1]), at(&self.d[2])],
            start: at(&self.start),
            inv: [at(&self.inv[0]), at(&self.inv[1]), at(&self.inv[2])],
            last: U::splat(simd, self.last[slot]),
            turn: TURN[(self.class[slot] >> 1) as usize % 3],
            shear: [at(&self.shear[0]), at(&self.shear[1]), at(&self.shear[2])],
        }
    }

    /// What the box test needs of one ray, in all lanes: origin and 1 / direction.
    #[inline(always)]
    pub fn slabs<S: Simd>(&self, simd: S, slot: usize) -> ([F<S>; 3], [F<S>; 3]) {
        let at = |c: &[f32; RAYS]| F::splat(simd, c[slot % RAYS]);
        (
            [at(&self.o[0]), at(&self.o[1]), at(&self.o[2])],
            [at(&self.inv[0]), at(&self.inv[1]), at(&self.inv[2])],
        )
    }

    /// The rows of a node that hold the faces which a ray meets first.
    #[inline(always)]
    pub fn near(&self, slot: usize) -> [usize; 3] {
        let row = |k: usize| k + Node::HI * usize::from(self.inv[k][slot] < 0.0);
        [row(0), row(1), row(2)]
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

    /// Whether all rays of the sample start far from the first: nothing holds such rays together.
    #[inline(always)]
    pub fn is_strewn(&self, apart: f32) -> bool {
        let mut strewn = self.len > LANES;
        for j in self.samples() {
            strewn &= self.between(j).0 > apart;
        }
        strewn
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
        self.len.div_ceil(LANES)
    }

    /// Finds the frusta; all rays are of one class.
    #[inline(never)]
    pub fn bound<S: Simd>(&mut self, simd: S, question: Question) {
        simd.vectorize(
            #[inline(always)]
            || self.find_frusta(simd, question),
        );
    }

    #[inline(always)]
    fn find_frusta<S: Simd>(&mut self, simd: S, question: Question) {
        let class = self.class[0];
        self.turn = TURN[(class >> 1) as usize % 3];
        self.sign = if class & 1 == 0 { 1.0 } else { -1.0 };
        self.apex = Apex::Origins;
        let turn = self.turn;
        let inf = F::splat(simd, f32::INFINITY);
        let sign = F::splat(simd, self.sign);
        // Groups that are not there are met by nothing.
        self.groups.end.fill(-1.0);
        self.groups.margin.fill(UNDERFLOW);
        let shared = question == Question::Any && self.bound_ends(simd);
        let mut whole = [[inf; 6], [F::splat(simd, f32::NEG_INFINITY); 6]];
        for g in 0..self.groups() {
            let at = g * LANES..(g + 1) * LANES;
            let (o0, o1, o2, s0, s1, inv) = if shared {
                (
                    F::from_slice(simd, &self.groups.lo[0]),
                    F::from_slice(simd, &self.groups.lo[1]),
                    F::from_slice(simd, &self.groups.lo[2]),
                    self.end_slope(simd, 0, g),
                    self.end_slope(simd, 1, g),
                    F::splat(simd, 1.0),
                )
            } else {
                (
                    F::from_slice(simd, &self.o[turn[0]][at.clone()]),
                    F::from_slice(simd, &self.o[turn[1]][at.clone()]),
                    F::from_slice(simd, &self.o[turn[2]][at.clone()]),
                    F::from_slice(simd, &self.shear[0][at.clone()]) * sign,
                    F::from_slice(simd, &self.shear[1][at.clone()]) * sign,
                    F::from_slice(simd, &self.shear[2][at.clone()]) * sign,
                )
            };
            let all = [o0, o1, o2, s0, s1, inv];
            for k in 0..6 {
                whole[0][k] = lesser(simd, all[k], whole[0][k]);
                whole[1][k] = greater(simd, all[k], whole[1][k]);
            }
            if !shared {
                // Of one eye, which is soon seen, there is one box.
                if g == 0 || !is_one(&whole) {
                    for (k, axis) in all[..3].iter().enumerate() {
                        self.groups.lo[k][g] = least(simd, *axis);
                        self.groups.hi[k][g] = most(simd, *axis);
                    }
                } else {
                    for k in 0..3 {
                        self.groups.lo[k][g] = self.groups.lo[k][0];
                        self.groups.hi[k][g] = self.groups.hi[k][0];
                    }
                }
                self.groups.end[g] = most(simd, F::from_slice(simd, &self.t[at]));
            }
            for k in 0..2 {
                self.groups.slope[k][0][g] = least(simd, all[3 + k]) - SLACK;
                self.groups.slope[k][1][g] = most(simd, all[3 + k]) + SLACK;
            }
            self.groups.inv[g] = least(simd, inv);
        }
        for (k, (lo, hi)) in whole[0].iter().zip(&whole[1]).take(3).enumerate() {
            self.whole.lo[k].fill(least(simd, *lo));
            self.whole.hi[k].fill(most(simd, *hi));
        }
        for k in 0..2 {
            self.whole.slope[k][0].fill(least(simd, whole[0][3 + k]) - SLACK);
            self.whole.slope[k][1].fill(most(simd, whole[1][3 + k]) + SLACK);
        }
        self.whole.inv.fill(least(simd, whole[0][5]));
        self.whole.margin = self.groups.margin;
        self.whole.end.fill(self.groups.end.iter().copied().fold(-1.0, f32::max));
        if shared {
            // Seen from the ends, rays run backward.
            self.sign = -self.sign;
        }
    }

    /// Whether all rays end at one place, and the frusta's apex and margin if so.
    #[inline(always)]
    fn bound_ends<S: Simd>(&mut self, simd: S) -> bool {
        let turn = self.turn;
        let end = |i: usize, k: usize| self.o[turn[k]][i] + self.t[i] * self.d[turn[k]][i];
        let apex = [end(0, 0), end(0, 1), end(0, 2)];
        let zero = F::splat(simd, 0.0);
        let (mut stray, mut size, mut shortest) = (zero, zero, F::splat(simd, f32::INFINITY));
        let mut finite = true;
        for g in (0..self.groups() * LANES).step_by(LANES) {
            let t = F::from_slice(simd, &self.t[g..g + LANES]);
            finite &= t.simd_lt(F::splat(simd, f32::INFINITY)).all_true();
            shortest = lesser(simd, t, shortest);
            let mut sum = t;
            for k in 0..3 {
                let o = F::from_slice(simd, &self.o[turn[k]][g..g + LANES]);
                let d = F::from_slice(simd, &self.d[turn[k]][g..g + LANES]);
                stray = greater(simd, abs(o + t * d - F::splat(simd, apex[k])), stray);
                sum += abs(o);
            }
            size = greater(simd, sum, size);
        }
        let stray = most(simd, stray) + most(simd, size) * (1.0 / 262_144.0);
        // So much nearer to each other than to any origin that all rays run the same way.
        if !(finite && stray < least(simd, shortest) * (1.0 / 64.0)) {
            return false;
        }
        self.apex = Apex::Ends;
        for (k, at) in apex.into_iter().enumerate() {
            self.groups.lo[k].fill(at);
            self.groups.hi[k].fill(at);
        }
        self.groups.margin.fill(4.0 * stray + UNDERFLOW);
        for g in 0..self.groups() {
            let at = g * LANES..(g + 1) * LANES;
            let o = F::from_slice(simd, &self.o[turn[2]][at]);
            let way = abs(o - F::splat(simd, apex[2]));
            self.groups.end[g] = most(simd, way) * (1.0 + SLACK) + 4.0 * stray;
        }
        true
    }

    /// The slopes from the apex to the origins of a group.
    #[inline(always)]
    fn end_slope<S: Simd>(&self, simd: S, k: usize, g: usize) -> F<S> {
        let at = g * LANES..(g + 1) * LANES;
        let (turn, apex) = (self.turn, &self.groups.lo);
        let u = F::from_slice(simd, &self.o[turn[k]][at.clone()]) - F::from_slice(simd, &apex[k]);
        let w = F::from_slice(simd, &self.o[turn[2]][at]) - F::from_slice(simd, &apex[2]);
        u / abs(w)
    }

    /// A group as kernels see it.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, simd: S, group: usize) -> RayLanes<S> {
        let at = group * LANES..(group + 1) * LANES;
        let at = |c: &[f32; RAYS]| F::from_slice(simd, &c[at.clone()]);
        RayLanes {
            o: [at(&self.o[0]), at(&self.o[1]), at(&self.o[2])],
            d: [at(&self.d[0]), at(&self.d[1]), at(&self.d[2])],
            start: at(&self.start),
            inv: [at(&self.inv[0]), at(&self.inv[1]), at(&self.inv[2])],
            last: U::from_slice(simd, &self.last[group * LANES..(group + 1) * LANES]),
            turn: self.turn,
            shear: [at(&self.shear[0]), at(&self.shear[1]), at(&self.shear[2])],
        }
    }

    /// Which of eight boxes the bundle may hit before its ends, and where at the earliest.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, b: &BoxLanes<S>) -> (F<S>, u32) {
        let t = self.turn;
        let (lo, hi) = ([b.lo[t[0]], b.lo[t[1]], b.lo[t[2]]], [b.hi[t[0]], b.hi[t[1]], b.hi[t[2]]]);
        let (entry, meets) = meet(simd, &self.whole.lanes(simd), self.sign, lo, hi);
        (entry, meets.to_bitmask() as u32)
    }

    /// Which groups may hit a box (the same in all lanes) before their ends.
    #[inline(always)]
    pub fn meeting<S: Simd>(&self, simd: S, b: &BoxLanes<S>) -> u32 {
        let t = self.turn;
        let (lo, hi) = ([b.lo[t[0]], b.lo[t[1]], b.lo[t[2]]], [b.hi[t[0]], b.hi[t[1]], b.hi[t[2]]]);
        let (_, meets) = meet(simd, &self.groups.lanes(simd), self.sign, lo, hi);
        meets.to_bitmask() as u32 & ((1 << self.groups()) - 1)
    }

    /// Where the bundle ends, in the measure of the entries that [`Bundle::meet`] gives.
    #[inline(always)]
    pub fn end(&self) -> f32 {
        self.whole.end[0]
    }

    /// Says that the rays of a group have a new t.
    #[inline(always)]
    pub fn shorten<S: Simd>(&mut self, simd: S, group: usize, t: F<S>) {
        let longest = most(simd, t);
        match self.apex {
            Apex::Origins => self.groups.end[group] = longest,
            Apex::Ends if longest < 0.0 => self.groups.end[group] = -1.0,
            Apex::Ends => return,
        }
        let end = most(simd, F::from_slice(simd, &self.groups.end));
        self.whole.end.fill(end);
    }

    /// How far the slopes spread, and how far the origins.
    pub fn spread(&self) -> (f32, f32) {
        let w = &self.whole;
        let slopes = (0..2).map(|k| w.slope[k][1][0] - w.slope[k][0][0]).sum();
        (slopes, (0..3).map(|k| w.hi[k][0] - w.lo[k][0]).sum())
    }
}

impl Default for Bundle {
    fn default() -> Self {
        Bundle::new()
    }
}

/// Whether all origins so far are the same, lane by lane; that of the first group bounds them then.
#[inline(always)]
fn is_one<S: Simd>(whole: &[[F<S>; 6]; 2]) -> bool {
    let same = |k: usize| whole[0][k].simd_eq(whole[1][k]);
    (same(0) & same(1) & same(2)).all_true()
}

/// The least lane.
#[inline(always)]
fn least<S: Simd>(_simd: S, x: F<S>) -> f32 {
    x.reduce_min()
}

/// The greatest lane.
#[inline(always)]
fn most<S: Simd>(_simd: S, x: F<S>) -> f32 {
    x.reduce_max()
}

/// The class of a ray is twice its longest axis, plus 1 if it runs backward along that; this one
/// can hit nothing.
pub const NO_CLASS: u32 = 6;
