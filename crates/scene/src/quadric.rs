//! The quadrics of revolution, the ellipsoid and the torus. Lengths are in the scene's own unit; an
//! axis has any length but zero, and `z` is how far a point lies along it.

use crate::fault::{Fault, direction, finite, positive};
use glam::DVec3;

/// Whether the ends of an open quadric are closed by discs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Caps {
    /// It is open: one sees into it.
    #[default]
    Open,
    /// They are closed, as a part of the same surface.
    Closed,
}

/// A tube: distance `radius` from the axis, z from 0 at `base` to `height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Where the axis begins.
    pub base: DVec3,
    /// The axis' direction.
    pub axis: DVec3,
    /// The radius, above 0.
    pub radius: f64,
    /// The length along the axis, above 0.
    pub height: f64,
    /// Whether both ends are closed.
    pub caps: Caps,
}

/// One nappe of a cone, opening along the axis: distance `radius z / height` from it, z from 0 at
/// `apex` to `height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The point.
    pub apex: DVec3,
    /// The axis' direction.
    pub axis: DVec3,
    /// The radius at `height`, above 0.
    pub radius: f64,
    /// The length along the axis, above 0.
    pub height: f64,
    /// Whether the wide end is closed.
    pub caps: Caps,
}

/// A bowl: the square of the distance from the axis is `radius^2 z / height`, z from 0 at `vertex` to
/// `height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paraboloid {
    /// The lowest point of the bowl.
    pub vertex: DVec3,
    /// The axis' direction.
    pub axis: DVec3,
    /// The radius at `height`, above 0.
    pub radius: f64,
    /// The length along the axis, above 0.
    pub height: f64,
    /// Whether the wide end is closed.
    pub caps: Caps,
}

/// A hyperboloid of one sheet: distance `waist` from the axis at `center`, `radius` at z = -`height`
/// and `height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hyperboloid {
    /// The middle of the waist.
    pub center: DVec3,
    /// The axis' direction.
    pub axis: DVec3,
    /// The radius at both ends.
    pub radius: f64,
    /// The radius in the middle, above 0 and below `radius`.
    pub waist: f64,
    /// The length along the axis from the middle to an end, above 0.
    pub height: f64,
    /// Whether both ends are closed.
    pub caps: Caps,
}

/// A sphere drawn out along x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// The centre.
    pub center: DVec3,
    /// The half axes along x, y and z, above 0.
    pub radii: DVec3,
}

/// A ring: distance `minor` from the circle of radius `major` around the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    /// The middle of the hole.
    pub center: DVec3,
    /// The axis' direction, through the hole.
    pub axis: DVec3,
    /// The radius of the ring.
    pub major: f64,
    /// The radius of its tube, above 0 and below `major`.
    pub minor: f64,
}

fn revolved(
    (name, origin): (&'static str, DVec3),
    axis: DVec3,
    radius: f64,
    height: f64,
) -> Result<(), Fault> {
    finite(name, &origin.to_array())?;
    direction("axis", axis)?;
    positive("radius", radius)?;
    positive("height", height)
}

impl Cylinder {
    /// Whether this is a cylinder that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        revolved(("base", self.base), self.axis, self.radius, self.height)
    }
}

impl Cone {
    /// Whether this is a cone that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        revolved(("apex", self.apex), self.axis, self.radius, self.height)
    }
}

impl Paraboloid {
    /// Whether this is a paraboloid that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        revolved(("vertex", self.vertex), self.axis, self.radius, self.height)
    }
}

impl Hyperboloid {
    /// Whether this is a hyperboloid that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        revolved(("center", self.center), self.axis, self.radius, self.height)?;
        positive("waist", self.waist)?;
        if (self.waist as f32) < self.radius as f32 {
            Ok(())
        } else {
            Err(Fault::new("waist", "must be less than `radius`"))
        }
    }
}

impl Ellipsoid {
    /// Whether this is an ellipsoid that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("center", &self.center.to_array())?;
        self.radii.to_array().into_iter().try_for_each(|r| positive("radii", r))
    }
}

impl Torus {
    /// Whether this is a torus that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        finite("center", &self.center.to_array())?;
        direction("axis", self.axis)?;
        positive("major", self.major)?;
        positive("minor", self.minor)?;
        if (self.minor as f32) < self.major as f32 {
            Ok(())
        } else {
            Err(Fault::new("minor", "must be less than `major`"))
        }
    }
}
