//! glTF 2.0 and GLB to columns.
//!
//! Source: Khronos, "glTF 2.0 Specification". The meshes of the default scene (else of the first, else
//! of all nodes), each with the transforms of its nodes applied. Of a material, `ambient` is its
//! emissive colour, `diffuse` its base colour by what it is not metallic, `specular` by what it is.
//! Textures, skins, morph targets and animations are left out; points and lines are passed over.

use crate::error::Fault;
use crate::finish::{finish, unit};
use ::gltf::accessor::{DataType, Dimensions};
use ::gltf::buffer::Source;
use ::gltf::mesh::Mode;
use ::gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};
use base64::Engine;
use reflet_scene::{MeshData, MeshMaterial};
use std::collections::HashMap;

/// What a glTF file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfMesh {
    /// The vertices and the triangles that have an area.
    pub data: MeshData,
    /// Triangles left out because they have no area.
    pub without_area: u64,
    /// Primitives left out because they are points or lines.
    pub passed_over: u64,
}

/// The most triangles of all nodes together: a small file can name one mesh very often.
const MOST_TRIANGLES: usize = 1 << 27;

/// The triangles of a glTF file, text or binary. `read` gives the bytes of a file that the glTF
/// names, by its path relative to it.
///
/// # Errors
/// What is no glTF 2.0, or asks for what is not read; accessors that reach beyond their buffers,
/// indices of no vertex, numbers that are not finite, nodes in a circle; what `read` says.
pub fn parse<E>(
    bytes: &[u8],
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>, E>,
) -> Result<GltfMesh, GltfError<E>> {
    let fault = |message: String| GltfError::Broken(Fault::file(message));
    let broken = |error: ::gltf::Error| fault(format!("is no glTF 2.0 file: {error}"));
    let Gltf { document, mut blob } = Gltf::from_slice_without_validation(bytes).map_err(broken)?;
    let root = document.into_json();
    // The crate's own validation takes these for granted.
    let count = root.accessors.len();
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        if let Some(index) = primitive.attributes.values().find(|index| index.value() >= count) {
            let index = index.value();
            return Err(fault(format!("accessor {index} is asked for, there are {count}")));
        }
    }
    let document = Document::from_json(root).map_err(broken)?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let index = buffer.index();
        let data = match buffer.source() {
            Source::Bin => {
                blob.take().ok_or_else(|| fault(format!("buffer {index} is missing")))?
            }
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => embedded(data)
                    .ok_or_else(|| fault(format!("the data of buffer {index} is no base64")))?,
                None => {
                    let name = decoded(uri)
                        .ok_or_else(|| fault(format!("buffer {index} has a broken name")))?;
                    read(&name).map_err(GltfError::Other)?
                }
            },
        };
        if data.len() < buffer.length() {
            let (length, wanted) = (data.len(), buffer.length());
            return Err(fault(format!("buffer {index} has {length} bytes in place of {wanted}")));
        }
        buffers.push(data);
    }
    let mut reading =
        Reading { buffers, mesh: GltfMesh::default(), materials: HashMap::new(), attributes: None };
    reading.nodes(&document).map_err(fault)?;
    reading.end().map_err(fault)
}

/// Why a glTF file cannot serve.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GltfError<E> {
    /// It is broken.
    Broken(Fault),
    /// A file that it names cannot be read.
    Other(E),
}

/// The bytes of `[type][;base64],...`.
fn embedded(data: &str) -> Option<Vec<u8>> {
    let (_, text) = data.split_once(";base64,")?;
    let standard = base64::engine::general_purpose::STANDARD.decode(text);
    standard.or_else(|_| base64::engine::general_purpose::STANDARD_NO_PAD.decode(text)).ok()
}

/// A relative URI as a path: `%20` is a blank.
fn decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &rest[2..];
    }
    String::from_utf8(bytes).ok()
}

type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Columns of `a b`, of matrices given by columns.
fn times(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| [0, 1, 2, 3].map(|row| (0..4).map(|k| a[k][row] * column[k]).sum()))
}

