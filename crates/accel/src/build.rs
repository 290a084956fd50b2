//! The tree by binned surface area, straight into nodes of eight: of the branches that a node has
//! so far the largest is split in two, until there are eight or none is left to split.
//!
//! Large branches are split ahead on all threads, very large ones each by all; then nodes are made
//! of them on all threads. What comes out never depends on how many there are, since unions and
//! counts do not depend on their order, and parts are joined in a fixed one.

use crate::bins::{Bins, Grid};
use crate::blocks::{Blocks, Leaf};
use crate::copies::{MeshTrees, stands_alone};
use crate::items::{Item, boxes, centers, deal};
use crate::lanes::LANES;
use crate::prefetch::prefer_large_pages;
use crate::tree::{Child, Node, Tree};
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use reflet_pack::{Geometry, SHAPE_KINDS, ShapeKind, Slot};
use std::collections::BTreeMap;

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
/// From this many on it is itself worth all threads: while there are fewer branches than threads.
const SHARED: usize = 1 << 14;
/// What each of them takes at once.
const SHARE: usize = 1 << 12;
/// Deeper branches are halved by count: bad luck in the bins must not make the tree a list.
const MAX_BINNED_DEPTH: usize = 64;

/// Builds the tree over all visible primitives but planes, and puts them into `blocks`, which are
/// empty.
pub fn build(
    g: &Geometry,
    (level, quality): (Level, Quality),
    blocks: &mut Blocks,
    meshes: &MeshTrees,
) -> Tree {
    let mut items = gather(g);
    let count = items.len();
    if count == 0 {
        return Tree::default();
    }
    let mut room = with_room(count);
    let none = (0..count).into_par_iter().with_min_len(PARALLEL).map(|_| Item::NOTHING);
    none.collect_into_vec(&mut room);
    let desk = Desk { sides: [&mut items, &mut room], first: 0 };
    let parts = dispatch!(level, simd => plant(simd, quality, desk));
    drop(room);
    let mut part = Part { nodes: with_room(parts.len()), ..Part::default() };
    parts.append_to(&mut part);
    for (kind, leaves) in ShapeKind::ALL.into_iter().zip(&part.leaves) {
        blocks.fill(kind, g, &items, leaves, meshes);
    }
    let mut tree = Tree { nodes: part.nodes, depth: part.depth, ..Tree::default() };
    tree.measure();
    tree
}

/// All visible primitives but planes.
fn gather(g: &Geometry) -> Vec<Item> {
    let wanted = |s: &Slot| g.is_visible(*s) && g.shape[s.index()].0 != ShapeKind::Plane;
    let slots = (0..g.len() as u32).into_par_iter().with_min_len(PARALLEL).map(Slot);
    let count = slots.clone().filter(wanted).count();
    let mut items = with_room(count);
    if count == g.len() {
        slots.map(|slot| Item::new(g, slot)).collect_into_vec(&mut items);
    } else {
        items.extend(g.slots().filter(wanted).map(|slot| Item::new(g, slot)));
    }
    items
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
    /// What was made apart, by the lane of the root: then the root is the only node here.
    below: Vec<(usize, Part)>,
}

impl Part {
    /// For some items; nodes mostly are fewer than there is room for.
    fn with_room(items: usize) -> Part {
        Part { nodes: with_room(items / 24), ..Part::default() }
    }

    /// How many nodes there are in all.
    fn len(&self) -> usize {
        self.nodes.len() + self.below.iter().map(|(_, part)| part.len()).sum::<usize>()
    }

    /// Appends all of it to one part; gives the place of its root.
    fn append_to(self, all: &mut Part) -> usize {
        let first = all.nodes.len();
        let moved = all.leaves.each_ref().map(Vec::len);
        all.nodes.extend(self.nodes.into_iter().map(|mut node| {
            node.rename(|child| match child.target() {
                Ok(index) => Child::node(index + first),
                Err((kind, block)) => Child::block(kind, block + moved[kind as usize]),
            });
            node
        }));
        for (all, more) in all.leaves.iter_mut().zip(self.leaves) {
            all.extend(more);
        }
        all.depth = all.depth.max(self.depth);
        for (lane, part) in self.below {
            let child = Child::node(part.append_to(all));
            all.nodes[first].set_child(lane, child);
        }
        first
    }
}

