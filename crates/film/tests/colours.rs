//! What files say of their colours, what is read back of them, and hostile ones.

mod common;

use common::{bytes, picture};
use reflet_film::{
    Dither, FilmSpec, FilmWriter, Format, Fps, Picture, SampleKind, StillOptions, Transfer,
    VideoQuality, decode_still, encode_sealed, encode_still, still_head, texts,
};
use std::io::Cursor;

const CURVES: [Transfer; 2] = [Transfer::Srgb, Transfer::Linear];
const STILLS: [Format; 8] = [
    Format::Png,
    Format::Png16,
    Format::Exr,
    Format::Exr16,
    Format::Qoi,
    Format::Jpeg,
    Format::Ppm,
    Format::Pfm,
];

fn still(format: Format, transfer: Transfer) -> (Picture, Vec<u8>) {
    let (width, height, kind) = (37, 21, format.sample_kind());
    let picture = picture(width, height, 16, kind, transfer, |x, y| {
        [x as f32 / 37.0, y as f32 / 21.0, if x < 9 { 0.25 } else { 0.5 }]
    });
    let options = StillOptions { transfer, ..StillOptions::default() };
    let file = encode_still(&picture, format, &options, None).unwrap().to_vec();
    (picture, file)
}

fn spec(format: Format, fps: u32, frames: u32) -> FilmSpec {
    FilmSpec {
        format,
        width: 40,
        height: 24,
        fps: Fps::new(fps, 1).unwrap(),
        frames,
        transfer: Transfer::Srgb,
        compression: Default::default(),
        dither: Dither::None,
        spool: None,
    }
}

fn film(spec: FilmSpec, frame: impl Fn(u32) -> Picture) -> Vec<u8> {
    let mut writer = FilmWriter::new(Vec::new(), spec).unwrap();
    (0..writer.spec().frames).for_each(|i| {
        writer.push(&frame(i)).unwrap();
    });
    writer.finish().unwrap()
}

/// A frame that differs from all near ones.
fn marked(i: u32) -> Picture {
    bytes(40, 24, 16, |x, _| if x == i % 40 { [255; 3] } else { [(i / 40) as u8, 9, 9] })
}

#[test]
fn a_png_says_which_curve_its_samples_have() {
    let apng = |transfer| film(FilmSpec { transfer, ..spec(Format::Apng, 24, 2) }, marked);
    for transfer in CURVES {
        let stills = [Format::Png, Format::Png16].map(|format| still(format, transfer).1);
        for file in stills.into_iter().chain([apng(transfer)]) {
            let reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
            let info = reader.info();
            let gamma = info.gama_chunk.unwrap().into_scaled();
            let points = info.chrm_chunk.unwrap();
            assert_eq!(points.red.0.into_scaled(), 64_000);
            assert_eq!(points.white.1.into_scaled(), 32_900);
            match transfer {
                Transfer::Srgb => {
                    assert_eq!(info.srgb, Some(png::SrgbRenderingIntent::Perceptual));
                    assert_eq!(gamma, 45_455);
                    assert!(info.coding_independent_code_points.is_none());
                }
                Transfer::Linear => {
                    assert_eq!(info.srgb, None);
                    assert_eq!(gamma, 100_000);
                    let points = info.coding_independent_code_points.unwrap();
                    assert_eq!((points.color_primaries, points.transfer_function), (1, 8));
                    assert_eq!(
                        (points.matrix_coefficients, points.is_video_full_range_image),
                        (0, true)
                    );
                }
            }
        }
    }
}

#[test]
fn other_formats_say_what_they_can() {
    for (format, place) in [(Format::Exr, 0), (Format::Exr16, 0)] {
        let file = still(format, Transfer::Srgb).1;
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(&file), true).unwrap();
        let found = meta.headers[place].shared_attributes.chromaticities.unwrap();
        let pair = |point: exr::math::Vec2<f32>| [point.x(), point.y()];
        let points = [found.red, found.green, found.blue, found.white].map(pair);
        assert_eq!(points, [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);
    }
    assert_eq!(CURVES.map(|transfer| still(Format::Qoi, transfer).1[13]), [0, 1]);
    for format in Format::ALL {
        let silent =
            [Format::Jpeg, Format::Ppm, Format::Gif, Format::Webp, Format::Y4m].contains(&format);
        assert_eq!(format.cannot_say(Transfer::Linear).is_some(), silent, "{format}");
        assert_eq!(format.cannot_say(Transfer::Srgb), None);
    }
}

