//! Wavefront OBJ to columns.
//!
//! Source: "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, Wavefront, 1995.
//! - `v x y z`; a fourth value (the weight, which polygons do not use) or a colour after it must be
//!   numbers and is ignored. `vt u v` and `vn x y z` likewise.
//! - `f` with corners `a`, `a/b`, `a//c` or `a/b/c`: vertex, texture vertex and normal, counted from
//!   1, or, when negative, back from the last one so far. A polygon becomes a fan from its first
//!   corner, so it should be convex. Texture vertices and normals serve if every corner has one; a
//!   vertex is then stored once for each pair of them.
//! - `usemtl` names the material of what follows, `mtllib` the files that describe it.
//! - `\` before a line's end continues it, `#` starts a comment.
//! - The format's other statements (groups, curves) are ignored; words that the format does not know
//!   are ignored and counted.

pub use crate::error::Fault;
use crate::finish::finish;
use crate::words::{Words, number, shown};
use reflet_scene::{MeshData, MeshMaterial};
use std::collections::HashMap;

/// What an OBJ file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obj {
    /// The vertices, the triangles that have an area, and the names of their materials.
    pub data: MeshData,
    /// Triangles left out because they have no area.
    pub without_area: u64,
    /// Statements whose first word the format does not know.
    pub unknown: u64,
    /// The line of the first of them, counted from 1.
    pub unknown_line: Option<u64>,
    /// What `mtllib` lines name, each as the whole rest of its line.
    pub libraries: Vec<String>,
    /// Texture vertices, or normals, that were left out because some corners have none.
    pub partial: Vec<&'static str>,
}

/// The format's statements that say nothing about where triangles are.
const IGNORED: &[&[u8]] = &[
    b"vp",
    b"g",
    b"o",
    b"s",
    b"mg",
    b"maplib",
    b"usemap",
    b"l",
    b"p",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"call",
    b"csh",
];

/// A corner of a face: vertex, texture vertex and normal, counted from 0.
type Corner = [u32; 3];

/// For a corner without texture vertex or normal.
const NONE: u32 = u32::MAX;

/// What the three numbers of a corner count.
const KINDS: [&str; 3] = ["vertex", "texture vertex", "normal"];

/// A file half read.
#[derive(Default)]
struct Reading {
    obj: Obj,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    corners: Vec<[Corner; 3]>,
    /// The highest of each kind that a face asked for before it was there, and the line of that face.
    ahead: [Option<(i64, u64)>; 3],
    /// Indices of materials by name, and of the one in use.
    names: HashMap<String, u32>,
    wears: Option<u32>,
}

