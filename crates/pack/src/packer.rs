//! The world into columns, whole or only the rows that a frame touched.

use crate::bounds::Aabb;
use crate::cells::Wide;
use crate::changes::{Changes, Settings, SurfaceState};
use crate::columns::{Columns, LightBits, material_of};
use crate::copies::{MeshCopy, way};
use crate::filter::positions;
use crate::geometry::{Geometry, SHAPE_KINDS, ShapeKind};
use crate::ids::{LightId, MaterialId, PrimId, SurfaceId};
use crate::lights::{LightPlace, Lights, point_light, projector, spotlight, sun};
use crate::materials::{MaterialRow, Materials};
use crate::parts::{Anchor, Part, parts};
use crate::sharing::{Meshes, Sharing};
use crate::sources::{Parents, Source, Sources, sources};
use crate::surfaces::{Cells, Paint, Surfaces};
use crate::tints::{Site, Tint};
use crate::view::{Model, View};
use glam::{DAffine3, DVec3};
use reflet_scene::{
    Camera, Checker, Group, Image, Instance, Key, Mapped, Material, Mesh, PointLight, Projector,
    Scene, Shader, Shading, Spotlight, Spread, Stripes, Sun, Surface, Textured,
};
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::Arc;

/// Where an entity's row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Row {
    None,
    Material(u32),
    /// A checker or stripes, which surfaces wear.
    Pattern,
    /// What is shown of itself, if it is no group: so many surfaces from the first on.
    Shown(u32, u32),
    /// So many lights from the first on.
    Lights(u32, u32),
}

