//! The text of a script: from bytes to what Rhai reads.

use crate::error::{ErrorKind, ScriptError};
use std::borrow::Cow;
use std::io::Read;
use std::path::PathBuf;

/// The text of a script.
#[derive(Clone, Debug)]
pub struct Source {
    /// Where it came from: for messages, and its folder is where its files are found.
    pub path: PathBuf,
    /// The script itself.
    pub text: String,
}

/// The longest script, in bytes.
const LONGEST: u64 = 16 << 20;
/// The most lines: Rhai counts them in 16 bits.
const LINES: usize = 65_535;
/// The byte-order mark that some editors write before UTF-8.
const MARK: char = '\u{feff}';

impl Source {
    /// What stands in the place of the path of a script that came through standard input.
    pub const STDIN: &str = "<stdin>";

    /// Reads a script's file.
    ///
    /// # Errors
    /// It is missing, no regular file, too long or not UTF-8: [`ErrorKind::Input`].
    pub fn read(path: impl Into<PathBuf>) -> Result<Source, ScriptError> {
        let path = path.into();
        let wrong = |message: String| Err(unreadable(&path, message));
        let cannot = |e: std::io::Error| unreadable(&path, format!("cannot read the script: {e}"));
        let about = std::fs::metadata(&path).map_err(cannot)?;
        if !about.is_file() {
            return wrong("cannot read the script: this is no regular file".into());
        }
        let file = std::fs::File::open(&path).map_err(cannot)?;
        Source::from_reader(path, file)
    }

    /// Reads a script from a stream, for example standard input; files that it names are found in
    /// the folder of `path`.
    ///
    /// # Errors
    /// The stream breaks off, is too long or not UTF-8: [`ErrorKind::Input`].
    pub fn from_reader(path: impl Into<PathBuf>, reader: impl Read) -> Result<Source, ScriptError> {
        let path = path.into();
        let mut bytes = Vec::new();
        reader
            .take(LONGEST + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| unreadable(&path, format!("cannot read the script: {e}")))?;
        if bytes.len() as u64 > LONGEST {
            return Err(unreadable(&path, format!("the script is longer than {LONGEST} bytes")));
        }
        let text = decode(bytes).map_err(|message| unreadable(&path, message))?;
        Ok(Source { path, text })
    }
}

fn unreadable(path: &std::path::Path, message: String) -> ScriptError {
    ScriptError {
        kind: ErrorKind::Input,
        message,
        path: path.into(),
        place: None,
        notes: Vec::new(),
        frame: None,
    }
}

/// UTF-8, with a byte-order mark or without; every line ends in a line feed.
fn decode(bytes: Vec<u8>) -> Result<String, String> {
    let utf16 = match bytes.as_slice() {
        [0xff, 0xfe, ..] | [_, 0, _, 0, ..] => Some("UTF-16 (little-endian)"),
        [0xfe, 0xff, ..] | [0, _, 0, _, ..] => Some("UTF-16 (big-endian)"),
        _ => None,
    };
    if let Some(encoding) = utf16 {
        return Err(format!(
            "the script is {encoding} text: save it as UTF-8, or convert it: iconv -f UTF-16 -t UTF-8"
        ));
    }
    let line = |before: &[u8]| 1 + before.iter().filter(|b| **b == b'\n').count();
    let text = String::from_utf8(bytes).map_err(|e| {
        let bytes = e.as_bytes();
        let at = e.utf8_error().valid_up_to();
        format!(
            "the script is not UTF-8 text: line {} holds the byte 0x{:02x}; save it as UTF-8",
            line(&bytes[..at]),
            bytes[at]
        )
    })?;
    if let Some(at) = text.find('\0') {
        return Err(format!(
            "the script is no text: line {} holds a zero byte",
            line(&text.as_bytes()[..at])
        ));
    }
    let text = text.strip_prefix(MARK).map(str::to_owned).unwrap_or(text);
    // Old Macintosh editors end lines with a carriage return alone.
    let lone = |text: &str| text.replace("\r\n", "\n").contains('\r');
    Ok(if lone(&text) { text.replace("\r\n", "\n").replace('\r', "\n") } else { text })
}

/// What is wrong with a script that is too long, if it is.
pub(crate) fn too_long(text: &str) -> Option<String> {
    (text.len() as u64 > LONGEST || text.lines().count() > LINES).then(|| {
        format!("the script is longer than {LINES} lines or {LONGEST} bytes: write loops instead")
    })
}

/// The script as Rhai reads it, with every character in its place: a first line `#!...`, by which
/// Unix finds a program, is a comment.
pub(crate) fn for_rhai(text: &str) -> Cow<'_, str> {
    match text.strip_prefix("#!") {
        Some(rest) => Cow::Owned(format!("//{rest}")),
        None => Cow::Borrowed(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<String, String> {
        Source::from_reader("a.rhai", bytes).map(|s| s.text).map_err(|e| e.message)
    }

    #[test]
    fn marks_and_line_ends_of_other_systems_are_taken() {
        assert_eq!(read(b"\xef\xbb\xbflet a = 1;").unwrap(), "let a = 1;");
        assert_eq!(read(b"a\rb\rc").unwrap(), "a\nb\nc");
        assert_eq!(read(b"a\r\nb\n").unwrap(), "a\r\nb\n");
        assert_eq!(for_rhai("#!/usr/bin/env reflet\nx"), "///usr/bin/env reflet\nx");
        assert_eq!(for_rhai("x"), "x");
    }

    #[test]
    fn other_encodings_are_named() {
        let little: Vec<u8> = "\u{feff}let".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = "\u{feff}let".encode_utf16().flat_map(u16::to_be_bytes).collect();
        for (bytes, name) in [
            (&little[..], "little-endian"),
            (&little[2..], "little-endian"),
            (&big[..], "big-endian"),
            (&big[2..], "big-endian"),
        ] {
            let said = read(bytes).unwrap_err();
            assert!(said.contains(name) && said.contains("save it as UTF-8"), "{said}");
        }
        assert_eq!(
            read(b"a\n\xe9").unwrap_err(),
            "the script is not UTF-8 text: line 2 holds the byte 0xe9; save it as UTF-8"
        );
        assert_eq!(
            read(b"abc\n\nd\0e").unwrap_err(),
            "the script is no text: line 3 holds a zero byte"
        );
    }
}
