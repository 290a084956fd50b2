//! What a cast takes, counted: nodes, kernels, and rays against primitives.
//!
//! Traversals are generic over a [`Counter`]. `()` counts nothing, and nothing is what is left of
//! it after compilation; [`Work`] counts, in one more instance of the scalar level only
//! ([`Accel::count`](crate::Accel::count)). Every level visits the same nodes and blocks in the same
//! order, since all that decides it is one sequence of IEEE operations.

use crate::bundle::Bundle;
use crate::lanes::{LANES, NO_PRIM, WIDE};

/// Told of each step of a traversal.
pub trait Counter {
    /// A node's boxes were held against a ray, or against the frustum of a bundle.
    fn node(&mut self);
    /// A kernel of so many lanes ran, in which so many rays met primitives; all others were in vain.
    fn kernel(&mut self, lanes: usize, used: impl FnOnce() -> usize);
}

/// Counts nothing.
impl Counter for () {
    #[inline(always)]
    fn node(&mut self) {}
    #[inline(always)]
    fn kernel(&mut self, _: usize, _: impl FnOnce() -> usize) {}
}

/// What rays took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Visits of nodes. A bundle visits a node once for all of its rays.
    pub nodes: u64,
    /// Runs of a kernel: one ray against the primitives of a block, or rays of a bundle against one.
    pub kernels: u64,
    /// The lanes of those runs.
    pub lanes: u64,
    /// Tests of one ray against one primitive, in those lanes.
    pub tests: u64,
}

impl Work {
    /// The share of the kernels' lanes in which a ray met a primitive, 0 to 1; 0 if none ran.
    pub fn occupancy(&self) -> f64 {
        self.tests as f64 / self.lanes.max(1) as f64
    }

    /// Visits and tests together.
    pub fn steps(&self) -> u64 {
        self.nodes + self.tests
    }
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Work) {
        self.nodes += other.nodes;
        self.kernels += other.kernels;
        self.lanes += other.lanes;
        self.tests += other.tests;
    }
}

impl Counter for Work {
    #[inline(always)]
    fn node(&mut self) {
        self.nodes += 1;
    }

    #[inline(always)]
    fn kernel(&mut self, lanes: usize, used: impl FnOnce() -> usize) {
        self.kernels += 1;
        self.lanes += lanes as u64;
        self.tests += used() as u64;
    }
}

/// How many primitives a block of these codes holds.
pub fn prims_of(codes: &[u32; LANES]) -> usize {
    codes.iter().filter(|code| **code != NO_PRIM.0).count()
}

/// How many rays of a group are there, and not done with.
pub fn rays_of(bundle: &Bundle, group: usize) -> usize {
    let rays = group * WIDE..bundle.len.min((group + 1) * WIDE);
    bundle.t[rays].iter().filter(|t| **t >= 0.0).count()
}