/// How many rows of each kind the script's own entities have; a frame's come after them.
#[derive(Clone, Copy, Debug, Default)]
struct Lengths {
    keys: usize,
    materials: usize,
    surfaces: usize,
    slots: usize,
    shapes: [usize; SHAPE_KINDS],
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
    sources: Sources,
    parents: Parents,
    meshes: Meshes,
    /// Surfaces by what they depend on beside their own entity: the pattern that they wear, places,
    /// and what they are instances of.
    dependents: HashMap<Key, BTreeSet<SurfaceId>>,
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
        Packer::sharing(scene, overrides, Sharing::Auto)
    }

    /// The same, with meshes shared otherwise.
    pub fn sharing(
        scene: &Scene,
        overrides: Overrides,
        sharing: Sharing,
    ) -> Result<Packer, NoCamera> {
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
            spread: spread(scene.image()),
            positions: positions(&scene.image()),
        };
        let mut packer = Packer {
            columns,
            rows: Vec::new(),
            sources: Sources::default(),
            parents: Parents::default(),
            meshes: Meshes::new(sharing),
            dependents: HashMap::new(),
            base: Lengths::default(),
            touched: Vec::new(),
            overrides,
        };
        packer.pack_all(scene);
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
        let settings = Settings::new(&view, &scene.image(), &model(scene, &self.overrides));
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
                let new = MaterialRow::from(new);
                match self.columns.surfaces.tint_channels() {
                    0 => new.is_specular() == old.is_specular(),
                    _ => new.specular_channels() == old.specular_channels(),
                }
            }),
            Row::Lights(first, _) => lights(scene, key)
                .into_iter()
                .zip(first..)
                .all(|(new, row)| new.0.bits() == self.columns.light_place(LightId(row)).bits()),
            Row::Pattern | Row::Shown(..) => false,
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
                Row::Pattern | Row::None => {}
                Row::Shown(first, count) => surfaces.extend(first..first + count),
                Row::Lights(first, _) => self.repack_lights(scene, key, first, &mut changes),
            }
            surfaces.extend(self.dependents.get(&key).into_iter().flatten().map(|s| s.0));
        }
        // Rows made for this frame were never packed before: `old_tail` compares them.
        surfaces.retain(|row| (*row as usize) < self.base.surfaces);
        surfaces.sort_unstable();
        surfaces.dedup();
        for row in surfaces {
            let old = SurfaceState::of(&self.columns, row as usize);
            if self.repack_surface(scene, row as usize) == Fits::No {
                return self.rebuild(scene);
            }
            changes.compare_surface(
                row as usize,
                &old,
                &SurfaceState::of(&self.columns, row as usize),
            );
        }

        if self.repack_surfaces(scene, made) == Fits::No {
            return self.rebuild(scene);
        }
        if let Some(view) = view(scene, &self.overrides) {
            self.columns.view = view;
        }
        self.columns.model = model(scene, &self.overrides);
        self.columns.samples = scene.image().samples;
        self.columns.spread = spread(scene.image());
        changes.compare_settings(&before, &Settings::of(&self.columns));
        if changes.samples || changes.view {
            self.columns.positions = positions(&scene.image());
        }
        old_tail.compare(&self.columns, &self.base, &was, &self.lengths(), &mut changes);
        changes
    }

    /// Packs all entities, into rows that are not there yet. Those made for a frame get theirs
    /// before any surface is read: the script's own may wear them.
    fn pack_all(&mut self, scene: &Scene) {
        let own = self.append(scene, scene.sealed_len());
        self.base = self.lengths();
        let made = self.append(scene, scene.len());
        self.repack_surfaces(scene, own.start..made.end);
    }

    /// Packs everything anew: a surface consists of other kinds of primitives than its rows are for.
    fn rebuild(&mut self, scene: &Scene) -> Changes {
        let mut materials = Materials::default();
        materials.push(None, Material::GREY_MATT);
        self.columns = Columns {
            geometry: Geometry::default(),
            surfaces: Surfaces::default(),
            materials,
            lights: Lights::default(),
            view: view(scene, &self.overrides).unwrap_or(self.columns.view),
            model: model(scene, &self.overrides),
            samples: scene.image().samples,
            spread: spread(scene.image()),
            positions: positions(&scene.image()),
        };
        self.rows.clear();
        self.sources.clear();
        self.parents = Parents::default();
        self.meshes.clear();
        self.dependents.clear();
        self.pack_all(scene);
        Changes { rebuilt: true, ..Changes::default() }
    }

    fn lengths(&self) -> Lengths {
        let c = &self.columns;
        let g = &c.geometry;
        Lengths {
            keys: self.rows.len(),
            materials: c.materials.rows.len(),
            surfaces: c.surfaces.len(),
            slots: g.len(),
            shapes: g.rows_by_kind(),
            lights: c.lights.len(),
        }
    }

    fn truncate_to_base(&mut self) {
        let base = self.base;
        let c = &mut self.columns;
        if self.rows.len() > base.keys {
            for surfaces in self.dependents.values_mut() {
                surfaces.retain(|s| s.index() < base.surfaces);
            }
            self.parents.truncate(base.keys as u32);
        }
        self.rows.truncate(base.keys);
        self.sources.truncate(base.surfaces);
        self.meshes.truncate(base.surfaces);
        c.materials.truncate(base.materials);
        c.lights.truncate(base.lights);
        c.surfaces.truncate(base.surfaces);
        c.geometry.truncate(base.slots, base.shapes);
    }

    /// Makes rows for the entities from the first that has none yet up to `end`. Rows of surfaces
    /// are left blank, since they may refer to later entities; they are returned.
    fn append(&mut self, scene: &Scene, end: u32) -> Range<usize> {
        let first = self.columns.surfaces.len();
        let from = self.rows.len() as u32;
        for key in (from..end).map(Key) {
            // A group is made after its members.
            if let Some(group) = scene.get::<Group>(key) {
                self.parents.note(key, &group);
            }
        }
        for key in (from..end).map(Key) {
            let row = self.append_one(scene, key);
            self.rows.push(row);
        }
        first..self.columns.surfaces.len()
    }

    fn repack_surfaces(&mut self, scene: &Scene, rows: Range<usize>) -> Fits {
        for i in rows {
            if self.repack_surface(scene, i) == Fits::No {
                return Fits::No;
            }
        }
        Fits::Yes
    }

    fn append_one(&mut self, scene: &Scene, key: Key) -> Row {
        let c = &mut self.columns;
        if scene.has::<Surface>(key) || scene.has::<Instance>(key) {
            let first = c.surfaces.len() as u32;
            for source in sources(scene, &self.parents, key) {
                self.append_surface(scene, key, source);
            }
            Row::Shown(first, self.columns.surfaces.len() as u32 - first)
        } else if let Some(material) = scene.get::<Material>(key) {
            c.materials.push(Some(key), material);
            Row::Material(c.materials.rows.len() as u32 - 1)
        } else if is_pattern(scene, key) {
            Row::Pattern
        } else if scene.has::<Group>(key) {
            Row::Shown(0, 0)
        } else {
            let first = c.lights.len() as u32;
            for (place, emissivity) in lights(scene, key) {
                c.lights.push(key, place, emissivity);
            }
            match c.lights.len() as u32 - first {
                0 => Row::None,
                count => Row::Lights(first, count),
            }
        }
    }

    fn append_surface(&mut self, scene: &Scene, key: Key, source: Source) {
        let id = SurfaceId(self.columns.surfaces.len() as u32);
        let mesh = scene.get::<Mesh>(source.surface);
        let materials = mesh.as_ref().map_or(1, |mesh| mesh.data.materials.len().max(1)) as u32;
        let above = source.steps.iter().map(|step| step.place);
        for on in above.chain((source.surface != key).then_some(source.surface)) {
            let rows = (id.0..id.0 + materials).map(SurfaceId);
            self.dependents.entry(on).or_default().extend(rows);
        }
        let g = &mut self.columns.geometry;
        let first = PrimId(g.prims());
        match &mesh {
            Some(mesh) => match self.meshes.shared(id.index(), &mesh.data, g.triangles.len()) {
                Some(shared) => {
                    let to = source.affine(scene);
                    g.push_copy(id, MeshCopy { mesh: shared, world: way(mesh, to.as_ref()) });
                }
                None => {
                    for i in 0..mesh.data.triangles.len() {
                        let id = SurfaceId(id.0 + material_of(&mesh.data, i));
                        g.push_blank(ShapeKind::Triangle, id);
                    }
                }
            },
            None => {
                let to = source.affine(scene);
                for part in parts(scene, source.surface).map(|(parts, _)| parts).unwrap_or_default()
                {
                    let kind = to.as_ref().map_or(part, |to| part.moved(to)).kind();
                    g.push_blank(kind, id);
                }
            }
        }
        let prims = g.prims() - first.0;
        let mesh = mesh.map(Arc::new);
        for material in 0..materials {
            let prims = if material == 0 { prims } else { 0 };
            self.columns.surfaces.push_blank(key, first, prims, mesh.clone());
            let row = self.columns.surfaces.len() - 1;
            self.sources.note(row, key, Source { material, ..source.clone() });
        }
    }

    fn repack_material(&mut self, scene: &Scene, key: Key, row: u32, changes: &mut Changes) {
        let Some(material) = scene.get::<Material>(key) else { return };
        let slot = &mut self.columns.materials.rows[row as usize];
        let new = MaterialRow::from(material);
        changes.compare_material(row as usize, Some(&*slot), Some(&new));
        *slot = new;
    }

    fn repack_lights(&mut self, scene: &Scene, key: Key, first: u32, changes: &mut Changes) {
        for ((place, emissivity), row) in lights(scene, key).into_iter().zip(first as usize..) {
            let old = self.columns.light_bits(row);
            self.columns.lights.set(row, place, emissivity);
            changes.compare_light(row, Some(old), Some(self.columns.light_bits(row)));
        }
    }

    /// Reads a surface's shape and paint from the world into its rows.
    fn repack_surface(&mut self, scene: &Scene, i: usize) -> Fits {
        let source = self.sources.of(i, self.columns.surfaces.key[i]);
        let key = source.surface;
        let Some(surface) = scene.get::<Surface>(key) else { return Fits::Yes };
        let visible = source.is_visible(scene);
        let to = source.affine(scene);
        let c = &mut self.columns;
        c.surfaces.visible[i] = visible;
        let slots = c.slots(i);
        let g = &mut c.geometry;
        let anchor;
        let mut own_parts = Vec::new();
        let mut material = surface.material;
        if let Some(mesh) = scene.get::<Mesh>(key) {
            let old = c.surfaces.mesh[i].as_ref();
            if old.is_some_and(|old| !Arc::ptr_eq(&old.data, &mesh.data)) {
                return Fits::No;
            }
            let number = source.material;
            material = material.or_else(|| mesh.worn_for(number as usize));
            let moved = old.is_none_or(|old| !same_placement(old, &mesh))
                || c.surfaces.moved_by[i] != to.map(affine_bits);
            if number > 0 {
                // The primitives are those of the first material's row.
            } else if moved || g.bounds[slots.start..].first().is_none_or(Aabb::is_empty) {
                g.place_mesh(slots.start, &mesh.data, &way(&mesh, to.as_ref()));
            }
            anchor = Anchor { origin: mesh.translate, normal: None };
            let smooth = mesh.shading == Shading::Smooth && !mesh.data.normals.is_empty();
            let turn = smooth.then(|| crate::rows::normal_turn(&mesh, to.as_ref()));
            c.surfaces.set_smooth(i, turn);
            c.surfaces.mesh[i] = Some(Arc::new(mesh));
            c.surfaces.moved_by[i] = to.map(affine_bits);
        } else {
            let Some((parts, own)) = parts(scene, source.surface) else { return Fits::Yes };
            let moved = |part: &Part| to.as_ref().map_or(*part, |to| part.moved(to));
            let kinds = parts.iter().map(|part| moved(part).kind());
            if !kinds.eq(g.shape[slots.clone()].iter().map(|(kind, _)| *kind)) {
                return Fits::No;
            }
            for (slot, part) in slots.clone().zip(&parts) {
                g.set_part(slot, &moved(part));
            }
            (own_parts, anchor) = (parts, own);
        }
        if !visible {
            g.bounds[slots].fill(Aabb::EMPTY);
        }
        let site = Site { anchor, parts: &own_parts, to: to.as_ref() };
        let paint = self.paint(scene, material, &site);
        // A frame may hand a surface another pattern: it depends on both from then on.
        if let Some(m) = material.filter(|m| is_pattern(scene, *m)) {
            self.dependents.entry(m).or_default().insert(SurfaceId(i as u32));
        }
        self.columns.surfaces.set_paint(i, paint);
        Fits::Yes
    }

    fn paint(&self, scene: &Scene, material: Option<Key>, site: &Site<'_>) -> Paint {
        let row = |key: Key| match self.rows.get(key.index()) {
            Some(Row::Material(row)) => MaterialId(*row),
            _ => Materials::GREY_MATT,
        };
        let Some(key) = material else { return Paint::plain(Materials::GREY_MATT) };
        let alternate = |even, odd, cells: Wide| {
            let cells = site.to.map_or_else(|| cells.rounded(), |to| cells.moved(to).rounded());
            Paint { even: row(even), odd: row(odd), cells: Some(Box::new(cells)), tint: None }
        };
        let tinted = |base, tint| Paint { tint: Some(Arc::new(tint)), ..Paint::plain(row(base)) };
        if let Some(checker) = scene.get::<Checker>(key) {
            alternate(checker.even, checker.odd, Cells::checker(&checker, &site.anchor))
        } else if let Some(stripes) = scene.get::<Stripes>(key) {
            alternate(stripes.even, stripes.odd, Cells::stripes(&stripes, &site.anchor))
        } else if let Some(textured) = scene.get::<Textured>(key) {
            tinted(textured.base, Tint::textured(&textured, site))
        } else if let Some(shader) = scene.get::<Shader>(key) {
            tinted(shader.base, Tint::shader(&shader, site))
        } else if let Some(Mapped(maps)) = scene.get::<Mapped>(key) {
            tinted(key, Tint::mapped(maps, site))
        } else {
            Paint::plain(row(key))
        }
    }
}

