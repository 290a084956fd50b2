//! What rays tell: whether anything is in view, and whether a light is shut in.

use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::view::Projection;
use reflet_pack::{Columns, Key, ShapeKind};
use reflet_scene::DVec3;
use std::collections::HashSet;

/// Rays from the camera, across and down.
pub const GRID: [u32; 2] = [96, 54];
/// Directions in which a light must be shut in.
const DIRECTIONS: u32 = 128;
/// Surfaces that are looked through, one behind the other.
const LAYERS: usize = 64;
/// A ray goes on beyond a hit by this part of the way to it.
const STEP: f32 = 1e-4;

/// Where visible surfaces are that have an end, by their keys.
pub fn middles(columns: &Columns) -> impl Iterator<Item = (Key, DVec3)> + '_ {
    let geometry = &columns.geometry;
    let seen = geometry.slots().filter(|slot| geometry.is_visible(*slot));
    seen.filter_map(|slot| {
        let (bounds, (kind, _)) = (geometry.bounds[slot.index()], geometry.shape[slot.index()]);
        let surface = geometry.surface[slot.index()];
        let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
        let middle = (wide(bounds.lo) + wide(bounds.hi)) / 2.0;
        let ends = kind != ShapeKind::Plane && middle.is_finite();
        ends.then(|| (columns.surfaces.key[surface.index()], middle))
    })
}

/// What rays are cast at.
pub struct Sight<'a> {
    columns: &'a Columns,
    accel: Accel,
    scratch: Scratch,
    hits: Hits,
}

/// Why nothing is in view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Empty {
    /// There is no visible surface.
    NoSurface,
    /// All of them are behind the camera.
    Behind,
    /// All of them are beside the picture.
    Beside,
}

/// What a closed surface holds, a light or the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Within {
    /// The light alone.
    Light,
    /// The eye alone.
    Eye,
}

impl<'a> Sight<'a> {
    /// Rays at a packed scene.
    pub fn new(columns: &'a Columns) -> Option<Self> {
        let level = Isa::Auto.level().ok()?;
        let accel = Accel::build(&columns.geometry, level, Structure::Auto);
        Some(Self { columns, accel, scratch: Scratch::default(), hits: Hits::default() })
    }

    /// The keys of the surfaces that rays hit, and where.
    fn cast(&mut self, rays: &[(DVec3, DVec3, f32)]) -> Vec<Option<(Key, f32)>> {
        let narrow = |v: DVec3| v.to_array().map(|x| x as f32);
        let mut stream = Rays::default();
        for (origin, dir, t_min) in rays {
            stream.push(narrow(*origin), narrow(*dir), f32::INFINITY, HitCode::NONE);
            let i = stream.len() - 1;
            stream.t_min[i] = *t_min;
        }
        stream.pad();
        let mut counts = RayCounts::default();
        self.accel.closest(&stream, &mut self.hits, &mut self.scratch, &mut counts);
        let found = (0..rays.len()).map(|i| {
            let surface = self.columns.surface_of(self.hits.code[i].prim()?);
            Some((self.columns.surfaces.key[surface.index()], self.hits.t[i]))
        });
        found.collect()
    }

    /// Whether the camera sees no surface at all, and why.
    pub fn empty(&mut self) -> Option<Empty> {
        let view = &self.columns.view;
        let [width, height] = view.size.map(f64::from);
        let [across, down] = GRID.map(f64::from);
        let mut rays = Vec::new();
        for y in 0..GRID[1] {
            for x in 0..GRID[0] {
                let (x, y) = ((f64::from(x) + 0.5) / across, (f64::from(y) + 0.5) / down);
                let (origin, dir) = view.ray(x * width, y * height);
                let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
                rays.push((wide(origin), wide(dir), 0.0));
            }
        }
        if self.cast(&rays).iter().any(Option::is_some) {
            return None;
        }
        let geometry = &self.columns.geometry;
        if !geometry.slots().any(|slot| geometry.is_visible(slot)) {
            return Some(Empty::NoSurface);
        }
        // What is smaller than the grid's meshes is in view if its middle is.
        let (mut before, columns) = (false, self.columns);
        for (_, middle) in middles(columns) {
            let [depth, x, y] = place(columns, middle);
            before |= depth > 0.0;
            if depth > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0 {
                return None;
            }
        }
        let planes =
            geometry.slots().any(|slot| geometry.shape[slot.index()].0 == ShapeKind::Plane);
        Some(if before || planes { Empty::Beside } else { Empty::Behind })
    }

    /// The surface between a light and the eye on every way: it is met in every direction from one
    /// of them, and not from the other. A light without a place, a sun, is outside of everything.
    pub fn between(&mut self, light: Option<DVec3>, eye: DVec3) -> Option<(Key, Within)> {
        let around_eye = self.around(eye);
        let around_light = light.map_or_else(HashSet::new, |at| self.around(at));
        let within = |this: &HashSet<Key>, other, within| {
            this.difference(other).min().map(|key| (*key, within))
        };
        within(&around_light, &around_eye, Within::Light)
            .or_else(|| within(&around_eye, &around_light, Within::Eye))
    }

    /// The surfaces that are met in every direction.
    fn around(&mut self, at: DVec3) -> HashSet<Key> {
        let mut met = vec![HashSet::new(); DIRECTIONS as usize];
        let mut starts: Vec<(usize, f32)> = (0..met.len()).map(|i| (i, 0.0)).collect();
        for layer in 0..LAYERS {
            let rays: Vec<_> = starts.iter().map(|(i, t)| (at, direction(*i), *t)).collect();
            let hits = self.cast(&rays);
            if layer == 0 && hits.iter().any(Option::is_none) {
                return HashSet::new();
            }
            let mut on = Vec::new();
            for ((i, _), hit) in starts.into_iter().zip(hits) {
                if let Some((key, t)) = hit {
                    met[i].insert(key);
                    on.push((i, t * (1.0 + STEP) + f32::MIN_POSITIVE));
                }
            }
            starts = on;
            if starts.is_empty() {
                break;
            }
        }
        let mut all = met.into_iter();
        let first = all.next().unwrap_or_default();
        all.fold(first, |common, met| common.intersection(&met).copied().collect())
    }
}

/// Directions that are spread evenly over a sphere (Gonzalez, "Measurement of areas on a sphere
/// using Fibonacci and latitude-longitude lattices", Math. Geosci., 2010).
fn direction(i: usize) -> DVec3 {
    let golden = std::f64::consts::PI * (3.0 - libm::sqrt(5.0));
    let (z, turn) = (1.0 - (2.0 * i as f64 + 1.0) / f64::from(DIRECTIONS), golden * i as f64);
    let r = libm::sqrt(1.0 - z * z);
    DVec3::new(r * libm::cos(turn), r * libm::sin(turn), z)
}

/// Where a point is for the camera: how far ahead, in lengths of its forward vector, and where in
/// the picture, from -1 to 1 across and up.
fn place(columns: &Columns, at: DVec3) -> [f64; 3] {
    let view = &columns.view;
    let [f, r, u] = [view.forward, view.right, view.up].map(DVec3::from_array);
    let p = at - DVec3::from_array(view.eye.map(f64::from));
    // Cramer's rule: the three need not be at right angles.
    let det = f.dot(r.cross(u));
    let [depth, x, y] = [r.cross(u), u.cross(f), f.cross(r)].map(|n| p.dot(n) / det);
    match view.projection {
        Projection::Parallel => [depth, x, y],
        Projection::Perspective => [depth, x / depth, y / depth],
    }
}
