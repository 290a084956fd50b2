//! Animated GIF with one palette of at most 256 colours for the whole film, so that a colour looks
//! the same in every frame; of each frame, the rectangle with the pixels that changed, the others
//! within it transparent.
//!
//! The palette stands at the file's head and is known only when all frames are: until then what
//! changed waits, compressed, in memory or beyond some size in a nameless temporary file.

use super::quantise::{Colours, Palette};
use super::{FilmSpec, Shot};
use crate::picture::TileRect;
use std::borrow::Cow;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use tempfile::{SpooledTempFile, spooled_tempfile};

/// Bytes that wait in memory.
const SPOOLED: usize = 32 << 20;

pub(super) struct GifFilm<W: Write> {
    sink: W,
    colours: Colours,
    /// The stored rectangles, and how long each stays.
    frames: Vec<(TileRect, u16)>,
    spool: BufWriter<SpooledTempFile>,
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

impl<W: Write> GifFilm<W> {
    pub(super) fn new(sink: W) -> Self {
        let spool = BufWriter::new(spooled_tempfile(SPOOLED));
        Self { sink, colours: Colours::default(), frames: Vec::new(), spool }
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
        self.frames.push((stored, spec.fps.delay_of(shot.index, 100)));
        let packed = miniz_oxide::deflate::compress_to_vec(&pixels, 1);
        self.spool.write_all(&(packed.len() as u64).to_le_bytes())?;
        self.spool.write_all(&packed)
    }

    pub(super) fn finish(self, spec: &FilmSpec) -> io::Result<W> {
        let mut spool = self.spool.into_inner().map_err(|error| error.into_error())?;
        spool.rewind()?;
        let mut spool = BufReader::new(spool);
        // One index is kept for "unchanged".
        let spare = usize::from(self.frames.len() > 1);
        let palette = self.colours.palette(256 - spare);
        let transparent = (spare > 0).then_some(palette.colours().len() as u8);
        let mut colours = palette.colours().concat();
        if transparent.is_some() {
            colours.extend_from_slice(&[0; 3]);
        }
        let (width, height) = (spec.width as u16, spec.height as u16);
        let mut encoder = gif::Encoder::new(self.sink, width, height, &colours).map_err(failed)?;
        if spec.frames > 1 {
            encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        }
        for (index, (stored, delay)) in self.frames.iter().enumerate() {
            let mut length = [0; 8];
            spool.read_exact(&mut length)?;
            let mut packed = vec![0; u64::from_le_bytes(length) as usize];
            spool.read_exact(&mut packed)?;
            let pixels = miniz_oxide::inflate::decompress_to_vec(&packed)
                .map_err(|error| io::Error::other(format!("GIF: {error}")))?;
            let buffer = indices(&pixels, &palette, transparent.unwrap_or(0));
            let frame = gif::Frame {
                delay: *delay,
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
        }
        encoder.into_inner().map_err(failed)
    }
}

fn indices(pixels: &[u8], palette: &Palette, unchanged: u8) -> Vec<u8> {
    let pixels = pixels.as_chunks::<4>().0.iter();
    pixels
        .map(|pixel| match *pixel {
            [CHANGED, r, g, b] => palette.index([r, g, b]),
            _ => unchanged,
        })
        .collect()
}
