//! `reflet render`: from a script to files.

use crate::console::Console;
use crate::exit::{Exit, Failure};
use crate::json::Line;
use crate::meant::{Detail, Render, Tell, Times};
use crate::progress::{self, Progress};
use crate::signals::Signals;
use crate::told;
use reflet_film::Target;
use reflet_frame::{Event, Job, RenderError, Resume, Standing, resume};
use reflet_script::Stage;
use std::io::{self, Write};
use std::path::PathBuf;

/// Renders once.
///
/// # Errors
/// Whatever goes wrong; with `--json` the last line on stdout says it, too.
pub fn run(meant: &Render, console: &Console, signals: &Signals) -> Result<(), Failure> {
    once(meant, console, signals, &mut |_| {})
}

/// Renders once. `read` is told the files that the script has read, as soon as it has.
///
/// # Errors
/// Like [`run`].
pub fn once(
    meant: &Render,
    console: &Console,
    signals: &Signals,
    read: &mut dyn FnMut(&[PathBuf]),
) -> Result<(), Failure> {
    let result = job(meant, console, signals, read);
    if let (Err(failure), Tell::Scheduler) = (&result, meant.tell) {
        // Nothing can be told to a scheduler that does not read.
        let _ = openjd("fail", failure.message.lines().next().unwrap_or("stopped"));
    }
    if let (Err(failure), Tell::Programs) = (&result, meant.tell)
        && let Err(error) = Line::error(failure).print()
        && error.kind() == io::ErrorKind::BrokenPipe
    {
        return Err(Failure::quiet(failure.exit));
    }
    result
}

fn job(
    meant: &Render,
    console: &Console,
    signals: &Signals,
    read: &mut dyn FnMut(&[PathBuf]),
) -> Result<(), Failure> {
    let mut stage = meant.script.load()?;
    read(&stage.inputs());
    let Some(job) = planned(meant, &stage)? else {
        if let Some(shard) = meant.shard {
            console.say(&format!("shard {shard} has no frames: there are more shards than frames"));
        }
        return Ok(());
    };

    let mut teller = Teller {
        meant,
        console,
        signals,
        progress: None,
        frames: 0,
        done: 0,
        missing: Vec::new(),
        unread: None,
    };
    let how = how_to_resume(&job);
    let result = signals.rendering(&job.target.path_for(0), how, |cancel| {
        reflet_frame::render(&mut stage, &job, cancel, &mut |event| teller.event(&event))
    });
    read(&stage.inputs());
    if let Some(progress) = &teller.progress {
        progress.end();
    }
    match result {
        Ok(summary) => match meant.tell {
            Tell::Programs => Line::done(&summary).print().map_err(|e| unread(&e)),
            Tell::People | Tell::Scheduler => {
                let frames = job.frames.as_deref().unwrap_or_default();
                let ends = (frames.first().copied(), frames.last().copied());
                let (first, last) = (ends.0.unwrap_or(0), ends.1.unwrap_or(0));
                if summary.frames > 0 {
                    let place = place(&job.target, first, last);
                    console.say(&progress::summary(&summary, &place));
                }
                if job.resume == Resume::Keep {
                    console.say(&kept(summary.kept, &teller.missing));
                } else if summary.remade > 0 && meant.times == Times::Once {
                    console.say(&would_have_kept(summary.remade));
                }
                Ok(())
            }
        },
        Err(RenderError::Cancelled) => Err(teller.stopped(how)),
        Err(error) => Err(error.into()),
    }
}

/// The job that is meant; `None` if there is nothing in it to do.
///
/// # Errors
/// What the script does not take.
pub fn planned(meant: &Render, stage: &Stage) -> Result<Option<Job>, Failure> {
    let count = stage.with_scene(|scene| scene.animation().frames);
    let frames = match &meant.frames {
        Some(ranges) => ranges.within(count).map_err(Failure::usage)?,
        None => (0..count).collect(),
    };
    if let (Some(tile), true) = (meant.tile, frames.len() > 1) {
        return Err(Failure::usage(format!(
            "--tile {tile} is a part of one picture, and there are {} frames: pick one, as in \
             --frames 0",
            frames.len()
        )));
    }
    let frames = meant.shard.map_or_else(|| frames.clone(), |shard| shard.of(&frames));
    // A tile is a part of one picture, so its name takes no number by itself.
    let numbered = if meant.tile.is_some() { 1 } else { count };
    let target = Target::parse(&meant.output, meant.format.as_deref(), numbered)
        .map_err(|e| Failure::usage(e.to_string()))?;
    if frames.is_empty() {
        return Ok(None);
    }
    Ok(Some(Job {
        frames: Some(frames),
        size: meant.size,
        draft: meant.draft,
        threads: meant.threads,
        isa: meant.isa,
        reuse: meant.reuse,
        cache_bytes: meant.cache_bytes,
        resume: meant.resume,
        tile: meant.tile,
        compression: meant.compression,
        dither: meant.dither,
        quality: meant.quality,
        target,
    }))
}

