//! QOI, after its one-page specification (qoiformat.org, version 2022-01-05), three channels.

use crate::decode::StillHead;
use crate::picture::Picture;
use crate::transfer::Transfer;

pub(crate) const MAGIC: &[u8] = b"qoif";
const INDEX: u8 = 0x00;
const DIFF: u8 = 0x40;
const LUMA: u8 = 0x80;
const RUN: u8 = 0xc0;
const RGB: u8 = 0xfe;
const RGBA: u8 = 0xff;
const LONGEST_RUN: u8 = 62;

fn hash([r, g, b]: [u8; 3]) -> usize {
    // Alpha is 255 throughout.
    (usize::from(r) * 3 + usize::from(g) * 5 + usize::from(b) * 7 + 255 * 11) % 64
}

pub(crate) fn encode(picture: &Picture, transfer: Transfer) -> Vec<u8> {
    let (width, height) = (picture.layout().width(), picture.layout().height());
    let mut out = Vec::with_capacity(width as usize * height as usize);
    out.extend_from_slice(MAGIC);
    out.extend_from_slice(&width.to_be_bytes());
    out.extend_from_slice(&height.to_be_bytes());
    // Three channels; the sRGB curve, or all of them linear.
    out.extend_from_slice(&[3, u8::from(transfer == Transfer::Linear)]);

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

/// The bytes of the header.
const HEAD: usize = 14;

/// What the header says.
///
/// # Errors
/// What is wrong, in words.
pub(crate) fn read_head(bytes: &[u8]) -> Result<StillHead, String> {
    let Some(&[_, _, _, _, w0, w1, w2, w3, h0, h1, h2, h3, _, space]) = bytes.first_chunk::<HEAD>()
    else {
        return Err("it ends too early".to_owned());
    };
    let size = [[w0, w1, w2, w3], [h0, h1, h2, h3]].map(u32::from_be_bytes);
    let transfer = if space == 1 { Transfer::Linear } else { Transfer::Srgb };
    Ok(StillHead { size, transfer: Some(transfer) })
}

/// The samples of red, green and blue; opacity is left out.
///
/// # Errors
/// It ends too early.
pub(crate) fn decode(bytes: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, String> {
    let cut = || "it ends too early".to_owned();
    let length = width as usize * height as usize * 3;
    let mut samples = Vec::new();
    samples.try_reserve_exact(length).map_err(|_| "there is no memory for it".to_owned())?;
    let mut seen = [[0_u8; 4]; 64];
    let mut pixel = [0, 0, 0, 255_u8];
    let mut rest = bytes.get(HEAD..).ok_or_else(cut)?.iter().copied();
    while samples.len() < length {
        let tag = rest.next().ok_or_else(cut)?;
        let mut byte = || rest.next().ok_or_else(cut);
        let mut times = 1;
        let [r, g, b, _] = &mut pixel;
        match tag {
            RGB => (*r, *g, *b) = (byte()?, byte()?, byte()?),
            RGBA => pixel = [byte()?, byte()?, byte()?, byte()?],
            _ if tag & 0xc0 == INDEX => pixel = seen[usize::from(tag)],
            _ if tag & 0xc0 == DIFF => {
                for (value, shift) in [(r, 4), (g, 2), (b, 0)] {
                    *value = value.wrapping_add((tag >> shift) & 3).wrapping_sub(2);
                }
            }
            _ if tag & 0xc0 == LUMA => {
                let (green, others) = ((tag & 63).wrapping_sub(32), byte()?);
                *g = g.wrapping_add(green);
                *r = r.wrapping_add(green).wrapping_add(others >> 4).wrapping_sub(8);
                *b = b.wrapping_add(green).wrapping_add(others & 15).wrapping_sub(8);
            }
            _ => times = usize::from(tag & 63) + 1,
        }
        let [r, g, b, a] = pixel.map(usize::from);
        seen[(r * 3 + g * 5 + b * 7 + a * 11) % 64] = pixel;
        for _ in 0..times.min((length - samples.len()) / 3) {
            samples.extend_from_slice(&pixel[..3]);
        }
    }
    Ok(samples)
}
