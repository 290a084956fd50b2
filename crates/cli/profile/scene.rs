//! One frame of a scene: the time of its stages, and its rays by kind.
//!
//! Rays are told apart by recording the streams that the first pass casts, once, and casting each
//! kind again on its own. So nothing is measured within the renderer itself, and what it spends
//! beside its rays is the difference.

use crate::exit::{Exit, Failure};
use crate::frames::outside_of;
use crate::meant::Script;
use crate::profile::cast::{self, Question};
use crate::profile::counted::{self, Spread};
use crate::profile::counters::{self, Counted as Hardware};
use crate::profile::figures::Figure;
use crate::profile::passes::{Pass, Passes, Worker};
use crate::profile::timeline::Timeline;
use crate::profile::{Outputs, dump, encode, heatmap, reuse};
use cpu_time::ThreadTime;
use rayon::prelude::*;
use reflet_accel::{Accel, Isa, Quality, Rays, Structure, Work};
use reflet_pack::{Changes, Columns, Overrides, Packer, SceneHasher};
use reflet_trace::BatchColours;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A frame, packed, and how long that took.
pub struct Frame {
    /// The frame's columns.
    pub columns: Columns,
    /// The columns of the frame before, if there is one, and what has changed since.
    pub before: Option<(Columns, Changes)>,
    /// The stages before the tree: their names and times.
    pub stages: Vec<(&'static str, Duration)>,
    /// Files that were read for it.
    pub inputs: Vec<PathBuf>,
    quality: Quality,
}

/// What is measured at one level on some threads; times are of each repetition.
pub struct Measured {
    /// The level's name.
    pub isa: &'static str,
    /// How many threads.
    pub threads: usize,
    /// Building the tree, on the wall, once.
    pub build: Duration,
    /// Bytes of it.
    pub bytes: usize,
    /// The expected cost of a random ray in it.
    pub sah_cost: f32,
    /// The first pass, CPU time of all threads.
    pub trace: Vec<Duration>,
    /// The second, likewise.
    pub shade: Vec<Duration>,
    /// Both, on the wall.
    pub wall: Vec<Duration>,
    /// Before each repetition: the time of [`cast::reference`].
    pub reference: Vec<Duration>,
    /// Camera, mirror and shadow rays.
    pub kinds: [Kind; 3],
    /// How tiles differ: rays.
    pub tile_rays: Spread,
    /// Node visits and primitive tests.
    pub tile_steps: Spread,
    /// Microseconds of CPU time, both passes.
    pub tile_us: Spread,
    /// The picture to a PNG.
    pub encoded: encode::Encoded,
    /// What re-use saves, if there is a frame before.
    pub saved: Option<reuse::Saved>,
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
    pub cpu: Vec<Duration>,
    /// The same on the wall.
    pub wall: Vec<Duration>,
    /// Before each repetition: the time of [`cast::reference`].
    pub reference: Vec<Duration>,
    /// Node visits and primitive tests.
    pub work: Work,
    /// What the processor counted, where it tells.
    pub hardware: Hardware,
}

/// Runs a script as far as a frame.
///
/// # Errors
/// The script's, or there is no such frame.
pub fn load(script: &Script, frame: u32, quality: Quality) -> Result<Frame, Failure> {
    let mut timer = Instant::now();
    let mut stages = Vec::new();
    let mut lap =
        |name| stages.push((name, std::mem::replace(&mut timer, Instant::now()).elapsed()));
    let mut stage = script.load()?;
    lap("script");
    let count = stage.with_scene(|scene| scene.animation().frames);
    if frame >= count {
        return Err(Failure::usage(format!("--frame: {}", outside_of(frame, count))));
    }
    let packer = stage.with_scene(|scene| Packer::new(scene, Overrides::default()));
    let mut packer = packer.map_err(|e| Failure::new(Exit::Script, e.to_string()))?;
    lap("pack");
    let mut earlier = None;
    if let Some(before) = frame.checked_sub(1) {
        stage.frame(before)?;
        stage.with_scene(|scene| packer.update(scene));
        earlier = Some(packer.columns().clone());
        lap("frame before");
    }
    stage.frame(frame)?;
    lap("script, frame");
    let changes = stage.with_scene(|scene| packer.update(scene));
    lap("pack, frame");
    if let Some(before) = &earlier {
        // The whole comparison; packing only looks at what the frame wrote.
        std::hint::black_box(Changes::between(before, packer.columns()));
        lap("diff, whole");
    }
    let before = earlier.map(|columns| (columns, changes));
    let inputs = stage.inputs();
    Ok(Frame { columns: packer.columns().clone(), before, stages, inputs, quality })
}

impl Frame {
    /// How many primitives there are.
    pub fn primitives(&self) -> usize {
        self.columns.geometry.prims() as usize
    }

    /// A hash of all that decides the frame's picture.
    pub fn name(&self) -> String {
        SceneHasher::of(&self.columns).to_string()
    }

    fn accel(&self, isa: Isa) -> Result<Accel, Failure> {
        let level = isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
        Ok(Accel::build_as(&self.columns.geometry, level, Structure::Auto, self.quality))
    }

