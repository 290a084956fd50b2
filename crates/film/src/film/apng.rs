//! Animated PNG (PNG specification, third edition, 11.3.2), RGB of 8 bits.

use super::{FilmSpec, Fps, Shot};
use crate::png;
use rayon::prelude::*;
use std::io::{self, Write};

/// How long a frame stays: so many of so many to a second. Exact where the rate's fraction fits,
/// otherwise rounded so that nothing drifts.
fn delay(fps: Fps, index: u32) -> (u16, u16) {
    let (long, short) = (fps.denominator(), fps.numerator());
    if let (Ok(delay), Ok(unit)) = (u16::try_from(long), u16::try_from(short)) {
        return (delay, unit);
    }
    let units = [60_000, 1000, 1].into_iter();
    let mut fitting = units.filter_map(|unit: u16| {
        Some((u16::try_from(fps.delay_of(index, unit.into())).ok()?, unit))
    });
    fitting.next().unwrap_or((u16::MAX, 1))
}

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
        png::colour_chunks(&mut bytes, spec.transfer);
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
        let (delay, unit) = delay(spec.fps, shot.index);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_exact_or_do_not_drift() {
        let exact = |numerator, denominator| delay(Fps::new(numerator, denominator).unwrap(), 7);
        assert_eq!(exact(24000, 1001), (1001, 24000));
        assert_eq!(exact(60, 1), (1, 60));
        assert_eq!(exact(1, 1000), (1000, 1));
        for (numerator, denominator) in [(120_000, 1001), (99_991, 1000), (70_001, 999_983)] {
            let fps = Fps::new(numerator, denominator).unwrap();
            let all = (0..1000).map(|index| delay(fps, index));
            let length: f64 = all.map(|(delay, unit)| f64::from(delay) / f64::from(unit)).sum();
            let wanted = 1000.0 * f64::from(denominator) / f64::from(numerator);
            // Half of a unit.
            assert!((length - wanted).abs() <= 0.5e-3, "{fps:?}: {length} {wanted}");
        }
    }
}
