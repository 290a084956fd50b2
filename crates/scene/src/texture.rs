//! Pictures that surfaces wear.

/// A picture as a file holds it, in linear intensities.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// Red, green, blue; row by row from the top, so that texel (x, y) from the upper left corner is
    /// `texels[y * width + x]`. All are finite.
    pub texels: Vec<[f32; 3]>,
}
