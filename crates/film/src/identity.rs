//! What tells a file from all others, whatever it is called: hard and symbolic links included.

use std::fs::{self, File, Metadata};
use std::io;
use std::path::Path;

/// The identity of a file or a folder, as long as it exists: device and inode. Where the system has
/// no such numbers, the path that all links are resolved in.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(Id);

#[cfg(unix)]
type Id = (u64, u64);
#[cfg(not(unix))]
type Id = std::path::PathBuf;

impl FileId {
    /// Of the file or folder at `path`; the end of a chain of symbolic links.
    ///
    /// # Errors
    /// There is none, or it cannot be reached.
    pub fn of(path: &Path) -> io::Result<Self> {
        Self::known(path, &fs::metadata(path)?)
    }

    /// Of what stands at `path` itself, which may be a symbolic link.
    pub(crate) fn of_name(path: &Path) -> io::Result<Self> {
        Self::known(path, &fs::symlink_metadata(path)?)
    }

    /// Of an open file that was made at `path`.
    pub(crate) fn of_open(file: &File, path: &Path) -> io::Result<Self> {
        Self::known(path, &file.metadata()?)
    }

    #[cfg(unix)]
    fn known(_: &Path, about: &Metadata) -> io::Result<Self> {
        use std::os::unix::fs::MetadataExt;
        Ok(Self((about.dev(), about.ino())))
    }

    #[cfg(not(unix))]
    fn known(path: &Path, _: &Metadata) -> io::Result<Self> {
        path.canonicalize().map(Self)
    }
}
