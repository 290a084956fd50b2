//! Columns to pictures, tile by tile on all threads.

use crate::job::Reuse;
use crate::reuse::{MadeFor, Plan};
use crate::tile::{KeptTile, Room, Tiler, Worker};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use reflet_accel::isa::Level;
use reflet_accel::{Accel, Isa, RayCounts, Structure};
use reflet_film::{Layout, Picture, TileMut, TransferTable};
use reflet_pack::{Changes, Columns, Slot, Spread, SurfaceChange};
use reflet_trace::{BatchColours, Grid, Points, RayTally, Shader, Tracer};
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
    /// The pictures' left upper pixel, where they are a part of a larger one.
    pub origin: [u32; 2],
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
            origin: [0, 0],
            tile: 16,
            structure: Structure::Auto,
            reuse: Reuse::Keep,
            cache_bytes: u64::MAX,
        }
    }
}

/// Frames that share their ray trees.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    /// The scene; of its colours, those of any of the frames.
    pub columns: &'a Columns,
    /// What differs between the frame rendered before and the batch's first; `None` if that is not
    /// known.
    pub changes: Option<&'a Changes>,
    /// The colours of each frame.
    pub colours: &'a BatchColours,
    /// From colours to samples.
    pub table: &'a TransferTable,
    /// The picture of the frame rendered before, made with the same table.
    pub last: Option<&'a Picture>,
}

/// What a batch took in the engine.
#[derive(Clone, Debug, Default)]
pub struct Work {
    /// Rays by kind.
    pub rays: RayTally,
    /// Rays as `accel` counted them.
    pub counts: RayCounts,
    /// Why all trees were made from scratch, if they were.
    pub fresh: Option<&'static str>,
    /// Pixels of which at least one tree was made from its root.
    pub retraced_pixels: u64,
    /// Nodes whose point was found again without a ray.
    pub replayed_nodes: u64,
    /// Segments that were held against the bounds of what moved.
    pub tested_segments: u64,
    /// Nodes that kept trees grew by, below their leaves.
    pub deepened_nodes: u64,
    /// Nodes whose local colour was computed.
    pub local_nodes: u64,
    /// Tiles shaded rather than copied from the frame before, by frame of the batch.
    pub shaded_tiles: Vec<u64>,
    /// Tiles of a frame.
    pub tiles: u64,
    /// Bytes of trees kept for the next batch.
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
    /// Kept once a surface has moved.
    points: Points,
}

/// The trees of the last frame.
struct Store {
    made_for: MadeFor,
    tiles: Vec<KeptTile>,
    bytes: AtomicU64,
}

