//! PPM and PFM: a few words of text and the samples.

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

/// What the head of a PPM or PFM says.
pub(crate) struct Head {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The greatest sample of a PPM, the scale of a PFM, whose sign tells the order of bytes.
    last: f64,
    /// Where the samples begin.
    end: usize,
}

/// Reads the head: words with blanks or remarks between.
///
/// # Errors
/// It is broken.
pub(crate) fn read_head(bytes: &[u8]) -> Result<Head, String> {
    let broken = || "its head is broken".to_owned();
    let mut at = 2;
    let mut words = [""; 3];
    for word in &mut words {
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
        let length = bytes[at..].iter().take(32).take_while(|b| !b.is_ascii_whitespace()).count();
        *word = std::str::from_utf8(&bytes[at..at + length]).map_err(|_| broken())?;
        at += length;
    }
    let [width, height, last] = words;
    let edge = |text: &str| text.parse::<u32>().ok().filter(|edge| (1..=65_535).contains(edge));
    let size = [edge(width).ok_or_else(broken)?, edge(height).ok_or_else(broken)?];
    let last = last.parse::<f64>().ok().filter(|last| last.is_finite()).ok_or_else(broken)?;
    Ok(Head { size, last, end: at + 1 })
}

/// The samples of a PPM.
///
/// # Errors
/// They have not 8 bits.
pub(crate) fn ppm_samples(bytes: &[u8]) -> Result<&[u8], String> {
    let head = read_head(bytes)?;
    if head.last != 255.0 {
        return Err("its samples have not 8 bits".to_owned());
    }
    Ok(bytes.get(head.end..).unwrap_or_default())
}

/// The rows of a PFM, each with its number from the top.
///
/// # Errors
/// It is not of ours, or ends too early.
pub(crate) fn pfm_rows(bytes: &[u8], mut take: impl FnMut(u32, &[f32])) -> Result<(), String> {
    let Head { size: [width, height], last, end } = read_head(bytes)?;
    if last.abs() != 1.0 {
        return Err("its scale is neither -1 nor 1".to_owned());
    }
    let line = width as usize * 12;
    let data = bytes.get(end..).unwrap_or_default();
    if data.len() / line < height as usize {
        return Err("it ends too early".to_owned());
    }
    let mut row = Vec::with_capacity(width as usize * 3);
    for (y, line) in (0..height).rev().zip(data.chunks_exact(line)) {
        row.clear();
        let little = last < 0.0;
        let number = |four: &[u8; 4]| match little {
            true => f32::from_le_bytes(*four),
            false => f32::from_be_bytes(*four),
        };
        row.extend(line.as_chunks::<4>().0.iter().map(number));
        take(y, &row);
    }
    Ok(())
}
