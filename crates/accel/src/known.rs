//! Rays in lanes, each against the one primitive that it is known to hit: no traversal.

use crate::blocks::Pick;
use crate::kernels::{self, PlaneLanes, QuadLanes, SphereLanes, TriangleLanes};
use crate::lanes::{F, LANES, M, RayLanes, TURN, U, V3, abs, load3, rows3};
use crate::rays::{HitCode, Rays};
use crate::slab::{self, BoxLanes};
use fearless_simd::prelude::*;
use reflet_pack::copies::facing;
use reflet_pack::{Geometry, SHAPE_KINDS, ShapeKind};

type Lane3 = [[f32; LANES]; 3];

/// Finds how far each ray runs to the primitive of its code, with the bits that a search through
/// all primitives would give; infinity where a code is [`HitCode::NONE`]. A ray that does not hit
/// what its code says gets any number.
///
/// # Panics
/// If the columns of `rays`, `codes` or `t` are not padded to whole lanes.
#[inline(always)]
pub fn distances<S: Simd>(simd: S, g: &Geometry, rays: &Rays, codes: &[HitCode], t: &mut [f32]) {
    for first in (0..rays.len()).step_by(LANES) {
        let lanes = first..first + LANES;
        let found = eight(simd, g, (rays, first), &codes[lanes.clone()]);
        found.store_slice(&mut t[lanes]);
    }
}

/// Which lanes hold a primitive of each kind, as 1, and its row there.
struct Kinds {
    of: [[u32; LANES]; SHAPE_KINDS],
    rows: [usize; LANES],
}

#[inline(always)]
fn eight<S: Simd>(simd: S, g: &Geometry, (rays, first): (&Rays, usize), codes: &[HitCode]) -> F<S> {
    let ray = &along(simd, rays, first, 2);
    let mut kinds = Kinds { of: [[0; LANES]; SHAPE_KINDS], rows: [0; LANES] };
    let (mut lo, mut hi): (Lane3, Lane3) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    let mut code = [0; LANES];
    let mut present = [false; SHAPE_KINDS];
    let mut triangles = [[[0.0; 3]; 3]; LANES];
    for (lane, known) in codes.iter().enumerate() {
        let Some(prim) = known.prim() else { continue };
        let (slot, which) = g.slot_of(prim);
        let (mut kind, row) = g.shape[slot.index()];
        let mut bounds = g.bounds[slot.index()];
        match kind {
            ShapeKind::Triangle => triangles[lane] = g.triangles.points(row as usize),
            ShapeKind::Copy => {
                kind = ShapeKind::Triangle;
                triangles[lane] = g.copies[row as usize].triangle(which);
                bounds = facing(triangles[lane]).1;
            }
            _ => {}
        }
        kinds.of[kind as usize][lane] = 1;
        kinds.rows[lane] = row as usize;
        present[kind as usize] = true;
        code[lane] = known.0 & !1;
        for k in 0..3 {
            lo[k][lane] = bounds.lo[k];
            hi[k][lane] = bounds.hi[k];
        }
    }
    let code = U::from_slice(simd, &code);
    let mut t = F::splat(simd, f32::INFINITY);
    if present[ShapeKind::Sphere as usize] {
        let (is, rows) = lanes_of(simd, &kinds, ShapeKind::Sphere);
        let center = gather(simd, &rows, |row| g.spheres.center.get(row));
        let radius = gather(simd, &rows, |row| [g.spheres.radius[row]; 3])[0];
        let hit = kernels::sphere(simd, ray, &SphereLanes { center, radius, code });
        t = is.select(hit.t, t);
    }
    if present[ShapeKind::Plane as usize] {
        let (is, rows) = lanes_of(simd, &kinds, ShapeKind::Plane);
        let point = gather(simd, &rows, |row| g.planes.point.get(row));
        let normal = gather(simd, &rows, |row| g.planes.normal.get(row));
        let hit = kernels::plane(simd, ray, &PlaneLanes { point, normal, code });
        t = is.select(hit.t, t);
    }
    if present[ShapeKind::Quad as usize] || present[ShapeKind::Triangle as usize] {
        // Edge functions turn the longest axis to the third place: the rays of one at a time.
        let size = [abs(ray.d[0]), abs(ray.d[1]), abs(ray.d[2])];
        let is_x = size[0].simd_ge(size[1]) & size[0].simd_ge(size[2]);
        let is_y = !is_x & size[1].simd_ge(size[2]);
        for (axis, of_axis) in [is_x, is_y, !(is_x | is_y)].into_iter().enumerate() {
            if of_axis.any_true() {
                let ray = along(simd, rays, first, axis);
                t = of_axis.select(edged(simd, g, &ray, (&kinds, &triangles, code), t), t);
            }
        }
    }
    if present[ShapeKind::Solid as usize] {
        let (is, rows) = lanes_of(simd, &kinds, ShapeKind::Solid);
        let mut solids = [g.solids.rows[rows[0]]; LANES];
        for (solid, row) in solids.iter_mut().zip(rows) {
            *solid = g.solids.rows[row];
        }
        let hit = kernels::solids(simd, ray, (&solids, Pick::Each), (code, is));
        t = is.select(hit.t, t);
    }
    let bounds = BoxLanes {
        lo: load3(simd, [&lo[0], &lo[1], &lo[2]]),
        hi: load3(simd, [&hi[0], &hi[1], &hi[2]]),
    };
    let (entry, _) = slab::enter(simd, ray, &bounds);
    entry.simd_gt(t).select(entry, t)
}

