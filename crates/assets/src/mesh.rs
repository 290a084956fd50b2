//! A mesh file to columns, by its ending.

use crate::error::{AssetError, Fault};
use crate::texture::Budget;
use crate::{format, gltf, mtl, obj, ply, stl};
use reflet_scene::MeshData;
use std::path::Path;

/// What a mesh file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The columns.
    pub data: MeshData,
    /// What deserves a warning.
    pub notes: Vec<String>,
}

/// The mesh in `bytes`, a file that is called `path`. `other` gives the bytes of a file that it
/// names, by its path relative to it.
///
/// # Errors
/// An ending that is none of obj, ply, stl, gltf and glb; a broken file, or one that it needs and
/// that cannot be read.
pub fn decode(
    path: &Path,
    bytes: &[u8],
    other: &mut dyn FnMut(&str) -> Result<Vec<u8>, AssetError>,
) -> Result<MeshFile, AssetError> {
    decode_within(&Budget::default(), path, bytes, other)
}

/// The same, with textures that count against the memory of a scene's.
///
/// # Errors
/// As [`decode`].
pub fn decode_within(
    budget: &Budget,
    path: &Path,
    bytes: &[u8],
    other: &mut dyn FnMut(&str) -> Result<Vec<u8>, AssetError>,
) -> Result<MeshFile, AssetError> {
    let broken = |fault: Fault| AssetError::broken(path, fault);
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let ending = ending.to_ascii_lowercase();
    if let Some(what) = format::other_than(&ending, bytes) {
        return Err(broken(Fault::file(format!("is {what}"))));
    }
    let mut notes = Vec::new();
    let (data, without_area) = match ending.as_str() {
        "obj" => {
            let mut obj = obj::parse(bytes).map_err(broken)?;
            let worn = mtl::worn::wear(path, &mut obj, other, budget)?;
            notes.extend(obj.left_out.into_iter().chain(worn));
            (obj.data, 0)
        }
        "ply" => {
            let mut ply = ply::parse(bytes).map_err(broken)?;
            mtl::worn::by_vertex(&mut ply.data);
            notes = ply.left_out;
            (ply.data, 0)
        }
        "stl" => {
            let stl = stl::parse(bytes).map_err(broken)?;
            notes = stl.left_out;
            (stl.data, 0)
        }
        "gltf" | "glb" => {
            let mesh = gltf::parse(bytes, other, budget).map_err(|error| match error {
                gltf::GltfError::Broken(fault) => broken(fault),
                gltf::GltfError::Other(error) => error,
            })?;
            notes.extend(mesh.notes);
            (mesh.data, mesh.without_area)
        }
        _ => {
            let message = "a mesh file ends in .obj, .ply, .stl, .gltf or .glb";
            return Err(AssetError::forbidden(path, message));
        }
    };
    if without_area > 0 {
        notes.insert(0, format!("{} without area skipped", counted(without_area, "triangle")));
    }
    // A warning is one line, whatever names a file holds.
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let notes = notes.iter().map(|note| note.chars().map(printable).collect()).collect();
    Ok(MeshFile { data, notes })
}

fn counted(n: u64, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}
