//! Mesh files and materials as other programs write them.

use reflet_assets::{AssetError, Assets, Cause, mesh};
use reflet_scene::{Map, MeshData, MeshMaterial, Wrap};
use std::path::Path;

fn decode(name: &str, bytes: &[u8]) -> Result<mesh::MeshFile, AssetError> {
    mesh::decode(Path::new(name), bytes, &mut |name| {
        Err(reflet_assets::jail::open(Path::new("/nowhere"), name).expect_err("no such folder"))
    })
}

fn whole(name: &str, bytes: &[u8]) -> MeshData {
    decode(name, bytes).unwrap_or_else(|error| panic!("{error}")).data
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

const FOUR: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\n";

fn facet(corners: [[f32; 3]; 3], attribute: u16) -> Vec<u8> {
    let numbers = corners.iter().flatten().flat_map(|x| x.to_le_bytes());
    [0; 12].into_iter().chain(numbers).chain(attribute.to_le_bytes()).collect()
}

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn stl(head: &[u8], count: u32, facets: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    facets.iter().for_each(|facet| bytes.extend(facet));
    bytes
}

#[test]
fn binary_stl_with_more_behind_its_facets() {
    for head in [&b"exported"[..], b"solid facet normal"] {
        let mut bytes = stl(head, 1, &[facet(CORNERS, 0)]);
        bytes.push(b'\n');
        let file = decode("a.stl", &bytes).unwrap();
        assert_eq!(file.data.triangles, [[0, 1, 2]]);
        assert_eq!(file.notes, ["1 byte after the facets left out"]);
    }
    let mut odd = CORNERS;
    odd[1][2] = f32::NAN;
    let file = decode("a.stl", &stl(b"", 2, &[facet(odd, 0), facet(CORNERS, 0x8000)])).unwrap();
    assert_eq!(file.data.triangles.len(), 1);
    assert_eq!(
        file.notes,
        [
            "1 facet has attribute bytes (a colour?), which are left out",
            "1 face with a corner whose position is not finite skipped"
        ]
    );
    // Cut off, and begun like a text: no byte of it is in the message.
    let cut = &stl(b"solid \x01\x02", 9, &[facet(CORNERS, 0)])[..];
    let said = decode("a.stl", cut).unwrap_err().to_string();
    assert_eq!(
        said,
        "a.stl: byte 80: announces 9 facets, which take 534 bytes, and has 134; is it an STL file?"
    );
}

#[test]
fn ascii_stl_in_every_dress() {
    let one = "facet normal nan nan nan outer loop vertex 0 0 0 vertex 1E0 0 0 vertex 0 +1. 0 endloop endfacet";
    for text in [
        format!("solid\n{one}\nendsolid\n"),
        format!("  SOLID x\r\n{}\r\nENDSOLID x\r\n", one.to_uppercase().replace("NAN", "nan")),
        format!("\u{feff}solid a\n{one}\nendsolid a\nsolid b\nendsolid b"),
        format!("solid a\n\n\t{}\n\nendsolid", one.replace(' ', "\n  ")),
    ] {
        let file = decode("a.stl", text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((file.data.triangles.len(), file.notes.len()), (1, 0), "{text}");
    }
    let text = format!("solid\n{one}\n{}\n", one.replace("1E0", "inf"));
    let notes = decode("a.stl", text.as_bytes()).unwrap().notes;
    let not_finite = "1 face with a corner whose position is not finite skipped";
    assert_eq!(notes, ["1 `endsolid` is missing at the end", not_finite]);
}

/// A head with these elements, and the values of a square and what follows.
fn ply(vertex: &str, elements: &str, values: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement vertex 4\nproperty float x\n\
         property float y\nproperty float z\n{vertex}{elements}end_header\n{values}"
    )
    .into_bytes()
}

const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";

#[test]
fn ply_with_strips() {
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let data = whole("a.ply", &ply("", strips, &format!("{SQUARE}9 0 1 3 2 -1 0 1 2 -1\n")));
    assert_eq!(data.triangles, [[0, 1, 3], [3, 1, 2], [0, 1, 2]]);
}

#[test]
fn ply_colours_are_worn() {
    let colours =
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    let rows =
        "0 0 0 255 0 128 255\n1 0 0 255 255 255 9\n1 1 0 0 0 0 0\n0 1 0 0 0 0 0\n4 0 1 2 3\n";
    let file = decode("a.ply", &ply(colours, FACES, rows)).unwrap();
    // sRGB 128 of 255 is 0.2158605 in linear intensities.
    assert_eq!(file.data.colours[..2], [[1.0, 0.0, 0.215_860_5], [1.0; 3]]);
    let [material] = &file.data.materials[..] else { panic!() };
    assert_eq!((material.diffuse, material.specular), ([1.0; 3], [0.0; 3]));
    assert_eq!(material.maps.as_ref().unwrap().by_vertex, [false, true, false]);
    assert_eq!(file.notes, ["not read: `vertex.alpha`"]);
    let floats = colours.replace("uchar", "float");
    let rows = rows.replace("255 0 128 255", "1 0 0.5 1");
    let data = whole("a.ply", &ply(&floats, FACES, &rows));
    assert_eq!(data.colours[0], [1.0, 0.0, 0.214_041_14]);
}

#[test]
fn ply_faces_that_are_none_are_counted() {
    let faces = FACES.replace("face 1", "face 5");
    let values = "0 0 0\n1 0 0\n1 1 0\nnan 1 0\n2 0 1\n0\n3 0 1 2\n4 0 1 2 3\n3 0 0 1\n";
    let file = decode("a.ply", &ply("", &faces, values)).unwrap();
    assert_eq!(file.data.triangles, [[0, 1, 2]]);
    assert_eq!(
        file.notes,
        [
            "2 faces of fewer than three corners skipped (the first in line 16)",
            "1 face with a corner whose position is not finite skipped",
            "1 triangle without area skipped"
        ]
    );
    let from_1 = ply("", FACES, &format!("{SQUARE}4 1 2 3 4\n"));
    let said = decode("a.ply", &from_1).unwrap_err().to_string();
    assert_eq!(said, "a.ply:16: vertex 4 is asked for, there are 4; they are counted from 0");
    let cloud = decode("a.ply", &ply("", "", SQUARE)).unwrap_err().to_string();
    assert_eq!(cloud, "a.ply: holds 4 vertices and no face: a point cloud is no surface");
}

#[test]
fn ply_normals_that_are_none_are_those_around() {
    let normals = "property float nx\nproperty float ny\nproperty float nz\n";
    let rows = "0 0 0 nan nan nan\n1 0 0 -nan(ind) 0 0\n1 1 0 0 0 0\n0 1 0 1 0 0\n4 0 1 2 3\n";
    let data = whole("a.ply", &ply(normals, FACES, rows));
    assert_eq!(data.normals[..3], [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(data.normals[3], [1.0, 0.0, 0.0]);
}

#[test]
fn what_is_no_mesh_is_told_by_its_format() {
    let mut long = b"\x89PNG".to_vec();
    long.resize(4000, 0);
    for (name, bytes, said) in [
        ("a.obj", &b""[..], "a.obj: is empty"),
        ("a.stl", b"", "a.stl: is empty"),
        (
            "a.obj.gz",
            b"\x1f\x8b\x08",
            "a.obj.gz: is a file compressed by gzip; unpack it (`gunzip`)",
        ),
        ("a.ply", b"PK\x03\x04", "a.ply: is a ZIP archive; unpack it"),
        ("a.obj", b"\xff\xfev\0 \0", "a.obj: is a text in UTF-16; save it as UTF-8"),
        ("a.ply", b"\xfe\xff\0p", "a.ply: is a text in UTF-16; save it as UTF-8"),
        ("a.stl", b"\xff\xfes\0", "a.stl: is a text in UTF-16; save it as UTF-8"),
        ("a.obj", b"ply\nformat", "a.obj: is a PLY file; let its name end in .ply"),
        ("a.stl", b"glTF\x02", "a.stl: is a GLB file; let its name end in .glb"),
        ("a.obj", b"\n <!DOCTYPE html>", "a.obj: is an HTML page; download the file itself"),
        ("a.stl", &long, "a.stl: is a PNG picture"),
        ("a.fbx", b"Kaydara FBX Binary", "a.fbx: is an FBX file; convert it to glTF or OBJ"),
        (
            "a.dae",
            b"<?xml v",
            "a.dae: is an XML file (COLLADA, X3D, AMF?); convert it to glTF or OBJ",
        ),
        (
            "a.obj",
            b"version https://git-lfs.github.com/spec/v1",
            "a.obj: is a Git LFS pointer; fetch the file itself (`git lfs pull`)",
        ),
    ] {
        let error = decode(name, bytes).unwrap_err();
        assert_eq!((error.to_string().as_str(), error.cause()), (said, Cause::Broken));
    }
    // Whatever a whole binary STL file begins with.
    for head in [&b"glTF"[..], b"{", b"ply\n", b"PK\x03\x04", b"\x89PNG"] {
        assert_eq!(whole("a.stl", &stl(head, 1, &[facet(CORNERS, 0)])).triangles.len(), 1);
    }
}

/// The materials of a mesh with this library beside it, and the note.
fn worn(mtl: &str) -> (Vec<MeshMaterial>, String) {
    let names: Vec<&str> = mtl.lines().filter_map(|line| line.strip_prefix("newmtl ")).collect();
    let faces: String =
        names.iter().map(|name| format!("usemtl {name}\nf 1/1 2/1 3/1\n")).collect();
    let obj = format!("mtllib a.mtl\n{FOUR}{faces}");
    let room = folder(&[
        ("m/a.obj", obj.as_bytes()),
        ("m/a.mtl", mtl.as_bytes()),
        ("m/Textures/Two Words.PPM", b"P6 1 1 255 \xff\x80\x00"),
    ]);
    let assets = Assets::new(room.path().to_owned());
    let mesh = assets.mesh("m/a.obj").unwrap_or_else(|error| panic!("{error}"));
    let notes: Vec<String> = assets.notes().into_iter().map(|note| note.message).collect();
    assert!(notes.len() <= 1, "{notes:?}");
    (mesh.materials.clone(), notes.concat())
}

#[test]
fn what_illum_says_is_meant() {
    let (worn, note) = worn(
        "newmtl a\nillum 0\nKa 1 1 1\nKd 0.5 0.5 0.5\nKs 1 1 1\nnewmtl b\nillum 1\nKa 0.25\nKs 1\n\
         newmtl c\nillum 2\nKs 0.5\nnewmtl d\nillum 3\nKs 0.5\nnewmtl e\nKs 0.5\nnewmtl f\nillum 2\nKs 0\n",
    );
    let specular: Vec<f64> = worn.iter().map(|m| m.specular[0]).collect();
    assert_eq!(specular, [0.0, 0.0, 0.0, 0.5, 0.5, 0.0]);
    assert_eq!((worn[0].ambient, worn[1].ambient), ([0.0; 3], [0.25; 3]));
    assert_eq!(note, "3 highlights left out (`Ks` with `illum` 0 to 2 does not mirror)");
}

#[test]
fn colours_that_are_not_given() {
    let grey = MeshMaterial::grey("");
    let (worn, note) = worn(
        "newmtl none\nNs 10\nnewmtl photo\nmap_Kd gone.ppm\nnewmtl shine\nKe 2 1 0\nKa 1 1 1\n\
         newmtl mirror\nKs 1 1 1\nnewmtl see\nKd 1 0 0\nd 0.5\nTr 0\nmap_Bump a.png\nTf 1 1 1\n",
    );
    assert_eq!((worn[0].ambient, worn[0].diffuse), (grey.ambient, grey.diffuse));
    assert_eq!(worn[1].diffuse, [1.0; 3]);
    assert_eq!((worn[2].ambient, worn[2].diffuse), ([3.0, 2.0, 1.0], [0.0; 3]));
    assert_eq!((worn[3].diffuse, worn[3].specular), ([0.0; 3], [1.0; 3]));
    assert!(
        note.starts_with("the texture `gone.ppm` is not worn: there is no such file"),
        "{note}"
    );
    assert!(note.ends_with("; not read of its materials: d, map_Bump, Tf"), "{note}");
}

#[test]
fn metalness_turns_diffuse_into_specular() {
    let (worn, _) = worn(
        "newmtl a\nKd 0.5 0.25 1\nKs 1 1 1\nillum 2\nPm 0.5\nPr 0.5\nnewmtl b\nKd 1 1 1\nPm 1\n\
         newmtl c\nKd 1 1 1\nPm 0\nPr 0.5\n",
    );
    assert_eq!(worn[0].diffuse, [0.375, 0.1875, 0.75]);
    assert_eq!(worn[0].specular, [0.125, 0.0625, 0.25]);
    assert_eq!((worn[1].diffuse, worn[1].specular), ([0.0; 3], [1.0; 3]));
    assert_eq!((worn[2].diffuse, worn[2].specular), ([1.0; 3], [0.0; 3]));
}

#[test]
fn textures_are_worn_by_their_makers_names() {
    let (worn, note) = worn(
        "newmtl a\nmap_Kd Textures/Two Words.PPM\nnewmtl b\nKd 0.5 0.5 0.5\n\
         map_kd -s 2 3 1 -o 0.5 0.25 -clamp on .\\textures\\two words.ppm\n\
         newmtl c\nmap_Kd C:\\Users\\me\\Textures\\Two Words.PPM\n\
         newmtl d\nKa 1 1 1\nmap_Ka \"textures\\TWO WORDS.PPM\"\n",
    );
    let diffuse = |i: usize| -> Map {
        worn[i]
            .maps
            .as_ref()
            .and_then(|maps| maps.diffuse.clone())
            .unwrap_or_else(|| panic!("{note}"))
    };
    // sRGB 128 of 255 is 0.2158605 in linear intensities.
    assert_eq!(diffuse(0).image.texels, [[1.0, 0.215_860_5, 0.0]]);
    assert_eq!((worn[0].diffuse, worn[1].diffuse), ([1.0; 3], [0.5; 3]));
    assert_eq!(diffuse(1).place, [[2.0, 0.0, 0.5], [0.0, 3.0, 0.25]]);
    assert_eq!((diffuse(0).wrap, diffuse(1).wrap), ([Wrap::Repeat; 2], [Wrap::Clamp; 2]));
    assert!(worn[3].maps.as_ref().is_some_and(|maps| maps.ambient.is_some()));
    // Another machine's folder is not here, and the file is not beside the mesh.
    assert!(worn[2].maps.is_none() && note.contains("is not worn"), "{note}");
}

#[test]
fn libraries_named_in_every_way() {
    let red = b"newmtl red\nKd 1 0 0\n";
    let room = folder(&[
        ("one.obj", b"mtllib .\\Sub\\a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"),
        ("two.obj", b"mtllib gone.mtl SUB/A.MTL\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"),
        ("up.obj", b"mtllib ../b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"),
        ("wide.obj", b"mtllib w.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"),
        ("sub/a.mtl", red),
        ("b.mtl", red),
        ("w.mtl", b"\xff\xfen\0e\0w\0"),
    ]);
    let assets = Assets::new(room.path().to_owned());
    for name in ["one.obj", "two.obj", "up.obj"] {
        assert_eq!(assets.mesh(name).unwrap().materials[0].diffuse, [1.0, 0.0, 0.0], "{name}");
    }
    let said = assets.mesh("wide.obj").unwrap_err().to_string();
    assert!(said.ends_with("w.mtl: is a text in UTF-16; save it as UTF-8"), "{said}");
}

#[test]
fn vertex_colours_multiply_what_the_mesh_wears() {
    let obj = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n";
    let [bare] = &whole("a.obj", obj.as_bytes()).materials[..] else { panic!() };
    assert_eq!((bare.name.as_str(), bare.diffuse), ("", [1.0; 3]));
    assert!(bare.maps.as_ref().is_some_and(|maps| maps.by_vertex == [false, true, false]));
    let white = obj.replace("1 0 0\nv", "1 1 1\nv").replace("0 1 0\nv 0", "1 1 1\nv 0");
    let white = white.replace("0 0 1\nf", "1 1 1\nf");
    let data = whole("a.obj", white.as_bytes());
    assert!(data.materials.is_empty() && data.colours.is_empty(), "{data:?}");
}
