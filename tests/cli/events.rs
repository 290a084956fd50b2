//! `--json`: what programs read.

use crate::room::{Ran, Room, STILL};
use serde_json::Value;
use std::process::Stdio;

fn lines(ran: &Ran) -> Vec<Value> {
    let parsed = ran.text().lines().map(serde_json::from_str::<Value>);
    parsed.collect::<Result<_, _>>().unwrap_or_else(|e| panic!("{e} in {}", ran.text()))
}

fn kinds(lines: &[Value]) -> Vec<&str> {
    lines.iter().map(|line| line["event"].as_str().unwrap()).collect()
}

#[test]
fn every_frame_is_an_event() {
    let room = Room::furnished();
    let ran =
        room.good(&["render", "five.rhai", "-o", "o/f-####.png", "--frames", "1-3", "--json"]);
    assert_eq!(ran.err, "", "people are told nothing");
    let lines = lines(&ran);
    assert_eq!(kinds(&lines), ["start", "frame", "frame", "frame", "done"]);
    assert_eq!(lines[0]["frames"], 3);
    assert_eq!((&lines[0]["width"], &lines[0]["height"]), (&16.into(), &9.into()));
    let mut bytes = 0;
    for (line, frame) in lines[1..4].iter().zip(1..) {
        assert_eq!(line["frame"], frame);
        let path = format!("o/f-{frame:04}.png");
        assert_eq!(line["path"], path);
        assert!(line["ms"].as_f64().unwrap() > 0.0);
        assert_eq!(line["bytes"], std::fs::metadata(room.path(&path)).unwrap().len());
        bytes += line["bytes"].as_u64().unwrap();
        assert!(line["retraced_pixels"].is_u64());
        for kind in ["camera", "mirror", "shadow"] {
            assert!(line["rays"][kind].is_u64(), "{kind}");
        }
    }
    assert_eq!(lines[1]["rays"]["camera"], 16 * 9);
    assert_eq!(lines[1]["rays"]["mirror"], 0, "nothing mirrors");
    let done = &lines[4];
    assert_eq!(done["frames"], 3);
    assert_eq!(done["bytes"], bytes);
    let camera: u64 = lines[1..4].iter().map(|l| l["rays"]["camera"].as_u64().unwrap()).sum();
    assert_eq!(done["rays"]["camera"], camera);
}

#[test]
fn warnings_and_errors_are_events_too() {
    let dark = STILL.replace("light(", "// light(");
    let room = Room::with(&[("dark.rhai", &dark), ("bad.rhai", "let a = \"b;\n")]);
    let ran = room.good(&["render", "dark.rhai", "-o", "a.png", "--json"]);
    let told = lines(&ran);
    assert_eq!(kinds(&told), ["warning", "start", "frame", "done"]);
    assert!(told[0]["message"].as_str().unwrap().contains("light"));

    let ran = room.bad(&["render", "bad.rhai", "-o", "a.png", "--json"], 65, &["bad.rhai:1"]);
    let told = lines(&ran);
    assert_eq!(kinds(&told), ["error"]);
    assert_eq!(told[0]["exit"], 65);
    assert!(told[0]["message"].as_str().unwrap().contains("bad.rhai:1"));
}

/// `print` goes to stderr with its line, and never between the events.
#[test]
fn what_a_script_prints_is_not_among_the_events() {
    let room = Room::with(&[("p.rhai", &format!("{STILL}print(\"here\");"))]);
    let ran = room.good(&["render", "p.rhai", "-o", "a.png", "--json"]);
    assert_eq!(ran.err, "p.rhai:7: here\n");
    assert_eq!(kinds(&lines(&ran)), ["start", "frame", "done"]);
    let ran = room.good(&["render", "p.rhai", "-o", "-"]);
    assert!(ran.err.starts_with("p.rhai:7: here\n"), "{}", ran.err);
    assert!(ran.out.starts_with(b"P6"));
}

