//! `--resume`, `verify`, shards and tiles: nothing lost, nothing done twice, the same bytes however
//! a run was cut.

use crate::room::{FIVE, Room, STILL};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Five frames of a scene with a mesh and a parameter, and their folder.
fn room() -> Room {
    let more = "let gloss = param(\"gloss\", 0.25, 0.0, 1.0);\nmesh(#{ file: \"m.obj\", \
                material: #{ diffuse: gloss } });\n";
    Room::with(&[("a.rhai", &format!("{STILL}{FIVE}{more}")), ("m.obj", MESH)])
}

fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries
        .map(|e| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap()))
        .collect()
}

/// Renders with `--resume`; gives the frames that were made.
fn made(room: &Room, more: &[&str]) -> Vec<u64> {
    let args = ["render", "a.rhai", "-o", "o/f-##.png", "--resume", "--json"];
    let ran = room.good(&[&args[..], more].concat());
    let lines = ran.text().lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter(|l| l["event"] == "frame").map(|l| l["frame"].as_u64().unwrap()).collect()
}

#[test]
fn only_what_is_missing_damaged_or_stale_is_made_again() {
    let room = room();
    let verify = |code: i32, again: &str| {
        let ran = room.run(&["verify", "a.rhai", "o/f-##.png"]);
        assert_eq!((ran.code, ran.text().trim_end()), (Some(code), again), "{}", ran.err);
        ran
    };
    verify(1, "0-4");
    assert_eq!(made(&room, &[]), [0, 1, 2, 3, 4]);
    let whole = bytes(&room.path("o"));
    assert_eq!(whole.len(), 5, "no other file is left");
    verify(0, "");
    assert_eq!(made(&room, &[]), [0; 0]);

    // A comment, and whatever else changes no bit of the packed scene.
    let script = std::fs::read_to_string(room.path("a.rhai")).unwrap();
    room.write("a.rhai", format!("// a comment\n{script}\nlet unused = 3;\n"));
    verify(0, "");
    room.write("m.obj", format!("# a comment\n{MESH}"));
    assert_eq!(made(&room, &["--threads", "1", "--no-reuse"]), [0; 0]);

    // A file that is gone, and one flipped bit anywhere in one that is there.
    std::fs::remove_file(room.path("o/f-03.png")).unwrap();
    let good = &whole["f-01.png"];
    for at in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 1 << (at % 8);
        room.write("o/f-01.png", &bad);
        let ran = room.run(&["verify", "a.rhai", "o/f-##.png", "--frames", "1"]);
        assert_eq!((ran.code, ran.text()), (Some(1), "1\n"), "byte {at}: {}", ran.err);
    }
    verify(1, "1,3");
    assert_eq!(made(&room, &[]), [1, 3]);
    assert!(bytes(&room.path("o")) == whole);
    for cut in [0, 1, 8, 40, good.len() - 1] {
        room.write("o/f-01.png", &good[..cut]);
        let ran = verify(1, "1");
        assert!(ran.err.contains("frame 1: "), "{}", ran.err);
    }

    // Another program's file of that name, a mesh, a parameter, a size.
    room.write("o/f-01.png", "something else");
    verify(1, "1");
    assert_eq!(made(&room, &[]), [1]);
    room.write("m.obj", MESH.replace("0 1 0", "0 1 0.001"));
    assert_eq!(made(&room, &[]), [0, 1, 2, 3, 4]);
    assert_eq!(made(&room, &["--set", "gloss=0.5"]), [0, 1, 2, 3, 4]);
    assert_eq!(made(&room, &["--set", "gloss=0.5"]), [0; 0]);
    assert_eq!(made(&room, &["--size", "17x9"]), [0, 1, 2, 3, 4]);
    // One frame only.
    let script = script.replace("f.phase", "f.phase + if f.index == 2 { 0.25 } else { 0.0 }");
    room.write("a.rhai", &script);
    made(&room, &[]);
    room.write("a.rhai", script.replace("0.25 }", "0.5 }"));
    assert_eq!(made(&room, &[]), [2]);
}

