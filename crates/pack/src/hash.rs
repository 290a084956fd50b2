//! A name for a packed scene that follows from its bits: what a picture was made from.
//!
//! All that decides a pixel takes part: what rays meet, what it wears, lights, view, settings and
//! samples. What does not, stays out: hidden surfaces, keys, addresses, and how the columns came to
//! be what they are. Numbers count by their bits, as in [`crate::changes`].

use crate::changes::Changes;
use crate::columns::Columns;
use crate::geometry::ShapeKind;
use crate::ids::LightId;
use reflet_scene::{Filter, MeshData, Texture};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

/// The hash of a scene: BLAKE3 of its columns in a fixed order, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SceneHash([u8; 32]);

/// 64 hexadecimal digits.
impl fmt::Display for SceneHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Hashes scene after scene, each time only the columns that changed.
#[derive(Debug, Default)]
pub struct SceneHasher {
    surfaces: Option<blake3::Hash>,
    paint: Option<blake3::Hash>,
    materials: Option<blake3::Hash>,
    lights: Option<blake3::Hash>,
}

impl SceneHasher {
    /// The hash of `columns`; `changes` is how they differ from those of the call before, and is
    /// not looked at in the first call.
    pub fn hash(&mut self, columns: &Columns, changes: &Changes) -> SceneHash {
        if changes.rebuilt {
            *self = SceneHasher::default();
        }
        // A surface that appears brings its paint.
        if !changes.surfaces.is_empty() {
            (self.surfaces, self.paint) = (None, None);
        }
        if !changes.repainted.is_empty() || !changes.patterns.is_empty() {
            self.paint = None;
        }
        if !changes.materials.is_empty() {
            self.materials = None;
        }
        if !changes.lights.is_empty() {
            self.lights = None;
        }
        let parts = [
            *self.surfaces.get_or_insert_with(|| surfaces(columns)),
            *self.paint.get_or_insert_with(|| paint(columns)),
            *self.materials.get_or_insert_with(|| materials(columns)),
            *self.lights.get_or_insert_with(|| lights(columns)),
            settings(columns),
        ];
        // The domain's number grows when the same columns come to mean another picture.
        let mut all = blake3::Hasher::new_derive_key("reflet packed scene 4");
        for part in parts {
            all.update(part.as_bytes());
        }
        SceneHash(*all.finalize().as_bytes())
    }

    /// The hash of `columns` by themselves.
    pub fn of(columns: &Columns) -> SceneHash {
        Self::default().hash(columns, &Changes::default())
    }
}

/// Numbers on their way into a hash, in pieces that are worth a call.
struct Words {
    hasher: blake3::Hasher,
    bytes: Vec<u8>,
}

const PIECE: usize = 1 << 16;

impl Words {
    fn new() -> Self {
        Words { hasher: blake3::Hasher::new(), bytes: Vec::with_capacity(PIECE + 256) }
    }

    fn add(&mut self, words: impl IntoIterator<Item = u32>) {
        for word in words {
            self.bytes.extend_from_slice(&word.to_le_bytes());
        }
        if self.bytes.len() >= PIECE {
            self.hasher.update(&self.bytes);
            self.bytes.clear();
        }
    }

    fn points<const N: usize>(&mut self, points: [[f32; 3]; N]) {
        self.add(points.into_iter().flatten().map(f32::to_bits));
    }

    fn digest(&mut self, hash: blake3::Hash) {
        self.bytes.extend_from_slice(hash.as_bytes());
    }

    fn finish(mut self) -> blake3::Hash {
        self.hasher.update(&self.bytes);
        self.hasher.finalize()
    }
}

/// Visible surfaces in the order in which equal hits are decided, each with its primitives.
fn surfaces(columns: &Columns) -> blake3::Hash {
    let mut words = Words::new();
    let geometry = &columns.geometry;
    let mut meshes = Meshes::default();
    for i in (0..columns.surfaces.len()).filter(|i| columns.surfaces.visible[*i]) {
        words.add([columns.surfaces.prims[i]]);
        if let (Some(turn), Some(mesh)) = (&columns.surfaces.smooth[i], &columns.surfaces.mesh[i]) {
            words.add(turn.iter().flatten().flat_map(|x| split(x.to_bits())));
            words.digest(meshes.of(&mesh.data));
        }
        for slot in columns.slots(i) {
            let (kind, row) = geometry.shape[slot];
            let row = row as usize;
            words.add([kind as u32]);
            match kind {
                ShapeKind::Sphere => {
                    let (center, radius) = geometry.spheres.row(row);
                    words.points([center]);
                    words.add([radius.to_bits()]);
                }
                ShapeKind::Plane => {
                    let planes = &geometry.planes;
                    words.points([planes.point.get(row), planes.normal.get(row)]);
                }
                ShapeKind::Quad => {
                    words.points(geometry.quads.points(row));
                    words.points([geometry.quads.normal.get(row)]);
                }
                ShapeKind::Triangle => {
                    words.points(geometry.triangles.points(row));
                    words.points([geometry.triangles.normal.get(row)]);
                }
                ShapeKind::Solid => {
                    let bits = geometry.solids.rows[row].bits();
                    words.add(bits.into_iter().flat_map(split));
                }
                ShapeKind::Copy => {
                    let copy = &geometry.copies[row];
                    words.digest(meshes.of(&copy.mesh.data));
                    words.add(copy.world.iter().flatten().flat_map(|x| split(x.to_bits())));
                }
            }
        }
    }
    words.finish()
}