/// Whether a surface's parts are of the kinds that its rows are for, and a mesh is of the same file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fits {
    Yes,
    No,
}

fn is_pattern(scene: &Scene, key: Key) -> bool {
    scene.has::<Checker>(key)
        || scene.has::<Stripes>(key)
        || scene.has::<Textured>(key)
        || scene.has::<Shader>(key)
}

fn affine_bits(to: DAffine3) -> Box<[u64; 12]> {
    Box::new(to.to_cols_array().map(f64::to_bits))
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

/// One sample is everywhere.
pub(crate) fn spread(image: Image) -> Spread {
    if image.samples > 1 { image.spread } else { Spread::Everywhere }
}

fn view(scene: &Scene, overrides: &Overrides) -> Option<View> {
    let camera = scene.get::<Camera>(scene.singletons.camera?)?;
    let image = scene.image();
    let size = overrides.size.unwrap_or([image.width, image.height]);
    Some(View::new(&camera, size, image.filter))
}

/// The lights that an entity is: one, or one a colour.
fn lights(scene: &Scene, key: Key) -> Vec<(LightPlace, [f32; 3])> {
    if let Some(l) = scene.get::<PointLight>(key) {
        return vec![point_light(&l)];
    }
    if let Some(l) = scene.get::<Spotlight>(key) {
        return vec![spotlight(&l)];
    }
    if let Some(l) = scene.get::<Sun>(key) {
        return vec![sun(&l)];
    }
    scene.get::<Projector>(key).map(|l| projector(&l).to_vec()).unwrap_or_default()
}

/// Whether two meshes are in the same place, by bits.
fn same_placement(a: &Mesh, b: &Mesh) -> bool {
    let turn = |m: &Mesh| [m.rotate, m.translate].map(|v| v.to_array().map(f64::to_bits));
    a.scale.to_bits() == b.scale.to_bits() && turn(a) == turn(b)
}

pub(crate) fn f32s(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}
