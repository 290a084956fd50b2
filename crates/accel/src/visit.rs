//! What a traversal has still to visit, nearest first.

use crate::tree::Child;

/// Children still to be visited: where the ray enters them, as the upper half, and what they are.
/// An entry is not negative, so its bits are ordered as it is.
pub type Key = u64;

/// The key of a child.
#[inline(always)]
pub fn key(entry: f32, child: Child) -> Key {
    u64::from(entry.to_bits()) << 32 | u64::from(child.0)
}

/// Where the child of a key is entered.
#[inline(always)]
pub fn entry_of(key: Key) -> f32 {
    f32::from_bits((key >> 32) as u32)
}
