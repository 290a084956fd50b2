//! The formats, their names, and what they hold.

use crate::picture::SampleKind;
use std::fmt;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// PNG, 8 bits a sample.
    Png,
    /// PNG, 16 bits a sample.
    Png16,
    /// OpenEXR, 32-bit floats, channels B, G, R.
    Exr,
    /// OpenEXR, 16-bit floats.
    Exr16,
    /// The Quite OK Image format, 8 bits.
    Qoi,
    /// JPEG, 8 bits, 4:4:4.
    Jpeg,
    /// Binary PPM (`P6`), 8 bits.
    Ppm,
    /// Portable float map (`PF`), little-endian.
    Pfm,
    /// Animated GIF.
    Gif,
    /// Animated PNG, 8 bits.
    Apng,
    /// Animated WebP, lossless.
    Webp,
    /// YUV4MPEG2, 4:4:4.
    Y4m,
    /// MP4, encoded by ffmpeg.
    Mp4,
    /// Matroska, encoded by ffmpeg.
    Mkv,
    /// AV1 in IVF, 4:4:4; only where the feature `av1` was asked for.
    Ivf,
}

/// A name that is no format's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownFormat {
    /// The name as given.
    pub name: String,
}

impl fmt::Display for UnknownFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown format {:?}", self.name)?;
        if let Some(nearest) = Format::nearest(&self.name) {
            write!(f, ", did you mean {nearest:?}?")?;
        }
        write!(f, " (known: {})", Format::NAMES.join(", "))
    }
}

impl std::error::Error for UnknownFormat {}

impl Format {
    /// Every name that [`Format::from_name`] takes, stills first.
    pub const NAMES: [&str; 16] = [
        "png", "png16", "exr", "exr16", "qoi", "jpg", "jpeg", "ppm", "pfm", "gif", "apng", "webp",
        "y4m", "mp4", "mkv", "ivf",
    ];

    /// All formats, stills first.
    pub const ALL: [Self; 15] = [
        Self::Png,
        Self::Png16,
        Self::Exr,
        Self::Exr16,
        Self::Qoi,
        Self::Jpeg,
        Self::Ppm,
        Self::Pfm,
        Self::Gif,
        Self::Apng,
        Self::Webp,
        Self::Y4m,
        Self::Mp4,
        Self::Mkv,
        Self::Ivf,
    ];

    /// The format called `name`, in either case, without a leading dot.
    pub fn from_name(name: &str) -> Result<Self, UnknownFormat> {
        Ok(match name.to_ascii_lowercase().as_str() {
            "png" => Self::Png,
            "png16" => Self::Png16,
            "exr" => Self::Exr,
            "exr16" => Self::Exr16,
            "qoi" => Self::Qoi,
            "jpg" | "jpeg" => Self::Jpeg,
            "ppm" => Self::Ppm,
            "pfm" => Self::Pfm,
            "gif" => Self::Gif,
            "apng" => Self::Apng,
            "webp" => Self::Webp,
            "y4m" => Self::Y4m,
            "mp4" => Self::Mp4,
            "mkv" => Self::Mkv,
            "ivf" => Self::Ivf,
            _ => {
                return Err(UnknownFormat { name: name.to_owned() });
            }
        })
    }

    /// The format's name, which is also the usual ending of its files (`png16` and `exr16` apart).
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Png16 => "png16",
            Self::Exr => "exr",
            Self::Exr16 => "exr16",
            Self::Qoi => "qoi",
            Self::Jpeg => "jpg",
            Self::Ppm => "ppm",
            Self::Pfm => "pfm",
            Self::Gif => "gif",
            Self::Apng => "apng",
            Self::Webp => "webp",
            Self::Y4m => "y4m",
            Self::Mp4 => "mp4",
            Self::Mkv => "mkv",
            Self::Ivf => "ivf",
        }
    }

    /// The known name that is nearest to `name`, if one is near (at most two edits away, and
    /// nearer than half of its length).
    pub fn nearest(name: &str) -> Option<&'static str> {
        let name = name.to_ascii_lowercase();
        let (distance, nearest) = Self::NAMES
            .iter()
            .map(|known| (edits(&name, known), *known))
            .min_by_key(|(distance, _)| *distance)?;
        (distance <= 2 && distance * 2 <= nearest.len()).then_some(nearest)
    }

    /// The samples that a picture in this format is made of.
    pub fn sample_kind(self) -> SampleKind {
        match self {
            Self::Png16 => SampleKind::U16,
            Self::Exr | Self::Exr16 | Self::Pfm => SampleKind::F32,
            _ => SampleKind::U8,
        }
    }

    /// True for formats that hold all frames of an animation in one file.
    pub fn is_film(self) -> bool {
        use Format::{Apng, Gif, Ivf, Mkv, Mp4, Webp, Y4m};
        matches!(self, Gif | Apng | Webp | Y4m | Mp4 | Mkv | Ivf)
    }
}

impl Format {
    /// True for films that ffmpeg encodes.
    pub fn is_by_ffmpeg(self) -> bool {
        matches!(self, Self::Mp4 | Self::Mkv)
    }

    /// Why this program cannot write the format, if it cannot.
    pub fn unbuilt(self) -> Option<&'static str> {
        (self == Self::Ivf && !cfg!(feature = "av1")).then_some(
            "this program was built without AV1: build it with `--features av1`, or let the output \
             end in .mp4, .webp, .apng, .gif or .y4m",
        )
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Edits between two words: letters added, left out, replaced, or two neighbours swapped.
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_formats_and_back() {
        for name in Format::NAMES {
            let format = Format::from_name(name).unwrap();
            assert_eq!(Format::from_name(&name.to_uppercase()), Ok(format));
            assert!(Format::ALL.contains(&format));
        }
        for format in Format::ALL {
            assert_eq!(Format::from_name(format.name()), Ok(format));
        }
    }

    #[test]
    fn unknown_names_offer_the_nearest() {
        assert_eq!(Format::nearest("pgn"), Some("png"));
        assert_eq!(Format::nearest("pngg"), Some("png"));
        assert_eq!(Format::nearest("jpge"), Some("jpg"));
        assert_eq!(Format::nearest("giff"), Some("gif"));
        assert_eq!(Format::nearest("docx"), None);
        let text = Format::from_name("exrr").unwrap_err().to_string();
        assert_eq!(
            text,
            "unknown format \"exrr\", did you mean \"exr\"? (known: png, png16, exr, exr16, qoi, \
             jpg, jpeg, ppm, pfm, gif, apng, webp, y4m, mp4, mkv, ivf)"
        );
    }
}
