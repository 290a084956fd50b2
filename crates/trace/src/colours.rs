//! What only shading reads, for each frame of a batch.

use reflet_pack::materials::{MaterialRow, Rgb};
use reflet_pack::{Attenuation, Changes, Columns, LightId, MaterialChange, MaterialId};

/// The colours of frames that share their ray trees, in order: a batch.
///
/// The first frame may differ in any way from what came before it; later ones only as
/// [`reflet_pack::Packer::only_recolours`] allows.
#[derive(Clone, Debug, Default)]
pub struct BatchColours {
    frames: Vec<FrameColours>,
}

/// The colours of one frame.
#[derive(Clone, Debug)]
struct FrameColours {
    settings: FrameSettings,
    /// What differs from the batch's frame before.
    materials: Vec<MaterialChange>,
}

/// The colours that any node may take part in.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrameSettings {
    pub background: Rgb,
    pub attenuation: Attenuation,
    pub emissivity: Vec<Rgb>,
}

impl BatchColours {
    /// A batch of one frame: `columns` as they are.
    pub fn of(columns: &Columns) -> BatchColours {
        let mut batch = BatchColours::default();
        batch.push(columns, &Changes::default());
        batch
    }

    /// Adds a frame with the colours of `columns`; `changes` is how these differ from the frame
    /// added before.
    pub fn push(&mut self, columns: &Columns, changes: &Changes) {
        let emissivity = |i| columns.emissivity(LightId(i));
        let settings = FrameSettings {
            background: columns.model.background,
            attenuation: columns.model.attenuation,
            emissivity: (0..columns.lights.len() as u32).map(emissivity).collect(),
        };
        // What leads to the first frame is no part of the batch.
        let materials = if self.is_empty() { Vec::new() } else { changes.materials.clone() };
        self.frames.push(FrameColours { settings, materials });
    }

    /// How many frames there are.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// The most bytes that the batch's materials take once they are laid out frame by frame.
    pub fn bytes(&self) -> u64 {
        let changes: usize = self.frames.iter().map(|f| f.materials.len()).sum();
        let laid_out = self.frames.len() * size_of::<MaterialRow>() + size_of::<MaterialChange>();
        (changes * laid_out) as u64
    }

    pub(crate) fn settings(&self, frame: usize) -> &FrameSettings {
        &self.frames[frame].settings
    }
}

/// The rows that materials have in each frame of a batch.
pub(crate) struct MaterialsByFrame {
    /// Materials that change within the batch, ascending.
    changed: Vec<MaterialId>,
    /// Their rows, a list a frame.
    rows: Vec<Vec<MaterialRow>>,
}

impl MaterialsByFrame {
    pub fn new(batch: &BatchColours) -> MaterialsByFrame {
        let all = || batch.frames.iter().flat_map(|f| &f.materials);
        let mut changed: Vec<MaterialId> = all().map(|c| c.material).collect();
        changed.sort_unstable();
        changed.dedup();
        let mut now = vec![None; changed.len()];
        let index = |id: &MaterialId| changed.partition_point(|c| c < id);
        for change in all() {
            let row = &mut now[index(&change.material)];
            *row = row.or(change.old);
        }
        let rows = batch.frames.iter().map(|frame| {
            for change in &frame.materials {
                now[index(&change.material)] = change.new;
            }
            now.iter().map(|row| row.unwrap_or_default()).collect()
        });
        let rows = rows.collect();
        MaterialsByFrame { changed, rows }
    }

    /// Where a material stands among those that change.
    pub fn find(&self, id: MaterialId) -> Option<u32> {
        self.changed.binary_search(&id).ok().map(|i| i as u32)
    }

    /// The row of the `i`-th changing material in a frame.
    pub fn row(&self, frame: usize, i: u32) -> &MaterialRow {
        &self.rows[frame][i as usize]
    }
}
