//! The end of a film, which says what it was made from and whether the film is whole.
//!
//! A film is hashed as it is written, so its texts come last, as lines of `key: value`: in GIF as
//! comments, in APNG as a text chunk, in WebP as a chunk of its own, in MP4 as a `uuid` box, in
//! Matroska as a tag. The last line is [`CHECK`], the BLAKE3 hash of all that comes before the texts
//! and of the lines before it. YUV4MPEG2 and IVF have no place at their end; there the same lines
//! stand in a file beside the film, as for stills.
//!
//! A reader parses the lines, builds the end anew from them and compares, so that no byte goes
//! unchecked.

use crate::format::Format;
use crate::png;
use crate::safe::SafeFile;
use crate::seal::{CHECK, Unsealed};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

/// The first line of a film's texts, and the key in it.
const FIRST: &str = "reflet-film: ";

/// No end is longer.
const LONGEST: u64 = 4096;

/// Of the `uuid` box. Drawn once.
const BOX: [u8; 16] = [
    0x5b, 0x1e, 0x0f, 0x3a, 0x92, 0x6c, 0x4d, 0x47, 0xa1, 0x0d, 0x3c, 0x58, 0xe7, 0x24, 0x90, 0x6b,
];

/// True for films whose texts stand beside them.
pub(crate) fn needs_manifest(format: Format) -> bool {
    matches!(format, Format::Y4m | Format::Ivf)
}

/// What ends a film that says nothing.
pub(super) fn bare(format: Format) -> Vec<u8> {
    let mut end = Vec::new();
    match format {
        Format::Gif => end.push(0x3b),
        Format::Apng => png::chunk(&mut end, b"IEND", &[]),
        _ => {}
    }
    end
}

/// The lines of a film's texts; `hasher` has seen all bytes before them.
pub(super) fn lines(format: Format, texts: &[(&str, &str)], mut hasher: blake3::Hasher) -> String {
    let first = [(FIRST.trim_end_matches(": "), format.name())];
    let all = first.iter().chain(texts);
    let lines: String = all.map(|(key, value)| format!("{key}: {value}\n")).collect();
    hasher.update(lines.as_bytes());
    format!("{lines}{CHECK}: {}\n", hasher.finalize())
}

/// What ends a film with these lines.
///
/// # Errors
/// They are too long.
pub(super) fn sealed(format: Format, lines: &str) -> io::Result<Vec<u8>> {
    let mut end = Vec::new();
    let data = lines.as_bytes();
    match format {
        Format::Gif => {
            for line in lines.split_inclusive('\n') {
                let length = u8::try_from(line.len()).map_err(|_| too_long())?;
                end.extend_from_slice(&[0x21, 0xfe, length]);
                end.extend_from_slice(line.as_bytes());
                end.push(0);
            }
        }
        Format::Apng => png::chunk(&mut end, b"tEXt", &[b"Comment\0", data]),
        Format::Webp => super::webp::chunk(&mut end, b"rflt", data),
        Format::Mp4 => {
            end.extend_from_slice(&(data.len() as u32 + 24).to_be_bytes());
            end.extend_from_slice(b"uuid");
            end.extend_from_slice(&BOX);
            end.extend_from_slice(data);
        }
        Format::Mkv => {
            let name = element(&[0x45, 0xa3], b"COMMENT");
            let simple = element(&[0x67, 0xc8], &[name, element(&[0x44, 0x87], data)].concat());
            // No targets: the tag is of the whole file.
            let tag = element(&[0x73, 0x73], &[element(&[0x63, 0xc0], &[]), simple].concat());
            end = element(&[0x12, 0x54, 0xc3, 0x67], &tag);
        }
        _ => {}
    }
    end.extend(bare(format));
    if end.len() as u64 > LONGEST { Err(too_long()) } else { Ok(end) }
}

/// Adds the end to a film that another program has written, and that `written` reads.
pub(crate) fn append(
    file: &mut SafeFile,
    written: &mut File,
    format: Format,
    texts: &[(&str, &str)],
) -> io::Result<()> {
    let length = written.metadata()?.len();
    if format == Format::Mkv {
        // The tag is a part of the segment, whose size therefore grows.
        let mut head = Vec::new();
        written.take(256).read_to_end(&mut head)?;
        let fit = |(at, size): &(u64, u64)| at + 8 + size == length;
        let Some((at, size)) = segment(&head).filter(fit) else {
            return Err(io::Error::other("ffmpeg has written a Matroska file of another kind"));
        };
        let end = sealed(format, &lines(format, texts, blake3::Hasher::new()))?;
        let size = (size + end.len() as u64) | 1 << 56;
        file.overwrite(at, &size.to_be_bytes())?;
    }
    let lines = lines(format, texts, hash(written, length, format)?);
    file.overwrite(length, &sealed(format, &lines)?)
}

fn too_long() -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, "a film's texts are too long")
}

/// An element of Matroska (RFC 8794), its size in four bytes.
fn element(id: &[u8], data: &[u8]) -> Vec<u8> {
    let size = (data.len() as u32 | 1 << 28).to_be_bytes();
    [id, &size, data].concat()
}