/// The cofactors of the upper 3x3 part: what normals turn with.
fn cofactors(m: &Matrix) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| {
        let (a, b) = (m[(c + 1) % 3], m[(c + 2) % 3]);
        [0, 1, 2].map(|r| {
            let (j, k) = ((r + 1) % 3, (r + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    })
}

struct Reading {
    buffers: Vec<Vec<u8>>,
    mesh: GltfMesh,
    /// Indices in our list by those in the file; `None` is the material of what has none.
    materials: HashMap<Option<usize>, u32>,
    /// Whether all vertices so far have normals, and places in a texture.
    attributes: Option<[bool; 2]>,
}

impl Reading {
    fn nodes(&mut self, document: &Document) -> Result<(), String> {
        let mut waiting: Vec<(Node<'_>, Matrix)> = Vec::new();
        let scene = document.default_scene().or_else(|| document.scenes().next());
        match scene {
            Some(scene) => waiting.extend(scene.nodes().map(|node| (node, IDENTITY))),
            None => {
                let children: Vec<usize> = document
                    .nodes()
                    .flat_map(|node| node.children().map(|child| child.index()).collect::<Vec<_>>())
                    .collect();
                let roots = document.nodes().filter(|node| !children.contains(&node.index()));
                waiting.extend(roots.map(|node| (node, IDENTITY)));
            }
        }
        waiting.reverse();
        let mut seen = vec![false; document.nodes().count()];
        while let Some((node, above)) = waiting.pop() {
            if std::mem::replace(&mut seen[node.index()], true) {
                return Err(format!("node {} has two parents, or is its own", node.index()));
            }
            let own = node.transform().matrix().map(|column| column.map(f64::from));
            let matrix = times(&above, &own);
            if let Some(mesh) = node.mesh() {
                for primitive in mesh.primitives() {
                    let place = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
                    self.primitive(&primitive, &matrix)
                        .map_err(|message| format!("{place}: {message}"))?;
                }
            }
            let children: Vec<Node<'_>> = node.children().collect();
            waiting.extend(children.into_iter().rev().map(|child| (child, matrix)));
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, matrix: &Matrix) -> Result<(), String> {
        let mode = primitive.mode();
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            self.mesh.passed_over += 1;
            return Ok(());
        }
        let positions = primitive.get(&Semantic::Positions).ok_or("it has no positions")?;
        let positions = self.floats::<3>(&positions, "POSITION")?;
        let normals = primitive.get(&Semantic::Normals);
        let normals = normals.map(|a| self.floats::<3>(&a, "NORMAL")).transpose()?;
        let uvs = primitive.get(&Semantic::TexCoords(0));
        let uvs = uvs.map(|a| self.floats::<2>(&a, "TEXCOORD_0")).transpose()?;
        let count = positions.len();
        for (name, length) in
            [("NORMAL", normals.as_ref().map(Vec::len)), ("TEXCOORD_0", uvs.as_ref().map(Vec::len))]
        {
            if let Some(length) = length.filter(|length| *length != count) {
                return Err(format!("{name} has {length} elements, and POSITION {count}"));
            }
        }
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, count)?,
            None => (0..count as u32).collect(),
        };
        let data = &mut self.mesh.data;
        if data.triangles.len() + indices.len() > MOST_TRIANGLES
            || data.positions.len() + count >= u32::MAX as usize
        {
            return Err(format!("there are more than {MOST_TRIANGLES} triangles"));
        }
        let base = data.positions.len() as u32;
        for [x, y, z] in positions {
            let point = [f64::from(x), f64::from(y), f64::from(z), 1.0];
            let moved =
                [0, 1, 2].map(|r| (0..4).map(|k| matrix[k][r] * point[k]).sum::<f64>() as f32);
            if !moved.iter().all(|value| value.is_finite()) {
                return Err("a position is not finite, or beyond the range of f32".to_owned());
            }
            data.positions.push(moved);
        }
        let turn = cofactors(matrix);
        // A transform that mirrors turns triangles over.
        let determinant: f64 = (0..3).map(|r| matrix[0][r] * turn[0][r]).sum();
        let mirrored = determinant < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let all = self.attributes.get_or_insert([true; 2]);
        all[0] &= normals.is_some();
        all[1] &= uvs.is_some();
        for normal in normals.into_iter().flatten() {
            let n = normal.map(f64::from);
            let turned = [0, 1, 2].map(|r| sign * (0..3).map(|k| turn[k][r] * n[k]).sum::<f64>());
            data.normals.push(unit(turned).unwrap_or([0.0; 3]));
        }
        // In glTF v goes down.
        data.uvs.extend(uvs.into_iter().flatten().map(|[u, v]| [u, 1.0 - v]));

        let before = data.triangles.len();
        let mut push = |[a, b, c]: [u32; 3]| {
            let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
            data.triangles.push(triangle.map(|index| index + base));
        };
        match mode {
            Mode::TriangleStrip => {
                for (i, corners) in indices.windows(3).enumerate() {
                    let [a, b, c] = [corners[0], corners[1], corners[2]];
                    push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
            Mode::TriangleFan => {
                let first = indices.first().copied().unwrap_or(0);
                indices
                    .get(1..)
                    .unwrap_or_default()
                    .windows(2)
                    .for_each(|w| push([first, w[0], w[1]]));
            }
            _ => indices.as_chunks::<3>().0.iter().for_each(|corners| push(*corners)),
        }
        let more = data.triangles.len() - before;
        let wears = self.material(primitive);
        let worn = &mut self.mesh.data.triangle_materials;
        worn.resize(worn.len() + more, wears);
        Ok(())
    }

    /// The index of a primitive's material in our list.
    fn material(&mut self, primitive: &Primitive<'_>) -> u32 {
        let material = primitive.material();
        let list = &mut self.mesh.data.materials;
        *self.materials.entry(material.index()).or_insert_with(|| {
            if let Some(index) = material.index() {
                // Names need not be there, and need not differ.
                let own = material.name().unwrap_or_default();
                let is_taken = own.is_empty() || list.iter().any(|m| m.name == own);
                let name = if is_taken { format!("{own}#{index}") } else { own.to_owned() };
                let surface = material.pbr_metallic_roughness();
                let [r, g, b, _] = surface.base_color_factor().map(f64::from);
                let metallic = f64::from(surface.metallic_factor());
                list.push(MeshMaterial {
                    name,
                    ambient: material.emissive_factor().map(f64::from),
                    diffuse: [r, g, b].map(|part| part * (1.0 - metallic)),
                    specular: [r, g, b].map(|part| part * metallic),
                    maps: None,
                });
            } else {
                list.push(MeshMaterial::grey(""));
            }
            list.len() as u32 - 1
        })
    }

    /// The bytes of an accessor's elements: the first one's place, the way from one to the next, and
    /// all bytes that they are in. Nothing of it reaches beyond the buffer.
    fn elements(&self, accessor: &Accessor<'_>) -> Result<(&[u8], usize), String> {
        if accessor.sparse().is_some() {
            return Err("sparse accessors are not read".to_owned());
        }
        let (size, count) = (accessor.size(), accessor.count());
        let view = accessor.view().ok_or("an accessor names no buffer view")?;
        let stride = view.stride().unwrap_or(size).max(1);
        let span =
            count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
        let start = view.offset().checked_add(accessor.offset());
        let end = start.zip(span).and_then(|(start, span)| start.checked_add(span));
        let buffer = &self.buffers[view.buffer().index()];
        let inside = accessor.offset().checked_add(span.unwrap_or(usize::MAX));
        match (start, end) {
            (Some(start), Some(end))
                if end <= buffer.len() && inside.is_some_and(|end| end <= view.length()) =>
            {
                Ok((&buffer[start..end], stride))
            }
            _ => Err(format!("accessor {} reaches beyond its buffer", accessor.index())),
        }
    }

    fn floats<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        name: &str,
    ) -> Result<Vec<[f32; N]>, String> {
        let wanted = if N == 2 { Dimensions::Vec2 } else { Dimensions::Vec3 };
        let kind = accessor.data_type();
        let width = match kind {
            DataType::F32 => 4,
            DataType::U16 | DataType::I16 if accessor.normalized() => 2,
            DataType::U8 | DataType::I8 if accessor.normalized() => 1,
            _ => return Err(format!("{name} is of numbers that are not read")),
        };
        if accessor.dimensions() != wanted {
            return Err(format!("{name} has not {N} numbers an element"));
        }
        let (bytes, stride) = self.elements(accessor)?;
        let mut values = Vec::with_capacity(accessor.count());
        for start in (0..accessor.count()).map(|i| i * stride) {
            let mut element = [0.0; N];
            for (i, value) in element.iter_mut().enumerate() {
                let raw = &bytes[start + i * width..start + (i + 1) * width];
                *value = match (kind, raw) {
                    (DataType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
                    (DataType::U16, &[a, b]) => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
                    (DataType::I16, &[a, b]) => f32::from(i16::from_le_bytes([a, b])) / 32767.0,
                    (DataType::I8, &[a]) => f32::from(a as i8) / 127.0,
                    (_, raw) => f32::from(raw[0]) / 255.0,
                };
                if !value.is_finite() {
                    let index = accessor.index();
                    return Err(format!("accessor {index} holds a number that is not finite"));
                }
            }
            values.push(element);
        }
        Ok(values)
    }

    fn indices(&self, accessor: &Accessor<'_>, vertices: usize) -> Result<Vec<u32>, String> {
        if accessor.dimensions() != Dimensions::Scalar {
            return Err("its indices are no single numbers".to_owned());
        }
        let (bytes, stride) = self.elements(accessor)?;
        let mut indices = Vec::with_capacity(accessor.count());
        for start in (0..accessor.count()).map(|i| i * stride) {
            let index = match (accessor.data_type(), &bytes[start..]) {
                (DataType::U8, [a, ..]) => u32::from(*a),
                (DataType::U16, [a, b, ..]) => u32::from(u16::from_le_bytes([*a, *b])),
                (DataType::U32, [a, b, c, d, ..]) => u32::from_le_bytes([*a, *b, *c, *d]),
                _ => return Err("its indices are of numbers that are not read".to_owned()),
            };
            if index as usize >= vertices {
                return Err(format!("vertex {index} is asked for, there are {vertices}"));
            }
            indices.push(index);
        }
        Ok(indices)
    }

    fn end(mut self) -> Result<GltfMesh, String> {
        let data = &mut self.mesh.data;
        if data.triangles.is_empty() {
            return Err("its scene holds no triangle".to_owned());
        }
        let [normals, uvs] = self.attributes.unwrap_or([false; 2]);
        if !normals {
            data.normals = Vec::new();
        }
        if !uvs {
            data.uvs = Vec::new();
        }
        // Only what wears no material at all.
        if self.materials.keys().all(Option::is_none) {
            data.materials = Vec::new();
            data.triangle_materials = Vec::new();
        }
        self.mesh.without_area = finish(data);
        Ok(self.mesh)
    }
}
