//! SIGINT and SIGTERM.
#![cfg(unix)]

use crate::room::{Ran, Room, STILL};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// An animation that no test waits for.
fn endless() -> Room {
    let more = "animation(#{ frames: 1000000 }); on_frame(|f| { paint.diffuse = f.t; });";
    let script = STILL.replace("width: 16, height: 9", "width: 160, height: 90");
    Room::with(&[("a.rhai", &format!("{script}{more}"))])
}

/// An animation that does not get beyond its frame 199. (Frames are told of some batches later.)
fn stuck() -> String {
    format!(
        "{STILL}animation(#{{ frames: 400 }}); on_frame(|f| {{ if f.index == 199 {{ loop {{ }} }} }});"
    )
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").arg(name).arg(child.id().to_string()).status();
    assert!(sent.unwrap().success());
}

/// Starts a render with `--json`, and waits until `frames` frames are done.
fn start(room: &Room, out: &str, frames: usize) -> Child {
    let mut child = room
        .command(&["render", "a.rhai", "-o", out, "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let frame = |line: &String| line.contains(r#""event":"frame""#);
    let seen = lines.by_ref().map_while(Result::ok).filter(frame).take(frames).count();
    assert_eq!(seen, frames);
    // The rest must be read, or the process would wait.
    std::thread::spawn(move || lines.map_while(Result::ok).count());
    child
}

fn end(child: Child) -> Ran {
    child.wait_with_output().unwrap().into()
}

#[test]
fn frames_that_were_done_stand_and_nothing_else_stays() {
    for (name, code) in [("-INT", 130), ("-TERM", 143), ("-USR1", 75)] {
        let room = endless();
        let child = start(&room, "f-#.png", 3);
        signal(&child, name);
        let ran = end(child);
        assert_eq!(ran.code, Some(code), "{name}: {}", ran.err);
        assert!(ran.err.starts_with("error: stopped"), "{}", ran.err);
        assert!(ran.err.contains("--resume"), "{}", ran.err);
        let made = room.made();
        assert!(made.len() >= 3, "{made:?}");
        for name in made {
            assert!(name.starts_with("f-"), "{name}");
            assert_eq!(crate::room::png(&room.path(&name)).0, 160, "{name}");
        }
    }
}

#[test]
fn a_film_that_is_not_whole_does_not_stay() {
    let room = endless();
    let child = start(&room, "f.y4m", 3);
    signal(&child, "-INT");
    assert_eq!(end(child).code, Some(130));
    assert_eq!(room.made(), [""; 0]);
}

#[test]
fn a_script_that_does_not_end_is_ended() {
    let room = Room::with(&[("a.rhai", &stuck()), ("b.rhai", "loop { }")]);
    // In a frame function, while a film is being written.
    let child = start(&room, "f.y4m", 3);
    signal(&child, "-TERM");
    assert_eq!(end(child).code, Some(143));
    assert_eq!(room.made(), [""; 0]);
    // In the script itself: a message comes after two seconds, and then it is surely running.
    let mut child =
        room.command(&["render", "b.rhai", "-o", "b.png"]).stderr(Stdio::piped()).spawn().unwrap();
    let mut told = String::new();
    BufReader::new(child.stderr.as_mut().unwrap()).read_line(&mut told).unwrap();
    assert!(told.contains("Ctrl-C"), "{told}");
    let begin = Instant::now();
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // A thousand million operations would take longer than this on any machine.
    assert!(begin.elapsed() < Duration::from_secs(5));
}

#[test]
fn a_second_signal_ends_at_once() {
    let room = Room::with(&[("a.rhai", &stuck())]);
    let child = start(&room, "f.y4m", 3);
    signal(&child, "-INT");
    // Two signals of one kind that come too close are one.
    std::thread::sleep(Duration::from_millis(200));
    signal(&child, "-INT");
    assert_eq!(end(child).code, Some(130));
    assert_eq!(room.made(), [""; 0]);
}

#[test]
fn a_watch_is_ended_while_it_waits() {
    let room = Room::with(&[("a.rhai", STILL)]);
    for (name, code) in [("-INT", 130), ("-TERM", 143)] {
        let mut child = room
            .command(&["render", "a.rhai", "-o", "a.png", "--watch"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut told = String::new();
        BufReader::new(child.stderr.as_mut().unwrap()).read_line(&mut told).unwrap();
        assert!(told.starts_with("1 frame in "), "{told}");
        signal(&child, name);
        assert_eq!(child.wait().unwrap().code(), Some(code));
        assert_eq!(room.made(), ["a.png"]);
    }
}
