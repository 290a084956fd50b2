//! A frame's stages and tiles on their threads, as a timeline that opens in Perfetto.
//!
//! Source: "Trace Event Format", the JSON array of complete events; times are microseconds.

use crate::exit::Failure;
use crate::profile::passes::{Pass, Passes, Worker};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

/// What took some time on some thread.
struct Span {
    name: String,
    thread: usize,
    start: Duration,
    length: Duration,
}

/// Events, in the order in which they are written.
#[derive(Default)]
pub struct Timeline {
    spans: Vec<Span>,
    end: Duration,
}

/// The row of all that is not a tile.
const MAIN: usize = 0;

impl Timeline {
    /// Appends a stage of the main thread, right after the last.
    pub fn stage(&mut self, name: &str, length: Duration) {
        self.spans.push(Span { name: name.into(), thread: MAIN, start: self.end, length });
        self.end += length;
    }

    /// Makes all tiles on the threads of a pool, and appends when each was made.
    pub fn tiles(&mut self, passes: &Passes<'_>, pool: &ThreadPool) {
        let origin = Instant::now();
        let tile = |worker: &mut Worker, tile: usize| {
            let thread = rayon::current_thread_index().unwrap_or_default() + 1;
            let begin = origin.elapsed();
            let (mut start, mut parts) = (begin, Vec::new());
            passes.make(worker, tile, |pass| {
                let now = origin.elapsed();
                let name = match pass {
                    Pass::Trace => "trace",
                    Pass::Shade => "shade",
                };
                parts.push(Span { name: name.into(), thread, start, length: now - start });
                start = now;
            });
            // What encloses others comes first.
            let whole =
                Span { name: format!("tile {tile}"), thread, start: begin, length: start - begin };
            parts.insert(0, whole);
            parts
        };
        let tiles = (0..passes.grid.len()).into_par_iter();
        let spans: Vec<Vec<Span>> =
            pool.install(|| tiles.map_init(Worker::default, tile).collect());
        let (before, length) = (self.end, origin.elapsed());
        self.stage("trace and shade", length);
        for mut span in spans.into_iter().flatten() {
            span.start += before;
            self.spans.push(span);
        }
    }

    fn json(&self) -> Value {
        let us = |time: Duration| time.as_nanos() as f64 * 1e-3;
        let threads = self.spans.iter().map(|s| s.thread + 1).max().unwrap_or_default();
        let names = (0..threads).map(|thread| {
            let name = match thread {
                MAIN => "stages".to_owned(),
                thread => format!("thread {}", thread - 1),
            };
            json!({ "ph": "M", "name": "thread_name", "pid": 1, "tid": thread, "args": { "name": name } })
        });
        let spans = self.spans.iter().map(|s| {
            json!({ "ph": "X", "name": s.name, "pid": 1, "tid": s.thread,
                "ts": us(s.start), "dur": us(s.length) })
        });
        json!({ "displayTimeUnit": "ns", "traceEvents": names.chain(spans).collect::<Vec<_>>() })
    }

    /// Writes it.
    ///
    /// # Errors
    /// An output's.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        super::put(path, self.json().to_string().as_bytes())
    }
}