#[test]
fn without_json_a_summary_closes_and_no_bar_is_drawn_off_a_terminal() {
    let room = Room::furnished();
    // Only a material changes: without re-use every frame is traced, with it the first one is.
    let kept = "4 of 5 frames cast no ray from the eye";
    for (more, camera, rate, last, out) in [
        (["--no-reuse"].as_slice(), "720 camera", "Mrays/s", "2 threads", "a/f.png"),
        (&[], "144 camera", "re-use saved 628 of 785 rays (80 %)", kept, "b/f.png"),
    ] {
        let args = ["render", "five.rhai", "-o", out, "--threads", "2", "--isa", "scalar"];
        let ran = room.good(&[args.as_slice(), more].concat());
        assert!(ran.out.is_empty());
        assert!(ran.err.trim_end().ends_with(last), "{}", ran.err);
        assert!(ran.err.starts_with("5 frames in "), "{}", ran.err);
        for word in ["f-0004.png", camera, "0 mirror", "shadow", rate, "scalar", "2 threads"] {
            assert!(ran.err.contains(word), "{word}: {}", ran.err);
        }
        assert!(!ran.err.contains('\x1b') && !ran.err.contains('\r'), "{:?}", ran.err);
    }
}

#[test]
fn a_listener_that_leaves_ends_the_render_quietly() {
    let room = Room::furnished();
    let mut child = room
        .command(&["render", "five.rhai", "-o", "f.png", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let ran: Ran = child.wait_with_output().unwrap().into();
    assert_eq!((ran.code, ran.err.as_str()), (Some(74), ""));
}

/// `--verbose` names what changed, and says what was redone for it.
#[test]
fn a_frame_is_told_with_what_changed_in_it() {
    let room = Room::furnished();
    let ran = room.good(&["render", "five.rhai", "-o", "f.png", "--frames", "1-2", "--verbose"]);
    let told: Vec<&str> = ran.err.lines().filter(|line| line.starts_with("frame ")).collect();
    assert!(told[0].starts_with("frame 1: traced anew (there is no frame before); "), "{told:?}");
    assert!(
        told[1].starts_with("frame 2: changed: material (line 5) colours; no ray cast; "),
        "{told:?}"
    );
    assert_eq!(told.len(), 2);

    // The same for programs.
    let ran = room.good(&["render", "five.rhai", "-o", "f.png", "--frames", "1-2", "--json"]);
    let frames: Vec<Value> = lines(&ran).into_iter().filter(|e| e["event"] == "frame").collect();
    assert_eq!(frames[0]["fresh"], "there is no frame before");
    assert_eq!(frames[1]["fresh"], Value::Null);
    assert_eq!(frames[1]["changes"], 1);
    assert_eq!(frames[1]["changed"][0]["name"], "material (line 5)");
    assert_eq!(frames[1]["changed"][0]["how"], "colours");
    assert_eq!(frames[1]["accel_rays"], 0);
}

/// What moves is retraced where it can be seen, and no more is said to have been.
#[test]
fn counts_tell_what_was_redone() {
    let ball = "sphere(#{ center: [0.6, 0.6, 1.2], radius: 0.3, material: paint })";
    let moves = "on_frame(|f| { small.center = [0.6 - 0.1 * f.index, 0.6, 1.2]; });";
    let script =
        format!("{STILL}let small = {ball};\nanimation(#{{ frames: 3, fps: 10 }});\n{moves}");
    let room = Room::with(&[("moves.rhai", &script)]);
    let ran = room.good(&["render", "moves.rhai", "-o", "f.png", "--json"]);
    let frames: Vec<Value> = lines(&ran).into_iter().filter(|e| e["event"] == "frame").collect();
    assert_eq!(frames[0]["retraced_pixels"], 144);
    for frame in &frames[1..] {
        let pixels = frame["retraced_pixels"].as_u64().unwrap();
        assert!((1..40).contains(&pixels), "{frame}");
        assert_eq!(frame["rays"]["camera"], pixels);
        assert!(frame["tested_segments"].as_u64().unwrap() > 0);
        assert_eq!(frame["changed"][0]["how"], "moved");
    }
}
