//! `reflet farm`: jobs for schedulers that are there already.

mod commands;
mod openjd;
mod slurm;

use crate::args::ScriptArgs;
use crate::console::{Console, print};
use crate::exit::Failure;
use crate::frames::FrameRanges;
use crate::meant;
use crate::shell::{line, operand, quoted};
use clap::{Args, Subcommand};
use reflet_film::{Compression, Format, Target};
use reflet_frame::resume::ranges;
use reflet_script::{Options, Source, Stage};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The schedulers.
#[derive(Debug, Subcommand)]
pub enum FarmCommand {
    /// A shell script that submits an array job, and the job that joins its files
    #[command(
        before_help = "Examples:\n  reflet farm slurm room.rhai -o out/frame-####.png --film room.mp4 > job.sh\n  sh job.sh --partition=night\n  reflet farm slurm room.rhai -o huge.png --size 30000x20000 --tiles 8x6 > job.sh"
    )]
    Slurm(FarmArgs),
    /// An Open Job Description template, for AWS Deadline Cloud and `openjd run`
    #[command(
        before_help = "Examples:\n  reflet farm openjd room.rhai -o out/frame-####.png > template.json\n  openjd run template.json --step Render"
    )]
    Openjd(FarmArgs),
    /// One command a line, for GNU parallel or OpenCue's cuecmd
    #[command(
        before_help = "Examples:\n  reflet farm commands room.rhai -o out/frame-####.png > tasks.txt\n  parallel --joblog log --resume < tasks.txt"
    )]
    Commands(FarmArgs),
}

impl FarmCommand {
    /// What it takes.
    pub fn args(&self) -> &FarmArgs {
        match self {
            Self::Slurm(args) | Self::Openjd(args) | Self::Commands(args) => args,
        }
    }
}

/// What every kind of job takes.
#[derive(Debug, Args)]
pub struct FarmArgs {
    #[command(flatten)]
    pub script: ScriptArgs,
    /// Where the pictures go, as for `render`
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// The frames to render; all without it
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true)]
    pub frames: Option<FrameRanges>,
    /// The pictures' size instead of the script's
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = crate::values::size)]
    pub size: Option<(u32, u32)>,
    /// How much time a smaller PNG or EXR is worth: fast, balanced or small
    #[arg(long, value_name = "LEVEL", default_value = "fast", value_parser = crate::values::compression())]
    #[arg(hide_possible_values = true)]
    pub compression: Compression,
    /// Frames a task; 10 without it, and for Slurm as many more as leave at most 1000 tasks
    #[arg(long, value_name = "N", value_parser = crate::values::count, allow_negative_numbers = true)]
    pub chunk: Option<NonZeroU32>,
    /// Split one picture into columns x rows, and merge it in the end
    #[arg(long, value_name = "CxR", conflicts_with = "film")]
    pub tiles: Option<Tiles>,
    /// Join the frames to a film in the end
    #[arg(long, value_name = "FILE")]
    pub film: Option<PathBuf>,
}

/// Columns and rows of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    columns: u32,
    rows: u32,
}

impl FromStr for Tiles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            text.parse().ok().filter(|n: &u32| digits && (1..=1000).contains(n))
        };
        let edges = text.split_once(['x', 'X']).map(|(c, r)| (number(c), number(r)));
        match edges {
            Some((Some(columns), Some(rows))) => Ok(Tiles { columns, rows }),
            _ => Err("write columns x rows, each from 1 to 1000, as in 8x6".into()),
        }
    }
}

/// Frames a task, if nobody says.
const CHUNK: usize = 10;

/// A job, whatever schedules it. Its names are text without control characters, and no options.
struct FarmJob {
    script: String,
    output: String,
    /// Folders that files of the scene may come from, beside the script's own.
    assets: Vec<String>,
    /// Other arguments that every task has: `--set`, `--size` and the like.
    more: Vec<String>,
    /// How the whole of tiles is compressed, if not as usual.
    compression: Option<&'static str>,
    fps: f64,
    work: Work,
}

/// What is split, and how.
enum Work {
    /// Frames, so many a task if that was asked for, and the film that is made of them.
    Frames { frames: Vec<u32>, chunk: Option<usize>, film: Option<String> },
    /// One picture, in tiles.
    Tiles { tiles: Tiles, frame: u32 },
}