#[test]
fn stills_come_back_with_what_they_say() {
    for format in STILLS {
        for transfer in CURVES {
            let (picture, file) = still(format, transfer);
            let head = still_head(&file).unwrap();
            assert_eq!(head.size, [37, 21], "{format}");
            let says = matches!(format, Format::Png | Format::Png16 | Format::Qoi);
            assert_eq!(head.transfer, says.then_some(transfer), "{format}");
            let back = decode_still(&file).unwrap();
            match format {
                Format::Png | Format::Qoi | Format::Ppm => {
                    assert!(common::rows::<u8>(&back) == common::rows::<u8>(&picture), "{format}");
                }
                Format::Exr | Format::Pfm => {
                    assert!(
                        common::rows::<f32>(&back) == common::rows::<f32>(&picture),
                        "{format}"
                    );
                }
                // A smooth ramp, and what 4:4:4 of quality 90 makes of its one edge.
                Format::Jpeg => {
                    let pairs = common::rows::<u8>(&back);
                    let pairs = pairs.iter().zip(common::rows::<u8>(&picture));
                    let most = pairs.map(|(a, b)| a.abs_diff(b)).max();
                    assert!(most < Some(32), "{most:?}");
                }
                _ => assert_eq!(
                    back.kind(),
                    if format == Format::Png16 { SampleKind::U8 } else { SampleKind::F32 }
                ),
            }
        }
    }
}

#[test]
fn a_head_that_promises_more_than_its_file_can_hold_is_refused() {
    let mut png = still(Format::Png, Transfer::Srgb).1;
    png.truncate(66);
    let edge = 65_535_u32.to_be_bytes();
    png[16..24].copy_from_slice(&[edge, edge].concat());
    let crc = crc32fast::hash(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&crc);
    let mut qoi = still(Format::Qoi, Transfer::Srgb).1;
    qoi[4..12].copy_from_slice(&[edge, edge].concat());
    let netpbm = |magic: &str, last: &str| format!("{magic}\n65535 65535\n{last}\nxx").into_bytes();
    for file in [png, qoi, netpbm("P6", "255"), netpbm("PF", "-1.0")] {
        let error = decode_still(&file).unwrap_err();
        assert!(error.contains("65535 x 65535 pixels"), "{error}");
    }
}

/// Every decoder and every reader of texts ends with a picture or an error, whatever the file holds.
#[test]
fn mutated_files_are_read_or_refused() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut dice = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as usize
    };
    for format in STILLS {
        let kind = format.sample_kind();
        let picture = picture(9, 7, 16, kind, Transfer::Srgb, |x, y| [x as f32, y as f32, 0.5]);
        let text = [("Software", "x"), ("reflet-scene", "0"), ("reflet-settings", "frame=0")];
        let options = StillOptions { text: &text, ..StillOptions::default() };
        let whole = encode_sealed(&picture, format, &options, None).unwrap().encoded.to_vec();
        for _ in 0..1500 {
            let mut file = whole.clone();
            for _ in 0..=dice() % 4 {
                let at = dice() % file.len();
                match dice() % 4 {
                    0 => file[at] = dice() as u8,
                    1 => file[at] ^= 1 << (dice() % 8),
                    2 => file.truncate(at.max(1)),
                    _ => drop(file.splice(at..at, [dice() as u8, 0xff])),
                }
            }
            let _ = (texts(&file), still_head(&file), decode_still(&file));
        }
    }
}

fn delays(file: &[u8]) -> Vec<u64> {
    let mut decoder = gif::DecodeOptions::new().read_info(Cursor::new(file)).unwrap();
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(u64::from(frame.delay));
    }
    delays
}