/// The distances of shapes with edges, in the lanes that hold them; `t` elsewhere.
#[inline(always)]
fn edged<S: Simd>(
    simd: S,
    g: &Geometry,
    ray: &RayLanes<S>,
    (kinds, triangles, code): (&Kinds, &[[[f32; 3]; 3]; LANES], U<S>),
    mut t: F<S>,
) -> F<S> {
    let turned = |v: V3<S>| [v[ray.turn[0]], v[ray.turn[1]], v[ray.turn[2]]];
    let (is, rows) = lanes_of(simd, kinds, ShapeKind::Quad);
    if is.any_true() {
        let corner = |i: usize| gather(simd, &rows, |row| g.quads.corners[i].get(row));
        let point = corner(0);
        let corners = [turned(point), turned(corner(1)), turned(corner(2)), turned(corner(3))];
        let normal = gather(simd, &rows, |row| g.quads.normal.get(row));
        let hit = kernels::quad(simd, ray, &QuadLanes { corners, point, normal, code });
        t = is.select(hit.t, t);
    }
    let (is, _) = lanes_of(simd, kinds, ShapeKind::Triangle);
    if is.any_true() {
        let lanes = [0, 1, 2, 3, 4, 5, 6, 7];
        let corner = |i: usize| gather(simd, &lanes, |lane| triangles[lane][i]);
        let corners = [turned(corner(0)), turned(corner(1)), turned(corner(2))];
        let hit = kernels::triangle(simd, ray, &TriangleLanes { corners, code });
        t = is.select(hit.t, t);
    }
    t
}

/// Eight rays as kernels see those whose longest axis is `axis`.
#[inline(always)]
fn along<S: Simd>(simd: S, rays: &Rays, first: usize, axis: usize) -> RayLanes<S> {
    let (o, d) = (rows3(simd, &rays.origin, first), rows3(simd, &rays.dir, first));
    let one = F::splat(simd, 1.0);
    let mut last = [0; LANES];
    for (to, code) in last.iter_mut().zip(&rays.last[first..first + LANES]) {
        *to = code.0;
    }
    let turn = TURN[axis];
    let long = d[turn[2]];
    RayLanes {
        o,
        d,
        start: F::from_slice(simd, &rays.t_min[first..first + LANES]),
        inv: [one / d[0], one / d[1], one / d[2]],
        last: U::from_slice(simd, &last),
        turn,
        shear: [d[turn[0]] / long, d[turn[1]] / long, one / long],
        turned: [o[turn[0]], o[turn[1]], o[turn[2]]],
    }
}

/// The lanes of a kind, and in each the row of a primitive of that kind: elsewhere that of any.
#[inline(always)]
fn lanes_of<S: Simd>(simd: S, kinds: &Kinds, kind: ShapeKind) -> (M<S>, [usize; LANES]) {
    let of = &kinds.of[kind as usize];
    let mut any = 0;
    for (is, row) in of.iter().zip(&kinds.rows) {
        any = if *is == 1 { *row } else { any };
    }
    let mut rows = [any; LANES];
    for (row, (is, own)) in rows.iter_mut().zip(of.iter().zip(&kinds.rows)) {
        *row = if *is == 1 { *own } else { *row };
    }
    (U::from_slice(simd, of).simd_eq(1u32), rows)
}

#[inline(always)]
fn gather<S: Simd>(simd: S, rows: &[usize; LANES], get: impl Fn(usize) -> [f32; 3]) -> V3<S> {
    let mut lanes: Lane3 = [[0.0; LANES]; 3];
    for (lane, row) in rows.iter().enumerate() {
        let v = get(*row);
        lanes[0][lane] = v[0];
        lanes[1][lane] = v[1];
        lanes[2][lane] = v[2];
    }
    load3(simd, [&lanes[0], &lanes[1], &lanes[2]])
}
