//! Where light comes from.

use crate::geometry::Columns3;
use crate::ids::LightId;
use crate::materials::Rgb;
use crate::view::unit;
use reflet_scene::{DVec3, Falloff, Key, PointLight, Projector, Spotlight, Sun, Texture};
use std::sync::Arc;

/// The part of a light that decides what it reaches.
#[derive(Clone, Debug)]
pub struct LightPlace {
    /// Where it is, or the unit direction to it.
    pub at: [f32; 3],
    /// The unit axis of a spotlight's cone, pointing away from the light.
    pub axis: [f32; 3],
    /// The cosine of the cone's half width; a point light has -2, which every angle passes.
    pub cos_angle: f32,
    /// How its light falls with distance.
    pub reach: Reach,
    /// The slide in front of it, and which of its colours this light is.
    pub slide: Option<(Arc<Slide>, Channel)>,
}

/// A picture that light shines through.
#[derive(Clone, Debug)]
pub struct Slide {
    /// The picture.
    pub image: Arc<Texture>,
    /// Of the way q from the light to a point: how far it lies along the light's axis, and how far to
    /// the right and up in halves of the picture's width and height at length 1. All in `f64`.
    pub frame: [[f64; 3]; 3],
}

/// One of three colours. A light behind a slide is three lights, one of each, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// The first of the three, for which shadows are found.
    Red,
    /// See [`Channel::Red`].
    Green,
    /// See [`Channel::Red`].
    Blue,
}

impl Slide {
    /// What of the light passes on the way `q` from the light: a texel, or none beside the picture.
    pub fn texel(&self, q: [f32; 3]) -> [f32; 3] {
        let q = q.map(f64::from);
        let along = |v: &[f64; 3]| v[0] * q[0] + v[1] * q[1] + v[2] * q[2];
        let z = along(&self.frame[0]);
        let (s, t) = (0.5 + 0.5 * along(&self.frame[1]) / z, 0.5 + 0.5 * along(&self.frame[2]) / z);
        // Not a number beside the light's own plane.
        if !(z > 0.0 && (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t)) {
            return [0.0; 3];
        }
        let (w, h) = (self.image.width, self.image.height);
        let (column, row) = ((s * f64::from(w)) as u32, ((1.0 - t) * f64::from(h)) as u32);
        let at = row.min(h - 1) as usize * w as usize + column.min(w - 1) as usize;
        self.image.texels[at]
    }
}

/// How far away a light is, and so how its light falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Somewhere.
    Near(Falloff),
    /// Infinitely far.
    Far,
}

impl LightPlace {
    /// A light without a cone and without a slide.
    fn bare(at: [f32; 3], reach: Reach) -> LightPlace {
        LightPlace { at, axis: [0.0; 3], cos_angle: -2.0, reach, slide: None }
    }

    /// All of it as bits; a slide's picture is its address, since files are read once.
    pub fn bits(&self) -> [u64; 16] {
        let mut bits = [0; 16];
        let small = self.at.iter().chain(&self.axis).chain([&self.cos_angle]);
        for (to, x) in bits.iter_mut().zip(small) {
            *to = u64::from(x.to_bits());
        }
        bits[7] = match self.reach {
            Reach::Near(Falloff::Inverse) => 0,
            Reach::Near(Falloff::None) => 1,
            Reach::Near(Falloff::Square) => 2,
            Reach::Far => 3,
        };
        if let Some((slide, channel)) = &self.slide {
            bits[8] = 1 + *channel as u64;
            bits[9] = Arc::as_ptr(&slide.image) as u64;
            // The axis stands above; these turn and size the picture around it.
            for (to, x) in bits[10..].iter_mut().zip(slide.frame[1..].iter().flatten()) {
                *to = x.to_bits();
            }
        }
        bits
    }

    /// All of it as bits that follow from its content alone.
    pub(crate) fn content_bits(&self) -> Vec<u64> {
        let mut bits = self.bits().to_vec();
        if let Some((slide, _)) = &self.slide {
            bits[9] = u64::from(slide.image.width) << 32 | u64::from(slide.image.height);
            bits.extend(slide.image.texels.iter().flatten().map(|x| u64::from(x.to_bits())));
        }
        bits
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
    /// How far away they are.
    pub reach: Vec<Reach>,
    /// The slides in front of them.
    pub slide: Vec<Option<(Arc<Slide>, Channel)>>,
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
        LightPlace {
            at: self.at.get(i),
            axis: self.axis.get(i),
            cos_angle: self.cos_angle[i],
            reach: self.reach[i],
            slide: self.slide[i].clone(),
        }
    }

    pub(crate) fn push(&mut self, key: Key, place: LightPlace, emissivity: Rgb) {
        self.key.push(key);
        self.at.push(place.at);
        self.axis.push(place.axis);
        self.cos_angle.push(place.cos_angle);
        self.reach.push(place.reach);
        self.slide.push(place.slide);
        self.emissivity.push(emissivity);
    }

    pub(crate) fn set(&mut self, i: usize, place: LightPlace, emissivity: Rgb) {
        self.at.set(i, place.at);
        self.axis.set(i, place.axis);
        self.cos_angle[i] = place.cos_angle;
        self.reach[i] = place.reach;
        self.slide[i] = place.slide;
        self.emissivity[i] = emissivity;
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.key.truncate(n);
        self.at.truncate(n);
        self.axis.truncate(n);
        self.cos_angle.truncate(n);
        self.reach.truncate(n);
        self.slide.truncate(n);
        self.emissivity.truncate(n);
    }
}

pub(crate) fn point_light(light: &PointLight) -> (LightPlace, Rgb) {
    (LightPlace::bare(f32s(light.at), Reach::Near(light.falloff)), f32s(light.emissivity))
}

pub(crate) fn spotlight(light: &Spotlight) -> (LightPlace, Rgb) {
    let place = LightPlace {
        axis: f32s(unit(light.aim - light.at)),
        cos_angle: libm::cos(light.angle_degrees.to_radians()) as f32,
        ..LightPlace::bare(f32s(light.at), Reach::Near(light.falloff))
    };
    (place, f32s(light.emissivity))
}

pub(crate) fn sun(light: &Sun) -> (LightPlace, Rgb) {
    (LightPlace::bare(f32s(unit(-light.direction)), Reach::Far), f32s(light.emissivity))
}

pub(crate) fn projector(light: &Projector) -> [(LightPlace, Rgb); 3] {
    let f = unit(light.aim - light.at);
    let r = unit(f.cross(light.up));
    let u = r.cross(f);
    let k = libm::tan(light.angle_degrees.to_radians());
    let (w, h) = (f64::from(light.image.width), f64::from(light.image.height));
    let frame = [f, r / k, u * (w / h) / k].map(|v| v.to_array());
    let slide = Arc::new(Slide { image: light.image.clone(), frame });
    // The cone through the picture's corners, and a little more.
    let corner = (1.0 + k * k * (1.0 + (h / w) * (h / w))).sqrt();
    let emissivity = f32s(light.emissivity);
    [Channel::Red, Channel::Green, Channel::Blue].map(|channel| {
        let place = LightPlace {
            axis: f32s(f),
            cos_angle: (1.0 / corner - 1e-5) as f32,
            slide: Some((slide.clone(), channel)),
            ..LightPlace::bare(f32s(light.at), Reach::Near(light.falloff))
        };
        let mut own = [0.0; 3];
        own[channel as usize] = emissivity[channel as usize];
        (place, own)
    })
}

fn f32s(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}
