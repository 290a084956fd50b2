//! Frames to one file: animated GIF, animated PNG, animated WebP, YUV4MPEG2.
//!
//! Frames stream: a film of any length takes the memory of a few frames. GIF, APNG and WebP store of
//! each frame the rectangle that holds all pixels that changed, so rows that did not change are not
//! stored twice. A frame equal to the one before is a patch of one pixel, so that the file has as
//! many frames as the animation; only of a GIF that is faster than viewers, some are left out.

mod apng;
#[cfg(feature = "av1")]
mod av1;
pub(crate) mod closing;
mod encoding;
mod fps;
mod gif;
mod pace;
mod quantise;
mod sink;
mod webp;
mod y4m;

pub use encoding::{Dither, VideoQuality};
pub use fps::{Fps, FpsError};
pub use sink::FilmSink;

use crate::format::Format;
use crate::picture::{Picture, TileRect};
use crate::still::Compression;
use crate::transfer::Transfer;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

/// What a film is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilmSpec {
    /// GIF, APNG, WebP, Y4M, what ffmpeg makes of Y4M, or AV1.
    pub format: Format,
    /// Pixels across, 1..=65535.
    pub width: u32,
    /// Pixels down, 1..=65535.
    pub height: u32,
    /// Frames a second.
    pub fps: Fps,
    /// Frames in all, at least 1. APNG says it at its head.
    pub frames: u32,
    /// What the samples went through, which formats that can say it say.
    pub transfer: Transfer,
    /// For APNG.
    pub compression: Compression,
    /// For GIF.
    pub dither: Dither,
    /// The folder for what must wait until all frames are known, in a file without a name (GIF);
    /// the system's own folder for such files if `None`.
    pub spool: Option<PathBuf>,
}

/// What was stored of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pushed {
    /// The pixels that were stored: none if the frame was left out.
    pub stored: TileRect,
    /// False if every pixel equals that of the frame before.
    pub changed: bool,
}

/// Writes the frames of a film, one after the other.
#[derive(Debug)]
pub struct FilmWriter<W: Write> {
    spec: FilmSpec,
    pushed: u32,
    frame: Vec<u8>,
    before: Vec<u8>,
    codec: Codec<W>,
}

#[derive(Debug)]
enum Codec<W: Write> {
    Gif(Box<gif::GifFilm<W>>),
    Apng(apng::ApngFilm<W>),
    Webp(webp::WebpFilm<W>),
    Y4m(y4m::Y4mFilm<W>),
    #[cfg(feature = "av1")]
    Av1(Box<av1::Av1Film<W>>),
}

/// Bytes that go over some written before, once the film has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Where.
    pub offset: u64,
    /// What.
    pub bytes: [u8; 4],
}

fn invalid(message: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, message)
}

impl<W: Write> FilmWriter<W> {
    /// Begins a film: writes its head to `sink`, which is then written to as frames come, in large
    /// pieces.
    ///
    /// # Errors
    /// `InvalidInput` if `spec` is not a film's; what `sink` reports.
    pub fn new(sink: W, spec: FilmSpec) -> io::Result<Self> {
        let sizes = 1..=65535;
        if !sizes.contains(&spec.width) || !sizes.contains(&spec.height) {
            return Err(invalid(format!(
                "a film of {} x {} pixels: width and height must be 1 to 65535",
                spec.width, spec.height
            )));
        }
        if spec.frames == 0 {
            return Err(invalid("a film of no frames".to_owned()));
        }
        let codec = match spec.format {
            Format::Gif => Codec::Gif(Box::new(gif::GifFilm::new(sink, spec.spool.as_deref()))),
            Format::Apng => Codec::Apng(apng::ApngFilm::new(sink, &spec)?),
            Format::Webp => Codec::Webp(webp::WebpFilm::new(sink, &spec)?),
            Format::Y4m | Format::Mp4 | Format::Mkv => Codec::Y4m(y4m::Y4mFilm::new(sink, &spec)?),
            #[cfg(feature = "av1")]
            Format::Ivf => Codec::Av1(Box::new(av1::Av1Film::new(sink, &spec)?)),
            #[cfg(not(feature = "av1"))]
            Format::Ivf => {
                let why = Format::Ivf.unbuilt().unwrap_or_default();
                return Err(io::Error::new(ErrorKind::Unsupported, why));
            }
            still => {
                return Err(invalid(format!(
                    "{still} is not a film: each frame is a still of its own"
                )));
            }
        };
        Ok(Self { spec, pushed: 0, frame: Vec::new(), before: Vec::new(), codec })
    }

