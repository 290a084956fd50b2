//! Indexed triangles and their placement.

use crate::fault::{Fault, finite};
use crate::key::Key;
use crate::maps::Maps;
use crate::material::Material;
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// What a mesh file holds: vertices, triangles and materials, as columns. A column that the file has
/// nothing for is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions, in the file's own unit.
    pub positions: Vec<[f32; 3]>,
    /// Three indices into `positions` a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// A unit vector a vertex: the normal of the surface that the triangles stand for; zero where the
    /// file gives none, so that a triangle of such corners has its own. Empty if there is none at all.
    pub normals: Vec<[f32; 3]>,
    /// A place in a texture a vertex: u to the right, v up, (0, 0) the lower left corner of the
    /// picture, (1, 1) the upper right one; beyond that it repeats. Zero where the file gives none;
    /// empty if there is none at all.
    pub uvs: Vec<[f32; 2]>,
    /// The same once more, for maps that take their second texture coordinates.
    pub second_uvs: Vec<[f32; 2]>,
    /// A linear colour a vertex; 1 where the file gives none, empty if there is none at all. Those
    /// materials are multiplied with it whose maps say so.
    pub colours: Vec<[f32; 3]>,
    /// An index into `materials` a triangle. Empty if the file names no material.
    pub triangle_materials: Vec<u32>,
    /// The materials that triangles wear, in the order in which the file first uses them.
    pub materials: Vec<MeshMaterial>,
}

/// A material as a mesh file gives it. Colours are linear: red, green, blue; with `maps` they are
/// factors of what these say.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshMaterial {
    /// Its name in the file; empty for what wears no material beside others that do.
    pub name: String,
    /// Light of its own.
    pub ambient: [f64; 3],
    /// The share of a light's intensity that is scattered.
    pub diffuse: [f64; 3],
    /// The share of the mirrored ray's intensity.
    pub specular: [f64; 3],
    /// What multiplies the colours from point to point.
    pub maps: Option<Arc<Maps>>,
}

impl MeshMaterial {
    /// A grey matt one, for triangles of which the file does not say more than a name.
    pub fn grey(name: impl Into<String>) -> Self {
        let Material { ambient, diffuse, specular } = Material::GREY_MATT;
        let [ambient, diffuse, specular] = [ambient, diffuse, specular].map(|c| c.to_array());
        MeshMaterial { name: name.into(), ambient, diffuse, specular, maps: None }
    }
}

/// Which normals a mesh is lit and mirrored by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Shading {
    /// Those of the file, where it has them: between corners they turn smoothly.
    #[default]
    Smooth,
    /// Those of the triangles.
    Faceted,
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
    /// Which normals it is lit and mirrored by.
    pub shading: Shading,
    /// What stands for the file's own materials, where the mesh as a whole wears none; sorted by name.
    pub worn: Arc<[Worn]>,
}

/// The entity that stands for a material of a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worn {
    /// The material's name in the file.
    pub name: String,
    /// An entity with a [`Material`].
    pub material: Key,
}

impl Mesh {
    /// Puts other entities in place of those that stand for materials of these names.
    pub fn wear(&mut self, others: Vec<Worn>) {
        // A file may have very many materials: what is sorted is found quickly.
        let mut worn: BTreeMap<String, Key> =
            self.worn.iter().map(|worn| (worn.name.clone(), worn.material)).collect();
        worn.extend(others.into_iter().map(|other| (other.name, other.material)));
        self.worn = worn.into_iter().map(|(name, material)| Worn { name, material }).collect();
    }

    /// What stands for the file's material of this name.
    pub fn worn_by(&self, name: &str) -> Option<Key> {
        let at = self.worn.binary_search_by(|worn| worn.name.as_str().cmp(name)).ok()?;
        Some(self.worn[at].material)
    }

    /// What stands for the file's material number `i`.
    pub fn worn_for(&self, i: usize) -> Option<Key> {
        self.worn_by(&self.data.materials.get(i)?.name)
    }

    /// Whether this is a mesh that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("scale", &[self.scale])?;
        if !(self.scale as f32).is_normal() {
            return Err(Fault::new("scale", "must not be 0 (also after rounding to f32)"));
        }
        finite("rotate", &self.rotate.to_array())?;
        finite("translate", &self.translate.to_array())?;
        let names: HashSet<&str> = self.data.materials.iter().map(|m| &m.name[..]).collect();
        let is_there = |worn: &&Worn| names.contains(&worn.name[..]);
        match self.worn.iter().find(|worn| !is_there(worn)) {
            None => Ok(()),
            Some(Worn { name, .. }) => {
                let names: Vec<String> =
                    self.data.materials.iter().map(|m| format!("`{}`", m.name)).collect();
                let has = if names.is_empty() { "none".into() } else { names.join(", ") };
                Err(Fault::new(
                    "materials",
                    format!("names `{name}`, which is no material of the file; it has {has}"),
                ))
            }
        }
    }
}
