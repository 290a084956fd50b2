//! Groups and instances: where they put the things that they hold.

use crate::fault::{Fault, finite};
use crate::key::Key;
use glam::DVec3;
use std::sync::Arc;

/// A way to put a thing elsewhere: a point p comes to lie at R (S p) + T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// S: the factors along x, y and z; none is 0, negative ones mirror.
    pub scale: DVec3,
    /// R: degrees about the x, y and z axes, applied in this order.
    pub rotate: DVec3,
    /// T: in the scene's unit.
    pub translate: DVec3,
    /// Whether it is in the picture at all.
    pub visible: bool,
}

impl Default for Place {
    fn default() -> Self {
        Place { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO, visible: true }
    }
}

impl Place {
    /// Whether this is a place that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("scale", &self.scale.to_array())?;
        if self.scale.to_array().into_iter().any(|s| !(s as f32).is_normal()) {
            return Err(Fault::new("scale", "must not be 0 (also after rounding to f32)"));
        }
        finite("rotate", &self.rotate.to_array())?;
        finite("translate", &self.translate.to_array())
    }
}

/// Things that are moved as a whole, by the entity's [`Place`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The surfaces, groups and instances in it; each is in no other group.
    pub members: Arc<[Key]>,
}

/// One more copy of a thing, put elsewhere by the entity's [`Place`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instance {
    /// A surface, a group or another instance, made before.
    pub of: Key,
}
