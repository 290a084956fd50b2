//! Nodes as columns, level by level.

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
    /// One column a light: cos / r, or 0 in shadow.
    pub light: Vec<Vec<f32>>,
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
        for column in &mut self.light {
            column.clear();
        }
    }

    /// The bytes that its columns hold.
    pub fn bytes(&self) -> usize {
        self.len() * (4 + 2 + 4 + 2 + 4 * self.light.len())
    }
}

/// The ray trees of one sample of one tile.
#[derive(Clone, Debug, Default)]
pub struct Trees {
    /// From the camera rays downward. The last may be empty.
    pub levels: Vec<Level>,
    /// Which surfaces the nodes lie on: `slot - 1` is the index here.
    pub palette: Vec<Slot>,
}

impl Trees {
    /// Empties the trees, keeping their memory.
    pub fn clear(&mut self) {
        self.levels.iter_mut().for_each(Level::clear);
        self.palette.clear();
    }

    /// How many nodes there are on all levels.
    pub fn nodes(&self) -> usize {
        self.levels.iter().map(Level::len).sum()
    }

    /// The bytes that all columns hold.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(Level::bytes).sum::<usize>() + self.palette.len() * size_of::<Slot>()
    }

    /// Whether any node lies on `surface`.
    pub fn sees(&self, surface: SurfaceId) -> bool {
        self.palette.iter().any(|slot| slot.surface == surface)
    }
}
