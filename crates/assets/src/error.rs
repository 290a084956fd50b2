//! What is wrong with a file.

use std::path::{Path, PathBuf};

/// The kinds of wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// There is no such file, or it may not be read.
    Missing,
    /// The path leads out of the script's folder, or to what is no regular file.
    Forbidden,
    /// The file is there and its contents are wrong.
    Broken,
}

/// What is wrong inside of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The line, counted from 1, in a text; `None` if the whole file is at fault.
    pub line: Option<u64>,
    /// The byte, counted from 0, in a file that is no text.
    pub byte: Option<u64>,
    /// What is wrong and what to do.
    pub message: String,
}

impl Fault {
    /// Of the whole file.
    pub(crate) fn file(message: impl Into<String>) -> Self {
        Self { line: None, byte: None, message: message.into() }
    }

    /// In a line, counted from 1.
    pub(crate) fn line(line: u64, message: impl Into<String>) -> Self {
        Self { line: Some(line), byte: None, message: message.into() }
    }

    /// At a byte, counted from 0.
    pub(crate) fn byte(byte: usize, message: impl Into<String>) -> Self {
        Self { line: None, byte: Some(byte as u64), message: message.into() }
    }
}

/// A file that cannot serve: which, where in it, what is wrong and what to do, on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssetError {
    path: PathBuf,
    line: Option<u64>,
    byte: Option<u64>,
    cause: Cause,
    message: String,
}

impl AssetError {
    pub(crate) fn missing(path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            line: None,
            byte: None,
            cause: Cause::Missing,
            message: message.into(),
        }
    }

    pub(crate) fn forbidden(path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            line: None,
            byte: None,
            cause: Cause::Forbidden,
            message: message.into(),
        }
    }

    pub(crate) fn broken(path: &Path, fault: Fault) -> Self {
        let Fault { line, byte, message } = fault;
        Self { path: path.into(), line, byte, cause: Cause::Broken, message }
    }

    /// The same, with more to say.
    pub(crate) fn and(mut self, more: &str) -> Self {
        self.message += more;
        self
    }

    /// What is wrong, without the place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What kind of wrong it is.
    pub fn cause(&self) -> Cause {
        self.cause
    }

    /// The file, with the folder in front as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The line in the file, counted from 1, where there is one to blame.
    pub fn line(&self) -> Option<u64> {
        self.line
    }

    /// The byte in the file, counted from 0, where there is one to blame.
    pub fn byte(&self) -> Option<u64> {
        self.byte
    }
}

impl std::fmt::Display for AssetError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // A name with a line break in it must not break the message into two.
        let path = self.path.to_string_lossy().replace(|c: char| c.is_control(), "\u{fffd}");
        match (self.line, self.byte) {
            (Some(line), _) => write!(f, "{path}:{line}: {}", self.message),
            (None, Some(byte)) => write!(f, "{path}: byte {byte}: {}", self.message),
            (None, None) => write!(f, "{path}: {}", self.message),
        }
    }
}

impl std::error::Error for AssetError {}
