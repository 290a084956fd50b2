//! Kinds of pictures that are met seldom, and sizes that are too large: read right, or refused by name.

use exr::prelude::*;
use reflet_assets::texture::{self, Encoding, Read};
use reflet_assets::{Assets, Fault};
use std::path::Path;
use std::sync::Arc;

fn corpus(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn read(bytes: &[u8]) -> std::result::Result<Read, Fault> {
    texture::read(bytes, Encoding::Told)
}

fn refused(bytes: &[u8]) -> String {
    texture::decode(bytes).expect_err("a file that is not read").message
}

/// Where a JPEG's frame header begins.
fn frame(bytes: &[u8]) -> usize {
    bytes.windows(2).position(|pair| matches!(pair, [0xff, 0xc0..=0xc2])).unwrap()
}

#[test]
fn jpegs_that_are_not_read_are_told_from_their_markers() {
    assert!(refused(&corpus("jpeg/scans.jpg")).contains("a baseline picture in several scans"));
    assert!(refused(&corpus("jpeg/arith.jpg")).contains("arithmetic coding"));
    let whole = corpus("jpeg/s0.jpg");
    let at = frame(&whole);
    for (place, value, what) in [
        (at + 1, 0xc3, "lossless coding"),
        (at + 1, 0xc5, "hierarchical coding"),
        (at + 1, 0xca, "arithmetic coding"),
        (at + 4, 12, "samples of 12 bits"),
    ] {
        let mut other = whole.clone();
        other[place] = value;
        assert!(refused(&other).contains(what), "{what}: {}", refused(&other));
    }
    let mut later = whole.clone();
    later[at + 5..at + 7].fill(0);
    assert!(refused(&later).contains("DNL"), "{}", refused(&later));
    assert!(refused(&whole[..whole.len() - 20]).contains("ends too early"));
    // So many pixels cannot be in so few bytes.
    let mut wide = whole.clone();
    wide[at + 5..at + 9].copy_from_slice(&[16, 0, 16, 0]);
    assert!(refused(&wide).contains("ends too early"));
    let mut fewer = whole.clone();
    fewer[at + 14] = 0x22;
    assert!(refused(&fewer).contains("sampled less often than others"), "{}", refused(&fewer));
    for name in ["s0", "s2", "g", "prog", "cmyk", "rst", "exif", "h1v2"] {
        assert!(read(&corpus(&format!("jpeg/{name}.jpg"))).is_ok(), "{name}");
    }
}

#[test]
fn palettes_hold_every_colour_that_is_used() {
    let indexed = |palette: &[u8], opacity: Option<&[u8]>, depth, data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 1);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(depth);
        encoder.set_palette(palette.to_vec());
        if let Some(opacity) = opacity {
            encoder.set_trns(opacity.to_vec());
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    };
    use png::BitDepth::{Eight, Four, One, Two};
    let two = [0, 0, 0, 255, 255, 255];
    for (depth, data) in [
        (One, &[0b0110_0000][..]),
        (Two, &[0b0001_0100]),
        (Four, &[0x01, 0x10]),
        (Eight, &[0, 1, 1, 0]),
    ] {
        let read = read(&indexed(&two, None, depth, data)).unwrap();
        let reds: Vec<f32> = read.texture.texels.iter().map(|texel| texel[0]).collect();
        assert_eq!(reds, [0.0, 1.0, 1.0, 0.0], "{depth:?}");
        assert!(!read.transparent);
    }
    let short = refused(&indexed(&two, None, Eight, &[0, 1, 2, 0]));
    assert_eq!(
        short,
        "the PNG is broken: the pixel in column 2 and row 0 has colour 2 of a palette of 2"
    );
    assert!(read(&indexed(&two, Some(&[9]), Eight, &[1, 1, 1, 1])).is_ok_and(|r| !r.transparent));
    assert!(read(&indexed(&two, Some(&[9]), Eight, &[0, 1, 1, 1])).is_ok_and(|r| r.transparent));
    let many = refused(&indexed(&two, Some(&[9, 9, 9]), Eight, &[1; 4]));
    assert!(many.contains("more opacities (tRNS) than colours"), "{many}");
    assert!(refused(&indexed(&two[..5], None, Eight, &[0; 4])).contains("palette of 5 bytes"));
    assert!(refused(&indexed(&[], None, Eight, &[0; 4])).starts_with("the PNG is broken"));
}

