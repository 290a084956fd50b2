//! What a file is that is not what its name says, by its first bytes.

/// What a file begins with, its format, and what to do with it.
const SIGNS: &[(&[u8], &str)] = &[
    (b"\x1f\x8b", "a file compressed by gzip; unpack it (`gunzip`)"),
    (b"PK\x03\x04", "a ZIP archive; unpack it"),
    (b"BZh", "a file compressed by bzip2; unpack it"),
    (b"\xfd7zXZ\0", "a file compressed by xz; unpack it"),
    (b"\x28\xb5\x2f\xfd", "a file compressed by Zstandard; unpack it"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive; unpack it"),
    (b"Rar!\x1a\x07", "a RAR archive; unpack it"),
    (b"\xff\xfe", "a text in UTF-16; save it as UTF-8"),
    (b"\xfe\xff", "a text in UTF-16; save it as UTF-8"),
    (b"version https://git-lfs", "a Git LFS pointer; fetch the file itself (`git lfs pull`)"),
    (b"<!DOCTYPE", "an HTML page; download the file itself"),
    (b"<!doctype", "an HTML page; download the file itself"),
    (b"<html", "an HTML page; download the file itself"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"%PDF", "a PDF document"),
    (b"BLENDER", "a Blender file; export it as glTF or OBJ"),
    (b"Kaydara FBX", "an FBX file; convert it to glTF or OBJ"),
    (b"; FBX", "an FBX file; convert it to glTF or OBJ"),
    (b"PXR-USDC", "a USD file; convert it to glTF or OBJ"),
    (b"#usda", "a USD file; convert it to glTF or OBJ"),
    (b"#VRML", "a VRML file; convert it to glTF or OBJ"),
    (b"<?xml", "an XML file (COLLADA, X3D, AMF?); convert it to glTF or OBJ"),
    (b"xof 0", "a DirectX file; convert it to glTF or OBJ"),
    (b"AC3D", "an AC3D file; convert it to glTF or OBJ"),
    (b"OFF\n", "an OFF file; convert it to PLY or OBJ"),
    (b"OFF\r", "an OFF file; convert it to PLY or OBJ"),
    (b"COFF", "an OFF file; convert it to PLY or OBJ"),
    (b"# .PCD", "a PCD point cloud; convert it to PLY or OBJ"),
    (b"# vtk", "a VTK file; convert it to PLY or OBJ"),
    (b"$MeshFormat", "a Gmsh file; convert it to PLY or OBJ"),
    (b"\x89HDF", "an HDF5 file; convert it to PLY or OBJ"),
    (b"ISO-10303-21", "a STEP file; convert it to STL or OBJ"),
    (b"MM\0", "a 3DS file; convert it to glTF or OBJ"),
];

/// The formats that are read, and the endings of their names.
const READ: &[(&[u8], &str, &[&str])] = &[
    (b"ply\n", "a PLY file; let its name end in .ply", &["ply"]),
    (b"ply\r", "a PLY file; let its name end in .ply", &["ply"]),
    (b"glTF", "a GLB file; let its name end in .glb", &["glb", "gltf"]),
    (b"{", "a JSON text; a glTF file's name ends in .gltf", &["gltf", "glb"]),
    (b"solid ", "an ASCII STL file; let its name end in .stl", &["stl"]),
];

/// What is in a file whose name has this ending, in lower case, and does not belong there: in words
/// that follow `is`. `None` where it may be what it is called.
pub(crate) fn other_than(ending: &str, bytes: &[u8]) -> Option<&'static str> {
    if bytes.is_empty() {
        return Some("empty");
    }
    // A binary STL file begins with any 80 bytes.
    let long_stl =
        ending == "stl" && bytes.len() >= 84 && !matches!(bytes, [0xff | 0xfe, 0xfe | 0xff, ..]);
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let begins = |sign: &[u8]| bytes.starts_with(sign) || text.starts_with(sign);
    let read = READ.iter().find(|(sign, ..)| begins(sign));
    if let Some((_, what, endings)) = read {
        return (!endings.contains(&ending) && !long_stl).then_some(what);
    }
    if long_stl && crate::stl::is_whole(bytes) {
        return None;
    }
    SIGNS.iter().find(|(sign, _)| begins(sign)).map(|(_, what)| *what)
}
