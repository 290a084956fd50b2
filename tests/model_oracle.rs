//! The oracle's own sanity: hand-computed values, and that its comparison can fail.

mod oracle;

use oracle::compare::compare;
use oracle::families;
use oracle::filter::PixelFilter;
use oracle::pattern::tile;
use oracle::recursion::{Ray, Stage, raytrace, times};
use oracle::scene::{Attenuation, Camera, Checker, Scene, Shape, Wears};
use oracle::script::{number, script};
use oracle::vec3::{Vec3, v3};
use oracle::view::{picture, sample_positions, stable};

const X: Vec3 = v3(1.0, 0.0, 0.0);
const Y: Vec3 = v3(0.0, 1.0, 0.0);
const Z: Vec3 = v3(0.0, 0.0, 1.0);

fn grey(x: f64) -> Vec3 {
    Vec3::splat(x)
}

/// Hand values are sums and quotients of a few small numbers: a few roundings of an f64.
fn near(got: Vec3, want: Vec3) {
    assert!((got - want).largest() <= 1e-14 * want.largest().max(1.0), "{got:?} is not {want:?}");
}

/// One pixel, straight ahead.
fn one_pixel(eye: Vec3, look_at: Vec3) -> Scene {
    Scene::empty(1, 1, eye, look_at)
}

#[test]
fn a_sphere_head_on() {
    // The eye is 5 from the center, so 4 from the surface; the light is at the eye, so cos is 1
    // and r is 4: (0.5 + 2 * 6 * 1 / 4) / 4.
    let mut s = one_pixel(Z * 5.0, Vec3::ZERO);
    let matt = s.material(v3(0.5, 0.0, 0.0), v3(2.0, 1.0, 0.0), Vec3::ZERO);
    s.surface(Shape::Sphere { center: Vec3::ZERO, radius: 1.0 }, matt);
    s.light(Z * 5.0, grey(6.0));
    near(picture(&s).at(0, 0), v3(3.5 / 4.0, 1.5 / 4.0, 0.0));
}

#[test]
fn two_facing_mirrors() {
    // From z = 1 to the mirror at 0, then to and fro over a gap of 3: a sum of 0.5^k / (1 + 3 k).
    let mut s = one_pixel(Z, Vec3::ZERO);
    let mirror = s.material(grey(1.0), Vec3::ZERO, grey(0.5));
    s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, mirror);
    s.surface(Shape::Plane { point: Z * 3.0, normal: Z }, mirror);
    s.settings.max_bounces = 3;
    let want = 1.0 + 0.5 / 4.0 + 0.25 / 7.0 + 0.125 / 10.0;
    near(picture(&s).at(0, 0), grey(want));
}

#[test]
fn a_ball_from_inside() {
    // From the center of a ball of radius 2: hits at 2, 2 + 4 and 2 + 8, each with cos 1, r 2.
    let mut s = one_pixel(Vec3::ZERO, X);
    let shell = s.material(Vec3::ZERO, grey(1.0), grey(0.5));
    s.surface(Shape::Sphere { center: Vec3::ZERO, radius: 2.0 }, shell);
    s.light(Vec3::ZERO, grey(4.0));
    s.settings.max_bounces = 2;
    near(picture(&s).at(0, 0), grey(2.0 / 2.0 + 0.5 * (2.0 / 6.0 + 0.5 * (2.0 / 10.0))));
    // A light outside is hidden by the far side.
    s.lights[0].at = X * -3.0;
    near(picture(&s).at(0, 0), Vec3::ZERO);
}

#[test]
fn a_light_behind_a_wall_or_behind_the_surface() {
    let mut s = one_pixel(Z * 2.0, Vec3::ZERO);
    let matt = s.material(Vec3::ZERO, grey(1.0), Vec3::ZERO);
    s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, matt);
    s.light(v3(3.0, 0.0, 4.0), grey(10.0));
    // r = 5, cos = 4 / 5, total_dist = 2.
    near(picture(&s).at(0, 0), grey(10.0 * 0.8 / 5.0 / 2.0));
    s.lights[0].at = v3(3.0, 0.0, -4.0);
    near(picture(&s).at(0, 0), Vec3::ZERO);
    s.lights[0].at = v3(3.0, 0.0, 4.0);
    // On the way from the origin to the light, at (1.5, 0, 2).
    s.surface(Shape::Sphere { center: v3(1.5, 0.0, 2.0), radius: 0.1 }, matt);
    near(picture(&s).at(0, 0), Vec3::ZERO);
    // Beyond the light it hides nothing.
    s.surfaces[1].shape = Shape::Sphere { center: v3(4.5, 0.0, 6.0), radius: 0.1 };
    near(picture(&s).at(0, 0), grey(0.8));
}

