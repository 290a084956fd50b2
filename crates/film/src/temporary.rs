//! Temporary files: names that no other process has, and locks that tell the files of living
//! processes from orphans.
//!
//! A file that is to be called NAME is written as `.NAME.reflet-RUN-N.tmp` beside its place. RUN is
//! drawn at random by each process: process numbers would not do, since two containers or machines
//! that share a folder have the same ones. While the process lives it holds an exclusive lock on the
//! file (`flock`), which the system releases however the process ends. So an orphan is a temporary
//! file whose lock is free.
//!
//! Between the making of a file and its lock it looks like an orphan. Whoever removes an orphan holds
//! its lock meanwhile, and the maker, once it has the lock, looks whether the name still leads to its
//! file; if not, it makes another one.

use crate::identity::FileId;
use crate::safe::{explain, folder_of};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

const MARK: &str = ".reflet-";
const ENDING: &str = ".tmp";
/// Hexadecimal digits of a run.
const RUN_DIGITS: usize = 16;

/// What names the temporary files of this process.
fn run() -> u64 {
    static RUN: OnceLock<u64> = OnceLock::new();
    // The keys of a `RandomState` come from the system's source of random numbers.
    *RUN.get_or_init(|| RandomState::new().hash_one(std::process::id()))
}

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

/// `.NAME.reflet-RUN-N.tmp`, with as much of NAME as a file name's usual 255 bytes leave room for.
fn temporary_name(name: &OsStr, count: u64) -> OsString {
    let mut temporary = OsString::from(".");
    temporary.push(stem(name));
    temporary.push(format!("{MARK}{:0RUN_DIGITS$x}-{count}{ENDING}", run()));
    temporary
}

/// The run and the final name that a temporary name tells of.
fn told_by(temporary: &OsStr) -> Option<(u64, String)> {
    let name = temporary.to_str()?.strip_prefix('.')?;
    let (name, mark) = name.strip_suffix(ENDING)?.rsplit_once(MARK)?;
    let (run, count) = mark.split_once('-')?;
    count.parse::<u64>().ok()?;
    let run = Some(run).filter(|run| run.len() == RUN_DIGITS)?;
    Some((u64::from_str_radix(run, 16).ok()?, name.to_owned()))
}

/// Whether the lock of `file` was free, and is held from now on until the file is closed. Where locks
/// keep other programs from reading, or the file system has none, that is an error.
#[cfg(unix)]
fn lock(file: &File) -> io::Result<bool> {
    match file.try_lock() {
        Ok(()) => Ok(true),
        Err(fs::TryLockError::WouldBlock) => Ok(false),
        Err(fs::TryLockError::Error(error)) => Err(error),
    }
}

#[cfg(not(unix))]
fn lock(_: &File) -> io::Result<bool> {
    Err(io::Error::from(ErrorKind::Unsupported))
}

/// A file under its temporary name. Dropped, it is removed.
#[derive(Debug)]
pub(crate) struct Temporary {
    /// Closed last: its lock is held as long as the name stands.
    pub file: File,
    /// `None` once it is renamed.
    path: Option<PathBuf>,
}

impl Temporary {
    /// Makes one in the folder of `place`.
    pub fn beside(place: &Path) -> io::Result<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = place
            .file_name()
            .ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "the path names no file"))?;
        let mut tries = 0;
        loop {
            let count = COUNT.fetch_add(1, Ordering::Relaxed);
            let path = folder_of(place).join(temporary_name(name, count));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    let made = Self { file, path: Some(path) };
                    // Without locks nobody removes what seems to be an orphan, either.
                    if lock(&made.file).unwrap_or(true) && made.is_there().is_ok() {
                        return Ok(made);
                    }
                }
                Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
                Err(_) => {}
            }
            tries += 1;
            if tries == 1000 {
                return Err(io::Error::other("its temporary files are removed at once"));
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Whether its name still leads to it.
    fn is_there(&self) -> io::Result<()> {
        let Some(path) = &self.path else { return Ok(()) };
        let gone = |what| {
            let name = path.file_name().unwrap_or_default().display();
            Err(io::Error::other(format!("another program has {what} its temporary file {name}")))
        };
        match FileId::of_name(path) {
            Ok(id) if id == FileId::of_open(&self.file, path)? => Ok(()),
            Ok(_) => gone("replaced"),
            Err(error) if error.kind() == ErrorKind::NotFound && folder_of(path).is_dir() => {
                gone("removed")
            }
            Err(error) => Err(error),
        }
    }

    /// Gives the file the name `place`, and tells its identity. Another program's file that has come
    /// to stand under the temporary name is left alone.
    pub fn rename(mut self, place: &Path) -> io::Result<FileId> {
        self.is_there()?;
        if let Some(path) = &self.path {
            fs::rename(path, place)?;
        }
        self.path = None;
        FileId::of_open(&self.file, place)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // Nothing better can be done here; `stray_files` finds what stays.
        if let (Some(path), Ok(())) = (&self.path, self.is_there()) {
            let _ = fs::remove_file(path);
        }
    }
}

