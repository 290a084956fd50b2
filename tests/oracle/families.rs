//! Random scenes, by kind. Each is a pure function of its seed.

use super::draw::{Draw, Rounding, normal_of};
use super::filter::PixelFilter;
use super::scene::{Attenuation, Camera, Scene, Shape, Wears};
use super::vec3::{Vec3, v3};

pub const WIDTH: usize = 48;
pub const HEIGHT: usize = 36;

/// A kind of scene: its name, its generator.
#[derive(Clone, Copy)]
pub struct Family {
    pub name: &'static str,
    pub scene: fn(u64) -> Scene,
}

pub const SPARSE: Family = Family { name: "sparse", scene: sparse };
pub const DENSE: Family = Family { name: "dense", scene: dense };
pub const ROOM: Family = Family { name: "room", scene: room };
pub const BALL: Family = Family { name: "ball", scene: ball };
pub const WINDOW: Family = Family { name: "window", scene: window };
pub const GRAZING: Family = Family { name: "grazing", scene: grazing };
pub const PATTERNS: Family = Family { name: "patterns", scene: patterns };
pub const FACING: Family = Family { name: "facing", scene: facing };
pub const SETTINGS: Family = Family { name: "settings", scene: settings };
pub const SAMPLES: Family = Family { name: "samples", scene: samples };

pub fn draw_of(seed: u64) -> Draw {
    let rounding = [Rounding::Single, Rounding::Decimal, Rounding::Dyadic][(seed % 3) as usize];
    Draw::new(seed, rounding)
}

/// The stage of most families: a box over the floor, seen from the front.
pub const LOW: Vec3 = v3(-3.5, 0.4, -4.0);
pub const HIGH: Vec3 = v3(3.5, 3.2, 2.0);

pub fn staged(d: &mut Draw) -> Scene {
    let eye = v3(d.range(-3.0, 3.0), d.range(0.6, 4.5), d.range(6.0, 9.0));
    let look_at = d.point(v3(-1.0, 0.5, -1.5), v3(1.0, 1.8, 0.5));
    let mut scene = Scene::empty(WIDTH, HEIGHT, eye, look_at);
    let tilt = d.range(-0.3, 0.3);
    let fov_degrees = d.range(25.0, 75.0);
    scene.camera = Camera::LookAt { eye, look_at, up: v3(tilt, 1.0, 0.1), fov_degrees };
    scene.settings.max_bounces = d.int(0, 6);
    scene
}

pub fn key_light(d: &mut Draw, scene: &mut Scene) {
    let at = d.point(v3(-6.0, 4.0, -1.0), v3(6.0, 8.0, 7.0));
    let emissivity = d.colour(15.0, 90.0);
    scene.light(at, emissivity);
}

fn ceiling_spot(d: &mut Draw, scene: &mut Scene) {
    let at = d.point(v3(-3.0, 5.0, -3.0), v3(3.0, 8.0, 3.0));
    let aim = d.point(v3(-2.0, 0.0, -3.0), v3(2.0, 1.0, 2.0));
    let (angle, emissivity) = (d.range(8.0, 50.0), d.colour(20.0, 90.0));
    scene.spotlight(at, aim, angle, emissivity);
}

pub fn floor(d: &mut Draw, scene: &mut Scene) {
    let normal = v3(d.range(-0.1, 0.1), d.range(0.5, 2.0), d.range(-0.1, 0.1));
    let point = v3(d.range(-1.0, 1.0), 0.0, d.range(-1.0, 1.0));
    let wears =
        if d.chance(60) { d.checker(scene, normal, 0.4, 1.8) } else { d.material(scene, 40) };
    scene.surface(Shape::Plane { point, normal }, wears);
}

/// One to four spheres, perhaps a floor, one light.
fn sparse(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    key_light(&mut d, &mut scene);
    if d.chance(70) {
        floor(&mut d, &mut scene);
    }
    for _ in 0..d.int(1, 4) {
        let ball = d.sphere(LOW, HIGH, [0.4, 1.6]);
        let wears = d.material(&mut scene, 60);
        scene.surface(ball, wears);
    }
    scene
}

