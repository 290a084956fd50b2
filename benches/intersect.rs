//! Rays to hits, on one core: shapes, structures, questions, streams and SIMD levels.

mod scenes;

use criterion::{Criterion, Throughput};
use reflet_accel::{Accel, Hits, Isa, RayCounts, Scratch, Structure};
use reflet_pack::Columns;
use scenes::{Shape, Stream};

fn main() {
    scenes::run(|criterion| {
        let shapes = [
            ("spheres", Shape::Sphere),
            ("triangles", Shape::Triangle),
            ("cylinders", Shape::Cylinder),
            ("tori", Shape::Torus),
        ];
        for (name, shape) in shapes {
            for (n, structure) in [(16, Structure::List), (100_000, Structure::Tree)] {
                let (scene, _) = scenes::random_scene(shape, n);
                let packer = scenes::packed(&scene);
                let streams =
                    [("camera", Stream::Camera), ("random", Stream::Random), ("odd", Stream::Odd)];
                for (kind, stream) in streams {
                    let name = format!("{n}-{name}/{structure:?}/{kind}").to_lowercase();
                    measure(criterion, &name, packer.columns(), structure, stream);
                }
            }
        }
    });
}

fn measure(
    criterion: &mut Criterion,
    name: &str,
    columns: &Columns,
    structure: Structure,
    stream: Stream,
) {
    let rays = scenes::rays(columns, stream, f32::INFINITY);
    // As long as many shadow rays are: about half of the cube.
    let segments = scenes::rays(columns, stream, 10.0);
    for isa in Isa::available() {
        let level = isa.level().expect("one that is available");
        let accel = Accel::build(&columns.geometry, level, structure);
        let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
        let mut group = criterion.benchmark_group(format!("{name}/closest"));
        group.throughput(Throughput::Elements(rays.len() as u64));
        let mut hits = Hits::default();
        group.bench_function(isa.name(), |b| {
            b.iter(|| accel.closest(&rays, &mut hits, &mut scratch, &mut counts));
        });
        group.finish();
        let mut group = criterion.benchmark_group(format!("{name}/any"));
        group.throughput(Throughput::Elements(segments.len() as u64));
        let mut occluded = Vec::new();
        group.bench_function(isa.name(), |b| {
            b.iter(|| accel.any(&segments, &mut occluded, &mut scratch, &mut counts));
        });
        group.finish();
    }
}
