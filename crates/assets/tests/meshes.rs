//! Mesh files of every format, whole and broken.

use proptest::prelude::*;
use reflet_assets::{AssetError, Assets, Cause, mesh};
use reflet_scene::MeshData;
use std::path::Path;

/// A unit square of two triangles in the plane z = 0.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn decode(name: &str, bytes: &[u8]) -> Result<mesh::MeshFile, AssetError> {
    mesh::decode(Path::new(name), bytes, &mut |name| {
        Err(reflet_assets::jail::open(Path::new("/nowhere"), name).expect_err("no such folder"))
    })
}

fn whole(name: &str, bytes: &[u8]) -> MeshData {
    decode(name, bytes).unwrap_or_else(|error| panic!("{error}")).data
}

fn ascii_ply() -> Vec<u8> {
    let mut text = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\n\
        property float y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        property uchar red\nproperty float s\nproperty float t\nelement face 1\n\
        property list uchar int vertex_indices\nproperty float quality\nelement edge 1\n\
        property int a\nproperty int b\nend_header\n"
        .to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z} 0 0 2 255 {x} {y}\n");
    }
    (text + "4 0 1 2 3 0.5\n0 1\n").into_bytes()
}

/// The same mesh in binary, of the byte order that `put` gives numbers.
fn binary_ply(order: &str, put: fn(&mut Vec<u8>, f64, &str)) -> Vec<u8> {
    let text = String::from_utf8(ascii_ply()).unwrap();
    let head = text.split_inclusive("end_header\n").next().unwrap();
    let mut bytes = head.replace("ascii", order).into_bytes();
    for [x, y, z] in CORNERS.map(|corner| corner.map(f64::from)) {
        for (value, kind) in [(x, "f"), (y, "f"), (z, "d"), (0.0, "f"), (0.0, "f"), (2.0, "f")] {
            put(&mut bytes, value, kind);
        }
        for (value, kind) in [(255.0, "c"), (x, "f"), (y, "f")] {
            put(&mut bytes, value, kind);
        }
    }
    put(&mut bytes, 4.0, "c");
    (0..4).for_each(|i| put(&mut bytes, f64::from(i), "i"));
    put(&mut bytes, 0.5, "f");
    put(&mut bytes, 0.0, "i");
    put(&mut bytes, 1.0, "i");
    bytes
}

fn raw(value: f64, kind: &str) -> Vec<u8> {
    match kind {
        "c" => vec![value as u8],
        "i" => (value as i32).to_le_bytes().to_vec(),
        "f" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    }
}

fn little() -> Vec<u8> {
    binary_ply("binary_little_endian", |bytes, value, kind| bytes.extend(raw(value, kind)))
}

fn big() -> Vec<u8> {
    binary_ply("binary_big_endian", |bytes, value, kind| {
        bytes.extend(raw(value, kind).into_iter().rev());
    })
}

