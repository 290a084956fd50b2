//! The first pass: the ray trees of a tile, level by level; from nothing, or grown on from those of
//! the frame before.

use crate::camera;
use crate::capsule::Capsules;
use crate::grid::TileRect;
use crate::lighting::{self, Shadows};
use crate::mirror;
use crate::palette::{PaletteIndex, Slot};
use crate::segment::Begin;
use crate::stream::{RayTally, Recorded, Stream};
use crate::tint::{self, Combine, TintScratch};
use crate::trees::{Level, Points, Trees};
use fearless_simd::dispatch;
use reflet_accel::{Accel, HitCode, RayCounts, Rays, Scratch};
use reflet_pack::lights::Channel;
use reflet_pack::surfaces::Cells;
use reflet_pack::view::Projection;
use reflet_pack::{Columns, LightId, Spread};

/// Memory of one thread for the first pass, and what it counted.
#[derive(Default)]
pub struct TraceScratch {
    /// Rays by kind.
    pub rays: RayTally,
    /// The same rays, counted where they entered `accel`.
    pub counts: RayCounts,
    /// Nodes whose position was found again without a ray.
    pub replayed: u64,
    /// Segments of kept trees that were held against the bounds of what moved.
    pub tested: u64,
    /// Nodes that kept trees grew by, below their leaves.
    pub deepened: u64,
    /// Where the rays themselves are kept, if they are wanted.
    pub record: Option<Recorded>,
    pub(crate) known: Stream,
    pub(crate) fresh: Stream,
    next: Rays,
    /// Where the camera rays of a tile start, if not in one point.
    pub(crate) origins: [Vec<f32>; 3],
    shadows: Shadows,
    occluded: Vec<bool>,
    rows: Vec<u16>,
    childless: Vec<bool>,
    palette: PaletteIndex,
    tint: TintScratch,
    accel: Scratch,
}

impl TraceScratch {
    fn stream(&self, which: Which) -> &Stream {
        match which {
            Which::Known => &self.known,
            Which::Fresh => &self.fresh,
        }
    }

    /// Marks the nodes of a level that have no mirrored ray.
    fn find_childless(&mut self, trees: &Trees, depth: usize) {
        self.childless.clear();
        self.childless.resize(trees.levels[depth].len(), true);
        for parent in trees.levels.get(depth + 1).map_or(&[][..], |below| &below.parent) {
            self.childless[usize::from(*parent)] = false;
        }
    }
}

/// What the first pass reads.
pub struct Tracer<'a> {
    /// The scene.
    pub columns: &'a Columns,
    /// The same scene's primitives, to intersect with.
    pub accel: &'a Accel,
    /// Whether trees made from scratch keep where their rays ended.
    pub points: Points,
}

/// What of kept trees is found anew. Rays are cast only for that.
#[derive(Clone, Debug, Default)]
pub struct Revision {
    /// Lights whose terms are computed anew at every node, ascending.
    pub relight: Vec<LightId>,
    /// Whether cells of patterns are looked up again.
    pub cells: PatternCells,
}

/// Whether cells of patterns are looked up again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatternCells {
    /// They are as they were.
    #[default]
    Keep,
    /// They may have changed.
    Again,
}

