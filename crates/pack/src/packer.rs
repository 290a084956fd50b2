//! The world into columns, whole or only the rows that a frame touched.

use crate::bounds::Aabb;
use crate::changes::{Changes, Settings, SurfaceState};
use crate::columns::{Columns, LightBits};
use crate::geometry::{Geometry, ShapeKind};
use crate::ids::{LightId, MaterialId, PrimId, SurfaceId};
use crate::lights::{Lights, point_light, spotlight};
use crate::materials::{MaterialRow, Materials};
use crate::surfaces::{Cells, Paint, Surfaces};
use crate::view::{Model, View};
use glam::DVec3;
use reflet_scene::{
    Camera, Checker, Key, Material, Mesh, Plane, PointLight, Quad, Scene, Sphere, Spotlight,
    Surface, Triangle,
};
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::Arc;

/// Where an entity's row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Row {
    None,
    Material(u32),
    Checker,
    Surface(u32),
    Light(u32),
}

/// How many rows of each kind the script's own entities have; a frame's come after them.
#[derive(Clone, Copy, Debug, Default)]
struct Lengths {
    keys: usize,
    materials: usize,
    surfaces: usize,
    prims: usize,
    shapes: [usize; 4],
    lights: usize,
}

/// Columns that follow a scene from frame to frame.
///
/// [`Packer::new`] packs all of the script's own entities. [`Packer::update`] reads again only the
/// rows that this frame touched or the last one did, and those made in a frame; so a frame of a
/// large scene costs what it changes.
pub struct Packer {
    columns: Columns,
    rows: Vec<Row>,
    /// Surfaces by the checker that they wear: the pattern's cells depend on both.
    wearers: HashMap<Key, BTreeSet<SurfaceId>>,
    base: Lengths,
    touched: Vec<Key>,
    overrides: Overrides,
}

/// What stands in for the scene's own settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overrides {
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// No more bounces than this.
    pub max_bounces: Option<u32>,
}

/// The scene has no camera, so there is no picture of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoCamera;

impl std::fmt::Display for NoCamera {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the scene has no camera")
    }
}

impl std::error::Error for NoCamera {}

impl Packer {
    /// Packs a scene as its script left it.
    pub fn new(scene: &Scene, overrides: Overrides) -> Result<Packer, NoCamera> {
        let mut materials = Materials::default();
        materials.push(None, Material::GREY_MATT);
        let columns = Columns {
            geometry: Geometry::default(),
            surfaces: Surfaces::default(),
            materials,
            lights: Lights::default(),
            view: view(scene, &overrides).ok_or(NoCamera)?,
            model: model(scene, &overrides),
            samples: scene.image().samples,
        };
        let mut packer = Packer {
            columns,
            rows: Vec::new(),
            wearers: HashMap::new(),
            base: Lengths::default(),
            touched: Vec::new(),
            overrides,
        };
        let made = packer.append(scene, scene.sealed_len());
        packer.repack_surfaces(scene, made);
        packer.base = packer.lengths();
        Ok(packer)
    }

    /// The columns as of the last call.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// Whether the next [`Packer::update`] will find nothing changed but colours that shading alone
    /// reads: materials of which each goes on reflecting or goes on not to, intensities of lights,
    /// background, attenuation. The ray trees of the columns of now are then those of the scene of
    /// now. `false` may be too careful: a surface that was written counts as moved.
    pub fn only_recolours(&self, scene: &Scene) -> bool {
        let Some(view) = view(scene, &self.overrides) else { return false };
        let settings = Settings::new(&view, scene.image().samples, &model(scene, &self.overrides));
        let made_for_a_frame =
            scene.len() as usize > self.base.keys || self.rows.len() > self.base.keys;
        !made_for_a_frame
            && settings.recoloured(&Settings::of(&self.columns))
            && self.touched.iter().chain(&scene.touched()).all(|key| self.recolours(scene, *key))
    }

