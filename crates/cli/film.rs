//! `reflet film FRAMES -o OUT`: frames on disk to one film.

use crate::console::Console;
use crate::exit::{Exit, Failure};
use crate::frames::FrameRanges;
use crate::meant::no_terminal;
use crate::progress::bytes;
use crate::signals::Signals;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use reflet_film::{Dither, Format, Fps, Target, VideoQuality};
use reflet_frame::{JoinError, JoinEvent, JoinOptions, resume::ranges};
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
    /// Frames a second: a number, or a fraction as in 24000/1001
    #[arg(long, value_name = "N", default_value = "24", value_parser = fps)]
    pub fps: Fps,
    #[command(flatten)]
    pub encoding: EncodingArgs,
    /// Which of the numbered frames; all that are there without it, which must have no gap
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true)]
    pub frames: Option<FrameRanges>,
    /// The format, whatever the output's ending
    #[arg(long, value_name = "EXT")]
    pub format: Option<String>,
}

/// How a film is encoded, where its format leaves a choice.
#[derive(Clone, Copy, Debug, Args)]
pub struct EncodingArgs {
    /// How a GIF stands for colours that its palette of 256 lacks: none takes the nearest, ordered
    /// a fixed pattern of near ones [default: none]
    #[arg(long, value_name = "HOW", value_parser = dither())]
    pub dither: Option<Dither>,
    /// How well ffmpeg encodes an MP4 or MKV, 0 to 100: two are one step of H.264's CRF, 100 is
    /// CRF 1 [default: 68, CRF 16]
    #[arg(long, value_name = "N", value_parser = quality)]
    pub quality: Option<VideoQuality>,
}

impl EncodingArgs {
    /// What is chosen for a format.
    ///
    /// # Errors
    /// The format leaves no such choice.
    pub fn of(self, format: Format) -> Result<(Dither, VideoQuality), Failure> {
        if self.dither.is_some() && format != Format::Gif {
            return Err(Failure::usage(format!("--dither is for gif, and -o is {format}")));
        }
        if self.quality.is_some() && !format.is_by_ffmpeg() {
            return Err(Failure::usage(format!(
                "--quality is for films that ffmpeg encodes, mp4 and mkv, and -o is {format}"
            )));
        }
        Ok((self.dither.unwrap_or_default(), self.quality.unwrap_or_default()))
    }
}

fn dither() -> impl TypedValueParser<Value = Dither> {
    let all = [Dither::None, Dither::Ordered];
    PossibleValuesParser::new(all.map(Dither::name))
        .map(move |name| all.into_iter().find(|dither| dither.name() == name).unwrap_or_default())
}

fn quality(text: &str) -> Result<VideoQuality, String> {
    let quality = text.parse().ok().and_then(VideoQuality::new);
    quality.ok_or_else(|| "a whole number from 0 to 100".into())
}

fn fps(text: &str) -> Result<Fps, String> {
    Fps::from_text(text).map_err(|error| error.to_string())
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
    no_terminal(&target)?;
    let (dither, quality) = args.encoding.of(target.format())?;
    let options = JoinOptions { fps: args.fps, dither, quality };
    let paths = inputs(args)?;
    let joined = signals.rendering(&target.path_for(0), "", |cancel| {
        reflet_frame::join(&paths, &target, options, cancel, &mut |event| match event {
            JoinEvent::Joined(done) => console.show(&format!("frame {done}/{}", paths.len())),
            JoinEvent::Warning(text) => console.warn(text),
        })
    });
    console.show("");
    let written = joined.map_err(|error| match error {
        JoinError::Input(message) => Failure::new(Exit::Input, message),
        JoinError::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
            Failure::quiet(Exit::Output)
        }
        error @ (JoinError::Output(_) | JoinError::Refused(_)) => {
            Failure::new(Exit::Output, error.to_string())
        }
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
