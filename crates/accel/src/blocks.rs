//! Primitives in lanes: what leaves hold.

use crate::copies::{CopyBlock, MeshTrees};
use crate::items::Item;
use crate::kernels::{self, Candidate, PlaneLanes, QuadLanes, SphereLanes, TriangleLanes};
use crate::lanes::{F, Floats, LANES, RayLanes, W};
use crate::prefetch::{prefer_large_pages, prefetch};
use crate::rays::HitCode;
use crate::slab::{self, BoxLanes};
use fearless_simd::prelude::*;
use rayon::prelude::*;
use reflet_pack::geometry::Columns3;
use reflet_pack::{Aabb, Form, Geometry, ShapeKind, Slot, Solid};

type Lane = [f32; LANES];

/// The boxes of up to eight primitives. Empty lanes have an empty box: no ray hits them. Kept
/// apart from what kernels read, since a box is looked at only where a kernel has passed.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Frame {
    lo: [Lane; 3],
    hi: [Lane; 3],
}

impl Default for Frame {
    fn default() -> Self {
        let e = Aabb::EMPTY;
        Frame { lo: e.lo.map(|x| [x; LANES]), hi: e.hi.map(|x| [x; LANES]) }
    }
}

impl Frame {
    fn set(&mut self, lane: usize, b: &Aabb) {
        for k in 0..3 {
            self.lo[k][lane] = b.lo[k];
            self.hi[k][lane] = b.hi[k];
        }
    }

    /// The box of one lane.
    pub fn bounds(&self, lane: usize) -> Aabb {
        Aabb { lo: [0, 1, 2].map(|k| self.lo[k][lane]), hi: [0, 1, 2].map(|k| self.hi[k][lane]) }
    }

    /// The box of all lanes.
    pub fn union(&self) -> Aabb {
        (0..LANES).fold(Aabb::EMPTY, |all, lane| all.union(&self.bounds(lane)))
    }

    /// The boxes in lanes.
    #[inline(always)]
    pub fn boxes<S: Simd>(&self, simd: S) -> BoxLanes<F<S>> {
        self.pick(simd, Pick::Each)
    }

    /// The boxes in lanes, with the axes in another order.
    #[inline(always)]
    pub fn turned<S: Simd>(&self, simd: S, turn: [usize; 3]) -> BoxLanes<F<S>> {
        let pick = Pick::Each;
        BoxLanes { lo: turned(simd, &self.lo, turn, pick), hi: turned(simd, &self.hi, turn, pick) }
    }

    /// The box of one lane, in all lanes.
    #[inline(always)]
    pub fn box_of<S: Simd>(&self, simd: S, lane: usize) -> BoxLanes<W<S>> {
        self.pick(simd, Pick::One(lane))
    }

    #[inline(always)]
    fn pick<S: Simd, V: Floats<S>>(&self, simd: S, pick: Pick) -> BoxLanes<V> {
        BoxLanes { lo: vectors(simd, &self.lo, pick), hi: vectors(simd, &self.hi, pick) }
    }
}

/// Which lanes of a block are asked for.
#[derive(Clone, Copy)]
pub enum Pick {
    /// Each in its own place.
    Each,
    /// One, in all places.
    One(usize),
}

#[inline(always)]
fn floats<S: Simd, V: Floats<S>>(simd: S, v: &Lane, pick: Pick) -> V {
    match pick {
        Pick::Each => V::from_slice(simd, v),
        Pick::One(lane) => V::splat(simd, v[lane]),
    }
}

#[inline(always)]
fn codes<S: Simd, V: Floats<S>>(simd: S, v: &[u32; LANES], pick: Pick) -> V::Bits {
    match pick {
        Pick::Each => V::Bits::from_slice(simd, v),
        Pick::One(lane) => V::Bits::splat(simd, v[lane]),
    }
}

#[inline(always)]
fn vectors<S: Simd, V: Floats<S>>(simd: S, v: &[Lane; 3], pick: Pick) -> [V; 3] {
    turned(simd, v, [0, 1, 2], pick)
}

