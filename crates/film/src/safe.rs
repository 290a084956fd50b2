//! Files that appear under their name only when they are whole.
//!
//! A [`SafeFile`] is written beside its place under a temporary name and renamed when it is complete
//! and on disk. A full disk, an error or a killed process leaves the file of before, or none. Of two
//! that are written at one place at once, the one that is renamed later stands, whole.

use crate::identity::FileId;
use crate::temporary::Temporary;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, IoSlice, Seek, SeekFrom, Write};
use std::path::{Component, Path, PathBuf};

/// An output that is being written. Unless it is committed, dropping it leaves no trace.
#[derive(Debug)]
pub struct SafeFile {
    /// As the caller wrote it, for messages.
    name: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    /// Written under `temporary`, to be renamed to `place`.
    Beside {
        temporary: Temporary,
        place: PathBuf,
    },
    /// A device, a pipe or the like: written through.
    Through(File),
    Stdout(io::Stdout),
}

/// Folders in which files were renamed and which are to be synced. Syncing once for many files
/// spares one wait per file; the files themselves are synced before they are renamed, so that a
/// name never shows a broken file.
#[derive(Debug, Default)]
pub struct PendingFolders {
    folders: Vec<PathBuf>,
}

impl PendingFolders {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    fn add(&mut self, folder: &Path) {
        if !self.folders.iter().any(|known| known == folder) {
            self.folders.push(folder.to_owned());
        }
    }

    /// Syncs every folder and forgets them.
    pub fn sync(&mut self) -> io::Result<()> {
        for folder in std::mem::take(&mut self.folders) {
            sync_folder(&folder)?;
        }
        Ok(())
    }
}

/// Whether the folder of an output is made if it is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Folders {
    /// It is made.
    Make,
    /// It was there a moment ago: that it has vanished is an error, since files in it are gone.
    Expect,
}

/// What went wrong, with the path, and what to do about it.
pub(crate) fn explain(doing: &str, path: &Path, error: &io::Error) -> io::Error {
    let advice = match error.kind() {
        ErrorKind::StorageFull => "; free some space or choose another folder",
        ErrorKind::QuotaExceeded => "; your quota is used up: free some space",
        ErrorKind::FileTooLarge => "; files may not become so large here (see `ulimit -f`)",
        ErrorKind::PermissionDenied => "; choose a folder that you may write to",
        ErrorKind::ReadOnlyFilesystem => "; the file system is read-only: choose another folder",
        ErrorKind::NotFound => "; its folder is gone",
        ErrorKind::NotADirectory => "; a part of the path is a file, not a folder",
        ErrorKind::InvalidFilename => "; shorten the name",
        ErrorKind::BrokenPipe => "; the reader has gone",
        _ => "",
    };
    io::Error::new(error.kind(), format!("cannot {doing} {}: {error}{advice}", path.display()))
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    let synced = File::open(folder).and_then(|folder| folder.sync_all());
    match synced {
        // Some file systems cannot sync a folder; there is no more to be had there.
        Err(error) if !matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
            Err(explain("sync the folder", folder, &error))
        }
        _ => Ok(()),
    }
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Where writing to `path` ends up: the end of its chain of symlinks. `None` if the chain leads
/// through a process's own descriptors (`/dev/stdout`), which must be written through.
fn resolve(path: &Path) -> io::Result<Option<PathBuf>> {
    let mut place = path.to_owned();
    for _ in 0..40 {
        let descriptor = ["/proc", "/dev/fd"].iter().any(|root| place.starts_with(root));
        if descriptor {
            return Ok(None);
        }
        match fs::read_link(&place) {
            Ok(next) => {
                let folder = place.parent().unwrap_or(Path::new(""));
                place = folder.join(next);
            }
            Err(_) => return Ok(Some(place)),
        }
    }
    Err(io::Error::new(ErrorKind::InvalidInput, "too many levels of symbolic links"))
}

