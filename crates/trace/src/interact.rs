//! Where a ray hit, and how the surface lies there.

use fearless_simd::prelude::*;
use reflet_accel::lanes::{F, LANES, M, V3, abs, dot, load3, rows3, sub};
use reflet_accel::{Hits, Rays, solid};
use reflet_pack::copies::facing;
use reflet_pack::{Form, Geometry, ShapeKind};

/// Points on surfaces, as columns padded to whole lanes; rows of rays that missed mean nothing.
#[derive(Clone, Debug, Default)]
pub struct Interactions {
    /// The hit point p.
    pub p: [Vec<f32>; 3],
    /// The unit normal at p, turned to face the incoming ray.
    pub n: [Vec<f32>; 3],
    /// Where rays leave: p itself, or for flat bounded shapes p moved off the surface by a bound on
    /// its rounding.
    pub start: [Vec<f32>; 3],
    /// The normal of the triangle, turned likewise; [`Interactions::n`] is another on a smooth mesh.
    /// Empty if no mesh is smooth.
    pub facing: [Vec<f32>; 3],
    /// The way from the triangle of a smooth mesh up to the surface that its normals describe, 0 on
    /// others. Empty if no mesh is smooth.
    pub lift: [Vec<f32>; 3],
}

/// How far rays that leave a flat bounded shape start off it, relative to the coordinates of p and
/// its way from the shape's first corner: 16 units in the last place (2^-24). The projection of p
/// onto the plane leaves about 4 of the coordinates and 8 of the way.
const OFFSET: f32 = 1.0 / 1_048_576.0;

/// What is needed of eight surfaces, gathered.
struct Surfaces {
    /// The centre of a sphere; a point of a flat shape.
    anchor: [[f32; LANES]; 3],
    /// The normal of a flat shape.
    normal: [[f32; LANES]; 3],
    /// The radius of a sphere, 0 for a flat shape.
    radius: [f32; LANES],
    /// [`OFFSET`] for a flat bounded shape, else 0.
    offset: [f32; LANES],
    /// 1 where a closed shape was hit from the inside.
    inside: [u32; LANES],
    /// 1 where it is a solid, whose point and normal were found in `f64`.
    solid: [u32; LANES],
    /// The point of a solid.
    at: [[f32; LANES]; 3],
}

impl Surfaces {
    #[inline(always)]
    fn gather(g: &Geometry, (rays, first): (&Rays, usize), hits: &Hits) -> Surfaces {
        let mut s = Surfaces {
            anchor: [[0.0; LANES]; 3],
            normal: [[0.0; LANES], [1.0; LANES], [0.0; LANES]],
            radius: [0.0; LANES],
            offset: [0.0; LANES],
            inside: [0; LANES],
            solid: [0; LANES],
            at: [[0.0; LANES]; 3],
        };
        for (lane, at) in (first..first + LANES).enumerate() {
            let code = hits.code[at];
            let Some(prim) = code.prim() else { continue };
            let (slot, which) = g.slot_of(prim);
            let (kind, row) = g.shape[slot.index()];
            let row = row as usize;
            let (anchor, normal) = match kind {
                ShapeKind::Sphere => {
                    s.radius[lane] = g.spheres.radius[row];
                    s.inside[lane] = u32::from(code.is_inside());
                    (g.spheres.center.get(row), [0.0, 1.0, 0.0])
                }
                ShapeKind::Plane => (g.planes.point.get(row), g.planes.normal.get(row)),
                ShapeKind::Quad => {
                    s.offset[lane] = OFFSET;
                    (g.quads.corners[0].get(row), g.quads.normal.get(row))
                }
                ShapeKind::Triangle => {
                    s.offset[lane] = OFFSET;
                    (g.triangles.corners[0].get(row), g.triangles.normal.get(row))
                }
                ShapeKind::Copy => {
                    s.offset[lane] = OFFSET;
                    let points = g.copies[row].triangle(which);
                    (points[0], facing(points).0)
                }
                ShapeKind::Solid => {
                    let solid = &g.solids.rows[row];
                    let ray = [&rays.origin, &rays.dir].map(|c| [0, 1, 2].map(|k| c[k][at]));
                    let (p, normal) = solid::point(solid, (ray[0], ray[1]), hits.t[at]);
                    s.solid[lane] = 1;
                    s.inside[lane] = u32::from(code.is_inside());
                    if solid.form == Form::Disc {
                        s.offset[lane] = OFFSET;
                    }
                    for (column, x) in s.at.iter_mut().zip(p) {
                        column[lane] = x;
                    }
                    (p, normal)
                }
            };
            for k in 0..3 {
                s.anchor[k][lane] = anchor[k];
                s.normal[k][lane] = normal[k];
            }
        }
        s
    }
}

