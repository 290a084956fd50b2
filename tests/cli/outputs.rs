//! Files: made whole or not at all.

use crate::room::{Ran, Room, png};
use std::process::Stdio;

#[test]
fn every_format_is_made() {
    let room = Room::furnished();
    let starts: &[(&str, &[u8])] = &[
        ("a.png", b"\x89PNG\r\n\x1a\n"),
        ("a.exr", b"\x76\x2f\x31\x01"),
        ("a.qoi", b"qoif"),
        ("a.jpg", b"\xff\xd8\xff"),
        ("a.ppm", b"P6"),
        ("a.pfm", b"PF"),
        ("a.gif", b"GIF89a"),
        ("a.apng", b"\x89PNG\r\n\x1a\n"),
        ("a.y4m", b"YUV4MPEG2 W16 H9"),
        ("a.webp", b"RIFF"),
    ];
    for (name, start) in starts {
        room.good(&["render", "still.rhai", "-o", name]);
        let bytes = std::fs::read(room.path(name)).unwrap();
        assert!(bytes.starts_with(start), "{name}: {:?}", &bytes[..16]);
    }
    room.good(&["render", "still.rhai", "-o", "picture", "--format", "png"]);
    assert_eq!(png(&room.path("picture")), png(&room.path("a.png")));
    // QOI, PFM and Y4M hold no text.
    assert_eq!(room.made().len(), starts.len() + 4, "no temporary file stays: {:?}", room.made());
}

#[test]
fn frames_are_numbered_and_films_are_not() {
    let room = Room::furnished();
    room.good(&["render", "five.rhai", "-o", "a.png", "--frames", "2"]);
    room.good(&["render", "five.rhai", "-o", "new/folder/b%02d.png"]);
    room.good(&["render", "five.rhai", "-o", "c.gif"]);
    assert_eq!(room.made(), ["a-0002.png", "c.gif", "new"]);
    assert_eq!(room.names_in("new/folder").len(), 5);
    assert_eq!(png(&room.path("a-0002.png")), png(&room.path("new/folder/b02.png")));
}

#[test]
fn stdout_takes_a_still_as_ppm_and_an_animation_as_y4m() {
    let room = Room::furnished();
    let still = room.good(&["render", "still.rhai", "-o", "-"]);
    let head = b"P6\n16 9\n255\n";
    assert!(still.out.starts_with(head), "{:?}", &still.out[..16]);
    assert_eq!(still.out.len(), head.len() + 16 * 9 * 3);
    room.good(&["render", "still.rhai", "-o", "a.png"]);
    assert_eq!(still.out[head.len()..], png(&room.path("a.png")).2);
    let film = room.good(&["render", "five.rhai", "-o", "-"]);
    assert!(film.out.starts_with(b"YUV4MPEG2 W16 H9 F10:1 "));
    let frames = film.out.windows(6).filter(|w| w == b"FRAME\n").count();
    assert_eq!(frames, 5);
    assert_eq!(room.made(), ["a.png"]);
}

#[test]
fn frames_on_disk_become_the_film_that_a_render_makes() {
    let room = Room::furnished();
    room.good(&["render", "five.rhai", "-o", "f/a-##.png"]);
    for name in ["a.gif", "a.apng", "a.webp", "a.y4m"] {
        let joined = format!("joined-{name}");
        room.good(&["render", "five.rhai", "-o", name]);
        room.good(&["film", "f/a-##.png", "-o", &joined, "--fps", "10"]);
        let read = |name: &str| std::fs::read(room.path(name)).unwrap();
        assert!(read(name) == read(&joined), "{name}");
    }
    room.good(&["render", "five.rhai", "-o", "f/a-##.exr", "--frames", "1-2"]);
    room.good(&["film", "f/a-01.exr", "f/a-02.exr", "-o", "exr.y4m"]);
    room.good(&["film", "f/a-##.png", "-o", "png.y4m", "--frames", "1-2"]);
    let read = |name: &str| std::fs::read(room.path(name)).unwrap();
    assert!(read("exr.y4m") == read("png.y4m"));

    let film = |more: &[&str], code: i32, words: &[&str]| {
        room.bad(&[&["film", "-o", "bad.gif"], more].concat(), code, words);
        assert!(!room.path("bad.gif").exists());
    };
    film(&["f/b-##.png"], 66, &["no frames", "f/b-00.png"]);
    film(&["f/a-##.png", "--frames", "3-5"], 66, &["frames 5 of", "missing"]);
    std::fs::remove_file(room.path("f/a-03.png")).unwrap();
    film(&["f/a-##.png"], 66, &["frames 3 of", "--resume"]);
    film(&["f/a-00.png", "still.rhai"], 66, &["still.rhai", "PNG"]);
    room.good(&["render", "still.rhai", "-o", "wide.png", "--size", "17x9"]);
    film(&["f/a-00.png", "wide.png"], 66, &["17x9", "16x9"]);
    let mut bad = read("f/a-01.png");
    bad.truncate(bad.len() - 20);
    room.write("f/a-01.png", bad);
    film(&["f/a-00.png", "f/a-01.png"], 66, &["f/a-01.png", "damaged"]);
    film(&["f/a-00.png", "--fps", "0"], 2, &["--fps"]);
    room.bad(&["film", "f/a-00.png", "-o", "a.png"], 2, &["no film"]);
}

