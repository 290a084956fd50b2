//! What can be typed: the command line, word by word. What it means together is [`crate::meant`]'s.

use crate::check::CheckArgs;
use crate::farm::FarmCommand;
use crate::film::{EncodingArgs, FilmArgs};
use crate::frames::FrameRanges;
use crate::merge::MergeArgs;
use crate::parts::PartArgs;
use crate::values::{
    Isas, bytes, command, compression, count, format, frame, isa, isas, operations, quality, size,
    threads,
};
use crate::verify::VerifyArgs;
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use reflet_accel::{Isa, Quality};
use reflet_film::Compression;
use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  reflet new room                                     write a starter scene, room.rhai
  reflet render room.rhai -o room.png                 one picture
  reflet render room.rhai -o out/frame-####.png       every frame of its animation, one file each
  reflet render room.rhai -o room.gif --draft         the animation as a film, small and quick
  reflet render room.rhai -o room.png --watch         again at each save of the script
  reflet check room.rhai                              what the scene holds, and what looks wrong";

const RENDER_EXAMPLES: &str = "\
Examples:
  reflet render room.rhai -o room.png
  reflet render room.rhai -o out/frame-####.exr --frames 0-119:10
  reflet render room.rhai -o room.png --size 1920x1080 --set gloss=0.7
  reflet render room.rhai -o room.png --frames 57 --draft --watch
  reflet render room.rhai -o - | ffmpeg -i - room.mp4";

const PROFILE_EXAMPLES: &str = "\
Examples:
  reflet profile room.rhai                            one frame: its stages, its rays by kind
  reflet profile --spheres balls.npy --rays camera.npy
  reflet profile --mesh bunny.obj --rays shadow.npy --any --json
  reflet profile --verts v.npy --tris t.npy --rays r.npy --hits hits.npy --isa all --threads 1,2";

const CODES: &str = "\
Exit codes:
  0  done                              74  an output could not be written
  1  some frames failed otherwise      75  stopped by SIGUSR1; --resume goes on
  2  the command line is wrong        130  stopped by SIGINT (Ctrl-C)
 65  the script is wrong              143  stopped by SIGTERM
 66  an input is missing or bad";

/// A ray tracer: scenes are scripts, and a frame costs only what changed.
#[derive(Debug, Parser)]
#[command(name = "reflet", version, before_help = EXAMPLES, after_help = CODES)]
#[command(max_term_width = 100, arg_required_else_help = true)]
pub struct Typed {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene: a picture, a sequence of pictures or a film
    #[command(before_help = RENDER_EXAMPLES, after_help = CODES)]
    Render(RenderArgs),
    /// Check a finished sequence: which frames are missing, damaged or stale
    #[command(
        before_help = "Examples:\n  reflet verify room.rhai out/frame-####.png\n  reflet verify room.rhai out/frame-####.png --frames 0-99 --set gloss=1"
    )]
    Verify(VerifyArgs),
    /// Join the tiles of one huge picture
    #[command(
        before_help = "Examples:\n  reflet render room.rhai -o parts/1.exr --tile 1,1/2x1\n  reflet render room.rhai -o parts/2.exr --tile 2,1/2x1\n  reflet merge parts/*.exr -o room.png"
    )]
    Merge(MergeArgs),
    /// Join frames on disk to a film
    #[command(
        before_help = "Examples:\n  reflet film out/frame-####.png -o room.mp4\n  reflet film out/frame-####.png -o room.webp --fps 12 --frames 0-119:2"
    )]
    Film(FilmArgs),
    /// Write a job for a scheduler: Slurm, Open Job Description, or one command a line
    #[command(
        subcommand,
        before_help = "Examples:\n  reflet farm slurm room.rhai -o out/frame-####.png > job.sh\n  reflet farm commands room.rhai -o out/frame-####.png | parallel"
    )]
    Farm(FarmCommand),
    /// Say what a scene holds, and warn of what looks wrong
    #[command(
        before_help = "Examples:\n  reflet check room.rhai\n  reflet check room.rhai --frames all --set gloss=1"
    )]
    Check(CheckArgs),
    /// Measure how fast rays are, a scene's or from files
    #[command(before_help = PROFILE_EXAMPLES, after_help = CODES)]
    Profile(Box<ProfileArgs>),
    /// Write a commented starter scene
    #[command(before_help = "Examples:\n  reflet new room           writes room.rhai")]
    New(NewArgs),
    /// List a scene's parameters
    #[command(
        before_help = "Examples:\n  reflet params room.rhai\n  reflet params room.rhai --json   for programs"
    )]
    Params(ParamsArgs),
    /// Print a completion script for a shell
    #[command(
        before_help = "Examples:\n  reflet completions bash > ~/.local/share/bash-completion/completions/reflet\n  reflet completions zsh > ~/.zfunc/_reflet"
    )]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page, in roff
    #[command(
        before_help = "Examples:\n  reflet man | man -l -\n  reflet man render > reflet-render.1"
    )]
    Man {
        /// The command whose page it is; without it, the page of all
        #[arg(value_parser = command(), hide_possible_values = true)]
        command: Option<String>,
    },
}