/// The triangles in the text of an OBJ file.
///
/// # Errors
/// Broken or non-finite numbers, faces of fewer than three corners, indices of no vertex, and a
/// file without any face, each with its line.
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
            Some(b"v") => self.obj.data.positions.push(vertex(words)?),
            Some(b"vt") => {
                let u = words.number("vt", "a texture vertex")?;
                let mut uv = [u, 0.0];
                // The second number may be left out, a third one is ignored.
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
                self.normals.push(normal);
            }
            Some(b"f") => self.face(words)?,
            Some(b"usemtl") => self.wear(words.rest()),
            Some(b"mtllib") => {
                let name = words.rest();
                if !name.is_empty() && !self.obj.libraries.contains(&name) {
                    self.obj.libraries.push(name);
                }
            }
            Some(word) if IGNORED.contains(&word) => {}
            Some(_) => {
                self.obj.unknown += 1;
                self.obj.unknown_line.get_or_insert(words.line);
            }
        }
        Ok(())
    }

    /// What faces wear from now on.
    fn wear(&mut self, name: String) {
        let data = &mut self.obj.data;
        if self.wears.is_none() && !self.corners.is_empty() {
            // Those before wear none.
            self.names.insert(String::new(), 0);
            data.materials.push(MeshMaterial::grey(""));
            data.triangle_materials.resize(self.corners.len(), 0);
        }
        let next = data.materials.len() as u32;
        self.wears = Some(*self.names.entry(name.clone()).or_insert(next));
        if self.wears == Some(next) {
            data.materials.push(MeshMaterial::grey(name));
        }
    }

    fn face(&mut self, words: &mut Words<'_>) -> Result<(), Fault> {
        let counts = [self.obj.data.positions.len(), self.uvs.len(), self.normals.len()];
        let (mut first, mut last, mut corners) = ([0; 3], [0; 3], 0u64);
        while let Some(word) = words.next() {
            let told = corner_of(word, words.line)?;
            let mut corner = [NONE; 3];
            for kind in 0..3 {
                let Some(index) = told[kind] else { continue };
                let count = counts[kind];
                let none = || Fault::line(words.line, no_such(kind, index, count));
                let from_1 = if index > 0 { index } else { count as i64 + 1 + index };
                corner[kind] = match u32::try_from(from_1 - 1) {
                    Ok(found) if found != NONE => found,
                    _ => return Err(none()),
                };
                let most = &mut self.ahead[kind];
                if from_1 > count as i64 && most.is_none_or(|(most, _)| from_1 > most) {
                    *most = Some((from_1, words.line));
                }
            }
            match corners {
                0 => first = corner,
                1 => {}
                _ => {
                    self.corners.push([first, last, corner]);
                    self.obj.data.triangle_materials.extend(self.wears);
                }
            }
            last = corner;
            corners += 1;
        }
        if corners < 3 {
            let message =
                format!("a face needs three corners, this one has {corners}; mend the `f` line");
            return Err(Fault::line(words.line, message));
        }
        Ok(())
    }

    fn end(mut self) -> Result<Obj, Fault> {
        let counts = [self.obj.data.positions.len(), self.uvs.len(), self.normals.len()];
        for (kind, (count, ahead)) in counts.into_iter().zip(self.ahead).enumerate() {
            if let Some((index, line)) = ahead.filter(|(index, _)| *index > count as i64) {
                return Err(Fault::line(line, no_such(kind, index, count)));
            }
        }
        if self.corners.is_empty() {
            let message = "holds no face (`f` line); is it a Wavefront OBJ file?";
            return Err(Fault::file(message));
        }
        let has = |kind: usize| {
            let some = self.corners.iter().flatten().any(|corner| corner[kind] != NONE);
            let all = some && self.corners.iter().flatten().all(|corner| corner[kind] != NONE);
            (some, all)
        };
        let (uvs, normals) = (has(1), has(2));
        for ((some, all), noun) in [(uvs, "texture vertices"), (normals, "normals")] {
            if some && !all {
                self.obj.partial.push(noun);
            }
        }
        match (uvs.1, normals.1) {
            (false, false) => {
                let corners = self.corners.iter();
                self.obj.data.triangles =
                    corners.map(|corners| corners.map(|[vertex, ..]| vertex)).collect();
            }
            (uvs, normals) => self.split(uvs, normals),
        }
        self.corners = Vec::new();
        self.obj.without_area = finish(&mut self.obj.data);
        Ok(self.obj)
    }

    /// One vertex for each group of vertex, texture vertex and normal that a corner has.
    fn split(&mut self, uvs: bool, normals: bool) {
        let data = &mut self.obj.data;
        let positions = std::mem::take(&mut data.positions);
        // The group that a vertex was last in is mostly the one that it is in again.
        let mut last = vec![(NONE, NONE, NONE); positions.len()];
        let mut groups: HashMap<Corner, u32> = HashMap::new();
        for corners in &self.corners {
            data.triangles.push(corners.map(|[vertex, uv, normal]| {
                let uv = if uvs { uv } else { NONE };
                let normal = if normals { normal } else { NONE };
                let recent = &mut last[vertex as usize];
                if (recent.0, recent.1) == (uv, normal) && recent.2 != NONE {
                    return recent.2;
                }
                let index = *groups.entry([vertex, uv, normal]).or_insert_with(|| {
                    data.positions.push(positions[vertex as usize]);
                    data.uvs.extend(uvs.then(|| self.uvs[uv as usize]));
                    data.normals.extend(normals.then(|| self.normals[normal as usize]));
                    data.positions.len() as u32 - 1
                });
                *recent = (uv, normal, index);
                index
            }));
        }
    }
}

fn vertex(words: &mut Words<'_>) -> Result<[f32; 3], Fault> {
    let mut position = [0.0; 3];
    for (i, slot) in position.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            let message =
                format!("a vertex needs three coordinates, this one has {i}; mend the `v` line");
            return Err(Fault::line(words.line, message));
        };
        *slot = number(word, words.line, "v")?;
    }
    while let Some(word) = words.next() {
        number(word, words.line, "v")?;
    }
    Ok(position)
}

