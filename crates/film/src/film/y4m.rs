//! YUV4MPEG2 (the format of mjpegtools), 4:4:4, 8 bits, full range, BT.601 matrix as in JPEG
//! (ITU-T T.871): every pixel keeps its own chroma, and readers are told of the range by
//! `XCOLORRANGE=FULL`.

use super::{FilmSpec, Shot};
use rayon::prelude::*;
use std::io::{self, Write};

#[derive(Debug)]
pub(super) struct Y4mFilm<W> {
    sink: W,
    bytes: Vec<u8>,
}

const FRAME: &[u8] = b"FRAME\n";

impl<W: Write> Y4mFilm<W> {
    pub(super) fn new(mut sink: W, spec: &FilmSpec) -> io::Result<Self> {
        let head = format!(
            "YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C444 XCOLORRANGE=FULL\n",
            spec.width,
            spec.height,
            spec.fps.numerator(),
            spec.fps.denominator()
        );
        sink.write_all(head.as_bytes())?;
        Ok(Self { sink, bytes: Vec::new() })
    }

    pub(super) fn push(&mut self, shot: &Shot<'_>) -> io::Result<()> {
        let pixels = shot.frame.len() / 3;
        self.bytes.resize(FRAME.len() + pixels * 3, 0);
        let (head, planes) = self.bytes.split_at_mut(FRAME.len());
        head.copy_from_slice(FRAME);
        self::planes(shot.frame, planes);
        self.sink.write_all(&self.bytes)
    }

    pub(super) fn finish(self) -> W {
        self.sink
    }
}

/// Pixels to three planes of as many samples, one after the other.
pub(super) fn planes(frame: &[u8], planes: &mut [u8]) {
    let pixels = frame.len() / 3;
    let (luma, chroma) = planes.split_at_mut(pixels);
    let (blue, red) = chroma.split_at_mut(pixels);
    const PIECE: usize = 1 << 14;
    let planes =
        luma.par_chunks_mut(PIECE).zip(blue.par_chunks_mut(PIECE)).zip(red.par_chunks_mut(PIECE));
    let pieces = planes.zip(frame.par_chunks(PIECE * 3));
    pieces.for_each(|(((luma, blue), red), frame)| {
        let planes = luma.iter_mut().zip(blue).zip(red);
        for (((luma, blue), red), pixel) in planes.zip(frame.chunks_exact(3)) {
            [*luma, *blue, *red] = ycbcr([pixel[0], pixel[1], pixel[2]]);
        }
    });
}

/// The fraction as a multiple of 2^-22, rounded.
const fn fixed(numerator: i64, denominator: i64) -> i32 {
    ((2 * (numerator << 22) + denominator) / (2 * denominator)) as i32
}

/// Luma is 0.299 R + 0.587 G + 0.114 B; chroma is (B - luma) / 1.772 + 128 and
/// (R - luma) / 1.402 + 128; each rounded to the nearest (the tests hold all colours against that).
fn ycbcr([r, g, b]: [u8; 3]) -> [u8; 3] {
    let (r, g, b) = (i32::from(r), i32::from(g), i32::from(b));
    // The sums err by less than 1e-4 and are whole multiples of 1/1000, 1/1772 or 1/1402, so a lift
    // of 1.5e-4 brings every exact half up and nothing else.
    const HALF: i32 = (1 << 21) + 629;
    const MIDDLE: i32 = (128 << 22) + HALF;
    let luma = fixed(299, 1000) * r + fixed(587, 1000) * g + fixed(114, 1000) * b + HALF;
    let blue = MIDDLE - fixed(299, 1772) * r - fixed(587, 1772) * g + (1 << 21) * b;
    let red = MIDDLE + (1 << 21) * r - fixed(587, 1402) * g - fixed(114, 1402) * b;
    // Pure blue and pure red would round to 256.
    [(luma >> 22) as u8, (blue >> 22).min(255) as u8, (red >> 22).min(255) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_is_rounded_to_the_nearest() {
        // Rounding half up, as the fixed-point sum does; the sums are multiples of 1/denominator.
        let round = |numerator: i32, denominator: i32| {
            (2 * numerator + denominator).div_euclid(2 * denominator)
        };
        for r in 0..=255 {
            for g in 0..=255 {
                for b in 0..=255 {
                    let luma = round(299 * r + 587 * g + 114 * b, 1000);
                    let blue = 128 + round(886 * b - 299 * r - 587 * g, 1772);
                    let red = 128 + round(701 * r - 587 * g - 114 * b, 1402);
                    let want = [luma, blue.min(255), red.min(255)].map(|v| v as u8);
                    assert_eq!(ycbcr([r as u8, g as u8, b as u8]), want, "{r} {g} {b}");
                }
            }
        }
    }
}
