//! A scene's primitives and rays as NumPy's files, to be cast again here or by others' kernels.
//!
//! In such files a ray knows no surface that it leaves. Where it would meet that surface again at
//! its own start, its `tmin` is raised to that root, so that it does not.

use crate::exit::Failure;
use crate::profile::npy;
use reflet_accel::{HitCode, Rays, brute};
use reflet_pack::{Geometry, ShapeKind};
use std::path::Path;

/// Writes the visible spheres and triangles in the order of their ids, as
/// `DIR/NAME.spheres.npy`, and `DIR/NAME.verts.npy` with `DIR/NAME.tris.npy`. Says what it wrote,
/// and what is in no such file.
///
/// # Errors
/// An output's.
pub fn primitives(geometry: &Geometry, dir: &Path, name: &str) -> Result<String, Failure> {
    let (mut spheres, mut corners, mut left_out) = (Vec::new(), Vec::new(), [0usize; 3]);
    for slot in geometry.slots() {
        let (kind, row) = geometry.shape[slot.index()];
        let row = row as usize;
        match kind {
            _ if !geometry.is_visible(slot) => {}
            ShapeKind::Sphere => {
                let [x, y, z] = geometry.spheres.center.get(row);
                spheres.push([x, y, z, geometry.spheres.radius[row]]);
            }
            ShapeKind::Copy => {
                let copy = &geometry.copies[row];
                (0..copy.len()).for_each(|i| corners.extend(copy.triangle(i)));
            }
            ShapeKind::Triangle => corners.extend(geometry.triangles.points(row)),
            ShapeKind::Plane => left_out[0] += 1,
            ShapeKind::Quad => left_out[1] += 1,
            ShapeKind::Solid => left_out[2] += 1,
        }
    }
    let mut text = String::new();
    if !spheres.is_empty() {
        npy::write_rows(&dir.join(format!("{name}.spheres.npy")), &spheres)?;
        text += &format!("{name}.spheres.npy: {} spheres\n", spheres.len());
    }
    if !corners.is_empty() {
        let count = corners.len() as u32 / 3;
        let indices: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        npy::write_rows(&dir.join(format!("{name}.verts.npy")), &corners)?;
        npy::write_rows(&dir.join(format!("{name}.tris.npy")), &indices)?;
        text += &format!("{name}.verts.npy, {name}.tris.npy: {count} triangles\n");
    }
    for (count, what) in
        left_out.into_iter().zip(["infinite planes", "quads", "curved shapes and discs"])
    {
        if count > 0 {
            text +=
                &format!("not in any file, for want of an array that holds them: {count} {what}\n");
        }
    }
    Ok(text)
}

/// Writes the rays of one kind as `DIR/NAME.KIND.rays.npy`.
///
/// # Errors
/// An output's.
pub fn rays(
    geometry: &Geometry,
    streams: &[Rays],
    dir: &Path,
    (name, kind): (&str, &str),
) -> Result<String, Failure> {
    let mut rows = Vec::new();
    for rays in streams {
        for i in 0..rays.len() {
            let at = |columns: &[Vec<f32>; 3]| [columns[0][i], columns[1][i], columns[2][i]];
            let (o, d) = (at(&rays.origin), at(&rays.dir));
            // A root beyond the ray's end is none.
            let t_max = rays.t_max[i];
            let t_min = start(geometry, (o, d, rays.t_min[i]), rays.last[i]).min(t_max);
            rows.push([o[0], o[1], o[2], t_min, d[0], d[1], d[2], t_max]);
        }
    }
    npy::write_rows(&dir.join(format!("{name}.{kind}.rays.npy")), &rows)?;
    Ok(format!("{name}.{kind}.rays.npy: {} rays\n", rows.len()))
}

/// The least `tmin` from which a ray that knows nothing of the surface `last` meets it where one
/// that leaves it does.
fn start(geometry: &Geometry, (o, d, mut t_min): ([f32; 3], [f32; 3], f32), last: HitCode) -> f32 {
    let Some(prim) = last.prim() else { return t_min };
    let t = |t_min, last| brute::hit(geometry, prim, (o, d, t_min), last).map(|hit| hit.0);
    let wanted = t(t_min, last);
    // A surface has at most two roots.
    for _ in 0..2 {
        match t(t_min, HitCode::NONE) {
            Some(t) if Some(t) != wanted => t_min = t,
            _ => break,
        }
    }
    t_min
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_that_leaves_a_sphere_starts_beyond_its_own_root() {
        let mut geometry = Geometry::default();
        geometry.push_sphere([0.0, 0.0, 0.0], 1.0);
        let ball = HitCode::FIRST;
        // A start that lies inside by rounding: from there the far side is a hit.
        let (o, d) = ([0.0, 0.0, 0.999_999_9], [0.0, 0.0, 1.0]);
        let seen = |t_min, last| brute::closest(&geometry, (o, d), (t_min, f32::INFINITY), last).1;
        assert!(!seen(0.0, HitCode::NONE).is_none() && seen(0.0, ball).is_none());
        let from = start(&geometry, (o, d, 0.0), ball);
        assert!(from > 0.0 && from < 1e-6 && seen(from, HitCode::NONE).is_none(), "{from}");
        // One that leaves the inside, across the ball, meets the other side.
        let (o, d) = ([0.0, 0.0, -1.000_000_1], [0.0, 0.0, 1.0]);
        let wanted = brute::closest(&geometry, (o, d), (0.0, 9.0), ball.inward());
        let from = start(&geometry, (o, d, 0.0), ball.inward());
        let found = brute::closest(&geometry, (o, d), (from, 9.0), HitCode::NONE);
        assert_eq!((found, wanted.1.is_inside()), (wanted, true));
        assert_eq!(start(&geometry, (o, d, 0.5), HitCode::NONE), 0.5);
    }
}
