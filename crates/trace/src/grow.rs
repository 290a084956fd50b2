//! The first pass: the ray trees of a tile, level by level.

use crate::camera;
use crate::grid::TileRect;
use crate::interact::Interactions;
use crate::lighting;
use crate::mirror;
use crate::palette::{PaletteIndex, Slot};
use crate::trees::{Level, Trees};
use fearless_simd::dispatch;
use reflet_accel::{Accel, Hits, RayCounts, Rays, Scratch};
use reflet_pack::surfaces::Cells;
use reflet_pack::{Columns, LightId};

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

/// Memory of one thread for the first pass, and what it counted.
#[derive(Default)]
pub struct TraceScratch {
    /// Rays by kind.
    pub rays: RayTally,
    /// The same rays, counted where they entered `accel`.
    pub counts: RayCounts,
    stream: Rays,
    next: Rays,
    hits: Hits,
    points: Interactions,
    shadow: Rays,
    shadow_rows: Vec<u16>,
    occluded: Vec<bool>,
    mirror_rows: Vec<u16>,
    totals: Vec<f32>,
    palette: PaletteIndex,
    accel: Scratch,
}

/// What the first pass reads.
pub struct Tracer<'a> {
    /// The scene.
    pub columns: &'a Columns,
    /// The same scene's primitives, to intersect with.
    pub accel: &'a Accel,
}

impl Tracer<'_> {
    /// Makes the ray trees of one sample of a tile from scratch.
    pub fn grow(&self, rect: TileRect, sample: u32, trees: &mut Trees, scratch: &mut TraceScratch) {
        trees.clear();
        scratch.palette.start(&[], self.columns.surfaces.len());
        camera::rays(&self.columns.view, rect, sample, &mut scratch.stream);
        scratch.rays.camera += scratch.stream.len() as u64;
        scratch.totals.clear();
        scratch.totals.resize(scratch.stream.len(), 0.0);
        let mut depth = 0;
        while !scratch.stream.is_empty() {
            if trees.levels.len() == depth {
                trees.levels.push(Level::default());
            }
            self.grow_level(depth, trees, scratch);
            depth += 1;
        }
        trees.levels.truncate(depth);
    }

    /// Intersects the stream, makes its nodes, and leaves the mirrored rays as the next stream.
    fn grow_level(&self, depth: usize, trees: &mut Trees, scratch: &mut TraceScratch) {
        let len = scratch.stream.len();
        let level = &mut trees.levels[depth];
        if depth == 0 {
            level.parent.extend(0..len as u16);
        } else {
            level.parent.extend_from_slice(&scratch.mirror_rows);
        }
        let s = &mut *scratch;
        self.accel.closest(&s.stream, &mut s.hits, &mut s.accel, &mut s.counts);
        dispatch!(self.accel.level(), simd => s.points.find(simd, &self.columns.geometry, &s.stream, &s.hits));
        level.code.extend_from_slice(&s.hits.code[..len]);
        self.place(level, &mut trees.palette, s);
        self.light(level, s);
        self.cast(depth, level, &trees.palette, s);
    }

    /// Path lengths and slots.
    fn place(&self, level: &mut Level, palette: &mut Vec<Slot>, s: &mut TraceScratch) {
        for (row, code) in level.code.iter().enumerate() {
            let Some(prim) = code.prim() else {
                level.slot.push(0);
                level.total.push(1.0);
                continue;
            };
            let surface = self.columns.surface_of(prim);
            let odd = match &self.columns.paint(surface).cells {
                Some(cells) => is_odd(cells, [0, 1, 2].map(|k| s.points.p[k][row])),
                None => false,
            };
            level.slot.push(s.palette.number(Slot { surface, odd }, palette));
            level.total.push(s.totals[row] + s.hits.t[row]);
        }
    }

    /// One column a light.
    fn light(&self, level: &mut Level, s: &mut TraceScratch) {
        let lights = self.columns.lights.len();
        level.light.resize_with(lights, Vec::new);
        for (i, term) in level.light.iter_mut().enumerate() {
            let place = self.columns.light_place(LightId(i as u32));
            dispatch!(self.accel.level(), simd => lighting::aim(
                simd, &place, &s.points, &level.code, term, &mut s.shadow, &mut s.shadow_rows
            ));
            s.rays.shadow += s.shadow.len() as u64;
            self.accel.any(&s.shadow, &mut s.occluded, &mut s.accel, &mut s.counts);
            for (row, hidden) in s.shadow_rows.iter().zip(&s.occluded) {
                if *hidden {
                    term[usize::from(*row)] = 0.0;
                }
            }
        }
    }

    /// The next level's rays.
    fn cast(&self, depth: usize, level: &Level, palette: &[Slot], s: &mut TraceScratch) {
        let model = &self.columns.model;
        s.mirror_rows.clear();
        if depth < model.max_bounces as usize {
            let mirrors = |slot: u16| {
                slot != 0 && {
                    let material = palette[usize::from(slot) - 1].material(self.columns);
                    self.columns.material(material).is_specular()
                }
            };
            let reflects = |row: &u16| {
                let row = usize::from(*row);
                level.total[row] <= model.max_path && mirrors(level.slot[row])
            };
            s.mirror_rows.extend((0..level.len() as u16).filter(reflects));
        }
        s.rays.mirror += s.mirror_rows.len() as u64;
        dispatch!(self.accel.level(), simd => mirror::reflect(
            simd, &s.stream, &s.points, &level.code, &s.mirror_rows, &mut s.next
        ));
        std::mem::swap(&mut s.stream, &mut s.next);
        s.totals.clear();
        s.totals.extend(s.mirror_rows.iter().map(|row| level.total[usize::from(*row)]));
    }
}

/// Whether p lies in a cell whose numbers sum up to an odd one.
fn is_odd(cells: &Cells, p: [f32; 3]) -> bool {
    let way = [p[0] - cells.origin[0], p[1] - cells.origin[1], p[2] - cells.origin[2]];
    let along = |axis: [f32; 3]| way[0] * axis[0] + way[1] * axis[1] + way[2] * axis[2];
    parity((along(cells.x) / cells.size[0]).floor()) ^ parity((along(cells.y) / cells.size[1]).floor())
}

/// Whether a whole number is odd. Beyond 2^24 every `f32` is even.
fn parity(whole: f32) -> bool {
    let half = whole * 0.5;
    half != half.floor()
}

