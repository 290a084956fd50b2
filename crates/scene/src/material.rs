//! Reflectivities, and which surface wears what. Colours are linear, red, green, blue.

use crate::fault::{Fault, direction, finite, parallel, positive};
use crate::key::Key;
use glam::DVec3;

/// How a surface answers light. Values are finite; they may exceed 1 or be negative.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Material {
    /// Light that the surface gives off by itself.
    pub ambient: DVec3,
    /// The share of a light's intensity that is scattered.
    pub diffuse: DVec3,
    /// The share of the mirrored ray's intensity; all 0: no ray is cast.
    pub specular: DVec3,
}

impl Material {
    /// What a surface wears that was given no material: a grey matt one.
    pub const GREY_MATT: Material =
        Material { ambient: DVec3::splat(0.05), diffuse: DVec3::splat(0.6), specular: DVec3::ZERO };

    /// Whether this is a material that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("ambient", &self.ambient.to_array())?;
        finite("diffuse", &self.diffuse.to_array())?;
        finite("specular", &self.specular.to_array())
    }
}

/// Two materials in tiles over a flat surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// The material where the sum of the tile's two numbers is even.
    pub even: Key,
    /// The material where it is odd.
    pub odd: Key,
    /// The tiles' lengths along x and y, above 0.
    pub size: [f64; 2],
    /// The direction of x; its part along the surface's normal is removed.
    pub xdir: DVec3,
}

impl Checker {
    /// Whether this is a checker that can be rendered (on some surface).
    pub fn check(&self) -> Result<(), Fault> {
        positive("size", self.size[0])?;
        positive("size", self.size[1])?;
        direction("xdir", self.xdir)
    }

    /// Whether it can be worn by a flat surface with this normal (of any length but zero).
    pub fn check_on(&self, normal: DVec3) -> Result<(), Fault> {
        if parallel(self.xdir, normal) {
            return Err(Fault::new("xdir", "must not be along the normal of the surface"));
        }
        Ok(())
    }
}

/// What every surface has beside its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surface {
    /// The entity with its [`Material`] or [`Checker`]; `None` is [`Material::GREY_MATT`].
    pub material: Option<Key>,
    /// Whether it is in the picture at all.
    pub visible: bool,
}
