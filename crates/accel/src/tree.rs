//! The tree: nodes of eight boxes.

use crate::lanes::{F, LANES, U};
use crate::order::{Order, orders};
use fearless_simd::prelude::*;
use reflet_pack::{Aabb, ShapeKind};

/// An inner node: the boxes of eight children in lanes, four cache lines. Its rows are the least x,
/// y, z of each child, what each child is, the greatest x, y, z, so that a bit of a row's number tells
/// the near face from the far one, and the orders of the octants; floats are kept by their bits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Node {
    rows: [[u32; LANES]; 8],
}

impl Node {
    /// The row of the greatest x; that of the least is 0.
    pub const HI: usize = 4;
    const CHILD: usize = 3;
    const ORDER: usize = 7;

    pub(crate) fn empty() -> Node {
        let mut node = Node { rows: [[Child::NONE.0; LANES]; 8] };
        (0..LANES).for_each(|lane| node.set_bounds(lane, &Aabb::EMPTY));
        node
    }

    /// A row of faces in lanes.
    #[inline(always)]
    pub fn faces<S: Simd>(&self, simd: S, row: usize) -> F<S> {
        F::from_bits(U::from_slice(simd, &self.rows[row % 8]))
    }

    /// For each axis the row that holds the faces which rays of an octant meet first.
    #[inline(always)]
    pub fn near_rows(octant: usize) -> [usize; 3] {
        let row = |k: usize| k + Self::HI * (octant >> k & 1);
        [row(0), row(1), row(2)]
    }

    /// Where those rows begin among all numbers of a node, and the octant itself.
    #[inline(always)]
    pub fn near_of(octant: usize) -> [u8; 4] {
        const OF: [[u8; 4]; 8] = {
            let mut of = [[0; 4]; 8];
            let mut octant = 0;
            while octant < 8 {
                let mut k = 0;
                while k < 3 {
                    of[octant][k] = ((k + Node::HI * (octant >> k & 1)) * LANES) as u8;
                    k += 1;
                }
                of[octant][3] = octant as u8;
                octant += 1;
            }
            of
        };
        OF[octant % 8]
    }

    /// Where a row of near faces and that of far ones begin, from what [`Node::near_of`] gives.
    #[inline(always)]
    pub fn near_and_far(near: u8) -> (usize, usize) {
        let near = usize::from(near) & (7 * LANES);
        (near, near ^ (Self::HI * LANES))
    }

    /// The row that begins at such a place.
    #[inline(always)]
    pub fn faces_of<S: Simd>(&self, simd: S, first: usize) -> F<S> {
        let first = first & (7 * LANES);
        F::from_bits(U::from_slice(simd, &self.rows.as_flattened()[first..first + LANES]))
    }

    /// A child.
    #[inline(always)]
    pub fn child(&self, lane: usize) -> Child {
        Child(self.rows[Self::CHILD][lane % LANES])
    }

    /// All children.
    #[inline(always)]
    pub fn children(&self) -> &[u32; LANES] {
        &self.rows[Self::CHILD]
    }

    /// The order in which rays of an octant visit the children.
    #[inline(always)]
    pub fn order(&self, octant: usize) -> Order {
        self.rows[Self::ORDER][octant % LANES]
    }

    /// Finds the orders anew, from where the children's boxes are.
    pub(crate) fn set_order(&mut self) {
        let mut twice = [[0.0; LANES]; 3];
        for (k, row) in twice.iter_mut().enumerate() {
            let (lo, hi) = (&self.rows[k], &self.rows[Self::HI + k]);
            for (lane, x) in row.iter_mut().enumerate() {
                *x = f32::from_bits(lo[lane]) + f32::from_bits(hi[lane]);
            }
        }
        self.rows[Self::ORDER] = orders(&twice);
    }

    pub(crate) fn set_child(&mut self, lane: usize, child: Child) {
        self.rows[Self::CHILD][lane] = child.0;
    }

    /// Gives each child another name.
    pub(crate) fn rename(&mut self, name: impl Fn(Child) -> Child) {
        for child in &mut self.rows[Self::CHILD] {
            let old = Child(*child);
            *child = if old.is_none() { old } else { name(old) }.0;
        }
    }

    /// The box of a child.
    pub fn bounds(&self, lane: usize) -> Aabb {
        let at = |row: usize| f32::from_bits(self.rows[row][lane]);
        Aabb { lo: [at(0), at(1), at(2)], hi: [at(4), at(5), at(6)] }
    }

    /// The box of a child that it has; empty for any other.
    #[inline(always)]
    pub(crate) fn bounds_of(&self, child: Child) -> Aabb {
        let is_it = |own: &u32| *own == child.0;
        self.children().iter().position(is_it).map_or(Aabb::EMPTY, |lane| self.bounds(lane))
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
    /// How many kinds [`Child::kind`] tells apart.
    pub const KINDS: usize = 16;
    const LEAF: u32 = 1 << 31;
    const KIND: u32 = 28;

    pub(crate) fn node(index: usize) -> Child {
        // 64 GiB of nodes: all above would be taken for another kind.
        assert!(index < 1 << Self::KIND, "node {index}");
        Child(index as u32)
    }

    pub(crate) const fn block(kind: ShapeKind, index: usize) -> Child {
        Child(Self::LEAF | (kind as u32) << Self::KIND | index as u32)
    }

    /// A number for its kind: below half of [`Child::KINDS`] a node, above a leaf, or none.
    #[inline(always)]
    pub const fn kind(self) -> usize {
        (self.0 >> Self::KIND) as usize
    }

    /// Whether there is no child.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// The index of the node or block among those of its kind; anything if there is no child.
    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & ((1 << Self::KIND) - 1)) as usize
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
            4 => ShapeKind::Solid,
            _ => ShapeKind::Copy,
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

pub(crate) fn half_area(b: &Aabb) -> f32 {
    if b.is_empty() {
        return 0.0;
    }
    let e = [0, 1, 2].map(|k| b.hi[k] - b.lo[k]);
    e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
}
