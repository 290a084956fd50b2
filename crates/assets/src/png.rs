//! PNG to 8-bit red, green and blue.

use png::{BitDepth, Decoder, Transformations};
use std::io::Cursor;

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
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let (width, height) = reader.info().size();
    let (colour, depth) = reader.output_color_type();
    let length = reader.output_buffer_size().ok_or("it is larger than the address space")?;
    let mut samples = Vec::new();
    samples.try_reserve_exact(length).map_err(|_| "there is no memory for it".to_owned())?;
    samples.resize(length, 0);
    reader.next_frame(&mut samples).map_err(|error| error.to_string())?;
    if depth == BitDepth::Sixteen {
        let pairs = samples.as_chunks::<2>().0.iter();
        // 65535 is 255 times 257.
        let round = |pair: &[u8; 2]| ((u32::from(u16::from_be_bytes(*pair)) + 128) / 257) as u8;
        samples = pairs.map(round).collect();
    }
    let mut pixels = Vec::with_capacity(width as usize * height as usize * 3);
    for pixel in samples.chunks_exact(colour.samples()) {
        match *pixel {
            [r, g, b] | [r, g, b, _] => pixels.extend_from_slice(&[r, g, b]),
            [grey] | [grey, _] => pixels.extend_from_slice(&[grey; 3]),
            _ => {}
        }
    }
    Ok(Rgb8 { width, height, pixels })
}
