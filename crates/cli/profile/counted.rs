//! What rays take, counted rather than timed: node visits and primitive tests.

use crate::profile::cast::Question;
use crate::profile::passes::{Passes, Worker};
use rayon::prelude::*;
use reflet_accel::{Accel, Hits, Rays, Scratch, Work};
use reflet_trace::{Recorded, TileRect};
use std::time::Duration;

/// Counts of one frame.
#[derive(Default)]
pub struct Counted {
    /// All of its rays by kind, in the streams that they were cast in.
    pub recorded: Recorded,
    /// What camera, mirror and shadow rays took.
    pub work: [Work; 3],
    /// Rays of each tile.
    pub tile_rays: Vec<u64>,
    /// Node visits and primitive tests of each tile.
    pub tile_steps: Vec<u64>,
}

/// How something is spread over tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half of them have no more.
    pub p50: f64,
    /// 95 of 100 have no more.
    pub p95: f64,
    /// None has more.
    pub max: f64,
}

impl Spread {
    /// The spread of some numbers, by the nearest rank; zeros of none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Spread {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let rank = |share: f64| (share * values.len() as f64).ceil() as usize;
        let at = |share| values.get(rank(share).max(1) - 1).copied().unwrap_or_default();
        Spread { p50: at(0.5), p95: at(0.95), max: at(1.0) }
    }

    /// The spread of counts.
    pub fn of_counts(counts: &[u64]) -> Spread {
        Spread::of(counts.iter().map(|n| *n as f64))
    }

    /// The spread of times, in microseconds.
    pub fn of_times(times: &[Duration]) -> Spread {
        Spread::of(times.iter().map(|t| t.as_secs_f64() * 1e6))
    }
}

/// What streams by kind take.
fn work(accel: &Accel, recorded: &Recorded, scratch: &mut Scratch) -> [Work; 3] {
    let mut hits = Hits::default();
    let mut kind = |streams: &[Rays], question| {
        let mut work = Work::default();
        streams.iter().for_each(|rays| work += accel.count(rays, question, &mut hits, scratch));
        work
    };
    [
        kind(&recorded.camera, Question::Closest),
        kind(&recorded.mirror, Question::Closest),
        kind(&recorded.shadow, Question::Any),
    ]
}

fn rays_of(recorded: &Recorded) -> usize {
    let Recorded { camera, mirror, shadow } = recorded;
    [camera, mirror, shadow].into_iter().flatten().map(Rays::len).sum()
}

/// Counts what each tile takes, on the threads of the pool that this is called in.
pub fn tiles(passes: &Passes<'_>, accel: &Accel) -> Counted {
    let tile = |(worker, scratch): &mut (Worker, Scratch), tile: usize| {
        let recorded = passes.record(worker, passes.grid.rect(tile));
        let work = work(accel, &recorded, scratch);
        (recorded, work)
    };
    let tiles = (0..passes.grid.len()).into_par_iter();
    let tiles: Vec<_> = tiles.map_init(Default::default, tile).collect();
    let mut all = Counted::default();
    for (recorded, work) in tiles {
        all.tile_rays.push(rays_of(&recorded) as u64);
        all.tile_steps.push(work.iter().map(Work::steps).sum());
        all.work.iter_mut().zip(work).for_each(|(sum, work)| *sum += work);
        all.recorded.camera.extend(recorded.camera);
        all.recorded.mirror.extend(recorded.mirror);
        all.recorded.shadow.extend(recorded.shadow);
    }
    all
}

/// Node visits and primitive tests of each pixel, row by row: what its rays take when they are cast
/// without those of its neighbours, with which a bundle would share visits.
pub fn pixels(passes: &Passes<'_>, accel: &Accel) -> Vec<u64> {
    let [width, height] = passes.grid.size;
    let pixel = |(worker, scratch): &mut (Worker, Scratch), i: u32| {
        let rect = TileRect { x: i % width, y: i / width, width: 1, height: 1 };
        let recorded = passes.record(worker, rect);
        work(accel, &recorded, scratch).iter().map(Work::steps).sum()
    };
    (0..width * height).into_par_iter().map_init(Default::default, pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        let spread = Spread::of((1..=100).rev().map(f64::from));
        assert_eq!(spread, Spread { p50: 50.0, p95: 95.0, max: 100.0 });
        assert_eq!(Spread::of([7.0]), Spread { p50: 7.0, p95: 7.0, max: 7.0 });
        assert_eq!(Spread::of_counts(&[1, 2, 9]), Spread { p50: 2.0, p95: 9.0, max: 9.0 });
        assert_eq!(Spread::of([]), Spread { p50: 0.0, p95: 0.0, max: 0.0 });
    }
}
