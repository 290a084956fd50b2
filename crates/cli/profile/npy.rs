//! NumPy's array files: two-dimensional arrays read, rows of hits written.
//!
//! Source: "A simple file format for NumPy arrays", NEP 1; versions 1.0 to 3.0 of `numpy.lib.format`.

use crate::exit::{Exit, Failure};
use std::fs;
use std::io::Write;
use std::path::Path;

const MAGIC: &[u8] = b"\x93NUMPY";

/// A kind of number that an array may hold, four bytes in little-endian order.
pub trait Number: Copy {
    /// Its name in the header, without the order of bytes.
    const NAME: &'static str;
    /// The number that four bytes hold.
    fn of(bytes: [u8; 4]) -> Self;
}

impl Number for f32 {
    const NAME: &'static str = "f4";
    fn of(bytes: [u8; 4]) -> f32 {
        f32::from_le_bytes(bytes)
    }
}

impl Number for u32 {
    const NAME: &'static str = "u4";
    fn of(bytes: [u8; 4]) -> u32 {
        u32::from_le_bytes(bytes)
    }
}

/// The rows of an array of the shape (n, `WIDTH`).
///
/// # Errors
/// An input's: the file is missing, is no such array, or is cut short.
pub fn read<T: Number, const WIDTH: usize>(path: &Path) -> Result<Vec<[T; WIDTH]>, Failure> {
    let bytes = fs::read(path).map_err(|e| fault(path, &e.to_string()))?;
    rows(&bytes).map_err(|what| fault(path, &what))
}

fn fault(path: &Path, what: &str) -> Failure {
    Failure::new(Exit::Input, format!("{}: {what}", path.display()))
}

fn rows<T: Number, const WIDTH: usize>(bytes: &[u8]) -> Result<Vec<[T; WIDTH]>, String> {
    let (header, data) = split(bytes)?;
    let wanted = format!("an array of shape (n, {WIDTH}) and type <{} is wanted", T::NAME);
    let descr = value(header, "descr").ok_or("the header has no `descr`")?;
    if descr.trim_matches(['\'', '"']) != format!("<{}", T::NAME) {
        return Err(format!("the type is {descr}; {wanted}"));
    }
    if value(header, "fortran_order") != Some("False") {
        return Err(format!("the order is Fortran's; {wanted}, in C's order"));
    }
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
    if n.checked_mul(4 * WIDTH) != Some(data.len()) {
        let holds = data.len();
        return Err(format!("the header promises {n} rows, but {holds} bytes follow it"));
    }
    let number = |b: &[u8]| T::of([b[0], b[1], b[2], b[3]]);
    let row = |row: &[u8]| std::array::from_fn(|k| number(&row[4 * k..]));
    Ok(data.chunks_exact(4 * WIDTH).map(row).collect())
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
    let put = || {
        let mut file = fs::File::create(path)?;
        file.write_all(MAGIC)?;
        file.write_all(&[1, 0])?;
        file.write_all(&(header.len() as u16).to_le_bytes())?;
        file.write_all(header.as_bytes())?;
        file.write_all(data)?;
        file.sync_all()
    };
    put()
        .map_err(|e: std::io::Error| Failure::new(Exit::Output, format!("{}: {e}", path.display())))
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
            (with("<f4", "<f8"), "<f8"),
            (with("<f4", ">f4"), ">f4"),
            (with("False", "True"), "Fortran"),
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
