//! Shapes. Lengths are in the scene's own unit.

use crate::fault::{Fault, direction, finite, parallel, positive};
use glam::DVec3;

/// All points at distance `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub center: DVec3,
    /// The radius, above 0.
    pub radius: f64,
}

/// The infinite plane through `point` across `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of the plane, and the origin of its patterns.
    pub point: DVec3,
    /// The normal, of any length but zero.
    pub normal: DVec3,
}

/// The parallelogram `corner + s u + t v`, s and t in \[0, 1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// The corner at s = t = 0, and the origin of its patterns.
    pub corner: DVec3,
    /// The edge along s.
    pub u: DVec3,
    /// The edge along t.
    pub v: DVec3,
}

/// The triangle between three points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The first corner, and the origin of its patterns.
    pub a: DVec3,
    /// The second corner.
    pub b: DVec3,
    /// The third corner.
    pub c: DVec3,
}

/// The flat disc around `center` across `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// The centre, and the origin of its patterns.
    pub center: DVec3,
    /// The normal, of any length but zero.
    pub normal: DVec3,
    /// The radius, above 0.
    pub radius: f64,
}

/// A box whose faces lie along the scene's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cuboid {
    /// Between two corners.
    Corners {
        /// The least x, y and z.
        min: DVec3,
        /// The greatest; each above that of `min`.
        max: DVec3,
    },
    /// Around a point.
    Centered {
        /// The middle.
        center: DVec3,
        /// The lengths along x, y and z, above 0.
        size: DVec3,
    },
}

impl Sphere {
    /// Whether this is a sphere that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("center", &self.center.to_array())?;
        positive("radius", self.radius)
    }
}

impl Plane {
    /// Whether this is a plane that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("point", &self.point.to_array())?;
        direction("normal", self.normal)
    }
}

impl Quad {
    /// `u x v`, the direction of the surface's own normal.
    pub fn normal(&self) -> DVec3 {
        self.u.cross(self.v)
    }

    /// Whether this is a quad that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("corner", &self.corner.to_array())?;
        direction("u", self.u)?;
        direction("v", self.v)?;
        if parallel(self.u, self.v) {
            return Err(Fault::new("v", "must not be parallel to `u`"));
        }
        Ok(())
    }
}

impl Triangle {
    /// `(b - a) x (c - a)`, the direction of the surface's own normal.
    pub fn normal(&self) -> DVec3 {
        (self.b - self.a).cross(self.c - self.a)
    }

    /// Whether this is a triangle that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("a", &self.a.to_array())?;
        finite("b", &self.b.to_array())?;
        finite("c", &self.c.to_array())?;
        let (u, v) = (self.b - self.a, self.c - self.a);
        if parallel(u, v) || !((u.length() as f32).is_normal() && (v.length() as f32).is_normal()) {
            return Err(Fault::new(
                "c",
                "must not lie on the line through `a` and `b`: a triangle needs an area",
            ));
        }
        Ok(())
    }
}

impl Disc {
    /// Whether this is a disc that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("center", &self.center.to_array())?;
        direction("normal", self.normal)?;
        positive("radius", self.radius)
    }
}

impl Cuboid {
    /// The corners of least and of greatest x, y and z.
    pub fn corners(&self) -> [DVec3; 2] {
        match *self {
            Cuboid::Corners { min, max } => [min, max],
            Cuboid::Centered { center, size } => [center - size / 2.0, center + size / 2.0],
        }
    }

    /// Whether this is a cuboid that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        let [min, max] = self.corners();
        let (first, last) = match self {
            Cuboid::Corners { .. } => ("min", "max"),
            Cuboid::Centered { .. } => ("center", "size"),
        };
        finite(first, &min.to_array())?;
        finite(last, &max.to_array())?;
        let above = |k: usize| (max[k] as f32) > min[k] as f32;
        match (self, (0..3).all(above)) {
            (_, true) => Ok(()),
            (Cuboid::Corners { .. }, _) => Err(Fault::new(
                "max",
                "must be above `min` in x, y and z (also after rounding to f32)",
            )),
            (Cuboid::Centered { .. }, _) => Err(Fault::new(
                "size",
                "must be three lengths above 0 (also after rounding the corners to f32)",
            )),
        }
    }
}
