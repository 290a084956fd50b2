//! An output is never an input, and what is not ours is not written over: looked at before anything
//! is written.
//!
//! Files are compared by what they are and not by what they are called, so links count. An earlier
//! output is no input and may be replaced.

use reflet_film::{FileId, Target, is_foreign_manifest, manifest_path, needs_manifest};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Files that are read and must not be written over.
#[derive(Clone, Debug, Default)]
pub struct Inputs(BTreeMap<FileId, PathBuf>);

/// Why nothing is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The output is an input.
    Input {
        /// The output.
        output: PathBuf,
        /// The input, as it is called where it is read.
        input: PathBuf,
    },
    /// A file that we did not write stands where the film's or picture's texts go.
    Foreign {
        /// The output.
        output: PathBuf,
        /// That file.
        manifest: PathBuf,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Input { output, input } if output == input => {
                write!(f, "cannot write {}: it is an input of this run; ", output.display())?;
                f.write_str("name another output")
            }
            Refusal::Input { output, input } => write!(
                f,
                "cannot write {}: it is the same file as {}, an input of this run; name another \
                 output",
                output.display(),
                input.display()
            ),
            Refusal::Foreign { output, manifest } => write!(
                f,
                "cannot write {}: what it is made from goes into {}, and that is another \
                 program's file; move it away or name another output",
                output.display(),
                manifest.display()
            ),
        }
    }
}

impl std::error::Error for Refusal {}

impl Inputs {
    /// The files at `paths`. What is not there, a folder or a device cannot be written over.
    pub fn of(paths: impl IntoIterator<Item = impl AsRef<Path>>) -> Self {
        let known = |path: &Path| {
            let id = FileId::of(path).ok().filter(|_| path.is_file());
            id.map(|id| (id, path.to_owned()))
        };
        Self(paths.into_iter().filter_map(|path| known(path.as_ref())).collect())
    }

    /// Refuses an output that is one of these files.
    ///
    /// # Errors
    /// It is one.
    pub fn spare(&self, output: &Path) -> Result<(), Refusal> {
        match FileId::of(output).ok().and_then(|id| self.0.get(&id)) {
            Some(input) => {
                Err(Refusal::Input { output: output.to_owned(), input: input.to_owned() })
            }
            None => Ok(()),
        }
    }

    /// Refuses a target of which a file, or what stands beside it, is one of these files or another
    /// program's.
    ///
    /// # Errors
    /// The first file that is.
    pub fn spare_by(&self, target: &Target, frames: &[u32]) -> Result<(), Refusal> {
        if target.is_stdout() {
            return Ok(());
        }
        let files = if target.is_numbered() { frames } else { &frames[..frames.len().min(1)] };
        for frame in files {
            let output = target.path_for(*frame);
            self.spare(&output)?;
            let manifest = manifest_path(&output);
            // A device has none.
            let stands = needs_manifest(target.format()) && (output.is_file() || !output.exists());
            if stands {
                self.spare(&manifest)?;
                if is_foreign_manifest(&manifest) {
                    return Err(Refusal::Foreign { output, manifest });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_are_known_by_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in"), "in").unwrap();
        fs::write(at("other"), "in").unwrap();
        fs::hard_link(at("in"), at("hard")).unwrap();
        let inputs = Inputs::of([at("in"), at("absent"), folder.path().to_owned()]);
        for name in ["in", "hard", "./in"] {
            assert!(inputs.spare(&at(name)).is_err(), "{name}");
        }
        for name in ["other", "absent", "new"] {
            assert_eq!(inputs.spare(&at(name)), Ok(()), "{name}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("hard", at("soft")).unwrap();
            assert!(inputs.spare(&at("soft")).is_err());
            assert!(inputs.spare(Path::new("/dev/null")).is_ok());
            assert!(Inputs::of(["/dev/null"]).spare(Path::new("/dev/null")).is_ok());
        }
    }
}
