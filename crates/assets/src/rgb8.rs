//! Pictures of whole samples to 8-bit red, green and blue, as frames of films need them: samples as they
//! are stored, through no curve.

use crate::picture::{self, Room, Samples};

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

/// Decodes a picture, given as its bytes: 16 bits are rounded to 8, transparency is left out. Of an
/// animated one, the first picture.
///
/// # Errors
/// What is wrong with the file, in words; what holds floats.
pub fn decode(bytes: &[u8]) -> Result<Rgb8, String> {
    let room = Room { most: MOST_BYTES, left: MOST_BYTES, made: 3 };
    let raster = picture::decode(bytes, room).map_err(|fault| fault.message)?;
    let samples = match raster.samples {
        Samples::U8(samples) => samples,
        Samples::U16 { values, most } => {
            let most = u32::from(most);
            values.iter().map(|value| ((u32::from(*value) * 255 + most / 2) / most) as u8).collect()
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
