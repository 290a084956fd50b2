//! Words as a POSIX shell reads them back: for commands that are printed to be pasted, and for
//! those that are written into jobs.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A word, quoted if need be. What cannot be typed, control characters and bytes that are no UTF-8,
/// stands as octal numbers between `$'` and `'` (POSIX.1-2024, section 2.2.4).
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref();
    // Some shells expand a first `=` to a command's path.
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,%@+".contains(c);
    match word.to_str() {
        Some(text) if !text.is_empty() && !text.starts_with('=') && text.chars().all(plain) => {
            text.into()
        }
        Some(text) if !text.contains(char::is_control) => {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
        _ => {
            let mut quoted = String::from("$'");
            for byte in word.as_encoded_bytes() {
                match byte {
                    b'\'' | b'\\' => _ = write!(quoted, "\\{}", char::from(*byte)),
                    b' '..=b'~' => quoted.push(char::from(*byte)),
                    _ => _ = write!(quoted, "\\{byte:03o}"),
                }
            }
            quoted + "'"
        }
    }
}

/// Words as one command.
pub fn line(words: &[impl AsRef<OsStr>]) -> String {
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// A path that no program takes for an option; `-`, the standard streams, stays.
pub fn operand(path: &Path) -> PathBuf {
    let option = path.as_os_str().as_encoded_bytes().first() == Some(&b'-');
    if option && path != Path::new("-") { Path::new(".").join(path) } else { path.to_path_buf() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        assert_eq!(quoted("out/frame-%04d.png"), "out/frame-%04d.png");
        assert_eq!(quoted("out/frame-####.png"), "'out/frame-####.png'");
        assert_eq!(quoted("it's $HOME"), "'it'\\''s $HOME'");
        assert_eq!(quoted("=ls"), "'=ls'");
        assert_eq!(quoted("ä{a,b}"), "'ä{a,b}'");
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("a\nb'\\\u{1b}ä"), "$'a\\012b\\'\\\\\\033\\303\\244'");
        assert_eq!(line(&["a b", "c"]), "'a b' c");
    }

    #[test]
    fn operands_are_no_options() {
        assert_eq!(operand(Path::new("-x.rhai")), Path::new("./-x.rhai"));
        assert_eq!(operand(Path::new("-")), Path::new("-"));
        assert_eq!(operand(Path::new("a/-x.rhai")), Path::new("a/-x.rhai"));
    }
}
