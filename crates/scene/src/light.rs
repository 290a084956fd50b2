//! Lights. A light is no surface: nothing hits it.

use crate::fault::{Fault, direction, finite, parallel};
use crate::texture::Texture;
use glam::DVec3;
use std::sync::Arc;

/// How the light that reaches a point falls with its distance r.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Falloff {
    /// As 1 / r.
    #[default]
    Inverse,
    /// Not at all.
    None,
    /// As 1 / r^2.
    Square,
}

/// Light that travels in one direction from infinitely far away; it does not fall with distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Where it travels, of any length but zero.
    pub direction: DVec3,
    /// Its intensity, linear red, green, blue.
    pub emissivity: DVec3,
}

/// A light in one point, the same in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where it is.
    pub at: DVec3,
    /// Its intensity, linear red, green, blue.
    pub emissivity: DVec3,
    /// How it falls with distance.
    pub falloff: Falloff,
}

/// A light in one point that lights a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spotlight {
    /// Where it is.
    pub at: DVec3,
    /// A point on the cone's axis.
    pub aim: DVec3,
    /// The cone's half width in degrees, between 0 and 90.
    pub angle_degrees: f64,
    /// Its intensity, linear red, green, blue.
    pub emissivity: DVec3,
    /// How it falls with distance.
    pub falloff: Falloff,
}

/// A slide in front of a light in one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Projector {
    /// Where it is.
    pub at: DVec3,
    /// A point that the middle of the picture falls on.
    pub aim: DVec3,
    /// The direction that is up in the picture.
    pub up: DVec3,
    /// Half of the angle that the picture's width takes, in degrees, between 0 and 90.
    pub angle_degrees: f64,
    /// The slide, shared between all that name the same file.
    pub image: Arc<Texture>,
    /// The intensity behind the slide, linear red, green, blue.
    pub emissivity: DVec3,
    /// How it falls with distance.
    pub falloff: Falloff,
}

impl Projector {
    /// Whether this is a projector that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("at", &self.at.to_array())?;
        finite("aim", &self.aim.to_array())?;
        direction("up", self.up)?;
        finite("emissivity", &self.emissivity.to_array())?;
        if !(self.angle_degrees > 0.0 && self.angle_degrees < 90.0) {
            return Err(Fault::new("angle", "must be between 0 and 90 degrees"));
        }
        if !((self.aim - self.at).length() as f32).is_normal() {
            return Err(Fault::new("aim", "must not equal `at`"));
        }
        if parallel(self.aim - self.at, self.up) {
            return Err(Fault::new("up", "must not be along the way from `at` to `aim`"));
        }
        Ok(())
    }
}

impl Sun {
    /// Whether this is a light that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        direction("direction", self.direction)?;
        finite("emissivity", &self.emissivity.to_array())
    }
}

impl PointLight {
    /// Whether this is a light that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("at", &self.at.to_array())?;
        finite("emissivity", &self.emissivity.to_array())
    }
}

impl Spotlight {
    /// Whether this is a spotlight that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("at", &self.at.to_array())?;
        finite("aim", &self.aim.to_array())?;
        finite("emissivity", &self.emissivity.to_array())?;
        if !(self.angle_degrees > 0.0 && self.angle_degrees < 90.0) {
            return Err(Fault::new("angle", "must be between 0 and 90 degrees"));
        }
        if !((self.aim - self.at).length() as f32).is_normal() {
            return Err(Fault::new("aim", "must not equal `at`"));
        }
        Ok(())
    }
}
