//! Primitives and rays from files.

use crate::exit::{Exit, Failure};
use crate::profile::npy::{self, Number};
use reflet_accel::lanes::LANES;
use reflet_accel::{HitCode, Rays};
use reflet_pack::Geometry;
use std::path::{Path, PathBuf};

/// Where primitives come from.
#[derive(Clone, Debug)]
pub enum Primitives {
    /// An (n, 4) array: centre and radius.
    Spheres(PathBuf),
    /// An OBJ file.
    Mesh(PathBuf),
    /// An (n, 3) array of positions and an (n, 3) array of indices into it.
    Indexed(PathBuf, PathBuf),
}

impl Primitives {
    /// The files that they are in.
    pub fn files(&self) -> Vec<&Path> {
        match self {
            Primitives::Spheres(file) | Primitives::Mesh(file) => vec![file],
            Primitives::Indexed(verts, tris) => vec![verts, tris],
        }
    }

    /// Reads them; ids count them in the file's order. What they hold is added to `digest`.
    ///
    /// # Errors
    /// An input's.
    pub fn read(&self, digest: &mut Digest) -> Result<Geometry, Failure> {
        let mut geometry = Geometry::default();
        match self {
            Primitives::Spheres(path) => {
                let spheres = npy::read::<f32, 4>(path)?;
                few(path, spheres.len())?;
                digest.rows("spheres", &spheres);
                for (row, [x, y, z, radius]) in spheres.into_iter().enumerate() {
                    finite(path, row, "centre", [x, y, z])?;
                    if !(radius > 0.0 && radius.is_finite()) {
                        let what = format!("row {row}: the radius is {radius}; it must be above 0");
                        return Err(npy::fault(path, &what));
                    }
                    geometry.push_sphere([x, y, z], radius);
                }
            }
            Primitives::Mesh(path) => {
                let fault =
                    |what: String| Failure::new(Exit::Input, format!("{}{what}", path.display()));
                let text = std::fs::read(path).map_err(|e| fault(format!(": {e}")))?;
                let obj = reflet_assets::obj::parse(&text).map_err(|e| {
                    let line = e.line.map(|line| format!(":{line}")).unwrap_or_default();
                    fault(format!("{line}: {}", e.message))
                })?;
                few(path, obj.data.triangles.len())?;
                triangles(&mut geometry, digest, &obj.data.positions, &obj.data.triangles);
            }
            Primitives::Indexed(positions, indices) => {
                let at = npy::read::<f32, 3>(positions)?;
                let rows = npy::read::<u32, 3>(indices)?;
                few(indices, rows.len())?;
                for (row, corner) in at.iter().enumerate() {
                    finite(positions, row, "vertex", *corner)?;
                }
                for (i, row) in rows.iter().enumerate() {
                    if let Some(v) = row.iter().find(|v| **v as usize >= at.len()) {
                        let what = format!("row {i} names vertex {v} of {}", at.len());
                        return Err(npy::fault(indices, &what));
                    }
                }
                triangles(&mut geometry, digest, &at, &rows);
            }
        }
        Ok(geometry)
    }
}

fn triangles(
    geometry: &mut Geometry,
    digest: &mut Digest,
    at: &[[f32; 3]],
    triangles: &[[u32; 3]],
) {
    digest.rows("corners", at);
    digest.rows("triangles", triangles);
    for triangle in triangles {
        geometry.push_triangle(triangle.map(|v| at[v as usize]));
    }
}

/// What inputs hold, as a hash that names them.
#[derive(Default)]
pub struct Digest(blake3::Hasher);

impl Digest {
    /// Adds an array.
    fn rows<T: Number, const WIDTH: usize>(&mut self, name: &str, rows: &[[T; WIDTH]]) {
        self.0.update(format!("{name} {}:", rows.len()).as_bytes());
        for row in rows {
            row.iter().for_each(|x| _ = self.0.update(&x.bytes()));
        }
    }

    /// The hash of all that was added.
    pub fn name(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

fn finite(path: &Path, row: usize, what: &str, at: [f32; 3]) -> Result<(), Failure> {
    if at.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(npy::fault(path, &format!("row {row}: the {what} is {at:?}, which is not finite")))
}

fn few(path: &Path, n: usize) -> Result<(), Failure> {
    if n <= HitCode::MAX_PRIMS {
        return Ok(());
    }
    Err(Failure::new(Exit::Input, format!("{}: {n} primitives are too many", path.display())))
}

/// A direction's length may differ from 1 by as much: some 80 times what dividing by the length
/// in 32 bits leaves, and far less than what moves a hit by a visible part of its distance.
const UNIT: f64 = 1e-5;

/// What is wrong with a ray, if something is.
fn wrong([ox, oy, oz, t_min, dx, dy, dz, t_max]: [f32; 8]) -> Option<String> {
    let (origin, dir) = ([ox, oy, oz], [dx, dy, dz]);
    let length = dir.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt();
    if !origin.iter().all(|x| x.is_finite()) {
        Some(format!("the origin is {origin:?}, which is not finite"))
    } else if length.is_nan() || (length - 1.0).abs() > UNIT {
        Some(format!(
            "the direction is {dir:?}, of length {length}; rays are cast along unit vectors, so \
             divide by the length"
        ))
    } else if !(t_min >= 0.0 && t_min.is_finite()) {
        Some(format!("tmin is {t_min}; it must be finite and not below 0"))
    } else if t_max.is_nan() || t_max < t_min {
        Some(format!("tmax is {t_max}; it must not be below tmin, {t_min}"))
    } else {
        None
    }
}

/// The rays of an (n, 8) array (origin, t_min, direction, t_max), in `parts` streams of about
/// equal length, which together are the file's order. What they hold is added to `digest`.
///
/// # Errors
/// An input's.
pub fn rays(path: &Path, parts: usize, digest: &mut Digest) -> Result<Vec<Rays>, Failure> {
    let rows = npy::read::<f32, 8>(path)?;
    for (i, row) in rows.iter().enumerate() {
        if let Some(what) = wrong(*row) {
            return Err(npy::fault(path, &format!("row {i}: {what}")));
        }
    }
    digest.rows("rays", &rows);
    let part = rows.len().div_ceil(parts).next_multiple_of(8 * LANES).max(1);
    let stream = |rows: &[[f32; 8]]| {
        let mut rays = Rays::default();
        for [ox, oy, oz, t_min, dx, dy, dz, t_max] in rows.iter().copied() {
            rays.push([ox, oy, oz], [dx, dy, dz], t_max, HitCode::NONE);
            let i = rays.len() - 1;
            rays.t_min[i] = t_min;
        }
        rays.pad();
        rays
    };
    Ok(rows.chunks(part).map(stream).collect())
}
