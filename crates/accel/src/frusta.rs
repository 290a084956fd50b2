//! The frusta that hold a bundle's rays, of each group and of all, and what they meet.
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

use crate::bundle::Bundle;
use crate::lanes::{F, LANES, M, TURN, abs, greater, lesser};
use crate::rays::Question;
use crate::slab::BoxLanes;
use fearless_simd::prelude::*;

/// How much wider a frustum is than the slopes of its rays.
const SLACK: f32 = 1.0 / 32_768.0;

/// What the product of a way and a reciprocal may lose by underflow.
const UNDERFLOW: f32 = 1e-30;

/// Where a frustum narrows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Apex {
    /// At the rays' origins; t bounds it.
    Origins,
    /// At their common end; its way from there bounds it.
    Ends,
}

/// Frusta in lanes, as memory.
#[derive(Clone, Default)]
#[repr(C, align(32))]
pub(crate) struct Columns {
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
