//! WebP, TIFF, BMP, TGA, QOI and Radiance HDR, through the crate `image`.

use super::format::Format;
use super::{Curve, Raster, Room, Samples, profile_note, zeros};
use crate::error::Fault;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8], format: Format, room: Room) -> Result<Raster, Fault> {
    let known = match format {
        Format::WebP => ImageFormat::WebP,
        Format::Tiff => ImageFormat::Tiff,
        Format::Bmp => ImageFormat::Bmp,
        Format::Tga => ImageFormat::Tga,
        Format::Qoi => ImageFormat::Qoi,
        _ => ImageFormat::Hdr,
    };
    let name = format.name();
    let wrong = |error: ImageError| match error {
        ImageError::Unsupported(what) => {
            Fault::file(format!("the {name} is of a kind that is not read: {}", line(&what)))
        }
        ImageError::Limits(what) => {
            Fault::file(format!("the {name} takes too much memory to read: {}", line(&what)))
        }
        other => Fault::file(format!("the {name} is broken: {}", line(&other))),
    };
    let mut limits = Limits::default();
    limits.max_image_width = Some(super::LONGEST_EDGE);
    limits.max_image_height = Some(super::LONGEST_EDGE);
    limits.max_alloc = Some(room.left);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), known);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(wrong)?;
    let (width, height) = decoder.dimensions();
    let colour = decoder.color_type();
    let channels = usize::from(colour.channel_count());
    // The decoders work in a buffer of their own, and there are samples in bytes and in numbers.
    let count =
        room.pixels(width.into(), height.into(), 3 * u64::from(colour.bytes_per_pixel()))?;
    let mut notes = Vec::new();
    if let Ok(Some(profile)) = decoder.icc_profile() {
        notes.extend(profile_note(&profile));
    }
    notes.extend(more(bytes, format));
    let orientation = decoder.orientation().map_err(wrong)?;
    let mut raw: Vec<u8> = zeros(count * usize::from(colour.bytes_per_pixel()))?;
    decoder.read_image(&mut raw).map_err(wrong)?;
    let (samples, curve) = match colour {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            (Samples::U8(raw), Curve::Srgb)
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let pairs = raw.as_chunks::<2>().0.iter();
            let values = pairs.map(|pair| u16::from_ne_bytes(*pair)).collect();
            (Samples::U16 { values, most: u16::MAX }, Curve::Srgb)
        }
        // Floats are intensities.
        _ => {
            let fours = raw.as_chunks::<4>().0.iter();
            (Samples::F32(fours.map(|four| f32::from_ne_bytes(*four)).collect()), Curve::Linear)
        }
    };
    Ok(Raster { width, height, channels, samples, curve, orientation, notes })
}

/// What follows the first picture.
fn more(bytes: &[u8], format: Format) -> Option<String> {
    let note = match format {
        // The extended head says whether frames follow (RFC 9649, 2.7).
        Format::WebP => {
            let moves = bytes.get(12..16) == Some(b"VP8X") && bytes.get(20)? & 2 != 0;
            moves.then_some("it is an animation: its first picture alone is read")
        }
        Format::Tiff => directory_after(bytes)
            .is_some_and(|next| next != 0)
            .then_some("it holds more pictures than one: the first is read"),
        _ => None,
    };
    note.map(str::to_owned)
}

/// Where a TIFF's second directory lies; 0 if there is none (TIFF 6.0, section 2; BigTIFF has wider
/// numbers).
fn directory_after(bytes: &[u8]) -> Option<u64> {
    let little = bytes[0] == b'I';
    let number = |at: u64, size: usize| -> Option<u64> {
        let at = usize::try_from(at).ok()?;
        let field = bytes.get(at..at.checked_add(size)?)?.iter();
        let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(if little { field.rev().fold(0, join) } else { field.fold(0, join) })
    };
    let (first, count, entry, size) = match number(2, 2)? {
        43 => (number(8, 8)?, 8, 20, 8),
        _ => (number(4, 4)?, 2, 12, 4),
    };
    let entries = number(first, count)?.checked_mul(entry)?;
    number(first.checked_add(count as u64)?.checked_add(entries)?, size)
}

/// Words of others on one line.
fn line(words: &dyn std::fmt::Display) -> String {
    words.to_string().replace(char::is_control, " ")
}
