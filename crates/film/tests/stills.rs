//! Stills, read back by other people's decoders.

mod common;

use common::{balls, bytes, noise, picture, rows};
use reflet_film::{
    Compression, Encoded, Format, KeptBands, Picture, SampleKind, StillOptions, Transfer,
    encode_still,
};
use std::collections::HashMap;
use std::io::Cursor;

const COMPRESSIONS: [Compression; 3] =
    [Compression::Fast, Compression::Balanced, Compression::Small];

fn encode(picture: &Picture, format: Format, compression: Compression) -> Encoded {
    let options = StillOptions { compression, ..StillOptions::default() };
    encode_still(picture, format, &options, None).unwrap()
}

/// What the `png` crate reads: size, depth, samples, text.
fn read_png(file: &[u8]) -> (u32, u32, png::BitDepth, Vec<u8>, HashMap<String, String>) {
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut samples).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    reader.finish().unwrap();
    let mut text = HashMap::new();
    for chunk in &reader.info().uncompressed_latin1_text {
        text.insert(chunk.keyword.clone(), chunk.text.clone());
    }
    for chunk in &reader.info().utf8_text {
        text.insert(chunk.keyword.clone(), chunk.get_text().unwrap());
    }
    (info.width, info.height, info.bit_depth, samples, text)
}

fn hold_png(picture: &Picture, compression: Compression) {
    let layout = picture.layout();
    let format = match picture.kind() {
        SampleKind::U16 => Format::Png16,
        _ => Format::Png,
    };
    let file = encode(picture, format, compression).to_vec();
    let (width, height, depth, samples, _) = read_png(&file);
    assert_eq!((width, height), (layout.width(), layout.height()));
    let image = image::load_from_memory_with_format(&file, image::ImageFormat::Png).unwrap();
    if format == Format::Png16 {
        assert_eq!(depth, png::BitDepth::Sixteen);
        let want: Vec<u16> = rows(picture);
        let big_endian: Vec<u8> = want.iter().flat_map(|s| s.to_be_bytes()).collect();
        assert!(samples == big_endian, "{layout:?} {compression:?}");
        assert!(image.into_rgb16().into_raw() == want);
    } else {
        assert_eq!(depth, png::BitDepth::Eight);
        let want: Vec<u8> = rows(picture);
        assert!(samples == want, "{layout:?} {compression:?}");
        assert!(image.into_rgb8().into_raw() == want);
    }
}

/// Sizes about the edges of tiles and bands.
const SIZES: [(u32, u32); 14] = [
    (1, 1),
    (1, 2),
    (2, 1),
    (1, 300),
    (300, 1),
    (3, 5),
    (16, 16),
    (17, 33),
    (15, 64),
    (31, 65),
    (200, 129),
    (640, 33),
    (1280, 17),
    (65535, 9),
];

#[test]
fn png_of_every_size_comes_back() {
    for (width, height) in SIZES {
        for tile in [1, 7, 16, 64] {
            if tile == 1 && width > 1280 {
                continue;
            }
            let noise = bytes(width, height, tile, |x, y| {
                let [r, g, b, _] = noise(x, y, 1).to_le_bytes();
                [r, g & 3, if y % 3 == 0 { b } else { 0 }]
            });
            hold_png(&noise, Compression::Fast);
        }
    }
}

#[test]
fn png_of_every_content_comes_back() {
    for compression in COMPRESSIONS {
        hold_png(&bytes(100, 70, 16, |_, _| [1, 2, 3]), compression);
        hold_png(&bytes(100, 70, 16, |_, _| [0; 3]), compression);
        hold_png(&bytes(257, 70, 16, |x, y| [x as u8, y as u8, (x + y) as u8]), compression);
        // Rows that repeat, for the filter Up.
        let column = |x: u32, _: u32| noise(x, 0, 5).to_le_bytes()[..3].try_into().unwrap();
        hold_png(&bytes(300, 70, 16, column), compression);
        let any = |x: u32, y: u32| noise(x, y, 9).to_le_bytes()[..3].try_into().unwrap();
        hold_png(&bytes(300, 70, 16, any), compression);
        // Zeros in runs of every length.
        let gaps = |x: u32, y: u32| [u8::from(x.is_multiple_of(y + 2)), 0, 0];
        hold_png(&bytes(333, 90, 16, gaps), compression);
        hold_png(&balls(320, 180, SampleKind::U8, 0.3), compression);
        hold_png(&balls(160, 90, SampleKind::U16, 0.3), compression);
    }
    hold_png(&balls(1280, 720, SampleKind::U8, 0.3), Compression::Fast);
}

