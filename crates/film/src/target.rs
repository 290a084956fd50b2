//! What `-o OUT` means: the format, and the name of each frame's file.

use crate::format::{Format, UnknownFormat};
use crate::safe::{Folders, SafeFile};
use crate::slots::{MOST_DIGITS, SlotError, slots};
use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Where the frames of a render go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    format: Format,
    place: Place,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Place {
    Stdout,
    /// One file: a still, a film, or a device that takes frame after frame.
    One(PathBuf),
    /// A file per frame: the number stands between `before` and `after`, zero-padded.
    Numbered {
        folder: PathBuf,
        before: String,
        after: String,
        digits: usize,
    },
}

/// Why `-o OUT` cannot be followed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TargetError {
    /// `OUT` is empty.
    Empty,
    /// The last component names a folder (`out/`, `..`).
    NoFileName {
        /// The path as given.
        out: PathBuf,
    },
    /// The file name is not UTF-8.
    NotUtf8 {
        /// The path as given.
        out: PathBuf,
    },
    /// The file name has no ending to tell the format by, and no format was named.
    NoEnding {
        /// The path as given.
        out: PathBuf,
    },
    /// The ending, or the format named instead, is not known.
    UnknownFormat {
        /// The path as given.
        out: PathBuf,
        /// The name and what is known.
        unknown: UnknownFormat,
    },
    /// This program was built without the format.
    Unbuilt {
        /// The path as given.
        out: PathBuf,
        /// What to do.
        why: &'static str,
    },
    /// More than one place for the frame number.
    TwoNumbers {
        /// The path as given.
        out: PathBuf,
    },
    /// Something that is almost a frame number, such as `%4d`.
    AlmostNumber {
        /// The path as given.
        out: PathBuf,
        /// What is almost one.
        almost: String,
    },
    /// A frame number with too many digits.
    TooManyDigits {
        /// The path as given.
        out: PathBuf,
    },
    /// The frame number stands in the name of a folder that is not there.
    NumberInFolder {
        /// The path as given.
        out: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// A frame number in the name of a film, which holds all frames.
    NumberInFilm {
        /// The path as given.
        out: PathBuf,
        /// The film's format.
        format: Format,
    },
}

impl fmt::Display for TargetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the output has no name: write for example -o picture.png"),
            Self::NoFileName { out } => write!(
                f,
                "the output {} names a folder: write for example -o {}",
                out.display(),
                out.join("frame-####.png").display()
            ),
            Self::NotUtf8 { out } => {
                write!(f, "the output's file name {} is not UTF-8", out.display())
            }
            Self::NoEnding { out } => write!(
                f,
                "the output {} has no ending to tell its format by: add one, or --format with one \
                 of {}",
                out.display(),
                Format::NAMES.join(", ")
            ),
            Self::UnknownFormat { out, unknown } => {
                write!(f, "the output {}: {unknown}", out.display())
            }
            Self::Unbuilt { out, why } => write!(f, "the output {}: {why}", out.display()),
            Self::TwoNumbers { out } => write!(
                f,
                "the output {} has two places for the frame number: keep one run of # or one %04d",
                out.display()
            ),
            Self::AlmostNumber { out, almost } => write!(
                f,
                "the output {}: `{almost}` is no frame number; write %04d or ####. A % that is only \
                 a part of the name stands before no letter, digit, % or #",
                out.display()
            ),
            Self::TooManyDigits { out } => write!(
                f,
                "the output {} asks for a frame number of more than {MOST_DIGITS} digits; write \
                 #### or %04d",
                out.display()
            ),
            Self::NumberInFolder { out, folder } => write!(
                f,
                "the output {} has a frame number in the name of a folder; only the last part takes \
                 one, as in frame-%04d.png. If the folder is called {}, make it first",
                out.display(),
                folder.display()
            ),
            Self::NumberInFilm { out, format } => write!(
                f,
                "the output {} has a frame number, but {format} holds all frames in one file: \
                 leave the number out",
                out.display()
            ),
        }
    }
}

impl std::error::Error for TargetError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::UnknownFormat { unknown, .. } => Some(unknown),
            _ => None,
        }
    }
}