/// Where a Matroska file's head holds the size of its one segment, and the size: eight bytes, as
/// ffmpeg writes it. `None` if it is made otherwise.
fn segment(head: &[u8]) -> Option<(u64, u64)> {
    // The EBML header's own size takes one byte.
    let header = usize::from(*head.strip_prefix(&[0x1a, 0x45, 0xdf, 0xa3])?.first()?);
    let at = match header & 0x80 {
        0 => 12 + usize::from(*head.get(11)?), // of eight bytes
        _ => 5 + (header & 0x7f),
    };
    let rest = head.get(at..)?.strip_prefix(&[0x18, 0x53, 0x80, 0x67])?;
    let size = u64::from_be_bytes(rest.get(..8)?.try_into().ok()?);
    (size >> 56 == 1).then_some((at as u64 + 4, size & ((1 << 56) - 1)))
}

/// The film that begins with `head` and carries its texts itself.
pub(crate) fn carried(head: &[u8]) -> Option<Format> {
    if head.starts_with(b"GIF89a") {
        Some(Format::Gif)
    } else if png::is_animated(head) {
        Some(Format::Apng)
    } else if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WEBP") {
        Some(Format::Webp)
    } else if head.get(4..8) == Some(b"ftyp") {
        Some(Format::Mp4)
    } else if head.starts_with(&[0x1a, 0x45, 0xdf, 0xa3]) {
        Some(Format::Mkv)
    } else {
        None
    }
}

/// The texts of a film, without the check, if the film is whole. It is read in pieces.
pub(crate) fn read(mut file: File, format: Format) -> Result<Vec<(String, String)>, Unsealed> {
    let damaged = |how: &str| Unsealed::Damaged(how.to_owned());
    let failed = Unsealed::Unreadable;
    let length = file.metadata().map_err(failed)?.len();
    let kept = length.min(LONGEST);
    file.seek(SeekFrom::Start(length - kept)).map_err(failed)?;
    let mut tail = vec![0; kept as usize];
    file.read_exact(&mut tail).map_err(failed)?;
    let first = FIRST.as_bytes();
    let start = tail.windows(first.len()).rposition(|w| w == first).ok_or(Unsealed::Bare)?;
    let mut pairs = pairs(&tail[start..], format).ok_or_else(|| damaged("its end is broken"))?;
    let told: String = pairs.iter().map(|(key, value)| format!("{key}: {value}\n")).collect();
    let end = sealed(format, &told).map_err(|_| damaged("its end is broken"))?;
    let texts: Vec<(&str, &str)> =
        pairs.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
    let [_, texts @ .., _] = &texts[..] else { return Err(damaged("its end is broken")) };
    if !tail.ends_with(&end) {
        return Err(damaged("its end is broken"));
    }
    let hasher = hash(&mut file, length - end.len() as u64, format).map_err(failed)?;
    let stated = format != Format::Webp || {
        let mut head = [0; 8];
        file.rewind().and_then(|()| file.read_exact(&mut head)).map_err(failed)?;
        u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]])) + 8 == length
    };
    if !stated || lines(format, texts, hasher) != told {
        return Err(damaged("its bytes are not those that were written"));
    }
    pairs.pop();
    pairs.remove(0);
    Ok(pairs)
}

/// The film whose manifest begins with this line; `None` if it is a still's.
pub(crate) fn first_line(manifest: &str) -> Option<Format> {
    Format::from_name(manifest.lines().next()?.strip_prefix(FIRST)?).ok()
}

/// The texts of a film beside which `manifest` stands, without the check, if both are whole.
pub(crate) fn beside(
    mut file: File,
    format: Format,
    manifest: &str,
) -> Result<Vec<(String, String)>, Unsealed> {
    let broken = || Unsealed::Damaged("its manifest is broken".to_owned());
    let mut pairs = pairs(manifest.as_bytes(), format).ok_or_else(broken)?;
    let texts: Vec<(&str, &str)> =
        pairs.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
    let [_, texts @ .., _] = &texts[..] else { return Err(broken()) };
    let length = file.metadata().map_err(Unsealed::Unreadable)?.len();
    let hasher = hash(&mut file, length, format).map_err(Unsealed::Unreadable)?;
    if lines(format, texts, hasher) != manifest {
        return Err(Unsealed::Damaged("its bytes are not those that were written".to_owned()));
    }
    pairs.pop();
    pairs.remove(0);
    Ok(pairs)
}

/// A hasher that has seen the first `length` bytes, as they were when they were written: of a WebP,
/// the length in its head was not known then.
pub(crate) fn hash(file: &mut File, length: u64, format: Format) -> io::Result<blake3::Hasher> {
    file.rewind()?;
    let mut hasher = blake3::Hasher::new();
    let mut piece = vec![0; 1 << 18];
    let mut done = 0;
    while done < length {
        let most = piece.len().min((length - done) as usize);
        let read = file.read(&mut piece[..most])?;
        if read == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        if format == Format::Webp {
            for at in (done..8).filter(|at| (4..8).contains(at)) {
                piece[(at - done) as usize] = 0;
            }
        }
        hasher.update(&piece[..read]);
        done += read as u64;
    }
    Ok(hasher)
}

/// The lines that begin at `text`, up to that of the check.
fn pairs(text: &[u8], format: Format) -> Option<Vec<(String, String)>> {
    let mut rest = text;
    let mut pairs = Vec::new();
    loop {
        let end = rest.iter().position(|byte| *byte == b'\n')?;
        let (key, value) = std::str::from_utf8(&rest[..end]).ok()?.split_once(": ")?;
        pairs.push((key.to_owned(), value.to_owned()));
        if key == CHECK {
            return Some(pairs);
        }
        // Between two lines of a GIF stand the end of one comment and the beginning of the next.
        let between = if format == Format::Gif { 4 } else { 0 };
        rest = rest.get(end + 1 + between..)?;
    }
}
