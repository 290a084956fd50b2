//! What lights give to a point, before shadows.

use super::scene::{Falloff, Light, Scene};
use super::texture::{Edge, Filter, Slide};
use super::vec3::Vec3;

/// Light that comes to a point from `dir` (of length 1), over the way `reach`.
#[derive(Clone, Copy, Debug)]
pub struct Arriving {
    pub dir: Vec3,
    pub reach: f64,
    /// The emissivity that is shown there.
    pub emissivity: Vec3,
    /// What multiplies cos.
    pub weight: f64,
}

/// All that could arrive at `p`, if nothing stood between.
pub fn arriving(scene: &Scene, p: Vec3) -> Vec<Arriving> {
    let lights = scene.lights.iter().filter_map(|light| of_light(scene, light, p));
    let suns = scene.suns.iter().map(|sun| Arriving {
        dir: -sun.direction.unit(),
        reach: f64::INFINITY,
        emissivity: sun.emissivity,
        weight: 1.0,
    });
    lights.chain(suns).collect()
}

fn of_light(scene: &Scene, light: &Light, p: Vec3) -> Option<Arriving> {
    let way = light.at - p;
    let reach = way.length();
    let dir = way / reach;
    let in_cone = light.cone.is_none_or(|cone| {
        let axis = (cone.aim - light.at).unit();
        axis.dot(-dir) > cone.half_width_degrees.to_radians().cos()
    });
    if !in_cone {
        return None;
    }
    let emissivity = match &light.slide {
        None => light.emissivity,
        Some(slide) => shown_by(scene, slide, light, p)?,
    };
    let weight = match light.falloff {
        Falloff::Inverse => 1.0 / reach,
        Falloff::None => 1.0,
        Falloff::Square => 1.0 / (reach * reach),
    };
    Some(Arriving { dir, reach, emissivity, weight })
}

/// The emissivity of a projector toward `p`: none outside of its slide.
fn shown_by(scene: &Scene, slide: &Slide, light: &Light, p: Vec3) -> Option<Vec3> {
    let texture = &scene.textures[slide.texture];
    let forward = (slide.aim - light.at).unit();
    let right = forward.cross(slide.up).unit();
    let up = right.cross(forward);
    let q = p - light.at;
    let z = q.dot(forward);
    let k = slide.half_width_degrees.to_radians().tan();
    let aspect = texture.width as f64 / texture.height as f64;
    let s = 0.5 + 0.5 * q.dot(right) / (z * k);
    let t = 0.5 + 0.5 * q.dot(up) / (z * k) * aspect;
    let inside = z > 0.0 && (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t);
    inside
        .then(|| texture.at(s, t, Filter::Nearest, Edge::Clamp).zip(light.emissivity, |a, b| a * b))
}
