//! Files that say what they are and whether they are whole.
//!
//! A sealed file carries its texts and, last of them, [`CHECK`]: the BLAKE3 hash of all of its
//! bytes but the check itself. PNG carries them as text chunks, EXR as string attributes, JPEG and
//! PPM as a comment of `key: value` lines. QOI and PFM have no place for text; there the same lines
//! stand in a file beside the picture, whose name is the picture's with [`MANIFEST_ENDING`] added.
//! Films carry theirs at their end.

use crate::bands::KeptBands;
use crate::film::closing;
use crate::format::Format;
use crate::picture::Picture;
use crate::still::{Encoded, StillOptions, encode_still};
use crate::{exr, png};
use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The key of the hash of a file's other bytes.
pub const CHECK: &str = "reflet-check";

/// What is added to a picture's name for the file that stands beside it.
pub const MANIFEST_ENDING: &str = ".reflet";

/// The bytes by which formats are told apart: of a PNG with all chunks that stand before the control
/// chunk of an animation.
const HEAD: u64 = 256;

/// The digits of a hash.
const DIGITS: usize = 64;

/// A picture's file, and what stands beside it if the format holds no text.
#[derive(Clone, Debug)]
pub struct Sealed {
    /// The file.
    pub encoded: Encoded,
    /// The lines of its manifest, for formats without text.
    pub manifest: Option<String>,
}

/// Why a file's texts are not to be had.
#[derive(Debug)]
pub enum Unsealed {
    /// There is no file.
    Missing,
    /// It carries no texts of ours: another program made it, or it was made without them.
    Bare,
    /// It is not as it was written; in which way.
    Damaged(String),
    /// It cannot be read.
    Unreadable(io::Error),
}

impl fmt::Display for Unsealed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("missing"),
            Self::Bare => f.write_str("it does not say what it was made from"),
            Self::Damaged(how) => write!(f, "damaged: {how}"),
            Self::Unreadable(error) => write!(f, "cannot be read: {error}"),
        }
    }
}

impl std::error::Error for Unsealed {}

/// The name of the file beside `picture`.
pub fn manifest_path(picture: &Path) -> PathBuf {
    let mut name = OsString::from(picture);
    name.push(MANIFEST_ENDING);
    name.into()
}

/// Whether a file stands at the place of a manifest that is none of ours, not even a damaged one.
pub fn is_foreign_manifest(path: &Path) -> bool {
    match fs::metadata(path) {
        Ok(about) if about.is_file() => {}
        // A link that leads nowhere counts, too.
        Ok(_) => return true,
        Err(_) => return fs::symlink_metadata(path).is_ok(),
    }
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(4096).read_to_end(&mut head));
    let ours = head.split(|byte| *byte == b'\n').any(|line| line.starts_with(b"reflet-"));
    read.is_err() || !(ours || head.is_empty())
}

/// True for formats whose texts stand beside the picture.
pub fn needs_manifest(format: Format) -> bool {
    matches!(format, Format::Qoi | Format::Pfm) || closing::needs_manifest(format)
}

/// As [`encode_still`], and seals the file with its `options.text`.
///
/// # Errors
/// Those of [`encode_still`].
pub fn encode_sealed(
    picture: &Picture,
    format: Format,
    options: &StillOptions<'_>,
    kept: Option<&mut KeptBands>,
) -> io::Result<Sealed> {
    let blank = "0".repeat(DIGITS);
    let mut text = options.text.to_vec();
    if matches!(format, Format::Exr | Format::Exr16) {
        text.push((CHECK, &blank));
    }
    let options = StillOptions { text: &text, ..options.clone() };
    let mut encoded = encode_still(picture, format, &options, kept)?;
    let lines = || -> String {
        options.text.iter().map(|(key, value)| format!("{key}: {value}\n")).collect()
    };
    let mut manifest = None;
    match format {
        Format::Png | Format::Png16 => {
            let check = hash(&encoded, 0..0);
            // Text chunks are ours to add at the head's end.
            png::text_chunks(head(&mut encoded), &[(CHECK, &check)]);
        }
        Format::Jpeg | Format::Ppm => {
            let lines = format!("{}{CHECK}: {blank}\n", lines());
            let bytes = head(&mut encoded);
            match format {
                Format::Jpeg => insert_comment(bytes, &lines)?,
                _ => insert_remarks(bytes, &lines),
            }
            fill_in(&mut encoded);
        }
        Format::Exr | Format::Exr16 => fill_in(&mut encoded),
        _ => manifest = Some(format!("{}{CHECK}: {}\n", lines(), hash(&encoded, 0..0))),
    }
    Ok(Sealed { encoded, manifest })
}

