//! What is wrong with a script, for the person who wrote it.

use crate::messages;
use rhai::Position;
use std::path::Path;

/// Who has to mend it, which decides the program's exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The script is wrong (exit 65).
    Script,
    /// A value given by `--set` is wrong (exit 2).
    Set,
    /// A file that the script reads is missing or bad, or the script itself cannot be read (exit 66).
    Input,
    /// The system gives no thread to run the script on (exit 1).
    System,
}

/// A place in the script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Counted from 1.
    pub line: usize,
    /// In characters, counted from 1.
    pub column: usize,
    /// The text of the line.
    pub text: String,
}

/// A second place, for example where a function was called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// What happened there, for example ``called from here, in `flake` ``.
    pub message: String,
    /// Where.
    pub place: Place,
}

/// What is wrong with a script, with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScriptError {
    /// Who has to mend it.
    pub kind: ErrorKind,
    /// What is wrong, what was expected, and the nearest known name; one line.
    pub message: String,
    /// The script's path, as it was given.
    pub path: Box<Path>,
    /// Where it is wrong, if it is in one place.
    pub place: Option<Place>,
    /// More places, from the inside out.
    pub notes: Vec<Note>,
    /// The frame in which it happened.
    pub frame: Option<u32>,
}

impl std::fmt::Display for ScriptError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let path = self.path.to_string_lossy().replace(char::is_control, "\u{fffd}");
        let frame = self.frame.map(|k| format!(" (in frame {k})")).unwrap_or_default();
        match &self.place {
            None => write!(f, "{path}: {}{frame}", self.message)?,
            Some(place) => {
                write!(f, "{path}:{}:{}: {}{frame}", place.line, place.column, self.message)?;
                mark(f, place)?;
            }
        }
        for note in &self.notes {
            write!(f, "\n{path}:{}:{}: {}", note.place.line, note.place.column, note.message)?;
            mark(f, &note.place)?;
        }
        Ok(())
    }
}

impl std::error::Error for ScriptError {}

/// Characters of a source line that are shown at most.
const SHOWN: usize = 120;

/// The source line with a marker below the column.
fn mark(f: &mut std::fmt::Formatter<'_>, place: &Place) -> std::fmt::Result {
    let column = place.column.max(1) - 1;
    // A very long line is shown around its column only.
    let from = if column < SHOWN { 0 } else { column - SHOWN / 2 };
    let shown: String = place.text.chars().skip(from).take(SHOWN).collect();
    let before: String =
        shown.chars().take(column - from).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
    let gutter = " ".repeat(place.line.to_string().len());
    write!(f, "\n {} | {}\n {gutter} | {before}^", place.line, shown.trim_end())
}

/// A position with the text of its line.
pub(crate) fn place(text: &str, at: Position) -> Option<Place> {
    let line = at.line()?;
    let text = text.lines().nth(line - 1).unwrap_or("").to_owned();
    let mut column = at.position().unwrap_or(1).max(1);
    // Rhai points at the dot for some properties and at the name for others.
    let mut from = text.chars().skip(column - 1);
    if from.next() == Some('.') && from.next().is_some_and(char::is_alphabetic) {
        column += 1;
    }
    Some(Place { line, column, text: messages::source_line(&text) })
}