/// The numbers of a corner `a`, `a/b`, `a//c` or `a/b/c`: not 0, perhaps negative.
fn corner_of(word: &[u8], line: u64) -> Result<[Option<i64>; 3], Fault> {
    let mut parts = word.split(|b| *b == b'/');
    let vertex = parts.next().and_then(integer);
    let second = parts.next();
    let third = parts.next();
    let (texture, normal) = (second.and_then(integer), third.and_then(integer));
    // A corner may leave out its texture vertex (`a//c`), and nothing else.
    let whole = match (second, third) {
        (None, _) => true,
        (Some(_), None) => texture.is_some(),
        (Some(second), Some(_)) => (second.is_empty() || texture.is_some()) && normal.is_some(),
    };
    let all = [vertex, texture, normal];
    if vertex.is_none() || !whole || parts.next().is_some() {
        let message =
            format!("{} is no corner of a face; write a, a/b, a//c or a/b/c", shown(word));
        return Err(Fault::line(line, message));
    }
    if let Some(kind) = all.iter().position(|number| *number == Some(0)) {
        let noun = KINDS[kind];
        let message = format!("{noun} 0 is asked for; they are counted from 1");
        return Err(Fault::line(line, message));
    }
    Ok(all)
}

/// A decimal integer, held within ±2^40: beyond that there is no vertex anyway.
fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0i64;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = (value * 10 + i64::from(digit - b'0')).min(1 << 40);
    }
    Some(if negative { -value } else { value })
}

