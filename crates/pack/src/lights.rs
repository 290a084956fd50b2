//! Where light comes from.

use crate::geometry::Columns3;
use crate::ids::LightId;
use crate::materials::Rgb;
use reflet_scene::{Key, PointLight, Spotlight};

/// The part of a light that decides what it reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPlace {
    /// Where it is.
    pub at: [f32; 3],
    /// The unit axis of a spotlight's cone, pointing away from the light.
    pub axis: [f32; 3],
    /// The cosine of the cone's half width; a point light has -2, which every angle passes.
    pub cos_angle: f32,
}

impl LightPlace {
    /// The bits of all seven numbers.
    pub fn bits(&self) -> [u32; 7] {
        let [x, y, z] = self.at;
        let [u, v, w] = self.axis;
        [x, y, z, u, v, w, self.cos_angle].map(f32::to_bits)
    }
}

/// Lights, one row each, in key order.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Whose row it is.
    pub key: Vec<Key>,
    /// Positions.
    pub at: Columns3,
    /// Unit axes of the cones.
    pub axis: Columns3,
    /// Cosines of the cones' half widths, -2 for point lights.
    pub cos_angle: Vec<f32>,
    /// Intensities.
    pub emissivity: Vec<Rgb>,
}

impl Lights {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.key.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.key.is_empty()
    }

    /// What light `id` reaches.
    pub fn place(&self, id: LightId) -> LightPlace {
        let i = id.index();
        LightPlace { at: self.at.get(i), axis: self.axis.get(i), cos_angle: self.cos_angle[i] }
    }

    pub(crate) fn push(&mut self, key: Key, place: LightPlace, emissivity: Rgb) {
        self.key.push(key);
        self.at.push(place.at);
        self.axis.push(place.axis);
        self.cos_angle.push(place.cos_angle);
        self.emissivity.push(emissivity);
    }

    pub(crate) fn set(&mut self, i: usize, place: LightPlace, emissivity: Rgb) {
        self.at.set(i, place.at);
        self.axis.set(i, place.axis);
        self.cos_angle[i] = place.cos_angle;
        self.emissivity[i] = emissivity;
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.key.truncate(n);
        self.at.truncate(n);
        self.axis.truncate(n);
        self.cos_angle.truncate(n);
        self.emissivity.truncate(n);
    }
}

pub(crate) fn point_light(light: &PointLight) -> (LightPlace, Rgb) {
    let at = light.at.to_array().map(|x| x as f32);
    let place = LightPlace { at, axis: [0.0; 3], cos_angle: -2.0 };
    (place, light.emissivity.to_array().map(|x| x as f32))
}

pub(crate) fn spotlight(light: &Spotlight) -> (LightPlace, Rgb) {
    let axis = light.aim - light.at;
    let place = LightPlace {
        at: light.at.to_array().map(|x| x as f32),
        axis: (axis / axis.length()).to_array().map(|x| x as f32),
        cos_angle: libm::cos(light.angle_degrees.to_radians()) as f32,
    };
    (place, light.emissivity.to_array().map(|x| x as f32))
}
