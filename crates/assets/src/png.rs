//! PNG to 8-bit red, green and blue, as frames of films need it.

use crate::picture::{self, Room, Samples, format::Format};

/// The memory that a frame may take while it is decoded, in bytes.
const MOST_BYTES: u64 = 4 << 30;

/// A decoded picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb8 {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Red, green, blue; row by row from the top.
    pub pixels: Vec<u8>,
}

/// Decodes a PNG of any kind, given as its bytes: 16 bits are rounded to 8, transparency is left
/// out. Of an animated one, the first picture.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn decode(bytes: &[u8]) -> Result<Rgb8, String> {
    if picture::format::of(bytes).map_err(|fault| fault.message)? != Format::Png {
        return Err("is no PNG".to_owned());
    }
    let room = Room { most: MOST_BYTES, left: MOST_BYTES, made: 3 };
    let raster = picture::decode(bytes, room).map_err(|fault| fault.message)?;
    let samples = match raster.samples {
        Samples::U8(samples) => samples,
        // 65535 is 255 times 257.
        Samples::U16 { values, .. } => {
            values.iter().map(|value| ((u32::from(*value) + 128) / 257) as u8).collect()
        }
        Samples::F32(_) => return Err("its samples are no integers".to_owned()),
    };
    let count = raster.width as usize * raster.height as usize * 3;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(count).map_err(|_| "there is no memory for it".to_owned())?;
    for pixel in samples.chunks_exact(raster.channels) {
        match *pixel {
            [r, g, b] | [r, g, b, _] => pixels.extend_from_slice(&[r, g, b]),
            [grey, ..] => pixels.extend_from_slice(&[grey; 3]),
            [] => {}
        }
    }
    Ok(Rgb8 { width: raster.width, height: raster.height, pixels })
}
