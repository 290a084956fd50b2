//! One tile of a batch of frames: its trees brought up to date, and its pixels in every frame.

use crate::reuse::{Keep, Plan};
use reflet_film::{Picture, TileMut, TransferTable};
use reflet_pack::Spread;
use reflet_trace::edges::EdgeScratch;
use reflet_trace::touch::TouchScratch;
use reflet_trace::{Grid, ShadeScratch, Shader, TileRect, TraceScratch, Tracer, Trees};
use std::sync::atomic::{AtomicU64, Ordering};

/// The trees of one tile, one for each of [`reflet_pack::Columns::positions`]; none if there was no
/// room.
#[derive(Default)]
pub(crate) struct KeptTile {
    samples: Vec<Trees>,
    /// Where samples are spent at edges: the pixels that have one, ascending.
    edges: Vec<u16>,
}

impl KeptTile {
    fn bytes(&self) -> u64 {
        let edges = 2 * self.edges.len() as u64;
        self.samples.iter().map(|t| t.bytes() as u64).sum::<u64>() + edges
    }
}

/// The room for kept trees: bytes in use, if trees are kept at all, and how many there may be.
pub(crate) struct Room<'a> {
    pub used: Option<&'a AtomicU64>,
    pub budget: u64,
}

impl Room<'_> {
    /// Counts a tile that took `before` bytes. Trees that grew beyond the room, by levels or points,
    /// are let go: they have been shaded.
    fn count(&self, before: u64, kept: &mut KeptTile) {
        let Some(used) = self.used else { return };
        // Wraps where it shrinks: the sum is right.
        let grown = kept.bytes().wrapping_sub(before);
        let now = used.fetch_add(grown, Ordering::Relaxed).wrapping_add(grown);
        if now > self.budget && !kept.samples.is_empty() {
            used.fetch_sub(kept.bytes(), Ordering::Relaxed);
            kept.samples = Vec::new();
        }
    }
}

/// What a tile is made of.
pub(crate) struct Tiler<'a> {
    pub plan: &'a Plan,
    pub tracer: Tracer<'a>,
    pub shader: Shader<'a>,
    pub table: &'a TransferTable,
    /// The picture before the batch's first, if it is at hand.
    pub last: Option<&'a Picture>,
    pub grid: Grid,
    pub room: Room<'a>,
}

/// Memory of one thread, and what it counted.
#[derive(Default)]
pub(crate) struct Worker {
    pub retraced_pixels: u64,
    /// Tiles shaded rather than copied from the frame before, by frame of the batch.
    pub shaded_tiles: Vec<u64>,
    pub trace: TraceScratch,
    pub shade: ShadeScratch,
    touch: TouchScratch,
    edges: EdgeScratch,
    trees: Trees,
}

/// Whether a tile's pixels can differ from those of the frame before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pixels {
    Same,
    MayDiffer,
}

