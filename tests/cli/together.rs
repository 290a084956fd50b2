//! Two runs at one place, and a place that is taken away.
#![cfg(unix)]

use crate::room::{Ran, Room, STILL};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Stdio};

/// An animation whose events fill a pipe before it ends, so that a run waits until they are read.
fn long(frames: u32) -> Room {
    let more = format!(
        "animation(#{{ frames: {frames}, fps: 25 }}); on_frame(|f| {{ paint.diffuse = f.phase; }});"
    );
    Room::with(&[("a.rhai", &format!("{STILL}{more}"))])
}

/// A run that waits in its midst until the rest of its events are read.
struct Waiting {
    child: Child,
    events: BufReader<ChildStdout>,
}

impl Waiting {
    fn start(room: &Room, wrap: &[&str], out: &str) -> Self {
        let args = ["render", "a.rhai", "-o", out, "--json", "--threads", "1"];
        let inner = room.command(&args);
        let mut command = match wrap {
            [] => inner,
            [first, rest @ ..] => {
                let mut outer = Command::new(first);
                outer.args(rest).arg(inner.get_program()).args(args).current_dir(room.path("."));
                outer
            }
        };
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut events = BufReader::with_capacity(16, child.stdout.take().unwrap());
        let mut line = String::new();
        while !line.contains(r#""event":"frame""#) {
            line.clear();
            assert!(events.read_line(&mut line).unwrap() > 0, "it ends early");
        }
        Waiting { child, events }
    }

    fn end(mut self) -> Ran {
        let mut rest = Vec::new();
        self.events.read_to_end(&mut rest).unwrap();
        self.child.wait_with_output().unwrap().into()
    }
}

/// What makes two processes have one number: a namespace each. `None` where that is not allowed.
fn namespaces() -> Option<&'static [&'static str]> {
    const ALL: [&[&str]; 2] =
        [&["unshare", "--pid", "--fork"], &["unshare", "--user", "--pid", "--fork"]];
    let works = |wrap: &&'static [&'static str]| {
        let ran = Command::new(wrap[0]).args(&wrap[1..]).args(["sh", "-c", "test $$ = 1"]).output();
        ran.is_ok_and(|ran| ran.status.success())
    };
    ALL.iter().copied().find(|wrap| works(wrap))
}

#[test]
fn two_runs_at_one_film_both_end_well_and_it_is_whole() {
    const FRAMES: u32 = 600;
    let room = long(FRAMES);
    let mut ways: Vec<&[&str]> = vec![&[]];
    match namespaces() {
        Some(wrap) => ways.push(wrap),
        None => println!("skipped: no namespaces of process numbers may be made here"),
    }
    for out in ["whole.gif", "whole.y4m"] {
        room.good(&["render", "a.rhai", "-o", out]);
        let whole = std::fs::read(room.path(out)).unwrap();
        let out = out.replace("whole", "both");
        for wrap in &ways {
            for first_ends_first in [true, false] {
                let one = Waiting::start(&room, wrap, &out);
                let two = Waiting::start(&room, wrap, &out);
                let (first, second) = if first_ends_first { (one, two) } else { (two, one) };
                for ran in [first.end(), second.end()] {
                    assert_eq!(ran.code, Some(0), "{}", ran.err);
                    assert!(std::fs::read(room.path(&out)).unwrap() == whole, "{out} {wrap:?}");
                }
                room.good(&["verify", "a.rhai", &out]);
                std::fs::remove_file(room.path(&out)).unwrap();
            }
        }
    }
    assert!(room.names_in(".").iter().all(|name| !name.ends_with(".tmp")), "{:?}", room.made());
}

#[test]
fn what_a_killed_run_left_is_swept_and_a_living_one_is_not() {
    let room = long(600);
    let mut killed = Waiting::start(&room, &[], "f.y4m");
    killed.child.kill().unwrap();
    killed.child.wait().unwrap();
    let temporary = || room.names_in(".").into_iter().filter(|n| n.ends_with(".tmp")).count();
    assert_eq!(temporary(), 1);
    let living = Waiting::start(&room, &[], "f.y4m");
    assert_eq!(temporary(), 1, "the orphan is gone");
    room.good(&["render", "a.rhai", "-o", "f.y4m", "--size", "8x4"]);
    assert_eq!(temporary(), 1, "the living one stays");
    assert_eq!(living.end().code, Some(0));
    room.good(&["verify", "a.rhai", "f.y4m"]);
    assert_eq!(temporary(), 0);
}

#[test]
fn a_folder_that_is_replaced_during_a_run_is_noticed() {
    for made_anew in [true, false] {
        let room = long(400);
        let run = Waiting::start(&room, &[], "o/f-###.png");
        // Files are written while this happens, so that the run may fail at one of them, too.
        if made_anew {
            std::fs::rename(room.path("o"), room.path("away")).unwrap();
            std::fs::create_dir(room.path("o")).unwrap();
        } else {
            std::fs::remove_file(room.path("o/f-000.png")).unwrap();
        }
        let ran = run.end();
        assert_eq!(ran.code, Some(74), "{}", ran.err);
        let there: Vec<String> = room.names_in("o");
        assert!(there.len() < 400);
        if ran.err.contains("are missing") {
            let (what, first) = match made_anew {
                true => ("the folder was replaced", " are missing in o: 0"),
                false => ("files were removed", "1 of 400 frames are missing in o: 0;"),
            };
            assert!(ran.err.contains(what) && ran.err.contains(first), "{}", ran.err);
            assert!(ran.err.contains("--resume"), "{}", ran.err);
        } else {
            assert!(made_anew, "{}", ran.err);
        }
        room.good(&["render", "a.rhai", "-o", "o/f-###.png", "--resume"]);
        room.good(&["verify", "a.rhai", "o/f-###.png"]);
    }
}