#[test]
fn a_miss_and_a_cut_path() {
    let mut s = one_pixel(Z, Vec3::ZERO);
    s.settings.background = v3(0.25, 0.5, 1.0);
    near(picture(&s).at(0, 0), v3(0.25, 0.5, 1.0));
    let mirror = s.material(grey(1.0), Vec3::ZERO, v3(2.0, 0.0, 1.0));
    s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, mirror);
    near(picture(&s).at(0, 0), v3(1.5, 1.0, 2.0));
    // The path is 1 long when the mirrored ray is cast: not longer than 1, but longer than 0.75.
    s.settings.max_path = 1.0;
    near(picture(&s).at(0, 0), v3(1.5, 1.0, 2.0));
    s.settings.max_path = 0.75;
    near(picture(&s).at(0, 0), grey(1.0));
}

#[test]
fn a_spotlight_ends_at_its_half_width() {
    let mut s = one_pixel(Z * 2.0, Vec3::ZERO);
    s.settings.attenuation = Attenuation::None;
    let matt = s.material(Vec3::ZERO, grey(1.0), Vec3::ZERO);
    s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, matt);
    // The light at (3, 0, 4) looks straight down; the origin is 36.87 degrees off its axis.
    s.spotlight(v3(3.0, 0.0, 4.0), v3(3.0, 0.0, 0.0), 36.8, grey(5.0));
    near(picture(&s).at(0, 0), Vec3::ZERO);
    s.lights[0].cone.as_mut().expect("a spotlight").half_width_degrees = 36.9;
    near(picture(&s).at(0, 0), grey(0.8));
}

#[test]
fn quads_and_triangles_end_at_their_edges() {
    let quad = Shape::Quad { corner: v3(-1.0, -1.0, 0.0), u: X * 2.0, v: v3(1.0, 2.0, 0.0) };
    let triangle = Shape::Triangle { a: -X, b: X, c: Y };
    let hit = |shape: Shape, x: f64, y: f64| {
        let mut s = one_pixel(Z, Vec3::ZERO);
        let glow = s.material(grey(1.0), Vec3::ZERO, Vec3::ZERO);
        s.surface(shape, glow);
        raytrace(&Stage::of(&s), Ray::of_eye(v3(x, y, 3.0), -Z)) != Vec3::ZERO
    };
    // The left edge of the quad runs from (-1, -1) to (0, 1), its right edge from (1, -1) to (2, 1).
    assert!(hit(quad, -0.49, 0.0) && !hit(quad, -0.51, 0.0));
    assert!(hit(quad, 1.49, 0.0) && !hit(quad, 1.51, 0.0));
    assert!(hit(quad, 1.9, 0.99) && !hit(quad, 1.9, 1.01));
    assert!(hit(triangle, 0.49, 0.5) && !hit(triangle, 0.51, 0.5));
    assert!(hit(triangle, -0.49, 0.5) && !hit(triangle, 0.0, -0.01));
}

#[test]
fn tiles_have_one_width_everywhere() {
    let floor = Shape::Plane { point: Y, normal: Y * 3.0 };
    // x leans out of the plane; what is left of it is the x axis, and y = normal x x = -z.
    let checker = Checker { even: 0, odd: 1, size: [2.0, 0.5], xdir: v3(5.0, 1.0, 0.0) };
    let at = |x: f64, z: f64| tile(&floor, &checker, v3(x, 1.0, z));
    assert_eq!([at(-3.9, -0.1), at(-2.1, -0.1)], [0, 0]);
    assert_eq!([at(-1.9, -0.1), at(-0.1, -0.1)], [1, 1]);
    assert_eq!([at(0.1, -0.1), at(1.9, -0.1)], [0, 0]);
    assert_eq!([at(2.1, -0.1), at(0.1, -0.6)], [1, 1]);
    assert_eq!([at(0.1, 0.1), at(0.1, 0.4), at(0.1, 0.6)], [1, 1, 0]);
    // Of the quad u x v: turned the other way, y turns too.
    let checker = Checker { size: [1.0, 1.0], xdir: X, ..checker };
    let quad = |u, v| Shape::Quad { corner: Vec3::ZERO, u, v };
    assert_eq!(tile(&quad(X * 4.0, Y * 4.0), &checker, v3(0.5, 0.5, 0.0)), 0);
    assert_eq!(tile(&quad(Y * 4.0, X * 4.0), &checker, v3(0.5, 0.5, 0.0)), 1);
}

#[test]
fn the_two_cameras() {
    // Both look down -z with the same rays: at distance 2 the window is 4 x 2.
    let mut s = Scene::empty(8, 4, Z * 2.0, Vec3::ZERO);
    let (even, odd) = (
        s.material(grey(1.0), Vec3::ZERO, Vec3::ZERO),
        s.material(grey(3.0), grey(0.0), grey(0.0)),
    );
    let (Wears::Material(even), Wears::Material(odd)) = (even, odd) else { unreachable!() };
    s.checkers.push(Checker { even, odd, size: [0.7, 0.9], xdir: X });
    s.surface(Shape::Plane { point: v3(0.1, 0.2, -1.0), normal: Z }, Wears::Checker(0));
    s.camera = Camera::Window { viewpoint: Z * 2.0, window: [4.0, 2.0] };
    let classic = picture(&s);
    let fov_degrees = 2.0 * 0.5f64.atan().to_degrees();
    s.camera = Camera::LookAt { eye: Z * 2.0, look_at: -Z, up: Y, fov_degrees };
    let modern = picture(&s);
    for (a, b) in classic.pixels.iter().zip(&modern.pixels) {
        near(*a, *b);
    }
    // Pixel (0, 0) goes through (-1.75, 0.75, 0) and meets the plane at (-2.625, 1.125, -1):
    // tile (-4, 1), an odd one.
    near(classic.at(0, 0), grey(3.0 / v3(2.625, 1.125, 3.0).length()));
}

