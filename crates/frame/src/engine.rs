//! Columns to pictures, tile by tile on all threads.

use crate::job::Reuse;
use crate::reuse::{Keep, MadeFor, Plan};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use reflet_accel::isa::Level;
use reflet_accel::{Accel, Isa, RayCounts, Structure};
use reflet_film::{Layout, Picture, TileMut, TransferTable};
use reflet_pack::{Changes, Columns};
use reflet_trace::touch::TouchScratch;
use reflet_trace::{
    Grid, RayTally, ShadeScratch, Shader, TileColours, TileRect, TraceScratch, Tracer, Trees,
};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
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
    /// Whether trees are kept from frame to frame.
    pub reuse: Reuse,
    /// Bytes that kept trees may take; trees beyond are made anew each frame.
    pub cache_bytes: u64,
}

impl Default for EngineOptions {
    fn default() -> Self {
        Self {
            threads: None,
            isa: Isa::Auto,
            tile: 16,
            structure: Structure::Auto,
            reuse: Reuse::Keep,
            cache_bytes: u64::MAX,
        }
    }
}

/// What a frame took in the engine.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Rays by kind.
    pub rays: RayTally,
    /// Rays as `accel` counted them.
    pub counts: RayCounts,
    /// Pixels of which at least one tree was made from its root.
    pub retraced_pixels: u64,
    /// Nodes whose point was found again without a ray.
    pub replayed_nodes: u64,
    /// Bytes of trees kept for the next frame.
    pub kept_bytes: u64,
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
    store: Option<Store>,
}

/// The trees of the last frame.
struct Store {
    made_for: MadeFor,
    tiles: Vec<KeptTile>,
    bytes: AtomicU64,
}

/// The trees of one tile, a sample each; none if there was no room.
#[derive(Default)]
struct KeptTile {
    samples: Vec<Trees>,
}

impl KeptTile {
    fn bytes(&self) -> u64 {
        self.samples.iter().map(|t| t.bytes() as u64).sum()
    }
}

#[derive(Default)]
struct Worker {
    retraced_pixels: u64,
    touch: TouchScratch,
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
        Ok(Engine { options, level, pool: Arc::new(pool), workers, accel: None, store: None })
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
        let plan = self.plan(columns, changes, grid);
        self.trace_and_shade(&plan, columns, grid, table, picture, cancel);
        if cancel.load(Ordering::Relaxed) {
            self.store = None; // some tiles are of this frame and some of the last
            return Err(Cancelled);
        }
        let mut work = Work { build_ns, trace_ns: nanoseconds(start), ..Work::default() };
        work.kept_bytes = self.store.as_ref().map_or(0, |s| s.bytes.load(Ordering::Relaxed));
        for worker in &self.workers {
            let mut worker = worker.lock().unwrap_or_else(PoisonError::into_inner);
            work.rays += std::mem::take(&mut worker.trace.rays);
            work.replayed_nodes += std::mem::take(&mut worker.trace.replayed);
            work.retraced_pixels += std::mem::take(&mut worker.retraced_pixels);
            let counts = std::mem::take(&mut worker.trace.counts);
            work.counts.closest += counts.closest;
            work.counts.any += counts.any;
        }
        Ok(work)
    }

    /// Compares with what the kept trees were made for, and makes room for new ones.
    fn plan(&mut self, columns: &Columns, changes: Option<&Changes>, grid: Grid) -> Plan {
        if self.options.reuse == Reuse::Never {
            return Plan::Fresh;
        }
        let made_for = MadeFor::of(columns, grid);
        let plan = match (&self.store, changes) {
            (Some(store), Some(changes)) => Plan::of(changes, &store.made_for, &made_for),
            _ => Plan::Fresh,
        };
        match (&plan, &mut self.store) {
            (Plan::Keep(_), Some(store)) => store.made_for = made_for,
            _ => {
                let mut tiles = Vec::new();
                tiles.resize_with(grid.len(), KeptTile::default);
                self.store = Some(Store { made_for, tiles, bytes: AtomicU64::new(0) });
            }
        }
        plan
    }

    fn trace_and_shade(
        &mut self,
        plan: &Plan,
        columns: &Columns,
        grid: Grid,
        table: &TransferTable,
        picture: &mut Picture,
        cancel: &AtomicBool,
    ) {
        let Some(accel) = &self.accel else { return };
        let tracer = Tracer { columns, accel };
        let shader = Shader::new(columns, self.level);
        let (workers, budget) = (&self.workers, self.options.cache_bytes);
        let mut none = Vec::new();
        let (kept, bytes) = match &mut self.store {
            Some(store) => (&mut store.tiles, Some(&store.bytes)),
            None => {
                none.resize_with(grid.len(), KeptTile::default);
                (&mut none, None)
            }
        };
        let tile_of = |(mut tile, kept): (TileMut<'_>, &mut KeptTile)| {
            if cancel.load(Ordering::Relaxed) {
                return;
            }
            let index = rayon::current_thread_index().unwrap_or(0);
            let mut worker = workers[index].lock().unwrap_or_else(PoisonError::into_inner);
            let w = &mut *worker;
            let rect = grid.rect(tile.index);
            let room = Room { bytes, budget };
            w.trees_of(plan, &tracer, rect, kept, &shader, &room);
            shader.finish(rect, grid.edge, &w.shade, &mut w.colours);
            let [r, g, b] = &w.colours.rgb;
            table.encode_tile([r, g, b], &mut tile.samples);
        };
        self.pool.install(|| {
            picture.par_tiles_mut().zip(kept.par_iter_mut()).for_each(tile_of);
        });
    }
}

