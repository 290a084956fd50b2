//! PNG of every depth, with or without palette, transparency and interlacing, and what it says of its
//! curve: `cICP` before `iCCP` before `sRGB` before `gAMA` (W3C PNG, third edition, 4.3).

use super::{Curve, Orientation, Raster, Room, Samples, profile_note, wide, zeros};
use crate::error::Fault;
use png::{BitDepth, ColorType, Decoder, Info, Transformations};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8], room: Room) -> Result<Raster, Fault> {
    let broken = |error: png::DecodingError| Fault::file(format!("the PNG is broken: {error}"));
    let mut decoder = Decoder::new(Cursor::new(bytes));
    let head = decoder.read_header_info().map_err(broken)?;
    let (width, height) = head.size();
    let (indexed, depth) = (head.color_type == ColorType::Indexed, head.bit_depth);
    // A file with a palette is unpacked here, since the decoder takes a missing entry for black.
    decoder.set_transformations(match indexed {
        true => Transformations::IDENTITY,
        false => Transformations::EXPAND,
    });
    let mut reader = decoder.read_info().map_err(broken)?;
    let length = reader.output_buffer_size().ok_or_else(|| Fault::file("is too large"))?;
    let packed = (length as u64).div_ceil((u64::from(width) * u64::from(height)).max(1));
    // Samples of 16 bits are there in bytes and in numbers, and colours beside their indices.
    let each = match depth {
        _ if indexed => packed + 4,
        BitDepth::Sixteen => 2 * packed,
        _ => packed,
    };
    room.pixels(width.into(), height.into(), each)?;
    let mut packed: Vec<u8> = zeros(length)?;
    let row = reader.output_line_size(width).ok_or_else(|| Fault::file("is too large"))?;
    reader.next_frame(&mut packed).map_err(broken)?;
    // To the end, so that what comes after the picture is held against its checksums.
    reader.finish().map_err(broken)?;
    let (colour, depth) = reader.output_color_type();
    let info = reader.info();
    let (channels, samples) = match depth {
        _ if indexed => {
            let palette = Palette::of(info)?;
            (palette.channels, Samples::U8(palette.unpack(&packed, row, info)?))
        }
        BitDepth::Sixteen => {
            (colour.samples(), Samples::U16 { values: wide(&packed), most: u16::MAX })
        }
        _ => (colour.samples(), Samples::U8(packed)),
    };
    let mut notes = Vec::new();
    let curve = curve(info, &mut notes)?;
    if info.animation_control.is_some_and(|animation| animation.num_frames > 1) {
        notes.push("it is an animation: its first picture alone is read".to_owned());
    }
    let turned = info.exif_metadata.as_deref().and_then(Orientation::from_exif_chunk);
    let orientation = turned.unwrap_or(Orientation::NoTransforms);
    Ok(Raster { width, height, channels, samples, curve, orientation, notes })
}

/// The colours that indices stand for.
struct Palette {
    channels: usize,
    colours: Vec<[u8; 4]>,
}

impl Palette {
    fn of(info: &Info<'_>) -> Result<Palette, Fault> {
        let entries = info.palette.as_deref().unwrap_or_default();
        let (triples, rest) = entries.as_chunks::<3>();
        if triples.is_empty() || triples.len() > 256 || !rest.is_empty() {
            let message = format!("its palette of {} bytes is broken", entries.len());
            return Err(Fault::file(format!("the PNG is broken: {message}")));
        }
        let opacity = info.trns.as_deref().unwrap_or_default();
        if opacity.len() > triples.len() {
            let message = "the PNG is broken: it has more opacities (tRNS) than colours";
            return Err(Fault::file(message));
        }
        let opacities = opacity.iter().copied().chain(std::iter::repeat(255));
        let colours = triples.iter().zip(opacities).map(|([r, g, b], a)| [*r, *g, *b, a]);
        let channels = if opacity.is_empty() { 3 } else { 4 };
        Ok(Palette { channels, colours: colours.collect() })
    }

    /// The colours of indices that lie in `row` bytes a row.
    fn unpack(&self, packed: &[u8], row: usize, info: &Info<'_>) -> Result<Vec<u8>, Fault> {
        let (width, height) = (info.width as usize, info.height as usize);
        let depth = info.bit_depth as usize;
        let mut samples = super::reserved(width * height * self.channels)?;
        for (y, line) in packed.chunks_exact(row).take(height).enumerate() {
            for x in 0..width {
                let bit = x * depth;
                // The leftmost pixel has the highest bits of its byte.
                let shift = 8 - depth - bit % 8;
                let index = usize::from(line[bit / 8] >> shift) & ((1 << depth) - 1);
                let colour = self.colours.get(index).ok_or_else(|| {
                    Fault::file(format!(
                        "the PNG is broken: the pixel in column {x} and row {y} has colour {index} of a \
                         palette of {}",
                        self.colours.len()
                    ))
                })?;
                samples.extend_from_slice(&colour[..self.channels]);
            }
        }
        Ok(samples)
    }
}

/// The primaries of sRGB and its white (ITU-R BT.709), times 100,000: white, red, green, blue.
const PRIMARIES: [[u32; 2]; 4] = [[31270, 32900], [64000, 33000], [30000, 60000], [15000, 6000]];

fn curve(info: &Info<'_>, notes: &mut Vec<String>) -> Result<Curve, Fault> {
    let other = "its primaries are left out: its colours are taken as those of sRGB";
    if let Some(points) = info.coding_independent_code_points {
        if points.matrix_coefficients != 0 || !points.is_video_full_range_image {
            let message =
                "its samples are of narrow range (cICP), which is not read: save it as sRGB";
            return Err(Fault::file(message));
        }
        // 1 are those of sRGB, 2 are unspecified.
        if !matches!(points.color_primaries, 1 | 2) {
            notes.push(other.to_owned());
        }
        // ITU-T H.273, table 3.
        return Ok(match points.transfer_function {
            4 => Curve::Power(2.2),
            5 => Curve::Power(2.8),
            8 => Curve::Linear,
            16 | 18 => {
                let name = if points.transfer_function == 16 { "PQ" } else { "HLG" };
                let message = format!(
                    "its samples follow the curve {name} of HDR video, which is not read: save it as EXR \
                     or as sRGB"
                );
                return Err(Fault::file(message));
            }
            2 | 13 => Curve::Srgb,
            kind => {
                notes.push(format!("its transfer function {kind} (cICP) is taken as sRGB"));
                Curve::Srgb
            }
        });
    }
    if let Some(profile) = &info.icc_profile {
        notes.extend(profile_note(profile));
        return Ok(Curve::Srgb);
    }
    if info.srgb.is_some() {
        return Ok(Curve::Srgb);
    }
    if let Some(own) = info.chrm_chunk {
        let own = [own.white, own.red, own.green, own.blue];
        let own = own.map(|(x, y)| [x, y].map(|value| value.into_scaled()));
        // Files round them to three or four places.
        let far = |(a, b): (&u32, &u32)| a.abs_diff(*b) > 100;
        if own.as_flattened().iter().zip(PRIMARIES.as_flattened()).any(far) {
            notes.push(other.to_owned());
        }
    }
    let Some(gamma) = info.gama_chunk else { return Ok(Curve::Srgb) };
    Ok(match gamma.into_scaled() {
        // 1 / 2.2 is what programs write that mean sRGB.
        45_000..=46_000 => Curve::Srgb,
        100_000 => Curve::Linear,
        gamma => Curve::Power(100_000.0 / f64::from(gamma)),
    })
}
