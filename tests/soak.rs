//! Long runs: processes killed at random moments, faults at every write, and very many frames.
//!
//! The short form runs with the other tests. The long one is asked for by numbers:
//!
//! ```text
//! REFLET_SOAK_KILLS=1000 REFLET_SOAK_FRAMES=10000 REFLET_SOAK_FAULTS=1000 \
//!     cargo test --release --test soak -- --nocapture
//! ```
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const FRAMES: usize = 12;

fn script(frames: usize) -> String {
    format!(
        "image(#{{ width: 96, height: 54 }});
camera(#{{ eye: [0, 1, 5], look_at: [0, 0, 0] }});
light(#{{ at: [3, 4, 5], emissivity: 40 }});
let paint = material(#{{ diffuse: [0.8, 0.4, 0.2], specular: 0.3 }});
sphere(#{{ center: [0, 0, 0], radius: 1, material: paint }});
let ball = sphere(#{{ center: [2, 0, 0], radius: 0.5 }});
plane(#{{ point: [0, -1, 0], normal: [0, 1, 0], material: paint }});
animation(#{{ frames: {frames}, fps: 10 }});
on_frame(|f| {{ paint.diffuse = [f.phase, 0.4, 0.2]; if f.index % 3 == 0 {{ ball.center.x = 2 + f.t; }} }});
"
    )
}

/// How much is asked for.
fn asked(name: &str, short: usize) -> usize {
    std::env::var(name).map_or(short, |text| text.parse().expect("a number"))
}

fn folder(frames: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.rhai"), script(frames)).expect("a script");
    folder
}

fn reflet(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_reflet"));
    command.args(words).current_dir(folder).stdin(Stdio::null());
    command
}

fn good(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// All files of a folder, hidden ones too.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = std::fs::read_dir(folder) else { return BTreeMap::new() };
    let entries = entries.map(|entry| entry.expect("an entry"));
    let file = |e: std::fs::DirEntry| {
        (e.file_name().into_string().expect("UTF-8"), std::fs::read(e.path()).expect("a file"))
    };
    entries.map(file).collect()
}

fn decodes(name: &str, bytes: &[u8]) {
    let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    let mut reader = decoder.read_info().unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).unwrap_or_else(|e| panic!("{name}: {e}"));
}

/// The same numbers in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

#[test]
fn killed_at_random_moments_and_resumed() {
    let rounds = asked("REFLET_SOAK_KILLS", 25);
    let folder = folder(FRAMES);
    let at = folder.path();
    let begin = Instant::now();
    good(&reflet(at, &["render", "a.rhai", "-o", "whole/f-##.png"]).output().expect("the binary"));
    let whole_run = begin.elapsed();
    let whole = files(&at.join("whole"));
    assert_eq!(whole.len(), FRAMES);
    let mut dice = Dice(7);
    let (mut cut, mut found) = (0, 0);
    for round in 0..rounds {
        let mut child = reflet(at, &["render", "a.rhai", "-o", "o/f-##.png", "--resume", "--json"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the binary");
        let wait = dice.below(whole_run.as_micros() as u64 * 5 / 4);
        std::thread::sleep(Duration::from_micros(wait));
        let _ = child.kill(); // SIGKILL
        let ended_by_itself = child.wait().expect("a status").success();
        cut += usize::from(!ended_by_itself);
        let left = files(&at.join("o"));
        let finished: Vec<_> = left.keys().filter(|name| !name.starts_with('.')).cloned().collect();
        for name in &finished {
            decodes(name, &left[name]);
            assert!(left[name] == whole[name], "round {round}: {name} differs");
        }
        found += finished.len();
        // Sometimes the rest at once, sometimes on with what is there.
        if dice.below(3) == 0 || ended_by_itself {
            let words = ["render", "a.rhai", "-o", "o/f-##.png", "--resume", "--json"];
            let ran = reflet(at, &words).output().expect("the binary");
            good(&ran);
            let told = String::from_utf8_lossy(&ran.stdout).into_owned();
            let made = told.lines().filter(|l| l.contains(r#""event":"frame""#)).count();
            assert_eq!(made, FRAMES - finished.len(), "round {round}: what stood is made again");
            assert!(files(&at.join("o")) == whole, "round {round}: another result, or other files");
            std::fs::remove_dir_all(at.join("o")).expect("removed");
        }
    }
    println!("{rounds} rounds: {cut} killed in the middle, {found} frames found whole");
}

#[test]
fn a_fault_at_every_write_sync_and_rename() {
    let most = asked("REFLET_SOAK_FAULTS", 4);
    let folder = folder(3);
    let at = folder.path();
    let strace = |words: &[&str]| Command::new("strace").args(words).output();
    if !strace(&["-qq", "-o", "/dev/null", "true"]).is_ok_and(|ran| ran.status.success()) {
        let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
        assert!(!required, "strace is not there or may not trace");
        println!("skipped: strace is not there or may not trace");
        return;
    }
    let (mut faults, mut failed) = (0, 0);
    for out in ["f-#.png", "f-#.exr", "f-#.qoi", "f.y4m", "f.gif", "f.webp"] {
        let render = |out: &str| ["render", "a.rhai", "-o", out].map(str::to_owned);
        let whole_out = format!("whole-{}/{out}", out.replace('#', ""));
        let words = render(&whole_out);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        good(&reflet(at, &words).output().expect("the binary"));
        let whole = files(at.join(&whole_out).parent().expect("a folder"));
        for (call, error) in [
            ("writev", "ENOSPC"),
            ("write", "ENOSPC"),
            ("write", "EIO"),
            ("fsync", "EIO"),
            ("rename", "EIO"),
            ("openat", "EMFILE"),
        ] {
            for n in 1..=most {
                let inject = format!("inject={call}:error={error}:when={n}");
                let target = format!("o/{out}");
                let ran = Command::new("strace")
                    .args(["-f", "-qq", "-o", "/dev/null", "-e", &inject])
                    .arg(env!("CARGO_BIN_EXE_reflet"))
                    .args(render(&target))
                    .current_dir(at)
                    .stdin(Stdio::null())
                    .output()
                    .expect("strace");
                let told = String::from_utf8_lossy(&ran.stderr).into_owned();
                let what = format!("{out}, {inject}: {:?} {told}", ran.status.code());
                assert!(!told.contains("panicked"), "{what}");
                let left = files(&at.join("o"));
                for (name, bytes) in &left {
                    assert!(!name.starts_with('.'), "{name} stays; {what}");
                    assert!(whole.get(name) == Some(bytes), "{name} differs; {what}");
                }
                if ran.status.success() {
                    assert!(left == whole, "success with {} files; {what}", left.len());
                } else {
                    failed += 1;
                    // Opening libraries and inputs can fail, too.
                    if call != "openat" {
                        assert_eq!(ran.status.code(), Some(74), "{what}");
                        // The message itself may have been hit.
                        let lost = call == "write" && told.is_empty();
                        assert!(lost || told.contains("frame "), "{what}");
                    }
                }
                faults += 1;
                let _ = std::fs::remove_dir_all(at.join("o"));
                // Beyond the last call of its kind nothing fails any more.
                if ran.status.success() && n > 12 {
                    break;
                }
            }
        }
    }
    println!("{faults} faults, {failed} of them ended the run");
}

#[test]
fn memory_and_descriptors_stay_flat() {
    let frames = asked("REFLET_SOAK_FRAMES", 300);
    let folder = folder(frames);
    for out in ["o/f-#####.png", "f.gif", "f.apng", "f.webp"] {
        let mut child = reflet(folder.path(), &["render", "a.rhai", "-o", out, "--json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the binary");
        let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        let mut measure = |until: usize| {
            let frames = lines.by_ref().map_while(Result::ok);
            let frames = frames.filter(|line| line.contains(r#""event":"frame""#));
            assert_eq!(frames.take(until).count(), until);
            let process = format!("/proc/{}", child.id());
            let status = std::fs::read_to_string(format!("{process}/status")).unwrap_or_default();
            let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
            let resident = resident.and_then(|text| text.trim().strip_suffix(" kB"));
            let kib: usize = resident.map_or(0, |text| text.trim().parse().expect("a number"));
            let open = std::fs::read_dir(format!("{process}/fd")).map_or(0, Iterator::count);
            (kib, open)
        };
        let early = measure(frames / 4);
        let late = measure(frames / 2);
        println!("{out}: {early:?} KiB and descriptors, then {late:?}");
        assert!(late.1 <= early.1 + 3, "descriptors: {early:?}, then {late:?}");
        assert!(late.0 <= early.0 + (8 << 10), "memory: {early:?}, then {late:?}");
        assert_eq!(lines.map_while(Result::ok).filter(|l| l.contains("done")).count(), 1);
        assert!(child.wait().expect("a status").success());
    }
}
