//! Primitives in lanes: what leaves hold.

use crate::kernels::{self, Candidate, PlaneLanes, QuadLanes, SphereLanes, TriangleLanes};
use crate::lanes::{F, LANES, Permute, RayLanes, U, V3};
use crate::rays::HitCode;
use crate::slab::BoxLanes;
use fearless_simd::prelude::*;
use reflet_pack::{Aabb, Geometry, PrimId, ShapeKind};

type Lane = [f32; LANES];

/// The boxes and codes of up to eight primitives. Empty lanes have an empty box: no ray hits them.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Frame {
    lo: [Lane; 3],
    hi: [Lane; 3],
    code: [u32; LANES],
    /// How many lanes hold a primitive; they come first.
    used: usize,
}

impl Default for Frame {
    fn default() -> Self {
        let e = Aabb::EMPTY;
        Frame {
            lo: e.lo.map(|x| [x; LANES]),
            hi: e.hi.map(|x| [x; LANES]),
            code: [HitCode::NONE.0; LANES],
            used: 0,
        }
    }
}

impl Frame {
    fn set(&mut self, lane: usize, g: &Geometry, prim: PrimId) {
        let b = &g.bounds[prim.index()];
        for k in 0..3 {
            self.lo[k][lane] = b.lo[k];
            self.hi[k][lane] = b.hi[k];
        }
        self.code[lane] = HitCode::outside(prim).0;
        self.used = self.used.max(lane + 1);
    }

    /// The boxes.
    #[inline(always)]
    pub fn boxes<S: Simd>(&self, simd: S) -> BoxLanes<S> {
        BoxLanes { lo: lanes(simd, &self.lo), hi: lanes(simd, &self.hi) }
    }

    #[inline(always)]
    fn boxes_of<S: Simd>(&self, simd: S, lane: usize) -> BoxLanes<S> {
        BoxLanes { lo: splat(simd, &self.lo, lane), hi: splat(simd, &self.hi, lane) }
    }

    #[inline(always)]
    fn codes<S: Simd>(&self, simd: S) -> U<S> {
        U::from_slice(simd, &self.code)
    }

    #[inline(always)]
    fn code_of<S: Simd>(&self, simd: S, lane: usize) -> U<S> {
        U::splat(simd, self.code[lane])
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, v: &[Lane; 3]) -> V3<S> {
    [F::from_slice(simd, &v[0]), F::from_slice(simd, &v[1]), F::from_slice(simd, &v[2])]
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: &[Lane; 3], lane: usize) -> V3<S> {
    [F::splat(simd, v[0][lane]), F::splat(simd, v[1][lane]), F::splat(simd, v[2][lane])]
}

fn put(column: &mut [Lane; 3], lane: usize, v: [f32; 3]) {
    for k in 0..3 {
        column[k][lane] = v[k];
    }
}

/// Up to eight primitives of one kind.
pub trait Block: Default + Clone + Send + Sync {
    /// Writes a primitive into a lane.
    fn set(&mut self, lane: usize, g: &Geometry, prim: PrimId);
    /// Boxes and codes.
    fn frame(&self) -> &Frame;
    /// One ray against all lanes.
    fn test<S: Simd, P: Permute<S>>(&self, simd: S, ray: &RayLanes<S, P>) -> Candidate<S>;
    /// Eight rays against one lane.
    fn test_one<S: Simd, P: Permute<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, P>,
        lane: usize,
    ) -> Candidate<S>;
    /// The box of one lane, in all lanes.
    #[inline(always)]
    fn box_of<S: Simd>(&self, simd: S, lane: usize) -> BoxLanes<S> {
        self.frame().boxes_of(simd, lane)
    }
    /// How many of the lanes hold a primitive; they come first.
    #[inline(always)]
    fn used(&self) -> usize {
        self.frame().used
    }
}

/// Spheres.
#[derive(Clone, Debug, Default)]
pub struct SphereBlock {
    frame: Frame,
    center: [Lane; 3],
    radius: Lane,
}

impl Block for SphereBlock {
    fn set(&mut self, lane: usize, g: &Geometry, prim: PrimId) {
        let row = g.shape[prim.index()].1 as usize;
        self.frame.set(lane, g, prim);
        put(&mut self.center, lane, g.spheres.center.get(row));
        self.radius[lane] = g.spheres.radius[row];
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn test<S: Simd, P: Permute<S>>(&self, simd: S, ray: &RayLanes<S, P>) -> Candidate<S> {
        let center = lanes(simd, &self.center);
        let radius = F::from_slice(simd, &self.radius);
        kernels::sphere(simd, ray, &SphereLanes { center, radius, code: self.frame.codes(simd) })
    }

    #[inline(always)]
    fn test_one<S: Simd, P: Permute<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, P>,
        lane: usize,
    ) -> Candidate<S> {
        let center = splat(simd, &self.center, lane);
        let radius = F::splat(simd, self.radius[lane]);
        kernels::sphere(
            simd,
            ray,
            &SphereLanes { center, radius, code: self.frame.code_of(simd, lane) },
        )
    }
}

/// Infinite planes.
#[derive(Clone, Debug, Default)]
pub struct PlaneBlock {
    frame: Frame,
    point: [Lane; 3],
    normal: [Lane; 3],
}

