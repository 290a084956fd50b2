//! Pictures that surfaces wear or light shines through.

use crate::fault::{Fault, direction, positive};
use crate::key::Key;
use glam::DVec3;
use std::sync::Arc;

/// A picture's texels, linear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texture {
    /// Texels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Red, green, blue; row by row from the top, so that texel (x, y) from the upper left corner is
    /// `texels[y * width + x]`. All are finite.
    pub texels: Vec<[f32; 3]>,
}

/// How a picture lies on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mapping {
    /// Once over all of it.
    #[default]
    Fit,
    /// Again and again over a flat surface.
    Tile,
}

/// What lies between the middles of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TexelFilter {
    /// A mean of the four around, by distance.
    #[default]
    Bilinear,
    /// The nearest.
    Nearest,
}

/// A material whose reflectivities are multiplied with a picture's texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Textured {
    /// The material.
    pub base: Key,
    /// The picture, shared between all that name the same file.
    pub image: Arc<Texture>,
    /// How it lies on a surface.
    pub mode: Mapping,
    /// With [`Mapping::Tile`], the picture's lengths along x and y, above 0.
    pub size: [f64; 2],
    /// With [`Mapping::Tile`], the direction of x; its part along the surface's normal is removed.
    pub xdir: DVec3,
    /// What lies between the middles of texels.
    pub filter: TexelFilter,
}

impl Textured {
    /// Whether this is a texture that can be rendered (on some surface).
    pub fn check(&self) -> Result<(), Fault> {
        self.size.iter().try_for_each(|s| positive("size", *s))?;
        direction("xdir", self.xdir)
    }

    /// Whether it can be worn by a flat surface with this normal (of any length but zero).
    pub fn check_on(&self, normal: DVec3) -> Result<(), Fault> {
        match self.mode {
            Mapping::Tile => crate::material::lies_across(self.xdir, normal),
            Mapping::Fit => Ok(()),
        }
    }
}