fn head(encoded: &mut Encoded) -> &mut Vec<u8> {
    Arc::make_mut(&mut encoded.parts[0])
}

/// Puts the hash in the place that the head has for it.
fn fill_in(encoded: &mut Encoded) {
    let field = check_field(&encoded.parts[0]);
    if let Some(field) = field {
        let check = hash(encoded, field.clone());
        head(encoded)[field].copy_from_slice(check.as_bytes());
    }
}

/// The hash of all bytes but those of the head at `without`.
fn hash(encoded: &Encoded, without: Range<usize>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (index, part) in encoded.parts.iter().enumerate() {
        if index == 0 {
            hasher.update(&part[..without.start]);
            hasher.update(&part[without.end..]);
        } else {
            hasher.update(part);
        }
    }
    hasher.finalize().to_string()
}

/// Where an EXR's, a JPEG's or a PPM's head holds the digits of its check.
fn check_field(head: &[u8]) -> Option<Range<usize>> {
    let exr = [CHECK.as_bytes(), b"\0string\0", &(DIGITS as u32).to_le_bytes()].concat();
    let line = format!("{CHECK}: ").into_bytes();
    let near = &head[..head.len().min(1 << 16)];
    let find = |what: &[u8]| Some(near.windows(what.len()).position(|w| w == what)? + what.len());
    let start = find(&exr).or_else(|| find(&line))?;
    (start + DIGITS <= head.len()).then_some(start..start + DIGITS)
}

/// A COM segment after the JFIF header, which must come first (ITU-T T.871).
fn insert_comment(jpeg: &mut Vec<u8>, lines: &str) -> io::Result<()> {
    let length = lines.len() + 2;
    let length = u16::try_from(length)
        .map_err(|_| io::Error::new(ErrorKind::InvalidInput, "a JPEG's comment is too long"))?;
    let mut at = 2;
    if jpeg.get(2..4) == Some(&[0xff, 0xe0]) {
        at += 2 + usize::from(u16::from_be_bytes([jpeg[4], jpeg[5]]));
    }
    let mut segment = vec![0xff, 0xfe];
    segment.extend_from_slice(&length.to_be_bytes());
    segment.extend_from_slice(lines.as_bytes());
    jpeg.splice(at..at, segment);
    Ok(())
}

/// Lines that begin with # after the magic number of a PPM.
fn insert_remarks(ppm: &mut Vec<u8>, lines: &str) {
    let remarks: String = lines.lines().map(|line| format!("# {line}\n")).collect();
    ppm.splice(3..3, remarks.into_bytes());
}

/// The texts of the sealed file at `path`, in their order and without the check, if the file is
/// whole. A film is read in pieces.
///
/// # Errors
/// [`Unsealed`].
pub fn read_sealed(path: &Path) -> Result<Vec<(String, String)>, Unsealed> {
    let mut file = open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut head).map_err(Unsealed::Unreadable)?;
    if let Some(film) = closing::carried(&head) {
        return closing::read(file, film);
    }
    let beside = [&b"qoif"[..], b"PF\n", b"YUV4MPEG2 ", b"DKIF"];
    if beside.iter().any(|magic| head.starts_with(magic)) {
        let lines = match open(&manifest_path(path)).and_then(whole) {
            Err(Unsealed::Missing) => return Err(Unsealed::Bare),
            lines => String::from_utf8(lines?).map_err(|_| damaged("its manifest is no text"))?,
        };
        return match closing::first_line(&lines) {
            Some(format) => closing::beside(file, format, &lines),
            None => {
                let length = file.metadata().map_err(Unsealed::Unreadable)?.len();
                let hasher = closing::hash(&mut file, length, Format::Qoi);
                checked(pairs(lines.lines())?, &hasher.map_err(Unsealed::Unreadable)?)
            }
        };
    }
    let mut bytes = head;
    file.read_to_end(&mut bytes).map_err(Unsealed::Unreadable)?;
    texts(&bytes)
}

