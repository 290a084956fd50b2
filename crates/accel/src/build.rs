//! The tree by binned surface area, straight into nodes of eight: of the branches that a node has
//! so far the largest is split in two, until there are eight or none is left to split.
//!
//! Boxes are eight floats, the greatest negated, so that a union is one `min` in lanes. Large
//! branches are binned and sorted on all threads; what comes out never depends on how many there
//! are, since unions and counts do not depend on their order, and parts are joined in a fixed one.

use crate::blocks::{Blocks, Leaf};
use crate::copies::{MeshTrees, stands_alone};
use crate::lanes::{F, LANES, lesser};
use crate::prefetch::prefer_large_pages;
use crate::tree::{Child, Node, Tree};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use reflet_pack::{Aabb, Geometry, SHAPE_KINDS, ShapeKind, Slot};

/// How much a tree is worth. The answer does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Quality {
    /// 8 bins: a little sooner made than [`Quality::Balanced`].
    Fast,
    /// 16 bins, and 8 for branches of less than 64 primitives.
    #[default]
    Balanced,
    /// 32 bins: some percent less expected cost at most.
    High,
}

impl std::str::FromStr for Quality {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "fast" => Ok(Quality::Fast),
            "balanced" => Ok(Quality::Balanced),
            "high" => Ok(Quality::High),
            _ => Err(format!("no quality is called `{name}`; give fast, balanced or high")),
        }
    }
}

/// Below this many primitives a branch is not worth a task of its own.
const PARALLEL: usize = 4096;
/// Above this many it is itself worth all threads.
const SHARED: usize = 1 << 16;
/// What each of them takes at once.
const SHARE: usize = 1 << 14;
/// Deeper branches are halved by count: bad luck in the bins must not make the tree a list.
const MAX_BINNED_DEPTH: usize = 64;

/// A box in lanes: the least x, y, z, anything, and the greatest, negated, and anything.
type Rows = [f32; LANES];
/// Neutral in a union.
const NOTHING: Rows = [f32::INFINITY; LANES];

/// What is in a slot: its box; the fourth row is the slot, by its bits, the eighth its kind.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Item {
    rows: Rows,
}

impl Item {
    const SLOT: usize = 3;
    const KIND: usize = 7;

    fn new(g: &Geometry, slot: Slot) -> Item {
        let Aabb { lo, hi } = &g.bounds[slot.index()];
        let kind = f32::from_bits(g.shape[slot.index()].0 as u32);
        Item { rows: [lo[0], lo[1], lo[2], f32::from_bits(slot.0), -hi[0], -hi[1], -hi[2], kind] }
    }

    fn slot(&self) -> Slot {
        Slot(self.rows[Self::SLOT].to_bits())
    }

    fn kind(&self) -> u32 {
        self.rows[Self::KIND].to_bits()
    }
}

fn aabb(r: &Rows) -> Aabb {
    Aabb { lo: [r[0], r[1], r[2]], hi: [-r[4], -r[5], -r[6]] }
}

#[inline(always)]
fn area(r: &Rows) -> f32 {
    let e = [-(r[0] + r[4]), -(r[1] + r[5]), -(r[2] + r[6])];
    e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
}

/// Some of the primitives, and as much room to sort them.
struct Branch<'a> {
    items: &'a mut [Item],
    room: &'a mut [Item],
    /// Where `items` begins among all.
    first: usize,
    bounds: Rows,
    depth: usize,
    /// Whether it is not to be split: of one kind, and few enough for a block.
    is_leaf: bool,
}

impl<'a> Branch<'a> {
    fn new<S: Simd>(
        simd: S,
        items: &'a mut [Item],
        room: &'a mut [Item],
        first: usize,
        depth: usize,
    ) -> Branch<'a> {
        let bounds = shared(simd, items, Sum::Boxes);
        let is_leaf = items.len() == 1
            || items.len() <= LANES
                && items.iter().all(|i| i.kind() == items[0].kind())
                && !stands_alone(ShapeKind::ALL[items[0].kind() as usize]);
        Branch { items, room, first, bounds, depth, is_leaf }
    }
}