#[test]
fn ffmpeg_makes_what_it_is_there_for() {
    use std::process::Command;
    let room = Room::furnished();
    let args = ["render", "five.rhai", "-o", "a.mp4"];
    let ran: Ran = room.command(&args).env("PATH", "").output().unwrap().into();
    assert_eq!(ran.code, Some(74), "{}", ran.err);
    assert!(ran.err.contains("install it"), "{}", ran.err);
    assert_eq!(room.made(), [""; 0]);
    if Command::new("ffprobe").arg("-version").output().is_err() {
        let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
        assert!(!required, "ffmpeg is not there");
        println!("skipped: ffmpeg is not there");
        return;
    }
    for name in ["a.mp4", "a.mkv"] {
        let again = format!("again-{name}");
        room.good(&["render", "five.rhai", "-o", name, "--size", "33x21"]);
        room.good(&["render", "five.rhai", "-o", &again, "--size", "33x21", "--threads", "1"]);
        let read = |name: &str| std::fs::read(room.path(name)).unwrap();
        assert!(read(name) == read(&again), "{name}: the same frames give other bytes");
        let mut probe = Command::new("ffprobe");
        probe.args(["-v", "error", "-count_frames", "-of", "csv=p=0", "-show_entries"]);
        probe.args(["stream=codec_name,width,height,r_frame_rate,nb_read_frames"]);
        let told = probe.arg(room.path(name)).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&told.stdout).trim(), "h264,34,22,10/1,5", "{name}");
    }
    assert_eq!(room.made().len(), 4, "{:?}", room.made());
}

#[test]
fn a_draft_is_a_quarter_in_size() {
    let room = Room::furnished();
    room.good(&["render", "still.rhai", "-o", "a.png", "--draft", "--size", "64x10"]);
    let (width, height, _) = png(&room.path("a.png"));
    assert_eq!((width, height), (16, 2));
    room.good(&["render", "still.rhai", "-o", "b.png", "--draft", "--size", "1x3"]);
    assert_eq!(png(&room.path("b.png")).0, 1);
}

#[test]
fn options_of_work_do_not_show() {
    let room = Room::furnished();
    let bytes = |name: &str, more: &[&str]| {
        room.good(&[&["render", "still.rhai", "-o", name, "--size", "50x40"], more].concat());
        std::fs::read(room.path(name)).unwrap()
    };
    let plain = bytes("a.png", &[]);
    assert_eq!(plain, bytes("b.png", &["--threads", "1"]));
    assert_eq!(plain, bytes("c.png", &["--threads", "16", "--no-reuse"]));
    assert_eq!(plain, bytes("d.png", &["--isa", "scalar"]));
}

#[test]
fn a_folder_as_target_is_an_error() {
    let room = Room::furnished();
    std::fs::create_dir(room.path("dir.png")).unwrap();
    room.bad(&["render", "still.rhai", "-o", "dir.png"], 74, &["dir.png"]);
    assert!(room.names_in("dir.png").is_empty());
    room.bad(&["render", "still.rhai", "-o", "still.rhai/a.png"], 74, &["still.rhai"]);
    assert_eq!(room.made(), ["dir.png"]);
}

#[test]
fn a_file_that_is_there_is_replaced_when_the_new_one_is_whole() {
    let room = Room::furnished();
    room.write("a.png", "old");
    room.write("bad.rhai", "nonsense(");
    room.bad(&["render", "bad.rhai", "-o", "a.png"], 65, &[]);
    assert_eq!(std::fs::read(room.path("a.png")).unwrap(), b"old");
    room.good(&["render", "still.rhai", "-o", "a.png"]);
    assert_eq!(png(&room.path("a.png")).0, 16);
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let room = Room::furnished();
    std::fs::create_dir(room.path("far")).unwrap();
    std::os::unix::fs::symlink("far/b.png", room.path("a.png")).unwrap();
    room.good(&["render", "still.rhai", "-o", "a.png"]);
    assert!(room.path("a.png").is_symlink());
    assert_eq!(room.names_in("far"), ["b.png"]);
    assert_eq!(png(&room.path("a.png")).0, 16);
}

#[test]
fn a_reader_that_leaves_gets_no_message() {
    let room = Room::furnished();
    for script in ["still.rhai", "five.rhai"] {
        let mut child = room
            .command(&["render", script, "-o", "-", "--size", "640x360"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let ran: Ran = child.wait_with_output().unwrap().into();
        assert_eq!(ran.code, Some(74), "{}", ran.err);
        assert_eq!(ran.err, "");
    }
}

#[test]
fn more_compression_is_smaller_and_the_same_picture() {
    let room = Room::furnished();
    let script = std::fs::read_to_string(room.path("still.rhai")).unwrap();
    room.write("still.rhai", script.replace("width: 16, height: 9", "width: 160, height: 90"));
    let mut sizes = Vec::new();
    for level in ["fast", "balanced", "small"] {
        let name = format!("{level}.png");
        room.good(&["render", "still.rhai", "-o", &name, "--compression", level]);
        assert_eq!(png(&room.path(&name)), png(&room.path("fast.png")));
        sizes.push(std::fs::metadata(room.path(&name)).unwrap().len());
    }
    assert!(sizes[1] < sizes[0] && sizes[2] <= sizes[1], "{sizes:?}");
    let ran = room.run(&["render", "still.rhai", "-o", "a.png", "--compression", "best"]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.err.contains("one of fast, balanced and small"), "{}", ran.err);
}