impl Worker {
    /// Makes a tile in every frame of the batch: `frames` has it in each picture.
    pub fn tile(&mut self, tiler: &Tiler<'_>, kept: &mut KeptTile, frames: &mut [TileMut<'_>]) {
        let Some(index) = frames.first().map(|tile| tile.index) else { return };
        let rect = tiler.grid.rect(index);
        self.shaded_tiles.resize(frames.len(), 0);
        let before = kept.bytes();
        let first = match tiler.tracer.columns.spread {
            Spread::Everywhere => self.trees_of(tiler, rect, kept),
            Spread::Edges => self.trees_at_edges(tiler, rect, kept),
        };
        tiler.room.count(before, kept);
        let same = tiler.last.filter(|_| first == Pixels::Same);
        for frame in 0..frames.len() {
            let (done, rest) = frames.split_at_mut(frame);
            let tile = &mut rest[0];
            match (done.last(), same) {
                (None, Some(last)) => tile.copy_from_picture(last),
                (Some(before), _) if !tiler.shader.is_recoloured(frame, &self.shade) => {
                    tile.copy_from(before);
                }
                _ => {
                    let place = (rect, tiler.grid.edge);
                    let colours = tiler.shader.finish(frame, place, &mut self.shade);
                    tiler.table.encode_tile(colours, &mut tile.samples);
                    self.shaded_tiles[frame] += 1;
                }
            }
        }
    }

    /// Brings the trees of a tile up to date, all samples of them, and adds their colours; tells about
    /// the pixels of the batch's first frame.
    fn trees_of(&mut self, tiler: &Tiler<'_>, rect: TileRect, kept: &mut KeptTile) -> Pixels {
        let Tiler { tracer, shader, room, .. } = tiler;
        shader.begin(&mut self.shade);
        let mut pixels = Pixels::MayDiffer;
        if let (Plan::Keep(keep), false) = (tiler.plan, kept.samples.is_empty()) {
            if tiler.last.is_some() {
                pixels = Pixels::Same;
            }
            for (sample, trees) in kept.samples.iter_mut().enumerate() {
                let updated = self.update(keep, tracer, (rect, sample as u32), trees);
                if updated == Pixels::MayDiffer || keep.recolours(trees, tracer.columns) {
                    pixels = Pixels::MayDiffer;
                }
            }
            // Not a look at any node where nothing differs in the whole batch.
            let asleep = |trees: &Trees| !shader.recolours(trees);
            if pixels == Pixels::Same && kept.samples.iter().all(asleep) {
                return pixels;
            }
            for trees in &kept.samples {
                shader.add(trees, &mut self.shade);
            }
            return pixels;
        }
        // Only a whole tile is kept; all of its samples or none.
        kept.samples.clear();
        let mut keeps = room.used.is_some();
        let mut grown = 0;
        self.retraced_pixels += rect.pixels() as u64;
        for sample in 0..tracer.columns.positions.len() as u32 {
            tracer.grow(rect, sample, &mut self.trees, &mut self.trace);
            shader.add(&self.trees, &mut self.shade);
            grown += self.trees.bytes() as u64;
            let used = room.used.map_or(0, |b| b.load(Ordering::Relaxed));
            keeps &= used.saturating_add(grown) <= room.budget;
            if keeps {
                kept.samples.push(self.trees.clone());
            } else {
                kept.samples.clear();
            }
        }
        pixels
    }

    /// The same where samples are spent at edges: trees at the pixels' centres, which tell where edges
    /// are and are shown where there is none, then those of the samples of pixels with an edge. The
    /// trees at centres have an apron of a pixel, so that edges do not depend on where tiles end.
    fn trees_at_edges(&mut self, tiler: &Tiler<'_>, rect: TileRect, kept: &mut KeptTile) -> Pixels {
        let Tiler { tracer, shader, room, .. } = tiler;
        let (samples, pixels) = (tracer.columns.positions.len(), rect.pixels());
        let wide = rect.with_apron(tracer.columns.view.size);
        shader.begin(&mut self.shade);
        let mut changed = Pixels::MayDiffer;
        match tiler.plan {
            Plan::Keep(keep) if !kept.samples.is_empty() => {
                if tiler.last.is_some() {
                    changed = Pixels::Same;
                }
                let updated = self.update(keep, tracer, (wide, 0), &mut kept.samples[0]);
                let toggles = keep.toggles(&kept.samples[0], tracer.columns);
                if updated == Pixels::MayDiffer || toggles {
                    changed = Pixels::MayDiffer;
                    let edges = tracer.edges(&kept.samples[0], (wide, rect), &mut self.edges);
                    if edges != kept.edges {
                        kept.samples.truncate(1);
                        kept.edges = edges;
                    }
                }
                for sample in 1..kept.samples.len() {
                    let trees = &mut kept.samples[sample];
                    let updated = self.update(keep, tracer, (rect, sample as u32), trees);
                    if updated == Pixels::MayDiffer {
                        changed = Pixels::MayDiffer;
                    }
                }
                let recolours = |trees: &Trees| keep.recolours(trees, tracer.columns);
                if kept.samples.iter().any(recolours) {
                    changed = Pixels::MayDiffer;
                }
            }
            _ => kept.samples.clear(),
        }
        let wanted = |edges: &[u16]| if edges.is_empty() { 1 } else { samples };
        let whole = !kept.samples.is_empty() && kept.samples.len() >= wanted(&kept.edges);
        kept.samples.truncate(wanted(&kept.edges));
        let asleep = |trees: &Trees| !shader.recolours(trees);
        if changed == Pixels::Same && whole && kept.samples.iter().all(asleep) {
            return changed;
        }
        let mut keeps = room.used.is_some();
        let mut grown = 0;
        let mut sample = 0;
        loop {
            let known = sample < kept.samples.len();
            if !known {
                changed = Pixels::MayDiffer;
                match sample {
                    0 => {
                        tracer.grow(wide, 0, &mut self.trees, &mut self.trace);
                        kept.edges = tracer.edges(&self.trees, (wide, rect), &mut self.edges);
                        self.retraced_pixels += pixels as u64;
                    }
                    _ => {
                        let place = (rect, sample as u32);
                        tracer.grow_at(place, &kept.edges, &mut self.trees, &mut self.trace);
                    }
                }
            }
            let trees = if known { &kept.samples[sample] } else { &self.trees };
            if sample == 0 {
                let rows = wide.rows_of(rect);
                let rows = rows.filter(|(_, pixel)| kept.edges.binary_search(pixel).is_err());
                shader.add_at(trees, (rows, pixels), &mut self.shade);
            } else {
                let edges = kept.edges.iter().copied().enumerate();
                let rows = edges.map(|(row, pixel)| (row as u16, pixel));
                shader.add_at(trees, (rows, pixels), &mut self.shade);
            }
            if !known {
                grown += self.trees.bytes() as u64;
                let used = room.used.map_or(0, |b| b.load(Ordering::Relaxed));
                keeps &= used.saturating_add(grown) <= room.budget;
                if keeps && kept.samples.len() == sample {
                    kept.samples.push(self.trees.clone());
                }
            }
            sample += 1;
            if sample >= wanted(&kept.edges) {
                break;
            }
        }
        // Only a whole tile is kept; all of its samples or none.
        if kept.samples.len() < wanted(&kept.edges) {
            kept.samples.clear();
        }
        changed
    }

    fn update(
        &mut self,
        keep: &Keep,
        tracer: &Tracer<'_>,
        (rect, sample): (TileRect, u32),
        trees: &mut Trees,
    ) -> Pixels {
        let mut pixels = Pixels::Same;
        if let Some(moved) = &keep.moved {
            let scratch = (&mut self.trace, &mut self.touch);
            let relit = &keep.revision.relight;
            let retraced = tracer.retrace((rect, sample), moved, relit, trees, scratch);
            self.retraced_pixels += retraced as u64;
            if retraced > 0 {
                pixels = Pixels::MayDiffer;
            }
        }
        let deepens =
            keep.may_deepen(trees, tracer.columns) && tracer.lacks_levels(trees, &mut self.trace);
        if deepens || keep.revises() {
            tracer.revise((rect, sample), trees, &keep.revision, &mut self.trace);
            pixels = Pixels::MayDiffer;
        }
        pixels
    }
}
