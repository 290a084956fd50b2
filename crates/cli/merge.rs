//! `reflet merge PARTS -o OUT`: the tiles of one huge picture to the whole.

use crate::console::Console;
use crate::exit::{Exit, Failure};
use crate::progress::bytes;
use crate::signals::Signals;
use clap::Args;
use reflet_film::{Compression, Target};
use reflet_frame::MergeError;
use std::path::PathBuf;

/// What `merge` takes.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The parts, as `render --tile` made them, in any order
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// Where the whole picture goes: the ending is the format
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// How much time a smaller PNG or EXR is worth: fast, balanced or small
    #[arg(long, value_name = "LEVEL", default_value = "fast", value_parser = crate::values::compression())]
    #[arg(hide_possible_values = true)]
    pub compression: Compression,
    /// The format, whatever the output's ending
    #[arg(long, value_name = "EXT", value_parser = crate::values::format())]
    #[arg(hide_possible_values = true)]
    pub format: Option<String>,
}

/// Merges parts.
///
/// # Errors
/// Gaps, overlaps, parts of other pictures or none; the output.
pub fn run(args: &MergeArgs, console: &Console, signals: &Signals) -> Result<(), Failure> {
    let target = Target::parse(args.output.as_os_str(), args.format.as_deref(), 1)
        .map_err(|e| Failure::usage(e.to_string()))?;
    if target.format().is_film() || target.is_stdout() {
        return Err(Failure::usage("merge makes one picture; let -o name a file, as in still.png"));
    }
    if target.is_numbered() {
        return Err(Failure::usage(
            "merge makes one picture; let -o name it without a frame number",
        ));
    }
    let path = target.path_for(0);
    let merge = || reflet_frame::merge(&args.parts, &target, args.compression);
    // A signal that comes meanwhile is waited for, and then no half file stays.
    let merged = signals.rendering(&path, "", |_| merge());
    let merged = merged.map_err(|error| {
        let exit = match error {
            MergeError::Input(_) => Exit::Input,
            MergeError::Output(_) | MergeError::Refused(_) => Exit::Output,
            MergeError::Memory(_) => Exit::Failed,
        };
        Failure::new(exit, error.to_string())
    })?;
    let [width, height] = merged.size;
    console.say(&format!(
        "{} parts to a picture of {width}x{height}, {} to {}",
        merged.parts,
        bytes(merged.bytes),
        path.display()
    ));
    Ok(())
}
