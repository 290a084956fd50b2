//! Animated GIF: each frame has its own palette of at most 256 colours, made of the pixels that
//! changed; the others within its rectangle are transparent and so keep their colour.

use super::quantise::Palette;
use super::{FilmSpec, Shot};
use std::borrow::Cow;
use std::io::{self, Write};

pub(super) struct GifFilm<W: Write> {
    encoder: gif::Encoder<W>,
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

impl<W: Write> GifFilm<W> {
    pub(super) fn new(sink: W, spec: &FilmSpec) -> io::Result<Self> {
        let (width, height) = (spec.width as u16, spec.height as u16);
        let mut encoder = gif::Encoder::new(sink, width, height, &[]).map_err(failed)?;
        if spec.frames > 1 {
            encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        }
        Ok(Self { encoder })
    }

    pub(super) fn push(&mut self, shot: &Shot<'_>, spec: &FilmSpec) -> io::Result<()> {
        let stored = shot.stored;
        let count = stored.width as usize * stored.height as usize;
        let mut pixels: Vec<Option<[u8; 3]>> = Vec::with_capacity(count);
        for y in 0..stored.height {
            let row = shot.row(shot.frame, y).chunks_exact(3);
            let colours = row.map(|pixel| [pixel[0], pixel[1], pixel[2]]);
            match shot.before {
                None => pixels.extend(colours.map(Some)),
                Some(before) => {
                    let before = shot.row(before, y).chunks_exact(3);
                    let changed = colours
                        .zip(before)
                        .map(|(colour, before)| (colour != *before).then_some(colour));
                    pixels.extend(changed);
                }
            }
        }
        // One index is kept for "unchanged".
        let spare = usize::from(shot.before.is_some());
        let palette = Palette::of(pixels.iter().flatten().copied(), 256 - spare);
        let transparent = shot.before.map(|_| palette.colours().len() as u8);
        let mut colours: Vec<u8> = palette.colours().concat();
        if transparent.is_some() {
            colours.extend_from_slice(&[0; 3]);
        }
        let buffer = pixels
            .into_iter()
            .map(|pixel| match (pixel, transparent) {
                (Some(colour), _) => palette.index(colour),
                (None, index) => index.unwrap_or(0),
            })
            .collect();
        let frame = gif::Frame {
            delay: spec.fps.delay_of(shot.index, 100),
            dispose: gif::DisposalMethod::Keep,
            transparent,
            top: stored.y as u16,
            left: stored.x as u16,
            width: stored.width as u16,
            height: stored.height as u16,
            palette: Some(colours),
            buffer: Cow::Owned(buffer),
            ..gif::Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(failed)
    }

    pub(super) fn finish(self) -> io::Result<W> {
        self.encoder.into_inner().map_err(failed)
    }
}
