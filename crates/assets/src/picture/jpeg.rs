//! JPEG: what its markers say (ITU-T T.81, annex B), and the decoder for what that can do.
//!
//! The decoder takes what it cannot do for something that it can, and fills in what is missing with
//! grey. So a file is walked from marker to marker first.

use super::{Curve, Orientation, Raster, Room, Samples, profile_note};
use crate::error::Fault;
use std::io::Cursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// Far more scans than a progressive file has; each costs a pass over the picture.
const MOST_SCANS: usize = 200;

/// What the markers of a file say.
#[derive(Debug, Default)]
struct Markers {
    frame: Option<Frame>,
    /// How many components each scan has.
    scans: Vec<u8>,
    orientation: Option<Orientation>,
    /// The pieces of an ICC profile, in the order of the file.
    profile: Vec<u8>,
    /// Whether there is an end after the first scan: before that there may be another picture, small,
    /// with an end of its own.
    ended: bool,
}

/// A frame header.
#[derive(Clone, Debug)]
struct Frame {
    /// The marker's second byte.
    kind: u8,
    precision: u8,
    height: u16,
    width: u16,
    /// How often each component is sampled along x and y.
    sampling: Vec<[u8; 2]>,
}

impl Markers {
    fn of(bytes: &[u8]) -> Result<Markers, Fault> {
        let mut markers = Markers::default();
        let mut at = 2;
        while let Some(&[first, kind]) = bytes.get(at..at + 2) {
            match kind {
                _ if first != 0xff && markers.scans.is_empty() => break,
                // Stray bytes between scans.
                _ if first != 0xff => {
                    at = next_marker(bytes, at);
                    continue;
                }
                0xff => {
                    at += 1;
                    continue;
                }
                0x01 | 0xd0..=0xd7 => {
                    at += 2;
                    continue;
                }
                0xd9 => {
                    markers.ended = !markers.scans.is_empty();
                    break;
                }
                _ => {}
            }
            let Some(&[high, low]) = bytes.get(at + 2..at + 4) else { break };
            let length = usize::from(u16::from_be_bytes([high, low]));
            let Some(body) = bytes.get(at + 4..).and_then(|r| r.get(..length.checked_sub(2)?))
            else {
                break;
            };
            at += 2 + length;
            match kind {
                // All start-of-frame markers; the others of this row define tables.
                0xc0..=0xcf if !matches!(kind, 0xc4 | 0xc8 | 0xcc) => {
                    markers.frame = Some(Frame::of(kind, body).ok_or_else(|| {
                        Fault::byte(
                            at - length,
                            "the JPEG is broken: its frame header is too short",
                        )
                    })?);
                }
                0xcc => return Err(unread("arithmetic coding")),
                0xda => {
                    markers.scans.push(body.first().copied().unwrap_or(0));
                    at = next_marker(bytes, at);
                }
                0xe1 if body.starts_with(b"Exif\0\0") && markers.orientation.is_none() => {
                    markers.orientation = Orientation::from_exif_chunk(&body[6..]);
                }
                0xe2 if body.starts_with(b"ICC_PROFILE\0") => {
                    markers.profile.extend_from_slice(body.get(14..).unwrap_or_default());
                }
                _ => {}
            }
        }
        Ok(markers)
    }
}

impl Frame {
    fn of(kind: u8, body: &[u8]) -> Option<Frame> {
        let &[precision, h0, h1, w0, w1, count, ref rest @ ..] = body else { return None };
        let components = rest.as_chunks::<3>().0.get(..count.into())?;
        let sampling = components.iter().map(|[_, both, _]| [both >> 4, both & 15]).collect();
        let (height, width) = (u16::from_be_bytes([h0, h1]), u16::from_be_bytes([w0, w1]));
        Some(Frame { kind, precision, height, width, sampling })
    }

    /// The fewest bytes that its blocks of 8 x 8 samples take: a code for the mean, which a progressive
    /// file has in a scan of its own, and one for the end of the block, of a bit each.
    fn least_bytes(&self) -> u64 {
        let widest = |axis: usize| self.sampling.iter().map(|each| each[axis]).max().unwrap_or(0);
        let across = |length: u16, of: u8, most: u8| {
            (u64::from(length) * u64::from(of)).div_ceil(8 * u64::from(most.max(1)))
        };
        let blocks = |[x, y]: &[u8; 2]| {
            across(self.width, *x, widest(0)) * across(self.height, *y, widest(1))
        };
        let bits = if self.is_progressive() { 1 } else { 2 };
        self.sampling.iter().map(blocks).sum::<u64>() * bits / 8
    }

