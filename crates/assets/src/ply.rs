//! PLY to columns: ascii, and binary of either byte order.
//!
//! Source: G. Turk, "The PLY Polygon File Format", 1994. Of the element `vertex`, `x y z` are read,
//! `nx ny nz`, `u v` (also `s t` and `texture_u texture_v`) and the colours `red green blue` (sRGB, as
//! Blender and MeshLab write them); of `face`, the list `vertex_indices` (also `vertex_index`); of
//! `tristrips`, the same, with -1 where a strip begins again. Faces of fewer than three corners, or
//! with a corner whose position is not finite, are left out, and so are other elements and properties.

mod head;
mod values;

use crate::error::Fault;
use crate::faces::Faces;
use crate::finish::finish;
use crate::left_out::{FEW_CORNERS, LeftOut, WITHOUT_AREA};
use crate::texture::linear;
use crate::words::shown;
use head::{Element, Encoding, Head, Number, Property};
use reflet_scene::MeshData;
use values::Values;

/// What a PLY file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ply {
    /// The vertices and the triangles that have an area.
    pub data: MeshData,
    /// What was left out, in words.
    pub left_out: Vec<String>,
}

/// Where a vertex's property goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Slot {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Colour(usize),
    Nowhere,
}

impl Slot {
    fn of(property: &Property) -> Self {
        if property.length.is_some() {
            return Self::Nowhere;
        }
        match &*property.name {
            b"x" => Self::Position(0),
            b"y" => Self::Position(1),
            b"z" => Self::Position(2),
            b"nx" => Self::Normal(0),
            b"ny" => Self::Normal(1),
            b"nz" => Self::Normal(2),
            b"u" | b"s" | b"texture_u" => Self::Uv(0),
            b"v" | b"t" | b"texture_v" => Self::Uv(1),
            b"red" | b"r" | b"diffuse_red" => Self::Colour(0),
            b"green" | b"g" | b"diffuse_green" => Self::Colour(1),
            b"blue" | b"b" | b"diffuse_blue" => Self::Colour(2),
            _ => Self::Nowhere,
        }
    }
}

/// A file half read.
#[derive(Default)]
struct Reading {
    data: MeshData,
    faces: Faces<u32>,
    left_out: LeftOut,
    /// Elements and properties that were passed over, by name.
    passed_over: Vec<String>,
    /// The highest vertex that is asked for, and where; the lowest one.
    highest: Option<(u32, Fault)>,
    lowest: Option<u32>,
}

/// The triangles of a PLY file.
///
/// # Errors
/// A broken head, a file that ends too early, indices of no vertex, and a file without any face; with
/// the line or the byte.
pub fn parse(bytes: &[u8]) -> Result<Ply, Fault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut head = Head { bytes, at: 0, line: 0 };
    let (encoding, elements) = head.read()?;
    let mut values = Values { bytes, at: head.at, line: head.line + 1, encoding };
    let mut reading = Reading::default();
    for element in &elements {
        match &*element.name {
            b"vertex" if reading.data.positions.is_empty() => {
                reading.vertices(&mut values, element)?;
            }
            b"face" => reading.lists(&mut values, element, Reading::face)?,
            b"tristrips" => reading.lists(&mut values, element, Reading::strip)?,
            _ => {
                if element.count > 0 {
                    reading.passed_over.push(shown(&element.name));
                }
                // Elements without properties take no bytes, however many they are.
                let count = if element.properties.is_empty() { 0 } else { element.count };
                for _ in 0..count {
                    element.properties.iter().try_for_each(|p| values.skip(p))?;
                }
            }
        }
    }
    reading.end()
}