/// Some of the items, in one of two places: branches of even depth are on the first side, and what
/// they are cut into goes to the other. Leaves all end on the first.
struct Desk<'a> {
    sides: [&'a mut [Item]; 2],
    /// Where all this begins among all.
    first: usize,
}

impl<'a> Desk<'a> {
    /// Brings a leaf to the first side; gives its kind.
    fn settle(&mut self, leaf: &Branch) -> usize {
        let (from, to) = self.pair(leaf);
        if !leaf.depth.is_multiple_of(2) {
            to.copy_from_slice(from);
        }
        from[0].kind() as usize
    }

    /// The items of a branch, and where they are sorted to.
    fn pair(&mut self, branch: &Branch) -> (&[Item], &mut [Item]) {
        let first = branch.first - self.first;
        let [even, odd] = &mut self.sides;
        let (from, to) = if branch.depth.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        (&from[first..][..branch.len], &mut to[first..][..branch.len])
    }

    /// All of it, for a while.
    fn lend(&mut self) -> Desk<'_> {
        let [even, odd] = &mut self.sides;
        Desk { sides: [even, odd], first: self.first }
    }

    /// Takes away what comes before a place.
    fn take_to(&mut self, end: usize) -> Desk<'a> {
        let (len, first) = (end - self.first, self.first);
        self.first = end;
        let sides = self.sides.each_mut().map(|side| side.split_off_mut(..len).unwrap_or_default());
        Desk { sides, first }
    }
}

/// A part of the items.
#[derive(Clone, Copy)]
struct Branch {
    bounds: Item,
    /// Where it begins among all.
    first: usize,
    len: usize,
    depth: usize,
    /// Whether it is not to be split: of one kind, and few enough for a block.
    is_leaf: bool,
}

impl Branch {
    /// Where it begins and ends: no two that are split share both.
    fn span(&self) -> (usize, usize) {
        (self.first, self.first + self.len)
    }
}

/// The largest box that can be split; of equal ones the first.
fn largest(open: &[Branch]) -> Option<usize> {
    let mut largest: Option<(f32, usize)> = None;
    for (i, branch) in open.iter().enumerate().filter(|(_, b)| !b.is_leaf) {
        let area = branch.bounds.area();
        if largest.is_none_or(|l| area > l.0) {
            largest = Some((area, i));
        }
    }
    largest.map(|l| l.1)
}

#[inline(always)]
fn plant<S: Simd>(simd: S, quality: Quality, mut desk: Desk<'_>) -> Part {
    let threads = rayon::current_num_threads();
    let mut planter = Planter { simd, quality, threads, ahead: BTreeMap::new() };
    let items = &*desk.sides[0];
    let (len, is_leaf) = (items.len(), fits(items));
    let root = Branch { bounds: planter.shared(items, boxes), first: 0, len, depth: 0, is_leaf };
    let mut part = Part::with_room(if threads == 1 { len } else { 0 });
    if threads > 1 {
        planter.ahead = planter.split_ahead(desk.lend(), root);
    }
    planter.node(&mut desk, root, 1, &mut part);
    part
}

/// Whether a block holds all of them.
#[inline(always)]
fn fits(items: &[Item]) -> bool {
    items.len() == 1
        || items.len() <= LANES
            && items.iter().all(|i| i.kind() == items[0].kind())
            && !stands_alone(ShapeKind::ALL[items[0].kind() as usize])
}

struct Planter<S: Simd> {
    simd: S,
    quality: Quality,
    threads: usize,
    ahead: Ahead,
}

/// What large branches have been split into, by their spans.
type Ahead = BTreeMap<(usize, usize), [Branch; 2]>;

