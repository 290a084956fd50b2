//! Stderr for people: lines, and one line below them that keeps changing.
//!
//! Cloned consoles are one console, so that a script's `print`, a warning and the progress bar do
//! not write into each other from several threads.

use crate::exit::Failure;
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// The console: stderr.
#[derive(Clone)]
pub struct Console {
    /// Whether a line may be rewritten.
    terminal: bool,
    /// Whether colours are welcome.
    colours: bool,
    /// The changing line as it stands, empty if there is none.
    below: Arc<Mutex<String>>,
}

impl Console {
    /// The process's stderr; colours only on a terminal, and not if `NO_COLOR` is set and not
    /// empty (<https://no-color.org>).
    pub fn new() -> Self {
        let set = |name| std::env::var_os(name).is_some_and(|v| !v.is_empty());
        let dumb = std::env::var_os("TERM").is_some_and(|v| v == "dumb");
        let terminal = std::io::stderr().is_terminal() && !dumb;
        Self { terminal, colours: terminal && !set("NO_COLOR"), below: Arc::default() }
    }

    /// Writes a line, or several.
    pub fn say(&self, text: &str) {
        let below = self.below.lock().unwrap_or_else(PoisonError::into_inner);
        let clear = if below.is_empty() { "" } else { "\r\x1b[K" };
        // There is nobody to tell when stderr is closed.
        let _ = std::io::stderr().write_all(format!("{clear}{text}\n{below}").as_bytes());
    }

    /// Writes a warning.
    pub fn warn(&self, text: &str) {
        self.say(&format!("{} {text}", self.coloured("warning:", "33")));
    }

    /// Writes an error.
    pub fn error(&self, text: &str) {
        self.say(&format!("{} {text}", self.coloured("error:", "31")));
    }

    /// Replaces the changing line; an empty one takes it away. Nothing off a terminal.
    pub fn show(&self, line: &str) {
        if !self.terminal {
            return;
        }
        let mut below = self.below.lock().unwrap_or_else(PoisonError::into_inner);
        if *below != line {
            below.clear();
            below.push_str(line);
            let _ = std::io::stderr().write_all(format!("\r\x1b[K{line}").as_bytes());
        }
    }

    /// `text` in the colour of an ANSI code, if colours are welcome.
    pub fn coloured(&self, text: &str, code: &str) -> String {
        if self.colours { format!("\x1b[1;{code}m{text}\x1b[0m") } else { text.into() }
    }
}

/// Writes to stdout.
///
/// # Errors
/// Stdout cannot be written; a reader that has left is told to nobody.
pub fn print(text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_ref()).and_then(|()| out.flush()).map_err(|e| Failure::printing(&e))
}