#[test]
fn png_of_16_bits_of_every_size_comes_back() {
    for (width, height) in SIZES.into_iter().filter(|size| size.0 < 2000) {
        let curve = Transfer::Linear;
        let ramp = picture(width, height, 16, SampleKind::U16, curve, |x, y| {
            [x as f32 / 300.0, (noise(x, y, 2) >> 8) as f32 / 16_777_216.0, y as f32 / 128.0]
        });
        hold_png(&ramp, Compression::Fast);
    }
}

#[test]
fn a_file_does_not_depend_on_tiles_or_threads() {
    let draw = |tile| {
        picture(201, 133, tile, SampleKind::U8, Transfer::Srgb, |x, y| {
            [x as f32 / 200.0, y as f32 / 132.0, 0.25]
        })
    };
    let pools = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap()
    });
    for format in [Format::Png, Format::Qoi, Format::Jpeg, Format::Ppm] {
        let want = encode(&draw(16), format, Compression::Fast).to_vec();
        for tile in [1, 5, 32, 64] {
            let picture = draw(tile);
            for pool in &pools {
                let found = pool.install(|| encode(&picture, format, Compression::Fast).to_vec());
                assert!(found == want, "{format} {tile}");
            }
        }
    }
}

/// Frames of an animation of which some rows change, forth and back.
fn frames(kind: SampleKind) -> Vec<Picture> {
    let steps: [(u32, u32); 6] = [(0, 0), (0, 0), (40, 1), (40, 2), (0, 0), (299, 3)];
    let draw = |(row, step): (u32, u32)| {
        picture(640, 300, 16, kind, Transfer::Srgb, move |x, y| {
            let change = if y == row { step as f32 / 8.0 } else { 0.0 };
            [x as f32 / 640.0, y as f32 / 300.0, change]
        })
    };
    steps.map(draw).to_vec()
}

#[test]
fn kept_bands_give_the_same_bytes() {
    for format in [Format::Png, Format::Png16, Format::Exr, Format::Exr16] {
        let frames = frames(format.sample_kind());
        for compression in COMPRESSIONS {
            let options = StillOptions { compression, ..StillOptions::default() };
            let mut kept = KeptBands::new();
            let mut counts = Vec::new();
            for frame in &frames {
                let warm = encode_still(frame, format, &options, Some(&mut kept)).unwrap();
                let cold = encode_still(frame, format, &options, None).unwrap();
                assert!(warm.to_vec() == cold.to_vec(), "{format} {compression:?}");
                assert_eq!(warm.len(), cold.to_vec().len());
                assert_eq!(cold.bands_kept, 0);
                assert_eq!(warm.bands_encoded + warm.bands_kept, cold.bands_encoded);
                counts.push(warm.bands_encoded);
            }
            // All of the first frame, nothing of an equal one, the one band of the row that
            // changed, and of the last frame the one that changed back and the other.
            let all = counts[0];
            assert!(all >= 8, "{format}: {all} bands");
            assert_eq!(counts[1..], [0, 1, 1, 1, 1], "{format} {compression:?}");
            assert!(kept.memory() >= 640 * 300 * 3);
            kept.clear();
            assert_eq!(kept.memory(), 0);
        }
    }
}

#[test]
fn kept_bands_start_anew_for_another_file() {
    let mut kept = KeptBands::new();
    let small = bytes(64, 128, 16, |_, _| [7; 3]);
    let wide = bytes(128, 64, 16, |_, _| [7; 3]);
    let mut encode = |picture: &Picture, compression| {
        let options = StillOptions { compression, ..StillOptions::default() };
        let warm = encode_still(picture, Format::Png, &options, Some(&mut kept)).unwrap();
        let cold = encode_still(picture, Format::Png, &options, None).unwrap();
        assert_eq!(warm.to_vec(), cold.to_vec());
        warm.bands_kept
    };
    assert_eq!(encode(&small, Compression::Fast), 0);
    assert_eq!(encode(&small, Compression::Fast), 2);
    assert_eq!(encode(&wide, Compression::Fast), 0);
    assert_eq!(encode(&wide, Compression::Small), 0);
    assert_eq!(encode(&wide, Compression::Small), 1);
}

