//! The filters of PNG (section 9 of its specification) and the choice among them.

use crate::still::Compression;

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
    let filters: &[u8] = match compression {
        Compression::Fast => &[SUB, UP, PAETH],
        Compression::Balanced | Compression::Small => &[0, SUB, UP, AVERAGE, PAETH],
    };
    let Scratch { best, tried } = scratch;
    let mut above: Option<&[u8]> = None;
    for row in raw.chunks_exact(row_bytes) {
        let mut least = u64::MAX;
        let mut chosen = 0;
        for &filter in filters {
            let Some(above) = above else {
                if filter > SUB {
                    continue;
                }
                apply(filter, row, row, pixel_bytes, tried);
                let cost = cost(tried);
                if cost < least {
                    (least, chosen) = (cost, filter);
                    std::mem::swap(best, tried);
                }
                continue;
            };
            apply(filter, row, above, pixel_bytes, tried);
            let cost = cost(tried);
            if cost < least {
                (least, chosen) = (cost, filter);
                std::mem::swap(best, tried);
            }
        }
        out.push(chosen);
        out.extend_from_slice(best);
        above = Some(row);
    }
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

fn apply(filter: u8, row: &[u8], above: &[u8], pixel_bytes: usize, out: &mut Vec<u8>) {
    let n = row.len();
    out.clear();
    out.resize(n, 0);
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
        UP => {
            for ((out, &x), &b) in out.iter_mut().zip(row).zip(above) {
                *out = x.wrapping_sub(b);
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
        _ => out.copy_from_slice(row),
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
