//! Wavefront OBJ to columns.
//!
//! Source: "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, Wavefront, 1995.
//! - `v x y z`, with a weight (which polygons do not use) or a colour (red, green, blue in 0..1, sRGB,
//!   as MeshLab and Blender write them) after it; `vt u v` and `vn x y z`.
//! - `f` with corners `a`, `a/b`, `a//c` or `a/b/c`: vertex, texture vertex and normal, counted from
//!   1, or, when negative, back from the last one so far; numbers may be missing after a slash. Faces
//!   of fewer than three corners are left out. A vertex is stored once for each group of the three.
//! - `usemtl` names the material of what follows, `mtllib` the files that describe it.
//! - `\` before a line's end continues it, `#` starts a comment.
//! - Numbers that are not finite count as none: a face with such a corner is left out, a normal
//!   becomes that of the triangles around it.
//! - Lines, points, curves, and words that the format does not know are left out and counted; groups
//!   say nothing about where triangles are.

mod corner;

pub use crate::error::Fault;
use crate::faces::Faces;
use crate::finish::finish;
use crate::left_out::{FEW_CORNERS, Kind, LeftOut, WITHOUT_AREA};
use crate::texture::linear;
use crate::words::{Words, number};
use corner::{Corner, NONE, corner_of};
use reflet_scene::{MeshData, MeshMaterial};
use std::collections::{HashMap, HashSet};

/// What an OBJ file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obj {
    /// The vertices, the triangles that have an area, and the names of their materials.
    pub data: MeshData,
    /// What was left out, in words.
    pub left_out: Vec<String>,
    /// What `mtllib` lines name, each as the whole rest of its line.
    pub libraries: Vec<String>,
}

/// Statements of the format that say nothing about where triangles are.
const SILENT: &[&[u8]] = &[
    b"vp",
    b"g",
    b"o",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"ctech",
    b"stech",
];

/// Statements of the format that are left out.
const LEFT_OUT: &[(&[u8], Kind)] = &[
    (b"l", Kind::new("line (`l`) left out", "lines (`l`) left out")),
    (b"p", Kind::new("point (`p`) left out", "points (`p`) left out")),
    (b"curv", CURVES),
    (b"curv2", CURVES),
    (b"surf", CURVES),
    (b"usemap", MAPS),
    (b"maplib", MAPS),
    (b"call", CALLS),
    (b"csh", CALLS),
    (b"shadow_obj", CALLS),
    (b"trace_obj", CALLS),
];
const CURVES: Kind =
    Kind::new("free-form curve or surface left out", "free-form curves and surfaces left out");
const MAPS: Kind = Kind::new("texture map statement left out", "texture map statements left out");
const CALLS: Kind =
    Kind::new("mention of another file left out", "mentions of other files left out");
const SMOOTHED: Kind = Kind::new(
    "smoothing group left out: its faces have no normals",
    "smoothing groups left out: their faces have no normals",
);
const UNKNOWN: Kind = Kind::new("unknown statement ignored", "unknown statements ignored");
const WITHOUT_UV: Kind = Kind::new(
    "corner without texture coordinates, which others have, takes (0, 0)",
    "corners without texture coordinates, which others have, take (0, 0)",
);
const ABSENT: [Kind; 3] = [
    UNKNOWN,
    Kind::new(
        "corner asks for a texture vertex that is not there",
        "corners ask for texture vertices that are not there",
    ),
    Kind::new(
        "corner asks for a normal that is not there",
        "corners ask for normals that are not there",
    ),
];

/// A file half read.
#[derive(Default)]
struct Reading {
    obj: Obj,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Colours by vertex, as far as there are any.
    colours: Vec<[f32; 3]>,
    faces: Faces<Corner>,
    /// What each face wears.
    worn: Vec<u32>,
    /// The libraries so far.
    named: HashSet<String>,
    left_out: LeftOut,
    /// The highest vertex that a face asked for before it was there, and the line of that face.
    ahead: Option<(i64, u64)>,
    /// Indices of materials by name, and of the one in use.
    names: HashMap<String, u32>,
    wears: Option<u32>,
    /// Lines that begin a smoothing group, and the first of them.
    smoothed: u64,
    smoothed_line: Option<u64>,
}

/// The triangles in the text of an OBJ file.
///
/// # Errors
/// Broken numbers, corners that are none, indices of no vertex, and a file without any face, each
/// with its line.
pub fn parse(text: &[u8]) -> Result<Obj, Fault> {
    let mut words = Words::of(text);
    let mut reading = Reading::default();
    while !words.is_empty() {
        reading.statement(&mut words)?;
        words.next_line();
    }
    reading.end()
}