#[test]
fn fast_png_is_near_the_png_crates() {
    let smooth = picture(1280, 720, 16, SampleKind::U8, Transfer::Srgb, |x, y| {
        let (x, y) = (x as f32 / 1280.0, y as f32 / 720.0);
        [x * y, (x - 0.5).powi(2) + (y - 0.5).powi(2), 1.0 / (1.0 + x + y)]
    });
    let pictures = [
        balls(1280, 720, SampleKind::U8, 0.2),
        balls(640, 360, SampleKind::U8, 0.7),
        balls(320, 180, SampleKind::U8, 0.4),
        smooth,
    ];
    for picture in pictures {
        let ours = encode(&picture, Format::Png, Compression::Fast).len();
        let mut theirs = Vec::new();
        let layout = picture.layout();
        let mut encoder = png::Encoder::new(&mut theirs, layout.width(), layout.height());
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&rows::<u8>(&picture)).unwrap();
        writer.finish().unwrap();
        assert!(
            ours as f64 <= 1.1 * theirs.len() as f64,
            "{layout:?}: {ours} bytes, the png crate {}",
            theirs.len()
        );
        let balanced = encode(&picture, Format::Png, Compression::Balanced).len();
        let small = encode(&picture, Format::Png, Compression::Small).len();
        assert!(small <= balanced && balanced < ours, "{small} {balanced} {ours}");
    }
}

#[test]
fn text_is_carried() {
    let text = [("Software", "Reflet"), ("Scene", "Möbius\nzwei")];
    let options = StillOptions { text: &text, ..StillOptions::default() };
    let flat = bytes(4, 4, 16, |_, _| [1, 2, 3]);
    let file = encode_still(&flat, Format::Png, &options, None).unwrap();
    let (.., found) = read_png(&file.to_vec());
    assert_eq!(found.len(), 2);
    for (key, value) in text {
        assert_eq!(found[key], value);
    }

    let linear = picture(4, 4, 16, SampleKind::F32, Transfer::Srgb, |_, _| [1.0, 2.0, 3.0]);
    let file = encode_still(&linear, Format::Exr, &options, None).unwrap();
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(file.to_vec()), true).unwrap();
    let header = &meta.headers[0];
    for (key, value) in text {
        let name = exr::meta::attribute::Text::from(key);
        let own = header.own_attributes.other.get(&name);
        let own = own.or_else(|| header.shared_attributes.other.get(&name));
        let software = header.own_attributes.software_name.clone();
        match own {
            Some(exr::meta::attribute::AttributeValue::Text(found)) => {
                // The crate reads texts as Latin-1, so compare bytes.
                let latin: Vec<u8> = found.chars().map(|c| c as u8).collect();
                assert_eq!(latin, value.as_bytes());
            }
            other => panic!("{key}: {other:?} {software:?}"),
        }
    }

    for (key, value) in [("", "x"), (" a", "x"), ("a  b", "x"), ("ä", "x"), ("a", "\0")] {
        let text = [(key, value)];
        let options = StillOptions { text: &text, ..StillOptions::default() };
        let error = encode_still(&flat, Format::Png, &options, None).unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::InvalidInput, "{key:?}");
    }
    for text in [[("channels", "x"), ("b", "y")], [("a", "x"), ("a", "y")]] {
        let options = StillOptions { text: &text, ..StillOptions::default() };
        assert!(encode_still(&linear, Format::Exr, &options, None).is_err());
    }
}

#[test]
fn exr_comes_back_bit_for_bit() {
    use exr::prelude::*;
    for (width, height) in [(1, 1), (1, 40), (40, 1), (17, 33), (130, 100)] {
        let odd = picture(width, height, 16, SampleKind::F32, Transfer::Srgb, |x, y| {
            let n = noise(x, y, 4);
            [
                f32::from_bits(n),
                x as f32 / 7.0 - y as f32,
                if n.is_multiple_of(4) { f32::INFINITY } else { 0.25 },
            ]
        });
        for format in [Format::Exr, Format::Exr16] {
            for compression in COMPRESSIONS {
                let file = encode(&odd, format, compression).to_vec();
                let image = read()
                    .no_deep_data()
                    .largest_resolution_level()
                    .all_channels()
                    .first_valid_layer()
                    .all_attributes()
                    .from_buffered(Cursor::new(&file))
                    .unwrap();
                let channels = &image.layer_data.channel_data.list;
                let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
                assert_eq!(names, ["B", "G", "R"]);
                let want: Vec<f32> = rows(&odd);
                for (channel, place) in channels.iter().zip([2, 1, 0]) {
                    let want = want.iter().skip(place).step_by(3).copied();
                    match &channel.sample_data {
                        FlatSamples::F32(found) => {
                            assert_eq!(format, Format::Exr);
                            let found: Vec<u32> = found.iter().map(|f| f.to_bits()).collect();
                            assert_eq!(found, want.map(f32::to_bits).collect::<Vec<u32>>());
                        }
                        FlatSamples::F16(found) => {
                            assert_eq!(format, Format::Exr16);
                            let found: Vec<u16> = found.iter().map(|f| f.to_bits()).collect();
                            let want = want.map(|f| half::f16::from_f32(f).to_bits());
                            assert_eq!(found, want.collect::<Vec<u16>>());
                        }
                        FlatSamples::U32(_) => panic!("floats were written"),
                    }
                }
            }
        }
    }
}