#[inline(always)]
fn union(a: Rows, b: Rows) -> Rows {
    let mut out = a;
    for (to, from) in out.iter_mut().zip(b) {
        *to = if from < *to { from } else { *to };
    }
    out
}

/// What is summed over items.
#[derive(Clone, Copy)]
enum Sum {
    Boxes,
    Centers,
}

/// The union of all boxes, or of all centres: on all threads if that pays.
#[inline(always)]
fn shared<S: Simd>(simd: S, items: &[Item], what: Sum) -> Rows {
    if items.len() < SHARED {
        return sum(simd, items, what);
    }
    let part = |items: &[Item]| {
        simd.vectorize(
            #[inline(always)]
            || sum(simd, items, what),
        )
    };
    items.par_chunks(SHARE).map(part).reduce(|| NOTHING, union)
}

#[inline(always)]
fn sum<S: Simd>(simd: S, items: &[Item], what: Sum) -> Rows {
    let mut all = F::splat(simd, f32::INFINITY);
    match what {
        Sum::Boxes => {
            for item in items {
                all = lesser(simd, F::from_slice(simd, &item.rows), all);
            }
        }
        Sum::Centers => {
            for item in items {
                all = lesser(simd, center(simd, item), all);
            }
        }
    }
    let mut rows = NOTHING;
    all.store_slice(&mut rows);
    rows
}

/// Builds the tree over all visible primitives but planes, and puts them into `blocks`, which are
/// empty.
pub fn build(
    g: &Geometry,
    (level, quality): (Level, Quality),
    blocks: &mut Blocks,
    meshes: &MeshTrees,
) -> Tree {
    let wanted = |s: &Slot| g.is_visible(*s) && g.shape[s.index()].0 != ShapeKind::Plane;
    let slots = (0..g.len() as u32).into_par_iter().with_min_len(PARALLEL).map(Slot);
    let count = slots.clone().filter(wanted).count();
    if count == 0 {
        return Tree::default();
    }
    let [mut items, mut room] = [(); 2].map(|()| with_room(count));
    items.extend(g.slots().filter(wanted).map(|slot| Item::new(g, slot)));
    room.resize(count, Item { rows: NOTHING });
    let (some, spare) = (&mut items[..], &mut room[..]);
    let part = dispatch!(level, simd => plant(simd, quality, some, spare));
    let slots: Vec<Slot> =
        items.par_iter().with_min_len(PARALLEL).map(|item| item.slot()).collect();
    for (kind, leaves) in ShapeKind::ALL.into_iter().zip(&part.leaves) {
        blocks.fill(kind, g, &slots, leaves, meshes);
    }
    let mut nodes = with_room(part.nodes.len());
    nodes.extend(part.nodes);
    let mut tree = Tree { nodes, depth: part.depth, ..Tree::default() };
    tree.measure();
    tree
}

/// An empty vector with as much room, on large pages.
fn with_room<T>(len: usize) -> Vec<T> {
    let mut rows = Vec::with_capacity(len);
    prefer_large_pages(rows.spare_capacity_mut());
    rows
}

/// A part of the tree: nodes, a root first, and by kind the leaves that they name.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    leaves: [Vec<Leaf>; SHAPE_KINDS],
    depth: usize,
}

impl Part {
    /// Appends another; gives the place of its root.
    fn append(&mut self, other: Part) -> usize {
        let first = self.nodes.len();
        let moved = self.leaves.each_ref().map(Vec::len);
        self.nodes.extend(other.nodes.into_iter().map(|mut node| {
            node.rename(|child| match child.target() {
                Ok(index) => Child::node(index + first),
                Err((kind, block)) => Child::block(kind, block + moved[kind as usize]),
            });
            node
        }));
        for (all, more) in self.leaves.iter_mut().zip(other.leaves) {
            all.extend(more);
        }
        self.depth = self.depth.max(other.depth);
        first
    }
}