    fn is_progressive(&self) -> bool {
        self.kind == 0xc2
    }

    /// What of it is not read.
    fn unread(&self) -> Option<Fault> {
        let what = match self.kind {
            0xc3 => "lossless coding",
            0xc5..=0xc7 | 0xcd..=0xcf => "hierarchical coding",
            0xc9..=0xcb => "arithmetic coding",
            0xf7 => "JPEG-LS coding",
            _ if self.precision != 8 => {
                return Some(unread(&format!("samples of {} bits", self.precision)));
            }
            _ if self.height == 0 => "a height that is told after the picture (DNL)",
            _ => return None,
        };
        Some(unread(what))
    }
}

fn unread(what: &str) -> Fault {
    Fault::file(format!(
        "the JPEG has {what}, which is not read: save it as baseline or progressive JPEG, or as PNG"
    ))
}

/// The place of the next marker after entropy-coded data, or the end.
fn next_marker(bytes: &[u8], from: usize) -> usize {
    let rest = bytes[from..].windows(2);
    let marker = |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7 | 0xff);
    rest.clone().position(marker).map_or(bytes.len(), |at| from + at)
}

pub(super) fn decode(bytes: &[u8], room: Room) -> Result<Raster, Fault> {
    let broken =
        |error: &dyn std::fmt::Display| Fault::file(format!("the JPEG is broken: {error}"));
    let markers = Markers::of(bytes)?;
    let frame = markers.frame.clone().ok_or_else(|| match markers.scans.is_empty() {
        true => Fault::byte(bytes.len(), "the file ends too early"),
        false => broken(&"it has no frame header"),
    })?;
    if let Some(fault) = frame.unread() {
        return Err(fault);
    }
    let components = frame.sampling.len();
    if !matches!(components, 1 | 3 | 4) {
        return Err(unread(&format!("{components} components")));
    }
    if !markers.ended {
        return Err(Fault::byte(bytes.len(), "the file ends too early"));
    }
    if markers.scans.len() > MOST_SCANS {
        let message =
            format!("it has {} scans, and {MOST_SCANS} are read at most", markers.scans.len());
        return Err(broken(&message));
    }
    let whole = markers.scans.first().is_some_and(|first| usize::from(*first) == components);
    let subsampled = frame.sampling.iter().any(|each| *each != frame.sampling[0]);
    if !frame.is_progressive() && !whole && subsampled {
        return Err(unread("a baseline picture in several scans"));
    }
    let widest = |axis: usize| frame.sampling.iter().map(|each| each[axis]).max().unwrap_or(0);
    if (0..2).any(|axis| frame.sampling[0][axis] < widest(axis)) {
        return Err(unread("a first component that is sampled less often than others"));
    }
    // Three samples a pixel, and where scans follow each other two bytes for each coefficient.
    let each = 3 + if frame.is_progressive() || !whole { 2 * components as u64 } else { 0 };
    let count = room.pixels(frame.width.into(), frame.height.into(), each)?;
    // The decoder fills in what is missing before an end.
    if (bytes.len() as u64) < frame.least_bytes() {
        return Err(Fault::byte(bytes.len(), "the file ends too early"));
    }
    let options = DecoderOptions::default()
        .set_max_width(super::LONGEST_EDGE as usize)
        .set_max_height(super::LONGEST_EDGE as usize)
        .set_strict_mode(true)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| broken(&error))?;
    if decoder.dimensions() != Some((frame.width.into(), frame.height.into())) {
        return Err(broken(&"it has two frame headers"));
    }
    let samples = decoder.decode().map_err(|error| broken(&error))?;
    if samples.len() != 3 * count {
        return Err(broken(&"its samples are too few"));
    }
    let notes = match components {
        // A profile of inks says nothing of the colours that they were turned into.
        4 => {
            vec!["its inks (CMYK) are turned into red, green and blue without a profile".to_owned()]
        }
        _ if markers.profile.is_empty() => Vec::new(),
        _ => profile_note(&markers.profile).into_iter().collect(),
    };
    Ok(Raster {
        width: frame.width.into(),
        height: frame.height.into(),
        channels: 3,
        samples: Samples::U8(samples),
        curve: Curve::Srgb,
        orientation: markers.orientation.unwrap_or(Orientation::NoTransforms),
        notes,
    })
}
