//! The kernel of solids in lanes: what [`crate::solid::hit`] says of one ray and one solid, operation
//! by operation, of four at once.

use crate::lanes::LANES;
use crate::solid::CLOSE;
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, f64x4, mask64x4};
use reflet_pack::{Form, Solid};

/// How many pairs of a ray and a solid are solved at once.
pub const HALF: usize = LANES / 2;
/// `f64` lanes.
type D<S> = f64x4<S>;
/// Yes or no, a lane each.
type Y<S> = mask64x4<S>;
/// x, y, z in lanes.
type D3<S> = [D<S>; 3];

/// Rays, a lane each, and what is asked of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked {
    /// Origins.
    pub o: [[f32; HALF]; 3],
    /// Directions.
    pub d: [[f32; HALF]; 3],
    /// Where the rays begin.
    pub start: [f32; HALF],
    /// One of [`NOTHING`], [`A_ROOT`] and [`ANOTHER_ROOT`].
    pub what: [f32; HALF],
}

/// The lane is not in use.
pub const NOTHING: f32 = 0.0;
/// The nearest root.
pub const A_ROOT: f32 = 1.0;
/// The same for a ray that leaves this solid.
pub const ANOTHER_ROOT: f32 = 2.0;

/// Which solids are asked.
#[derive(Clone, Copy, Debug)]
pub enum Rows<'a> {
    /// One by all rays.
    One(&'a Solid),
    /// One by each.
    Each([&'a Solid; HALF]),
}

/// What is found, a lane each.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The distance; a NaN where there is none.
    pub t: [f32; HALF],
    /// 1 where the ray runs outward there, else 0.
    pub outward: [f32; HALF],
}

const DISC: f64 = 0.0;
const REVOLVED: f64 = 1.0;
const TORUS: f64 = 2.0;

/// Solids in lanes.
#[derive(Clone, Copy)]
struct SolidLanes<S: Simd> {
    /// The ways into their own coordinates: rows of 3x4 matrices.
    local: [[D<S>; 4]; 3],
    /// Of what is revolved a, b, c and the ends of z; of a torus its radii.
    form: [D<S>; 5],
    /// One of [`DISC`], [`REVOLVED`] and [`TORUS`].
    kind: D<S>,
}

/// The form's numbers, and which it is.
#[inline(always)]
fn numbers(form: &Form) -> ([f64; 5], f64) {
    match *form {
        Form::Disc => ([0.0; 5], DISC),
        Form::Revolved { profile: [a, b, c], z: [low, high] } => ([a, b, c, low, high], REVOLVED),
        Form::Torus { major, minor } => ([major, minor, 0.0, 0.0, 0.0], TORUS),
    }
}

#[inline(always)]
fn one<S: Simd>(simd: S, solid: &Solid) -> SolidLanes<S> {
    let zero = D::splat(simd, 0.0);
    let (form, kind) = numbers(&solid.form);
    let kind = D::splat(simd, kind);
    let mut lanes = SolidLanes { local: [[zero; 4]; 3], form: [zero; 5], kind };
    for i in 0..3 {
        for k in 0..4 {
            lanes.local[i][k] = D::splat(simd, solid.local[i][k]);
        }
    }
    for (to, x) in lanes.form.iter_mut().zip(form) {
        *to = D::splat(simd, x);
    }
    lanes
}

#[inline(always)]
fn four<S: Simd>(simd: S, a: f64, b: f64, c: f64, d: f64) -> D<S> {
    D::from_slice(simd, &[a, b, c, d])
}

#[inline(always)]
fn each<S: Simd>(simd: S, [a, b, c, d]: [&Solid; HALF]) -> SolidLanes<S> {
    let zero = D::splat(simd, 0.0);
    let [(fa, ka), (fb, kb)] = [numbers(&a.form), numbers(&b.form)];
    let [(fc, kc), (fd, kd)] = [numbers(&c.form), numbers(&d.form)];
    let kind = four(simd, ka, kb, kc, kd);
    let mut lanes = SolidLanes { local: [[zero; 4]; 3], form: [zero; 5], kind };
    for i in 0..3 {
        for k in 0..4 {
            let [a, b, c, d] = [a.local[i][k], b.local[i][k], c.local[i][k], d.local[i][k]];
            lanes.local[i][k] = four(simd, a, b, c, d);
        }
    }
    for k in 0..5 {
        lanes.form[k] = four(simd, fa[k], fb[k], fc[k], fd[k]);
    }
    lanes
}

/// Four rays against four solids, lane by lane.
///
/// A function of its own on each level, since it is long and asked for in many places.
#[inline(never)]
pub fn hit<S: Simd>(simd: S, rows: &Rows<'_>, asked: &Asked) -> Found {
    simd.vectorize(
        #[inline(always)]
        || {
            let solids = match rows {
                Rows::One(solid) => one(simd, solid),
                Rows::Each(solids) => each(simd, *solids),
            };
            let rays = AskedLanes {
                o: [wide(simd, &asked.o[0]), wide(simd, &asked.o[1]), wide(simd, &asked.o[2])],
                d: [wide(simd, &asked.d[0]), wide(simd, &asked.d[1]), wide(simd, &asked.d[2])],
                start: wide(simd, &asked.start),
                what: wide(simd, &asked.what),
            };
            let Best { t, outward } = solve(simd, &solids, &rays);
            let narrow = simd.narrow_f64x4(t, outward);
            let [mut t, mut outward] = [[0.0; HALF]; 2];
            t.copy_from_slice(&narrow.as_slice()[..HALF]);
            outward.copy_from_slice(&narrow.as_slice()[HALF..]);
            Found { t, outward }
        },
    )
}

#[inline(always)]
fn wide<S: Simd>(simd: S, x: &[f32; HALF]) -> D<S> {
    let [a, b, c, d] = *x;
    simd.widen_f32x8(f32x8::from_slice(simd, &[a, b, c, d, a, b, c, d])).0
}

/// [`Asked`] in lanes.
struct AskedLanes<S: Simd> {
    o: D3<S>,
    d: D3<S>,
    start: D<S>,
    what: D<S>,
}

/// [`Found`] in lanes; t is a number of `f32`.
struct Best<S: Simd> {
    t: D<S>,
    outward: D<S>,
}

#[inline(always)]
fn solve<S: Simd>(simd: S, solids: &SolidLanes<S>, asked: &AskedLanes<S>) -> Best<S> {
    let zero = D::splat(simd, 0.0);
    let p = asked.o;
    let m = &solids.local;
    let o = [
        m[0][0] * p[0] + m[0][1] * p[1] + m[0][2] * p[2] + m[0][3],
        m[1][0] * p[0] + m[1][1] * p[1] + m[1][2] * p[2] + m[1][3],
        m[2][0] * p[0] + m[2][1] * p[1] + m[2][2] * p[2] + m[2][3],
    ];
    let v = asked.d;
    let d = [
        m[0][0] * v[0] + m[0][1] * v[1] + m[0][2] * v[2],
        m[1][0] * v[0] + m[1][1] * v[1] + m[1][2] * v[2],
        m[2][0] * v[0] + m[2][1] * v[1] + m[2][2] * v[2],
    ];
    let dd = dot(d, d);
    let is = asked.what.simd_gt(zero) & dd.simd_gt(zero) & dd.simd_lt(f64::INFINITY);
    let leaves = asked.what.simd_gt(1.0);
    // From where the ray comes closest to the solid's middle, nothing cancels.
    let shift = leaves.select(zero, -dot(o, d) / dd);
    let near = along(o, shift, d);
    let ray = Local { o: near, d, dd, shift, start: asked.start, leaves };
    let mut found = Best { t: D::splat(simd, f64::NAN), outward: zero };
    let discs = is & solids.kind.simd_eq(DISC);
    if discs.any_true() {
        disc(simd, &Local { o, shift: zero, ..ray }, discs, &mut found);
    }
    let revolved_ones = is & solids.kind.simd_eq(REVOLVED);
    if revolved_ones.any_true() {
        revolved(simd, &ray, &solids.form, revolved_ones, &mut found);
    }
    let tori = is & solids.kind.simd_eq(TORUS);
    if tori.any_true() {
        torus(simd, &ray, (solids.form[0], solids.form[1]), tori, &mut found);
    }
    found
}

/// Rays in the solids' own coordinates.
#[derive(Clone, Copy)]
struct Local<S: Simd> {
    /// Where they start, moved by `shift`.
    o: D3<S>,
    d: D3<S>,
    /// The square of the direction's length.
    dd: D<S>,
    shift: D<S>,
    start: D<S>,
    leaves: Y<S>,
}

/// The least root above the rays' start, of those that are offered in ascending order.
struct Search<S: Simd> {
    root: D<S>,
    t: D<S>,
    has: Y<S>,
}

impl<S: Simd> Search<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = D::splat(simd, 0.0);
        Search { root: zero, t: zero, has: zero.simd_gt(zero) }
    }

    #[inline(always)]
    fn offer(&mut self, simd: S, ray: &Local<S>, root: D<S>, is: Y<S>) {
        let t = rounded(simd, root + ray.shift);
        let takes = is & !self.has & t.simd_gt(ray.start);
        self.root = takes.select(root, self.root);
        self.t = takes.select(t, self.t);
        self.has |= takes;
    }

    /// Writes down what was found; `gradient` is that at the root.
    #[inline(always)]
    fn end(self, simd: S, ray: &Local<S>, gradient: D3<S>, found: &mut Best<S>) {
        let (zero, one) = (D::splat(simd, 0.0), D::splat(simd, 1.0));
        let outward = dot(gradient, ray.d).simd_gt(zero).select(one, zero);
        found.t = self.has.select(self.t, found.t);
        found.outward = self.has.select(outward, found.outward);
    }
}

