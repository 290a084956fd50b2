//! Random shapes around an axis, motions, patterns and lights.

use super::draw::{Draw, normal_of};
use super::place::Motion;
use super::scene::{Falloff, Pattern, Scene, Shape, Sun, Wears};
use super::shader::{CODES, Function, Shader};
use super::shape::is_flat;
use super::texture::{Filter, Slide, Texture};
use super::vec3::{Vec3, v3};

impl Draw {
    /// An axis or a normal of any length; of some, along y, as people write them.
    pub fn axis(&mut self) -> Vec3 {
        if self.chance(30) {
            return v3(0.0, self.range(0.5, 2.0), 0.0);
        }
        let length = self.range(0.3, 4.0);
        self.vector(length)
    }

    pub fn disc(&mut self, low: Vec3, high: Vec3) -> Shape {
        let center = self.point(low, high);
        Shape::Disc { center, normal: self.axis(), radius: self.range(0.4, 1.5) }
    }

    pub fn cuboid(&mut self, low: Vec3, high: Vec3) -> Shape {
        let min = self.point(low, high);
        let size = self.point(Vec3::splat(0.4), Vec3::splat(1.6));
        Shape::Cuboid { min, max: (min + size).map(|x| self.round(x)) }
    }

    /// A cylinder, cone, paraboloid or hyperboloid; half of them with caps.
    pub fn quadric(&mut self, low: Vec3, high: Vec3) -> Shape {
        let (o, axis) = (self.point(low, high), self.axis());
        let (radius, height) = (self.range(0.3, 0.9), self.range(0.5, 1.8));
        let caps = self.chance(50);
        match self.int(0, 3) {
            0 => Shape::Cylinder { base: o, axis, radius, height, caps },
            1 => Shape::Cone { apex: o, axis, radius, height, caps },
            2 => Shape::Paraboloid { vertex: o, axis, radius, height, caps },
            _ => {
                let waist = self.range(0.1, 0.29);
                Shape::Hyperboloid { center: o, axis, radius, waist, height, caps }
            }
        }
    }

    pub fn ellipsoid(&mut self, low: Vec3, high: Vec3) -> Shape {
        let radii = self.point(Vec3::splat(0.25), Vec3::splat(1.3));
        Shape::Ellipsoid { center: self.point(low, high), radii }
    }

    pub fn torus(&mut self, low: Vec3, high: Vec3) -> Shape {
        let center = self.point(low, high);
        let (major, minor) = (self.range(0.45, 1.3), self.range(0.08, 0.4));
        Shape::Torus { center, axis: self.axis(), major, minor }
    }

    /// Any shape but a plane.
    pub fn shape(&mut self, low: Vec3, high: Vec3) -> Shape {
        match self.int(0, 9) {
            0 => self.sphere(low, high, [0.3, 1.0]),
            1 => self.quad(low, high, [0.6, 2.0]),
            2 => self.triangle(low, high, [0.8, 2.2]),
            3 => self.disc(low, high),
            4 => self.cuboid(low, high),
            5 => self.ellipsoid(low, high),
            6 => self.torus(low, high),
            _ => self.quadric(low, high),
        }
    }

    /// A motion to a place in the box; in some a mirror, in some a stretch.
    pub fn motion(&mut self, low: Vec3, high: Vec3) -> Motion {
        let translate = self.point(low, high);
        let rotate = match self.int(0, 3) {
            0 => Vec3::ZERO,
            1 => v3(0.0, self.range(-180.0, 180.0), 0.0),
            _ => self.point(Vec3::splat(-180.0), Vec3::splat(180.0)),
        };
        let mut scale = match self.int(0, 3) {
            0 => v3(1.0, 1.0, 1.0),
            1 => Vec3::splat(self.range(0.5, 1.5)),
            _ => self.point(Vec3::splat(0.5), Vec3::splat(1.5)),
        };
        if self.chance(25) {
            scale.0[self.int(0, 2)] *= -1.0;
        }
        Motion { translate, rotate, scale }
    }

    fn base(&mut self, scene: &mut Scene) -> usize {
        match self.material(scene, 40) {
            Wears::Material(i) => i,
            _ => unreachable!("materials are drawn as materials"),
        }
    }

    /// A direction far from `normal`, if there is one; of some, the default.
    fn xdir(&mut self, normal: Option<Vec3>) -> Vec3 {
        let fits = |x: Vec3| normal.is_none_or(|n| x.unit().cross(n.unit()).length() > 0.4);
        let x = v3(1.0, 0.0, 0.0);
        if self.chance(30) && fits(x) {
            return x;
        }
        loop {
            let length = self.range(0.5, 3.0);
            let x = self.vector(length);
            if fits(x) {
                return x;
            }
        }
    }

