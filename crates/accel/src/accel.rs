//! All of it behind two calls.

use crate::blocks::Blocks;
use crate::build::{self, Quality};
use crate::copies::MeshTrees;
use crate::count::Work;
use crate::lanes::WIDE;
use crate::rays::{HitCode, Hits, Question, RayCounts, Rays};
use crate::refit::{Places, Refit, WORN};
use crate::stream::{self, Below, Memory, Structures, Way};
use crate::tree::Tree;
use fearless_simd::{Fallback, Level, Simd, dispatch};
use reflet_pack::{Geometry, ShapeKind, Slot};

/// How primitives are kept. The answer does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Structure {
    /// Whichever suits the number of primitives.
    #[default]
    Auto,
    /// A list: rays in lanes against one primitive after the other.
    List,
    /// A tree, but for infinite planes: one ray at a time against eight boxes.
    Tree,
}

/// What rays are intersected with.
pub struct Accel {
    level: Level,
    /// What every ray is tested against.
    list: Blocks,
    /// What the tree's leaves hold.
    leaves: Blocks,
    tree: Tree,
    /// What copies of meshes share.
    meshes: MeshTrees,
    below: Below,
    structure: Structure,
    quality: Quality,
    way: Way,
    /// How many slots it was built from, visible or not.
    slots: usize,
    /// The area of the tree's boxes when it was built.
    area: f32,
    /// Found when something moves for the first time.
    places: Option<Places>,
}

/// Up to this many bounded primitives a list is quicker than a tree.
const LIST: usize = 24;

impl Accel {
    /// Builds over all visible primitives.
    pub fn build(geometry: &Geometry, level: Level, structure: Structure) -> Accel {
        Accel::build_as(geometry, level, structure, Quality::default())
    }

    /// The same, with a tree of some quality.
    pub fn build_as(
        geometry: &Geometry,
        level: Level,
        structure: Structure,
        quality: Quality,
    ) -> Accel {
        Accel::build_with(geometry, level, structure, quality, MeshTrees::default())
    }

    /// The same, with the trees of meshes as far as they are there.
    fn build_with(
        geometry: &Geometry,
        level: Level,
        structure: Structure,
        quality: Quality,
        mut meshes: MeshTrees,
    ) -> Accel {
        meshes.follow(geometry, level, quality);
        let visible = |kind: ShapeKind| {
            let of_kind = |s: &Slot| geometry.shape[s.index()].0 == kind && geometry.is_visible(*s);
            geometry.slots().filter(of_kind).collect::<Vec<_>>()
        };
        let mut list = Blocks::default();
        list.push(ShapeKind::Plane, geometry, &visible(ShapeKind::Plane), &meshes);
        let bounded = geometry.len() - geometry.planes.len();
        let as_list = match structure {
            Structure::Auto => bounded <= LIST && geometry.copies.is_empty(),
            Structure::List => true,
            Structure::Tree => false,
        };
        let (mut leaves, mut tree) = (Blocks::default(), Tree::default());
        if as_list {
            for kind in ShapeKind::ALL.into_iter().filter(|kind| *kind != ShapeKind::Plane) {
                list.push(kind, geometry, &visible(kind), &meshes);
            }
        } else {
            tree = build::build(geometry, (level, quality), &mut leaves, &meshes);
        }
        let area = tree.area();
        Accel {
            level,
            list,
            leaves,
            tree,
            structure,
            quality,
            way: Way::Auto,
            below: meshes.below(geometry),
            meshes,
            slots: geometry.len(),
            area,
            places: None,
        }
    }

    /// Sends all rays one way, whatever they are; for tests and measurements.
    pub fn cast_by(&mut self, way: Way) {
        self.way = way;
    }

    /// Takes over where `moved` is now in `geometry`: its shape, or whether it is visible. All others must be as they were. Hits are then those of a structure that was
    /// built from `geometry`.
    ///
    /// Boxes are refitted, about a microsecond a primitive; the whole is built again, on all
    /// threads of the pool that this is called in, if primitives were added or removed, are of
    /// another kind, or are visible for the first time since the structure was built, when most of
    /// very many have moved, which a new tree costs no more than, and when the boxes have grown to
    /// [`WORN`] times their area.
    pub fn refit(&mut self, geometry: &Geometry, moved: &[Slot]) -> Refit {
        if geometry.len() == self.slots && !outnumber(moved.len(), self.slots) {
            let Accel { list, leaves, tree, places, .. } = self;
            let places = places.get_or_insert_with(|| Places::find(geometry, list, leaves, tree));
            let done = places.refit(geometry, moved, (list, leaves, tree));
            // A NaN (of boxes that overflow) is no quality, either.
            if done && tree.area() <= WORN * self.area {
                return Refit::Refitted;
            }
        }
        let (way, meshes) = (self.way, std::mem::take(&mut self.meshes));
        let (level, structure, quality) = (self.level, self.structure, self.quality);
        *self = Accel::build_with(geometry, level, structure, quality, meshes);
        self.way = way;
        Refit::Rebuilt
    }

