//! Columns to what rays are intersected with: built from nothing, and refitted to what moved.

mod scenes;

use criterion::{BatchSize, Criterion, Throughput};
use reflet_accel::{Accel, Isa, Structure};
use reflet_pack::{Geometry, Slot};
use scenes::Shape;

const SHAPES: u32 = 100_000;

fn main() {
    scenes::run(|criterion| {
        for (name, shape) in [("spheres", Shape::Sphere), ("triangles", Shape::Triangle)] {
            let (scene, _) = scenes::random_scene(shape, SHAPES);
            let packer = scenes::packed(&scene);
            build(criterion, name, &packer.columns().geometry);
        }
        refit(criterion);
    });
}

fn build(criterion: &mut Criterion, name: &str, geometry: &Geometry) {
    let level = Isa::Auto.level().expect("auto is always there");
    for (threads, name) in [(1, format!("{name}/1 thread")), (0, format!("{name}/all threads"))] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut group = criterion.benchmark_group("build");
        group.throughput(Throughput::Elements(u64::from(SHAPES)));
        group.bench_function(name, |b| {
            let build = || Accel::build(geometry, level, Structure::Tree);
            b.iter_batched(|| (), |()| pool.install(build), BatchSize::PerIteration);
        });
        group.finish();
    }
}

/// Spheres on a grid, each `step` of its radius away from its place.
fn grid(step: f32) -> Geometry {
    let mut geometry = Geometry::default();
    for i in 0..SHAPES {
        let [x, y, z] = [i % 50, i / 50 % 50, i / 2500].map(|k| k as f32);
        geometry.push_sphere([x + 0.3 * step, y, z], 0.3);
    }
    geometry
}

fn refit(criterion: &mut Criterion) {
    let level = Isa::Auto.level().expect("auto is always there");
    // There and back again, by so little that the tree never wears out.
    let places = [grid(0.0), grid(0.1)];
    for (name, moved) in [("1 of 100,000", 1), ("1,000 of 100,000", 1000), ("all", SHAPES)] {
        let moved: Vec<Slot> = (0..SHAPES).step_by((SHAPES / moved) as usize).map(Slot).collect();
        let mut accel = Accel::build(&places[0], level, Structure::Tree);
        let mut turn = places.iter().cycle().skip(1);
        let mut move_all = || accel.refit(turn.next().expect("a cycle"), &moved);
        // All at once are built again.
        move_all();
        let mut group = criterion.benchmark_group("refit");
        group.throughput(Throughput::Elements(moved.len() as u64));
        group.bench_function(name, |b| b.iter(&mut move_all));
        group.finish();
    }
}
