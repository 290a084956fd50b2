//! What each pixel costs, as a picture.

use crate::exit::{Exit, Failure};
use reflet_film::{Format, Layout, Picture, SampleKind, SamplesMut, StillOptions, encode_still};
use std::path::Path;

/// Viridis by S. van der Walt and N. Smith (2015, CC0), at ninths: dark blue to yellow, with a
/// lightness that grows evenly. <https://bids.github.io/colormap/>
const VIRIDIS: [[u8; 3]; 10] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x28, 0x78],
    [0x3e, 0x49, 0x89],
    [0x31, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6e, 0xce, 0x58],
    [0xb5, 0xde, 0x2b],
    [0xfd, 0xe7, 0x25],
];

/// The digits, five rows of three pixels each, the left one in the highest bit.
const DIGITS: [[u8; 5]; 10] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 7, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 1, 2, 2],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
];

/// Pixels a pixel of a digit, and from one digit to the next.
const SCALE: usize = 2;
const ADVANCE: usize = 4 * SCALE;

/// Rows of the legend: a gap, the bar, a gap, numbers, a gap.
const GAP: usize = 4;
const BAR: usize = 10;
const LEGEND: usize = 3 * GAP + BAR + 5 * SCALE;

/// The narrowest picture that the legend's numbers fit in.
const NARROW: usize = 128;

/// The colour of a share, 0 to 1.
fn colour(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * 9.0;
    let below = (at as usize).min(8);
    let way = at - below as f64;
    let mix = |k: usize| {
        let [a, b] = [VIRIDIS[below][k], VIRIDIS[below + 1][k]].map(f64::from);
        (a + (b - a) * way).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

/// Rows of pixels.
struct Canvas {
    width: usize,
    rows: Vec<[u8; 3]>,
}

impl Canvas {
    fn put(&mut self, (x, y): (usize, usize), colour: [u8; 3]) {
        self.rows[y * self.width + x] = colour;
    }

    fn number(&mut self, (x, y): (usize, usize), number: &str) {
        for (i, digit) in number.bytes().enumerate() {
            for (row, bits) in DIGITS[usize::from(digit - b'0') % 10].into_iter().enumerate() {
                for column in (0..3).filter(|column| bits >> (2 - column) & 1 == 1) {
                    for k in 0..SCALE * SCALE {
                        let dx = column * SCALE + k % SCALE;
                        let at = (x + i * ADVANCE + dx, y + row * SCALE + k / SCALE);
                        self.put(at, [255; 3]);
                    }
                }
            }
        }
    }
}

/// Colours costs, from 0 to the greatest, over a legend: the bar of colours, and the numbers at its
/// ends.
fn draw(costs: &[u64], width: usize) -> Canvas {
    let (most, height) = (costs.iter().max().copied().unwrap_or_default(), costs.len() / width);
    let wide = width.max(NARROW);
    let mut canvas = Canvas { width: wide, rows: vec![[0; 3]; wide * (height + LEGEND)] };
    for (i, cost) in costs.iter().enumerate() {
        canvas.put((i % width, i / width), colour(*cost as f64 / most.max(1) as f64));
    }
    for x in 0..wide {
        for y in 0..BAR {
            canvas.put((x, height + GAP + y), colour(x as f64 / (wide - 1) as f64));
        }
    }
    let (text, y) = (most.to_string(), height + 2 * GAP + BAR);
    canvas.number((GAP, y), "0");
    canvas.number((wide.saturating_sub(text.len() * ADVANCE + GAP), y), &text);
    canvas
}

/// Writes a PNG of what each pixel of a picture of some width costs, row by row.
///
/// # Errors
/// An output's.
pub fn write(path: &Path, costs: &[u64], width: u32) -> Result<(), Failure> {
    let canvas = draw(costs, width as usize);
    let encode = || -> Result<Vec<u8>, Box<dyn std::error::Error>> {
        let height = canvas.rows.len() / canvas.width;
        let layout = Layout::try_new(canvas.width as u32, height as u32, 16)?;
        let mut picture = Picture::try_new(layout, SampleKind::U8)?;
        for tile in picture.tiles_mut() {
            let (rect, SamplesMut::U8(samples)) = (layout.tile_rect(tile.index), tile.samples)
            else {
                continue;
            };
            for y in 0..rect.height as usize {
                let row = (rect.y as usize + y) * canvas.width + rect.x as usize;
                let from = canvas.rows[row..row + rect.width as usize].as_flattened();
                let to = y * layout.tile() as usize * 3;
                samples[to..to + from.len()].copy_from_slice(from);
            }
        }
        Ok(encode_still(&picture, Format::Png, &StillOptions::default(), None)?.to_vec())
    };
    let fault = |e| Failure::new(Exit::Output, format!("{}: {e}", path.display()));
    super::put(path, &encode().map_err(fault)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colours_are_those_of_the_published_table() {
        assert_eq!(colour(0.0), VIRIDIS[0]);
        assert_eq!(colour(1.0), VIRIDIS[9]);
        assert_eq!(colour(4.0 / 9.0), VIRIDIS[4]);
        // The table's row 128 of 256 is (0.127568, 0.566949, 0.550556): within 4 of 255 of it.
        let far = |a: u8, b: f64| (f64::from(a) - 255.0 * b).abs();
        let [r, g, b] = colour(128.0 / 255.0);
        assert!(far(r, 0.127568) < 4.0 && far(g, 0.566949) < 4.0 && far(b, 0.550556) < 4.0);
    }

    #[test]
    fn costs_stand_over_a_legend() {
        let canvas = draw(&[0, 50, 100, 25], 2);
        assert_eq!((canvas.width, canvas.rows.len()), (NARROW, NARROW * (2 + LEGEND)));
        assert_eq!(canvas.rows[..2], [VIRIDIS[0], colour(0.5)]);
        assert_eq!(canvas.rows[NARROW..NARROW + 2], [VIRIDIS[9], colour(0.25)]);
        let bar = (2 + GAP) * NARROW;
        assert_eq!([canvas.rows[bar], canvas.rows[bar + NARROW - 1]], [VIRIDIS[0], VIRIDIS[9]]);
        // 0 has 12 pixels, 1 has 8; all of the scale's square.
        let white = canvas.rows.iter().filter(|c| **c == [255; 3]).count();
        assert_eq!(white, (12 + 8 + 2 * 12) * SCALE * SCALE);
        assert_eq!(draw(&[0; 4], 4).rows[0], VIRIDIS[0]);
    }
}
