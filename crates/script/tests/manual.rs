//! The manual holds: its examples run, and its reference is that of the table.

use reflet_script::{Options, Source, Stage, reference};
use std::fmt::Write;

const MANUAL: &str = include_str!("../MANUAL.md");
const MARK: &str = "## Reference\n";

#[test]
fn every_example_runs_with_all_its_frames() {
    let mut count = 0;
    for example in MANUAL.split("```rhai\n").skip(1) {
        let example = example.split("```").next().unwrap();
        let camera = "camera(#{ eye: [0, 2, 8], look_at: [0, 1, 0] });\n";
        let text = if example.contains("camera(") {
            example.to_owned()
        } else {
            format!("{camera}{example}")
        };
        let run = || -> Result<(), reflet_script::ScriptError> {
            let source = Source { path: "manual.rhai".into(), text: text.clone() };
            let mut stage = Stage::load(source, &Options::default())?;
            let frames = stage.with_scene(|scene| scene.animation().frames);
            (0..frames).try_for_each(|k| stage.frame(k))
        };
        if let Err(error) = run() {
            panic!("{error}\nin\n{text}");
        }
        count += 1;
    }
    assert!(count >= 10, "{count} examples");
}

/// The reference as the table has it.
fn written() -> String {
    let language = reference();
    let mut out = String::from("### Makers\n");
    for maker in &language.makers {
        let _ = write!(
            out,
            "\n#### {}\n\n{}\n\n| key | takes | default | |\n| --- | --- | --- | --- |\n",
            maker.name, maker.doc
        );
        for key in &maker.keys {
            let default = key.default.unwrap_or("needed");
            let _ = writeln!(out, "| `{}` | {} | {default} | {} |", key.name, key.takes, key.doc);
        }
    }
    out.push_str("\n### Helpers\n\n| call | gives |\n| --- | --- |\n");
    for helper in &language.helpers {
        let _ = writeln!(out, "| `{}` | {} |", helper.usage.replace('|', "\\|"), helper.doc);
    }
    out.push_str(
        "\n### Mathematics\n\nAngles are in radians here, in degrees in the keys of makers and in `rotate` and `hsv`.\n\n| call | gives |\n| --- | --- |\n",
    );
    for function in &language.maths {
        let _ = writeln!(out, "| `{}` | {} |", function.usage, function.doc);
    }
    let rhai: Vec<String> = language.rhai.iter().map(|name| format!("`{name}`")).collect();
    let _ = writeln!(
        out,
        "\n### From Rhai itself\n\nStatements, arrays, maps and strings are as in the [Rhai book](https://rhai.rs/book/), with these functions and methods: {}.",
        rhai.join(", ")
    );
    out.push_str("\n### What a frame function is told\n\n| property | is |\n| --- | --- |\n");
    for (name, doc) in language.frame {
        let _ = writeln!(out, "| `f.{name}` | {doc} |");
    }
    out
}

/// `REFLET_BLESS=1 cargo test -p reflet-script --test manual` writes the reference anew.
#[test]
fn the_reference_is_that_of_the_table() {
    let (text, reference) = MANUAL.split_once(MARK).expect("the manual has a reference");
    let expected = format!("\n{}", written());
    if std::env::var_os("REFLET_BLESS").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/MANUAL.md");
        std::fs::write(path, format!("{text}{MARK}{expected}")).unwrap();
    } else {
        assert!(
            reference == expected,
            "the manual's reference is stale: REFLET_BLESS=1 cargo test -p reflet-script --test manual"
        );
    }
}
