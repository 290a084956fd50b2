//! SIGINT, SIGTERM and SIGUSR1 (a scheduler's warning): the first ends a render after its tile, a
//! second one at once.

use crate::console::Console;
use crate::exit::{Exit, Failure};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What came in so far.
#[derive(Clone, Default)]
pub struct Signals(Arc<Inner>);

#[derive(Default)]
struct Inner {
    /// Told to a render.
    cancel: AtomicBool,
    /// Whether there is a render that can be told; without one a signal ends the process.
    rendering: AtomicBool,
    /// Whether files are waited for: then a signal is the usual way to end.
    waiting: AtomicBool,
    /// The exit code of the signal that came, 0 if none did.
    exit: AtomicU8,
    /// Where the render's unfinished files stand.
    folder: Mutex<Option<PathBuf>>,
    /// How the render that runs is gone on with, for a message.
    how: Mutex<&'static str>,
}

/// So long may a render take to notice a signal: a tile, and the file that is being written. A
/// script that never ends does not notice at all.
const PATIENCE: Duration = Duration::from_millis(1500);

impl Signals {
    /// Listens from now on.
    ///
    /// # Errors
    /// The system gives no thread to listen on.
    pub fn listen(console: &Console) -> Result<Self, Failure> {
        let signals = Self::default();
        signals
            .spawn(console)
            .map_err(|e| Failure::new(Exit::Failed, format!("cannot start a thread: {e}")))?;
        Ok(signals)
    }

    #[cfg(unix)]
    fn spawn(&self, console: &Console) -> io::Result<()> {
        use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1, SIGXFSZ};
        // With a handler a file that may not grow is an error of the write, and not the end.
        let noted = Arc::new(AtomicBool::new(false));
        if let Err(error) = signal_hook::flag::register(SIGXFSZ, noted) {
            console.warn(&format!("cannot listen to signals: {error}"));
        }
        let mut incoming = match signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGUSR1]) {
            Ok(incoming) => incoming,
            Err(error) => {
                console.warn(&format!("cannot listen to signals: {error}"));
                return Ok(());
            }
        };
        let (signals, console) = (self.clone(), console.clone());
        let listen = move || {
            for signal in incoming.forever() {
                let exit = match signal {
                    SIGINT => Exit::Interrupted,
                    SIGUSR1 => Exit::Resumable,
                    _ => Exit::Terminated,
                };
                if !signals.came(exit) {
                    signals.end(exit, &console);
                }
                let (late, of) = (signals.clone(), console.clone());
                let wait = move || {
                    std::thread::sleep(PATIENCE);
                    late.end(exit, &of);
                };
                if std::thread::Builder::new().spawn(wait).is_err() {
                    signals.end(exit, &console);
                }
            }
        };
        std::thread::Builder::new().name("signals".into()).spawn(listen).map(|_| ())
    }

    /// Ends the process now. Files that are not whole yet are removed.
    #[cfg(unix)]
    fn end(&self, exit: Exit, console: &Console) -> ! {
        console.show("");
        if self.0.waiting.load(Ordering::SeqCst) {
            console.say("no longer watching");
        } else {
            let how = *self.0.how.lock().unwrap_or_else(PoisonError::into_inner);
            console.error(&format!("stopped at once{how}"));
        }
        let folder = self.0.folder.lock().unwrap_or_else(PoisonError::into_inner);
        let strays = folder.as_deref().and_then(|f| reflet_film::stray_files(f).ok());
        for stray in strays.into_iter().flatten() {
            if stray.is_ours() {
                let _ = std::fs::remove_file(stray.path);
            }
        }
        std::process::exit(i32::from(exit as u8));
    }

    /// Elsewhere the system's own way of ending a process stays.
    #[cfg(not(unix))]
    fn spawn(&self, _: &Console) -> io::Result<()> {
        Ok(())
    }

    /// Takes note of a signal; `false` if the process is to end at once.
    fn came(&self, exit: Exit) -> bool {
        self.0.exit.store(exit as u8, Ordering::SeqCst);
        let told = self.0.cancel.swap(true, Ordering::SeqCst);
        !told && self.0.rendering.load(Ordering::SeqCst)
    }

    /// Runs a render into `file`, which a signal then ends through the flag that it is given.
    /// `how` says how to go on with it later.
    pub fn rendering<R>(
        &self,
        file: &Path,
        how: &'static str,
        render: impl FnOnce(&AtomicBool) -> R,
    ) -> R {
        *self.0.how.lock().unwrap_or_else(PoisonError::into_inner) = how;
        // A link's file is made where the link leads.
        let place = file.canonicalize().unwrap_or_else(|_| file.to_path_buf());
        let folder = place.parent().filter(|f| !f.as_os_str().is_empty());
        *self.0.folder.lock().unwrap_or_else(PoisonError::into_inner) =
            Some(folder.unwrap_or(Path::new(".")).to_path_buf());
        self.0.rendering.store(true, Ordering::SeqCst);
        let result = render(&self.0.cancel);
        self.0.rendering.store(false, Ordering::SeqCst);
        result
    }

    /// Waits for files; a signal that comes meanwhile ends the process without an error.
    pub fn waiting(&self, wait: impl FnOnce()) {
        self.0.waiting.store(true, Ordering::SeqCst);
        wait();
        self.0.waiting.store(false, Ordering::SeqCst);
    }

    /// Ends a running render from within, because nobody reads what it tells.
    pub fn cancel(&self) {
        self.0.cancel.store(true, Ordering::SeqCst);
    }

    /// The failure that a signal is, if one came.
    pub fn failure(&self) -> Option<Failure> {
        match self.0.exit.load(Ordering::SeqCst) {
            0 => None,
            code if code == Exit::Terminated as u8 => Some(Failure::quiet(Exit::Terminated)),
            code if code == Exit::Resumable as u8 => Some(Failure::quiet(Exit::Resumable)),
            _ => Some(Failure::quiet(Exit::Interrupted)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_is_told_and_the_second_ends() {
        let signals = Signals::default();
        assert_eq!(signals.failure(), None);
        let second = signals.rendering(Path::new("x.png"), "", |cancel| {
            assert!(signals.came(Exit::Terminated));
            assert!(cancel.load(Ordering::SeqCst));
            signals.came(Exit::Interrupted)
        });
        assert!(!second);
        assert_eq!(signals.failure(), Some(Failure::quiet(Exit::Interrupted)));
    }

    #[test]
    fn without_a_render_the_first_ends() {
        assert!(!Signals::default().came(Exit::Interrupted));
    }
}