impl FarmJob {
    /// What every task's command begins with, after the program's name; the output follows.
    fn scene(&self) -> Vec<String> {
        vec!["render".into(), self.script.clone(), "-o".into()]
    }

    /// The options of every task's command.
    fn options(&self) -> Vec<String> {
        let mut words: Vec<String> = self.folders().collect();
        words.extend(self.more.iter().cloned());
        words.push("--resume".into());
        words
    }

    /// The command that checks all frames.
    fn verify(&self, frames: &[u32]) -> Vec<String> {
        let mut words = vec!["verify".into(), self.script.clone(), self.output.clone()];
        words.extend(self.folders());
        words.extend(self.more.iter().cloned());
        words.extend(["--frames".into(), ranges(frames)]);
        words
    }

    fn folders(&self) -> impl Iterator<Item = String> {
        self.assets.iter().flat_map(|folder| ["--assets".into(), folder.clone()])
    }

    /// The option that compresses the whole of tiles.
    fn compressed(&self) -> Vec<String> {
        let name = self.compression.into_iter();
        name.flat_map(|name| ["--compression".into(), name.into()]).collect()
    }

    /// The folder of a picture's parts.
    fn parts(&self) -> String {
        format!("{}.parts", self.output)
    }

    /// The arguments of the command that ends the job, if there is one. Parts are named one by one.
    fn ending(&self) -> Option<Vec<String>> {
        match &self.work {
            Work::Frames { film: None, .. } => None,
            Work::Frames { film: Some(film), frames, .. } => Some(vec![
                "film".into(),
                self.output.clone(),
                "-o".into(),
                film.clone(),
                "--fps".into(),
                self.fps.to_string(),
                "--frames".into(),
                ranges(frames),
            ]),
            Work::Tiles { tiles, .. } => {
                let mut words = vec!["merge".into(), "-o".into(), self.output.clone()];
                words.extend(self.compressed());
                let places = (1..=tiles.rows)
                    .flat_map(|row| (1..=tiles.columns).map(move |column| (column, row)));
                words.extend(places.map(|(c, r)| format!("{}/{c}-{r}.exr", self.parts())));
                Some(words)
            }
        }
    }
}

/// A name as text that every reader of a job takes as it is: what is no text, or would end a line,
/// is refused.
fn name(what: &str, path: &Path) -> Result<String, Failure> {
    let path = operand(path);
    let text = path.to_str().ok_or_else(|| {
        let name = quoted(&path);
        Failure::usage(format!("{what}: the name {name} is no UTF-8, and a job is; rename it"))
    })?;
    plain(what, text)?;
    Ok(text.to_owned())
}

/// Text without control characters.
fn plain(what: &str, text: &str) -> Result<(), Failure> {
    if !text.contains(char::is_control) {
        return Ok(());
    }
    let text = quoted(text);
    Err(Failure::usage(format!(
        "{what}: {text} has control characters, which no job can hold; rename it"
    )))
}

/// Writes a job.
///
/// # Errors
/// The script is wrong; frames or options that do not fit it.
pub fn run(command: &FarmCommand, console: &Console) -> Result<(), Failure> {
    match command {
        FarmCommand::Slurm(args) => {
            let job = planned(args, console)?;
            let array = slurm::Array::of(&job.work);
            if let Some(warning) = array.warning() {
                console.warn(&warning);
            }
            print(slurm::script(&job, array))
        }
        FarmCommand::Openjd(args) => print(openjd::template(&planned(args, console)?)?),
        FarmCommand::Commands(args) => {
            let job = planned(args, console)?;
            print(commands::lines(&job))?;
            if let Some(words) = job.ending() {
                console.say(&format!("when all are done: reflet {}", line(&words)));
            }
            Ok(())
        }
    }
}