    fn recolours(&self, scene: &Scene, key: Key) -> bool {
        match self.rows[key.index()] {
            Row::Material(row) => scene.get::<Material>(key).is_some_and(|new| {
                let old = &self.columns.materials.rows[row as usize];
                MaterialRow::from(new).is_specular() == old.is_specular()
            }),
            Row::Light(row) => light(scene, key).is_some_and(|(place, _)| {
                place.bits() == self.columns.light_place(LightId(row)).bits()
            }),
            Row::Checker | Row::Surface(_) => false,
            Row::None => true,
        }
    }

    /// Follows the scene to its state of now and tells what differs from the call before.
    pub fn update(&mut self, scene: &Scene) -> Changes {
        let mut changes = Changes::default();
        let before = Settings::of(&self.columns);
        let now = scene.touched();
        let mut dirty = std::mem::replace(&mut self.touched, now.clone());
        dirty.extend(now);
        dirty.sort_unstable();
        dirty.dedup();

        let was = self.lengths();
        let old_tail = Tail::of(&self.columns, &self.base);
        self.truncate_to_base();
        // Before the dirty rows are read: they may wear what this frame made.
        let made = self.append(scene, scene.len());

        let mut surfaces = Vec::new();
        for key in dirty {
            match self.rows[key.index()] {
                Row::Material(row) => self.repack_material(scene, key, row, &mut changes),
                Row::Checker => {
                    surfaces.extend(self.wearers.get(&key).into_iter().flatten().map(|s| s.0));
                }
                Row::Surface(row) => surfaces.push(row),
                Row::Light(row) => self.repack_light(scene, key, row, &mut changes),
                Row::None => {}
            }
        }
        surfaces.sort_unstable();
        surfaces.dedup();
        for row in surfaces {
            let old = SurfaceState::of(&self.columns, row as usize);
            self.repack_surface(scene, row as usize);
            changes.compare_surface(
                row as usize,
                &old,
                &SurfaceState::of(&self.columns, row as usize),
            );
        }

        self.repack_surfaces(scene, made);
        if let Some(view) = view(scene, &self.overrides) {
            self.columns.view = view;
        }
        self.columns.model = model(scene, &self.overrides);
        self.columns.samples = scene.image().samples;
        changes.compare_settings(&before, &Settings::of(&self.columns));
        old_tail.compare(&self.columns, &self.base, &was, &self.lengths(), &mut changes);
        changes
    }

    fn lengths(&self) -> Lengths {
        let c = &self.columns;
        let g = &c.geometry;
        Lengths {
            keys: self.rows.len(),
            materials: c.materials.rows.len(),
            surfaces: c.surfaces.len(),
            prims: g.len(),
            shapes: [
                g.spheres.prim.len(),
                g.planes.prim.len(),
                g.quads.prim.len(),
                g.triangles.prim.len(),
            ],
            lights: c.lights.len(),
        }
    }

    fn truncate_to_base(&mut self) {
        let base = self.base;
        let c = &mut self.columns;
        if self.rows.len() > base.keys {
            for wearers in self.wearers.values_mut() {
                wearers.retain(|s| s.index() < base.surfaces);
            }
        }
        self.rows.truncate(base.keys);
        c.materials.truncate(base.materials);
        c.lights.truncate(base.lights);
        c.surfaces.truncate(base.surfaces);
        c.geometry.truncate(base.prims, base.shapes);
    }

    /// Makes rows for the entities from the first that has none yet up to `end`. Rows of surfaces
    /// are left blank, since they may refer to later entities; they are returned.
    fn append(&mut self, scene: &Scene, end: u32) -> Range<usize> {
        let first = self.columns.surfaces.len();
        for index in self.rows.len() as u32..end {
            let key = Key(index);
            let row = self.append_one(scene, key);
            self.rows.push(row);
        }
        first..self.columns.surfaces.len()
    }

    fn repack_surfaces(&mut self, scene: &Scene, rows: Range<usize>) {
        for i in rows {
            self.repack_surface(scene, i);
        }
    }

