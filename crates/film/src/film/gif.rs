//! Animated GIF with one palette of at most 256 colours for the whole film, so that a colour looks
//! the same in every frame; of each frame, the rectangle with the pixels that changed, the others
//! within it transparent.
//!
//! The palette stands at the file's head and is known only when all frames are: until then what
//! changed waits, compressed, beyond a first megabyte in a file without a name next to the film.
//! Then it is read again, frame by frame. So memory does not grow with the film's length, and the
//! disk must hold about twice the film while it is made.

use super::quantise::{Colours, Palette, bin};
use super::{Dither, FilmSpec, Shot, pace};
use crate::picture::TileRect;
use crate::safe::explain;
use std::borrow::Cow;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::{SpooledTempFile, spooled_tempfile_in};

/// The longest delay that a GIF can hold.
const LONGEST: u32 = u16::MAX as u32;

/// Bytes that wait in memory.
const SPOOLED: usize = 1 << 20;

pub(super) struct GifFilm<W: Write> {
    sink: W,
    colours: Colours,
    spool: BufWriter<SpooledTempFile>,
    /// Frames that wait.
    frames: u32,
    /// Where `spool` goes, for messages.
    folder: PathBuf,
}

impl<W: Write> std::fmt::Debug for GifFilm<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GifFilm").finish_non_exhaustive()
    }
}

fn failed(error: gif::EncodingError) -> io::Error {
    match error {
        gif::EncodingError::Io(error) => error,
        other => io::Error::other(format!("GIF: {other}")),
    }
}

/// A pixel that waits: whether it changed, and its colour.
const CHANGED: u8 = 1;

/// A frame that waits: its rectangle, how long it stays, and how many bytes its pixels are packed
/// to.
struct Waiting {
    stored: TileRect,
    delay: u32,
    packed: u64,
}

impl Waiting {
    const BYTES: usize = 28;

    fn to_bytes(&self) -> Vec<u8> {
        let TileRect { x, y, width, height } = self.stored;
        let mut bytes = [x, y, width, height].map(u32::to_le_bytes).concat();
        bytes.extend_from_slice(&self.delay.to_le_bytes());
        bytes.extend_from_slice(&self.packed.to_le_bytes());
        bytes
    }

    fn read(spool: &mut impl Read) -> io::Result<Self> {
        let mut bytes = [0; Self::BYTES];
        spool.read_exact(&mut bytes)?;
        let word = |at: usize| u64::from(u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i])));
        let [x, y, width, height] = [0, 4, 8, 12].map(|at| word(at) as u32);
        let delay = word(16) as u32;
        let stored = TileRect { x, y, width, height };
        Ok(Self { stored, delay, packed: word(20) | word(24) << 32 })
    }
}

/// A sink that can be told to take no more: the encoder ends a file by itself, and we end it with
/// what it was made from.
struct Ending<W> {
    sink: W,
    ended: bool,
}

impl<W: Write> Write for Ending<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.ended { Ok(bytes.len()) } else { self.sink.write(bytes) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

impl<W: Write> GifFilm<W> {
    pub(super) fn new(sink: W, folder: Option<&Path>) -> Self {
        let folder = folder.map_or_else(std::env::temp_dir, Path::to_owned);
        let spool = BufWriter::new(spooled_tempfile_in(SPOOLED, &folder));
        Self { sink, colours: Colours::default(), spool, frames: 0, folder }
    }

    pub(super) fn push(&mut self, shot: &Shot<'_>, spec: &FilmSpec) -> io::Result<()> {
        let stored = shot.stored;
        let mut pixels = Vec::with_capacity((stored.width * stored.height) as usize * 4);
        for y in 0..stored.height {
            let row = shot.row(shot.frame, y);
            let before = shot.before.map(|before| shot.row(before, y));
            for (at, pixel) in row.as_chunks::<3>().0.iter().enumerate() {
                if before.is_some_and(|before| before[3 * at..3 * at + 3] == *pixel) {
                    pixels.extend_from_slice(&[0; 4]);
                } else {
                    self.colours.add(*pixel);
                    pixels.extend_from_slice(&[CHANGED, pixel[0], pixel[1], pixel[2]]);
                }
            }
        }
        let packed = miniz_oxide::deflate::compress_to_vec(&pixels, 1);
        let delay = pace::hundredths(spec.fps, spec.frames, shot.index).unwrap_or(0) as u32;
        self.frames += 1;
        let waiting = Waiting { stored, delay, packed: packed.len() as u64 };
        let spool = &mut self.spool;
        spool
            .write_all(&waiting.to_bytes())
            .and_then(|()| spool.write_all(&packed))
            .map_err(|error| explain("write what waits for the palette in", &self.folder, &error))
    }

