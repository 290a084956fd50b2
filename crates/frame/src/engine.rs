//! Columns to pictures, tile by tile on all threads.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use reflet_accel::isa::Level;
use reflet_accel::{Accel, Isa, RayCounts, Structure};
use reflet_film::{Layout, Picture, TransferTable};
use reflet_pack::{Changes, Columns};
use reflet_trace::{
    Grid, RayTally, ShadeScratch, Shader, TileColours, TraceScratch, Tracer, Trees,
};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// How an engine works. None of it shows in a picture.
#[derive(Clone, Copy, Debug)]
pub struct EngineOptions {
    /// Threads; as many as the machine has if `None`.
    pub threads: Option<NonZeroUsize>,
    /// Which instructions the kernels use.
    pub isa: Isa,
    /// The tiles' edge in pixels.
    pub tile: u32,
    /// How primitives are kept.
    pub structure: Structure,
}

impl Default for EngineOptions {
    fn default() -> Self {
        Self { threads: None, isa: Isa::Auto, tile: 16, structure: Structure::Auto }
    }
}

/// What a frame took in the engine.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Rays by kind.
    pub rays: RayTally,
    /// Rays as `accel` counted them.
    pub counts: RayCounts,
    /// Pixels of which at least one tree was traced.
    pub retraced_pixels: u64,
    /// Nanoseconds of building what rays are intersected with.
    pub build_ns: u64,
    /// Nanoseconds of tracing and shading.
    pub trace_ns: u64,
}

/// Threads and what they keep from frame to frame.
pub struct Engine {
    options: EngineOptions,
    level: Level,
    pool: Arc<ThreadPool>,
    workers: Vec<Mutex<Worker>>,
    accel: Option<Accel>,
}


#[derive(Default)]
struct Worker {
    trace: TraceScratch,
    shade: ShadeScratch,
    trees: Trees,
    colours: TileColours,
}

/// The frame was told to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

impl Engine {
    /// Starts the threads.
    ///
    /// # Errors
    /// If this machine lacks the instructions, or the threads cannot be had.
    pub fn new(options: EngineOptions) -> Result<Engine, String> {
        let level = options.isa.level().map_err(|e| e.to_string())?;
        let threads = options.threads.map_or(0, NonZeroUsize::get);
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("trace-{i}"))
            .build()
            .map_err(|e| format!("cannot start threads: {e}; ask for fewer with --threads"))?;
        let workers = (0..pool.current_num_threads()).map(|_| Mutex::default()).collect();
        Ok(Engine { options, level, pool: Arc::new(pool), workers, accel: None })
    }

    /// How many threads there are.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// The instructions in use.
    pub fn isa(&self) -> &'static str {
        self.options.isa.resolved().name()
    }

    /// The tiles of a scene's picture.
    pub fn grid(&self, columns: &Columns) -> Grid {
        Grid::new(columns.view.size, self.options.tile, columns.model.max_bounces)
    }

    /// The threads, for work beside tracing.
    pub fn pool(&self) -> Arc<ThreadPool> {
        self.pool.clone()
    }

    /// Renders a frame into `picture`. `changes` is what differs from the frame rendered before;
    /// `None` if that is not known.
    pub fn render(
        &mut self,
        columns: &Columns,
        changes: Option<&Changes>,
        table: &TransferTable,
        picture: &mut Picture,
        cancel: &AtomicBool,
    ) -> Result<Work, Cancelled> {
        let start = Instant::now();
        if self.accel.is_none() || changes.is_none_or(|c| !c.surfaces.is_empty()) {
            let structure = self.options.structure;
            let build = || Accel::build(&columns.geometry, self.level, structure);
            self.accel = Some(self.pool.install(build));
        }
        let build_ns = nanoseconds(start);
        let start = Instant::now();
        let grid = grid_of(picture.layout());
        self.trace_and_shade(columns, grid, table, picture, cancel);
        if cancel.load(Ordering::Relaxed) {
            return Err(Cancelled);
        }
        let mut work = Work { build_ns, trace_ns: nanoseconds(start), ..Work::default() };
        work.retraced_pixels = u64::from(grid.size[0]) * u64::from(grid.size[1]);
        for worker in &self.workers {
            let mut worker = worker.lock().unwrap_or_else(PoisonError::into_inner);
            work.rays += std::mem::take(&mut worker.trace.rays);
            let counts = std::mem::take(&mut worker.trace.counts);
            work.counts.closest += counts.closest;
            work.counts.any += counts.any;
        }
        Ok(work)
    }

    fn trace_and_shade(
        &self,
        columns: &Columns,
        grid: Grid,
        table: &TransferTable,
        picture: &mut Picture,
        cancel: &AtomicBool,
    ) {
        let Some(accel) = &self.accel else { return };
        let tracer = Tracer { columns, accel };
        let shader = Shader::new(columns, self.level);
        self.pool.install(|| {
            picture.par_tiles_mut().for_each(|mut tile| {
                if cancel.load(Ordering::Relaxed) {
                    return;
                }
                let index = rayon::current_thread_index().unwrap_or(0);
                let mut worker = self.workers[index].lock().unwrap_or_else(PoisonError::into_inner);
                let w = &mut *worker;
                let rect = grid.rect(tile.index);
                shader.begin(&mut w.shade);
                for sample in 0..columns.samples {
                    tracer.grow(rect, sample, &mut w.trees, &mut w.trace);
                    shader.add(&w.trees, &mut w.shade);
                }
                shader.finish(rect, grid.edge, &w.shade, &mut w.colours);
                let [r, g, b] = &w.colours.rgb;
                table.encode_tile([r, g, b], &mut tile.samples);
            });
        });
    }
}

/// The tiles of a picture as the first pass sees them.
fn grid_of(layout: Layout) -> Grid {
    Grid { size: [layout.width(), layout.height()], edge: layout.tile() }
}

/// Nanoseconds since `start`.
pub(crate) fn nanoseconds(start: Instant) -> u64 {
    start.elapsed().as_nanos() as u64
}
