//! The house stands as `crates/README.md` draws it: data goes forward only, each outside crate has
//! its room, and the top level holds what it should.
//!
//! Every rule is a function from files to faults, so that each is also shown to find a fault.

use std::fs;
use std::path::Path;

/// The crates in the order of the pipeline. The last is the root package, in `crates/cli`.
const ORDER: [&str; 9] =
    ["scene", "assets", "script", "pack", "accel", "trace", "film", "frame", "cli"];

/// Crates that read or write pictures. What stands here serves only `assets`, `film`, or both.
const CODECS: [(&str, &[&str]); 4] = [
    ("decodes and encodes images", &["image", "png", "gif", "exr", "qoi", "tiff", "webp", "bmp"]),
    ("decodes and encodes images", &["image-webp", "libwebp", "lodepng", "openexr", "rapid-qoi"]),
    ("decodes images", &["jpeg-decoder", "zune-core", "zune-jpeg", "zune-png", "zune-image"]),
    ("encodes images", &["jpeg-encoder", "mozjpeg", "ravif", "rav1e", "webp-animation", "mtpng"]),
];

/// What the top level may hold beside LICENSE files, dotfiles and what git ignores.
const TOP: [&str; 9] = [
    "Cargo.toml",
    "Cargo.lock",
    "CHANGELOG.md",
    "README.md",
    "rust-toolchain.toml",
    "crates",
    "scripts",
    "tests",
    "benches",
];

/// The most lines of a source file.
const MAX_LINES: usize = 600;

/// A file: its path from the top, with `/` between folders, and its text.
struct File {
    path: String,
    text: String,
}

impl File {
    fn new(path: &str, text: &str) -> Self {
        File { path: path.to_owned(), text: text.to_owned() }
    }

    /// The crate that the file is of. The root's manifest is that of `cli`.
    fn room(&self) -> Option<&str> {
        if self.path == "Cargo.toml" {
            return Some("cli");
        }
        self.path.strip_prefix("crates/")?.split_once('/').map(|(room, _)| room)
    }

    fn is_manifest(&self) -> bool {
        self.path == "Cargo.toml" || self.path.ends_with("/Cargo.toml")
    }

    /// Whether it is part of the crate itself, and not of its tests.
    fn is_source(&self) -> bool {
        let path = self.path.strip_prefix("crates/").and_then(|path| path.split_once('/'));
        path.is_some_and(|(room, inside)| {
            inside.ends_with(".rs") && (room == "cli" || inside.starts_with("src/"))
        })
    }

    fn fault(&self, what: impl std::fmt::Display) -> String {
        format!("{}: {what}", self.path)
    }
}

/// The place of a crate in the order.
fn place(room: &str) -> Option<usize> {
    ORDER.iter().position(|r| *r == room)
}

/// The names of a manifest's dependencies, but for those that only tests and benches have. A
/// renamed one counts by both names.
fn dependencies(manifest: &str) -> Vec<String> {
    let mut names = Vec::new();
    // Whether the lines are dependencies, or keys of one that has a table of its own.
    let (mut listed, mut single) = (false, false);
    for line in manifest.lines().map(str::trim) {
        if let Some(header) = line.strip_prefix('[') {
            let header = header.trim_end_matches(']');
            let parts = header.rsplit_once("dependencies");
            let counts = |before: &str| {
                matches!(before.rsplit('.').next(), Some("" | "build-")) && before != "workspace."
            };
            let name = parts.filter(|(before, _)| counts(before)).map(|(_, after)| after);
            listed = name == Some("");
            single = name.is_some_and(|name| !name.is_empty());
            names.extend(name.filter(|_| single).map(|n| n.trim_matches(['.', '"']).to_owned()));
        } else if listed && !line.starts_with('#') && line.contains('=') {
            let end = line.find(['.', '=', ' ']).unwrap_or(line.len());
            names.push(line[..end].trim_matches('"').to_owned());
        }
        if let Some((_, rest)) = line.split_once("package = \"")
            && (listed || single)
        {
            names.extend(rest.split('"').next().map(str::to_owned));
        }
    }
    names
}