    fn append_one(&mut self, scene: &Scene, key: Key) -> Row {
        let c = &mut self.columns;
        if scene.has::<Surface>(key) {
            let row = c.surfaces.len() as u32;
            self.append_surface(scene, key);
            Row::Surface(row)
        } else if let Some(material) = scene.get::<Material>(key) {
            c.materials.push(Some(key), material);
            Row::Material(c.materials.rows.len() as u32 - 1)
        } else if scene.has::<Checker>(key) {
            Row::Checker
        } else if let Some((place, emissivity)) = light(scene, key) {
            c.lights.push(key, place, emissivity);
            Row::Light(c.lights.len() as u32 - 1)
        } else {
            Row::None
        }
    }

    fn append_surface(&mut self, scene: &Scene, key: Key) {
        let id = SurfaceId(self.columns.surfaces.len() as u32);
        let mesh = scene.get::<Mesh>(key).map(Arc::new);
        let prims = mesh.as_ref().map_or(1, |m| m.data.triangles.len());
        let kind = shape_kind(scene, key);
        let c = &mut self.columns;
        let first = PrimId(c.geometry.len() as u32);
        c.surfaces.push_blank(key, first, prims as u32, mesh);
        for _ in 0..prims {
            c.geometry.push_blank(kind, id);
        }
    }

    fn repack_material(&mut self, scene: &Scene, key: Key, row: u32, changes: &mut Changes) {
        let Some(material) = scene.get::<Material>(key) else { return };
        let slot = &mut self.columns.materials.rows[row as usize];
        let new = MaterialRow::from(material);
        changes.compare_material(row as usize, Some(&*slot), Some(&new));
        *slot = new;
    }

    fn repack_light(&mut self, scene: &Scene, key: Key, row: u32, changes: &mut Changes) {
        let Some((place, emissivity)) = light(scene, key) else { return };
        let old = self.columns.light_bits(row as usize);
        self.columns.lights.set(row as usize, place, emissivity);
        changes.compare_light(row as usize, Some(old), Some(self.columns.light_bits(row as usize)));
    }

    /// Reads a surface's shape and paint from the world into its rows.
    fn repack_surface(&mut self, scene: &Scene, i: usize) {
        let key = self.columns.surfaces.key[i];
        let Some(surface) = scene.get::<Surface>(key) else { return };
        let c = &mut self.columns;
        c.surfaces.visible[i] = surface.visible;
        let range = c.surfaces.range(i);
        let g = &mut c.geometry;
        let mut frame = (DVec3::ZERO, DVec3::Y);
        if let Some(mesh) = scene.get::<Mesh>(key) {
            let moved = c.surfaces.mesh[i].as_ref().is_none_or(|old| !same_placement(old, &mesh));
            if moved || g.bounds[range.start..].first().is_none_or(Aabb::is_empty) {
                g.set_mesh(range.start, &mesh);
            }
            frame = (mesh.translate, DVec3::Y);
            c.surfaces.mesh[i] = Some(Arc::new(mesh));
        } else if let Some(s) = scene.get::<Sphere>(key) {
            g.set_sphere(range.start, &s);
            frame = (s.center, DVec3::Y);
        } else if let Some(p) = scene.get::<Plane>(key) {
            g.set_plane(range.start, &p);
            frame = (p.point, p.normal);
        } else if let Some(q) = scene.get::<Quad>(key) {
            g.set_quad(range.start, &q);
            frame = (q.corner, q.normal());
        } else if let Some(t) = scene.get::<Triangle>(key) {
            g.set_triangle(range.start, [t.a, t.b, t.c].map(f32s), Some(t.normal()));
            frame = (t.a, t.normal());
        }
        if !surface.visible {
            g.bounds[range].fill(Aabb::EMPTY);
        }
        let paint = self.paint(scene, surface.material, frame);
        self.columns.surfaces.paint[i] = paint;
        // A frame may hand a surface another checker: it is a wearer of both from then on.
        if let Some(m) = surface.material.filter(|_| paint.cells.is_some()) {
            self.wearers.entry(m).or_default().insert(SurfaceId(i as u32));
        }
    }

