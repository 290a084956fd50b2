//! `reflet film FRAMES -o OUT`: frames on disk to one film.

use crate::console::Console;
use crate::exit::{Exit, Failure};
use crate::frames::FrameRanges;
use crate::progress::bytes;
use crate::signals::Signals;
use clap::Args;
use reflet_film::{Fps, Target};
use reflet_frame::{JoinError, resume::ranges};
use std::path::PathBuf;

/// What `film` takes.
#[derive(Debug, Args)]
pub struct FilmArgs {
    /// The frames: a name with a run of # for the number, as `render -o` was told, or the files in
    /// order
    #[arg(required = true, value_name = "FRAMES")]
    pub inputs: Vec<PathBuf>,
    /// The film; its ending is the format
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Frames a second
    #[arg(long, value_name = "N", default_value = "24")]
    pub fps: f64,
    /// Which of the numbered frames; all that are there without it, which must have no gap
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true)]
    pub frames: Option<FrameRanges>,
    /// The format, whatever the output's ending
    #[arg(long, value_name = "EXT")]
    pub format: Option<String>,
}

/// Makes a film.
///
/// # Errors
/// Frames that are missing, damaged or of different sizes; the film cannot be written.
pub fn run(args: &FilmArgs, console: &Console, signals: &Signals) -> Result<(), Failure> {
    let target = Target::parse(args.output.as_os_str(), args.format.as_deref(), 2)
        .map_err(|e| Failure::usage(e.to_string()))?;
    if !target.format().is_film() {
        return Err(Failure::usage(format!(
            "{} is no film; let -o end in mp4, mkv, ivf, webp, apng, gif or y4m",
            target.format()
        )));
    }
    let fps = Fps::from_f64(args.fps).map_err(|e| Failure::usage(format!("--fps: {e}")))?;
    let paths = inputs(args)?;
    let joined = signals.rendering(&target.path_for(0), "", |cancel| {
        reflet_frame::join(&paths, &target, fps, cancel, &mut |done| {
            console.show(&format!("frame {done}/{}", paths.len()));
        })
    });
    console.show("");
    let written = joined.map_err(|error| match error {
        JoinError::Input(message) => Failure::new(Exit::Input, message),
        JoinError::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
            Failure::quiet(Exit::Output)
        }
        JoinError::Output(error) => Failure::new(Exit::Output, error.to_string()),
        JoinError::Cancelled => {
            let failure = signals.failure().unwrap_or(Failure::quiet(Exit::Interrupted));
            Failure { message: "stopped; no film was made".into(), ..failure }
        }
    })?;
    let (count, path) = (paths.len(), target.path_for(0));
    console.say(&format!("{count} frames, {} to {}", bytes(written), path.display()));
    Ok(())
}

/// The files of the frames, in order.
fn inputs(args: &FilmArgs) -> Result<Vec<PathBuf>, Failure> {
    let [pattern] = &args.inputs[..] else { return unnumbered(args) };
    // What exists by this very name is a frame, whatever characters it has.
    if pattern.is_file() {
        return unnumbered(args);
    }
    // The format does not matter: the bytes tell it.
    let numbered = Target::parse(pattern.as_os_str(), Some("png"), 2)
        .map_err(|e| Failure::usage(e.to_string()))?;
    let missing = |message: String| Failure::new(Exit::Input, message);
    let there = numbered.frames_on_disk().map_err(|e| missing(e.to_string()))?;
    let frames = match &args.frames {
        Some(frames) => {
            frames.within(u32::MAX).map_err(|_| Failure::usage("--frames: too high a number"))?
        }
        None => match (there.first(), there.last()) {
            (Some(first), Some(last)) => (*first..=*last).collect(),
            _ => {
                let first = numbered.path_for(0);
                return Err(missing(format!(
                    "there are no frames by the name of {}, as in {}",
                    pattern.display(),
                    first.display()
                )));
            }
        },
    };
    let gone: Vec<u32> =
        frames.iter().copied().filter(|frame| there.binary_search(frame).is_err()).collect();
    if !gone.is_empty() {
        return Err(missing(format!(
            "frames {} of {} are missing; render them with --resume, or pick others with --frames",
            ranges(&gone),
            pattern.display()
        )));
    }
    Ok(frames.into_iter().map(|frame| numbered.path_for(frame)).collect())
}

fn unnumbered(args: &FilmArgs) -> Result<Vec<PathBuf>, Failure> {
    match args.frames {
        Some(_) => {
            Err(Failure::usage("--frames picks from numbered frames, as in out/frame-####.png"))
        }
        None => Ok(args.inputs.clone()),
    }
}
