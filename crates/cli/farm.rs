//! `reflet farm`: jobs for schedulers that are there already.

mod commands;
mod openjd;
mod slurm;

use crate::args::ScriptArgs;
use crate::console::{Console, print};
use crate::exit::Failure;
use crate::frames::FrameRanges;
use crate::meant;
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
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = crate::args::size)]
    pub size: Option<(u32, u32)>,
    /// How much time a smaller PNG or EXR is worth: fast, balanced or small
    #[arg(long, value_name = "LEVEL", default_value = "fast", value_parser = crate::args::compression)]
    pub compression: Compression,
    /// Frames a task
    #[arg(long, value_name = "N", default_value = "10")]
    pub chunk: NonZeroU32,
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

/// A job, whatever schedules it.
struct FarmJob {
    script: PathBuf,
    output: PathBuf,
    /// Folders that files of the scene may come from, beside the script's own.
    assets: Vec<PathBuf>,
    /// Other arguments that every task has: `--set`, `--size` and the like.
    more: Vec<String>,
    /// How the whole of tiles is compressed, if not as usual.
    compression: Option<&'static str>,
    fps: f64,
    work: Work,
}

/// What is split, and how.
enum Work {
    /// Frames, so many a task, and the film that is made of them.
    Frames { frames: Vec<u32>, chunk: usize, film: Option<PathBuf> },
    /// One picture, in tiles.
    Tiles { tiles: Tiles, frame: u32 },
}

impl FarmJob {
    /// What every task's command begins with, after the program's name.
    fn render(&self, output: &str) -> Vec<String> {
        let mut words = vec!["render".into(), text(&self.script), "-o".into(), output.into()];
        words.extend(self.folders());
        words.extend(self.more.iter().cloned());
        words.push("--resume".into());
        words
    }

    /// The command that checks all frames.
    fn verify(&self, frames: &[u32]) -> Vec<String> {
        let mut words = vec!["verify".into(), text(&self.script), text(&self.output)];
        words.extend(self.folders());
        words.extend(self.more.iter().cloned());
        words.extend(["--frames".into(), ranges(frames)]);
        words
    }

    fn folders(&self) -> impl Iterator<Item = String> {
        self.assets.iter().flat_map(|folder| ["--assets".into(), text(folder)])
    }

    /// The option that compresses the whole of tiles.
    fn compressed(&self) -> Vec<String> {
        let name = self.compression.into_iter();
        name.flat_map(|name| ["--compression".into(), name.into()]).collect()
    }

    /// The folder of a picture's parts.
    fn parts(&self) -> String {
        format!("{}.parts", text(&self.output))
    }

    /// The arguments of the command that ends the job, if there is one. Parts are named one by one.
    fn ending(&self) -> Option<Vec<String>> {
        match &self.work {
            Work::Frames { film: None, .. } => None,
            Work::Frames { film: Some(film), frames, .. } => Some(vec![
                "film".into(),
                text(&self.output),
                "-o".into(),
                text(film),
                "--fps".into(),
                self.fps.to_string(),
                "--frames".into(),
                ranges(frames),
            ]),
            Work::Tiles { tiles, .. } => {
                let mut words = vec!["merge".into(), "-o".into(), text(&self.output)];
                words.extend(self.compressed());
                let places = (1..=tiles.rows)
                    .flat_map(|row| (1..=tiles.columns).map(move |column| (column, row)));
                words.extend(places.map(|(c, r)| format!("{}/{c}-{r}.exr", self.parts())));
                Some(words)
            }
        }
    }
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// A word as a POSIX shell reads it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,%@+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.into();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

fn line(words: &[String]) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// Writes a job.
///
/// # Errors
/// The script is wrong; frames or options that do not fit it.
pub fn run(command: &FarmCommand, console: &Console) -> Result<(), Failure> {
    match command {
        FarmCommand::Slurm(args) => print(slurm::script(&planned(args, console)?)),
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
    let target = Target::parse(args.output.as_os_str(), None, numbered).map_err(usage)?;
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
        more.extend(["--set".into(), format!("{name}={value}")]);
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
        None => Work::Frames { frames, chunk: args.chunk.get() as usize, film: args.film.clone() },
        Some(tiles) => match frames[..] {
            [frame] => Work::Tiles { tiles, frame },
            _ => {
                return Err(Failure::usage(format!(
                    "--tiles splits one picture, and there are {} frames: pick one, as in --frames 0",
                    frames.len()
                )));
            }
        },
    };
    Ok(FarmJob {
        script: args.script.script.clone(),
        output: args.output.clone(),
        assets: args.script.assets.clone(),
        more,
        compression,
        fps: animation.fps,
        work,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        assert_eq!(quoted("out/frame-%04d.png"), "out/frame-%04d.png");
        assert_eq!(quoted("out/frame-####.png"), "'out/frame-####.png'");
        assert_eq!(quoted("it's $HOME"), "'it'\\''s $HOME'");
        assert_eq!(quoted(""), "''");
    }
}
