//! PNG, written in bands of rows.
//!
//! Every band is filtered and deflated by itself and ends on a byte, so that bands are encoded in
//! parallel, concatenate to one zlib stream, and keep their bytes while their rows stay the same.
//! A band is one IDAT chunk; a last, short one ends the stream and carries the checksum, combined
//! from those of the bands. (PNG specification, third edition; RFC 1950 and 1951.)

pub(crate) mod deflate;
mod filter;
mod huffman;
mod texts;

use crate::bands::{self, Codec, KeptBands, Key, Piece};
use crate::picture::{Picture, SampleKind};
use crate::still::{Compression, Encoded, StillOptions};
use crate::transfer::Transfer;
use std::ops::Range;
use std::sync::Arc;

pub(crate) use texts::{is_animated, read_head, read_texts};

pub(crate) const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// Deflate with a window of 32 KiB, no dictionary, "fastest" as the level.
pub(crate) const ZLIB_HEADER: [u8; 2] = [0x78, 0x01];

/// Rows in a band of a picture whose rows have `row_bytes` bytes: a power of two (so that bands
/// and tiles meet), about 64 KiB, but not so few rows that the first one, which cannot lean on the
/// row above, would count.
pub(crate) fn band_rows(row_bytes: usize) -> u32 {
    let rows = (65536 / row_bytes).clamp(8, 64);
    1 << rows.ilog2()
}

/// Appends a chunk: length, type, data, checksum.
pub(crate) fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[&[u8]]) {
    let length: usize = data.iter().map(|part| part.len()).sum();
    out.extend_from_slice(&(length as u32).to_be_bytes());
    let mut crc = crc32fast::Hasher::new();
    for part in [&kind[..]].iter().chain(data) {
        crc.update(part);
        out.extend_from_slice(part);
    }
    out.extend_from_slice(&crc.finalize().to_be_bytes());
}

/// The header chunk of an RGB picture.
pub(crate) fn header_chunk(out: &mut Vec<u8>, width: u32, height: u32, depth: u8) {
    let (width, height) = (width.to_be_bytes(), height.to_be_bytes());
    // Colour type 2 is RGB; then deflate, adaptive filters, not interlaced.
    chunk(out, b"IHDR", &[&width, &height, &[depth, 2, 0, 0, 0]]);
}

/// What the samples stand for: the curve, and the primaries and the white of sRGB (Rec. ITU-R BT.709),
/// for readers of every age. (PNG specification, third edition, 11.3.2.)
pub(crate) fn colour_chunks(out: &mut Vec<u8>, transfer: Transfer) {
    let gamma: u32 = match transfer {
        Transfer::Srgb => 45_455,
        Transfer::Linear => 100_000,
    };
    if transfer == Transfer::Linear {
        // BT.709 primaries, linear, RGB, full range (ITU-T H.273).
        chunk(out, b"cICP", &[&[1, 8, 0, 1]]);
    }
    chunk(out, b"gAMA", &[&gamma.to_be_bytes()]);
    let points: [u32; 8] = [31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6_000];
    chunk(out, b"cHRM", &[&points.map(u32::to_be_bytes).concat()]);
    if transfer == Transfer::Srgb {
        // Perceptual.
        chunk(out, b"sRGB", &[&[0]]);
    }
}

/// Text in ASCII as tEXt, other text as iTXt.
pub(crate) fn text_chunks(out: &mut Vec<u8>, text: &[(&str, &str)]) {
    for (key, value) in text {
        if value.is_ascii() {
            chunk(out, b"tEXt", &[key.as_bytes(), b"\0", value.as_bytes()]);
        } else {
            // Not compressed, no language, no translated key.
            chunk(out, b"iTXt", &[key.as_bytes(), b"\0\0\0\0\0", value.as_bytes()]);
        }
    }
}

/// The end of the zlib stream: an empty final block and the Adler-32 of everything.
pub(crate) fn stream_end(adler: u32) -> [u8; 6] {
    let adler = adler.to_be_bytes();
    [0x03, 0x00, adler[0], adler[1], adler[2], adler[3]]
}

/// The Adler-32 of two pieces, from the Adler-32 of each and the second one's length.
pub(crate) fn adler_combine(first: u32, second: u32, second_len: u64) -> u32 {
    const PRIME: u64 = 65521;
    let (a1, b1) = (u64::from(first & 0xffff), u64::from(first >> 16));
    let (a2, b2) = (u64::from(second & 0xffff), u64::from(second >> 16));
    // Each sum starts at 1, which the second piece counted once more, in b once a byte.
    let a = (a1 + a2 + PRIME - 1) % PRIME;
    let length = second_len % PRIME;
    let b = (b1 + b2 + length * (a1 + PRIME - 1)) % PRIME;
    ((b << 16) | a) as u32
}

/// Buffers of one worker.
#[derive(Default)]
pub(crate) struct Scratch {
    filter: filter::Scratch,
    filtered: Vec<u8>,
    deflate: deflate::Scratch,
}

