//! Lights. A light is no surface: nothing hits it.

use crate::fault::{Fault, finite};
use glam::DVec3;

/// A light in one point, the same in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where it is.
    pub at: DVec3,
    /// Its intensity, linear red, green, blue.
    pub emissivity: DVec3,
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
