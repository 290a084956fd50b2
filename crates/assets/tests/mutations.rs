//! Small files with wrong bytes, words and lines: errors with one line of text, or meshes that hold
//! together, in bounded time. The seed is fixed, so that a failure can be looked at.

use reflet_assets::{AssetError, mesh};
use reflet_scene::MeshData;
use std::path::Path;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 1 0.5 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.2 0\nvt 0 0\n\
    vt 1 0 0\nvt 0.5\nvn 0 0 1\nvn 0 0 0\nusemtl red\nf 1/1/1 2/2/1 3/3/2 4\ns 1\nusemtl \\\nblue\n\
    f -5 -4 -3// -2/1/ -1\nl 1 2\nf 1 2\n";
const MTL: &str = "newmtl red\nKd 1 0 0\nKs 0.5\nillum 3\nmap_Kd -s 2 2 -clamp on a.ppm\nnewmtl blue\n\
    Ke 1 1 1\nPm 0.5\nPr 0.25\nmap_Kd tex\\a.ppm\nd 0.5\nKd xyz 1 1 1\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment x\nelement vertex 5\nproperty float x\n\
    property double y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\n\
    property float t\nelement face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\n\
    property list int int vertex_index\nelement odd 2\nproperty list uchar short a\nend_header\n\
    0 0 0 0 0 1 255 0 0 0 0\n1 0 0 0 0 1 0 0 0 1 0\n1 1 0 nan 0 1 0 0 0 1 1\n0 1 0 0 0 1 0 9 0 0 1\n\
    0.5 0.2 0 0 0 0 0 0 0 0 0\n5 0 4 1 2 3\n3 0 1 2\n6 0 1 2 3 -1 0\n2 1 2\n0\n";
const STL: &str = "solid a b\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  \
    vertex 1 1 0\n endloop\nendfacet\nendsolid a b\n";

fn binary_ply() -> Vec<u8> {
    let head = "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 3\r\nproperty float x\r\n\
        property float y\r\nproperty float z\r\nproperty uchar red\r\nproperty uchar green\r\n\
        property uchar blue\r\nelement tristrips 1\r\nproperty list int int vertex_indices\r\n\
        end_header\r\n";
    let mut bytes = head.as_bytes().to_vec();
    for corner in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        corner.iter().for_each(|x| bytes.extend(x.to_be_bytes()));
        bytes.extend([200, 100, 50]);
    }
    [4_i32, 0, 1, 2, -1].iter().for_each(|i| bytes.extend(i.to_be_bytes()));
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid x".to_vec();
    bytes.resize(80, 0);
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend([0; 12]);
    [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .for_each(|x| bytes.extend(x.to_le_bytes()));
    bytes.extend([1, 0, 7, 7, 7]);
    bytes
}

/// Words that readers stumble over.
const WORDS: [&[u8]; 16] = [
    b"nan",
    b"-1",
    b"0",
    b"4294967295",
    b"1e39",
    b"-0.0",
    b"1e-46",
    b"99999999999999999999",
    b"/",
    b"1//",
    b"\\\n",
    b"f",
    b"\r",
    b"#",
    b"1.#IND",
    b"\xff",
];

struct Dice(u64);

impl Dice {
    /// A number below `n` (xorshift64*, S. Vigna, 2016).
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n.max(1)
    }

    fn mutate(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..=self.below(4) {
            let (at, end) = (self.below(bytes.len()), self.below(bytes.len()));
            match self.below(7) {
                0 => bytes.truncate(at),
                1 if at < bytes.len() => bytes[at] = self.below(256) as u8,
                2 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                3 if at < end => drop(bytes.drain(at..end.min(at + 40))),
                4 if at < end => {
                    let part = bytes[at..end.min(at + 40)].to_vec();
                    let to = self.below(bytes.len());
                    bytes.splice(to..to, part);
                }
                // In place of a word.
                5 => {
                    let is_blank = |byte: &u8| byte.is_ascii_whitespace();
                    let start = bytes[..at].iter().rposition(is_blank).map_or(0, |at| at + 1);
                    let end = bytes[at..].iter().position(is_blank).map_or(bytes.len(), |n| at + n);
                    bytes.splice(start..end, WORDS[self.below(WORDS.len())].iter().copied());
                }
                _ => drop(bytes.splice(at..at, WORDS[self.below(WORDS.len())].iter().copied())),
            }
        }
    }
}

