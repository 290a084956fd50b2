//! The binary against the f64 recursion on random scenes of the later words, each word alone and
//! all of them mixed, as `model_random.rs` holds it for the first ones.

mod oracle;

use oracle::binary::{folder, render};
use oracle::script::script;
use oracle::words;

oracle::hold::families! {
    discs_and_boxes: words::FLAT,
    quadrics_with_and_without_caps: words::QUADRICS,
    ellipsoids_and_tori: words::ROUND,
    inside_of_mirrored_shells: words::INSIDE,
    groups_and_instances: words::PLACED,
    solid_checkers_and_stripes: words::CELLS,
    cells_that_begin_in_turned_faces: words::BOXES,
    pictures_whole_and_in_tiles: words::PICTURES,
    shaders_on_any_shape: words::SHADERS,
    suns_projectors_and_falloffs: words::LAMPS,
    parallel_rays: words::ORTHO,
    meshes_of_each_format: words::MESHES,
    everything_mixed: words::MIXED,
}

/// The picture is the same, bit for bit, whatever the kernels and the number of threads.
#[test]
fn every_level_shows_the_same() {
    let folder = folder("levels");
    for seed in 100..112 {
        let scene = (words::MIXED.scene)(seed);
        for texture in &scene.textures {
            texture.write(&folder);
        }
        let path = folder.join(format!("mixed-{seed}.rhai"));
        let seen = |arguments: &[&str]| {
            let rendered = render(&path, &script(&scene), arguments);
            rendered.unwrap_or_else(|e| panic!("{e}")).picture.pixels
        };
        let plain = seen(&["--isa", "scalar", "--threads", "1"]);
        assert_eq!(plain, seen(&["--isa", "auto", "--threads", "3"]), "seed {seed}");
    }
}