    /// The film's description.
    pub fn spec(&self) -> &FilmSpec {
        &self.spec
    }

    /// Frames so far.
    pub fn frames(&self) -> u32 {
        self.pushed
    }

    /// Adds a frame of 8-bit samples.
    ///
    /// # Errors
    /// `InvalidInput` if the picture is not of the film's size and sample kind, or there are more
    /// frames than announced; what the sink reports.
    pub fn push(&mut self, picture: &Picture) -> io::Result<Pushed> {
        let (layout, spec) = (picture.layout(), &self.spec);
        if (layout.width(), layout.height()) != (spec.width, spec.height)
            || picture.kind() != spec.format.sample_kind()
        {
            return Err(invalid(format!(
                "a frame of {} x {} {:?} samples in a film of {} x {} {:?}",
                layout.width(),
                layout.height(),
                picture.kind(),
                spec.width,
                spec.height,
                spec.format.sample_kind()
            )));
        }
        if self.pushed == spec.frames {
            return Err(invalid(format!("the film was announced with {} frames", spec.frames)));
        }
        if spec.format == Format::Gif
            && pace::hundredths(spec.fps, spec.frames, self.pushed).is_none()
        {
            self.pushed += 1;
            let stored = TileRect { x: 0, y: 0, width: 0, height: 0 };
            return Ok(Pushed { stored, changed: false });
        }
        std::mem::swap(&mut self.frame, &mut self.before);
        self.frame.clear();
        crate::png::gather(picture, 0..spec.height, &mut self.frame);
        let whole = TileRect { x: 0, y: 0, width: spec.width, height: spec.height };
        let pushed = if self.pushed == 0 {
            Pushed { stored: whole, changed: true }
        } else {
            match changed(&self.frame, &self.before, spec.width as usize) {
                Some(stored) => Pushed { stored, changed: true },
                None => {
                    Pushed { stored: TileRect { x: 0, y: 0, width: 1, height: 1 }, changed: false }
                }
            }
        };
        let before = (self.pushed > 0).then_some(self.before.as_slice());
        let shot = Shot {
            index: self.pushed,
            width: spec.width as usize,
            frame: &self.frame,
            before,
            stored: pushed.stored,
        };
        match &mut self.codec {
            Codec::Gif(film) => film.push(&shot, spec)?,
            Codec::Apng(film) => film.push(&shot, spec)?,
            Codec::Webp(film) => film.push(&shot, spec)?,
            Codec::Y4m(film) => film.push(&shot)?,
            #[cfg(feature = "av1")]
            Codec::Av1(film) => film.push(&shot)?,
        }
        self.pushed += 1;
        Ok(match spec.format {
            // Every frame is stored whole.
            Format::Y4m | Format::Mp4 | Format::Mkv | Format::Ivf => {
                Pushed { stored: whole, ..pushed }
            }
            _ => pushed,
        })
    }

    /// What goes over the film's head when it has ended: to be asked for when all frames are in.
    pub fn patch(&self) -> Option<Patch> {
        match &self.codec {
            Codec::Webp(film) => webp::patch(film.length()).ok(),
            _ => None,
        }
    }

    /// Ends the film and gives the sink back, flushed.
    ///
    /// # Errors
    /// `InvalidInput` if there are fewer frames than announced; what the sink reports.
    pub fn finish(self) -> io::Result<W> {
        let end = closing::bare(self.spec.format);
        let mut sink = self.all_but_the_end()?;
        sink.write_all(&end)?;
        sink.flush()?;
        Ok(sink)
    }