/// The identifiers of a source text outside of comments and of string and character literals, each
/// with its line.
fn identifiers(text: &str) -> Vec<(usize, &str)> {
    let bytes = text.as_bytes();
    let is_word = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b >= 0x80;
    let (mut found, mut at, mut line) = (Vec::new(), 0, 1);
    while at < bytes.len() {
        let rest = &text.as_bytes()[at..];
        let end = match rest[0] {
            b'/' if rest.starts_with(b"//") => find(rest, b"\n").unwrap_or(rest.len()),
            b'/' if rest.starts_with(b"/*") => block_comment(rest),
            b'"' => string(rest),
            b'\'' => character(rest),
            b if is_word(b) => {
                let end = rest.iter().position(|b| !is_word(*b)).unwrap_or(rest.len());
                let word = &text[at..at + end];
                let hashes = rest[end..].iter().take_while(|b| **b == b'#').count();
                let quoted = rest.get(end + hashes) == Some(&b'"');
                if matches!(word, "r" | "br" | "cr") && quoted {
                    let close = format!("\"{}", "#".repeat(hashes));
                    let open = end + hashes + 1;
                    find(&rest[open..], close.as_bytes())
                        .map_or(rest.len(), |i| open + i + close.len())
                } else {
                    found.push((line, word));
                    end
                }
            }
            _ => 1,
        };
        line += rest[..end].iter().filter(|b| **b == b'\n').count();
        at += end;
    }
    found
}

fn find(text: &[u8], what: &[u8]) -> Option<usize> {
    text.windows(what.len()).position(|w| w == what)
}

/// The length of a block comment, with those inside of it.
fn block_comment(text: &[u8]) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        if text[at..].starts_with(b"/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if text[at..].starts_with(b"*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    text.len()
}