/// Up to two dozen spheres, a wall, a flag, three lights.
fn dense(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    key_light(&mut d, &mut scene);
    key_light(&mut d, &mut scene);
    ceiling_spot(&mut d, &mut scene);
    let palette: Vec<Wears> = (0..8).map(|_| d.material(&mut scene, 60)).collect();
    for _ in 0..d.int(8, 24) {
        let ball = d.sphere(LOW, HIGH, [0.3, 0.9]);
        scene.surface(ball, palette[d.int(0, 7)]);
    }
    floor(&mut d, &mut scene);
    for _ in 0..d.int(0, 3) {
        let wall = d.quad(v3(-5.0, 0.0, -7.0), v3(2.0, 1.0, -3.0), [2.0, 6.0]);
        scene.surface(wall, palette[d.int(0, 7)]);
        let flag = d.triangle(LOW, HIGH, [0.8, 3.0]);
        scene.surface(flag, palette[d.int(0, 7)]);
    }
    scene
}

/// A closed room of six quads with things in it; the eye and the lights are inside.
fn room(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let (w, h, l) = (d.range(3.0, 5.0), d.range(2.5, 4.0), d.range(3.0, 6.0));
    let eye = d.point(v3(-0.6 * w, 0.3 * h, 0.5 * l), v3(0.6 * w, 0.8 * h, 0.9 * l));
    let look_at = d.point(v3(-1.0, 0.5, -1.0), v3(1.0, 1.5, 0.0));
    let mut scene = Scene::empty(WIDTH, HEIGHT, eye, look_at);
    let fov_degrees = d.range(40.0, 90.0);
    scene.camera = Camera::LookAt { eye, look_at, up: v3(0.0, 1.0, 0.0), fov_degrees };
    scene.settings.max_bounces = d.int(1, 5);
    for _ in 0..d.int(1, 3) {
        let at = d.point(v3(-0.8 * w, 0.5 * h, -0.8 * l), v3(0.8 * w, 0.95 * h, 0.8 * l));
        let emissivity = d.colour(4.0, 20.0);
        scene.light(at, emissivity);
    }
    let (x, y, z) = (v3(2.0 * w, 0.0, 0.0), v3(0.0, h, 0.0), v3(0.0, 0.0, 2.0 * l));
    let near = v3(-w, 0.0, -l);
    // Some walls show their back: the normal turns to whoever looks.
    for (corner, u, v) in [
        (near, z, x),
        (near + y, x, z),
        (near, x, y),
        (near + z, x, y),
        (near, y, z),
        (near + x, z, y),
    ] {
        let wall = Shape::Quad { corner, u, v };
        let wears = if d.chance(40) {
            d.checker(&mut scene, u.cross(v), 0.5, 2.0)
        } else {
            d.material(&mut scene, 50)
        };
        scene.surface(wall, wears);
    }
    for _ in 0..d.int(1, 6) {
        let ball = d.sphere(v3(-0.7 * w, 0.3, -0.7 * l), v3(0.7 * w, 0.7 * h, 0.3 * l), [0.3, 0.8]);
        let wears = d.material(&mut scene, 60);
        scene.surface(ball, wears);
    }
    scene
}

