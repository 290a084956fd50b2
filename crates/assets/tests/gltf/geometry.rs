//! What a file holds, how it is stored, and where it stands.

use crate::draft::{CORNERS, Draft, floats};
use reflet_assets::mesh::decode;
use serde_json::{Value, json};
use std::path::Path;

#[test]
fn what_a_file_holds_beside_its_triangles_is_no_fault() {
    let mut draft = Draft::triangle();
    let own = draft.accessor(&[1, 2, 3], (5121, 3, "SCALAR"));
    draft.primitive()["attributes"]["_FEATURE_ID_0"] = json!(own);
    draft.primitive()["attributes"]["_batch"] = json!(own);
    draft.primitive()["extras"] = json!([1, "two", null]);
    draft.json["extras"] = json!("a text");
    draft.json["nodes"][0]["extras"] = json!(3.5);
    draft.json["nodes"][0]["extensions"] = json!({ "ACME_unknown": [[], {}] });
    draft.json["asset"]["extras"] = json!({ "deep": { "er": [true] } });
    draft.json["extensions"] = json!({ "ACME_root": 1 });
    let file = draft.read().unwrap();
    assert_eq!((file.data.triangles.len(), file.notes.len()), (1, 0));
}

#[test]
fn required_extensions_that_say_nothing_of_geometry_are_told_and_left_out() {
    for name in ["KHR_lights_punctual", "KHR_materials_ior", "KHR_xmp_json_ld", "ACME_new"] {
        let mut draft = Draft::triangle();
        draft.json["extensionsRequired"] = json!([name]);
        draft.json["extensionsUsed"] = json!([name]);
        assert_eq!(draft.note(), format!("left out: {name}"));
    }
    for name in ["KHR_texture_transform", "KHR_mesh_quantization", "KHR_materials_unlit"] {
        let mut draft = Draft::triangle();
        draft.json["extensionsRequired"] = json!([name]);
        assert_eq!(draft.note(), "");
    }
    for (name, by) in [
        ("KHR_draco_mesh_compression", "Draco"),
        ("EXT_meshopt_compression", "meshopt"),
        ("KHR_meshopt_compression", "meshopt"),
    ] {
        let mut draft = Draft::triangle();
        draft.json["extensionsRequired"] = json!([name]);
        let fault = draft.fault();
        assert!(fault.contains(&format!("compressed with {by}")), "{fault}");
        // Not required: the plain data is there, or it is not.
        draft.json["extensionsRequired"] = json!([]);
        draft.json["extensionsUsed"] = json!([name]);
        assert_eq!(draft.note(), format!("left out: {name}"));
        draft.json["bufferViews"][0]["buffer"] = json!(1);
        assert!(draft.fault().contains(&format!("compressed with {by}")));
    }
}

#[test]
fn what_is_left_out_is_told_once() {
    let mut draft = Draft::triangle();
    let texture = json!({ "index": 7 });
    let material = json!({
        "alphaMode": "BLEND", "normalTexture": texture, "occlusionTexture": texture,
    });
    draft.push("materials", material);
    draft.primitive()["material"] = json!(0);
    draft.json["animations"] = json!([{ "channels": [] }, {}]);
    draft.json["cameras"] = json!([{}]);
    let expected = "left out: normal maps, occlusion maps, opacity, 2 animations, 1 camera";
    assert_eq!(draft.note(), expected);
}

#[test]
fn only_what_has_no_normals_goes_without() {
    let mut draft = Draft::triangle();
    let normals = draft.accessor(&floats(&[0.6, 0.0, 0.8].repeat(3)), (5126, 3, "VEC3"));
    draft.primitive()["attributes"]["NORMAL"] = json!(normals);
    let plain = json!({ "attributes": { "POSITION": 0 } });
    draft.json["meshes"][0]["primitives"].as_array_mut().unwrap().insert(0, plain.clone());
    draft.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(plain);
    let data = draft.data();
    assert_eq!(data.normals[..3], [[0.0; 3]; 3]);
    assert_eq!(data.normals[3..6], [[0.6, 0.0, 0.8]; 3]);
    assert_eq!(data.normals[6..], [[0.0; 3]; 3]);
}