impl<S: Simd> Planter<S> {
    /// Makes a node of a branch, and all below.
    fn node(&self, desk: &mut Desk<'_>, root: Branch, level: usize, part: &mut Part) {
        part.depth = part.depth.max(level);
        let (mut open, mut count) = ([root; LANES], 1);
        while count < LANES {
            let Some(i) = largest(&open[..count]) else { break };
            let ahead = if open[i].len > PARALLEL { self.ahead.get(&open[i].span()) } else { None };
            let [left, right] = ahead.copied().unwrap_or_else(|| self.split(desk, &open[i]));
            open[i] = open[count - 1];
            (open[count - 1], open[count]) = (left, right);
            count += 1;
        }
        let (index, mut node) = (part.nodes.len(), Node::empty());
        for (lane, branch) in open[..count].iter().enumerate() {
            node.set_bounds(lane, &branch.bounds.aabb());
            if branch.is_leaf {
                let kind = desk.settle(branch);
                let leaves = &mut part.leaves[kind];
                node.set_child(lane, Child::block(ShapeKind::ALL[kind], leaves.len()));
                leaves.push(Leaf { first: branch.first, len: branch.len });
            }
        }
        node.set_order();
        part.nodes.push(node);
        let inner = open[..count].iter().enumerate().filter(|(_, branch)| !branch.is_leaf);
        if self.threads == 1 || root.len <= PARALLEL {
            for (lane, branch) in inner {
                let child = Child::node(part.nodes.len());
                part.nodes[index].set_child(lane, child);
                self.node(desk, *branch, level + 1, part);
            }
        } else {
            part.below = self.nodes(desk.lend(), inner.collect(), level + 1);
        }
    }

    /// Makes nodes of some branches, each with its lane, on all threads.
    fn nodes(
        &self,
        mut desk: Desk<'_>,
        mut branches: Vec<(usize, &Branch)>,
        level: usize,
    ) -> Vec<(usize, Part)> {
        branches.sort_by_key(|(_, branch)| branch.first);
        let mut works = Vec::with_capacity(branches.len());
        for (lane, branch) in branches {
            desk.take_to(branch.first);
            works.push((lane, desk.take_to(branch.first + branch.len), *branch));
        }
        works.sort_by_key(|(lane, ..)| *lane);
        let grow = |(lane, mut desk, branch): (usize, Desk<'_>, Branch)| {
            let mut part = Part::with_room(if branch.len <= PARALLEL { branch.len } else { 0 });
            self.node(&mut desk, branch, level, &mut part);
            (lane, part)
        };
        works.into_par_iter().map(grow).collect()
    }

    /// Splits large branches on all threads before nodes are made of them. Whatever is chosen for
    /// a node, all that is no leaf is split sooner or later, and always in the same way.
    fn split_ahead(&self, mut desk: Desk<'_>, branch: Branch) -> Ahead {
        if branch.is_leaf || branch.len <= PARALLEL {
            return Ahead::new();
        }
        let [left, right] = self.split(&mut desk, &branch);
        let desk_of_left = desk.take_to(right.first);
        let (mut all, more) =
            rayon::join(|| self.split_ahead(desk_of_left, left), || self.split_ahead(desk, right));
        all.extend(more);
        all.insert(branch.span(), [left, right]);
        all
    }

    fn split(&self, desk: &mut Desk<'_>, branch: &Branch) -> [Branch; 2] {
        self.simd.vectorize(
            #[inline(always)]
            || {
                let (from, to) = desk.pair(branch);
                let (middle, bounds) = self.sort(from, to, branch.depth);
                let (left, right) = to.split_at(middle);
                let (first, depth) = (branch.first, branch.depth + 1);
                let half = |items: &[Item], first, bounds| {
                    let (len, is_leaf) = (items.len(), fits(items));
                    Branch { bounds, first, len, depth, is_leaf }
                };
                [half(left, first, bounds[0]), half(right, first + middle, bounds[1])]
            },
        )
    }

