//! Meshes that stand in the scene once more: only the way there is stored, no triangle.
//!
//! A copy takes as many ids as its mesh has triangles, so that ties are decided as if they were
//! stored. It takes one [`Slot`] for all of them; a list of runs tells the two numbers apart.

use crate::bounds::{Aabb, round_down, round_up};
use crate::ids::{PrimId, Slot};
use glam::{DAffine3, DVec3};
use reflet_scene::{Mesh, MeshData};
use std::sync::Arc;

/// The way of points into the scene: the rows of a matrix, the last column what is added.
pub type World = [[f64; 4]; 3];

/// Where `world` puts a point: the one sequence of operations by which a vertex of a mesh comes into
/// the scene, stored or not.
#[inline(always)]
pub fn put(world: &World, p: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])];
    let row = |w: &[f64; 4]| (w[0] * x + w[1] * y + w[2] * z + w[3]) as f32;
    [row(&world[0]), row(&world[1]), row(&world[2])]
}

/// The way of a mesh's vertices: by its own placement, and on by groups and instances.
pub(crate) fn way(mesh: &Mesh, to: Option<&DAffine3>) -> World {
    let own = crate::rows::rotation(mesh.rotate) * mesh.scale;
    let own = DAffine3::from_mat3_translation(own, mesh.translate);
    let all = to.map_or(own, |to| *to * own);
    let m = all.matrix3;
    [0, 1, 2].map(|k| [m.x_axis[k], m.y_axis[k], m.z_axis[k], all.translation[k]])
}