/// An EXR whose data of 4 x 4 pixels begins at `place` in the window given.
fn windowed(place: (i32, i32), window: IntegerBounds) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        (at.x() as f32 + 1.0, at.y() as f32 + 1.0, 0.5_f32)
    });
    let about =
        LayerAttributes { layer_position: Vec2(place.0, place.1), ..LayerAttributes::default() };
    let layer = Layer::new((4, 4), about, exr::prelude::Encoding::SMALL_LOSSLESS, channels);
    let image = Image::empty(ImageAttributes::new(window)).with_layer(layer);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn an_exr_is_its_display_window() {
    let own = read(&corpus("exr/window.exr")).unwrap().texture;
    assert_eq!((own.width, own.height), (16, 16));
    for (i, texel) in own.texels.iter().enumerate() {
        let inside = (4..12).contains(&(i % 16)) && (4..12).contains(&(i / 16));
        assert_eq!(*texel, [if inside { 1.0 } else { 0.0 }; 3], "{i}");
    }
    let at =
        |read: &Read, x: usize, y: usize| read.texture.texels[y * read.texture.width as usize + x];
    // Beyond it on two sides, with a window that does not begin at 0.
    let beyond = read(&windowed((-3, 8), IntegerBounds::new((-2, 5), (3, 5)))).unwrap();
    assert_eq!((beyond.texture.width, beyond.texture.height), (3, 5));
    assert_eq!(beyond.notes, ["what lies outside of its display window is left out"]);
    assert_eq!(at(&beyond, 0, 2), [0.0; 3]);
    assert_eq!(at(&beyond, 0, 3), [2.0, 1.0, 0.5]);
    assert_eq!(at(&beyond, 2, 4), [4.0, 2.0, 0.5]);
    // Beside it altogether.
    let beside = read(&windowed((40, 40), IntegerBounds::new((0, 0), (2, 2)))).unwrap();
    assert_eq!(beside.texture.texels, [[0.0; 3]; 4]);
}

#[test]
fn channels_of_an_exr_are_read_or_named() {
    let file = |channels: Vec<AnyChannel<FlatSamples>>| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = Image::from_channels((2, 1), AnyChannels::sort(channels.into()));
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    };
    let floats = |name: &str| AnyChannel::new(name, FlatSamples::F32(vec![0.5, 2.0]));
    let whole = |name: &str| AnyChannel::new(name, FlatSamples::U32(vec![1, 7]));
    let half = |name: &str| {
        AnyChannel::new(name, FlatSamples::F16([0.25, 3.0].map(f16::from_f32).to_vec()))
    };
    let mixed = read(&file(vec![whole("R"), half("G"), floats("B"), floats("Z")])).unwrap();
    assert_eq!(mixed.texture.texels, [[1.0, 0.25, 0.5], [7.0, 3.0, 2.0]]);
    assert_eq!(mixed.notes, ["its channels Z are left out"]);
    let clear = read(&file(vec![floats("R"), floats("G"), floats("B"), floats("A")])).unwrap();
    assert!(clear.transparent);
    assert_eq!(read(&file(vec![half("Y")])).unwrap().texture.texels, [[0.25; 3], [3.0; 3]]);
    let chroma = refused(&file(vec![floats("Y"), floats("RY"), floats("BY")]));
    assert!(chroma.contains("luminance and chroma (channels Y, RY and BY)"), "{chroma}");
    assert_eq!(
        refused(&file(vec![floats("R"), floats("G")])),
        "the EXR has no part with channels R, G and B, or Y; it has G, R"
    );
}