/// The first folder of `out` that looks as if it held the frame number and is not there.
fn numbered_folder(out: &Path) -> Option<&Path> {
    let folders: Vec<&Path> = out.ancestors().skip(1).collect();
    folders.into_iter().rev().find(|folder| {
        let name = folder.file_name().and_then(OsStr::to_str);
        let numbered = name.is_some_and(|name| slots(name).map_or(true, |s| !s.is_empty()));
        numbered && !folder.is_dir()
    })
}

/// True if `path` exists and takes bytes as they come, like `/dev/full` or a pipe.
fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

impl Target {
    /// The target named by `out` in the animation of `frames` frames (1 for a still), whatever
    /// part of it is rendered.
    ///
    /// The format follows from `format`, or else from the ending. A run of `#` in the last
    /// component, or `%04d`, or `%d`, is the frame number; an animation of more than one frame
    /// without either gets `-####` before the ending, unless `out` exists and is a device or a
    /// pipe, where frame follows frame. Films hold all frames. `-` is the standard output: PPM for
    /// a still, Y4M for an animation, unless `format` says otherwise; stills of several frames
    /// follow one another there.
    pub fn parse(out: &OsStr, format: Option<&str>, frames: u32) -> Result<Self, TargetError> {
        let path = Path::new(out);
        let unknown = |unknown| TargetError::UnknownFormat { out: path.to_owned(), unknown };
        let named = format
            .map(|name| Format::from_name(name.strip_prefix('.').unwrap_or(name)))
            .transpose()
            .map_err(unknown)?;
        let built = |format: Format| match format.unbuilt() {
            Some(why) => Err(TargetError::Unbuilt { out: path.to_owned(), why }),
            None => Ok(format),
        };
        if out.is_empty() {
            return Err(TargetError::Empty);
        }
        if out == "-" {
            let usual = if frames > 1 { Format::Y4m } else { Format::Ppm };
            return Ok(Self { format: built(named.unwrap_or(usual))?, place: Place::Stdout });
        }
        let no_name = || TargetError::NoFileName { out: path.to_owned() };
        // `Path` overlooks a slash at the end.
        if out.as_encoded_bytes().last().is_some_and(|&b| b == b'/' || b == b'\\' && cfg!(windows))
        {
            return Err(no_name());
        }
        let name = path.file_name().ok_or_else(no_name)?;
        let name = name.to_str().ok_or_else(|| TargetError::NotUtf8 { out: path.to_owned() })?;
        let dot = name.rfind('.').filter(|&dot| dot + 1 < name.len());
        let format = match (named, dot) {
            (Some(format), _) => format,
            (None, Some(dot)) => Format::from_name(&name[dot + 1..]).map_err(unknown)?,
            (None, None) => {
                return Err(TargetError::NoEnding { out: path.to_owned() });
            }
        };
        let format = built(format)?;
        let slots = slots(name).map_err(|error| match error {
            SlotError::Almost(almost) => TargetError::AlmostNumber { out: path.to_owned(), almost },
            SlotError::TooManyDigits => TargetError::TooManyDigits { out: path.to_owned() },
        })?;
        if let (true, Some(folder)) = (slots.is_empty(), numbered_folder(path)) {
            let (out, folder) = (path.to_owned(), folder.to_owned());
            return Err(TargetError::NumberInFolder { out, folder });
        }
        let (before, after, digits) = match slots.as_slice() {
            [] if format.is_film() || frames <= 1 || is_device(path) => {
                return Ok(Self { format, place: Place::One(path.to_owned()) });
            }
            [] => {
                let end = dot.filter(|&dot| dot > 0).unwrap_or(name.len());
                (format!("{}-", &name[..end]), name[end..].to_owned(), 4)
            }
            [_] if format.is_film() => {
                return Err(TargetError::NumberInFilm { out: path.to_owned(), format });
            }
            [slot] => (name[..slot.start].to_owned(), name[slot.end..].to_owned(), slot.digits),
            _ => {
                return Err(TargetError::TwoNumbers { out: path.to_owned() });
            }
        };
        Ok(Self {
            format,
            place: Place::Numbered {
                folder: path.parent().unwrap_or(Path::new("")).to_owned(),
                before,
                after,
                digits,
            },
        })
    }

    /// The format of the files.
    pub fn format(&self) -> Format {
        self.format
    }

