//! The frame number in the name of a file: `####`, `%d` or `%04d`.

/// A place for the frame number: the bytes of the name that it takes, and its least digits.
pub struct Slot {
    /// Where it begins.
    pub start: usize,
    /// Where it ends.
    pub end: usize,
    /// The least digits.
    pub digits: usize,
}

/// The most digits that a name may ask for.
pub const MOST_DIGITS: usize = 100;

/// Why a name's frame number cannot be told.
pub enum SlotError {
    /// What looks like one and is none.
    Almost(String),
    /// It has more than [`MOST_DIGITS`].
    TooManyDigits,
}

/// The runs of `#` and the `%d`, `%04d` in a file name. Whatever else another program would take
/// for a number is an error, so that no file is called `f%4d.png`.
pub fn slots(name: &str) -> Result<Vec<Slot>, SlotError> {
    let mut slots = Vec::new();
    let mut at = 0;
    while let Some(found) = name[at..].find(['#', '%']) {
        let start = at + found;
        let rest = &name[start..];
        let (len, digits) = if rest.starts_with('#') {
            let run = rest.len() - rest.trim_start_matches('#').len();
            (run, run)
        } else {
            match percent(&rest[1..]) {
                Percent::Literal => {
                    at = start + 1;
                    continue;
                }
                Percent::Almost(len) => {
                    return Err(SlotError::Almost(rest[..1 + len].to_owned()));
                }
                Percent::Number { len, digits } => (1 + len, digits),
            }
        };
        if digits > MOST_DIGITS {
            return Err(SlotError::TooManyDigits);
        }
        at = start + len;
        slots.push(Slot { start, end: at, digits });
    }
    Ok(slots)
}

/// What a `%` is; lengths are those of what follows it.
enum Percent {
    /// A part of the name.
    Literal,
    /// A frame number.
    Number { len: usize, digits: usize },
    /// A conversion of `printf` that pads in another way, or converts something else.
    Almost(usize),
}

/// What a `%` is, by what follows it.
fn percent(rest: &str) -> Percent {
    let width = rest.bytes().take_while(u8::is_ascii_digit).count();
    match rest[width..].chars().next() {
        // `%4d` pads with blanks, so only `%d` and `%0Nd` count.
        Some('d') if width == 0 || rest.starts_with('0') => {
            // A number too long to be read is too long for a name, too.
            let digits = if width == 0 { 1 } else { rest[..width].parse().unwrap_or(usize::MAX) };
            return Percent::Number { len: width + 1, digits };
        }
        Some(c) if c.is_ascii_alphabetic() => return Percent::Almost(width + 1),
        Some(c @ ('%' | '#')) if width == 0 => return Percent::Almost(c.len_utf8()),
        _ => {}
    }
    // Flags and a precision; `%-dark` and `%.png` are none, for a word goes on.
    let flags = rest.trim_start_matches(|c: char| "-+ '0".contains(c));
    let digits = flags.trim_start_matches(|c: char| c == '.' || c.is_ascii_digit());
    let mut after = digits.chars();
    let converts = after.next().is_some_and(|c| "diuoxX".contains(c));
    let word = after.next().is_some_and(char::is_alphanumeric);
    let len = rest.len() - digits.len();
    if len > 0 && converts && !word { Percent::Almost(len + 1) } else { Percent::Literal }
}