    /// Finds the closest hit of each ray. `hits` gets as many rows as `rays` has, padded to whole
    /// lanes; a ray that hits nothing before its end has no code and its own end as t.
    ///
    /// # Panics
    /// If the columns of `rays` are not padded ([`Rays::pad`]).
    pub fn closest(
        &self,
        rays: &Rays,
        hits: &mut Hits,
        scratch: &mut Scratch,
        counts: &mut RayCounts,
    ) {
        counts.closest += rays.len() as u64;
        self.cast(rays, Question::Closest, hits, scratch);
    }

    /// Finds which rays hit anything before their end; `occluded` gets as many rows as `rays` has.
    ///
    /// # Panics
    /// If the columns of `rays` are not padded ([`Rays::pad`]).
    pub fn any(
        &self,
        rays: &Rays,
        occluded: &mut Vec<bool>,
        scratch: &mut Scratch,
        counts: &mut RayCounts,
    ) {
        counts.any += rays.len() as u64;
        let mut hits = std::mem::take(&mut scratch.hits);
        self.cast(rays, Question::Any, &mut hits, scratch);
        occluded.clear();
        occluded.extend(hits.code[..rays.len()].iter().map(|code| !code.is_none()));
        scratch.hits = hits;
    }

    /// Casts rays with all that it takes counted: at the scalar level, whose steps are those of any
    /// other level, and slowly. The hits are as ever; of [`Question::Any`] only the codes count.
    ///
    /// # Panics
    /// If the columns of `rays` are not padded ([`Rays::pad`]).
    pub fn count(
        &self,
        rays: &Rays,
        question: Question,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Work {
        self.count_on(Fallback::new(), rays, question, hits, scratch)
    }

    /// The same at any level, for the test that steps do not depend on it. Each level that this is
    /// called with is compiled once more.
    ///
    /// # Panics
    /// If the columns of `rays` are not padded ([`Rays::pad`]).
    #[inline(always)]
    pub fn count_on<S: Simd>(
        &self,
        simd: S,
        rays: &Rays,
        question: Question,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Work {
        let mut work = Work::default();
        let out = begin(rays, hits);
        let memory = &mut scratch.memory;
        stream::cast(simd, self.structures(), rays, question, out, memory, &mut work);
        work
    }

    fn cast(&self, rays: &Rays, question: Question, hits: &mut Hits, scratch: &mut Scratch) {
        let (what, out) = (self.structures(), begin(rays, hits));
        let memory = &mut scratch.memory;
        dispatch!(self.level, simd => {
            stream::cast(simd, what, rays, question, out, memory, &mut ())
        });
    }

    fn structures(&self) -> Structures<'_> {
        let Accel { list, leaves, tree, way, below, .. } = self;
        Structures { list, leaves, tree, way: *way, below: *below }
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        let trees = size_of_val(&self.tree.nodes[..]) + self.meshes.bytes();
        self.list.bytes() + self.leaves.bytes() + trees
    }

    /// What a random ray through the tree's bounds costs by the surface-area heuristic: node visits
    /// plus block tests, each weighted with the chance that it is needed. 0 for a list.
    pub fn sah_cost(&self) -> f32 {
        self.tree.sah_cost()
    }

    /// The instructions in use.
    pub fn level(&self) -> Level {
        self.level
    }
}

/// Memory of one thread for its traversals.
#[derive(Default)]
pub struct Scratch {
    memory: Memory,
    hits: Hits,
}

/// Rows for what rays hit: nothing so far, and their ends.
fn begin<'a>(rays: &Rays, hits: &'a mut Hits) -> (&'a mut [f32], &'a mut [HitCode]) {
    let padded = rays.len().next_multiple_of(WIDE);
    hits.t.clear();
    hits.t.extend_from_slice(&rays.t_max[..padded]);
    hits.code.clear();
    hits.code.resize(padded, HitCode::NONE);
    (&mut hits.t, &mut hits.code)
}

/// Whether so much of what there is has moved that a new tree is quicker than a refitted one.
fn outnumber(moved: usize, slots: usize) -> bool {
    slots >= 4096 && moved > slots / 4 * 3
}