/// A temporary file that a process left behind, or is at work on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StrayFile {
    /// Where it is.
    pub path: PathBuf,
    /// The name that it was to have, or as much of it as a temporary name has room for.
    pub name: String,
    run: u64,
}

impl StrayFile {
    /// Whether it was to become the file called `name`.
    pub fn was_to_be(&self, name: &OsStr) -> bool {
        stem(name).to_str() == Some(&self.name)
    }

    /// Whether this process made it.
    pub fn is_ours(&self) -> bool {
        self.run == run()
    }

    /// Removes it if the process that made it has ended, and tells whether it did. A file whose
    /// maker cannot be told to have ended (another user's, or one on a file system without locks)
    /// stays.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove_orphan(&self) -> io::Result<bool> {
        // Opening a pipe would wait for its other end.
        let is_file = fs::symlink_metadata(&self.path).is_ok_and(|about| about.is_file());
        if self.is_ours() || !is_file {
            return Ok(false);
        }
        // Over a network only what may be written can be locked; a temporary file has the mode of
        // the file that it was to replace, which may be one for reading only.
        let open = |write| OpenOptions::new().read(true).write(write).open(&self.path);
        let Ok(file) = open(true).or_else(|_| open(false)) else { return Ok(false) };
        if !lock(&file).unwrap_or(false) {
            return Ok(false);
        }
        let ours = FileId::of_open(&file, &self.path)?;
        match FileId::of_name(&self.path) {
            Ok(id) if id == ours => fs::remove_file(&self.path).map(|()| true),
            _ => Ok(false),
        }
    }
}

/// The temporary files in `folder`, in the order of their names.
///
/// # Errors
/// The folder cannot be listed.
pub fn stray_files(folder: &Path) -> io::Result<Vec<StrayFile>> {
    let fail = |error: io::Error| explain("list the folder", folder, &error);
    let mut strays = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        if let Some((run, name)) = told_by(&entry.file_name()) {
            strays.push(StrayFile { path: entry.path(), name, run });
        }
    }
    strays.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(strays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn temporary_names_are_known_again_and_fit() {
        for name in ["a.png", "x.reflet-1-2.tmp", &"é".repeat(127)] {
            let temporary = temporary_name(OsStr::new(name), u64::MAX);
            let (told, stem) = told_by(&temporary).unwrap();
            assert_eq!(told, run());
            assert!(name.starts_with(&stem));
            assert!(temporary.len() <= 255, "{}", temporary.len());
        }
        let other = ".a.reflet-0123456789abcdef-1";
        assert!(told_by(OsStr::new(&format!("{other}.tmp"))).is_some());
        let not_ours = ["a.png", ".a.tmp", ".a.reflet-x-1.tmp", ".a.reflet-1-1.tmp"];
        for name in not_ours.into_iter().chain([&*format!("{other}.png")]) {
            assert_eq!(told_by(OsStr::new(name)), None, "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_in_the_place_of_ours_is_neither_renamed_nor_removed() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("a.png");
        for removed in [false, true] {
            let mut file = Temporary::beside(&place).unwrap();
            file.file.write_all(b"ours").unwrap();
            let path = file.path().unwrap().to_owned();
            // The old one is kept open by `file`, so its inode is not used again.
            fs::remove_file(&path).unwrap();
            if !removed {
                fs::write(&path, b"another's").unwrap();
            }
            let what = if removed { "removed" } else { "replaced" };
            let error = file.rename(&place).unwrap_err().to_string();
            assert!(error.starts_with(&format!("another program has {what}")), "{error}");
            assert!(!place.exists());
            assert_eq!(path.exists(), !removed);
        }
    }

    #[cfg(unix)]
    #[test]
    fn only_an_orphan_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        // As another process would: only its lock says that it is at work.
        let path = folder.path().join(".a.png.reflet-0123456789abcdef-0.tmp");
        let maker = File::create(&path).unwrap();
        let stray = || stray_files(folder.path()).unwrap().remove(0);
        assert!(stray().was_to_be(OsStr::new("a.png")) && !stray().is_ours());
        assert!(lock(&maker).unwrap());
        assert!(!stray().remove_orphan().unwrap() && path.exists());
        drop(maker);
        assert!(stray().remove_orphan().unwrap() && !path.exists());

        let ours = Temporary::beside(&folder.path().join("a.png")).unwrap();
        assert!(stray().is_ours() && !stray().remove_orphan().unwrap());
        drop(ours);
        assert!(stray_files(folder.path()).unwrap().is_empty());
    }
}
