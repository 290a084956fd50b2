//! The model through the binary, against numbers that a person can work out on paper.
//!
//! Most scenes are one pixel that looks straight ahead, with lengths that are small whole numbers:
//! then every step is exact in f32 and the test asks for equality. Where a step rounds, the
//! tolerance is the number of roundings times [`ROUNDING`].

mod oracle;

use oracle::binary::{Rendered, rendered};
use oracle::compare::RIGHT_WITHIN;
use oracle::hand::{ROUNDING, ahead, classic, grey, within};
use oracle::vec3::{Vec3, v3};
use oracle::view::relative_error;
use std::fmt::Write as _;

/// Two mirrors that face each other in z = 0 and z = 3.
fn two_mirrors(material: &str) -> String {
    format!(
        "let m = material(#{{ {material} }});
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: m }});
plane(#{{ point: [0, 0, 3], normal: [0, 0, -1], material: m }});"
    )
}

#[test]
fn forty_bounces_add_up_their_paths() {
    // Hits at path lengths 1, 4, 7, ..., 121, each worth 0.9^k / (1 + 3 k).
    let sum = |n: i32| (0..=n).map(|k| 0.9f64.powi(k) / f64::from(1 + 3 * k)).sum::<f64>();
    let mirrors = two_mirrors("ambient: 1, specular: 0.9");
    for n in [39, 40] {
        let got = ahead(&format!("forty-{n}"), &format!("max_bounces: {n}"), &mirrors);
        // The lengths are exact. A hit rounds at 1 / length, at its product with the ambient
        // value and at the sum, and each of up to 40 mirrors above it at its specular value, the
        // product and the sum: at most 3 + 40 * 3 roundings.
        within(got, grey(sum(n)), 123.0);
    }
    // The last bounce is larger than the tolerance: one too many or too few is seen.
    assert!((sum(40) - sum(39)) / sum(40) > 4.0 * 123.0 * ROUNDING);
}

#[test]
fn bounces_without_attenuation_are_a_geometric_series() {
    // 1 + 1/2 + ... + 2^-n = 2 - 2^-n, exact in f32 up to n = 23.
    let mirrors = two_mirrors("ambient: 1, specular: 0.5");
    for n in [0, 1, 2, 5, 16, 22] {
        let settings = format!("attenuation: \"none\", max_bounces: {n}");
        let got = ahead(&format!("series-{n}"), &settings, &mirrors);
        assert_eq!(got, grey(2.0 - 0.5f64.powi(n)), "max_bounces: {n}");
    }
    // 16 is the default.
    let got = ahead("series-default", "attenuation: \"none\"", &mirrors);
    assert_eq!(got, grey(2.0 - 0.5f64.powi(16)));
}