    fn paint(
        &self,
        scene: &Scene,
        material: Option<Key>,
        (origin, normal): (DVec3, DVec3),
    ) -> Paint {
        let row = |key: Key| match self.rows.get(key.index()) {
            Some(Row::Material(row)) => MaterialId(*row),
            _ => Materials::GREY_MATT,
        };
        let Some(key) = material else {
            return Paint { even: Materials::GREY_MATT, odd: Materials::GREY_MATT, cells: None };
        };
        match scene.get::<Checker>(key) {
            Some(checker) => Paint {
                even: row(checker.even),
                odd: row(checker.odd),
                cells: Some(Cells::new(&checker, origin, normal)),
            },
            None => Paint { even: row(key), odd: row(key), cells: None },
        }
    }
}

/// Rows made for one frame, kept until they are compared with the next frame's.
struct Tail {
    materials: Vec<MaterialRow>,
    surfaces: Vec<SurfaceState>,
    lights: Vec<LightBits>,
}

impl Tail {
    fn of(c: &Columns, base: &Lengths) -> Tail {
        Tail {
            materials: c.materials.rows[base.materials..].to_vec(),
            surfaces: (base.surfaces..c.surfaces.len()).map(|i| SurfaceState::of(c, i)).collect(),
            lights: (base.lights..c.lights.len()).map(|i| c.light_bits(i)).collect(),
        }
    }

    fn compare(self, c: &Columns, base: &Lengths, was: &Lengths, is: &Lengths, out: &mut Changes) {
        let gone = SurfaceState::of(c, usize::MAX);
        let new = Tail::of(c, base);
        for i in 0..was.materials.max(is.materials) - base.materials {
            let row = base.materials + i;
            out.compare_material(row, self.materials.get(i), new.materials.get(i));
        }
        for i in 0..was.surfaces.max(is.surfaces) - base.surfaces {
            let old = self.surfaces.get(i).unwrap_or(&gone);
            out.compare_surface(base.surfaces + i, old, new.surfaces.get(i).unwrap_or(&gone));
        }
        for i in 0..was.lights.max(is.lights) - base.lights {
            out.compare_light(
                base.lights + i,
                self.lights.get(i).copied(),
                new.lights.get(i).copied(),
            );
        }
    }
}

fn model(scene: &Scene, overrides: &Overrides) -> Model {
    let mut model = Model::from(scene.settings());
    model.max_bounces = model.max_bounces.min(overrides.max_bounces.unwrap_or(u32::MAX));
    model
}

fn view(scene: &Scene, overrides: &Overrides) -> Option<View> {
    let camera = scene.get::<Camera>(scene.singletons.camera?)?;
    let image = scene.image();
    Some(View::new(&camera, overrides.size.unwrap_or([image.width, image.height])))
}

fn light(scene: &Scene, key: Key) -> Option<(crate::lights::LightPlace, [f32; 3])> {
    if let Some(l) = scene.get::<PointLight>(key) {
        return Some(point_light(&l));
    }
    scene.get::<Spotlight>(key).map(|l| spotlight(&l))
}

fn shape_kind(scene: &Scene, key: Key) -> ShapeKind {
    if scene.has::<Sphere>(key) {
        ShapeKind::Sphere
    } else if scene.has::<Plane>(key) {
        ShapeKind::Plane
    } else if scene.has::<Quad>(key) {
        ShapeKind::Quad
    } else {
        ShapeKind::Triangle
    }
}

/// Whether two meshes are the same triangles in the same place. The triangles are compared by their
/// address: files are read once.
fn same_placement(a: &Mesh, b: &Mesh) -> bool {
    let place = |m: &Mesh| (m.scale.to_bits(), m.rotate, m.translate);
    Arc::ptr_eq(&a.data, &b.data) && place(a) == place(b)
}

pub(crate) fn f32s(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}
