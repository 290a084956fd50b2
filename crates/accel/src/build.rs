//! The tree by binned surface area: two children at first, then gathered into eight.

use crate::blocks::Blocks;
use crate::lanes::{F, LANES, U};
use fearless_simd::prelude::*;
use reflet_pack::{Aabb, Geometry, PrimId, ShapeKind};

/// An inner node: the boxes of eight children in lanes, four cache lines. Its rows are the least x,
/// y, z of each child, what each child is, and the greatest x, y, z, so that a bit of a row's number
/// tells the near face from the far one; floats are kept by their bits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Node {
    rows: [[u32; LANES]; 8],
}

impl Node {
    /// The row of the greatest x; that of the least is 0.
    pub const HI: usize = 4;
    const CHILD: usize = 3;

    fn empty() -> Node {
        let mut node = Node { rows: [[Child::NONE.0; LANES]; 8] };
        (0..LANES).for_each(|lane| node.set_bounds(lane, &Aabb::EMPTY));
        node
    }

    /// A row of faces in lanes.
    #[inline(always)]
    pub fn faces<S: Simd>(&self, simd: S, row: usize) -> F<S> {
        F::from_bits(U::from_slice(simd, &self.rows[row % 8]))
    }

    /// A child.
    #[inline(always)]
    pub fn child(&self, lane: usize) -> Child {
        Child(self.rows[Self::CHILD][lane % LANES])
    }

    fn set_child(&mut self, lane: usize, child: Child) {
        self.rows[Self::CHILD][lane] = child.0;
    }

    /// The box of a child.
    pub fn bounds(&self, lane: usize) -> Aabb {
        let at = |row: usize| f32::from_bits(self.rows[row][lane]);
        Aabb { lo: [at(0), at(1), at(2)], hi: [at(4), at(5), at(6)] }
    }

    /// The box of all children.
    pub fn union(&self) -> Aabb {
        (0..LANES).fold(Aabb::EMPTY, |all, lane| all.union(&self.bounds(lane)))
    }

    /// Writes the box of a child.
    pub fn set_bounds(&mut self, lane: usize, b: &Aabb) {
        for k in 0..3 {
            self.rows[k][lane] = b.lo[k].to_bits();
            self.rows[Self::HI + k][lane] = b.hi[k].to_bits();
        }
    }
}

/// What a child of a node is: another node, or a block of primitives of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Child(pub(crate) u32);

impl Child {
    /// No child; its box is empty.
    pub const NONE: Child = Child(u32::MAX);
    /// The first node.
    pub const ROOT: Child = Child(0);
    const LEAF: u32 = 1 << 31;
    const KIND: u32 = 28;

    fn node(index: usize) -> Child {
        Child(index as u32)
    }

    fn block(kind: ShapeKind, index: usize) -> Child {
        Child(Self::LEAF | (kind as u32) << Self::KIND | index as u32)
    }

    /// Whether there is no child.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// The node's index, or the kind and index of the block.
    #[inline(always)]
    pub fn target(self) -> Result<usize, (ShapeKind, usize)> {
        if self.0 & Self::LEAF == 0 {
            return Ok(self.0 as usize);
        }
        let kind = match (self.0 >> Self::KIND) & 7 {
            0 => ShapeKind::Sphere,
            1 => ShapeKind::Plane,
            2 => ShapeKind::Quad,
            3 => ShapeKind::Triangle,
            _ => ShapeKind::Solid,
        };
        Err((kind, (self.0 & ((1 << Self::KIND) - 1)) as usize))
    }
}

/// Nodes; the first is the root. Empty if there is no bounded primitive.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// The nodes.
    pub nodes: Vec<Node>,
    /// The number of levels.
    pub depth: usize,
    /// The sum of the edges of the box of all.
    pub extent: f32,
    /// The least x, y, z of the box of all.
    pub least: [f32; 3],
    /// 1 over its edges.
    pub per_extent: [f32; 3],
}