impl Tracer<'_> {
    fn position(&self, sample: u32) -> [f64; 2] {
        self.columns.positions[sample as usize]
    }

    /// Makes the ray trees of one sample of a tile from scratch: the trees through one of
    /// [`Columns::positions`].
    pub fn grow(&self, rect: TileRect, sample: u32, trees: &mut Trees, s: &mut TraceScratch) {
        trees.clear();
        trees.points = self.points;
        s.palette.start(&[], self.columns.surfaces.len());
        s.known.clear();
        camera::rays(&self.columns.view, rect, self.position(sample), &mut s.fresh.rays);
        s.fresh.parents.clear();
        s.fresh.parents.extend(0..rect.pixels() as u16);
        self.descend(trees, &Revision::default(), s);
        self.find_capsules((rect, sample), trees, s);
    }

    /// Makes the trees of some of a tile's pixels from scratch.
    pub fn grow_at(
        &self,
        (rect, sample): (TileRect, u32),
        pixels: &[u16],
        trees: &mut Trees,
        s: &mut TraceScratch,
    ) {
        trees.clear();
        self.grow_some((rect, sample), pixels, self.points, trees, s);
        self.find_capsules((rect, sample), trees, s);
    }

    /// Makes the trees of some of a tile's pixels from scratch. At level 0 they have one row a
    /// pixel of `pixels`, whose parent is the pixel. They number their surfaces on from the palette
    /// that they have.
    pub(crate) fn grow_some(
        &self,
        (rect, sample): (TileRect, u32),
        pixels: &[u16],
        points: Points,
        trees: &mut Trees,
        s: &mut TraceScratch,
    ) {
        trees.levels.iter_mut().for_each(Level::clear);
        trees.points = points;
        s.palette.start(&trees.palette, self.columns.surfaces.len());
        s.known.clear();
        let (at, pixels) = (self.position(sample), pixels.iter().copied());
        camera::some_rays(&self.columns.view, rect, at, pixels.clone(), &mut s.fresh.rays);
        s.fresh.parents.clear();
        s.fresh.parents.extend(pixels);
        self.descend(trees, &Revision::default(), s);
    }

    /// Brings kept trees up to date: the terms of `revision`'s lights and cells, and levels below
    /// nodes that reflect now and did not before. What is kept is replayed: each node's point is
    /// found again from its parent's, by the kernel of the surface that it is known to lie on.
    pub fn revise(
        &self,
        (rect, sample): (TileRect, u32),
        trees: &mut Trees,
        revision: &Revision,
        s: &mut TraceScratch,
    ) {
        let before = trees.nodes();
        s.palette.start(&trees.palette, self.columns.surfaces.len());
        self.known_rays((rect, sample), trees, s);
        s.fresh.clear();
        self.descend(trees, revision, s);
        self.find_capsules((rect, sample), trees, s);
        s.deepened += (trees.nodes() - before) as u64;
    }

    /// The camera rays of kept trees, in their order.
    pub(crate) fn known_rays(
        &self,
        (rect, sample): (TileRect, u32),
        trees: &Trees,
        s: &mut TraceScratch,
    ) {
        let pixels = trees.levels.first().map_or(&[][..], |level| &level.parent);
        let (at, pixels) = (self.position(sample), pixels.iter().copied());
        camera::some_rays(&self.columns.view, rect, at, pixels, &mut s.known.rays);
    }

    /// Whether some node of kept trees reflects now and has no mirrored ray.
    pub fn lacks_levels(&self, trees: &Trees, s: &mut TraceScratch) -> bool {
        (0..trees.levels.len()).any(|depth| {
            s.find_childless(trees, depth);
            let level = &trees.levels[depth];
            (0..level.len()).any(|row| s.childless[row] && self.reflects(trees, depth, row))
        })
    }

    /// Level by level: `s.known` holds the rays of the level's own nodes, in their order, and
    /// `s.fresh` those of new ones, which come after them.
    fn descend(&self, trees: &mut Trees, revision: &Revision, s: &mut TraceScratch) {
        s.known.totals.clear();
        s.known.totals.resize(s.known.rays.len(), 0.0);
        s.fresh.totals.clear();
        s.fresh.totals.resize(s.fresh.rays.len(), 0.0);
        s.rays.camera += s.fresh.rays.len() as u64;
        for depth in 0.. {
            if s.known.rays.is_empty() && s.fresh.rays.is_empty() {
                break;
            }
            if trees.levels.len() == depth {
                trees.levels.push(Level::default());
            }
            let kept = trees.levels[depth].len();
            self.replay(&trees.levels[depth], s);
            self.intersect(depth, s);
            let points = trees.points;
            let level = &mut trees.levels[depth];
            if points == Points::Kept {
                place(level, &s.fresh);
            }
            if revision.cells == PatternCells::Again {
                self.look_up_cells(level, &mut trees.palette, s);
            }
            self.append(level, &mut trees.palette, s);
            self.light(level, kept, &revision.relight, s);
            self.cast(trees, depth, kept, s);
        }
        while trees.levels.last().is_some_and(Level::is_empty) {
            trees.levels.pop();
        }
    }

    fn find_capsules(&self, at: (TileRect, u32), trees: &mut Trees, s: &mut TraceScratch) {
        if trees.points == Points::Kept {
            self.find_origins(at, s);
            Capsules::find(trees, self.begin(&s.origins));
        }
    }

    /// Finds where camera rays start, if that is not in one point.
    pub(crate) fn find_origins(&self, (rect, sample): (TileRect, u32), s: &mut TraceScratch) {
        if self.columns.view.projection == Projection::Parallel {
            camera::rays(&self.columns.view, rect, self.position(sample), &mut s.next);
            s.origins.clone_from(&s.next.origin);
        }
    }

    /// Where camera rays start, once [`Tracer::find_origins`] has looked.
    pub(crate) fn begin<'s>(&self, origins: &'s [Vec<f32>; 3]) -> Begin<'s> {
        match self.columns.view.projection {
            Projection::Perspective => Begin::Eye(self.columns.view.eye),
            Projection::Parallel => Begin::Above(origins),
        }
    }

    /// Finds the points of the level's own nodes again, without a traversal.
    fn replay(&self, level: &Level, s: &mut TraceScratch) {
        s.replayed += s.known.rays.len() as u64;
        let columns = self.columns;
        dispatch!(self.accel.level(), simd => s.known.replay(simd, columns, &level.code));
    }

    /// Finds what the new rays hit.
    fn intersect(&self, depth: usize, s: &mut TraceScratch) {
        let fresh = &mut s.fresh;
        if let Some(record) = s.record.as_mut().filter(|_| !fresh.rays.is_empty()) {
            let kind = if depth == 0 { &mut record.camera } else { &mut record.mirror };
            kind.push(fresh.rays.clone());
        }
        self.accel.closest(&fresh.rays, &mut fresh.hits, &mut s.accel, &mut s.counts);
        let columns = self.columns;
        dispatch!(self.accel.level(), simd => s.fresh.find(simd, columns));
    }

    /// Slots of the level's own nodes, as cells are now.
    fn look_up_cells(&self, level: &mut Level, palette: &mut Vec<Slot>, s: &mut TraceScratch) {
        for (row, code) in level.code.iter().enumerate() {
            let (slot, cell) = self.slot(*code, s.known.point(row), palette, &mut s.palette);
            level.slot[row] = slot;
            if let Some(to) = level.cell.get_mut(row) {
                *to = cell;
            }
        }
        self.tint(level, 0, Which::Known, s);
    }

    /// Makes nodes of the new rays: what they hit, path lengths and slots.
    fn append(&self, level: &mut Level, palette: &mut Vec<Slot>, s: &mut TraceScratch) {
        let fresh = &s.fresh;
        level.parent.extend_from_slice(&fresh.parents);
        for row in 0..fresh.rays.len() {
            let code = fresh.hits.code[row];
            let total = if code.is_none() { 1.0 } else { fresh.totals[row] + fresh.hits.t[row] };
            level.code.push(code);
            level.total.push(total);
            let (slot, cell) = self.slot(code, fresh.point(row), palette, &mut s.palette);
            level.slot.push(slot);
            if self.columns.spread == Spread::Edges {
                level.cell.push(cell);
            }
        }
        self.tint(level, level.len() - s.fresh.rays.len(), Which::Fresh, s);
    }

    /// What pictures and expressions say at the points of one stream, whose nodes are those from row
    /// `first` on.
    fn tint(&self, level: &mut Level, first: usize, which: Which, s: &mut TraceScratch) {
        let channels = self.columns.surfaces.tint_channels();
        level.tint.resize_with(channels, Vec::new);
        if channels == 0 {
            return;
        }
        let (points, len) = match which {
            Which::Known => (&s.known.points, s.known.rays.len()),
            Which::Fresh => (&s.fresh.points, s.fresh.rays.len()),
        };
        let rows = first + len;
        level.tint.iter_mut().filter(|c| c.len() < rows).for_each(|c| c.resize(rows, 1.0));
        let (out, points) = ((&mut level.tint[..], first), (points, &level.code[first..rows]));
        let (columns, scratch) = (self.columns, &mut s.tint);
        dispatch!(self.accel.level(), simd => tint::fill(simd, columns, points, out, scratch));
    }

    /// The slot of what was hit, and the cell of its pattern.
    fn slot(
        &self,
        code: HitCode,
        p: [f32; 3],
        palette: &mut Vec<Slot>,
        index: &mut PaletteIndex,
    ) -> (u16, u32) {
        let Some(prim) = code.prim() else { return (0, 0) };
        let surface = self.columns.surface_of(prim);
        let cells = self.columns.paint(surface).cells.as_ref();
        let (odd, cell) = cells.map_or((false, 0), |cells| cell_of(cells, p));
        (index.number(Slot { surface, odd }, palette), cell)
    }

    /// One column a light: of all nodes for those in `relight`, else of the new ones.
    fn light(&self, level: &mut Level, kept: usize, relight: &[LightId], s: &mut TraceScratch) {
        let lights = self.columns.lights.len();
        level.light.resize_with(lights, Vec::new);
        for i in 0..lights {
            let id = LightId(i as u32);
            let slide = &self.columns.lights.slide[i];
            if slide.as_ref().is_some_and(|(_, channel)| *channel != Channel::Red) {
                continue; // its column was written with that of red
            }
            let colours = if slide.is_some() { 3 } else { 1 };
            let columns = &mut level.light[i..i + colours];
            // A light that is new has no terms yet.
            columns.iter_mut().for_each(|terms| terms.resize(kept, 0.0));
            if relight.binary_search(&id).is_ok() {
                self.light_stream(id, &level.code[..kept], Which::Known, columns, 0, s);
            }
            self.light_stream(id, &level.code[kept..], Which::Fresh, columns, kept, s);
        }
    }

    /// Writes the terms of one light, or of the three that are one with a slide, at the points of one
    /// stream from row `first` of `columns` on.
    fn light_stream(
        &self,
        light: LightId,
        codes: &[HitCode],
        which: Which,
        columns: &mut [Vec<f32>],
        first: usize,
        s: &mut TraceScratch,
    ) {
        let place = self.columns.light_place(light);
        if codes.is_empty() {
            return;
        }
        let range = first..first + codes.len();
        columns.iter_mut().for_each(|terms| terms.resize(range.end.max(terms.len()), 0.0));
        let Some((terms, others)) = columns.split_first_mut() else { return };
        let out = &mut terms[range.clone()];
        let mut shadows = std::mem::take(&mut s.shadows);
        let points = &s.stream(which).points;
        dispatch!(self.accel.level(), simd => lighting::aim(simd, &place, points, codes, out, &mut shadows));
        self.occlude(&shadows.rays, &shadows.rows, out, s);
        shadows.lifted.retain(|row| out[usize::from(*row)] != 0.0);
        if !shadows.lifted.is_empty() {
            lighting::climb(&s.stream(which).points, codes, &mut shadows);
            self.occlude(&shadows.rays, &shadows.lifted, out, s);
        }
        let points = &s.stream(which).points;
        if let Some((slide, _)) = &place.slide {
            others.iter_mut().for_each(|terms| terms[range.clone()].copy_from_slice(out));
            for row in shadows.rows.iter().map(|row| usize::from(*row)) {
                let way = [0, 1, 2].map(|k| points.p[k][row] - place.at[k]);
                let texel = slide.texel(way);
                // What is blocked stays -0, whatever would shine there.
                let shine = |term: &mut f32, texel: f32| {
                    if *term != 0.0 {
                        *term = if texel == 0.0 { 0.0 } else { *term * texel };
                    }
                };
                shine(&mut out[row], texel[0]);
                for (terms, texel) in others.iter_mut().zip(&texel[1..]) {
                    shine(&mut terms[range.start + row], *texel);
                }
            }
        }
        s.shadows = shadows;
    }

    /// Casts shadow rays, and writes -0 into the rows whose ray is blocked.
    fn occlude(&self, rays: &Rays, rows: &[u16], terms: &mut [f32], s: &mut TraceScratch) {
        s.rays.shadow += rays.len() as u64;
        if let Some(record) = s.record.as_mut().filter(|_| !rays.is_empty()) {
            record.shadow.push(rays.clone());
        }
        self.accel.any(rays, &mut s.occluded, &mut s.accel, &mut s.counts);
        for (row, hidden) in rows.iter().zip(&s.occluded) {
            if *hidden {
                terms[usize::from(*row)] = -0.0;
            }
        }
    }

    /// The next level's rays: those of its own nodes, and those of nodes that it lacks.
    fn cast(&self, trees: &Trees, depth: usize, kept: usize, s: &mut TraceScratch) {
        let level = &trees.levels[depth];
        let empty = Level::default();
        let below = trees.levels.get(depth + 1).unwrap_or(&empty);
        s.find_childless(trees, depth);
        let rows = |range: std::ops::Range<usize>, childless: &[bool], rows: &mut Vec<u16>| {
            rows.clear();
            let reflects = |row: &usize| childless[*row] && self.reflects(trees, depth, *row);
            rows.extend(range.filter(reflects).map(|row| row as u16));
        };

        // Known nodes that reflect only now, then new nodes: together the next level's new rays.
        rows(0..kept, &s.childless, &mut s.rows);
        self.reflect(&s.known, &s.rows, &level.code[..kept], &mut s.next);
        let mut parents = std::mem::take(&mut s.fresh.spare);
        parents.clear();
        parents.extend_from_slice(&s.rows);
        let mut late = std::mem::take(&mut s.next);
        rows(kept..level.len(), &s.childless, &mut s.rows);
        parents.extend_from_slice(&s.rows);
        s.rows.iter_mut().for_each(|row| *row -= kept as u16);
        self.reflect(&s.fresh, &s.rows, &level.code[kept..], &mut s.next);
        if !late.is_empty() {
            for i in 0..s.next.len() {
                late.push_from(&s.next, i);
            }
            late.pad();
            std::mem::swap(&mut late, &mut s.next);
        }
        std::mem::swap(&mut s.fresh.rays, &mut s.next);
        s.fresh.spare = std::mem::replace(&mut s.fresh.parents, parents);
        s.fresh.totals.clear();
        s.fresh.totals.extend(s.fresh.parents.iter().map(|row| level.total[usize::from(*row)]));
        s.rays.mirror += s.fresh.rays.len() as u64;

        self.reflect(&s.known, &below.parent, &level.code[..kept], &mut s.next);
        std::mem::swap(&mut s.known.rays, &mut s.next);
    }

    /// Whether a node casts a mirrored ray.
    pub(crate) fn reflects(&self, trees: &Trees, depth: usize, row: usize) -> bool {
        let model = &self.columns.model;
        let level = &trees.levels[depth];
        let slot = level.slot[row];
        depth < model.max_bounces as usize && slot != 0 && level.total[row] <= model.max_path && {
            let slot = &trees.palette[usize::from(slot) - 1];
            let own = self.columns.material(slot.material(self.columns)).specular;
            let tint = self.columns.paint(slot.surface).tint.as_deref();
            Combine::of(tint).is_specular(own, level, row)
        }
    }

    fn reflect(&self, from: &Stream, rows: &[u16], codes: &[HitCode], out: &mut Rays) {
        dispatch!(self.accel.level(), simd => mirror::reflect(
            simd, &from.rays, &from.points, codes, rows, out
        ));
    }
}

