//! Files that appear under their name only when they are whole.
//!
//! A [`SafeFile`] is written beside its place under a temporary name, `.NAME.reflet-PID-N.tmp`, and
//! renamed when it is complete and on disk. A full disk, an error or a killed process leaves the
//! file of before, or none.

use std::ffi::{OsStr, OsString};
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
        file: File,
        temporary: Temporary,
        place: PathBuf,
    },
    /// A device, a pipe or the like: written through.
    Through(File),
    Stdout(io::Stdout),
}

/// Removes the file when dropped.
#[derive(Debug)]
struct Temporary {
    /// `None` once it is renamed: the name may then be another's.
    path: Option<PathBuf>,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // Nothing better can be done here; `stray_files` finds what stays.
        if let Some(path) = &self.path {
            let _ = fs::remove_file(path);
        }
    }
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

fn folder_of(place: &Path) -> &Path {
    match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

const MARK: &str = ".reflet-";
const TEMPORARY_ENDING: &str = ".tmp";

/// As much of a name as a temporary one has room for.
fn stem(name: &OsStr) -> &OsStr {
    match name.to_str() {
        Some(text) => {
            let mut end = text.len().min(200);
            while !text.is_char_boundary(end) {
                end -= 1;
            }
            OsStr::new(&text[..end])
        }
        None if name.len() <= 200 => name,
        None => OsStr::new("file"),
    }
}

/// `.NAME.reflet-PID-N.tmp`, with as much of NAME as a file name's usual 255 bytes leave room for.
fn temporary_name(name: &OsStr, count: u32) -> OsString {
    let mut temporary = OsString::from(".");
    temporary.push(stem(name));
    temporary.push(format!("{MARK}{}-{count}{TEMPORARY_ENDING}", std::process::id()));
    temporary
}

fn create_beside(place: &Path) -> io::Result<(File, Temporary)> {
    let name = place
        .file_name()
        .ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "the path names no file"))?;
    let mut count = 0;
    loop {
        let path = folder_of(place).join(temporary_name(name, count));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, Temporary { path: Some(path) })),
            // Another thread's, or one that an earlier process of this number left.
            Err(error) if error.kind() == ErrorKind::AlreadyExists && count < 100_000 => count += 1,
            Err(error) => return Err(error),
        }
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
        let (file, temporary) = create_beside(&place).map_err(fail)?;
        if let Some(meta) = existing {
            // The new file keeps the mode of the one that it replaces, where that can be done.
            let _ = file.set_permissions(meta.permissions());
        }
        Ok(Self { name: path.to_owned(), sink: Sink::Beside { file, temporary, place } })
    }

    /// Where the bytes are until the file gets its name; `None` if they are written through.
    pub fn temporary(&self) -> Option<&Path> {
        match &self.sink {
            Sink::Beside { temporary, .. } => temporary.path.as_deref(),
            Sink::Through(_) | Sink::Stdout(_) => None,
        }
    }

    /// Writes over bytes written before.
    ///
    /// # Errors
    /// What is written through cannot be written over; what the system says.
    pub fn overwrite(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let Sink::Beside { file, .. } = &mut self.sink else {
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

    /// As [`SafeFile::commit`], but leaves the folder to be synced later, with others.
    pub fn commit_in(self, folders: &mut PendingFolders) -> io::Result<()> {
        let fail = |error: io::Error| explain("write", &self.name, &error);
        match self.sink {
            Sink::Beside { file, mut temporary, place } => {
                file.sync_all().map_err(fail)?;
                drop(file);
                if let Some(path) = &temporary.path {
                    fs::rename(path, &place).map_err(fail)?;
                }
                temporary.path = None;
                folders.add(folder_of(&place));
                Ok(())
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
                _ => Ok(()),
            },
            Sink::Stdout(mut stdout) => stdout.flush().map_err(fail),
        }
    }

    /// Writes the bytes of the file at `from`, by the system's own copying where it has one.
    pub fn copy_from(&mut self, from: &Path) -> io::Result<u64> {
        let mut source = File::open(from).map_err(|error| explain("read", from, &error))?;
        let copied = match &mut self.sink {
            Sink::Beside { file, .. } | Sink::Through(file) => io::copy(&mut source, file),
            Sink::Stdout(stdout) => io::copy(&mut source, stdout),
        };
        copied.map_err(|error| explain("write", &self.name, &error))
    }
}

impl Write for SafeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.sink {
            Sink::Beside { file, .. } | Sink::Through(file) => file.write(bytes),
            Sink::Stdout(stdout) => stdout.write(bytes),
        };
        self.explained(written)
    }

    fn write_vectored(&mut self, slices: &[IoSlice<'_>]) -> io::Result<usize> {
        let written = match &mut self.sink {
            Sink::Beside { file, .. } | Sink::Through(file) => file.write_vectored(slices),
            Sink::Stdout(stdout) => stdout.write_vectored(slices),
        };
        self.explained(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = match &mut self.sink {
            Sink::Beside { file, .. } | Sink::Through(file) => file.flush(),
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

/// A temporary file that a process left behind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StrayFile {
    /// Where it is.
    pub path: PathBuf,
    /// The process that made it; it may still be at work.
    pub process: u32,
    /// The name that it was to have, or as much of it as a temporary name has room for.
    pub name: String,
}

impl StrayFile {
    /// Whether it was to become the file called `name`.
    pub fn was_to_be(&self, name: &OsStr) -> bool {
        stem(name).to_str() == Some(&self.name)
    }

    /// Whether the process that made it has ended. Where the system does not tell, it has.
    pub fn is_orphan(&self) -> bool {
        let program = |process: &str| fs::read(Path::new("/proc").join(process).join("comm")).ok();
        // A number may be another program's by now; our own was another's before.
        self.process == std::process::id()
            || program(&self.process.to_string()).is_none_or(|name| Some(name) != program("self"))
    }
}

/// The process and the final name that a temporary name tells of.
fn told_by(temporary: &OsStr) -> Option<(u32, String)> {
    let name = temporary.to_str()?.strip_prefix('.')?;
    let (name, mark) = name.strip_suffix(TEMPORARY_ENDING)?.rsplit_once(MARK)?;
    let (process, count) = mark.split_once('-')?;
    count.parse::<u32>().ok()?;
    Some((process.parse().ok()?, name.to_owned()))
}

/// The temporary files of [`SafeFile`]s in `folder`, in the order of their names.
pub fn stray_files(folder: &Path) -> io::Result<Vec<StrayFile>> {
    let fail = |error: io::Error| explain("list the folder", folder, &error);
    let mut strays = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        if let Some((process, name)) = told_by(&entry.file_name()) {
            strays.push(StrayFile { path: entry.path(), process, name });
        }
    }
    strays.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(strays)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_names_are_known_again_and_fit() {
        for name in ["a.png", "x.reflet-1-2.tmp", &"é".repeat(127)] {
            let temporary = temporary_name(OsStr::new(name), 7);
            let (process, stem) = told_by(&temporary).unwrap();
            assert_eq!(process, std::process::id());
            assert!(name.starts_with(&stem));
            assert!(temporary.len() <= 255, "{}", temporary.len());
        }
        for name in ["a.png", ".a.tmp", ".a.reflet-x-1.tmp", ".a.reflet-1-1.png"] {
            assert_eq!(told_by(OsStr::new(name)), None, "{name}");
        }
    }
}