/// The room for kept trees: bytes in use, if trees are kept at all, and how many there may be.
struct Room<'a> {
    bytes: Option<&'a AtomicU64>,
    budget: u64,
}

impl Worker {
    /// Brings the trees of a tile up to date, sample by sample, and adds their colours.
    fn trees_of(
        &mut self,
        plan: &Plan,
        tracer: &Tracer<'_>,
        rect: TileRect,
        kept: &mut KeptTile,
        shader: &Shader<'_>,
        room: &Room<'_>,
    ) {
        let samples = tracer.columns.samples as usize;
        let before = kept.bytes();
        kept.samples.truncate(samples);
        shader.begin(&mut self.shade);
        if let Plan::Keep(keep) = plan {
            for (sample, trees) in kept.samples.iter_mut().enumerate() {
                self.update(keep, tracer, (rect, sample as u32), trees);
                shader.add(trees, &mut self.shade);
            }
        } else {
            kept.samples.clear();
        }
        // Only a whole tile is kept; all of its samples or none.
        let mut keeps = room.bytes.is_some();
        let mut grown = 0;
        if kept.samples.len() < samples {
            self.retraced_pixels += rect.pixels() as u64;
        }
        for sample in kept.samples.len()..samples {
            tracer.grow(rect, sample as u32, &mut self.trees, &mut self.trace);
            shader.add(&self.trees, &mut self.shade);
            grown += self.trees.bytes() as u64;
            let used = room.bytes.map_or(0, |b| b.load(Ordering::Relaxed));
            keeps &= used.saturating_add(grown) <= room.budget;
            if keeps {
                kept.samples.push(self.trees.clone());
            } else {
                kept.samples.clear();
            }
        }
        if let Some(bytes) = room.bytes {
            // Wraps where it shrinks: the sum is right.
            bytes.fetch_add(kept.bytes().wrapping_sub(before), Ordering::Relaxed);
        }
    }

    fn update(
        &mut self,
        keep: &Keep,
        tracer: &Tracer<'_>,
        (rect, sample): (TileRect, u32),
        trees: &mut Trees,
    ) {
        if let Some(moved) = &keep.moved {
            let scratch = (&mut self.trace, &mut self.touch);
            let relit = &keep.revision.relight;
            let pixels = tracer.retrace((rect, sample), moved, relit, trees, scratch);
            self.retraced_pixels += pixels as u64;
        }
        let deepens =
            keep.may_deepen(trees, tracer.columns) && tracer.lacks_levels(trees, &mut self.trace);
        if deepens || keep.revises() {
            tracer.revise((rect, sample), trees, &keep.revision, &mut self.trace);
        }
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