/// The length of a string literal.
fn string(text: &[u8]) -> usize {
    let mut at = 1;
    while at < text.len() && text[at] != b'"' {
        at += if text[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(text.len())
}

/// The length of a character literal, or 1 before a lifetime.
fn character(text: &[u8]) -> usize {
    if text.get(1) == Some(&b'\\') {
        return find(&text[3..], b"'").map_or(text.len(), |i| i + 4);
    }
    // A character takes up to four bytes.
    (2..=5)
        .find(|i| text.get(*i) == Some(&b'\''))
        .filter(|i| *i == 2 || text[1] >= 0x80)
        .map_or(1, |i| i + 1)
}

/// Whether a crate may name another one, of this workspace or from outside; why not, if not.
fn forbidden(room: &str, name: &str) -> Option<String> {
    let name = name.replace('_', "-");
    let here = place(room)?;
    if let Some(other) = name.strip_prefix("reflet-").and_then(place) {
        return (other > here).then(|| format!("`{room}` comes before `{}`", ORDER[other]));
    }
    match name.as_str() {
        "rhai" if room != "script" => Some("only `script` names rhai".to_owned()),
        "hecs" if here > place("pack")? => Some("nothing after `pack` names hecs".to_owned()),
        _ => None,
    }
}

/// Crates import only from those before them, and outside crates stay in their rooms.
fn imports(files: &[File]) -> Vec<String> {
    let mut faults = Vec::new();
    for file in files {
        let Some(room) = file.room() else { continue };
        if file.is_manifest() {
            if place(room).is_none() {
                faults.push(file.fault(format!("`{room}` has no place in the order")));
            }
            for name in dependencies(&file.text) {
                faults.extend(
                    forbidden(room, &name).map(|why| file.fault(format!("`{name}`: {why}"))),
                );
            }
        } else if file.is_source() {
            for (line, name) in identifiers(&file.text) {
                let why = forbidden(room, name);
                faults.extend(why.map(|why| file.fault(format!("line {line}: `{name}`: {why}"))));
            }
        }
    }
    faults
}

/// Only `assets` decodes images and only `film` encodes them.
fn codecs(files: &[File]) -> Vec<String> {
    let mut faults = Vec::new();
    for file in files {
        let Some(room) = file.room() else { continue };
        if file.is_manifest() {
            for name in dependencies(&file.text) {
                for (does, crates) in CODECS {
                    let serves = match room {
                        "assets" => does != "encodes images",
                        "film" => does != "decodes images",
                        _ => false,
                    };
                    if crates.contains(&name.as_str()) && !serves {
                        faults.push(file.fault(format!("`{name}` {does}, and `{room}` does not")));
                    }
                }
            }
        } else if file.is_source() {
            let wrong = match room {
                "assets" => "Encoder",
                "film" => "Decoder",
                _ => continue, // no codec is there to be called
            };
            for (line, name) in identifiers(&file.text) {
                if name.ends_with(wrong) {
                    faults.push(file.fault(format!("line {line}: `{name}` in `{room}`")));
                }
            }
        }
    }
    faults
}

/// `unsafe` stands in one file of `accel` at most.
fn unsafety(files: &[File]) -> Vec<String> {
    let mut allowed = None;
    let mut faults = Vec::new();
    for file in files.iter().filter(|f| f.path.starts_with("crates/") && f.path.ends_with(".rs")) {
        let Some((line, _)) = identifiers(&file.text).into_iter().find(|(_, w)| *w == "unsafe")
        else {
            continue;
        };
        if !file.path.starts_with("crates/accel/src/") {
            faults.push(file.fault(format!("line {line}: `unsafe` outside of `accel`")));
        } else if let Some(first) = allowed.replace(&file.path) {
            faults
                .push(file.fault(format!("line {line}: `unsafe`, as in {first}: one file has it")));
        }
    }
    faults
}

/// No source file is too long.
fn lengths(files: &[File]) -> Vec<String> {
    let long = |f: &&File| f.path.ends_with(".rs") && f.text.lines().count() > MAX_LINES;
    let fault =
        |f: &File| f.fault(format!("{} lines, at most {MAX_LINES}", f.text.lines().count()));
    files.iter().filter(long).map(fault).collect()
}

/// The top level holds what it should. `ignored` is the text of `.gitignore`, of which patterns
/// `/name` and `/*.ending` count.
fn top_level(names: &[String], ignored: &str) -> Vec<String> {
    let ignored: Vec<&str> = ignored.lines().filter_map(|l| l.trim().strip_prefix('/')).collect();
    let matches = |pattern: &str, name: &str| match pattern.strip_prefix('*') {
        Some(ending) => name.ends_with(ending),
        None => name == pattern.trim_end_matches('/'),
    };
    let known = |name: &str| {
        name.starts_with('.')
            || name.starts_with("LICENSE")
            || TOP.contains(&name)
            || ignored.iter().any(|pattern| matches(pattern, name))
    };
    let unknown = names.iter().filter(|name| !known(name));
    unknown.map(|name| format!("{name}: nothing of this name belongs on the top level")).collect()
}

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All Rust files and manifests of the project.
fn project() -> Vec<File> {
    let mut files = vec![read(&top().join("Cargo.toml"))];
    let mut folders: Vec<_> = ["crates", "tests", "benches"].map(|name| top().join(name)).into();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
            let path = entry.expect("an entry of a folder").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs" || e == "toml") {
                files.push(read(&path));
            }
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    files
}

fn read(path: &Path) -> File {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let parts = path.strip_prefix(top()).expect("a file of the project").components();
    let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
    File { path: parts.join("/"), text }
}

fn none(faults: Vec<String>) {
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// One file with a fault is reported once, and the message names what is meant.
fn reported(rule: fn(&[File]) -> Vec<String>, path: &str, text: &str, needle: &str) {
    let faults = rule(&[File::new(path, text)]);
    assert_eq!(faults.len(), 1, "{path}: {text}: {faults:?}");
    assert!(faults[0].starts_with(path) && faults[0].contains(needle), "{}", faults[0]);
}

fn silent(rule: fn(&[File]) -> Vec<String>, path: &str, text: &str) {
    assert_eq!(rule(&[File::new(path, text)]), Vec::<String>::new(), "{path}: {text}");
}

#[test]
fn the_project_is_seen() {
    let files = project();
    for room in ORDER {
        assert!(files.iter().any(|f| f.room() == Some(room) && f.is_source()), "{room}");
        assert!(files.iter().any(|f| f.room() == Some(room) && f.is_manifest()), "{room}");
    }
    let script = files.iter().find(|f| f.path == "crates/script/Cargo.toml").expect("a manifest");
    assert!(dependencies(&script.text).contains(&"rhai".to_owned()));
}

#[test]
fn data_goes_forward_only() {
    none(imports(&project()));
}

#[test]
fn a_backward_import_is_reported() {
    let manifest = "crates/pack/Cargo.toml";
    reported(imports, manifest, "[dependencies]\nreflet-accel.workspace = true\n", "reflet-accel");
    reported(imports, manifest, "[dependencies.reflet-trace]\npath = \"../trace\"\n", "trace");
    reported(imports, manifest, "[build-dependencies]\nreflet-film = { path = \"x\" }\n", "film");
    reported(
        imports,
        manifest,
        "[target.'cfg(unix)'.dependencies]\nreflet-frame = \"1\"\n",
        "frame",
    );
    silent(imports, manifest, "[dev-dependencies]\nreflet-trace.workspace = true\n");
    silent(imports, manifest, "[dependencies]\nreflet-scene.workspace = true\n");
    silent(imports, "Cargo.toml", "[workspace.dependencies]\nrhai = \"1\"\nhecs = \"1\"\n");
    let source = "crates/accel/src/lib.rs";
    reported(imports, source, "use reflet_trace::Tracer;", "line 1: `reflet_trace`");
    reported(imports, source, "fn f() {\n    reflet_film::g()\n}", "line 2");
    silent(imports, source, "//! Not `reflet_trace`.\nuse reflet_pack::PrimId;");
    reported(imports, "crates/utils/Cargo.toml", "[package]\nname = \"x\"\n", "no place");
}

#[test]
fn rhai_and_hecs_outside_their_rooms_are_reported() {
    for room in ORDER.iter().filter(|r| **r != "script") {
        let source =
            if *room == "cli" { "crates/cli/a.rs" } else { &format!("crates/{room}/src/a.rs") };
        reported(imports, source, "pub fn f(_: rhai::Map) {}", "rhai");
        reported(imports, source, "/* \" */ use rhai as r; // \"", "rhai");
        silent(
            imports,
            source,
            "fn f() -> (&'static str, char, &'static str) { (\"rhai\", 'r', r#\"\"rhai\"#) }",
        );
    }
    reported(imports, "Cargo.toml", "[dependencies]\nrhai.workspace = true\n", "rhai");
    reported(
        imports,
        "crates/trace/Cargo.toml",
        "[dependencies]\nx = { package = \"rhai\" }\n",
        "rhai",
    );
    reported(imports, "crates/trace/Cargo.toml", "[dependencies.x]\npackage = \"rhai\"\n", "rhai");
    silent(imports, "crates/script/Cargo.toml", "[dependencies]\nrhai.workspace = true\n");
    silent(imports, "crates/script/src/a.rs", "use rhai::Map;");
    for room in &ORDER[4..8] {
        reported(
            imports,
            &format!("crates/{room}/Cargo.toml"),
            "[dependencies]\nhecs = \"0.11\"\n",
            "hecs",
        );
        reported(imports, &format!("crates/{room}/src/a.rs"), "use hecs::World;", "hecs");
    }
    silent(imports, "crates/pack/src/a.rs", "use hecs::World;");
}

#[test]
fn only_assets_decodes_and_only_film_encodes() {
    none(codecs(&project()));
}

#[test]
fn a_codec_outside_its_room_is_reported() {
    for name in ["image", "png", "exr", "qoi", "gif", "jpeg-encoder", "jpeg-decoder"] {
        let manifest = format!("[dependencies]\n{name} = \"1\"\n");
        for path in ["Cargo.toml", "crates/frame/Cargo.toml", "crates/scene/Cargo.toml"] {
            reported(codecs, path, &manifest, name);
            silent(codecs, path, &manifest.replace("[dep", "[dev-dep"));
        }
    }
    silent(codecs, "crates/film/Cargo.toml", "[dependencies]\ngif = \"1\"\njpeg-encoder = \"1\"\n");
    silent(
        codecs,
        "crates/assets/Cargo.toml",
        "[dependencies]\npng = \"1\"\njpeg-decoder = \"1\"\n",
    );
    reported(codecs, "crates/film/Cargo.toml", "[dependencies]\njpeg-decoder = \"1\"\n", "decodes");
    reported(
        codecs,
        "crates/assets/Cargo.toml",
        "[dependencies]\njpeg-encoder = \"1\"\n",
        "encodes",
    );
    reported(codecs, "crates/film/src/a.rs", "let d = gif::Decoder::new(r);", "Decoder");
    reported(codecs, "crates/assets/src/a.rs", "let e = png::Encoder::new(w, 1, 1);", "Encoder");
}

#[test]
fn unsafe_stands_in_one_file_at_most() {
    none(unsafety(&project()));
}

#[test]
fn unsafe_elsewhere_is_reported() {
    let code = "fn f(p: *const u8) -> u8 {\n    unsafe { *p }\n}";
    reported(unsafety, "crates/trace/src/grow.rs", code, "line 2");
    reported(unsafety, "crates/film/tests/a.rs", code, "line 2");
    silent(unsafety, "crates/accel/src/simd.rs", code);
    silent(unsafety, "crates/trace/src/grow.rs", "#![forbid(unsafe_code)] // unsafe\n");
    let two = ["crates/accel/src/a.rs", "crates/accel/src/b.rs"].map(|path| File::new(path, code));
    assert_eq!(unsafety(&two).len(), 1);
}

#[test]
fn no_source_file_is_too_long() {
    none(lengths(&project()));
}

#[test]
fn a_long_file_is_reported() {
    let path = "crates/scene/src/a.rs";
    silent(lengths, path, &"//\n".repeat(MAX_LINES));
    reported(lengths, path, &"//\n".repeat(MAX_LINES + 1), "601 lines");
}

#[test]
fn the_top_level_holds_what_it_should() {
    let entries = fs::read_dir(top()).expect("the top level");
    let names = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
    let ignored = fs::read_to_string(top().join(".gitignore")).expect(".gitignore");
    none(top_level(&names.collect::<Vec<_>>(), &ignored));
}

#[test]
fn a_stray_top_level_entry_is_reported() {
    let names = ["src", "LICENSE-MIT", ".ci", "target", "a.png", "a.txt", "crates", "utils"];
    let faults = top_level(&names.map(str::to_owned), "/target\n/*.png\n");
    let strays: Vec<_> = faults.iter().filter_map(|f| f.split(':').next()).collect();
    assert_eq!(strays, ["src", "a.txt", "utils"]);
}
