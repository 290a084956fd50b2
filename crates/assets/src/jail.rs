//! A file's bytes, from inside one folder.
//!
//! A scene may come from anywhere, so a name in it must not reach beyond the scene's own folder:
//! no absolute path, no `..`, no symbolic link that leaves, and nothing but regular files (a pipe
//! would block, a device need not end).

use crate::error::AssetError;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

/// The largest file that is read, in bytes. The shortest vertex takes three of them, so the number of
/// vertices stays within `u32`.
pub const MAX_BYTES: u64 = 4 << 30;

/// A regular file inside of a folder, open for reading.
#[derive(Debug)]
pub struct Inside {
    file: File,
    length: u64,
    place: PathBuf,
    shown: PathBuf,
}

/// Opens `file` below `root`.
///
/// Where the name leads is looked up first, so that links may stay inside. What was found is then
/// opened beneath the folder without following any link, so that nothing put there in between leads
/// out.
///
/// # Errors
/// [`crate::Cause::Forbidden`] if the name is empty, absolute or holds `..`, or names what is no
/// regular file; [`crate::Cause::Missing`] if there is nothing below `root`, or a link leads out:
/// nobody learns what is elsewhere.
pub fn open(root: &Path, file: &str) -> Result<Inside, AssetError> {
    let shown = root.join(file);
    if file.is_empty() {
        return Err(AssetError::forbidden(
            root,
            "the file's name is empty; name one in this folder",
        ));
    }
    for component in Path::new(file).components() {
        let what = match component {
            Component::Normal(_) | Component::CurDir => continue,
            Component::ParentDir => "a path with `..`",
            Component::RootDir | Component::Prefix(_) => "an absolute path",
        };
        let message = format!(
            "{what} is not allowed: a scene's files stand in the script's folder or below it; write a \
             path relative to it"
        );
        return Err(AssetError::forbidden(Path::new(file), message));
    }
    let absent = || {
        let message = "there is no such file in the folder; the path is relative to the script's \
                       folder, and links may not lead out of it";
        AssetError::missing(&shown, message)
    };
    let root = root.canonicalize().map_err(|e| unreadable(root, &e))?;
    let place = shown.canonicalize().map_err(|_| absent())?;
    let below = place.strip_prefix(&root).map_err(|_| absent())?;
    let opened = match below.as_os_str().is_empty() {
        true => Err(AssetError::forbidden(&shown, "this is a folder; name a file in it")),
        false => beneath(&root, below).map_err(|e| match e.kind() {
            ErrorKind::NotFound => absent(),
            _ => unreadable(&shown, &e),
        }),
    }?;
    let about = opened.metadata().map_err(|e| unreadable(&shown, &e))?;
    if !about.is_file() {
        let what = if about.is_dir() { "this is a folder" } else { "this is no regular file" };
        return Err(AssetError::forbidden(&shown, format!("{what}; name a file in it")));
    }
    Ok(Inside { file: opened, length: about.len(), place, shown })
}

/// Opens what stands at `path` below `root`, neither following a link nor waiting for a pipe.
#[cfg(unix)]
fn beneath(root: &Path, path: &Path) -> std::io::Result<File> {
    use rustix::fs::{Mode, OFlags, open, openat};
    let folder = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let mut at = open(root, folder, Mode::empty())?;
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{ResolveFlags, openat2};
        use rustix::io::Errno;
        let resolve = ResolveFlags::BENEATH | ResolveFlags::NO_SYMLINKS;
        match openat2(&at, path, flags, Mode::empty(), resolve) {
            // Older than Linux 5.6, or kept from us by a sandbox.
            Err(Errno::NOSYS | Errno::PERM) => {}
            opened => return Ok(File::from(opened?)),
        }
    }
    // Folder by folder, each opened in the one before.
    let mut names = path.components().map(Component::as_os_str).peekable();
    while let Some(name) = names.next() {
        let flags = if names.peek().is_some() { folder } else { flags };
        at = openat(&at, name, flags | OFlags::NOFOLLOW, Mode::empty())?;
    }
    Ok(File::from(at))
}

/// Opens what stands at `path` below `root`.
#[cfg(not(unix))]
fn beneath(root: &Path, path: &Path) -> std::io::Result<File> {
    File::open(root.join(path))
}