    /// Makes the frame's colours `repeat` times, and casts its rays by kind as often.
    ///
    /// # Errors
    /// The threads cannot be had, or the machine lacks the instructions.
    pub fn measure(&self, isa: Isa, threads: usize, repeat: usize) -> Result<Measured, Failure> {
        let pool = cast::pool(threads)?;
        let start = Instant::now();
        let accel = pool.install(|| self.accel(isa))?;
        let build = start.elapsed();
        let colours = BatchColours::of(&self.columns);
        let passes = Passes::new(&self.columns, &accel, &colours, accel.level());
        let tile = |worker: &mut Worker, tile: usize| {
            let (mut times, mut start) = ([Duration::ZERO; 2], ThreadTime::now());
            passes.make(worker, tile, |pass| {
                let part = &mut times[if pass == Pass::Trace { 0 } else { 1 }];
                *part += start.elapsed();
                start = ThreadTime::now();
            });
            times
        };
        let all = || -> Vec<[Duration; 2]> {
            let tiles = (0..passes.grid.len()).into_par_iter();
            tiles.map_init(Worker::default, tile).collect()
        };
        let (mut trace, mut shade, mut wall) = (Vec::new(), Vec::new(), Vec::new());
        let mut reference = Vec::new();
        let mut tiles = vec![Vec::new(); passes.grid.len()];
        for round in 0..=repeat {
            let quick = cast::reference(&pool);
            let start = Instant::now();
            let times = pool.install(all);
            // The first round finds its memory.
            if round > 0 {
                wall.push(start.elapsed());
                reference.push(quick);
                trace.push(times.iter().map(|t| t[0]).sum());
                shade.push(times.iter().map(|t| t[1]).sum());
                tiles.iter_mut().zip(times).for_each(|(all, t)| all.push(t[0] + t[1]));
            }
        }
        let tile_times: Vec<_> = tiles.iter().map(|times| cast::median(times)).collect();
        let counts = pool.install(|| counted::tiles(&passes, &accel));
        let kind = |k: usize, name, streams: &[Rays], question| {
            let cast = cast::cast(&accel, &pool, streams, question, repeat);
            let rays = streams.iter().map(Rays::len).sum();
            let (hits, work) = (cast.hits(streams), counts.work[k]);
            let cast::Cast { cpu, wall, reference, .. } = cast;
            let hardware = counters::count(&accel, streams, question);
            Kind { name, rays, hits, cpu, wall, reference, work, hardware }
        };
        Ok(Measured {
            isa: isa.resolved().name(),
            threads,
            build,
            bytes: accel.bytes(),
            sah_cost: accel.sah_cost(),
            trace,
            shade,
            wall,
            reference,
            kinds: [
                kind(0, "camera", &counts.recorded.camera, Question::Closest),
                kind(1, "mirror", &counts.recorded.mirror, Question::Closest),
                kind(2, "shadow", &counts.recorded.shadow, Question::Any),
            ],
            tile_rays: Spread::of_counts(&counts.tile_rays),
            tile_steps: Spread::of_counts(&counts.tile_steps),
            tile_us: Spread::of_times(&tile_times),
            encoded: encode::measure(self, isa, threads, repeat)?,
            saved: reuse::measure(self, isa, threads, repeat)?,
        })
    }

    /// Writes what is asked for beside the measurement, and says what.
    ///
    /// # Errors
    /// An output's; the threads cannot be had, or the machine lacks the instructions.
    pub fn write(
        &self,
        outputs: &Outputs,
        name: &str,
        isa: Isa,
        threads: usize,
    ) -> Result<String, Failure> {
        let mut text = String::new();
        if outputs.dump.is_none() && outputs.heatmap.is_none() && outputs.timeline.is_none() {
            return Ok(text);
        }
        let pool = cast::pool(threads)?;
        let start = Instant::now();
        let accel = pool.install(|| self.accel(isa))?;
        let build = start.elapsed();
        let colours = BatchColours::of(&self.columns);
        let passes = Passes::new(&self.columns, &accel, &colours, accel.level());
        if let Some(path) = &outputs.timeline {
            let mut timeline = Timeline::default();
            self.stages.iter().for_each(|(name, time)| timeline.stage(name, *time));
            timeline.stage("build", build);
            timeline.tiles(&passes, &pool);
            timeline.write(path)?;
        }
        if let Some(path) = &outputs.heatmap {
            let costs = pool.install(|| counted::pixels(&passes, &accel));
            heatmap::write(path, &costs, passes.grid.size[0])?;
            let Spread { p50, p95, max } = Spread::of_counts(&costs);
            text += &format!(
                "{}: node visits and primitive tests of each pixel's rays alone; \
                 p50 {p50}, p95 {p95}, max {max}\n",
                path.display()
            );
        }
        if let Some(dir) = &outputs.dump {
            let geometry = &self.columns.geometry;
            text += &dump::primitives(geometry, dir, name)?;
            let recorded = pool.install(|| counted::tiles(&passes, &accel)).recorded;
            for (kind, streams) in [
                ("camera", &recorded.camera),
                ("mirror", &recorded.mirror),
                ("shadow", &recorded.shadow),
            ] {
                text += &dump::rays(geometry, streams, dir, (name, kind))?;
            }
        }
        Ok(text)
    }
}

impl Measured {
    /// What `--save` keeps.
    pub fn figures(&self) -> Vec<Figure> {
        let figure = |what: &str, cpu: &[Duration], reference: &[Duration]| {
            Figure::new(what, (self.isa, self.threads), cpu, reference)
        };
        let passes = [("trace", &self.trace), ("shade", &self.shade)];
        let passes = passes.map(|(what, cpu)| figure(what, cpu, &self.reference));
        // Of rays that there are none of, nothing is to be compared.
        let kinds = self.kinds.iter().filter(|kind| kind.rays > 0);
        let kinds = kinds.map(|kind| figure(kind.name, &kind.cpu, &kind.reference));
        passes.into_iter().chain(kinds).collect()
    }
}
