//! The README tells the truth: its scripts are saved under the names in their first lines, and its
//! `reflet` commands are run in order, with the files, output and exit codes that it promises.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn readme() -> String {
    let text = fs::read_to_string(top().join("README.md")).expect("README.md");
    text.replace("\r\n", "\n")
}

/// A fenced block: its language and its lines.
fn blocks(text: &str) -> Vec<(&str, Vec<&str>)> {
    let mut blocks: Vec<(&str, Vec<&str>)> = Vec::new();
    let mut open = false;
    for line in text.lines() {
        match line.strip_prefix("```") {
            Some(language) if !open => blocks.push((language, Vec::new())),
            Some(_) => {}
            None => {
                if let Some((_, lines)) = blocks.last_mut().filter(|_| open) {
                    lines.push(line);
                }
                continue;
            }
        }
        open = !open;
    }
    assert!(!open, "a fence of README.md is not closed");
    blocks
}

/// An empty folder for one test.
fn room(name: &str) -> PathBuf {
    let room = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme").join(name);
    let _ = fs::remove_dir_all(&room);
    fs::create_dir_all(&room).expect("a folder");
    room
}

fn reflet(room: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_reflet"));
    command.current_dir(room).args(arguments.split_whitespace());
    command.output().expect("the binary")
}

/// The frames and pixels of a PNG, so that a file of the right name is also the right picture.
fn png_size(path: &Path) -> (u32, u32) {
    let file = fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let decoder = png::Decoder::new(std::io::BufReader::new(file));
    let mut reader = decoder.read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut bytes).expect("all of its rows");
    assert!(bytes.iter().any(|b| *b != bytes[0]), "{}: one colour", path.display());
    reader.info().size()
}

#[test]
fn the_tutorial_runs_as_it_is_printed() {
    let text = readme();
    let room = room("tutorial");
    let (mut scripts, mut commands) = (Vec::new(), 0);
    let mut last = String::new();
    for (language, lines) in blocks(&text) {
        match language {
            "rhai" => {
                let name = lines[0].strip_prefix("// ").expect("a script begins with its name");
                fs::write(room.join(name), lines.join("\n") + "\n").expect("a script");
                scripts.push(name);
            }
            "sh" => {
                for line in lines.iter().filter_map(|line| line.strip_prefix("reflet ")) {
                    let (arguments, promise) =
                        line.split_once(" # ").unwrap_or((line, "exit code 0"));
                    let ran = reflet(&room, arguments);
                    last = String::from_utf8(ran.stderr).expect("UTF-8");
                    let code = ran.status.code().map(|code| format!("exit code {code}"));
                    assert_eq!(code.as_deref(), Some(promise), "{arguments}: {last}");
                    scripts.retain(|script| !arguments.contains(script));
                    commands += 1;
                }
            }
            "text" if lines[0].starts_with("error: ") => {
                assert_eq!(last.trim_end(), lines.join("\n"));
            }
            _ => {}
        }
    }
    assert!(commands >= 6, "only {commands} commands were found");
    assert!(scripts.is_empty(), "scripts that no command uses: {scripts:?}");

    assert_eq!(png_size(&room.join("first.png")), (640, 360));
    assert_eq!(png_size(&room.join("mirrors.png")), (480, 270));
    assert_eq!(png_size(&room.join("dull.png")), (480, 270));
    let names = |folder: &str| {
        let entries = fs::read_dir(room.join(folder)).expect(folder);
        let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name()).collect();
        names.sort();
        names.into_iter().map(|name| name.into_string().expect("UTF-8")).collect::<Vec<_>>()
    };
    let all: Vec<_> = (0..24).map(|frame| format!("breathe-{frame:02}.png")).collect();
    assert_eq!(names("out"), all);
    let some = ["breathe-06.png", "breathe-10.png", "breathe-14.png", "breathe-18.png"];
    assert_eq!(names("again"), some);
    let read = |folder: &str, name: &str| fs::read(room.join(folder).join(name)).expect(name);
    for name in some {
        assert!(read("out", name) == read("again", name), "{name} alone is another picture");
    }
    assert!(read("out", some[0]) != read("out", some[1]), "the animation does not move");
    assert!(read("", "mirrors.png") != read("", "dull.png"), "--set changes nothing");
    assert_eq!(&read("", "breathe.gif")[..6], b"GIF89a");
    assert_eq!(&read("", "breathe.webp")[8..12], b"WEBP");
    assert_eq!(png_size(&room.join("joined.png")), (480, 270));
    assert!(read("", "joined.png") == read("", "mirrors.png"), "tiles make another picture");
}

#[test]
fn the_first_command_makes_the_picture_that_is_shown() {
    let text = readme();
    let command = "cargo run --release -- render ";
    let line = text.lines().find(|line| line.contains("cargo run")).expect("a command");
    let arguments = line.strip_prefix(command).expect("the first `cargo run` is the main job");
    let (script, out) = arguments.split_once(" -o ").expect("an output");
    let shown = format!("]({})", script.replace(".rhai", ".png"));
    assert!(text.contains(&shown), "README.md does not show {shown}");
    let name = out.strip_suffix(".png").expect("a PNG");
    assert!(!name.contains(['/', '\\', '.']), "{out} is not in the checkout itself");

    let room = room("first");
    fs::create_dir(room.join("scripts")).expect("a folder");
    fs::copy(top().join(script), room.join(script)).expect("the script");
    let ran = reflet(&room, &format!("render {arguments}"));
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    png_size(&room.join(out));
}

#[test]
fn links_lead_somewhere() {
    let text = readme();
    let mut links = 0;
    for (_, rest) in text.match_indices("](").map(|(at, _)| text.split_at(at + 2)) {
        let target = rest.split([')', '#']).next().unwrap_or_default();
        if !target.is_empty() && !target.contains("://") {
            assert!(top().join(target).exists(), "README.md links to {target}");
            links += 1;
        }
    }
    assert!(links > 10, "only {links} links were found");
}

#[test]
fn every_command_and_option_is_listed() {
    let text = readme();
    let room = room("help");
    let help = |arguments: &str| String::from_utf8(reflet(&room, arguments).stdout).expect("UTF-8");
    // The first word of each line of a section that begins with `prefix`.
    let listed = |help: &str, section: &str, prefix: &str| -> Vec<String> {
        let lines = help.lines().skip_while(|line| *line != section).skip(1);
        let lines = lines.take_while(|line| !line.is_empty() && line.starts_with("  "));
        let names = lines.filter_map(|line| {
            let words = line.split("  ").find(|part| !part.trim().is_empty())?.split_whitespace();
            words.map(|word| word.trim_end_matches(',')).find(|word| word.starts_with(prefix))
        });
        names.map(str::to_owned).collect()
    };
    let commands = listed(&help("--help"), "Commands:", "");
    assert!(commands.len() >= 6, "{commands:?}");
    for command in commands.iter().filter(|c| *c != "help") {
        assert!(text.contains(&format!("| `reflet {command} ")), "README.md lacks {command}");
    }
    let options = listed(&help("render --help"), "Options:", "--");
    assert!(options.len() >= 10, "{options:?}");
    for option in options.iter().filter(|o| !["--help", "--output"].contains(&o.as_str())) {
        assert!(text.contains(&format!("| `{option}")), "README.md lacks {option}");
    }
    let options = listed(&help("profile --help"), "Options:", "--");
    assert!(options.len() >= 15, "{options:?}");
    for option in options.iter().filter(|o| *o != "--help") {
        assert!(text.contains(&format!("`{option}")), "README.md lacks profile's {option}");
    }
}