/// EXR has no checksums of its own, JPEG takes almost anything; all of them notice.
#[test]
fn one_flipped_bit_is_noticed_in_every_format() {
    let room = Room::furnished();
    for (name, more) in [
        ("a.png", &[][..]),
        ("b.png", &["--format", "png16"]),
        ("a.exr", &[]),
        ("b.exr", &["--format", "exr16"]),
        ("a.jpg", &[]),
        ("a.ppm", &[]),
        ("a.qoi", &[]),
        ("a.pfm", &[]),
    ] {
        room.good(&[&["render", "still.rhai", "-o", name, "--size", "5x4"], more].concat());
        let verify = |code: i32, what: &str| {
            let args = [&["verify", "still.rhai", name, "--size", "5x4"], more].concat();
            let ran = room.run(&args);
            assert_eq!(ran.code, Some(code), "{name}, {what}: {}", ran.err);
        };
        verify(0, "as it was written");
        let good = std::fs::read(room.path(name)).unwrap();
        for at in 0..good.len() {
            if good.len() > 300 && at % 5 != 0 {
                continue;
            }
            let mut bad = good.clone();
            bad[at] ^= 1 << (at % 8);
            room.write(name, &bad);
            verify(1, &format!("byte {at}"));
        }
        room.write(name, [&good[..], b"\0"].concat());
        verify(1, "a byte too many");
        room.write(name, &good);
        verify(0, "mended");
    }
    let made = room.made();
    let beside: Vec<_> = made.iter().filter(|name| name.ends_with(".reflet")).collect();
    assert_eq!(beside, ["a.pfm.reflet", "a.qoi.reflet"], "only formats without text need it");
}

#[test]
fn every_cut_of_a_run_gives_the_same_bytes() {
    let room = room();
    room.good(&["render", "a.rhai", "-o", "whole/f-##.png"]);
    let whole = bytes(&room.path("whole"));
    for count in [1, 2, 3, 7] {
        let folder = format!("shards-{count}");
        for index in (1..=count).rev() {
            let (shard, out) = (format!("{index}/{count}"), format!("{folder}/f-##.png"));
            let threads = index.to_string();
            let args = ["render", "a.rhai", "-o", &out, "--shard", &shard, "--threads", &threads];
            room.good(&args);
        }
        assert!(bytes(&room.path(&folder)) == whole, "{count} shards");
    }
    // Every subset of frames found, the others made.
    for found in 0..32_u32 {
        std::fs::create_dir(room.path("o")).unwrap();
        for (i, (name, bytes)) in whole.iter().enumerate() {
            if found & (1 << i) != 0 {
                room.write(&format!("o/{name}"), bytes);
            }
        }
        let missing: Vec<u64> = (0..5).filter(|i| found & (1 << i) == 0).collect();
        assert_eq!(made(&room, &[]), missing, "{found:05b}");
        assert!(bytes(&room.path("o")) == whole, "{found:05b}");
        std::fs::remove_dir_all(room.path("o")).unwrap();
    }
}

/// Shards, threads, tiles, re-use and the point from which a run is taken up again, all crossed:
/// the frames, and the film of them, are those of one run in one piece.
#[test]
fn cuts_and_threads_crossed_give_the_same_bytes() {
    let room = room();
    room.good(&["render", "a.rhai", "-o", "whole/f-##.png"]);
    room.good(&["render", "a.rhai", "-o", "whole.gif"]);
    let whole = bytes(&room.path("whole"));
    let film = std::fs::read(room.path("whole.gif")).unwrap();
    for threads in ["1", "2", "5"] {
        for more in [&[][..], &["--no-reuse"], &["--cache-mem", "0"], &["--isa", "scalar"]] {
            for (count, found) in [(1, 0b00000_u32), (2, 0b10010), (3, 0b01001), (5, 0b00100)] {
                std::fs::create_dir(room.path("o")).unwrap();
                for (i, (name, bytes)) in whole.iter().enumerate() {
                    // One that stands, and one that a killed process has cut.
                    let cut = if found & (1 << i) != 0 { bytes.len() } else { bytes.len() / 2 };
                    if i % 2 == 0 || cut == bytes.len() {
                        room.write(&format!("o/{name}"), &bytes[..cut]);
                    }
                }
                for index in 1..=count {
                    let shard = format!("{index}/{count}");
                    let args = ["render", "a.rhai", "-o", "o/f-##.png", "--resume", "--shard"];
                    let more = [&args[..], &[&shard, "--threads", threads], more].concat();
                    room.good(&more);
                }
                let what = format!("{threads} threads, {more:?}, {count} shards, {found:05b}");
                assert!(bytes(&room.path("o")) == whole, "{what}");
                room.good(&["film", "o/f-##.png", "-o", "joined.gif", "--fps", "10"]);
                assert!(std::fs::read(room.path("joined.gif")).unwrap() == film, "{what}");
                std::fs::remove_dir_all(room.path("o")).unwrap();
            }
            let args = ["render", "a.rhai", "-o", "again.gif", "--threads", threads];
            room.good(&[&args[..], more].concat());
            assert!(std::fs::read(room.path("again.gif")).unwrap() == film, "{threads} {more:?}");
        }
        // One frame of it in tiles.
        for (columns, rows) in [(1, 1), (2, 1), (1, 3), (3, 2), (5, 4)] {
            let mut words = vec!["merge".to_owned(), "-o".into(), "tiled.png".into()];
            for (row, column) in (1..=rows).flat_map(|r| (1..=columns).map(move |c| (r, c))) {
                let (tile, part) =
                    (format!("{column},{row}/{columns}x{rows}"), format!("p/{column}-{row}.exr"));
                let args = ["render", "a.rhai", "-o", &part, "--frames", "2", "--tile", &tile];
                room.good(&[&args[..], &["--threads", threads]].concat());
                words.push(part);
            }
            room.good(&words.iter().map(String::as_str).collect::<Vec<_>>());
            let tiled = std::fs::read(room.path("tiled.png")).unwrap();
            assert!(tiled == whole["f-02.png"], "{columns}x{rows} tiles, {threads} threads");
        }
    }
}

