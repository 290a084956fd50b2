//! Rays cast at primitives, and how long it takes.

use crate::exit::{Exit, Failure};
use cpu_time::ThreadTime;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use reflet_accel::{Accel, Hits, RayCounts, Rays, Scratch};
use std::time::{Duration, Instant};

pub use reflet_accel::Question;

/// What one stream gave.
#[derive(Default)]
pub struct Answer {
    hits: Hits,
    occluded: Vec<bool>,
}

/// What rays gave, and how long they took.
pub struct Cast {
    /// Of each repetition: the CPU time of all threads.
    pub cpu: Vec<Duration>,
    /// Of each repetition: the time on the wall.
    pub wall: Vec<Duration>,
    /// Before each repetition: the time of [`reference()`].
    pub reference: Vec<Duration>,
    answers: Vec<Answer>,
}

/// Threads to cast rays on.
///
/// # Errors
/// They cannot be had.
pub fn pool(threads: usize) -> Result<ThreadPool, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Failure::new(Exit::Failed, format!("cannot start threads: {e}")))
}

/// The CPU time of a piece of work that is always the same, the mean of all threads at once: how
/// quick the machine is just now. Clocks change, and other work shares cores.
pub fn reference(pool: &ThreadPool) -> Duration {
    let work = |_: rayon::BroadcastContext<'_>| {
        let start = ThreadTime::now();
        let mut column = [0.5f32; 2048];
        for round in 0..256 {
            let round = std::hint::black_box(round as f32);
            column.iter_mut().for_each(|x| *x = (*x * 0.999 + round).sqrt());
        }
        std::hint::black_box(column);
        start.elapsed()
    };
    let times = pool.broadcast(work);
    times.iter().sum::<Duration>() / times.len().max(1) as u32
}

/// Casts `streams`, once to warm up and then `repeat` times.
pub fn cast(
    accel: &Accel,
    pool: &ThreadPool,
    streams: &[Rays],
    question: Question,
    repeat: usize,
) -> Cast {
    let mut cast =
        Cast { cpu: Vec::new(), wall: Vec::new(), reference: Vec::new(), answers: Vec::new() };
    cast.answers.resize_with(streams.len(), Answer::default);
    // So few parts that their clocks do not count, and so many that no thread waits long.
    let part = streams.len().div_ceil(8 * pool.current_num_threads()).max(1);
    for round in 0..=repeat {
        let reference = reference(pool);
        let start = Instant::now();
        let one = |scratch: &mut Scratch, (rays, answers): (&[Rays], &mut [Answer])| {
            let start = ThreadTime::now();
            let mut counts = RayCounts::default();
            for (rays, answer) in rays.iter().zip(answers) {
                match question {
                    Question::Closest => {
                        accel.closest(rays, &mut answer.hits, scratch, &mut counts)
                    }
                    Question::Any => accel.any(rays, &mut answer.occluded, scratch, &mut counts),
                }
            }
            start.elapsed()
        };
        let work = streams.par_chunks(part).zip(cast.answers.par_chunks_mut(part)).with_max_len(1);
        let cpu = pool.install(|| work.map_init(Scratch::default, one).sum());
        // The first round finds its memory.
        if round > 0 {
            cast.cpu.push(cpu);
            cast.wall.push(start.elapsed());
            cast.reference.push(reference);
        }
    }
    cast
}

/// The middle one of some times; none of none.
pub fn median(times: &[Duration]) -> Duration {
    let mut times = times.to_vec();
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
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

impl Cast {
    /// How many rays hit.
    pub fn hits(&self, streams: &[Rays]) -> usize {
        streams.iter().zip(&self.answers).map(|(rays, answer)| answer.count(rays.len())).sum()
    }

    /// Eight bytes a ray: t and the primitive.
    pub fn rows(&self, streams: &[Rays]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (rays, answer) in streams.iter().zip(&self.answers) {
            for i in 0..rays.len() {
                let (t, prim) = answer.row(i);
                bytes.extend_from_slice(&t.to_le_bytes());
                bytes.extend_from_slice(&prim.to_le_bytes());
            }
        }
        bytes
    }
}

/// Mrays/s.
pub fn speed(rays: usize, time: Duration) -> f64 {
    rays as f64 / time.as_secs_f64().max(1e-9) * 1e-6
}
