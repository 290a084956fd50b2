//! What becomes of materials and their textures.

use crate::draft::{Draft, picture, textured};
use reflet_assets::{Assets, Cause};
use reflet_scene::{Maps, MeshData, Mirrored, TexelFilter, UvSet, Wrap};
use serde_json::{Value, json};

fn colours(data: &MeshData) -> [[f64; 3]; 3] {
    let [m] = &data.materials[..] else { panic!("{:?}", data.materials) };
    [m.ambient, m.diffuse, m.specular]
}

fn maps(data: &MeshData) -> &Maps {
    data.materials[0].maps.as_ref().expect("maps")
}

#[test]
fn metal_mirrors_by_its_smoothness_and_plastic_does_not() {
    let base = [1.0, 0.5, 0.25];
    for (metallic, roughness, share) in
        [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 1.0), (0.5, 0.5, 0.25)]
    {
        let mut draft = Draft::triangle();
        let metal = json!({
            "baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": metallic,
            "roughnessFactor": roughness,
        });
        draft.push("materials", json!({ "pbrMetallicRoughness": metal }));
        draft.primitive()["material"] = json!(0);
        let data = draft.data();
        let expected = [[0.0; 3], base.map(|x| x * (1.0 - share)), base.map(|x| x * share)];
        assert_eq!(colours(&data), expected);
        assert_eq!(data.materials[0].maps, None);
    }
}

#[test]
fn textures_are_factors_of_their_materials() {
    let texture = json!({ "index": 0 });
    let metal = json!({
        "baseColorTexture": texture, "baseColorFactor": [0.5, 1, 1, 1],
        "metallicRoughnessTexture": texture, "metallicFactor": 0.75,
    });
    let material = json!({
        "pbrMetallicRoughness": metal, "emissiveTexture": texture, "emissiveFactor": [0.25, 0, 0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } },
    });
    let draft = textured(material, &[[255, 0, 0], [0, 51, 255]]);
    let data = draft.data();
    assert_eq!(colours(&data), [[2.0, 0.0, 0.0], [0.5, 1.0, 1.0], [0.5, 1.0, 1.0]]);
    let maps = maps(&data);
    let [ambient, diffuse] = [&maps.ambient, &maps.diffuse].map(|map| map.as_ref().unwrap());
    assert!(ambient.is_same(diffuse) && maps.specular.as_ref().unwrap().is_same(diffuse));
    assert_eq!(diffuse.image.texels[0], [1.0, 0.0, 0.0]);
    let Mirrored::Metal { map, metalness, roughness } = &maps.mirrored else { panic!() };
    assert_eq!((*metalness, *roughness), (0.75, 1.0));
    // Not by the curve of colours: 51 is a fifth, but for the rounding of the way there and back.
    assert!((map.image.texels[1][1] - 0.2).abs() < 1e-6 && map.image.texels[1][2] == 1.0);
    assert_eq!(draft.note(), "");
}

#[test]
fn a_texture_lies_as_its_sampler_and_its_transform_say() {
    let transform = json!({ "offset": [0.5, 0], "scale": [2, 4], "texCoord": 1 });
    let texture = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
    let metal = json!({ "baseColorTexture": texture, "metallicFactor": 0 });
    let mut draft = textured(json!({ "pbrMetallicRoughness": metal }), &[[255; 3]]);
    draft.json["textures"][0]["sampler"] = json!(0);
    draft.push("samplers", json!({ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }));
    let second = draft.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"].clone();
    draft.primitive()["attributes"] = json!({ "POSITION": 0, "TEXCOORD_1": second });
    let data = draft.data();
    let map = maps(&data).diffuse.as_ref().unwrap();
    assert_eq!((map.filter, map.wrap), (TexelFilter::Nearest, [Wrap::Clamp, Wrap::Mirror]));
    // v goes up here: 1 - 4 (1 - v).
    assert_eq!((map.set, map.place), (UvSet::Second, [[2.0, 0.0, 0.5], [0.0, 4.0, -3.0]]));
    assert_eq!(data.second_uvs, [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]);
    assert!(data.uvs.is_empty());
    draft.primitive()["attributes"] = json!({ "POSITION": 0 });
    assert_eq!(draft.note(), "1 primitive without the texture coordinates of its textures");
}

#[test]
fn specular_and_glossiness_and_what_is_not_lit() {
    let gloss = json!({
        "diffuseFactor": [0.5, 0.5, 0.5, 1], "specularFactor": [0.25, 0, 0],
        "glossinessFactor": 0.5,
    });
    let with =
        |gloss: &Value| json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": gloss } });
    let mut draft = textured(with(&gloss), &[[255; 3]]);
    assert_eq!(colours(&draft.data()), [[0.0; 3], [0.375; 3], [0.125, 0.0, 0.0]]);
    let mut pictured = gloss.clone();
    pictured["specularGlossinessTexture"] = json!({ "index": 0 });
    draft.json["materials"][0] = with(&pictured);
    let data = draft.data();
    assert_eq!(colours(&data), [[0.0; 3], [0.5; 3], [0.125, 0.0, 0.0]]);
    assert_eq!(maps(&data).mirrored, Mirrored::Specular([0.25, 0.0, 0.0]));
    assert_eq!(draft.note(), "left out: glossiness of textures");
    draft.json["materials"][0] = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1, 1] },
        "extensions": { "KHR_materials_unlit": {} },
    });
    assert_eq!(colours(&draft.data()), [[0.5, 0.25, 1.0], [0.0; 3], [0.0; 3]]);
}

