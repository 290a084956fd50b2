//! The order in which a long stream of scattered rays is cast: neighbours in it start near each
//! other and run the same way, so that they find the same nodes in the cache.

use crate::build::Tree;
use crate::bundle::{self, NO_CLASS};
use crate::lanes::TURN;
use crate::rays::Rays;

/// Shorter streams are cast as they come.
const LONG: usize = 4096;

/// The memory of an order.
#[derive(Default)]
pub struct Order {
    keyed: Vec<u64>,
    rows: Vec<u32>,
}

static SORT: std::sync::LazyLock<u32> = std::sync::LazyLock::new(|| {
    std::env::var("SORT").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
});

impl Order {
    /// The rows of `rays` in an order of their own, if that is worth it.
    pub fn sort(&mut self, tree: &Tree, rays: &Rays) -> Option<&[u32]> {
        if rays.len() < LONG || tree.nodes.len() < 16 || !is_scattered(tree, rays) || *SORT == 0 {
            return None;
        }
        let mode = *SORT;
        self.keyed.clear();
        self.keyed.extend((0..rays.len()).map(|i| u64::from(key(tree, rays, i, mode)) << 32 | i as u64));
        self.keyed.sort_unstable();
        self.rows.clear();
        self.rows.extend(self.keyed.iter().map(|k| *k as u32));
        Some(&self.rows)
    }
}

/// Whether most neighbours start far from each other or run apart, in a sample.
fn is_scattered(tree: &Tree, rays: &Rays) -> bool {
    let sample = 64;
    let step = rays.len() / sample;
    let mut apart = 0;
    for s in 0..sample {
        let (i, j) = (s * step, s * step + 8.min(step - 1));
        let way: f32 = (0..3).map(|k| (rays.origin[k][i] - rays.origin[k][j]).abs()).sum();
        let turn: f32 = (0..3).map(|k| (rays.dir[k][i] - rays.dir[k][j]).abs()).sum();
        apart += usize::from(way > 0.02 * tree.extent || turn > 0.25);
    }
    apart > sample / 4
}

/// Spreads the lower 10 bits to every third place.
fn spread3(mut x: u32) -> u32 {
    x = (x | x << 16) & 0x0300_00ff;
    x = (x | x << 8) & 0x0300_f00f;
    x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Spreads the lower 16 bits to every second place.
fn spread2(mut x: u32) -> u32 {
    x = (x | x << 8) & 0x00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

fn key(tree: &Tree, rays: &Rays, i: usize, mode: u32) -> u32 {
    let class = bundle::class(rays, i);
    if class == NO_CLASS {
        return u32::MAX;
    }
    let turn = TURN[usize::from(class >> 1)];
    let o = |k: usize, cells: f32| {
        let x = (rays.origin[k][i] - tree.least[k]) * tree.per_extent[k] * cells;
        (x.max(0.0) as u32).min(cells as u32 - 1)
    };
    let s = |k: usize, cells: f32| {
        let x = rays.dir[turn[k]][i] / rays.dir[turn[2]][i];
        (((x * 0.5 + 0.5) * cells) as u32).min(cells as u32 - 1)
    };
    let c = u32::from(class);
    match mode {
        1 => {
            // class, origin 4x3, slopes 4x2, origin..
            let p = spread3(o(0, 16.0)) | spread3(o(1, 16.0)) << 1 | spread3(o(2, 16.0)) << 2;
            let q = spread2(s(0, 16.0)) | spread2(s(1, 16.0)) << 1;
            c << 20 | p << 8 | q
        }
        2 => {
            let p = spread3(o(0, 64.0)) | spread3(o(1, 64.0)) << 1 | spread3(o(2, 64.0)) << 2;
            let q = spread2(s(0, 8.0)) | spread2(s(1, 8.0)) << 1;
            c << 24 | q << 18 | p
        }
        3 => {
            let p = spread3(o(0, 8.0)) | spread3(o(1, 8.0)) << 1 | spread3(o(2, 8.0)) << 2;
            let q = spread2(s(0, 32.0)) | spread2(s(1, 32.0)) << 1;
            c << 19 | p << 10 | q
        }
        _ => {
            let p = spread3(o(0, 64.0)) | spread3(o(1, 64.0)) << 1 | spread3(o(2, 64.0)) << 2;
            p << 3 | c
        }
    }
}
