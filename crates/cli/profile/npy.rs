//! NumPy's array files: two-dimensional arrays read, rows of hits written.
//!
//! Source: "A simple file format for NumPy arrays", NEP 1; versions 1.0 to 3.0 of `numpy.lib.format`.

use crate::exit::{Exit, Failure};
use std::fs;
use std::path::Path;

const MAGIC: &[u8] = b"\x93NUMPY";

/// A kind of number that an array is read as and written of: four bytes in little-endian order.
pub trait Number: Copy {
    /// Its name in the header, without the order of bytes.
    const NAME: &'static str;
    /// The types that it is read from.
    const FROM: &'static str;
    /// The number nearest to what a file holds.
    fn of(value: Value) -> Result<Self, String>;
    /// Its four bytes.
    fn bytes(self) -> [u8; 4];
}

/// A number as a file holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// 32 or 64 bits.
    Float(f64),
    /// 8 to 64 bits, with a sign or without.
    Whole(i128),
}

impl Number for f32 {
    const NAME: &'static str = "f4";
    const FROM: &'static str = "float32, float64 or whole numbers";
    fn of(value: Value) -> Result<f32, String> {
        match value {
            Value::Float(x) if x.is_finite() && (x as f32).is_infinite() => {
                Err(format!("{x:e} is too great for 32 bits"))
            }
            Value::Float(x) => Ok(x as f32),
            Value::Whole(n) => Ok(n as f32),
        }
    }
    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

impl Number for u32 {
    const NAME: &'static str = "u4";
    const FROM: &'static str = "whole numbers";
    fn of(value: Value) -> Result<u32, String> {
        match value {
            Value::Whole(n) => n.try_into().map_err(|_| format!("{n} is no index")),
            Value::Float(x) => Err(format!("{x} is no whole number")),
        }
    }
    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

/// How numbers stand in a file: `<f4`, `>i8`, `|u1`.
#[derive(Clone, Copy)]
struct Stored {
    /// `f`, `i` or `u`.
    kind: u8,
    /// Bytes of each.
    size: usize,
    big_endian: bool,
}

impl Stored {
    fn named(descr: &str) -> Option<Stored> {
        let text = descr.trim_matches(['\'', '"']);
        let (order, rest) = match text.as_bytes().first()? {
            b'<' | b'>' | b'|' | b'=' => text.split_at(1),
            _ => ("<", text),
        };
        let (kind, size) = match rest {
            "f4" => (b'f', 4),
            "f8" => (b'f', 8),
            "i1" => (b'i', 1),
            "i2" => (b'i', 2),
            "i4" => (b'i', 4),
            "i8" => (b'i', 8),
            "u1" => (b'u', 1),
            "u2" => (b'u', 2),
            "u4" => (b'u', 4),
            "u8" => (b'u', 8),
            _ => return None,
        };
        Some(Stored { kind, size, big_endian: order == ">" })
    }

