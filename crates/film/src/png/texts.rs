//! Reading back what a PNG file carries.

use super::SIGNATURE;
use crate::seal::CHECK;
use std::ops::Range;

/// Keys and values, and where the whole chunk of the check is.
type Texts = (Vec<(String, String)>, Range<usize>);

/// The texts of a PNG file, and where the whole chunk of [`CHECK`] is (empty if there is none).
/// Every chunk must be whole and the file end with the last one.
///
/// # Errors
/// What is wrong, in words.
pub(crate) fn read_texts(bytes: &[u8]) -> Result<Texts, String> {
    let mut texts = Vec::new();
    let (mut at, mut check) = (SIGNATURE.len(), 0..0);
    loop {
        let word = |at: usize| -> Option<u32> {
            Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
        };
        let cut = || "it ends too early".to_owned();
        let length = word(at).ok_or_else(cut)? as usize;
        let kind = bytes.get(at + 4..at + 8).ok_or_else(cut)?;
        let data = bytes.get(at + 8..).and_then(|rest| rest.get(..length)).ok_or_else(cut)?;
        let end = at + 12 + length;
        if word(end - 4).ok_or_else(cut)? != crc32fast::hash(&bytes[at + 4..end - 4]) {
            return Err(format!("the checksum of the chunk at byte {at} is wrong"));
        }
        let text = match kind {
            b"tEXt" => Some("\0"),
            b"iTXt" => Some("\0\0\0\0\0"),
            _ => None,
        };
        if let (Some(between), Ok(data)) = (text, std::str::from_utf8(data))
            && let Some((key, value)) = data.split_once(between)
        {
            if key == CHECK {
                check = at..end;
            }
            texts.push((key.to_owned(), value.to_owned()));
        }
        if kind == b"IEND" {
            return if end == bytes.len() {
                Ok((texts, check))
            } else {
                Err("it goes on after its end".to_owned())
            };
        }
        at = end;
    }
}