/// Runs the script once, so that whatever is wrong is known before anything is submitted.
fn planned(args: &FarmArgs, console: &Console) -> Result<FarmJob, Failure> {
    let script = name("SCRIPT", &args.script.script)?;
    if script == "-" {
        return Err(Failure::usage("tasks read the script from a file; save it under a name"));
    }
    let mut output = name("--output", &args.output)?;
    let film = args.film.as_deref().map(|film| name("--film", film)).transpose()?;
    let assets = args.script.assets.iter().map(|folder| name("--assets", folder));
    let assets: Vec<String> = assets.collect::<Result<_, _>>()?;
    let options = meant::options(&args.script, console);
    let stage = Stage::load(Source::read(&args.script.script)?, &options)?;
    let animation = stage.with_scene(|scene| scene.animation());
    let frames = match &args.frames {
        Some(frames) => frames.within(animation.frames).map_err(Failure::usage)?,
        None => (0..animation.frames).collect(),
    };
    // Numbered as the tasks will number them.
    let usage = |e: reflet_film::TargetError| Failure::usage(e.to_string());
    let numbered = if args.tiles.is_some() { 1 } else { animation.frames };
    let target = Target::parse(output.as_ref(), None, numbered).map_err(usage)?;
    if target.is_stdout() || target.format().is_film() {
        return Err(Failure::usage(
            "the tasks of a farm make a file for each frame: let -o name them, as in \
             out/frame-####.png; --film joins them",
        ));
    }
    if let Some(film) = &args.film {
        let film = Target::parse(film.as_os_str(), None, 1).map_err(usage)?;
        if !film.format().is_film() {
            let message = format!("--film: {} is no film but stills", film.format());
            return Err(Failure::usage(message));
        }
        if !matches!(target.format(), Format::Png | Format::Png16 | Format::Exr | Format::Ppm) {
            return Err(Failure::usage("--film joins PNG, EXR or PPM frames; let -o end so"));
        }
    }
    let mut more = Vec::new();
    for (name, value) in &args.script.set {
        let set = format!("--set={name}={value}");
        plain("--set", &set)?;
        match set.split_at(6) {
            (_, set) if !set.starts_with('-') => more.extend(["--set".into(), set.into()]),
            _ => more.push(set),
        }
    }
    if let Some((width, height)) = args.size {
        more.extend(["--size".into(), format!("{width}x{height}")]);
    }
    if args.script.max_operations.get() != Options::default().max_operations {
        more.extend(["--max-operations".into(), args.script.max_operations.to_string()]);
    }
    if args.script.max_memory != Options::default().max_memory {
        more.extend(["--max-memory".into(), args.script.max_memory.to_string()]);
    }
    let compression = match args.compression {
        Compression::Fast => None,
        Compression::Balanced => Some("balanced"),
        Compression::Small => Some("small"),
    };
    // The compression of parts is not that of the whole.
    if let (Some(name), None) = (compression, args.tiles) {
        more.extend(["--compression".into(), name.into()]);
    }
    let work = match args.tiles {
        None => Work::Frames { frames, chunk: args.chunk.map(|chunk| chunk.get() as usize), film },
        Some(tiles) => match frames[..] {
            [frame] => {
                // The number of a picture is known now, and merging does not know it.
                output = target.path_for(frame).to_string_lossy().into_owned();
                Work::Tiles { tiles, frame }
            }
            _ => {
                return Err(Failure::usage(format!(
                    "--tiles splits one picture, and there are {} frames: pick one, as in --frames 0",
                    frames.len()
                )));
            }
        },
    };
    let job = FarmJob { script, output, assets, more, compression, fps: animation.fps, work };
    can_run(&job)?;
    Ok(job)
}

/// What Linux allows of one argument, and of all arguments of a command, less what the environment
/// may take (`MAX_ARG_STRLEN`, and a quarter of the usual stack).
const ARGUMENT: usize = (128 << 10) - 1;
const ARGUMENTS: usize = 1 << 20;

/// Refuses a job whose last command is too long to be run.
fn can_run(job: &FarmJob) -> Result<(), Failure> {
    let verify = match &job.work {
        Work::Frames { frames, .. } => job.verify(frames),
        Work::Tiles { .. } => Vec::new(),
    };
    for words in [verify, job.ending().unwrap_or_default()] {
        // Each ends in a zero and has a pointer.
        let all: usize = words.iter().map(|word| word.len() + 9).sum();
        if all > ARGUMENTS || words.iter().any(|word| word.len() > ARGUMENT) {
            return Err(Failure::usage(
                "the job's last command would be longer than systems allow: take fewer --tiles, or \
                 --frames in fewer ranges",
            ));
        }
    }
    Ok(())
}
