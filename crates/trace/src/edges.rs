//! Where a picture has edges: the pixels that are worth more than one sample.
//!
//! A pixel has one where its ray tree differs in kind from that of a neighbour: in what it hit, in
//! the pattern's cell, or in which lights reach it, at any level; and wherever it meets a texture, a
//! shader or a projector's picture. Chosen by trees as they would be made from scratch, never by
//! colour, so that the choice can be kept with them and does not flicker.

use crate::grid::TileRect;
use crate::grow::Tracer;
use crate::trees::Trees;

/// Memory of one thread for finding edges.
#[derive(Default)]
pub struct EdgeScratch {
    /// Of each pixel, what its tree is like.
    kinds: Vec<u64>,
    /// The pixel that each node of a level belongs to, and of the level above.
    pixels: [Vec<u16>; 2],
}

/// The kind of a tree that has an edge wherever it is.
const EDGE: u64 = u64::MAX;

/// In place of the pixel of a node that a tree made from scratch would not have.
const NO_PIXEL: u16 = u16::MAX;

impl TileRect {
    /// The same with a border of one pixel, as far as a picture of `size` goes.
    pub fn with_apron(&self, size: [u32; 2]) -> TileRect {
        let (x, y) = (self.x.saturating_sub(1), self.y.saturating_sub(1));
        let right = (self.x + self.width + 1).min(size[0]);
        let lower = (self.y + self.height + 1).min(size[1]);
        TileRect { x, y, width: right - x, height: lower - y }
    }

    /// Pairs of a row of trees over `self` and the pixel of `inner`, which lies inside, that it is.
    pub fn rows_of(&self, inner: TileRect) -> impl Iterator<Item = (u16, u16)> + Clone + use<> {
        let wide = *self;
        (0..inner.height).flat_map(move |y| {
            (0..inner.width).map(move |x| {
                let row = (inner.y - wide.y + y) * wide.width + inner.x - wide.x + x;
                (row as u16, (y * inner.width + x) as u16)
            })
        })
    }
}

impl Tracer<'_> {
    /// The pixels of `inner` that have an edge, ascending; `trees` are those of `wide`, which has an
    /// apron around it.
    pub fn edges(
        &self,
        trees: &Trees,
        (wide, inner): (TileRect, TileRect),
        s: &mut EdgeScratch,
    ) -> Vec<u16> {
        self.find_kinds(trees, wide.pixels(), s);
        let (width, height) = (wide.width as usize, wide.height as usize);
        let has_edge = |row: usize| {
            let (x, y) = (row % width, row / width);
            let own = s.kinds[row];
            let around = |i: usize, n: usize| i.saturating_sub(1)..(i + 2).min(n);
            own == EDGE
                || around(y, height)
                    .any(|y| around(x, width).any(|x| s.kinds[y * width + x] != own))
        };
        let rows = wide.rows_of(inner).filter(|(row, _)| has_edge(usize::from(*row)));
        rows.map(|(_, pixel)| pixel).collect()
    }

    fn find_kinds(&self, trees: &Trees, pixels: usize, s: &mut EdgeScratch) {
        s.kinds.clear();
        s.kinds.resize(pixels, 0);
        let [above, own] = &mut s.pixels;
        above.clear();
        for (depth, level) in trees.levels.iter().enumerate() {
            own.clear();
            own.extend(level.parent.iter().map(|parent| match depth.checked_sub(1) {
                None => *parent,
                // Kept trees may have nodes below one that reflects no longer.
                Some(up) if !self.reflects(trees, up, usize::from(*parent)) => NO_PIXEL,
                Some(_) => above[usize::from(*parent)],
            }));
            for (row, pixel) in own.iter().enumerate().filter(|(_, pixel)| **pixel != NO_PIXEL) {
                let kind = &mut s.kinds[usize::from(*pixel)];
                let slot = level.slot[row];
                let tinted = slot != 0 && {
                    let surface = trees.palette[usize::from(slot) - 1].surface;
                    self.columns.paint(surface).tint.is_some()
                };
                let lights = level.light.iter().zip(&self.columns.lights.slide);
                let pictured =
                    lights.clone().any(|(terms, slide)| slide.is_some() && terms[row] != 0.0);
                if tinted || pictured || *kind == EDGE {
                    *kind = EDGE;
                    continue;
                }
                let mut own = mix(*kind, u64::from(slot));
                own = mix(own, u64::from(self.face(level.code[row])));
                own = mix(own, u64::from(level.cell.get(row).copied().unwrap_or_default()));
                for (terms, _) in lights {
                    own = mix(own, u64::from(terms[row] != 0.0));
                }
                // A kind of its own stands for edges.
                *kind = own & (EDGE >> 1);
            }
            std::mem::swap(above, own);
        }
    }

    /// Which face of its surface was hit, and from which side; all triangles of a mesh are one.
    fn face(&self, code: reflet_accel::HitCode) -> u32 {
        let Some(prim) = code.prim() else { return 0 };
        let surface = self.columns.surface_of(prim).index();
        if self.columns.surfaces.mesh[surface].is_some() { 1 } else { code.0 }
    }
}

/// One step of a hash (the finaliser of splitmix64, Steele et al., "Fast Splittable Pseudorandom
/// Number Generators", OOPSLA 2014).
fn mix(hash: u64, value: u64) -> u64 {
    let z = (hash ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