const TRIANGLES: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn ascii_stl() -> Vec<u8> {
    let mut text = "solid a square of two\n".to_owned();
    for triangle in TRIANGLES {
        text += "  facet normal 0 0 1\n    outer loop\n";
        for [x, y, z] in triangle.map(|corner| CORNERS[corner]) {
            text += &format!("      vertex {x} {y} {z:e}\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    (text + "endsolid a square of two\n").into_bytes()
}

fn binary_stl() -> Vec<u8> {
    // Some programs begin binary files like texts.
    let mut bytes = b"solid".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for triangle in TRIANGLES {
        bytes.extend([0; 12]);
        for corner in triangle.map(|corner| CORNERS[corner]) {
            corner.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// The buffer of a glTF file: positions, normals, places in a texture, indices of 16 bits.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    CORNERS.iter().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
    (0..4).for_each(|_| [0.0_f32, 0.0, 1.0].iter().for_each(|v| bytes.extend(v.to_le_bytes())));
    for [x, y, _] in CORNERS {
        [x, 1.0 - y].iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    TRIANGLES.iter().flatten().for_each(|index| bytes.extend((*index as u16).to_le_bytes()));
    bytes
}

fn gltf_json(buffer: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"translation":[10,0,0],"children":[1]}},{{"mesh":0,"scale":[2,-1,1]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,
"material":0}},{{"attributes":{{"POSITION":0}},"mode":0}}]}}],
"materials":[{{"name":"gold","emissiveFactor":[0.5,0,0],
"pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0.25,1],"metallicFactor":0.75,"roughnessFactor":0}}}}],
"accessors":[
{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":0,"byteOffset":48,"componentType":5126,"count":4,"type":"VEC3"}},
{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
{{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":96}},{{"buffer":0,"byteOffset":96,"byteLength":32}},
{{"buffer":0,"byteOffset":128,"byteLength":12}}],"buffers":[{{{buffer}"byteLength":140}}]}}"#
    )
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = |chunk: &[u8]| {
        let bits = chunk.iter().fold(0_u32, |bits, b| bits << 8 | u32::from(*b));
        let bits = bits << (8 * (3 - chunk.len()));
        let digit = |i: usize| match i <= chunk.len() {
            true => char::from(DIGITS[(bits >> (18 - 6 * i)) as usize & 63]),
            false => '=',
        };
        (0..4).map(digit).collect::<String>()
    };
    bytes.chunks(3).map(digits).collect()
}

fn embedded() -> Vec<u8> {
    let uri = format!(r#""uri":"data:application/octet-stream;base64,{}","#, base64(&buffer()));
    gltf_json(&uri).into_bytes()
}

fn glb() -> Vec<u8> {
    let mut json = gltf_json("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let data = buffer();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((12 + 8 + json.len() as u32 + 8 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &data)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn obj() -> Vec<u8> {
    b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 3\n\
      f 1/1/1 2/2/1 3/3/1 4/4/1\n"
        .to_vec()
}

/// All formats, by the name of a file.
fn all() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("a.obj", obj()),
        ("a.ply", ascii_ply()),
        ("b.ply", little()),
        ("c.PLY", big()),
        ("a.stl", ascii_stl()),
        ("b.stl", binary_stl()),
        ("a.gltf", embedded()),
        ("a.glb", glb()),
    ]
}

#[test]
fn one_square_in_all_formats() {
    for (name, bytes) in all() {
        let data = whole(name, &bytes);
        let gltf = name.contains(".g");
        let corners = match gltf {
            true => CORNERS.map(|[x, y, z]| [10.0 + 2.0 * x, -y, z]),
            false => CORNERS,
        };
        assert_eq!(data.positions, corners, "{name}");
        // A transform that mirrors turns triangles over.
        let want = if gltf { [[0, 2, 1], [0, 3, 2]] } else { [[0, 1, 2], [0, 2, 3]] };
        assert_eq!(data.triangles, want, "{name}");
        if name.ends_with(".stl") {
            assert!(data.normals.is_empty() && data.uvs.is_empty(), "{name}");
        } else {
            assert_eq!(data.normals, [[0.0, 0.0, 1.0]; 4], "{name}");
            assert_eq!(data.uvs, CORNERS.map(|[x, y, _]| [x, y]), "{name}");
        }
        if !gltf {
            assert!(data.materials.is_empty() && data.triangle_materials.is_empty(), "{name}");
            continue;
        }
        assert_eq!(data.triangle_materials, [0, 0]);
        let [gold] = &data.materials[..] else { panic!("{:?}", data.materials) };
        assert_eq!((gold.name.as_str(), gold.ambient), ("gold", [0.5, 0.0, 0.0]));
        assert_eq!((gold.diffuse, gold.specular), ([0.25, 0.125, 0.0625], [0.75, 0.375, 0.1875]));
        let notes = decode(name, &bytes).unwrap().notes;
        assert_eq!(notes, ["1 primitive of points or lines skipped"]);
    }
}

#[test]
fn broken_files_are_errors_with_a_place_and_never_panics() {
    for (name, bytes) in all() {
        for cut in 0..bytes.len() {
            // What is cut at a blank at the end is whole.
            if let Err(error) = decode(name, &bytes[..cut]) {
                assert_eq!(error.cause(), Cause::Broken, "{name} cut at {cut}: {error}");
            }
        }
        // An STL text that is cut between two facets lacks no more than its end.
        let half = decode(name, &bytes[..bytes.len() / 2]);
        assert!(half.is_ok_and(|file| !file.notes.is_empty()) == (name == "a.stl"), "{name}");
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut bad = bytes.clone();
                bad[at] ^= 1 << bit;
                if let Ok(file) = decode(name, &bad) {
                    sound(&file.data);
                }
            }
        }
    }
}

/// Every index leads somewhere, and every number is finite.
fn sound(data: &MeshData) {
    let count = data.positions.len();
    assert!(data.triangles.iter().flatten().all(|index| (*index as usize) < count));
    assert!(data.normals.is_empty() || data.normals.len() == count);
    assert!(data.uvs.is_empty() || data.uvs.len() == count);
    let worn = &data.triangle_materials;
    assert!(worn.is_empty() || worn.len() == data.triangles.len());
    assert!(worn.iter().all(|index| (*index as usize) < data.materials.len()));
    assert!(data.positions.iter().chain(&data.normals).flatten().all(|value| value.is_finite()));
    assert!(data.uvs.iter().flatten().all(|value| value.is_finite()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn several_wrong_bytes_at_once(
        which in 0..8_usize,
        wrong in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        cut in any::<prop::sample::Index>(),
        cuts in any::<bool>(),
    ) {
        let (name, mut bytes) = all().swap_remove(which);
        for (at, byte) in wrong {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cuts {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(file) = decode(name, &bytes) {
            sound(&file.data);
        }
    }
}

#[test]
fn faults_name_their_place() {
    let replaced = |bytes: Vec<u8>, from: &str, to: &str| {
        String::from_utf8(bytes).unwrap().replacen(from, to, 1).into_bytes()
    };
    let mut far = little();
    let at = far.len() - 12 - 4;
    far[at..at + 4].copy_from_slice(&9_i32.to_le_bytes());
    let cases: Vec<(&str, Vec<u8>, String)> = vec![
        ("a.ply", b"plx\n".to_vec(), "a.ply:1: does not begin with `ply`; is it a PLY file?".into()),
        (
            "a.ply",
            replaced(ascii_ply(), "property float y", "property flaot y"),
            "a.ply:6: `property flaot y` is no line of a PLY file's head".into(),
        ),
        ("a.ply", replaced(ascii_ply(), "1 1 0", "1 one 0"), "a.ply:23: `one` is not a number".into()),
        (
            "a.ply",
            replaced(ascii_ply(), "4 0 1 2 3", "2 0 1"),
            "a.ply: holds 4 vertices and no face: a point cloud is no surface (1 face of fewer than three corners skipped (line 25); not read: `vertex.red`, `face.quality`, `edge`)".into(),
        ),
        ("b.ply", far, format!("b.ply: byte {at}: vertex 9 is asked for, there are 4 (counted from 0)")),
        (
            "b.ply",
            little()[..little().len() - 9].to_vec(),
            format!("b.ply: byte {}: the file ends too early", little().len() - 12),
        ),
        (
            "a.stl",
            replaced(ascii_stl(), "endloop", "endlop"),
            "a.stl:7: `endlop` stands where `endloop` belongs".into(),
        ),
        (
            "a.stl",
            replaced(ascii_stl(), "vertex 1 0", "vertex x 0"),
            "a.stl:5: `x` is not a number; mend the `vertex` line".into(),
        ),
        (
            "b.stl",
            [&[b' '; 80][..], &[2, 0, 0, 0], &[0; 50]].concat(),
            "b.stl: byte 80: announces 2 facets, which take 184 bytes, and has 134; is it an STL file?"
                .into(),
        ),
        (
            "a.gltf",
            replaced(embedded(), r#""count":6"#, r#""count":7"#),
            "a.gltf: mesh 0, primitive 0: accessor 3 reaches beyond its buffer".into(),
        ),
        (
            "a.gltf",
            replaced(embedded(), r#""children":[1]"#, r#""children":[0]"#),
            "a.gltf: node 0 has two parents, or is its own".into(),
        ),
        ("a.fbx", b"x".to_vec(), "a.fbx: a mesh file ends in .obj, .ply, .stl, .gltf or .glb".into()),
    ];
    for (name, bytes, message) in cases {
        assert_eq!(decode(name, &bytes).unwrap_err().to_string(), message);
    }
}

fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

#[test]
fn a_gltf_reads_buffers_beside_it_and_nowhere_else() {
    let named = |uri: &str| gltf_json(&format!(r#""uri":"{uri}","#));
    let (good, up) = (named("the%20data.bin"), named("../secret.bin"));
    let (absolute, web) = (named("/etc/passwd"), named("https://example.org/a.bin"));
    let data = buffer();
    let room = folder(&[
        ("scene/m/a.gltf", good.as_bytes()),
        ("scene/m/the data.bin", &data),
        ("scene/up.gltf", up.as_bytes()),
        ("scene/absolute.gltf", absolute.as_bytes()),
        ("scene/web.gltf", web.as_bytes()),
        ("secret.bin", &data),
    ]);
    let assets = Assets::new(room.path().join("scene"));
    assert_eq!(assets.mesh("m/a.gltf").unwrap().triangles.len(), 2);
    assert!(assets.asked().contains(&room.path().join("scene/m/the data.bin")));
    assert_eq!(assets.mesh("up.gltf").unwrap_err().cause(), Cause::Forbidden);
    assert_eq!(assets.mesh("absolute.gltf").unwrap_err().cause(), Cause::Forbidden);
    let web = assets.mesh("web.gltf").unwrap_err().to_string();
    assert!(web.contains("is on the network; store it beside the file"), "{web}");
}

#[test]
fn an_obj_wears_the_materials_of_its_libraries() {
    let obj = "mtllib two words.mtl\nmtllib b.mtl gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n\
               usemtl red\nf 1 2 3\nusemtl lost\nf 1 2 3\nf 1 1 2\nusemtl red\nf 1 2 3\n";
    let room = folder(&[
        ("m/a.obj", obj.as_bytes()),
        ("m/two words.mtl", b"newmtl red\nKd 1 0 0\nKs 0.5\n"),
        ("m/b.mtl", b"newmtl other\nKd 0 1 0\n"),
        ("m/bad.obj", b"mtllib bad.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"),
        ("m/bad.mtl", b"newmtl a\nKd 1 x 0\n"),
    ]);
    let assets = Assets::new(room.path().to_owned());
    let mesh = assets.mesh("m/a.obj").unwrap();
    assert_eq!(mesh.triangle_materials, [0, 1, 2, 1], "that without area is left out");
    let names: Vec<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["", "red", "lost"]);
    assert_eq!(
        (mesh.materials[1].diffuse, mesh.materials[1].specular),
        ([1.0, 0.0, 0.0], [0.5; 3])
    );
    assert_eq!(mesh.materials[2].diffuse, mesh.materials[0].diffuse);
    let notes: Vec<String> = assets.notes().into_iter().map(|note| note.message).collect();
    let [note] = &notes[..] else { panic!("one note a file: {notes:?}") };
    let notes: Vec<&str> = note.split("; ").collect();
    assert_eq!(notes[0], "1 triangle without area skipped");
    assert!(notes[1].starts_with("its materials in `gone.mtl` are grey: there is no such file"));
    assert_eq!(notes[3], "1 material not found and grey, the first `lost`");
    let error = assets.mesh("m/bad.obj").unwrap_err();
    let path = room.path().join("m/bad.mtl").display().to_string();
    assert_eq!(error.to_string(), format!("{path}:2: `x` is not a number; mend the `Kd` line"));
    for name in ["m/two words.mtl", "m/b.mtl", "m/gone.mtl", "m/bad.mtl"] {
        assert!(assets.asked().contains(&room.path().join(name)), "{name} is watched");
    }
}

#[test]
fn an_obj_splits_vertices_only_where_corners_differ() {
    let head = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvt 0.5 0.5\n";
    let normals = "vn 0 0 2\nvn 0 0 0\n";
    let data = |more: &str| whole("a.obj", format!("{head}{normals}{more}").as_bytes());
    let split = data("f 1/1/1 2/1/1 3/1/1\nf 1/2/2 3/1/1 4/1/1\n");
    assert_eq!(split.triangles, [[0, 1, 2], [3, 2, 4]]);
    assert_eq!(split.positions[3], split.positions[0]);
    assert_eq!(split.uvs[3], [0.5, 0.5]);
    // A normal of no length becomes that of the triangles around it.
    assert_eq!(split.normals, [[0.0, 0.0, 1.0]; 5]);
    let plain = data("f 1/1 2/1 3/1\nf 1 3 4\n");
    assert_eq!((plain.positions.len(), plain.uvs.len()), (6, 6));
}

#[test]
fn other_folders_are_looked_in_after_the_scripts_own() {
    let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let room = folder(&[
        ("scene/own.obj", triangle),
        ("scene/both.obj", triangle),
        ("one/both.obj", b"broken f"),
        ("one/first.obj", triangle),
        ("two/first.obj", b"broken f"),
        ("two/second.obj", triangle),
        ("secret.obj", triangle),
    ]);
    let at = |name: &str| room.path().join(name);
    let assets = Assets::new(at("scene")).with_folders([at("one"), at("two")]);
    for name in ["own.obj", "both.obj", "first.obj", "second.obj"] {
        assert_eq!(assets.mesh(name).unwrap().triangles.len(), 1, "{name}");
    }
    let error = assets.mesh("none.obj").unwrap_err();
    assert_eq!(error.cause(), Cause::Missing);
    assert!(error.to_string().ends_with(", nor is it in the 2 others"), "{error}");
    assert_eq!(assets.mesh("../secret.obj").unwrap_err().cause(), Cause::Forbidden);
    let absolute = at("one/first.obj");
    assert_eq!(assets.mesh(absolute.to_str().unwrap()).unwrap_err().cause(), Cause::Forbidden);
}

/// Run with `cargo test --release -p reflet-assets -- --ignored --nocapture`: it measures.
#[test]
#[ignore = "measures, does not judge"]
fn a_million_triangles() {
    let n = 708_u32; // vertices along an edge: 2 * 707 * 707 triangles
    let vertices: Vec<[f32; 3]> = (0..n * n)
        .map(|i| {
            let (x, y) = ((i % n) as f32 * 0.123_456_7, (i / n) as f32 * 0.123_456_7);
            [x, y, (x * y).sin()]
        })
        .collect();
    let triangles: Vec<[u32; 3]> = (0..n * (n - 1))
        .filter(|i| i % n != n - 1)
        .flat_map(|i| [[i, i + 1, i + n], [i + n, i + 1, i + n + 1]])
        .collect();
    let lines = |head: &str, tail: &str, each: &dyn Fn(&[u32; 3]) -> String| {
        let text: String = triangles.iter().map(each).collect();
        (head.to_owned() + &text + tail).into_bytes()
    };
    let words = |[x, y, z]: [f32; 3]| format!("{x:.6} {y:.6} {z:.6}");
    let v: String = vertices.iter().map(|p| format!("v {}\n", words(*p))).collect();
    let vn: String =
        vertices.iter().map(|p| format!("vt {:.4} {:.4}\nvn 0 0 1\n", p[0], p[1])).collect();
    let ply_head = |format: &str| {
        let (v, f) = (vertices.len(), triangles.len());
        format!(
            "ply\nformat {format} 1.0\nelement vertex {v}\nproperty float x\nproperty float y\n\
             property float z\nelement face {f}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let plain: String = vertices.iter().map(|p| words(*p) + "\n").collect();
    let raw: Vec<u8> = vertices.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let faces: Vec<u8> = triangles
        .iter()
        .flat_map(|t| [3_u8].into_iter().chain(t.iter().flat_map(|i| i.to_le_bytes())))
        .collect();
    let indices: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let at = |i: u32| vertices[i as usize];
    let mut stl = vec![b' '; 80];
    stl.extend((triangles.len() as u32).to_le_bytes());
    for triangle in &triangles {
        stl.extend([0; 12]);
        triangle.iter().flat_map(|i| at(*i)).for_each(|value| stl.extend(value.to_le_bytes()));
        stl.extend([0; 2]);
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],"accessors":[
{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
{{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}],"bufferViews":[
{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],
"buffers":[{{"byteLength":{}}}]}}"#,
        vertices.len(),
        triangles.len() * 3,
        raw.len(),
        raw.len(),
        indices.len(),
        raw.len() + indices.len()
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let data = [raw.clone(), indices].concat();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &data)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    for (name, bytes) in [
        ("v, f.obj", lines(&v, "", &|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1))),
        (
            "v, vt, vn, f.obj",
            lines(&(v.clone() + &vn), "", &|t| {
                let [a, b, c] = t.map(|i| i + 1);
                format!("f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\n")
            }),
        ),
        (
            "ascii.ply",
            lines(&(ply_head("ascii") + &plain), "", &|[a, b, c]| format!("3 {a} {b} {c}\n")),
        ),
        ("binary.ply", [ply_head("binary_little_endian").into_bytes(), raw, faces].concat()),
        (
            "ascii.stl",
            lines("solid a\n", "endsolid a\n", &|t| {
                let [a, b, c] = t.map(|i| words(at(i)));
                format!(
                    "facet normal 0 0 1\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\n\
                     endfacet\n"
                )
            }),
        ),
        ("binary.stl", stl),
        ("a.glb", glb),
    ] {
        let begin = std::time::Instant::now();
        let data = whole(name, &bytes);
        let took = begin.elapsed();
        println!("{name}: {} triangles, {} MB: {took:?}", data.triangles.len(), bytes.len() >> 20);
        assert_eq!(data.triangles.len(), triangles.len());
        assert_eq!(data.positions.len(), vertices.len(), "{name}");
    }
}
