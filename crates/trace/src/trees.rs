//! Nodes as columns, level by level.

use crate::capsule::Capsules;
use crate::palette::Slot;
use reflet_accel::HitCode;
use reflet_pack::SurfaceId;

/// One level of the ray trees of a tile: level 0 has a node a pixel, row by row; level k + 1 has a
/// node for each mirrored ray of level k. Columns have `len` rows.
#[derive(Clone, Debug, Default)]
pub struct Level {
    /// What was hit and from which side; none: a miss.
    pub code: Vec<HitCode>,
    /// Surface and pattern cell, as an index into [`Trees::palette`]; 0 for a miss.
    pub slot: Vec<u16>,
    /// The length of the path from the eye to the hit, over all bounces; 1 for a miss.
    pub total: Vec<f32>,
    /// The node of the level above whose ray this is; at level 0 its pixel.
    pub parent: Vec<u16>,
    /// One column a light: cos / r; 0 where the light is behind the surface or does not shine
    /// there, and -0 where something stands before it.
    pub light: Vec<Vec<f32>>,
    /// What pictures and expressions say there, a column a number; see
    /// [`reflet_pack::surfaces::Surfaces::tint_channels`].
    pub tint: Vec<Vec<f32>>,
    /// Which cell of its surface's pattern each lies in, as a hash. Empty unless samples are spent at
    /// edges.
    pub cell: Vec<u32>,
    /// Where the ray ended, as three columns: the hit point, or a miss's unit direction. Empty
    /// unless the trees keep their points.
    pub at: [Vec<f32>; 3],
    /// How far from there shadow rays may leave, at most: see [`crate::interact::Interactions::lift`].
    /// Empty unless the trees keep their points.
    pub lift: Vec<f32>,
    /// Chunks of the rays as capsules; none unless the trees keep their points.
    pub capsules: Capsules,
}

/// Whether trees keep where their rays ended: 12 bytes a node, of use only where surfaces move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Points {
    /// They can be found again by replaying.
    #[default]
    Dropped,
    /// They are kept.
    Kept,
}

impl Level {
    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.code.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.code.is_empty()
    }

    pub(crate) fn clear(&mut self) {
        self.code.clear();
        self.slot.clear();
        self.total.clear();
        self.parent.clear();
        self.cell.clear();
        self.floats().for_each(Vec::clear);
    }

    /// Takes the marked rows out.
    pub(crate) fn remove(&mut self, marked: &[bool]) {
        remove(&mut self.code, marked);
        remove(&mut self.slot, marked);
        remove(&mut self.total, marked);
        remove(&mut self.parent, marked);
        remove(&mut self.cell, marked);
        self.floats().for_each(|column| remove(column, marked));
    }

    /// Replaces a row, but for its parent, by a row of another level with the same columns.
    pub(crate) fn replace(&mut self, row: usize, by: &Level, from: usize) {
        self.code[row] = by.code[from];
        self.slot[row] = by.slot[from];
        self.total[row] = by.total[from];
        if let (Some(cell), Some(new)) = (self.cell.get_mut(row), by.cell.get(from)) {
            *cell = *new;
        }
        let new = by.light.iter().chain(&by.tint).chain(&by.at).chain([&by.lift]);
        for (column, new) in self.floats().zip(new) {
            column[row] = new[from];
        }
    }

    /// Appends all rows of another level with the same columns.
    pub(crate) fn append(&mut self, other: &Level, parent: impl Fn(u16) -> u16) {
        self.code.extend_from_slice(&other.code);
        self.slot.extend_from_slice(&other.slot);
        self.total.extend_from_slice(&other.total);
        self.parent.extend(other.parent.iter().map(|p| parent(*p)));
        self.cell.extend_from_slice(&other.cell);
        self.light.resize_with(other.light.len(), Vec::new);
        self.tint.resize_with(other.tint.len(), Vec::new);
        let new = other.light.iter().chain(&other.tint).chain(&other.at).chain([&other.lift]);
        for (column, new) in self.floats().zip(new) {
            column.extend_from_slice(new);
        }
    }

    /// All columns of floats but for the lengths of paths.
    fn floats(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        self.light.iter_mut().chain(&mut self.tint).chain(&mut self.at).chain([&mut self.lift])
    }

    /// The bytes that it takes: its columns, and for each of them the allocator's own.
    pub fn bytes(&self) -> usize {
        const ALLOCATION: usize = 16;
        let nested = self.light.len() + self.tint.len();
        let columns =
            4 + nested + self.at.iter().chain([&self.lift]).filter(|c| !c.is_empty()).count();
        let own = size_of::<Level>() + nested * size_of::<Vec<f32>>();
        own + columns * ALLOCATION + self.cells() + self.capsules.bytes()
    }

    fn cells(&self) -> usize {
        let points = self.at.iter().chain([&self.lift]).map(Vec::len).sum::<usize>();
        let points = (points + self.cell.len()) * 4;
        self.len() * (4 + 2 + 4 + 2 + 4 * (self.light.len() + self.tint.len())) + points
    }
}

fn remove<T>(column: &mut Vec<T>, marked: &[bool]) {
    let mut rows = marked.iter();
    column.retain(|_| !rows.next().copied().unwrap_or(false));
}

/// The ray trees of one sample of one tile.
#[derive(Clone, Debug, Default)]
pub struct Trees {
    /// From the camera rays downward. The last may be empty.
    pub levels: Vec<Level>,
    /// Which surfaces the nodes lie on: `slot - 1` is the index here.
    pub palette: Vec<Slot>,
    /// Whether the levels keep where rays ended.
    pub points: Points,
}

impl Trees {
    /// Empties the trees, keeping their memory.
    pub fn clear(&mut self) {
        self.levels.iter_mut().for_each(Level::clear);
        self.palette.clear();
    }

    /// Makes as many columns of light terms as there are lights; new ones are dark.
    pub(crate) fn fit_lights(&mut self, lights: usize) {
        for level in &mut self.levels {
            let len = level.len();
            level.light.resize_with(lights, Vec::new);
            level.light.iter_mut().for_each(|terms| terms.resize(len, 0.0));
        }
    }

    /// How many nodes there are on all levels.
    pub fn nodes(&self) -> usize {
        self.levels.iter().map(Level::len).sum()
    }

    /// The bytes that all levels take.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(Level::bytes).sum::<usize>() + self.palette.len() * size_of::<Slot>()
    }

    /// Whether any node lies on `surface`.
    pub fn sees(&self, surface: SurfaceId) -> bool {
        self.palette.iter().any(|slot| slot.surface == surface)
    }
}
