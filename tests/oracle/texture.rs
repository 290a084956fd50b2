//! Small pictures: drawn from a seed, written as files for the binary, read here by definition.

use super::vec3::{Vec3, v3};
use std::path::Path;

/// A picture of 8 bits, rows from the top, and the name of its file.
#[derive(Clone, Debug)]
pub struct Texture {
    pub file: String,
    pub width: usize,
    pub height: usize,
    pub texels: Vec<[u8; 3]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    Nearest,
    Bilinear,
}

/// What is beyond the picture's edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Edge {
    Clamp,
    Wrap,
}

/// A picture in front of a light.
#[derive(Clone, Copy, Debug)]
pub struct Slide {
    pub aim: Vec3,
    pub up: Vec3,
    pub half_width_degrees: f64,
    pub texture: usize,
}

/// The light that an 8-bit sRGB value stands for (IEC 61966-2-1).
pub fn decoded(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

impl Texture {
    /// Texel (i, j), j counted from the top.
    fn texel(&self, i: i64, j: i64, edge: Edge) -> Vec3 {
        let at = |i: i64, n: usize| match edge {
            Edge::Clamp => i.clamp(0, n as i64 - 1) as usize,
            Edge::Wrap => i.rem_euclid(n as i64) as usize,
        };
        let [r, g, b] = self.texels[at(j, self.height) * self.width + at(i, self.width)];
        v3(decoded(r), decoded(g), decoded(b))
    }

    /// The picture at (s, t), s to the right, t upward, the picture itself in [0, 1]^2.
    pub fn at(&self, s: f64, t: f64, filter: Filter, edge: Edge) -> Vec3 {
        let (x, y) = (s * self.width as f64, (1.0 - t) * self.height as f64);
        if filter == Filter::Nearest {
            return self.texel(x.floor() as i64, y.floor() as i64, edge);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (i, j) = (x.floor(), y.floor());
        let (a, b) = (x - i, y - j);
        let row = |j: i64| {
            self.texel(i as i64, j, edge) * (1.0 - a) + self.texel(i as i64 + 1, j, edge) * a
        };
        row(j as i64) * (1.0 - b) + row(j as i64 + 1) * b
    }

    /// Writes the file into `folder`.
    pub fn write(&self, folder: &Path) {
        let path = folder.join(&self.file);
        let file = std::fs::File::create(&path).expect("a file for a texture");
        let mut encoder = png::Encoder::new(file, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(self.texels.as_flattened()).expect("texels");
    }
}
