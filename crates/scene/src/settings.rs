//! The picture, the settings of the model, and the animation: one of each in a scene.

use crate::fault::{Fault, finite};
use glam::DVec3;

/// The size of the picture and its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row, 1 to 65535.
    pub width: u32,
    /// Rows, 1 to 65535.
    pub height: u32,
    /// Samples a pixel, 1 to [`Image::MAX_SAMPLES`].
    pub samples: u32,
    /// Where they are spent.
    pub spread: Spread,
    /// How they weigh what lies around the pixel's centre.
    pub filter: Filter,
}

/// Where the samples of a picture are spent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Spread {
    /// In every pixel.
    #[default]
    Everywhere,
    /// In pixels with an edge; the others show what their centre sees.
    Edges,
}

/// How much what lies at some distance from a pixel's centre counts in it: along x times along y.
/// None reaches farther than the centres of the neighbouring pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Filter {
    /// The same in the whole pixel, nothing outside.
    #[default]
    Box,
    /// Falling evenly to nothing at the neighbours' centres.
    Tent,
    /// A normal distribution of half a pixel's width, cut at the neighbours' centres.
    Gaussian,
}

impl Filter {
    /// All of them, in the order of their names in scripts.
    pub const ALL: [Filter; 3] = [Filter::Box, Filter::Tent, Filter::Gaussian];
    /// Their names, in scripts and files.
    pub const NAMES: &'static [&'static str] = &["box", "tent", "gaussian"];

    /// Its name, in scripts and files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The filter of a name.
    pub fn from_name(name: &str) -> Option<Filter> {
        Self::ALL.into_iter().find(|filter| filter.name() == name)
    }
}

impl Image {
    /// The most pixels in a row, and the most rows.
    pub const MAX_EDGE: u32 = 65_535;
    /// The most samples a pixel.
    pub const MAX_SAMPLES: u32 = 65_536;

    /// Whether this is a picture that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        for (name, edge) in [("width", self.width), ("height", self.height)] {
            if !(1..=Self::MAX_EDGE).contains(&edge) {
                return Err(Fault::new(name, "must be between 1 and 65535"));
            }
        }
        if !(1..=Self::MAX_SAMPLES).contains(&self.samples) {
            return Err(Fault::new("samples", "must be between 1 and 65536"));
        }
        Ok(())
    }
}

impl Default for Image {
    fn default() -> Self {
        Self {
            width: 640,
            height: 360,
            samples: 1,
            spread: Spread::Everywhere,
            filter: Filter::Box,
        }
    }
}

/// Whether an intensity is divided by the length of its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Attenuation {
    /// It is: `1 / total_dist`.
    #[default]
    Inverse,
    /// It is not.
    None,
}

/// How intensities become 8-bit samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TransferCurve {
    /// Through the sRGB curve.
    #[default]
    Srgb,
    /// As they are.
    Linear,
}

/// What holds for the whole scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Reflections along one path, 0 to [`Settings::MAX_BOUNCES`].
    pub max_bounces: u32,
    /// A ray whose path is already longer than this returns 0; infinite by default.
    pub max_path: f64,
    /// Whether intensities fall with the path.
    pub attenuation: Attenuation,
    /// What a ray that hits nothing returns, linear red, green, blue.
    pub background: DVec3,
    /// The curve of 8- and 16-bit files.
    pub transfer: TransferCurve,
}

impl Settings {
    /// The most reflections along one path: a node's index in its tile has 16 bits.
    pub const MAX_BOUNCES: u32 = 65_000;

    /// Whether these are settings that can be rendered.
    pub fn check(&self) -> Result<(), Fault> {
        if self.max_bounces > Self::MAX_BOUNCES {
            return Err(Fault::new("max_bounces", "must be between 0 and 65000"));
        }
        if self.max_path.is_nan() || self.max_path < 0.0 {
            return Err(Fault::new("max_path", "must be a length, at least 0"));
        }
        finite("background", &self.background.to_array())
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_bounces: 16,
            max_path: f64::INFINITY,
            attenuation: Attenuation::Inverse,
            background: DVec3::ZERO,
            transfer: TransferCurve::Srgb,
        }
    }
}

/// How many pictures, how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Animation {
    /// The number of frames, at least 1.
    pub frames: u32,
    /// Frames a second, above 0.
    pub fps: f64,
}

impl Default for Animation {
    fn default() -> Self {
        Self { frames: 1, fps: 24.0 }
    }
}
