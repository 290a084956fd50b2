//! What was typed, taken together: everything that can be wrong before the script is read is found
//! here.

use crate::args::{Command, NewArgs, ParamsArgs, ProfileArgs, RenderArgs, ScriptArgs, Typed};
use crate::check;
use crate::console::Console;
use crate::exit::Failure;
use crate::farm::FarmCommand;
use crate::film::FilmArgs;
use crate::frames::FrameRanges;
use crate::heap;
use crate::merge::MergeArgs;
use crate::parts::{PartArgs, Shard};
use crate::profile::cast::Question;
use crate::profile::inputs::Primitives;
use crate::profile::{Outputs, Profile, Subject};
use crate::verify::VerifyArgs;
use clap_complete::Shell;
use reflet_accel::Isa;
use reflet_film::{Compression, Dither, Format, Target, VideoQuality};
use reflet_frame::{Draft, Resume, Reuse, TileChoice};
use reflet_script::{Options, Source, Stage};
use std::ffi::OsString;
use std::io::IsTerminal;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;

/// What is to be done.
pub enum Meant {
    /// Render.
    Render(Render),
    /// Check a finished sequence.
    Verify(Render),
    /// Join tiles.
    Merge(MergeArgs),
    /// Join frames to a film.
    Film(FilmArgs),
    /// Write a job for a scheduler.
    Farm(FarmCommand),
    /// Measure.
    Profile(Profile),
    /// Say what a scene holds.
    Check(Script, Option<check::Frames>),
    /// List parameters.
    Params(Script, Tell),
    /// Write the starter scene.
    New(NewArgs),
    /// Print completions.
    Completions(Shell),
    /// Print a manual page.
    Man(Option<String>),
}

/// A script and how it runs.
pub struct Script {
    /// Its file.
    pub path: PathBuf,
    /// How it runs.
    pub options: Options,
}

impl Script {
    /// Reads and runs the script.
    ///
    /// # Errors
    /// It cannot be read, is wrong, or does not take a `--set`.
    pub fn load(&self) -> Result<Stage, Failure> {
        Ok(Stage::load(Source::read(&self.path)?, &self.options)?)
    }
}

/// Whom the program talks to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tell {
    /// People: text.
    People,
    /// Programs: JSON on stdout.
    Programs,
    /// A scheduler that speaks Open Job Description, on stdout; people are told the rest.
    Scheduler,
}

/// How much people are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// How far it is, and a summary.
    Summary,
    /// Every frame, too.
    Frames,
}

/// How often a scene is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Times {
    /// Once.
    Once,
    /// At each save.
    AtEachSave,
}

/// A render.
pub struct Render {
    /// The scene.
    pub script: Script,
    /// `OUT` as typed.
    pub output: OsString,
    /// The format's name, if it is not the output's ending.
    pub format: Option<String>,
    /// Which frames; all if `None`.
    pub frames: Option<FrameRanges>,
    /// Width and height in pixels, if not the script's.
    pub size: Option<[u32; 2]>,
    /// Whether this is a quick look.
    pub draft: Draft,
    /// Threads; one per core if `None`.
    pub threads: Option<NonZeroUsize>,
    /// Which kernels.
    pub isa: Isa,
    /// Whether frames build on the frame before.
    pub reuse: Reuse,
    /// Bytes that kept trees may take; a quarter of the free memory if `None`.
    pub cache_bytes: Option<u64>,
    /// Whether frames that stand are kept.
    pub resume: Resume,
    /// Which part of the frames; all if `None`.
    pub shard: Option<Shard>,
    /// Which part of the picture; all if `None`.
    pub tile: Option<TileChoice>,
    /// How much time a smaller file is worth.
    pub compression: Compression,
    /// How a GIF stands for colours that its palette lacks.
    pub dither: Dither,
    /// How well ffmpeg encodes a film.
    pub quality: VideoQuality,
    /// Whom events are told to.
    pub tell: Tell,
    /// Whether people are told of every frame.
    pub detail: Detail,
    /// Once or at each save.
    pub times: Times,
}

