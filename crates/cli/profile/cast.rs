//! Rays cast at primitives, and how long it takes.

use crate::exit::{Exit, Failure};
use cpu_time::ThreadTime;
use rayon::prelude::*;
use reflet_accel::{Accel, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::Geometry;
use std::time::{Duration, Instant};

/// What is asked of each ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Its closest hit.
    Closest,
    /// Whether it hits anything.
    Any,
}

/// What one stream gave.
#[derive(Default)]
pub struct Answer {
    hits: Hits,
    occluded: Vec<bool>,
}

/// What is measured at one level on some threads.
pub struct Measured {
    /// The level's name.
    pub isa: &'static str,
    /// How many threads.
    pub threads: usize,
    /// How many rays.
    pub rays: usize,
    /// How many of them hit.
    pub hits: usize,
    /// Of building what they are cast at, by the wall clock.
    pub build: Duration,
    /// That it holds.
    pub bytes: usize,
    /// The expected cost of a random ray by the surface-area heuristic.
    pub sah_cost: f32,
    /// Of each repetition: the CPU time of all threads.
    pub cpu: Vec<Duration>,
    /// Of each repetition: the time on the wall.
    pub wall: Vec<Duration>,
    /// What the streams gave.
    pub answers: Vec<Answer>,
}

/// Casts `streams` at `geometry`, once to warm up and then `repeat` times.
///
/// # Errors
/// The threads cannot be had, or the machine lacks the instructions.
pub fn measure(
    geometry: &Geometry,
    streams: &[Rays],
    question: Question,
    (isa, threads, repeat): (Isa, usize, usize),
) -> Result<Measured, Failure> {
    let level = isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|e| Failure::new(Exit::Failed, format!("cannot start threads: {e}")))?;
    let start = Instant::now();
    let accel = pool.install(|| Accel::build(geometry, level, Structure::Auto));
    let mut measured = Measured {
        isa: isa.resolved().name(),
        threads,
        rays: streams.iter().map(Rays::len).sum(),
        hits: 0,
        build: start.elapsed(),
        bytes: accel.bytes(),
        sah_cost: accel.sah_cost(),
        cpu: Vec::new(),
        wall: Vec::new(),
        answers: Vec::new(),
    };
    measured.answers.resize_with(streams.len(), Answer::default);
    for round in 0..=repeat {
        let start = Instant::now();
        let one = |scratch: &mut Scratch, (rays, answer): (&Rays, &mut Answer)| {
            let start = ThreadTime::now();
            let mut counts = RayCounts::default();
            match question {
                Question::Closest => {
                    accel.closest(rays, &mut answer.hits, scratch, &mut counts);
                }
                Question::Any => accel.any(rays, &mut answer.occluded, scratch, &mut counts),
            }
            start.elapsed()
        };
        let work = streams.par_iter().zip(&mut measured.answers).with_max_len(1);
        let cpu = pool.install(|| work.map_init(Scratch::default, one).sum());
        // The first round finds its memory.
        if round > 0 {
            measured.cpu.push(cpu);
            measured.wall.push(start.elapsed());
        }
    }
    measured.hits = streams.iter().zip(&measured.answers).map(|(r, a)| a.count(r.len())).sum();
    Ok(measured)
}

impl Answer {
    fn count(&self, rays: usize) -> usize {
        if self.occluded.is_empty() {
            return self.hits.code.iter().take(rays).filter(|c| !c.is_none()).count();
        }
        self.occluded.iter().filter(|o| **o).count()
    }

    /// The answer to ray `i`: t and the primitive's id; infinity and the greatest `u32` if it hits
    /// nothing. Of an occluded ray only that is known: 0 and 0.
    fn row(&self, i: usize) -> (f32, u32) {
        let hit = if self.occluded.is_empty() {
            self.hits.code[i].prim().map(|prim| (self.hits.t[i], prim.0))
        } else {
            self.occluded[i].then_some((0.0, 0))
        };
        hit.unwrap_or((f32::INFINITY, u32::MAX))
    }
}

impl Measured {
    /// Eight bytes a ray: t and the primitive.
    pub fn rows(&self, streams: &[Rays]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(8 * self.rays);
        for (rays, answer) in streams.iter().zip(&self.answers) {
            for i in 0..rays.len() {
                let (t, prim) = answer.row(i);
                bytes.extend_from_slice(&t.to_le_bytes());
                bytes.extend_from_slice(&prim.to_le_bytes());
            }
        }
        bytes
    }

    /// Least, median and greatest Mrays/s of the repetitions by these times.
    pub fn mrays_per_s(&self, times: &[Duration]) -> [f64; 3] {
        let speed = |t: &Duration| self.rays as f64 / t.as_secs_f64().max(1e-9) * 1e-6;
        let mut speeds: Vec<f64> = times.iter().map(speed).collect();
        speeds.sort_by(f64::total_cmp);
        match speeds[..] {
            [] => [0.0; 3],
            _ => [speeds[0], speeds[speeds.len() / 2], speeds[speeds.len() - 1]],
        }
    }
}
