//! What a scene is: the nouns of the script's makers, as structs of f64s.

use super::vec3::{Vec3, v3};

/// All that a picture depends on. Surfaces stand in the order in which the script makes them.
#[derive(Clone, Debug)]
pub struct Scene {
    pub width: usize,
    pub height: usize,
    pub samples: usize,
    pub settings: Settings,
    pub camera: Camera,
    pub lights: Vec<Light>,
    pub materials: Vec<Material>,
    pub checkers: Vec<Checker>,
    pub surfaces: Vec<Surface>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub max_bounces: usize,
    /// Infinite unless the script says so.
    pub max_path: f64,
    pub attenuation: Attenuation,
    pub background: Vec3,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            max_bounces: 16,
            max_path: f64::INFINITY,
            attenuation: Attenuation::Inverse,
            background: Vec3::ZERO,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attenuation {
    Inverse,
    None,
}

#[derive(Clone, Copy, Debug)]
pub enum Camera {
    LookAt { eye: Vec3, look_at: Vec3, up: Vec3, fov_degrees: f64 },
    Window { viewpoint: Vec3, window: [f64; 2] },
}

#[derive(Clone, Copy, Debug)]
pub struct Light {
    pub at: Vec3,
    pub emissivity: Vec3,
    /// A spotlight's, or none for a point light.
    pub cone: Option<Cone>,
}

#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub aim: Vec3,
    pub half_width_degrees: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub ambient: Vec3,
    pub diffuse: Vec3,
    pub specular: Vec3,
}

/// Two materials, by index, in tiles.
#[derive(Clone, Copy, Debug)]
pub struct Checker {
    pub even: usize,
    pub odd: usize,
    pub size: [f64; 2],
    pub xdir: Vec3,
}

#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub shape: Shape,
    pub wears: Wears,
}

/// What a surface wears, by index into the scene's columns.
#[derive(Clone, Copy, Debug)]
pub enum Wears {
    Material(usize),
    Checker(usize),
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Sphere { center: Vec3, radius: f64 },
    Plane { point: Vec3, normal: Vec3 },
    Quad { corner: Vec3, u: Vec3, v: Vec3 },
    Triangle { a: Vec3, b: Vec3, c: Vec3 },
}

impl Scene {
    /// Nothing but a camera at `eye` that looks at `look_at`.
    pub fn empty(width: usize, height: usize, eye: Vec3, look_at: Vec3) -> Scene {
        Scene {
            width,
            height,
            samples: 1,
            settings: Settings::default(),
            camera: Camera::LookAt { eye, look_at, up: v3(0.0, 1.0, 0.0), fov_degrees: 45.0 },
            lights: Vec::new(),
            materials: Vec::new(),
            checkers: Vec::new(),
            surfaces: Vec::new(),
        }
    }

    /// Adds a material and says what wears it.
    pub fn material(&mut self, ambient: Vec3, diffuse: Vec3, specular: Vec3) -> Wears {
        self.materials.push(Material { ambient, diffuse, specular });
        Wears::Material(self.materials.len() - 1)
    }

    /// Adds a surface.
    pub fn surface(&mut self, shape: Shape, wears: Wears) {
        self.surfaces.push(Surface { shape, wears });
    }

    /// Adds a point light.
    pub fn light(&mut self, at: Vec3, emissivity: Vec3) {
        self.lights.push(Light { at, emissivity, cone: None });
    }

    /// Adds a spotlight.
    pub fn spotlight(&mut self, at: Vec3, aim: Vec3, half_width_degrees: f64, emissivity: Vec3) {
        self.lights.push(Light { at, emissivity, cone: Some(Cone { aim, half_width_degrees }) });
    }
}
