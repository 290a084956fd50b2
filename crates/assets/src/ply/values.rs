//! The numbers of a PLY file.

use super::head::{Encoding, Number, Property};
use crate::error::Fault;
use crate::words::shown;

/// The numbers after the head.
pub(crate) struct Values<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub line: u64,
    pub encoding: Encoding,
}

impl Values<'_> {
    /// At a byte, or in a text in the line that is being read.
    pub fn fault(&self, at: usize, message: impl Into<String>) -> Fault {
        match self.encoding {
            Encoding::Ascii => Fault::line(self.line, message),
            _ => Fault::byte(at, message),
        }
    }

    /// The next number.
    ///
    /// # Errors
    /// The file ends, or what follows is none.
    #[inline]
    pub fn next(&mut self, number: Number) -> Result<f64, Fault> {
        if self.encoding == Encoding::Ascii {
            return self.word();
        }
        let width = number.bytes();
        let Some(found) = self.bytes.get(self.at..self.at + width) else {
            return Err(self.fault(self.at, "the file ends too early"));
        };
        self.at += width;
        let mut raw = [0; 8];
        raw[..width].copy_from_slice(found);
        if self.encoding == Encoding::Big {
            raw[..width].reverse();
        }
        let [a, b, c, d, ..] = raw;
        Ok(match number {
            Number::I8 => f64::from(a as i8),
            Number::U8 => f64::from(a),
            Number::I16 => f64::from(i16::from_le_bytes([a, b])),
            Number::U16 => f64::from(u16::from_le_bytes([a, b])),
            Number::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Number::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Number::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Number::F64 => f64::from_le_bytes(raw),
        })
    }

    fn word(&mut self) -> Result<f64, Fault> {
        while let Some(byte) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            let end =
                *byte == b'\n' || *byte == b'\r' && self.bytes.get(self.at + 1) != Some(&b'\n');
            self.line += u64::from(end);
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(self.fault(self.at, "the file ends too early"));
        }
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = &rest[..end];
        let text = std::str::from_utf8(word).ok();
        let parsed = match crate::words::is_not_finite(word) {
            true => Some(f64::NAN),
            false => text.and_then(|word| word.parse().ok()),
        };
        let value = parsed
            .ok_or_else(|| self.fault(self.at, format!("{} is not a number", shown(word))))?;
        self.at += end;
        Ok(value)
    }

    /// The length of a list, which the rest of the file must be able to hold.
    ///
    /// # Errors
    /// It is not.
    pub fn length(&mut self, number: Number) -> Result<usize, Fault> {
        let at = self.at;
        let length = self.next(number)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= self.bytes.len() as f64 {
            Ok(length as usize)
        } else {
            Err(self.fault(at, format!("a list cannot have the length {length}")))
        }
    }

    /// Passes over a property.
    ///
    /// # Errors
    /// As those of [`Self::next`].
    pub fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count = property.length.map_or(Ok(1), |length| self.length(length))?;
        for _ in 0..count {
            self.next(property.number)?;
        }
        Ok(())
    }
}
