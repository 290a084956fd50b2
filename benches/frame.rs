//! Columns to a picture, on all cores: from nothing, and after the frame before.

mod scenes;

use criterion::{Criterion, Throughput};
use reflet_film::{Layout, Picture, SampleKind, Transfer, TransferTable};
use reflet_frame::Batch;
use reflet_trace::BatchColours;
use std::sync::atomic::AtomicBool;

/// How frames are made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Made {
    /// From nothing.
    Cold,
    /// After another frame of the animation, in which all ten mirrors had another specularity.
    Recoloured,
    /// The same, eight frames at a time.
    Batched,
}

/// Frames of a batch.
const BATCH: usize = 8;

fn main() {
    scenes::run(|criterion| {
        measure(criterion, "cold", Made::Cold);
        measure(criterion, "recoloured", Made::Recoloured);
        measure(criterion, "batched", Made::Batched);
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
    let frames = if made == Made::Batched { BATCH } else { 1 };
    let picture = || Picture::try_new(layout, SampleKind::U8).expect("memory");
    let mut pictures: Vec<Picture> = (0..frames).map(|_| picture()).collect();
    let table = TransferTable::new(Transfer::Srgb, SampleKind::U8);
    let never = AtomicBool::new(false);
    // There and back again: each frame's changes lead from the other.
    let batches = [0, 1].map(|first| {
        let mut colours = BatchColours::default();
        for (columns, changes) in changes.iter().cycle().skip(first).take(frames) {
            colours.push(columns, changes);
        }
        colours
    });
    let mut turn = changes.iter().zip(&batches).cycle();
    let mut render = |known: bool| {
        let ((columns, changes), colours) = turn.next().expect("a cycle");
        let changes = known.then_some(changes);
        let batch = Batch { columns, changes, colours, table: &table, last: None };
        engine.render(batch, &mut pictures, &never).expect("it is not cancelled")
    };
    render(false);
    let mut group = criterion.benchmark_group("frame/mirrors-10");
    let pixels = u64::from(width) * u64::from(height);
    group.throughput(Throughput::Elements(pixels * frames as u64));
    group.bench_function(name, |b| b.iter(|| render(made != Made::Cold)));
    group.finish();
}
