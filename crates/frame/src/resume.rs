//! All policy of taking up again: which files stand, and which are made anew.
//!
//! A file stands if it is whole, bit for bit as it was written, and says that it was made from what
//! it would be made from now. Neither its age nor its name counts.

use crate::provenance::Provenance;
use reflet_film::{Target, Unsealed, manifest_path, read_sealed, stray_files};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// What a job does with files that stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Resume {
    /// It makes them anew.
    #[default]
    Never,
    /// It keeps them.
    Keep,
}

/// How a frame's file is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It is what a render would make now.
    Stands,
    /// There is none.
    Missing,
    /// It was made from something else, or is not as it was written; in which way.
    Stale(String),
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Standing::Stands => f.write_str("up to date"),
            Standing::Missing => f.write_str("missing"),
            Standing::Stale(why) => f.write_str(why),
        }
    }
}

/// How the file at `path` is found, which would now be made from `wanted`.
pub fn standing(path: &Path, wanted: &Provenance) -> Standing {
    match told(path) {
        Ok(texts) => wanted.differs(&texts).map_or(Standing::Stands, Standing::Stale),
        Err(standing) => standing,
    }
}

/// What the file at `path` says that it was made from, if it is whole.
pub(crate) fn told(path: &Path) -> Result<Vec<(String, String)>, Standing> {
    read_sealed(path).map_err(|error| match error {
        Unsealed::Missing => Standing::Missing,
        error => Standing::Stale(error.to_string()),
    })
}

/// Removes what killed processes left of the files of `frames`, and tells what it was. What a living
/// process is at work on stays, and so do files of other names: on file systems without locks they
/// may be another machine's.
///
/// # Errors
/// A folder cannot be listed, or a file not removed; with the path.
pub fn sweep(target: &Target, frames: &[u32]) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
    if target.is_stdout() {
        return Ok(Vec::new());
    }
    let mut folders = BTreeSet::new();
    let mut names: BTreeSet<OsString> = BTreeSet::new();
    for frame in frames {
        let path = target.path_for(*frame);
        // A link's file is made where the link leads.
        let path = path.canonicalize().unwrap_or(path);
        for path in [manifest_path(&path), path] {
            names.extend(path.file_name().map(ToOwned::to_owned));
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            folders.insert(folder.unwrap_or(Path::new(".")).to_owned());
        }
    }
    let mut swept = Vec::new();
    for folder in folders.into_iter().filter(|folder| folder.is_dir()) {
        for stray in stray_files(&folder).map_err(|error| (folder.clone(), error))? {
            let whole = names.contains(std::ffi::OsStr::new(&stray.name));
            let ours = whole || names.iter().any(|name| stray.was_to_be(name));
            if ours && stray.remove_orphan().map_err(|error| (stray.path.clone(), error))? {
                swept.push(stray.path);
            }
        }
    }
    Ok(swept)
}

/// Frames as `--frames` takes them: `0-4,7,10-20:2`. They must ascend.
pub fn ranges(frames: &[u32]) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut rest = frames;
    while let [first, tail @ ..] = rest {
        let step = tail.first().map_or(1, |next| next - first);
        let steady = rest.windows(2).take_while(|pair| pair[1] - pair[0] == step).count() + 1;
        // Two frames that do not follow one another are no range.
        let length = if steady == 2 && step > 1 { 1 } else { steady };
        let last = rest[length - 1];
        parts.push(match (length, step) {
            (1, _) => first.to_string(),
            (_, 1) => format!("{first}-{last}"),
            _ => format!("{first}-{last}:{step}"),
        });
        rest = &rest[length..];
    }
    parts.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_as_ranges() {
        for (frames, text) in [
            (&[][..], ""),
            (&[7], "7"),
            (&[0, 1, 2, 3], "0-3"),
            (&[0, 2], "0,2"),
            (&[0, 2, 4], "0-4:2"),
            (&[0, 1, 5, 8, 11, 12, 13], "0-1,5-11:3,12-13"),
            (&[3, 4, 9], "3-4,9"),
        ] {
            assert_eq!(ranges(frames), text, "{frames:?}");
        }
    }
}
