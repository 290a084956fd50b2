//! Files to columns: what a script names by file, found inside the script's folder (or others that
//! were named for it) and nowhere else, and decoded.
//!
//! | room | holds |
//! | --- | --- |
//! | [`jail`] | a file's bytes, from inside one folder |
//! | [`mesh`] | a mesh file to [`MeshData`], by its ending |
//! | [`obj`], [`mtl`] | Wavefront OBJ and its materials |
//! | [`ply`] | PLY |
//! | [`stl`] | STL |
//! | [`mod@gltf`] | glTF and GLB |
//! | [`picture`] | PNG, JPEG, EXR and others to samples |
//! | [`rgb8`] | pictures to 8-bit pixels |
//! | [`texture`] | those to [`Texture`], and the memory of all of them |
//! | [`shield`] | a decoder's panic to an error |
//! | [`error`] | what is wrong with a file: missing, forbidden or broken, with its line or byte |
//! | `format` | what a file is that is not what its name says |
//! | `faces`, `polygon` | polygons, and how they become triangles |
//! | `lookup` | files named in another case |
//! | `left_out` | what is left out of a file, counted |
//! | `finish` | what all mesh formats end with |
//! | `words` | text files, word by word |
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # std::fs::write(folder.path().join("tri.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
//! # std::fs::write(folder.path().join("white.ppm"), b"P6\n1 1\n255\n\xff\xff\xff")?;
//! let assets = reflet_assets::Assets::new(folder.path().to_path_buf());
//! let mesh = assets.mesh("tri.obj")?;
//! assert_eq!(mesh.triangles, [[0, 1, 2]]);
//! assert!(assets.mesh("../tri.obj").is_err()); // outside the folder
//! let texture = assets.texture("white.ppm")?;
//! assert_eq!((texture.width, texture.texels[0]), (1, [1.0; 3]));
//! # Ok(()) }
//! ```

pub mod error;
mod faces;
mod finish;
mod format;
pub mod gltf;
pub mod jail;
mod left_out;
mod lookup;
pub mod mesh;
pub mod mtl;
pub mod obj;
pub mod picture;
pub mod ply;
mod polygon;
pub mod rgb8;
pub mod shield;
pub mod stl;
pub mod texture;
mod words;

pub use error::{AssetError, Cause, Fault};
use reflet_scene::{MeshData, Texture};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use texture::Encoding;

/// The files of one scene, each read once.
///
/// A new run of a script takes a new `Assets`, so that it sees the files as they are then.
#[derive(Debug)]
pub struct Assets {
    /// Where files are looked for, in this order; the first is the script's own.
    folders: Vec<PathBuf>,
    read: Mutex<Read>,
    budget: texture::Budget,
}

#[derive(Debug, Default)]
struct Read {
    /// By canonical path, so that two names of one file share its columns.
    meshes: HashMap<PathBuf, Arc<MeshData>>,
    textures: HashMap<PathBuf, Arc<Texture>>,
    notes: Vec<Note>,
    asked: Vec<PathBuf>,
    /// The same, to find them.
    is_asked: HashSet<PathBuf>,
}

