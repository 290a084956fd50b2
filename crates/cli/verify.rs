//! `reflet verify SCRIPT OUT`: which frames on disk are not what a render would make now.

use crate::args::ScriptArgs;
use crate::console::{Console, print};
use crate::exit::{Exit, Failure};
use crate::film::EncodingArgs;
use crate::frames::FrameRanges;
use crate::meant::Render;
use crate::render;
use crate::signals::Signals;
use clap::Args;
use reflet_film::Compression;
use reflet_frame::{RenderError, Standing, resume};
use std::path::PathBuf;

/// What `verify` takes: the script, and what bears on the bytes of its frames.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    pub script: ScriptArgs,
    /// Where the frames are, as `render -o` was told
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// The frames to check; all without it
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true)]
    pub frames: Option<FrameRanges>,
    /// The pictures' size, if it is not the script's
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = crate::values::size)]
    pub size: Option<(u32, u32)>,
    /// The frames were rendered with --draft
    #[arg(long)]
    pub draft: bool,
    /// How much time a smaller PNG, APNG or EXR was worth: fast, balanced or small
    #[arg(long, value_name = "LEVEL", default_value = "fast", value_parser = crate::values::compression())]
    #[arg(hide_possible_values = true)]
    pub compression: Compression,
    #[command(flatten)]
    pub encoding: EncodingArgs,
    /// The format, if it is not the output's ending
    #[arg(long, value_name = "EXT", value_parser = crate::values::format())]
    #[arg(hide_possible_values = true)]
    pub format: Option<String>,
}

/// Checks a sequence. Frames to be made again go to stdout, in the grammar of `--frames`; why, to
/// stderr.
///
/// # Errors
/// Frames are missing or stale; the script is wrong.
pub fn run(meant: &Render, console: &Console, signals: &Signals) -> Result<(), Failure> {
    let mut stage = meant.script.load()?;
    let Some(job) = render::planned(meant, &stage)? else { return Ok(()) };
    let (mut whole, mut missing, mut again) = (0_usize, Vec::new(), Vec::new());
    let path = job.target.path_for(0);
    let result = signals.rendering(&path, "", |cancel| {
        reflet_frame::verify(&mut stage, &job, cancel, &mut |checked| {
            match checked.standing {
                Standing::Stands => {
                    whole += checked.frames.len();
                    return;
                }
                Standing::Missing => missing.extend(&checked.frames),
                Standing::Stale(why) => {
                    let path = checked.path.display();
                    match &checked.frames[..] {
                        [frame] => console.say(&format!("frame {frame}: {path}: {why}")),
                        _ => console.say(&format!("{path}: {why}")),
                    }
                }
            }
            again.extend(checked.frames);
        })
    });
    match result {
        Err(RenderError::Cancelled) => {
            let failure = signals.failure().unwrap_or_else(|| RenderError::Cancelled.into());
            return Err(Failure { message: "stopped".into(), ..failure });
        }
        result => result?,
    }
    if again.is_empty() {
        let frames = if whole == 1 { "the frame is" } else { "all frames are" };
        console.say(&format!("{frames} up to date ({whole})"));
        return Ok(());
    }
    if !missing.is_empty() {
        console.say(&format!("missing: {}", resume::ranges(&missing)));
    }
    again.sort_unstable();
    print(format!("{}\n", resume::ranges(&again)))?;
    let total = whole + again.len();
    Err(Failure::new(
        Exit::Failed,
        format!(
            "{} of {total} frames are not up to date; `reflet render --resume` makes them",
            again.len()
        ),
    ))
}
