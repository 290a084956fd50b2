//! PNG, JPEG, OpenEXR and PPM to texels in linear intensities.
//!
//! The bytes tell the format. Samples of 8 and 16 bits go through the curve of sRGB (IEC 61966-2-1),
//! whatever a file says of its colours; EXR is taken as it is. Transparency is left out, and grey
//! becomes three equal numbers.

use crate::error::Fault;
use reflet_scene::Texture;
use std::io::Cursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// The most texels: 1.6 GB.
pub const MOST_TEXELS: u64 = 1 << 27;

/// The longest edge.
pub const LONGEST_EDGE: u32 = 65_535;

/// The texture in a file given as its bytes.
///
/// # Errors
/// What is no such file, is broken or too large, or holds numbers that are not finite; where the
/// decoder does not tell a place, of the whole file.
pub fn decode(bytes: &[u8]) -> Result<Texture, Fault> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        png(bytes)
    } else if bytes.starts_with(&[0xff, 0xd8]) {
        jpeg(bytes)
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr(bytes)
    } else if bytes.starts_with(b"P6") || bytes.starts_with(b"P5") {
        netpbm(bytes)
    } else {
        Err(Fault::file("is no PNG, JPEG, EXR or PPM file"))
    }
}

/// How many texels there are, if they are not too many.
fn texels(width: u64, height: u64) -> Result<usize, Fault> {
    let edges = 1..=u64::from(LONGEST_EDGE);
    if !edges.contains(&width) || !edges.contains(&height) || width * height > MOST_TEXELS {
        let message = format!(
            "has {width} x {height} texels; edges are 1 to {LONGEST_EDGE}, and all together at most \
             {MOST_TEXELS}"
        );
        return Err(Fault::file(message));
    }
    Ok((width * height) as usize)
}

fn reserved<T>(count: usize) -> Result<Vec<T>, Fault> {
    let mut all = Vec::new();
    all.try_reserve_exact(count).map_err(|_| Fault::file("there is no memory for its texels"))?;
    Ok(all)
}

/// sRGB to linear, of a sample in 0..=1.
pub(crate) fn linear(sample: f64) -> f32 {
    let linear = match sample <= 0.04045 {
        true => sample / 12.92,
        false => libm::pow((sample + 0.055) / 1.055, 2.4),
    };
    linear as f32
}

/// The intensities of all samples of 8 bits.
fn table8() -> [f32; 256] {
    std::array::from_fn(|sample| linear(sample as f64 / 255.0))
}

/// The intensities of all samples up to `most`.
fn table16(most: u32) -> Vec<f32> {
    (0..=most).map(|sample| linear(f64::from(sample) / f64::from(most))).collect()
}

/// Pixels of one to four samples, of which one is grey, two grey and opacity, four colour and opacity.
fn rgb(pixel: &[f32]) -> [f32; 3] {
    match *pixel {
        [r, g, b, ..] => [r, g, b],
        [grey, ..] => [grey; 3],
        [] => [0.0; 3],
    }
}

fn png(bytes: &[u8]) -> Result<Texture, Fault> {
    let broken = |error: png::DecodingError| Fault::file(format!("the PNG is broken: {error}"));
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = reader.info().size();
    let count = texels(width.into(), height.into())?;
    let (colour, depth) = reader.output_color_type();
    let length = reader.output_buffer_size().ok_or_else(|| Fault::file("is too large"))?;
    let mut samples: Vec<u8> = reserved(length)?;
    samples.resize(length, 0);
    reader.next_frame(&mut samples).map_err(broken)?;
    // To the end, so that what comes after the picture is held against its checksums.
    reader.finish().map_err(broken)?;
    let channels = colour.samples();
    let mut all = reserved(count)?;
    if depth == png::BitDepth::Sixteen {
        let table = table16(65_535);
        for pixel in samples.chunks_exact(2 * channels).take(count) {
            let mut values = [0.0; 4];
            for (value, pair) in values.iter_mut().zip(pixel.as_chunks::<2>().0) {
                *value = table[usize::from(u16::from_be_bytes(*pair))];
            }
            all.push(rgb(&values[..channels]));
        }
    } else {
        let table = table8();
        for pixel in samples.chunks_exact(channels).take(count) {
            let mut values = [0.0; 4];
            for (value, sample) in values.iter_mut().zip(pixel) {
                *value = table[usize::from(*sample)];
            }
            all.push(rgb(&values[..channels]));
        }
    }
    whole(width, height, all)
}

/// Whether the marker of a JPEG's end comes after its first scan (ITU-T T.81, annex B): before that
/// there may be another picture, small, with an end of its own.
fn has_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, kind]) = bytes.get(at..at + 2) {
        match (kind, bytes.get(at + 2..at + 4)) {
            (0xda, _) => return bytes[at..].windows(2).any(|pair| pair == [0xff, 0xd9]),
            (0xff, _) => at += 1,
            (0x01 | 0xd0..=0xd7, _) => at += 2,
            (_, Some(&[high, low])) => at += 2 + usize::from(u16::from_be_bytes([high, low])),
            _ => return false,
        }
    }
    false
}

