//! One frame of a scene: the time of its stages, and its rays by kind.
//!
//! Rays are told apart by recording the streams that the first pass casts, once, and casting each
//! kind again on its own. So nothing is measured within the renderer itself, and what it spends
//! beside its rays is the difference.

use crate::exit::{Exit, Failure};
use crate::frames::FrameRanges;
use crate::meant::Script;
use crate::profile::cast::{self, Question};
use cpu_time::ThreadTime;
use rayon::prelude::*;
use reflet_accel::{Accel, Isa, Rays, Structure};
use reflet_frame::EngineOptions;
use reflet_pack::{Columns, Overrides, Packer};
use reflet_trace::{
    BatchColours, Grid, Points, Recorded, ShadeScratch, Shader, TraceScratch, Tracer, Trees,
};
use std::time::{Duration, Instant};

/// A frame, packed, and how long that took.
pub struct Frame {
    columns: Columns,
    /// The stages before the tree: their names and times.
    pub stages: Vec<(&'static str, Duration)>,
}

/// What is measured at one level on some threads; times are medians.
pub struct Measured {
    /// The level's name.
    pub isa: &'static str,
    /// How many threads.
    pub threads: usize,
    /// Building the tree, on the wall.
    pub build: Duration,
    /// Bytes of it.
    pub bytes: usize,
    /// The expected cost of a random ray in it.
    pub sah_cost: f32,
    /// The first pass, CPU time of all threads.
    pub trace: Duration,
    /// The second, likewise.
    pub shade: Duration,
    /// Both, on the wall.
    pub wall: Duration,
    /// Camera, mirror and shadow rays.
    pub kinds: [Kind; 3],
}

/// Rays of one kind.
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// How many.
    pub rays: usize,
    /// How many of them hit.
    pub hits: usize,
    /// What they took, CPU time of all threads.
    pub cpu: Duration,
    /// The same on the wall.
    pub wall: Duration,
}

/// Runs a script as far as a frame.
///
/// # Errors
/// The script's, or there is no such frame.
pub fn load(script: &Script, frame: u32) -> Result<Frame, Failure> {
    let mut timer = Instant::now();
    let mut stages = Vec::new();
    let mut lap =
        |name| stages.push((name, std::mem::replace(&mut timer, Instant::now()).elapsed()));
    let mut stage = script.load()?;
    lap("script");
    let count = stage.with_scene(|scene| scene.animation().frames);
    let asked: FrameRanges = frame.to_string().parse().map_err(Failure::usage)?;
    asked.within(count).map_err(Failure::usage)?;
    let packer = stage.with_scene(|scene| Packer::new(scene, Overrides::default()));
    let mut packer = packer.map_err(|e| Failure::new(Exit::Script, e.to_string()))?;
    lap("pack");
    stage.frame(frame)?;
    lap("script, frame");
    stage.with_scene(|scene| packer.update(scene));
    lap("pack, frame");
    Ok(Frame { columns: packer.columns().clone(), stages })
}

/// Memory of a thread.
#[derive(Default)]
struct Worker {
    trace: TraceScratch,
    trees: Trees,
    shade: ShadeScratch,
}

impl Frame {
    /// How many primitives there are.
    pub fn primitives(&self) -> usize {
        self.columns.geometry.len()
    }

    /// Makes the frame's colours `repeat` times, and casts its rays by kind as often.
    ///
    /// # Errors
    /// The threads cannot be had, or the machine lacks the instructions.
    pub fn measure(&self, isa: Isa, threads: usize, repeat: usize) -> Result<Measured, Failure> {
        let columns = &self.columns;
        let level = isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
        let pool = cast::pool(threads)?;
        let start = Instant::now();
        let build = || Accel::build(&columns.geometry, level, Structure::Auto);
        let accel = pool.install(build);
        let build = start.elapsed();
        let tracer = Tracer { columns, accel: &accel, points: Points::Dropped };
        let colours = BatchColours::of(columns);
        let shader = Shader::new(columns, &colours, level);
        let edge = EngineOptions::default().tile;
        let grid = Grid::new(columns.view.size, edge, columns.model.max_bounces);
        let tile = |worker: &mut Worker, tile: usize| {
            let mut times = [Duration::ZERO; 2];
            let rect = grid.rect(tile);
            shader.begin(&mut worker.shade);
            for sample in 0..columns.samples {
                let start = ThreadTime::now();
                tracer.grow(rect, sample, &mut worker.trees, &mut worker.trace);
                times[0] += start.elapsed();
                let start = ThreadTime::now();
                shader.add(&worker.trees, &mut worker.shade);
                times[1] += start.elapsed();
            }
            let start = ThreadTime::now();
            std::hint::black_box(shader.finish(0, (rect, grid.edge), &mut worker.shade));
            times[1] += start.elapsed();
            times
        };
        let all = || {
            let tiles = (0..grid.len()).into_par_iter();
            let times = tiles.map_init(Worker::default, tile);
            times.reduce(|| [Duration::ZERO; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
        };
        let (mut trace, mut shade, mut wall) = (Vec::new(), Vec::new(), Vec::new());
        for round in 0..=repeat {
            let start = Instant::now();
            let times = pool.install(all);
            // The first round finds its memory.
            if round > 0 {
                trace.push(times[0]);
                shade.push(times[1]);
                wall.push(start.elapsed());
            }
        }
        let mut worker = Worker::default();
        worker.trace.record = Some(Recorded::default());
        (0..grid.len()).for_each(|i| {
            tile(&mut worker, i);
        });
        let recorded = worker.trace.record.unwrap_or_default();
        let kind = |name, streams: &[Rays], question| {
            let cast = cast::cast(&accel, &pool, streams, question, repeat);
            let rays = streams.iter().map(Rays::len).sum();
            let (cpu, wall) = (cast::median(&cast.cpu), cast::median(&cast.wall));
            Kind { name, rays, hits: cast.hits(streams), cpu, wall }
        };
        Ok(Measured {
            isa: isa.resolved().name(),
            threads,
            build,
            bytes: accel.bytes(),
            sah_cost: accel.sah_cost(),
            trace: cast::median(&trace),
            shade: cast::median(&shade),
            wall: cast::median(&wall),
            kinds: [
                kind("camera", &recorded.camera, Question::Closest),
                kind("mirror", &recorded.mirror, Question::Closest),
                kind("shadow", &recorded.shadow, Question::Any),
            ],
        })
    }
}
