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

/// The canonical path of `file` below `root`.
///
/// # Errors
/// [`crate::Cause::Forbidden`] if the name is empty, absolute, holds `..`, or leads outside `root`
/// or to what is no regular file; [`crate::Cause::Missing`] if there is nothing.
pub fn find(root: &Path, file: &str) -> Result<PathBuf, AssetError> {
    let shown = root.join(file);
    let inside = "a scene's files stand in the script's folder or below it";
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
        let message = format!("{what} is not allowed: {inside}; write a path relative to it");
        return Err(AssetError::forbidden(Path::new(file), message));
    }
    let canonical_root = root.canonicalize().map_err(|e| unreadable(root, &e))?;
    let found = shown.canonicalize().map_err(|e| unreadable(&shown, &e))?;
    if !found.starts_with(&canonical_root) {
        let message = format!("a link leads out of the folder: {inside}; copy the file there");
        return Err(AssetError::forbidden(&shown, message));
    }
    let kind = found.metadata().map_err(|e| unreadable(&shown, &e))?;
    if !kind.is_file() {
        let what = if kind.is_dir() { "this is a folder" } else { "this is no regular file" };
        return Err(AssetError::forbidden(&shown, format!("{what}; name a file in it")));
    }
    Ok(found)
}

/// The bytes of a file that [`find`] found; `shown` is its name in messages.
///
/// # Errors
/// [`crate::Cause::Missing`] if it cannot be read, is larger than [`MAX_BYTES`], or memory does not
/// hold it.
pub fn bytes(found: &Path, shown: &Path) -> Result<Vec<u8>, AssetError> {
    let mut file = File::open(found).map_err(|e| unreadable(shown, &e))?;
    let meta = file.metadata().map_err(|e| unreadable(shown, &e))?;
    let too_large = || {
        let message = format!("larger than {} GiB; split it", MAX_BYTES >> 30);
        AssetError::forbidden(shown, message)
    };
    if meta.len() > MAX_BYTES {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    if bytes.try_reserve_exact(meta.len() as usize + 1).is_err() {
        let message = format!("no memory for its {} bytes; split it", meta.len());
        return Err(AssetError::missing(shown, message));
    }
    // A file may grow while it is read.
    (&mut file).take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|e| unreadable(shown, &e))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(too_large());
    }
    Ok(bytes)
}

fn unreadable(path: &Path, error: &std::io::Error) -> AssetError {
    let message = match error.kind() {
        ErrorKind::NotFound => {
            "there is no such file; the path is relative to the script's folder".into()
        }
        ErrorKind::PermissionDenied => "may not be read; change its permissions".into(),
        ErrorKind::InvalidInput => "no file can have this name".into(),
        _ => format!("cannot be read: {error}"),
    };
    AssetError::missing(path, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cause;

    fn cause(root: &Path, file: &str) -> Cause {
        find(root, file).unwrap_err().cause()
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
        assert_eq!(find(&inner, "./in.obj").unwrap(), inner.canonicalize().unwrap().join("in.obj"));
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
        symlink("../secret.obj", inner.join("leaves.obj")).unwrap();
        symlink(dir.path(), inner.join("up")).unwrap();
        symlink("loop.obj", inner.join("loop.obj")).unwrap();
        assert!(find(&inner, "stays.obj").is_ok());
        assert_eq!(cause(&inner, "leaves.obj"), Cause::Forbidden);
        assert_eq!(cause(&inner, "up/secret.obj"), Cause::Forbidden);
        assert_eq!(cause(&inner, "loop.obj"), Cause::Missing);
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
