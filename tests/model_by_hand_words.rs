//! Patterns, shaders and lights through the binary, against numbers that a person can work out on
//! paper. Where the classic view looks at the plane of its window, a pixel's point is known to a
//! few roundings.

mod oracle;

use oracle::binary::{folder, rendered};
use oracle::hand::{ahead, classic, grey, within};
use oracle::texture::Texture;
use oracle::vec3::{Vec3, v3};
use oracle::view::Picture;

const RED: Vec3 = v3(1.0, 0.0, 0.0);
const GREEN: Vec3 = v3(0.0, 1.0, 0.0);
const BLUE: Vec3 = v3(0.0, 0.0, 1.0);
const WHITE: Vec3 = v3(1.0, 1.0, 1.0);

/// A wall that is the window itself, with a matt material.
const WALL: &str =
    "plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: material(#{ diffuse: 1 }) });";

/// A picture beside the scripts, of so many columns; its texels are 0 or 255 in each channel.
fn picture_file(name: &str, width: usize, texels: &[Vec3]) {
    let texels: Vec<[u8; 3]> = texels.iter().map(|t| t.0.map(|x| (x * 255.0) as u8)).collect();
    let (file, height) = (format!("{name}.png"), texels.len() / width);
    Texture { file, width, height, texels }.write(&folder("model"));
}

/// Red, green above blue, white.
fn four(name: &str) {
    picture_file(name, 2, &[RED, GREEN, BLUE, WHITE]);
}

fn rows(picture: &Picture) -> Vec<&[Vec3]> {
    picture.pixels.chunks(picture.width).collect()
}

/// The pattern of 0 and 1 that `f` gives for the pixel's point, held exactly.
fn holds(name: &str, n: usize, edge: f64, things: &str, want: impl Fn(f64, f64) -> Vec3) {
    let picture = classic(name, n, edge, things).picture;
    for (i, got) in picture.pixels.iter().enumerate() {
        let at = |i: usize| (i as f64 + 0.5) * edge / n as f64 - edge / 2.0;
        let (x, y) = (at(i % n), -at(i / n));
        assert_eq!(*got, want(x, y), "{name}: ({x}, {y})");
    }
}

