//! What is wrong with a file.

use crate::obj::ObjFault;
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

/// A file that cannot serve: which, where in it, what is wrong and what to do, on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssetError {
    path: PathBuf,
    line: Option<u64>,
    cause: Cause,
    message: String,
}

impl AssetError {
    pub(crate) fn missing(path: &Path, message: impl Into<String>) -> Self {
        Self { path: path.into(), line: None, cause: Cause::Missing, message: message.into() }
    }

    pub(crate) fn forbidden(path: &Path, message: impl Into<String>) -> Self {
        Self { path: path.into(), line: None, cause: Cause::Forbidden, message: message.into() }
    }

    pub(crate) fn broken(path: &Path, fault: ObjFault) -> Self {
        let ObjFault { line, message } = fault;
        Self { path: path.into(), line, cause: Cause::Broken, message }
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
}

impl std::fmt::Display for AssetError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // A name with a line break in it must not break the message into two.
        let path = self.path.to_string_lossy().replace(|c: char| c.is_control(), "\u{fffd}");
        match self.line {
            Some(line) => write!(f, "{path}:{line}: {}", self.message),
            None => write!(f, "{path}: {}", self.message),
        }
    }
}

impl std::error::Error for AssetError {}
