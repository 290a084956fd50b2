//! Wavefront OBJ: `v` and `f` lines to columns.
//!
//! Source: "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, Wavefront, 1995.
//! - `v x y z`; a fourth value (the weight, which polygons do not use) or a colour after it must be
//!   numbers and is ignored.
//! - `f` with corners `a`, `a/b`, `a//c` or `a/b/c`, of which only the vertex `a` is used: counted
//!   from 1, or, when negative, back from the last vertex so far. A polygon becomes a fan from its
//!   first corner, so it should be convex.
//! - `\` before a line's end continues it, `#` starts a comment.
//! - The format's other statements (texture coordinates, normals, groups, materials, curves) are
//!   ignored; words that the format does not know are ignored and counted.

use reflet_scene::MeshData;

/// What an OBJ file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obj {
    /// The vertices and the triangles that have an area.
    pub data: MeshData,
    /// Triangles left out because they have no area.
    pub without_area: u64,
    /// Statements whose first word the format does not know.
    pub unknown: u64,
    /// The line of the first of them, counted from 1.
    pub unknown_line: Option<u64>,
}

/// What is wrong with an OBJ file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjFault {
    /// The line, counted from 1; `None` if the whole file is at fault.
    pub line: Option<u64>,
    /// What is wrong and what to do.
    pub message: String,
}

/// The format's statements that say nothing about where triangles are.
const IGNORED: &[&[u8]] = &[
    b"vt",
    b"vn",
    b"vp",
    b"g",
    b"o",
    b"s",
    b"mg",
    b"mtllib",
    b"usemtl",
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

/// The triangles in the text of an OBJ file.
///
/// # Errors
/// Broken or non-finite numbers, faces of fewer than three corners, indices of no vertex, and a
/// file without any face, each with its line.
pub fn parse(text: &[u8]) -> Result<Obj, ObjFault> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut words = Words { text, at: 0, line: 1 };
    let mut obj = Obj::default();
    // The highest vertex that a face asked for before it was there, and the line of that face.
    let mut ahead: Option<(i64, u64)> = None;
    while words.at < text.len() {
        match words.next() {
            None => {}
            Some(b"v") => obj.data.positions.push(vertex(&mut words)?),
            Some(b"f") => face(&mut words, &mut obj.data, &mut ahead)?,
            Some(word) if IGNORED.contains(&word) => {}
            Some(_) => {
                obj.unknown += 1;
                obj.unknown_line.get_or_insert(words.line);
            }
        }
        words.next_line();
    }
    let count = obj.data.positions.len();
    if let Some((index, line)) = ahead.filter(|(index, _)| *index as u64 > count as u64) {
        return Err(at(line, no_such_vertex(index, count)));
    }
    if obj.data.triangles.is_empty() {
        let message = "holds no face (`f` line); is it a Wavefront OBJ file?".into();
        return Err(ObjFault { line: None, message });
    }
    let MeshData { positions, triangles } = &mut obj.data;
    let before = triangles.len();
    triangles.retain(|t| has_area(t.map(|i| positions[i as usize])));
    obj.without_area = (before - triangles.len()) as u64;
    positions.shrink_to_fit();
    triangles.shrink_to_fit();
    Ok(obj)
}

/// Whether the corners span an area: differences and products of `f32` values, taken in `f64`, are
/// exact unless the coordinates' magnitudes lie more than 2^28 apart.
fn has_area([a, b, c]: [[f32; 3]; 3]) -> bool {
    let edge = |p: [f32; 3]| [0, 1, 2].map(|i| f64::from(p[i]) - f64::from(a[i]));
    let (u, v) = (edge(b), edge(c));
    (0..3).any(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        u[j] * v[k] != u[k] * v[j]
    })
}

fn vertex(words: &mut Words<'_>) -> Result<[f32; 3], ObjFault> {
    let mut position = [0.0; 3];
    for (i, slot) in position.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            let message =
                format!("a vertex needs three coordinates, this one has {i}; mend the `v` line");
            return Err(at(words.line, message));
        };
        *slot = number(word, words.line)?;
    }
    while let Some(word) = words.next() {
        number(word, words.line)?;
    }
    Ok(position)
}

fn number(word: &[u8], line: u64) -> Result<f32, ObjFault> {
    let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f32>().ok());
    match parsed {
        Some(x) if x.is_finite() => Ok(x),
        Some(_) => {
            let message = format!(
                "{} is not finite, or beyond the range of f32; scale the mesh",
                shown(word)
            );
            Err(at(line, message))
        }
        None => Err(at(line, format!("{} is not a number; mend the `v` line", shown(word)))),
    }
}

fn face(
    words: &mut Words<'_>,
    data: &mut MeshData,
    ahead: &mut Option<(i64, u64)>,
) -> Result<(), ObjFault> {
    let count = data.positions.len();
    let (mut first, mut last, mut corners) = (0, 0, 0u64);
    while let Some(word) = words.next() {
        let index = vertex_of(word, words.line)?;
        let index = if index > 0 { index } else { count as i64 + 1 + index };
        let vertex = match u32::try_from(index - 1) {
            Ok(vertex) if index > 0 => vertex,
            _ if index <= 0 => {
                let back = index - 1 - count as i64;
                return Err(at(words.line, no_such_vertex(back, count)));
            }
            _ => return Err(at(words.line, no_such_vertex(index, count))),
        };
        if vertex as usize >= count && ahead.is_none_or(|(most, _)| index > most) {
            *ahead = Some((index, words.line));
        }
        match corners {
            0 => first = vertex,
            1 => {}
            _ => data.triangles.push([first, last, vertex]),
        }
        last = vertex;
        corners += 1;
    }
    if corners < 3 {
        let message =
            format!("a face needs three corners, this one has {corners}; mend the `f` line");
        return Err(at(words.line, message));
    }
    Ok(())
}

