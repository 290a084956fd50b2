//! Textures of every format, from our own hand and from other programs, whole and broken.

use reflet_assets::{Assets, Cause, texture};
use reflet_scene::Texture;
use std::process::Command;
use std::sync::Arc;

/// sRGB to linear, as IEC 61966-2-1 says it.
fn linear(sample: f64) -> f32 {
    let value =
        if sample <= 0.04045 { sample / 12.92 } else { ((sample + 0.055) / 1.055).powf(2.4) };
    value as f32
}

/// A picture of 5 x 3 samples of 8 bits.
fn samples() -> Vec<u8> {
    (0..5 * 3 * 3).map(|i| (i * 37 % 256) as u8).collect()
}

fn png(colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 5, 3);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

fn exr(grey: bool) -> Vec<u8> {
    use exr::prelude::*;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let value = |at: Vec2<usize>| (at.x() as f32 - 1.5) * 1000.0 + at.y() as f32;
    if grey {
        let channels = SpecificChannels::build().with_channel("Y").with_pixel_fn(|at| (value(at),));
        Image::from_channels((5, 3), channels).write().to_buffered(&mut bytes).unwrap();
    } else {
        let channels =
            SpecificChannels::rgb(|at: Vec2<usize>| (value(at), f16::from_f32(0.5), 2.0_f32));
        Image::from_channels((5, 3), channels).write().to_buffered(&mut bytes).unwrap();
    }
    bytes.into_inner()
}

fn ppm() -> Vec<u8> {
    [&b"P6 # a remark\n5\n3 255\n"[..], &samples()].concat()
}

fn jpeg() -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels: Vec<u8> =
        (0..40 * 24).flat_map(|i| [(i % 40 * 6) as u8, (i / 40 * 10) as u8, 99]).collect();
    let encoder = jpeg_encoder::Encoder::new(&mut bytes, 100);
    encoder.encode(&pixels, 40, 24, jpeg_encoder::ColorType::Rgb).unwrap();
    bytes
}

fn expected(samples: &[u8]) -> Vec<[f32; 3]> {
    let pixels = samples.as_chunks::<3>().0.iter();
    pixels.map(|pixel| pixel.map(|sample| linear(f64::from(sample) / 255.0))).collect()
}

fn near(texture: &Texture, want: &[[f32; 3]]) {
    assert_eq!(texture.texels.len(), want.len());
    for (a, b) in texture.texels.iter().flatten().zip(want.iter().flatten()) {
        // Two ways to a power.
        assert!((a - b).abs() <= 1e-7, "{a} {b}");
    }
}

#[test]
fn every_format_is_read() {
    use png::{BitDepth, ColorType};
    let rgb = texture::decode(&png(ColorType::Rgb, BitDepth::Eight, &samples())).unwrap();
    assert_eq!((rgb.width, rgb.height), (5, 3));
    near(&rgb, &expected(&samples()));
    assert_eq!(texture::decode(&ppm()).unwrap(), rgb);
    assert_eq!(
        (rgb.texels[0][0], texture::decode(b"P5 1 1 255\n\xff").unwrap().texels[0]),
        (0.0, [1.0; 3])
    );

    // Opacity is left out, grey is three equal numbers.
    let clear: Vec<u8> = samples().chunks(3).flat_map(|p| [p[0], p[1], p[2], 7]).collect();
    assert_eq!(texture::decode(&png(ColorType::Rgba, BitDepth::Eight, &clear)).unwrap(), rgb);
    let greys: Vec<u8> = samples().into_iter().take(15).collect();
    let grey = texture::decode(&png(ColorType::Grayscale, BitDepth::Eight, &greys)).unwrap();
    let want: Vec<u8> = greys.iter().flat_map(|sample| [*sample; 3]).collect();
    near(&grey, &expected(&want));

    // 65535 is 255 times 257: the same colours in 16 bits.
    let wide: Vec<u8> = samples().into_iter().flat_map(|sample| [sample, sample]).collect();
    let sixteen = texture::decode(&png(ColorType::Rgb, BitDepth::Sixteen, &wide)).unwrap();
    near(&sixteen, &expected(&samples()));
    let ppm16 = texture::decode(&[&b"P6 5 3 65535\n"[..], &wide].concat()).unwrap();
    assert_eq!(ppm16, sixteen);
    let between = png(ColorType::Grayscale, BitDepth::Sixteen, &[0x12, 0x34].repeat(15));
    let between = texture::decode(&between).unwrap().texels[14];
    assert!((between[0] - linear(f64::from(0x1234) / 65535.0)).abs() < 1e-8);

    let floats = texture::decode(&exr(false)).unwrap();
    assert_eq!((floats.width, floats.height), (5, 3));
    assert_eq!(floats.texels[0], [-1500.0, 0.5, 2.0]);
    assert_eq!(floats.texels[2 * 5 + 4], [2502.0, 0.5, 2.0]);
    assert_eq!(texture::decode(&exr(true)).unwrap().texels[5], [-1499.0; 3]);

    let lossy = texture::decode(&jpeg()).unwrap();
    assert_eq!((lossy.width, lossy.height), (40, 24));
    for (x, y) in [(0, 0), (39, 0), (20, 12), (5, 23)] {
        let want = [x * 6, y * 10, 99].map(|v| linear(f64::from(v) / 255.0));
        let found = lossy.texels[(y * 40 + x) as usize];
        let far = found.iter().zip(want).any(|(a, b)| (a - b).abs() > 0.03);
        assert!(!far, "{x}, {y}: {found:?} {want:?}");
    }
}

