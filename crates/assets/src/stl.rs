//! STL to columns: ascii and binary.
//!
//! Source: 3D Systems, "StereoLithography Interface Specification", 1989. Facets hold their corners
//! one by one; corners of the same bits become one vertex, so that neighbours share it. The facets'
//! own normals are not read: they follow from the corners.

use crate::error::Fault;
use crate::finish::finish;
use crate::left_out::{Kind, LeftOut, NOT_FINITE, WITHOUT_AREA};
use crate::words::{Words, number, shown};
use rayon::prelude::*;
use reflet_scene::MeshData;
use std::collections::HashMap;

/// What an STL file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stl {
    /// The vertices and the triangles that have an area.
    pub data: MeshData,
    /// What was left out, in words.
    pub left_out: Vec<String>,
}

/// Bytes of a binary file before its facets, and of a facet.
const HEAD: usize = 84;
const FACET: usize = 50;

const TRAILING: Kind =
    Kind::new("byte after the facets left out", "bytes after the facets left out");
const ATTRIBUTES: Kind = Kind::new(
    "facet has attribute bytes (a colour?), which are left out",
    "facets have attribute bytes (colours?), which are left out",
);
const NO_END: Kind = Kind::new("`endsolid` is missing at the end", "`endsolid`s are missing");

/// The bytes that a binary file's number of facets asks for.
fn wanted(bytes: &[u8]) -> Option<(u64, u64)> {
    let count = bytes.get(80..HEAD)?;
    let facets = u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
    Some((facets, HEAD as u64 + facets * FACET as u64))
}

/// Whether this is a binary file to the last byte, whatever it begins with.
pub(crate) fn is_whole(bytes: &[u8]) -> bool {
    wanted(bytes).is_some_and(|(_, wanted)| wanted == bytes.len() as u64)
}

/// Whether this is a text that begins with `solid`: binary files may begin so, too, and then numbers
/// follow that are no text.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let is_control = |byte: &u8| *byte < b' ' && !byte.is_ascii_whitespace();
    start.len() >= 5
        && start[..5].eq_ignore_ascii_case(b"solid")
        && !start.iter().take(512).any(is_control)
}

/// The triangles of an STL file. It is binary if its length is what its number of facets asks for
/// (some binary files begin with `solid`, too), or if it is no text.
///
/// # Errors
/// A file that ends too early, words that do not belong there, broken numbers, and a file without any
/// facet; with the line or the byte.
pub fn parse(bytes: &[u8]) -> Result<Stl, Fault> {
    let mut mesh = Merged::default();
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if !is_whole(bytes) && is_text(text) {
        ascii(text, &mut mesh)?;
    } else if let Some((facets, wanted)) = wanted(bytes) {
        let length = bytes.len() as u64;
        if wanted > length || facets == 0 && length > HEAD as u64 {
            let message = format!(
                "announces {facets} facets, which take {wanted} bytes, and has {length}; is it an STL file?"
            );
            return Err(Fault::byte(80, message));
        }
        mesh.left_out.add_all(TRAILING, length - wanted, None);
        binary(&bytes[..wanted as usize], &mut mesh);
    } else {
        return Err(Fault::byte(bytes.len(), "the file ends too early; is it an STL file?"));
    }
    let Merged { mut data, mut left_out, .. } = mesh;
    if data.triangles.is_empty() {
        let told = left_out.told().join("; ");
        let but = if told.is_empty() { told } else { format!(" that can be seen: {told}") };
        return Err(Fault::file(format!("holds no facet{but}")));
    }
    left_out.add_all(WITHOUT_AREA, finish(&mut data), None);
    if data.triangles.is_empty() {
        let told = left_out.told().join("; ");
        return Err(Fault::file(format!("holds no facet that can be seen: {told}")));
    }
    Ok(Stl { data, left_out: left_out.told() })
}

/// How many vertices are found again without a look at all of them.
const RECENT: usize = 1 << 14;

/// Vertices by their bits.
struct Merged {
    data: MeshData,
    left_out: LeftOut,
    known: HashMap<[u32; 3], u32>,
    /// Facets that follow one another mostly share vertices; each has one place here.
    recent: Vec<([u32; 3], u32)>,
}

impl Default for Merged {
    fn default() -> Self {
        // Not the bits of a number that a file may hold.
        let recent = vec![([u32::MAX; 3], 0); RECENT];
        let (data, left_out) = Default::default();
        Self { data, left_out, known: HashMap::new(), recent }
    }
}

impl Merged {
    fn vertex(&mut self, position: [f32; 3]) -> u32 {
        let bits = position.map(f32::to_bits);
        let mixed = bits
            .iter()
            .fold(0_u32, |sum, part| (sum.rotate_left(11) ^ part).wrapping_mul(0x9e37_79b1));
        let place = &mut self.recent[mixed as usize >> 18];
        if place.0 == bits {
            return place.1;
        }
        let next = self.data.positions.len() as u32;
        let index = *self.known.entry(bits).or_insert(next);
        if index == next {
            self.data.positions.push(position);
        }
        *place = (bits, index);
        index
    }

    /// Makes room for so many facets, of which two share a vertex thrice on average.
    fn reserve(&mut self, facets: usize) {
        self.data.triangles.reserve(facets);
        self.known.reserve(facets / 2);
    }