impl Reading {
    fn vertices(&mut self, values: &mut Values<'_>, element: &Element) -> Result<(), Fault> {
        let slots: Vec<Slot> = element.properties.iter().map(Slot::of).collect();
        let has = |slot: Slot| slots.contains(&slot);
        if !(0..3).all(|axis| has(Slot::Position(axis))) {
            return Err(Fault::file("its element `vertex` lacks one of x, y and z"));
        }
        let normals = (0..3).all(|axis| has(Slot::Normal(axis)));
        let uvs = has(Slot::Uv(0)) && has(Slot::Uv(1));
        let colours = (0..3).all(|part| has(Slot::Colour(part)));
        let is_read = |slot: Slot| match slot {
            Slot::Position(_) => true,
            Slot::Normal(_) => normals,
            Slot::Uv(_) => uvs,
            Slot::Colour(_) => colours,
            Slot::Nowhere => false,
        };
        self.pass_over(element, |at| is_read(slots[at]));
        // The head was held against the file's length.
        let most = element.count as usize;
        self.data.positions.reserve(most);
        self.data.normals.reserve(if normals { most } else { 0 });
        self.data.uvs.reserve(if uvs { most } else { 0 });
        self.data.colours.reserve(if colours { most } else { 0 });
        for _ in 0..element.count {
            let (mut position, mut normal, mut uv) = ([0.0; 3], [0.0; 3], [0.0; 2]);
            let mut colour = [1.0; 3];
            for (property, slot) in element.properties.iter().zip(&slots) {
                if *slot == Slot::Nowhere {
                    values.skip(property)?;
                    continue;
                }
                let at = values.at;
                let wide = values.next(property.number)?;
                let value = wide as f32;
                if wide.is_finite() && !value.is_finite() {
                    let message = format!("{wide:e} is beyond the range of f32; scale the mesh");
                    return Err(values.fault(at, message));
                }
                match *slot {
                    Slot::Position(axis) => position[axis] = value,
                    Slot::Normal(axis) => normal[axis] = value,
                    Slot::Uv(axis) => uv[axis] = if value.is_finite() { value } else { 0.0 },
                    Slot::Colour(part) => colour[part] = intensity(wide, property.number),
                    Slot::Nowhere => {}
                }
            }
            self.data.positions.push(position);
            // A normal of no length counts as one that is not finite.
            let normal = if normal == [0.0; 3] { [f32::NAN; 3] } else { normal };
            self.data.normals.extend(normals.then_some(normal));
            self.data.uvs.extend(uvs.then_some(uv));
            self.data.colours.extend(colours.then_some(colour));
        }
        Ok(())
    }

    /// Remembers the properties that are not read.
    fn pass_over(&mut self, element: &Element, is_read: impl Fn(usize) -> bool) {
        let (of, number) = (String::from_utf8_lossy(&element.name), element.properties.len());
        for (at, property) in (0..number).zip(&element.properties) {
            if !is_read(at) && element.count > 0 {
                let name = String::from_utf8_lossy(&property.name);
                self.passed_over.push(shown(format!("{of}.{name}").as_bytes()));
            }
        }
    }