impl Reading {
    fn statement(&mut self, words: &mut Words<'_>) -> Result<(), Fault> {
        match words.next() {
            None => {}
            Some(b"v") => self.vertex(words)?,
            Some(b"vt") => {
                let mut uv = [words.number("vt", "a texture vertex")?, 0.0];
                // The second number may be left out, a third one is a depth.
                let mut at = 1;
                while let Some(word) = words.next() {
                    let value = number(word, words.line, "vt")?;
                    if at == 1 {
                        uv[1] = value;
                    }
                    at += 1;
                }
                self.uvs.push(uv);
            }
            Some(b"vn") => {
                let mut normal = [0.0; 3];
                for value in &mut normal {
                    *value = words.number("vn", "a normal")?;
                }
                // One of no length counts as one that is not finite.
                let is_none = normal == [0.0; 3];
                self.normals.push(if is_none { [f32::NAN; 3] } else { normal });
            }
            // `fo` is what `f` was called in the format's first version.
            Some(b"f" | b"fo") => self.face(words)?,
            Some(b"usemtl") => self.wear(words.rest()),
            Some(b"mtllib") => {
                let name = words.rest();
                if !name.is_empty() && self.named.insert(name.clone()) {
                    self.obj.libraries.push(name);
                }
            }
            Some(b"s") if matches!(words.next(), None | Some(b"off" | b"0")) => {}
            Some(b"s") => {
                self.smoothed += 1;
                self.smoothed_line.get_or_insert(words.line);
            }
            Some(word) if SILENT.contains(&word) => {}
            Some(word) => {
                let known = LEFT_OUT.iter().find(|(name, _)| *name == word);
                self.left_out.add(known.map_or(UNKNOWN, |(_, kind)| *kind), Some(words.line));
            }
        }
        Ok(())
    }