#[test]
fn total_dist_is_the_whole_path() {
    // 1 to the mirror and 3 to the wall: 8 / (1 + 3), not 8 / 3.
    let things = "plane(#{ point: [0, 0, 0], normal: [0, 0, 1],
    material: material(#{ specular: 1 }) });
plane(#{ point: [0, 0, 3], normal: [0, 0, -1], material: material(#{ ambient: 8 }) });";
    assert_eq!(ahead("whole-path", "max_bounces: 1", things), grey(2.0));
}

#[test]
fn total_dist_adds_up_around_corners() {
    // 4 to a mirror at 45 degrees, 8 along x to the next, 4 up to the ceiling: 32 / 16.
    let script = "image(#{ width: 1, height: 1 });
camera(#{ eye: [0, 0, 4], look_at: [0, 0, 0] });
let mirror = material(#{ specular: 1 });
quad(#{ corner: [-1, -1, 1], u: [2, 0, -2], v: [0, 2, 0], material: mirror });
triangle(#{ a: [7, -1, -9], b: [9, 1, -9], c: [8, 0, 9], material: mirror });
plane(#{ point: [0, 4, 0], normal: [0, 1, 0], material: material(#{ ambient: 32 }) });";
    // The two unit normals at 45 degrees round, and with them both directions and all that
    // follows: about 10 operations each way, 3 for the intensity.
    within(rendered("corners", script).picture.at(0, 0), grey(2.0), 32.0);
}

#[test]
fn attenuation_divides_by_the_path_or_not_at_all() {
    let wall = "plane(#{ point: [0, 0, -7], normal: [0, 0, 1],
    material: material(#{ ambient: [3, 1, -2] }) });";
    assert_eq!(ahead("inverse", "attenuation: \"inverse\"", wall), v3(0.375, 0.125, -0.25));
    assert_eq!(ahead("none", "attenuation: \"none\"", wall), v3(3.0, 1.0, -2.0));
}

#[test]
fn a_light_gives_diffuse_times_emissivity_times_cos_over_r() {
    // The light is 4 in front of the wall and 3 aside: r = 5, cos = 4 / 5; the path is 1.
    let things = "light(#{ at: [3, 0, 4], emissivity: [100, 50, 25] });
plane(#{ point: [0, 0, 0], normal: [0, 0, 1],
    material: material(#{ ambient: [0, 0, 1], diffuse: [1, 0.5, 0] }) });";
    // Roundings: cos, cos / r, two products and a sum, and those of r itself: below 8.
    within(ahead("light", "", things), v3(16.0, 4.0, 1.0), 8.0);
}

#[test]
fn a_path_longer_than_max_path_ends_in_zero_not_in_the_background() {
    let mirror = "plane(#{ point: [0, 0, 0], normal: [0, 0, 1],
    material: material(#{ ambient: 1, specular: [2, 0, 1] }) });";
    let background = "background: [0.25, 0.5, 1]";
    let seen = v3(1.5, 1.0, 2.0);
    assert_eq!(ahead("background", background, mirror), seen);
    // The path is 1 when the mirrored ray is cast: that is not longer than 1.
    let path = |length: &str| format!("{background}, max_path: {length}");
    assert_eq!(ahead("path-1", &path("1"), mirror), seen);
    assert_eq!(ahead("path-0.9", &path("0.9"), mirror), grey(1.0));
    // Between two mirrors the hits are at 1, 4, 7 and 10; the last is cast at 7.
    let mirrors = two_mirrors("ambient: 1, specular: 1");
    let count = |length: &str| format!("attenuation: \"none\", max_path: {length}");
    assert_eq!(ahead("path-7", &count("7"), &mirrors), grey(4.0));
    assert_eq!(ahead("path-6.9", &count("6.9"), &mirrors), grey(3.0));
}

#[test]
fn a_miss_adds_nothing_or_the_background() {
    let mirror = "sphere(#{ center: [0, 0, -2], radius: 1,
    material: material(#{ ambient: 3, specular: 1 }) });";
    // The sphere is met at z = -1, 2 away; the mirrored ray goes back past the eye.
    assert_eq!(ahead("miss", "", mirror), grey(1.5));
    assert_eq!(ahead("miss-lit", "background: [4, 0, 0.5]", mirror), v3(5.5, 1.5, 2.0));
    let aside = "sphere(#{ center: [5, 0, -2], radius: 1 });";
    assert_eq!(ahead("miss-all", "", aside), Vec3::ZERO);
    assert_eq!(ahead("miss-all-lit", "background: [4, 0, 0.5]", aside), v3(4.0, 0.0, 0.5));
}

/// A picture of 16 x 12 pixels that a wall fills, lit from `at`, and its rays.
fn counted(name: &str, settings: &str, specular: &str) -> Rendered {
    let script = format!(
        "image(#{{ width: 16, height: 12 }});
settings(#{{ {settings} }});
camera(#{{ eye: [0, 0, 1], look_at: [0, 0, 0] }});
light(#{{ at: [0, 1, 2], emissivity: 5 }});
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1],
    material: material(#{{ ambient: 1, diffuse: 1, specular: {specular} }}) }});"
    );
    rendered(name, &script)
}

#[test]
fn a_material_with_zero_specular_casts_no_ray() {
    let matt = counted("count-matt", "", "0");
    assert_eq!((matt.rays("camera"), matt.rays("mirror"), matt.rays("shadow")), (192, 0, 192));
    // One channel is enough for a ray, and every mirrored ray goes free.
    let mirror = counted("count-mirror", "", "[0, 0.001, 0]");
    assert_eq!((mirror.rays("camera"), mirror.rays("mirror")), (192, 192));
    assert_eq!(mirror.picture.pixels, matt.picture.pixels);
    let direct = counted("count-direct", "max_bounces: 0", "1");
    assert_eq!((direct.rays("camera"), direct.rays("mirror")), (192, 0));
    assert_eq!(direct.picture.pixels, matt.picture.pixels);
}

#[test]
fn max_bounces_zero_shows_what_the_eye_sees_directly() {
    let mirrors = two_mirrors("ambient: [1, 2, 3], specular: 0.9");
    assert_eq!(ahead("direct", "max_bounces: 0", &mirrors), v3(1.0, 2.0, 3.0));
}

#[test]
fn a_tie_goes_to_the_surface_made_first() {
    let shapes = [
        ("quad", "quad(#{ corner: [-3.1, -3.3, 0], u: [6, 0.3, 0], v: [0.2, 6, 0.7]"),
        ("sphere", "sphere(#{ center: [0.1, 0.2, -3], radius: 4"),
        ("triangle", "triangle(#{ a: [-9, -4, 0.3], b: [9, -4, -0.2], c: [0, 9, 0]"),
        ("plane", "plane(#{ point: [0, 0, -0.3], normal: [0.1, 0.2, 1]"),
    ];
    // Others far behind, so that the pair is not all that a structure holds.
    let mut others = String::new();
    for i in 0..40 {
        writeln!(others, "sphere(#{{ center: [{}, {}, -60], radius: 2 }});", i % 8, i / 8)
            .expect("text");
    }
    for (name, shape) in shapes {
        let red = format!("{shape}, material: material(#{{ ambient: [1, 0, 0] }}) }});\n");
        let green = format!("{shape}, material: material(#{{ ambient: [0, 1, 0] }}) }});\n");
        for (first, second, want) in
            [(&red, &green, v3(1.0, 0.0, 0.0)), (&green, &red, v3(0.0, 1.0, 0.0))]
        {
            for (place, things) in [
                ("before", format!("{first}{second}{others}")),
                ("around", format!("{first}{others}{second}")),
                ("after", format!("{others}{first}{second}")),
            ] {
                let file = format!("tie-{name}-{place}-{}", want[0]);
                let picture = classic(&file, 16, 2.0, &things).picture;
                assert!(picture.pixels.iter().all(|p| *p == want), "{file}: {:?}", picture.pixels);
            }
        }
    }
}

#[test]
fn a_negative_emissivity_subtracts() {
    // Both lights are 2 in front of the wall: (8 - 2) / 2 in red, (0 - 3) / 2 in green.
    let things = "light(#{ at: [0, 0, 2], emissivity: [8, 0, 1] });
light(#{ at: [0, 0, 2], emissivity: [-2, -3, -1] });
plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: material(#{ diffuse: 1 }) });";
    assert_eq!(ahead("negative", "", things), v3(3.0, -1.5, 0.0));
}

#[test]
fn specular_above_one_is_not_clamped() {
    let things = "plane(#{ point: [0, 0, 0], normal: [0, 0, 1],
    material: material(#{ ambient: 1, specular: [4, -2, 1.5] }) });
plane(#{ point: [0, 0, 3], normal: [0, 0, 1], material: material(#{ ambient: 2 }) });";
    assert_eq!(ahead("above-one", "attenuation: \"none\"", things), v3(9.0, -3.0, 4.0));
}

#[test]
fn a_pixel_is_the_mean_of_its_samples() {
    // Of four samples at a = 0.6177, 0.3726, 0.1274 and 0.8823 of one pixel from x = -1 to 1, three
    // lie left of x = 0.5 and one right of it; downward, b = 0.6452, 0.2151, 0.7849 and 0.3548, one
    // of them below y = -0.5.
    let things = "quad(#{ corner: [-9, -9, 0], u: [9.5, 0, 0], v: [0, 18, 0],
    material: material(#{ ambient: [1, 0, 0] }) });
quad(#{ corner: [0.5, -9, 0], u: [9, 0, 0], v: [0, 18, 0],
    material: material(#{ ambient: [5, 0, 4] }) });";
    let script = |samples: usize| {
        format!(
            "image(#{{ width: 1, height: 1, samples: {samples} }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ viewpoint: [0, 0, 2], window: [2, 2] }});
{things}"
        )
    };
    let pixel =
        |samples| rendered(&format!("samples-{samples}"), &script(samples)).picture.at(0, 0);
    assert_eq!(pixel(1), v3(1.0, 0.0, 0.0));
    assert_eq!(pixel(2), v3(1.0, 0.0, 0.0));
    assert_eq!(pixel(4), v3((1.0 + 1.0 + 1.0 + 5.0) / 4.0, 0.0, 1.0));
    // The mean is taken before anything is clamped: here of 5 and 1.
    let up = "quad(#{ corner: [-9, -0.5, 0], u: [18, 0, 0], v: [0, 9, 0],
    material: material(#{ ambient: 8 }) });";
    let script = script(4).replace(things, up);
    assert_eq!(rendered("samples-up", &script).picture.at(0, 0), grey(6.0));
}

#[test]
fn a_spotlight_ends_sharply_at_its_half_width() {
    // 3 in front of the wall, 45 degrees: a disc of radius 3. With rho the way to the light, the
    // intensity is 12 * (3 / rho) / rho.
    let n = 64;
    let things = "spotlight(#{ at: [0, 0, 3], aim: [0, 0, 0], angle: 45, emissivity: 12 });
plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: material(#{ diffuse: 1 }) });";
    let picture = classic("spotlight", n, 8.0, things).picture;
    let mut lit = 0;
    for y in 0..n {
        for x in 0..n {
            let at = |i: usize| (i as f64 + 0.5) / 8.0 - 4.0;
            let square = at(x) * at(x) + at(y) * at(y);
            // No pixel's center is nearer to the edge than this, so none is in doubt.
            assert!((square - 9.0).abs() > 1e-3);
            let want = if square < 9.0 { 12.0 * 3.0 / (9.0 + square) } else { 0.0 };
            let got = picture.at(x, y);
            lit += usize::from(want > 0.0);
            assert!(want > 0.0 || got == Vec3::ZERO, "({x}, {y}): {got:?} in the dark");
            assert!(relative_error(grey(want), got) <= RIGHT_WITHIN, "({x}, {y}): {got:?}, {want}");
        }
    }
    // Pi times 24 pixels squared.
    assert!((1780..1840).contains(&lit), "{lit}");
}

#[test]
fn a_shadow_through_a_hole() {
    // The eye and the wall in z = 0 are below a screen in z = 4 with a hole from -0.5 to 0.5; the
    // light in z = 6 shines through it on the square from -1.5 to 1.5.
    let n = 64;
    let mut script = format!(
        "image(#{{ width: {n}, height: {n} }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ eye: [0, 0, 3], look_at: [0, 0, 0], fov: 90 }});
light(#{{ at: [0, 0, 6], emissivity: 36 }});
let matt = material(#{{ diffuse: 1 }});
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: matt }});
"
    );
    for (corner, u, v) in [
        ("[-9, -9, 4]", "[8.5, 0, 0]", "[0, 18, 0]"),
        ("[0.5, -9, 4]", "[8.5, 0, 0]", "[0, 18, 0]"),
        ("[-0.5, -9, 4]", "[1, 0, 0]", "[0, 8.5, 0]"),
        ("[-0.5, 0.5, 4]", "[1, 0, 0]", "[0, 8.5, 0]"),
    ] {
        writeln!(script, "quad(#{{ corner: {corner}, u: {u}, v: {v}, material: matt }});")
            .expect("text");
    }
    let picture = rendered("hole", &script).picture;
    for y in 0..n {
        for x in 0..n {
            let at = |i: usize| 3.0 * ((i as f64 + 0.5) / 32.0 - 1.0);
            let lit = at(x).abs() < 1.5 && at(y).abs() < 1.5;
            let square = at(x) * at(x) + at(y) * at(y);
            let want = if lit { 36.0 * 6.0 / (36.0 + square) } else { 0.0 };
            let got = picture.at(x, y);
            assert!(lit || got == Vec3::ZERO, "({x}, {y}): {got:?} in shadow");
            assert!(relative_error(grey(want), got) <= RIGHT_WITHIN, "({x}, {y}): {got:?}, {want}");
        }
    }
}

#[test]
fn a_sphere_seen_from_inside() {
    // From the center of a ball of radius 2 with the light there: hits at 2, 6 and 10, each with
    // cos 1 and r 2, whatever the direction.
    let script = |light: &str| {
        format!(
            "image(#{{ width: 12, height: 12 }});
settings(#{{ max_bounces: 2 }});
camera(#{{ eye: [0, 0, 0], look_at: [1, 2, 3], fov: 120 }});
light(#{{ at: {light}, emissivity: 4 }});
sphere(#{{ center: [0, 0, 0], radius: 2, material: material(#{{ diffuse: 1, specular: 0.5 }}) }});"
        )
    };
    let want = 2.0 / 2.0 + 0.5 * (2.0 / 6.0 + 0.5 * (2.0 / 10.0));
    for got in &rendered("inside", &script("[0, 0, 0]")).picture.pixels {
        // About 20 operations a hit, three hits.
        within(*got, grey(want), 60.0);
    }
    // The shell hides a light outside from all of its inside.
    for light in ["[0, 3, 0]", "[-2, -2, -2]", "[2.0001, 0, 0]"] {
        let picture = rendered("inside-dark", &script(light)).picture;
        assert!(picture.pixels.iter().all(|p| *p == Vec3::ZERO), "light {light}");
    }
}

#[test]
fn a_light_hides_nothing_and_what_is_beyond_it_hides_it_not() {
    let things = |at: &str| {
        format!(
            "light(#{{ at: [0, 0, 4], emissivity: 8 }});
let matt = material(#{{ diffuse: 1 }});
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: matt }});
sphere(#{{ center: [0, 0, {at}], radius: 0.5, material: matt }});"
        )
    };
    assert_eq!(ahead("beyond", "", &things("6")), grey(2.0));
    assert_eq!(ahead("between", "", &things("2.5")), Vec3::ZERO);
}

#[test]
fn a_checker_has_no_double_wide_tiles_at_the_axes() {
    // The plane is the window itself: 4 x 4 pixels a tile, from -4 to 4.
    let things = "let tiles = checker(#{ even: material(#{ ambient: [1, 0, 0] }), odd: material(#{ ambient: [0, 1, 0] }) });
plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: tiles });";
    let picture = classic("checker", 32, 8.0, things).picture;
    for y in 0..32 {
        for x in 0..32 {
            // x counts tiles from -4, y from 3 downward: the first tile, (-4, 3), is odd.
            let odd = (x / 4 + y / 4 + 1) % 2 == 1;
            let want = if odd { v3(0.0, 1.0, 0.0) } else { v3(1.0, 0.0, 0.0) };
            assert_eq!(picture.at(x, y), want, "({x}, {y})");
        }
    }
}

#[test]
fn no_surface_shadows_or_mirrors_itself() {
    // A ball of radius 1 where coordinates have an ulp of 6.1e-5: 16384 ulp, hardly more than the
    // 1e4 that are promised. With the light at the eye all that is seen is lit, and its mirrored rays go free.
    let script = "image(#{ width: 64, height: 64 });
settings(#{ attenuation: \"none\", background: [0, 100, 0] });
camera(#{ eye: [1000, 1000, 1004], look_at: [1000, 1000, 1000], fov: 40 });
light(#{ at: [1000, 1000, 1004], emissivity: 3 });
sphere(#{ center: [1000, 1000, 1000], radius: 1,
    material: material(#{ ambient: [0, 0, 1], diffuse: [1, 0, 0], specular: 1 }) });";
    let picture = rendered("far", script).picture;
    let on_ball: Vec<&Vec3> = picture.pixels.iter().filter(|p| p[2] != 0.0).collect();
    assert!(on_ball.len() > 1000, "{}", on_ball.len());
    for pixel in on_ball {
        // 1 in blue would be 2 where the ball mirrors itself, and green would be missing there.
        assert!(pixel[0] > 0.0 && pixel[1] == 100.0 && pixel[2] == 1.0, "{pixel:?}");
    }
}

/// Two overflowing factors: their product is infinite in f32.
const OVERFLOW: &str = "diffuse: 1e10";
const HUGE_LIGHT: &str = "light(#{ at: [0, 0, 2], emissivity: 1e38 });";

#[test]
fn zero_meets_no_overflow_in_shadow() {
    let wall = format!(
        "plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: material(#{{ ambient: [1, 2, 3], {OVERFLOW} }}) }});"
    );
    let want = v3(1.0, 2.0, 3.0);
    let screen = "quad(#{ corner: [-1, -1, 1.5], u: [2, 0, 0], v: [0, 2, 0] });";
    let shadow = format!("{HUGE_LIGHT}\n{wall}\n{screen}");
    assert_eq!(ahead("huge-shadow", "", &shadow), want);
    let behind = format!("light(#{{ at: [0, 0, -2], emissivity: 1e38 }});\n{wall}");
    assert_eq!(ahead("huge-behind", "", &behind), want);
    let aside = format!(
        "spotlight(#{{ at: [0, 0, 2], aim: [5, 0, 2], angle: 10, emissivity: 1e38 }});\n{wall}"
    );
    assert_eq!(ahead("huge-aside", "", &aside), want);
    // In the open it does overflow: to infinity, not to NaN.
    let open = ahead("huge-open", "", &format!("{HUGE_LIGHT}\n{wall}"));
    assert_eq!(open, grey(f64::INFINITY));
}

#[test]
fn zero_meets_no_overflow_in_a_mirror() {
    // The mirror shows a wall that overflows in all channels, but only in its green one.
    let things = |specular: &str| {
        format!(
            "{HUGE_LIGHT}
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: material(#{{ ambient: 1, specular: {specular} }}) }});
plane(#{{ point: [0, 0, 3], normal: [0, 0, -1], material: material(#{{ {OVERFLOW} }}) }});"
        )
    };
    let green = ahead("huge-green", "", &things("[0, 0.5, 0]"));
    assert_eq!(green, v3(1.0, f64::INFINITY, 1.0));
    assert_eq!(ahead("huge-none", "", &things("0")), grey(1.0));
    assert_eq!(ahead("huge-direct", "max_bounces: 0", &things("1")), grey(1.0));
    assert_eq!(ahead("huge-cut", "max_path: 0.5", &things("1")), grey(1.0));
    // Mirrors whose product overflows, over a wall that gives nothing.
    let black = two_mirrors("ambient: 0, specular: 1e38");
    assert_eq!(ahead("huge-mirrors", "", &black), Vec3::ZERO);
}

#[test]
fn huge_lights_on_faint_surfaces_stay_finite() {
    let things = "light(#{ at: [0, 0, 2], emissivity: [1e38, 1e38, 1e38] });
plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: material(#{ ambient: [0, 0, 1], diffuse: [1e-30, -1e-36, 0] }) });";
    // The two inputs and three products round.
    within(ahead("huge-faint", "", things), v3(5e7, -50.0, 1.0), 6.0);
}