    /// All but the file's last byte.
    pub(super) fn finish(self, spec: &FilmSpec) -> io::Result<W> {
        let folder = &self.folder;
        let waits = |error| explain("read what waits for the palette in", folder, &error);
        let spool = self.spool.into_inner().map_err(|error| error.into_error());
        let mut spool = spool
            .map_err(|error| explain("write what waits for the palette in", folder, &error))?;
        spool.rewind().map_err(waits)?;
        let mut spool = BufReader::new(spool);
        // One index is kept for "unchanged".
        let spare = usize::from(self.frames > 1);
        let palette = self.colours.palette(256 - spare);
        // Where every colour is in the palette there is nothing to be dithered.
        let dithers = spec.dither == Dither::Ordered && !palette.is_exact();
        let nearest = dithers.then(|| palette.nearest());
        let transparent = (spare > 0).then_some(palette.colours().len() as u8);
        let mut colours = palette.colours().concat();
        if transparent.is_some() {
            colours.extend_from_slice(&[0; 3]);
        }
        let (width, height) = (spec.width as u16, spec.height as u16);
        let sink = Ending { sink: self.sink, ended: false };
        let mut encoder = gif::Encoder::new(sink, width, height, &colours).map_err(failed)?;
        if self.frames > 1 {
            encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        }
        for index in 0..self.frames {
            let Waiting { stored, delay, packed } = Waiting::read(&mut spool).map_err(waits)?;
            let mut bytes = vec![0; packed as usize];
            spool.read_exact(&mut bytes).map_err(waits)?;
            let pixels = miniz_oxide::inflate::decompress_to_vec(&bytes)
                .map_err(|error| io::Error::other(format!("GIF: {error}")))?;
            let buffer =
                indices(&pixels, stored, &palette, transparent.unwrap_or(0), nearest.as_deref());
            let frame = gif::Frame {
                delay: delay.min(LONGEST) as u16,
                dispose: gif::DisposalMethod::Keep,
                transparent: transparent.filter(|_| index > 0),
                top: stored.y as u16,
                left: stored.x as u16,
                width: stored.width as u16,
                height: stored.height as u16,
                buffer: Cow::Owned(buffer),
                ..gif::Frame::default()
            };
            encoder.write_frame(&frame).map_err(failed)?;
            // A longer delay than a GIF can hold is that of several frames; the others change nothing.
            let mut rest = delay.saturating_sub(LONGEST);
            while let (1.., Some(unchanged)) = (rest, transparent) {
                let frame = gif::Frame {
                    delay: rest.min(LONGEST) as u16,
                    dispose: gif::DisposalMethod::Keep,
                    transparent,
                    width: 1,
                    height: 1,
                    buffer: Cow::Owned(vec![unchanged]),
                    ..gif::Frame::default()
                };
                encoder.write_frame(&frame).map_err(failed)?;
                rest = rest.saturating_sub(LONGEST);
            }
        }
        encoder.get_mut().ended = true;
        Ok(encoder.into_inner().map_err(failed)?.sink)
    }
}

fn indices(
    pixels: &[u8],
    stored: TileRect,
    palette: &Palette,
    unchanged: u8,
    nearest: Option<&[u8]>,
) -> Vec<u8> {
    let width = stored.width as usize;
    let pixels = pixels.as_chunks::<4>().0.iter().enumerate();
    pixels
        .map(|(at, pixel)| match (*pixel, nearest) {
            ([CHANGED, r, g, b], None) => palette.index([r, g, b]),
            ([CHANGED, r, g, b], Some(nearest)) => {
                let (x, y) = (stored.x as usize + at % width, stored.y as usize + at / width);
                let lift = threshold(x, y);
                let lifted = [r, g, b].map(|v| (i32::from(v) + lift).clamp(0, 255) as u8);
                nearest[bin(lifted)]
            }
            _ => unchanged,
        })
        .collect()
}

/// What ordered dithering adds to the samples of a pixel: -16 to 15, about half of the way from one
/// colour to the next in a palette of 6 to 7 steps an axis. Its mean over 8 x 8 pixels is -1/2.
fn threshold(x: usize, y: usize) -> i32 {
    // Bayer's matrix: the bits of x xor y and of y, interleaved, the lowest bits first.
    let (mixed, y) = (x ^ y, y);
    let bit = |v: usize, i: usize| (v >> i) & 1;
    let rank = (0..3).fold(0, |rank, i| rank << 2 | bit(mixed, i) << 1 | bit(y, i));
    rank as i32 / 2 - 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_spread_over_every_block() {
        let mut all: Vec<i32> = (0..64).map(|i| threshold(i % 8 + 8, i / 8 + 40)).collect();
        assert_eq!(threshold(0, 0), -16);
        // Neighbours differ by half of the range.
        assert_eq!(threshold(1, 0), 0);
        all.sort_unstable();
        let twice: Vec<i32> = (-16..16).flat_map(|v| [v, v]).collect();
        assert_eq!(all, twice);
    }
}
