//! What wrong scripts say, by a table: the line and the column, the key or the name, what it takes
//! and the nearest known one.

use reflet_script::{ErrorKind, Options, Place, ScriptError, Source, Stage};

struct Case<'a> {
    name: &'a str,
    sets: Vec<(String, String)>,
    script: &'a str,
    expected: Vec<&'a str>,
}

fn table(text: &str) -> Vec<Case<'_>> {
    text.split("\n=== ").skip(1).map(case).collect()
}

fn case(text: &str) -> Case<'_> {
    let (head, rest) = text.split_once('\n').expect("a case has lines");
    let (script, said) = rest.split_once("\n>>> ").expect("a case has an error");
    let (name, set) = head.split_once(" --set ").unwrap_or((head, ""));
    let sets = set.split_once('=').map(|(n, v)| (n.to_owned(), v.to_owned()));
    let expected = said.trim_end().split("\n>>> ").collect();
    Case { name, sets: sets.into_iter().collect(), script, expected }
}

/// Loads a script and runs all of its frames.
fn run(case: &Case<'_>, folder: &std::path::Path) -> Result<(), ScriptError> {
    let options =
        Options { max_operations: 1_000_000, sets: case.sets.clone(), ..Options::default() };
    let source = Source { path: folder.join("scene.rhai"), text: case.script.to_owned() };
    let mut stage = Stage::load(source, &options)?;
    let frames = stage.with_scene(|scene| scene.animation().frames);
    (0..frames).try_for_each(|k| stage.frame(k))
}

fn said(error: &ScriptError) -> Vec<String> {
    let at = |place: &Option<&Place>| match place {
        Some(place) => format!("{}:{}", place.line, place.column),
        None => "-".to_owned(),
    };
    let frame = error.frame.map(|k| format!(" (in frame {k})")).unwrap_or_default();
    let mut lines = vec![format!("{}: {}{frame}", at(&error.place.as_ref()), error.message)];
    lines.extend(error.notes.iter().map(|n| format!("{}: {}", at(&Some(&n.place)), n.message)));
    lines
}

#[test]
fn every_wrong_script_says_what_is_wrong_where() {
    let folder = std::env::temp_dir().join(format!("reflet-wrong-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("tri.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let two = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl blue\nf 3 2 1\n";
    std::fs::write(folder.join("two.obj"), two).unwrap();
    // One pixel.
    std::fs::write(folder.join("dot.ppm"), "P6 1 1 255\nabc").unwrap();
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 nan\n";
    let broken: [(&str, &[u8]); 9] = [
        ("bad.obj", b"v 0 0 0\nv 1 0 x\n"),
        ("far.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
        ("lost.obj", b"mtllib bad.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"),
        ("bad.mtl", b"newmtl a\nKd 1 x 0\n"),
        ("bad.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty flaot x\n"),
        ("bad.stl", stl.as_bytes()),
        ("bad.glb", b"glTF\x02\0\0\0\x0c\0\0\0"),
        ("bad.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01"),
        ("bad.ppm", b"P6 2 1 255\nabc"),
    ];
    for (name, bytes) in broken {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
    let shown = folder.display().to_string();
    let mut cases = table(include_str!("wrong_scripts.txt"));
    cases.extend(table(include_str!("wrong_words.txt")));
    cases.extend(table(include_str!("wrong_meshes.txt")));
    cases.extend(table(include_str!("wrong_habits.txt")));
    assert!(cases.len() >= 200, "{} cases", cases.len());
    let mut wrong = Vec::new();
    for case in &cases {
        let expected: Vec<String> =
            case.expected.iter().map(|line| line.replace("FOLDER", &shown)).collect();
        let got = match run(case, &folder) {
            Ok(()) => vec!["no error".to_owned()],
            Err(error) => said(&error),
        };
        if got != expected {
            wrong.push(format!("{}\n  expected {expected:#?}\n  got {got:#?}", case.name));
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn error_of(text: &str, options: &Options) -> ScriptError {
    Stage::load(Source { path: "a/scene.rhai".into(), text: text.into() }, options).unwrap_err()
}

#[test]
fn who_has_to_mend_it_is_told() {
    let kind = |text: &str, set: Option<&str>| {
        let sets = set.map(|v| ("g".to_owned(), v.to_owned())).into_iter().collect();
        error_of(text, &Options { sets, ..Options::default() }).kind
    };
    let script = "let g = param(\"g\", 0.5, 0.0, 1.0);";
    assert_eq!(kind("sphere(5);", None), ErrorKind::Script);
    assert_eq!(kind(script, Some("2")), ErrorKind::Set);
    assert_eq!(
        kind("camera(#{ viewpoint: [0, 0, 1], window: [1, 1] });", Some("2")),
        ErrorKind::Set
    );
    assert_eq!(kind("mesh(#{ file: \"no.obj\" });", None), ErrorKind::Input);
    let missing = Source::read("no/such/script.rhai").unwrap_err();
    assert_eq!(missing.kind, ErrorKind::Input);
    let folder = Source::read(std::env::temp_dir()).unwrap_err();
    assert_eq!(folder.message, "cannot read the script: this is no regular file");
}

#[test]
fn the_marker_stands_below_wide_characters_and_is_left_out_where_columns_end() {
    let shown = |text: &str| error_of(text, &Options::default()).to_string();
    assert_eq!(
        shown("let v = \"日本e\u{301}\"; 2 ^ 3;"),
        "a/scene.rhai:1:19: `^` does not go between whole numbers: a power is written 2 ** 3\n \
         1 | let v = \"日本e\u{301}\"; 2 ^ 3;\n   \
         |                    ^"
    );
    let far = format!("let v = [{}]; 2 ^ 3;", "1, ".repeat(30_000));
    assert!(shown(&far).ends_with(
        "= at or beyond column 65535, where columns are no longer counted: break the line"
    ));
}

#[test]
fn the_source_line_is_shown_with_a_marker_below_the_column() {
    let text = "fn ball(r) {\n\tsphere(#{ center: [0, 0, 0], radius: r });\n}\nball(0);\n";
    assert_eq!(
        error_of(text, &Options::default()).to_string(),
        "a/scene.rhai:2:31: `radius` takes a number above 0, got the number 0\n \
         2 | \tsphere(#{ center: [0, 0, 0], radius: r });\n   \
         | \t                             ^\n\
         a/scene.rhai:4:1: `ball` was called here\n \
         4 | ball(0);\n   \
         | ^"
    );
}