    fn facet(&mut self, corners: Corners) {
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            self.left_out.add(NOT_FINITE, None);
            return;
        }
        let triangle = corners.map(|corner| self.vertex(corner));
        self.data.triangles.push(triangle);
    }
}

fn binary(bytes: &[u8], mesh: &mut Merged) {
    let facets = bytes[HEAD..].as_chunks::<FACET>().0;
    mesh.reserve(facets.len());
    let coloured = facets.iter().filter(|facet| facet[48..] != [0; 2]).count();
    mesh.left_out.add_all(ATTRIBUTES, coloured as u64, None);
    for facet in facets {
        let mut corners = [[0.0; 3]; 3];
        for (i, raw) in facet[12..48].as_chunks::<4>().0.iter().enumerate() {
            corners[i / 3][i % 3] = f32::from_le_bytes(*raw);
        }
        mesh.facet(corners);
    }
}

/// Bytes of a text that are worth a thread of their own.
const CHUNK: usize = 1 << 20;

/// Long texts are read in chunks, each from the start of a facet, on all threads. Whatever is wrong
/// in one of them is looked for again from the file's start, where lines are counted.
fn ascii(bytes: &[u8], mesh: &mut Merged) -> Result<(), Fault> {
    let chunks = chunks(bytes);
    let last = chunks.len() - 1;
    let read = |(i, chunk): (usize, &&[u8])| {
        // Between two facets of a solid, but for the file's ends.
        let (before, after) = (i > 0, i < last);
        let (inside, facets) = facets(&mut Words::of(chunk), before).ok()?;
        (inside == after).then_some(facets)
    };
    let all: Option<Vec<_>> = match last {
        0 => None,
        _ => chunks.par_iter().enumerate().map(read).collect(),
    };
    let all = match all {
        Some(all) => all,
        None => {
            let mut words = Words::of(bytes);
            let (inside, facets) = facets(&mut words, false)?;
            if inside {
                mesh.left_out.add(NO_END, None);
            }
            vec![facets]
        }
    };
    mesh.reserve(all.iter().map(Vec::len).sum());
    all.iter().flatten().for_each(|corners| mesh.facet(*corners));
    Ok(())
}

/// A text cut where lines begin with `facet`; one chunk at least.
fn chunks(bytes: &[u8]) -> Vec<&[u8]> {
    let mut chunks = Vec::with_capacity(bytes.len() / CHUNK + 1);
    let mut rest = bytes;
    let starts_facet = |line: &[u8]| {
        let line = line.trim_ascii_start();
        line.len() > 5 && line[..5].eq_ignore_ascii_case(b"facet") && line[5].is_ascii_whitespace()
    };
    while let Some(ahead) = rest.get(CHUNK..) {
        let mut lines = ahead.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        let Some((at, _)) = lines.find(|(at, _)| starts_facet(&ahead[at + 1..])) else { break };
        let (chunk, after) = rest.split_at(CHUNK + at + 1);
        chunks.push(chunk);
        rest = after;
    }
    chunks.push(rest);
    chunks
}

type Corners = [[f32; 3]; 3];

/// The facets of a text, and whether it ends inside of a solid; `solid` tells whether it begins
/// there. Words of any case; the line breaks between them do not matter, but for the names of solids.
fn facets(words: &mut Words<'_>, mut solid: bool) -> Result<(bool, Vec<Corners>), Fault> {
    let mut facets = Vec::new();
    while let Some(word) = next(words) {
        let word_is = |wanted: &[u8]| word.eq_ignore_ascii_case(wanted);
        if word_is(b"facet") && solid {
            expect(words, "normal")?;
            for _ in 0..3 {
                // Some programs write `nan` for facets without area.
                next(words).ok_or_else(|| ends(words))?;
            }
            expect(words, "outer")?;
            expect(words, "loop")?;
            let mut corners = [[0.0; 3]; 3];
            for corner in &mut corners {
                expect(words, "vertex")?;
                for value in corner {
                    let word = next(words).ok_or_else(|| ends(words))?;
                    *value = number(word, words.line, "vertex")?;
                }
            }
            expect(words, "endloop")?;
            expect(words, "endfacet")?;
            facets.push(corners);
        } else if word_is(b"solid") || word_is(b"endsolid") {
            solid = word_is(b"solid");
            words.rest();
        } else {
            let message = format!("{} does not belong here; is it an STL file?", shown(word));
            return Err(Fault::line(words.line, message));
        }
    }
    Ok((solid, facets))
}

fn ends(words: &Words<'_>) -> Fault {
    Fault::line(words.line, "the file ends in the midst of a facet")
}

/// The next word, on whatever line.
fn next<'a>(words: &mut Words<'a>) -> Option<&'a [u8]> {
    loop {
        match words.next() {
            Some(word) => return Some(word),
            None if words.is_empty() => return None,
            None => words.next_line(),
        }
    }
}

fn expect(words: &mut Words<'_>, wanted: &str) -> Result<(), Fault> {
    match next(words) {
        Some(word) if word.eq_ignore_ascii_case(wanted.as_bytes()) => Ok(()),
        Some(word) => {
            let message = format!("{} stands where `{wanted}` belongs", shown(word));
            Err(Fault::line(words.line, message))
        }
        None => Err(ends(words)),
    }
}