impl Inside {
    /// Where it is in truth: the same for all names of one file.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Its name in messages.
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// Its bytes.
    ///
    /// # Errors
    /// [`crate::Cause::Missing`] if it cannot be read or memory does not hold it,
    /// [`crate::Cause::Forbidden`] if it is larger than [`MAX_BYTES`].
    pub fn bytes(&self) -> Result<Vec<u8>, AssetError> {
        let shown = &self.shown;
        let too_large = || {
            let message = format!("larger than {} GiB; split it", MAX_BYTES >> 30);
            AssetError::forbidden(shown, message)
        };
        if self.length > MAX_BYTES {
            return Err(too_large());
        }
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(self.length as usize + 1).is_err() {
            let message = format!("no memory for its {} bytes; split it", self.length);
            return Err(AssetError::missing(shown, message));
        }
        // A file may grow while it is read.
        let read = (&self.file).take(MAX_BYTES + 1).read_to_end(&mut bytes);
        read.map_err(|e| unreadable(shown, &e))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(too_large());
        }
        Ok(bytes)
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> AssetError {
    let message = match error.kind() {
        ErrorKind::NotFound => "there is no such folder".into(),
        ErrorKind::PermissionDenied => "may not be read; change its permissions".into(),
        _ => format!("cannot be read: {error}"),
    };
    AssetError::missing(path, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cause;

    fn cause(root: &Path, file: &str) -> Cause {
        open(root, file).unwrap_err().cause()
    }

    #[test]
    fn names_that_lead_out_are_forbidden() {
        let dir = tempfile::tempdir().unwrap();
        let inner = dir.path().join("scene");
        std::fs::create_dir_all(inner.join("sub")).unwrap();
        std::fs::write(dir.path().join("secret.obj"), "v 0 0 0").unwrap();
        std::fs::write(inner.join("in.obj"), "v 0 0 0").unwrap();
        for bad in ["", "../secret.obj", "sub/../in.obj", "sub/..", "sub", "."] {
            assert_eq!(cause(&inner, bad), Cause::Forbidden, "{bad:?}");
        }
        let absolute = inner.join("in.obj");
        assert_eq!(cause(&inner, absolute.to_str().unwrap()), Cause::Forbidden);
        assert_eq!(cause(&inner, "none.obj"), Cause::Missing);
        assert_eq!(cause(&inner, "in.obj/none"), Cause::Missing);
        assert_eq!(cause(&inner, "a\0b"), Cause::Missing);
        let opened = open(&inner, "./in.obj").unwrap();
        assert_eq!(opened.place(), inner.canonicalize().unwrap().join("in.obj"));
        assert_eq!(opened.bytes().unwrap(), b"v 0 0 0");
    }

    #[cfg(unix)]
    #[test]
    fn links_may_stay_and_may_not_leave() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let inner = dir.path().join("scene");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(dir.path().join("secret.obj"), "v 0 0 0").unwrap();
        std::fs::write(inner.join("in.obj"), "v 0 0 0").unwrap();
        symlink("in.obj", inner.join("stays.obj")).unwrap();
        symlink(inner.join("in.obj"), inner.join("absolute.obj")).unwrap();
        symlink("../secret.obj", inner.join("leaves.obj")).unwrap();
        symlink("../none.obj", inner.join("dangles.obj")).unwrap();
        symlink(dir.path(), inner.join("up")).unwrap();
        symlink("loop.obj", inner.join("loop.obj")).unwrap();
        assert_eq!(open(&inner, "stays.obj").unwrap().bytes().unwrap(), b"v 0 0 0");
        assert!(open(&inner, "absolute.obj").is_ok());
        // What is outside and what is nowhere have the same words.
        let absent = open(&inner, "none.obj").unwrap_err();
        for name in ["leaves.obj", "dangles.obj", "up/secret.obj", "up/none.obj", "loop.obj"] {
            let error = open(&inner, name).unwrap_err();
            assert_eq!(
                (error.cause(), error.message()),
                (Cause::Missing, absent.message()),
                "{name}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_put_in_place_of_what_was_found_is_not_followed() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let inner = dir.path().join("scene");
        std::fs::create_dir_all(inner.join("sub")).unwrap();
        std::fs::create_dir(dir.path().join("out")).unwrap();
        std::fs::write(dir.path().join("out/a.obj"), "secret").unwrap();
        std::fs::write(inner.join("sub/a.obj"), "v 0 0 0").unwrap();
        assert!(beneath(&inner, Path::new("sub/a.obj")).is_ok());
        std::fs::remove_dir_all(inner.join("sub")).unwrap();
        symlink("../out", inner.join("sub")).unwrap();
        assert!(beneath(&inner, Path::new("sub/a.obj")).is_err());
        symlink("../out/a.obj", inner.join("b.obj")).unwrap();
        assert!(beneath(&inner, Path::new("b.obj")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_refused_and_does_not_block() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe.obj");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|s| s.success()), "this test needs mkfifo");
        assert_eq!(cause(dir.path(), "pipe.obj"), Cause::Forbidden);
    }
}