    /// A solid checker or stripes.
    pub fn cells(&mut self, scene: &mut Scene, shape: &Shape) -> Wears {
        let (even, odd) = (self.base(scene), self.base(scene));
        let pattern = if self.chance(50) {
            let size = self.point(Vec3::splat(0.15), Vec3::splat(0.9)).0;
            Pattern::Solid { even, odd, size }
        } else {
            let normal = is_flat(shape).then(|| normal_of(shape));
            Pattern::Stripes { even, odd, width: self.range(0.1, 0.6), xdir: self.xdir(normal) }
        };
        scene.pattern(pattern)
    }

    /// A new picture; `name` makes its file's name one of its own.
    pub fn texture(&mut self, scene: &mut Scene, name: &str) -> usize {
        let (width, height) = (self.int(1, 9), self.int(1, 7));
        let mut byte = || self.int(0, 255) as u8;
        let texels = (0..width * height).map(|_| [byte(), byte(), byte()]).collect();
        let file = format!("{name}-{}.png", scene.textures.len());
        scene.textures.push(Texture { file, width, height, texels });
        scene.textures.len() - 1
    }

    /// A picture on a shape, as a whole or in tiles.
    pub fn textured(&mut self, scene: &mut Scene, name: &str, shape: &Shape) -> Wears {
        let (base, texture) = (self.base(scene), self.texture(scene, name));
        let filter = if self.chance(60) { Filter::Bilinear } else { Filter::Nearest };
        let tiles = matches!(shape, Shape::Plane { .. }) || is_flat(shape) && self.chance(50);
        let pattern = if tiles {
            let size = [self.range(0.4, 2.0), self.range(0.4, 2.0)];
            Pattern::Tile { base, texture, filter, size, xdir: self.xdir(Some(normal_of(shape))) }
        } else {
            Pattern::Fit { base, texture, filter }
        };
        scene.pattern(pattern)
    }

    fn function(&mut self) -> Function {
        let k = [0; 4].map(|_| self.range(0.2, 1.0));
        Function { code: &CODES[self.int(0, CODES.len() - 1)], k }
    }

    /// A shader of one to three functions.
    pub fn shaded(&mut self, scene: &mut Scene) -> Wears {
        let base = self.base(scene);
        let mut shader = Shader::default();
        let first = self.int(0, 2);
        for (i, slot) in
            [&mut shader.ambient, &mut shader.diffuse, &mut shader.specular].into_iter().enumerate()
        {
            if i == first || self.chance(30) {
                *slot = Some(self.function());
            }
        }
        scene.pattern(Pattern::Shader { base, shader })
    }

    /// Whatever fits on a shape.
    pub fn wears(&mut self, scene: &mut Scene, name: &str, shape: &Shape) -> Wears {
        match self.int(0, 9) {
            0 | 1 => self.cells(scene, shape),
            2 | 3 => self.textured(scene, name, shape),
            4 | 5 => self.shaded(scene),
            6 if is_flat(shape) => self.checker(scene, normal_of(shape), 0.2, 1.2),
            _ => self.material(scene, 50),
        }
    }

    /// A sun, a projector, or a light with a falloff.
    pub fn lamp(&mut self, scene: &mut Scene, name: &str) {
        let at = self.point(v3(-5.0, 4.0, -1.0), v3(5.0, 8.0, 6.0));
        let aim = self.point(v3(-1.5, 0.0, -2.0), v3(1.5, 1.5, 0.5));
        match self.int(0, 4) {
            0 => {
                let length = self.range(0.2, 5.0);
                let direction = ((aim - at).unit() * length).map(|x| self.round(x));
                let emissivity = self.colour(0.5, 8.0);
                scene.suns.push(Sun { direction, emissivity });
                return;
            }
            1 | 2 => {
                let texture = self.texture(scene, name);
                let slide = Slide {
                    aim,
                    up: v3(self.range(-0.5, 0.5), 1.0, self.range(-0.2, 0.2)),
                    half_width_degrees: self.range(10.0, 50.0),
                    texture,
                };
                let emissivity = self.colour(30.0, 120.0);
                scene.projector(at, slide, emissivity);
            }
            3 => {
                let (angle, emissivity) = (self.range(10.0, 50.0), self.colour(20.0, 90.0));
                scene.spotlight(at, aim, angle, emissivity);
            }
            _ => {
                let emissivity = self.colour(15.0, 90.0);
                scene.light(at, emissivity);
            }
        }
        let last = scene.lights.len() - 1;
        let light = &mut scene.lights[last];
        // About as bright, whatever it is divided by.
        match self.int(0, 2) {
            0 => {}
            1 => {
                light.falloff = Falloff::None;
                light.emissivity = light.emissivity.map(|x| self.round(x / 8.0));
            }
            _ => {
                light.falloff = Falloff::Square;
                light.emissivity = light.emissivity * 8.0;
            }
        }
    }
}
