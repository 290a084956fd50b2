//! What each light gives, and whether it is seen.

use crate::interact::Interactions;
use fearless_simd::prelude::*;
use reflet_accel::lanes::{F, LANES, V3, dot, rows3, splat3, sub};
use reflet_accel::{HitCode, Rays};
use reflet_pack::Falloff;
use reflet_pack::lights::{LightPlace, Reach};

/// Shadow rays to one light.
#[derive(Default)]
pub struct Shadows {
    /// The rays.
    pub rays: Rays,
    /// The row of a level that each belongs to.
    pub rows: Vec<u16>,
    /// Those of the rows whose light is behind the triangle of a smooth mesh: the ray leaves the
    /// surface that the mesh's normals describe.
    pub lifted: Vec<u16>,
}

/// Writes each point's cosine, divided as the light falls off, into `term`; 0 where the light is behind the surface, outside the
/// light's cone or nothing was hit; and for the others a shadow ray into `shadows`.
#[inline(always)]
pub fn aim<S: Simd>(
    simd: S,
    light: &LightPlace,
    points: &Interactions,
    codes: &[HitCode],
    term: &mut [f32],
    shadows: &mut Shadows,
) {
    let Shadows { rays, rows, lifted } = shadows;
    let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
    let infinity = F::splat(simd, f32::INFINITY);
    let at: V3<S> = splat3(simd, light.at);
    let axis = splat3(simd, light.axis);
    let cos_angle = F::splat(simd, light.cos_angle);
    let len = codes.len();
    term.fill(0.0);
    rows.clear();
    lifted.clear();
    rays.resize(len);
    let mut cast = 0;
    for first in (0..len).step_by(LANES) {
        let p = rows3(simd, &points.p, first);
        let n = rows3(simd, &points.n, first);
        let mut start = rows3(simd, &points.start, first);
        let way = match light.reach {
            Reach::Near(_) => sub(at, p),
            Reach::Far => at,
        };
        let r = match light.reach {
            Reach::Near(_) => dot(way, way).sqrt(),
            Reach::Far => one,
        };
        let cos = dot(n, way) / r;
        let in_cone = (zero - dot(way, axis) / r).simd_gt(cos_angle);
        let lit = (cos.simd_gt(zero) & in_cone).to_bitmask();
        if lit == 0 {
            continue;
        }
        let value = match light.reach {
            Reach::Near(Falloff::Inverse) => cos / r,
            Reach::Near(Falloff::Square) => cos / r / r,
            Reach::Near(Falloff::None) | Reach::Far => cos,
        };
        let mut leaves_above = 0;
        if !points.lift[0].is_empty() {
            let facing = rows3(simd, &points.facing, first);
            let lift: V3<S> = rows3(simd, &points.lift, first);
            let lies_above =
                !(lift[0].simd_eq(zero) & lift[1].simd_eq(zero) & lift[2].simd_eq(zero));
            let above = !dot(facing, way).simd_gt(zero) & lies_above;
            for k in 0..3 {
                start[k] = above.select(start[k] + lift[k], start[k]);
            }
            leaves_above = above.to_bitmask();
        }
        // The ray runs from where rays leave; its length is its own.
        let (dir, length) = match light.reach {
            Reach::Near(_) => {
                let run = sub(at, start);
                let length = dot(run, run).sqrt();
                ([run[0] / length, run[1] / length, run[2] / length], length)
            }
            Reach::Far => (at, infinity),
        };
        for lane in (0..LANES.min(len - first)).filter(|l| lit >> l & 1 == 1) {
            let row = first + lane;
            if codes[row].is_none() {
                continue;
            }
            term[row] = value.as_slice()[lane];
            for k in 0..3 {
                rays.origin[k][cast] = start[k].as_slice()[lane];
                rays.dir[k][cast] = dir[k].as_slice()[lane];
            }
            rays.t_max[cast] = length.as_slice()[lane];
            rays.last[cast] = codes[row];
            rows.push(row as u16);
            if leaves_above >> lane & 1 == 1 {
                lifted.push(row as u16);
            }
            cast += 1;
        }
    }
    rays.resize(cast);
}

/// Puts in the place of shadow rays the ways from the triangles up to where the lifted ones among them
/// begin. They, too, must be free: what lies between would be passed by.
pub(crate) fn climb(points: &Interactions, codes: &[HitCode], shadows: &mut Shadows) {
    let Shadows { rays, lifted, .. } = shadows;
    rays.resize(lifted.len());
    for (i, row) in lifted.iter().map(|row| usize::from(*row)).enumerate() {
        let way = [0, 1, 2].map(|k| f64::from(points.lift[k][row]));
        let length = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
        for (k, way) in way.into_iter().enumerate() {
            rays.origin[k][i] = points.start[k][row];
            rays.dir[k][i] = (way / length) as f32;
        }
        rays.t_max[i] = length as f32;
        rays.last[i] = codes[row];
    }
}
