//! From linear intensities to samples.
//!
//! An integer sample is `round(max * encode(clamp(I, 0, 1)))`, evaluated as if in f64. No power is
//! taken per pixel: a sample is the number of thresholds at or below the intensity, where
//! threshold `k` is the least f32 whose sample is `k`. Which thresholds may matter follows from
//! the upper bits of the float.

use crate::picture::{SampleKind, SamplesMut};

/// The curve between linear light and the samples of integer formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Transfer {
    /// The sRGB curve of IEC 61966-2-1.
    #[default]
    Srgb,
    /// No curve: samples are proportional to intensities.
    Linear,
}

impl Transfer {
    /// The curve itself, from linear intensity in [0, 1] to encoded value in [0, 1].
    pub fn encode(self, intensity: f64) -> f64 {
        match self {
            Self::Linear => intensity,
            Self::Srgb if intensity <= 0.003_130_8 => 12.92 * intensity,
            Self::Srgb => 1.055 * libm::pow(intensity, 1.0 / 2.4) - 0.055,
        }
    }

    /// The definition of an integer sample: `round(max * encode(clamp(I, 0, 1)))`, 0 for NaN.
    /// The tables give the same number for every f32.
    pub fn quantise(self, intensity: f32, max: u32) -> u32 {
        let clamped = if intensity > 0.0 { f64::from(intensity).min(1.0) } else { 0.0 };
        (f64::from(max) * self.encode(clamped)).round() as u32
    }

    /// The inverse of `encode`, as a first guess only.
    fn decode(self, encoded: f64) -> f64 {
        match self {
            Self::Linear => encoded,
            Self::Srgb if encoded <= 0.040_45 => encoded / 12.92,
            Self::Srgb => libm::pow((encoded + 0.055) / 1.055, 2.4),
        }
    }

    /// The least f32 whose sample is at least `k`, 1 <= k <= max.
    fn threshold(self, k: u32, max: u32) -> f32 {
        let mut x = self.decode((f64::from(k) - 0.5) / f64::from(max)) as f32;
        while self.quantise(x, max) >= k {
            x = x.next_down();
        }
        while self.quantise(x, max) < k {
            x = x.next_up();
        }
        x
    }
}

/// The canonical NaN that float formats hold.
const NAN_BITS: u32 = 0x7fc0_0000;

/// A [`Transfer`] made ready for one kind of sample. Making one takes microseconds for 8 bits and
/// some milliseconds for 16 bits: make it once and keep it.
#[derive(Clone, Debug)]
pub struct TransferTable {
    transfer: Transfer,
    table: Table,
}

#[derive(Clone, Debug)]
enum Table {
    U8(Box<Buckets8>),
    U16(Box<Thresholds16>),
    F32,
}

/// 8 bits: a bucket is a float's upper 16 bits, and no bucket holds two thresholds. With `low` the
/// 16 bits below, `sample + low + 65536 - threshold` carries into bit 16 exactly from the bucket's
/// threshold on. The entry has the upper bits taken off already, so that it is added to the whole
/// float: `(entry + bits) >> 16` ends in the sample. Of the table only the 7 KiB between the floor
/// and 1 are ever read.
type Buckets8 = [u32; 65536];
/// Below the first threshold of 8 bits, and the bottom of a bucket.
const U8_FLOOR: f32 = 1.0 / 8192.0;

fn table_u8(transfer: Transfer) -> Box<Buckets8> {
    let thresholds: Vec<f32> = (1..=255).map(|k| transfer.threshold(k, 255)).collect();
    let mut table: Box<Buckets8> = vec![0; 65536].try_into().expect("65536 entries");
    for upper in (U8_FLOOR.to_bits() >> 16)..=(1.0_f32.to_bits() >> 16) {
        let start = f32::from_bits(upper << 16);
        let end = f32::from_bits((upper << 16) | 0xffff);
        let base = thresholds.partition_point(|&t| t <= start) as u32;
        let inside = thresholds.partition_point(|&t| t <= end) as u32 - base;
        let mut entry = base << 16;
        if inside > 0 {
            entry += 0x1_0000 - (thresholds[base as usize].to_bits() & 0xffff);
        }
        debug_assert!(inside <= 1);
        table[upper as usize] = entry.wrapping_sub(upper << 16);
    }
    table
}

/// The bits of `x`, held between `floor` and 1. In this order a NaN becomes the floor.
#[inline(always)]
fn clamped_bits(x: f32, floor: f32) -> u32 {
    let x = if x > floor { x } else { floor };
    let x = if x < 1.0 { x } else { 1.0 };
    x.to_bits()
}

#[inline(always)]
fn sample_u8(table: &Buckets8, bits: u32) -> u8 {
    (table[(bits >> 16) as usize].wrapping_add(bits) >> 16) as u8
}

