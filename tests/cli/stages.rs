//! Signals at each stage of a render: while a mesh is read, a tree built, rays traced, a picture
//! encoded. (Scripts that do not end are in `stopped`.)
#![cfg(unix)]

use crate::room::Room;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Vertices along an edge of the mesh.
const EDGE: u32 = 600;

/// A scene of which every stage takes long: a mesh of 717,602 triangles, and a large picture that
/// is packed as small as can be.
fn room() -> Room {
    let mut text = Vec::new();
    for i in 0..EDGE * EDGE {
        let (x, z) = (f64::from(i % EDGE) * 0.01 - 3.0, f64::from(i / EDGE) * 0.01 - 3.0);
        writeln!(text, "v {x:.6} {:.6} {z:.6}", 0.2 * (9.0 * x * z).sin()).unwrap();
    }
    for i in (0..EDGE * (EDGE - 1)).filter(|i| i % EDGE != EDGE - 1) {
        let (a, b) = (i + 1, i + EDGE + 1);
        writeln!(text, "f {a} {b} {}\nf {b} {} {}", a + 1, b + 1, a + 1).unwrap();
    }
    let script = "
image(#{ width: 1600, height: 1200 });
camera(#{ eye: [0, 4, 3], look_at: [0, 0, 0] });
light(#{ at: [3, 4, 5], emissivity: 40 });
mesh(#{ file: \"m.obj\", material: #{ diffuse: [0.8, 0.4, 0.2], specular: 0.3 } });
";
    let room = Room::with(&[("a.rhai", script)]);
    room.write("m.obj", text);
    room
}

fn start(room: &Room) -> (Child, Instant) {
    let args = ["render", "a.rhai", "-o", "o/a.png", "--compression", "small", "--json"];
    let mut command = room.command(&args);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    (child, Instant::now())
}

#[test]
fn each_stage_ends_soon_after_a_signal() {
    let room = room();
    // When the stages are, on this machine.
    let (mut child, begin) = start(&room);
    let mut times = Vec::new();
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        let event: Value = serde_json::from_str(&line.unwrap()).unwrap();
        times.push((event["event"].as_str().unwrap().to_owned(), begin.elapsed(), event));
    }
    assert!(child.wait().unwrap().success());
    std::fs::remove_dir_all(room.path("o")).unwrap();
    let of = |name: &str| times.iter().find(|(event, ..)| event == name).unwrap();
    let ((_, started, _), (_, done, report)) = (of("start"), of("frame"));
    let took = |stage: &str| Duration::from_secs_f64(report[stage].as_f64().unwrap() / 1e3);
    let (encode, trace, build) = (took("encode_ms"), took("trace_ms"), took("build_ms"));
    let encoding = done.saturating_sub(encode / 2);
    let tracing = done.saturating_sub(encode + trace / 2);
    let building = done.saturating_sub(encode + trace + build / 2);
    println!("load {started:?}, build {build:?}, trace {trace:?}, encode {encode:?}");

    for (stage, after) in [
        ("load", *started / 4),
        ("load", *started / 2),
        ("build", building),
        ("trace", tracing),
        ("encode", encoding),
    ] {
        for (name, code) in [("-INT", 130), ("-TERM", 143), ("-USR1", 75)] {
            let mut after = after;
            let (output, took) = loop {
                let (child, begin) = start(&room);
                std::thread::sleep(after.saturating_sub(begin.elapsed()));
                let sent = Instant::now();
                let killed = Command::new("kill").arg(name).arg(child.id().to_string()).status();
                assert!(killed.unwrap().success());
                let output = child.wait_with_output().unwrap();
                // The machine may be quicker now than when it was timed: then the signal comes
                // sooner.
                if !output.status.success() || stage == "encode" {
                    break (output, sent.elapsed());
                }
                assert!(after > Duration::from_millis(20), "{stage}: {name} was not heard");
                after = after * 3 / 4;
                std::fs::remove_dir_all(room.path("o")).unwrap();
            };
            let told = String::from_utf8_lossy(&output.stderr);
            let what = format!("{stage}, {name} after {after:?}: {took:?}, {told}");
            // The machine may have been quicker this time.
            if !(output.status.success() && stage == "encode") {
                assert_eq!(output.status.code(), Some(code), "{what}");
                assert!(told.contains("stopped"), "{what}");
                let left = room.path("o").exists().then(|| room.names_in("o"));
                assert_eq!(left.unwrap_or_default(), [""; 0], "{what}");
            }
            assert!(took < Duration::from_secs(3), "{what}");
            let _ = std::fs::remove_dir_all(room.path("o"));
        }
    }
}
