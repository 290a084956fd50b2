//! Columns to a picture, on all cores: from nothing, and after the frame before.

mod scenes;

use criterion::{Criterion, Throughput};
use reflet_film::{Layout, Picture, SampleKind, Transfer, TransferTable};
use reflet_pack::Changes;
use std::sync::atomic::AtomicBool;

/// How a frame is made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Made {
    /// From nothing.
    Cold,
    /// After another frame of the animation, in which all ten mirrors had another specularity.
    Recoloured,
}

fn main() {
    scenes::run(|criterion| {
        measure(criterion, "cold", Made::Cold);
        measure(criterion, "recoloured", Made::Recoloured);
    });
}

fn measure(criterion: &mut Criterion, name: &str, made: Made) {
    let mut stage = scenes::mirrors(0);
    let mut packer = stage.with_scene(scenes::packed);
    let changes = [1, 0].map(|frame| {
        stage.frame(frame).unwrap_or_else(|e| panic!("{e}"));
        let changes = stage.with_scene(|scene| packer.update(scene));
        (packer.columns().clone(), changes)
    });
    let mut engine = scenes::engine(None);
    let [width, height] = packer.columns().view.size;
    let edge = engine.grid(packer.columns()).edge;
    let layout = Layout::try_new(width, height, edge).expect("a size");
    let mut picture = Picture::try_new(layout, SampleKind::U8).expect("memory");
    let table = TransferTable::new(Transfer::Srgb, SampleKind::U8);
    let never = AtomicBool::new(false);
    let mut render = |columns: &_, changes: Option<&Changes>| {
        let work = engine.render(columns, changes, &table, &mut picture, &never);
        work.expect("it is not cancelled")
    };
    render(&changes[1].0, None);
    let mut turn = changes.iter().cycle();
    let mut group = criterion.benchmark_group("frame/mirrors-10");
    group.throughput(Throughput::Elements(u64::from(width) * u64::from(height)));
    group.bench_function(name, |b| {
        b.iter(|| {
            let (columns, changes) = turn.next().expect("a cycle");
            render(columns, (made == Made::Recoloured).then_some(changes))
        });
    });
    group.finish();
}
