//! `reflet profile`.

use crate::room::Room;

/// A .npy file of `rows` of one width.
fn npy(descr: &str, width: usize, rows: &[u8]) -> Vec<u8> {
    let n = rows.len() / 4 / width;
    let text =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({n}, {width}), }}\n");
    let length = (text.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes(), rows].concat()
}

fn floats(rows: &[f32]) -> Vec<u8> {
    rows.iter().flat_map(|x| x.to_le_bytes()).collect()
}

const INF: f32 = f32::INFINITY;

/// Two balls on the z axis, and rays along it: one that hits the first, one that begins inside of
/// it, one that begins beyond it, one that ends before it, and one that passes by.
fn room() -> Room {
    let room = Room::furnished();
    room.write("balls.npy", npy("<f4", 4, &floats(&[0., 0., 0., 1., 0., 0., -5., 1.])));
    let row = |x: f32, tmin: f32, tmax: f32| [x, 0., 4., tmin, 0., 0., -1., tmax];
    let rays =
        [row(0., 0., INF), row(0., 3.5, INF), row(0., 5.5, INF), row(0., 0., 2.), row(9., 0., INF)];
    room.write("rays.npy", npy("<f4", 8, &floats(rays.as_flattened())));
    room
}

/// What a file of hits holds: t and primitive.
fn hits(room: &Room) -> Vec<(f32, u32)> {
    let bytes = std::fs::read(room.path("hits.npy")).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let text = std::str::from_utf8(&bytes[10..start]).unwrap();
    assert!(text.contains("[('t', '<f4'), ('prim', '<u4')]") && start % 64 == 0, "{text}");
    let four = |b: &[u8]| [b[0], b[1], b[2], b[3]];
    let row = |b: &[u8]| (f32::from_le_bytes(four(b)), u32::from_le_bytes(four(&b[4..])));
    bytes[start..].chunks_exact(8).map(row).collect()
}

#[test]
fn rays_from_a_file_hit_spheres_from_a_file() {
    let room = room();
    let args = ["profile", "--spheres", "balls.npy", "--rays", "rays.npy", "--repeat", "2"];
    let more = ["--hits", "hits.npy", "--json"];
    let ran = room.good(&[&args[..], &more[..]].concat());
    let line: serde_json::Value = serde_json::from_str(ran.text().lines().last().unwrap()).unwrap();
    assert_eq!((&line["rays"], &line["hits"], &line["threads"]), (&5.into(), &3.into(), &1.into()));
    for key in ["mrays_per_s_per_core", "mrays_per_s", "build_ms"] {
        assert!(line[key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(line["isa"].is_string());
    let none = (INF, u32::MAX);
    assert_eq!(hits(&room), [(3.0, 0), (5.0, 0), (8.0, 1), none, none]);

    room.good(&[&args[..], &["--any", "--hits", "hits.npy"]].concat());
    assert_eq!(hits(&room), [(0.0, 0), (0.0, 0), (0.0, 0), none, none]);
    let table = room.good(&[&args[..], &["--isa", "all", "--threads", "1,2"]].concat());
    assert!(table.text().lines().count() > 4 && table.text().contains("scalar"));
}

#[test]
fn rays_from_a_file_hit_triangles_from_files() {
    let room = room();
    let corners = floats(&[-1., -1., 0., 1., -1., 0., 0., 1., 0.]);
    room.write("v.npy", npy("<f4", 3, &corners));
    let one: Vec<u8> = [0u32, 1, 2].iter().flat_map(|i| i.to_le_bytes()).collect();
    room.write("t.npy", npy("<u4", 3, &one));
    room.write("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let rays = ["--rays", "rays.npy", "--hits", "hits.npy"];
    for primitives in [&["--verts", "v.npy", "--tris", "t.npy"][..], &["--mesh", "m.obj"]] {
        room.good(&[&["profile"], primitives, &rays].concat());
        let none = (INF, u32::MAX);
        assert_eq!(hits(&room), [(4.0, 0), (4.0, 0), none, none, none]);
    }
    let two: Vec<u8> = [0u32, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    room.write("t.npy", npy("<u4", 3, &two));
    let args = ["profile", "--verts", "v.npy", "--tris", "t.npy", "--rays", "rays.npy"];
    room.bad(&args, 66, &["t.npy", "vertex 3 of 3"]);
}

#[test]
fn inputs_that_cannot_be_read_are_66() {
    let room = room();
    let mut cut = std::fs::read(room.path("rays.npy")).unwrap();
    cut.pop();
    room.write("cut.npy", &cut);
    room.write("text.npy", "no array");
    let cast = |spheres: &str, rays: &str, words: &[&str]| {
        room.bad(&["profile", "--spheres", spheres, "--rays", rays], 66, words);
    };
    cast("none.npy", "rays.npy", &["none.npy"]);
    cast("text.npy", "rays.npy", &["text.npy", "no .npy"]);
    cast("rays.npy", "rays.npy", &["rays.npy", "(n, 4)"]);
    cast("balls.npy", "cut.npy", &["cut.npy", "bytes"]);
    cast("balls.npy", "balls.npy", &["balls.npy", "(n, 8)"]);
    room.bad(&["profile", "--mesh", "none.obj", "--rays", "rays.npy"], 66, &["none.obj"]);
    room.bad(&["profile", "none.rhai"], 66, &["none.rhai"]);
    let args = ["profile", "--spheres", "balls.npy", "--rays", "rays.npy", "--hits", "no/h.npy"];
    room.bad(&args, 74, &["no/h.npy"]);
}

#[test]
fn words_that_do_not_go_together_are_usage_errors() {
    let room = room();
    room.bad(&["profile"], 2, &["profile"]);
    room.bad(&["profile", "--rays", "rays.npy"], 2, &["--spheres"]);
    room.bad(&["profile", "--spheres", "balls.npy"], 2, &["--rays"]);
    room.bad(&["profile", "--verts", "v.npy", "--rays", "rays.npy"], 2, &["--tris"]);
    let both = ["profile", "--spheres", "balls.npy", "--mesh", "m.obj", "--rays", "rays.npy"];
    room.bad(&both, 2, &["--mesh"]);
    room.bad(&["profile", "still.rhai", "--rays", "rays.npy"], 2, &["--rays"]);
    room.bad(&["profile", "still.rhai", "--frame", "1"], 2, &["one frame, 0"]);
    room.bad(&["profile", "still.rhai", "--isa", "avx1024"], 2, &["avx2", "all"]);
}

#[test]
fn a_scene_is_profiled_by_kind_of_ray_and_by_stage() {
    let room = room();
    let ran = room.good(&["profile", "five.rhai", "--frame", "3"]);
    for word in ["camera", "mirror", "shadow", "script", "pack", "build", "trace", "Mrays/s"] {
        assert!(ran.text().contains(word), "{word}: {}", ran.text());
    }
    let ran = room.good(&["profile", "still.rhai", "--json", "--threads", "2"]);
    let line: serde_json::Value = serde_json::from_str(ran.text().lines().last().unwrap()).unwrap();
    assert_eq!(line["rays"]["camera"], 16 * 9);
    assert_eq!(line["rays"]["mirror"], 0);
    assert!(line["rays"]["shadow"].as_u64().unwrap() > 0);
    assert_eq!(line["threads"], 2);
    assert!(room.made().iter().all(|name| name.ends_with(".npy")), "{:?}", room.made());
}
