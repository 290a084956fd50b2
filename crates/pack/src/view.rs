//! Eye, picture, settings.

use crate::materials::Rgb;
use reflet_scene::{Attenuation, Camera, DVec3, Filter, Settings, TransferCurve};

/// What camera rays have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Where they start: the eye.
    Perspective,
    /// Their direction: [`View::forward`].
    Parallel,
}

/// How pixels become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// What the rays have in common.
    pub projection: Projection,
    /// Where all camera rays start, or the one in the middle of the picture.
    pub eye: [f32; 3],
    /// The direction of the pixel position (x, y) of a picture of `size` is the unit vector of
    /// `forward + (2 x / width - 1) right + (1 - 2 y / height) up`, computed in `f64` and rounded
    /// once, since neighbouring pixels differ by little. Parallel rays start at `eye +
    /// (2 x / width - 1) right + (1 - 2 y / height) up` instead.
    pub forward: [f64; 3],
    /// Half of the picture's width, as a vector.
    pub right: [f64; 3],
    /// Half of the picture's height, as a vector.
    pub up: [f64; 3],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// How a pixel's positions are spread around its centre.
    pub filter: Filter,
}

impl View {
    /// The view of `camera` on a picture of `size` pixels.
    pub fn new(camera: &Camera, size: [u32; 2], filter: Filter) -> View {
        let [w, h] = size.map(f64::from);
        match *camera {
            Camera::LookAt { eye, look_at, up, fov_degrees } => {
                let [f, r, u] = frame(eye, look_at, up);
                let k = libm::tan(fov_degrees.to_radians() / 2.0);
                View {
                    projection: Projection::Perspective,
                    eye: eye.to_array().map(|x| x as f32),
                    forward: f.to_array(),
                    right: (r * (k * (w / h))).to_array(),
                    up: (u * k).to_array(),
                    size,
                    filter,
                }
            }
            Camera::Parallel { eye, look_at, up, height } => {
                let [f, r, u] = frame(eye, look_at, up);
                let half = height / 2.0;
                View {
                    projection: Projection::Parallel,
                    eye: eye.to_array().map(|x| x as f32),
                    forward: f.to_array(),
                    right: (r * (half * (w / h))).to_array(),
                    up: (u * half).to_array(),
                    size,
                    filter,
                }
            }
            Camera::Window { viewpoint, window } => View {
                projection: Projection::Perspective,
                eye: viewpoint.to_array().map(|x| x as f32),
                forward: (-viewpoint).to_array(),
                right: [window[0] / 2.0, 0.0, 0.0],
                up: [0.0, window[1] / 2.0, 0.0],
                size,
                filter,
            },
        }
    }

    /// Where the ray through pixel position (x, y) starts, and its unit direction; y downward.
    #[inline]
    pub fn ray(&self, x: f64, y: f64) -> ([f32; 3], [f32; 3]) {
        let a = 2.0 * x / f64::from(self.size[0]) - 1.0;
        let b = 1.0 - 2.0 * y / f64::from(self.size[1]);
        let off = |k: usize| a * self.right[k] + b * self.up[k];
        if self.projection == Projection::Parallel {
            let origin = [0, 1, 2].map(|k| (f64::from(self.eye[k]) + off(k)) as f32);
            return (origin, self.forward.map(|x| x as f32));
        }
        let at = |k: usize| self.forward[k] + a * self.right[k] + b * self.up[k];
        let d = [at(0), at(1), at(2)];
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        (self.eye, [(d[0] / length) as f32, (d[1] / length) as f32, (d[2] / length) as f32])
    }

    /// The bits of all that decides the ray through a place of the picture.
    pub fn bits(&self) -> [u64; 15] {
        let mut out = [0; 15];
        let wide = self.forward.iter().chain(&self.right).chain(&self.up).map(|x| x.to_bits());
        let narrow = self.eye.iter().map(|x| u64::from(x.to_bits()));
        let size = self.size.iter().map(|x| u64::from(*x));
        let projection = [u64::from(self.projection == Projection::Parallel)];
        for (o, x) in out.iter_mut().zip(wide.chain(narrow).chain(size).chain(projection)) {
            *o = x;
        }
        out
    }
}

/// The unit vectors forward, to the right and up of a view.
fn frame(eye: DVec3, look_at: DVec3, up: DVec3) -> [DVec3; 3] {
    let f = unit(look_at - eye);
    let r = unit(f.cross(up));
    [f, r, r.cross(f)]
}

pub(crate) fn unit(v: DVec3) -> DVec3 {
    v / v.length()
}

/// The settings of the model, rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Reflections along one path.
    pub max_bounces: u32,
    /// A ray whose path is already longer than this returns 0.
    pub max_path: f32,
    /// Whether intensities fall with the path.
    pub attenuation: Attenuation,
    /// What a ray that hits nothing returns.
    pub background: Rgb,
    /// The curve of files with whole samples.
    pub transfer: TransferCurve,
}

impl From<Settings> for Model {
    fn from(s: Settings) -> Self {
        Self {
            max_bounces: s.max_bounces,
            max_path: s.max_path as f32,
            attenuation: s.attenuation,
            background: s.background.to_array().map(|x| x as f32),
            transfer: s.transfer,
        }
    }
}