/// Inside a mirrored sphere, with smaller ones in it.
fn ball(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let center = d.point(Vec3::splat(-0.5), Vec3::splat(0.5));
    let radius = d.range(3.0, 4.5);
    let eye = v3(d.range(-0.6, 0.6), d.range(-0.6, 0.6), d.range(1.2, 2.0));
    let look_at = d.point(Vec3::splat(-0.4), Vec3::splat(0.4));
    let mut scene = Scene::empty(WIDTH, HEIGHT, eye, look_at);
    let fov_degrees = d.range(50.0, 100.0);
    scene.camera = Camera::LookAt { eye, look_at, up: v3(0.1, 1.0, 0.0), fov_degrees };
    scene.settings.max_bounces = d.int(1, 6);
    // In some the light stands outside, and the shell shadows its own inside.
    let reach = if d.chance(20) { 2.0 * radius } else { 1.6 };
    for _ in 0..d.int(1, 2) {
        let at = d.vector(reach);
        let emissivity = d.colour(6.0, 25.0);
        scene.light(at, emissivity);
    }
    let specular = d.specular(0.3, 0.9);
    let (ambient, diffuse) = (d.colour(0.0, 0.2), d.colour(0.1, 0.8));
    let shell = scene.material(ambient, diffuse, specular);
    scene.surface(Shape::Sphere { center, radius }, shell);
    for _ in 0..d.int(0, 3) {
        let core = d.sphere(v3(-1.5, -1.5, -1.8), v3(1.5, 1.5, 0.2), [0.2, 0.8]);
        let wears = d.material(&mut scene, 40);
        scene.surface(core, wears);
    }
    scene
}

/// The classic view: the window at z = 0, with things on both sides of it.
fn window(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let viewpoint = v3(d.range(-1.0, 1.0), d.range(-1.0, 1.5), d.range(2.5, 6.0));
    let mut scene = Scene::empty(WIDTH, HEIGHT, viewpoint, Vec3::ZERO);
    scene.camera = Camera::Window { viewpoint, window: [d.range(3.0, 9.0), d.range(2.5, 7.0)] };
    scene.settings.max_bounces = d.int(0, 6);
    for _ in 0..d.int(1, 3) {
        let at = d.point(v3(-5.0, 1.0, -4.0), v3(5.0, 7.0, 6.0));
        let emissivity = d.colour(15.0, 90.0);
        scene.light(at, emissivity);
    }
    if d.chance(60) {
        let ground = Shape::Plane { point: v3(0.0, -2.5, 0.0), normal: v3(0.0, 1.0, 0.0) };
        let wears = d.checker(&mut scene, normal_of(&ground), 0.6, 2.0);
        scene.surface(ground, wears);
    }
    for _ in 0..d.int(2, 9) {
        let ball = d.sphere(v3(-4.0, -2.0, -8.0), v3(4.0, 2.5, 0.4), [0.3, 1.3]);
        let wears = d.material(&mut scene, 60);
        scene.surface(ball, wears);
    }
    let flag = d.triangle(v3(-3.0, -2.0, -7.0), v3(2.0, 1.0, -2.0), [1.0, 3.0]);
    let wears = d.material(&mut scene, 50);
    scene.surface(flag, wears);
    scene
}

/// Spotlights that graze walls and floors.
fn grazing(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    floor(&mut d, &mut scene);
    let wall = Shape::Quad {
        corner: v3(-6.0, 0.0, d.range(-6.0, -4.0)),
        u: v3(12.0, 0.0, d.range(-1.0, 1.0)),
        v: v3(0.0, d.range(4.0, 7.0), 0.0),
    };
    let wears = d.material(&mut scene, 50);
    scene.surface(wall, wears);
    for _ in 0..d.int(1, 4) {
        // Low over the floor, and aimed along it.
        let at = d.point(v3(-6.0, 0.1, -4.0), v3(6.0, 0.8, 5.0));
        let aim = d.point(v3(-2.0, 0.0, -5.0), v3(2.0, 1.2, 1.0));
        let (angle, emissivity) = (d.range(3.0, 85.0), d.colour(20.0, 120.0));
        scene.spotlight(at, aim, angle, emissivity);
    }
    for _ in 0..d.int(1, 6) {
        let ball = d.sphere(LOW, HIGH, [0.3, 1.0]);
        let wears = d.material(&mut scene, 40);
        scene.surface(ball, wears);
    }
    scene
}

