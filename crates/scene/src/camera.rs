//! The two views: a modern camera and the classic window.

use crate::fault::{Fault, direction, finite, parallel, positive};
use glam::DVec3;

/// Where the picture is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// A pinhole at `eye`.
    LookAt {
        /// Where the eye is.
        eye: DVec3,
        /// The point in the middle of the picture.
        look_at: DVec3,
        /// The direction that is up in the picture.
        up: DVec3,
        /// The vertical field of view in degrees, between 0 and 180.
        fov_degrees: f64,
    },
    /// Parallel rays: no perspective.
    Parallel {
        /// Where the middle of the picture is seen from; what lies behind is not in the picture.
        eye: DVec3,
        /// The point in the middle of the picture.
        look_at: DVec3,
        /// The direction that is up in the picture.
        up: DVec3,
        /// The height that the picture shows, above 0.
        height: f64,
    },
    /// The classic view: a window in the plane z = 0, centred at the origin.
    Window {
        /// Where the eye is; not in the window's plane.
        viewpoint: DVec3,
        /// The window's width and height, above 0.
        window: [f64; 2],
    },
}

impl Camera {
    /// Whether this is a camera that can see.
    pub fn check(&self) -> Result<(), Fault> {
        match *self {
            Camera::LookAt { eye, look_at, up, fov_degrees } => {
                finite("eye", &eye.to_array())?;
                finite("look_at", &look_at.to_array())?;
                direction("up", up)?;
                if !(fov_degrees > 0.0 && fov_degrees < 180.0) {
                    return Err(Fault::new("fov", "must be between 0 and 180 degrees"));
                }
                looks(eye, look_at, up)
            }
            Camera::Parallel { eye, look_at, up, height } => {
                finite("eye", &eye.to_array())?;
                finite("look_at", &look_at.to_array())?;
                direction("up", up)?;
                positive("ortho", height)?;
                looks(eye, look_at, up)
            }
            Camera::Window { viewpoint, window } => {
                finite("viewpoint", &viewpoint.to_array())?;
                positive("window", window[0])?;
                positive("window", window[1])?;
                if !(viewpoint.z as f32).is_normal() {
                    return Err(Fault::new(
                        "viewpoint",
                        "must not lie in the window's plane z = 0",
                    ));
                }
                Ok(())
            }
        }
    }
}

/// Whether there is a direction of view, and an up across it.
fn looks(eye: DVec3, look_at: DVec3, up: DVec3) -> Result<(), Fault> {
    if !((look_at - eye).length() as f32).is_normal() {
        return Err(Fault::new("look_at", "must not equal `eye`"));
    }
    if parallel(look_at - eye, up) {
        return Err(Fault::new("up", "must not be along the view from `eye` to `look_at`"));
    }
    Ok(())
}
