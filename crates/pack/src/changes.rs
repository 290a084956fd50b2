//! What differs between two frames of columns, by bits and by key.
//!
//! Bits, not values: 0.0 and -0.0 differ, a NaN equals itself. A row that was made for the last
//! frame only is the same row as one made for this frame with the same key.

use crate::bounds::{Aabb, Volume};
use crate::columns::{Columns, LightBits, SurfaceBits};
use crate::geometry::{Geometry, ShapeKind};
use crate::ids::{LightId, MaterialId, SurfaceId};
use crate::materials::MaterialRow;
use crate::packer::spread;
use crate::view::{Model, View};
use reflet_scene::{Filter, Image};

/// A surface whose shape, place or visibility changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceChange {
    /// Which one; its row may not exist in one of the two frames.
    pub surface: SurfaceId,
    /// Where it was.
    pub old: Volume,
    /// Where it is.
    pub new: Volume,
}

/// A material whose numbers changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialChange {
    /// Which one; its row may not exist in one of the two frames.
    pub material: MaterialId,
    /// What it was.
    pub old: Option<MaterialRow>,
    /// What it is.
    pub new: Option<MaterialRow>,
}

/// How a light changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightChange {
    /// Only its intensity.
    Emissivity(LightId),
    /// Where it is or what it reaches (and perhaps its intensity).
    Place(LightId),
    /// It is new.
    Added(LightId),
    /// It is gone.
    Removed(LightId),
}

/// What differs between two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// All of it, perhaps: a surface consists of other primitives than before, so that rows were
    /// numbered anew. Nothing else is told then.
    pub rebuilt: bool,
    /// The eye, the picture's size or the filter.
    pub view: bool,
    /// Samples a pixel, or where they are spent.
    pub samples: bool,
    /// Settings that only shading reads: attenuation, background, transfer, and the two limits.
    pub model: bool,
    /// Materials whose numbers differ, ascending.
    pub materials: Vec<MaterialChange>,
    /// Those of them of whose specular red, green or blue one is no longer 0: nodes may cast a mirrored
    /// ray now that cast none before.
    pub woken: Vec<MaterialId>,
    /// Surfaces that wear other materials in the same pattern, ascending.
    pub repainted: Vec<SurfaceId>,
    /// Surfaces whose pattern's cells differ, ascending.
    pub patterns: Vec<SurfaceId>,
    /// Surfaces that moved, appeared, vanished or changed shape, ascending.
    pub surfaces: Vec<SurfaceChange>,
    /// Lights, ascending.
    pub lights: Vec<LightChange>,
}