#[test]
fn qoi_comes_back() {
    for (width, height) in [(1, 1), (1, 200), (200, 1), (62, 3), (63, 3), (17, 33), (320, 180)] {
        let draw: [&dyn Fn(u32, u32) -> [u8; 3]; 5] = [
            &|_, _| [0; 3],
            &|_, _| [255, 0, 9],
            &|x, y| noise(x, y, 1).to_le_bytes()[..3].try_into().unwrap(),
            // Few colours (index), small steps (diff and luma), and runs.
            &|x, y| [(noise(x / 3, y, 1) % 3) as u8, 0, (noise(x / 5, y, 2) % 4) as u8],
            &|x, y| [(x * 2 + y) as u8, (x * 9) as u8, (x * 5 + noise(x, y, 1) % 9) as u8],
        ];
        for draw in draw {
            let picture = bytes(width, height, 16, draw);
            let file = encode(&picture, Format::Qoi, Compression::Fast).to_vec();
            let found = image::load_from_memory_with_format(&file, image::ImageFormat::Qoi);
            let found = found.unwrap().into_rgb8();
            assert_eq!(found.dimensions(), (width, height));
            assert!(found.into_raw() == rows::<u8>(&picture), "{width} x {height}");
        }
    }
}

#[test]
fn jpeg_is_as_near_as_another_encoder() {
    let distance = |file: &[u8], want: &[u8], size| {
        let found = image::load_from_memory_with_format(file, image::ImageFormat::Jpeg);
        let found = found.unwrap().into_rgb8();
        assert_eq!(found.dimensions(), size);
        let squares = found.into_raw().into_iter().zip(want);
        let sum: f64 = squares.map(|(a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
        (sum / want.len() as f64).sqrt()
    };
    for (width, height) in [(1, 1), (17, 33), (320, 180)] {
        let picture = balls(width, height, SampleKind::U8, 0.1);
        let want = rows::<u8>(&picture);
        let ours = encode(&picture, Format::Jpeg, Compression::Fast).to_vec();
        let mut theirs = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut theirs, 90)
            .encode(&want, width, height, image::ExtendedColorType::Rgb8)
            .unwrap();
        let ours = distance(&ours, &want, (width, height));
        let theirs = distance(&theirs, &want, (width, height));
        // The same quality, tables and sampling; what differs is the rounding within the cosine
        // transform, which moves some coefficients by a step: a tenth, or half a level.
        assert!(ours <= theirs * 1.1 + 0.5, "{width} x {height}: {ours}, theirs {theirs}");
    }
    let picture = bytes(2, 2, 16, |_, _| [0; 3]);
    for jpeg_quality in [0, 101] {
        let options = StillOptions { jpeg_quality, ..StillOptions::default() };
        assert!(encode_still(&picture, Format::Jpeg, &options, None).is_err());
    }
}

#[test]
fn ppm_and_pfm_are_their_header_and_samples() {
    let picture = bytes(3, 2, 16, |x, y| [x as u8, y as u8, 7]);
    let file = encode(&picture, Format::Ppm, Compression::Fast).to_vec();
    assert_eq!(
        file,
        b"P6\n3 2\n255\n\0\0\x07\x01\0\x07\x02\0\x07\0\x01\x07\x01\x01\x07\x02\x01\x07"
    );
    let linear = common::picture(2, 2, 1, SampleKind::F32, Transfer::Srgb, |x, y| {
        [x as f32, y as f32, -2.5]
    });
    let file = encode(&linear, Format::Pfm, Compression::Fast).to_vec();
    let mut want = b"PF\n2 2\n-1.0\n".to_vec();
    // The lower row first.
    for sample in [0.0_f32, 1.0, -2.5, 1.0, 1.0, -2.5, 0.0, 0.0, -2.5, 1.0, 0.0, -2.5] {
        want.extend(sample.to_le_bytes());
    }
    assert_eq!(file, want);
}

#[test]
fn wrong_pictures_are_errors() {
    let narrow = bytes(2, 2, 16, |_, _| [0; 3]);
    for format in [Format::Png16, Format::Exr, Format::Pfm, Format::Gif, Format::Y4m] {
        let options = StillOptions::default();
        let error = encode_still(&narrow, format, &options, None).unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::InvalidInput, "{format}");
    }
}