#[test]
fn samples_are_the_means_of_their_positions() {
    for filter in PixelFilter::ALL {
        assert_eq!(sample_positions(1, filter), [(0.5, 0.5)]);
    }
    // Two lie at 0.5 and 0.2549 (downward 0.5 and 0.0698) before they are centred.
    let two = sample_positions(2, PixelFilter::Box);
    let want =
        [(0.6225611668766536, 0.7150798545009734), (0.37743883312334635, 0.2849201454990266)];
    for ((a, b), (x, y)) in two.into_iter().zip(want) {
        assert!((a - x).abs() < 1e-15 && (b - y).abs() < 1e-15, "{a} {b}");
    }
    // A wall that glows left of x = 0.5, seen so that the one pixel spans x from -1 to 1: of the
    // four samples at a = 0.6177, 0.3726, 0.1274, 0.8823 the first three have x = 2 a - 1 below it.
    let mut s = one_pixel(Z, Vec3::ZERO);
    s.settings.attenuation = Attenuation::None;
    s.camera = Camera::Window { viewpoint: Z, window: [2.0, 2.0] };
    let glow = s.material(grey(1.0), Vec3::ZERO, Vec3::ZERO);
    let corner = v3(-9.0, -9.0, 0.0);
    s.surface(Shape::Quad { corner, u: X * 9.5, v: Y * 18.0 }, glow);
    s.samples = 4;
    near(picture(&s).at(0, 0), grey(0.75));
}

#[test]
fn filters_spread_the_positions() {
    // Of a tent from -1 to 1, 1/8 lies below -1/2 and 7/8 below 1/2, and 1/32 below -3/4; of a gaussian
    // cut at two sigma = 1, 68.268949 of 95.449974 parts lie within sigma = 1/2.
    let within = |got: f64, want: f64, bound: f64| assert!((got - want).abs() < bound, "{got}");
    for (u, place) in [(0.125, 0.0), (0.5, 0.5), (0.875, 1.0), (1.0 / 32.0, -0.25)] {
        within(PixelFilter::Tent.place(u), place, 1e-11);
    }
    let outside = (1.0 - 0.68268949 / 0.95449974) / 2.0;
    within(PixelFilter::Gaussian.place(outside), 0.0, 1e-7);
    within(PixelFilter::Gaussian.place(1.0 - outside), 1.0, 1e-7);
    for u in [0.0, 0.3, 0.99] {
        within(PixelFilter::Box.place(u), u, 1e-11);
    }
}

#[test]
fn zero_times_anything_is_zero() {
    assert_eq!(times(0.0, f64::INFINITY), 0.0);
    assert_eq!(times(f64::NAN, -0.0), 0.0);
    assert_eq!(times(2.0, 3.0), 6.0);
}

#[test]
fn numbers_parse_back() {
    for x in [0.1, -0.0, 1e38, 1e-30, 1.0 / 3.0, -2.0, f64::from(0.1f32)] {
        let text = number(x);
        assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(x.to_bits()), "{text}");
        assert!(text.contains('.') && !text.contains('e'), "{text}");
    }
}

#[test]
fn a_scene_is_a_function_of_its_seed() {
    let twice = |seed| [0, 1].map(|_| script(&(families::DENSE.scene)(seed)));
    assert_eq!(twice(3)[0], twice(3)[1]);
    assert_ne!(twice(3)[0], twice(4)[0]);
}

#[test]
fn the_comparison_can_fail() {
    let scene = (families::DENSE.scene)(7);
    let want = picture(&scene);
    assert!(compare(&scene, &want, &want).is_ok());
    let mask = stable(&scene, &want);
    let stable: Vec<usize> = (0..mask.len()).filter(|i| mask[*i]).collect();
    // One stable pixel in 1728 may be wrong, two may not; and none may be non-finite.
    let mut got = want.clone();
    got.pixels[stable[5]] += grey(0.1);
    assert!(compare(&scene, &want, &got).is_ok());
    got.pixels[stable[9]] += grey(0.1);
    let report = compare(&scene, &want, &got).expect_err("two wrong pixels");
    assert!(report.contains("wrong: 2"), "{report}");
    let mut got = want.clone();
    got.pixels[stable[5]].0[1] = f64::NAN;
    assert!(compare(&scene, &want, &got).is_err());
    let other = picture(&(families::DENSE.scene)(8));
    assert!(compare(&scene, &want, &other).is_err());
}
