//! A rendered picture to the bytes of a PNG, on one core, beside the `png` crate.

mod scenes;

use criterion::Throughput;
use reflet_film::{
    Compression, Format, Layout, Picture, SampleKind, StillOptions, Transfer, TransferTable,
    encode_still,
};
use reflet_frame::Batch;
use reflet_trace::BatchColours;
use std::sync::atomic::AtomicBool;

fn main() {
    let packer = scenes::mirrors(0).with_scene(scenes::packed);
    let columns = packer.columns();
    let [width, height] = columns.view.size;
    let mut engine = scenes::engine(Some(1));
    let edge = engine.grid(columns).edge;
    let layout = Layout::try_new(width, height, edge).expect("a size");
    let mut pictures = [Picture::try_new(layout, SampleKind::U8).expect("memory")];
    let table = TransferTable::new(Transfer::Srgb, SampleKind::U8);
    let never = AtomicBool::new(false);
    let colours = BatchColours::of(columns);
    let batch = Batch { columns, changes: None, colours: &colours, table: &table, last: None };
    engine.render(batch, &mut pictures, &never).expect("it is not cancelled");
    let [picture] = pictures;
    // The peer gets its rows ready; ours takes them out of the tiles itself.
    let line = width as usize * 3;
    let mut rows = vec![0; line * height as usize];
    rows.chunks_exact_mut(line).zip(0..).for_each(|(row, y)| picture.row(y, row));

    let ours = |compression| {
        let options = StillOptions { compression, ..StillOptions::default() };
        encode_still(&picture, Format::Png, &options, None).expect("a PNG").len()
    };
    let theirs = |compression| {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(compression);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(&rows).expect("rows");
        writer.finish().expect("an end");
        file.len()
    };
    scenes::run(|criterion| {
        let mut group = criterion.benchmark_group("encode/mirrors-10");
        group.throughput(Throughput::Bytes(rows.len() as u64));
        let pool = engine.pool();
        for (name, ours_at, theirs_at) in [
            ("fast", Compression::Fast, png::Compression::Fast),
            ("balanced", Compression::Balanced, png::Compression::Balanced),
        ] {
            eprintln!("{name}: {} bytes, png {} bytes", ours(ours_at), theirs(theirs_at));
            let mut measure = |side: &str, encode: &(dyn Fn() -> usize + Sync)| {
                group.bench_function(format!("{side}/{name}"), |b| {
                    pool.install(|| b.iter(encode));
                });
            };
            measure("reflet", &|| ours(ours_at));
            measure("png", &|| theirs(theirs_at));
        }
        group.finish();
    });
}
