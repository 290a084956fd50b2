//! The JSON and the buffers of a glTF file, from text or from GLB, from inside or beside it.

use super::Trouble;
use super::json::{Head, Root, View};
use crate::error::AssetError;
use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

/// A glTF file: its JSON and its buffers, those that cannot be read with the reason.
pub(super) struct File {
    pub root: Root,
    buffers: Vec<Result<Vec<u8>, Trouble>>,
}

/// The bytes of other files, by path relative to the glTF.
pub(super) type Other<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, AssetError>;

impl File {
    /// Takes a file apart.
    pub fn open(bytes: &[u8], other: Other<'_>) -> Result<File, Trouble> {
        let (json, blob) = chunks(bytes)?;
        let root = root(json)?;
        let mut blob = blob.map(<[u8]>::to_vec);
        let load = |(index, buffer): (usize, &super::json::Buffer)| match &buffer.uri {
            Some(uri) => load(uri, other),
            None => blob.take().filter(|_| index == 0).ok_or_else(|| {
                Trouble::Said("it is not in the file; embed it, or store it beside the file".into())
            }),
        };
        let buffers = root.buffers.iter().enumerate().map(load).collect();
        Ok(File { root, buffers })
    }

    /// All bytes of its buffers together.
    pub fn bytes(&self) -> usize {
        self.buffers.iter().flatten().map(Vec::len).sum()
    }

    /// A view's bytes, and itself.
    pub fn view(&self, index: usize) -> Result<(&[u8], &View), Trouble> {
        let view = self.root.buffer_views.get(index);
        let view = view.ok_or_else(|| {
            let there = self.root.buffer_views.len();
            format!("buffer view {index} is asked for, there are {there}")
        })?;
        let number = view.buffer;
        let buffer = self.buffers.get(number).ok_or_else(|| {
            format!("buffer {number} is asked for, there are {}", self.buffers.len())
        })?;
        let buffer = match buffer {
            Ok(buffer) => buffer,
            Err(Trouble::Said(why)) => return Err(format!("buffer {number}: {why}").into()),
            Err(error) => return Err(error.clone()),
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        let bytes = bytes.ok_or_else(|| {
            let there = buffer.len();
            format!("buffer view {index} reaches beyond its buffer of {there} bytes")
        })?;
        Ok((bytes, view))
    }
}

/// The bytes that a URI holds or names.
pub(super) fn load(uri: &str, other: Other<'_>) -> Result<Vec<u8>, Trouble> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme.to_ascii_lowercase());
    match scheme.as_deref() {
        Some("data") => {
            embedded(&uri["data:".len()..]).ok_or_else(|| "its data URI is no base64".into())
        }
        Some("http" | "https") => {
            Err(format!("`{uri}` is on the network; store it beside the file").into())
        }
        _ => {
            // Some write names as they are, and some with the separators of Windows.
            let name = decoded(uri).unwrap_or_else(|| uri.to_owned()).replace('\\', "/");
            match other(&name) {
                Err(_) if name != uri && other(uri).is_ok() => other(uri).map_err(Trouble::Other),
                read => read.map_err(Trouble::Other),
            }
        }
    }
}

/// The JSON and the binary chunk.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Trouble> {
    let number = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|four| four.first_chunk());
        four.map(|four| u32::from_le_bytes(*four) as usize)
    };
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    match number(4) {
        Some(2) => {}
        Some(version) => {
            let message = format!("is binary glTF {version}, and version 2 is read; convert it");
            return Err(message.into());
        }
        None => return Err("the file ends too early".into()),
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while let (Some(length), Some(kind)) = (number(at), bytes.get(at + 4..at + 8)) {
        let start = at + 8;
        let end = start.checked_add(length).filter(|end| *end <= bytes.len());
        let end = end.ok_or("the file ends too early")?;
        let chunk = &bytes[start..end];
        match kind {
            b"JSON" => json = json.or(Some(chunk)),
            b"BIN\0" => binary = binary.or(Some(chunk)),
            _ => {}
        }
        // Chunks end at a multiple of 4; some writers leave the padding out of their length.
        at = end.next_multiple_of(4);
    }
    Ok((json.ok_or("the file has no JSON in it")?, binary))
}

fn root(json: &[u8]) -> Result<Root, Trouble> {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    if json.starts_with(b"\xff\xfe") || json.starts_with(b"\xfe\xff") {
        return Err("is UTF-16; save it as UTF-8".into());
    }
    // A GLB's padding.
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let json = &json[..end];
    let head = serde_json::from_slice::<Head>(json).unwrap_or_default();
    let version = head.asset.version;
    if !version.is_empty() && !version.starts_with("2") {
        let message = format!("is glTF {version}, and 2.0 is read; convert it");
        return Err(message.into());
    }
    serde_json::from_slice(json).map_err(|error| format!("is no glTF 2.0 file: {error}").into())
}

/// The bytes of `[type][;base64],...`.
fn embedded(data: &str) -> Option<Vec<u8>> {
    let (head, text) = data.split_once(',')?;
    let is_base64 =
        head.rsplit(';').next().is_some_and(|word| word.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 {
        return percent_decoded(text);
    }
    let mut text =
        if text.contains('%') { percent_decoded(text)? } else { text.as_bytes().to_vec() };
    text.retain(|byte| !byte.is_ascii_whitespace());
    let lenient = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    let decode = |alphabet| GeneralPurpose::new(alphabet, lenient).decode(&text).ok();
    decode(&alphabet::STANDARD).or_else(|| decode(&alphabet::URL_SAFE))
}

/// A relative URI as a path: `%20` is a blank.
fn decoded(uri: &str) -> Option<String> {
    String::from_utf8(percent_decoded(uri)?).ok()
}

fn percent_decoded(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &rest[2..];
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_are_read_as_they_are_written() {
        for uri in [
            "application/octet-stream;base64,+/+/",
            ";base64,+/+/",
            "application/gltf-buffer;charset=x;BASE64,+/ +/",
            "a/b;base64,-_-_",
            "base64;base64,%2B%2F%2b/",
        ] {
            assert_eq!(embedded(uri).as_deref(), Some(&[0xfb, 0xff, 0xbf][..]), "{uri}");
        }
        assert_eq!(embedded(";base64,AAE").as_deref(), Some(&[0, 1][..]), "without padding");
        assert_eq!(embedded("text/plain,a%20b").as_deref(), Some(&b"a b"[..]));
        assert_eq!(embedded(";base64,!"), None);
        assert_eq!(embedded("nothing"), None);
    }
}