fn all() -> Vec<(&'static str, Vec<u8>)> {
    use png::{BitDepth, ColorType};
    vec![
        ("png", png(ColorType::Rgb, BitDepth::Eight, &samples())),
        ("exr", exr(false)),
        ("grey exr", exr(true)),
        ("ppm", ppm()),
        ("jpeg", jpeg()),
    ]
}

#[test]
fn broken_files_are_errors_and_never_panics() {
    for (name, bytes) in all() {
        for cut in 0..bytes.len() {
            let result = texture::decode(&bytes[..cut]);
            // A JPEG whose last marker alone is gone is whole.
            assert!(
                result.is_err() || name == "jpeg" && cut + 2 >= bytes.len(),
                "{name} cut at {cut}"
            );
        }
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut bad = bytes.clone();
                bad[at] ^= 1 << bit;
                if let Ok(texture) = texture::decode(&bad) {
                    assert_eq!(texture.texels.len() as u32, texture.width * texture.height);
                    assert!(texture.texels.iter().flatten().all(|value| value.is_finite()));
                }
            }
        }
    }
}

#[test]
fn faults_say_what_is_wrong() {
    let decode = |bytes: &[u8]| texture::decode(bytes).unwrap_err();
    assert!(
        decode(b"GIF89a").message.starts_with("is a GIF, which is not read as a picture: save")
    );
    let short = decode(&ppm()[..40]);
    assert_eq!((short.byte, short.message.as_str()), (Some(40), "the file ends too early"));
    let head = decode(b"P6 5 x 255\n");
    assert_eq!((head.byte, head.message.as_str()), (Some(5), "the head needs a number here"));
    let high = decode(b"P5 1 1 100\n\x65");
    assert_eq!((high.byte, high.message.as_str()), (Some(11), "the sample 101 is above 100"));
    let huge = decode(b"P6 65535 65535 255\n");
    assert_eq!(
        huge.message,
        "has 65535 x 65535 pixels, which take 61439 MiB to read; pictures may take 1024 MiB in all: \
         make it smaller"
    );
    assert!(decode(b"P6 0 5 255\n").message.starts_with("has 0 x 5 pixels; edges are 1 to 65535"));
}

#[test]
fn a_texture_is_read_once_from_inside_the_folder() {
    let room = tempfile::tempdir().unwrap();
    std::fs::create_dir(room.path().join("scene")).unwrap();
    std::fs::write(room.path().join("scene/a.ppm"), ppm()).unwrap();
    std::fs::write(room.path().join("scene/bad.ppm"), b"P6 1 1 255\n").unwrap();
    std::fs::write(room.path().join("secret.ppm"), ppm()).unwrap();
    let assets = Assets::new(room.path().join("scene"));
    let first = assets.texture("a.ppm").unwrap();
    assert!(Arc::ptr_eq(&first, &assets.texture("./a.ppm").unwrap()));
    let error = assets.texture("bad.ppm").unwrap_err();
    let path = room.path().join("scene/bad.ppm").display().to_string();
    assert_eq!(error.to_string(), format!("{path}: byte 11: the file ends too early"));
    assert_eq!(assets.texture("../secret.ppm").unwrap_err().cause(), Cause::Forbidden);
    assert_eq!(assets.texture("none.png").unwrap_err().cause(), Cause::Missing);
    assert_eq!(assets.asked().len(), 4);
}

/// Pictures that other programs have written.
#[test]
fn files_of_other_programs() {
    let room = tempfile::tempdir().unwrap();
    let script = "
import sys
from PIL import Image
picture = Image.new('RGB', (40, 24))
picture.putdata([(i % 40 * 6, i // 40 * 10, 99) for i in range(40 * 24)])
picture.save('a.png')
picture.save('a.ppm')
picture.quantize(256).save('palette.png')
picture.convert('L').save('grey.jpg', quality=95)
picture.save('a.jpg', quality=95, progressive=True)
picture.convert('CMYK').save('cmyk.jpg', quality=95)
";
    let python = Command::new("python3").args(["-c", script]).current_dir(room.path()).output();
    if !python.is_ok_and(|ran| ran.status.success()) {
        let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
        assert!(!required, "Pillow is not there");
        return println!("skipped: Pillow is not there");
    }
    let assets = Assets::new(room.path().to_owned());
    let exact = assets.texture("a.png").unwrap();
    assert_eq!((exact.width, exact.height), (40, 24));
    let want: Vec<u8> =
        (0..40 * 24).flat_map(|i| [(i % 40 * 6) as u8, (i / 40 * 10) as u8, 99]).collect();
    near(&exact, &expected(&want));
    assert_eq!(assets.texture("a.ppm").unwrap(), exact);
    for (name, most) in [("palette.png", 0.15), ("a.jpg", 0.06), ("cmyk.jpg", 0.1)] {
        let texture = assets.texture(name).unwrap();
        let worst = texture.texels.iter().flatten().zip(exact.texels.iter().flatten());
        let worst = worst.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < most, "{name}: {worst}");
    }
    let grey = assets.texture("grey.jpg").unwrap();
    assert!(grey.texels.iter().all(|[r, g, b]| r == g && g == b));
}
