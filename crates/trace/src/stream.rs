//! The rays of one level on their way to becoming nodes.

use crate::interact::Interactions;
use crate::smooth;
use fearless_simd::Simd;
use reflet_accel::lanes::LANES;
use reflet_accel::{HitCode, Hits, Rays, known};
use reflet_pack::Columns;

/// Rays cast, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayTally {
    /// From the eye.
    pub camera: u64,
    /// From mirrors.
    pub mirror: u64,
    /// To lights.
    pub shadow: u64,
}

impl RayTally {
    /// The sum of all kinds.
    pub fn total(&self) -> u64 {
        self.camera + self.mirror + self.shadow
    }
}

impl std::ops::AddAssign for RayTally {
    fn add_assign(&mut self, other: RayTally) {
        self.camera += other.camera;
        self.mirror += other.mirror;
        self.shadow += other.shadow;
    }
}

/// The streams of rays that were cast, by kind, each as it entered `accel`.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// From the eye, a stream a tile and sample.
    pub camera: Vec<Rays>,
    /// From mirrors, a stream a tile, sample and level.
    pub mirror: Vec<Rays>,
    /// To lights, a stream a tile, sample, level and light.
    pub shadow: Vec<Rays>,
}

/// Rays, what they hit, and where.
#[derive(Default)]
pub(crate) struct Stream {
    pub rays: Rays,
    pub hits: Hits,
    pub points: Interactions,
    /// The length of the path before each ray.
    pub totals: Vec<f32>,
    /// The row of the level above whose ray each is.
    pub parents: Vec<u16>,
    pub spare: Vec<u16>,
}

impl Stream {
    pub fn clear(&mut self) {
        self.rays.clear();
        self.totals.clear();
        self.parents.clear();
    }

    /// The hit point of a row.
    pub fn point(&self, row: usize) -> [f32; 3] {
        [0, 1, 2].map(|k| self.points.p[k][row])
    }

    #[inline(always)]
    pub fn find<S: Simd>(&mut self, simd: S, columns: &Columns) {
        self.points.find(simd, &columns.geometry, &self.rays, &self.hits);
        if columns.surfaces.any_smooth() {
            smooth::turn(columns, &self.hits.code[..self.rays.len()], &mut self.points);
        }
    }

    /// Finds t of hits that are known but for it, and the points: the same kernel gives the same
    /// bits.
    #[inline(always)]
    pub fn replay<S: Simd>(&mut self, simd: S, columns: &Columns, codes: &[HitCode]) {
        let len = self.rays.len();
        let padded = len.next_multiple_of(LANES);
        self.hits.t.resize(padded, 0.0);
        self.hits.code.clear();
        self.hits.code.extend_from_slice(&codes[..len]);
        self.hits.code.resize(padded, HitCode::NONE);
        known::distances(simd, &columns.geometry, &self.rays, &self.hits.code, &mut self.hits.t);
        self.find(simd, columns);
    }
}