fn jpeg(bytes: &[u8]) -> Result<Texture, Fault> {
    let options = DecoderOptions::default()
        .set_max_width(LONGEST_EDGE as usize)
        .set_max_height(LONGEST_EDGE as usize)
        .set_strict_mode(true)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let broken =
        |error: &dyn std::fmt::Display| Fault::file(format!("the JPEG is broken: {error}"));
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| broken(&error))?;
    if !has_end(bytes) {
        // The decoder fills in what is missing with grey.
        return Err(Fault::byte(bytes.len(), "the file ends too early"));
    }
    let (width, height) = decoder.dimensions().ok_or_else(|| broken(&"it has no size"))?;
    let count = texels(width as u64, height as u64)?;
    let samples = decoder.decode().map_err(|error| broken(&error))?;
    let table = table8();
    let mut all = reserved(count)?;
    let pixels = samples.as_chunks::<3>().0.iter();
    all.extend(pixels.take(count).map(|pixel| pixel.map(|sample| table[usize::from(sample)])));
    whole(width as u32, height as u32, all)
}

/// Texels as an EXR's reader fills them in, and how many are across.
type Filling = (Vec<[f32; 3]>, usize);

fn fill((all, width): &mut Filling, x: usize, y: usize, texel: [f32; 3]) {
    if let Some(place) = all.get_mut(y * *width + x) {
        *place = texel;
    }
}

fn exr(bytes: &[u8]) -> Result<Texture, Fault> {
    use ::exr::meta::MetaData;
    use ::exr::prelude::*;
    let broken = |error: Error| Fault::file(format!("the EXR is broken: {error}"));
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(broken)?;
    // Nothing is reserved for what a head says before it is known to be within bounds.
    for header in &meta.headers {
        let size = header.layer_size;
        reserved::<[f32; 3]>(texels(size.width() as u64, size.height() as u64)?)?;
    }
    let blank = |size: Vec2<usize>| -> Filling { (vec![[0.0; 3]; size.area()], size.width()) };
    let named = |name: &str| {
        let mut channels = meta.headers.iter().flat_map(|header| &header.channels.list);
        channels.any(|channel| channel.name == *name)
    };
    let read = read().no_deep_data().largest_resolution_level();
    let (size, (all, _)) = if named("R") && named("G") && named("B") {
        let colours = read.rgb_channels(
            |size, _| blank(size),
            |filling: &mut Filling, at, (r, g, b)| fill(filling, at.x(), at.y(), [r, g, b]),
        );
        let read = colours.first_valid_layer().all_attributes().non_parallel();
        let layer = read.from_buffered(Cursor::new(bytes)).map_err(broken)?.layer_data;
        (layer.size, layer.channel_data.pixels)
    } else if named("Y") {
        let greys = read.specific_channels().required("Y").collect_pixels(
            |size, _| blank(size),
            |filling: &mut Filling, at, (y,): (f32,)| fill(filling, at.x(), at.y(), [y; 3]),
        );
        let read = greys.first_valid_layer().all_attributes().non_parallel();
        let layer = read.from_buffered(Cursor::new(bytes)).map_err(broken)?.layer_data;
        (layer.size, layer.channel_data.pixels)
    } else {
        return Err(Fault::file("the EXR has no layer with channels R, G and B, or Y"));
    };
    whole(size.width() as u32, size.height() as u32, all)
}

/// PPM and PGM, binary, of 8 or 16 bits.
fn netpbm(bytes: &[u8]) -> Result<Texture, Fault> {
    let channels = if bytes.starts_with(b"P6") { 3 } else { 1 };
    let mut at = 2;
    let mut numbers = [0_u64; 3];
    for number in &mut numbers {
        let start = at;
        loop {
            match bytes.get(at) {
                Some(b'#') => {
                    let rest = bytes[at..].iter().position(|b| *b == b'\n');
                    at += rest.ok_or_else(|| Fault::byte(at, "the head ends too early"))?;
                }
                Some(byte) if byte.is_ascii_whitespace() => at += 1,
                _ => break,
            }
        }
        let digits = bytes[at..].iter().take_while(|b| b.is_ascii_digit()).count();
        let text = std::str::from_utf8(&bytes[at..at + digits]).unwrap_or_default();
        let parsed = text.parse().ok().filter(|_| at > start && digits < 10);
        *number = parsed.ok_or_else(|| Fault::byte(at, "the head needs a number here"))?;
        at += digits;
    }
    let [width, height, most] = numbers;
    if !(1..=65_535).contains(&most) {
        let message = format!("samples up to {most}: they must be 1 to 65535");
        return Err(Fault::byte(at, message));
    }
    let count = texels(width, height)?;
    if !bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
        return Err(Fault::byte(at, "a blank belongs between the head and the samples"));
    }
    let samples = &bytes[at + 1..];
    let wide = if most > 255 { 2 } else { 1 };
    if samples.len() < count * channels * wide {
        return Err(Fault::byte(bytes.len(), "the file ends too early"));
    }
    let table = table16(most as u32);
    let mut all = reserved(count)?;
    for (index, pixel) in samples.chunks_exact(channels * wide).take(count).enumerate() {
        let mut values = [0.0; 3];
        for (i, (value, raw)) in values.iter_mut().zip(pixel.chunks_exact(wide)).enumerate() {
            let sample = raw.iter().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
            *value = *table.get(sample).ok_or_else(|| {
                let byte = at + 1 + (index * channels + i) * wide;
                Fault::byte(byte, format!("the sample {sample} is above {most}"))
            })?;
        }
        all.push(rgb(&values[..channels]));
    }
    whole(width as u32, height as u32, all)
}

/// A texture of finite numbers.
fn whole(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Result<Texture, Fault> {
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(Fault::file("the file ends too early"));
    }
    let finite = |texel: &[f32; 3]| texel.iter().all(|value| value.is_finite());
    if let Some(at) = texels.iter().position(|texel| !finite(texel)) {
        let (x, y) = (at as u32 % width, at as u32 / width);
        return Err(Fault::file(format!("the texel in column {x} and row {y} is not finite")));
    }
    Ok(Texture { width, height, texels })
}
