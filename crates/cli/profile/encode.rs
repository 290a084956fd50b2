//! What a frame's picture takes on its way to a file in memory.

use crate::exit::{Exit, Failure};
use crate::profile::cast;
use crate::profile::scene::Frame;
use reflet_accel::Isa;
use reflet_film::{
    Format, Layout, Picture, SampleKind, StillOptions, Transfer, TransferTable, encode_still,
};
use reflet_frame::{Batch, Engine, EngineOptions};
use reflet_trace::BatchColours;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// A PNG as `render` writes it unless told otherwise.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encoded {
    /// The median time on the wall.
    pub wall: Duration,
    /// The size of the file.
    pub bytes: usize,
}

/// Renders the frame once and encodes its picture `repeat` times.
///
/// # Errors
/// The threads or the memory cannot be had, or the machine lacks the instructions.
pub fn measure(frame: &Frame, isa: Isa, threads: usize, repeat: usize) -> Result<Encoded, Failure> {
    let failed = |what: String| Failure::new(Exit::Failed, what);
    let threads = NonZeroUsize::new(threads);
    let options = EngineOptions { isa, threads, ..EngineOptions::default() };
    let mut engine = Engine::new(options).map_err(failed)?;
    let columns = &frame.columns;
    let [width, height] = columns.view.size;
    let layout = Layout::try_new(width, height, engine.grid(columns).edge);
    let layout = layout.map_err(|e| failed(e.to_string()))?;
    let picture = Picture::try_new(layout, SampleKind::U8).map_err(|e| failed(e.to_string()))?;
    let mut pictures = [picture];
    let table = TransferTable::new(Transfer::Srgb, SampleKind::U8);
    let (never, colours) = (AtomicBool::new(false), BatchColours::of(columns));
    let batch = Batch { columns, changes: None, colours: &colours, table: &table, last: None };
    // Nothing cancels it.
    let _ = engine.render(batch, &mut pictures, &never);
    let (mut times, mut bytes) = (Vec::new(), 0);
    for round in 0..=repeat {
        let start = Instant::now();
        let options = StillOptions::default();
        let encode = || encode_still(&pictures[0], Format::Png, &options, None);
        bytes = engine.pool().install(encode).map_err(|e| failed(e.to_string()))?.len();
        // The first round finds its memory.
        if round > 0 {
            times.push(start.elapsed());
        }
    }
    Ok(Encoded { wall: cast::median(&times), bytes })
}
