//! Texts that are read in chunks, on several threads, say what they say in one piece.

use reflet_assets::mesh::{MeshFile, decode};
use std::path::Path;

fn read(text: &str) -> Result<MeshFile, String> {
    let none = &mut |_: &str| panic!("an STL names no other file");
    decode(Path::new("a.stl"), text.as_bytes(), none).map_err(|error| error.to_string())
}

#[test]
fn a_long_ascii_stl_is_read_as_a_whole() {
    let facet = |i: usize| {
        format!(
            "  facet normal 0 0 1\n outer loop\n  vertex {i} 0 0\n  vertex {i} 1 0\n  vertex {i} 0 1\n endloop\n endfacet\n"
        )
    };
    let facets: Vec<String> = (0..30_000).map(facet).collect();
    let lines = |upto: usize| 1 + 7 * upto;
    let text = |between: &dyn Fn(usize) -> &'static str| {
        let mut text = "solid facet one\n".to_owned();
        for (i, facet) in facets.iter().enumerate() {
            text += between(i);
            text += facet;
        }
        text + "endsolid facet one\n"
    };
    let plain = text(&|_| "");
    assert!(plain.len() > 3 << 20, "several chunks");
    let data = read(&plain).unwrap().data;
    assert_eq!(data.triangles.len(), facets.len());
    for (i, triangle) in data.triangles.iter().enumerate() {
        let x = i as f32;
        let corners = triangle.map(|vertex| data.positions[vertex as usize]);
        assert_eq!(corners, [[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]);
    }
    // The facet that a chunk begins with, and one in the midst of a chunk.
    let mut at = "solid facet one\n".len();
    let first = facets.iter().position(|facet| {
        at += facet.len();
        at > 1 << 20
    });
    let first = first.unwrap() + 1;
    for i in [first - 1, first, first + 1, 20_000] {
        // Several solids, and names that look like facets.
        let several = |k: usize| if k == i { "endsolid facet\nsolid\tfacet x\n" } else { "" };
        assert_eq!(read(&text(&several)).unwrap().data, data, "{i}");
        let fault = |between: &dyn Fn(usize) -> &'static str| read(&text(between)).unwrap_err();
        let ended = |k: usize| if k == i { "endsolid\n" } else { "" };
        let line = lines(i) + 2;
        let said = format!("a.stl:{line}: `facet` does not belong here; is it an STL file?");
        assert_eq!(fault(&ended), said, "{i}");
        let odd = |k: usize| if k == i { "vertex\n" } else { "" };
        let line = lines(i) + 1;
        let said = format!("a.stl:{line}: `vertex` does not belong here; is it an STL file?");
        assert_eq!(fault(&odd), said, "{i}");
    }
    let cut = plain.replace("endsolid facet one\n", "");
    let read_cut = read(&cut).unwrap();
    assert_eq!(
        (read_cut.data, &read_cut.notes[..]),
        (data, &["1 `endsolid` is missing at the end".to_owned()][..])
    );
    let cut = cut.trim_end().strip_suffix("endfacet").unwrap();
    let line = lines(facets.len());
    let said = format!("a.stl:{line}: the file ends in the midst of a facet");
    assert_eq!(read(cut).unwrap_err(), said);
    let number = plain.replace("vertex 29000 1 0", "vertex 29000 1 o");
    let said = read(&number).unwrap_err();
    let line = lines(29_000) + 4;
    assert_eq!(said, format!("a.stl:{line}: `o` is not a number; mend the `vertex` line"));
}
