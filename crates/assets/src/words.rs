//! The words of a text file, line by line.

use crate::error::Fault;

/// The words of a text, line by line.
pub(crate) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    /// The line that `at` stands in, counted from 1.
    pub line: u64,
}

impl<'a> Words<'a> {
    /// Those of `text`, without the mark that some editors put before it.
    pub fn of(text: &'a [u8]) -> Self {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        Words { text, at: 0, line: 1 }
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.at >= self.text.len()
    }

    /// The rest of this line as one name, without blanks around it.
    pub fn rest(&mut self) -> String {
        let rest = &self.text[self.at..];
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += end;
        String::from_utf8_lossy(&rest[..end]).trim().to_owned()
    }

    /// A number that the `statement` needs; `noun` says what it is one of.
    ///
    /// # Errors
    /// There is none, or it is not finite.
    pub fn number(&mut self, statement: &str, noun: &str) -> Result<f32, Fault> {
        match self.next() {
            Some(word) => number(word, self.line, statement),
            None => {
                let message = format!("{noun} lacks a number; mend the `{statement}` line");
                Err(Fault::line(self.line, message))
            }
        }
    }

    /// The next word of this line.
    pub fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match self.text.get(self.at)? {
                b' ' | b'\t' => self.at += 1,
                b'\\' if self.line_end(self.at + 1) > 0 => {
                    self.at += 1 + self.line_end(self.at + 1);
                    self.line += 1;
                }
                b'\n' | b'\r' => return None,
                b'#' => {
                    self.skip_comment();
                    return None;
                }
                _ => break,
            }
        }
        let start = self.at;
        loop {
            let rest = &self.text[self.at..];
            let stop = rest.iter().position(|byte| *byte <= b' ' || *byte == b'\\');
            self.at += stop.unwrap_or(rest.len());
            match self.text.get(self.at) {
                None | Some(b' ' | b'\t' | b'\n' | b'\r') => break,
                Some(b'\\') if self.line_end(self.at + 1) > 0 => break,
                // Another control character, or a stroke that continues no line.
                Some(_) => self.at += 1,
            }
        }
        Some(&self.text[start..self.at])
    }

    /// Goes to the start of the next line.
    pub fn next_line(&mut self) {
        while self.next().is_some() {
            // Word by word, so that a continued line is skipped whole.
        }
        let end = self.line_end(self.at);
        self.at += end;
        self.line += u64::from(end > 0);
    }

    fn skip_comment(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    }

    /// How many bytes the line's end at `at` has: 0 if there is none.
    fn line_end(&self, at: usize) -> usize {
        match self.text.get(at..) {
            Some([b'\r', b'\n', ..]) => 2,
            Some([b'\n' | b'\r', ..]) => 1,
            _ => 0,
        }
    }
}

/// A finite number.
///
/// # Errors
/// It is none; with the line.
pub(crate) fn number(word: &[u8], line: u64, statement: &str) -> Result<f32, Fault> {
    let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f32>().ok());
    match parsed {
        Some(x) if x.is_finite() => Ok(x),
        Some(_) => Err(Fault::line(
            line,
            format!("{} is not finite, or beyond the range of f32; scale the mesh", shown(word)),
        )),
        None => {
            let message = format!("{} is not a number; mend the `{statement}` line", shown(word));
            Err(Fault::line(line, message))
        }
    }
}

/// A word of the file for a message: short and printable.
pub(crate) fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(40)]);
    let text: String = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    format!("`{text}`")
}
