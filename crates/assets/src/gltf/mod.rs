//! glTF 2.0 and GLB to columns.
//!
//! Source: Khronos, "glTF 2.0 Specification". The meshes of the default scene (else of the first, else
//! of all nodes), each with the transforms of its nodes applied; skins and morph targets as they are
//! at rest. Points and lines are passed over, animations, cameras and lights left out.
//!
//! | room | holds |
//! | --- | --- |
//! | `container` | text or GLB to its JSON and buffers |
//! | `json` | the JSON's members |
//! | `accessor` | elements in buffers |
//! | `matrix` | transforms |
//! | `nodes` | which meshes are shown, and where |
//! | `primitive` | vertices and triangles |
//! | `material` | metalness and roughness to the model's colours |
//! | `textures` | the pictures that materials name |

mod accessor;
mod container;
mod json;
mod material;
mod matrix;
mod nodes;
mod primitive;
mod textures;

use crate::error::{AssetError, Fault};
use crate::finish::finish;
use crate::texture::Budget;
use container::{File, Other};
use json::{Primitive, Root};
use nodes::{Shown, Ways};
use primitive::is_passed_over;
use reflet_scene::{MeshData, MeshMaterial, UvSet};
use std::collections::{HashMap, HashSet};
use textures::Textures;

/// What a glTF file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfMesh {
    /// The vertices and the triangles that have an area.
    pub data: MeshData,
    /// Triangles left out because they have no area.
    pub without_area: u64,
    /// What else is left out, for a warning.
    pub notes: Vec<String>,
}

/// Why a glTF file cannot serve.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GltfError {
    /// It is broken.
    Broken(Fault),
    /// A file that it names cannot be read.
    Other(AssetError),
}

/// What is wrong while a file is read.
#[derive(Clone, Debug)]
enum Trouble {
    Said(String),
    Other(AssetError),
}

impl From<String> for Trouble {
    fn from(message: String) -> Self {
        Trouble::Said(message)
    }
}

impl From<&str> for Trouble {
    fn from(message: &str) -> Self {
        Trouble::Said(message.to_owned())
    }
}

impl From<Trouble> for GltfError {
    fn from(trouble: Trouble) -> Self {
        match trouble {
            Trouble::Said(message) => GltfError::Broken(Fault::file(message)),
            Trouble::Other(error) => GltfError::Other(error),
        }
    }
}

impl Trouble {
    /// With the place in front.
    fn at(self, place: impl FnOnce() -> String) -> Trouble {
        match self {
            Trouble::Said(message) => Trouble::Said(format!("{}: {message}", place())),
            other => other,
        }
    }
}

/// Extensions that are read.
const READ: [&str; 8] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions that hide the geometry from a reader that does not know them, and by what.
const COMPRESSED: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "Draco"),
    ("EXT_meshopt_compression", "meshopt"),
    ("KHR_meshopt_compression", "meshopt"),
];

/// The triangles of a glTF file, text or binary. `other` gives the bytes of a file that the glTF
/// names, by its path relative to it.
///
/// # Errors
/// What is no glTF 2.0, or is compressed; accessors that reach beyond their buffers, nodes in a
/// circle, more triangles than can be built; what `other` says. Pictures that cannot be read are
/// none.
pub fn parse(
    bytes: &[u8],
    other: &mut dyn FnMut(&str) -> Result<Vec<u8>, AssetError>,
    budget: &Budget,
) -> Result<GltfMesh, GltfError> {
    let file = File::open(bytes, other)?;
    let compressed = |names: &[String]| {
        COMPRESSED.iter().find(|(name, _)| names.iter().any(|n| n == name)).map(|(_, by)| {
            let message = format!(
                "is compressed with {by}, which is not read; decompress it, for example with \
                 `gltf-transform copy`"
            );
            GltfError::from(Trouble::Said(message))
        })
    };
    if let Some(error) = compressed(&file.root.extensions_required) {
        return Err(error);
    }
    // Where compression is optional the plain data may be there, too.
    build(&file, other, budget)
        .map_err(|trouble| compressed(&file.root.extensions_used).unwrap_or_else(|| trouble.into()))
}

fn build(file: &File, other: Other<'_>, budget: &Budget) -> Result<GltfMesh, Trouble> {
    let shown = file.shown()?;
    file.check_size(&shown)?;
    let mut building = Building {
        file,
        coloured: file.coloured(&shown),
        textures: Textures::new(file, other, budget),
        data: MeshData::default(),
        materials: HashMap::new(),
        passed_over: 0,
        broken: 0,
        without_uvs: 0,
    };
    for shown in &shown {
        building.mesh(shown)?;
    }
    building.end()
}

impl File {
    /// The materials that vertices with colours wear.
    fn coloured(&self, shown: &[Shown]) -> HashSet<Option<usize>> {
        let primitives = shown.iter().flat_map(|shown| &self.root.meshes[shown.mesh].primitives);
        primitives.filter(|p| p.attributes.color_0.is_some()).map(|p| p.material).collect()
    }
}

struct Building<'a> {
    file: &'a File,
    coloured: HashSet<Option<usize>>,
    textures: Textures<'a>,
    data: MeshData,
    /// Indices in our list by those in the file; `None` is the material of what has none.
    materials: HashMap<Option<usize>, u32>,
    passed_over: u64,
    /// Triangles with a corner that is not there or not finite.
    broken: u64,
    /// Primitives without the texture coordinates that their material's textures take.
    without_uvs: u64,
}

