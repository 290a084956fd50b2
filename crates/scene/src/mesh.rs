//! Indexed triangles and their placement.

use crate::fault::{Fault, finite};
use glam::DVec3;
use std::sync::Arc;

/// What a mesh file holds: vertices and triangles, as columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions, in the file's own unit.
    pub positions: Vec<[f32; 3]>,
    /// Three indices into `positions` a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A mesh in the scene: scaled, then rotated about x, then y, then z, then translated.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The triangles, shared between all meshes made from the same file.
    pub data: Arc<MeshData>,
    /// The factor that all positions are multiplied with; not 0.
    pub scale: f64,
    /// Degrees about the x, y and z axes, applied in this order.
    pub rotate: DVec3,
    /// The way of the mesh's origin, in the scene's unit.
    pub translate: DVec3,
}

impl Mesh {
    /// Whether this is a mesh that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("scale", &[self.scale])?;
        if !(self.scale as f32).is_normal() {
            return Err(Fault::new("scale", "must not be 0 (also after rounding to f32)"));
        }
        finite("rotate", &self.rotate.to_array())?;
        finite("translate", &self.translate.to_array())
    }
}
