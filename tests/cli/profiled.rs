//! `reflet profile`.

use crate::room::{Room, png};

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
    let args =
        ["profile", "--spheres", "balls.npy", "--rays", "rays.npy", "--hits", "rays.npy/h.npy"];
    room.bad(&args, 74, &["rays.npy"]);
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
    room.bad(&["profile", "still.rhai", "--heatmap", "a.jpg"], 2, &["--heatmap", ".png"]);
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

/// Mirrored balls that touch each other and a triangle, and things that no file of arrays holds.
const MIRRORS: &str = "
image(#{ width: 24, height: 16 });
camera(#{ eye: [0, 1, 6], look_at: [0, 0, 0] });
light(#{ at: [3, 4, 5], emissivity: 40 });
let chrome = material(#{ diffuse: [0.1, 0.1, 0.1], specular: [0.9, 0.9, 0.9] });
for x in -1..2 { sphere(#{ center: [x * 2.0, 0, 0], radius: 1, material: chrome }); }
";
const FLOOR: &str = "
plane(#{ point: [0, -1, 0], normal: [0, 1, 0], material: chrome });
quad(#{ corner: [-3, -1, -3], u: [6, 0, 0], v: [0, 3, 0], material: chrome });
triangle(#{ a: [-3, -1, 2], b: [3, -1, 2], c: [0, -1, 4], material: chrome });
";

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text.lines().last().unwrap()).unwrap()
}

#[test]
fn rays_of_a_scene_hit_the_same_when_they_come_from_files() {
    let room = Room::with(&[("m.rhai", MIRRORS)]);
    let whole = json(room.good(&["profile", "m.rhai", "--json", "--dump", "d/e"]).text());
    let names = ["m.camera.rays.npy", "m.mirror.rays.npy", "m.shadow.rays.npy", "m.spheres.npy"];
    assert_eq!(room.names_in("d/e"), names);
    for (kind, more) in [("camera", &[][..]), ("mirror", &[]), ("shadow", &["--any"])] {
        let rays = format!("d/e/m.{kind}.rays.npy");
        let args = ["profile", "--spheres", "d/e/m.spheres.npy", "--rays", &rays, "--json"];
        let line = json(room.good(&[&args[..], more].concat()).text());
        assert!(line["rays"].as_u64().unwrap() > 0, "{kind}");
        assert_eq!((&line["rays"], &line["hits"]), (&whole["rays"][kind], &whole["hits"][kind]));
    }
    room.bad(&["profile", "m.rhai", "--dump", "m.rhai"], 74, &["m.rhai"]);
}

#[test]
fn what_cannot_be_dumped_is_named() {
    let room = Room::with(&[("m.rhai", &format!("{MIRRORS}{FLOOR}"))]);
    let text = room.good(&["profile", "m.rhai", "--dump", "d"]).text().to_owned();
    for word in ["3 spheres", "1 triangles", "1 infinite planes", "1 quads"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let ran = room.good(&["profile", "m.rhai", "--dump", "d", "--json"]);
    assert!(ran.err.contains("1 quads") && json(ran.text()).is_object(), "{}", ran.err);
    let triangles = ["--verts", "d/m.verts.npy", "--tris", "d/m.tris.npy"];
    room.good(&[&["profile", "--rays", "d/m.mirror.rays.npy"], &triangles[..]].concat());
}

#[test]
fn what_is_counted_does_not_depend_on_levels_and_threads() {
    let room = Room::with(&[("m.rhai", &format!("{MIRRORS}{FLOOR}"))]);
    let args = ["profile", "m.rhai", "--json", "--isa", "all", "--threads", "1,2"];
    let ran = room.good(&args);
    let keys = ["node_visits_per_ray", "primitive_tests_per_ray", "lane_occupancy", "rays", "hits"];
    let counts: Vec<_> = ran.text().lines().map(|l| keys.map(|k| json(l)[k].clone())).collect();
    assert!(counts.len() >= 4 && counts.iter().all(|c| *c == counts[0]), "{counts:?}");
    let line = json(ran.text());
    assert!(line["primitive_tests_per_ray"]["mirror"].as_f64().unwrap() > 0.0);
    for key in ["rays", "steps", "cpu_us"] {
        let tiles = ["p50", "p95", "max"].map(|p| line["tiles"][key][p].as_f64().unwrap());
        assert!(tiles.is_sorted() && tiles[2] > 0.0, "{key}: {tiles:?}");
    }
}

#[test]
fn a_heat_map_and_a_timeline_are_written() {
    let room = room();
    let ran =
        room.good(&["profile", "still.rhai", "--heatmap", "cost.png", "--trace", "out/t.json"]);
    assert!(ran.text().contains("cost.png"));
    let (width, height, pixels) = png(&room.path("cost.png"));
    assert!(width >= 16 && height > 9);
    assert!(pixels.chunks(3).any(|p| p == [0xfd, 0xe7, 0x25]), "no pixel has the greatest cost");
    let text = std::fs::read_to_string(room.path("out/t.json")).unwrap();
    let timeline: serde_json::Value = serde_json::from_str(&text).unwrap();
    let events = timeline["traceEvents"].as_array().unwrap();
    let lengths = |name: &str| -> Vec<f64> {
        let of_name = events.iter().filter(|e| e["ph"] == "X" && e["name"] == name);
        of_name.map(|e| e["ts"].as_f64().unwrap() + e["dur"].as_f64().unwrap()).collect()
    };
    for name in ["script", "pack", "build", "tile 0", "trace", "shade"] {
        assert!(!lengths(name).is_empty(), "{name}");
    }
    // 16 x 9 pixels are one tile, and it ends before the stage that it belongs to.
    let (tile, all) = (lengths("tile 0"), lengths("trace and shade"));
    assert!(tile.len() == 1 && all.len() == 1 && tile[0] <= all[0], "{tile:?} {all:?}");
    room.bad(&["profile", "still.rhai", "--heatmap", "still.rhai/c.png"], 74, &["still.rhai"]);
    room.bad(&["profile", "still.rhai", "--trace", "still.rhai/t.json"], 74, &["still.rhai"]);
}

#[test]
fn figures_are_kept_and_compared() {
    let room = room();
    let spheres = ["profile", "--spheres", "balls.npy", "--rays", "rays.npy"];
    room.good(&[&spheres[..], &["--save", "out/f.json"]].concat());
    let text = std::fs::read_to_string(room.path("out/f.json")).unwrap();
    let kept: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(kept["figures"][0]["cpu_ns"].as_array().unwrap().len(), 5);
    for key in ["version", "cpu", "subject", "inputs", "quality"] {
        assert!(kept["about"][key].is_string(), "{key}: {text}");
    }
    let ran = room.good(&[&spheres[..], &["--against", "out/f.json"]].concat());
    assert!(ran.text().contains("beyond noise"), "{}", ran.text());
    let line =
        json(room.good(&[&spheres[..], &["--against", "out/f.json", "--json"]].concat()).text());
    assert!(line["mrays_per_s_per_core"].is_number() && line["against"][0]["ratio"].is_number());
    // Unlike things are not compared, and what differs is named.
    let against = |args: &[&str], words: &[&str]| {
        room.bad(&[args, &["--against", "out/f.json"]].concat(), 66, words);
    };
    against(&["profile", "still.rhai"], &["a frame of a scene", "rays from a file", "inputs"]);
    against(&[&spheres[..], &["--any"]].concat(), &["--any"]);
    against(&[&spheres[..], &["--quality", "high"]].concat(), &["--quality", "balanced", "high"]);
    against(&[&spheres[..], &["--threads", "2"]].concat(), &["--threads", "on 1", "on 2"]);
    room.write("one.npy", npy("<f4", 4, &floats(&[0., 0., 0., 1.])));
    against(&["profile", "--spheres", "one.npy", "--rays", "rays.npy"], &["inputs"]);
    room.write("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    against(&["profile", "--mesh", "m.obj", "--rays", "rays.npy"], &["inputs"]);
    let other = text.replace("\"cpu\": \"", "\"cpu\": \"another ");
    room.write("out/other.json", other);
    room.bad(&[&spheres[..], &["--against", "out/other.json"]].concat(), 66, &["CPU", "another"]);
    room.bad(&["profile", "still.rhai", "--against", "rays.npy"], 66, &["rays.npy", "--save"]);
    room.bad(&["profile", "still.rhai", "--save", "still.rhai/f"], 74, &["still.rhai"]);
    room.bad(&[&spheres[..], &["--dump", "d"]].concat(), 2, &["--dump"]);
}

#[test]
fn what_the_frame_before_saves_is_told() {
    let room = room();
    let reuse = |frame: &str| {
        let ran = room.good(&["profile", "five.rhai", "--frame", frame, "--json"]);
        json(ran.text())["reuse"].clone()
    };
    assert!(reuse("0").is_null());
    // Only a colour changes.
    let saved = reuse("2");
    assert_eq!(saved["kept"]["rays"], 0);
    assert!(saved["fresh"]["rays"].as_u64().unwrap() > 16 * 9 && saved["nothing_kept"].is_null());
}

#[test]
fn numbers_that_make_no_sense_are_66_with_their_row() {
    let room = room();
    const NAN: f32 = f32::NAN;
    let good = [0., 0., 4., 0., 0., 0., -1., INF];
    let ray = |column: usize, x: f32, words: &[&str]| {
        let mut row = good;
        row[column] = x;
        room.write("bad.npy", npy("<f4", 8, &floats(&[good, row].concat())));
        let args = ["profile", "--spheres", "balls.npy", "--rays", "bad.npy", "--hits", "h.npy"];
        room.bad(&args, 66, &[&["bad.npy: row 1"], words].concat());
    };
    ray(1, NAN, &["origin"]);
    ray(0, INF, &["origin"]);
    ray(5, NAN, &["direction", "NaN"]);
    ray(6, 0., &["direction", "length 0"]);
    // One that is 1 % too long lost half of its hits.
    ray(6, -1.01, &["direction", "1.01"]);
    ray(3, NAN, &["tmin"]);
    ray(3, -1., &["tmin", "-1"]);
    ray(7, NAN, &["tmax"]);
    ray(7, -1., &["tmax", "-1"]);
    let sphere = |row: [f32; 4], words: &[&str]| {
        room.write("bad.npy", npy("<f4", 4, &floats(&[[0., 0., 0., 1.], row].concat())));
        let args = ["profile", "--spheres", "bad.npy", "--rays", "rays.npy"];
        room.bad(&args, 66, &[&["bad.npy: row 1"], words].concat());
    };
    sphere([0., 0., 0., -1.], &["radius", "-1"]);
    sphere([0., 0., 0., 0.], &["radius"]);
    sphere([0., 0., 0., NAN], &["radius", "NaN"]);
    sphere([0., NAN, 0., 1.], &["centre"]);
    room.write("v.npy", npy("<f4", 3, &floats(&[0., 0., 0., 1., NAN, 0., 0., 1., 0.])));
    room.write("t.npy", npy("<u4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]));
    let args = ["profile", "--verts", "v.npy", "--tris", "t.npy", "--rays", "rays.npy"];
    room.bad(&args, 66, &["v.npy: row 1", "NaN"]);
    assert!(!room.path("h.npy").exists());
    // What rounding leaves of a unit vector is one.
    let third = 1f32 / 3f32.sqrt();
    let row = [0., 0., 4., 0., third, third, -third, INF];
    room.write("bad.npy", npy("<f4", 8, &floats(&row)));
    room.good(&["profile", "--spheres", "balls.npy", "--rays", "bad.npy", "--repeat", "1"]);
}

#[test]
fn other_types_of_numbers_give_the_same_hits() {
    let room = room();
    let doubles = |rows: &[f64]| rows.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let array = |descr: &str, shape: &str, order: &str, data: &[u8]| {
        let text =
            format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let length = (text.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes(), data].concat()
    };
    room.good(&["profile", "--spheres", "balls.npy", "--rays", "rays.npy", "--hits", "hits.npy"]);
    let wanted = hits(&room);
    let by_rows = doubles(&[0., 0., 0., 1., 0., 0., -5., 1.]);
    let by_columns = doubles(&[0., 0., 0., 0., 0., -5., 1., 1.]);
    for (order, data) in [("False", &by_rows), ("True", &by_columns)] {
        room.write("other.npy", array("<f8", "(2, 4)", order, data));
        let args = ["profile", "--spheres", "other.npy", "--rays", "rays.npy"];
        room.good(&[&args[..], &["--hits", "hits.npy"]].concat());
        assert_eq!(hits(&room), wanted);
    }
    for (descr, shape, word) in [("<c16", "(1, 4)", "<c16"), ("<f8", "(8,)", "(8,)")] {
        room.write("other.npy", array(descr, shape, "False", &by_rows));
        let args = ["profile", "--spheres", "other.npy", "--rays", "rays.npy"];
        room.bad(&args, 66, &["other.npy", word, "(n, 4)"]);
    }
}