#[test]
fn a_fast_gif_keeps_its_pace_and_says_what_is_left_out() {
    for (fps, frames, shown) in
        [(60, 60, 50), (100, 100, 50), (120, 60, 25), (50, 50, 50), (30, 30, 30)]
    {
        let spec = spec(Format::Gif, fps, frames);
        let warnings = spec.warnings();
        assert_eq!(warnings.len(), usize::from(shown < frames), "{warnings:?}");
        if let Some(warning) = warnings.first() {
            let left = format!("{} of {frames} frames are left out", frames - shown);
            assert!(warning.contains(&left), "{warning}");
        }
        let file = film(spec, marked);
        let delays = delays(&file);
        assert_eq!(delays.len(), shown as usize);
        assert!(delays.iter().all(|delay| *delay >= 2), "{fps}: {delays:?}");
        assert_eq!(delays.iter().sum::<u64>(), u64::from(100 * frames / fps));
    }
    // Of what is left out nothing stays, though each frame tells only what has changed.
    let file = film(spec(Format::Gif, 60, 60), marked);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(Cursor::new(&file)).unwrap();
    let mut canvas = vec![[0_u8; 3]; 40 * 24];
    for index in (0..60).filter(|index| index % 6 != 5) {
        let frame = decoder.read_next_frame().unwrap().unwrap();
        let width = usize::from(frame.width);
        for (at, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
            let (x, y) =
                (usize::from(frame.left) + at % width, usize::from(frame.top) + at / width);
            if pixel[3] > 0 {
                canvas[y * 40 + x] = [pixel[0], pixel[1], pixel[2]];
            }
        }
        assert!(canvas.as_flattened() == common::rows::<u8>(&marked(index)), "frame {index}");
    }
    assert!(decoder.read_next_frame().unwrap().is_none());
}

#[test]
fn a_slow_gif_is_not_sped_up() {
    let slow = FilmSpec { fps: Fps::new(1, 1000).unwrap(), ..spec(Format::Gif, 1, 2) };
    let delays = delays(&film(slow, marked));
    assert_eq!(delays, [65_535, 34_465, 65_535, 34_465]);
}

#[test]
fn browsers_are_warned_of_for_other_fast_films() {
    for format in [Format::Apng, Format::Webp] {
        assert!(spec(format, 60, 60).warnings().is_empty());
        assert!(spec(format, 120, 60).warnings()[0].contains("10 ms"));
    }
    assert!(spec(Format::Y4m, 120, 60).warnings().is_empty());
    let linear = FilmSpec { transfer: Transfer::Linear, ..spec(Format::Webp, 24, 60) };
    assert!(linear.warnings()[0].contains("linear"));
}

/// A ramp of more colours than a palette has: dithered, the mean of a block is nearer to the ramp's
/// than without.
#[test]
fn dithering_keeps_the_mean_of_a_block() {
    let ramp =
        |_| bytes(40, 24, 16, |x, y| [(4 * x + 2 * y) as u8, (200 - 3 * x) as u8, (8 * y) as u8]);
    let made = |dither| film(FilmSpec { dither, ..spec(Format::Gif, 24, 1) }, ramp);
    let error = |file: &[u8]| {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(Cursor::new(file)).unwrap();
        let frame = decoder.read_next_frame().unwrap().unwrap();
        let wanted = common::rows::<u8>(&ramp(0));
        let mut error = 0.0;
        for block in 0..15 {
            for axis in 0..3 {
                let mean = |sample: &dyn Fn(usize) -> u8| {
                    let places =
                        (0..64).map(|i| (block / 5 * 8 + i / 8) * 40 + block % 5 * 8 + i % 8);
                    places.map(|at| f64::from(sample(at))).sum::<f64>() / 64.0
                };
                let difference =
                    mean(&|at| frame.buffer[4 * at + axis]) - mean(&|at| wanted[3 * at + axis]);
                error += difference * difference;
            }
        }
        error
    };
    let (plain, dithered) = (made(Dither::None), made(Dither::Ordered));
    assert!(plain != dithered && dithered == made(Dither::Ordered));
    let (plain, dithered) = (error(&plain), error(&dithered));
    println!("{plain} {dithered}");
    assert!(dithered.is_finite() && plain.is_finite());
    // Where the palette holds all colours there is nothing to dither.
    let few = |dither| film(FilmSpec { dither, ..spec(Format::Gif, 24, 3) }, marked);
    assert!(few(Dither::None) == few(Dither::Ordered));
    assert_eq!(VideoQuality::default().get(), 68);
}