impl Command {
    /// The values that parameters are given.
    pub fn sets(&self) -> &[(String, String)] {
        match self {
            Self::Render(args) => &args.script.set,
            Self::Verify(args) => &args.script.set,
            Self::Farm(command) => &command.args().script.set,
            Self::Check(args) => &args.script.set,
            Self::Profile(args) => &args.set,
            Self::Params(args) => &args.script.set,
            Self::Merge(_) | Self::Film(_) | Self::New(_) => &[],
            Self::Completions { .. } | Self::Man { .. } => &[],
        }
    }
}

/// A script and what bears on running it.
#[derive(Debug, Args)]
pub struct ScriptArgs {
    /// The scene, a Rhai script
    pub script: PathBuf,
    /// Give a parameter of the script a value (may be repeated)
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub set: Vec<(String, String)>,
    /// A folder that files of the scene may come from, beside the script's own (may be repeated)
    #[arg(long, value_name = "DIR", value_parser = folder)]
    pub assets: Vec<PathBuf>,
    /// Stop a script that takes more operations than this
    #[arg(long, value_name = "N", default_value = "1000000000", value_parser = operations)]
    #[arg(allow_negative_numbers = true)]
    pub max_operations: NonZeroU64,
    /// Stop a script that holds more memory than this: bytes, or with K, M or G; files that it
    /// reads do not count
    #[arg(long, value_name = "BYTES", default_value = "1G", value_parser = bytes)]
    pub max_memory: u64,
}

/// A folder that is there.
fn folder(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.metadata() {
        Ok(about) if about.is_dir() => Ok(path),
        Ok(_) => Err("this is a file; name the folder that it is in".to_owned()),
        Err(_) => Err("there is no such folder".to_owned()),
    }
}

/// What `render` takes.
#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub script: ScriptArgs,
    /// Where the pictures go: the ending is the format, a run of # the frame number, - is stdout
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// The frames to render: 7, 0-119, 0-119:10 (every tenth), or a list with commas
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true)]
    pub frames: Option<FrameRanges>,
    /// The picture's size instead of the script's, each side 1 to 65535
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Quarter width and height, at most 3 bounces
    #[arg(long)]
    pub draft: bool,
    /// Render again at each save of the script or of a file that it names, until stopped
    #[arg(long)]
    pub watch: bool,
    /// Worker threads, at most 1024; by default one per core
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<NonZeroUsize>,
    /// The kernels: scalar, sse2, sse4.2, avx2, avx512, neon or auto; all give the same picture
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = isa())]
    #[arg(hide_possible_values = true)]
    pub isa: Isa,
    /// Trace every frame from nothing; the picture is the same
    #[arg(long)]
    pub no_reuse: bool,
    /// Memory for what is kept between frames: bytes, or with K, M or G; by default a quarter of
    /// what is free; the picture is the same
    #[arg(long, value_name = "BYTES", value_parser = bytes, allow_negative_numbers = true)]
    pub cache_mem: Option<u64>,
    #[command(flatten)]
    pub part: PartArgs,
    /// The format, whatever the output's ending: png, png16, exr, exr16, qoi, jpg, ppm, pfm, gif,
    /// apng, webp, y4m, mp4 or mkv
    #[arg(long, value_name = "EXT", value_parser = format(), hide_possible_values = true)]
    pub format: Option<String>,
    #[command(flatten)]
    pub encoding: EncodingArgs,
    /// How much time a smaller PNG or EXR is worth: fast, balanced or small; all are lossless
    #[arg(long, value_name = "LEVEL", default_value = "fast", value_parser = compression())]
    #[arg(hide_possible_values = true)]
    pub compression: Compression,
    /// Print one JSON event a line on stdout
    #[arg(long)]
    pub json: bool,
    /// Print progress on stdout as Open Job Description wants it
    #[arg(long, conflicts_with = "json")]
    pub openjd: bool,
    /// Say of every frame what changed, what was redone for it and why
    #[arg(short, long)]
    pub verbose: bool,
}