/// The batch was told to stop.
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
        Ok(Engine {
            options,
            level,
            pool: Arc::new(pool),
            workers,
            accel: None,
            store: None,
            points: Points::Dropped,
        })
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
        let bounces = columns.model.max_bounces;
        let mut edge = self.options.tile;
        if columns.spread == Spread::Edges {
            // Larger, since each has an apron to trace, and with room for that.
            edge = (2 * edge).clamp(1, Grid::MAX_EDGE / 2).next_power_of_two();
            let nodes = |edge: u32| u64::from((edge + 2) * (edge + 2)) * (u64::from(bounces) + 1);
            while edge > 1 && nodes(edge) > 65_535 {
                edge /= 2;
            }
        }
        Grid::new(columns.view.size, edge, bounces)
    }

    /// The threads, for work beside tracing.
    pub fn pool(&self) -> Arc<ThreadPool> {
        self.pool.clone()
    }

    /// How many bytes kept trees may take from now on.
    pub fn set_tree_budget(&mut self, bytes: u64) {
        self.options.cache_bytes = bytes;
    }

    /// Renders a batch, a frame a picture.
    ///
    /// # Panics
    /// If the pictures differ in size, tiles or samples.
    pub fn render(
        &mut self,
        batch: Batch<'_>,
        pictures: &mut [Picture],
        cancel: &AtomicBool,
    ) -> Result<Work, Cancelled> {
        let start = Instant::now();
        let Batch { columns, changes, .. } = batch;
        self.accelerate(columns, changes);
        let build_ns = nanoseconds(start);
        let Some(first) = pictures.first() else { return Ok(Work::default()) };
        let start = Instant::now();
        let grid = Grid { origin: self.options.origin, ..grid_of(first.layout()) };
        let plan = self.plan(columns, changes, grid);
        self.tiles(&plan, batch, grid, pictures, cancel);
        if cancel.load(Ordering::Relaxed) {
            self.store = None; // some tiles are of this frame and some of the last
            return Err(Cancelled);
        }
        let mut work = self.collect(pictures.len());
        work.tiles = grid.len() as u64;
        work.fresh = if let Plan::Fresh(why) = plan { Some(why) } else { None };
        work.build_ns = build_ns;
        work.trace_ns = nanoseconds(start);
        Ok(work)
    }

    /// Brings the structure that rays are intersected with up to date.
    fn accelerate(&mut self, columns: &Columns, changes: Option<&Changes>) {
        let geometry = &columns.geometry;
        match (&mut self.accel, changes) {
            (Some(accel), Some(changes)) if !changes.rebuilt => {
                let still_there = |c: &&SurfaceChange| c.surface.index() < columns.surfaces.len();
                let moved = changes.surfaces.iter().filter(still_there);
                let moved: Vec<Slot> = moved.flat_map(|c| columns.parts_of(c.surface)).collect();
                if !changes.surfaces.is_empty() {
                    self.pool.install(|| accel.refit(geometry, &moved));
                }
            }
            (accel, _) => {
                let (level, structure) = (self.level, self.options.structure);
                let build = || Accel::build(geometry, level, structure);
                *accel = Some(self.pool.install(build));
            }
        }
    }

    /// Compares with what the kept trees were made for, and makes room for new ones.
    fn plan(&mut self, columns: &Columns, changes: Option<&Changes>, grid: Grid) -> Plan {
        if self.options.reuse == Reuse::Never {
            return Plan::Fresh("no trees are kept");
        }
        let made_for = MadeFor::of(columns, grid);
        let plan = match (&self.store, changes) {
            (Some(store), Some(changes)) => Plan::of(changes, &store.made_for, &made_for),
            _ => Plan::Fresh("there is no frame before"),
        };
        match (&plan, &mut self.store) {
            (Plan::Keep(keep), Some(store)) => {
                store.made_for = made_for;
                if keep.moved.is_some() {
                    self.points = Points::Kept;
                }
            }
            _ => {
                let mut tiles = Vec::new();
                tiles.resize_with(grid.len(), KeptTile::default);
                self.store = Some(Store { made_for, tiles, bytes: AtomicU64::new(0) });
            }
        }
        plan
    }

    fn tiles(
        &mut self,
        plan: &Plan,
        batch: Batch<'_>,
        grid: Grid,
        pictures: &mut [Picture],
        cancel: &AtomicBool,
    ) {
        let Some(accel) = &self.accel else { return };
        let mut none = Vec::new();
        let (kept, used) = match &mut self.store {
            Some(store) => (&mut store.tiles, Some(&store.bytes)),
            None => {
                none.resize_with(grid.len(), KeptTile::default);
                (&mut none, None)
            }
        };
        let tiler = Tiler {
            plan,
            tracer: Tracer { columns: batch.columns, accel, points: self.points },
            shader: Shader::new(batch.columns, batch.colours, self.level),
            table: batch.table,
            last: batch.last,
            grid,
            room: Room { used, budget: self.options.cache_bytes },
        };
        let workers = &self.workers;
        let tile = |(mut frames, kept): (Vec<TileMut<'_>>, &mut KeptTile)| {
            if !cancel.load(Ordering::Relaxed) {
                let index = rayon::current_thread_index().unwrap_or(0);
                let mut worker = workers[index].lock().unwrap_or_else(PoisonError::into_inner);
                worker.tile(&tiler, kept, &mut frames);
            }
        };
        let tiles = by_tile(pictures, grid.len());
        self.pool.install(|| tiles.into_par_iter().zip(kept.par_iter_mut()).for_each(tile));
    }

    /// What all threads counted since the last batch.
    fn collect(&mut self, frames: usize) -> Work {
        let mut work = Work { shaded_tiles: vec![0; frames], ..Work::default() };
        work.kept_bytes = self.store.as_ref().map_or(0, |s| s.bytes.load(Ordering::Relaxed));
        for worker in &mut self.workers {
            let worker = worker.get_mut().unwrap_or_else(PoisonError::into_inner);
            work.rays += std::mem::take(&mut worker.trace.rays);
            work.replayed_nodes += std::mem::take(&mut worker.trace.replayed);
            work.tested_segments += std::mem::take(&mut worker.trace.tested);
            work.deepened_nodes += std::mem::take(&mut worker.trace.deepened);
            work.local_nodes += std::mem::take(&mut worker.shade.local_nodes);
            work.retraced_pixels += std::mem::take(&mut worker.retraced_pixels);
            let counts = std::mem::take(&mut worker.trace.counts);
            work.counts.closest += counts.closest;
            work.counts.any += counts.any;
            let shaded = std::mem::take(&mut worker.shaded_tiles);
            work.shaded_tiles.iter_mut().zip(shaded).for_each(|(sum, n)| *sum += n);
        }
        work
    }
}

/// The tiles of all pictures, those of the same place together.
fn by_tile(pictures: &mut [Picture], tiles: usize) -> Vec<Vec<TileMut<'_>>> {
    let mut places: Vec<Vec<TileMut<'_>>> = Vec::new();
    places.resize_with(tiles, || Vec::with_capacity(pictures.len()));
    for picture in pictures {
        for tile in picture.tiles_mut() {
            places[tile.index].push(tile);
        }
    }
    places
}

/// The tiles of a picture as the first pass sees them.
fn grid_of(layout: Layout) -> Grid {
    Grid { size: [layout.width(), layout.height()], origin: [0, 0], edge: layout.tile() }
}

/// Nanoseconds since `start`.
pub(crate) fn nanoseconds(start: Instant) -> u64 {
    start.elapsed().as_nanos() as u64
}