/// 16 bits: a bucket holds many thresholds; a line through it guesses the sample to within one,
/// and two comparisons settle it.
#[derive(Clone, Debug)]
struct Thresholds16 {
    /// `at[k]` is threshold k; `at[0]` = 0, and infinity stands at the end.
    at: Vec<f32>,
    /// The sample at the start of each bucket, and one more.
    base: Vec<u32>,
}

/// Below the first threshold of 16 bits, and the bottom of a bucket.
const U16_FLOOR: f32 = 1.0 / 2_097_152.0;
const U16_SHIFT: u32 = 15;

fn table_u16(transfer: Transfer) -> Box<Thresholds16> {
    let mut at = vec![0.0];
    at.extend((1..=65535).map(|k| transfer.threshold(k, 65535)));
    at.push(f32::INFINITY);
    let first = U16_FLOOR.to_bits() >> U16_SHIFT;
    let last = 1.0_f32.to_bits() >> U16_SHIFT;
    let base = (first..=last + 1)
        .map(|bucket| {
            let start = f32::from_bits(bucket << U16_SHIFT);
            at.partition_point(|&t| t <= start.min(1.0)) as u32 - 1
        })
        .collect();
    Box::new(Thresholds16 { at, base })
}

#[inline(always)]
fn sample_u16(table: &Thresholds16, bits: u32) -> u16 {
    let x = f32::from_bits(bits);
    let bucket = ((bits - U16_FLOOR.to_bits()) >> U16_SHIFT) as usize;
    let low = bits & ((1 << U16_SHIFT) - 1);
    let base = table.base[bucket];
    let guess = (base + (((table.base[bucket + 1] - base) * low) >> U16_SHIFT)) as usize;
    let sample = guess + usize::from(x >= table.at[guess]) + usize::from(x >= table.at[guess + 1]);
    (sample - 1) as u16
}

/// Integer samples of pixels. Clamping by itself, some pixels at a time, is left to the vector
/// units; together with the look-up the compiler makes branches of it.
#[inline(always)]
fn each<T>(pixels: &[[f32; 4]], samples: &mut [T], floor: f32, sample: impl Fn(u32) -> T) {
    const PIECE: usize = 64;
    let mut bits = [0_u32; 4 * PIECE];
    for (samples, pixels) in samples.chunks_mut(3 * PIECE).zip(pixels.chunks(PIECE)) {
        for (bits, &x) in bits.iter_mut().zip(pixels.as_flattened()) {
            *bits = clamped_bits(x, floor);
        }
        for (samples, bits) in samples.chunks_exact_mut(3).zip(bits.chunks_exact(4)) {
            samples[0] = sample(bits[0]);
            samples[1] = sample(bits[1]);
            samples[2] = sample(bits[2]);
        }
    }
}

fn canonical(x: f32) -> f32 {
    if x.is_nan() { f32::from_bits(NAN_BITS) } else { x }
}

impl SamplesMut<'_> {
    fn len(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => samples.len(),
            Self::F32(samples) => samples.len(),
        }
    }
}

impl TransferTable {
    /// The table of `transfer` for samples of `kind`. Float samples take intensities as they are.
    pub fn new(transfer: Transfer, kind: SampleKind) -> Self {
        let table = match kind {
            SampleKind::U8 => Table::U8(table_u8(transfer)),
            SampleKind::U16 => Table::U16(table_u16(transfer)),
            SampleKind::F32 => Table::F32,
        };
        Self { transfer, table }
    }

    /// The transfer that the table was made of.
    pub fn transfer(&self) -> Transfer {
        self.transfer
    }

    /// The kind of samples that it gives.
    pub fn kind(&self) -> SampleKind {
        match self.table {
            Table::U8(_) => SampleKind::U8,
            Table::U16(_) => SampleKind::U16,
            Table::F32 => SampleKind::F32,
        }
    }

