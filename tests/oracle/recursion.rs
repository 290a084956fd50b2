//! `raytrace`, as the course writes it.

use super::lamp::{Arriving, arriving};
use super::mesh::risen;
use super::pattern::{Point, material};
use super::place::{Shown, shown};
use super::scene::{Attenuation, Scene, Shape};
use super::shape::{Part, own_normal, root};
use super::vec3::Vec3;

/// A scene and the list of all that is in its picture.
pub struct Stage<'a> {
    pub scene: &'a Scene,
    pub shown: Vec<Shown>,
}

impl Stage<'_> {
    pub fn of(scene: &Scene) -> Stage<'_> {
        Stage { scene, shown: shown(scene) }
    }
}

/// What a ray leaves: one of what is shown, and the part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    pub shown: usize,
    pub part: Part,
}

/// A ray and its history: how long its path is already, what it leaves, how often it was mirrored.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub base: Vec3,
    /// Of length 1.
    pub dir: Vec3,
    pub total_dist: f64,
    pub last_hit: Option<Departure>,
    pub depth: usize,
}

impl Ray {
    /// A ray of the eye.
    pub fn of_eye(base: Vec3, dir: Vec3) -> Ray {
        Ray { base, dir, total_dist: 0.0, last_hit: None, depth: 0 }
    }
}

/// A product in which a factor that is exactly 0 contributes nothing, whatever the other is.
pub fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// The light that comes back along `ray`.
pub fn raytrace(stage: &Stage<'_>, ray: Ray) -> Vec3 {
    let settings = &stage.scene.settings;
    if ray.total_dist > settings.max_path {
        return Vec3::ZERO;
    }
    let Some((here, t)) = closest(stage, &ray) else {
        return settings.background;
    };
    let total_dist = ray.total_dist + t;
    let p = ray.base + ray.dir * t;

    // The point and the normal in the surface's own coordinates, then in the world.
    let copy = &stage.shown[here.shown];
    let shape = &stage.scene.surfaces[copy.surface].shape;
    let (own_p, own_dir) = (copy.point_within(p), copy.direction_within(ray.dir));
    let own = own_normal(shape, here.part, own_p);
    let facing = if own.dot(own_dir) > 0.0 { -own } else { own };
    let mut n = copy.normal_shown(facing);
    let mut lit = Lit { p, n, facing: n, lift: Vec3::ZERO };
    if let (Shape::Mesh { mesh }, Part::Flat(i)) = (shape, here.part)
        && let Some(smooth) = mesh.smooth_normal(i, own_p)
    {
        let smooth = copy.normal_shown(smooth);
        let side = if smooth.dot(n) < 0.0 { -1.0 } else { 1.0 };
        let shown = (|p| copy.point_shown(p), |n| copy.normal_shown(n) * side);
        lit.lift = mesh.lift((i, own_p), shown, (p, n));
        n = smooth * side;
        lit.n = n;
    }
    let at = Point { p: own_p, part: here.part, facing };
    let material = material(stage.scene, copy.surface, at);

    let mut intensity = material.ambient;
    for light in arriving(stage.scene, p) {
        let geometry = seen(stage, &light, &lit, here);
        let scattered = material.diffuse.zip(light.emissivity, times);
        intensity += scattered.map(|x| times(x, geometry));
    }
    if settings.attenuation == Attenuation::Inverse {
        intensity = intensity / total_dist;
    }
    if material.specular != Vec3::ZERO && ray.depth < settings.max_bounces {
        let u = -ray.dir;
        // `unit` only takes away what 16 bounces would add up in rounding.
        let v = (n * (2.0 * u.dot(n)) - u).unit();
        let v = if n == lit.facing { v } else { risen(v, lit.facing) };
        let mirrored =
            Ray { base: p, dir: v, total_dist, last_hit: Some(here), depth: ray.depth + 1 };
        intensity += material.specular.zip(raytrace(stage, mirrored), times);
    }
    intensity
}

/// What the ray meets first, and the way to it; of equals, the one made first.
fn closest(stage: &Stage<'_>, ray: &Ray) -> Option<(Departure, f64)> {
    let mut best: Option<(Departure, f64)> = None;
    for i in 0..stage.shown.len() {
        if let Some((t, part)) = root_of(stage, i, ray.last_hit, ray.base, ray.dir)
            && best.is_none_or(|(_, nearest)| t < nearest)
        {
            best = Some((Departure { shown: i, part }, t));
        }
    }
    best
}

fn root_of(
    stage: &Stage<'_>,
    i: usize,
    last: Option<Departure>,
    base: Vec3,
    dir: Vec3,
) -> Option<(f64, Part)> {
    let copy = &stage.shown[i];
    let shape = &stage.scene.surfaces[copy.surface].shape;
    let leaves = last.filter(|departure| departure.shown == i).map(|departure| departure.part);
    root(shape, copy.point_within(base), copy.direction_within(dir), leaves)
}

/// A point that lights shine on.
struct Lit {
    p: Vec3,
    n: Vec3,
    /// The normal of the triangle, where a mesh has others.
    facing: Vec3,
    /// From there up to the surface that these describe.
    lift: Vec3,
}

/// What the light's emissivity is multiplied with at a point, or 0 where the light is not seen. Light
/// from behind the triangle of a smooth mesh comes over the surface that its normals describe.
fn seen(stage: &Stage<'_>, light: &Arriving, at: &Lit, here: Departure) -> f64 {
    let cos = at.n.dot(light.dir);
    // A light exactly at `p` has no cosine (NaN), so it is not in front.
    let in_front = cos > 0.0;
    if !in_front {
        return 0.0;
    }
    let blocked = |base: Vec3, dir: Vec3, reach: f64| {
        (0..stage.shown.len())
            .any(|i| root_of(stage, i, Some(here), base, dir).is_some_and(|(t, _)| t < reach))
    };
    let hidden = if at.facing.dot(light.dir) > 0.0 || at.lift == Vec3::ZERO {
        blocked(at.p, light.dir, light.reach)
    } else {
        let over = at.p + at.lift;
        let way = at.p + light.dir * light.reach - over;
        let (dir, reach) = match light.reach.is_finite() {
            true => (way.unit(), way.length()),
            false => (light.dir, light.reach),
        };
        blocked(at.p, at.lift.unit(), at.lift.length()) || blocked(over, dir, reach)
    };
    if hidden { 0.0 } else { cos * light.weight }
}