#[inline(always)]
fn plant<S: Simd>(simd: S, quality: Quality, items: &mut [Item], room: &mut [Item]) -> Part {
    let (mut part, planter) = (Part::default(), Planter { simd, quality });
    let root = Branch::new(simd, items, room, 0, 0);
    planter.node(root, 1, &mut part);
    part
}

struct Planter<S: Simd> {
    simd: S,
    quality: Quality,
}

impl<S: Simd> Planter<S> {
    /// Makes a node of a branch, and all below.
    fn node(&self, root: Branch<'_>, level: usize, part: &mut Part) {
        part.depth = part.depth.max(level);
        let mut open = Vec::with_capacity(LANES);
        open.push(root);
        while open.len() < LANES {
            // The largest box; of equal ones the first.
            let mut largest: Option<(f32, usize)> = None;
            for (i, branch) in open.iter().enumerate().filter(|(_, b)| !b.is_leaf) {
                let area = area(&branch.bounds);
                if largest.is_none_or(|l| area > l.0) {
                    largest = Some((area, i));
                }
            }
            let Some((_, i)) = largest else { break };
            let [left, right] = self.split(open.swap_remove(i));
            open.push(left);
            open.push(right);
        }
        let index = part.nodes.len();
        part.nodes.push(Node::empty());
        let mut inner = Vec::new();
        for (lane, branch) in open.into_iter().enumerate() {
            part.nodes[index].set_bounds(lane, &aabb(&branch.bounds));
            if branch.is_leaf {
                let kind = branch.items[0].kind() as usize;
                let leaves = &mut part.leaves[kind];
                part.nodes[index].set_child(lane, Child::block(ShapeKind::ALL[kind], leaves.len()));
                leaves.push(Leaf { first: branch.first, len: branch.items.len() });
            } else {
                inner.push((lane, branch));
            }
        }
        part.nodes[index].set_order();
        if inner.iter().map(|(_, b)| b.items.len()).sum::<usize>() > PARALLEL {
            let grow = |(lane, branch)| {
                let mut part = Part::default();
                self.node_apart(branch, level + 1, &mut part);
                (lane, part)
            };
            let parts: Vec<(usize, Part)> = inner.into_par_iter().map(grow).collect();
            for (lane, below) in parts {
                let child = Child::node(part.append(below));
                part.nodes[index].set_child(lane, child);
            }
        } else {
            for (lane, branch) in inner {
                let child = Child::node(part.nodes.len());
                part.nodes[index].set_child(lane, child);
                self.node(branch, level + 1, part);
            }
        }
    }

    /// On a thread that has not yet entered the SIMD level.
    fn node_apart(&self, root: Branch<'_>, level: usize, part: &mut Part) {
        self.simd.vectorize(
            #[inline(always)]
            || self.node(root, level, part),
        );
    }

    fn split<'a>(&self, branch: Branch<'a>) -> [Branch<'a>; 2] {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let Branch { items, room, first, depth, .. } = branch;
                let middle = self.sort(items, room, depth);
                let (left, right) = items.split_at_mut(middle);
                let (left_room, right_room) = room.split_at_mut(middle);
                [
                    Branch::new(simd, left, left_room, first, depth + 1),
                    Branch::new(simd, right, right_room, first + middle, depth + 1),
                ]
            },
        )
    }

    /// Sorts items to two sides, neither empty; gives the place of the border.
    #[inline(always)]
    fn sort(&self, items: &mut [Item], room: &mut [Item], depth: usize) -> usize {
        let len = items.len();
        let kind = items[0].kind();
        let middle = if len <= LANES && !stands_alone(ShapeKind::ALL[kind as usize]) {
            partition(
                self.simd,
                items,
                room,
                #[inline(always)]
                |item| item.kind() == kind,
            )
        } else if depth < MAX_BINNED_DEPTH {
            match self.quality {
                Quality::Fast => self.sort_binned::<8>(items, room),
                Quality::Balanced if len < 64 => self.sort_binned::<8>(items, room),
                Quality::Balanced => self.sort_binned::<16>(items, room),
                Quality::High => self.sort_binned::<32>(items, room),
            }
        } else {
            0
        };
        // All centres in one place, or no numbers.
        if middle == 0 || middle == len { len / 2 } else { middle }
    }

    #[inline(always)]
    fn sort_binned<const N: usize>(&self, items: &mut [Item], room: &mut [Item]) -> usize {
        let bins = Bins::<S, N>::of(self.simd, items);
        let Some((axis, border)) = bins.border(self.simd, items) else { return 0 };
        partition(
            self.simd,
            items,
            room,
            #[inline(always)]
            |item| bins.slots(self.simd, item)[axis] < border,
        )
    }
}

