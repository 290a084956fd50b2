//! Copies of meshes: one tree of the file's own triangles serves all of them.
//!
//! The tree is kept in the file's coordinates. A ray stays in the scene's: each box that it is held
//! against is put into the scene on the way, as the box of its moved corners, widened by more than
//! rounding can err; so it holds the own boxes of all triangles below, and leaves out no hit. The
//! triangles of a leaf are put there with the bits that they would be stored with ([`put`]). A copy
//! is therefore hit as if its triangles were stored, to the bit, whatever moves it.

use crate::blocks::{Block, Blocks, Frame, TriangleBlock};
use crate::brute;
use crate::build::{self, Quality};
use crate::lanes::{F, LANES, NO_PRIM, RayLanes};
use crate::rays::HitCode;
use crate::slab::BoxLanes;
use crate::stream::Below;
use crate::tree::{Node, Tree};
use fearless_simd::Level;
use fearless_simd::prelude::*;
use reflet_pack::copies::{World, facing, put};
use reflet_pack::{Aabb, Geometry, MeshCopy, MeshData, ShapeKind, Slot};
use std::collections::HashMap;
use std::sync::Arc;

/// A mesh's own triangles in the file's coordinates, and the tree over them.
#[derive(Debug)]
pub struct MeshTree {
    data: Arc<MeshData>,
    /// Its nodes; the root stands for the whole mesh.
    pub tree: Tree,
    /// Its leaves; codes count from the mesh's first triangle.
    pub blocks: Blocks,
}

impl MeshTree {
    fn new(data: &Arc<MeshData>, level: Level, quality: Quality) -> MeshTree {
        let mut geometry = Geometry::default();
        for t in &data.triangles {
            geometry.push_candidate(t.map(|v| data.positions[v as usize]));
        }
        let mut blocks = Blocks::default();
        let tree = build::build(&geometry, (level, quality), &mut blocks, &MeshTrees::default());
        MeshTree { data: data.clone(), tree, blocks }
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        self.blocks.bytes() + size_of_val(&self.tree.nodes[..])
    }
}

/// The trees of all meshes that have copies, by the address of their triangles.
#[derive(Clone, Debug, Default)]
pub struct MeshTrees(HashMap<usize, Arc<MeshTree>>);

impl MeshTrees {
    /// Builds those that are missing, and drops those that no copy needs.
    pub fn follow(&mut self, g: &Geometry, level: Level, quality: Quality) {
        let mut needed = HashMap::new();
        for copy in &g.copies {
            let data = &copy.mesh.data;
            needed.entry(Arc::as_ptr(data) as usize).or_insert(data);
        }
        self.0.retain(|address, _| needed.contains_key(address));
        for (address, data) in needed {
            let build = || Arc::new(MeshTree::new(data, level, quality));
            self.0.entry(address).or_insert_with(build);
        }
    }

    fn of(&self, copy: &MeshCopy) -> &Arc<MeshTree> {
        // Followed before anything is built from the same geometry.
        &self.0[&(Arc::as_ptr(&copy.mesh.data) as usize)]
    }

    /// What leaves that are copies stand for.
    pub fn below(&self, g: &Geometry) -> Below {
        Below {
            depth: self.0.values().map(|mesh| mesh.tree.depth).max().unwrap_or_default(),
            nodes: g.copies.iter().map(|copy| self.of(copy).tree.nodes.len()).sum(),
        }
    }

    /// Bytes that they hold.
    pub fn bytes(&self) -> usize {
        self.0.values().map(|mesh| mesh.bytes()).sum()
    }
}

/// A copy as a leaf.
#[derive(Clone, Debug)]
pub struct CopyBlock {
    /// That of its first triangle.
    code: [u32; LANES],
    /// What it is a copy of.
    pub mesh: Arc<MeshTree>,
    world: World,
    /// `world`, rounded; its last column less and more what boxes are widened by.
    turn: [[f32; 3]; 3],
    least: [f32; 3],
    most: [f32; 3],
    bounds: Aabb,
}

impl CopyBlock {
    pub(crate) fn new(g: &Geometry, slot: Slot, meshes: &MeshTrees) -> CopyBlock {
        let copy = &g.copies[g.shape[slot.index()].1 as usize];
        let mut code = [NO_PRIM.0; LANES];
        code[0] = HitCode::outside(g.first_prim(slot)).0;
        let mut block = CopyBlock {
            code,
            mesh: meshes.of(copy).clone(),
            world: copy.world,
            turn: [[0.0; 3]; 3],
            least: [0.0; 3],
            most: [0.0; 3],
            bounds: Aabb::EMPTY,
        };
        block.place(g, slot);
        block
    }