impl Building<'_> {
    fn mesh(&mut self, shown: &Shown) -> Result<(), Trouble> {
        let file = self.file;
        let (node, mesh) = (&file.root.nodes[shown.node], &file.root.meshes[shown.mesh]);
        let ways = file.ways(shown).map_err(|t| t.at(|| format!("node {}", shown.node)))?;
        let weights = node.weights.as_ref().or(mesh.weights.as_ref());
        let weights = weights.map_or(&[][..], |weights| &weights[..]);
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let place = || format!("mesh {}, primitive {index}", shown.mesh);
            self.primitive(primitive, weights, &ways).map_err(|trouble| trouble.at(place))?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        weights: &[f64],
        ways: &[Ways],
    ) -> Result<(), Trouble> {
        if is_passed_over(primitive) {
            self.passed_over += 1;
            return Ok(());
        }
        let vertices = self.file.vertices(primitive, weights)?;
        let wears = self.material(primitive.material)?;
        let maps = self.data.materials[wears as usize].maps.clone();
        let lacks = |set: UvSet| match set {
            UvSet::First => !vertices.has_uvs(0),
            UvSet::Second => !vertices.has_uvs(1),
        };
        self.without_uvs += u64::from(maps.iter().flat_map(|m| m.all()).any(|map| lacks(map.set)));
        for way in ways {
            let [more, far] = vertices.append(way, &mut self.data)?;
            self.broken += vertices.broken + far;
            let worn = &mut self.data.triangle_materials;
            worn.resize(worn.len() + more as usize, wears);
        }
        Ok(())
    }

    /// The index of a primitive's material in our list.
    fn material(&mut self, index: Option<usize>) -> Result<u32, Trouble> {
        if let Some(known) = self.materials.get(&index) {
            return Ok(*known);
        }
        let coloured = self.coloured.contains(&index);
        let materials = &self.file.root.materials;
        let list = &mut self.data.materials;
        let material = match index {
            Some(index) => {
                let material = materials.get(index).ok_or_else(|| {
                    format!("material {index} is asked for, there are {}", materials.len())
                })?;
                // Names need not be there, and need not differ.
                let own = &material.name;
                let is_taken = own.is_empty() || list.iter().any(|m| m.name == *own);
                let name = if is_taken { format!("{own}#{index}") } else { own.clone() };
                material::read(name, material, coloured, &mut self.textures)
            }
            None if coloured => {
                material::read(String::new(), &json::Material::default(), true, &mut self.textures)
            }
            None => MeshMaterial::grey(""),
        };
        list.push(material);
        let number = list.len() as u32 - 1;
        self.materials.insert(index, number);
        Ok(number)
    }

    fn end(mut self) -> Result<GltfMesh, Trouble> {
        let data = &mut self.data;
        if data.triangles.is_empty() {
            return Err("its scene holds no triangle".into());
        }
        // Only what wears no material at all.
        let is_plain = data.materials.iter().all(|m| *m == MeshMaterial::grey(""));
        if self.materials.keys().all(Option::is_none) && is_plain {
            data.materials = Vec::new();
            data.triangle_materials = Vec::new();
        }
        let mut notes = Vec::new();
        let mut tell = |count: u64, noun: &str, what: &str| {
            if count > 0 {
                notes.push(format!("{count} {noun}{} {what}", if count == 1 { "" } else { "s" }));
            }
        };
        tell(self.passed_over, "primitive", "of points or lines skipped");
        tell(self.broken, "triangle", "skipped: a corner is not there or not finite");
        tell(self.without_uvs, "primitive", "without the texture coordinates of its textures");
        let unread = self.textures.unread;
        if let Some(first) = unread.first() {
            let count = unread.len();
            let what = format!("not read, the factors stand alone ({first})");
            tell(count as u64, "texture", &what);
        }
        let left_out = left_out(&self.file.root, self.materials.keys().flatten());
        if !left_out.is_empty() {
            notes.push(format!("left out: {}", left_out.join(", ")));
        }
        let without_area = finish(&mut self.data);
        Ok(GltfMesh { data: self.data, without_area, notes })
    }
}

/// What of a file is not read, by names; of materials, those that are worn.
fn left_out<'a>(root: &Root, worn: impl Iterator<Item = &'a usize>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let materials = worn.filter_map(|index| root.materials.get(*index));
    let mut of_materials: Vec<&str> = materials.flat_map(material::left_out).collect();
    of_materials.sort_unstable();
    of_materials.dedup();
    all.extend(of_materials.into_iter().map(str::to_owned));
    let targets = root.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| &p.targets);
    let others = |t: &json::Target| {
        [&t.texcoord_0, &t.texcoord_1, &t.color_0].into_iter().any(Option::is_some)
    };
    if targets.into_iter().any(others) {
        all.push("colours and texture coordinates of morph targets".to_owned());
    }
    for (count, noun) in [(root.animations.len(), "animation"), (root.cameras.len(), "camera")] {
        if count > 0 {
            all.push(format!("{count} {noun}{}", if count == 1 { "" } else { "s" }));
        }
    }
    let used = root.extensions_required.iter().chain(&root.extensions_used);
    for name in used.filter(|name| !READ.contains(&name.as_str())) {
        if !all.contains(name) {
            all.push(name.clone());
        }
    }
    all
}