    fn vertex(&mut self, words: &mut Words<'_>) -> Result<(), Fault> {
        let mut numbers = [0.0; 7];
        let mut count = 0;
        while let Some(word) = words.next() {
            let value = number(word, words.line, "v")?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = value;
            }
            count += 1;
        }
        let [x, y, z, rest @ ..] = numbers;
        if count < 3 {
            let message = format!(
                "a vertex needs three coordinates, this one has {count}; mend the `v` line"
            );
            return Err(Fault::line(words.line, message));
        }
        let colour = match count {
            6 => Some([rest[0], rest[1], rest[2]]),
            7 => Some([rest[1], rest[2], rest[3]]),
            _ => None,
        };
        if let Some(colour) = colour {
            self.colours.resize(self.obj.data.positions.len(), [1.0; 3]);
            self.colours.push(
                colour.map(
                    |x| if x.is_finite() { linear(f64::from(x).clamp(0.0, 1.0)) } else { 1.0 },
                ),
            );
        }
        self.obj.data.positions.push([x, y, z]);
        Ok(())
    }

    /// What faces wear from now on.
    fn wear(&mut self, name: String) {
        let data = &mut self.obj.data;
        if self.wears.is_none() && self.faces.len() > 0 {
            // Those before wear none.
            self.names.insert(String::new(), 0);
            data.materials.push(MeshMaterial::grey(""));
            self.worn.resize(self.faces.len(), 0);
        }
        let next = data.materials.len() as u32;
        let index = match self.names.get(&name) {
            Some(index) => *index,
            None => {
                data.materials.push(MeshMaterial::grey(name.clone()));
                self.names.insert(name, next);
                next
            }
        };
        self.wears = Some(index);
    }

    fn face(&mut self, words: &mut Words<'_>) -> Result<(), Fault> {
        let counts = [self.obj.data.positions.len(), self.uvs.len(), self.normals.len()];
        while let Some(word) = words.next() {
            let told = corner_of(word, words.line)?;
            let mut corner = [NONE; 3];
            for kind in 0..3 {
                let Some(index) = told[kind] else { continue };
                if index == 0 {
                    // Some programs write 0 for what is not there.
                    continue;
                }
                let count = counts[kind];
                let from_1 = if index > 0 { index } else { count as i64 + 1 + index };
                match u32::try_from(from_1 - 1) {
                    Ok(found) if found != NONE => corner[kind] = found,
                    _ if kind == 0 => return Err(no_such(index, count, words.line)),
                    _ => self.left_out.add(ABSENT[kind], Some(words.line)),
                }
                let ahead = kind == 0 && from_1 > count as i64;
                if ahead && self.ahead.is_none_or(|(most, _)| from_1 > most) {
                    self.ahead = Some((from_1, words.line));
                }
            }
            self.faces.push(corner);
        }
        if self.faces.close() {
            self.worn.extend(self.wears);
        } else {
            self.left_out.add(FEW_CORNERS, Some(words.line));
        }
        Ok(())
    }

    fn end(mut self) -> Result<Obj, Fault> {
        let count = self.obj.data.positions.len();
        if let Some((index, line)) = self.ahead.filter(|(index, _)| *index > count as i64) {
            return Err(no_such(index, count, line));
        }
        if self.faces.len() == 0 {
            let told = self.left_out.told();
            return Err(Fault::file(match told.is_empty() || count == 0 {
                true => "holds no face (`f` line); is it a Wavefront OBJ file?".to_owned(),
                false => format!("holds no face (`f` line), but: {}", told.join("; ")),
            }));
        }
        self.triangles();
        let without_area = finish(&mut self.obj.data);
        self.left_out.add_all(WITHOUT_AREA, without_area, None);
        if self.obj.data.triangles.is_empty() {
            let told = self.left_out.told().join("; ");
            return Err(Fault::file(format!("holds no triangle that can be seen: {told}")));
        }
        self.obj.left_out = self.left_out.told();
        Ok(self.obj)
    }

    /// Cuts faces into triangles, with one vertex for each group of vertex, texture vertex and normal
    /// that a corner has.
    fn triangles(&mut self) {
        let Self { faces, uvs, normals, left_out, .. } = self;
        let uv_of = |corner: Corner| {
            uvs.get(corner[1] as usize).filter(|uv| uv.iter().all(|x| x.is_finite()))
        };
        let normal_of = |corner: Corner| normals.get(corner[2] as usize);
        let (mut has_uv, mut has_normal) = (0, 0);
        let mut absent = [0; 3];
        for corner in faces.corners() {
            has_uv += u64::from(uv_of(*corner).is_some());
            has_normal += u64::from(normal_of(*corner).is_some());
            for (kind, count) in [(1, uvs.len()), (2, normals.len())] {
                absent[kind] += u64::from(corner[kind] != NONE && corner[kind] as usize >= count);
            }
        }
        let corners = faces.corners().len() as u64;
        (1..3).for_each(|kind| left_out.add_all(ABSENT[kind], absent[kind], None));
        if has_uv > 0 {
            left_out.add_all(WITHOUT_UV, corners - has_uv, None);
        }
        if has_normal < corners {
            left_out.add_all(SMOOTHED, self.smoothed, self.smoothed_line);
        }
        let data = &mut self.obj.data;
        if !self.colours.is_empty() {
            self.colours.resize(data.positions.len(), [1.0; 3]);
        }
        let worn = &self.worn;
        let mut triangle_materials = Vec::new();
        let mut triangles = Vec::with_capacity(corners as usize / 3);
        let positions = std::mem::take(&mut data.positions);
        let place = |corner: Corner| positions[corner[0] as usize];
        if has_uv == 0 && has_normal == 0 {
            faces.triangles(place, left_out, |face, corners| {
                triangle_materials.extend(worn.get(face));
                triangles.push(corners.map(|[vertex, ..]| vertex));
            });
            data.positions = positions;
            data.colours = std::mem::take(&mut self.colours);
        } else {
            // The group that a vertex was last in is mostly the one that it is in again.
            let mut last = vec![(NONE, NONE, NONE); positions.len()];
            let mut groups: HashMap<Corner, u32> = HashMap::new();
            let colours = &self.colours;
            faces.triangles(place, left_out, |face, corners| {
                triangle_materials.extend(worn.get(face));
                triangles.push(corners.map(|corner| {
                    let (uv, normal) = (uv_of(corner), normal_of(corner));
                    let [vertex, u, n] = corner;
                    let group = [vertex, uv.map_or(NONE, |_| u), normal.map_or(NONE, |_| n)];
                    let recent = &mut last[vertex as usize];
                    if (recent.0, recent.1) == (group[1], group[2]) && recent.2 != NONE {
                        return recent.2;
                    }
                    let index = *groups.entry(group).or_insert_with(|| {
                        data.positions.push(positions[vertex as usize]);
                        data.colours.extend(colours.get(vertex as usize));
                        if has_uv > 0 {
                            data.uvs.push(uv.copied().unwrap_or_default());
                        }
                        if has_normal > 0 {
                            data.normals.push(normal.copied().unwrap_or_default());
                        }
                        data.positions.len() as u32 - 1
                    });
                    *recent = (group[1], group[2], index);
                    index
                }));
            });
        }
        data.triangles = triangles;
        data.triangle_materials = triangle_materials;
    }
}

fn no_such(index: i64, count: usize, line: u64) -> Fault {
    let message = format!("vertex {index} is asked for, there are {count}; mend the `f` line");
    Fault::line(line, message)
}

#[cfg(test)]
mod tests;