    /// True for the standard output.
    pub fn is_stdout(&self) -> bool {
        self.place == Place::Stdout
    }

    /// True if every frame has a file of its own.
    pub fn is_numbered(&self) -> bool {
        matches!(self.place, Place::Numbered { .. })
    }

    /// The file that holds frame `frame`: the same for every frame if the target is not numbered,
    /// and `-` for the standard output.
    pub fn path_for(&self, frame: u32) -> PathBuf {
        match &self.place {
            Place::Stdout => PathBuf::from("-"),
            Place::One(path) => path.clone(),
            Place::Numbered { folder, before, after, digits } => {
                folder.join(format!("{before}{frame:0digits$}{after}"))
            }
        }
    }

    /// The frames whose files are there, ascending; none if the target is not numbered.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub fn frames_on_disk(&self) -> io::Result<Vec<u32>> {
        let Place::Numbered { folder, before, after, digits } = &self.place else {
            return Ok(Vec::new());
        };
        let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let fail = |error: io::Error| {
            let message = format!("cannot list the folder {}: {error}", place.display());
            io::Error::new(error.kind(), message)
        };
        let mut frames = Vec::new();
        for entry in fs::read_dir(place).map_err(fail)? {
            let name = entry.map_err(fail)?.file_name();
            let number =
                name.to_str().and_then(|n| n.strip_prefix(&**before)?.strip_suffix(&**after));
            let frame = number.filter(|n| n.bytes().all(|b| b.is_ascii_digit()));
            // `7` is not what `007` was written as.
            let written = |frame: &u32| Some(format!("{frame:0digits$}").as_str()) == number;
            frames.extend(frame.and_then(|n| n.parse::<u32>().ok()).filter(written));
        }
        frames.sort_unstable();
        Ok(frames)
    }

    /// Opens the file that holds frame `frame`.
    pub fn open(&self, frame: u32) -> io::Result<SafeFile> {
        self.open_in(frame, Folders::Make)
    }

    /// As [`Target::open`], but missing folders are made only if `folders` says so.
    pub fn open_in(&self, frame: u32, folders: Folders) -> io::Result<SafeFile> {
        match self.place {
            Place::Stdout => Ok(SafeFile::stdout()),
            _ => SafeFile::create_in(&self.path_for(frame), folders),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(out: &str, format: Option<&str>, frames: u32) -> Result<Target, TargetError> {
        Target::parse(OsStr::new(out), format, frames)
    }

    #[test]
    fn names_of_frames() {
        let cases = [
            ("a.png", None, 1, Format::Png, "a.png"),
            ("a.png", None, 2, Format::Png, "a-0007.png"),
            ("out/a.b.exr", None, 120, Format::Exr, "out/a.b-0007.exr"),
            ("o##t/f-###.png", None, 120, Format::Png, "o##t/f-007.png"),
            ("f#.png", None, 1, Format::Png, "f7.png"),
            ("f%04d.png", None, 9, Format::Png, "f0007.png"),
            ("f%d.jpg", None, 9, Format::Jpeg, "f7.jpg"),
            ("f%0d.png", None, 9, Format::Png, "f7.png"),
            ("100%.png", None, 1, Format::Png, "100%.png"),
            ("50%-dark.png", None, 9, Format::Png, "50%-dark-0007.png"),
            ("10% or %02d.png", None, 9, Format::Png, "10% or 07.png"),
            ("f.####", Some("png"), 9, Format::Png, "f.0007"),
            ("a.png", Some("png16"), 1, Format::Png16, "a.png"),
            ("a", Some(".QOI"), 9, Format::Qoi, "a-0007"),
            (".png", Some("png"), 9, Format::Png, ".png-0007"),
            ("A.GIF", None, 9, Format::Gif, "A.GIF"),
            ("a.y4m", None, 1, Format::Y4m, "a.y4m"),
            ("-", None, 1, Format::Ppm, "-"),
            ("-", None, 9, Format::Y4m, "-"),
            ("-", Some("png"), 1, Format::Png, "-"),
            ("/tmp/x/%02d.pfm", None, 9, Format::Pfm, "/tmp/x/07.pfm"),
        ];
        for (out, format, frames, expected, path) in cases {
            let target = parse(out, format, frames).unwrap();
            assert_eq!(target.format(), expected, "{out}");
            assert_eq!(target.path_for(7), Path::new(path), "{out}");
        }
        assert_eq!(parse("f##.png", None, 9).unwrap().path_for(12345), Path::new("f12345.png"));
    }

    #[test]
    fn errors_say_what_to_do() {
        let cases = [
            ("", None, "the output has no name: write for example -o picture.png"),
            (
                "out/",
                None,
                "the output out/ names a folder: write for example -o out/frame-####.png",
            ),
            ("..", None, "the output .. names a folder: write for example -o ../frame-####.png"),
            (
                "a",
                None,
                "the output a has no ending to tell its format by: add one, or --format with one \
                 of png, png16, exr, exr16, qoi, jpg, jpeg, ppm, pfm, gif, apng, webp, y4m, mp4, mkv, ivf",
            ),
            (
                "a.pgn",
                None,
                "the output a.pgn: unknown format \"pgn\", did you mean \"png\"? (known: png, \
                 png16, exr, exr16, qoi, jpg, jpeg, ppm, pfm, gif, apng, webp, y4m, mp4, mkv, ivf)",
            ),
            (
                "a.png",
                Some("tiff"),
                "the output a.png: unknown format \"tiff\" (known: png, png16, exr, exr16, qoi, \
                 jpg, jpeg, ppm, pfm, gif, apng, webp, y4m, mp4, mkv, ivf)",
            ),
            (
                "#-%d.png",
                None,
                "the output #-%d.png has two places for the frame number: keep one run of # or \
                 one %04d",
            ),
            (
                "f%4d.png",
                None,
                "the output f%4d.png: `%4d` is no frame number; write %04d or ####. A % that is \
                 only a part of the name stands before no letter, digit, % or #",
            ),
            (
                "no-%04d/f.png",
                None,
                "the output no-%04d/f.png has a frame number in the name of a folder; only the last \
                 part takes one, as in frame-%04d.png. If the folder is called no-%04d, make it \
                 first",
            ),
            (
                "f-####.gif",
                None,
                "the output f-####.gif has a frame number, but gif holds all frames in one file: \
                 leave the number out",
            ),
        ];
        for (out, format, message) in cases {
            assert_eq!(parse(out, format, 9).unwrap_err().to_string(), message);
        }
    }

    #[test]
    fn what_is_almost_a_number_is_no_name() {
        for (name, almost) in [
            ("%x.png", "%x"),
            ("f-%i.png", "%i"),
            ("%5d.png", "%5d"),
            ("%s", "%s"),
            ("50%off.png", "%o"),
            ("a%%b.png", "%%"),
            ("%####.png", "%#"),
            ("##-%4d.png", "%4d"),
            ("%-4d.png", "%-4d"),
            ("%+d.png", "%+d"),
            ("% 4d.png", "% 4d"),
            ("%.4d.png", "%.4d"),
            ("%04i.png", "%04i"),
            ("%04dx%3d.png", "%3d"),
        ] {
            for frames in [1, 9] {
                match parse(name, Some("png"), frames) {
                    Err(TargetError::AlmostNumber { almost: found, .. }) => {
                        assert_eq!(found, almost, "{name}");
                    }
                    other => panic!("{name}: {other:?}"),
                }
            }
        }
        let long = "#".repeat(MOST_DIGITS + 1);
        for name in [&long, "%0101d", "%099999999999999999999d"] {
            let found = parse(name, Some("png"), 9);
            assert!(matches!(found, Err(TargetError::TooManyDigits { .. })), "{found:?}");
        }
    }

    #[test]
    fn folders_that_are_there_may_have_any_name() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("c%04d#");
        let out = folder.join("f.png");
        let parse = || Target::parse(out.as_os_str(), None, 9);
        assert!(matches!(parse(), Err(TargetError::NumberInFolder { .. })));
        fs::create_dir(&folder).unwrap();
        assert_eq!(parse().unwrap().path_for(7), folder.join("f-0007.png"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_take_no_number() {
        let target = parse("/dev/null", Some("png"), 9).unwrap();
        assert_eq!(target.path_for(3), Path::new("/dev/null"));
    }
}
