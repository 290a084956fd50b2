//! Primitives and rays from files.

use crate::exit::{Exit, Failure};
use crate::profile::npy;
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

    /// Reads them; ids count them in the file's order.
    ///
    /// # Errors
    /// An input's.
    pub fn read(&self) -> Result<Geometry, Failure> {
        let mut geometry = Geometry::default();
        match self {
            Primitives::Spheres(path) => {
                let spheres = npy::read::<f32, 4>(path)?;
                few(path, spheres.len())?;
                for [x, y, z, radius] in spheres {
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
                for triangle in &obj.data.triangles {
                    geometry.push_triangle(triangle.map(|v| obj.data.positions[v as usize]));
                }
            }
            Primitives::Indexed(positions, triangles) => {
                let at = npy::read::<f32, 3>(positions)?;
                let rows = npy::read::<u32, 3>(triangles)?;
                few(triangles, rows.len())?;
                for (i, row) in rows.iter().enumerate() {
                    if let Some(v) = row.iter().find(|v| **v as usize >= at.len()) {
                        let (file, n) = (triangles.display(), at.len());
                        let what = format!("{file}: row {i} names vertex {v} of {n}");
                        return Err(Failure::new(Exit::Input, what));
                    }
                    geometry.push_triangle(row.map(|v| at[v as usize]));
                }
            }
        }
        Ok(geometry)
    }
}

fn few(path: &Path, n: usize) -> Result<(), Failure> {
    if n <= HitCode::MAX_PRIMS {
        return Ok(());
    }
    Err(Failure::new(Exit::Input, format!("{}: {n} primitives are too many", path.display())))
}

/// The rays of an (n, 8) array (origin, t_min, direction, t_max), in `parts` streams of about
/// equal length, which together are the file's order.
///
/// # Errors
/// An input's.
pub fn rays(path: &Path, parts: usize) -> Result<Vec<Rays>, Failure> {
    let rows = npy::read::<f32, 8>(path)?;
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
