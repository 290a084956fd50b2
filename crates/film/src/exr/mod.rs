//! OpenEXR: one part of scan lines, channels B, G, R of 32- or 16-bit floats, line order
//! increasing (after "OpenEXR File Layout", openexr.com). Written here so that bands keep their
//! bytes and attributes stand in a fixed order; the tests read it with the `exr` crate.

mod read;

use crate::bands::{self, Codec, KeptBands, Key, Piece};
use crate::format::Format;
use crate::picture::Picture;
use crate::still::{Compression, Encoded, StillOptions};
use half::slice::HalfFloatSliceExt;
use std::io::{self, ErrorKind};
use std::ops::Range;
use std::sync::Arc;

pub(crate) use read::{MAGIC, decode, read_header};

/// Rows of a band: a multiple of every number of lines that a chunk may hold.
const BAND_ROWS: u32 = 16;

/// How chunks are compressed.
#[derive(Clone, Copy)]
enum Method {
    /// As they are, one line a chunk.
    None,
    /// Deflate at this level, 16 lines a chunk.
    Zip(u8),
}

impl Method {
    fn of(compression: Compression) -> Self {
        match compression {
            Compression::Fast => Self::None,
            Compression::Balanced => Self::Zip(1),
            Compression::Small => Self::Zip(9),
        }
    }

    fn lines(self) -> usize {
        match self {
            Self::None => 1,
            Self::Zip(_) => 16,
        }
    }

    fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Zip(_) => 3,
        }
    }
}

/// Attribute names that the header holds already.
const OWN_ATTRIBUTES: [&str; 9] = [
    "channels",
    "chromaticities",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
];

/// The primaries and the white of Rec. ITU-R BT.709: x and y of red, green, blue and white.
const CHROMATICITIES: [f32; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];

fn attribute(header: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]) {
    for text in [name, kind] {
        header.extend_from_slice(text.as_bytes());
        header.push(0);
    }
    header.extend_from_slice(&(value.len() as u32).to_le_bytes());
    header.extend_from_slice(value);
}

fn header(picture: &Picture, half: bool, method: Method, text: &[(&str, &str)]) -> Vec<u8> {
    let (width, height) = (picture.layout().width(), picture.layout().height());
    // Names of more than 31 bytes are announced by a flag.
    let long_names = text.iter().any(|(key, _)| key.len() > 31);
    let mut header = vec![0x76, 0x2f, 0x31, 0x01, 2, if long_names { 4 } else { 0 }, 0, 0];
    let mut channels = Vec::new();
    for name in [b'B', b'G', b'R'] {
        channels.extend_from_slice(&[name, 0]);
        let pixel_type: u32 = if half { 1 } else { 2 };
        // Type, not perceptually linear (and padding), sampled at every pixel.
        for word in [pixel_type, 0, 1, 1] {
            channels.extend_from_slice(&word.to_le_bytes());
        }
    }
    channels.push(0);
    let window: Vec<u8> =
        [0, 0, width - 1, height - 1].iter().flat_map(|corner| corner.to_le_bytes()).collect();
    attribute(&mut header, "channels", "chlist", &channels);
    attribute(
        &mut header,
        "chromaticities",
        "chromaticities",
        &CHROMATICITIES.map(f32::to_le_bytes).concat(),
    );
    attribute(&mut header, "compression", "compression", &[method.code()]);
    attribute(&mut header, "dataWindow", "box2i", &window);
    attribute(&mut header, "displayWindow", "box2i", &window);
    attribute(&mut header, "lineOrder", "lineOrder", &[0]);
    let one = 1.0_f32.to_le_bytes();
    attribute(&mut header, "pixelAspectRatio", "float", &one);
    attribute(&mut header, "screenWindowCenter", "v2f", &[0; 8]);
    attribute(&mut header, "screenWindowWidth", "float", &one);
    for (key, value) in text {
        attribute(&mut header, key, "string", value.as_bytes());
    }
    header.push(0);
    header
}