/// The bins of a branch on all three axes, by twice the boxes' centres. (Wald, "On fast Construction
/// of SAH-based Bounding Volume Hierarchies", RT 2007.)
#[derive(Clone, Copy)]
struct Bins<S: Simd, const N: usize> {
    least: F<S>,
    scale: F<S>,
    /// Axes on which centres differ.
    spread: [bool; 3],
}

/// Added to a small number, this leaves its nearest integer in the lowest bits.
const TO_BITS: f32 = 12_582_912.0;

/// What is in each bin of each axis.
struct Filled<const N: usize> {
    boxes: [[Rows; 3]; N],
    counts: [[u32; 3]; N],
}

/// Twice the centre, and in the upper half its negative.
#[inline(always)]
fn center<S: Simd>(simd: S, item: &Item) -> F<S> {
    let rows = F::from_slice(simd, &item.rows);
    rows - rows.slide::<4>(rows)
}

impl<S: Simd, const N: usize> Bins<S, N> {
    #[inline(always)]
    fn of(simd: S, items: &[Item]) -> Bins<S, N> {
        let rows = shared(simd, items, Sum::Centers);
        let (mut scale, mut spread) = ([0.0; LANES], [false; 3]);
        for k in 0..3 {
            let extent = -(rows[k] + rows[k + 4]);
            // Not a number when the extent overflows: such scenes are halved by count.
            if extent > 0.0 && extent.is_finite() {
                scale[k] = N as f32 * (1.0 - 1e-6) / extent;
                spread[k] = scale[k].is_finite();
            }
        }
        let (least, scale) = (F::from_slice(simd, &rows), F::from_slice(simd, &scale));
        Bins { least, scale, spread }
    }

    /// Which bins an item is in.
    #[inline(always)]
    fn slots(&self, simd: S, item: &Item) -> [usize; 3] {
        let place = (center(simd, item) - self.least) * self.scale - 0.499_999;
        let place = (place + TO_BITS).to_bits() & (N as u32 - 1);
        let slots = place.as_slice();
        [slots[0] as usize, slots[1] as usize, slots[2] as usize]
    }

    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // An axis each, of three columns at once.
    fn fill(&self, simd: S, items: &[Item]) -> Filled<N> {
        let mut filled = Filled::new();
        for item in items {
            let rows = F::from_slice(simd, &item.rows);
            let slots = self.slots(simd, item);
            for k in 0..3 {
                let slot = slots[k] % N;
                let all = &mut filled.boxes[slot][k];
                lesser(simd, rows, F::from_slice(simd, &all[..])).store_slice(&mut all[..]);
                filled.counts[slot][k] += 1;
            }
        }
        filled
    }

