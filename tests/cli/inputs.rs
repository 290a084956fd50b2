//! An output is never an input, and what another program wrote stays.

use crate::room::{FIVE, Room, STILL};
use std::io::Read;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A scene that wears a picture, and a second one from frame 2 on.
fn textured() -> Room {
    let more = "
let wall = textured(#{ base: paint, file: \"wall.ppm\" });
sphere(#{ center: [2, 0, 0], radius: 0.5, material: wall });
animation(#{ frames: 5, fps: 10 });
on_frame(|f| {
    if f.index == 2 {
        let late = textured(#{ base: paint, file: \"late.ppm\" });
        sphere(#{ center: [-2, 0, 0], radius: 0.5, material: late });
    }
});
";
    let scene = format!("{STILL}{more}");
    let room = Room::with(&[("a.rhai", &scene), ("still.rhai", STILL)]);
    for name in ["wall.ppm", "late.ppm"] {
        room.write(name, b"P6\n2 1\n255\n\xff\x00\x00\x00\xff\x00");
    }
    room
}

/// Everything in the folder but for the scripts' changes: names and bytes.
fn all(room: &Room) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| {
        let bytes = std::fs::read(room.path(&name)).unwrap_or_default();
        (name, bytes)
    };
    room.names_in(".").into_iter().map(read).collect()
}

/// Refused, with these words, and nothing is written.
fn refused(room: &Room, args: &[&str], words: &[&str]) {
    let before = all(room);
    room.bad(args, 74, words);
    assert!(all(room) == before, "{args:?}");
}

#[test]
fn a_render_spares_its_script_and_what_it_reads() {
    let room = textured();
    let render = ["render", "a.rhai", "-o"];
    refused(&room, &[&render[..], &["a.rhai", "--format", "gif"]].concat(), &["a.rhai", "input"]);
    refused(
        &room,
        &[&render[..], &["wall.ppm", "--frames", "0", "--format", "gif"]].concat(),
        &["wall.ppm"],
    );
    refused(
        &room,
        &["render", "still.rhai", "-o", "still.rhai", "--format", "png"],
        &["still.rhai"],
    );
    std::fs::hard_link(room.path("wall.ppm"), room.path("hard-0003.ppm")).unwrap();
    refused(&room, &[&render[..], &["hard.ppm"]].concat(), &["hard-0003.ppm", "wall.ppm"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.rhai", room.path("soft.gif")).unwrap();
        refused(&room, &[&render[..], &["soft.gif"]].concat(), &["soft.gif", "a.rhai"]);
    }
    // What only a frame reads is known once it is read.
    let before = std::fs::read(room.path("late.ppm")).unwrap();
    room.bad(&[&render[..], &["late.ppm", "--format", "gif"]].concat(), 74, &["late.ppm"]);
    assert_eq!(std::fs::read(room.path("late.ppm")).unwrap(), before);
}

#[test]
fn a_watch_that_would_render_without_end_ends() {
    let room = textured();
    for out in ["a.rhai", "wall.ppm"] {
        let args = ["render", "a.rhai", "-o", out, "--format", "gif", "--watch"];
        let mut child = room.command(&args).stderr(Stdio::piped()).spawn().unwrap();
        let begin = Instant::now();
        let status = loop {
            match child.try_wait().unwrap() {
                Some(status) => break status,
                None if begin.elapsed() > Duration::from_secs(60) => {
                    child.kill().unwrap();
                    panic!("{out}: it goes on");
                }
                None => std::thread::sleep(Duration::from_millis(20)),
            }
        };
        let mut err = String::new();
        child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        assert_eq!(status.code(), Some(74), "{err}");
    }
}

#[test]
fn a_profile_spares_its_inputs() {
    let room = textured();
    // A heat map's name ends in .png.
    for option in ["--save", "--trace", "--dump"] {
        for file in ["a.rhai", "wall.ppm"] {
            refused(&room, &["profile", "a.rhai", "--repeat", "1", option, file], &[file]);
        }
    }
    refused(&room, &["profile", "a.rhai", "--save", "f", "--trace", "f"], &["two outputs"]);
    room.write("f.npy", "x");
    let files = ["profile", "--spheres", "f.npy", "--rays", "f.npy"];
    refused(&room, &[&files[..], &["--hits", "f.npy"]].concat(), &["f.npy"]);
}

#[test]
fn a_film_and_a_whole_picture_spare_their_parts() {
    let room = Room::with(&[("a.rhai", &format!("{STILL}{FIVE}")), ("still.rhai", STILL)]);
    room.good(&["render", "a.rhai", "-o", "f-#.png"]);
    refused(&room, &["film", "f-#.png", "-o", "f-3.png", "--format", "apng"], &["f-3.png"]);
    room.good(&["render", "still.rhai", "-o", "p-1.exr", "--tile", "1,1/2x1"]);
    room.good(&["render", "still.rhai", "-o", "p-2.exr", "--tile", "2,1/2x1"]);
    refused(&room, &["merge", "p-1.exr", "p-2.exr", "-o", "p-2.exr"], &["p-2.exr"]);
}

#[test]
fn a_file_of_another_program_beside_a_film_stays() {
    let room = Room::with(&[("a.rhai", &format!("{STILL}{FIVE}")), ("still.rhai", STILL)]);
    room.good(&["render", "a.rhai", "-o", "f-#.exr"]);
    for (script, out) in [("a.rhai", "z.y4m"), ("still.rhai", "z.qoi"), ("still.rhai", "z.pfm")] {
        let beside = format!("{out}.reflet");
        room.write(&beside, "my notes\n");
        refused(&room, &["render", script, "-o", out], &[out, &beside]);
        if script == "a.rhai" {
            // This film would say nothing, and remove what stands there.
            refused(&room, &["film", "f-#.exr", "-o", out], &[out, &beside]);
        }
        std::fs::remove_file(room.path(&beside)).unwrap();
        // Ours is replaced, even a damaged one.
        room.good(&["render", script, "-o", out]);
        let mut ours = std::fs::read(room.path(&beside)).unwrap();
        ours.truncate(ours.len() / 2);
        room.write(&beside, ours);
        room.good(&["render", script, "-o", out]);
    }
}

#[test]
fn a_terminal_gets_no_picture() {
    let room = Room::furnished();
    let program = env!("CARGO_BIN_EXE_reflet");
    let under_terminal = |command: &str| {
        let mut script = std::process::Command::new("script");
        script.args(["-qec", command, "/dev/null"]).current_dir(room.path("."));
        script.stdin(Stdio::null()).output()
    };
    let Ok(probe) = under_terminal("test -t 1 && echo yes") else {
        println!("skipped: there is no script(1)");
        return;
    };
    if !String::from_utf8_lossy(&probe.stdout).contains("yes") {
        println!("skipped: script(1) makes no terminal");
        return;
    }
    room.good(&["render", "five.rhai", "-o", "f-#.png"]);
    for args in ["render still.rhai -o -", "film f-#.png -o - --format y4m"] {
        let ran = under_terminal(&format!("'{program}' {args}")).unwrap();
        assert_eq!(ran.status.code(), Some(2), "{args}");
        assert!(String::from_utf8_lossy(&ran.stdout).contains("a terminal"), "{args}");
    }
}
