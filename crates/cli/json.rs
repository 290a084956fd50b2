//! `--json`: one event a line on stdout.
//!
//! | event | when | fields |
//! | --- | --- | --- |
//! | `start` | the script has run | `frames`, `width`, `height`, `isa`, `threads` |
//! | `warning` | at any time | `message` |
//! | `swept` | a killed process's file was removed | `path` |
//! | `kept` | a frame's file stands | `frame`, `path` |
//! | `again` | a frame's file does not stand | `frame`, `path`, `why` |
//! | `film_kept` | the film stands | `path`, `frames` |
//! | `film_again` | the film does not stand | `path`, `why` |
//! | `frame` | a frame is on disk | `frame`, `path`, `ms`, `rays`, `changed`, ... |
//! | `error` | the render failed; the last line then | `exit`, `message` |
//! | `done` | all frames are on disk; the last line | `frames`, `ms`, `rays`, ... |
//!
//! Times are milliseconds, `rays` counts by kind, sizes are bytes. What was done once for several
//! frames, shaded together as a `batch`, counts as the first one's.

use crate::exit::Failure;
use reflet_frame::{Event, FrameReport, Summary, Thing};
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// A line.
#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Line<'a> {
    /// The script has run and the first frame begins.
    Start { frames: usize, width: u32, height: u32, isa: &'a str, threads: usize },
    /// Something that the user may want to mend.
    Warning { message: &'a str },
    /// A killed process's file was removed.
    Swept { path: String },
    /// A frame's file stands and was kept.
    Kept { frame: u32, path: String },
    /// A frame's file does not stand, and is made again.
    Again { frame: u32, path: String, why: String },
    /// The film stands and was kept.
    FilmKept { path: String, frames: usize },
    /// The film does not stand, and is made again.
    FilmAgain { path: String, why: String },
    /// A frame is on disk.
    Frame {
        frame: u32,
        path: Option<String>,
        ms: f64,
        script_ms: f64,
        pack_ms: f64,
        build_ms: f64,
        trace_ms: f64,
        encode_ms: f64,
        /// What differs from the frame before, by name: the first few.
        changed: Vec<Change<'a>>,
        /// How many things differ.
        changes: usize,
        /// Why all trees were made from scratch, if they were.
        fresh: Option<&'a str>,
        rays: Rays,
        accel_rays: u64,
        retraced_pixels: u64,
        tested_segments: u64,
        replayed_nodes: u64,
        deepened_nodes: u64,
        shaded_tiles: u64,
        tiles: u64,
        batch: u32,
        kept_bytes: u64,
        bands_encoded: u64,
        bands_kept: u64,
        bytes: u64,
    },
    /// The render failed.
    Error { exit: u8, message: &'a str },
    /// The render is done.
    Done {
        frames: u64,
        kept: u64,
        remade: u64,
        ms: f64,
        trace_ms: f64,
        rays: Rays,
        mrays_per_s: f64,
        bytes: u64,
        frames_without_retrace: u64,
        rays_saved: u64,
        tiles_copied: u64,
        bands_kept: u64,
        isa: &'a str,
        threads: usize,
    },
}

/// One thing that differs.
#[derive(Serialize)]
pub struct Change<'a> {
    name: &'a str,
    how: &'a str,
}

/// Rays by kind.
#[derive(Serialize)]
pub struct Rays {
    camera: u64,
    mirror: u64,
    shadow: u64,
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

fn ms(ns: u64) -> f64 {
    ns as f64 / 1e6
}

impl<'a> Line<'a> {
    /// The line of an event of the frame loop.
    pub fn event(event: &Event<'a>) -> Self {
        match event {
            &Event::Started { frames, size: [width, height], isa, threads } => {
                Line::Start { frames, width, height, isa, threads }
            }
            Event::Warning(message) => Line::Warning { message },
            Event::Swept(path) => Line::Swept { path: text(path) },
            Event::Kept { frame, path } => Line::Kept { frame: *frame, path: text(path) },
            Event::Again { frame, path, standing } => {
                Line::Again { frame: *frame, path: text(path), why: standing.to_string() }
            }
            Event::FilmKept { path, frames } => {
                Line::FilmKept { path: text(path), frames: *frames }
            }
            Event::FilmAgain { path, standing } => {
                Line::FilmAgain { path: text(path), why: standing.to_string() }
            }
            Event::Frame(report) => Line::frame(report),
        }
    }

    fn frame(r: &'a FrameReport) -> Self {
        let change = |thing: &'a Thing| Change { name: &thing.name, how: thing.how };
        Line::Frame {
            frame: r.frame,
            path: r.path.as_deref().map(text),
            ms: ms(r.elapsed_ns()),
            script_ms: ms(r.script_ns),
            pack_ms: ms(r.pack_ns),
            build_ms: ms(r.build_ns),
            trace_ms: ms(r.trace_ns),
            encode_ms: ms(r.encode_ns),
            changed: r.changed.things.iter().map(change).collect(),
            changes: r.changed.count,
            fresh: r.fresh,
            rays: Rays { camera: r.rays.camera, mirror: r.rays.mirror, shadow: r.rays.shadow },
            accel_rays: r.accel_rays,
            retraced_pixels: r.retraced_pixels,
            tested_segments: r.tested_segments,
            replayed_nodes: r.replayed_nodes,
            deepened_nodes: r.deepened_nodes,
            shaded_tiles: r.shaded_tiles,
            tiles: r.tiles,
            batch: r.batch,
            kept_bytes: r.kept_bytes,
            bands_encoded: r.bands_encoded,
            bands_kept: r.bands_kept,
            bytes: r.bytes,
        }
    }

    /// The closing line.
    pub fn done(summary: &'a Summary) -> Self {
        let rays = summary.rays;
        Line::Done {
            frames: summary.frames,
            kept: summary.kept,
            remade: summary.remade,
            ms: ms(summary.elapsed_ns),
            trace_ms: ms(summary.trace_ns),
            rays: Rays { camera: rays.camera, mirror: rays.mirror, shadow: rays.shadow },
            mrays_per_s: crate::progress::mrays_per_second(summary),
            bytes: summary.bytes,
            frames_without_retrace: summary.frames_without_retrace,
            rays_saved: summary.rays_saved,
            tiles_copied: summary.tiles_copied[0],
            bands_kept: summary.bands_kept[0],
            isa: summary.isa,
            threads: summary.threads,
        }
    }

    /// The closing line of a render that failed.
    pub fn error(failure: &'a Failure) -> Self {
        Line::Error { exit: failure.exit as u8, message: &failure.message }
    }

    /// Prints the line, whole, on stdout.
    ///
    /// # Errors
    /// Stdout cannot be written, perhaps because its reader has left.
    pub fn print(&self) -> io::Result<()> {
        let mut line = serde_json::to_vec(self)?;
        line.push(b'\n');
        let mut out = io::stdout().lock();
        out.write_all(&line)?;
        out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exit::Exit;

    fn told(line: &Line<'_>) -> String {
        serde_json::to_string(line).unwrap()
    }

    #[test]
    fn lines_read_as_documented() {
        let report = FrameReport {
            frame: 3,
            path: Some("out/frame-0003.png".into()),
            script_ns: 1_000_000,
            encode_ns: 900_000,
            retraced_pixels: 7,
            ..FrameReport::default()
        };
        let line = told(&Line::event(&Event::Frame(&report)));
        let start = r#"{"event":"frame","frame":3,"path":"out/frame-0003.png","ms":1.9,"#;
        assert!(line.starts_with(start), "{line}");
        assert!(line.contains(r#""rays":{"camera":0,"mirror":0,"shadow":0}"#), "{line}");
        assert!(line.contains(r#""retraced_pixels":7"#), "{line}");
        let done = told(&Line::done(&Summary::default()));
        assert!(
            done.starts_with(r#"{"event":"done","frames":0,"kept":0,"remade":0,"ms":0.0,"#),
            "{done}"
        );
        let failure = Failure::new(Exit::Script, "a \"word\"\nand a line");
        assert_eq!(
            told(&Line::error(&failure)),
            r#"{"event":"error","exit":65,"message":"a \"word\"\nand a line"}"#
        );
    }
}
