//! Scripts mutated at random, token by token, end with a scene or with a message, never otherwise.
//!
//! `REFLET_FUZZ=CASES` runs more than the few hundred of every day, `REFLET_FUZZ_SEED=N` others.

use reflet_script::{ErrorKind, Options, Source, Stage};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}

/// What no script of a person holds.
const ODD: &[&str] = &[
    "0",
    "-1",
    "1e308",
    "9223372036854775807",
    "0.0/0.0",
    "()",
    "[]",
    "#{}",
    "\"\"",
    "\"\\u001b[2J\\nerror: x\"",
    "'\\x00'",
    "|x| x",
    "|a, b| { a = b; }",
    "this",
    "global::X",
    "0..3",
    "0..=-1",
    "[[[[0]]]]",
    "loop { }",
    "throw [1, #{ a: () }];",
    "a = [a, a];",
    "let h = 0; for i in 0..99 { let g = h; h = || g; }",
    "\"x\".pad(99999, 'y')",
    "range(0, 10, 0)",
    ".to_chars()",
    ".sort(|a, b| 1)",
    ".map(|x| [x])",
    ".drain(|x| true)",
    ".splice(0, 9, [1])",
    ".to_blob()",
    ".split(\"\")",
    ".call(1)",
    ".0",
    "[0..2]",
    "?.x",
    "??",
    "switch 1 { 1 => 2, _ => 3 }",
    "try { throw 1; } catch (e) { print(e); }",
    "fn f(x) { f(x) }",
    "on_frame(|f| { print(f); });",
    "animation(#{ frames: 3 });",
    "print",
    "debug",
    "type_of",
    "Fn(\"sphere\")",
    "is_shared",
    "`${",
    "}`",
    "/*",
    "//",
    "\u{202e}",
    "\0",
];

/// A script's words, numbers, strings and signs, with the blanks before each.
fn tokens(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    let mut rest = text;
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    while !rest.is_empty() {
        let blank = rest.len() - rest.trim_start().len();
        let mut chars = rest[blank..].chars();
        let first = chars.next().unwrap_or(' ');
        let len = if word(first) {
            rest[blank..].find(|c| !word(c)).unwrap_or(rest.len() - blank)
        } else if first == '"' {
            rest[blank + 1..].find('"').map_or(1, |end| end + 2)
        } else {
            first.len_utf8()
        };
        let end = (blank + len).min(rest.len());
        all.push(rest[..end].to_owned());
        rest = &rest[end..];
    }
    all
}

/// The end of the bracketed span that begins at `at`, if one does.
fn span(tokens: &[String], at: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(at) {
        match token.trim() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth <= 0 {
            return i + 1;
        }
    }
    at + 1
}

fn mutate(random: &mut Random, script: &mut Vec<String>, pool: &[String]) {
    let at = random.below(script.len());
    let end = span(script, at);
    match random.below(8) {
        0 => drop(script.drain(at..end)),
        1 => {
            let copy: Vec<String> = script[at..end].to_vec();
            let to = random.below(script.len());
            script.splice(to..to, copy);
        }
        2 => script[at] = random.pick(pool).clone(),
        3 => script[at] = format!(" {} ", random.pick(ODD)),
        4 => script.insert(at, format!(" {} ", random.pick(ODD))),
        5 => {
            let other = random.below(script.len());
            script.swap(at, other);
        }
        6 => {
            script.insert(end, " }\n".into());
            script.insert(at, " for k in 0..30 { ".into());
        }
        _ => {
            // An expression in place of another.
            let from = random.below(script.len());
            let part = script[from..span(script, from)].to_vec();
            script.splice(at..end, part);
        }
    }
    if script.is_empty() {
        script.push(";".into());
    }
}

/// Loads a script and takes two frames; what is wrong with how that ended.
fn run(path: &Path, text: String) -> Result<&'static str, String> {
    let quiet: reflet_script::Told = Arc::new(|_| {});
    let options = Options {
        max_operations: 100_000,
        max_memory: 256 << 20,
        print: Some(Arc::new(|text, _| assert!(!text.contains(['\n', '\u{1b}'])))),
        slow: Some(quiet),
        ..Options::default()
    };
    let frames = |stage: &mut Stage| {
        let last = stage.with_scene(|scene| scene.animation().frames) - 1;
        stage.frame(last).and_then(|()| stage.frame(0))
    };
    let source = Source { path: path.into(), text };
    let loaded = Stage::load(source, &options);
    let Err(error) = loaded.and_then(|mut stage| frames(&mut stage)) else { return Ok("scenes") };
    let about_all = error.message.starts_with("the scene has no camera");
    if error.message.contains("broke down") {
        return Err("a panic".into());
    }
    if error.place.is_none() && !about_all && error.kind == ErrorKind::Script {
        return Err(format!("no place: {error}"));
    }
    if error.to_string().contains('\u{1b}') || error.message.contains('\n') {
        return Err(format!("steers the terminal: {error:?}"));
    }
    Ok("messages")
}

#[test]
fn mutated_scripts_end_with_a_scene_or_a_message() {
    let number = |name: &str| std::env::var(name).ok().and_then(|n| n.parse::<u64>().ok());
    let (cases, seed) = (number("REFLET_FUZZ"), number("REFLET_FUZZ_SEED"));
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scripts"));
    let mut scripts: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "rhai"))
        .collect();
    scripts.sort();
    let read = |path: &PathBuf| tokens(&std::fs::read_to_string(path).unwrap());
    let sources: Vec<Vec<String>> = scripts.iter().map(read).collect();
    let pool: Vec<String> = sources.iter().flatten().cloned().collect();
    let (mut scenes, mut messages) = (0, 0);
    let cases = cases.unwrap_or(300);
    for case in 0..cases {
        let mut random = Random(seed.unwrap_or(14).wrapping_mul(1 << 32) + case);
        let mut script = random.pick(&sources).clone();
        for _ in 0..=random.below(2) {
            mutate(&mut random, &mut script, &pool);
        }
        let text = script.concat();
        match run(&folder.join("mutated.rhai"), text.clone()) {
            Ok("scenes") => scenes += 1,
            Ok(_) => messages += 1,
            Err(why) => panic!("case {case}: {why}\n{text}"),
        }
        if case % 10_000 == 9999 {
            println!("{} cases: {scenes} scenes, {messages} messages", case + 1);
        }
    }
    println!("{cases} cases: {scenes} scenes, {messages} messages");
    // Mutants that all fail, or that all pass, would find nothing.
    assert!(scenes * 40 > cases && messages * 40 > cases, "{scenes} and {messages}");
}
