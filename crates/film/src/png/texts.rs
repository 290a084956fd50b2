//! Reading back what a PNG file carries.

use super::SIGNATURE;
use crate::decode::StillHead;
use crate::seal::CHECK;
use crate::transfer::Transfer;
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

/// Whether a PNG that begins so is an animation: its control chunk stands before all pictures.
pub(crate) fn is_animated(head: &[u8]) -> bool {
    let mut at = SIGNATURE.len();
    while head.starts_with(&SIGNATURE) {
        let Some([a, b, c, d, kind @ ..]) = head.get(at..at + 8) else { return false };
        match kind {
            b"acTL" => return true,
            b"IDAT" | b"IEND" => return false,
            _ => at = at.saturating_add(12 + u32::from_be_bytes([*a, *b, *c, *d]) as usize),
        }
    }
    false
}

/// The size of a PNG, and what it says of its samples. As the specification has it, cICP counts before
/// sRGB, and that before gAMA.
///
/// # Errors
/// What is wrong, in words.
pub(crate) fn read_head(bytes: &[u8]) -> Result<StillHead, String> {
    let word = |at: usize| -> Result<u32, String> {
        let four = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
        four.map(u32::from_be_bytes).ok_or_else(|| "it ends too early".to_owned())
    };
    if bytes.get(12..16) != Some(b"IHDR") {
        return Err("its header is broken".to_owned());
    }
    let size = [word(16)?, word(20)?];
    let (mut at, mut found) = (SIGNATURE.len(), [None; 3]);
    // What is cut off here is found to be broken where the pixels are read.
    while let (Ok(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) {
        let data = bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize));
        match (kind, data) {
            (b"IDAT" | b"IEND", _) | (_, None) => break,
            (b"cICP", Some([_, 8, ..])) => found[0] = Some(Transfer::Linear),
            (b"cICP", Some([_, 13, ..])) => found[0] = Some(Transfer::Srgb),
            (b"sRGB", _) => found[1] = Some(Transfer::Srgb),
            (b"gAMA", Some([0, 1, 0x86, 0xa0])) => found[2] = Some(Transfer::Linear),
            _ => {}
        }
        at += 12 + length as usize;
    }
    Ok(StillHead { size, transfer: found.into_iter().flatten().next() })
}