impl Block for PlaneBlock {
    fn set(&mut self, lane: usize, g: &Geometry, prim: PrimId) {
        let row = g.shape[prim.index()].1 as usize;
        self.frame.set(lane, g, prim);
        put(&mut self.point, lane, g.planes.point.get(row));
        put(&mut self.normal, lane, g.planes.normal.get(row));
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn test<S: Simd, P: Permute<S>>(&self, simd: S, ray: &RayLanes<S, P>) -> Candidate<S> {
        let (point, normal) = (lanes(simd, &self.point), lanes(simd, &self.normal));
        kernels::plane(simd, ray, &PlaneLanes { point, normal, code: self.frame.codes(simd) })
    }

    #[inline(always)]
    fn test_one<S: Simd, P: Permute<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, P>,
        lane: usize,
    ) -> Candidate<S> {
        let (point, normal) = (splat(simd, &self.point, lane), splat(simd, &self.normal, lane));
        kernels::plane(
            simd,
            ray,
            &PlaneLanes { point, normal, code: self.frame.code_of(simd, lane) },
        )
    }
}

/// Parallelograms.
#[derive(Clone, Debug, Default)]
pub struct QuadBlock {
    frame: Frame,
    corners: [[Lane; 3]; 4],
    normal: [Lane; 3],
}

impl Block for QuadBlock {
    fn set(&mut self, lane: usize, g: &Geometry, prim: PrimId) {
        let row = g.shape[prim.index()].1 as usize;
        self.frame.set(lane, g, prim);
        for (column, p) in self.corners.iter_mut().zip(g.quads.points(row)) {
            put(column, lane, p);
        }
        put(&mut self.normal, lane, g.quads.normal.get(row));
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn test<S: Simd, P: Permute<S>>(&self, simd: S, ray: &RayLanes<S, P>) -> Candidate<S> {
        let c = &self.corners;
        let corners =
            [lanes(simd, &c[0]), lanes(simd, &c[1]), lanes(simd, &c[2]), lanes(simd, &c[3])];
        let normal = lanes(simd, &self.normal);
        kernels::quad(simd, ray, &QuadLanes { corners, normal, code: self.frame.codes(simd) })
    }

    #[inline(always)]
    fn test_one<S: Simd, P: Permute<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, P>,
        lane: usize,
    ) -> Candidate<S> {
        let c = &self.corners;
        let at = |i: usize| splat(simd, &c[i], lane);
        let corners = [at(0), at(1), at(2), at(3)];
        let normal = splat(simd, &self.normal, lane);
        kernels::quad(
            simd,
            ray,
            &QuadLanes { corners, normal, code: self.frame.code_of(simd, lane) },
        )
    }
}

/// Triangles.
#[derive(Clone, Debug, Default)]
pub struct TriangleBlock {
    frame: Frame,
    corners: [[Lane; 3]; 3],
}

impl Block for TriangleBlock {
    fn set(&mut self, lane: usize, g: &Geometry, prim: PrimId) {
        let row = g.shape[prim.index()].1 as usize;
        self.frame.set(lane, g, prim);
        for (column, p) in self.corners.iter_mut().zip(g.triangles.points(row)) {
            put(column, lane, p);
        }
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn test<S: Simd, P: Permute<S>>(&self, simd: S, ray: &RayLanes<S, P>) -> Candidate<S> {
        let c = &self.corners;
        let corners = [lanes(simd, &c[0]), lanes(simd, &c[1]), lanes(simd, &c[2])];
        kernels::triangle(simd, ray, &TriangleLanes { corners, code: self.frame.codes(simd) })
    }

    #[inline(always)]
    fn test_one<S: Simd, P: Permute<S>>(
        &self,
        simd: S,
        ray: &RayLanes<S, P>,
        lane: usize,
    ) -> Candidate<S> {
        let c = &self.corners;
        let corners =
            [splat(simd, &c[0], lane), splat(simd, &c[1], lane), splat(simd, &c[2], lane)];
        kernels::triangle(
            simd,
            ray,
            &TriangleLanes { corners, code: self.frame.code_of(simd, lane) },
        )
    }
}

/// All primitives in lanes, a list a kind.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    /// Spheres.
    pub spheres: Vec<SphereBlock>,
    /// Infinite planes.
    pub planes: Vec<PlaneBlock>,
    /// Parallelograms.
    pub quads: Vec<QuadBlock>,
    /// Triangles.
    pub triangles: Vec<TriangleBlock>,
}

impl Blocks {
    /// Bytes that they hold.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.spheres[..])
            + size_of_val(&self.planes[..])
            + size_of_val(&self.quads[..])
            + size_of_val(&self.triangles[..])
    }

    /// Puts up to eight primitives of one kind into a new block and gives its index.
    pub fn push(&mut self, kind: ShapeKind, g: &Geometry, prims: &[PrimId]) -> usize {
        match kind {
            ShapeKind::Sphere => push(&mut self.spheres, g, prims),
            ShapeKind::Plane => push(&mut self.planes, g, prims),
            ShapeKind::Quad => push(&mut self.quads, g, prims),
            ShapeKind::Triangle => push(&mut self.triangles, g, prims),
        }
    }
}

fn push<B: Block>(list: &mut Vec<B>, g: &Geometry, prims: &[PrimId]) -> usize {
    let mut block = B::default();
    for (lane, prim) in prims.iter().enumerate() {
        block.set(lane, g, *prim);
    }
    list.push(block);
    list.len() - 1
}