/// The contents of meshes, each hashed once however often it is in the scene.
#[derive(Default)]
struct Meshes(HashMap<*const MeshData, blake3::Hash>);

impl Meshes {
    fn of(&mut self, data: &Arc<MeshData>) -> blake3::Hash {
        *self.0.entry(Arc::as_ptr(data)).or_insert_with(|| {
            let mut words = Words::new();
            for t in &data.triangles {
                words.points(t.map(|v| data.positions[v as usize]));
                words.add(*t);
            }
            words.add(data.normals.iter().flatten().map(|x| x.to_bits()));
            words.add(data.uvs.iter().flatten().map(|x| x.to_bits()));
            words.add(data.triangle_materials.iter().copied());
            for (name, column) in
                [(1, data.second_uvs.as_flattened()), (2, data.colours.as_flattened())]
            {
                // Files without these keep their names.
                if !column.is_empty() {
                    words.add([name, column.len() as u32]);
                    words.add(column.iter().map(|x| x.to_bits()));
                }
            }
            words.finish()
        })
    }
}

/// The texels of pictures, each hashed once however many surfaces wear it.
#[derive(Default)]
struct Images(HashMap<*const Texture, blake3::Hash>);

impl Images {
    fn of(&mut self, image: &Arc<Texture>) -> blake3::Hash {
        *self.0.entry(Arc::as_ptr(image)).or_insert_with(|| {
            let mut words = Words::new();
            words.add([image.width, image.height]);
            for texels in image.texels.chunks(PIECE / 16) {
                words.add(texels.as_flattened().iter().map(|x| x.to_bits()));
            }
            words.finish()
        })
    }
}

fn split(bits: u64) -> [u32; 2] {
    [bits as u32, (bits >> 32) as u32]
}

fn paint(columns: &Columns) -> blake3::Hash {
    let mut words = Words::new();
    let (mut meshes, mut images) = (Meshes::default(), Images::default());
    for i in (0..columns.surfaces.len()).filter(|i| columns.surfaces.visible[*i]) {
        let paint = &columns.surfaces.paint[i];
        words.add([paint.even.0, paint.odd.0, u32::from(paint.cells.is_some())]);
        words.add(paint.cells.iter().flat_map(|cells| cells.bits()));
        let tint = paint.tint.as_ref().map_or(Vec::new(), |tint| tint.content_bits());
        words.add([tint.len() as u32]);
        words.add(tint.into_iter().flat_map(split));
        for image in paint.tint.iter().flat_map(|tint| tint.images()) {
            words.digest(images.of(image));
        }
        let mesh = columns.surfaces.mesh[i].as_ref();
        if let Some(mesh) = mesh.filter(|m| paint.tint.is_some() || m.data.materials.len() > 1) {
            words.digest(meshes.of(&mesh.data));
        }
    }
    words.finish()
}

fn materials(columns: &Columns) -> blake3::Hash {
    let mut words = Words::new();
    for row in &columns.materials.rows {
        words.add(row.bits());
    }
    words.finish()
}

fn lights(columns: &Columns) -> blake3::Hash {
    let mut words = Words::new();
    for i in 0..columns.lights.len() {
        let bits = columns.light_bits(i);
        words
            .add(columns.light_place(LightId(i as u32)).content_bits().into_iter().flat_map(split));
        words.add(bits.emissivity);
    }
    words.finish()
}

fn settings(columns: &Columns) -> blake3::Hash {
    let mut words = Words::new();
    for bits in columns.view.bits() {
        words.add(split(bits));
    }
    let model = &columns.model;
    words.add([columns.samples, columns.spread as u32]);
    words.add([model.max_bounces, model.max_path.to_bits()]);
    words.add([model.attenuation as u32, model.transfer as u32]);
    words.add(model.background.map(f32::to_bits));
    // The only sample is in the centre, whatever the filter.
    let filter = if columns.samples > 1 { columns.view.filter } else { Filter::Box };
    words.add([filter as u32]);
    words.finish()
}
