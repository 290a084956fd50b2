//! Random numbers, materials, patterns and surfaces.

use super::scene::{Checker, Scene, Shape, Wears};
use super::vec3::{Vec3, v3};

/// How drawn numbers are rounded, so that packing to f32 loses as much as the family wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rounding {
    /// To f32: packing loses nothing.
    Single,
    /// To multiples of 1/64: besides, many roots, edges and cells are exact.
    Dyadic,
    /// To three decimals, as people write scenes: packing rounds.
    Decimal,
}

/// A stream of numbers: the 64-bit finaliser of MurmurHash3 (Appleby) over a counter.
pub struct Draw {
    counter: u64,
    pub rounding: Rounding,
}

impl Draw {
    pub fn new(seed: u64, rounding: Rounding) -> Draw {
        Draw { counter: seed.wrapping_mul(0x1_0000_0001).wrapping_add(seed << 40), rounding }
    }

    fn bits(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(0xA076_1D64_78BD_642F);
        let mut z = self.counter;
        z = (z ^ (z >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
        z = (z ^ (z >> 33)).wrapping_mul(0xC4CE_B9FE_1A85_EC53);
        z ^ (z >> 33)
    }

    /// `x` on the grid of the family.
    pub fn round(&self, x: f64) -> f64 {
        match self.rounding {
            Rounding::Single => f64::from(x as f32),
            Rounding::Dyadic => (x * 64.0).round() / 64.0,
            Rounding::Decimal => (x * 1000.0).round() / 1000.0,
        }
    }

    /// A number from `low` to `high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        self.round(low + (high - low) * unit)
    }

    /// A whole number from `low` to `high`, both included.
    pub fn int(&mut self, low: usize, high: usize) -> usize {
        low + (self.bits() % (high - low + 1) as u64) as usize
    }

    /// True in `percent` of all cases.
    pub fn chance(&mut self, percent: usize) -> bool {
        self.int(0, 99) < percent
    }

    /// A point in the box.
    pub fn point(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        v3(self.range(low[0], high[0]), self.range(low[1], high[1]), self.range(low[2], high[2]))
    }

    pub fn colour(&mut self, low: f64, high: f64) -> Vec3 {
        if self.chance(15) {
            Vec3::splat(self.range(low, high))
        } else {
            self.point(Vec3::splat(low), Vec3::splat(high))
        }
    }

    /// A vector of about `length`, in any direction.
    pub fn vector(&mut self, length: f64) -> Vec3 {
        loop {
            let v = self.point(Vec3::splat(-1.0), Vec3::splat(1.0));
            if (0.3..1.0).contains(&v.length()) {
                return (v.unit() * length).map(|x| self.round(x));
            }
        }
    }

    /// Two vectors of the given lengths that are far from parallel.
    pub fn span(&mut self, low: f64, high: f64) -> (Vec3, Vec3) {
        loop {
            let (a, b) = (self.range(low, high), self.range(low, high));
            let (u, v) = (self.vector(a), self.vector(b));
            if u.unit().cross(v.unit()).length() > 0.5 {
                return (u, v);
            }
        }
    }

    /// A colour of a mirror; of some, one channel or two are exactly 0.
    pub fn specular(&mut self, low: f64, high: f64) -> Vec3 {
        let mut specular = self.colour(low, high);
        while self.chance(15) {
            specular.0[self.int(0, 2)] = 0.0;
        }
        specular
    }

    /// A material that mirrors in `mirrors` percent of all cases.
    pub fn material(&mut self, scene: &mut Scene, mirrors: usize) -> Wears {
        let ambient = if self.chance(20) { Vec3::ZERO } else { self.colour(0.0, 0.6) };
        let diffuse = if self.chance(8) { Vec3::ZERO } else { self.colour(0.0, 2.5) };
        let specular = if self.chance(mirrors) { self.specular(0.1, 0.95) } else { Vec3::ZERO };
        scene.material(ambient, diffuse, specular)
    }

    /// A checker of two new materials whose x is not near `normal`.
    pub fn checker(&mut self, scene: &mut Scene, normal: Vec3, low: f64, high: f64) -> Wears {
        let index = |wears| match wears {
            Wears::Material(i) => i,
            Wears::Checker(_) | Wears::Pattern(_) | Wears::File => {
                unreachable!("materials are drawn as materials")
            }
        };
        let (even, odd) = (index(self.material(scene, 40)), index(self.material(scene, 40)));
        let size = [self.range(low, high), self.range(low, high)];
        let xdir = loop {
            let length = self.range(0.5, 3.0);
            let xdir = self.vector(length);
            if xdir.unit().cross(normal.unit()).length() > 0.4 {
                break xdir;
            }
        };
        scene.checkers.push(Checker { even, odd, size, xdir });
        Wears::Checker(scene.checkers.len() - 1)
    }

    /// A sphere with its center in the box.
    pub fn sphere(&mut self, low: Vec3, high: Vec3, radius: [f64; 2]) -> Shape {
        let center = self.point(low, high);
        Shape::Sphere { center, radius: self.range(radius[0], radius[1]) }
    }

    /// A quad with a corner in the box.
    pub fn quad(&mut self, low: Vec3, high: Vec3, edge: [f64; 2]) -> Shape {
        let (u, v) = self.span(edge[0], edge[1]);
        Shape::Quad { corner: self.point(low, high), u, v }
    }

    /// A triangle with a corner in the box.
    pub fn triangle(&mut self, low: Vec3, high: Vec3, edge: [f64; 2]) -> Shape {
        let (u, v) = self.span(edge[0], edge[1]);
        let a = self.point(low, high);
        Shape::Triangle { a, b: (a + u).map(|x| self.round(x)), c: (a + v).map(|x| self.round(x)) }
    }
}

/// The normal of a flat shape, of any length.
pub fn normal_of(shape: &Shape) -> Vec3 {
    match *shape {
        Shape::Plane { normal, .. } => normal,
        Shape::Quad { u, v, .. } => u.cross(v),
        Shape::Triangle { a, b, c } => (b - a).cross(c - a),
        Shape::Disc { normal, .. } => normal,
        _ => unreachable!("not a flat shape"),
    }
}
