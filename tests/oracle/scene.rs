//! What a scene is: the nouns of the script's makers, as structs of f64s.

use super::filter::PixelFilter;
use super::mesh::Mesh;
use super::place::Motion;
use super::shader::Shader;
use super::texture::{Filter, Slide, Texture};
use super::vec3::{Vec3, v3};

/// All that a picture depends on. Surfaces stand in the order in which the script makes them, then
/// things do; handles name either by index.
#[derive(Clone, Debug)]
pub struct Scene {
    pub width: usize,
    pub height: usize,
    pub samples: usize,
    pub filter: PixelFilter,
    pub settings: Settings,
    pub camera: Camera,
    pub lights: Vec<Light>,
    pub suns: Vec<Sun>,
    pub materials: Vec<Material>,
    pub checkers: Vec<Checker>,
    pub patterns: Vec<Pattern>,
    pub textures: Vec<Texture>,
    pub surfaces: Vec<Surface>,
    pub things: Vec<Thing>,
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
    Ortho { eye: Vec3, look_at: Vec3, up: Vec3, height: f64 },
}

/// A light at a point.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    pub at: Vec3,
    pub emissivity: Vec3,
    pub falloff: Falloff,
    /// A spotlight's.
    pub cone: Option<Cone>,
    /// A projector's.
    pub slide: Option<Slide>,
}

/// What cos is divided by: the distance, nothing, or the distance squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Falloff {
    #[default]
    Inverse,
    None,
    Square,
}

#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub aim: Vec3,
    pub half_width_degrees: f64,
}

/// A light infinitely far away, that travels along `direction`.
#[derive(Clone, Copy, Debug)]
pub struct Sun {
    pub direction: Vec3,
    pub emissivity: Vec3,
}

#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub ambient: Vec3,
    pub diffuse: Vec3,
    pub specular: Vec3,
}

/// Two materials, by index, in tiles on a flat surface.
#[derive(Clone, Copy, Debug)]
pub struct Checker {
    pub even: usize,
    pub odd: usize,
    pub size: [f64; 2],
    pub xdir: Vec3,
}

/// A pattern for any surface; materials and textures by index.
#[derive(Clone, Copy, Debug)]
pub enum Pattern {
    Solid {
        even: usize,
        odd: usize,
        size: [f64; 3],
    },
    Stripes {
        even: usize,
        odd: usize,
        width: f64,
        xdir: Vec3,
    },
    /// The picture over the surface's (u, v).
    Fit {
        base: usize,
        texture: usize,
        filter: Filter,
    },
    /// The picture again and again, every `size` along the xdir of a flat surface.
    Tile {
        base: usize,
        texture: usize,
        filter: Filter,
        size: [f64; 2],
        xdir: Vec3,
    },
    Shader {
        base: usize,
        shader: Shader,
    },
}

#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub shape: Shape,
    pub wears: Wears,
    pub visible: bool,
}

/// What a surface wears, by index into the scene's columns.
#[derive(Clone, Copy, Debug)]
pub enum Wears {
    Material(usize),
    Checker(usize),
    Pattern(usize),
    /// What a mesh's file says.
    File,
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Sphere { center: Vec3, radius: f64 },
    Plane { point: Vec3, normal: Vec3 },
    Quad { corner: Vec3, u: Vec3, v: Vec3 },
    Triangle { a: Vec3, b: Vec3, c: Vec3 },
    Disc { center: Vec3, normal: Vec3, radius: f64 },
    Cuboid { min: Vec3, max: Vec3 },
    Cylinder { base: Vec3, axis: Vec3, radius: f64, height: f64, caps: bool },
    Cone { apex: Vec3, axis: Vec3, radius: f64, height: f64, caps: bool },
    Paraboloid { vertex: Vec3, axis: Vec3, radius: f64, height: f64, caps: bool },
    Hyperboloid { center: Vec3, axis: Vec3, radius: f64, waist: f64, height: f64, caps: bool },
    Ellipsoid { center: Vec3, radii: Vec3 },
    Torus { center: Vec3, axis: Vec3, major: f64, minor: f64 },
    Mesh { mesh: &'static Mesh },
}

/// A surface or a thing, by index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    Surface(usize),
    Thing(usize),
}

/// What places others. Its parts are surfaces or things before it.
#[derive(Clone, Debug)]
pub struct Thing {
    pub of: Of,
    pub motion: Motion,
    pub visible: bool,
}

#[derive(Clone, Debug)]
pub enum Of {
    Group(Vec<Handle>),
    Instance(Handle),
}

impl Scene {
    /// Nothing but a camera at `eye` that looks at `look_at`.
    pub fn empty(width: usize, height: usize, eye: Vec3, look_at: Vec3) -> Scene {
        Scene {
            width,
            height,
            samples: 1,
            filter: PixelFilter::Box,
            settings: Settings::default(),
            camera: Camera::LookAt { eye, look_at, up: v3(0.0, 1.0, 0.0), fov_degrees: 45.0 },
            lights: Vec::new(),
            suns: Vec::new(),
            materials: Vec::new(),
            checkers: Vec::new(),
            patterns: Vec::new(),
            textures: Vec::new(),
            surfaces: Vec::new(),
            things: Vec::new(),
        }
    }

    /// Adds a material and says what wears it.
    pub fn material(&mut self, ambient: Vec3, diffuse: Vec3, specular: Vec3) -> Wears {
        self.materials.push(Material { ambient, diffuse, specular });
        Wears::Material(self.materials.len() - 1)
    }

    /// Adds a pattern and says what wears it.
    pub fn pattern(&mut self, pattern: Pattern) -> Wears {
        self.patterns.push(pattern);
        Wears::Pattern(self.patterns.len() - 1)
    }

    /// Adds a surface.
    pub fn surface(&mut self, shape: Shape, wears: Wears) -> Handle {
        self.surfaces.push(Surface { shape, wears, visible: true });
        Handle::Surface(self.surfaces.len() - 1)
    }

    /// Adds a group or an instance.
    pub fn thing(&mut self, of: Of, motion: Motion) -> Handle {
        self.things.push(Thing { of, motion, visible: true });
        Handle::Thing(self.things.len() - 1)
    }

    /// Adds a point light.
    pub fn light(&mut self, at: Vec3, emissivity: Vec3) {
        let falloff = Falloff::Inverse;
        self.lights.push(Light { at, emissivity, falloff, cone: None, slide: None });
    }

    /// Adds a spotlight.
    pub fn spotlight(&mut self, at: Vec3, aim: Vec3, half_width_degrees: f64, emissivity: Vec3) {
        self.light(at, emissivity);
        let last = self.lights.len() - 1;
        self.lights[last].cone = Some(Cone { aim, half_width_degrees });
    }

    /// Adds a projector.
    pub fn projector(&mut self, at: Vec3, slide: Slide, emissivity: Vec3) {
        self.light(at, emissivity);
        let last = self.lights.len() - 1;
        self.lights[last].slide = Some(slide);
    }
}
