//! glTF files, made piece by piece.

use reflet_assets::AssetError;
use reflet_assets::mesh::{MeshFile, decode};
use reflet_scene::MeshData;
use serde_json::{Value, json};
use std::path::Path;

/// A file under construction: its JSON, and its only buffer.
pub struct Draft {
    pub json: Value,
    pub bytes: Vec<u8>,
}

pub const CORNERS: [[f32; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

impl Draft {
    /// One triangle, not indexed.
    pub fn triangle() -> Draft {
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        });
        let mut draft = Draft { json, bytes: Vec::new() };
        draft.accessor(&floats(CORNERS.as_flattened()), (5126, 3, "VEC3"));
        draft
    }

    /// A view of more bytes; gives its number.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let at = self.bytes.len();
        self.bytes.extend(bytes);
        let view = json!({ "buffer": 0, "byteOffset": at, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    /// An accessor of more bytes; gives its number.
    pub fn accessor(
        &mut self,
        bytes: &[u8],
        (component, count, kind): (u32, usize, &str),
    ) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    pub fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let data: String = self.bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
        let uri = format!("data:application/octet-stream,{data}");
        json["buffers"] = json!([{ "uri": uri, "byteLength": self.bytes.len() }]);
        json.to_string().into_bytes()
    }

    pub fn read(&self) -> Result<MeshFile, AssetError> {
        let nothing = |name: &str| panic!("{name} is asked for");
        decode(Path::new("a.gltf"), &self.text(), &mut { nothing })
    }

    pub fn data(&self) -> MeshData {
        self.read().unwrap().data
    }

    pub fn note(&self) -> String {
        self.read().unwrap().notes.join("; ")
    }

    pub fn fault(&self) -> String {
        self.read().unwrap_err().to_string()
    }
}

/// A binary PPM: not a format that glTF knows, but one that needs no encoder.
pub fn picture(texels: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = format!("P6\n{} 1\n255\n", texels.len()).into_bytes();
    bytes.extend(texels.as_flattened());
    bytes
}

/// A triangle in a material with a picture of two texels.
pub fn textured(material: Value, texels: &[[u8; 3]]) -> Draft {
    let mut draft = Draft::triangle();
    let places = draft.accessor(&floats(&[0.0, 1.0, 1.0, 1.0, 0.5, 0.0]), (5126, 3, "VEC2"));
    draft.primitive()["attributes"]["TEXCOORD_0"] = json!(places);
    draft.primitive()["material"] = json!(0);
    draft.push("materials", material);
    let view = draft.view(&picture(texels));
    draft.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    draft.push("textures", json!({ "source": 0 }));
    draft
}
