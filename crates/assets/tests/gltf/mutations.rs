//! Files with wrong values in them.

use crate::draft::{Draft, floats, textured};
use reflet_assets::mesh::decode;
use serde_json::{Value, json};
use std::path::Path;

/// A file of nearly all that is read.
fn everything() -> Draft {
    let texture = json!({
        "index": 0, "texCoord": 0,
        "extensions": { "KHR_texture_transform": { "scale": [2, 2], "rotation": 1 } },
    });
    let gloss = json!({ "diffuseTexture": texture, "specularGlossinessTexture": texture });
    let metal = json!({ "baseColorTexture": texture, "metallicRoughnessTexture": texture });
    let mut draft = textured(json!({ "pbrMetallicRoughness": metal }), &[[255; 3], [9, 8, 7]]);
    let glossy = json!({
        "emissiveTexture": texture, "emissiveFactor": [1, 1, 1],
        "extensions": { "KHR_materials_pbrSpecularGlossiness": gloss },
    });
    draft.push("materials", glossy);
    draft.push("samplers", json!({ "wrapS": 33648 }));
    let normals = draft.accessor(&[0, 0, 127, 0, 0, 127, 0, 0, 127], (5120, 3, "VEC3"));
    draft.json["accessors"][normals]["normalized"] = json!(true);
    let joints = draft.accessor(&[1, 0, 0, 0].repeat(3), (5121, 3, "VEC4"));
    let weights = draft.accessor(&floats(&[1.0, 0.0, 0.0, 0.0].repeat(3)), (5126, 3, "VEC4"));
    let one: Vec<f32> = (0..16).map(|i| f32::from(u8::from(i % 5 == 0))).collect();
    let bind = draft.accessor(&floats(&one.repeat(2)), (5126, 2, "MAT4"));
    let ways = draft.accessor(&floats(&[1.0; 6]), (5126, 2, "VEC3"));
    let indices = draft.accessor(&[0, 0, 1, 0, 2, 0], (5123, 3, "SCALAR"));
    let (at, values) = (draft.view(&[2]), draft.view(&floats(&[0.0, 2.0, 7.0])));
    draft.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": at, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let places = draft.primitive()["attributes"]["TEXCOORD_0"].clone();
    let all = json!({
        "POSITION": 0, "NORMAL": normals, "TEXCOORD_0": places, "COLOR_0": normals,
        "JOINTS_0": joints, "WEIGHTS_0": weights,
    });
    let targets = json!([{ "POSITION": 0, "NORMAL": normals }]);
    draft.json["meshes"][0] = json!({ "weights": [0.5], "primitives": [
        { "attributes": all, "indices": indices, "material": 0, "targets": targets },
        { "attributes": { "POSITION": 0 }, "mode": 5, "material": 1 },
    ] });
    draft.json["skins"] = json!([{ "joints": [2, 1], "inverseBindMatrices": bind }]);
    let attributes = json!({ "TRANSLATION": ways, "SCALE": ways });
    draft.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "children": [1] },
        { "children": [2], "rotation": [0, 0, 0, 1], "scale": [1, -1, 1] },
        { "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } },
    ]);
    draft
}

/// Numbers that are the same on every machine (Marsaglia, "Xorshift RNGs", 2003).
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % n
    }
}

/// How many values there are in a value, itself counted.
fn size(value: &Value) -> usize {
    1 + match value {
        Value::Array(all) => all.iter().map(size).sum(),
        Value::Object(all) => all.values().map(size).sum(),
        _ => 0,
    }
}

/// Puts another value in place of number `at`.
fn replace(value: &mut Value, mut at: usize, by: &Value) {
    if at == 0 {
        *value = by.clone();
        return;
    }
    at -= 1;
    let parts: Vec<&mut Value> = match value {
        Value::Array(all) => all.iter_mut().collect(),
        Value::Object(all) => all.iter_mut().map(|(_, part)| part).collect(),
        _ => return,
    };
    for part in parts {
        let own = size(part);
        if at < own {
            return replace(part, at, by);
        }
        at -= own;
    }
}

/// A million of them, by `REFLET_FUZZ_CASES=1000000`, found nothing.
#[test]
fn wrong_values_anywhere_are_faults_and_never_panics() {
    let given = std::env::var("REFLET_FUZZ_CASES").ok().and_then(|n| n.parse().ok());
    let cases: u32 = given.unwrap_or(3000);
    let others = json!([
        0,
        1,
        2,
        3,
        5,
        255,
        -1,
        0.5,
        1e300,
        -1e300,
        4_294_967_295_u32,
        18_446_744_073_709_551_615_u64,
        null,
        true,
        "",
        "data:;base64,AAAA",
        [],
        {},
        [0, 0, 0],
        5120,
        5122,
        5125,
        "VEC2",
        "MAT4",
    ]);
    let others = others.as_array().unwrap();
    let whole = everything();
    assert_eq!(whole.data().triangles.len(), 6);
    let mut dice = Dice(0x9e37_79b9_7f4a_7c15);
    for _ in 0..cases {
        let mut draft = Draft { json: whole.json.clone(), bytes: whole.bytes.clone() };
        for _ in 0..1 + dice.below(4) {
            if dice.below(4) == 0 {
                let (at, byte) = (dice.below(draft.bytes.len()), dice.below(256) as u8);
                draft.bytes[at] = byte;
            } else {
                let (at, by) = (dice.below(size(&draft.json)), dice.below(others.len()));
                replace(&mut draft.json, at, &others[by]);
            }
        }
        if !draft.json.is_object() {
            continue;
        }
        let none = reflet_assets::Assets::new("no such folder".into());
        let nothing = |name: &str| Err(none.mesh(name).expect_err("there is no such folder"));
        let Ok(file) = decode(Path::new("a.gltf"), &draft.text(), &mut { nothing }) else {
            continue;
        };
        let data = file.data;
        let count = data.positions.len();
        assert!(data.triangles.iter().flatten().all(|corner| (*corner as usize) < count));
        for length in
            [data.normals.len(), data.uvs.len(), data.second_uvs.len(), data.colours.len()]
        {
            assert!(length == 0 || length == count);
        }
        assert!(data.positions.iter().flatten().all(|x| x.is_finite()));
        assert_eq!(
            data.triangle_materials.len(),
            if data.materials.is_empty() { 0 } else { data.triangles.len() }
        );
        assert!(data.triangle_materials.iter().all(|m| (*m as usize) < data.materials.len()));
    }
}