/// [`vectors`] with the axes in another order.
#[inline(always)]
fn turned<S: Simd, V: Floats<S>>(simd: S, v: &[Lane; 3], turn: [usize; 3], pick: Pick) -> [V; 3] {
    [
        floats(simd, &v[turn[0]], pick),
        floats(simd, &v[turn[1]], pick),
        floats(simd, &v[turn[2]], pick),
    ]
}

fn put(column: &mut [Lane; 3], lane: usize, v: [f32; 3]) {
    for k in 0..3 {
        column[k][lane] = v[k];
    }
}

#[inline(always)]
fn ask_for3(columns: &Columns3, row: usize) {
    prefetch(&columns.x, row);
    prefetch(&columns.y, row);
    prefetch(&columns.z, row);
}

/// Up to eight primitives of one kind.
pub trait Block: Default + Clone + Send + Sync {
    /// Writes a primitive into a lane.
    fn set(&mut self, lane: usize, g: &Geometry, slot: Slot);
    /// Asks for what [`Block::set`] will read.
    #[inline(always)]
    fn ask_for(_: &Geometry, _: Slot) {}
    /// The code of each lane; [`crate::lanes::NO_PRIM`] where there is none.
    fn codes(&self) -> &[u32; LANES];
    /// Rays in lanes against the primitives of `pick`, place by place.
    fn against<S: Simd, V: Floats<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, V>,
        pick: Pick,
    ) -> Candidate<S, V>;

    /// One ray against all lanes.
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, ray: &RayLanes<S>) -> Candidate<S> {
        self.against(simd, ray, Pick::Each)
    }

    /// Many rays against one lane.
    #[inline(always)]
    fn test_one<S: Simd>(
        &self,
        simd: S,
        ray: &RayLanes<S, W<S>>,
        lane: usize,
    ) -> Candidate<S, W<S>> {
        self.against(simd, ray, Pick::One(lane))
    }
}

/// Spheres.
#[derive(Clone, Debug, Default)]
#[repr(C, align(32))]
pub struct SphereBlock {
    center: [Lane; 3],
    radius: Lane,
    code: [u32; LANES],
}

impl Block for SphereBlock {
    fn set(&mut self, lane: usize, g: &Geometry, slot: Slot) {
        let row = g.shape[slot.index()].1 as usize;
        self.code[lane] = HitCode::outside(g.first_prim(slot)).0;
        put(&mut self.center, lane, g.spheres.center.get(row));
        self.radius[lane] = g.spheres.radius[row];
    }

    #[inline(always)]
    fn ask_for(g: &Geometry, slot: Slot) {
        let row = g.shape[slot.index()].1 as usize;
        ask_for3(&g.spheres.center, row);
        prefetch(&g.spheres.radius, row);
    }

    fn codes(&self) -> &[u32; LANES] {
        &self.code
    }

    #[inline(always)]
    fn against<S: Simd, V: Floats<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, V>,
        pick: Pick,
    ) -> Candidate<S, V> {
        let center = vectors(simd, &self.center, pick);
        let radius = floats(simd, &self.radius, pick);
        let code = codes::<S, V>(simd, &self.code, pick);
        kernels::sphere(simd, ray, &SphereLanes { center, radius, code })
    }
}

/// Infinite planes.
#[derive(Clone, Debug, Default)]
#[repr(C, align(32))]
pub struct PlaneBlock {
    point: [Lane; 3],
    normal: [Lane; 3],
    code: [u32; LANES],
}

impl Block for PlaneBlock {
    fn set(&mut self, lane: usize, g: &Geometry, slot: Slot) {
        let row = g.shape[slot.index()].1 as usize;
        self.code[lane] = HitCode::outside(g.first_prim(slot)).0;
        put(&mut self.point, lane, g.planes.point.get(row));
        put(&mut self.normal, lane, g.planes.normal.get(row));
    }

    fn codes(&self) -> &[u32; LANES] {
        &self.code
    }

    #[inline(always)]
    fn against<S: Simd, V: Floats<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, V>,
        pick: Pick,
    ) -> Candidate<S, V> {
        let (point, normal) = (vectors(simd, &self.point, pick), vectors(simd, &self.normal, pick));
        let code = codes::<S, V>(simd, &self.code, pick);
        kernels::plane(simd, ray, &PlaneLanes { point, normal, code })
    }
}

