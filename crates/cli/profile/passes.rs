//! The two passes of a frame, tile by tile, as the renderer makes them.

use reflet_accel::Accel;
use reflet_accel::isa::Level;
use reflet_frame::EngineOptions;
use reflet_pack::Columns;
use reflet_trace::{
    BatchColours, Grid, Points, Recorded, ShadeScratch, Shader, TileRect, TraceScratch, Tracer,
    Trees,
};

/// What the passes read.
pub struct Passes<'a> {
    /// The tiles.
    pub grid: Grid,
    columns: &'a Columns,
    tracer: Tracer<'a>,
    shader: Shader<'a>,
}

/// Memory of a thread.
#[derive(Default)]
pub struct Worker {
    trace: TraceScratch,
    trees: Trees,
    shade: ShadeScratch,
}

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Pixels to ray trees.
    Trace,
    /// Ray trees to colours.
    Shade,
}

impl<'a> Passes<'a> {
    /// The passes of one frame.
    pub fn new(
        columns: &'a Columns,
        accel: &'a Accel,
        colours: &'a BatchColours,
        level: Level,
    ) -> Passes<'a> {
        let edge = EngineOptions::default().tile;
        Passes {
            grid: Grid::new(columns.view.size, edge, columns.model.max_bounces),
            columns,
            tracer: Tracer { columns, accel, points: Points::Dropped },
            shader: Shader::new(columns, colours, level),
        }
    }

    /// Makes a tile, and says after each part which pass it was.
    pub fn make(&self, worker: &mut Worker, tile: usize, mut lap: impl FnMut(Pass)) {
        let rect = self.grid.rect(tile);
        self.shader.begin(&mut worker.shade);
        for sample in 0..self.columns.positions.len() as u32 {
            lap(Pass::Shade);
            self.tracer.grow(rect, sample, &mut worker.trees, &mut worker.trace);
            lap(Pass::Trace);
            self.shader.add(&worker.trees, &mut worker.shade);
        }
        let place = (rect, self.grid.edge);
        std::hint::black_box(self.shader.finish(0, place, &mut worker.shade));
        lap(Pass::Shade);
    }

    /// The streams that the first pass casts for some pixels.
    pub fn record(&self, worker: &mut Worker, rect: TileRect) -> Recorded {
        worker.trace.record = Some(Recorded::default());
        for sample in 0..self.columns.positions.len() as u32 {
            self.tracer.grow(rect, sample, &mut worker.trees, &mut worker.trace);
        }
        worker.trace.record.take().unwrap_or_default()
    }
}