#[test]
fn the_kin_of_ppm_is_read() {
    let texels = |bytes: &[u8]| read(bytes).unwrap().texture.texels.clone();
    let (black, white) = ([0.0; 3], [1.0; 3]);
    assert_eq!(texels(b"P1 # bits\n3 1\n1 0\n1"), [black, white, black]);
    assert_eq!(texels(b"P1 3 1 101"), [black, white, black]);
    assert_eq!(texels(b"P2 2 1 9 0 9"), [black, white]);
    assert_eq!(texels(b"P3 1 1 255\n255 # red\n0 0"), [[1.0, 0.0, 0.0]]);
    assert_eq!(texels(b"P4 3 2\n\xa0\x40"), [black, white, black, white, black, white]);
    let pam =
        b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 2\nMAXVAL 255\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n\xff\x07";
    assert_eq!(texels(pam), [white]);
    assert!(read(pam).unwrap().transparent);
    let floats: Vec<u8> = [1.0_f32, 2.0].iter().flat_map(|value| value.to_be_bytes()).collect();
    // The lowest row comes first.
    assert_eq!(texels(&[b"Pf\n1 2\n1.0\n", &floats[..]].concat()), [[2.0; 3], [1.0; 3]]);
    assert_eq!(refused(b"P3 1 1 255\n255 0"), "the file ends too early");
    assert_eq!(refused(b"P3 1 1 255\n255 x 0"), "a number belongs here");
    assert_eq!(refused(b"P2 1 1 9 10"), "the sample 10 is above 9");
    assert_eq!(read(b"P5 1 1 255\n\xffP5 1 1 255\n\xff").unwrap().notes.len(), 1);
}

#[test]
fn sizes_are_counted_before_anything_is_decoded() {
    let begun = std::time::Instant::now();
    let mut png = corpus("png/rgb.png");
    png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let check = crc32fast::hash(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&check);
    let mut jpeg = corpus("jpeg/prog.jpg");
    let at = frame(&jpeg);
    jpeg[at + 5..at + 9].fill(0xff);
    let mut bmp = corpus("bmp/rgb.bmp");
    bmp[18..26].copy_from_slice(&[0xff, 0xff, 0, 0, 0xff, 0xff, 0, 0]);
    let mut tga = corpus("tga/rgb-rle.tga");
    tga[12..16].fill(0xff);
    let mut qoi = corpus("qoi/rgb.qoi");
    qoi[4..12].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65535 +X 65535\n\x02\x02\xff\xff".to_vec();
    let pgm = b"P5 65535 65535 255\n".to_vec();
    let exr = windowed((0, 0), IntegerBounds::new((0, 0), (65_535, 65_535)));
    let all = [png, jpeg, bmp, tga, qoi, hdr, pgm, exr];
    for bytes in all {
        let fault = refused(&bytes);
        let sizes =
            ["has 65535 x 65535 pixels, which take ", "has 16384 x 16384 pixels, which take "];
        let told = sizes.iter().any(|size| fault.starts_with(size));
        assert!(told && fault.contains("pictures may take 1024 MiB in all"), "{fault}");
    }
    // Nothing was decoded or allocated; the bound leaves room for a busy machine.
    assert!(begun.elapsed().as_secs() < 20);
}

#[test]
fn all_textures_of_a_scene_share_one_memory() {
    let room = tempfile::tempdir().unwrap();
    let picture = |side: usize| {
        [format!("P5 {side} {side} 255\n").as_bytes(), &vec![9; side * side]].concat()
    };
    for name in ["a", "b", "c"] {
        std::fs::write(room.path().join(name), picture(100)).unwrap();
    }
    std::fs::write(room.path().join("large"), picture(200)).unwrap();
    // 10,000 texels of 12 bytes each, and a byte a sample while one is read: two fit, and not three.
    let assets = Assets::new(room.path().to_owned()).with_texture_memory(260_000);
    let a = assets.texture("a").unwrap();
    let b = assets.texture("b").unwrap();
    let error = assets.texture("c").unwrap_err().to_string();
    assert!(error.contains("c: has 100 x 100 pixels, which take 1 MiB to read; "), "{error}");
    assert!(error.contains("in all, of which 0 MiB are left: make it smaller"), "{error}");
    // One that nothing wears any longer makes room, and is read again when it is asked for.
    drop(b);
    let c = assets.texture("c").unwrap();
    assert!(Arc::ptr_eq(&a, &assets.texture("a").unwrap()));
    assert!(assets.texture("b").is_err());
    drop(c);
    assert!(assets.texture("b").is_ok());
    assert!(assets.texture("large").unwrap_err().message().starts_with("has 200 x 200 pixels"));
}
