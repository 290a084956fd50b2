//! The formats of Netpbm: PBM, PGM and PPM as text or binary, PAM; and PFM.

use super::{Curve, Orientation, Raster, Room, Samples, reserved};
use crate::error::Fault;

pub(super) fn decode(bytes: &[u8], room: Room) -> Result<Raster, Fault> {
    let mut head = Head { bytes, at: 2 };
    match bytes[1] {
        b'7' => pam(&mut head, room),
        b'F' | b'f' => pfm(&mut head, room),
        kind => {
            let (width, height) = (head.number()?, head.number()?);
            let most = if matches!(kind, b'1' | b'4') { 1 } else { head.most()? };
            let channels = if matches!(kind, b'3' | b'6') { 3 } else { 1 };
            let coding = match kind {
                b'4' => Coding::Bits,
                b'1' => Coding::Digits,
                b'2' | b'3' => Coding::Text,
                _ => Coding::Bytes,
            };
            raster(&mut head, [width, height], channels, most, coding, room)
        }
    }
}

/// What is read so far.
struct Head<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Head<'_> {
    /// Skips blanks and remarks; whether there were any.
    fn blanks(&mut self) -> Result<bool, Fault> {
        let start = self.at;
        loop {
            match self.bytes.get(self.at) {
                Some(b'#') => {
                    let rest = self.bytes[self.at..].iter().position(|b| *b == b'\n');
                    self.at += rest.ok_or_else(|| self.fault("the head ends too early"))?;
                }
                Some(byte) if byte.is_ascii_whitespace() => self.at += 1,
                _ => return Ok(self.at > start),
            }
        }
    }

    fn number(&mut self) -> Result<u64, Fault> {
        let blank = self.blanks()?;
        let rest = &self.bytes[self.at..];
        let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        let text = std::str::from_utf8(&rest[..digits]).unwrap_or_default();
        let parsed = text.parse().ok().filter(|_| blank && digits < 10);
        let number = parsed.ok_or_else(|| self.fault("the head needs a number here"))?;
        self.at += digits;
        Ok(number)
    }

    /// What stands for 1.
    fn most(&mut self) -> Result<u16, Fault> {
        let most = self.number()?;
        let fits = u16::try_from(most).ok().filter(|most| *most > 0);
        fits.ok_or_else(|| self.fault(&format!("samples up to {most}: they must be 1 to 65535")))
    }

    /// The blank before binary samples.
    fn end(&mut self) -> Result<(), Fault> {
        if !self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            return Err(self.fault("a blank belongs between the head and the samples"));
        }
        self.at += 1;
        Ok(())
    }

    /// The next line, without its break.
    fn line(&mut self) -> Result<&str, Fault> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().take(1024).position(|b| *b == b'\n');
        let end = end.ok_or_else(|| self.fault("the head ends too early"))?;
        let line = std::str::from_utf8(&rest[..end]);
        let line = line.map_err(|_| self.fault("the head is no text"))?;
        self.at += end + 1;
        Ok(line.trim())
    }

    fn fault(&self, message: &str) -> Fault {
        Fault::byte(self.at, message)
    }
}

/// How samples are written.
#[derive(Clone, Copy, PartialEq)]
enum Coding {
    /// A byte each, or two, the high one first.
    Bytes,
    /// Eight in a byte, each row from a byte of its own; 1 is black.
    Bits,
    /// Numbers between blanks.
    Text,
    /// The digits 0 and 1; 1 is black.
    Digits,
}

fn raster(
    head: &mut Head<'_>,
    [width, height]: [u64; 2],
    channels: usize,
    most: u16,
    coding: Coding,
    room: Room,
) -> Result<Raster, Fault> {
    let each = channels as u64 * if most == 255 { 1 } else { 2 };
    let pixels = room.pixels(width, height, each)?;
    let count = pixels * channels;
    let cut = || Fault::byte(head.bytes.len(), "the file ends too early");
    // Fewer bytes than samples: nothing is reserved for what cannot follow.
    let left = head.bytes.len().saturating_sub(head.at);
    if coding != Coding::Bits && left < count {
        return Err(cut());
    }
    let values = match coding {
        Coding::Bytes | Coding::Bits => {
            head.end()?;
            binary(head, [width, height], count, most, coding)?
        }
        Coding::Text | Coding::Digits => text(head, count, most, coding)?,
    };
    let notes = match head.bytes[head.at.min(head.bytes.len())..].trim_ascii().is_empty() {
        true => Vec::new(),
        false => vec!["what follows its first picture is left out".to_owned()],
    };
    Ok(Raster {
        width: width as u32,
        height: height as u32,
        channels,
        samples: values,
        curve: Curve::Srgb,
        orientation: Orientation::NoTransforms,
        notes,
    })
}

