//! `raytrace`, as the course writes it.

use super::scene::{Attenuation, Light, Material, Scene, Wears};
use super::shape::{Departure, own_normal, root, root_of_departure, tile};
use super::vec3::Vec3;

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
pub fn raytrace(scene: &Scene, ray: Ray) -> Vec3 {
    if ray.total_dist > scene.settings.max_path {
        return Vec3::ZERO;
    }
    let Some((surface, t)) = closest(scene, &ray) else {
        return scene.settings.background;
    };
    let total_dist = ray.total_dist + t;
    let p = ray.base + ray.dir * t;
    let shape = &scene.surfaces[surface].shape;
    let own = own_normal(shape, p);
    let inside = own.dot(ray.dir) > 0.0;
    let n = if inside { -own } else { own };
    let here = Departure { surface, inside };
    let material = material(scene, surface, p);

    let mut intensity = material.ambient;
    for light in &scene.lights {
        let geometry = cos_over_r(scene, light, p, n, here);
        let scattered = material.diffuse.zip(light.emissivity, times);
        intensity += scattered.map(|x| times(x, geometry));
    }
    if scene.settings.attenuation == Attenuation::Inverse {
        intensity = intensity / total_dist;
    }
    if material.specular != Vec3::ZERO && ray.depth < scene.settings.max_bounces {
        let u = -ray.dir;
        // `unit` only takes away what 16 bounces would add up in rounding.
        let v = (n * (2.0 * u.dot(n)) - u).unit();
        let mirrored =
            Ray { base: p, dir: v, total_dist, last_hit: Some(here), depth: ray.depth + 1 };
        intensity += material.specular.zip(raytrace(scene, mirrored), times);
    }
    intensity
}

/// The nearest surface along the ray and the way to it; of equals, the one made first.
fn closest(scene: &Scene, ray: &Ray) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for i in 0..scene.surfaces.len() {
        if let Some(t) = root_of(scene, i, ray.last_hit, ray.base, ray.dir)
            && best.is_none_or(|(_, nearest)| t < nearest)
        {
            best = Some((i, t));
        }
    }
    best
}

fn root_of(scene: &Scene, i: usize, last: Option<Departure>, base: Vec3, dir: Vec3) -> Option<f64> {
    let shape = &scene.surfaces[i].shape;
    match last {
        Some(departure) if departure.surface == i => {
            root_of_departure(shape, departure.inside, base, dir)
        }
        _ => root(shape, base, dir),
    }
}

fn material(scene: &Scene, surface: usize, p: Vec3) -> &Material {
    let surface = &scene.surfaces[surface];
    match surface.wears {
        Wears::Material(i) => &scene.materials[i],
        Wears::Checker(i) => &scene.materials[tile(&surface.shape, &scene.checkers[i], p)],
    }
}

/// `cos / r` of `light` at `p`, or 0 where the light is not seen.
fn cos_over_r(scene: &Scene, light: &Light, p: Vec3, n: Vec3, here: Departure) -> f64 {
    let way = light.at - p;
    let r = way.length();
    let dir = way / r;
    let cos = n.dot(dir);
    // A light exactly at `p` has no cosine (NaN), so it is not in front.
    let in_front = cos > 0.0;
    let in_cone = light.cone.is_none_or(|cone| {
        let axis = (cone.aim - light.at).unit();
        axis.dot(-dir) > cone.half_width_degrees.to_radians().cos()
    });
    if !in_front || !in_cone {
        return 0.0;
    }
    let blocked = (0..scene.surfaces.len())
        .any(|i| root_of(scene, i, Some(here), p, dir).is_some_and(|t| t < r));
    if blocked { 0.0 } else { cos / r }
}
