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
    assert_eq!(obj.left_out, ["3 triangles without area skipped"]);
    assert_eq!(obj.data.triangles, [[0, 6, 7]], "tiny is not without area");
    // A needle 1e7 long and 1 wide has an area of 5e6.
    let needle = parse(b"v 0 0 0\nv 10000000 0 0\nv 10000000 1 0\nf 1 2 3").unwrap();
    assert!(needle.left_out.is_empty());
}

#[test]
fn other_statements_are_ignored_and_unknown_ones_counted() {
    let text = format!(
        "mtllib a b\n{FOUR}vt 0 0\nvn 0 0 1\ng \\\nf 9 9 9\no b\ns off\nhello\nusemtl m\nl 1 2\nf 1 2 3\nsurf 0 1\nworld\nl 1 2 3\n"
    );
    let obj = parse(text.as_bytes()).unwrap();
    assert_eq!(
        obj.left_out,
        [
            "2 unknown statements ignored (the first in line 12)",
            "2 lines (`l`) left out (the first in line 14)",
            "1 free-form curve or surface left out (line 16)",
        ]
    );
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
        ("v 1e39 0 0\n", 1, "`1e39` is beyond the range of f32; scale the mesh"),
        ("v 0 0,5 0\n", 1, "`0,5` is not a number (decimals follow a point); mend the `v` line"),
        ("v 0 0 \u{1}\n", 1, "what is no text is not a number; mend the `v` line"),
        ("v 0 0 0\nf 1 1 2\n", 2, "vertex 2 is asked for, there are 1; mend the `f` line"),
        ("v 0 0 0\nf -2 1 1\n", 2, "vertex -2 is asked for, there are 1; mend the `f` line"),
        ("v 0 0 0\nf 0 1 1\n", 2, "vertex 0 is asked for; they are counted from 1"),
        (
            "v 0 0 0\nf 1 9999999999 1\n",
            2,
            "vertex 9999999999 is asked for, there are 1; mend the `f` line",
        ),
        (
            "v 0 0 0\nf 1 1 1/2/3/4\n",
            2,
            "`1/2/3/4` is no corner of a face; write a, a/b, a//c or a/b/c",
        ),
        ("v 0 0 0\nf 1 1 1.5\n", 2, "`1.5` is no corner of a face; write a, a/b, a//c or a/b/c"),
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
    for text in ["", "v 0 0 0\n", "\\"] {
        assert_eq!(fault(text), none, "{text:?}");
    }
    let (line, message) = fault("v 0 0 0\nv 1 0 0\nl 1 2\nf 1 2\n");
    let said = "holds no face (`f` line), but: 1 line (`l`) left out (line 3); 1 face of fewer than three corners skipped (line 4)";
    assert_eq!((line, message.as_str()), (None, said));
    let (_, message) = fault("v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n");
    let said = "holds no triangle that can be seen: 1 face with a corner whose position is not finite skipped";
    assert_eq!(message, said);
}

#[test]
fn numbers_may_be_missing_after_a_slash() {
    let more = "vt 0 0\n";
    for face in
        ["f 1/ 2/ 3/", "f 1// 2// 3//", "f 1/1/ 2/1/ 3/1/", "f 1/0/0 2/0/0 3/0/0", "fo 1 2 3"]
    {
        assert_eq!(triangles(&format!("{more}{face}")), [[0, 1, 2]], "{face}");
    }
}

#[test]
fn faces_that_are_none_are_counted() {
    let obj = parse(format!("{FOUR}v nan 0 0\nf 1 2\nf 1 2 3\nf\nf 1 2 5\n").as_bytes()).unwrap();
    assert_eq!(obj.data.triangles, [[0, 1, 2]]);
    assert_eq!(
        obj.left_out,
        [
            "2 faces of fewer than three corners skipped (the first in line 6)",
            "1 face with a corner whose position is not finite skipped",
        ]
    );
    assert!(obj.data.positions.iter().flatten().all(|x| x.is_finite()));
}

#[test]
fn a_concave_face_is_covered_and_nothing_else() {
    let text = "v -1 -1 0\nv 0 0 0\nv 1 -1 0\nv 0 2 0\nf 1 2 3 4\n";
    let mut triangles = parse(text.as_bytes()).unwrap().data.triangles;
    triangles.iter_mut().for_each(|triangle| triangle.sort_unstable());
    triangles.sort_unstable();
    assert_eq!(triangles, [[0, 1, 3], [1, 2, 3]]);
}

#[test]
fn normals_that_are_none_become_those_around_and_absent_ones_are_the_triangles_own() {
    for none in ["nan nan nan", "-nan(ind) -nan(ind) -nan(ind)", "0 0 0", "1.#QNAN 0 1", "0 inf 0"]
    {
        let text = format!("{FOUR}vn {none}\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4\n");
        let data = parse(text.as_bytes()).unwrap().data;
        assert_eq!(data.normals[..3], [[0.0, 0.0, 1.0]; 3], "{none}");
        assert_eq!(data.normals[3..], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]], "{none}");
    }
}

#[test]
fn attributes_that_some_corners_lack_are_told() {
    let text = format!("{FOUR}vt 0.5 0.5\nvn 0 0 1\ns 1\nf 1/1 2/1 3/1\nf 1//1 3//7 4/9/-9\n");
    let obj = parse(text.as_bytes()).unwrap();
    assert_eq!(obj.data.uvs[..3], [[0.5; 2]; 3]);
    assert_eq!(obj.data.uvs[3..], [[0.0; 2]; 3]);
    assert_eq!(
        obj.left_out,
        [
            "2 corners ask for normals that are not there (the first in line 9)",
            "1 corner asks for a texture vertex that is not there",
            "3 corners without texture coordinates, which others have, take (0, 0)",
            "1 smoothing group left out: its faces have no normals (line 7)",
        ]
    );
}

#[test]
fn vertices_have_colours_and_weights() {
    let text = "v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 1 0 1 0\nv 1 1 0 0.5\nf 1 2 3\nf 2 3 4\n";
    let data = parse(text.as_bytes()).unwrap().data;
    // sRGB 0.5 is 0.21404114 in linear intensities.
    assert_eq!(data.colours, [[1.0, 0.0, 0.214_041_14], [1.0; 3], [0.0, 1.0, 0.0], [1.0; 3]]);
}

#[test]
fn three_hundred_thousand_materials_are_quick() {
    let mut text = FOUR.to_owned();
    for i in 0..300_000 {
        text += &format!("usemtl m{i}\nf 1 2 3\nmtllib l{i}\n");
    }
    let begin = std::time::Instant::now();
    let obj = parse(text.as_bytes()).unwrap();
    assert_eq!((obj.data.materials.len(), obj.libraries.len()), (300_000, 300_000));
    // It takes half a second; looking at all names for each takes minutes.
    assert!(begin.elapsed().as_secs() < 20);
}