    /// Sorts items to two sides, neither empty; gives the place of the border, and their boxes.
    #[inline(always)]
    fn sort(&self, from: &[Item], to: &mut [Item], depth: usize) -> (usize, [Item; 2]) {
        let (len, kind) = (from.len(), from[0].kind());
        let sorted = if len <= LANES && !stands_alone(ShapeKind::ALL[kind as usize]) {
            to.copy_from_slice(from);
            to.sort_by_key(|item| item.kind() != kind);
            let middle = to.partition_point(|item| item.kind() == kind);
            return self.halves(to, middle);
        } else if depth < MAX_BINNED_DEPTH {
            match self.quality {
                Quality::Fast => self.sort_binned::<8>(from, to),
                Quality::Balanced if len < 64 => self.sort_binned::<8>(from, to),
                Quality::Balanced => self.sort_binned::<16>(from, to),
                Quality::High => self.sort_binned::<32>(from, to),
            }
        } else {
            None
        };
        // All centres in one place, or no numbers.
        sorted.unwrap_or_else(
            #[inline(always)]
            || {
                to.copy_from_slice(from);
                self.halves(to, len / 2)
            },
        )
    }

    #[inline(always)]
    fn halves(&self, items: &[Item], middle: usize) -> (usize, [Item; 2]) {
        let (left, right) = items.split_at(middle);
        (middle, [boxes(self.simd, left), boxes(self.simd, right)])
    }

    #[inline(always)]
    fn sort_binned<const N: usize>(
        &self,
        from: &[Item],
        to: &mut [Item],
    ) -> Option<(usize, [Item; 2])> {
        let simd = self.simd;
        if self.threads > 1 && from.len() >= SHARED {
            return self.sort_shared::<N>(from, to);
        }
        let grid = Grid::<N>::new(&centers(simd, from));
        let cut = Bins::fill(simd, &grid, from).cut(simd, &grid)?;
        let (left, right) = to.split_at_mut(cut.left);
        deal(
            from,
            left,
            right,
            #[inline(always)]
            |item| grid.is_left(item, cut.border),
        );
        Some((cut.left, cut.bounds))
    }

    /// The same on all threads.
    fn sort_shared<const N: usize>(
        &self,
        from: &[Item],
        to: &mut [Item],
    ) -> Option<(usize, [Item; 2])> {
        let simd = self.simd;
        let grid = Grid::<N>::new(&self.shared(from, centers));
        let fill = |items: &[Item]| {
            simd.vectorize(
                #[inline(always)]
                || Bins::fill(simd, &grid, items),
            )
        };
        let shares: Vec<Bins<N>> = from.par_chunks(SHARE).map(fill).collect();
        let cut = simd.vectorize(
            #[inline(always)]
            || {
                let mut all = Bins::EMPTY;
                for share in &shares {
                    all.join(simd, share);
                }
                all.cut(simd, &grid)
            },
        )?;
        let (mut left, mut right) = to.split_at_mut(cut.left);
        let mut parts = Vec::with_capacity(shares.len());
        for (some, share) in from.chunks(SHARE).zip(shares) {
            let (to_left, rest) = left.split_at_mut(share.left(cut.border));
            left = rest;
            let (to_right, rest) = right.split_at_mut(some.len() - to_left.len());
            right = rest;
            parts.push((some, to_left, to_right));
        }
        parts.into_par_iter().for_each(|(some, left, right)| {
            simd.vectorize(
                #[inline(always)]
                || {
                    deal(
                        some,
                        left,
                        right,
                        #[inline(always)]
                        |item| grid.is_left(item, cut.border),
                    )
                },
            );
        });
        Some((cut.left, cut.bounds))
    }

    /// What `sum` gives for all items, by parts on all threads if that pays.
    fn shared(&self, items: &[Item], sum: impl Fn(S, &[Item]) -> Item + Sync) -> Item {
        let part = |items: &[Item]| {
            self.simd.vectorize(
                #[inline(always)]
                || sum(self.simd, items),
            )
        };
        if self.threads == 1 || items.len() < SHARED {
            return part(items);
        }
        items.par_chunks(SHARE).map(part).reduce(|| Item::NOTHING, Item::union)
    }
}
