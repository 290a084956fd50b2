//! The curved shapes, groups and instances through the binary, against numbers that a person can
//! work out on paper.
//!
//! Quotients by a path's length and the roots of a quadric take a dozen operations a hit: the
//! tolerance is [`HIT`] roundings for each hit of a path, unless the case says why it is exact.

mod oracle;

use oracle::binary::rendered;
use oracle::compare::RIGHT_WITHIN;
use oracle::hand::{ahead, classic, grey, within};
use oracle::vec3::{Vec3, v3};
use oracle::view::relative_error;

/// The roundings that one hit may have.
const HIT: f64 = 20.0;

/// A material that is worth 1 at each hit and halves what it mirrors.
const HALF_MIRROR: &str = "material: material(#{ ambient: 1, specular: 0.5 })";
const GLOW: &str = "material: material(#{ ambient: 1 })";

/// `1 / first + 0.5 / (first + gap) + 0.25 / (first + 2 gap) ...`, of so many hits.
fn series(first: f64, gap: f64, hits: i32) -> Vec3 {
    grey((0..hits).map(|k| 0.5f64.powi(k) / (first + gap * f64::from(k))).sum())
}

#[test]
fn the_inside_of_a_cylinder_mirrors_itself() {
    // From z = 1 to the wall at z = -2, then to and fro over the diameter of 4.
    for caps in ["", ", caps: true"] {
        let tube = format!(
            "cylinder(#{{ base: [0, -1, 0], axis: [0, 3, 0], radius: 2, height: 2{caps}, {HALF_MIRROR} }});"
        );
        let got = ahead("tube", "max_bounces: 3", &tube);
        within(got, series(3.0, 4.0, 4), 4.0 * HIT);
    }
}

#[test]
fn caps_close_what_is_open_without_them() {
    let tin = |z: f64, height: f64, caps: bool| {
        format!(
            "cylinder(#{{ base: [0, 0, {z:?}], axis: [0, 0, 1], radius: 1, height: {height:?}, caps: {caps}, {HALF_MIRROR} }});"
        )
    };
    let seen = |name: &str, tin: &str| ahead(name, "max_bounces: 2, background: 8", tin);
    // From outside: the cap, 2 ahead, that mirrors the background; or through the tube.
    within(seen("cap", &tin(-3.0, 2.0, true)), grey(0.5 + 4.0), HIT);
    assert_eq!(seen("no-cap", &tin(-3.0, 2.0, false)), grey(8.0));
    // From inside: from cap to cap, 6 apart.
    within(seen("caps", &tin(-2.0, 6.0, true)), series(3.0, 6.0, 3), 3.0 * HIT);
    assert_eq!(seen("no-caps", &tin(-2.0, 6.0, false)), grey(8.0));
    // A cone and a paraboloid have one cap, at their wide end; a hyperboloid has two.
    for (maker, at, caps) in [("cone", "apex", 1), ("paraboloid", "vertex", 1)] {
        for (z, up, hit) in [(-4.0, 1.0, Some(3.0)), (0.0, -1.0, None)] {
            let shape = format!(
                "{maker}(#{{ {at}: [0.25, 0, {z:?}], axis: [0, 0, {up:?}], radius: 2, height: 2, caps: {}, {GLOW} }});",
                caps == 1
            );
            let got = ahead(&format!("{maker}-cap"), "", &shape);
            match hit {
                // The cap faces the eye.
                Some(t) => within(got, grey(1.0 / t), HIT),
                // The body does, near its tip: before the cap in z = -2.
                None => assert!(got[0] > 1.0 / 3.0 && got[0] <= 1.0, "{maker}: {got:?}"),
            }
        }
    }
    let bell = |caps: bool| {
        format!(
            "hyperboloid(#{{ center: [0, 0, -3], axis: [0, 0, 1], radius: 2, waist: 1, height: 2, caps: {caps}, {GLOW} }});"
        )
    };
    within(ahead("bell", "", &bell(true)), grey(1.0 / 2.0), HIT);
    assert_eq!(ahead("bell-open", "", &bell(false)), Vec3::ZERO);
}

