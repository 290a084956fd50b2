//! All columns of a scene.

use crate::geometry::{Geometry, ShapeKind};
use crate::ids::{LightId, MaterialId, PrimId, Slot, SurfaceId};
use crate::lights::{LightPlace, Lights};
use crate::materials::{MaterialRow, Materials, Rgb};
use crate::surfaces::{Paint, Surfaces};
use crate::view::{Model, View};
use reflet_scene::{MeshData, Spread};
use std::ops::Range;

/// A scene as columns: all that later stages know of it.
#[derive(Clone, Debug)]
pub struct Columns {
    /// What rays are intersected with.
    pub geometry: Geometry,
    /// Which primitives are one surface, and what it wears.
    pub surfaces: Surfaces,
    /// Colours of reflection.
    pub materials: Materials,
    /// Where light comes from.
    pub lights: Lights,
    /// Eye and picture size.
    pub view: View,
    /// Settings of the model.
    pub model: Model,
    /// Samples a pixel.
    pub samples: u32,
    /// Where they are spent; everywhere, if there is only one.
    pub spread: Spread,
    /// Where in a pixel its trees begin; see [`crate::filter::positions`].
    pub positions: Vec<[f64; 2]>,
}

/// The part of a surface that decides where rays hit it, as bits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ShapeBits {
    Hidden,
    /// The address of the shared triangles, the placement, what moves it on, and whether it is
    /// smooth.
    Mesh(usize, [u64; 7], Option<Box<[u64; 12]>>, bool),
    /// Its primitive, as most surfaces have one.
    One(PartBits),
    /// Its primitives.
    Several(Vec<PartBits>),
}

/// One primitive, as bits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum PartBits {
    Sphere([u32; 4]),
    Plane([u32; 6]),
    Quad([u32; 15]),
    Triangle([u32; 12]),
    Solid([u64; 18]),
    Copy,
}

/// All of one surface, as bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SurfaceBits {
    /// The first primitive and how many there are, and the shape: a row that another one pushed along
    /// is another shape to whoever knows primitives by id, even if it is hidden.
    pub shape: (PrimId, u32, ShapeBits),
    pub materials: [MaterialId; 2],
    pub cells: Option<[u32; 15]>,
    pub tint: Option<Vec<u64>>,
}

/// All of one light, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LightBits {
    pub place: [u64; 16],
    pub emissivity: [u32; 3],
}

impl Columns {
    /// The materials and pattern of a surface.
    #[inline]
    pub fn paint(&self, surface: SurfaceId) -> &Paint {
        &self.surfaces.paint[surface.index()]
    }

    /// The row of a material.
    #[inline]
    pub fn material(&self, id: MaterialId) -> &MaterialRow {
        self.materials.get(id)
    }

    /// What light `id` reaches.
    pub fn light_place(&self, id: LightId) -> LightPlace {
        self.lights.place(id)
    }

    /// The intensity of light `id`.
    pub fn emissivity(&self, id: LightId) -> Rgb {
        self.lights.emissivity[id.index()]
    }

    pub(crate) fn surface_bits(&self, i: usize) -> SurfaceBits {
        let paint = &self.surfaces.paint[i];
        SurfaceBits {
            shape: (self.surfaces.first_prim[i], self.surfaces.prims[i], self.shape_bits(i)),
            materials: [paint.even, paint.odd],
            cells: paint.cells.as_ref().map(|c| c.bits()),
            tint: paint.tint.as_ref().map(|t| t.bits()),
        }
    }

    fn shape_bits(&self, i: usize) -> ShapeBits {
        if !self.surfaces.visible[i] {
            return ShapeBits::Hidden;
        }
        if let Some(mesh) = &self.surfaces.mesh[i] {
            let mut bits = [0; 7];
            let numbers = [mesh.scale].into_iter().chain(mesh.rotate.to_array());
            for (b, x) in bits.iter_mut().zip(numbers.chain(mesh.translate.to_array())) {
                *b = x.to_bits();
            }
            let data = std::sync::Arc::as_ptr(&mesh.data) as usize;
            let is_smooth = self.surfaces.smooth[i].is_some();
            return ShapeBits::Mesh(data, bits, self.surfaces.moved_by[i].clone(), is_smooth);
        }
        let mut prims = self.slots(i).map(|slot| self.part_bits(slot));
        match (self.surfaces.prims[i], prims.next()) {
            (1, Some(one)) => ShapeBits::One(one),
            (_, first) => ShapeBits::Several(first.into_iter().chain(prims).collect()),
        }
    }

    /// The slots of surface `i`.
    pub(crate) fn slots(&self, i: usize) -> Range<usize> {
        let (first, prims) = (self.surfaces.first_prim[i], self.surfaces.prims[i]);
        let (Slot(slot), _) = self.geometry.slot_of(first);
        let slot = slot as usize;
        match self.geometry.shape.get(slot) {
            Some((ShapeKind::Copy, _)) if prims > 0 => slot..slot + 1,
            _ => slot..slot + prims as usize,
        }
    }

    /// What a structure that rays are intersected with has to look at when a surface moved: the slots
    /// of its primitives, or its copy's one.
    pub fn parts_of(&self, surface: SurfaceId) -> impl Iterator<Item = Slot> + use<> {
        self.slots(surface.index()).map(|slot| Slot(slot as u32))
    }

    fn part_bits(&self, slot: usize) -> PartBits {
        let g = &self.geometry;
        let (kind, row) = g.shape[slot];
        let row = row as usize;
        match kind {
            ShapeKind::Sphere => {
                let ([x, y, z], r) = g.spheres.row(row);
                PartBits::Sphere([x, y, z, r].map(f32::to_bits))
            }
            ShapeKind::Plane => {
                PartBits::Plane(bits([g.planes.point.get(row), g.planes.normal.get(row)]))
            }
            ShapeKind::Quad => {
                let [a, b, c, d] = g.quads.points(row);
                PartBits::Quad(bits([a, b, c, d, g.quads.normal.get(row)]))
            }
            ShapeKind::Triangle => {
                let [a, b, c] = g.triangles.points(row);
                PartBits::Triangle(bits([a, b, c, g.triangles.normal.get(row)]))
            }
            ShapeKind::Solid => PartBits::Solid(g.solids.rows[row].bits()),
            // Meshes are compared before.
            ShapeKind::Copy => PartBits::Copy,
        }
    }

    pub(crate) fn light_bits(&self, i: usize) -> LightBits {
        let id = LightId(i as u32);
        LightBits {
            place: self.lights.place(id).bits(),
            emissivity: self.emissivity(id).map(f32::to_bits),
        }
    }

    /// The surface that a primitive belongs to.
    #[inline]
    pub fn surface_of(&self, prim: PrimId) -> SurfaceId {
        let g = &self.geometry;
        let (slot, which) = g.slot_of(prim);
        let surface = g.surface[slot.index()];
        match g.shape[slot.index()] {
            (ShapeKind::Copy, row) => {
                SurfaceId(surface.0 + material_of(&g.copies[row as usize].mesh.data, which))
            }
            _ => surface,
        }
    }
}

/// The number of the material that a mesh's triangle wears: 0 if the file does not name several.
pub(crate) fn material_of(data: &MeshData, triangle: usize) -> u32 {
    if data.materials.len() < 2 {
        return 0;
    }
    data.triangle_materials.get(triangle).copied().unwrap_or_default()
}

fn bits<const N: usize, const M: usize>(points: [[f32; 3]; N]) -> [u32; M] {
    let mut out = [0; M];
    for (o, x) in out.iter_mut().zip(points.iter().flatten()) {
        *o = x.to_bits();
    }
    out
}