/// The texts of a sealed file that carries them itself, given as its bytes.
///
/// # Errors
/// [`Unsealed`], though never that it is missing.
pub fn texts(bytes: &[u8]) -> Result<Vec<(String, String)>, Unsealed> {
    if bytes.starts_with(&png::SIGNATURE) {
        let (pairs, check) = png::read_texts(bytes).map_err(Unsealed::Damaged)?;
        return checked(pairs, &hash_without(bytes, check));
    }
    let (pairs, missing) = if bytes.starts_with(&exr::MAGIC) {
        let header = exr::read_header(bytes).map_err(Unsealed::Damaged)?;
        (header.texts, "its attribute for the check")
    } else if bytes.starts_with(&[0xff, 0xd8]) {
        let text = jpeg_comment(bytes).ok_or(Unsealed::Bare)?;
        (pairs(text.lines())?, "its line for the check")
    } else if bytes.starts_with(b"P6\n") {
        let end = bytes.windows(2).position(|w| w[0] == b'\n' && w[1] != b'#');
        let text = std::str::from_utf8(&bytes[3..end.map_or(3, |end| end.max(2) + 1)])
            .map_err(|_| damaged("its remarks are no text"))?;
        (pairs(text.lines().filter_map(|line| line.strip_prefix("# ")))?, "its line for the check")
    } else if bytes.is_empty() {
        return Err(damaged("it is empty"));
    } else {
        return Err(Unsealed::Bare);
    };
    if pairs.iter().all(|(key, _)| key != CHECK) {
        return Err(Unsealed::Bare);
    }
    let field = check_field(bytes).ok_or_else(|| damaged(&format!("{missing} is broken")))?;
    checked(pairs, &hash_without(bytes, field))
}

fn open(path: &Path) -> Result<File, Unsealed> {
    let unreadable = |error: io::Error| match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => Unsealed::Missing,
        _ => Unsealed::Unreadable(error),
    };
    let about = fs::metadata(path).map_err(unreadable)?;
    if !about.is_file() {
        // A device could be read without end.
        return Err(Unsealed::Bare);
    }
    File::open(path).map_err(unreadable)
}

fn whole(mut file: File) -> Result<Vec<u8>, Unsealed> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(Unsealed::Unreadable)?;
    Ok(bytes)
}

/// A hasher that has seen `bytes` but for those at `without`.
fn hash_without(bytes: &[u8], without: Range<usize>) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..without.start]).update(&bytes[without.end..]);
    hasher
}

fn damaged(how: &str) -> Unsealed {
    Unsealed::Damaged(how.to_owned())
}

fn pairs<'a>(lines: impl Iterator<Item = &'a str>) -> Result<Vec<(String, String)>, Unsealed> {
    lines
        .map(|line| {
            let pair = line.split_once(": ").map(|(key, value)| (key.to_owned(), value.to_owned()));
            pair.ok_or_else(|| damaged("its text is broken"))
        })
        .collect()
}

/// The pairs without the check, if that is the hash of what `hasher` has seen.
fn checked(
    mut pairs: Vec<(String, String)>,
    hasher: &blake3::Hasher,
) -> Result<Vec<(String, String)>, Unsealed> {
    let Some(at) = pairs.iter().position(|(key, _)| key == CHECK) else {
        return Err(Unsealed::Bare);
    };
    let (_, check) = pairs.remove(at);
    if hasher.finalize().to_string() != check {
        return Err(damaged("its bytes are not those that were written"));
    }
    Ok(pairs)
}

/// The text of the first comment before the picture.
fn jpeg_comment(bytes: &[u8]) -> Option<&str> {
    let mut at = 2;
    loop {
        let [0xff, kind, high, low] = *bytes.get(at..at + 4)? else { return None };
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        if kind == 0xfe {
            return std::str::from_utf8(bytes.get(at + 4..end)?).ok();
        }
        if kind == 0xda {
            return None;
        }
        at = end;
    }
}
