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
    let plain = |c: char| if c.is_control() && c != '\t' { '\u{fffd}' } else { c };
    let shown: String = place.text.chars().skip(from).take(SHOWN).map(plain).collect();
    let mut before = String::new();
    for c in shown.chars().take(column - from) {
        match c {
            '\t' => before.push('\t'),
            c => before.extend(std::iter::repeat_n(' ', width(c))),
        }
    }
    let gutter = " ".repeat(place.line.to_string().len());
    if place.column >= COLUMNS && place.text.chars().nth(COLUMNS).is_some() {
        return write!(
            f,
            "\n {gutter} = at or beyond column {COLUMNS}, where columns are no longer counted: break the line"
        );
    }
    write!(f, "\n {} | {}\n {gutter} | {before}^", place.line, shown.trim_end())
}

/// The last column that Rhai counts, in 16 bits.
const COLUMNS: usize = 65_535;

/// The columns of a terminal that a character takes: two if it is wide by Unicode's annex 11 (East
/// Asian Width), none if it combines with the one before. Only whole blocks are told apart.
fn width(c: char) -> usize {
    match u32::from(c) {
        0x300..=0x36f | 0x200b..=0x200f | 0x20d0..=0x20ff | 0xfe00..=0xfe0f => 0,
        0x1100..=0x115f
        | 0x2e80..=0xa4cf
        | 0xac00..=0xd7a3
        | 0xf900..=0xfaff
        | 0xfe30..=0xfe6f
        | 0xff00..=0xff60
        | 0xffe0..=0xffe6
        | 0x1f300..=0x1faff
        | 0x20000..=0x3fffd => 2,
        _ => 1,
    }
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
