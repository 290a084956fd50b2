//! PLY to columns: ascii, and binary of either byte order.
//!
//! Source: G. Turk, "The PLY Polygon File Format", 1994. Of the element `vertex`, `x y z` are read,
//! `nx ny nz`, and `u v` (also `s t` and `texture_u texture_v`); of `face`, the list `vertex_indices`
//! (also `vertex_index`). A polygon becomes a fan from its first corner, so it should be convex.
//! Other elements and properties are passed over.

use crate::error::Fault;
use crate::finish::finish;
use crate::words::shown;
use reflet_scene::MeshData;

/// What a PLY file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ply {
    /// The vertices and the triangles that have an area.
    pub data: MeshData,
    /// Triangles left out because they have no area.
    pub without_area: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
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
    fn of(word: &[u8]) -> Option<Self> {
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

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property: one number, or a list whose length is a number of the first type.
struct Property {
    name: Vec<u8>,
    length: Option<Number>,
    number: Number,
}

struct Element {
    name: Vec<u8>,
    count: u64,
    properties: Vec<Property>,
}

/// Where a vertex's property goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Slot {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Nowhere,
}

impl Slot {
    fn of(name: &[u8]) -> Self {
        match name {
            b"x" => Self::Position(0),
            b"y" => Self::Position(1),
            b"z" => Self::Position(2),
            b"nx" => Self::Normal(0),
            b"ny" => Self::Normal(1),
            b"nz" => Self::Normal(2),
            b"u" | b"s" | b"texture_u" => Self::Uv(0),
            b"v" | b"t" | b"texture_v" => Self::Uv(1),
            _ => Self::Nowhere,
        }
    }
}

/// The triangles of a PLY file.
///
/// # Errors
/// A broken head, a file that ends too early, numbers that are not finite, faces of fewer than three
/// corners, indices of no vertex, and a file without any face; with the line or the byte.
pub fn parse(bytes: &[u8]) -> Result<Ply, Fault> {
    let mut head = Head { bytes, at: 0, line: 0 };
    let (encoding, elements) = head.read()?;
    let mut values = Values { bytes, at: head.at, line: head.line + 1, encoding };
    let mut data = MeshData::default();
    let mut place = (0, 0);
    for element in &elements {
        match &*element.name {
            b"vertex" if data.positions.is_empty() => vertices(&mut values, element, &mut data)?,
            b"face" => {
                place = (values.at, values.line);
                faces(&mut values, element, &mut data)?;
            }
            _ => {
                for _ in 0..element.count {
                    element.properties.iter().try_for_each(|p| values.skip(p))?;
                }
            }
        }
    }
    let count = data.positions.len();
    if let Some(index) = data.triangles.iter().flatten().find(|v| **v as usize >= count) {
        // Faces may stand before their vertices.
        let message = format!("vertex {index} is asked for, there are {count} (counted from 0)");
        return Err(match encoding {
            Encoding::Ascii => Fault::line(place.1, message),
            _ => Fault::byte(place.0, message),
        });
    }
    if data.triangles.is_empty() {
        return Err(Fault::file("holds no face; triangle strips and point clouds are not read"));
    }
    let without_area = finish(&mut data);
    Ok(Ply { data, without_area })
}

struct Head<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
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

    fn read(&mut self) -> Result<(Encoding, Vec<Element>), Fault> {
        if self.next_line().ok() != Some(b"ply") {
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
        Ok((encoding, elements))
    }
}

/// The numbers after the head.
struct Values<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    encoding: Encoding,
}

