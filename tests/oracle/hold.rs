//! Families of random scenes held against the binary: at one sample a pixel and at several, at
//! least 99.9 % of the stable pixels of every scene within 1e-3 of max(1, value), no pixel
//! non-finite. The tolerance is the one that the model promises; there is no other.

use super::binary::{folder, render};
use super::compare::{Verdict, compare};
use super::families::Family;
use super::scene::Shape;
use super::script::script;
use super::view::picture;

/// Scenes of each family.
const SCENES: u64 = 40;

/// Renders and compares one scene. A scene that fails leaves its script behind.
fn hold(family: Family, seed: u64) -> Result<Verdict, String> {
    let scene = (family.scene)(seed);
    let folder = folder("random");
    let path = folder.join(format!("{}-{seed}.rhai", family.name));
    for texture in &scene.textures {
        texture.write(&folder);
    }
    let meshes: Vec<_> = scene
        .surfaces
        .iter()
        .filter_map(|s| match s.shape {
            Shape::Mesh { mesh } => Some(mesh),
            _ => None,
        })
        .collect();
    for mesh in &meshes {
        mesh.write(&folder);
    }
    let threads = (1 + seed % 3).to_string();
    let text = script(&scene);
    let held = render(&path, &text, &["--threads", &threads])
        .and_then(|rendered| compare(&scene, &picture(&scene), &rendered.picture));
    match held {
        Ok(verdict) => {
            for file in scene.textures.iter().map(|t| folder.join(&t.file)).chain([path]) {
                std::fs::remove_file(&file).map_err(|e| format!("{}: {e}", file.display()))?;
            }
            for file in meshes.iter().map(|mesh| folder.join(&mesh.file)) {
                std::fs::remove_file(&file).map_err(|e| format!("{}: {e}", file.display()))?;
            }
            Ok(verdict)
        }
        Err(why) => Err(format!("{}, seed {seed}, script {}:\n{why}", family.name, path.display())),
    }
}

/// Holds all scenes of a family, and reports every one that fails.
pub fn hold_all(family: Family) {
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

/// A test for each family.
#[allow(unused_macros)]
macro_rules! families {
    ($($test:ident: $family:expr),+ $(,)?) => {
        $(
            #[test]
            fn $test() {
                oracle::hold::hold_all($family);
            }
        )+
    };
}
#[allow(unused_imports)]
pub(crate) use families;