#[test]
fn vertex_colours_multiply_the_base_colour() {
    let mut draft = Draft::triangle();
    let colours = draft.accessor(&[255, 0, 51, 255].repeat(3), (5121, 3, "VEC4"));
    draft.json["accessors"][colours]["normalized"] = json!(true);
    draft.primitive()["attributes"]["COLOR_0"] = json!(colours);
    let more = json!({ "attributes": { "POSITION": 0 }, "material": 0 });
    draft.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(more);
    draft.push("materials", json!({ "name": "plain" }));
    let data = draft.data();
    assert_eq!(data.colours, [[[1.0, 0.0, 0.2]; 3], [[1.0; 3]; 3]].concat());
    let [bare, plain] = &data.materials[..] else { panic!("{:?}", data.materials) };
    assert_eq!((bare.name.as_str(), bare.diffuse), ("", [1.0; 3]));
    assert_eq!(bare.maps.as_ref().unwrap().by_vertex, [false, true, false]);
    assert_eq!(plain.maps, None);
}

#[test]
fn a_texture_that_cannot_be_read_leaves_no_glowing_mirror() {
    let texture = json!({ "index": 0 });
    let material = json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": texture, "metallicRoughnessTexture": texture,
            "roughnessFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1],
        },
        "emissiveTexture": texture, "emissiveFactor": [1, 1, 1],
    });
    let plain = [[0.0; 3], [0.5; 3], [0.0; 3]];
    let mut draft = textured(material, &[[255; 3]]);
    for (image, why) in [
        (json!({ "uri": "data:image/ktx2;base64,q0tUWCAyMLsNChoK" }), "image 0: is a KTX2 texture"),
        (json!({ "bufferView": 99 }), "image 0: buffer view 99 is asked for"),
        (json!({}), "image 0: holds nothing"),
        (
            json!({ "uri": "https://a.b/c.png" }),
            "`https://a.b/c.png`: `https://a.b/c.png` is on the",
        ),
    ] {
        draft.json["images"][0] = image;
        let file = draft.read().unwrap();
        assert_eq!(colours(&file.data), plain);
        let note = file.notes.join("; ");
        assert!(note.starts_with("1 texture not read, the factors stand alone ("), "{note}");
        assert!(note.contains(why), "{note}");
    }
    // Where one format cannot be read another may be there.
    let view = draft.view(&picture(&[[255; 3]]));
    draft.push("images", json!({ "bufferView": view }));
    draft.json["textures"][0] = json!({
        "source": 1, "extensions": { "KHR_texture_basisu": { "source": 0 } },
    });
    assert_eq!(draft.note(), "");
    assert!(maps(&draft.data()).diffuse.is_some());
    draft.json["textures"][0] = json!({ "extensions": { "EXT_texture_webp": { "source": 1 } } });
    assert_eq!(draft.note(), "");
}

#[test]
fn pictures_and_buffers_stand_beside_the_file() {
    let metal = json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 0 });
    let mut draft = textured(json!({ "pbrMetallicRoughness": metal }), &[[255; 3]]);
    let write = |image: &str, buffer: &str| {
        let mut json = draft.json.clone();
        json["images"][0] = json!({ "uri": image });
        json["buffers"] = json!([{ "uri": buffer, "byteLength": 1 << 20 }]);
        json.to_string()
    };
    let good = write("the%20maps\\a.ppm", "100%.bin");
    let outside = write("../secret.ppm", "100%.bin");
    let gone = write("a.ppm", "gone.bin");
    let room = tempfile::tempdir().unwrap();
    let scene = room.path().join("scene");
    std::fs::create_dir_all(scene.join("the maps")).unwrap();
    std::fs::write(scene.join("the maps/a.ppm"), picture(&[[255; 3]])).unwrap();
    std::fs::write(room.path().join("secret.ppm"), picture(&[[255; 3]])).unwrap();
    std::fs::write(scene.join("100%.bin"), std::mem::take(&mut draft.bytes)).unwrap();
    for (name, text) in [("good.gltf", good), ("outside.gltf", outside), ("gone.gltf", gone)] {
        std::fs::write(scene.join(name), text).unwrap();
    }
    let assets = Assets::new(scene.clone());
    assert!(assets.mesh("good.gltf").unwrap().materials[0].maps.is_some());
    assert!(assets.notes().is_empty() && assets.asked().contains(&scene.join("the maps/a.ppm")));
    assert_eq!(assets.mesh("outside.gltf").unwrap().materials[0].maps, None);
    let [note] = &assets.notes()[..] else { panic!("one note a file") };
    assert!(note.message.contains("`../secret.ppm`: a path with `..` is not allowed"), "{note}");
    assert_eq!(assets.mesh("gone.gltf").unwrap_err().cause(), Cause::Missing);
}
