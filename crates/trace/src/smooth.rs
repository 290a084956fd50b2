//! Meshes that are lit and mirrored by the normals of their file.
//!
//! A light that stands in front of such a normal may stand behind the triangle, whose neighbours then
//! block it: the shadow's edge, the terminator, would follow the triangles. So the way to such a light
//! leads over the surface that the normals describe: up to there first, then on to the light. That
//! surface is Phong tessellation's (Boubekeur and Alexa, SIGGRAPH Asia 2008), as Hanika, "Hacking the
//! Shadow Terminator" (Ray Tracing Gems II, chapter 4, 2021), has it for shadow rays.

use crate::interact::Interactions;
use reflet_accel::HitCode;
use reflet_pack::{Columns, PrimId};

type V = [f64; 3];

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

/// Turns the normals at points on smooth meshes from those of the triangles to those of the file, and
/// finds how far the surface that these describe lies above.
pub(crate) fn turn(columns: &Columns, codes: &[HitCode], points: &mut Interactions) {
    points.facing.clone_from(&points.n);
    let padded = points.n[0].len();
    points.lift.iter_mut().for_each(|column| column.resize(padded, 0.0));
    for (row, code) in codes.iter().enumerate() {
        let Some(prim) = code.prim() else { continue };
        let surface = columns.surface_of(prim).index();
        let Some(turn) = &columns.surfaces.smooth[surface] else { continue };
        let at = |c: &[Vec<f32>; 3]| [c[0][row], c[1][row], c[2][row]];
        let facing = wide(at(&points.n));
        let p = at(&points.p);
        let Some(patch) = Patch::of(columns, (prim, surface), p) else { continue };
        let turned = |n: V| unit(turn.map(|r| dot(r, n)));
        let Some(own) = turned(patch.normal()) else { continue };
        // To the side that the ray comes from, as the triangle's.
        let side = if dot(own, facing) < 0.0 { -1.0 } else { 1.0 };
        let normals = patch.normals.map(|n| turned(n).map(|n| n.map(|x| x * side)));
        let lift = patch.lift(normals, facing, wide(p));
        for k in 0..3 {
            points.n[k][row] = (own[k] * side) as f32;
            points.lift[k][row] = lift[k] as f32;
        }
    }
}

/// The corners of a triangle, and what each counts at a point of it.
struct Patch {
    points: [V; 3],
    /// Of the file, in its coordinates.
    normals: [V; 3],
    weights: V,
}

impl Patch {
    fn of(columns: &Columns, (prim, surface): (PrimId, usize), p: [f32; 3]) -> Option<Patch> {
        let data = &columns.surfaces.mesh[surface].as_ref()?.data;
        let first = columns.surfaces.range(surface).start;
        let corners = *data.triangles.get(prim.index() - first)?;
        let points = columns.geometry.triangle(prim)?;
        let mut normals = [[0.0; 3]; 3];
        for (normal, corner) in normals.iter_mut().zip(corners) {
            *normal = wide(*data.normals.get(corner as usize)?);
        }
        Some(Patch { points: points.map(wide), normals, weights: weights(points, p) })
    }

    /// The file's normal at the point, in the file's coordinates.
    fn normal(&self) -> V {
        let mut n = [0.0; 3];
        for (own, weight) in self.normals.iter().zip(self.weights) {
            n = [n[0] + weight * own[0], n[1] + weight * own[1], n[2] + weight * own[2]];
        }
        n
    }

    /// The way from `p` up to the surface that the normals, now of the scene, describe: the mean of
    /// the ways to the planes that touch it at the corners. Only up, and none where that surface runs
    /// below the triangle.
    fn lift(&self, normals: [Option<V>; 3], facing: V, p: V) -> V {
        let mut lift = [0.0; 3];
        for ((n, corner), weight) in normals.into_iter().zip(self.points).zip(self.weights) {
            let Some(n) = n else { continue };
            let height = dot(sub(corner, p), n);
            let way = if height > 0.0 { weight * height } else { 0.0 };
            lift = [0, 1, 2].map(|k| lift[k] + way * n[k]);
        }
        if dot(lift, facing) > 0.0 { lift } else { [0.0; 3] }
    }
}
