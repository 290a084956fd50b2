//! What re-use saves, and what peers take for the same frames: a table of ratios.
//!
//! Each scene is rendered with and without re-use by the binary itself, in turn, and of each
//! figure the median is taken. Tachyon and POV-Ray join in where they are installed.

mod peers;

use peers::{Figures, Peer, median};
use std::path::Path;
use std::process::Command;

/// How often each side runs.
const ROUNDS: usize = 5;

/// A scene of `balls` mirrors over a plane, of which one frame function changes something.
fn dense(balls: u32, radius: f64, size: [u32; 2], frame: &str) -> String {
    let [width, height] = size;
    format!(
        "image(#{{ width: {width}, height: {height} }});
         animation(#{{ frames: 12, fps: 24 }});
         camera(#{{ eye: [0, 2.5, -9], look_at: [0, 0.8, 0], fov: 40 }});
         settings(#{{ max_bounces: 8, attenuation: \"none\" }});
         let sun = light(#{{ at: [6, 9, -6], emissivity: 8.4 }});
         light(#{{ at: [-7, 6, -4], emissivity: 6 }});
         let ground = material(#{{ diffuse: [0.7, 0.7, 0.8], specular: 0.3 }});
         plane(#{{ point: [0, -1, 0], normal: [0, 1, 0], material: ground }});
         let dice = random(7);
         let skins = []; let balls = [];
         for i in 0..{balls} {{
             let skin = material(#{{ diffuse: [0.5 * dice.float(), 0.3, 0.4], specular: 0.6 }});
             let at = [8 * dice.float() - 4, 4 * dice.float() - 0.6, 6 * dice.float() - 2];
             let radius = {radius:?} * (0.6 + 0.8 * dice.float());
             skins.push(skin);
             balls.push(sphere(#{{ center: at, radius: radius, material: skin }}));
         }}
         skins[3].specular = 0.0;
         on_frame(|f| {{ {frame} }});"
    )
}

/// The median over the frames after the first of the time of tracing and shading, and what else the
/// events tell of them.
struct Told {
    first_ms: f64,
    later_ms: f64,
    rays: u64,
    retraced: u64,
    shaded: f64,
    bands: f64,
}

fn told(events: &str) -> Told {
    let frames: Vec<serde_json::Value> = events
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .filter(|event: &serde_json::Value| event["event"] == "frame")
        .collect();
    let later = &frames[1..];
    let number = |event: &serde_json::Value, name: &str| event[name].as_f64().unwrap_or(0.0);
    let of = |name: &str| median(later.iter().map(|e| number(e, name)).collect());
    let rays = later.iter().flat_map(|e| e["rays"].as_object().into_iter().flatten());
    let bands = of("bands_encoded") + of("bands_kept");
    Told {
        first_ms: number(&frames[0], "trace_ms"),
        later_ms: of("trace_ms"),
        rays: rays.filter_map(|(_, n)| n.as_u64()).sum::<u64>() / later.len() as u64,
        retraced: of("retraced_pixels") as u64,
        shaded: of("shaded_tiles") / number(&frames[0], "tiles"),
        bands: of("bands_encoded") / bands.max(1.0),
    }
}

/// A side's name, the frames that it renders, and how.
type Run = (String, u32, Box<dyn Fn() -> Command>);

fn reflet(script: &Path, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_reflet"));
    command.arg("render").arg(script).arg("-o").arg(out.join("f-##.png")).arg("--json").args(more);
    command
}

fn main() {
    // `cargo bench` passes options of Criterion to all benches.
    let folder = tempfile::tempdir().expect("a folder for pictures");
    let wide = [1280, 720];
    println!(
        "one thread, 1280x720; ms of tracing and shading, median of the frames after the first"
    );
    println!(
        "{:<44} {:>8} {:>8} {:>7} {:>10} {:>9} {:>7} {:>6}",
        "scene and what changes",
        "fresh",
        "re-used",
        "ratio",
        "rays",
        "retraced",
        "shaded",
        "bands"
    );
    for (name, balls, radius, frame) in [
        (
            "30 balls, every specular",
            30,
            0.7,
            "for s in skins { s.specular = 0.3 + 0.02 * f.index; }",
        ),
        ("10 balls, one material", 10, 0.7, "skins[4].specular = 0.2 + 0.02 * f.index;"),
        ("30 balls, one wakes at frame 6", 30, 0.7, "if f.index >= 6 { skins[3].specular = 0.5; }"),
        ("30 balls, one moves", 30, 0.7, "balls[3].center += vec3(0.02 * f.index, 0, 0);"),
        (
            "1000 small balls, one moves",
            1000,
            0.12,
            "balls[3].center += vec3(0.02 * f.index, 0, 0);",
        ),
        ("30 balls, a light circles", 30, 0.7, "sun.at = rotate(sun.at, [0, 1, 0], 3 * f.index);"),
    ] {
        let script = folder.path().join("scene.rhai");
        std::fs::write(&script, dense(balls, radius, wide, frame)).expect("a script");
        let mut sides = [Vec::new(), Vec::new()];
        for _ in 0..ROUNDS {
            for (side, more) in
                [(0, &["--threads", "1", "--no-reuse"][..]), (1, &["--threads", "1"])]
            {
                let frames = if side == 0 { "0-2" } else { "0-11" };
                let mut command = reflet(&script, folder.path(), more);
                let ran = command.args(["--frames", frames]).output().expect("the binary runs");
                assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
                sides[side].push(told(&String::from_utf8_lossy(&ran.stdout)));
            }
        }
        let fresh = median(sides[0].iter().map(|t| t.first_ms).collect());
        let kept = median(sides[1].iter().map(|t| t.later_ms).collect());
        let t = &sides[1][0];
        println!(
            "{name:<44} {fresh:>8.1} {kept:>8.2} {:>7.4} {:>10} {:>9} {:>6.0}% {:>5.0}%",
            kept / fresh,
            t.rays,
            t.retraced,
            100.0 * t.shaded,
            100.0 * t.bands,
        );
    }

    println!(
        "\nmirrors-10, 640x360, two threads, whole processes with PNGs on disk, seconds a frame"
    );
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/mirrors-10.rhai");
    let mut runs: Vec<Run> = Vec::new();
    for (name, frames, more) in [
        ("reflet, 48 frames", 48, &["--threads", "2"][..]),
        ("reflet --no-reuse, 12 frames", 12, &["--threads", "2", "--no-reuse", "--frames", "0-11"]),
        ("reflet, one still", 1, &["--threads", "2", "--frames", "0"]),
    ] {
        let (script, out) = (script.clone(), folder.path().to_owned());
        runs.push((name.into(), frames, Box::new(move || reflet(&script, &out, more))));
    }
    for peer in Peer::ALL {
        match peer.command(folder.path()) {
            Some(command) => runs.push((peer.name().into(), 1, command)),
            None => println!("({} is not installed)", peer.name()),
        }
    }
    let mut figures: Vec<Vec<Figures>> = vec![Vec::new(); runs.len()];
    for _ in 0..ROUNDS {
        for ((_, frames, command), figures) in runs.iter().zip(&mut figures) {
            figures.push(Figures::of(&mut command()).per_frame(*frames));
        }
    }
    let medians: Vec<Figures> = figures.iter().map(|f| Figures::median(f)).collect();
    for ((name, ..), f) in runs.iter().zip(&medians) {
        let (wall, cpu) = (f.wall / medians[0].wall, f.cpu / medians[0].cpu);
        println!("{name:<32} wall {:.4} ({wall:5.1}x)   cpu {:.4} ({cpu:5.1}x)", f.wall, f.cpu);
    }
}