impl Tree {
    /// Takes the measures of the box of all.
    pub fn measure(&mut self) {
        let Some(root) = self.nodes.first() else { return };
        let b = root.union();
        self.least = b.lo;
        let edges = [0, 1, 2].map(|k| b.hi[k] - b.lo[k]);
        self.extent = edges.iter().sum();
        self.per_extent = edges.map(|e| 1.0 / e);
    }

    /// The chance that a ray which meets the root visits each child, summed over all children, and
    /// 1 for the root itself (Goldsmith and Salmon, "Automatic Creation of Object Hierarchies for
    /// Ray Tracing", 1987).
    pub fn sah_cost(&self) -> f32 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        1.0 + self.area() / half_area(&root.union())
    }

    /// Half the area of the boxes of all children.
    pub fn area(&self) -> f32 {
        let area = |n: &Node| (0..LANES).map(|i| half_area(&n.bounds(i))).sum::<f32>();
        self.nodes.iter().map(|n| f64::from(area(n))).sum::<f64>() as f32
    }
}

#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    prim: PrimId,
    kind: ShapeKind,
}

impl Item {
    /// Twice the box's centre on an axis.
    fn center(&self, k: usize) -> f32 {
        self.bounds.lo[k] + self.bounds.hi[k]
    }
}

enum Binary {
    Leaf { bounds: Aabb, first: usize, len: usize },
    Inner { bounds: Aabb, children: Box<[Binary; 2]> },
}

impl Binary {
    fn bounds(&self) -> &Aabb {
        match self {
            Binary::Leaf { bounds, .. } | Binary::Inner { bounds, .. } => bounds,
        }
    }
}

/// Builds the tree over all visible primitives but planes, and puts them into `blocks`.
pub fn build(g: &Geometry, blocks: &mut Blocks) -> Tree {
    let mut items: Vec<Item> = (0..g.len() as u32)
        .map(PrimId)
        .filter(|p| g.is_visible(*p) && g.shape[p.index()].0 != ShapeKind::Plane)
        .map(|prim| Item { bounds: g.bounds[prim.index()], prim, kind: g.shape[prim.index()].0 })
        .collect();
    if items.is_empty() {
        return Tree::default();
    }
    let root = split(&mut items, 0, 0);
    let mut gather = Gather { g, items: &items, blocks, tree: Tree::default() };
    gather.node(&root, 1);
    let mut tree = gather.tree;
    tree.measure();
    tree
}

const BINS: usize = 16;
/// Below this many primitives a branch is not worth a task of its own.
const PARALLEL: usize = 4096;
/// Deeper branches are halved by count: bad luck in the bins must not make the tree a list.
const MAX_BINNED_DEPTH: usize = 48;

fn split(items: &mut [Item], first: usize, depth: usize) -> Binary {
    let bounds = items.iter().fold(Aabb::EMPTY, |all, i| all.union(&i.bounds));
    let one_kind = items.iter().all(|i| i.kind == items[0].kind);
    if items.len() <= LANES && one_kind {
        return Binary::Leaf { bounds, first, len: items.len() };
    }
    let middle = if items.len() <= LANES {
        let kind = items[0].kind;
        partition(items, |i| i.kind == kind)
    } else {
        (depth < MAX_BINNED_DEPTH).then(|| binned(items)).flatten().unwrap_or(items.len() / 2)
    };
    let (left, right) = items.split_at_mut(middle);
    let (left, right) = if left.len() + right.len() > PARALLEL {
        rayon::join(|| split(left, first, depth + 1), || split(right, first + middle, depth + 1))
    } else {
        (split(left, first, depth + 1), split(right, first + middle, depth + 1))
    };
    Binary::Inner { bounds, children: Box::new([left, right]) }
}

