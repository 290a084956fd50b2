//! Primitives that moved: their lanes and boxes are written anew, and the boxes above them; the
//! tree's shape stays until it has become a bad one.

use crate::blocks::Blocks;
use crate::lanes::LANES;
use crate::rays::HitCode;
use crate::tree::Tree;
use reflet_pack::{Geometry, SHAPE_KINDS, ShapeKind, Slot};
use std::collections::BTreeSet;

/// What became of a structure whose primitives moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refit {
    /// Only what moved, and the boxes above it, was written.
    Refitted,
    /// It was built again: primitives were added, removed, of another kind or visible for the first
    /// time, most of very many had moved, or the boxes had grown too large.
    Rebuilt,
}

/// Boxes that have grown to this many times their area are worth a new tree.
pub const WORN: f32 = 1.5;

/// Where what is in each slot is, and what is above each block and node.
pub struct Places {
    /// By slot: eight times the block's index plus the lane, [`IN_LIST`] set if the block is
    /// the list's; [`NOWHERE`] if it was invisible.
    slot: Vec<u32>,
    /// By kind and block of the leaves: the node's index times eight plus the lane.
    leaf: [Vec<u32>; SHAPE_KINDS],
    /// The same by node; that of the root means nothing.
    node: Vec<u32>,
}

const IN_LIST: u32 = 1 << 31;
const NOWHERE: u32 = u32::MAX;

impl Places {
    /// Finds them for structures that were built from `g`.
    pub fn find(g: &Geometry, list: &Blocks, leaves: &Blocks, tree: &Tree) -> Places {
        let mut places = Places {
            slot: vec![NOWHERE; g.len()],
            leaf: ShapeKind::ALL.map(|kind| vec![0; leaves.len(kind)]),
            node: vec![0; tree.nodes.len()],
        };
        for (blocks, flag) in [(list, IN_LIST), (leaves, 0)] {
            for kind in ShapeKind::ALL {
                for block in 0..blocks.len(kind) {
                    for (lane, code) in blocks.codes(kind, block).iter().enumerate() {
                        if let Some(prim) = HitCode(*code).prim() {
                            let (slot, _) = g.slot_of(prim);
                            places.slot[slot.index()] = (block * LANES + lane) as u32 | flag;
                        }
                    }
                }
            }
        }
        for (index, node) in tree.nodes.iter().enumerate() {
            for (lane, child) in (0..LANES).map(|lane| (lane, node.child(lane))) {
                let above = (index * LANES + lane) as u32;
                match child.target() {
                    _ if child.is_none() => {}
                    Ok(node) => places.node[node] = above,
                    Err((kind, block)) => places.leaf[kind as usize][block] = above,
                }
            }
        }
        places
    }

    /// Writes `moved` where they are, and the boxes above them. `false`, and an unknown part of it
    /// done, if that cannot be.
    pub fn refit(
        &self,
        g: &Geometry,
        moved: &[Slot],
        (list, leaves, tree): (&mut Blocks, &mut Blocks, &mut Tree),
    ) -> bool {
        let mut dirty = BTreeSet::new();
        for slot in moved {
            let Some(place) = self.slot.get(slot.index()).copied() else { return false };
            if place == NOWHERE {
                if g.is_visible(*slot) {
                    return false;
                }
                continue;
            }
            let (kind, blocks) = (
                g.shape[slot.index()].0,
                if place & IN_LIST == 0 { &mut *leaves } else { &mut *list },
            );
            let at = (place & !IN_LIST) as usize;
            let (block, lane) = (at / LANES, at % LANES);
            let is_same = block < blocks.len(kind)
                && blocks.codes(kind, block)[lane] == HitCode::outside(g.first_prim(*slot)).0
                && (kind != ShapeKind::Copy || blocks.copies[block].is_of(g, *slot));
            if !is_same {
                return false;
            }
            blocks.set(kind, block, lane, g, *slot);
            if place & IN_LIST == 0 {
                let above = self.leaf[kind as usize][block] as usize;
                let (node, lane) = (above / LANES, above % LANES);
                tree.nodes[node].set_bounds(lane, &leaves.bounds(kind, block));
                dirty.insert(node);
            }
        }
        // Nodes stand before those below them: from the last to the first.
        while let Some(node) = dirty.pop_last() {
            tree.nodes[node].set_order();
            if node == 0 {
                break;
            }
            let (bounds, above) = (tree.nodes[node].union(), self.node[node] as usize);
            tree.nodes[above / LANES].set_bounds(above % LANES, &bounds);
            dirty.insert(above / LANES);
        }
        tree.measure();
        true
    }
}