/// Appends where the rays of a stream ended, and how far above shadow rays may leave.
pub(crate) fn place(level: &mut Level, stream: &Stream) {
    let lift = |row: usize| {
        stream
            .points
            .lift
            .iter()
            .map(|column| column.get(row).map_or(0.0, |x| x.abs()))
            .sum::<f32>()
    };
    level.lift.extend((0..stream.rays.len()).map(lift));
    for (k, column) in level.at.iter_mut().enumerate() {
        let ends = stream.points.p[k].iter().zip(&stream.rays.dir[k]).zip(&stream.hits.code);
        let ends = ends.map(|((p, d), code)| if code.is_none() { *d } else { *p });
        column.extend(ends.take(stream.rays.len()));
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Which {
    Known,
    Fresh,
}

/// How far before a cell's border a point counts as on it, relative to the coordinates at hand: 16
/// units in the last place (2^-24) of p. A face of a box often lies in a border of the cells that
/// begin there, and must not be speckled by p's rounding.
const BORDER: f32 = 1.0 / 1_048_576.0;

/// Whether p lies in a cell whose numbers sum up to an odd one, and these numbers as a hash.
fn cell_of(cells: &Cells, p: [f32; 3]) -> (bool, u32) {
    let largest =
        |v: &[f32; 3]| v.iter().fold(0.0f32, |m, x| if x.abs() > m { x.abs() } else { m });
    let way = [p[0] - cells.origin[0], p[1] - cells.origin[1], p[2] - cells.origin[2]];
    // Tiles are across the flat surface that they lie on: it is in no border of theirs.
    let tiles = cells.axes[1] != [0.0; 3] && cells.axes[2] == [0.0; 3];
    let reach = if tiles { 0.0 } else { BORDER * (largest(&p) + largest(&cells.origin)) };
    // A direction that is not in use has cell 0 everywhere, which is even.
    cells.axes.iter().zip(cells.size).fold((false, 0), |(odd, hash), (axis, size)| {
        let along = way[0] * axis[0] + way[1] * axis[1] + way[2] * axis[2];
        let floor = floor((along + reach * largest(axis)) / size);
        (odd ^ (floor & 1 == 1), (hash ^ floor as u32).wrapping_mul(0x9e37_79b1).rotate_left(15))
    })
}

/// The greatest whole number not above `x`; 0 beyond 2^31, where every `f32` is even, as from 2^24 on.
/// Below that truncation is exact; `f32::floor` is a call on machines without SSE4.1.
fn floor(x: f32) -> i32 {
    let whole = x as i32;
    let floor = whole.wrapping_sub(i32::from(whole as f32 > x));
    if x.abs() < 2_147_483_648.0 { floor } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::floor;

    #[test]
    fn cells_are_counted_as_floor_counts_them() {
        let near =
            [0.0, 0.5, 1.0, 2.0, 3.5, 1e6, 8_388_607.5, 8_388_609.0, 16_777_216.0, 3e9, 1e30];
        for x in
            near.into_iter().flat_map(|x: f32| [x, x.next_up(), x.next_down(), -x, -x.next_up()])
        {
            let exact = f64::from(x).floor();
            assert_eq!(floor(x) & 1 == 1, exact.rem_euclid(2.0) == 1.0, "{x}");
            if exact.abs() < 2e9 {
                assert_eq!(f64::from(floor(x)), exact, "{x}");
            }
        }
    }
}
