//! Pixels to ray trees, tile by tile on one core.

mod scenes;

use criterion::Throughput;
use reflet_accel::{Accel, Isa, Structure};
use reflet_trace::{Grid, Points, TraceScratch, Tracer, Trees};

fn main() {
    let packer = scenes::mirrors(0).with_scene(scenes::packed);
    let columns = packer.columns();
    let grid = Grid::new(columns.view.size, 16, columns.model.max_bounces);
    scenes::run(|criterion| {
        let mut group = criterion.benchmark_group("trace/mirrors-10");
        for isa in Isa::available() {
            let level = isa.level().expect("one that is available");
            let accel = Accel::build(&columns.geometry, level, Structure::Auto);
            let tracer = Tracer { columns, accel: &accel, points: Points::Dropped };
            let (mut trees, mut scratch) = (Trees::default(), TraceScratch::default());
            let mut picture = |scratch: &mut TraceScratch| {
                for tile in 0..grid.len() {
                    tracer.grow(grid.rect(tile), 0, &mut trees, scratch);
                }
            };
            picture(&mut scratch);
            group.throughput(Throughput::Elements(scratch.rays.total()));
            group.bench_function(isa.name(), |b| b.iter(|| picture(&mut scratch)));
        }
        group.finish();
    });
}
