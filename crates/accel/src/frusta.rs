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

use crate::bundle::{Bundle, GROUPS, RAYS};
use crate::lanes::{F, Floats, LANES, M, TURN, W, WIDE, abs, greater, lesser, splat3};
use crate::rays::Question;
use crate::slab::{BoxLanes, enter};
use fearless_simd::prelude::*;
use reflet_pack::Aabb;

/// How much wider a frustum is than the slopes of its rays.
const SLACK: f32 = 1.0 / 32_768.0;

/// What the product of a way and a reciprocal may lose by underflow.
const UNDERFLOW: f32 = 1e-30;

/// Where a frustum narrows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum Apex {
    /// At the rays' origins; t bounds it.
    #[default]
    Origins,
    /// At their common end; its way from there bounds it.
    Ends,
}

/// One frustum as numbers, or several as lanes.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
struct Frustum<T> {
    /// The least and greatest slope of the two lesser axes.
    slope: [[T; 2]; 2],
    /// The box of apices, longest axis third.
    lo: [T; 3],
    hi: [T; 3],
    /// The least 1 / |direction| along the longest axis.
    inv: T,
    /// The greatest t, or way along the longest axis.
    end: T,
    /// How far rays may stray from the frustum.
    margin: T,
}

/// Of two groups the frusta, each as often as a block has primitives.
type Pair = Frustum<[f32; WIDE]>;

/// The frusta of a bundle.
#[derive(Clone, Default)]
pub(crate) struct Frusta {
    whole: Frustum<f32>,
    pairs: [Pair; GROUPS / 2],
    /// Where each group ends.
    ends: [f32; GROUPS],
    /// The sign of the longest axis, seen from the apex.
    sign: f32,
    apex: Apex,
}

impl<T> Frustum<T> {
    /// The same of another kind.
    #[inline(always)]
    fn each<U>(&self, to: impl Fn(&T) -> U) -> Frustum<U> {
        Frustum {
            slope: [
                [to(&self.slope[0][0]), to(&self.slope[0][1])],
                [to(&self.slope[1][0]), to(&self.slope[1][1])],
            ],
            lo: [to(&self.lo[0]), to(&self.lo[1]), to(&self.lo[2])],
            hi: [to(&self.hi[0]), to(&self.hi[1]), to(&self.hi[2])],
            inv: to(&self.inv),
            end: to(&self.end),
            margin: to(&self.margin),
        }
    }
}

/// Writes the frustum of one of two groups.
#[inline(always)]
fn put(pair: &mut Pair, second: usize, one: &Frustum<f32>) {
    let lanes = second % 2 * LANES..(second % 2 + 1) * LANES;
    let fill = |to: &mut [f32; WIDE], x: f32| to[lanes.clone()].fill(x);
    for k in 0..2 {
        fill(&mut pair.slope[k][0], one.slope[k][0]);
        fill(&mut pair.slope[k][1], one.slope[k][1]);
    }
    for k in 0..3 {
        fill(&mut pair.lo[k], one.lo[k]);
        fill(&mut pair.hi[k], one.hi[k]);
    }
    fill(&mut pair.inv, one.inv);
    fill(&mut pair.end, one.end);
    fill(&mut pair.margin, one.margin);
}

