//! Files to columns: what a script names by file, found inside the script's folder and nowhere
//! else, and decoded.
//!
//! | room | holds |
//! | --- | --- |
//! | [`jail`] | a file's bytes, from inside one folder |
//! | [`obj`] | Wavefront OBJ: `v` and `f` lines to [`MeshData`] |
//! | [`png`] | PNG to pixels |
//! | [`error`] | what is wrong with a file: missing, forbidden or broken, with its line |
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # std::fs::write(folder.path().join("tri.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
//! let assets = reflet_assets::Assets::new(folder.path().to_path_buf());
//! let mesh = assets.mesh("tri.obj")?;
//! assert_eq!(mesh.triangles, [[0, 1, 2]]);
//! assert!(assets.mesh("../tri.obj").is_err()); // outside the folder
//! # Ok(()) }
//! ```

pub mod error;
pub mod jail;
pub mod obj;
pub mod png;

pub use error::{AssetError, Cause};
use reflet_scene::MeshData;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The files of one scene, each read once.
///
/// A new run of a script takes a new `Assets`, so that it sees the files as they are then.
#[derive(Debug)]
pub struct Assets {
    root: PathBuf,
    read: Mutex<Read>,
}

#[derive(Debug, Default)]
struct Read {
    /// By canonical path, so that two names of one file share its columns.
    meshes: HashMap<PathBuf, Arc<MeshData>>,
    notes: Vec<Note>,
    asked: Vec<PathBuf>,
}

/// Something about a file that is no error, for a warning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The file, with the folder in front as it was given to [`Assets::new`].
    pub path: PathBuf,
    /// What was seen, for example `12 triangles without area were skipped`.
    pub message: String,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.message)
    }
}

impl Assets {
    /// The files below `root`, the script's folder; an empty path is the current folder.
    pub fn new(root: PathBuf) -> Self {
        let root = if root.as_os_str().is_empty() { PathBuf::from(".") } else { root };
        Self { root, read: Mutex::default() }
    }

    /// The folder that files are found in.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The triangles of a mesh file, by a path relative to the folder.
    ///
    /// A file that is asked for twice is read once, and its columns are shared.
    ///
    /// # Errors
    /// The file is missing, outside the folder, no regular file, or broken; see [`Cause`].
    pub fn mesh(&self, file: &str) -> Result<Arc<MeshData>, AssetError> {
        let shown = self.root.join(file);
        let mut read = self.lock();
        if !read.asked.contains(&shown) {
            read.asked.push(shown.clone());
        }
        let found = jail::find(&self.root, file)?;
        if let Some(mesh) = read.meshes.get(&found) {
            return Ok(mesh.clone());
        }
        let bytes = jail::bytes(&found, &shown)?;
        let obj = obj::parse(&bytes).map_err(|fault| AssetError::broken(&shown, fault))?;
        let mut note = |message| read.notes.push(Note { path: shown.clone(), message });
        if obj.without_area > 0 {
            note(format!("{} without area skipped", counted(obj.without_area, "triangle")));
        }
        if let Some(line) = obj.unknown_line {
            let statements = counted(obj.unknown, "unknown statement");
            note(format!("{statements} ignored, the first in line {line}"));
        }
        let mesh = Arc::new(obj.data);
        read.meshes.insert(found, mesh.clone());
        Ok(mesh)
    }

    /// The texels of a picture file.
    ///
    /// # Errors
    /// As [`Assets::mesh`].
    pub fn texture(&self, file: &str) -> Result<Arc<reflet_scene::Texture>, AssetError> {
        jail::find(&self.root, file)?;
        Ok(Arc::default())
    }

    /// What the files read so far deserve a warning for, in the order of reading.
    pub fn notes(&self) -> Vec<Note> {
        self.lock().notes.clone()
    }

    /// Every file that was asked for, each once, also those that could not be read: what to watch.
    pub fn asked(&self) -> Vec<PathBuf> {
        self.lock().asked.clone()
    }

    fn lock(&self) -> MutexGuard<'_, Read> {
        // Every write to `Read` is a single push or insert: nothing is left half done by a panic.
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn counted(n: u64, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(dir.path().join(name), text).unwrap();
        }
        dir
    }

    #[test]
    fn the_same_file_is_shared_under_all_its_names() {
        let dir = folder(&[("a.obj", TRIANGLE)]);
        let assets = Assets::new(dir.path().to_path_buf());
        let first = assets.mesh("a.obj").unwrap();
        assert!(Arc::ptr_eq(&first, &assets.mesh("a.obj").unwrap()));
        assert!(Arc::ptr_eq(&first, &assets.mesh("./a.obj").unwrap()));
        assert_eq!(first.triangles.len(), 1);
    }

    #[test]
    fn notes_count_what_was_skipped() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nwobble 1\nf 1 2 3\nf 1 2 4\nf 1 1 2\n";
        let dir = folder(&[("a.obj", text)]);
        let assets = Assets::new(dir.path().to_path_buf());
        assert_eq!(assets.mesh("a.obj").unwrap().triangles, [[0, 1, 2]]);
        assets.mesh("a.obj").unwrap();
        let notes: Vec<_> = assets.notes().into_iter().map(|n| n.message).collect();
        assert_eq!(
            notes,
            [
                "2 triangles without area skipped",
                "1 unknown statement ignored, the first in line 5"
            ]
        );
    }

    #[test]
    fn a_missing_file_is_remembered_for_watching() {
        let dir = folder(&[]);
        let assets = Assets::new(dir.path().to_path_buf());
        assert_eq!(assets.mesh("no.obj").unwrap_err().cause(), Cause::Missing);
        assert_eq!(assets.asked(), [dir.path().join("no.obj")]);
        std::fs::write(dir.path().join("no.obj"), TRIANGLE).unwrap();
        assert!(assets.mesh("no.obj").is_ok());
    }

    #[test]
    fn a_broken_line_is_named() {
        let dir = folder(&[("a.obj", "v 0 0 0\nv 1 x 0\n")]);
        let error = Assets::new(dir.path().to_path_buf()).mesh("a.obj").unwrap_err();
        assert_eq!(error.cause(), Cause::Broken);
        assert_eq!(error.line(), Some(2));
        let path = dir.path().join("a.obj");
        assert_eq!(
            error.to_string(),
            format!("{}:2: `x` is not a number; mend the `v` line", path.display())
        );
    }
}
