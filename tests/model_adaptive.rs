//! `adaptive: true` on the scenes in `scripts/`: next to the picture with all positions
//! everywhere, at no more than half of its rays.

mod oracle;

use oracle::binary::{Rendered, folder, render};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// The positions of a pixel that has edges.
const SAMPLES: &str = "16";
/// Two 8-bit values are alike within this.
const ALIKE: f64 = 4.0;
/// The share of the pixels that must be alike.
const SHARE: f64 = 0.995;

/// All stills and animations, and the folders that they read from.
fn gallery() -> (Vec<PathBuf>, PathBuf) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    let to = folder("adaptive");
    let mut scripts = Vec::new();
    let mut left = vec![(from, to.clone())];
    while let Some((from, to)) = left.pop() {
        fs::create_dir_all(&to).expect("a folder");
        for entry in fs::read_dir(&from).expect("a folder of scripts") {
            let path = entry.expect("an entry").path();
            let copy = to.join(path.file_name().expect("a name"));
            if path.is_dir() {
                left.push((path, copy));
            } else if path.extension() == Some(OsStr::new("rhai")) {
                scripts.push(path);
            } else {
                fs::copy(&path, &copy).expect("a copy of what a scene reads");
            }
        }
    }
    scripts.sort();
    (scripts, to)
}

/// A script with other samples in its `image`, or none if it has no such line.
fn sampled(text: &str, samples: &str) -> Option<String> {
    let start = text.find("\nimage(#{")?;
    let end = start + text[start..].find("});")?;
    let keys = text[start..end].trim_end();
    let keys = keys.split_once(", samples:").map_or(keys, |(size, _)| size);
    Some(format!("{}{keys}, samples: {samples} {}", &text[..start], &text[end..]))
}

fn middle_frame(text: &str) -> u32 {
    let Some((_, animation)) = text.split_once("\nanimation(#{ frames: ") else { return 0 };
    let digits = animation.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
    digits.parse::<u32>().expect("a number of frames") / 2
}

fn encoded(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    let curve = if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * curve).round()
}

fn rays(rendered: &Rendered) -> u64 {
    ["camera", "mirror", "shadow"].iter().map(|kind| rendered.rays(kind)).sum()
}

#[test]
fn edges_get_all_positions_and_the_rest_one() {
    let (scripts, folder) = gallery();
    let (mut all_rays, mut few_rays, mut wrong) = (0, 0, Vec::new());
    for script in &scripts {
        let text = fs::read_to_string(script).expect("a script");
        let name = script.file_stem().and_then(OsStr::to_str).expect("a plain name");
        let frame = middle_frame(&text).to_string();
        let Some(all) = sampled(&text, SAMPLES) else { continue };
        let few = sampled(&text, &format!("{SAMPLES}, adaptive: true")).expect("an image");
        let rendered = |kind: &str, text: &str| {
            let path = folder.join(format!("{name}-{kind}.rhai"));
            render(&path, text, &["--frames", &frame]).unwrap_or_else(|e| panic!("{e}"))
        };
        let (all, few) = (rendered("all", &all), rendered("few", &few));
        let alike = |i: usize| {
            let (a, b) = (all.picture.pixels[i], few.picture.pixels[i]);
            (a.map(encoded) - b.map(encoded)).largest() <= ALIKE
        };
        let count = all.picture.pixels.len();
        let share = (0..count).filter(|i| alike(*i)).count() as f64 / count as f64;
        let part = rays(&few) as f64 / rays(&all) as f64;
        println!("{name}: {:.2} % alike at {:.1} % of the rays", share * 100.0, part * 100.0);
        if share < SHARE {
            wrong.push(format!("{name}: only {:.2} % are alike", share * 100.0));
        }
        all_rays += rays(&all);
        few_rays += rays(&few);
    }
    assert!(scripts.len() >= 10 && all_rays > 0, "no scenes");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let part = few_rays as f64 / all_rays as f64;
    // At an edge the tree of the centre comes on top of all samples.
    let samples: f64 = SAMPLES.parse().expect("a number");
    assert!(part <= 0.5 + 1.0 / samples, "{:.1} % of the rays", part * 100.0);
}
