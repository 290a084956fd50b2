//! Curved shapes and discs, each in coordinates of its own: what `f32` cannot decide.
//!
//! A row holds the affine way from the scene into those coordinates in `f64`; kernels solve for t
//! there, so that t stays in the scene's unit. A row is read whole at each test, so rows are kept
//! together.

use crate::bounds::Aabb;
use glam::{DAffine3, DVec3};

/// What a solid is in its own coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// z = 0, x^2 + y^2 <= 1.
    Disc,
    /// x^2 + y^2 = a + b z + c z^2, z from `z[0]` to `z[1]` (infinite for closed ones).
    Revolved {
        /// a, b and c.
        profile: [f64; 3],
        /// The least and the greatest z.
        z: [f64; 2],
    },
    /// (sqrt(x^2 + y^2) - major)^2 + z^2 = minor^2.
    Torus {
        /// The radius of the ring.
        major: f64,
        /// The radius of its tube.
        minor: f64,
    },
}

impl Form {
    /// The unit sphere.
    pub const BALL: Form =
        Form::Revolved { profile: [1.0, 0.0, -1.0], z: [f64::NEG_INFINITY, f64::INFINITY] };

    /// Two corners of a box around all of it, in its own coordinates; `None` for [`Form::BALL`] and
    /// [`Form::Torus`], whose boxes are tighter found otherwise.
    fn drum(&self) -> Option<(f64, [f64; 2])> {
        match *self {
            Form::Disc => Some((1.0, [0.0, 0.0])),
            Form::Revolved { profile: [a, b, c], z } if z[0].is_finite() => {
                let square = |z: f64| a + b * z + c * z * z;
                // All profiles here are widest at an end.
                let widest = if square(z[0]) > square(z[1]) { square(z[0]) } else { square(z[1]) };
                Some((widest.sqrt(), z))
            }
            _ => None,
        }
    }

    fn bits(&self) -> [u64; 6] {
        match *self {
            Form::Disc => [0; 6],
            Form::Revolved { profile: [a, b, c], z: [low, high] } => {
                [1, a.to_bits(), b.to_bits(), c.to_bits(), low.to_bits(), high.to_bits()]
            }
            Form::Torus { major, minor } => [2, major.to_bits(), minor.to_bits(), 0, 0, 0],
        }
    }
}

/// One solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// What it is in its own coordinates.
    pub form: Form,
    /// The way there from the scene's: rows of a 3x4 matrix.
    pub local: [[f64; 4]; 3],
}

/// Solids, one row each.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    /// The rows.
    pub rows: Vec<Solid>,
}

impl Solids {
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }
}

impl Solid {
    /// A row that no ray hits, to be written over.
    pub(crate) const BLANK: Solid = Solid { form: Form::Disc, local: [[0.0; 4]; 3] };

    /// `form`, put into the scene by `world`; with its box, empty where `world` has no inverse.
    pub(crate) fn new(form: Form, world: &DAffine3) -> (Solid, Aabb) {
        let inverse = world.inverse();
        let (m, t) = (inverse.matrix3, inverse.translation);
        let local = [0, 1, 2].map(|k| [m.x_axis[k], m.y_axis[k], m.z_axis[k], t[k]]);
        if !local.iter().flatten().all(|x| x.is_finite()) {
            return (Solid::BLANK, Aabb::EMPTY);
        }
        let (lo, hi) = corners(&form, world);
        (Solid { form, local }, Aabb::outward(lo.to_array(), hi.to_array()))
    }

    /// All numbers as bits.
    pub fn bits(&self) -> [u64; 18] {
        let mut bits = [0; 18];
        let local = self.local.iter().flatten().map(|x| x.to_bits());
        for (to, from) in bits.iter_mut().zip(self.form.bits().into_iter().chain(local)) {
            *to = from;
        }
        bits
    }
}

/// The corners of a box around `form` as `world` puts it.
fn corners(form: &Form, world: &DAffine3) -> (DVec3, DVec3) {
    let (x, y, z) = (world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis);
    let across =
        |r: f64| DVec3::from_array([0, 1, 2].map(|k| r * (x[k] * x[k] + y[k] * y[k]).sqrt()));
    let around = |center: DVec3, half: DVec3| (center - half, center + half);
    match (form.drum(), form) {
        // The hull of two circles.
        (Some((radius, ends)), _) => {
            let half = across(radius);
            let [a, b] = ends.map(|end| around(world.translation + z * end, half));
            (a.0.min(b.0), a.1.max(b.1))
        }
        // A ball of radius `minor` along a circle.
        (None, Form::Torus { major, minor }) => {
            let ball = minor * DVec3::from_array([0, 1, 2].map(|k| norm([x[k], y[k], z[k]])));
            around(world.translation, across(*major) + ball)
        }
        (None, _) => {
            let half = DVec3::from_array([0, 1, 2].map(|k| norm([x[k], y[k], z[k]])));
            around(world.translation, half)
        }
    }
}

fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}
