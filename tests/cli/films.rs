//! Films that say what they were made from: kept, checked and made again as a whole.

use crate::room::{FIVE, Room, STILL};
use std::process::Command;

const OWN: [&str; 4] = ["f.gif", "f.apng", "f.webp", "f.y4m"];

fn room() -> Room {
    let more = "let gloss = param(\"gloss\", 0.25, 0.0, 1.0);\n\
                sphere(#{ center: [1, 1, 0], radius: 0.5, material: #{ diffuse: gloss } });\n";
    Room::with(&[("a.rhai", &format!("{STILL}{FIVE}{more}"))])
}

/// Films that this machine can make.
fn films() -> Vec<&'static str> {
    let ffmpeg = Command::new("ffprobe").arg("-version").output().is_ok();
    let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
    assert!(ffmpeg || !required, "ffmpeg is not there");
    let others: &[&str] = if ffmpeg { &["f.mp4", "f.mkv"] } else { &[] };
    if !ffmpeg {
        println!("skipped: ffmpeg is not there");
    }
    OWN.iter().chain(others).copied().collect()
}

fn verify(room: &Room, film: &str, code: i32, what: &str) {
    let ran = room.run(&["verify", "a.rhai", film]);
    assert_eq!(ran.code, Some(code), "{film}, {what}: {}", ran.err);
    let again = if code == 0 { "" } else { "0-4\n" };
    assert_eq!(ran.text(), again, "{film}, {what}");
}