impl Changes {
    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        *self == Changes::default()
    }

    /// Materials that cast a mirrored ray in one of the two frames only, ascending.
    pub fn toggled(&self) -> impl Iterator<Item = MaterialId> + '_ {
        let casts = |m: &Option<MaterialRow>| m.as_ref().is_some_and(MaterialRow::is_specular);
        self.materials.iter().filter(move |c| casts(&c.old) != casts(&c.new)).map(|c| c.material)
    }

    /// The full comparison of two frames. [`crate::Packer::update`] finds the same by looking only
    /// at the rows that a frame touched.
    pub fn between(old: &Columns, new: &Columns) -> Changes {
        let mut changes = Changes::default();
        changes.compare_view(old, new);
        changes.compare_materials(
            old,
            new,
            0..old.materials.rows.len().max(new.materials.rows.len()),
        );
        for i in 0..old.surfaces.len().max(new.surfaces.len()) {
            changes.compare_surface(i, &SurfaceState::of(old, i), &SurfaceState::of(new, i));
        }
        for i in 0..old.lights.len().max(new.lights.len()) {
            let bits = |c: &Columns| (i < c.lights.len()).then(|| c.light_bits(i));
            changes.compare_light(i, bits(old), bits(new));
        }
        changes
    }

    pub(crate) fn compare_view(&mut self, old: &Columns, new: &Columns) {
        self.compare_settings(&Settings::of(old), &Settings::of(new));
    }

    pub(crate) fn compare_settings(&mut self, old: &Settings, new: &Settings) {
        self.view = old.view != new.view;
        self.samples = old.samples != new.samples;
        self.model = old.model != new.model;
    }

    fn compare_materials(&mut self, old: &Columns, new: &Columns, ids: std::ops::Range<usize>) {
        for i in ids {
            self.compare_material(i, old.materials.rows.get(i), new.materials.rows.get(i));
        }
    }

    pub(crate) fn compare_material(
        &mut self,
        i: usize,
        old: Option<&MaterialRow>,
        new: Option<&MaterialRow>,
    ) {
        if old.map(MaterialRow::bits) != new.map(MaterialRow::bits) {
            let material = MaterialId(i as u32);
            self.materials.push(MaterialChange { material, old: old.copied(), new: new.copied() });
            let channels =
                |m: Option<&MaterialRow>| m.copied().unwrap_or_default().specular_channels();
            let mut gained = channels(old).into_iter().zip(channels(new));
            if gained.any(|(old, new)| new && !old) {
                self.woken.push(material);
            }
        }
    }

    pub(crate) fn compare_surface(&mut self, i: usize, old: &SurfaceState, new: &SurfaceState) {
        let surface = SurfaceId(i as u32);
        let moved = match (&old.bits, &new.bits) {
            (Some(a), Some(b)) => a.shape != b.shape,
            (None, None) => false,
            _ => true,
        };
        if moved {
            self.surfaces.push(SurfaceChange { surface, old: old.volume, new: new.volume });
        }
        if let (Some(a), Some(b)) = (&old.bits, &new.bits) {
            // All nodes of a surface that moved are made anew.
            if !moved && (a.cells != b.cells || a.tint != b.tint) {
                self.patterns.push(surface);
            }
            if a.materials != b.materials {
                self.repainted.push(surface);
            }
        }
    }

    pub(crate) fn compare_light(
        &mut self,
        i: usize,
        old: Option<LightBits>,
        new: Option<LightBits>,
    ) {
        let light = LightId(i as u32);
        self.lights.extend(match (old, new) {
            (Some(a), Some(b)) if a.place != b.place => Some(LightChange::Place(light)),
            (Some(a), Some(b)) if a.emissivity != b.emissivity => {
                Some(LightChange::Emissivity(light))
            }
            (None, Some(_)) => Some(LightChange::Added(light)),
            (Some(_), None) => Some(LightChange::Removed(light)),
            _ => None,
        });
    }
}

/// The scalar part of a frame, as bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    view: ([u64; 15], Filter),
    samples: [u32; 2],
    model: [u32; 7],
}

impl Settings {
    pub(crate) fn of(c: &Columns) -> Settings {
        let image = Image { samples: c.samples, spread: c.spread, ..Image::default() };
        Settings::new(&c.view, &image, &c.model)
    }

    pub(crate) fn new(view: &View, image: &Image, m: &Model) -> Settings {
        let [r, g, b] = m.background.map(f32::to_bits);
        let path = m.max_path.to_bits();
        let model = [m.max_bounces, path, m.attenuation as u32, m.transfer as u32, r, g, b];
        let samples = [image.samples, spread(*image) as u32];
        Settings { view: (view.bits(), view.filter), samples, model }
    }

    /// Whether two differ in nothing but background and attenuation.
    pub(crate) fn recoloured(&self, other: &Settings) -> bool {
        let shape = |s: &Settings| (s.view, s.samples, s.model[0], s.model[1], s.model[3]);
        shape(self) == shape(other)
    }
}

/// A surface in one of two frames; no bits if it is not there.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceState {
    bits: Option<SurfaceBits>,
    volume: Volume,
}

impl SurfaceState {
    pub(crate) fn of(columns: &Columns, i: usize) -> SurfaceState {
        if i >= columns.surfaces.len() {
            return SurfaceState { bits: None, volume: Volume::Nothing };
        }
        SurfaceState {
            bits: Some(columns.surface_bits(i)),
            volume: volume(&columns.geometry, columns.slots(i)),
        }
    }
}

fn volume(g: &Geometry, slots: std::ops::Range<usize>) -> Volume {
    let bounds = g.bounds[slots.clone()].iter().fold(Aabb::EMPTY, |all, b| all.union(b));
    match g.shape.get(slots.start) {
        _ if bounds.is_empty() => Volume::Nothing,
        Some((ShapeKind::Sphere, row)) => {
            let (center, radius) = g.spheres.row(*row as usize);
            Volume::Ball { center, radius }
        }
        _ => Volume::Box(bounds),
    }
}
