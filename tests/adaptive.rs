//! `adaptive: true`: the scenes of the gallery with nine samples at edges only, against nine
//! everywhere.

use std::path::{Path, PathBuf};
use std::process::Command;

/// An 8-bit picture's samples, and the camera rays that it took.
struct Rendered {
    samples: Vec<u8>,
    rays: u64,
}

fn render(script: &Path, out: &Path) -> Rendered {
    let run = Command::new(env!("CARGO_BIN_EXE_reflet"))
        .args(["render", "--json", "--frames", "0", "--size", "320x180", "-o"])
        .arg(out)
        .arg(script)
        .output()
        .expect("the binary starts");
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{}: {said}", script.display());
    let events = String::from_utf8_lossy(&run.stdout).into_owned();
    let frame = events.lines().find(|line| line.contains("\"event\":\"frame\"")).expect("a frame");
    let number = |kind: &str| -> u64 {
        let rest = &frame[frame.find(kind).expect("a count") + kind.len()..];
        let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        rest[..end].parse().expect("a number")
    };
    let rays = number("\"camera\":") + number("\"mirror\":") + number("\"shadow\":");
    let bytes = std::fs::read(out).expect("a picture");
    // A PPM: three lines of header, then the samples.
    let lines = bytes.iter().enumerate().filter(|(_, b)| **b == b'\n');
    let header = lines.map(|(i, _)| i).nth(2).expect("three lines");
    Rendered { samples: bytes[header + 1..].to_vec(), rays }
}

/// The scenes that have no texture or shader: there every pixel that sees one is an edge.
fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the gallery")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "rhai"))
        .collect();
    scenes.sort();
    scenes
}

#[test]
fn adaptive_pictures_are_those_of_all_samples_for_half_the_rays() {
    let room = Path::new(env!("CARGO_TARGET_TMPDIR")).join("adaptive");
    std::fs::create_dir_all(&room).expect("a folder");
    let mut rays = [0, 0];
    for scene in scenes() {
        let text = std::fs::read_to_string(&scene).expect("a script");
        let Some(at) = text.find("image(#{") else { continue };
        let end = at + text[at..].find('}').expect("the map's end");
        let (map, plain) =
            (&text[at..end], !text.contains("textured(") && !text.contains("shader("));
        if map.contains("adaptive") || text.contains("file:") || text.contains(".samples") || !plain
        {
            continue;
        }
        let size: Vec<&str> =
            map["image(#{".len()..].split(',').filter(|key| !key.contains("samples")).collect();
        let name = scene.file_stem().expect("a name").to_string_lossy().into_owned();
        let made =
            [("all", "samples: 9"), ("edges", "samples: 9, adaptive: true")].map(|(how, keys)| {
                let rest: Vec<&str> =
                    size.iter().copied().filter(|k| !k.trim().is_empty()).collect();
                let image = format!("image(#{{ {}, {keys} ", rest.join(","));
                let script = room.join(format!("{name}-{how}.rhai"));
                std::fs::write(&script, format!("{}{image}{}", &text[..at], &text[end..]))
                    .expect("a file");
                render(&script, &script.with_extension("ppm"))
            });
        let [all, edges] = &made;
        let far = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 4);
        let wrong = all.samples.chunks(3).zip(edges.samples.chunks(3)).filter(|p| far(*p)).count();
        let pixels = all.samples.len() / 3;
        println!("{name}: {wrong} of {pixels} differ, {} of {} rays", edges.rays, all.rays);
        assert!(wrong * 200 <= pixels, "{name}: {wrong} of {pixels} pixels differ");
        rays[0] += all.rays;
        rays[1] += edges.rays;
    }
    assert!(rays[0] > 0 && 2 * rays[1] <= rays[0], "{} of {} rays", rays[1], rays[0]);
}
