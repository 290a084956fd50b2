//! What a script says: shown as text, and bounded.

use crate::engine::Printer;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The most bytes that `print` and `debug` may write in all.
const MOST: usize = 1 << 20;
/// What a line is counted for beside its text: the script's path and the number.
const LINE: usize = 64;
/// The longest error message that is told whole.
const LONGEST: usize = 4000;

/// Whether a character moves the cursor, the colours or the direction of writing.
fn steers(c: char) -> bool {
    c != '\t' && c.is_control()
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// `text` with control characters as escapes, so that no string of a script can forge a line or
/// steer a terminal.
pub(crate) fn printable(text: &str) -> String {
    if !text.contains(steers) {
        return text.to_owned();
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if steers(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

/// A source line as it can be shown: a character in the place of each.
pub(crate) fn source_line(text: &str) -> String {
    text.chars().map(|c| if steers(c) { '\u{fffd}' } else { c }).collect()
}

/// The first bytes of `text`, at most `most`, up to the end of a character.
fn head(text: &str, most: usize) -> &str {
    let mut end = most.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

/// An error message, printable, and cut if it is very long.
pub(crate) fn message(text: &str) -> String {
    if text.len() <= LONGEST {
        return printable(text);
    }
    format!("{}... ({} bytes in all)", printable(head(text, LONGEST)), text.len())
}

/// A printer that escapes what it is given and ends with one line once it was given too much.
pub(crate) fn bounded(print: Printer) -> Printer {
    let said = AtomicUsize::new(0);
    Arc::new(move |text, line| {
        let before = said.load(Relaxed);
        if before > MOST {
            return;
        }
        let room = MOST - before;
        let shown = printable(head(text, room));
        let takes = shown.len() + LINE;
        said.store(before + takes, Relaxed);
        if takes <= room {
            print(&shown, line);
        } else {
            said.store(MOST + 1, Relaxed);
            print("(what is printed from here on is left out: it is more than 1 MiB)", line);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn nothing_steers_the_terminal() {
        assert_eq!(printable("a\tb äß"), "a\tb äß");
        assert_eq!(printable("x\nerror: y\u{1b}[2J"), "x\\nerror: y\\u{1b}[2J");
        assert_eq!(printable("\u{202e}x\u{9b}"), "\\u{202e}x\\u{9b}");
        assert_eq!(source_line("a\u{1b}b"), "a\u{fffd}b");
        let long = message(&"ä".repeat(8_000_000));
        assert!(long.len() < 4100 && long.ends_with("(16000000 bytes in all)"), "{}", long.len());
    }

    #[test]
    fn a_flood_ends_with_one_line() {
        let got: Arc<Mutex<Vec<(String, usize)>>> = Arc::default();
        let into = got.clone();
        let print =
            bounded(Arc::new(move |text, line| into.lock().unwrap().push((text.to_owned(), line))));
        for line in 0..100 {
            print(&"\u{1b}".repeat(20_000), line);
        }
        let got = got.lock().unwrap();
        let bytes: usize = got.iter().map(|(text, _)| text.len()).sum();
        assert!(bytes < 1 << 20, "{bytes}");
        assert!(got.last().unwrap().0.starts_with("(what is printed from here on"));
        assert_eq!(got.iter().filter(|(text, _)| text.starts_with('(')).count(), 1);
    }
}
