//! Light on coarse smooth meshes ends as on the surface that their normals describe, and no light
//! passes what stands there.

mod oracle;

use oracle::binary::{folder, render};
use oracle::vec3::{Vec3, v3};
use oracle::view::Picture;
use std::fmt::Write as _;

/// Writes a ball of radius 1 with exact normals, of so many sectors and rings.
fn write_ball(folder: &std::path::Path, sectors: usize, rings: usize) -> String {
    let mut out = String::new();
    for ring in 0..=rings {
        for sector in 0..sectors {
            let (up, around) = (
                std::f64::consts::PI * ring as f64 / rings as f64,
                std::f64::consts::TAU * sector as f64 / sectors as f64,
            );
            let p = v3(up.sin() * around.cos(), up.cos(), up.sin() * around.sin());
            let _ = writeln!(out, "v {0} {1} {2}\nvn {0} {1} {2}", p[0], p[1], p[2]);
        }
    }
    for ring in 0..rings {
        for sector in 0..sectors {
            let at = |ring: usize, sector: usize| ring * sectors + sector % sectors + 1;
            let corners = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, s)| at(ring + r, sector + s));
            let [a, b, c, d] = corners.map(|v| format!("{v}//{v}"));
            if ring > 0 {
                let _ = writeln!(out, "f {a} {b} {c}");
            }
            if ring + 1 < rings {
                let _ = writeln!(out, "f {a} {c} {d}");
            }
        }
    }
    let name = format!("ball-{sectors}-{rings}.obj");
    std::fs::write(folder.join(&name), out).expect("the ball is written");
    name
}