fn no_such(kind: usize, index: i64, count: usize) -> String {
    format!("{} {index} is asked for, there are {count}; mend the `f` line", KINDS[kind])
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOUR: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn triangles(faces: &str) -> Vec<[u32; 3]> {
        parse(format!("{FOUR}{faces}").as_bytes()).unwrap().data.triangles
    }

    fn fault(text: &str) -> (Option<u64>, String) {
        let fault = parse(text.as_bytes()).unwrap_err();
        (fault.line, fault.message)
    }

    #[test]
    fn corners_in_every_form() {
        let more = "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n";
        for face in
            ["f 1 2 3", "f 1/3 2/2 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/2/1 3/3/-1", "f -4 -3 -2"]
        {
            assert_eq!(triangles(&format!("{more}{face}")), [[0, 1, 2]], "{face}");
        }
        assert_eq!(triangles("f  1\t2  3 # a comment\r\n"), [[0, 1, 2]]);
        assert_eq!(triangles("f 1 \\\n2\\\r\n 3 4"), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn polygons_are_fans() {
        assert_eq!(triangles("f 1 2 3 4"), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangles("f 2 3 4 1\nf 1 2 3"), [[1, 2, 3], [1, 3, 0], [0, 1, 2]]);
    }

    #[test]
    fn negative_indices_count_from_where_they_stand() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -3 -2 -1\n";
        assert_eq!(parse(text.as_bytes()).unwrap().data.triangles, [[0, 1, 2], [1, 2, 3]]);
    }

    #[test]
    fn faces_may_stand_before_their_vertices() {
        let text = format!("f 1 2 3\n{FOUR}");
        assert_eq!(parse(text.as_bytes()).unwrap().data.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn line_ends_of_all_systems_and_none_at_the_end() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["\u{feff}# x", "v 0 0 0", "v 1 0 0", "", "v 0 1 0", "f 1 2 3"].join(end);
            assert_eq!(parse(text.as_bytes()).unwrap().data.triangles, [[0, 1, 2]], "{end:?}");
        }
    }

    #[test]
    fn vertices_keep_their_bits() {
        let text = "v 0.1 -1e-3 +3.5e2 1.0\nv 1 0 0 0.5 0.5 0.5\nv 16777217 0 1e-45\nf 1 2 3\n";
        let data = parse(text.as_bytes()).unwrap().data;
        let expected = [[0.1, -1e-3, 350.0], [1.0, 0.0, 0.0], [16777216.0, 0.0, f32::from_bits(1)]];
        assert_eq!(data.positions, expected);
    }

    #[test]
    fn triangles_without_area_are_counted() {
        let text = format!(
            "{FOUR}v 0.3 0.3 0\nv 2 2 0\nv 1e-40 0 0\nv 0 1e-40 0\nf 1 3 6\nf 1 1 2\nf 1 5 6\nf 1 7 8\n"
        );
        let obj = parse(text.as_bytes()).unwrap();
        assert_eq!(obj.without_area, 3);
        assert_eq!(obj.data.triangles, [[0, 6, 7]], "tiny is not without area");
        // A needle 1e7 long and 1 wide has an area of 5e6.
        let needle = parse(b"v 0 0 0\nv 10000000 0 0\nv 10000000 1 0\nf 1 2 3").unwrap();
        assert_eq!(needle.without_area, 0);
    }

    #[test]
    fn other_statements_are_ignored_and_unknown_ones_counted() {
        let text = format!(
            "mtllib a b\n{FOUR}vt 0 0\nvn 0 0 1\ng \\\nf 9 9 9\no b\ns off\nhello\nusemtl m\nf 1 2 3\nworld\n"
        );
        let obj = parse(text.as_bytes()).unwrap();
        assert_eq!((obj.unknown, obj.unknown_line), (2, Some(12)));
        assert_eq!(obj.data.triangles.len(), 1);
    }

    #[test]
    fn every_fault_has_its_line_and_its_words() {
        let cases: &[(&str, u64, &str)] = &[
            (
                "v 0 0 0\nv 1 2\n",
                2,
                "a vertex needs three coordinates, this one has 2; mend the `v` line",
            ),
            ("v 0 zero 0\n", 1, "`zero` is not a number; mend the `v` line"),
            ("v 0 0 0 red\n", 1, "`red` is not a number; mend the `v` line"),
            (
                "\n\nv 0 nan 0\n",
                3,
                "`nan` is not finite, or beyond the range of f32; scale the mesh",
            ),
            ("v 0 -inf 0\n", 1, "`-inf` is not finite, or beyond the range of f32; scale the mesh"),
            ("v 1e39 0 0\n", 1, "`1e39` is not finite, or beyond the range of f32; scale the mesh"),
            (
                "v 0 0 0\nf 1 1\n",
                2,
                "a face needs three corners, this one has 2; mend the `f` line",
            ),
            ("v 0 0 0\nf 1 1 2\n", 2, "vertex 2 is asked for, there are 1; mend the `f` line"),
            ("v 0 0 0\nf -2 1 1\n", 2, "vertex -2 is asked for, there are 1; mend the `f` line"),
            ("v 0 0 0\nf 0 1 1\n", 2, "vertex 0 is asked for; they are counted from 1"),
            (
                "v 0 0 0\nf 1 9999999999 1\n",
                2,
                "vertex 9999999999 is asked for, there are 1; mend the `f` line",
            ),
            ("v 0 0 0\nf 1 1 1/\n", 2, "`1/` is no corner of a face; write a, a/b, a//c or a/b/c"),
            (
                "v 0 0 0\nf 1 1 1/2/\n",
                2,
                "`1/2/` is no corner of a face; write a, a/b, a//c or a/b/c",
            ),
            (
                "v 0 0 0\nf 1 1 1/2/3/4\n",
                2,
                "`1/2/3/4` is no corner of a face; write a, a/b, a//c or a/b/c",
            ),
            (
                "v 0 0 0\nf 1 1 1.5\n",
                2,
                "`1.5` is no corner of a face; write a, a/b, a//c or a/b/c",
            ),
            ("v 0 0 0\nf 1 1 /2\n", 2, "`/2` is no corner of a face; write a, a/b, a//c or a/b/c"),
            (
                "v 0 0 0\n# \\\nf 1 \\\n1 x\n",
                4,
                "`x` is no corner of a face; write a, a/b, a//c or a/b/c",
            ),
        ];
        for (text, line, message) in cases {
            assert_eq!(fault(text), (Some(*line), (*message).to_string()), "{text:?}");
        }
        let none = (None, "holds no face (`f` line); is it a Wavefront OBJ file?".to_string());
        for text in ["", "v 0 0 0\n", "\u{0}\u{1}PNG\n\n", "\\"] {
            assert_eq!(fault(text), none, "{text:?}");
        }
    }
}
