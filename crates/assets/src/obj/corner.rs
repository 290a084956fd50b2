//! The corners of OBJ faces.

use crate::error::Fault;
use crate::words::shown;

/// A corner of a face: vertex, texture vertex and normal, counted from 0.
pub(crate) type Corner = [u32; 3];

/// For a corner without texture vertex or normal.
pub(crate) const NONE: u32 = u32::MAX;

/// The numbers of a corner `a`, `a/b`, `a//c` or `a/b/c`: not 0, perhaps negative. Numbers after a
/// slash may be missing: many programs write `a/`, `a//` and `a/b/`.
///
/// # Errors
/// It is no corner, or that of vertex 0; with the line.
pub(crate) fn corner_of(word: &[u8], line: u64) -> Result<[Option<i64>; 3], Fault> {
    let mut parts = word.split(|b| *b == b'/');
    let mut all = [None; 3];
    let mut is_whole = true;
    for (slot, number) in all.iter_mut().zip(&mut parts) {
        *slot = integer(number);
        is_whole &= slot.is_some() || number.is_empty();
    }
    if all[0].is_none() || !is_whole || parts.next().is_some() {
        let message =
            format!("{} is no corner of a face; write a, a/b, a//c or a/b/c", shown(word));
        return Err(Fault::line(line, message));
    }
    if all[0] == Some(0) {
        return Err(Fault::line(line, "vertex 0 is asked for; they are counted from 1"));
    }
    Ok(all)
}

/// A decimal integer, held within ±2^40: beyond that there is no vertex anyway.
fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0i64;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = (value * 10 + i64::from(digit - b'0')).min(1 << 40);
    }
    Some(if negative { -value } else { value })
}
