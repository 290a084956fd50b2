//! Animated PNG (PNG specification, third edition, 11.3.2), RGB of 8 bits.

use super::{FilmSpec, Shot};
use crate::png;
use rayon::prelude::*;
use std::io::{self, Write};

#[derive(Debug)]
pub(super) struct ApngFilm<W> {
    sink: W,
    /// The number of the next fcTL or fdAT chunk.
    sequence: u32,
    bytes: Vec<u8>,
}

impl<W: Write> ApngFilm<W> {
    pub(super) fn new(mut sink: W, spec: &FilmSpec) -> io::Result<Self> {
        let mut bytes = png::SIGNATURE.to_vec();
        png::header_chunk(&mut bytes, spec.width, spec.height, 8);
        // Played without end.
        let plays = 0_u32.to_be_bytes();
        png::chunk(&mut bytes, b"acTL", &[&spec.frames.to_be_bytes(), &plays]);
        sink.write_all(&bytes)?;
        Ok(Self { sink, sequence: 0, bytes })
    }

    fn next(&mut self) -> [u8; 4] {
        let sequence = self.sequence.to_be_bytes();
        self.sequence += 1;
        sequence
    }

    pub(super) fn push(&mut self, shot: &Shot<'_>, spec: &FilmSpec) -> io::Result<()> {
        self.bytes.clear();
        let stored = shot.stored;
        let mut control = self.next().to_vec();
        for number in [stored.width, stored.height, stored.x, stored.y] {
            control.extend_from_slice(&number.to_be_bytes());
        }
        let (numerator, denominator) = (spec.fps.denominator(), spec.fps.numerator());
        let (delay, unit) = match (u16::try_from(numerator), u16::try_from(denominator)) {
            (Ok(delay), Ok(unit)) => (delay, unit),
            _ => (spec.fps.delay_of(shot.index, 1000), 1000),
        };
        control.extend_from_slice(&delay.to_be_bytes());
        control.extend_from_slice(&unit.to_be_bytes());
        // Leave the frame standing, and overwrite the rectangle.
        control.extend_from_slice(&[0, 0]);
        png::chunk(&mut self.bytes, b"fcTL", &[&control]);

        let row_bytes = stored.width as usize * 3;
        let rows = png::band_rows(row_bytes);
        let bands: Vec<(Vec<u8>, u32, u64)> = (0..stored.height.div_ceil(rows))
            .into_par_iter()
            .map_init(<(Vec<u8>, png::Scratch)>::default, |(raw, scratch), band| {
                raw.clear();
                for y in band * rows..stored.height.min((band + 1) * rows) {
                    raw.extend_from_slice(shot.row(shot.frame, y));
                }
                let mut bytes = Vec::new();
                if band == 0 {
                    bytes.extend_from_slice(&png::ZLIB_HEADER);
                }
                let check =
                    png::code_band(raw, row_bytes, 3, spec.compression, scratch, &mut bytes);
                let length = raw.len() + raw.len() / row_bytes;
                (bytes, check, length as u64)
            })
            .collect();
        let adler = bands
            .iter()
            .fold(1, |adler, (_, check, length)| png::adler_combine(adler, *check, *length));
        for (index, (data, ..)) in bands.iter().enumerate() {
            let end = png::stream_end(adler);
            let end: &[u8] = if index + 1 == bands.len() { &end } else { &[] };
            if shot.index == 0 {
                png::chunk(&mut self.bytes, b"IDAT", &[data, end]);
            } else {
                let sequence = self.next();
                png::chunk(&mut self.bytes, b"fdAT", &[&sequence, data, end]);
            }
        }
        self.sink.write_all(&self.bytes)
    }

    pub(super) fn finish(self) -> W {
        self.sink
    }
}