pub(crate) fn encode(
    picture: &Picture,
    format: Format,
    options: &StillOptions<'_>,
    kept: Option<&mut KeptBands>,
) -> io::Result<Encoded> {
    for (index, (key, _)) in options.text.iter().enumerate() {
        let twice = options.text[..index].iter().any(|(other, _)| other == key);
        if twice || OWN_ATTRIBUTES.contains(key) {
            return Err(io::Error::new(
                ErrorKind::InvalidInput,
                format!("the text key {key:?} is taken: an EXR file names each attribute once"),
            ));
        }
    }
    let half = format == Format::Exr16;
    let method = Method::of(options.compression);
    let layout = picture.layout();
    let key = Key {
        codec: if half { Codec::Exr16 } else { Codec::Exr32 },
        compression: options.compression,
        width: layout.width(),
        height: layout.height(),
    };
    let line = layout.width() as usize * 3 * if half { 2 } else { 4 };
    let gather = |rows: Range<u32>, raw: &mut Vec<u8>| {
        if half {
            gather_half(picture, rows, raw);
        } else {
            gather_float(picture, rows, raw);
        }
    };
    let code = |index: usize, raw: &[u8], scratch: &mut Scratch| {
        let mut bytes = Vec::with_capacity(match method {
            Method::None => raw.len() + 8 * BAND_ROWS as usize,
            Method::Zip(_) => 0,
        });
        let mut lengths = Vec::new();
        let mut y = index as u32 * BAND_ROWS;
        for block in raw.chunks(line * method.lines()) {
            let start = bytes.len();
            bytes.extend_from_slice(&y.to_le_bytes());
            bytes.extend_from_slice(&[0; 4]);
            match method {
                Method::None => bytes.extend_from_slice(block),
                Method::Zip(level) => zip(block, level, scratch, &mut bytes),
            }
            let size = (bytes.len() - start - 8) as u32;
            bytes[start + 4..start + 8].copy_from_slice(&size.to_le_bytes());
            lengths.push(size + 8);
            y += (block.len() / line) as u32;
        }
        Piece { bytes: Arc::new(bytes), check: 0, lengths: lengths.into() }
    };
    let bands::Pieces { pieces, encoded } = bands::encode(key, BAND_ROWS, kept, gather, code);

    let mut head = header(picture, half, method, options.text);
    let chunks: usize = pieces.iter().map(|piece| piece.lengths.len()).sum();
    let mut offset = (head.len() + chunks * 8) as u64;
    for length in pieces.iter().flat_map(|piece| piece.lengths.iter()) {
        head.extend_from_slice(&offset.to_le_bytes());
        offset += u64::from(*length);
    }
    let mut parts = vec![Arc::new(head)];
    let bands = pieces.len();
    parts.extend(pieces.into_iter().map(|piece| piece.bytes));
    Ok(Encoded::from_parts(parts, bands, encoded))
}

/// Each line: all of B, all of G, all of R.
fn gather_float(picture: &Picture, rows: Range<u32>, raw: &mut Vec<u8>) {
    let plane = picture.layout().width() as usize * 4;
    let start = raw.len();
    raw.resize(start + rows.len() * plane * 3, 0);
    for (y, line) in rows.zip(raw[start..].chunks_exact_mut(plane * 3)) {
        let (blue, rest) = line.split_at_mut(plane);
        let (green, red) = rest.split_at_mut(plane);
        let mut places =
            blue.chunks_exact_mut(4).zip(green.chunks_exact_mut(4)).zip(red.chunks_exact_mut(4));
        for piece in picture.row_pieces::<f32>(y) {
            // The pixels come first in the zip, so that no place is taken when they end.
            for (pixel, ((blue, green), red)) in piece.chunks_exact(3).zip(&mut places) {
                red.copy_from_slice(&pixel[0].to_le_bytes());
                green.copy_from_slice(&pixel[1].to_le_bytes());
                blue.copy_from_slice(&pixel[2].to_le_bytes());
            }
        }
    }
}

fn gather_half(picture: &Picture, rows: Range<u32>, raw: &mut Vec<u8>) {
    let width = picture.layout().width() as usize;
    let mut line: Vec<f32> = Vec::with_capacity(width * 3);
    let mut halves = vec![half::f16::ZERO; width * 3];
    for y in rows {
        line.clear();
        for channel in [2, 1, 0] {
            for piece in picture.row_pieces::<f32>(y) {
                line.extend(piece.chunks_exact(3).map(|pixel| pixel[channel]));
            }
        }
        halves.convert_from_f32_slice(&line);
        raw.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
    }
}

#[derive(Default)]
struct Scratch {
    bytes: Vec<u8>,
}

/// A block that does not shrink is stored as it is, which its size tells.
fn zip(block: &[u8], level: u8, scratch: &mut Scratch, out: &mut Vec<u8>) {
    predict(block, &mut scratch.bytes);
    let zipped = miniz_oxide::deflate::compress_to_vec_zlib(&scratch.bytes, level);
    let shorter = zipped.len() < block.len();
    out.extend_from_slice(if shorter { &zipped } else { block });
}

/// Bytes at even places first, then those at odd ones, each as its difference to the one before,
/// plus 128.
fn predict(block: &[u8], out: &mut Vec<u8>) {
    out.clear();
    out.resize(block.len(), 0);
    let (even, odd) = out.split_at_mut(block.len().div_ceil(2));
    for ((pair, even), odd) in block.chunks_exact(2).zip(even.iter_mut()).zip(odd) {
        *even = pair[0];
        *odd = pair[1];
    }
    if block.len() % 2 == 1 {
        even[block.len() / 2] = block[block.len() - 1];
    }
    for i in (1..out.len()).rev() {
        out[i] = out[i].wrapping_sub(out[i - 1]).wrapping_add(128);
    }
}