    fn value(self, stored: &[u8]) -> Value {
        // As the low bytes of a little-endian number.
        let mut low = [0; 8];
        for (to, from) in low.iter_mut().zip(stored) {
            *to = *from;
        }
        if self.big_endian {
            low[..self.size].reverse();
        }
        let bits = u64::from_le_bytes(low);
        let unused = 64 - 8 * self.size as u32;
        match self.kind {
            b'f' if self.size == 4 => Value::Float(f32::from_bits(bits as u32).into()),
            b'f' => Value::Float(f64::from_bits(bits)),
            b'i' => Value::Whole((((bits << unused) as i64) >> unused).into()),
            _ => Value::Whole(bits.into()),
        }
    }
}

/// The rows of an array of the shape (n, `WIDTH`), converted where nothing is lost but precision.
///
/// # Errors
/// An input's: the file is missing, is no such array, or is cut short.
pub fn read<T: Number, const WIDTH: usize>(path: &Path) -> Result<Vec<[T; WIDTH]>, Failure> {
    let bytes = fs::read(path).map_err(|e| fault(path, &e.to_string()))?;
    rows(&bytes).map_err(|what| fault(path, &what))
}

/// What is wrong with a file.
pub fn fault(path: &Path, what: &str) -> Failure {
    Failure::new(Exit::Input, format!("{}: {what}", path.display()))
}

fn rows<T: Number, const WIDTH: usize>(bytes: &[u8]) -> Result<Vec<[T; WIDTH]>, String> {
    let (header, data) = split(bytes)?;
    let wanted = format!("an array of shape (n, {WIDTH}) and of {} is wanted", T::FROM);
    let descr = value(header, "descr").ok_or("the header has no `descr`")?;
    let stored = Stored::named(descr).filter(|s| T::NAME != u32::NAME || s.kind != b'f');
    let stored = stored.ok_or_else(|| format!("the type is {descr}; {wanted}"))?;
    let by_columns = match value(header, "fortran_order") {
        Some("True") => true,
        Some("False") => false,
        _ => return Err("the header has no `fortran_order`".into()),
    };
    let shape = value(header, "shape").ok_or("the header has no `shape`")?;
    let sizes: Vec<&str> = shape
        .trim_matches(['(', ')'])
        .split(',')
        .map(str::trim)
        .filter(|s| !s.is_empty())
        .collect();
    let n = match sizes[..] {
        [n, width] if width == WIDTH.to_string() => n.parse::<usize>().ok(),
        _ => None,
    };
    let n = n.ok_or_else(|| format!("the shape is {shape}; {wanted}"))?;
    if n.checked_mul(stored.size * WIDTH) != Some(data.len()) {
        let holds = data.len();
        return Err(format!("the header promises {n} rows, but {holds} bytes follow it"));
    }
    let number = |row: usize, column: usize| {
        let i = if by_columns { column * n + row } else { row * WIDTH + column };
        T::of(stored.value(&data[i * stored.size..][..stored.size]))
            .map_err(|what| format!("row {row}: {what}"))
    };
    let mut rows = Vec::with_capacity(n);
    for row in 0..n {
        let mut numbers = [number(row, 0)?; WIDTH];
        for (column, x) in numbers.iter_mut().enumerate().skip(1) {
            *x = number(row, column)?;
        }
        rows.push(numbers);
    }
    Ok(rows)
}

/// The header's text, and what follows it.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let rest = bytes.strip_prefix(MAGIC).ok_or("this is no .npy file")?;
    let cut = "the file is cut short within its header";
    let (length, start) = match *rest {
        [1, _, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), 4),
        [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]) as usize, 6),
        [version, ..] if version == 0 || version > 3 => {
            return Err(format!("version {version} of .npy is not known; 1 to 3 are"));
        }
        _ => return Err(cut.into()),
    };
    let (header, data) = rest[start..].split_at_checked(length).ok_or(cut)?;
    Ok((std::str::from_utf8(header).map_err(|_| "the header is no text")?, data))
}

/// The value of a key in the header, a Python dictionary.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let at = header.find(&format!("'{key}':"))?;
    let rest = header[at + key.len() + 3..].trim_start();
    let end = match rest.as_bytes().first()? {
        b'(' => rest.find(')')? + 1,
        b'[' => rest.find(']')? + 1,
        _ => rest.find([',', '}'])?,
    };
    Some(rest[..end].trim())
}

/// Writes an array of the shape (n, `WIDTH`).
///
/// # Errors
/// An output's.
pub fn write_rows<T: Number, const WIDTH: usize>(
    path: &Path,
    rows: &[[T; WIDTH]],
) -> Result<(), Failure> {
    let data: Vec<u8> = rows.as_flattened().iter().flat_map(|x| x.bytes()).collect();
    write(path, &format!("'<{}'", T::NAME), &format!("({}, {WIDTH})", rows.len()), &data)
}

