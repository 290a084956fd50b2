//! The binary against the f64 recursion on random scenes: at one sample a pixel and at several,
//! at least 99.9 % of the stable pixels of every scene within 1e-3 of max(1, value), no pixel
//! non-finite. The tolerance is the one that the model promises; there is no other.

mod oracle;

use oracle::binary::{folder, render};
use oracle::compare::{Verdict, compare};
use oracle::families::{self, Family};
use oracle::script::script;
use oracle::view::picture;

/// Scenes of each family; ten families make 400.
const SCENES: u64 = 40;

/// Renders and compares one scene. A scene that fails leaves its script behind.
fn hold(family: Family, seed: u64) -> Result<Verdict, String> {
    let scene = (family.scene)(seed);
    let path = folder("random").join(format!("{}-{seed}.rhai", family.name));
    let threads = (1 + seed % 3).to_string();
    let text = script(&scene);
    let held = render(&path, &text, &["--threads", &threads])
        .and_then(|rendered| compare(&scene, &picture(&scene), &rendered.picture));
    match held {
        Ok(verdict) => {
            std::fs::remove_file(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(verdict)
        }
        Err(why) => Err(format!("{}, seed {seed}, script {}:\n{why}", family.name, path.display())),
    }
}

/// Holds all scenes of a family, and reports every one that fails.
fn hold_all(family: Family) {
    let mut sum = Verdict::default();
    let mut failed = Vec::new();
    for seed in 0..SCENES {
        match hold(family, seed) {
            Ok(verdict) => {
                sum.pixels += verdict.pixels;
                sum.stable += verdict.stable;
                sum.wrong += verdict.wrong;
            }
            Err(why) => failed.push(why),
        }
    }
    println!("{}: {sum:?}", family.name);
    assert!(failed.is_empty(), "{} of {SCENES}:\n{}", failed.len(), failed.join("\n"));
    // The mask leaves out edges, not the picture: it may never hide what it should show.
    assert!(sum.stable as f64 >= 0.99 * sum.pixels as f64, "the mask hides too much: {sum:?}");
}

macro_rules! families {
    ($($test:ident: $family:ident),+ $(,)?) => {
        $(
            #[test]
            fn $test() {
                hold_all(families::$family);
            }
        )+
    };
}

families! {
    few_spheres_over_a_floor: SPARSE,
    many_spheres_a_wall_and_flags: DENSE,
    closed_rooms_of_quads: ROOM,
    inside_of_mirrored_spheres: BALL,
    the_classic_view: WINDOW,
    spotlights_that_graze: GRAZING,
    patterns_with_odd_x_directions: PATTERNS,
    mirrors_that_face_each_other: FACING,
    backgrounds_cut_paths_and_dark_lights: SETTINGS,
    several_samples_a_pixel: SAMPLES,
}