/// Checkers with odd x directions on planes, quads and triangles.
fn patterns(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    key_light(&mut d, &mut scene);
    key_light(&mut d, &mut scene);
    floor(&mut d, &mut scene);
    for i in 0..d.int(3, 8) {
        let flat = if i % 2 == 0 {
            d.quad(LOW, HIGH, [1.0, 4.0])
        } else {
            d.triangle(LOW, HIGH, [1.0, 4.0])
        };
        let wears = d.checker(&mut scene, normal_of(&flat), 0.15, 0.9);
        scene.surface(flat, wears);
    }
    if d.chance(50) {
        let behind = Shape::Plane { point: v3(0.0, 0.0, -9.0), normal: d.vector(1.0) };
        let wears = d.checker(&mut scene, normal_of(&behind), 0.5, 3.0);
        scene.surface(behind, wears);
    }
    scene
}

/// Mirrors that face each other, as quads, triangles or planes, with things between them.
fn facing(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    scene.settings.max_bounces = d.int(3, 6);
    key_light(&mut d, &mut scene);
    let tilt = d.range(-0.5, 0.5);
    let (x, gap) = (d.range(-3.0, -2.0), d.range(3.5, 6.0));
    let mirror = |d: &mut Draw, scene: &mut Scene, x: f64, tilt: f64| {
        let specular = d.specular(0.6, 0.98);
        let wears = scene.material(Vec3::splat(0.02), Vec3::splat(0.1), specular);
        let (corner, v) = (v3(x, -1.0, 3.0), v3(tilt, 8.0, 0.0));
        let shape = match d.int(0, 2) {
            0 => Shape::Quad { corner, u: v3(0.0, 0.0, -9.0), v },
            1 => Shape::Triangle { a: corner, b: corner + v3(0.0, 0.0, -14.0), c: corner + v },
            _ => Shape::Plane { point: corner, normal: v3(-1.0, tilt / 8.0, 0.0) },
        };
        scene.surface(shape, wears);
    };
    // The eye stands in front of both; a plane may hide much, which is a scene too.
    mirror(&mut d, &mut scene, x, tilt);
    mirror(&mut d, &mut scene, d_round(x + gap), -tilt);
    floor(&mut d, &mut scene);
    for _ in 0..d.int(1, 5) {
        let ball = d.sphere(v3(-1.5, 0.3, -4.0), v3(1.5, 2.5, 1.0), [0.2, 0.7]);
        let wears = d.material(&mut scene, 50);
        scene.surface(ball, wears);
    }
    scene
}

fn d_round(x: f64) -> f64 {
    f64::from(x as f32)
}

/// Backgrounds, cut paths, no attenuation, dark lights, mirrors that give more than they get.
fn settings(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    key_light(&mut d, &mut scene);
    if d.chance(40) {
        let at = d.point(v3(-4.0, 2.0, -2.0), v3(4.0, 6.0, 5.0));
        let emissivity = d.colour(-40.0, 6.0);
        scene.light(at, emissivity);
    }
    if d.chance(70) {
        scene.settings.background = d.colour(-0.2, 1.5);
    }
    if d.chance(50) {
        scene.settings.max_path = d.range(4.0, 16.0);
    }
    if d.chance(50) {
        scene.settings.attenuation = Attenuation::None;
    }
    floor(&mut d, &mut scene);
    for _ in 0..d.int(2, 8) {
        let ball = d.sphere(LOW, HIGH, [0.3, 1.2]);
        let wears = if d.chance(30) {
            let (ambient, diffuse) = (d.colour(-0.3, 0.3), d.colour(-0.5, 1.0));
            let specular = d.colour(-0.5, 1.4);
            scene.material(ambient, diffuse, specular)
        } else {
            d.material(&mut scene, 60)
        };
        scene.surface(ball, wears);
    }
    scene
}

/// Several samples a pixel over a scene of another family, through each filter.
fn samples(seed: u64) -> Scene {
    let of = [sparse, dense, patterns, window, ball][(seed % 5) as usize];
    let mut scene = of(seed);
    scene.samples = 2 + (seed / 5 % 4) as usize;
    scene.filter = PixelFilter::ALL[(seed % 3) as usize];
    (scene.width, scene.height) = (31, 23);
    scene
}