/// Parallelograms.
#[derive(Clone, Debug, Default)]
#[repr(C, align(32))]
pub struct QuadBlock {
    corners: [[Lane; 3]; 4],
    normal: [Lane; 3],
    code: [u32; LANES],
}

impl Block for QuadBlock {
    fn set(&mut self, lane: usize, g: &Geometry, slot: Slot) {
        let row = g.shape[slot.index()].1 as usize;
        self.code[lane] = HitCode::outside(g.first_prim(slot)).0;
        for (column, corner) in self.corners.iter_mut().zip(&g.quads.corners) {
            put(column, lane, corner.get(row));
        }
        put(&mut self.normal, lane, g.quads.normal.get(row));
    }

    fn codes(&self) -> &[u32; LANES] {
        &self.code
    }

    #[inline(always)]
    fn against<S: Simd, V: Floats<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, V>,
        pick: Pick,
    ) -> Candidate<S, V> {
        let (c, turn) = (&self.corners, ray.turn);
        let corners = [
            turned(simd, &c[0], turn, pick),
            turned(simd, &c[1], turn, pick),
            turned(simd, &c[2], turn, pick),
            turned(simd, &c[3], turn, pick),
        ];
        let (point, normal) = (vectors(simd, &c[0], pick), vectors(simd, &self.normal, pick));
        let code = codes::<S, V>(simd, &self.code, pick);
        kernels::quad(simd, ray, &QuadLanes { corners, point, normal, code })
    }
}

/// Triangles.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    corners: [[Lane; 3]; 3],
    code: [u32; LANES],
}

impl TriangleBlock {
    /// A corner of all lanes.
    pub(crate) fn corner(&self, i: usize) -> &[Lane; 3] {
        &self.corners[i]
    }

    pub(crate) fn corner_mut(&mut self, i: usize) -> &mut [Lane; 3] {
        &mut self.corners[i]
    }

    pub(crate) fn codes_mut(&mut self) -> &mut [u32; LANES] {
        &mut self.code
    }

    /// The corners of one lane.
    pub(crate) fn corners(&self, lane: usize) -> [[f32; 3]; 3] {
        let at = |c: &[Lane; 3]| [c[0][lane], c[1][lane], c[2][lane]];
        [at(&self.corners[0]), at(&self.corners[1]), at(&self.corners[2])]
    }
}

impl Block for TriangleBlock {
    fn set(&mut self, lane: usize, g: &Geometry, slot: Slot) {
        let row = g.shape[slot.index()].1 as usize;
        self.code[lane] = HitCode::outside(g.first_prim(slot)).0;
        for (column, corner) in self.corners.iter_mut().zip(&g.triangles.corners) {
            put(column, lane, corner.get(row));
        }
    }

    #[inline(always)]
    fn ask_for(g: &Geometry, slot: Slot) {
        let row = g.shape[slot.index()].1 as usize;
        for corner in &g.triangles.corners {
            ask_for3(corner, row);
        }
    }

    fn codes(&self) -> &[u32; LANES] {
        &self.code
    }

    #[inline(always)]
    fn against<S: Simd, V: Floats<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, V>,
        pick: Pick,
    ) -> Candidate<S, V> {
        let (c, turn) = (&self.corners, ray.turn);
        let corners = [
            turned(simd, &c[0], turn, pick),
            turned(simd, &c[1], turn, pick),
            turned(simd, &c[2], turn, pick),
        ];
        let code = codes::<S, V>(simd, &self.code, pick);
        kernels::triangle(simd, ray, &TriangleLanes { corners, code })
    }
}

/// Solids. Their kernel is dear, so that it is asked only where the ray passes the box.
#[derive(Clone, Debug)]
pub struct SolidBlock {
    rows: [Solid; LANES],
    frame: Frame,
    code: [u32; LANES],
}

impl Default for SolidBlock {
    fn default() -> Self {
        let row = Solid { form: Form::Disc, local: [[0.0; 4]; 3] };
        SolidBlock { rows: [row; LANES], frame: Frame::default(), code: [0; LANES] }
    }
}

