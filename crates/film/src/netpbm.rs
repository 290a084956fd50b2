//! PPM and PFM: a line of text and the samples.

use crate::picture::Picture;

/// Binary PPM, 8 bits, rows from the top.
pub(crate) fn ppm(picture: &Picture) -> Vec<u8> {
    let (width, height) = (picture.layout().width(), picture.layout().height());
    let header = format!("P6\n{width} {height}\n255\n");
    let mut bytes = Vec::with_capacity(header.len() + width as usize * height as usize * 3);
    bytes.extend_from_slice(header.as_bytes());
    for y in 0..height {
        for piece in picture.row_pieces::<u8>(y) {
            bytes.extend_from_slice(piece);
        }
    }
    bytes
}

/// Colour PFM, little-endian floats, rows from the bottom, as the format has it.
pub(crate) fn pfm(picture: &Picture) -> Vec<u8> {
    let (width, height) = (picture.layout().width(), picture.layout().height());
    let header = format!("PF\n{width} {height}\n-1.0\n");
    let mut bytes = Vec::with_capacity(header.len() + width as usize * height as usize * 12);
    bytes.extend_from_slice(header.as_bytes());
    for y in (0..height).rev() {
        for piece in picture.row_pieces::<f32>(y) {
            bytes.extend(piece.iter().flat_map(|sample| sample.to_le_bytes()));
        }
    }
    bytes
}
