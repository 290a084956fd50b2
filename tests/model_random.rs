//! The binary against the f64 recursion on random scenes of spheres and flat surfaces, 400 of them.

mod oracle;

use oracle::families;

oracle::hold::families! {
    few_spheres_over_a_floor: families::SPARSE,
    many_spheres_a_wall_and_flags: families::DENSE,
    closed_rooms_of_quads: families::ROOM,
    inside_of_mirrored_spheres: families::BALL,
    the_classic_view: families::WINDOW,
    spotlights_that_graze: families::GRAZING,
    patterns_with_odd_x_directions: families::PATTERNS,
    mirrors_that_face_each_other: families::FACING,
    backgrounds_cut_paths_and_dark_lights: families::SETTINGS,
    several_samples_a_pixel: families::SAMPLES,
}