impl Meant {
    /// What the command line means.
    ///
    /// # Errors
    /// Words that do not go together, and names that are not known: usage.
    pub fn by(typed: Typed, console: &Console) -> Result<Self, Failure> {
        set_once(typed.command.sets())?;
        Ok(match typed.command {
            Command::Render(args) => Self::Render(render(args, console)?),
            Command::Profile(args) => Self::Profile(profile(*args, console)?),
            Command::Verify(args) => Self::Verify(verify(args, console)?),
            Command::Merge(args) => Self::Merge(args),
            Command::Film(args) => Self::Film(args),
            Command::Farm(command) => Self::Farm(command),
            Command::Check(args) => Self::Check(script(args.script, console), args.frames),
            Command::Params(ParamsArgs { script: args, json }) => {
                Self::Params(script(args, console), tell(json))
            }
            Command::New(args) => Self::New(args),
            Command::Completions { shell } => Self::Completions(shell),
            Command::Man { command } => Self::Man(command),
        })
    }
}

/// Refuses a parameter that is given two values: one of them would be ignored.
fn set_once(sets: &[(String, String)]) -> Result<(), Failure> {
    for (i, (name, second)) in sets.iter().enumerate() {
        if let Some((_, first)) = sets[..i].iter().find(|(before, _)| before == name) {
            return Err(Failure::usage(format!(
                "--set {name} is given twice, as {first} and as {second}: keep one"
            )));
        }
    }
    Ok(())
}

fn script(args: ScriptArgs, console: &Console) -> Script {
    Script { options: options(&args, console), path: args.script }
}

/// How a script is run, by what was typed.
pub fn options(args: &ScriptArgs, console: &Console) -> Options {
    let (path, printer, slow) = (args.script.clone(), console.clone(), console.clone());
    Options {
        max_operations: args.max_operations.get(),
        max_memory: args.max_memory,
        heap: Some(heap::allocated),
        sets: args.set.clone(),
        assets: args.assets.clone(),
        print: Some(Arc::new(move |text, line| {
            printer.say(&format!("{}:{line}: {text}", path.display()));
        })),
        slow: Some(Arc::new(move |text| slow.warn(text))),
    }
}

fn tell(json: bool) -> Tell {
    if json { Tell::Programs } else { Tell::People }
}

fn profile(args: ProfileArgs, console: &Console) -> Result<Profile, Failure> {
    for isa in &args.isa.0 {
        isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
    }
    if args.heatmap.as_ref().is_some_and(|path| path.extension() != Some("png".as_ref())) {
        return Err(Failure::usage("--heatmap writes a PNG; let its name end in .png"));
    }
    let subject = match (args.script, args.rays) {
        (Some(path), _) => {
            let named = ScriptArgs {
                script: path,
                set: args.set,
                assets: args.assets,
                max_operations: args.max_operations,
                max_memory: args.max_memory,
            };
            let outputs = Outputs { dump: args.dump, heatmap: args.heatmap, timeline: args.trace };
            Subject::Scene(script(named, console), args.frame, outputs)
        }
        (None, Some(rays)) => {
            let primitives = match (args.spheres, args.mesh, args.verts, args.tris) {
                (Some(spheres), ..) => Primitives::Spheres(spheres),
                (_, Some(mesh), ..) => Primitives::Mesh(mesh),
                (.., Some(verts), Some(tris)) => Primitives::Indexed(verts, tris),
                _ => return Err(Failure::usage("give --spheres, --mesh, or --verts and --tris")),
            };
            let question = if args.any { Question::Any } else { Question::Closest };
            Subject::Files { primitives, rays, question, hits: args.hits }
        }
        (None, None) => return Err(Failure::usage("give a script, or primitives and --rays")),
    };
    Ok(Profile {
        subject,
        isas: args.isa.0,
        threads: args.threads.into_iter().map(NonZeroUsize::get).collect(),
        repeat: args.repeat.get() as usize,
        quality: args.quality,
        save: args.save,
        against: args.against,
        tell: tell(args.json),
    })
}