const PAIR: &str = "let even = material(#{ ambient: [1, 0, 0] });
let odd = material(#{ ambient: [0, 1, 0] });";

fn parity(n: f64) -> Vec3 {
    if n.rem_euclid(2.0) == 0.0 { RED } else { GREEN }
}

#[test]
fn solid_cells_are_decided_on_flat_faces() {
    let solid =
        format!("{PAIR}\nlet cells = checker(#{{ even: even, odd: odd, size: [1, 0.5, 1] }});");
    let cells = |x: f64, y: f64| parity(x.floor() + (y / 0.5).floor());
    // In a face of the cells: no rounding of z may show.
    let wall =
        format!("{solid}\nplane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: cells }});");
    holds("solid-plane", 32, 4.0, &wall, cells);
    let disc = format!(
        "{solid}\ndisc(#{{ center: [0, 0, 0], normal: [0, 0, -3], radius: 9, material: cells }});"
    );
    holds("solid-disc", 32, 4.0, &disc, cells);
    // The near face of a box is 2, two cells, from its origin; its other face is at the origin.
    let near =
        format!("{solid}\ncuboid(#{{ min: [-2, -2, -2], max: [2, 2, 0], material: cells }});");
    holds("solid-near", 32, 4.0, &near, cells);
    let far = format!(
        "{solid}\nlet dice = cuboid(#{{ min: [-2, -2, 0], max: [2, 2, 2], material: cells }});
group([dice], #{{ rotate: [0, 180, 0] }});"
    );
    // Turned about y, x runs the other way.
    holds("solid-far", 32, 4.0, &far, |x, y| cells(-x, y));
    // The bottom of a tin.
    let tin = format!(
        "{solid}\ncylinder(#{{ base: [0, 0, 0], axis: [0, 0, -1], radius: 4, height: 1, caps: true, material: cells }});"
    );
    holds("solid-tin", 32, 4.0, &tin, cells);
}

#[test]
fn stripes_have_one_width_everywhere() {
    let things = |xdir: &str| {
        format!(
            "{PAIR}
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: stripes(#{{ even: even, odd: odd, width: 0.5{xdir} }}) }});"
        )
    };
    holds("stripes", 32, 4.0, &things(""), |x, _| parity((x / 0.5).floor()));
    // Of a slanted xdir only the part along the wall counts, and of that not the length.
    let slanted = things(", xdir: [0, 3, 5]");
    holds("stripes-up", 32, 4.0, &slanted, |_, y| parity((y / 0.5).floor()));
    // On what is not flat it counts as it is: over the front of a box, 3/5 of y.
    let box_ = format!(
        "{PAIR}
cuboid(#{{ min: [-3, -3, -1], max: [3, 3, 0], material: stripes(#{{ even: even, odd: odd, width: 0.3, xdir: [0, 3, 4] }}) }});"
    );
    holds("stripes-box", 32, 4.0, &box_, |_, y| parity((((y + 3.0) * 0.6 + 0.8) / 0.3).floor()));
}

#[test]
fn pictures_are_upright_and_unmirrored() {
    four("upright");
    let textured = "let m = textured(#{ base: material(#{ ambient: 1 }), file: \"upright.png\", filter: \"nearest\"";
    let quarter = |x: f64, y: f64| match (x > 0.0, y > 0.0) {
        (false, true) => RED,
        (true, true) => GREEN,
        (false, false) => BLUE,
        (true, false) => WHITE,
    };
    for (name, shape) in [
        ("quad", "quad(#{ corner: [-2, -2, 0], u: [4, 0, 0], v: [0, 4, 0], material: m });"),
        ("box", "cuboid(#{ min: [-2, -2, -1], max: [2, 2, 0], material: m });"),
        // Its square is about the disc.
        ("disc", "disc(#{ center: [0, 0, 0], normal: [0, 0, 1], radius: 2.9, material: m });"),
        (
            "lid",
            "cylinder(#{ base: [0, 0, -1], axis: [0, 0, 1], radius: 2.9, height: 1, caps: true, material: m });",
        ),
    ] {
        let things = format!("{textured} }});\n{shape}");
        holds(&format!("upright-{name}"), 8, 4.0, &things, quarter);
    }
    // In tiles of 4 x 2 from the plane's point on.
    let tiles = format!(
        "{textured}, mode: \"tile\", size: [4, 2] }});
plane(#{{ point: [0, 0, 0], normal: [0, 0, 1], material: m }});"
    );
    holds("upright-tiles", 8, 8.0, &tiles, |x, y| {
        quarter(x.rem_euclid(4.0) - 2.0, y.rem_euclid(2.0) - 1.0)
    });
}

#[test]
fn a_globe_is_printed_from_left_to_right() {
    // Four columns: longitudes 0 to 90 red (from +x to -z, at the far side), then green, blue, white.
    picture_file("globe", 4, &[RED, GREEN, BLUE, WHITE]);
    let globe = "let m = textured(#{ base: material(#{ ambient: 1 }), file: \"globe.png\", filter: \"nearest\" });
let globe = sphere(#{ center: [0, 0, 0], radius: 1.9, material: m });";
    let seen = |name: &str, turned: i32| {
        let things = format!(
            "{globe}\ngroup([globe], #{{ rotate: [0, {turned}, 0], translate: [0, 0, -2] }});"
        );
        let picture = classic(name, 8, 4.0, &things).picture;
        (picture.at(3, 3), picture.at(4, 3))
    };
    assert_eq!(seen("globe-front", 0), (BLUE, WHITE));
    assert_eq!(seen("globe-back", 180), (RED, GREEN));
    assert_eq!(seen("globe-right", -90), (WHITE, RED));
}

#[test]
fn between_texels_the_light_is_linear() {
    picture_file("between", 2, &[Vec3::ZERO, WHITE]);
    let things =
        "let m = textured(#{ base: material(#{ ambient: [1, 2, 0.5] }), file: \"between.png\" });
quad(#{ corner: [-2, -2, 0], u: [4, 0, 0], v: [0, 4, 0], material: m });";
    let picture = classic("between", 8, 4.0, things).picture;
    // Texels are 2 wide, their centers at -1 and 1.
    let want = [0.0, 0.0, 0.125, 0.375, 0.625, 0.875, 1.0, 1.0];
    for row in rows(&picture) {
        for (got, want) in row.iter().zip(want) {
            within(*got, v3(want, 2.0 * want, 0.5 * want), 60.0);
        }
    }
    // A value in the middle of the curve: (0.5 + 0.055) / 1.055 to the power of 2.4 at 127.5.
    let texels = vec![[128; 3]];
    Texture { file: "middle.png".to_owned(), width: 1, height: 1, texels }.write(&folder("model"));
    let got = classic("middle", 1, 4.0, &things.replace("between.png", "middle.png")).picture;
    within(got.at(0, 0), v3(1.0, 2.0, 0.5) * 0.2158605001138992, 20.0);
}

#[test]
fn shaders_see_the_point() {
    let wall = |f: &str| {
        format!(
            "let k = 2;
let m = shader(#{{ base: material(#{{ diffuse: 1 }}), ambient: |p| {f} }});
quad(#{{ corner: [-2, -2, 0], u: [0, 4, 0], v: [4, 0, 0], material: m }});"
        )
    };
    let each = |name: &str, f: &str, want: &dyn Fn(f64, f64) -> Vec3| {
        let picture = classic(name, 8, 4.0, &wall(f)).picture;
        for (i, got) in picture.pixels.iter().enumerate() {
            let at = |i: usize| (i as f64 + 0.5) / 2.0 - 2.0;
            let (x, y) = (at(i % 8), -at(i / 8));
            let error = (*got - want(x, y)).largest();
            // Values of a few units, after a dozen operations.
            assert!(error < 1e-5, "{f} at ({x}, {y}): {got:?}, {:?}", want(x, y));
        }
    };
    each("shader-p", "[p.x, p.y, p.z]", &|x, y| v3(x, y, 0.0));
    // u runs up and v to the right, so the quad shows its back; the normal is turned to the eye.
    each("shader-uv", "[p.u, p.v, 0]", &|x, y| v3((y + 2.0) / 4.0, (x + 2.0) / 4.0, 0.0));
    each("shader-normal", "p.normal", &|_, _| BLUE);
    each("shader-grey", "p.x * k - 1", &|x, _| grey(2.0 * x - 1.0));
    each("shader-number", "0.25 * k", &|_, _| grey(0.5));
    each("shader-mod", "[mod(p.x, 1.5), mod(p.y, -1.5), floor(p.x)]", &|x, y| {
        v3(x.rem_euclid(1.5), y - -1.5 * (y / -1.5).floor(), x.floor())
    });
    each("shader-step", "[step(0.3, p.x), smoothstep(-1, 1, p.y), mix(2, 4, p.u)]", &|x, y| {
        let t = ((y + 1.0) / 2.0).clamp(0.0, 1.0);
        v3(f64::from(x >= 0.3), t * t * (3.0 - 2.0 * t), 2.0 + 2.0 * (y + 2.0) / 4.0)
    });
    each("shader-trig", "[sin(p.x), cos(p.y), acos(p.x / 2)]", &|x, y| {
        v3(x.sin(), y.cos(), (x / 2.0).acos())
    });
    each("shader-roots", "[sqrt(abs(p.x)), min(p.x, p.y), max(-p.x, p.y)]", &|x, y| {
        v3(x.abs().sqrt(), x.min(y), y.max(-x))
    });
    each(
        "shader-dot",
        "[dot(p.normal, [1, 2, 3]), length(vec3(p.x, p.y, 1)), clamp(p.x, -1, 1)]",
        &|x, y| v3(3.0, (x * x + y * y + 1.0).sqrt(), x.clamp(-1.0, 1.0)),
    );
}

#[test]
fn shaders_see_the_point_before_motions() {
    let things =
        "let m = shader(#{ base: material(#{ diffuse: 1 }), ambient: |p| [p.x, p.y, p.normal.z] });
let wall = quad(#{ corner: [-1, -1, 7], u: [2, 0, 0], v: [0, 2, 0], material: m });
group([wall], #{ scale: 2, translate: [0, 0, -14] });";
    let picture = classic("shader-moved", 8, 4.0, things).picture;
    for (i, got) in picture.pixels.iter().enumerate() {
        let at = |i: usize| (i as f64 + 0.5) / 2.0 - 2.0;
        within(*got, v3(at(i % 8) / 2.0, -at(i / 8) / 2.0, 1.0), 20.0);
    }
}

#[test]
fn noise_is_bounded_smooth_and_the_same_each_time() {
    let seen = |edge: f64| {
        let things = "let m = shader(#{ base: material(#{ diffuse: 1 }), ambient: |p| noise(p.x * 7.3, p.y * 7.3, p.z + 0.4) });
plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: m });";
        classic(&format!("noise-{edge}"), 64, edge, things).picture
    };
    let far = seen(8.0);
    let values: Vec<f64> = far.pixels.iter().map(|p| p[0]).collect();
    let (low, high) = values.iter().fold((1.0f64, -1.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
    assert!((-1.0..-0.3).contains(&low) && high > 0.3 && high <= 1.0, "{low} to {high}");
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    assert!(mean.abs() < 0.1, "{mean}");
    assert_eq!(far.pixels, seen(8.0).pixels);
    // Seen from near, where a pixel is 0.0073 of a cell, neighbours are alike and yet differ.
    let near = seen(0.064);
    let steps: Vec<f64> =
        rows(&near).iter().flat_map(|r| r.windows(2).map(|w| (w[1] - w[0]).largest())).collect();
    let largest = steps.iter().fold(0.0f64, |m, x| m.max(*x));
    assert!(largest > 1e-5 && largest < 0.04, "{largest}");
}

#[test]
fn falloffs_divide_or_do_not() {
    // The light is 5 away, its cosine 4/5.
    for (name, keys) in [
        ("light", "at: [3, 0, 4], emissivity: 10"),
        ("spotlight", "at: [3, 0, 4], aim: [0, 0, 0], angle: 20, emissivity: 10"),
    ] {
        for (falloff, want) in [("inverse", 1.6), ("none", 8.0), ("square", 0.32)] {
            let things = format!("{name}(#{{ {keys}, falloff: \"{falloff}\" }});\n{WALL}");
            within(ahead(&format!("{name}-{falloff}"), "", &things), grey(want), 20.0);
        }
        let things = format!("{name}(#{{ {keys} }});\n{WALL}");
        within(ahead(&format!("{name}-default"), "", &things), grey(1.6), 20.0);
    }
}

#[test]
fn a_sun_gives_its_cosine_at_any_distance() {
    let sun = "sun(#{ direction: [-3, 0, -4], emissivity: [5, 10, 20] });";
    let lit = ahead("sun", "attenuation: \"none\"", &format!("{sun}\n{WALL}"));
    within(lit, v3(4.0, 8.0, 16.0), 20.0);
    let away = WALL.replace("point: [0, 0, 0]", "point: [0, 0, -7]");
    within(ahead("sun-far", "", &format!("{sun}\n{away}")), v3(0.5, 1.0, 2.0), 20.0);
    // Behind the wall there is none, and a shadow has no end.
    let behind = sun.replace("-4", "4");
    assert_eq!(ahead("sun-behind", "", &format!("{behind}\n{WALL}")), Vec3::ZERO);
    let moon = "sphere(#{ center: [3000, 0, 4000], radius: 9 });";
    assert_eq!(ahead("sun-moon", "", &format!("{sun}\n{WALL}\n{moon}")), Vec3::ZERO);
    let other = "sphere(#{ center: [-3000, 0, 4000], radius: 9 });";
    within(ahead("sun-other", "", &format!("{sun}\n{WALL}\n{other}")), v3(4.0, 8.0, 16.0), 20.0);
}

#[test]
fn a_slide_is_upright_unmirrored_and_of_its_own_shape() {
    // The projector stands where the eye is, 2 before the wall: at 45 degrees its slide is 4 wide.
    four("slide");
    let things = |file: &str, up: &str| {
        format!(
            "projector(#{{ at: [0, 0, 2], aim: [0, 0, -5]{up}, angle: 45, file: \"{file}.png\", emissivity: 1, falloff: \"none\" }});\n{WALL}"
        )
    };
    let seen = |name: &str, file: &str, up: &str| {
        let picture = classic(name, 16, 8.0, &things(file, up)).picture;
        picture
            .pixels
            .iter()
            .map(|c| c.map(|x| if x > 0.0 { 1.0 } else { 0.0 }))
            .collect::<Vec<_>>()
    };
    let want = |f: &dyn Fn(f64, f64) -> Vec3| -> Vec<Vec3> {
        let at = |i: usize| (i as f64 + 0.5) / 2.0 - 4.0;
        (0..256).map(|i| f(at(i % 16), -at(i / 16))).collect()
    };
    let quarter = |x: f64, y: f64| match (x > 0.0, y > 0.0) {
        _ if x.abs() > 2.0 || y.abs() > 2.0 => Vec3::ZERO,
        (false, true) => RED,
        (true, true) => GREEN,
        (false, false) => BLUE,
        (true, false) => WHITE,
    };
    assert_eq!(seen("slide", "slide", ""), want(&quarter));
    // With x up, what was up is to the right, what was right is down.
    assert_eq!(seen("slide-turned", "slide", ", up: [1, 0, 0]"), want(&|x, y| quarter(-y, x)));
    // Four columns and one row: a quarter as high as wide.
    picture_file("slide-wide", 4, &[RED, GREEN, BLUE, WHITE]);
    let wide = |x: f64, y: f64| match y.abs() < 0.5 {
        true if (-2.0..2.0).contains(&x) => [RED, GREEN, BLUE, WHITE][(x + 2.0).floor() as usize],
        _ => Vec3::ZERO,
    };
    assert_eq!(seen("slide-wide", "slide-wide", ""), want(&wide));
    // The wall behind the projector stays dark.
    let behind = things("slide", "").replace("aim: [0, 0, -5]", "aim: [0, 0, 5]");
    assert!(
        classic("slide-behind", 4, 8.0, &behind).picture.pixels.iter().all(|p| *p == Vec3::ZERO)
    );
}

#[test]
fn a_slide_shines_as_its_texels_say() {
    four("shine");
    // The point (1, 1, 0) is r = sqrt(6) away; cos is 2 / r. The texel there is green.
    let script = format!(
        "image(#{{ width: 1, height: 1 }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ eye: [1, 1, 1], look_at: [1, 1, 0] }});
projector(#{{ at: [0, 0, 2], aim: [0, 0, 0], angle: 45, file: \"shine.png\", emissivity: [9, 18, 9] }});
{WALL}"
    );
    let got = rendered("shine", &script).picture.at(0, 0);
    within(got, v3(0.0, 18.0 * 2.0 / 6.0, 0.0), 20.0);
}
