//! From the eye to whole pictures, and which pixels of them are stable.

use super::filter::PixelFilter;
use super::recursion::{Ray, Stage, raytrace};
use super::scene::{Camera, Scene};
use super::vec3::{Vec3, v3};

/// Linear intensities, row by row from the top.
#[derive(Clone, Debug)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Vec3>,
}

impl Picture {
    pub fn at(&self, x: usize, y: usize) -> Vec3 {
        self.pixels[y * self.width + x]
    }
}

/// How far the eye's direction (of length 1) moves in the test of stability.
pub const NUDGE: f64 = 1.0 / (1 << 22) as f64;

/// A pixel that changes by more than this, relative to max(1, value), is not stable.
pub const STABLE_WITHIN: f64 = 1e-3;

/// Where the samples of a pixel lie in it, from its upper left corner, in pixels: spread by the
/// filter, then moved until their mean is the centre.
pub fn sample_positions(samples: usize, filter: PixelFilter) -> Vec<(f64, f64)> {
    let along = |step: f64| {
        let spread: Vec<f64> = (0..samples)
            .map(|i| (0.5 + i as f64 * step).fract())
            .map(|u| if filter == PixelFilter::Box { u } else { filter.place(u) })
            .collect();
        let mean = spread.iter().sum::<f64>() / samples as f64;
        spread.into_iter().map(move |x| x + 0.5 - mean)
    };
    along(0.7548776662466927).zip(along(0.5698402909980532)).collect()
}

/// The view with its frame worked out: `right` and `up` span the picture, both of length 1.
struct Eye {
    /// Where the samples of a pixel lie in it.
    places: Vec<(f64, f64)>,
    /// Where rays start at picture coordinates (0, 0), and how far that moves along them.
    base: Vec3,
    spread: [f64; 2],
    right: Vec3,
    up: Vec3,
    /// A direction (not of length 1) at picture coordinates (0, 0), and its changes along them.
    forward: Vec3,
    reach: [f64; 2],
}

impl Eye {
    fn of(scene: &Scene) -> Eye {
        let places = sample_positions(scene.samples, scene.filter);
        match scene.camera {
            Camera::LookAt { eye, look_at, up, fov_degrees } => {
                let forward = (look_at - eye).unit();
                let right = forward.cross(up).unit();
                let k = (fov_degrees.to_radians() / 2.0).tan();
                let aspect = scene.width as f64 / scene.height as f64;
                let up = right.cross(forward);
                let reach = [k * aspect, k];
                Eye { places, base: eye, spread: [0.0; 2], right, up, forward, reach }
            }
            Camera::Ortho { eye, look_at, up, height } => {
                let forward = (look_at - eye).unit();
                let right = forward.cross(up).unit();
                let half = height / 2.0;
                let spread = [half * scene.width as f64 / scene.height as f64, half];
                let up = right.cross(forward);
                Eye { places, base: eye, spread, right, up, forward, reach: [0.0; 2] }
            }
            Camera::Window { viewpoint, window } => Eye {
                places,
                base: viewpoint,
                spread: [0.0; 2],
                right: v3(1.0, 0.0, 0.0),
                up: v3(0.0, 1.0, 0.0),
                forward: -viewpoint,
                reach: [window[0] / 2.0, window[1] / 2.0],
            },
        }
    }

    /// The origin of the ray through the point (x, y) of the picture, in pixels, and its
    /// direction of length 1.
    fn ray(&self, scene: &Scene, x: f64, y: f64) -> (Vec3, Vec3) {
        let across = 2.0 * x / scene.width as f64 - 1.0;
        let upward = 1.0 - 2.0 * y / scene.height as f64;
        let moved = |[a, b]: [f64; 2]| self.right * (across * a) + self.up * (upward * b);
        (self.base + moved(self.spread), (self.forward + moved(self.reach)).unit())
    }
}

/// The pixel (x, y): the plain mean of its samples, each with its direction moved by `nudge`
/// (to the right, upward).
fn pixel(stage: &Stage<'_>, eye: &Eye, x: usize, y: usize, nudge: [f64; 2]) -> Vec3 {
    let scene = stage.scene;
    let mut sum = Vec3::ZERO;
    for &(a, b) in &eye.places {
        let (base, dir) = eye.ray(scene, x as f64 + a, y as f64 + b);
        let moved = dir + eye.right * nudge[0] + eye.up * nudge[1];
        let dir = if nudge == [0.0, 0.0] { dir } else { moved.unit() };
        sum += raytrace(stage, Ray::of_eye(base, dir));
    }
    sum / scene.samples as f64
}

/// The picture of `scene`.
pub fn picture(scene: &Scene) -> Picture {
    let (stage, eye) = (Stage::of(scene), Eye::of(scene));
    let pixels = (0..scene.width * scene.height)
        .map(|i| pixel(&stage, &eye, i % scene.width, i / scene.width, [0.0, 0.0]))
        .collect();
    Picture { width: scene.width, height: scene.height, pixels }
}

/// For each pixel of `picture` whether it is stable: whether it keeps its value, within
/// [`STABLE_WITHIN`], when the eye's direction moves by [`NUDGE`] to the right, to the left, up or
/// down (in the picture's own frame). Four directions, since a pixel just beside an edge changes
/// under the ones that cross it only.
pub fn stable(scene: &Scene, picture: &Picture) -> Vec<bool> {
    let (stage, eye) = (Stage::of(scene), Eye::of(scene));
    let nudges = [[NUDGE, 0.0], [-NUDGE, 0.0], [0.0, NUDGE], [0.0, -NUDGE]];
    picture
        .pixels
        .iter()
        .enumerate()
        .map(|(i, value)| {
            nudges.iter().all(|nudge| {
                let moved = pixel(&stage, &eye, i % scene.width, i / scene.width, *nudge);
                relative_error(*value, moved) <= STABLE_WITHIN
            })
        })
        .collect()
}

/// The largest difference of a channel, relative to max(1, the largest channel of `want`).
pub fn relative_error(want: Vec3, got: Vec3) -> f64 {
    (want - got).largest() / want.largest().max(1.0)
}