    /// Takes over where the copy is now.
    pub(crate) fn place(&mut self, g: &Geometry, slot: Slot) {
        self.bounds = g.bounds[slot.index()];
        self.world = g.copies[g.shape[slot.index()].1 as usize].world;
        let root = self.mesh.tree.nodes.first().map_or(Aabb::EMPTY, Node::union);
        let (mut edge, mut size) = (0.0f64, [0.0; 3]);
        for (k, w) in self.world.iter().enumerate() {
            size[k] = w[3].abs();
            let mut own = 0.0;
            for (j, by) in w[..3].iter().enumerate() {
                let (lo, hi) = (f64::from(root.lo[j]), f64::from(root.hi[j]));
                size[k] += by.abs() * lo.abs().max(hi.abs());
                own += by.abs() * (hi - lo);
                self.turn[k][j] = *by as f32;
            }
            edge = edge.max(own);
        }
        // A triangle's own box is wider than its exact corners by 2^-21 of an edge and less than
        // 4 units in the last place (2^-24) of a coordinate; what is computed in `faces` errs by
        // less than 10.
        for (k, size) in size.into_iter().enumerate() {
            let wider = (edge + size) / f64::from(1 << 20);
            self.least[k] = (self.world[k][3] - wider) as f32;
            self.most[k] = (self.world[k][3] + wider) as f32;
        }
    }

    pub(crate) fn codes(&self) -> &[u32; LANES] {
        &self.code
    }

    /// The box of all of it; empty while it is invisible.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Whether it shows the same mesh as a slot.
    pub(crate) fn is_of(&self, g: &Geometry, slot: Slot) -> bool {
        let row = g.shape[slot.index()].1 as usize;
        g.copies.get(row).is_some_and(|copy| Arc::ptr_eq(&copy.mesh.data, &self.mesh.data))
    }

    /// Boxes of the mesh, put into the scene.
    #[inline(always)]
    fn faces<S: Simd>(&self, simd: S, b: &BoxLanes<F<S>>) -> BoxLanes<F<S>> {
        let mut out = *b;
        // No number times infinity: an empty lane stays empty.
        let full = b.lo[0].simd_le(b.hi[0]);
        for k in 0..3 {
            let (mut lo, mut hi) = (F::splat(simd, 0.0), F::splat(simd, 0.0));
            for j in 0..3 {
                let by = self.turn[k][j];
                let (first, last) = if by < 0.0 { (b.hi[j], b.lo[j]) } else { (b.lo[j], b.hi[j]) };
                lo += first * by;
                hi += last * by;
            }
            out.lo[k] = full.select(lo + self.least[k], F::splat(simd, f32::INFINITY));
            out.hi[k] = full.select(hi + self.most[k], F::splat(simd, f32::NEG_INFINITY));
        }
        out
    }

    /// The boxes of a node's children, put into the scene.
    #[inline(always)]
    pub fn children<S: Simd>(&self, simd: S, node: &Node) -> BoxLanes<F<S>> {
        let b = BoxLanes {
            lo: [node.faces(simd, 0), node.faces(simd, 1), node.faces(simd, 2)],
            hi: [node.faces(simd, 4), node.faces(simd, 5), node.faces(simd, 6)],
        };
        self.faces(simd, &b)
    }

    /// Boxes that hold the own boxes of a leaf's triangles, in the scene.
    #[inline(always)]
    pub fn around<S: Simd>(&self, simd: S, frame: &Frame) -> BoxLanes<F<S>> {
        self.faces(simd, &frame.boxes(simd))
    }

    /// Puts a leaf's triangles into the scene, as if they were stored.
    #[inline(always)]
    pub fn place_leaf(&self, block: usize, out: &mut PlacedTriangles) {
        let own = &self.mesh.blocks.triangles.blocks[block];
        own.put_into(&self.world, self.code[0] - HitCode::FIRST.0, &mut out.0);
    }
}

/// Triangles of a copy on their way through kernels.
#[derive(Clone, Debug, Default)]
pub struct PlacedTriangles(TriangleBlock);

impl PlacedTriangles {
    /// They, as kernels take them.
    pub fn block(&self) -> &TriangleBlock {
        &self.0
    }

    /// The own box of one lane; empty if its triangle has no area.
    pub fn bounds(&self, lane: usize) -> Aabb {
        facing(self.0.corners(lane)).1
    }

    /// Where the ray in all lanes hits the triangle of one, by the definition, if its kernel gives
    /// `t`.
    #[inline(always)]
    pub fn enter<S: Simd>(&self, ray: &RayLanes<S>, lane: usize, t: f32) -> Option<f32> {
        let at = |v: &[F<S>; 3]| [v[0].as_slice()[0], v[1].as_slice()[0], v[2].as_slice()[0]];
        let entry = brute::enter(at(&ray.o), at(&ray.d), &self.bounds(lane))?;
        Some(if entry > t { entry } else { t })
    }
}

impl TriangleBlock {
    /// Puts the same triangles elsewhere, their codes raised.
    #[inline(always)]
    fn put_into(&self, world: &World, code: u32, out: &mut TriangleBlock) {
        for corner in 0..3 {
            let (from, to) = (self.corner(corner), out.corner_mut(corner));
            for lane in 0..LANES {
                let p = put(world, [from[0][lane], from[1][lane], from[2][lane]]);
                to[0][lane] = p[0];
                to[1][lane] = p[1];
                to[2][lane] = p[2];
            }
        }
        for (to, own) in out.codes_mut().iter_mut().zip(self.codes()) {
            *to = if *own == NO_PRIM.0 { *own } else { *own + code };
        }
    }
}

/// Whether a kind's leaves hold one row each.
pub(crate) fn stands_alone(kind: ShapeKind) -> bool {
    kind == ShapeKind::Copy
}
