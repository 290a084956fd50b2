//! What the builder of the tree sorts: boxes in lanes.

use crate::lanes::{F, LANES, lesser};
use fearless_simd::prelude::*;
use reflet_pack::{Aabb, Geometry, Slot};

/// A box in lanes: the least x, y, z, a tag, and the greatest, negated, and another tag. A union is
/// one `min`. Of what is in a slot the tags are the slot and its kind, by their bits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Item {
    /// The lanes.
    pub lanes: [f32; LANES],
}

impl Item {
    /// Neutral in a union.
    pub const NOTHING: Item = Item { lanes: [f32::INFINITY; LANES] };
    /// The lane of the first tag.
    pub const SLOT: usize = 3;
    /// The lane of the second.
    pub const KIND: usize = 7;

    /// What is in a slot.
    pub fn new(g: &Geometry, slot: Slot) -> Item {
        let Aabb { lo, hi } = &g.bounds[slot.index()];
        let kind = f32::from_bits(g.shape[slot.index()].0 as u32);
        Item { lanes: [lo[0], lo[1], lo[2], f32::from_bits(slot.0), -hi[0], -hi[1], -hi[2], kind] }
    }

    /// The slot that it is in.
    pub fn slot(&self) -> Slot {
        Slot(self.lanes[Self::SLOT].to_bits())
    }

    /// Its kind, as a number.
    pub fn kind(&self) -> u32 {
        self.lanes[Self::KIND].to_bits()
    }

    /// Of a bin: how many are in it.
    pub fn count(&self) -> usize {
        self.lanes[Self::SLOT].to_bits() as usize
    }

    /// The box.
    pub fn aabb(&self) -> Aabb {
        let r = &self.lanes;
        Aabb { lo: [r[0], r[1], r[2]], hi: [-r[4], -r[5], -r[6]] }
    }

    /// Half the area of the box.
    pub fn area(&self) -> f32 {
        let r = &self.lanes;
        let e = [-(r[0] + r[4]), -(r[1] + r[5]), -(r[2] + r[6])];
        e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
    }

    /// The least box that holds both.
    pub fn union(self, other: Item) -> Item {
        let mut out = self;
        for (to, from) in out.lanes.iter_mut().zip(other.lanes) {
            *to = if from < *to { from } else { *to };
        }
        out
    }

    /// All lanes.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> F<S> {
        F::from_slice(simd, &self.lanes)
    }

    /// From all lanes.
    #[inline(always)]
    pub fn store<S: Simd>(rows: F<S>) -> Item {
        let mut item = Item::NOTHING;
        rows.store_slice(&mut item.lanes);
        item
    }
}

/// Twice the centre, and in the upper half its negative.
#[inline(always)]
pub fn center<S: Simd>(simd: S, rows: F<S>) -> F<S> {
    let (low, high) = simd.split_f32x8(rows);
    rows - simd.combine_f32x4(high, low)
}

/// The union of all boxes.
#[inline(always)]
pub fn boxes<S: Simd>(simd: S, items: &[Item]) -> Item {
    let mut all = Item::NOTHING.load(simd);
    for item in items {
        all = lesser(simd, item.load(simd), all);
    }
    Item::store(all)
}

/// The union of all centres, as [`center`] gives them.
#[inline(always)]
pub fn centers<S: Simd>(simd: S, items: &[Item]) -> Item {
    let mut all = [Item::NOTHING.load(simd); 2];
    let (pairs, rest) = items.as_chunks::<2>();
    for [a, b] in pairs {
        all[0] = lesser(simd, center(simd, a.load(simd)), all[0]);
        all[1] = lesser(simd, center(simd, b.load(simd)), all[1]);
    }
    for item in rest {
        all[0] = lesser(simd, center(simd, item.load(simd)), all[0]);
    }
    Item::store(lesser(simd, all[1], all[0]))
}

/// Copies items to two sides, in their order on both. Sides are looked up, so that nothing is to be
/// predicted.
#[inline(always)]
pub fn deal(from: &[Item], left: &mut [Item], right: &mut [Item], is_left: impl Fn(&Item) -> bool) {
    let mut sides = [(right, 0), (left, 0)];
    for item in from {
        let (side, len) = &mut sides[usize::from(is_left(item))];
        side[*len] = *item;
        *len += 1;
    }
}