pub(crate) fn folder_of(place: &Path) -> &Path {
    match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

impl SafeFile {
    /// Opens an output named `path`. Missing folders are made, symlinks are followed to their end,
    /// and what exists and is not a regular file (a pipe, `/dev/full`, `/dev/stdout`) is written
    /// through.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::create_in(path, Folders::Make)
    }

    /// As [`SafeFile::create`], but missing folders are made only if `folders` says so.
    pub fn create_in(path: &Path, folders: Folders) -> io::Result<Self> {
        let fail = |error: io::Error| explain("write", path, &error);
        let existing = fs::metadata(path).ok();
        let mut place = None;
        match &existing {
            Some(meta) if meta.is_dir() => {
                return Err(io::Error::new(
                    ErrorKind::IsADirectory,
                    format!("cannot write {}: it is a folder; name a file in it", path.display()),
                ));
            }
            Some(meta) if !meta.is_file() => {}
            _ => place = resolve(path).map_err(fail)?,
        }
        let Some(place) = place else {
            let truncate = existing.is_some_and(|meta| meta.is_file());
            let file = OpenOptions::new().write(true).truncate(truncate).open(path);
            return Ok(Self { name: path.to_owned(), sink: Sink::Through(file.map_err(fail)?) });
        };
        if matches!(
            path.components().next_back(),
            None | Some(Component::ParentDir | Component::CurDir | Component::RootDir)
        ) {
            return Err(io::Error::new(
                ErrorKind::InvalidInput,
                format!("cannot write {}: the path names no file", path.display()),
            ));
        }
        let folder = folder_of(&place);
        if folders == Folders::Make {
            let made = fs::create_dir_all(folder);
            made.map_err(|error| explain("make the folder", folder, &error))?;
        }
        let temporary = Temporary::beside(&place).map_err(fail)?;
        if let Some(meta) = existing {
            // The new file keeps the mode of the one that it replaces, where that can be done.
            let _ = temporary.file.set_permissions(meta.permissions());
        }
        Ok(Self { name: path.to_owned(), sink: Sink::Beside { temporary, place } })
    }

    /// Where the bytes are until the file gets its name; `None` if they are written through.
    pub fn temporary(&self) -> Option<&Path> {
        match &self.sink {
            Sink::Beside { temporary, .. } => temporary.path(),
            Sink::Through(_) | Sink::Stdout(_) => None,
        }
    }

    /// Writes over bytes written before.
    ///
    /// # Errors
    /// What is written through cannot be written over; what the system says.
    pub fn overwrite(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let Sink::Beside { temporary: Temporary { file, .. }, .. } = &mut self.sink else {
            return Err(io::Error::from(ErrorKind::NotSeekable));
        };
        let written = file.seek(SeekFrom::Start(offset)).and_then(|_| file.write_all(bytes));
        written.map_err(|error| explain("write", &self.name, &error))
    }

    /// The standard output.
    pub fn stdout() -> Self {
        Self { name: PathBuf::from("-"), sink: Sink::Stdout(io::stdout()) }
    }

    /// The output's name as the caller gave it, `-` for the standard output.
    pub fn path(&self) -> &Path {
        &self.name
    }

    /// Flushes, syncs and renames: from here on the file stands under its name, whole, also after
    /// a power cut. On an error nothing of it stays.
    pub fn commit(self) -> io::Result<()> {
        let mut folders = PendingFolders::new();
        self.commit_in(&mut folders)?;
        folders.sync()
    }

    /// As [`SafeFile::commit`], but leaves the folder to be synced later, with others. Tells the
    /// identity of the file, unless it was written through.
    pub fn commit_in(self, folders: &mut PendingFolders) -> io::Result<Option<FileId>> {
        let fail = |error: io::Error| explain("write", &self.name, &error);
        match self.sink {
            Sink::Beside { temporary, place } => {
                temporary.file.sync_all().map_err(fail)?;
                let id = temporary.rename(&place).map_err(fail)?;
                folders.add(folder_of(&place));
                Ok(Some(id))
            }
            Sink::Through(file) => match file.sync_all() {
                // Pipes and character devices cannot be synced, which is no failure of theirs.
                Err(error)
                    if !matches!(
                        error.kind(),
                        ErrorKind::InvalidInput | ErrorKind::Unsupported
                    ) =>
                {
                    Err(fail(error))
                }
                _ => Ok(None),
            },
            Sink::Stdout(mut stdout) => stdout.flush().map_err(fail).map(|()| None),
        }
    }

    /// Writes the bytes of the file at `from`, by the system's own copying where it has one.
    pub fn copy_from(&mut self, from: &Path) -> io::Result<u64> {
        let mut source = File::open(from).map_err(|error| explain("read", from, &error))?;
        let copied = match &mut self.sink {
            Sink::Beside { temporary: Temporary { file, .. }, .. } | Sink::Through(file) => {
                io::copy(&mut source, file)
            }
            Sink::Stdout(stdout) => io::copy(&mut source, stdout),
        };
        copied.map_err(|error| explain("write", &self.name, &error))
    }
}

impl Write for SafeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.sink {
            Sink::Beside { temporary: Temporary { file, .. }, .. } | Sink::Through(file) => {
                file.write(bytes)
            }
            Sink::Stdout(stdout) => stdout.write(bytes),
        };
        self.explained(written)
    }

    fn write_vectored(&mut self, slices: &[IoSlice<'_>]) -> io::Result<usize> {
        let written = match &mut self.sink {
            Sink::Beside { temporary: Temporary { file, .. }, .. } | Sink::Through(file) => {
                file.write_vectored(slices)
            }
            Sink::Stdout(stdout) => stdout.write_vectored(slices),
        };
        self.explained(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = match &mut self.sink {
            Sink::Beside { temporary: Temporary { file, .. }, .. } | Sink::Through(file) => {
                file.flush()
            }
            Sink::Stdout(stdout) => stdout.flush(),
        };
        self.explained(flushed)
    }
}

impl SafeFile {
    fn explained<T>(&self, result: io::Result<T>) -> io::Result<T> {
        match result {
            // To be retried by the caller, as `Write::write_all` does.
            Err(error) if error.kind() == ErrorKind::Interrupted => Err(error),
            Err(error) => Err(explain("write", &self.name, &error)),
            done => done,
        }
    }
}
