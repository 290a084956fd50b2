//! A mesh file to columns, by its ending.

use crate::error::{AssetError, Cause, Fault};
use crate::{gltf, mtl, obj, ply, stl};
use reflet_scene::{MeshData, MeshMaterial};
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
    let broken = |fault: Fault| AssetError::broken(path, fault);
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let mut notes = Vec::new();
    let (data, without_area) = match ending.to_ascii_lowercase().as_str() {
        "obj" => {
            let mut obj = obj::parse(bytes).map_err(broken)?;
            materials(path, &mut obj, other, &mut notes)?;
            if let Some(line) = obj.unknown_line {
                let statements = counted(obj.unknown, "unknown statement");
                notes.push(format!("{statements} ignored, the first in line {line}"));
            }
            let partial = obj.partial.iter();
            notes.extend(
                partial.map(|noun| format!("its {noun} are ignored: some corners have none")),
            );
            (obj.data, obj.without_area)
        }
        "ply" => {
            let ply = ply::parse(bytes).map_err(broken)?;
            (ply.data, ply.without_area)
        }
        "stl" => {
            let stl = stl::parse(bytes).map_err(broken)?;
            (stl.data, stl.without_area)
        }
        "gltf" | "glb" => {
            let mesh = gltf::parse(bytes, other).map_err(|error| match error {
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
    Ok(MeshFile { data, notes })
}

/// Gives the materials that an OBJ file uses the colours that its libraries say.
fn materials(
    path: &Path,
    obj: &mut obj::Obj,
    other: &mut dyn FnMut(&str) -> Result<Vec<u8>, AssetError>,
    notes: &mut Vec<String>,
) -> Result<(), AssetError> {
    if obj.data.materials.is_empty() {
        return Ok(());
    }
    let mut known: Vec<MeshMaterial> = Vec::new();
    for line in &obj.libraries {
        // A line is one name, or several without blanks in them.
        let whole = other(line);
        let several = line.contains(char::is_whitespace)
            && whole.as_ref().is_err_and(|error| error.cause() == Cause::Missing);
        let names: Vec<(&str, Result<Vec<u8>, AssetError>)> = match several {
            true => line.split_whitespace().map(|name| (name, other(name))).collect(),
            false => vec![(line, whole)],
        };
        for (name, bytes) in names {
            match bytes {
                Ok(bytes) => {
                    let library = path.with_file_name("").join(name);
                    let read = mtl::parse(&bytes);
                    known.extend(read.map_err(|fault| AssetError::broken(&library, fault))?);
                }
                // Very many files name one that was left behind, on another machine.
                Err(error) => {
                    notes.push(format!("its materials in `{name}` are grey: {}", error.message()));
                }
            }
        }
    }
    let mut unknown = Vec::new();
    for material in &mut obj.data.materials {
        match known.iter().find(|known| known.name == material.name) {
            Some(known) => *material = known.clone(),
            None if material.name.is_empty() => {}
            None => unknown.push(material.name.clone()),
        }
    }
    if let (Some(first), false) = (unknown.first(), known.is_empty()) {
        let count = counted(unknown.len() as u64, "material");
        notes.push(format!("{count} not found and grey, the first `{first}`"));
    }
    Ok(())
}

fn counted(n: u64, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}