#[test]
fn quantised_and_sparse_accessors_are_read() {
    let mut draft = Draft::triangle();
    let bytes: Vec<u8> = [[-2_i16, 0, 0, 9], [2, 0, 0, 9], [0, 4, 0, 9]]
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let shorts = draft.accessor(&bytes, (5122, 3, "VEC3"));
    let view = draft.json["accessors"][shorts]["bufferView"].as_u64().unwrap() as usize;
    draft.json["bufferViews"][view]["byteStride"] = json!(8);
    draft.primitive()["attributes"]["POSITION"] = json!(shorts);
    draft.json["nodes"][0]["scale"] = json!([0.5, 0.5, 0.5]);
    let normals = draft.accessor(&[0, 0, 127, 0, 0, 127, 129, 0, 0], (5120, 3, "VEC3"));
    draft.json["accessors"][normals]["normalized"] = json!(true);
    draft.primitive()["attributes"]["NORMAL"] = json!(normals);
    let data = draft.data();
    assert_eq!(data.positions, CORNERS);
    assert_eq!(data.normals, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]);

    let mut draft = Draft::triangle();
    let (indices, values) = (draft.view(&[2]), draft.view(&floats(&[0.0, 2.0, 7.0])));
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    draft.json["accessors"][0]["sparse"] = sparse;
    assert_eq!(draft.data().positions[2], [0.0, 2.0, 7.0]);
    // Of no view at all: zeros but for these.
    draft.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(draft.data().triangles.is_empty() && draft.note() == "1 triangle without area skipped");
    draft.json["accessors"][0]["sparse"]["indices"]["componentType"] = json!(5125);
    assert!(draft.fault().contains("accessor 0 reaches beyond its buffer"));
}

#[test]
fn strips_fans_and_few_of_many_vertices() {
    let quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0_f32]];
    let many = [&[[9.0; 3]; 100], &quad[..]].concat();
    for (mode, expected) in [(5, [[0, 1, 2], [2, 1, 3]]), (6, [[0, 1, 2], [0, 2, 3]])] {
        let mut draft = Draft::triangle();
        let positions = draft.accessor(&floats(many.as_flattened()), (5126, 104, "VEC3"));
        draft.primitive()["attributes"]["POSITION"] = json!(positions);
        let indices = draft.accessor(&[100, 101, 102, 103], (5121, 4, "SCALAR"));
        draft.primitive()["indices"] = json!(indices);
        draft.primitive()["mode"] = json!(mode);
        let data = draft.data();
        assert_eq!((data.positions.len(), &data.triangles[..]), (4, &expected[..]));
        draft.bytes[draft.json["bufferViews"][2]["byteOffset"].as_u64().unwrap() as usize] = 200;
        if mode == 6 {
            // Both have the corner that is not there.
            assert!(draft.fault().contains("its scene holds no triangle"));
        } else {
            let note = "1 triangle skipped: a corner is not there or not finite";
            assert_eq!((draft.data().triangles.len(), draft.note().as_str()), (1, note));
        }
    }
}

#[test]
fn a_skinned_mesh_follows_its_joints_and_not_its_node() {
    let mut draft = Draft::triangle();
    let joints = draft.accessor(&[1, 0, 0, 0].repeat(3), (5121, 3, "VEC4"));
    let weights = draft.accessor(&floats(&[1.0, 0.0, 0.0, 0.0].repeat(3)), (5126, 3, "VEC4"));
    draft.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    draft.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    let mut bind = [0.0; 32];
    for i in [0, 5, 10, 15] {
        (bind[i], bind[16 + i]) = (1.0, 1.0);
    }
    bind[16 + 12] = 1.0; // x + 1
    let bind = draft.accessor(&floats(&bind), (5126, 2, "MAT4"));
    draft.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": bind }]);
    draft.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
        { "children": [2], "translation": [0, 3, 0] },
        { "translation": [0, 0, 5] },
    ]);
    let moved = CORNERS.map(|[x, y, z]| [x + 1.0, y + 3.0, z + 5.0]);
    assert_eq!(draft.data().positions, moved);
    // What has no weights stands where its node does.
    draft.primitive()["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
    assert_eq!(draft.data().positions[0], [99.0, 0.0, 0.0]);
    draft.json["nodes"][2]["children"] = json!([1]);
    draft.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    assert!(draft.fault().contains("node 1 is above itself"), "{}", draft.fault());
}

#[test]
fn morph_targets_stand_at_their_default_weights() {
    let mut draft = Draft::triangle();
    let target = draft.accessor(&floats(&[0.0, 0.0, 4.0].repeat(3)), (5126, 3, "VEC3"));
    draft.primitive()["targets"] = json!([{ "POSITION": target }, { "POSITION": target }]);
    assert_eq!(draft.data().positions[0][2], 0.0);
    draft.json["meshes"][0]["weights"] = json!([0.5, 1]);
    assert_eq!(draft.data().positions[0][2], 6.0);
    // Those of a node come before those of its mesh.
    draft.json["nodes"][0]["weights"] = json!([0.25, 0]);
    assert_eq!(draft.data().positions[0][2], 1.0);
}