/// Appends the filtered and deflated `raw` rows to `out`, ending on a byte, no block final, and
/// gives the Adler-32 of the filtered rows.
pub(crate) fn code_band(
    raw: &[u8],
    row_bytes: usize,
    pixel_bytes: usize,
    compression: Compression,
    scratch: &mut Scratch,
    out: &mut Vec<u8>,
) -> u32 {
    let filtered = &mut scratch.filtered;
    filtered.clear();
    filter::rows(raw, row_bytes, pixel_bytes, compression, &mut scratch.filter, filtered);
    deflate::block(filtered, compression, &mut scratch.deflate, out);
    simd_adler32::adler32(&filtered.as_slice())
}

/// Appends the raw bytes of `rows`.
pub(crate) fn gather(picture: &Picture, rows: Range<u32>, raw: &mut Vec<u8>) {
    if picture.kind() == SampleKind::U16 {
        for y in rows {
            for piece in picture.row_pieces::<u16>(y) {
                raw.extend(piece.iter().flat_map(|sample| sample.to_be_bytes()));
            }
        }
        return;
    }
    let row_bytes = picture.layout().width() as usize * 3;
    let start = raw.len();
    raw.resize(start + rows.len() * row_bytes, 0);
    for (y, row) in rows.zip(raw[start..].chunks_exact_mut(row_bytes)) {
        let mut rest = row;
        for piece in picture.row_pieces::<u8>(y) {
            let (head, tail) = rest.split_at_mut(piece.len());
            match (head.as_chunks_mut::<48>(), piece.as_chunks::<48>()) {
                // A copy of a known length, for tiles of 16 pixels, is three moves and no call.
                (([head], []), ([piece], [])) => *head = *piece,
                _ => head.copy_from_slice(piece),
            }
            rest = tail;
        }
    }
}

/// A still of 8 or 16 bits.
pub(crate) fn encode(
    picture: &Picture,
    options: &StillOptions<'_>,
    kept: Option<&mut KeptBands>,
) -> Encoded {
    let layout = picture.layout();
    let (codec, pixel_bytes) = match picture.kind() {
        SampleKind::U16 => (Codec::Png16, 6),
        _ => (Codec::Png8, 3),
    };
    let row_bytes = layout.width() as usize * pixel_bytes;
    let rows = band_rows(row_bytes);
    let key = Key {
        codec,
        compression: options.compression,
        width: layout.width(),
        height: layout.height(),
    };
    let code = |index: usize, raw: &[u8], scratch: &mut Scratch| {
        let mut bytes = Vec::with_capacity(raw.len() / 2 + 64);
        bytes.extend_from_slice(b"\0\0\0\0IDAT");
        if index == 0 {
            bytes.extend_from_slice(&ZLIB_HEADER);
        }
        let check =
            code_band(raw, row_bytes, pixel_bytes, options.compression, scratch, &mut bytes);
        let length = (bytes.len() - 8) as u32;
        bytes[..4].copy_from_slice(&length.to_be_bytes());
        let crc = crc32fast::hash(&bytes[4..]);
        bytes.extend_from_slice(&crc.to_be_bytes());
        bytes.shrink_to_fit();
        Piece { bytes: Arc::new(bytes), check, ..Piece::default() }
    };
    let gather = |rows: Range<u32>, raw: &mut Vec<u8>| gather(picture, rows, raw);
    let bands::Pieces { pieces, encoded } = bands::encode(key, rows, kept, gather, code);

    let mut head = SIGNATURE.to_vec();
    header_chunk(&mut head, layout.width(), layout.height(), (pixel_bytes / 3 * 8) as u8);
    colour_chunks(&mut head, options.transfer);
    text_chunks(&mut head, options.text);
    let mut adler = 1;
    for (index, piece) in pieces.iter().enumerate() {
        let rows = bands::rows_of(index, rows, layout.height());
        let length = rows.len() as u64 * (row_bytes as u64 + 1);
        adler = adler_combine(adler, piece.check, length);
    }
    let mut tail = Vec::new();
    chunk(&mut tail, b"IDAT", &[&stream_end(adler)]);
    chunk(&mut tail, b"IEND", &[]);

    let bands = pieces.len();
    let mut parts = vec![Arc::new(head)];
    parts.extend(pieces.into_iter().map(|piece| piece.bytes));
    parts.push(Arc::new(tail));
    Encoded::from_parts(parts, bands, encoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_combine() {
        let bytes: Vec<u8> = (0..200_000_u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
        for split in [0, 1, 2, 65520, 65521, 65522, 131_042, 199_999, 200_000] {
            let (first, second) = bytes.split_at(split);
            let combined = adler_combine(
                simd_adler32::adler32(&first),
                simd_adler32::adler32(&second),
                second.len() as u64,
            );
            assert_eq!(combined, simd_adler32::adler32(&bytes.as_slice()), "{split}");
        }
    }

    #[test]
    fn bands_are_about_64_kib() {
        assert_eq!(band_rows(1280 * 3), 16);
        assert_eq!(band_rows(640 * 3), 32);
        assert_eq!(band_rows(3), 64);
        assert_eq!(band_rows(65535 * 6), 8);
    }
}