impl Interactions {
    /// Finds point, normal and start of every ray of `rays` that hit something.
    #[inline(always)]
    pub fn find<S: Simd>(&mut self, simd: S, g: &Geometry, rays: &Rays, hits: &Hits) {
        let padded = rays.len().next_multiple_of(LANES);
        for column in self.p.iter_mut().chain(&mut self.n).chain(&mut self.start) {
            column.resize(padded, 0.0);
        }
        self.facing.iter_mut().chain(&mut self.lift).for_each(Vec::clear);
        for first in (0..rays.len()).step_by(LANES) {
            let lanes = first..first + LANES;
            let s = Surfaces::gather(g, (rays, first), hits);
            let t = F::from_slice(simd, &hits.t[lanes.clone()]);
            let (o, d) = (rows3(simd, &rays.origin, first), rows3(simd, &rays.dir, first));
            let found = point(simd, o, d, t, &s);
            for k in 0..3 {
                found.p[k].store_slice(&mut self.p[k][lanes.clone()]);
                found.n[k].store_slice(&mut self.n[k][lanes.clone()]);
                found.start[k].store_slice(&mut self.start[k][lanes.clone()]);
            }
        }
    }
}

struct Found<S: Simd> {
    p: V3<S>,
    n: V3<S>,
    start: V3<S>,
}

#[inline(always)]
fn point<S: Simd>(simd: S, o: V3<S>, d: V3<S>, t: F<S>, s: &Surfaces) -> Found<S> {
    let zero = F::splat(simd, 0.0);
    let anchor = load3(simd, [&s.anchor[0], &s.anchor[1], &s.anchor[2]]);
    let normal = load3(simd, [&s.normal[0], &s.normal[1], &s.normal[2]]);
    let radius = F::from_slice(simd, &s.radius);
    let curved: M<S> = radius.simd_gt(zero);

    let reached = [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]];
    let way = sub(reached, anchor);
    // A sphere's point is brought back to its surface along the radius, a flat shape's along the
    // normal: what is left is the rounding of coordinates, not of the ray's length.
    let length = dot(way, way).sqrt();
    let height = dot(way, normal);
    let solid = fearless_simd::u32x8::from_slice(simd, &s.solid).simd_eq(1u32);
    let at = load3(simd, [&s.at[0], &s.at[1], &s.at[2]]);
    let mut n = [zero; 3];
    let mut p = [zero; 3];
    for k in 0..3 {
        n[k] = curved.select(way[k] / length, normal[k]);
        p[k] = curved.select(anchor[k] + n[k] * radius, reached[k] - n[k] * height);
        p[k] = solid.select(at[k], p[k]);
    }
    let sided = curved | solid;
    let inside = fearless_simd::u32x8::from_slice(simd, &s.inside).simd_eq(1u32);
    let away = dot(d, n).simd_gt(zero);
    let flip = (sided & inside) | (!sided & away);
    for c in &mut n {
        *c = flip.select(zero - *c, *c);
    }
    let extent = longest(p) + longest(way);
    let by = F::from_slice(simd, &s.offset) * extent;
    let start = [p[0] + n[0] * by, p[1] + n[1] * by, p[2] + n[2] * by];
    Found { p, n, start }
}

#[inline(always)]
fn longest<S: Simd>(v: V3<S>) -> F<S> {
    let (x, y, z) = (abs(v[0]), abs(v[1]), abs(v[2]));
    let xy = y.simd_gt(x).select(y, x);
    z.simd_gt(xy).select(z, xy)
}