/// What `profile` takes.
#[derive(Debug, Args)]
pub struct ProfileArgs {
    /// A scene, of which one frame is measured
    #[arg(conflicts_with_all = ["rays", "primitives"], required_unless_present = "rays")]
    pub script: Option<PathBuf>,
    /// Give a parameter of the script a value (may be repeated)
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment, conflicts_with = "rays")]
    pub set: Vec<(String, String)>,
    /// A folder that files of the scene may come from, beside the script's own (may be repeated)
    #[arg(long, value_name = "DIR", value_parser = folder, conflicts_with = "rays")]
    pub assets: Vec<PathBuf>,
    /// Stop a script that takes more operations than this
    #[arg(long, value_name = "N", default_value = "1000000000", value_parser = operations)]
    #[arg(allow_negative_numbers = true)]
    pub max_operations: NonZeroU64,
    /// Stop a script that holds more memory than this: bytes, or with K, M or G; files that it
    /// reads do not count
    #[arg(long, value_name = "BYTES", default_value = "1G", value_parser = bytes)]
    pub max_memory: u64,
    /// Which frame of the script
    #[arg(long, value_name = "N", default_value = "0", value_parser = frame)]
    #[arg(allow_negative_numbers = true)]
    pub frame: u32,
    /// Spheres: a .npy array of (n, 4) f32, centre and radius
    #[arg(long, value_name = "S.npy", group = "primitives", requires = "rays")]
    pub spheres: Option<PathBuf>,
    /// Triangles: an OBJ file
    #[arg(long, value_name = "M.obj", group = "primitives", requires = "rays")]
    pub mesh: Option<PathBuf>,
    /// Triangles: a .npy array of (n, 3) f32, the positions of their corners
    #[arg(long, value_name = "V.npy", group = "primitives", requires_all = ["tris", "rays"])]
    pub verts: Option<PathBuf>,
    /// Triangles: a .npy array of (n, 3) u32, three rows of --verts each
    #[arg(long, value_name = "T.npy", requires = "verts")]
    pub tris: Option<PathBuf>,
    /// Rays: a .npy array of (n, 8) f32: origin, tmin, unit direction, tmax
    #[arg(long, value_name = "R.npy", requires = "primitives")]
    pub rays: Option<PathBuf>,
    /// Ask only whether each ray hits anything
    #[arg(long, requires = "rays")]
    pub any: bool,
    /// Write the answers: a .npy array of (n,) with the fields t (f32) and prim (u32)
    #[arg(long, value_name = "OUT.npy", requires = "rays")]
    pub hits: Option<PathBuf>,
    /// The kernels: scalar, sse2, sse4.2, avx2, avx512, neon, auto, or all that this machine has
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = isas())]
    #[arg(hide_possible_values = true)]
    pub isa: Isas,
    /// How much the tree of boxes is worth: fast, balanced or high; no hit depends on it
    #[arg(long, value_name = "LEVEL", default_value = "balanced", value_parser = quality())]
    #[arg(hide_possible_values = true)]
    pub quality: Quality,
    /// Threads, at most 1024; with commas, one measurement each
    #[arg(long, value_name = "N,...", default_value = "1", value_delimiter = ',', value_parser = threads)]
    #[arg(allow_negative_numbers = true)]
    pub threads: Vec<NonZeroUsize>,
    /// How often; the median counts
    #[arg(long, value_name = "N", default_value = "5", value_parser = count)]
    #[arg(allow_negative_numbers = true)]
    pub repeat: NonZeroU32,
    /// Write the scene's primitives, and its rays by kind, as .npy files into a folder
    #[arg(long, value_name = "DIR", conflicts_with = "rays")]
    pub dump: Option<PathBuf>,
    /// Write what each pixel costs, node visits and primitive tests, as a PNG with a legend
    #[arg(long, value_name = "OUT.png", conflicts_with = "rays")]
    pub heatmap: Option<PathBuf>,
    /// Write stages and tiles on their threads as a timeline for ui.perfetto.dev
    #[arg(long, value_name = "OUT.json", conflicts_with = "rays")]
    pub trace: Option<PathBuf>,
    /// Write the figures with all repetitions, for a later --against
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Compare with figures of --save: ratios, and whether they exceed the noise
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Print one JSON object a measurement on stdout
    #[arg(long)]
    pub json: bool,
}

/// What `new` takes.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The scene's name; `.rhai` is added if it is not there
    pub name: PathBuf,
}

/// What `params` takes.
#[derive(Debug, Args)]
pub struct ParamsArgs {
    #[command(flatten)]
    pub script: ScriptArgs,
    /// Print one JSON array on stdout
    #[arg(long)]
    pub json: bool,
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("write a parameter's name and its value, as in gloss=0.7".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_declaration_is_sound() {
        Typed::command().debug_assert();
    }

    #[test]
    fn help_opens_with_examples() {
        let mut command = Typed::command();
        assert!(command.render_help().to_string().starts_with("Examples:\n"));
        // `help` itself is clap's.
        for sub in command.get_subcommands_mut().filter(|sub| sub.get_name() != "help") {
            let help = sub.render_help().to_string();
            assert!(help.starts_with("Examples:\n"), "{}", sub.get_name());
        }
    }

    #[test]
    fn assignments() {
        assert_eq!(assignment("a=1"), Ok(("a".into(), "1".into())));
        assert_eq!(assignment("a=b=c"), Ok(("a".into(), "b=c".into())));
        for bad in ["", "a", "=1", "a=", " = "] {
            assert!(assignment(bad).is_err(), "{bad:?}");
        }
    }
}
