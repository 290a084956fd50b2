//! QOI, after its one-page specification (qoiformat.org, version 2022-01-05), three channels.

use crate::picture::Picture;

const INDEX: u8 = 0x00;
const DIFF: u8 = 0x40;
const LUMA: u8 = 0x80;
const RUN: u8 = 0xc0;
const RGB: u8 = 0xfe;
const LONGEST_RUN: u8 = 62;

fn hash([r, g, b]: [u8; 3]) -> usize {
    // Alpha is 255 throughout.
    (usize::from(r) * 3 + usize::from(g) * 5 + usize::from(b) * 7 + 255 * 11) % 64
}

pub(crate) fn encode(picture: &Picture) -> Vec<u8> {
    let (width, height) = (picture.layout().width(), picture.layout().height());
    let mut out = Vec::with_capacity(width as usize * height as usize);
    out.extend_from_slice(b"qoif");
    out.extend_from_slice(&width.to_be_bytes());
    out.extend_from_slice(&height.to_be_bytes());
    // Three channels; the transfer is the sRGB curve, as far as the format can say.
    out.extend_from_slice(&[3, 0]);

    // No pixel fits a slot that was never filled: those hold transparent black.
    let mut seen: [Option<[u8; 3]>; 64] = [None; 64];
    let mut before = [0_u8; 3];
    let mut run = 0;
    for y in 0..height {
        for piece in picture.row_pieces::<u8>(y) {
            for pixel in piece.chunks_exact(3) {
                let pixel = [pixel[0], pixel[1], pixel[2]];
                if pixel == before {
                    run += 1;
                    if run == LONGEST_RUN {
                        out.push(RUN | (run - 1));
                        run = 0;
                    }
                    continue;
                }
                if run > 0 {
                    out.push(RUN | (run - 1));
                    run = 0;
                }
                let slot = hash(pixel);
                if seen[slot] == Some(pixel) {
                    out.push(INDEX | slot as u8);
                } else {
                    seen[slot] = Some(pixel);
                    let red = pixel[0].wrapping_sub(before[0]);
                    let green = pixel[1].wrapping_sub(before[1]);
                    let blue = pixel[2].wrapping_sub(before[2]);
                    let small = [red, green, blue].map(|d| d.wrapping_add(2));
                    let luma = green.wrapping_add(32);
                    let red_luma = red.wrapping_sub(green).wrapping_add(8);
                    let blue_luma = blue.wrapping_sub(green).wrapping_add(8);
                    if small.iter().all(|&d| d < 4) {
                        out.push(DIFF | (small[0] << 4) | (small[1] << 2) | small[2]);
                    } else if luma < 64 && red_luma < 16 && blue_luma < 16 {
                        out.extend_from_slice(&[LUMA | luma, (red_luma << 4) | blue_luma]);
                    } else {
                        out.extend_from_slice(&[RGB, pixel[0], pixel[1], pixel[2]]);
                    }
                }
                before = pixel;
            }
        }
    }
    if run > 0 {
        out.push(RUN | (run - 1));
    }
    out.extend_from_slice(&[0, 0, 0, 0, 0, 0, 0, 1]);
    out
}