/// A picture of what `things` says, with `BALL` for the file of a ball; -9 where nothing is.
fn seen(name: &str, (sectors, rings): (usize, usize), things: &str) -> Picture {
    let folder = folder("terminator");
    let things = things.replace("BALL", &write_ball(&folder, sectors, rings));
    let script = format!(
        "settings(#{{ attenuation: \"none\", background: -9 }});
image(#{{ width: 160, height: 160 }});\n{things}"
    );
    let path = folder.join(format!("{name}.rhai"));
    render(&path, &script, &[]).unwrap_or_else(|why| panic!("{why}")).picture
}

/// The greatest step between neighbours in a row on the ball.
fn largest_step(picture: &Picture) -> f64 {
    let on_ball = |x: f64| x > -1.0;
    let rows = picture.pixels.chunks(picture.width);
    let steps = rows.flat_map(|row| row.windows(2)).map(|pair| (pair[0][0], pair[1][0]));
    let steps = steps.filter(|(a, b)| on_ball(*a) && on_ball(*b)).map(|(a, b)| (a - b).abs());
    steps.fold(0.0, f64::max)
}

const EYE: &str = "camera(#{ eye: [0, 1, 4], look_at: [0, 0, 0], fov: 36 });\n";
const SUN: &str = "sun(#{ direction: [-1, -0.5, -0.2], emissivity: 1 });\n";
const BALL: &str = "mesh(#{ file: \"BALL\", material: #{ diffuse: 1 } });\n";

/// A ball of radius 1 fills 120 pixels. Light on a sphere falls by 1/60 a pixel toward the
/// terminator where this is seen from above, and faster where it is seen at a slant; a coarse ball's
/// normals turn unevenly. A facet that goes black at once makes a step of 0.18 with 16 sectors.
const SMOOTH: f64 = 0.06;

#[test]
fn light_falls_off_smoothly_at_any_resolution() {
    for (sectors, rings) in [(12, 6), (16, 8), (17, 9), (24, 12), (40, 20)] {
        let picture =
            seen(&format!("sun-{sectors}"), (sectors, rings), &format!("{EYE}{SUN}{BALL}"));
        let step = largest_step(&picture);
        assert!(step < SMOOTH, "{sectors} sectors: a step of {step}");
        // A half of the ball is lit and a half is not.
        let lit = picture.pixels.iter().filter(|p| p[0] > 0.0).count();
        let dark = picture.pixels.iter().filter(|p| p[0] == 0.0).count();
        assert!(lit > 5000 && dark > 1500, "{lit} lit, {dark} dark");
    }
}

#[test]
fn so_for_all_lights_at_all_scales_and_in_all_places() {
    let lamp = "light(#{ at: [5, 2, 1], emissivity: 1, falloff: \"none\" });\n";
    let spot = "spotlight(#{ at: [5, 2, 1], aim: [0, 0, 0], angle: 40, emissivity: 1, falloff: \"none\" });\n";
    for (name, light) in [("lamp", lamp), ("spot", spot)] {
        let step = largest_step(&seen(name, (16, 8), &format!("{EYE}{light}{BALL}")));
        assert!(step < SMOOTH, "{name}: a step of {step}");
    }
    for scale in [1e-3, 1e3] {
        let eye = format!(
            "camera(#{{ eye: [0, {scale:?}, {:?}], look_at: [0, 0, 0], fov: 36 }});\n",
            4.0 * scale
        );
        let ball =
            format!("mesh(#{{ file: \"BALL\", scale: {scale:?}, material: #{{ diffuse: 1 }} }});");
        let step =
            largest_step(&seen(&format!("scale-{scale}"), (16, 8), &format!("{eye}{SUN}{ball}")));
        assert!(step < SMOOTH, "scale {scale}: a step of {step}");
    }
    for (name, place) in [
        ("mirrored", "scale: [-1, 1, 1]"),
        ("turned", "rotate: [30, 40, 50]"),
        ("stretched", "scale: [1, 0.7, 1.2]"),
    ] {
        let ball = format!(
            "let ball = mesh(#{{ file: \"BALL\", visible: false, material: #{{ diffuse: 1 }} }});
instance(ball, #{{ {place} }});"
        );
        let step = largest_step(&seen(name, (16, 8), &format!("{EYE}{SUN}{ball}")));
        assert!(step < SMOOTH, "{name}: a step of {step}");
    }
}

/// Whether the ball is dark all over.
fn is_dark(picture: &Picture) -> bool {
    picture.pixels.iter().all(|p| [Vec3::ZERO, Vec3::splat(-9.0)].contains(p))
}

#[test]
fn what_nearly_touches_the_mesh_lets_no_light_through() {
    // A wall behind the light side of the ball, nearer than the ball's own surface lies above the
    // triangles' middles, 0.02; the sun shines on its other side.
    let eye = "camera(#{ eye: [-1, 1, 4], look_at: [0, 0, 0], fov: 36 });\n";
    let wall =
        "plane(#{ point: [1.0005, 0, 0], normal: [1, 0, 0], material: #{ ambient: -9 } });\n";
    for direction in ["[-1, 0, 0]", "[-1, -0.5, -0.2]", "[-0.2, -1, 0]", "[-0.1, 0.3, -1]"] {
        let sun = format!("sun(#{{ direction: {direction}, emissivity: 1 }});\n");
        let name = format!("wall-{}", direction.len());
        assert!(is_dark(&seen(&name, (16, 8), &format!("{eye}{sun}{wall}{BALL}"))), "{direction}");
    }
    // A shell around the ball, 0.001 away, seen from within.
    let shell = "sphere(#{ center: [0, 0, 0], radius: 1.001, material: #{ ambient: 0 } });\n";
    let eye = "camera(#{ eye: [0, 1.0005, 0], look_at: [1, 0.5, 0], fov: 60 });\n";
    assert!(is_dark(&seen("shell", (16, 8), &format!("{eye}{SUN}{shell}{BALL}"))));
}

#[test]
fn shadows_of_others_stay_on_the_mesh() {
    // A beam along the sun's way to the terminator darkens as much of the coarse ball as of a fine one.
    let beam = "disc(#{ center: [1.5, 1.2, 0.9], normal: [1, 0.5, 0.2], radius: 0.35, material: #{ ambient: -9 } });\n";
    let shadow = |ball: (usize, usize)| {
        let things = format!("{EYE}{SUN}{BALL}");
        let name = format!("beam-{}", ball.0);
        let free = seen(&format!("{name}-free"), ball, &things);
        let blocked = seen(&name, ball, &format!("{things}{beam}"));
        let both = free.pixels.iter().zip(&blocked.pixels);
        both.filter(|(free, blocked)| free[0] > 0.0 && blocked[0] == 0.0).count() as f64
    };
    let (coarse, fine) = (shadow((16, 8)), shadow((96, 48)));
    assert!(fine > 300.0 && (coarse / fine - 1.0).abs() < 0.05, "{coarse} pixels and {fine}");
}

#[test]
fn facets_stay_facets() {
    // With `smooth: false` a facet that the sun does not face is dark, and all of it is alike.
    let flat = BALL.replace("material", "smooth: false, material");
    let picture = seen("flat", (16, 8), &format!("{EYE}{SUN}{flat}"));
    let mut greys: Vec<u64> = picture.pixels.iter().map(|p| p[0].to_bits()).collect();
    greys.sort_unstable();
    greys.dedup();
    // A value a triangle, of 224, and the background: f32 normals of a quad's halves differ.
    assert!((20..=225).contains(&greys.len()), "{} values", greys.len());
    assert!(largest_step(&picture) > SMOOTH);
}