/// Every index leads somewhere, and every number is finite.
fn is_sound(data: &MeshData) {
    let count = data.positions.len();
    assert!(data.triangles.iter().flatten().all(|index| (*index as usize) < count));
    for length in [data.normals.len(), data.uvs.len(), data.colours.len()] {
        assert!(length == 0 || length == count);
    }
    let worn = &data.triangle_materials;
    assert!(worn.is_empty() || worn.len() == data.triangles.len());
    assert!(worn.iter().all(|index| (*index as usize) < data.materials.len()));
    let vectors = data.positions.iter().chain(&data.normals).chain(&data.colours);
    assert!(vectors.flatten().all(|value| value.is_finite()));
    assert!(data.uvs.iter().flatten().all(|value| value.is_finite()));
    for material in &data.materials {
        let colours = [material.ambient, material.diffuse, material.specular];
        assert!(colours.iter().flatten().all(|value| value.is_finite()));
    }
}

/// Reads so many files; in an OBJ's case with a library that is wrong as well.
fn fuzz(rounds: usize, seed: u64) {
    let files: [(&str, Vec<u8>); 6] = [
        ("a.obj", OBJ.into()),
        ("b.obj", OBJ.into()),
        ("a.ply", PLY.into()),
        ("b.ply", binary_ply()),
        ("a.stl", STL.into()),
        ("b.stl", binary_stl()),
    ];
    let mut dice = Dice(seed);
    let missing = |name: &str| -> AssetError {
        reflet_assets::jail::open(Path::new("/nowhere"), name).expect_err("no such folder")
    };
    let mut read = 0;
    for round in 0..rounds {
        let (name, whole) = &files[round % files.len()];
        let (mut bytes, mut library) = (whole.clone(), MTL.as_bytes().to_vec());
        match *name {
            "b.obj" => dice.mutate(&mut library),
            _ => dice.mutate(&mut bytes),
        }
        let mut other = |name: &str| match name {
            "a.mtl" => Ok(library.clone()),
            "a.ppm" => Ok(b"P6 1 1 255 \xff\x80\x00".to_vec()),
            other => Err(missing(other)),
        };
        match mesh::decode(Path::new(name), &bytes, &mut other) {
            Ok(file) => {
                is_sound(&file.data);
                read += 1;
                let told = file.notes.join("; ");
                assert!(!told.contains(|c: char| c.is_control()), "{told:?} of {bytes:?}");
            }
            Err(error) => {
                let told = error.to_string();
                assert!(!told.contains(|c: char| c.is_control()), "{told:?} of {bytes:?}");
            }
        }
    }
    // Mutations that break everything would try nothing.
    assert!(read > rounds / 10 && read < rounds, "{read} of {rounds} were read");
}

#[test]
fn mutated_files_are_errors_or_meshes() {
    fuzz(6_000, 0x5eed);
}

/// Run with `--ignored`: for a change of a reader.
#[test]
#[ignore = "takes minutes"]
fn many_mutated_files() {
    (1..=200).for_each(|seed| fuzz(6_000, seed));
}

#[test]
fn files_that_announce_more_than_they_hold_are_refused_at_once() {
    let begin = std::time::Instant::now();
    let head = |more: &str| format!("ply\nformat ascii 1.0\n{more}end_header\n0 0 0\n");
    let vertices =
        "element vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1000000000\nproperty list uchar int vertex_indices\n";
    let mut stl = vec![0; 84];
    stl[80..84].copy_from_slice(&1_000_000_000_u32.to_le_bytes());
    let list = "element face 1\nproperty list int int vertex_indices\n";
    for (name, bytes, said) in [
        ("a.ply", head(vertices).into_bytes(), "1000000000 elements `vertex` do not fit"),
        ("a.ply", head(faces).into_bytes(), "1000000000 elements `face` do not fit"),
        (
            "a.ply",
            head(list).replace("0 0 0", "1000000000 0").into_bytes(),
            "cannot have the length",
        ),
        ("a.ply", head("element void 4000000000\n").into_bytes(), "no face"),
        ("a.stl", stl, "announces 1000000000 facets"),
        ("a.obj", b"v 0 0 0\nf 1 1 1000000000\n".to_vec(), "vertex 1000000000 is asked for"),
    ] {
        let error = mesh::decode(Path::new(name), &bytes, &mut |_| unreachable!()).unwrap_err();
        assert!(error.to_string().contains(said), "{error}");
    }
    assert!(begin.elapsed().as_secs() < 2, "nothing is reserved or counted");
}