/// Sorts by the best of the bins' borders and gives its place; `None` if all centres coincide.
/// (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007.)
fn binned(items: &mut [Item]) -> Option<usize> {
    let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items.iter() {
        for k in 0..3 {
            lo[k] = lo[k].min(item.center(k));
            hi[k] = hi[k].max(item.center(k));
        }
    }
    let bin = |item: &Item, k: usize| {
        let scale = BINS as f32 / (hi[k] - lo[k]);
        (((item.center(k) - lo[k]) * scale) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for k in 0..3 {
        // Not a number when the extent overflows: such scenes are halved by count.
        if !(hi[k] - lo[k] > 0.0 && (hi[k] - lo[k]).is_finite()) {
            continue;
        }
        let mut bins = [(Aabb::EMPTY, 0usize); BINS];
        for item in items.iter() {
            let slot = &mut bins[bin(item, k)];
            *slot = (slot.0.union(&item.bounds), slot.1 + 1);
        }
        let mut right = [(0.0f32, 0usize); BINS];
        let mut sum = (Aabb::EMPTY, 0);
        for i in (1..BINS).rev() {
            sum = (sum.0.union(&bins[i].0), sum.1 + bins[i].1);
            right[i] = (half_area(&sum.0), sum.1);
        }
        let mut left = (Aabb::EMPTY, 0);
        for i in 1..BINS {
            left = (left.0.union(&bins[i - 1].0), left.1 + bins[i - 1].1);
            if left.1 == 0 || right[i].1 == 0 {
                continue;
            }
            let cost = half_area(&left.0) * left.1 as f32 + right[i].0 * right[i].1 as f32;
            if best.is_none_or(|b| cost < b.0) {
                best = Some((cost, k, i));
            }
        }
    }
    let (_, k, border) = best?;
    Some(partition(items, |item| bin(item, k) < border))
}

/// Brings those that pass to the front, order kept within the front, and counts them.
fn partition(items: &mut [Item], pass: impl Fn(&Item) -> bool) -> usize {
    let mut front = 0;
    for i in 0..items.len() {
        if pass(&items[i]) {
            items.swap(front, i);
            front += 1;
        }
    }
    front
}

fn half_area(b: &Aabb) -> f32 {
    if b.is_empty() {
        return 0.0;
    }
    let e = [0, 1, 2].map(|k| b.hi[k] - b.lo[k]);
    e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
}

/// Binary nodes into wide ones.
struct Gather<'a> {
    g: &'a Geometry,
    items: &'a [Item],
    blocks: &'a mut Blocks,
    tree: Tree,
}

impl Gather<'_> {
    fn node(&mut self, root: &Binary, level: usize) -> usize {
        self.tree.depth = self.tree.depth.max(level);
        let mut open: Vec<&Binary> = vec![root];
        // Always open the largest, until there are eight or only leaves.
        while open.len() < LANES {
            let largest = open
                .iter()
                .enumerate()
                .filter(|(_, b)| matches!(b, Binary::Inner { .. }))
                .max_by(|(i, a), (j, b)| {
                    half_area(a.bounds()).total_cmp(&half_area(b.bounds())).then(j.cmp(i))
                })
                .map(|(i, _)| i);
            let Some(i) = largest else { break };
            let Binary::Inner { children, .. } = open[i] else { break };
            open[i] = &children[0];
            open.push(&children[1]);
        }
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::empty());
        for (lane, binary) in open.into_iter().enumerate() {
            let child = match binary {
                Binary::Leaf { first, len, .. } => {
                    let items = &self.items[*first..first + len];
                    let prims: Vec<PrimId> = items.iter().map(|i| i.prim).collect();
                    Child::block(items[0].kind, self.blocks.push(items[0].kind, self.g, &prims))
                }
                inner => Child::node(self.node(inner, level + 1)),
            };
            let node = &mut self.tree.nodes[index];
            node.set_bounds(lane, binary.bounds());
            node.set_child(lane, child);
        }
        index
    }
}