    /// The axis and the first bin of the right side of the least expected cost; `None` if there is
    /// no border with items on both sides.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // A bin each, of both sides at once.
    fn border(&self, simd: S, items: &[Item]) -> Option<(usize, usize)> {
        let filled = if items.len() < SHARED {
            self.fill(simd, items)
        } else {
            let part = |items: &[Item]| {
                simd.vectorize(
                    #[inline(always)]
                    || self.fill(simd, items),
                )
            };
            items.par_chunks(SHARE).map(part).reduce(Filled::new, Filled::join)
        };
        // Blocks are tested whole.
        let blocks = |count: u32| count.div_ceil(LANES as u32) as f32;
        let mut right = [[0.0f32; 3]; N];
        let mut sums = [NOTHING; 3];
        let mut counts = [0; 3];
        for i in (1..N).rev() {
            for k in 0..3 {
                sums[k] = union(sums[k], filled.boxes[i][k]);
                counts[k] += filled.counts[i][k];
                right[i][k] =
                    if counts[k] > 0 { area(&sums[k]) * blocks(counts[k]) } else { f32::INFINITY };
            }
        }
        let mut best: Option<(f32, usize, usize)> = None;
        let (mut sums, mut counts) = ([NOTHING; 3], [0; 3]);
        for i in 1..N {
            for k in 0..3 {
                sums[k] = union(sums[k], filled.boxes[i - 1][k]);
                counts[k] += filled.counts[i - 1][k];
                if counts[k] > 0 && self.spread[k] {
                    let cost = area(&sums[k]) * blocks(counts[k]) + right[i][k];
                    if cost < best.map_or(f32::INFINITY, |b| b.0) {
                        best = Some((cost, k, i));
                    }
                }
            }
        }
        best.map(|(_, axis, border)| (axis, border))
    }
}

impl<const N: usize> Filled<N> {
    #[inline(always)]
    fn new() -> Filled<N> {
        Filled { boxes: [[NOTHING; 3]; N], counts: [[0; 3]; N] }
    }

    fn join(mut self, other: Filled<N>) -> Filled<N> {
        for i in 0..N {
            for k in 0..3 {
                self.boxes[i][k] = union(self.boxes[i][k], other.boxes[i][k]);
                self.counts[i][k] += other.counts[i][k];
            }
        }
        self
    }
}

/// Brings those that pass to the front, in their order on both sides, and counts them.
#[inline(always)]
fn partition<S: Simd>(
    simd: S,
    items: &mut [Item],
    room: &mut [Item],
    is_left: impl Fn(&Item) -> bool + Sync,
) -> usize {
    if items.len() < SHARED {
        let (mut left, mut right) = (0, 0);
        for i in 0..items.len() {
            // Written to both sides, so that nothing is to be predicted.
            let item = items[i];
            items[left] = item;
            room[right] = item;
            let goes_left = usize::from(is_left(&item));
            left += goes_left;
            right += 1 - goes_left;
        }
        items[left..].copy_from_slice(&room[..right]);
        return left;
    }
    let count = |items: &[Item]| {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut count = 0;
                for item in items {
                    count += usize::from(is_left(item));
                }
                count
            },
        )
    };
    let counts: Vec<usize> = items.par_chunks(SHARE).map(count).collect();
    let middle = counts.iter().sum();
    let (mut left, mut right) = room.split_at_mut(middle);
    let mut parts = Vec::with_capacity(counts.len());
    for (some, count) in items.chunks(SHARE).zip(counts) {
        let (to_left, rest) = left.split_at_mut(count);
        left = rest;
        let (to_right, rest) = right.split_at_mut(some.len() - count);
        right = rest;
        parts.push((some, to_left, to_right));
    }
    parts.into_par_iter().for_each(|(some, to_left, to_right)| {
        simd.vectorize(
            #[inline(always)]
            || {
                let (mut left, mut right) = (0, 0);
                for item in some {
                    if is_left(item) {
                        to_left[left] = *item;
                        left += 1;
                    } else {
                        to_right[right] = *item;
                        right += 1;
                    }
                }
            },
        );
    });
    items.par_chunks_mut(SHARE).zip(room.par_chunks(SHARE)).for_each(|(to, from)| {
        to.copy_from_slice(from);
    });
    middle
}