/// Where the frusta enter boxes at the earliest (at least 0), and whether rays in them may hit what
/// is inside. Boxes have the longest axis third.
#[inline(always)]
fn meet<S: Simd, V: Floats<S>>(
    simd: S,
    f: &Frustum<V>,
    sign: f32,
    b: &BoxLanes<V>,
) -> (V, V::Mask) {
    let zero = V::splat(simd, 0.0);
    // Along the longest axis: the least and greatest way from the apices.
    let (first, last) = if sign > 0.0 {
        (b.lo[2] - f.hi[2], b.hi[2] - f.lo[2])
    } else {
        (f.lo[2] - b.hi[2], f.hi[2] - b.lo[2])
    };
    let entry = greater(simd, first * f.inv, zero);
    let mut out = entry.simd_gt(f.end) | last.simd_lt(zero - f.margin);
    for k in 0..2 {
        let above = b.lo[k] - f.hi[k];
        let below = b.hi[k] - f.lo[k];
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
        let forward = if class & 1 == 0 { 1.0 } else { -1.0 };
        self.frusta.sign = forward;
        self.frusta.apex = Apex::Origins;
        let shared = if question == Question::Any { self.bound_ends(simd) } else { None };
        let one_eye = self.has_one_origin(simd);
        let mut whole = Frustum {
            slope: [[f32::INFINITY, f32::NEG_INFINITY]; 2],
            lo: [f32::INFINITY; 3],
            hi: [f32::NEG_INFINITY; 3],
            inv: f32::INFINITY,
            end: -1.0,
            margin: UNDERFLOW,
        };
        // Groups that are not there are met by nothing.
        self.frusta.ends = [-1.0; GROUPS];
        for g in 0..GROUPS {
            let mut one = whole;
            (one.end, one.margin) = (-1.0, UNDERFLOW);
            if g < self.groups() {
                one = match &shared {
                    Some(ends) => self.frustum_of_ends(simd, g, ends),
                    None => self.frustum_of_origins(simd, g, forward, one_eye),
                };
                for k in 0..2 {
                    whole.slope[k][0] = whole.slope[k][0].min(one.slope[k][0]);
                    whole.slope[k][1] = whole.slope[k][1].max(one.slope[k][1]);
                }
                for k in 0..3 {
                    whole.lo[k] = whole.lo[k].min(one.lo[k]);
                    whole.hi[k] = whole.hi[k].max(one.hi[k]);
                }
                whole.inv = whole.inv.min(one.inv);
                whole.end = whole.end.max(one.end);
                whole.margin = one.margin;
            }
            self.frusta.ends[g] = one.end;
            put(&mut self.frusta.pairs[g / 2], g % 2, &one);
        }
        self.frusta.whole = whole;
        if shared.is_some() {
            // Seen from the ends, rays run backward.
            self.frusta.sign = -forward;
            self.frusta.apex = Apex::Ends;
        }
    }

    /// Sixteen rows of a column, those of a group.
    #[inline(always)]
    fn column<'a>(&self, c: &'a [f32], g: usize) -> &'a [f32] {
        &c[g % GROUPS * WIDE..(g % GROUPS + 1) * WIDE]
    }

    /// Whether all rays start at one place.
    #[inline(always)]
    fn has_one_origin<S: Simd>(&self, simd: S) -> bool {
        let mut same = true;
        for o in &self.o {
            let first = W::splat(simd, o[0]);
            for g in 0..self.groups() {
                let at = W::from_slice(simd, self.column(o, g));
                same &= at.simd_eq(first).all_true();
            }
        }
        same
    }

    /// The frustum of a group from where its rays start.
    #[inline(always)]
    fn frustum_of_origins<S: Simd>(
        &self,
        simd: S,
        g: usize,
        forward: f32,
        one_eye: bool,
    ) -> Frustum<f32> {
        let (turn, sign) = (self.turn, W::splat(simd, forward));
        let at = |c: &[f32]| W::from_slice(simd, self.column(c, g));
        let mut one = Frustum { margin: UNDERFLOW, ..Frustum::default() };
        for (k, axis) in turn.into_iter().enumerate() {
            let o = &self.o[axis];
            if one_eye {
                (one.lo[k], one.hi[k]) = (o[0], o[0]);
            } else {
                (one.lo[k], one.hi[k]) = (at(o).reduce_min(), at(o).reduce_max());
            }
        }
        for k in 0..2 {
            let slope = at(&self.shear[k]) * sign;
            one.slope[k] = [slope.reduce_min() - SLACK, slope.reduce_max() + SLACK];
        }
        one.inv = (at(&self.shear[2]) * sign).reduce_min();
        one.end = at(&self.t).reduce_max();
        one
    }

    /// The frustum of a group from where its rays end.
    #[inline(always)]
    fn frustum_of_ends<S: Simd>(&self, simd: S, g: usize, ends: &Ends) -> Frustum<f32> {
        let turn = self.turn;
        let from_end = |k: usize| {
            let o = W::from_slice(simd, self.column(&self.o[turn[k]], g));
            o - W::splat(simd, ends.apex[k])
        };
        let way = abs(from_end(2));
        let mut one = Frustum {
            lo: ends.apex,
            hi: ends.apex,
            inv: 1.0,
            margin: 4.0 * ends.stray + UNDERFLOW,
            end: way.reduce_max() * (1.0 + SLACK) + 4.0 * ends.stray,
            ..Frustum::default()
        };
        for k in 0..2 {
            let slope = from_end(k) / way;
            one.slope[k] = [slope.reduce_min() - SLACK, slope.reduce_max() + SLACK];
        }
        one
    }

    /// Where all rays end, if that is one place.
    #[inline(always)]
    fn bound_ends<S: Simd>(&self, simd: S) -> Option<Ends> {
        let turn = self.turn;
        let end = |i: usize, k: usize| self.o[turn[k]][i] + self.t[i] * self.d[turn[k]][i];
        let apex = [end(0, 0), end(0, 1), end(0, 2)];
        let zero = W::splat(simd, 0.0);
        let (mut stray, mut size, mut shortest) = (zero, zero, W::splat(simd, f32::INFINITY));
        let mut finite = true;
        for g in 0..self.groups() {
            let t = W::from_slice(simd, self.column(&self.t, g));
            finite &= t.simd_lt(W::splat(simd, f32::INFINITY)).all_true();
            shortest = lesser(simd, t, shortest);
            let mut sum = t;
            for k in 0..3 {
                let o = W::from_slice(simd, self.column(&self.o[turn[k]], g));
                let d = W::from_slice(simd, self.column(&self.d[turn[k]], g));
                stray = greater(simd, abs(o + t * d - W::splat(simd, apex[k])), stray);
                sum += abs(o);
            }
            size = greater(simd, sum, size);
        }
        let stray = stray.reduce_max() + size.reduce_max() * (1.0 / 262_144.0);
        // So much nearer to each other than to any origin that all rays run the same way.
        (finite && stray < shortest.reduce_min() * (1.0 / 64.0)).then_some(Ends { apex, stray })
    }

    /// Which of eight boxes, the longest axis third, the bundle may hit before its ends, and where
    /// at the earliest.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, b: &BoxLanes<F<S>>) -> (F<S>, M<S>) {
        let whole = self.frusta.whole.each(
            #[inline(always)]
            |x| F::splat(simd, *x),
        );
        meet(simd, &whole, self.frusta.sign, b)
    }

    /// Which groups may hit which of eight such boxes before their ends: eight bits a group, the
    /// first lowest.
    #[inline(always)]
    pub fn meet_by_group<S: Simd>(&self, simd: S, b: &BoxLanes<F<S>>) -> u32 {
        let twice = |x: F<S>| x.combine(x);
        let b = BoxLanes {
            lo: [twice(b.lo[0]), twice(b.lo[1]), twice(b.lo[2])],
            hi: [twice(b.hi[0]), twice(b.hi[1]), twice(b.hi[2])],
        };
        let mut met = 0;
        for (i, pair) in self.frusta.pairs[..self.groups().div_ceil(2)].iter().enumerate() {
            let pair = pair.each(
                #[inline(always)]
                |x| W::from_slice(simd, x),
            );
            let (_, meets) = meet(simd, &pair, self.frusta.sign, &b);
            met |= (meets.to_bitmask() as u32) << (WIDE * i);
        }
        met
    }

    /// Which rays may hit what is in a box before their ends, of those groups that have a bit in what
    /// [`Bundle::meet_by_group`] gave.
    #[inline(always)]
    pub fn meet_one<S: Simd>(&self, simd: S, met: u32, b: &Aabb) -> u64 {
        let b = BoxLanes { lo: splat3(simd, b.lo), hi: splat3(simd, b.hi) };
        let mut rays = 0;
        for g in 0..GROUPS {
            if met >> (LANES * g) & ((1 << LANES) - 1) != 0 {
                let (entry, passes) = enter(simd, &self.lanes(simd, g), &b);
                let t = W::from_slice(simd, self.column(&self.t, g));
                let meets = passes & entry.simd_le(t);
                rays |= meets.to_bitmask() << (WIDE * g);
            }
        }
        // The rest is the last ray once more.
        rays & (u64::MAX >> (RAYS - self.len))
    }

    /// Where the bundle ends, in the measure of the entries that [`Bundle::meet`] gives.
    #[inline(always)]
    pub fn end(&self) -> f32 {
        self.frusta.whole.end
    }

    /// Says that the rays of a group have a new t.
    #[inline(always)]
    pub fn shorten<S: Simd>(&mut self, group: usize, t: W<S>) {
        let (longest, f) = (t.reduce_max(), &mut self.frusta);
        let group = group % GROUPS;
        f.ends[group] = match f.apex {
            Apex::Origins => longest,
            Apex::Ends if longest < 0.0 => -1.0,
            Apex::Ends => return,
        };
        let lanes = group % 2 * LANES..(group % 2 + 1) * LANES;
        f.pairs[group / 2].end[lanes].fill(f.ends[group]);
        f.whole.end = f.ends[0].max(f.ends[1]).max(f.ends[2].max(f.ends[3]));
    }

    /// How far the slopes spread, and how far the origins.
    pub fn spread(&self) -> (f32, f32) {
        let w = &self.frusta.whole;
        let slopes = (0..2).map(|k| w.slope[k][1] - w.slope[k][0]).sum();
        (slopes, (0..3).map(|k| w.hi[k] - w.lo[k]).sum())
    }
}

/// Where rays end: one place, and how far at most they stray from it.
struct Ends {
    apex: [f32; 3],
    stray: f32,
}
