//! Every scene in `scripts/` makes, pixel for pixel, the picture that stands beside it: a still its
//! only frame, an animation its middle one.
//!
//! When a scene or the model changes on purpose, this writes the pictures anew; look at them before
//! they are committed:
//!
//! ```text
//! REFLET_BLESS=1 cargo test --release --test scripts_golden
//! ```

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a picture beside a script may weigh, so that a clone stays small.
const MAX_BYTES: u64 = 200_000;
const MAX_SIZE: (u32, u32) = (640, 360);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts")
}

/// The files in `scripts/` with this ending, in the order of their names.
fn files(ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder()).expect("scripts/");
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry of scripts/").path())
        .filter(|path| path.extension() == Some(OsStr::new(ending)))
        .collect();
    files.sort();
    files
}

/// The number of the middle frame: half of what the script's text gives as `frames`, 0 of a still.
fn middle_frame(script: &Path) -> u32 {
    let text = fs::read_to_string(script).expect("a script");
    let Some((_, animation)) = text.split_once("\nanimation(#{ frames: ") else { return 0 };
    let digits = animation.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
    digits.parse::<u32>().expect("a number of frames") / 2
}

/// Renders the middle frame of `script` and gives the file.
fn render(script: &Path) -> Result<PathBuf, String> {
    let frame = middle_frame(script);
    let name = script.file_stem().and_then(OsStr::to_str).expect("a plain name");
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scripts");
    fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let run = Command::new(env!("CARGO_BIN_EXE_reflet"))
        .arg("render")
        .arg(script)
        .arg("-o")
        .arg(out.join(format!("{name}-####.png")))
        .args(["--frames", &frame.to_string()])
        .output()
        .map_err(|e| format!("the binary did not start: {e}"))?;
    if !run.status.success() {
        return Err(format!("{}\n{}", run.status, String::from_utf8_lossy(&run.stderr)));
    }
    Ok(out.join(format!("{name}-{frame:04}.png")))
}

/// Size, and 8-bit samples a pixel, however the file stores them.
type Pixels = ((u32, u32), png::ColorType, Vec<u8>);

fn pixels(path: &Path) -> Result<Pixels, String> {
    let fault = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let file = fs::File::open(path).map_err(|e| fault(&e))?;
    let mut decoder = png::Decoder::new(std::io::BufReader::new(file));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|e| fault(&e))?;
    let size = reader.output_buffer_size().ok_or_else(|| fault(&"too large"))?;
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(|e| fault(&e))?;
    bytes.truncate(info.buffer_size());
    Ok(((info.width, info.height), info.color_type, bytes))
}

/// `Err` with what differs between the picture beside the script and the one just made.
fn hold(golden: &Path, made: &Path) -> Result<(), String> {
    let (want, got) = (pixels(golden)?, pixels(made)?);
    let bytes = fs::metadata(golden).map_err(|e| format!("{}: {e}", golden.display()))?.len();
    let (width, height) = want.0;
    if bytes > MAX_BYTES || width > MAX_SIZE.0 || height > MAX_SIZE.1 {
        return Err(format!("{width} x {height} and {bytes} bytes are too much"));
    }
    if (want.0, want.1) != (got.0, got.1) {
        return Err(format!("{:?} {:?}, golden {:?} {:?}", got.0, got.1, want.0, want.1));
    }
    let samples = want.2.len() / (width * height) as usize;
    let differ: Vec<usize> = want
        .2
        .chunks(samples)
        .zip(got.2.chunks(samples))
        .enumerate()
        .filter_map(|(i, (a, b))| (a != b).then_some(i))
        .collect();
    let Some(first) = differ.first() else { return Ok(()) };
    let (x, y) = (first % width as usize, first / width as usize);
    let at = |bytes: &[u8]| bytes[first * samples..][..samples].to_vec();
    Err(format!(
        "{} pixels differ; the first, ({x}, {y}), is {:?}, golden {:?}; see {}",
        differ.len(),
        at(&got.2),
        at(&want.2),
        made.display()
    ))
}

#[test]
fn every_script_makes_the_picture_beside_it() {
    let scripts = files("rhai");
    assert!(scripts.len() >= 10, "{} scripts", scripts.len());
    let bless = std::env::var_os("REFLET_BLESS").is_some();
    let mut failed = Vec::new();
    for script in &scripts {
        let golden = script.with_extension("png");
        let held = render(script).and_then(|made| {
            if bless {
                fs::copy(&made, &golden).map_err(|e| format!("{}: {e}", golden.display()))?;
            }
            hold(&golden, &made)
        });
        if let Err(why) = held {
            failed.push(format!("{}: {why}", script.display()));
        }
    }
    assert!(
        failed.is_empty(),
        "{} of {}:\n{}\n(REFLET_BLESS=1 writes them anew)",
        failed.len(),
        scripts.len(),
        failed.join("\n")
    );
}

#[test]
fn every_picture_has_its_script() {
    for golden in files("png") {
        assert!(golden.with_extension("rhai").is_file(), "{} has no script", golden.display());
    }
}