fn binary(
    head: &mut Head<'_>,
    [width, height]: [u64; 2],
    count: usize,
    most: u16,
    coding: Coding,
) -> Result<Samples, Fault> {
    let (width, height) = (width as usize, height as usize);
    let wide = if most > 255 { 2 } else { 1 };
    let row = width.div_ceil(8);
    let length = if coding == Coding::Bits { row * height } else { count * wide };
    let body = head.bytes.get(head.at..).and_then(|rest| rest.get(..length));
    let body = body.ok_or_else(|| Fault::byte(head.bytes.len(), "the file ends too early"))?;
    let start = head.at;
    head.at += length;
    if coding == Coding::Bits {
        let mut values = reserved(count)?;
        for line in body.chunks_exact(row) {
            values.extend((0..width).map(|x| u16::from(line[x / 8] >> (7 - x % 8) & 1 ^ 1)));
        }
        return Ok(Samples::U16 { values, most });
    }
    if most == 255 {
        let mut values = reserved(count)?;
        values.extend_from_slice(body);
        return Ok(Samples::U8(values));
    }
    let mut values = reserved(count)?;
    for raw in body.chunks_exact(wide) {
        values.push(raw.iter().fold(0, |sum, byte| sum << 8 | u16::from(*byte)));
    }
    if let Some(at) = values.iter().position(|value| *value > most) {
        return Err(above(start + at * wide, values[at].into(), most));
    }
    Ok(Samples::U16 { values, most })
}

fn text(head: &mut Head<'_>, count: usize, most: u16, coding: Coding) -> Result<Samples, Fault> {
    let mut values = reserved(count)?;
    while values.len() < count {
        if coding == Coding::Digits {
            head.blanks()?;
            let digit = head.bytes.get(head.at);
            values.push(match digit {
                Some(b'0') => 1,
                Some(b'1') => 0,
                Some(_) => return Err(head.fault("a 0 or 1 belongs here")),
                None => return Err(head.fault("the file ends too early")),
            });
            head.at += 1;
        } else {
            let from = head.at;
            let value = head.number().map_err(|_| match head.bytes.len() == head.at {
                true => head.fault("the file ends too early"),
                false => head.fault("a number belongs here"),
            })?;
            let fits = u16::try_from(value).ok().filter(|value| *value <= most);
            values.push(fits.ok_or_else(|| above(from, value, most))?);
        }
    }
    Ok(Samples::U16 { values, most })
}

fn above(byte: usize, value: u64, most: u16) -> Fault {
    Fault::byte(byte, format!("the sample {value} is above {most}"))
}

fn pam(head: &mut Head<'_>, room: Room) -> Result<Raster, Fault> {
    let mut sizes = [None; 4];
    let mut kind = String::new();
    head.line()?;
    loop {
        let start = head.at;
        let line = head.line()?;
        let (key, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let value = value.trim();
        let place = ["WIDTH", "HEIGHT", "DEPTH", "MAXVAL"].iter().position(|k| *k == key);
        match (place, key) {
            (Some(place), _) => {
                let number = value.parse::<u64>().ok().filter(|n| *n < 1_000_000_000);
                sizes[place] = Some(number.ok_or_else(|| {
                    Fault::byte(start, format!("the head needs a number after {key}"))
                })?);
            }
            (None, "TUPLTYPE") => kind = value.to_owned(),
            (None, "ENDHDR") => break,
            (None, key) if key.is_empty() || key.starts_with('#') => {}
            _ => return Err(Fault::byte(start, "the head holds an unknown word")),
        }
    }
    let [Some(width), Some(height), Some(depth), Some(most)] = sizes else {
        return Err(head.fault("the head needs WIDTH, HEIGHT, DEPTH and MAXVAL"));
    };
    let channels = usize::try_from(depth).ok().filter(|depth| (1..=4).contains(depth));
    let channels = channels.ok_or_else(|| {
        Fault::file(format!("the PAM has {depth} samples a pixel ({kind}): 1 to 4 are read"))
    })?;
    let most = u16::try_from(most)
        .ok()
        .filter(|most| *most > 0)
        .ok_or_else(|| head.fault(&format!("samples up to {most}: they must be 1 to 65535")))?;
    // The blank that binary samples begin after is the break of the last line.
    head.at -= 1;
    raster(head, [width, height], channels, most, Coding::Bytes, room)
}

fn pfm(head: &mut Head<'_>, room: Room) -> Result<Raster, Fault> {
    let channels = if head.bytes[1] == b'F' { 3 } else { 1 };
    let (width, height) = (head.number()?, head.number()?);
    head.blanks()?;
    let rest = head.bytes[head.at..].iter();
    let length = rest.take(32).take_while(|byte| !byte.is_ascii_whitespace()).count();
    let word = std::str::from_utf8(&head.bytes[head.at..head.at + length]).unwrap_or_default();
    let scale = word.parse::<f32>().ok().filter(|scale| scale.is_finite() && *scale != 0.0);
    let scale = scale.ok_or_else(|| head.fault("the head needs a scale here"))?;
    head.at += length;
    head.end()?;
    let pixels = room.pixels(width, height, 4 * channels as u64)?;
    let row = width as usize * channels;
    let body = head.bytes[head.at..].as_chunks::<4>().0;
    let body = body.get(..pixels * channels);
    let body = body.ok_or_else(|| Fault::byte(head.bytes.len(), "the file ends too early"))?;
    let mut values: Vec<f32> = reserved(pixels * channels)?;
    // The lowest row comes first, and a scale below 0 says that the low byte does.
    for line in body.chunks_exact(row).rev() {
        values.extend(line.iter().map(|four| match scale < 0.0 {
            true => f32::from_le_bytes(*four) * -scale,
            false => f32::from_be_bytes(*four) * scale,
        }));
    }
    Ok(Raster {
        width: width as u32,
        height: height as u32,
        channels,
        samples: Samples::F32(values),
        curve: Curve::Linear,
        orientation: Orientation::NoTransforms,
        notes: Vec::new(),
    })
}