impl Read {
    fn asks(&mut self, path: PathBuf) {
        if self.is_asked.insert(path.clone()) {
            self.asked.push(path);
        }
    }
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
        Self { folders: vec![root], read: Mutex::default(), budget: texture::Budget::default() }
    }

    /// The same, and the files below `folders`: what is not in one is looked for in the next.
    pub fn with_folders(mut self, folders: impl IntoIterator<Item = PathBuf>) -> Self {
        self.folders.extend(folders);
        self
    }

    /// The same, with so many bytes for all textures and what reading one takes beside them, in place
    /// of [`texture::MOST_BYTES`].
    pub fn with_texture_memory(mut self, bytes: u64) -> Self {
        self.budget = texture::Budget::new(bytes);
        self
    }

    /// The script's folder.
    pub fn root(&self) -> &Path {
        &self.folders[0]
    }

    /// The triangles of a mesh file, by a path relative to the folder. Its ending tells the format:
    /// obj, ply, stl, gltf or glb.
    ///
    /// A file that is asked for twice is read once, and its columns are shared.
    ///
    /// # Errors
    /// The file, or one that it needs, is missing, outside the folder, no regular file, or broken;
    /// see [`Cause`].
    pub fn mesh(&self, file: &str) -> Result<Arc<MeshData>, AssetError> {
        let mut read = self.lock();
        let (folder, found) = self.open(&mut read, file)?;
        if let Some(mesh) = read.meshes.get(found.place()) {
            return Ok(mesh.clone());
        }
        let bytes = found.bytes()?;
        let beside = Path::new(file).parent().unwrap_or(Path::new(""));
        // What a mesh needs stands in the same folder as the mesh, or below it.
        let mut other = |name: &str| {
            let relative = beside.join(name);
            let shown = folder.join(&relative);
            read.asks(shown.clone());
            let name = |path: &Path| path.to_str().map(str::to_owned);
            let Some(named) = name(&relative) else {
                return Err(AssetError::missing(&shown, "the name is not UTF-8"));
            };
            let opened = jail::open(&folder, &named).or_else(|error| {
                // Meshes from systems that do not tell upper from lower case name files so, too.
                let same = lookup::any_case(&folder, &relative);
                let same = same.filter(|same| error.cause() == Cause::Missing && *same != relative);
                let same = same.as_deref().and_then(name);
                same.map_or(Err(error), |same| jail::open(&folder, &same))
            })?;
            opened.bytes()
        };
        let (path, budget) = (found.shown(), &self.budget);
        let decoded = shield::shielded(|| mesh::decode_within(budget, path, &bytes, &mut other));
        let mesh::MeshFile { data, notes } = decoded.unwrap_or_else(|panic| {
            Err(AssetError::broken(path, Fault::file(format!("the file is broken ({panic})"))))
        })?;
        if !notes.is_empty() {
            read.notes.push(Note { path: path.into(), message: notes.join("; ") });
        }
        let mesh = Arc::new(data);
        read.meshes.insert(found.place().into(), mesh.clone());
        Ok(mesh)
    }

    /// The texels of a picture, by a path relative to the folder. The bytes tell the format; see
    /// [`picture::format`].
    ///
    /// A file that is asked for twice is read once, and its texels are shared. Where memory is short,
    /// those that nothing wears any longer are given up, and read again when they are asked for.
    ///
    /// # Errors
    /// The file is missing, outside the folder, no regular file, broken, or too large together with
    /// the other textures of the scene; see [`Cause`].
    pub fn texture(&self, file: &str) -> Result<Arc<Texture>, AssetError> {
        let mut read = self.lock();
        let (_, found) = self.open(&mut read, file)?;
        if let Some(texture) = read.textures.get(found.place()) {
            return Ok(texture.clone());
        }
        let bytes = found.bytes()?;
        let decode = || self.budget.texture(found.shown(), &bytes, Encoding::Told);
        let texture::Read { texture, notes, .. } = decode().or_else(|error| {
            let before = read.textures.len();
            read.textures.retain(|_, texture| Arc::strong_count(texture) > 1);
            if read.textures.len() < before { decode() } else { Err(error) }
        })?;
        for message in notes {
            let note = Note { path: found.shown().into(), message };
            if !read.notes.contains(&note) {
                read.notes.push(note);
            }
        }
        read.textures.insert(found.place().into(), texture.clone());
        Ok(texture)
    }

    /// The first folder that has a file of this name, and the file.
    fn open(&self, read: &mut Read, file: &str) -> Result<(PathBuf, jail::Inside), AssetError> {
        let mut missing = None;
        for folder in &self.folders {
            read.asks(folder.join(file));
            match jail::open(folder, file) {
                Ok(found) => return Ok((folder.clone(), found)),
                Err(error) if error.cause() == Cause::Missing => {
                    // The script's own folder is the one to tell of.
                    missing.get_or_insert(error);
                }
                Err(error) => return Err(error),
            }
        }
        match (missing, self.folders.len()) {
            (Some(error), 1) => Err(error),
            (Some(error), n) => Err(error.and(&format!(", nor is it in the {} others", n - 1))),
            (None, _) => Err(AssetError::missing(Path::new(file), "there is no such file")),
        }
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
            ["1 unknown statement ignored (line 5); 2 triangles without area skipped"]
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