impl Values<'_> {
    fn fault(&self, at: usize, message: impl Into<String>) -> Fault {
        match self.encoding {
            Encoding::Ascii => Fault::line(self.line, message),
            _ => Fault::byte(at, message),
        }
    }

    #[inline]
    fn next(&mut self, number: Number) -> Result<f64, Fault> {
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
        let value = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let value =
            value.ok_or_else(|| self.fault(self.at, format!("{} is not a number", shown(word))))?;
        self.at += end;
        Ok(value)
    }

    /// The length of a list, which the rest of the file must be able to hold.
    fn length(&mut self, number: Number) -> Result<usize, Fault> {
        let at = self.at;
        let length = self.next(number)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= self.bytes.len() as f64 {
            Ok(length as usize)
        } else {
            Err(self.fault(at, format!("a list cannot have the length {length}")))
        }
    }

    fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count = property.length.map_or(Ok(1), |length| self.length(length))?;
        for _ in 0..count {
            self.next(property.number)?;
        }
        Ok(())
    }

    /// No more than so many things of at least one byte each can follow: what to reserve.
    fn most(&self, count: u64) -> usize {
        count.min((self.bytes.len() - self.at.min(self.bytes.len())) as u64) as usize
    }
}

fn vertices(values: &mut Values<'_>, element: &Element, data: &mut MeshData) -> Result<(), Fault> {
    let slots: Vec<Slot> = element
        .properties
        .iter()
        .map(|p| if p.length.is_some() { Slot::Nowhere } else { Slot::of(&p.name) })
        .collect();
    let has = |slot: Slot| slots.contains(&slot);
    if !(0..3).all(|axis| has(Slot::Position(axis))) {
        return Err(Fault::file("its element `vertex` lacks one of x, y and z"));
    }
    let normals = (0..3).all(|axis| has(Slot::Normal(axis)));
    let uvs = has(Slot::Uv(0)) && has(Slot::Uv(1));
    let most = values.most(element.count);
    data.positions.reserve(most);
    data.normals.reserve(if normals { most } else { 0 });
    data.uvs.reserve(if uvs { most } else { 0 });
    for _ in 0..element.count {
        let (mut position, mut normal, mut uv) = ([0.0; 3], [0.0; 3], [0.0; 2]);
        for (property, slot) in element.properties.iter().zip(&slots) {
            if *slot == Slot::Nowhere {
                values.skip(property)?;
                continue;
            }
            let at = values.at;
            let value = values.next(property.number)? as f32;
            if !value.is_finite() {
                let message = "a number is not finite, or beyond the range of f32; scale the mesh";
                return Err(values.fault(at, message));
            }
            match *slot {
                Slot::Position(axis) => position[axis] = value,
                Slot::Normal(axis) => normal[axis] = value,
                Slot::Uv(axis) => uv[axis] = value,
                Slot::Nowhere => {}
            }
        }
        data.positions.push(position);
        data.normals.extend(normals.then_some(normal));
        data.uvs.extend(uvs.then_some(uv));
    }
    Ok(())
}

fn faces(values: &mut Values<'_>, element: &Element, data: &mut MeshData) -> Result<(), Fault> {
    let corners = |p: &Property| {
        p.length.is_some() && matches!(&*p.name, b"vertex_indices" | b"vertex_index")
    };
    if !element.properties.iter().any(corners) {
        return Err(Fault::file("its element `face` has no list `vertex_indices`"));
    }
    data.triangles.reserve(values.most(element.count));
    for _ in 0..element.count {
        for property in &element.properties {
            let (true, Some(length)) = (corners(property), property.length) else {
                values.skip(property)?;
                continue;
            };
            let at = values.at;
            let length = values.length(length)?;
            if length < 3 {
                let message = format!("a face needs three corners, this one has {length}");
                return Err(values.fault(at, message));
            }
            let (mut first, mut last) = (0, 0);
            for corner in 0..length {
                let at = values.at;
                let index = values.next(property.number)?;
                if !(index >= 0.0 && index.fract() == 0.0 && index < f64::from(u32::MAX)) {
                    return Err(values.fault(at, format!("vertex {index} is asked for")));
                }
                let index = index as u32;
                match corner {
                    0 => first = index,
                    1 => {}
                    _ => data.triangles.push([first, last, index]),
                }
                last = index;
            }
        }
    }
    Ok(())
}
