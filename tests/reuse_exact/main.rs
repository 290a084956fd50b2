//! A frame made by re-use, the same frame made from scratch in the run, and the frame rendered alone
//! have the same bytes, whatever the frames before it did: whole scripts drawn at random.
//!
//! The short form runs with the other tests. The long one is asked for by a number of frames:
//!
//! ```text
//! REFLET_SOAK_REUSE=100000 cargo test --release --test reuse_exact -- --nocapture
//! ```

mod draw;
mod found;

use draw::{Dice, Script};
use reflet_accel::Isa;
use reflet_film::{Compression, Dither, Target, VideoQuality};
use reflet_frame::{Draft, Job, Resume, Reuse};
use reflet_script::{Options, Source, Stage};
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The files that scripts read.
fn write_inputs(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).expect("an input");
    write("a.ppm", b"P6 2 2 255\n\xff\x00\x00\x00\x00\x00\x80\x80\x80\x10\xff\x20");
    write("b.ppm", b"P6 3 1 255\n\xff\xff\xff\x00\x00\x00\x30\x60\xff");
    write(
        "a.obj",
        b"v -0.5 0 0\nv 0.5 0 0\nv 0 0.9 0\nv 0 0.3 0.8\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    );
    write(
        "b.obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.3 0 1\nvn 0 0.3 1\nvn 0 0 1\nf 1//1 2//2 3//3\n",
    );
    write(
        "c.obj",
        b"mtllib c.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nusemtl red\nf 1 2 3\nusemtl shiny\nf 1 3 4\n",
    );
    write(
        "c.mtl",
        b"newmtl red\nKd 0.9 0.1 0.1\nnewmtl shiny\nKd 0.1 0.1 0.1\nKs 0.8 0.8 0.8\nillum 3\n",
    );
}

/// How a script is rendered; nothing of it may show.
struct Way {
    reuse: Reuse,
    threads: usize,
    isa: Isa,
    cache_bytes: Option<u64>,
    frames: Option<Vec<u32>>,
}

/// Renders a script into files of one folder, and gives their bytes in order.
fn render(script: &Path, out: &Path, way: Way, frames: u32) -> Result<Vec<Vec<u8>>, String> {
    let source = Source::read(script).map_err(|e| e.to_string())?;
    let mut stage = Stage::load(source, &Options::default()).map_err(|e| e.to_string())?;
    let target = out.join("f-####.exr");
    let target = Target::parse(target.as_os_str(), None, frames).map_err(|e| e.to_string())?;
    let wanted = way.frames.clone().unwrap_or_else(|| (0..frames).collect());
    let job = Job {
        frames: way.frames,
        size: None,
        draft: Draft::No,
        threads: NonZeroUsize::new(way.threads),
        isa: way.isa,
        reuse: way.reuse,
        cache_bytes: way.cache_bytes,
        resume: Resume::Never,
        tile: None,
        compression: Compression::default(),
        dither: Dither::default(),
        quality: VideoQuality::default(),
        target: target.clone(),
    };
    let done = reflet_frame::render(&mut stage, &job, &AtomicBool::new(false), &mut |_| {});
    done.map_err(|e| e.to_string())?;
    let read = |frame: &u32| fs::read(target.path_for(*frame)).map_err(|e| e.to_string());
    wanted.iter().map(read).collect()
}

/// Renders a script of so many frames in three ways and says which frames differ, if any.
fn hold(
    what: &str,
    Script { text, frames }: Script,
    dice: &mut Dice,
    folder: &Path,
) -> Result<u32, String> {
    let script = folder.join("s.rhai");
    fs::write(&script, &text).map_err(|e| e.to_string())?;
    let isas: Vec<Isa> = Isa::available().collect();
    let mut way = |reuse| Way {
        reuse,
        threads: 1 + dice.below(3),
        isa: isas[dice.below(isas.len())],
        cache_bytes: dice.pick(&[None, None, Some(0), Some(40_000)]),
        frames: None,
    };
    let (kept, fresh) = (way(Reuse::Keep), way(Reuse::Never));
    let mut alone = |frame| Way { frames: Some(vec![frame]), ..way(Reuse::Keep) };
    let failed = |how: String| format!("{what}: {how}\n{text}");
    let [a, b, c] = ["kept", "fresh", "alone"].map(|name| folder.join(name));
    let kept = render(&script, &a, kept, frames).map_err(failed)?;
    let fresh = render(&script, &b, fresh, frames).map_err(failed)?;
    for frame in 0..frames {
        let i = frame as usize;
        let alone = render(&script, &c, alone(frame), frames).map_err(failed)?;
        let differs: Vec<&str> = [("re-use", &kept[i]), ("--no-reuse", &fresh[i])]
            .into_iter()
            .filter_map(|(how, bytes)| (*bytes != alone[0]).then_some(how))
            .collect();
        if !differs.is_empty() {
            return Err(failed(format!("frame {frame}: {differs:?} differs from the frame alone")));
        }
    }
    Ok(frames)
}

/// A folder in memory where there is one: what is written is read back at once.
fn folder() -> tempfile::TempDir {
    let memory = PathBuf::from("/dev/shm");
    let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    made.expect("a folder")
}

#[test]
fn scripts_that_once_failed_have_the_same_frames_in_three_ways() {
    let folder = folder();
    write_inputs(folder.path());
    for (cause, text) in found::SCRIPTS {
        let frames = text.split("frames: ").nth(1).and_then(|rest| rest.split(' ').next());
        let frames = frames.and_then(|number| number.parse().ok()).expect("a number of frames");
        let script = Script { text: text.to_owned(), frames };
        let held = hold(cause, script, &mut Dice(1), folder.path());
        held.unwrap_or_else(|failure| panic!("{failure}"));
    }
}

#[test]
fn random_scripts_have_the_same_frames_in_three_ways() {
    let long = std::env::var("REFLET_SOAK_REUSE").ok();
    let wanted: u32 = long.map_or(300, |text| text.parse().expect("a number of frames"));
    let first: u64 = std::env::var("REFLET_SOAK_SEED").map_or(0, |s| s.parse().expect("a seed"));
    let folder = folder();
    write_inputs(folder.path());
    let (mut held, mut seed) = (0, first);
    while held < wanted {
        let dice = &mut Dice(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let script = draw::script(dice);
        let held_now = hold(&format!("seed {seed}"), script, dice, folder.path());
        held += held_now.unwrap_or_else(|failure| panic!("{failure}"));
        seed += 1;
    }
    println!("{held} frames of {} scripts", seed - first);
}
