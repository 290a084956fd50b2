//! Whole frames into one picture, as `render` makes them, but without a file.

use crate::exit::{Exit, Failure};
use reflet_accel::Isa;
use reflet_film::{Layout, Picture, SampleKind, Transfer, TransferTable};
use reflet_frame::engine::Work;
use reflet_frame::{Batch, Engine, EngineOptions};
use reflet_pack::{Changes, Columns};
use reflet_trace::BatchColours;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// An engine and its 8-bit picture.
pub struct Renderer {
    /// The engine.
    pub engine: Engine,
    pictures: [Picture; 1],
    table: TransferTable,
}

impl Renderer {
    /// For pictures of `columns`' size.
    ///
    /// # Errors
    /// The threads or the memory cannot be had, or the machine lacks the instructions.
    pub fn new(columns: &Columns, isa: Isa, threads: usize) -> Result<Renderer, Failure> {
        let failed = |what: String| Failure::new(Exit::Failed, what);
        let threads = NonZeroUsize::new(threads);
        let options = EngineOptions { isa, threads, ..EngineOptions::default() };
        let engine = Engine::new(options).map_err(failed)?;
        let [width, height] = columns.view.size;
        let layout = Layout::try_new(width, height, engine.grid(columns).edge);
        let layout = layout.map_err(|e| failed(e.to_string()))?;
        let picture =
            Picture::try_new(layout, SampleKind::U8).map_err(|e| failed(e.to_string()))?;
        let table = TransferTable::new(Transfer::Srgb, SampleKind::U8);
        Ok(Renderer { engine, pictures: [picture], table })
    }

    /// Renders a frame, from nothing or with what the last one left; its time on the wall.
    pub fn render(&mut self, columns: &Columns, changes: Option<&Changes>) -> (Duration, Work) {
        let Renderer { engine, pictures, table } = self;
        let colours = BatchColours::of(columns);
        let batch = Batch { columns, changes, colours: &colours, table, last: None };
        let start = Instant::now();
        // Nothing cancels it.
        let work = engine.render(batch, pictures, &AtomicBool::new(false)).unwrap_or_default();
        (start.elapsed(), work)
    }

    /// The picture of the last frame.
    pub fn picture(&self) -> &Picture {
        &self.pictures[0]
    }
}