#[test]
fn a_cone_is_seen_along_its_axis() {
    // Its tip in the middle of the window, opening away from the eye at 2: the ray through a point
    // of the window at rho from the middle meets it at the depth s with rho (2 + s) / 2 = s.
    let n = 33;
    let cone = |caps: bool| {
        format!(
            "light(#{{ at: [0, 0, 2], emissivity: 1, falloff: \"none\" }});
cone(#{{ apex: [0, 0, 0], axis: [0, 0, -2], radius: 1, height: 1, caps: {caps}, material: material(#{{ diffuse: 1 }}) }});"
        )
    };
    for caps in [false, true] {
        let picture = classic("cone-along", n, 4.0, &cone(caps)).picture;
        for (i, got) in picture.pixels.iter().enumerate() {
            let at = |i: usize| (i as f64 + 0.5) * 4.0 / n as f64 - 2.0;
            let (x, y) = (at(i % n), at(i / n));
            let rho = x.hypot(y);
            assert!(got.is_finite(), "({x}, {y}): {got:?}");
            // No tolerance: the picture's own pixels keep clear of the border between lit and dark,
            // by far more than f32 rounds (1e-7), so that which side each is on is certain.
            assert!((rho - 2.0 / 3.0).abs() > 1e-3, "a pixel in doubt");
            if rho == 0.0 {
                // The tip itself has no normal: any cosine will do.
                continue;
            }
            let s = rho / (1.0 - rho / 2.0);
            // The normal leans by 45 degrees, from the axis outward; the light is at the eye.
            let way = v3(-s, 0.0, 2.0 + s).unit();
            let cos = way.dot(v3(1.0, 0.0, 1.0).unit());
            let want = if rho < 2.0 / 3.0 { cos } else { 0.0 };
            assert!(
                relative_error(grey(want), *got) <= RIGHT_WITHIN,
                "({x}, {y}): {got:?}, {want}"
            );
        }
    }
}

#[test]
fn a_cone_has_one_nappe() {
    let things =
        format!("cone(#{{ apex: [0, 0, 0], axis: [0, 1, 0], radius: 1, height: 1, {GLOW} }});");
    let picture = classic("nappe", 16, 4.0, &things).picture;
    let lit = |rows: std::ops::Range<usize>| {
        picture.pixels[rows.start * 16..rows.end * 16].iter().filter(|p| **p != Vec3::ZERO).count()
    };
    assert!(lit(0..8) > 10, "{}", lit(0..8));
    assert_eq!(lit(8..16), 0, "below its tip there is nothing");
}

#[test]
fn a_torus_is_seen_through_its_hole_and_from_inside() {
    let ring = |z: f64, axis: &str, specular: f64| {
        format!(
            "torus(#{{ center: [0, 0, {z:?}], axis: {axis}, major: 1, minor: 0.25, material: material(#{{ ambient: 1, specular: {specular:?} }}) }});"
        )
    };
    let seen = |name: &str, ring: &str| ahead(name, "max_bounces: 2, background: 8", ring);
    assert_eq!(seen("hole", &ring(-1.0, "[0, 0, 2]", 0.5)), grey(8.0));
    // Across its axis: the tube is 0.75 ahead, and mirrors what is behind the eye.
    within(seen("across", &ring(-1.0, "[0, 1, 0]", 0.5)), grey(1.0 / 0.75 + 4.0), HIT);
    // The eye is inside of the tube, whose walls are 0.5 apart.
    within(seen("in-tube", &ring(0.0, "[0, 1, 0]", 0.5)), series(0.25, 0.5, 3), 4.0 * HIT);
    // The eye is in the hole: from z = 1 to the inner wall at z = -0.75 + 1, and to the other side.
    let around = ring(0.75, "[0, 1, 0]", 0.5);
    within(seen("in-hole", &around), series(1.0, 1.5, 3), 4.0 * HIT);
}

#[test]
fn rays_that_touch_are_finite() {
    // Each passes the middle of the picture at a distance that is its own radius.
    for (name, shape) in [
        ("cylinder", "cylinder(#{ base: [1, -1, -2], axis: [0, 1, 0], radius: 1, height: 2"),
        ("paraboloid", "paraboloid(#{ vertex: [0, 0, -2], axis: [1, 0, 0], radius: 1, height: 1"),
        (
            "hyperboloid",
            "hyperboloid(#{ center: [1, 0, -2], axis: [0, 1, 0], waist: 1, radius: 2, height: 1",
        ),
        ("ellipsoid", "ellipsoid(#{ center: [1, 0, -2], radii: [1, 2, 3]"),
        ("torus", "torus(#{ center: [1.25, 0, -2], axis: [0, 1, 0], major: 1, minor: 0.25"),
        ("cuboid", "cuboid(#{ min: [0, 0, -3], max: [1, 1, -2]"),
        ("disc", "disc(#{ center: [1, 0, -2], normal: [0, 0, 1], radius: 1"),
        ("cone", "cone(#{ apex: [0, 0, -2], axis: [0, 1, 0], radius: 1, height: 1"),
        // Along the wall itself.
        ("wall", "cylinder(#{ base: [1, 0, -3], axis: [0, 0, 1], radius: 1, height: 2"),
        ("slope", "cone(#{ apex: [0, 0, 0], axis: [1, 0, -1], radius: 1, height: 1"),
    ] {
        let things = format!(
            "light(#{{ at: [-4, 3, 5], emissivity: 5 }});
{shape}, material: material(#{{ ambient: 0.5, diffuse: 1, specular: 0.5 }}) }});"
        );
        let got = ahead(&format!("touch-{name}"), "", &things);
        assert!(got.is_finite() && got[0] < 8.0, "{name}: {got:?}");
    }
}

#[test]
fn both_ways_to_write_a_cuboid_are_one() {
    let seen = |name: &str, keys: &str| {
        let things = format!(
            "light(#{{ at: [1, 2, 4], emissivity: 9 }});
cuboid(#{{ {keys}, material: material(#{{ ambient: 0.2, diffuse: 1 }}) }});"
        );
        classic(name, 16, 4.0, &things).picture.pixels
    };
    let min_max = seen("cuboid-min", "min: [-1, -0.5, -3], max: [1, 1.5, -1]");
    assert_eq!(min_max, seen("cuboid-center", "center: [0, 0.5, -2], size: [2, 2, 2]"));
    // A corner of a box may be written first, but the face ahead of the eye is at its own place.
    let dice = format!("cuboid(#{{ min: [-1, -1, -4], max: [1, 1, -2], {HALF_MIRROR} }});");
    within(ahead("dice", "background: 8", &dice), grey(1.0 / 3.0 + 4.0), HIT);
    let room = format!("cuboid(#{{ center: [0, 0, 0], size: [4, 4, 6], {HALF_MIRROR} }});");
    within(ahead("room", "max_bounces: 3", &room), series(4.0, 6.0, 4), 4.0 * HIT);
}

#[test]
fn instances_of_instances() {
    // Out of the picture stands a ball; its copy at x = 3, too; the copy of the copy is twice as
    // large, at z = -3 right ahead: 3 away.
    let things = format!(
        "let ball = sphere(#{{ center: [0, 0, 0], radius: 0.5, visible: false, {GLOW} }});
let copy = instance(ball, #{{ translate: [3, 0, 0] }});
let large = instance(copy, #{{ translate: [-6, 0, -3], scale: 2 }});
copy.visible = false;"
    );
    within(ahead("copies", "background: 8", &things), grey(1.0 / 3.0), HIT);
    // What is written to the original shows in its copies.
    let grown = format!("{things}\nball.radius = 1;");
    within(ahead("grown", "background: 8", &grown), grey(1.0 / 2.0), HIT);
    let hidden = format!("{things}\nlarge.visible = false;");
    assert_eq!(ahead("copies-hidden", "background: 8", &hidden), grey(8.0));
}

#[test]
fn groups_move_and_hide_their_members() {
    // Turned by 90 degrees about y, what was at x = 2 is at z = -2; the group within it does its
    // own part first: the ball at (1, 0, 0) times 2 is at x = 2.
    let things = |extra: &str| {
        format!(
            "let ball = sphere(#{{ center: [1, 0, 0], radius: 0.25, {GLOW} }});
let inner = group([ball], #{{ scale: 2 }});
let outer = group([inner], #{{ rotate: [0, 90, 0] }});
{extra}"
        )
    };
    let seen = |name: &str, extra: &str| ahead(name, "background: 8", &things(extra));
    within(seen("groups", ""), grey(1.0 / 2.5), HIT);
    within(seen("groups-moved", "outer.translate = [0, 0, -1];"), grey(1.0 / 3.5), HIT);
    for hide in ["ball", "inner", "outer"] {
        assert_eq!(seen("groups-hidden", &format!("{hide}.visible = false;")), grey(8.0));
    }
    // About x, then y: y goes to z, then to x; the other order would leave it at z.
    let order = format!(
        "group([sphere(#{{ center: [0, 2, 0], radius: 0.5, {GLOW} }})], #{{ rotate: [90, 90, 0], translate: [-2, 0, -1] }});"
    );
    within(ahead("order", "background: 8", &order), grey(1.0 / 1.5), HIT);
}

#[test]
fn a_negative_scale_mirrors() {
    let even = "material(#{ ambient: [1, 0, 0] })";
    let odd = "material(#{ ambient: [0, 1, 0] })";
    let flag = format!(
        "let tiles = checker(#{{ even: {even}, odd: {odd}, size: [1, 9] }});
group([quad(#{{ corner: [0, 0, 0], u: [2, 0, 0], v: [0, 2, 0], material: tiles }})], #{{ scale: [-1, 1, 1] }});"
    );
    let picture = classic("mirrored", 4, 4.0, &flag).picture;
    let row: Vec<Vec3> = (0..4).map(|x| picture.at(x, 0)).collect();
    assert_eq!(row, [v3(0.0, 1.0, 0.0), v3(1.0, 0.0, 0.0), Vec3::ZERO, Vec3::ZERO]);
    // A ball inside out is a ball: lit from outside, and its inside mirrors itself.
    let ball = |scale: &str, z: i32| {
        format!(
            "light(#{{ at: [0, 0, 1], emissivity: 2, falloff: \"none\" }});
group([sphere(#{{ center: [0, 0, 0], radius: 1, material: material(#{{ diffuse: 0.5, specular: 0.5 }}) }})],
    #{{ translate: [0, 0, {z}], scale: {scale} }});"
        )
    };
    for scale in ["[-1, 1, 1]", "-1", "[1, 1, -1]", "[1, -1, -1]"] {
        let lit = ahead("inside-out", "attenuation: \"none\", background: 8", &ball(scale, -2));
        within(lit, grey(1.0 + 4.0), 2.0 * HIT);
    }
    // The eye and the light at z = 1 are within a ball of radius 2: each wall has cos 1.
    let within_ball =
        ahead("inside-out-inside", "attenuation: \"none\", max_bounces: 1", &ball("-2", 0));
    within(within_ball, grey(1.0 + 0.5), 3.0 * HIT);
}

#[test]
fn a_stretched_ball_is_an_ellipsoid() {
    let seen = |name: &str, shape: &str| {
        let things = format!(
            "light(#{{ at: [3, 4, 2], emissivity: 40 }});
let m = material(#{{ ambient: 0.1, diffuse: 1 }});
{shape}"
        );
        classic(name, 24, 4.0, &things).picture
    };
    let ellipsoid = seen(
        "stretched",
        "ellipsoid(#{ center: [0.5, 0, -2], radii: [1.5, 0.75, 1], material: m });",
    );
    let ball = seen(
        "stretched-ball",
        "instance(sphere(#{ center: [0, 0, 0], radius: 0.5, material: m, visible: false }),
    #{ translate: [0.5, 0, -2], scale: [3, 1.5, 2] });",
    );
    let off = |(a, b): (&Vec3, &Vec3)| relative_error(*a, *b) > RIGHT_WITHIN;
    let differ = ellipsoid.pixels.iter().zip(&ball.pixels).filter(|pair| off(*pair)).count();
    assert_eq!(differ, 0);
    assert!(ellipsoid.pixels.iter().filter(|p| **p != Vec3::ZERO).count() > 20);
}

#[test]
fn an_orthographic_picture_has_no_perspective() {
    // 4 high and 8 wide: a pixel is 1 x 1, and a wall of 3 x 1 fills three of them at any distance.
    for z in [0, -3, -63] {
        let script = format!(
            "image(#{{ width: 8, height: 4 }});
camera(#{{ eye: [0, 0, 1], look_at: [0, 0, 0], ortho: 4 }});
quad(#{{ corner: [-2, 1, {z}], u: [3, 0, 0], v: [0, 1, 0], {GLOW} }});"
        );
        let picture = rendered("ortho", &script).picture;
        for (i, got) in picture.pixels.iter().enumerate() {
            let want = if (2..5).contains(&i) { 1.0 / f64::from(1 - z) } else { 0.0 };
            within(*got, grey(want), 2.0);
        }
    }
}
