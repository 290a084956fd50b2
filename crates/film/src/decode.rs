//! Pictures back from files: those that this crate writes and that are joined to films or to one
//! picture.

use crate::picture::{Layout, Picture, SampleKind};
use crate::transfer::Transfer;
use crate::{exr, netpbm, png, qoi};

/// What a still's file says before its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StillHead {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// What its integer samples went through, if the file says so.
    pub transfer: Option<Transfer>,
}

/// The formats that are read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
    Qoi,
    Jpeg,
    Ppm,
    Pfm,
}

fn kind(bytes: &[u8]) -> Result<Kind, String> {
    let kinds: [(&[u8], Kind); 6] = [
        (&png::SIGNATURE, Kind::Png),
        (&exr::MAGIC, Kind::Exr),
        (qoi::MAGIC, Kind::Qoi),
        (&[0xff, 0xd8], Kind::Jpeg),
        (b"P6", Kind::Ppm),
        (b"PF", Kind::Pfm),
    ];
    let found = kinds.into_iter().find(|(magic, _)| bytes.starts_with(magic));
    found.map(|(_, kind)| kind).ok_or_else(|| "it is no PNG, EXR, QOI, JPEG, PPM or PFM".to_owned())
}

fn cut() -> String {
    "it ends too early".to_owned()
}

/// What a still says before its pixels, given as its bytes. A size that so few bytes cannot hold is
/// refused: nothing is allocated for it.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn still_head(bytes: &[u8]) -> Result<StillHead, String> {
    let kind = kind(bytes)?;
    // The least bits of the file that a pixel takes: deflate makes at most 1032 bytes of one, QOI 62
    // pixels, and a JPEG has at least two bits for a block of 8 x 8, which stands for 16 x 16 pixels
    // where it is of one channel of chroma.
    let (head, pixels_a_byte) = match kind {
        Kind::Png => (png::read_head(bytes)?, 8 * 1032),
        Kind::Exr => (StillHead { size: exr::read_header(bytes)?.size()?, transfer: None }, 1032),
        Kind::Qoi => (qoi::read_head(bytes)?, 62),
        Kind::Jpeg => (StillHead { size: jpeg_size(bytes)?, transfer: None }, 1024),
        Kind::Ppm => (StillHead { size: netpbm::read_head(bytes)?.size, transfer: None }, 1),
        Kind::Pfm => (StillHead { size: netpbm::read_head(bytes)?.size, transfer: None }, 1),
    };
    let [width, height] = head.size.map(u64::from);
    if width * height > pixels_a_byte * bytes.len() as u64 {
        return Err(format!(
            "it has {width} x {height} pixels and {} bytes: {}",
            bytes.len(),
            cut()
        ));
    }
    Ok(head)
}

/// The picture in a PNG, a QOI or a JPEG (any), an EXR, a PPM or a PFM (ours), given as its bytes. EXR
/// and PFM come as floats, the others as 8 bits of red, green and blue: 16 bits are rounded,
/// transparency is left out.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn decode_still(bytes: &[u8]) -> Result<Picture, String> {
    let size = still_head(bytes)?.size;
    match kind(bytes)? {
        Kind::Png | Kind::Jpeg => {
            let decoded = reflet_assets::rgb8::decode(bytes)?;
            of_rows([decoded.width, decoded.height], &decoded.pixels)
        }
        Kind::Exr => exr::decode(bytes),
        Kind::Qoi => of_rows(size, &qoi::decode(bytes, size)?),
        Kind::Ppm => of_rows(size, netpbm::ppm_samples(bytes)?),
        Kind::Pfm => {
            let mut picture = blank(size, SampleKind::F32)?;
            netpbm::pfm_rows(bytes, |y, row| picture.set_row(0, y, row))?;
            Ok(picture)
        }
    }
}

fn blank([width, height]: [u32; 2], kind: SampleKind) -> Result<Picture, String> {
    let layout = Layout::try_new(width, height, 16).map_err(|error| error.to_string())?;
    Picture::try_new(layout, kind).map_err(|error| error.to_string())
}

/// A picture of 8-bit rows, one after the other.
fn of_rows(size: [u32; 2], samples: &[u8]) -> Result<Picture, String> {
    let mut picture = blank(size, SampleKind::U8)?;
    let line = size[0] as usize * 3;
    if samples.len() < line * size[1] as usize {
        return Err(cut());
    }
    for (y, row) in samples.chunks_exact(line).take(size[1] as usize).enumerate() {
        picture.set_row(0, y as u32, row);
    }
    Ok(picture)
}

/// The size of a JPEG of one scan, as cameras and this crate write it.
fn jpeg_size(bytes: &[u8]) -> Result<[u32; 2], String> {
    let (mut at, mut size) = (2, None);
    loop {
        let [0xff, marker, high, low] = *bytes.get(at..at + 4).ok_or_else(cut)? else {
            return Err("its markers are broken".to_owned());
        };
        let length = usize::from(u16::from_be_bytes([high, low]));
        let data = bytes.get(at + 4..(at + 2 + length).max(at + 4)).ok_or_else(cut)?;
        match (marker, data) {
            (0xc0..=0xc2, [_, h0, h1, w0, w1, ..]) => {
                size =
                    Some([[*w0, *w1], [*h0, *h1]].map(|edge| u32::from(u16::from_be_bytes(edge))));
            }
            (0xda, _) => {
                // In a scan, 0xff is followed by 0 or a restart.
                let scans = bytes[at + 2..].windows(2).filter(|pair| *pair == [0xff, 0xda]).count();
                if scans > 0 {
                    return Err("it is a JPEG in several scans, which are not read here".to_owned());
                }
                return size.ok_or_else(|| "its size comes too late".to_owned());
            }
            _ => {}
        }
        at += 2 + length.max(2);
    }
}
