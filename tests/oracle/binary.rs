//! The binary's picture of a script.

use super::vec3::v3;
use super::view::Picture;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder of this name for a test's own files, under cargo's folder for them.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder for the test's files");
    folder
}

/// What a run of `reflet render` gave.
pub struct Rendered {
    pub picture: Picture,
    /// The lines of `--json`.
    pub events: String,
}

impl Rendered {
    /// The number of rays of a kind (`camera`, `mirror` or `shadow`) in the only frame.
    pub fn rays(&self, kind: &str) -> u64 {
        let frame = self
            .events
            .lines()
            .find(|line| line.contains("\"event\":\"frame\""))
            .unwrap_or_else(|| panic!("no frame event in:\n{}", self.events));
        let rays = &frame[frame.find("\"rays\"").expect("rays in the frame event")..];
        let value = &rays[rays.find(&format!("\"{kind}\":")).expect("this kind of ray")..];
        let digits = value[kind.len() + 3..].split(|c: char| !c.is_ascii_digit()).next();
        digits.and_then(|d| d.parse().ok()).unwrap_or_else(|| panic!("no count in {value}"))
    }
}

/// Renders `script` (which is kept at `path`, so that a failure can be looked at) to a float
/// picture beside it.
pub fn render(path: &Path, script: &str, arguments: &[&str]) -> Result<Rendered, String> {
    std::fs::write(path, script).map_err(|e| format!("{}: {e}", path.display()))?;
    let out = path.with_extension("pfm");
    let run = Command::new(env!("CARGO_BIN_EXE_reflet"))
        .arg("render")
        .arg(path)
        .arg("-o")
        .arg(&out)
        .arg("--json")
        .args(arguments)
        .output()
        .map_err(|e| format!("the binary did not start: {e}"))?;
    if !run.status.success() {
        let said = String::from_utf8_lossy(&run.stderr);
        return Err(format!("{}: {}\n{said}", path.display(), run.status));
    }
    let events = String::from_utf8_lossy(&run.stdout).into_owned();
    // A frame of an animation has its number in its name.
    let written = events.split("\"path\":\"").nth(1).and_then(|rest| rest.split('"').next());
    let out = written.map_or(out, PathBuf::from);
    let bytes = std::fs::read(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let picture = read_pfm(&bytes).map_err(|e| format!("{}: {e}", out.display()))?;
    std::fs::remove_file(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    Ok(Rendered { picture, events })
}

/// Renders `script`; a failure ends the test. `name` must be unique among a test program's calls.
pub fn rendered(name: &str, script: &str) -> Rendered {
    let path = folder("model").join(format!("{name}.rhai"));
    match render(&path, script, &[]) {
        Ok(rendered) => rendered,
        Err(why) => panic!("{why}\nthe script:\n{script}"),
    }
}

/// Decodes a colour PFM: three header lines, then rows of f32 triples, the bottom row first.
pub fn read_pfm(bytes: &[u8]) -> Result<Picture, String> {
    let mut rest = bytes;
    let mut word = || -> Result<&str, String> {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or("no header")?;
        let end = rest[start..].iter().position(u8::is_ascii_whitespace).ok_or("no header")?;
        let word = std::str::from_utf8(&rest[start..start + end]).map_err(|e| e.to_string())?;
        // Exactly one white byte ends the header.
        rest = &rest[start + end + 1..];
        Ok(word)
    };
    if word()? != "PF" {
        return Err("not a colour PFM".to_owned());
    }
    let size = |text: &str| text.parse::<usize>().map_err(|e| format!("size {text}: {e}"));
    let (width, height) = (size(word()?)?, size(word()?)?);
    let scale: f32 = word()?.parse().map_err(|e| format!("scale: {e}"))?;
    if rest.len() != width * height * 12 {
        return Err(format!("{} bytes for {width} x {height} pixels", rest.len()));
    }
    let value = |i: usize| {
        let b: [u8; 4] = rest[i * 4..i * 4 + 4].try_into().expect("four bytes");
        f64::from(if scale < 0.0 { f32::from_le_bytes(b) } else { f32::from_be_bytes(b) })
    };
    let pixels = (0..width * height)
        .map(|i| {
            let from = ((height - 1 - i / width) * width + i % width) * 3;
            v3(value(from), value(from + 1), value(from + 2))
        })
        .collect();
    Ok(Picture { width, height, pixels })
}
