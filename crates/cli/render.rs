//! `reflet render`: from a script to files.

use crate::console::Console;
use crate::exit::{Exit, Failure};
use crate::json::Line;
use crate::meant::{Detail, Render, Tell};
use crate::progress::{self, Progress};
use crate::signals::Signals;
use crate::told;
use reflet_film::Target;
use reflet_frame::{Event, Job, RenderError};
use std::io;
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
    let count = stage.with_scene(|scene| scene.animation().frames);
    let frames = meant.frames.as_ref().map(|ranges| ranges.within(count)).transpose();
    let frames = frames.map_err(Failure::usage)?;
    let target = Target::parse(&meant.output, meant.format.as_deref(), count)
        .map_err(|e| Failure::usage(e.to_string()))?;
    let job = Job {
        frames,
        size: meant.size,
        draft: meant.draft,
        threads: meant.threads,
        isa: meant.isa,
        reuse: meant.reuse,
        cache_bytes: meant.cache_bytes,
        compression: meant.compression,
        target,
    };

    let mut teller =
        Teller { meant, console, signals, progress: None, frames: 0, done: 0, unread: None };
    let result = signals.rendering(&job.target.path_for(0), |cancel| {
        reflet_frame::render(&mut stage, &job, cancel, &mut |event| teller.event(&event))
    });
    read(&stage.inputs());
    if let Some(progress) = &teller.progress {
        progress.end();
    }
    match result {
        Ok(summary) => match meant.tell {
            Tell::Programs => Line::done(&summary).print().map_err(|e| unread(&e)),
            Tell::People => {
                let ends = job.frames.as_ref().and_then(|f| Some((*f.first()?, *f.last()?)));
                let (first, last) = ends.unwrap_or((0, count.saturating_sub(1)));
                console.say(&progress::summary(&summary, &place(&job.target, first, last)));
                Ok(())
            }
        },
        Err(RenderError::Cancelled) => Err(teller.stopped()),
        Err(error) => Err(error.into()),
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
    /// Why the events cannot be told.
    unread: Option<Failure>,
}

impl Teller<'_> {
    fn event(&mut self, event: &Event<'_>) {
        match event {
            Event::Started { frames, .. } => self.frames = *frames,
            Event::Frame(_) => self.done += 1,
            Event::Warning(_) => {}
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
        match event {
            Event::Started { frames, .. } => {
                self.progress = Some(Progress::begin(self.console, *frames));
            }
            Event::Warning(text) => self.console.warn(text),
            Event::Frame(report) => {
                if self.meant.detail == Detail::Frames {
                    self.console.say(&told::frame(report));
                }
                if let Some(progress) = &mut self.progress {
                    progress.frame(self.done);
                }
            }
        }
    }

    /// What ended the render.
    fn stopped(self) -> Failure {
        if let Some(failure) = self.unread {
            return failure;
        }
        let mut failure = self.signals.failure().unwrap_or_else(|| RenderError::Cancelled.into());
        failure.message = match (self.done, self.frames) {
            (0, _) => "stopped before the first frame was done".into(),
            (done, frames) => format!("stopped; {done} of {frames} frames are done"),
        };
        failure
    }
}
