//! Chunks of a level's segments in capsules, so that most are passed over together when something
//! small moves.

use crate::segment::{self, Begin, Segments};
use crate::trees::Trees;
use fearless_simd::prelude::*;
use reflet_accel::lanes::{F, LANES, V3, load3};
use reflet_pack::Volume;
use reflet_pack::lights::LightPlace;
use std::ops::Range;

/// Rows of a chunk.
const CHUNK: usize = 32;

/// Of each chunk of a level, the balls that hold where its rays begin and where they end: x, y, z
/// and radius, padded to whole lanes. A ray that hits nothing has no end: its chunk's radius is
/// infinite.
#[derive(Clone, Debug, Default)]
pub struct Capsules {
    from: [Vec<f32>; 4],
    to: [Vec<f32>; 4],
    chunks: usize,
}

/// What a chunk's rays run to.
#[derive(Clone, Copy)]
pub(crate) enum To<'a> {
    /// Where they end.
    Ends,
    /// A light, from where they end.
    Light(&'a LightPlace),
}

impl Capsules {
    /// The bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.from.iter().chain(&self.to).map(|column| 4 * column.len()).sum()
    }

    /// Finds the capsules of all levels of trees that keep their points.
    pub(crate) fn find(trees: &mut Trees, begin: Begin<'_>) {
        for depth in 0..trees.levels.len() {
            let (above, level) = trees.levels.split_at_mut(depth);
            let begin = above.last().map_or(begin, |above| Begin::Above(&above.at));
            let level = &mut level[0];
            let mut capsules = std::mem::take(&mut level.capsules);
            capsules.clear();
            for first in (0..level.len()).step_by(CHUNK) {
                let rows = first..(first + CHUNK).min(level.len());
                let from = match begin {
                    Begin::Above(columns) => ball(|k| {
                        let at = |row: &u16| columns[k][usize::from(*row)];
                        extent(level.parent[rows.clone()].iter().map(at))
                    }),
                    Begin::Eye(eye) => [eye[0], eye[1], eye[2], 0.0],
                };
                let mut to = ball(|k| extent(level.at[k][rows.clone()].iter().copied()));
                // Shadow rays may leave above.
                to[3] +=
                    level.lift[rows.clone()].iter().fold(0.0, |m, x| if *x > m { *x } else { m });
                if level.code[rows].iter().any(|code| code.is_none()) {
                    to[3] = f32::INFINITY;
                }
                capsules.push(from, to);
            }
            capsules.pad();
            level.capsules = capsules;
        }
    }

    fn clear(&mut self) {
        self.from.iter_mut().chain(&mut self.to).for_each(Vec::clear);
        self.chunks = 0;
    }

    fn push(&mut self, from: [f32; 4], to: [f32; 4]) {
        self.from.iter_mut().zip(from).for_each(|(column, x)| column.push(x));
        self.to.iter_mut().zip(to).for_each(|(column, x)| column.push(x));
        self.chunks += 1;
    }

    fn pad(&mut self) {
        let padded = self.chunks.next_multiple_of(LANES);
        self.from.iter_mut().chain(&mut self.to).for_each(|column| column.resize(padded, 0.0));
    }

    /// The chunks whose rays may meet any of `volumes`, a flag each.
    #[inline(always)]
    pub(crate) fn near<S: Simd>(
        &self,
        simd: S,
        to: To<'_>,
        volumes: [&[Volume]; 2],
        near: &mut Vec<bool>,
    ) {
        near.clear();
        for first in (0..self.chunks).step_by(LANES) {
            let (ends, end_radius) = balls(simd, &self.to, first);
            let capsules = match to {
                To::Ends => {
                    let (begins, radius) = balls(simd, &self.from, first);
                    let wider = end_radius.simd_gt(radius);
                    Segments::thick(simd, begins, ends, wider.select(end_radius, radius))
                }
                To::Light(light) => segment::to_light(simd, ends, light, end_radius),
            };
            let mut lanes = 0;
            for volume in volumes.into_iter().flatten() {
                let (center, radius) = around(volume);
                lanes |= capsules.meet_ball(simd, center, radius).to_bitmask() as u32;
            }
            for lane in 0..LANES.min(self.chunks - first) {
                near.push(lanes >> lane & 1 == 1);
            }
        }
    }
}

/// The rows of the chunks that are flagged.
pub(crate) fn flagged(near: &[bool], rows: usize) -> impl Iterator<Item = Range<usize>> {
    let flagged = near.iter().enumerate().filter(|(_, near)| **near);
    flagged.map(move |(chunk, _)| chunk * CHUNK..((chunk + 1) * CHUNK).min(rows))
}

#[inline(always)]
fn balls<S: Simd>(simd: S, columns: &[Vec<f32>; 4], first: usize) -> (V3<S>, F<S>) {
    let lanes = first..first + LANES;
    let [x, y, z, radius] = columns;
    let center = load3(simd, [&x[lanes.clone()], &y[lanes.clone()], &z[lanes.clone()]]);
    (center, F::from_slice(simd, &radius[lanes]))
}

/// The least and the greatest.
fn extent(numbers: impl Iterator<Item = f32>) -> [f32; 2] {
    numbers.fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], x| {
        [if x < lo { x } else { lo }, if x > hi { x } else { hi }]
    })
}

/// The ball around the box that has `extent` along each axis.
fn ball(extent: impl Fn(usize) -> [f32; 2]) -> [f32; 4] {
    let [x, y, z] = [extent(0), extent(1), extent(2)];
    around_box([x[0], y[0], z[0]], [x[1], y[1], z[1]])
}

fn around_box(lo: [f32; 3], hi: [f32; 3]) -> [f32; 4] {
    let center = [0, 1, 2].map(|k| lo[k] * 0.5 + hi[k] * 0.5);
    let half = [0, 1, 2].map(|k| hi[k] * 0.5 - lo[k] * 0.5);
    let radius = (half[0] * half[0] + half[1] * half[1] + half[2] * half[2]).sqrt();
    [center[0], center[1], center[2], radius]
}

/// The ball around a volume; that of an infinite one has numbers that are none, and so is met.
fn around(volume: &Volume) -> ([f32; 3], f32) {
    match volume {
        Volume::Nothing => ([0.0; 3], f32::NEG_INFINITY),
        Volume::Ball { center, radius } => (*center, *radius),
        Volume::Box(b) => {
            let [x, y, z, radius] = around_box(b.lo, b.hi);
            ([x, y, z], radius)
        }
    }
}