/// What to tell whoever stops the job.
fn how_to_resume(job: &Job) -> &'static str {
    match job.target.is_stdout() || job.target.format().is_film() {
        true => "",
        false => "; the same command with --resume goes on from here",
    }
}

/// What `--resume` kept and made.
fn kept(kept: u64, missing: &[u32]) -> String {
    let missing = match missing {
        [] => String::new(),
        frames => format!("; missing before: {}", resume::ranges(frames)),
    };
    match kept {
        1 => format!("1 frame was up to date and was kept{missing}"),
        n => format!("{n} frames were up to date and were kept{missing}"),
    }
}

fn would_have_kept(frames: u64) -> String {
    match frames {
        1 => "1 frame was made anew that was up to date; --resume would have kept it".into(),
        n => {
            format!("{n} frames were made anew that were up to date; --resume would have kept them")
        }
    }
}

/// Where the frames went, for the summary.
fn place(target: &Target, first: u32, last: u32) -> String {
    let path = |frame| target.path_for(frame).display().to_string();
    match target.is_stdout() {
        true => "stdout".into(),
        false if target.is_numbered() && first < last => {
            format!("{} ... {}", path(first), path(last))
        }
        false => path(first),
    }
}

/// Tells a scheduler something in the protocol of Open Job Description.
fn openjd(key: &str, value: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "openjd_{key}: {value}")?;
    out.flush()
}

/// An event or the closing line could not be printed.
fn unread(error: &io::Error) -> Failure {
    match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::quiet(Exit::Output),
        _ => Failure::new(Exit::Output, format!("cannot write to stdout: {error}")),
    }
}

/// Tells people or programs what happens.
struct Teller<'a> {
    meant: &'a Render,
    console: &'a Console,
    signals: &'a Signals,
    progress: Option<Progress>,
    frames: usize,
    done: usize,
    /// Frames that `--resume` did not find.
    missing: Vec<u32>,
    /// Why the events cannot be told.
    unread: Option<Failure>,
}

impl Teller<'_> {
    fn event(&mut self, event: &Event<'_>) {
        match event {
            Event::Started { frames, .. } => self.frames = *frames,
            Event::Frame(_) | Event::Kept { .. } => self.done += 1,
            Event::FilmKept { frames, .. } => self.done += frames,
            Event::Warning(_) | Event::Swept(_) | Event::Again { .. } | Event::FilmAgain { .. } => {
            }
        }
        if self.meant.tell == Tell::Programs {
            if self.unread.is_none()
                && let Err(error) = Line::event(event).print()
            {
                // Whoever asked for the render does not listen any more.
                self.unread = Some(unread(&error));
                self.signals.cancel();
            }
            return;
        }
        if let (Tell::Scheduler, Event::Frame(_) | Event::Kept { .. }) = (self.meant.tell, event) {
            let (done, frames) = (self.done, self.frames.max(1));
            let percent = format!("{:.1}", 100.0 * done as f64 / frames as f64);
            let told = openjd("progress", &percent)
                .and_then(|()| openjd("status", &format!("{done} of {frames} frames are done")));
            if let (Err(error), None) = (told, &self.unread) {
                self.unread = Some(unread(&error));
                self.signals.cancel();
            }
        }
        match event {
            Event::Started { frames, .. } => {
                self.progress = Some(Progress::begin(self.console, *frames));
            }
            Event::Warning(text) => self.console.warn(text),
            Event::Swept(path) => {
                let path = path.display();
                self.console.say(&format!("{path} was left by a killed process and is removed"));
            }
            Event::Again { frame, standing: Standing::Missing, .. } => self.missing.push(*frame),
            Event::Again { frame, path, standing } => {
                let path = path.display();
                self.console.say(&format!("frame {frame}: {path}: {standing}; made again"));
            }
            Event::FilmKept { .. } | Event::FilmAgain { standing: Standing::Missing, .. } => {}
            Event::FilmAgain { path, standing } => {
                self.console.say(&format!("{}: {standing}; made again", path.display()));
            }
            Event::Frame(_) | Event::Kept { .. } => {
                if let (Event::Frame(report), Detail::Frames) = (event, self.meant.detail) {
                    self.console.say(&told::frame(report));
                }
                if let Some(progress) = &mut self.progress {
                    progress.frame(self.done);
                }
            }
        }
    }

    /// What ended the render.
    fn stopped(self, how: &str) -> Failure {
        if let Some(failure) = self.unread {
            return failure;
        }
        let mut failure = self.signals.failure().unwrap_or_else(|| RenderError::Cancelled.into());
        failure.message = match (self.done, self.frames) {
            (0, _) => format!("stopped before the first frame was done{how}"),
            (done, frames) => format!("stopped; {done} of {frames} frames are done{how}"),
        };
        failure
    }
}
