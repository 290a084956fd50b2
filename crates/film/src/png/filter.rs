//! The filters of PNG (section 9 of its specification) and the choice among them.

use crate::still::Compression;

const NONE: u8 = 0;
const SUB: u8 = 1;
const UP: u8 = 2;
const AVERAGE: u8 = 3;
const PAETH: u8 = 4;

/// The buffers of one worker.
#[derive(Default)]
pub(crate) struct Scratch {
    best: Vec<u8>,
    tried: Vec<u8>,
}

/// Appends each row of `raw` behind the number of its filter. The first row is filtered by itself
/// alone, so that a band does not depend on the one before.
pub(crate) fn rows(
    raw: &[u8],
    row_bytes: usize,
    pixel_bytes: usize,
    compression: Compression,
    scratch: &mut Scratch,
    out: &mut Vec<u8>,
) {
    let start = out.len();
    out.resize(start + raw.len() + raw.len() / row_bytes, 0);
    let mut above: Option<&[u8]> = None;
    let rows = raw.chunks_exact(row_bytes);
    for (row, out) in rows.zip(out[start..].chunks_exact_mut(row_bytes + 1)) {
        let Some((chosen, filtered)) = out.split_first_mut() else {
            continue;
        };
        *chosen = match (compression, above) {
            (Compression::Fast, None) => SUB,
            (Compression::Fast, Some(above)) => guess(row, above, pixel_bytes),
            (_, above) => try_all(row, above, pixel_bytes, scratch),
        };
        match compression {
            // Without a row above, no filter that is chosen looks there.
            Compression::Fast => apply(*chosen, row, above.unwrap_or(row), pixel_bytes, filtered),
            _ => filtered.copy_from_slice(&scratch.best),
        }
        above = Some(row);
    }
}

/// The filter of the least cost, whose result is left in `scratch.best`.
fn try_all(row: &[u8], above: Option<&[u8]>, pixel_bytes: usize, scratch: &mut Scratch) -> u8 {
    let Scratch { best, tried } = scratch;
    best.resize(row.len(), 0);
    tried.resize(row.len(), 0);
    let filters = if above.is_some() { NONE..=PAETH } else { NONE..=SUB };
    let (mut chosen, mut least) = (NONE, u64::MAX);
    for filter in filters {
        apply(filter, row, above.unwrap_or(row), pixel_bytes, tried);
        let cost = cost(tried);
        if cost < least {
            (chosen, least) = (filter, cost);
            std::mem::swap(best, tried);
        }
    }
    chosen
}

/// Sub, unless samples of the row say that Up is much better. In renders Sub alone is as small as
/// the cheapest of all filters to within a few percent, and Up seldom wins but then by far (rows
/// that repeat).
fn guess(row: &[u8], above: &[u8], pixel_bytes: usize) -> u8 {
    const SAMPLE: usize = 64;
    const STRIDE: usize = 256;
    let left = &row[..row.len() - pixel_bytes];
    let (row, above) = (&row[pixel_bytes..], &above[pixel_bytes..]);
    let (mut sub, mut up) = (0, 0);
    for start in (0..row.len()).step_by(STRIDE) {
        let end = row.len().min(start + SAMPLE);
        let samples = row[start..end].iter();
        let samples = samples.zip(&left[start..end]).zip(&above[start..end]);
        let (mut s, mut u) = (0_u16, 0_u16);
        for ((&x, &a), &b) in samples {
            s += u16::from((x.wrapping_sub(a) as i8).unsigned_abs());
            u += u16::from((x.wrapping_sub(b) as i8).unsigned_abs());
        }
        sub += u32::from(s);
        up += u32::from(u);
    }
    if 2 * up < sub { UP } else { SUB }
}

/// The sum of the filtered bytes as signed numbers, without their signs.
fn cost(filtered: &[u8]) -> u64 {
    // In pieces whose sums fit 16 bits, which vectorises best.
    let pieces = filtered.chunks(256);
    pieces
        .map(|piece| {
            let sum: u16 = piece.iter().map(|&b| u16::from((b as i8).unsigned_abs())).sum();
            u64::from(sum)
        })
        .sum()
}

/// Filters a row into `out`, of the same length. `above` is read by Up, Average and Paeth.
fn apply(filter: u8, row: &[u8], above: &[u8], pixel_bytes: usize, out: &mut [u8]) {
    if filter == UP {
        for ((out, &x), &b) in out.iter_mut().zip(row).zip(above) {
            *out = x.wrapping_sub(b);
        }
        return;
    }
    let n = row.len();
    let (first, rest) = out.split_at_mut(pixel_bytes);
    let left = &row[..n - pixel_bytes];
    let here = &row[pixel_bytes..];
    match filter {
        SUB => {
            first.copy_from_slice(&row[..pixel_bytes]);
            for ((out, &x), &a) in rest.iter_mut().zip(here).zip(left) {
                *out = x.wrapping_sub(a);
            }
        }
        AVERAGE => {
            for ((out, &x), &b) in first.iter_mut().zip(row).zip(above) {
                *out = x.wrapping_sub(b / 2);
            }
            let up = &above[pixel_bytes..];
            for (((out, &x), &a), &b) in rest.iter_mut().zip(here).zip(left).zip(up) {
                *out = x.wrapping_sub((a & b) + ((a ^ b) >> 1));
            }
        }
        PAETH => {
            for ((out, &x), &b) in first.iter_mut().zip(row).zip(above) {
                *out = x.wrapping_sub(b);
            }
            let up = &above[pixel_bytes..];
            let corner = &above[..n - pixel_bytes];
            let rest = rest.iter_mut().zip(here).zip(left).zip(up).zip(corner);
            for ((((out, &x), &a), &b), &c) in rest {
                *out = x.wrapping_sub(paeth(a, b, c));
            }
        }
        _ => {
            first.copy_from_slice(&row[..pixel_bytes]);
            rest.copy_from_slice(here);
        }
    }
}

/// Whichever of left, above and corner is nearest to left + above - corner, in this order.
#[inline(always)]
fn paeth(a: u8, b: u8, c: u8) -> u8 {
    let (x, y) = (i16::from(b) - i16::from(c), i16::from(a) - i16::from(c));
    let (to_a, to_b, to_c) = (x.abs(), y.abs(), (x + y).abs());
    let near = if to_b <= to_c { b } else { c };
    if to_a <= to_b && to_a <= to_c { a } else { near }
}
