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

/// The lengths of a checker's tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tiles {
    /// Along x and y of a flat surface, above 0.
    Flat([f64; 2]),
    /// Along the scene's x, y and z, through any surface; above 0.
    Solid([f64; 3]),
}

/// Two materials in tiles over a flat surface, or in blocks through any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// The material where the sum of the tile's numbers is even.
    pub even: Key,
    /// The material where it is odd.
    pub odd: Key,
    /// The tiles' lengths.
    pub size: Tiles,
    /// The direction of x on a flat surface; its part along the surface's normal is removed.
    pub xdir: DVec3,
}

/// Two materials in stripes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripes {
    /// The material of even stripes, the one that begins at the surface's origin among them.
    pub even: Key,
    /// The material of odd stripes.
    pub odd: Key,
    /// A stripe's width, above 0.
    pub width: f64,
    /// The direction across the stripes; on a flat surface its part along the normal is removed.
    pub xdir: DVec3,
}

impl Checker {
    /// Whether this is a checker that can be rendered (on some surface).
    pub fn check(&self) -> Result<(), Fault> {
        let sizes = match &self.size {
            Tiles::Flat(size) => &size[..],
            Tiles::Solid(size) => &size[..],
        };
        sizes.iter().try_for_each(|s| positive("size", *s))?;
        direction("xdir", self.xdir)
    }

    /// Whether it can be worn by a flat surface with this normal (of any length but zero).
    pub fn check_on(&self, normal: DVec3) -> Result<(), Fault> {
        match self.size {
            Tiles::Flat(_) => lies_across(self.xdir, normal),
            Tiles::Solid(_) => Ok(()),
        }
    }
}

impl Stripes {
    /// Whether these are stripes that can be rendered (on some surface).
    pub fn check(&self) -> Result<(), Fault> {
        positive("width", self.width)?;
        direction("xdir", self.xdir)
    }

    /// Whether they can be worn by a flat surface with this normal (of any length but zero).
    pub fn check_on(&self, normal: DVec3) -> Result<(), Fault> {
        lies_across(self.xdir, normal)
    }
}

pub(crate) fn lies_across(xdir: DVec3, normal: DVec3) -> Result<(), Fault> {
    if parallel(xdir, normal) {
        return Err(Fault::new("xdir", "must not be along the normal of the surface"));
    }
    Ok(())
}

/// What every surface has beside its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surface {
    /// The entity with its [`Material`] or pattern; `None` is [`Material::GREY_MATT`].
    pub material: Option<Key>,
    /// Whether it is in the picture at all.
    pub visible: bool,
}
