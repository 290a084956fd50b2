//! `reflet render --watch`: again at each save, whatever went wrong before.

use crate::console::Console;
use crate::exit::{Failure, Watch};
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
    let mut files = BTreeMap::from([(meant.script.path.clone(), None)]);
    loop {
        let begin = SystemTime::now();
        // Looked at before they are read, so that a save during a render is not missed. What an
        // earlier run read stays among them: it may be what this one lacks.
        for (path, seen) in &mut files {
            *seen = look_at(path);
        }
        let mut read = |paths: &[PathBuf]| {
            for path in paths {
                files.entry(path.clone()).or_insert_with(|| first_look(path, begin));
            }
        };
        if let Err(failure) = render::once(meant, console, signals, &mut read) {
            if signals.failure().is_some() {
                // A signal is how this ends.
                console.say(&failure.message);
                return Err(Failure::quiet(failure.exit));
            }
            if failure.watch == Watch::Ends || failure.message.is_empty() {
                return Err(failure);
            }
            console.error(&failure.message);
        }
        console.show(&format!("watching {}; Ctrl-C ends", meant.script.path.display()));
        signals.waiting(|| {
            while files.iter().all(|(path, seen)| look_at(path) == *seen) {
                std::thread::sleep(PAUSE);
            }
            settle(&files);
        });
        console.show("");
    }
}

/// Waits until the files stay as they are.
fn settle(files: &BTreeMap<PathBuf, Look>) {
    let look = || files.keys().map(|path| look_at(path)).collect::<Vec<_>>();
    let mut before = look();
    loop {
        std::thread::sleep(SETTLED);
        let now = look();
        if now == before {
            return;
        }
        before = now;
    }
}

/// The look of a file that the run since `begin` was the first to read: if it was written since, it
/// may be another than the one that was read, and counts as changed.
fn first_look(path: &Path, begin: SystemTime) -> Look {
    look_at(path).filter(|(modified, ..)| modified.is_none_or(|modified| modified <= begin))
}

/// A file as it is: time of its last change, length, and what it holds; `None` if it is not there.
type Look = Option<(Option<SystemTime>, u64, u64)>;

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

        // Read for the first time by a run that began before, and by one that began after.
        let second = Duration::from_secs(1);
        assert_eq!(first_look(&path, time - second), None);
        assert_eq!(first_look(&path, time + second), two);
    }
}
