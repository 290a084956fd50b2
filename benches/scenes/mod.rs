//! What the benches measure with.

#![allow(dead_code)] // each bench uses some of it

use criterion::Criterion;
use reflet_accel::{HitCode, Rays};
use reflet_frame::{Engine, EngineOptions};
use reflet_pack::{Columns, Overrides, Packer};
use reflet_scene::{
    Camera, Caps, Cylinder, DVec3, Key, Material, RandomStream, Scene, Sphere, Surface, Torus,
    Triangle,
};
use reflet_script::{Options, Source, Stage};
use std::num::NonZeroUsize;
use std::time::Duration;

/// Measures as the command line says, and each for about a second unless it says otherwise.
pub fn run(benches: impl FnOnce(&mut Criterion)) {
    let short = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    let mut criterion = short.configure_from_args();
    benches(&mut criterion);
    criterion.final_summary();
}

/// A shape that a random scene is made of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    Sphere,
    Triangle,
    /// Tubes around random axes.
    Cylinder,
    /// Rings around random axes.
    Torus,
}

/// Half the edge of the cube that random shapes have their centres in.
const ROOM: f64 = 10.0;

fn within(random: &mut RandomStream, half: f64) -> DVec3 {
    let mut next = || (2.0 * random.float() - 1.0) * half;
    let x = next();
    let y = next();
    DVec3::new(x, y, next())
}

/// `n` shapes in a cube, so large that a ray through the cube meets a few; and their material.
pub fn random_scene(shape: Shape, n: u32) -> (Scene, Key) {
    let mut random = RandomStream::new(7);
    let mut scene = Scene::new();
    let camera = Camera::LookAt {
        eye: DVec3::new(0.0, 0.0, 3.0 * ROOM),
        look_at: DVec3::ZERO,
        up: DVec3::Y,
        fov_degrees: 45.0,
    };
    scene.singletons.camera = Some(scene.spawn((camera,)));
    let material = scene.spawn((Material::GREY_MATT,));
    let size = 1.5 * ROOM / f64::from(n).sqrt();
    for _ in 0..n {
        let center = within(&mut random, ROOM);
        let surface = Surface { material: Some(material), visible: true };
        match shape {
            Shape::Sphere => scene.spawn((Sphere { center, radius: size * 0.5 }, surface)),
            Shape::Triangle => {
                let [a, b, c] = [(); 3].map(|()| center + within(&mut random, size));
                scene.spawn((Triangle { a, b, c }, surface))
            }
            Shape::Cylinder => {
                let (axis, caps) = (within(&mut random, 1.0), Caps::Open);
                let tube = Cylinder { base: center, axis, radius: size * 0.4, height: size, caps };
                scene.spawn((tube, surface))
            }
            Shape::Torus => {
                let axis = within(&mut random, 1.0);
                let ring = Torus { center, axis, major: size * 0.5, minor: size * 0.15 };
                scene.spawn((ring, surface))
            }
        };
    }
    scene.seal();
    (scene, material)
}

/// Packs a scene at the size that its image says.
pub fn packed(scene: &Scene) -> Packer {
    Packer::new(scene, Overrides::default()).expect("a camera")
}

/// A stream of `128 * 128` rays.
#[derive(Clone, Copy)]
pub enum Stream {
    /// From one eye through a grid of pixels, row by row.
    Camera,
    /// From anywhere in the cube to anywhere.
    Random,
    /// The same, but each with something the matter: a NaN, an infinity, a zero or a denormal.
    Odd,
}

/// What is the matter with odd rays.
const BAD: [f32; 6] = [f32::NAN, f32::INFINITY, 0.0, -0.0, 1e-40, f32::MAX];

const EDGE: u32 = 128;

/// Rays towards the cube of [`random_scene`], which end at `t_max`.
pub fn rays(columns: &Columns, stream: Stream, t_max: f32) -> Rays {
    let mut random = RandomStream::new(11);
    let mut rays = Rays::default();
    let view = &columns.view;
    let [width, height] = view.size.map(f64::from);
    for i in 0..EDGE * EDGE {
        let (mut origin, mut dir) = match stream {
            Stream::Camera => {
                let [x, y] = [i % EDGE, i / EDGE].map(|k| (f64::from(k) + 0.5) / f64::from(EDGE));
                view.ray(x * width, y * height)
            }
            Stream::Random | Stream::Odd => {
                let from = within(&mut random, ROOM);
                let way = (within(&mut random, ROOM) - from).normalize();
                (from.to_array().map(|x| x as f32), way.to_array().map(|x| x as f32))
            }
        };
        if let Stream::Odd = stream {
            let bad = BAD[i as usize / 6 % BAD.len()];
            match i % 6 {
                0 => dir[0] = bad,
                1 => dir = [bad; 3],
                2 => origin[1] = bad,
                3 => (dir[1], dir[2]) = (bad, bad),
                4 => dir = dir.map(|x| x * 1e-20),
                _ => dir = dir.map(|x| x * 1e-30),
            }
        }
        rays.push(origin, dir, t_max, HitCode::NONE);
    }
    rays.pad();
    rays
}

/// The scene of `scripts/mirrors-10.rhai` at one of its frames: ten mirrors, two lights, up to five
/// bounces, 640 x 360.
pub fn mirrors(frame: u32) -> Stage {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/mirrors-10.rhai");
    let source = Source::read(path).unwrap_or_else(|e| panic!("{e}"));
    let mut stage = Stage::load(source, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    stage.frame(frame).unwrap_or_else(|e| panic!("{e}"));
    stage
}

/// An engine with `threads`, or as many as the machine has.
pub fn engine(threads: Option<usize>) -> Engine {
    let threads = threads.and_then(NonZeroUsize::new);
    let engine = Engine::new(EngineOptions { threads, ..EngineOptions::default() });
    engine.unwrap_or_else(|e| panic!("{e}"))
}
