//! The words of a text file, line by line, and its numbers.

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
    /// There is none.
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

/// A number; NaN for what says that it is no finite one.
///
/// # Errors
/// It is none, or beyond the range of `f32`; with the line.
pub(crate) fn number(word: &[u8], line: u64, statement: &str) -> Result<f32, Fault> {
    if let Some(x) = plain(word) {
        return Ok(x);
    }
    if is_not_finite(word) {
        return Ok(f32::NAN);
    }
    match std::str::from_utf8(word).ok().and_then(|w| w.parse::<f32>().ok()) {
        Some(x) if x.is_finite() => Ok(x),
        Some(_) => {
            let message = format!("{} is beyond the range of f32; scale the mesh", shown(word));
            Err(Fault::line(line, message))
        }
        None => {
            let comma = if is_with_comma(word) { " (decimals follow a point)" } else { "" };
            let message =
                format!("{} is not a number{comma}; mend the `{statement}` line", shown(word));
            Err(Fault::line(line, message))
        }
    }
}

/// Whether a word is one of those that C libraries write for NaN and the infinities: `nan`,
/// `-nan(ind)`, `inf`, `1.#QNAN`.
pub(crate) fn is_not_finite(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").or_else(|| word.strip_prefix(b"+")).unwrap_or(word);
    let is = |wanted: &[u8]| word.eq_ignore_ascii_case(wanted);
    let begins = |wanted: &[u8]| {
        word.get(..wanted.len()).is_some_and(|start| start.eq_ignore_ascii_case(wanted))
    };
    is(b"nan") || is(b"inf") || is(b"infinity") || begins(b"nan(") || begins(b"1.#")
}

/// Whether a word is a number whose decimals follow a comma.
fn is_with_comma(word: &[u8]) -> bool {
    let text = String::from_utf8_lossy(word).replacen(',', ".", 1);
    word.contains(&b',') && text.parse::<f32>().is_ok()
}

/// Powers of ten that are exact in `f64`.
const TENS: [f64; 16] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// The nearest `f32` of a number as most files have them: a few digits and a point. `None`: it takes
/// a closer look, or is no number.
///
/// Up to 15 digits and their power of ten are exact in `f64`, so their quotient is rounded once
/// (Clinger, "How to Read Floating Point Numbers Accurately", PLDI 1990). Rounding it once more, to
/// `f32`, is right unless it lies within its own error of the middle between two of those.
fn plain(word: &[u8]) -> Option<f32> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, word),
    };
    let (mut whole, mut count, mut after) = (0_u64, 0, None);
    for (at, byte) in digits.iter().enumerate() {
        match byte {
            b'0'..=b'9' => {
                whole = whole * 10 + u64::from(byte - b'0');
                count += 1;
                if count > 15 {
                    return None;
                }
            }
            b'.' if after.is_none() => after = Some(digits.len() - at - 1),
            _ => return None,
        }
    }
    if count == 0 {
        return None;
    }
    let value = whole as f64 / TENS[after.unwrap_or(0)];
    // Of the 29 bits that are lost.
    let lost = value.to_bits() & ((1 << 29) - 1);
    let middle = 1 << 28;
    let near = (middle - 1..=middle + 1).contains(&lost);
    (!near).then_some(if negative { -value as f32 } else { value as f32 })
}

/// A word of the file for a message: short and printable.
pub(crate) fn shown(word: &[u8]) -> String {
    let end = word.len().min(40);
    // A letter that is cut in two at the end is none.
    let text = match std::str::from_utf8(&word[..end]) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&word[..error.valid_up_to()]).unwrap_or_default()
        }
        Err(_) => return "what is no text".to_owned(),
    };
    if text.chars().any(char::is_control) {
        return "what is no text".to_owned();
    }
    format!("`{text}`")
}

#[cfg(test)]
mod tests {
    use super::plain;
    use proptest::prelude::*;

    #[test]
    fn words_that_are_no_plain_numbers_are_left() {
        for word in
            ["", "-", ".", "-.", "+1", "1e5", "1.2.3", "nan", "1 ", "0x1", "1234567890123456"]
        {
            assert_eq!(plain(word.as_bytes()), None, "{word}");
        }
        // The middle between two numbers, and the least above it that is told apart.
        assert_eq!(plain(b"16777217"), None);
        assert_eq!(plain(b"16777217.0001"), Some(16_777_218.0));
        assert_eq!(plain(b"-0").map(f32::to_bits), Some((-0.0_f32).to_bits()));
        assert_eq!(plain(b"5."), Some(5.0));
        assert_eq!(plain(b".5"), Some(0.5));
    }

    proptest! {
        #[test]
        fn plain_numbers_are_those_of_the_standard_library(
            whole in 0_u64..1_000_000_000_000_000, point in 0..15_usize, negative: bool,
        ) {
            let mut word = whole.to_string();
            if point < word.len() {
                word.insert(point, '.');
            }
            let word = if negative { format!("-{word}") } else { word };
            if let Some(value) = plain(word.as_bytes()) {
                prop_assert_eq!(value.to_bits(), word.parse::<f32>().unwrap().to_bits());
            }
        }

        /// Numbers around the middle between two, where rounding twice could err.
        #[test]
        fn so_are_those_near_a_middle(bits in 0x3a00_0000_u32..0x4b00_0000, digits in 0..9_usize) {
            let below = f64::from(f32::from_bits(bits));
            let above = f64::from(f32::from_bits(bits + 1));
            let word = format!("{:.*}", digits, (below + above) / 2.0);
            if let Some(value) = plain(word.as_bytes()) {
                prop_assert_eq!(value.to_bits(), word.parse::<f32>().unwrap().to_bits(), "{}", word);
            }
        }
    }
}
