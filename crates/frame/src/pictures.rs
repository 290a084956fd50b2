//! The pictures under way, used again and again.

use crate::event::RenderError;
use crate::memory;
use reflet_film::{Layout, Picture, SampleKind};
use std::sync::Arc;

/// Pictures of one size: those of a batch, those that wait to be written, and the last one shaded,
/// which the next batch copies from.
pub struct Pictures {
    layout: Layout,
    kind: SampleKind,
    spare: Vec<Arc<Picture>>,
    last: Option<Arc<Picture>>,
    /// How many may still be made.
    left: usize,
    longest_batch: usize,
}

/// More frames at a time gain nothing: by then a tile's trees are read once for many frames.
const LONGEST_BATCH: usize = 16;

impl Pictures {
    /// Room for pictures of `layout`, of which those of more than the least number count against
    /// `budget` bytes.
    ///
    /// # Errors
    /// If not even one frame at a time fits into memory.
    pub fn new(
        layout: Layout,
        kind: SampleKind,
        frames: usize,
        budget: u64,
    ) -> Result<Self, RenderError> {
        let bytes = layout.len() as u64 * kind.bytes() as u64;
        // Beside a picture stand its rows as the encoder keeps them, and the file.
        let least = bytes.saturating_mul(3);
        let available = memory::available().unwrap_or(u64::MAX);
        if least > available {
            return Err(RenderError::Memory { needed: least, available });
        }
        // A batch is written while the next one is shaded, and one picture more is copied from.
        let room = (budget / 2 / bytes.max(1)).saturating_sub(1) / 2;
        let longest_batch = (room as usize).clamp(1, LONGEST_BATCH.min(frames.max(1)));
        let first = Picture::try_new(layout, kind)
            .map_err(|e| RenderError::Memory { needed: e.bytes as u64, available })?;
        let few = bytes.saturating_mul(5) > available / 2;
        let left = if few { 1 } else { 2 * longest_batch };
        Ok(Pictures { layout, kind, spare: vec![Arc::new(first)], last: None, left, longest_batch })
    }

    /// How many frames may be shaded at a time.
    pub fn longest_batch(&self) -> usize {
        self.longest_batch
    }

    /// Bytes of all pictures, once they are made, and of what the encoder keeps beside them.
    pub fn bytes(&self) -> u64 {
        let all = self.left + self.spare.len() + 2;
        all as u64 * self.layout.len() as u64 * self.kind.bytes() as u64
    }

    /// A picture to shade into; `None` if all are under way.
    pub fn take(&mut self) -> Option<Picture> {
        let free = self.spare.iter().position(|p| Arc::strong_count(p) == 1);
        if let Some(picture) = free.and_then(|i| Arc::into_inner(self.spare.swap_remove(i))) {
            return Some(picture);
        }
        if self.left > 0 {
            if let Ok(picture) = Picture::try_new(self.layout, self.kind) {
                self.left -= 1;
                return Some(picture);
            }
            self.left = 0;
        }
        None
    }

    /// Takes back a picture that was written.
    pub fn give_back(&mut self, picture: Arc<Picture>) {
        self.spare.push(picture);
    }

    /// The last picture shaded.
    pub fn last(&self) -> Option<Arc<Picture>> {
        self.last.clone()
    }

    /// Remembers the last picture shaded, for the next batch to copy from.
    pub fn set_last(&mut self, picture: &Arc<Picture>) {
        self.last = Some(picture.clone());
    }

    /// Lets go of the last picture, so that it can be shaded into.
    pub fn forget_last(&mut self) {
        self.last = None;
    }
}
