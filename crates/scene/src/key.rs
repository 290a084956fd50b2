//! Identity and order of making.

/// The stable identity of an entity: its place in the order in which the script made things.
///
/// Keys count up from 0 and are never used twice while a script's own entities live. Entities made
/// in a frame get the keys after the script's own, and give them back when the frame is over. A tie
/// between two surfaces goes to the lower key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub u32);

impl Key {
    /// The key as an index into per-entity tables.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
