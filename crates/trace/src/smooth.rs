//! Meshes that are lit and mirrored by the normals of their file.

use crate::interact::Interactions;
use reflet_accel::{Hits, Rays};
use reflet_pack::{Columns, PrimId};

type V = [f64; 3];

/// How far a mirrored ray rises at least, as a part of its length: below it could meet the triangle
/// beside the one that it leaves.
const RISE: f64 = 1e-3;

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: V) -> Option<V> {
    let length = dot(v, v).sqrt();
    (length > 0.0).then(|| v.map(|x| x / length))
}

fn wide(v: [f32; 3]) -> V {
    v.map(f64::from)
}

/// The weights of a triangle's corners at a point of its plane.
pub(crate) fn weights([a, b, c]: [[f32; 3]; 3], p: [f32; 3]) -> V {
    let [a, b, c] = [a, b, c].map(wide);
    let (u, v, w) = (sub(b, a), sub(c, a), sub(wide(p), a));
    let n = cross(u, v);
    let size = dot(n, n);
    let (beta, gamma) = (dot(cross(w, v), n) / size, dot(cross(u, w), n) / size);
    [1.0 - beta - gamma, beta, gamma]
}

/// Turns the normals at points on smooth meshes from those of the triangles to those of the file.
pub(crate) fn turn(columns: &Columns, rays: &Rays, hits: &Hits, points: &mut Interactions) {
    for row in 0..rays.len() {
        let Some(prim) = hits.code[row].prim() else { continue };
        let surface = columns.surface_of(prim).index();
        let Some(turn) = &columns.surfaces.smooth[surface] else { continue };
        let at = |c: &[Vec<f32>; 3]| [c[0][row], c[1][row], c[2][row]];
        let facing = wide(at(&points.n));
        let own = interpolated(columns, (prim, surface), at(&points.p));
        let own = own.and_then(|n| unit(turn.map(|r| dot(r, n))));
        let Some(own) = own else { continue };
        // To the side that the ray comes from, as the triangle's.
        let own = if dot(own, facing) < 0.0 { own.map(|x| -x) } else { own };
        let n = raised(own, facing, wide(at(&rays.dir)));
        for (column, x) in points.n.iter_mut().zip(n) {
            column[row] = x as f32;
        }
    }
}

/// The file's normal at a point, in the file's coordinates.
fn interpolated(columns: &Columns, (prim, surface): (PrimId, usize), p: [f32; 3]) -> Option<V> {
    let data = &columns.surfaces.mesh[surface].as_ref()?.data;
    let first = columns.surfaces.range(surface).start;
    let corners = data.triangles.get(prim.index() - first)?;
    let weights = weights(columns.geometry.triangle(prim)?, p);
    let mut n = [0.0; 3];
    for (corner, weight) in corners.iter().zip(weights) {
        let own = wide(*data.normals.get(*corner as usize)?);
        n = [n[0] + weight * own[0], n[1] + weight * own[1], n[2] + weight * own[2]];
    }
    Some(n)
}

/// `n`, or where the ray that it mirrors would dip below the triangle, the nearest to it that sends
/// the ray just above.
fn raised(n: V, facing: V, d: V) -> V {
    let twice = 2.0 * dot(d, n);
    let mirrored = [d[0] - twice * n[0], d[1] - twice * n[1], d[2] - twice * n[2]];
    let height = dot(mirrored, facing);
    if height >= RISE {
        return n;
    }
    let lift = RISE - height;
    let lifted = [0, 1, 2].map(|k| mirrored[k] + lift * facing[k]);
    // The normal that halves the way from the ray's coming to its going.
    unit(lifted).and_then(|v| unit(sub(v, d))).unwrap_or(facing)
}