    fn all_but_the_end(self) -> io::Result<W> {
        if self.pushed != self.spec.frames {
            return Err(invalid(format!(
                "the film was announced with {} frames and has {}",
                self.spec.frames, self.pushed
            )));
        }
        match self.codec {
            Codec::Gif(film) => film.finish(&self.spec),
            Codec::Apng(film) => Ok(film.finish()),
            Codec::Webp(film) => Ok(film.finish()),
            Codec::Y4m(film) => Ok(film.finish()),
            #[cfg(feature = "av1")]
            Codec::Av1(film) => film.finish(),
        }
    }
}

impl FilmWriter<FilmSink> {
    /// Ends the film with `texts`, which say what it was made from (with none it says nothing),
    /// gives the file its name, and tells its length in bytes.
    ///
    /// # Errors
    /// Those of [`FilmWriter::finish`]; what the system says, or ffmpeg.
    pub fn commit(self, texts: &[(&str, &str)]) -> io::Result<u64> {
        let format = self.spec.format;
        let webp = match &self.codec {
            Codec::Webp(film) => Some(film.length()),
            _ => None,
        };
        let patch = |end: usize| webp.map(|length| webp::patch(length + end as u64)).transpose();
        self.all_but_the_end()?.commit(format, texts, patch)
    }
}

/// A frame on its way to a codec.
#[derive(Clone, Copy)]
struct Shot<'a> {
    index: u32,
    /// Pixels a row.
    width: usize,
    /// R, G, B triples, rows from the top.
    frame: &'a [u8],
    /// The frame before, if there is one.
    before: Option<&'a [u8]>,
    stored: TileRect,
}

impl<'a> Shot<'a> {
    /// The triples of row `y` of the stored rectangle, taken from `frame`.
    fn row(&self, frame: &'a [u8], y: u32) -> &'a [u8] {
        let stored = self.stored;
        let start = ((stored.y + y) as usize * self.width + stored.x as usize) * 3;
        &frame[start..start + stored.width as usize * 3]
    }
}

/// The least rectangle outside of which two frames are equal; `None` if they are equal.
fn changed(frame: &[u8], before: &[u8], width: usize) -> Option<TileRect> {
    let row_bytes = width * 3;
    let rows = || {
        let rows = frame.chunks_exact(row_bytes).zip(before.chunks_exact(row_bytes));
        rows.enumerate()
    };
    let top = rows().find(|(_, (a, b))| a != b)?.0;
    let bottom = rows().rev().find(|(_, (a, b))| a != b)?.0;
    let (mut left, mut right) = (row_bytes, 0);
    for (_, (a, b)) in rows().skip(top).take(bottom + 1 - top) {
        // Only what is outside of the columns found so far can widen them.
        let differ = |(x, y): (&u8, &u8)| x != y;
        if let Some(at) = a[..left].iter().zip(&b[..left]).position(differ) {
            left = at;
        }
        if let Some(at) = a[right..].iter().zip(&b[right..]).rposition(differ) {
            right += at + 1;
        }
    }
    let (left, right) = (left / 3, right.div_ceil(3));
    Some(TileRect {
        x: left as u32,
        y: top as u32,
        width: (right - left) as u32,
        height: (bottom + 1 - top) as u32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_changed_rectangle_is_the_least() {
        let (width, height) = (7, 5);
        let before = vec![3_u8; width * height * 3];
        assert_eq!(changed(&before, &before, width), None);
        for (x0, y0, x1, y1) in
            [(0, 0, 0, 0), (6, 4, 6, 4), (2, 1, 5, 3), (0, 0, 6, 4), (4, 0, 1, 4)]
        {
            for channel in 0..3 {
                let mut frame = before.clone();
                frame[(y0 * width + x0) * 3 + channel] = 9;
                frame[(y1 * width + x1) * 3 + 2 - channel] = 9;
                let (left, right) = (x0.min(x1), x0.max(x1));
                assert_eq!(
                    changed(&frame, &before, width),
                    Some(TileRect {
                        x: left as u32,
                        y: y0 as u32,
                        width: (right - left + 1) as u32,
                        height: (y1 - y0 + 1) as u32,
                    })
                );
            }
        }
    }
}