/// Renders with `--resume`; gives what was told of the film, and how many frames were made.
fn resumed(room: &Room, film: &str, more: &[&str]) -> (String, usize) {
    let args = ["render", "a.rhai", "-o", film, "--resume", "--json"];
    let ran = room.good(&[&args[..], more].concat());
    let told = ran.text().lines().find(|line| line.contains(r#""event":"film_"#));
    let made = ran.text().lines().filter(|line| line.contains(r#""event":"frame""#)).count();
    (told.unwrap_or_default().to_owned(), made)
}

#[test]
fn a_film_is_kept_if_it_is_what_it_would_be_now() {
    let room = room();
    for film in films() {
        verify(&room, film, 1, "before");
        let (told, made) = resumed(&room, film, &[]);
        assert!(made == 5 && told.contains("film_again") && told.contains("missing"), "{told}");
        verify(&room, film, 0, "as it was written");
        let (told, made) = resumed(&room, film, &["--threads", "1", "--no-reuse"]);
        assert!(made == 0 && told.contains("film_kept"), "{film}: {told}");
        let ran = room.good(&["render", "a.rhai", "-o", film, "--resume"]);
        assert_eq!(ran.err, "5 frames were up to date and were kept\n");
        let ran = room.good(&["render", "a.rhai", "-o", film]);
        assert!(ran.err.contains("5 frames were made anew"), "{film}: {}", ran.err);

        // A comment makes nothing stale; a parameter, a size, other frames do.
        let script = std::fs::read_to_string(room.path("a.rhai")).unwrap();
        room.write("a.rhai", format!("// a comment\n{script}"));
        verify(&room, film, 0, "a comment");
        let whole = std::fs::read(room.path(film)).unwrap();
        for more in [&["--set", "gloss=0.5"][..], &["--size", "18x10"], &["--frames", "0-3"]] {
            let (told, made) = resumed(&room, film, more);
            assert!(made > 3 && told.contains("film_again"), "{film}, {more:?}: {told}");
            assert_eq!(resumed(&room, film, more).1, 0, "{film}, {more:?}");
        }
        verify(&room, film, 1, "other frames");
        resumed(&room, film, &[]);
        assert!(std::fs::read(room.path(film)).unwrap() == whole, "{film}");
        room.write("a.rhai", script.replace("fps: 10", "fps: 11"));
        verify(&room, film, 1, "another rate");
        room.write("a.rhai", script);
    }
    let beside: Vec<_> = room.made().into_iter().filter(|name| name.contains(".reflet")).collect();
    assert_eq!(beside, ["f.y4m.reflet"], "only formats without a place for text need it");
}

#[test]
fn one_flipped_bit_of_a_film_is_noticed() {
    let room = room();
    for film in films() {
        room.good(&["render", "a.rhai", "-o", film]);
        let good = std::fs::read(room.path(film)).unwrap();
        // All places are flipped in the tests of `film`.
        let tail = good.len().saturating_sub(400);
        let places = |at: &usize| at.is_multiple_of(if *at > tail { 23 } else { 211 });
        for at in (0..good.len()).filter(places) {
            let mut bad = good.clone();
            bad[at] ^= 1 << (at % 8);
            room.write(film, &bad);
            verify(&room, film, 1, &format!("byte {at} of {}", good.len()));
        }
        for cut in [0, 1, 20, good.len() / 2, good.len() - 1] {
            room.write(film, &good[..cut]);
            verify(&room, film, 1, &format!("{cut} bytes"));
        }
        room.write(film, [&good[..], b"\0"].concat());
        verify(&room, film, 1, "a byte too many");
        let (told, made) = resumed(&room, film, &[]);
        assert!(made == 5 && told.contains("film_again"), "{told}");
        assert!(std::fs::read(room.path(film)).unwrap() == good, "{film}");
    }
    // The manifest belongs to the film, too.
    let lines = std::fs::read(room.path("f.y4m.reflet")).unwrap();
    for at in (0..lines.len()).step_by(11) {
        let mut bad = lines.clone();
        bad[at] ^= 1 << (at % 8);
        room.write("f.y4m.reflet", &bad);
        verify(&room, "f.y4m", 1, &format!("byte {at} of the manifest"));
    }
}

#[test]
fn joined_frames_make_the_film_that_verify_knows() {
    let room = room();
    room.good(&["render", "a.rhai", "-o", "p/a-#.png"]);
    room.good(&["render", "a.rhai", "-o", "p/a-#.exr"]);
    for film in films() {
        room.good(&["film", "p/a-#.png", "-o", film, "--fps", "10"]);
        verify(&room, film, 0, "joined");
        let joined = std::fs::read(room.path(film)).unwrap();
        room.good(&["render", "a.rhai", "-o", film]);
        assert!(std::fs::read(room.path(film)).unwrap() == joined, "{film}");
        // Their transfer may be another than the scene's, so such a film says nothing.
        room.good(&["film", "p/a-#.exr", "-o", film, "--fps", "10"]);
        let ran = room.run(&["verify", "a.rhai", film]);
        assert!(ran.err.contains("does not say what it was made from"), "{film}: {}", ran.err);
    }
    assert!(room.made().iter().all(|name| !name.contains(".reflet")), "a film that is gone");
}

#[test]
fn other_programs_read_films_with_texts() {
    let room = room();
    if films().len() == OWN.len() {
        return;
    }
    // Of these, this ffmpeg reads no animated WebP.
    for film in films().into_iter().filter(|film| *film != "f.webp") {
        room.good(&["render", "a.rhai", "-o", film, "--size", "32x20"]);
        let mut probe = Command::new("ffprobe");
        probe.args(["-v", "warning", "-count_frames", "-of", "csv=p=0", "-show_entries"]);
        let told = probe.arg("stream=width,height,nb_read_frames").arg(room.path(film)).output();
        let told = told.unwrap();
        assert_eq!(String::from_utf8_lossy(&told.stdout).trim(), "32,20,5", "{film}");
        assert_eq!(String::from_utf8_lossy(&told.stderr), "", "{film}");
    }
}

#[cfg(not(feature = "av1"))]
#[test]
fn a_program_without_av1_says_how_to_get_it() {
    let room = room();
    for more in [&["render", "a.rhai", "-o", "f.ivf"][..], &["film", "no-#.png", "-o", "f.ivf"]] {
        room.bad(more, 2, &["f.ivf", "--features av1", ".webp"]);
    }
    assert_eq!(room.made(), [""; 0]);
}

#[test]
fn devices_and_the_standard_output_get_no_manifest() {
    let room = room();
    for format in ["qoi", "y4m", "gif"] {
        room.good(&["render", "a.rhai", "-o", "/dev/null", "--format", format]);
    }
    assert!(!std::path::Path::new("/dev/null.reflet").exists());
    let ran = room.good(&["render", "a.rhai", "-o", "-", "--format", "gif"]);
    assert!(ran.out.ends_with(&[0x3b]) && !ran.out.windows(6).any(|w| w == b"reflet"));
    assert_eq!(room.made(), [""; 0]);
}

/// All stills that a render writes are joined, the ones with floats through the scene's curve.
#[test]
fn every_kind_of_still_is_joined() {
    let room = room();
    for (curve, more) in [("srgb", ""), ("linear", "settings(#{ transfer: \"linear\" });\n")] {
        let script = format!("{more}{STILL}{FIVE}");
        room.write("b.rhai", script);
        room.good(&["render", "b.rhai", "-o", "whole.y4m"]);
        let whole = std::fs::read(room.path("whole.y4m")).unwrap();
        for (format, ending) in [
            ("png", "png"),
            ("png16", "png"),
            ("exr", "exr"),
            ("exr16", "exr"),
            ("qoi", "qoi"),
            ("jpg", "jpg"),
            ("ppm", "ppm"),
            ("pfm", "pfm"),
        ] {
            let frames = format!("{curve}-{format}/f-#.{ending}");
            room.good(&["render", "b.rhai", "-o", &frames, "--format", format]);
            room.good(&["film", &frames, "-o", "joined.y4m", "--fps", "10"]);
            let joined = std::fs::read(room.path("joined.y4m")).unwrap();
            assert_eq!(joined.len(), whole.len(), "{curve} {format}");
            // Rounded once from 16 bits, of which half floats hold 11, a sample differs by one at
            // most, and luma and chroma are sums of three; a JPEG differs more.
            let most = joined.iter().zip(&whole).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            let bound = match format {
                "png" | "exr" | "qoi" | "ppm" | "pfm" => 0,
                "jpg" => 60,
                _ => 2,
            };
            assert!(most <= bound, "{curve} {format}: {most}");
        }
    }
    room.bad(
        &["film", "srgb-png/f-0.png", "linear-png/f-1.png", "-o", "mixed.gif"],
        66,
        &["linear-png/f-1.png", "linear", "sRGB"],
    );
}

#[test]
fn choices_of_encoding_belong_to_their_formats() {
    let room = room();
    room.bad(&["render", "a.rhai", "-o", "f.webp", "--dither", "ordered"], 2, &["--dither", "gif"]);
    room.bad(&["render", "a.rhai", "-o", "f.gif", "--quality", "50"], 2, &["--quality", "mp4"]);
    let ran = room.run(&["render", "a.rhai", "-o", "f.mp4", "--quality", "101"]);
    assert!(ran.code == Some(2) && ran.err.contains("0 to 100"), "{}", ran.err);
    let ran = room.run(&["render", "a.rhai", "-o", "f.gif", "--dither", "noise"]);
    assert!(ran.code == Some(2) && ran.err.contains("ordered"), "{}", ran.err);
    assert_eq!(room.made(), [""; 0]);

    let dithered = ["render", "a.rhai", "-o", "f.gif", "--dither", "ordered", "--size", "64x36"];
    room.good(&dithered);
    let verify = ["verify", "a.rhai", "f.gif", "--size", "64x36"];
    room.good(&[&verify[..], &["--dither", "ordered"]].concat());
    assert_eq!(room.run(&verify).code, Some(1));

    room.good(&["render", "a.rhai", "-o", "f-#.png"]);
    room.good(&["film", "f-#.png", "-o", "f.y4m", "--fps", "24000/1001"]);
    let head = std::fs::read(room.path("f.y4m")).unwrap();
    assert!(head.starts_with(b"YUV4MPEG2 W16 H9 F24000:1001 "));
    room.bad(&["film", "f-#.png", "-o", "f.y4m", "--fps", "1/0"], 2, &["--fps", "24000/1001"]);
}

#[test]
fn a_gif_faster_than_viewers_is_warned_of() {
    let script = format!("{STILL}{}", FIVE.replace("frames: 5, fps: 10", "frames: 60, fps: 60"));
    let room = Room::with(&[("a.rhai", &script)]);
    let ran = room.good(&["render", "a.rhai", "-o", "f.gif"]);
    assert!(ran.err.contains("warning: a GIF at 60 frames a second"), "{}", ran.err);
    assert!(ran.err.contains("10 of 60 frames are left out"), "{}", ran.err);
    room.good(&["verify", "a.rhai", "f.gif"]);
    room.good(&["render", "a.rhai", "-o", "p-##.png"]);
    let ran = room.good(&["film", "p-##.png", "-o", "joined.gif", "--fps", "60"]);
    assert!(ran.err.contains("left out"), "{}", ran.err);
    let read = |name| std::fs::read(room.path(name)).unwrap();
    assert!(read("f.gif") == read("joined.gif"));
}

#[test]
fn ffmpeg_is_told_of_quality_and_colours() {
    let room = room();
    if films().len() == OWN.len() {
        return;
    }
    room.write("b.rhai", format!("settings(#{{ transfer: \"linear\" }});\n{STILL}{FIVE}"));
    for format in ["mp4", "mkv"] {
        let mut sizes = Vec::new();
        for quality in ["20", "68", "95"] {
            let name = format!("q{quality}.{format}");
            room.good(&["render", "a.rhai", "-o", &name, "--size", "160x90", "--quality", quality]);
            sizes.push(std::fs::metadata(room.path(&name)).unwrap().len());
        }
        assert!(sizes[0] < sizes[1] && sizes[1] < sizes[2], "{format}: {sizes:?}");
        let plain = format!("plain.{format}");
        room.good(&["render", "a.rhai", "-o", &plain, "--size", "160x90"]);
        let read = |name: &str| std::fs::read(room.path(name)).unwrap();
        assert!(read(&plain) == read(&format!("q68.{format}")));
        let verify = ["verify", "a.rhai", &format!("q20.{format}"), "--size", "160x90"];
        assert_eq!(room.run(&verify).code, Some(1));
        room.good(&[&verify[..], &["--quality", "20"]].concat());

        room.good(&["render", "b.rhai", "-o", &format!("linear.{format}")]);
        for (name, curve) in [("plain", "iec61966-2-1"), ("linear", "linear")] {
            let mut probe = Command::new("ffprobe");
            probe.args(["-v", "error", "-of", "csv=p=0", "-show_entries"]);
            probe.arg("stream=color_range,color_space,color_transfer,color_primaries");
            let told = probe.arg(room.path(&format!("{name}.{format}"))).output().unwrap();
            let told = String::from_utf8_lossy(&told.stdout).trim().to_owned();
            assert_eq!(told, format!("tv,bt709,{curve},bt709"), "{name}.{format}");
        }
    }
}
