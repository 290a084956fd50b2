//! A full disk: never success, whatever the format and wherever it fills.
#![cfg(target_os = "linux")]

use crate::room::{FIVE, Ran, Room, STILL};
use std::path::Path;
use std::process::{Command, Stdio};

/// Formats, and whether a file holds one frame.
const FORMATS: [&str; 14] = [
    "png", "png16", "exr", "exr16", "qoi", "jpg", "ppm", "pfm", "gif", "apng", "webp", "y4m",
    "mp4", "mkv",
];

fn is_film(format: &str) -> bool {
    FORMATS[8..].contains(&format)
}

/// Whether a format needs another program, which is not there.
fn cannot(format: &str) -> bool {
    let needs = matches!(format, "mp4" | "mkv");
    let cannot = needs && Command::new("ffmpeg").arg("-version").output().is_err();
    let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
    assert!(!cannot || !required, "ffmpeg is not there");
    cannot
}

/// Five frames, each with another picture; a little noise, so that nothing compresses to nothing.
fn room() -> Room {
    let noise = "let dice = random(3);
for i in 0..40 {
    let at = [4 * dice.float() - 2, 2 * dice.float() - 1, dice.float()];
    sphere(#{ center: at, radius: 0.1, material: #{ diffuse: [dice.float(), dice.float(), 0.5] } });
}
";
    Room::with(&[("a.rhai", &format!("{STILL}{noise}{FIVE}"))])
}

fn words(format: &str, folder: &str, size: &str) -> Vec<String> {
    let out = if is_film(format) { "f" } else { "f-#" };
    let out = format!("{folder}/{out}.{format}");
    let words =
        ["render", "a.rhai", "-o", &out, "--format", format, "--size", size, "--threads", "2"];
    words.map(str::to_owned).to_vec()
}

/// Holds that a run that was not given enough room has failed as it should, and that what stands is
/// a beginning of what `whole` holds.
fn failed(room: &Room, ran: &Ran, folder: &str, whole: &str, what: &str) {
    assert_eq!(ran.code, Some(74), "{what}: {}", ran.err);
    assert!(ran.err.starts_with("error: frame "), "{what}: {}", ran.err);
    assert!(
        ran.err.contains(&format!("{folder}/f")) && !ran.err.contains("panicked"),
        "{}",
        ran.err
    );
    let names = if room.path(folder).exists() { room.names_in(folder) } else { Vec::new() };
    for name in names {
        assert!(!name.starts_with('.'), "{what}: {name} stays");
        let read = |folder: &str| std::fs::read(room.path(&format!("{folder}/{name}"))).unwrap();
        assert!(read(folder) == read(whole), "{what}: {name} differs");
    }
}

/// Files may not grow beyond a limit, as on a disk that is full from there on: at the first byte,
/// within the head, in the middle, at the last byte of the largest file.
#[test]
fn no_format_succeeds_where_its_files_do_not_fit() {
    let room = room();
    if Command::new("prlimit").arg("--version").output().is_err() {
        let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
        assert!(!required, "prlimit is not there");
        println!("skipped: prlimit is not there");
        return;
    }
    for format in FORMATS {
        if cannot(format) {
            println!("skipped: ffmpeg is not there");
            continue;
        }
        for size in ["16x9", "160x90"] {
            let whole = format!("whole-{format}-{size}");
            let all = words(format, &whole, size);
            room.good(&all.iter().map(String::as_str).collect::<Vec<_>>());
            let lengths = room.names_in(&whole).into_iter().map(|name| {
                std::fs::metadata(room.path(&format!("{whole}/{name}"))).unwrap().len()
            });
            let largest = lengths.max().unwrap();
            let folder = format!("o-{format}-{size}");
            let limited = |limit: u64| -> Ran {
                let mut command = Command::new("prlimit");
                command.arg(format!("--fsize={limit}")).arg(env!("CARGO_BIN_EXE_reflet"));
                command.args(words(format, &folder, size)).current_dir(room.path("."));
                command.stdin(Stdio::null()).output().unwrap().into()
            };
            for limit in
                [0, 1, 50, largest / 3, largest / 2, largest.saturating_sub(300), largest - 1]
            {
                let what = format!("{format} {size}, {limit} of {largest} bytes");
                failed(&room, &limited(limit.min(largest - 1)), &folder, &whole, &what);
                let _ = std::fs::remove_dir_all(room.path(&folder));
            }
            let ran = limited(largest.max(1 << 20));
            assert_eq!(ran.code, Some(0), "{format} {size}: {}", ran.err);
            assert_eq!(room.names_in(&folder), room.names_in(&whole), "{format} {size}");
        }
    }
}

#[test]
fn a_full_device_is_an_output_error() {
    let room = Room::furnished();
    for format in [
        "png", "png16", "exr", "exr16", "qoi", "jpg", "ppm", "pfm", "gif", "apng", "webp", "y4m",
        "mp4",
    ] {
        let args = ["render", "still.rhai", "-o", "/dev/full", "--format", format];
        room.bad(&args, 74, &["/dev/full"]);
    }
    room.good(&["render", "still.rhai", "-o", "/dev/null", "--format", "png"]);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let ran: Ran =
        room.command(&["render", "still.rhai", "-o", "-"]).stdout(full).output().unwrap().into();
    assert_eq!(ran.code, Some(74), "{}", ran.err);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let args = ["render", "still.rhai", "-o", "a.png", "--json"];
    let ran: Ran = room.command(&args).stdout(full).output().unwrap().into();
    assert_eq!(ran.code, Some(74), "{}", ran.err);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let ran: Ran = room.command(&["check", "still.rhai"]).stdout(full).output().unwrap().into();
    assert_eq!(ran.code, Some(74), "{}", ran.err);
}

/// A file system that takes no more bytes, or none at all, where this process may mount one.
#[test]
fn a_full_and_a_read_only_file_system() {
    struct Mounted(std::path::PathBuf);
    impl Drop for Mounted {
        fn drop(&mut self) {
            let _ = Command::new("umount").arg(&self.0).status();
        }
    }
    let mount = |place: &Path, options: &str| -> Option<Mounted> {
        std::fs::create_dir(place).unwrap();
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(place).stderr(Stdio::null());
        mount.status().is_ok_and(|s| s.success()).then(|| Mounted(place.to_path_buf()))
    };
    let room = room();
    room.write("still.rhai", STILL);
    // Of real full disks programs learn at other moments than of limits: ffmpeg's exit code, for
    // one, does not tell of all of them.
    for kib in [4, 8, 16] {
        let Some(_full) = mount(&room.path("full"), &format!("size={kib}k")) else {
            println!("skipped: this process may not mount a tmpfs");
            return;
        };
        for format in FORMATS.into_iter().filter(|format| !cannot(format)) {
            let what = format!("{format}, {kib} KiB");
            let all = words(format, "full", "200x200");
            let ran = room.run(&all.iter().map(String::as_str).collect::<Vec<_>>());
            let whole = format!("whole-{format}");
            let all = words(format, &whole, "200x200");
            room.good(&all.iter().map(String::as_str).collect::<Vec<_>>());
            if ran.code == Some(0) {
                assert_eq!(room.names_in("full"), room.names_in(&whole), "{what}");
                for name in room.names_in("full") {
                    let read = |f: &str| std::fs::read(room.path(&format!("{f}/{name}"))).unwrap();
                    assert!(read("full") == read(&whole), "{what}: {name} is not whole");
                }
            } else {
                failed(&room, &ran, "full", &whole, &what);
            }
            for name in room.names_in("full") {
                std::fs::remove_file(room.path(&format!("full/{name}"))).unwrap();
            }
        }
        drop(_full);
        std::fs::remove_dir(room.path("full")).unwrap();
    }
    let _locked = mount(&room.path("locked"), "ro").expect("a second tmpfs after the first");
    room.bad(&["render", "still.rhai", "-o", "locked/a.png"], 74, &["locked/a.png"]);
    room.bad(&["new", "locked/scene"], 74, &["locked/scene.rhai"]);
}