    /// Reads an element that has a list of vertices, which `add` takes.
    fn lists(
        &mut self,
        values: &mut Values<'_>,
        element: &Element,
        mut add: impl FnMut(&mut Self, &mut Values<'_>, usize, Number) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let is_list = |p: &Property| {
            p.length.is_some() && matches!(&*p.name, b"vertex_indices" | b"vertex_index")
        };
        let Some(list) = element.properties.iter().position(is_list) else {
            let message =
                format!("its element {} has no list `vertex_indices`", shown(&element.name));
            return Err(Fault::file(message));
        };
        self.pass_over(element, |at| at == list);
        // A triangle takes four bytes at least.
        self.faces.reserve((element.count as usize).min((values.bytes.len() - values.at) / 4));
        for _ in 0..element.count {
            for (at, property) in element.properties.iter().enumerate() {
                match property.length.filter(|_| at == list) {
                    Some(length) => {
                        let length = values.length(length)?;
                        add(self, values, length, property.number)?;
                    }
                    None => values.skip(property)?,
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, index: f64, at: usize, values: &Values<'_>) -> Result<u32, Fault> {
        let asked = || values.fault(at, format!("vertex {index} is asked for"));
        if !(index >= 0.0 && index.fract() == 0.0 && index < f64::from(u32::MAX)) {
            return Err(asked());
        }
        let index = index as u32;
        if self.highest.as_ref().is_none_or(|(highest, _)| index > *highest) {
            self.highest = Some((index, asked()));
        }
        self.lowest = Some(self.lowest.map_or(index, |lowest| lowest.min(index)));
        Ok(index)
    }

    fn face(
        &mut self,
        values: &mut Values<'_>,
        length: usize,
        number: Number,
    ) -> Result<(), Fault> {
        let line = (values.encoding == Encoding::Ascii).then_some(values.line);
        for _ in 0..length {
            let at = values.at;
            let index = values.next(number)?;
            let corner = self.vertex(index, at, values)?;
            self.faces.push(corner);
        }
        if !self.faces.close() {
            self.left_out.add(FEW_CORNERS, line);
        }
        Ok(())
    }

    /// Triangles of which each shares an edge with the one before.
    fn strip(
        &mut self,
        values: &mut Values<'_>,
        length: usize,
        number: Number,
    ) -> Result<(), Fault> {
        let (mut last, mut count) = ([0; 2], 0_usize);
        for _ in 0..length {
            let at = values.at;
            let index = values.next(number)?;
            if index == -1.0 {
                count = 0;
                continue;
            }
            let corner = self.vertex(index, at, values)?;
            if count >= 2 {
                // Every other one is turned over.
                let [a, b] = if count.is_multiple_of(2) { last } else { [last[1], last[0]] };
                [a, b, corner].into_iter().for_each(|corner| self.faces.push(corner));
                self.faces.close();
            }
            last = [last[1], corner];
            count += 1;
        }
        Ok(())
    }

    fn end(mut self) -> Result<Ply, Fault> {
        let count = self.data.positions.len();
        if let Some((index, fault)) =
            self.highest.take().filter(|(index, _)| *index as usize >= count)
        {
            let from_1 = index as usize == count && self.lowest == Some(1);
            let hint = if from_1 { "; they are counted from 0" } else { " (counted from 0)" };
            let message = format!("{}, there are {count}{hint}", fault.message);
            return Err(Fault { message, ..fault });
        }
        if self.faces.len() == 0 {
            let mut told = self.left_out.told();
            if !self.passed_over.is_empty() {
                told.push(format!("not read: {}", self.passed_over.join(", ")));
            }
            let but =
                if told.is_empty() { String::new() } else { format!(" ({})", told.join("; ")) };
            let message =
                format!("holds {count} vertices and no face: a point cloud is no surface{but}");
            return Err(Fault::file(message));
        }
        let Self { data, faces, left_out, .. } = &mut self;
        let positions = &data.positions;
        let mut triangles = Vec::with_capacity(faces.len());
        faces.triangles(
            |vertex| positions[vertex as usize],
            left_out,
            |_, corners| triangles.push(corners),
        );
        data.triangles = triangles;
        left_out.add_all(WITHOUT_AREA, finish(data), None);
        let mut left_out = left_out.told();
        if self.data.triangles.is_empty() {
            let told = left_out.join("; ");
            return Err(Fault::file(format!("holds no triangle that can be seen: {told}")));
        }
        if !self.passed_over.is_empty() {
            left_out.push(format!("not read: {}", self.passed_over.join(", ")));
        }
        Ok(Ply { data: self.data, left_out })
    }
}

/// A part of a colour, of which whole numbers are sRGB from 0 to their type's greatest.
fn intensity(value: f64, number: Number) -> f32 {
    let most = match number {
        Number::I8 => f64::from(i8::MAX),
        Number::U8 => f64::from(u8::MAX),
        Number::I16 => f64::from(i16::MAX),
        Number::U16 => f64::from(u16::MAX),
        // Wide whole numbers hold bytes.
        Number::I32 | Number::U32 => f64::from(u8::MAX),
        Number::F32 | Number::F64 => 1.0,
    };
    if value.is_finite() { linear((value / most).clamp(0.0, 1.0)) } else { 1.0 }
}
