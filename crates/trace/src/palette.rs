//! The surfaces that a tile sees, numbered as they are first met.

use reflet_pack::{Columns, MaterialId, SurfaceId};

/// A surface and the parity of its pattern's cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Slot {
    /// The surface.
    pub surface: SurfaceId,
    /// Whether the cell's two numbers sum up to an odd one.
    pub odd: bool,
}

impl Slot {
    /// What is worn there today.
    pub fn material(&self, columns: &Columns) -> MaterialId {
        let paint = columns.paint(self.surface);
        if self.odd { paint.odd } else { paint.even }
    }
}

/// Numbers for slots: a table over all surfaces whose entries count only for the current tile.
#[derive(Default)]
pub struct PaletteIndex {
    round: u32,
    table: Vec<(u32, u16)>,
}

impl PaletteIndex {
    /// Starts over with `palette`, for a scene of `surfaces`.
    pub fn start(&mut self, palette: &[Slot], surfaces: usize) {
        if self.table.len() < 2 * surfaces || self.round == u32::MAX {
            self.table.clear();
            self.table.resize(2 * surfaces, (0, 0));
            self.round = 0;
        }
        self.round += 1;
        for (i, slot) in palette.iter().enumerate() {
            self.table[Self::entry(slot)] = (self.round, i as u16 + 1);
        }
    }

    /// The number of `slot`, appended to `palette` if it is new; never 0.
    pub fn number(&mut self, slot: Slot, palette: &mut Vec<Slot>) -> u16 {
        let entry = &mut self.table[Self::entry(&slot)];
        if entry.0 != self.round {
            palette.push(slot);
            *entry = (self.round, palette.len() as u16);
        }
        entry.1
    }

    fn entry(slot: &Slot) -> usize {
        2 * slot.surface.index() + usize::from(slot.odd)
    }
}