/// To the nearest `f32`.
#[inline(always)]
fn rounded<S: Simd>(simd: S, x: D<S>) -> D<S> {
    let narrow: f32x8<S> = simd.narrow_f64x4(x, x);
    simd.widen_f32x8(narrow).0
}

#[inline(always)]
fn dot<S: Simd>(a: D3<S>, b: D3<S>) -> D<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + s b`.
#[inline(always)]
fn along<S: Simd>(a: D3<S>, s: D<S>, b: D3<S>) -> D3<S> {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

#[inline(always)]
fn splats<S: Simd, const N: usize>(simd: S, numbers: [f64; N]) -> [D<S>; N] {
    let mut lanes = [D::splat(simd, 0.0); N];
    for (to, x) in lanes.iter_mut().zip(numbers) {
        *to = D::splat(simd, x);
    }
    lanes
}

#[inline(always)]
fn disc<S: Simd>(simd: S, ray: &Local<S>, is: Y<S>, found: &mut Best<S>) {
    let (zero, one) = (D::splat(simd, 0.0), D::splat(simd, 1.0));
    let t = -ray.o[2] / ray.d[2];
    let p = along(ray.o, t, ray.d);
    let inside = (p[0] * p[0] + p[1] * p[1]).simd_le(one);
    let mut search = Search::new(simd);
    search.offer(simd, ray, t, is & !ray.leaves & inside);
    search.end(simd, ray, [zero, zero, one], found);
}

#[inline(always)]
fn revolved<S: Simd>(
    simd: S,
    ray: &Local<S>,
    &[a, b, c, low, high]: &[D<S>; 5],
    is: Y<S>,
    found: &mut Best<S>,
) {
    let (zero, half_of) = (D::splat(simd, 0.0), D::splat(simd, 0.5));
    let (o, d, leaves) = (ray.o, ray.d, ray.leaves);
    let square = d[0] * d[0] + d[1] * d[1] - c * d[2] * d[2];
    let half = o[0] * d[0] + o[1] * d[1] - (c * o[2] + half_of * b) * d[2];
    let other = D::splat(simd, -2.0) * half / square;
    let constant = o[0] * o[0] + o[1] * o[1] - a - (b + c * o[2]) * o[2];
    let disc = half * half - square * constant;
    let meets = disc.simd_ge(zero);
    let root = disc.sqrt();
    let q = half.simd_lt(zero).select(root - half, -root - half);
    let (first, second) = (q / square, constant / q);
    let ascends = first.simd_lt(second);
    let (near, far) = (ascends.select(first, second), ascends.select(second, first));
    let near = leaves.select(other, near);
    let (at_near, at_far) = (o[2] + near * d[2], o[2] + far * d[2]);
    let mut search = Search::new(simd);
    let ends = at_near.simd_ge(low) & at_near.simd_le(high);
    search.offer(simd, ray, near, is & (leaves | meets) & ends);
    let ends = at_far.simd_ge(low) & at_far.simd_le(high);
    search.offer(simd, ray, far, is & !leaves & meets & ends);
    let p = along(o, search.root, d);
    let gradient = [p[0], p[1], D::splat(simd, -0.5) * b - c * p[2]];
    search.end(simd, ray, gradient, found);
}

#[inline(always)]
fn torus<S: Simd>(
    simd: S,
    ray: &Local<S>,
    (major, minor): (D<S>, D<S>),
    is: Y<S>,
    found: &mut Best<S>,
) {
    let [zero, one, two, quad] = splats(simd, [0.0, 1.0, 2.0, 4.0]);
    let (o, d, dd) = (ray.o, ray.d, ray.dd);
    let reach = major + minor;
    let (od, oo) = (dot(o, d), dot(o, o));
    let middle = -od / dd;
    let half = (reach * reach * D::splat(simd, 1.0 + 1e-9) - (oo - od * od / dd)) / dd;
    let is = is & half.simd_gt(zero);
    if !is.any_true() {
        return;
    }
    let (low, high) = (middle - half.sqrt(), middle + half.sqrt());
    let g = oo + major * major - minor * minor;
    let across = quad * major * major;
    let flat_oo = o[0] * o[0] + o[1] * o[1];
    let flat_od = o[0] * d[0] + o[1] * d[1];
    let flat_dd = d[0] * d[0] + d[1] * d[1];
    let c = [
        g * g - across * flat_oo,
        quad * od * g - two * across * flat_od,
        two * dd * g + quad * od * od - across * flat_dd,
        quad * dd * od,
        dd * dd,
    ];
    let mut search = Search::new(simd);
    let (others, leaving) = (is & !ray.leaves, is & ray.leaves);
    if others.any_true() {
        let (roots, are) = find_roots::<S, 5>(simd, c, (low, high), others);
        search.offer(simd, ray, roots[0], are[0]);
        search.offer(simd, ray, roots[1], are[1]);
        search.offer(simd, ray, roots[2], are[2]);
        search.offer(simd, ray, roots[3], are[3]);
    }
    if leaving.any_true() {
        let (roots, are) = find_roots::<S, 4>(simd, [c[1], c[2], c[3], c[4]], (low, high), leaving);
        search.offer(simd, ray, roots[0], are[0]);
        search.offer(simd, ray, roots[1], are[1]);
        search.offer(simd, ray, roots[2], are[2]);
    }
    let p = along(o, search.root, d);
    let ring = (p[0] * p[0] + p[1] * p[1]).sqrt();
    let inward = one - major / ring;
    search.end(simd, ray, [p[0] * inward, p[1] * inward, p[2]], found);
}

/// Roots in ascending order, each with the lanes that have it.
type Roots<S> = ([D<S>; 4], [Y<S>; 4]);

/// The roots of polynomials with `N` coefficients. Each place between two turns may hold one: it
/// stays empty in the lanes that have none there.
#[inline(always)]
fn find_roots<S: Simd, const N: usize>(
    simd: S,
    p: [D<S>; N],
    (low, high): (D<S>, D<S>),
    is: Y<S>,
) -> Roots<S> {
    let zero = D::splat(simd, 0.0);
    let none = zero.simd_gt(zero);
    // The polynomial and its derivatives down to a line.
    let mut chain = [[zero; N]; 4];
    chain[0] = p;
    for k in 1..N - 1 {
        for i in 0..N - k {
            chain[k][i] = D::splat(simd, (i + 1) as f64) * chain[k - 1][i + 1];
        }
    }
    let line = &chain[N - 2];
    let t = -line[0] / line[1];
    let mut roots = [t, zero, zero, zero];
    let mut are = [is & t.simd_ge(low) & t.simd_le(high), none, none, none];
    for k in (0..N - 2).rev() {
        let p = &chain[k][..N - k];
        let turns = N - 2 - k;
        let (mut next_roots, mut next_are) = ([zero; 4], [none; 4]);
        let (mut from, mut value) = (low, evaluate(simd, p, low));
        for i in 0..=turns {
            let (to, has) = if i < turns { (roots[i], are[i]) } else { (high, is) };
            if !has.any_true() {
                continue;
            }
            let at_to = evaluate(simd, p, to);
            let crosses = has & (value.simd_lt(zero) ^ at_to.simd_lt(zero));
            if crosses.any_true() {
                next_roots[i] = between(simd, p, (from, value), to, crosses);
                next_are[i] = crosses;
            }
            from = has.select(to, from);
            value = has.select(at_to, value);
        }
        (roots, are) = (next_roots, next_are);
    }
    (roots, are)
}

#[inline(always)]
fn evaluate<S: Simd>(simd: S, p: &[D<S>], t: D<S>) -> D<S> {
    let mut sum = D::splat(simd, 0.0);
    for c in p.iter().rev() {
        sum = sum * t + *c;
    }
    sum
}

/// Newton's method with halvings, until the last lane stands still.
#[inline(always)]
fn between<S: Simd>(
    simd: S,
    p: &[D<S>],
    (mut low, at_low): (D<S>, D<S>),
    mut high: D<S>,
    is: Y<S>,
) -> D<S> {
    let (zero, half) = (D::splat(simd, 0.0), D::splat(simd, 0.5));
    let falls = !at_low.simd_lt(zero);
    let close = D::splat(simd, CLOSE) * (low.abs() + high.abs());
    let mut moves = is;
    let mut t = half * (low + high);
    for _ in 0..64 {
        let (mut value, mut slope) = (zero, zero);
        for c in p.iter().rev() {
            slope = slope * t + value;
            value = value * t + *c;
        }
        // Of the same sign as at the low end.
        let below = value.simd_lt(zero) ^ falls;
        low = below.select(t, low);
        high = below.select(high, t);
        let step = t - value / slope;
        let ends = (step - t).abs().simd_le(close);
        let inside = ends | (step.simd_gt(low) & step.simd_lt(high));
        t = moves.select(inside.select(step, half * (low + high)), t);
        moves &= !ends;
        if !moves.any_true() {
            break;
        }
    }
    t
}