impl Block for SolidBlock {
    fn set(&mut self, lane: usize, g: &Geometry, slot: Slot) {
        self.code[lane] = HitCode::outside(g.first_prim(slot)).0;
        self.rows[lane] = g.solids.rows[g.shape[slot.index()].1 as usize];
        self.frame.set(lane, &g.bounds[slot.index()]);
    }

    fn codes(&self) -> &[u32; LANES] {
        &self.code
    }

    #[inline(always)]
    fn against<S: Simd, V: Floats<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, V>,
        pick: Pick,
    ) -> Candidate<S, V> {
        let (_, passes) = slab::enter(simd, ray, &self.frame.pick::<S, V>(simd, pick));
        let code = codes::<S, V>(simd, &self.code, pick);
        kernels::solids(simd, ray, (&self.rows, pick), (code, passes))
    }
}

/// Blocks of one kind, and the boxes of what they hold, a frame a block.
#[derive(Clone, Debug, Default)]
pub struct Shelf<B> {
    /// The blocks.
    pub blocks: Vec<B>,
    /// Their frames.
    pub frames: Vec<Frame>,
}

impl<B: Block> Shelf<B> {
    fn push(&mut self, g: &Geometry, slots: &[Slot]) {
        let index = self.blocks.len();
        self.blocks.push(B::default());
        self.frames.push(Frame::default());
        for (lane, slot) in slots.iter().enumerate() {
            self.set(index, lane, g, *slot);
        }
    }

    fn set(&mut self, block: usize, lane: usize, g: &Geometry, slot: Slot) {
        self.blocks[block].set(lane, g, slot);
        self.frames[block].set(lane, &g.bounds[slot.index()]);
    }

    /// Makes all blocks at once, on all threads.
    fn fill(&mut self, g: &Geometry, items: &[Item], leaves: &[Leaf]) {
        let items_of = |leaf: &Leaf| &items[leaf.first..][..leaf.len];
        // What is near in space may be anywhere in the columns.
        let block = |(index, leaf): (usize, &Leaf)| {
            if let Some(next) = leaves.get(index + 2) {
                items_of(next).iter().for_each(|item| prefetch(&g.shape, item.slot().index()));
            }
            if let Some(next) = leaves.get(index + 1) {
                items_of(next).iter().for_each(|item| B::ask_for(g, item.slot()));
            }
            let (mut block, mut frame) = (B::default(), Frame::default());
            for (lane, item) in items_of(leaf).iter().enumerate() {
                block.set(lane, g, item.slot());
                frame.set(lane, &item.aabb());
            }
            (block, frame)
        };
        self.blocks.reserve_exact(leaves.len());
        prefer_large_pages(self.blocks.spare_capacity_mut());
        self.frames.reserve_exact(leaves.len());
        prefer_large_pages(self.frames.spare_capacity_mut());
        let all = leaves.par_iter().enumerate().with_min_len(256).map(block);
        all.unzip_into_vecs(&mut self.blocks, &mut self.frames);
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.blocks[..]) + size_of_val(&self.frames[..])
    }
}

/// What a block is made from: a part of a list of items.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// Where it begins.
    pub first: usize,
    /// How many there are, at most eight.
    pub len: usize,
}

/// All primitives in lanes, a shelf a kind.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    /// Spheres.
    pub spheres: Shelf<SphereBlock>,
    /// Infinite planes.
    pub planes: Shelf<PlaneBlock>,
    /// Parallelograms.
    pub quads: Shelf<QuadBlock>,
    /// Triangles.
    pub triangles: Shelf<TriangleBlock>,
    /// Solids.
    pub solids: Shelf<SolidBlock>,
    /// Copies of meshes, one a block.
    pub copies: Vec<CopyBlock>,
}