fn render(args: RenderArgs, console: &Console) -> Result<Render, Failure> {
    let output = args.output.into_os_string();
    // The animation's length is not known yet, but no other mistake depends on it.
    let target = Target::parse(&output, args.format.as_deref(), 1)
        .map_err(|e| Failure::usage(e.to_string()))?;
    no_terminal(&target)?;
    if target.is_stdout() && args.openjd {
        return Err(Failure::usage("--openjd and -o - both write to stdout; let -o name a file"));
    }
    if target.is_stdout() && args.json {
        return Err(Failure::usage(
            "--json and -o - both write to stdout; let -o name a file, or leave --json out",
        ));
    }
    if target.is_stdout() && args.watch {
        return Err(Failure::usage(
            "--watch renders again and again, and stdout can take one render; let -o name a file",
        ));
    }
    files_for_parts(&target, &args.part)?;
    let (dither, quality) = args.encoding.of(target.format())?;
    args.isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
    Ok(Render {
        script: script(args.script, console),
        output,
        format: args.format,
        frames: args.frames,
        size: args.size.map(|(width, height)| [width, height]),
        draft: if args.draft { Draft::Yes } else { Draft::No },
        threads: args.threads,
        isa: args.isa,
        reuse: if args.no_reuse { Reuse::Never } else { Reuse::Keep },
        cache_bytes: args.cache_mem,
        resume: if args.part.resume { Resume::Keep } else { Resume::Never },
        shard: args.part.shard,
        tile: args.part.tile,
        tell: if args.openjd { Tell::Scheduler } else { tell(args.json) },
        compression: args.compression,
        dither,
        quality,
        detail: if args.verbose { Detail::Frames } else { Detail::Summary },
        times: if args.watch { Times::AtEachSave } else { Times::Once },
    })
}

/// Refuses to write a picture to a terminal.
///
/// # Errors
/// The standard output is one.
pub fn no_terminal(target: &Target) -> Result<(), Failure> {
    match target.is_stdout() && std::io::stdout().is_terminal() {
        true => Err(Failure::usage(format!(
            "-o - writes {} to stdout, which is a terminal: pipe it to a program, as in `| ffmpeg \
             -i - film.mp4`, or let -o name a file",
            target.format()
        ))),
        false => Ok(()),
    }
}

/// What keeps, splits or joins files needs files; what splits, a frame each.
fn files_for_parts(target: &Target, part: &PartArgs) -> Result<(), Failure> {
    let splits = match (part.shard, part.tile) {
        (Some(_), _) => Some("--shard"),
        (_, Some(_)) => Some("--tile"),
        _ => None,
    };
    let needs_files = splits.or(part.resume.then_some("--resume"));
    if let (Some(option), true) = (needs_files, target.is_stdout()) {
        return Err(Failure::usage(format!("{option} needs files; let -o name them, not stdout")));
    }
    if let (Some(option), true) = (splits, target.format().is_film()) {
        return Err(Failure::usage(format!(
            "{option} needs a file for each frame, and {} is one for all: render frames, as in \
             -o out/frame-####.png, and join them with `reflet film`",
            target.format()
        )));
    }
    if part.tile.is_some() && target.format() != Format::Exr {
        return Err(Failure::usage(
            "--tile makes EXR parts, of which `reflet merge` makes any format: let -o end in .exr",
        ));
    }
    Ok(())
}

fn verify(args: VerifyArgs, console: &Console) -> Result<Render, Failure> {
    let output = args.output.into_os_string();
    let target = Target::parse(&output, args.format.as_deref(), 1)
        .map_err(|e| Failure::usage(e.to_string()))?;
    if target.is_stdout() {
        return Err(Failure::usage("verify checks files, as in frame-####.png or film.gif"));
    }
    let (dither, quality) = args.encoding.of(target.format())?;
    Ok(Render {
        script: script(args.script, console),
        output,
        format: args.format,
        frames: args.frames,
        size: args.size.map(|(width, height)| [width, height]),
        draft: if args.draft { Draft::Yes } else { Draft::No },
        threads: None,
        isa: Isa::Auto,
        reuse: Reuse::Keep,
        cache_bytes: None,
        resume: Resume::Never,
        shard: None,
        tile: None,
        compression: args.compression,
        dither,
        quality,
        tell: Tell::People,
        detail: Detail::Summary,
        times: Times::Once,
    })
}
