//! Reading back our own EXR files: one part of scan lines, channels B, G, R, stored or ZIP.

use crate::picture::{Layout, Picture, SampleKind};
use half::f16;
use std::ops::Range;

/// The first bytes of every EXR file.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// What a header says.
#[derive(Debug)]
pub(crate) struct Header {
    /// Its string attributes, in order.
    pub texts: Vec<(String, String)>,
    channels: Vec<u8>,
    compression: u8,
    window: [i32; 4],
    /// Where the table of offsets begins.
    end: usize,
}

impl Header {
    /// Width and height in pixels.
    pub fn size(&self) -> Result<[u32; 2], String> {
        let [left, top, right, bottom] = self.window.map(i64::from);
        let edges = [right - left + 1, bottom - top + 1].map(u32::try_from);
        let [Ok(width @ 1..), Ok(height @ 1..)] = edges else {
            return Err("its size is broken".to_owned());
        };
        Ok([width, height])
    }
}

fn cut() -> String {
    "it ends too early".to_owned()
}

/// The bytes up to the next 0.
fn word(bytes: &[u8], at: &mut usize) -> Result<String, String> {
    let rest = bytes.get(*at..).ok_or_else(cut)?;
    let length = rest.iter().take(256).position(|b| *b == 0);
    let length = length.ok_or("its header is broken")?;
    *at += length + 1;
    String::from_utf8(rest[..length].to_vec()).map_err(|_| "its header is broken".to_owned())
}

fn int(bytes: &[u8], at: usize) -> Result<i32, String> {
    let four = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
    four.map(i32::from_le_bytes).ok_or_else(cut)
}

/// Reads the header of an EXR file.
///
/// # Errors
/// What is wrong, in words.
pub(crate) fn read_header(bytes: &[u8]) -> Result<Header, String> {
    let mut header = Header {
        texts: Vec::new(),
        channels: Vec::new(),
        compression: u8::MAX,
        window: [0; 4],
        end: 0,
    };
    let mut at = 8;
    while *bytes.get(at).ok_or_else(cut)? != 0 {
        let (name, kind) = (word(bytes, &mut at)?, word(bytes, &mut at)?);
        let size = usize::try_from(int(bytes, at)?).map_err(|_| "its header is broken")?;
        at += 4;
        let value = bytes.get(at..).and_then(|rest| rest.get(..size)).ok_or_else(cut)?;
        match (name.as_str(), kind.as_str()) {
            ("channels", _) => header.channels = value.to_vec(),
            ("compression", _) => header.compression = value.first().copied().unwrap_or(u8::MAX),
            ("dataWindow", "box2i") => {
                for (i, corner) in header.window.iter_mut().enumerate() {
                    *corner = int(value, 4 * i)?;
                }
            }
            (_, "string") => {
                let text = String::from_utf8(value.to_vec());
                header.texts.push((name, text.map_err(|_| "its text is broken")?));
            }
            _ => {}
        }
        at += size;
    }
    header.end = at + 1;
    Ok(header)
}

/// The picture of an EXR file that this crate wrote, as 32-bit floats.
///
/// # Errors
/// What is wrong or not ours, in words.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let header = read_header(bytes)?;
    let [width, height] = header.size()?;
    let layout = Layout::try_new(width, height, 16).map_err(|e| e.to_string())?;
    let sample = match channel_type(&header.channels) {
        Some(1) => 2,
        Some(2) => 4,
        _ => return Err("its channels are not B, G and R of one kind of float".to_owned()),
    };
    let lines: usize = match header.compression {
        0 => 1,
        3 => 16,
        _ => return Err("it is compressed in a way that is not read here".to_owned()),
    };
    let mut picture =
        Picture::try_new(layout, SampleKind::F32).map_err(|error| error.to_string())?;
    let line_bytes = width as usize * 3 * sample;
    let mut row = vec![0.0; width as usize * 3];
    for (index, first) in (0..height as usize).step_by(lines).enumerate() {
        let rows = first..(first + lines).min(height as usize);
        let at = header.end + 8 * index;
        let offset = bytes.get(at..at + 8).and_then(|eight| eight.try_into().ok());
        let offset = usize::try_from(u64::from_le_bytes(offset.ok_or_else(cut)?));
        let offset = offset.map_err(|_| cut())?;
        let block = block(bytes, offset, rows.clone(), line_bytes)?;
        for (y, line) in rows.zip(block.chunks_exact(line_bytes)) {
            let value = |channel: usize, x: usize| -> f32 {
                let at = (channel * width as usize + x) * sample;
                if sample == 2 {
                    f16::from_le_bytes([line[at], line[at + 1]]).to_f32()
                } else {
                    f32::from_le_bytes([line[at], line[at + 1], line[at + 2], line[at + 3]])
                }
            };
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                // Channels stand in the order of their names.
                for (i, v) in pixel.iter_mut().enumerate() {
                    *v = value(2 - i, x);
                }
            }
            picture.set_row(0, y as u32, &row);
        }
    }
    Ok(picture)
}

/// The type that B, G and R have, if there are just these.
fn channel_type(channels: &[u8]) -> Option<u8> {
    let (entries, rest) = channels.as_chunks::<18>();
    let ours = entries.len() == 3 && rest == [0];
    let named = entries.iter().zip(b"BGR").all(|(e, name)| e[0] == *name && e[1] == 0);
    let kind = entries.first()?[2];
    (ours && named && entries.iter().all(|e| e[2] == kind)).then_some(kind)
}

/// The raw bytes of one chunk of lines.
fn block(bytes: &[u8], at: usize, rows: Range<usize>, line: usize) -> Result<Vec<u8>, String> {
    let size = usize::try_from(int(bytes, at.checked_add(4).ok_or_else(cut)?)?);
    let size = size.map_err(|_| cut())?;
    let data = bytes.get(at + 8..).and_then(|rest| rest.get(..size)).ok_or_else(cut)?;
    let raw = rows.len() * line;
    if size == raw {
        return Ok(data.to_vec());
    }
    let broken = || "its lines are broken".to_owned();
    let mut packed =
        miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(data, raw).map_err(|_| broken())?;
    if packed.len() != raw {
        return Err(broken());
    }
    for i in 1..raw {
        packed[i] = packed[i].wrapping_add(packed[i - 1]).wrapping_sub(128);
    }
    let (even, odd) = packed.split_at(raw.div_ceil(2));
    Ok((0..raw).map(|i| if i % 2 == 0 { even[i / 2] } else { odd[i / 2] }).collect())
}
