//! Ray trees to linear colours, tile by tile on one core.

mod scenes;

use criterion::Throughput;
use reflet_accel::{Accel, Isa, Structure};
use reflet_trace::{BatchColours, Grid, Points, ShadeScratch, Shader, TraceScratch, Tracer, Trees};

fn main() {
    let packer = scenes::mirrors(0).with_scene(scenes::packed);
    let columns = packer.columns();
    let [width, height] = columns.view.size.map(u64::from);
    let grid = Grid::new(columns.view.size, 16, columns.model.max_bounces);
    let level = Isa::Auto.level().expect("there is always one");
    let accel = Accel::build(&columns.geometry, level, Structure::Auto);
    let tracer = Tracer { columns, accel: &accel, points: Points::Dropped };
    let mut scratch = TraceScratch::default();
    let grow = |tile| {
        let mut trees = Trees::default();
        tracer.grow(grid.rect(tile), 0, &mut trees, &mut scratch);
        trees
    };
    let tiles: Vec<Trees> = (0..grid.len()).map(grow).collect();
    scenes::run(|criterion| {
        let mut group = criterion.benchmark_group("shade/mirrors-10");
        group.throughput(Throughput::Elements(width * height));
        for isa in Isa::available() {
            let colours = BatchColours::of(columns);
            let level = isa.level().expect("one that is available");
            let shader = Shader::new(columns, &colours, level);
            let mut scratch = ShadeScratch::default();
            group.bench_function(isa.name(), |b| {
                b.iter(|| {
                    for (tile, trees) in tiles.iter().enumerate() {
                        shader.begin(&mut scratch);
                        shader.add(trees, &mut scratch);
                        std::hint::black_box(shader.finish(
                            0,
                            (grid.rect(tile), grid.edge),
                            &mut scratch,
                        ));
                    }
                });
            });
        }
        group.finish();
    });
}