/// The direction of a triangle's own normal, along `(b - a) x (c - a)`.
fn across([a, b, c]: [[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|p| DVec3::from_array(p.map(f64::from)));
    (b - a).cross(c - a)
}

/// The unit normal and the box of a triangle; zeros and [`Aabb::EMPTY`] if it has no area, since a
/// placement may flatten it: it is no longer there.
pub fn facing(points: [[f32; 3]; 3]) -> ([f32; 3], Aabb) {
    faced(points, across(points))
}

/// The same, by the normal that the corners had before they were rounded, of any length.
pub(crate) fn faced(points: [[f32; 3]; 3], normal: DVec3) -> ([f32; 3], Aabb) {
    if normal.length() > 0.0 {
        (crate::packer::f32s(crate::view::unit(normal)), Aabb::of_points(&points))
    } else {
        ([0.0; 3], Aabb::EMPTY)
    }
}

/// The triangles of a mesh that copies share, in the file's own coordinates.
#[derive(Clone, Debug)]
pub struct SharedMesh {
    /// The triangles.
    pub data: Arc<MeshData>,
    /// Boxes that hold all of them together.
    outline: Vec<Aabb>,
}

/// How many boxes an outline has: enough to follow the shape, few enough to move.
const OUTLINE: usize = 32;

impl SharedMesh {
    /// Outlines a mesh.
    pub fn new(data: Arc<MeshData>) -> SharedMesh {
        let bounds = |t: &[u32; 3]| Aabb::of_points(&t.map(|v| data.positions[v as usize]));
        let mut boxes: Vec<Aabb> = data.triangles.iter().map(bounds).collect();
        let mut outline = Vec::with_capacity(OUTLINE);
        halve(&mut boxes, OUTLINE, &mut outline);
        SharedMesh { data, outline }
    }

    /// A box around all triangles where `world` puts them, each with its own box.
    fn bounds(&self, world: &World) -> Aabb {
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for b in &self.outline {
            for (k, w) in world.iter().enumerate() {
                let (mut least, mut most) = (w[3], w[3]);
                for (by, (low, high)) in w.iter().zip(b.lo.iter().zip(&b.hi)) {
                    let (x, y) = (by * f64::from(*low), by * f64::from(*high));
                    least += x.min(y);
                    most += x.max(y);
                }
                lo[k] = lo[k].min(least);
                hi[k] = hi[k].max(most);
            }
        }
        if lo[0] > hi[0] {
            return Aabb::EMPTY;
        }
        // What a triangle's own box is wider than its exact corners: the corners' rounding and the
        // box's, together less than 2^-22 of a coordinate, and the padding of 2^-21 of an edge.
        let edge = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
        let wider = |k: usize| {
            edge / f64::from(1 << 20) + lo[k].abs().max(hi[k].abs()) / f64::from(1 << 21)
        };
        Aabb {
            lo: [0, 1, 2].map(|k| round_down(lo[k] - wider(k))),
            hi: [0, 1, 2].map(|k| round_up(hi[k] + wider(k))),
        }
    }
}

/// Sorts boxes into up to `parts` groups of neighbours, and gives the box of each.
fn halve(boxes: &mut [Aabb], parts: usize, out: &mut Vec<Aabb>) {
    let all = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
    if parts == 1 || boxes.len() < 2 {
        out.extend((!boxes.is_empty()).then_some(all));
        return;
    }
    let edge = |k: usize| all.hi[k] - all.lo[k];
    let axis = (1..3).fold(0, |best, k| if edge(k) > edge(best) { k } else { best });
    let middle = boxes.len() / 2;
    let center = |b: &Aabb| b.lo[axis] + b.hi[axis];
    boxes.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
    let (left, right) = boxes.split_at_mut(middle);
    halve(left, parts / 2, out);
    halve(right, parts / 2, out);
}

/// A mesh that stands in the scene once more.
#[derive(Clone, Debug)]
pub struct MeshCopy {
    /// What it is a copy of.
    pub mesh: Arc<SharedMesh>,
    /// Where it is.
    pub world: World,
}

impl MeshCopy {
    /// How many triangles it has.
    pub fn len(&self) -> usize {
        self.mesh.data.triangles.len()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The corners of a triangle in the scene, with the bits that they would be stored with.
    #[inline]
    pub fn triangle(&self, i: usize) -> [[f32; 3]; 3] {
        let data = &self.mesh.data;
        data.triangles[i].map(|v| put(&self.world, data.positions[v as usize]))
    }

    /// A box that holds the boxes of all of its triangles.
    pub fn bounds(&self) -> Aabb {
        self.mesh.bounds(&self.world)
    }
}

/// Which slots hold which ids: nothing, while each slot is one primitive.
#[derive(Clone, Debug, Default)]
pub(crate) struct Runs {
    /// The first id and the first slot of each run; a copy is one, and so is what follows it.
    starts: Vec<(u32, u32)>,
}

impl Runs {
    /// Notes that a slot holds `count` ids from `first` on.
    pub fn note_copy(&mut self, slot: usize, first: PrimId, count: usize) {
        if self.starts.is_empty() {
            self.starts.push((0, 0));
        }
        if self.starts.last() != Some(&(first.0, slot as u32)) {
            self.starts.push((first.0, slot as u32));
        }
        self.starts.push((first.0 + count as u32, slot as u32 + 1));
    }

    /// Forgets slots from `slots` on.
    pub fn truncate(&mut self, slots: usize) {
        self.starts.retain(|(_, slot)| *slot as usize <= slots);
        if self.starts.len() == 1 {
            self.starts.clear();
        }
    }

    /// Where a primitive is stored, and the which of that slot it is.
    #[inline]
    pub fn slot_of(&self, prim: PrimId) -> (Slot, usize) {
        if self.starts.is_empty() {
            return (Slot(prim.0), 0);
        }
        let run = self.starts.partition_point(|(first, _)| *first <= prim.0) - 1;
        let (first, slot) = self.starts[run];
        let offset = prim.0 - first;
        match self.starts.get(run + 1) {
            Some((next, after)) if *after == slot + 1 && *next - first > 1 => {
                (Slot(slot), offset as usize)
            }
            _ => (Slot(slot + offset), 0),
        }
    }

    /// The first primitive that a slot holds; of the slot after the last, how many there are.
    #[inline]
    pub fn first_of(&self, slot: Slot) -> PrimId {
        if self.starts.is_empty() {
            return PrimId(slot.0);
        }
        let run = self.starts.partition_point(|(_, start)| *start <= slot.0) - 1;
        let (first, start) = self.starts[run];
        PrimId(first + (slot.0 - start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_and_slots_lead_to_each_other() {
        // One row, a copy of five, a copy of one, two rows, a copy of three.
        let counts = [1, 5, 1, 1, 1, 3];
        let is_copy = [false, true, true, false, false, true];
        let mut runs = Runs::default();
        let mut first = 0;
        for (slot, (count, copy)) in counts.into_iter().zip(is_copy).enumerate() {
            if copy {
                runs.note_copy(slot, PrimId(first), count);
            }
            first += count as u32;
        }
        let mut prim = 0;
        for (slot, count) in counts.into_iter().enumerate() {
            assert_eq!(runs.first_of(Slot(slot as u32)), PrimId(prim));
            for i in 0..count {
                assert_eq!(runs.slot_of(PrimId(prim)), (Slot(slot as u32), i));
                prim += 1;
            }
        }
        assert_eq!(runs.first_of(Slot(6)), PrimId(12));
        runs.truncate(2);
        assert_eq!(runs.slot_of(PrimId(5)), (Slot(1), 4));
        assert_eq!(runs.slot_of(PrimId(7)), (Slot(3), 0));
        runs.truncate(1);
        assert_eq!(runs.slot_of(PrimId(7)), (Slot(7), 0));
    }
}
