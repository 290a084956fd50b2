//! What re-use saves: a frame after the frame before it, and the same frame from nothing.

use crate::exit::{Exit, Failure};
use crate::profile::cast;
use crate::profile::scene::Frame;
use reflet_accel::Isa;
use reflet_film::{Layout, Picture, SampleKind, Transfer, TransferTable};
use reflet_frame::engine::Work;
use reflet_frame::{Batch, Engine, EngineOptions};
use reflet_pack::{Changes, Columns};
use reflet_trace::BatchColours;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// One way to a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Way {
    /// Tree, rays and colours on the wall, the median.
    pub wall: Duration,
    /// Rays cast.
    pub rays: u64,
}

/// Both ways to one frame.
#[derive(Clone, Copy, Debug)]
pub struct Saved {
    /// From nothing.
    pub fresh: Way,
    /// With what the frame before left.
    pub kept: Way,
    /// Why nothing was kept, if so.
    pub why: Option<&'static str>,
}

/// Renders the frame `repeat` times both ways; `None` if no frame is before it.
///
/// # Errors
/// The threads cannot be had, or the machine lacks the instructions.
pub fn measure(
    frame: &Frame,
    isa: Isa,
    threads: usize,
    repeat: usize,
) -> Result<Option<Saved>, Failure> {
    let Some((before, changes)) = &frame.before else { return Ok(None) };
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
    let never = AtomicBool::new(false);
    let mut render = |columns: &Columns, changes: Option<&Changes>| {
        let colours = BatchColours::of(columns);
        let batch = Batch { columns, changes, colours: &colours, table: &table, last: None };
        let start = Instant::now();
        let work = engine.render(batch, &mut pictures, &never).unwrap_or_default();
        (start.elapsed(), work)
    };
    let (mut times, mut works) = ([Vec::new(), Vec::new()], [Work::default(), Work::default()]);
    for round in 0..=repeat {
        let fresh = render(columns, None);
        render(before, None);
        let kept = render(columns, Some(changes));
        for (k, (time, work)) in [fresh, kept].into_iter().enumerate() {
            // The first round finds its memory, and learns what is worth keeping.
            if round > 0 {
                times[k].push(time);
                works[k] = work;
            }
        }
    }
    let way = |k: usize| Way { wall: cast::median(&times[k]), rays: works[k].rays.total() };
    Ok(Some(Saved { fresh: way(0), kept: way(1), why: works[1].fresh }))
}
