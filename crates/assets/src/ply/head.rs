//! The head of a PLY file: which elements follow, and what each has.

use crate::error::Fault;
use crate::words::shown;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    /// By its name in a head.
    pub fn of(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// How many it takes in a binary file.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property: one number, or a list whose length is a number of the first type.
pub(crate) struct Property {
    pub name: Vec<u8>,
    pub length: Option<Number>,
    pub number: Number,
}

/// Things of one kind: how many there are, and what each has.
pub(crate) struct Element {
    pub name: Vec<u8>,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one takes.
    fn least(&self, encoding: Encoding) -> u64 {
        let least = |p: &Property| match encoding {
            // A digit and a blank, of which the file's last number needs none.
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.number).bytes() as u64,
        };
        self.properties.iter().map(least).sum()
    }
}

/// A head that is being read.
pub(crate) struct Head<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub line: u64,
}

impl<'a> Head<'a> {
    fn next_line(&mut self) -> Result<&'a [u8], Fault> {
        self.line += 1;
        let rest = &self.bytes[self.at..];
        let end = rest.iter().take(4096).position(|b| matches!(b, b'\n' | b'\r'));
        let Some(end) = end else {
            return Err(Fault::line(self.line, "the head does not end; is it a PLY file?"));
        };
        let both = rest[end..].starts_with(b"\r\n");
        self.at += end + 1 + usize::from(both);
        Ok(&rest[..end])
    }

    /// The encoding and the elements; `at` is then the first byte after the head.
    ///
    /// # Errors
    /// A line that does not belong there, and elements that the file cannot hold; with the line.
    pub fn read(&mut self) -> Result<(Encoding, Vec<Element>), Fault> {
        if self.next_line()?.trim_ascii_end() != b"ply" {
            return Err(Fault::line(1, "does not begin with `ply`; is it a PLY file?"));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let line = self.next_line()?;
            let words: Vec<&[u8]> =
                line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
            let broken = || {
                let message = format!("{} is no line of a PLY file's head", shown(line));
                Fault::line(self.line, message)
            };
            match words[..] {
                [] | [b"comment" | b"obj_info", ..] => {}
                [b"format", kind, _] => {
                    encoding = Some(match kind {
                        b"ascii" => Encoding::Ascii,
                        b"binary_little_endian" => Encoding::Little,
                        b"binary_big_endian" => Encoding::Big,
                        _ => return Err(broken()),
                    });
                }
                [b"element", name, count] => {
                    let count = std::str::from_utf8(count).ok().and_then(|c| c.parse().ok());
                    let count = count.filter(|count| *count <= u64::from(u32::MAX));
                    let count = count.ok_or_else(broken)?;
                    elements.push(Element { name: name.to_vec(), count, properties: Vec::new() });
                }
                [b"property", ref kind @ .., name] if !elements.is_empty() => {
                    let (length, number) = match kind[..] {
                        [number] => (None, Number::of(number)),
                        [b"list", length, number] => (Number::of(length), Number::of(number)),
                        _ => return Err(broken()),
                    };
                    let number = number.ok_or_else(broken)?;
                    if kind.len() == 3 && length.is_none() {
                        return Err(broken());
                    }
                    let property = Property { name: name.to_vec(), length, number };
                    elements.last_mut().ok_or_else(broken)?.properties.push(property);
                }
                [b"end_header"] => break,
                _ => return Err(broken()),
            }
        }
        let line = self.line;
        let encoding =
            encoding.ok_or_else(|| Fault::line(line, "the head has no `format` line"))?;
        let rest = (self.bytes.len() - self.at) as u64;
        let most = |e: &&Element| e.count.saturating_mul(e.least(encoding)) > rest + 1;
        if let Some(element) = elements.iter().find(most) {
            let message = format!(
                "{} elements {} do not fit into the {rest} bytes after the head: the file ends too early",
                element.count,
                shown(&element.name)
            );
            return Err(Fault::line(line, message));
        }
        Ok((encoding, elements))
    }
}
