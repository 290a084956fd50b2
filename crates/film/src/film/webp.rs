//! Animated WebP, lossless (WebP Container Specification; VP8L).

use super::{FilmSpec, Patch, Shot};
use crate::picture::TileRect;
use image_webp::{ColorType, EncodingError, WebPEncoder};
use std::io::{self, ErrorKind, Write};

/// The longest edge that VP8L can hold.
const LONGEST: u32 = 16_384;

#[derive(Debug)]
pub(super) struct WebpFilm<W> {
    sink: W,
    /// Bytes after the first eight.
    length: u64,
}

pub(super) fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    out.extend_from_slice(kind);
    out.extend_from_slice(&(data.len() as u32).to_le_bytes());
    out.extend_from_slice(data);
    if data.len() % 2 == 1 {
        out.push(0);
    }
}

/// The lower 24 bits.
fn three(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

fn failed(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(format!("WebP: {other}")),
    }
}

/// The length, where it belongs.
pub(super) fn patch(length: u64) -> io::Result<Patch> {
    let length = u32::try_from(length).ok().filter(|length| *length < u32::MAX);
    let length = length.ok_or_else(|| {
        io::Error::new(
            ErrorKind::FileTooLarge,
            "a WebP holds at most 4 GiB: make fewer or smaller frames, or another format",
        )
    })?;
    Ok(Patch { offset: 4, bytes: length.to_le_bytes() })
}

impl<W: Write> WebpFilm<W> {
    pub(super) fn new(mut sink: W, spec: &FilmSpec) -> io::Result<Self> {
        if spec.width > LONGEST || spec.height > LONGEST {
            return Err(io::Error::new(
                ErrorKind::InvalidInput,
                format!("a WebP of {} x {}: its edges are at most 16384", spec.width, spec.height),
            ));
        }
        // The length is not known yet.
        let mut head = b"RIFF\0\0\0\0WEBP".to_vec();
        let mut canvas = vec![2, 0, 0, 0]; // animated
        canvas.extend_from_slice(&three(spec.width - 1));
        canvas.extend_from_slice(&three(spec.height - 1));
        chunk(&mut head, b"VP8X", &canvas);
        // A black ground, played without end.
        chunk(&mut head, b"ANIM", &[0, 0, 0, 255, 0, 0]);
        sink.write_all(&head)?;
        Ok(Self { sink, length: head.len() as u64 - 8 })
    }

    pub(super) fn push(&mut self, shot: &Shot<'_>, spec: &FilmSpec) -> io::Result<()> {
        // Frames begin at even pixels.
        let TileRect { x, y, width, height } = shot.stored;
        let stored =
            TileRect { x: x & !1, y: y & !1, width: width + x % 2, height: height + y % 2 };
        let whole = Shot { stored, ..*shot };
        let mut pixels = Vec::with_capacity((stored.width * stored.height * 3) as usize);
        for row in 0..stored.height {
            pixels.extend_from_slice(whole.row(shot.frame, row));
        }
        let mut still = Vec::new();
        WebPEncoder::new(&mut still)
            .encode(&pixels, stored.width, stored.height, ColorType::Rgb8)
            .map_err(failed)?;
        let mut frame = Vec::with_capacity(still.len() + 16);
        frame.extend_from_slice(&three(stored.x / 2));
        frame.extend_from_slice(&three(stored.y / 2));
        frame.extend_from_slice(&three(stored.width - 1));
        frame.extend_from_slice(&three(stored.height - 1));
        // 24 bits hold more than four hours; the slowest rate has 17 minutes a frame.
        frame.extend_from_slice(&three(spec.fps.delay_of(shot.index, 1000) as u32));
        // Overwrite the rectangle, and leave the frame standing.
        frame.push(2);
        // Of the still's own file, what comes after its RIFF header.
        frame.extend_from_slice(&still[12..]);
        let mut bytes = Vec::with_capacity(frame.len() + 9);
        chunk(&mut bytes, b"ANMF", &frame);
        self.length += bytes.len() as u64;
        patch(self.length)?;
        self.sink.write_all(&bytes)
    }

    /// Bytes after the first eight, so far.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    pub(super) fn finish(self) -> W {
        self.sink
    }
}