/// The vertex number of a corner `a`, `a/b`, `a//c` or `a/b/c`: not 0, perhaps negative.
fn vertex_of(word: &[u8], line: u64) -> Result<i64, ObjFault> {
    let mut parts = word.split(|b| *b == b'/');
    let vertex = parts.next().and_then(integer);
    // A corner may leave out its texture vertex (`a//c`), and nothing else.
    let texture = parts.next().map(|p| p.is_empty() || integer(p).is_some());
    let normal = parts.next().map(|p| integer(p).is_some());
    let whole = match (texture, normal) {
        (None, _) => true,
        (Some(t), Some(n)) => t && n,
        (Some(t), None) => t && !word.ends_with(b"/"),
    };
    match vertex {
        Some(0) => Err(at(line, "vertex 0 is asked for; vertices are counted from 1".into())),
        Some(index) if whole && parts.next().is_none() => Ok(index),
        _ => {
            let message =
                format!("{} is no corner of a face; write a, a/b, a//c or a/b/c", shown(word));
            Err(at(line, message))
        }
    }
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

fn no_such_vertex(index: i64, count: usize) -> String {
    format!("vertex {index} is asked for, there are {count}; mend the `f` line")
}

fn at(line: u64, message: String) -> ObjFault {
    ObjFault { line: Some(line), message }
}

/// A word of the file for a message: short and printable.
fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(40)]);
    let text: String = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    format!("`{text}`")
}

/// The words of a text, line by line.
struct Words<'a> {
    text: &'a [u8],
    at: usize,
    /// The line that `at` stands in, counted from 1.
    line: u64,
}

impl<'a> Words<'a> {
    /// The next word of this line.
    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match self.text.get(self.at)? {
                b' ' | b'\t' => self.at += 1,
                b'\\' if self.line_end(self.at + 1) > 0 => {
                    self.at += 1 + self.line_end(self.at + 1);
                    self.line += 1;
                }
                b'\n' | b'\r' => return None,
                b'#' => {
                    self.skip_comment();
                    return None;
                }
                _ => break,
            }
        }
        let start = self.at;
        while let Some(byte) = self.text.get(self.at) {
            match byte {
                b' ' | b'\t' | b'\n' | b'\r' => break,
                b'\\' if self.line_end(self.at + 1) > 0 => break,
                _ => self.at += 1,
            }
        }
        Some(&self.text[start..self.at])
    }

    /// Goes to the start of the next line.
    fn next_line(&mut self) {
        while self.next().is_some() {
            // Word by word, so that a continued line is skipped whole.
        }
        let end = self.line_end(self.at);
        self.at += end;
        self.line += u64::from(end > 0);
    }

    fn skip_comment(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    }

    /// How many bytes the line's end at `at` has: 0 if there is none.
    fn line_end(&self, at: usize) -> usize {
        match self.text.get(at..) {
            Some([b'\r', b'\n', ..]) => 2,
            Some([b'\n' | b'\r', ..]) => 1,
            _ => 0,
        }
    }
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
        for face in
            ["f 1 2 3", "f 1/7 2/8 3/9", "f 1//4 2//5 3//6", "f 1/1/1 2/2/2 3/3/3", "f -4 -3 -2"]
        {
            assert_eq!(triangles(face), [[0, 1, 2]], "{face}");
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
            "mtllib a b\n{FOUR}vt 0 0\nvn x\ng \\\nf 9 9 9\no b\ns off\nhello\nusemtl m\nf 1 2 3\nworld\n"
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
            ("v 0 0 0\nf 0 1 1\n", 2, "vertex 0 is asked for; vertices are counted from 1"),
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

    /// Run with `cargo test --release -p reflet-assets -- --ignored --nocapture`: it measures.
    #[test]
    #[ignore = "measures, does not judge"]
    fn a_million_triangles() {
        use std::io::Write;
        let n = 708u32; // vertices along an edge: 2 * 707 * 707 triangles
        let mut text = Vec::new();
        for i in 0..n * n {
            let (x, y) = (f64::from(i % n) * 0.1234567, f64::from(i / n) * 0.1234567);
            writeln!(text, "v {x:.6} {y:.6} {:.6}", (x * y).sin()).unwrap();
        }
        for i in 0..n * n {
            if i % n != n - 1 && i / n != n - 1 {
                let (a, b) = (i + 1, i + n + 1);
                writeln!(text, "f {a} {} {b}\nf {b} {} {}", a + 1, a + 1, b + 1).unwrap();
            }
        }
        let start = std::time::Instant::now();
        let obj = parse(&text).unwrap();
        println!(
            "{} triangles, {} MB: {:?}",
            obj.data.triangles.len(),
            text.len() / 1_000_000,
            start.elapsed()
        );
        assert_eq!(obj.data.triangles.len(), 2 * 707 * 707);
    }
}