impl Blocks {
    /// Whether they hold nothing.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.spheres.blocks.is_empty()
            && self.planes.blocks.is_empty()
            && self.quads.blocks.is_empty()
            && self.triangles.blocks.is_empty()
            && self.solids.blocks.is_empty()
            && self.copies.is_empty()
    }

    /// Bytes that they hold.
    pub fn bytes(&self) -> usize {
        let flat = self.planes.bytes() + self.quads.bytes() + self.triangles.bytes();
        flat + self.spheres.bytes() + self.solids.bytes() + size_of_val(&self.copies[..])
    }

    /// How many blocks there are of a kind.
    pub fn len(&self, kind: ShapeKind) -> usize {
        match kind {
            ShapeKind::Sphere => self.spheres.blocks.len(),
            ShapeKind::Plane => self.planes.blocks.len(),
            ShapeKind::Quad => self.quads.blocks.len(),
            ShapeKind::Triangle => self.triangles.blocks.len(),
            ShapeKind::Solid => self.solids.blocks.len(),
            ShapeKind::Copy => self.copies.len(),
        }
    }

    /// The code of each lane of a block; 0 where there is no primitive.
    pub fn codes(&self, kind: ShapeKind, block: usize) -> &[u32; LANES] {
        match kind {
            ShapeKind::Sphere => self.spheres.blocks[block].codes(),
            ShapeKind::Plane => self.planes.blocks[block].codes(),
            ShapeKind::Quad => self.quads.blocks[block].codes(),
            ShapeKind::Triangle => self.triangles.blocks[block].codes(),
            ShapeKind::Solid => self.solids.blocks[block].codes(),
            ShapeKind::Copy => self.copies[block].codes(),
        }
    }

    /// The box of all of a block.
    pub fn bounds(&self, kind: ShapeKind, block: usize) -> Aabb {
        match kind {
            ShapeKind::Sphere => self.spheres.frames[block].union(),
            ShapeKind::Plane => self.planes.frames[block].union(),
            ShapeKind::Quad => self.quads.frames[block].union(),
            ShapeKind::Triangle => self.triangles.frames[block].union(),
            ShapeKind::Solid => self.solids.frames[block].union(),
            ShapeKind::Copy => self.copies[block].bounds(),
        }
    }

    /// Writes a primitive into a lane, or a copy into its block.
    pub fn set(&mut self, kind: ShapeKind, block: usize, lane: usize, g: &Geometry, slot: Slot) {
        match kind {
            ShapeKind::Sphere => self.spheres.set(block, lane, g, slot),
            ShapeKind::Plane => self.planes.set(block, lane, g, slot),
            ShapeKind::Quad => self.quads.set(block, lane, g, slot),
            ShapeKind::Triangle => self.triangles.set(block, lane, g, slot),
            ShapeKind::Solid => self.solids.set(block, lane, g, slot),
            ShapeKind::Copy => self.copies[block].place(g, slot),
        }
    }

    /// Makes a block of each of `leaves`, in place of all blocks of their kind.
    pub fn fill(
        &mut self,
        kind: ShapeKind,
        g: &Geometry,
        items: &[Item],
        leaves: &[Leaf],
        meshes: &MeshTrees,
    ) {
        match kind {
            ShapeKind::Sphere => self.spheres.fill(g, items, leaves),
            ShapeKind::Plane => self.planes.fill(g, items, leaves),
            ShapeKind::Quad => self.quads.fill(g, items, leaves),
            ShapeKind::Triangle => self.triangles.fill(g, items, leaves),
            ShapeKind::Solid => self.solids.fill(g, items, leaves),
            ShapeKind::Copy => {
                let copy = |leaf: &Leaf| CopyBlock::new(g, items[leaf.first].slot(), meshes);
                self.copies = leaves.iter().map(copy).collect();
            }
        }
    }

    /// Appends blocks of all of `slots`, which are of one kind.
    pub fn push(&mut self, kind: ShapeKind, g: &Geometry, slots: &[Slot], meshes: &MeshTrees) {
        let blocks = slots.chunks(LANES);
        match kind {
            ShapeKind::Sphere => blocks.for_each(|some| self.spheres.push(g, some)),
            ShapeKind::Plane => blocks.for_each(|some| self.planes.push(g, some)),
            ShapeKind::Quad => blocks.for_each(|some| self.quads.push(g, some)),
            ShapeKind::Triangle => blocks.for_each(|some| self.triangles.push(g, some)),
            ShapeKind::Solid => blocks.for_each(|some| self.solids.push(g, some)),
            ShapeKind::Copy => {
                self.copies.extend(slots.iter().map(|slot| CopyBlock::new(g, *slot, meshes)));
            }
        }
    }
}
