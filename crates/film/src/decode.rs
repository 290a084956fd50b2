//! Pictures back from files: those that this crate writes and that are joined to films or to one
//! picture.

use crate::picture::{Layout, Picture, SampleKind};
use crate::{exr, png};

/// The picture in a PNG (any), an EXR or a PPM (ours), given as its bytes. PNG comes as 8 bits of
/// red, green and blue: 16 bits are rounded, transparency is left out; EXR comes as floats.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn decode_still(bytes: &[u8]) -> Result<Picture, String> {
    if bytes.starts_with(&png::SIGNATURE) {
        png_picture(bytes)
    } else if bytes.starts_with(&exr::MAGIC) {
        exr::decode(bytes)
    } else if bytes.starts_with(b"P6") {
        ppm_picture(bytes)
    } else {
        Err("it is no PNG, EXR or PPM".to_owned())
    }
}

fn blank(width: u32, height: u32) -> Result<Picture, String> {
    let layout = Layout::try_new(width, height, 16).map_err(|error| error.to_string())?;
    Picture::try_new(layout, SampleKind::U8).map_err(|error| error.to_string())
}

fn png_picture(bytes: &[u8]) -> Result<Picture, String> {
    let decoded = reflet_assets::png::decode(bytes)?;
    let mut picture = blank(decoded.width, decoded.height)?;
    for (y, row) in decoded.pixels.chunks_exact(decoded.width as usize * 3).enumerate() {
        picture.set_row(0, y as u32, row);
    }
    Ok(picture)
}

fn ppm_picture(bytes: &[u8]) -> Result<Picture, String> {
    let broken = || "its head is broken".to_owned();
    let mut at = 2;
    let mut numbers = [0_u32; 3];
    for number in &mut numbers {
        loop {
            match bytes.get(at).ok_or_else(broken)? {
                b'#' => {
                    let rest = bytes[at..].iter().position(|b| *b == b'\n');
                    at += rest.ok_or_else(broken)?;
                }
                b if b.is_ascii_whitespace() => at += 1,
                _ => break,
            }
        }
        let digits = bytes[at..].iter().take_while(|b| b.is_ascii_digit()).count();
        let text = std::str::from_utf8(&bytes[at..at + digits]).map_err(|_| broken())?;
        *number = text.parse().map_err(|_| broken())?;
        at += digits;
    }
    let [width, height, most] = numbers;
    if most != 255 {
        return Err("its samples have not 8 bits".to_owned());
    }
    let mut picture = blank(width, height)?;
    let line = width as usize * 3;
    let pixels = bytes.get(at + 1..).unwrap_or_default();
    if pixels.len() < line * height as usize {
        return Err("it ends too early".to_owned());
    }
    for (y, row) in pixels.chunks_exact(line).take(height as usize).enumerate() {
        picture.set_row(0, y as u32, row);
    }
    Ok(picture)
}
