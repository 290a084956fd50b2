//! Promises over whole runs of the binary: a frame is the same alone and in a run, re-used or not,
//! on any number of threads; and a long run does not grow.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const SCRIPT: &str = r#"
image(#{ width: 96, height: 54 });
settings(#{ max_bounces: 4, background: [0.1, 0.1, 0.2] });
camera(#{ eye: [0, 2, 7], look_at: [0, 1, 0] });
let lamp = light(#{ at: [3, 6, 4], emissivity: 30 });
let chrome = material(#{ ambient: 0.05, diffuse: 0.3, specular: 0.0 });
let dull = material(#{ diffuse: 0.8 });
let floor = checker(#{ even: chrome, odd: dull });
plane(#{ point: [0, 0, 0], normal: [0, 1, 0], material: floor });
let dice = random(7);
let balls = [];
for i in 0..6 {
    balls.push(sphere(#{ center: [i - 2.5, 0.6, 0], radius: 0.4, material: if i % 2 == 0 { chrome } else { dull } }));
}
let seen = [0];
animation(#{ frames: 12, fps: 12 });
on_frame(|f| {
    chrome.specular = 0.5 - 0.5 * cos(TAU * f.phase);
    balls[3].center.y = 0.6 + dice.float();
    seen[0] += 1;
    if f.index % 4 == 1 { lamp.at.x = 2.0 + seen[0]; }
    if f.index == 5 { balls[0].visible = false; sphere(#{ center: [0, 2, 0], radius: 0.3, material: chrome }); }
});
"#;

fn scene(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("scene.rhai");
    fs::write(&path, text).expect("a temporary folder takes a file");
    path
}

fn render(script: &Path, out: &Path, more: &[&str]) {
    let ran = Command::new(env!("CARGO_BIN_EXE_reflet"))
        .arg("render")
        .arg(script)
        .arg("-o")
        .arg(out.join("f-####.pfm"))
        .args(more)
        .output()
        .expect("the binary runs");
    assert!(ran.status.success(), "{more:?}: {}", String::from_utf8_lossy(&ran.stderr));
}

fn frame(out: &Path, index: usize) -> Vec<u8> {
    fs::read(out.join(format!("f-{index:04}.pfm"))).expect("the frame is there")
}

#[test]
fn a_frame_is_the_same_alone_and_in_a_run_on_any_threads_reused_or_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = scene(folder.path(), SCRIPT);
    let run = folder.path().join("run");
    render(&script, &run, &[]);
    for (name, more) in [
        ("none", &["--no-reuse"][..]),
        ("one", &["--threads", "1"]),
        ("two", &["--threads", "2"]),
        ("three", &["--threads", "3"]),
        ("sixteen", &["--threads", "16"]),
        ("scalar", &["--isa", "scalar"]),
        ("no-room", &["--cache-mem", "0"]),
        ("some-room", &["--cache-mem", "64K"]),
    ] {
        let out = folder.path().join(name);
        render(&script, &out, more);
        for i in 0..12 {
            assert_eq!(frame(&out, i), frame(&run, i), "frame {i} with {more:?}");
        }
    }
    for i in [0, 5, 7, 11] {
        let out = folder.path().join(format!("alone-{i}"));
        render(&script, &out, &["--frames", &i.to_string()]);
        assert_eq!(frame(&out, i), frame(&run, i), "frame {i} alone");
    }
    // Backwards: each frame builds on the one after it.
    let out = folder.path().join("backwards");
    render(&script, &out, &["--frames", "11,9,7,5,3,1"]);
    for i in [1, 3, 5, 7, 9, 11] {
        assert_eq!(frame(&out, i), frame(&run, i), "frame {i} of a list");
    }
    assert!((1..12).any(|i| frame(&run, i) != frame(&run, 0)), "the animation moves");
}

#[test]
fn a_specular_animation_casts_no_ray_after_its_first_frame() {
    let text = SCRIPT
        .replace("specular: 0.0", "specular: 0.3")
        .replace("0.5 - 0.5 * cos", "0.6 - 0.5 * cos");
    let from = text.find("    balls[3]").expect("the script has this line");
    let text = format!("{}}});", &text[..from]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = scene(folder.path(), &text);
    let ran = Command::new(env!("CARGO_BIN_EXE_reflet"))
        .args(["render", script.to_str().expect("a path"), "--json", "-o"])
        .arg(folder.path().join("f-####.png"))
        .output()
        .expect("the binary runs");
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let lines = String::from_utf8(ran.stdout).expect("text");
    let rays = |line: &str| -> u64 {
        let event: serde_json::Value = serde_json::from_str(line).expect("an event a line");
        let kinds =
            ["camera", "mirror", "shadow"].map(|k| event["rays"][k].as_u64().expect("a count"));
        assert_eq!(kinds.iter().sum::<u64>(), event["accel_rays"].as_u64().expect("a count"));
        kinds.iter().sum()
    };
    let frames: Vec<u64> =
        lines.lines().filter(|l| l.contains(r#""event":"frame""#)).map(rays).collect();
    assert_eq!(frames.len(), 12);
    assert!(frames[0] > 96 * 54, "the first frame is traced");
    assert!(frames[1..].iter().all(|n| *n == 0), "no other is: {frames:?}");
}

#[test]
#[cfg(target_os = "linux")]
fn ten_thousand_frames_run_flat() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = SCRIPT
        .replace("frames: 12", "frames: 10000")
        .replace("width: 96, height: 54", "width: 24, height: 14");
    let script = scene(folder.path(), &text);
    let mut child = Command::new(env!("CARGO_BIN_EXE_reflet"))
        .args(["render", script.to_str().expect("a path"), "--json", "-o"])
        .arg(folder.path().join("film.y4m"))
        .stdout(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let of = |name: &str| PathBuf::from(format!("/proc/{}/{name}", child.id()));
    let (status, descriptors) = (of("status"), of("fd"));
    let resident = || -> u64 {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap_or("0 kB");
        line.trim().trim_end_matches("kB").trim().parse().expect("a number of KiB")
    };
    let open = || fs::read_dir(&descriptors).map_or(0, Iterator::count);
    // Each frame opens a file for a moment, to read how much memory it holds: what stays open is
    // the least of a look a frame.
    let least = |frames: &mut (u64, usize)| {
        frames.0 = frames.0.min(resident());
        frames.1 = frames.1.min(open());
    };
    let mut early = (u64::MAX, usize::MAX);
    let mut late = (u64::MAX, usize::MAX);
    let out = child.stdout.take().expect("a pipe");
    let mut frames = 0;
    for line in BufReader::new(out).lines() {
        if line.expect("text").contains(r#""event":"frame""#) {
            frames += 1;
            // What is read may lie some hundred frames behind: both looks stay clear of the end.
            match frames {
                1000..1050 => least(&mut early),
                9500..9550 => least(&mut late),
                _ => {}
            }
        }
    }
    assert!(child.wait().expect("it ends").success());
    assert_eq!(frames, 10_000);
    assert!(early.0 > 0 && early.1 > 0 && late.0 > 0);
    // The allocator's own slack: 8,500 frames that each lost 1 KiB would be above it.
    assert!(late.0 <= early.0 + 8 * 1024, "{} KiB became {} KiB", early.0, late.0);
    assert!(late.1 <= early.1, "{} descriptors became {}", early.1, late.1);
}