    /// Encodes a tile: `pixels` are linear intensities of red, green and blue and a fourth number
    /// that means nothing, rows of the tile consecutive; `samples` takes three a pixel. NaN becomes
    /// 0 in integers and one canonical NaN in floats.
    ///
    /// # Panics
    /// If the lengths do not fit, or `samples` are not of the table's kind.
    pub fn encode_tile(&self, pixels: &[[f32; 4]], samples: &mut SamplesMut<'_>) {
        assert_eq!(pixels.len() * 3, samples.len(), "three samples a pixel");
        match (&self.table, samples) {
            (Table::U8(table), SamplesMut::U8(out)) => {
                each(pixels, out, U8_FLOOR, |bits| sample_u8(table, bits));
            }
            (Table::U16(table), SamplesMut::U16(out)) => {
                each(pixels, out, U16_FLOOR, |bits| sample_u16(table, bits));
            }
            (Table::F32, SamplesMut::F32(out)) => {
                for (samples, pixel) in out.chunks_exact_mut(3).zip(pixels) {
                    let [r, g, b, _] = *pixel;
                    samples.copy_from_slice(&[r, g, b].map(canonical));
                }
            }
            _ => panic!("the picture's samples are not {:?}", self.kind()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVES: [Transfer; 2] = [Transfer::Srgb, Transfer::Linear];

    fn hold_u8(table: &Buckets8, transfer: Transfer, x: f32) {
        let (got, want) =
            (u32::from(sample_u8(table, clamped_bits(x, U8_FLOOR))), transfer.quantise(x, 255));
        assert_eq!(got, want, "{transfer:?} {x:e} ({:#x})", x.to_bits());
    }

    fn hold_u16(table: &Thresholds16, transfer: Transfer, x: f32) {
        let (got, want) =
            (u32::from(sample_u16(table, clamped_bits(x, U16_FLOOR))), transfer.quantise(x, 65535));
        assert_eq!(got, want, "{transfer:?} {x:e} ({:#x})", x.to_bits());
    }

    /// The threshold and two floats to either side.
    fn around(x: f32) -> [f32; 5] {
        let (down, up) = (x.next_down(), x.next_up());
        [down.next_down(), down, x, up, up.next_up()]
    }

    const ODD: [f32; 14] = [
        0.0,
        -0.0,
        -1.0,
        1.0,
        1.000_000_1,
        2.0,
        1e30,
        -1e30,
        f32::MIN_POSITIVE,
        1e-45,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        -f32::NAN,
    ];

    #[test]
    fn u8_is_exact_around_every_threshold() {
        for transfer in CURVES {
            let table = table_u8(transfer);
            for k in 1..=255 {
                for x in around(transfer.threshold(k, 255)) {
                    hold_u8(&table, transfer, x);
                }
            }
            for x in ODD {
                hold_u8(&table, transfer, x);
            }
        }
    }

    #[test]
    fn u16_is_exact_around_every_threshold() {
        for transfer in CURVES {
            let table = table_u16(transfer);
            for k in 1..=65535 {
                for x in around(transfer.threshold(k, 65535)) {
                    hold_u16(&table, transfer, x);
                }
            }
            for x in ODD {
                hold_u16(&table, transfer, x);
            }
        }
    }

    #[test]
    fn buckets_are_exact_at_both_ends() {
        for transfer in CURVES {
            let table = table_u8(transfer);
            for upper in 0..0x8000_u32 {
                for low in [0, 1, 0x7fff, 0x8000, 0xfffe, 0xffff] {
                    hold_u8(&table, transfer, f32::from_bits((upper << 16) | low));
                }
            }
            let table = table_u16(transfer);
            for upper in 0..0x10000_u32 {
                for low in [0, 1, 0x3fff, 0x4000, 0x7ffe, 0x7fff] {
                    hold_u16(&table, transfer, f32::from_bits((upper << 15) | low));
                }
            }
        }
    }

    #[test]
    #[ignore = "every float in [0, 1], both curves and depths: minutes"]
    fn every_float_is_exact() {
        use rayon::prelude::*;
        for transfer in CURVES {
            let (narrow, wide) = (table_u8(transfer), table_u16(transfer));
            (0..=1.0_f32.to_bits()).into_par_iter().for_each(|bits| {
                let x = f32::from_bits(bits);
                hold_u8(&narrow, transfer, x);
                hold_u16(&wide, transfer, x);
            });
        }
    }

    #[test]
    fn known_values() {
        // 0.2140411 is the linear intensity of sRGB one half (IEC 61966-2-1), 127.5 before
        // rounding; 0.5 is exactly half of 255 in linear.
        assert_eq!(Transfer::Srgb.quantise(0.2158605, 255), 128);
        assert_eq!(Transfer::Srgb.quantise(0.5, 255), 188);
        assert_eq!(Transfer::Linear.quantise(0.5, 255), 128);
        assert_eq!(Transfer::Linear.quantise(0.5, 65535), 32768);
        assert_eq!(Transfer::Srgb.quantise(1.0, 65535), 65535);
    }

    #[test]
    fn tiles_interleave_and_nan_is_canonical() {
        let odd_nan = f32::from_bits(0xffc0_1234);
        let rgb = [[0.0, odd_nan, -3.0, 5.0], [1.0, 0.25, 7.0, f32::NAN]];
        let mut out = [9.0; 6];
        TransferTable::new(Transfer::Srgb, SampleKind::F32)
            .encode_tile(&rgb, &mut SamplesMut::F32(&mut out));
        let bits = out.map(f32::to_bits);
        assert_eq!(
            bits,
            [
                0,
                NAN_BITS,
                (-3.0_f32).to_bits(),
                1.0_f32.to_bits(),
                0.25_f32.to_bits(),
                7.0_f32.to_bits()
            ]
        );
        let mut out = [9; 6];
        TransferTable::new(Transfer::Linear, SampleKind::U8)
            .encode_tile(&rgb, &mut SamplesMut::U8(&mut out));
        assert_eq!(out, [0, 0, 0, 255, 64, 255]);
    }
}
