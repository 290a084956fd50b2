//! `reflet new NAME`: a starter scene.

use crate::args::NewArgs;
use crate::exit::{Exit, Failure};
use crate::shell::{line, operand, quoted};
use reflet_film::Target;
use std::ffi::OsStr;
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The scene that is written.
pub const STARTER: &str = include_str!("starter.rhai");

/// Writes the starter scene to a file that is not there yet.
///
/// # Errors
/// A name that is no file's (usage); a file that is there already or cannot be written (output).
pub fn run(args: &NewArgs) -> Result<String, Failure> {
    let path = script_path(&args.name)?;
    write(&path)?;
    let (script, mut picture) = (operand(&path), operand(&path).with_extension("png"));
    // A name that holds a frame number, or almost one, is no name of one picture.
    if !Target::parse(picture.as_os_str(), None, 1).is_ok_and(|target| !target.is_numbered()) {
        picture.set_file_name("picture.png");
    }
    let words = ["reflet".as_ref(), "render".as_ref(), script.as_os_str(), "-o".as_ref()];
    let command = line(&[&words[..], &[picture.as_os_str()]].concat());
    Ok(format!("{} is written; render it with\n  {command}\n", quoted(&path)))
}

fn script_path(name: &Path) -> Result<PathBuf, Failure> {
    let text = name.to_string_lossy();
    if name.file_name().is_none() || text.ends_with(std::path::is_separator) {
        let message =
            format!("`{text}` names no file; write a scene's name, as in `reflet new room`");
        return Err(Failure::new(Exit::Usage, message));
    }
    if name.extension() == Some(OsStr::new("rhai")) {
        return Ok(name.to_path_buf());
    }
    // Not `with_extension`: `scene.v2` becomes `scene.v2.rhai`.
    let mut path = name.as_os_str().to_owned();
    path.push(".rhai");
    Ok(path.into())
}

fn write(path: &Path) -> Result<(), Failure> {
    let failed = |e: std::io::Error| Failure::new(Exit::Output, format!("{}: {e}", path.display()));
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    let mut file = OpenOptions::new().write(true).create_new(true).open(path).map_err(|e| {
        if e.kind() == ErrorKind::AlreadyExists {
            let message = format!("{} is there already; choose another name", path.display());
            return Failure::new(Exit::Output, message);
        }
        failed(e)
    })?;
    let written = file.write_all(STARTER.as_bytes()).and_then(|()| file.sync_all());
    written.map_err(|e| {
        // It is ours, made a moment ago; what it holds is half a scene.
        let _ = fs::remove_file(path);
        failed(e)
    })
}
