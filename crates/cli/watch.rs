//! `reflet render --watch`: again at each save, whatever went wrong before.

use crate::console::Console;
use crate::exit::Failure;
use crate::meant::Render;
use crate::render;
use crate::signals::Signals;
use reflet_script::Source;
use std::collections::BTreeMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::Hasher;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Between two looks at the files.
const PAUSE: Duration = Duration::from_millis(200);
/// Many editors empty a file and then fill it: what is read must stay so for as long as this.
const SETTLED: Duration = Duration::from_millis(50);
/// Files up to this size are also known by what they hold, where times are coarse.
const HASHED: u64 = 1 << 20;

/// Renders again and again, until a signal ends the process.
///
/// # Errors
/// The script cannot be read at the very start, or nobody listens any more. Everything else is told
/// and waits for the next save.
pub fn run(meant: &Render, console: &Console, signals: &Signals) -> Result<(), Failure> {
    Source::read(&meant.script.path)?;
    let mut inputs = vec![meant.script.path.clone()];
    loop {
        let before = look(&inputs);
        let known = inputs.clone();
        if let Err(failure) = render::once(meant, console, signals, &mut inputs) {
            if failure.message.is_empty() || signals.failure().is_some() {
                return Err(failure);
            }
            console.error(&failure.message);
        }
        // A file that only this run named counts from now on, the others from before the run, so
        // that a save during a render is not missed.
        let mut seen = look(&inputs);
        seen.extend(before);
        // What an earlier run read stays watched: it may be what this one lacked.
        inputs.extend(known.into_iter().filter(|path| !inputs.contains(path)).collect::<Vec<_>>());
        console.show(&format!("watching {}; Ctrl-C ends", meant.script.path.display()));
        while look(&inputs) == seen {
            std::thread::sleep(PAUSE);
        }
        let mut now = look(&inputs);
        loop {
            std::thread::sleep(SETTLED);
            let later = look(&inputs);
            if later == now {
                break;
            }
            now = later;
        }
        console.show("");
    }
}

/// A file as it is: time of its last change, length, and what it holds; `None` if it is not there.
type Look = Option<(Option<SystemTime>, u64, u64)>;

fn look(files: &[PathBuf]) -> BTreeMap<PathBuf, Look> {
    files.iter().map(|path| (path.clone(), look_at(path))).collect()
}

fn look_at(path: &Path) -> Look {
    let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    let mut hash = DefaultHasher::new();
    if about.len() <= HASHED {
        hash.write(&std::fs::read(path).ok()?);
    }
    Some((about.modified().ok(), about.len(), hash.finish()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_save_is_seen_even_within_a_tick_of_the_clock() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.rhai");
        assert_eq!(look_at(&path), None);
        assert_eq!(look_at(dir.path()), None);
        std::fs::write(&path, "one").unwrap();
        let one = look_at(&path);
        let time = std::fs::metadata(&path).unwrap().modified().unwrap();
        std::fs::write(&path, "two").unwrap();
        std::fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        let two = look_at(&path);
        assert_ne!(one, two);
        assert_eq!(one.unwrap().0, two.unwrap().0);
    }
}