#[test]
fn instances_of_a_node_are_counted_before_they_are_built() {
    let mut draft = Draft::triangle();
    let ways = draft.accessor(&floats(&[10.0, 0.0, 0.0, 0.0, 20.0, 0.0]), (5126, 2, "VEC3"));
    let sizes = draft.accessor(&floats(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]), (5126, 2, "VEC3"));
    let attributes = json!({ "TRANSLATION": ways, "SCALE": sizes, "_OWN": 77 });
    draft.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let data = draft.data();
    assert_eq!(data.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!((data.positions[1], data.positions[4]), ([11.0, 0.0, 0.0], [2.0, 20.0, 0.0]));

    // 40,000 nodes of 1,000 triangles: 40 million from less than a megabyte.
    let mut draft = Draft::triangle();
    let indices = draft.accessor(&[0, 1, 2].repeat(1000), (5121, 3000, "SCALAR"));
    draft.primitive()["indices"] = json!(indices);
    let nodes: Vec<Value> = (0..40_000).map(|_| json!({ "mesh": 0 })).collect();
    draft.json["scenes"] = json!([{ "nodes": (0..40_000).collect::<Vec<_>>() }]);
    draft.json["nodes"] = json!(nodes);
    let fault = draft.fault();
    assert!(
        fault.contains("its nodes show 40000000 triangles, and 8388608 are the most"),
        "{fault}"
    );
}

#[test]
fn scenes_may_be_missing_and_nodes_hidden() {
    let mut draft = Draft::triangle();
    draft.json["scene"] = json!(5);
    assert_eq!(draft.data().triangles.len(), 1);
    draft.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(draft.data().triangles.len(), 1);
    draft.json.as_object_mut().unwrap().remove("scenes");
    draft.json["nodes"] = json!([{ "mesh": 0 }, { "children": [0], "translation": [0, 0, 2] }]);
    assert_eq!(draft.data().positions[0], [-1.0, 0.0, 2.0]);
    draft.json["nodes"] = json!([
        { "mesh": 0 },
        { "mesh": 0, "extensions": { "KHR_node_visibility": { "visible": false } } },
    ]);
    assert_eq!(draft.data().triangles.len(), 1);
}

#[test]
fn numbers_that_are_not_finite_cost_a_triangle_and_not_the_file() {
    let mut draft = Draft::triangle();
    let two = [CORNERS, CORNERS].concat();
    let mut positions = floats(two.as_flattened());
    positions[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let positions = draft.accessor(&positions, (5126, 6, "VEC3"));
    draft.primitive()["attributes"]["POSITION"] = json!(positions);
    let mut normals = floats(&[0.0, 0.0, 1.0].repeat(6));
    normals[12 * 4..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let normals = draft.accessor(&normals, (5126, 6, "VEC3"));
    draft.primitive()["attributes"]["NORMAL"] = json!(normals);
    let data = draft.data();
    assert_eq!(data.triangles, [[3, 4, 5]]);
    assert_eq!(data.normals[4], [0.0; 3]);
    assert_eq!(draft.note(), "1 triangle skipped: a corner is not there or not finite");
}

#[test]
fn containers_are_taken_as_they_are_written() {
    let mut draft = Draft::triangle();
    let bom = [&b"\xef\xbb\xbf"[..], &draft.text()].concat();
    let read = |name: &str, bytes: &[u8]| {
        decode(Path::new(name), bytes, &mut |_: &str| panic!("no other file"))
    };
    assert_eq!(read("a.gltf", &bom).unwrap().data.triangles.len(), 1);
    // A GLB whose JSON ends in zeros, with a chunk of another kind and bytes after its end.
    let mut buffers = draft.json.clone();
    buffers["buffers"] = json!([{ "byteLength": draft.bytes.len() }]);
    let mut json = buffers.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), 0);
    let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    draft.bytes.extend([0; 4]);
    for (kind, chunk) in [(b"JSON", &json), (b"ACME", &vec![7; 8]), (b"BIN\0", &draft.bytes)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb.extend([0; 3]);
    assert_eq!(read("a.glb", &glb).unwrap().data.triangles.len(), 1);
    glb[4] = 1;
    let old = read("a.glb", &glb).unwrap_err().to_string();
    assert!(old.contains("binary glTF 1, and version 2 is read"), "{old}");
    let old = br#"{"asset":{"version":"1.0"},"buffers":{"a":{}}}"#;
    let old = read("a.gltf", old).unwrap_err().to_string();
    assert!(old.contains("is glTF 1.0, and 2.0 is read"), "{old}");
}