#[test]
fn a_resumed_animation_takes_nothing_over_from_frames_that_it_skipped() {
    // Each frame differs from the one before in a way of its own: colours, a move, a lamp.
    let more = "
animation(#{ frames: 9 });
let floor = plane(#{ point: [0, -1, 0], normal: [0, 1, 0], material: #{ diffuse: 0.5, specular: 0.3 } });
let ball = sphere(#{ center: [1.5, 0, 0], radius: 0.5 });
on_frame(|f| {
    if f.index % 3 == 0 { paint.diffuse = [f.t, 0.2, 0.9]; }
    if f.index % 2 == 1 { ball.center = [1.5 + 0.1 * f.index, 0, 0]; }
    if f.index == 4 { paint.specular = 0.5; }
    if f.index > 6 { light(#{ at: [0, 5, f.index], emissivity: 9 }); }
});";
    let room = Room::with(&[("a.rhai", &format!("{STILL}{more}"))]);
    room.good(&["render", "a.rhai", "-o", "whole/f-#.png"]);
    let whole = bytes(&room.path("whole"));
    for found in [0b1, 0b10, 0b101010101, 0b10101010, 0b1001001, 0b11011, 0b100110010, 0b111000] {
        std::fs::create_dir(room.path("o")).unwrap();
        for (i, (name, bytes)) in whole.iter().enumerate() {
            if found & (1 << i) != 0 {
                room.write(&format!("o/{name}"), bytes);
            }
        }
        room.good(&["render", "a.rhai", "-o", "o/f-#.png", "--resume"]);
        assert!(bytes(&room.path("o")) == whole, "{found:b}");
        std::fs::remove_dir_all(room.path("o")).unwrap();
    }
}

#[test]
fn what_killed_processes_left_is_removed_and_other_names_are_not() {
    let room = room();
    let whole = made(&room, &[]);
    assert_eq!(whole.len(), 5);
    room.write("o/.f-02.png.reflet-0123456789abcdef-0.tmp", "half");
    room.write("o/.other.png.reflet-0123456789abcdef-0.tmp", "another job's");
    let ran = room.good(&["render", "a.rhai", "-o", "o/f-##.png", "--resume"]);
    assert!(ran.err.contains("left by a killed process"), "{}", ran.err);
    assert!(ran.err.contains("5 frames were up to date"), "{}", ran.err);
    let names = room.names_in("o");
    assert_eq!(names[0], ".other.png.reflet-0123456789abcdef-0.tmp");
    assert_eq!(names.len(), 6, "{names:?}");
}

#[test]
fn a_plain_run_makes_all_anew_and_says_what_resume_would_have_kept() {
    let room = room();
    let render = || room.good(&["render", "a.rhai", "-o", "o/f-##.png"]).err;
    assert!(!render().contains("--resume"));
    std::fs::remove_file(room.path("o/f-00.png")).unwrap();
    let told = render();
    assert!(told.contains("4 frames were made anew"), "{told}");
    assert!(told.contains("--resume would have kept them"), "{told}");
}

#[test]
fn tiles_merge_to_the_picture_made_in_one_piece() {
    let mirror = "plane(#{ point: [0, -1, 0], normal: [0, 1, 0], material: #{ diffuse: 0.3, specular: 0.5 } });
settings(#{ transfer: \"linear\" });";
    let script = STILL.replace("height: 9", "height: 9, samples: 3");
    let room = Room::with(&[("a.rhai", &format!("{script}{mirror}")), ("still.rhai", STILL)]);
    let size = ["--size", "67x41"];
    let tile = |script: &str, tile: &str, out: &str| {
        let args = ["render", script, "-o", out, "--tile", tile];
        room.good(&[&args[..], &size].concat());
    };
    let mut parts = Vec::new();
    for row in 1..=2 {
        for column in 1..=3 {
            let out = format!("p/{column}-{row}.exr");
            tile("a.rhai", &format!("{column},{row}/3x2"), &out);
            parts.push(out);
        }
    }
    let merge = |parts: &[&str], out: &str| room.run(&[&["merge", "-o", out], parts].concat());
    let all: Vec<&str> = parts.iter().map(String::as_str).collect();
    for name in ["a.png", "a.exr", "a.jpg", "a.qoi"] {
        let (whole, merged) = (format!("whole/{name}"), format!("merged/{name}"));
        room.good(&[&["render", "a.rhai", "-o", &whole], &size[..]].concat());
        let ran = merge(&all, &merged);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        let read = |name: &str| std::fs::read(room.path(name)).unwrap();
        assert!(read(&whole) == read(&merged), "{name}");
        room.good(&[&["verify", "a.rhai", &merged], &size[..]].concat());
    }
    assert!(bytes(&room.path("merged")) == bytes(&room.path("whole")));

    tile("a.rhai", "1,1/2x2", "p/other.exr");
    tile("still.rhai", "1,1/3x2", "p/stranger.exr");
    room.good(&["render", "a.rhai", "-o", "p/whole.exr"]);
    let mut flipped = std::fs::read(room.path(all[0])).unwrap();
    *flipped.last_mut().unwrap() ^= 1;
    room.write("p/flipped.exr", flipped);
    let rest = &all[1..];
    for (first, words) in [
        (None, &["missing", "pixel 0,0"][..]),
        (Some("p/other.exr"), &["overlap"]),
        (Some("p/stranger.exr"), &["another scene"]),
        (Some("p/whole.exr"), &["no part of a picture"]),
        (Some("p/flipped.exr"), &["p/flipped.exr", "damaged"]),
        (Some("p/none.exr"), &["p/none.exr", "no such file"]),
        (Some("a.rhai"), &["a.rhai"]),
        (Some(all[1]), &["overlap"]),
    ] {
        let parts: Vec<&str> = first.into_iter().chain(rest.iter().copied()).collect();
        let ran = merge(&parts, "bad.png");
        assert_eq!(ran.code, Some(66), "{first:?}: {}", ran.err);
        for word in words {
            assert!(ran.err.contains(word), "{first:?}: {}", ran.err);
        }
        assert!(!room.path("bad.png").exists());
    }
}

#[test]
fn words_that_do_not_fit_a_part_are_usage_errors() {
    let room = Room::furnished();
    let render = |more: &[&str], words: &[&str]| {
        room.bad(&[&["render", "five.rhai"], more].concat(), 2, words);
    };
    render(&["-o", "a.gif", "--resume", "--shard", "1/2"], &["--shard", "gif"]);
    render(&["-o", "a.gif", "--shard", "1/2"], &["--shard", "reflet film"]);
    render(&["-o", "-", "--resume"], &["--resume", "stdout"]);
    render(&["-o", "a.png", "--shard", "3/2"], &["--shard", "2/5"]);
    render(&["-o", "a.png", "--tile", "1,1/2x2"], &["--tile", ".exr"]);
    render(&["-o", "a.exr", "--tile", "1,1/2x2"], &["--tile", "5 frames"]);
    render(&["-o", "a.exr", "--tile", "3,1/2x2"], &["--tile", "3,2/8x6"]);
    render(&["-o", "a.exr", "--tile", "1,1/99x1", "--frames", "0"], &["--tile", "16x9"]);
    room.bad(&["verify", "five.rhai", "-"], 2, &["verify"]);
    room.bad(&["merge", "-o", "a.png"], 2, &["PART"]);
    room.bad(&["merge", "a.exr", "-o", "a.gif"], 2, &["merge"]);
    assert!(room.made().is_empty(), "{:?}", room.made());
}

/// Earlier frames are gone with the folder: going on would hide that.
#[cfg(unix)]
#[test]
fn a_folder_that_vanishes_is_an_output_error() {
    use std::io::{BufRead, BufReader};
    let more = "animation(#{ frames: 100000 }); on_frame(|f| { paint.diffuse = f.t; });";
    let room = Room::with(&[("a.rhai", &format!("{STILL}{more}"))]);
    let mut child = room
        .command(&["render", "a.rhai", "-o", "o/f-#.png", "--json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    lines.by_ref().find(|line| line.contains(r#""event":"frame""#)).unwrap();
    while std::fs::remove_dir_all(room.path("o")).is_err() {}
    let last = lines.last().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(74), "{last}");
    assert!(last.contains("its folder is gone"), "{last}");
    assert!(last.contains("frame "), "{last}");
    assert!(!room.path("o").exists());
}