/// Writes an array.
///
/// `descr` is the type as NumPy spells it, quotes included; `shape` likewise, brackets included.
///
/// # Errors
/// An output's.
pub fn write(path: &Path, descr: &str, shape: &str, data: &[u8]) -> Result<(), Failure> {
    let mut header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}");
    // Data begin at a multiple of 64, and the header ends in a line feed.
    let before = MAGIC.len() + 4;
    let whole = (before + header.len() + 1).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', whole - before - header.len() - 1));
    header.push('\n');
    let length = (header.len() as u16).to_le_bytes();
    super::put(path, &[MAGIC, &[1, 0], &length, header.as_bytes(), data].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let length = header.len() as u32;
        let length = length.to_le_bytes();
        let length = if version == 1 { &length[..2] } else { &length[..] };
        [MAGIC, &[version, 0], length, header.as_bytes(), data].concat()
    }

    const HEADER: &str = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }\n";

    #[test]
    fn arrays_are_read_row_by_row() {
        let data = [1.0f32.to_le_bytes(), 2.5f32.to_le_bytes()].concat();
        for version in 1..=3 {
            assert_eq!(rows(&file(version, HEADER, &data)), Ok(vec![[1.0f32, 2.5]]));
        }
        let none = HEADER.replace("(1, 2)", "(0, 2)");
        assert_eq!(rows::<f32, 2>(&file(1, &none, &[])), Ok(vec![]));
    }

    #[test]
    fn other_types_and_orders_are_converted() {
        let array = |descr: &str, data: &[u8]| file(1, &HEADER.replace("<f4", descr), data);
        let both = |one: &[u8], two: &[u8]| [one, two].concat();
        let (x, y) = (1.0f64, -2.5f64);
        for bytes in [
            array("<f8", &both(&x.to_le_bytes(), &y.to_le_bytes())),
            array(">f8", &both(&x.to_be_bytes(), &y.to_be_bytes())),
            array(">f4", &both(&1.0f32.to_be_bytes(), &(-2.5f32).to_be_bytes())),
        ] {
            assert_eq!(rows(&bytes), Ok(vec![[1.0f32, -2.5]]));
        }
        assert_eq!(rows(&array("|i1", &[1, 0xfe])), Ok(vec![[1.0f32, -2.0]]));
        for bytes in [
            array("<i8", &both(&7i64.to_le_bytes(), &300i64.to_le_bytes())),
            array(">u2", &both(&7u16.to_be_bytes(), &300u16.to_be_bytes())),
        ] {
            assert_eq!(rows(&bytes), Ok(vec![[7u32, 300]]));
        }
        let negative = array("<i8", &both(&7i64.to_le_bytes(), &(-1i64).to_le_bytes()));
        assert_eq!(rows::<u32, 2>(&negative).unwrap_err(), "row 0: -1 is no index");
        let great = array("<f8", &both(&1e300f64.to_le_bytes(), &y.to_le_bytes()));
        assert!(rows::<f32, 2>(&great).unwrap_err().starts_with("row 0: 1e300 is too great"));
        let float = array("<f4", &[0; 8]);
        assert!(rows::<u32, 2>(&float).unwrap_err().contains("<f4"));
        let header = HEADER.replace("False", "True").replace("(1, 2)", "(2, 2)");
        let data: Vec<u8> = [1f32, 2., 3., 4.].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(rows(&file(1, &header, &data)), Ok(vec![[1f32, 3.], [2., 4.]]));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let data = [0; 8];
        let with = |from: &str, to: &str| file(1, &HEADER.replace(from, to), &data);
        let good = file(1, HEADER, &data);
        for (bytes, word) in [
            (b"P6".to_vec(), "no .npy"),
            (good[..9].to_vec(), "cut short"),
            (good[..30].to_vec(), "cut short"),
            (good[..good.len() - 1].to_vec(), "7 bytes"),
            (file(9, HEADER, &data), "version 9"),
            (with("<f4", "<f2"), "<f2"),
            (with("<f4", "<c8"), "<c8"),
            (with("<f4", "|b1"), "|b1"),
            (with("'<f4'", "[('x', '<f4')]"), "[('x', '<f4')]"),
            (with("<f4", "<f8"), "8 bytes follow"),
            (with("False", "Maybe"), "fortran_order"),
            (with("(1, 2)", "(2,)"), "(2,)"),
            (with("(1, 2)", "(1, 3)"), "(1, 3)"),
            (with("(1, 2)", "(18446744073709551615, 2)"), "rows"),
            (with("shape", "size"), "`shape`"),
        ] {
            let error = rows::<f32, 2>(&bytes).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
