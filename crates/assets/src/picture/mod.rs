//! Picture files to samples, before any of them becomes a number of light or a pixel.
//!
//! | room | reads |
//! | --- | --- |
//! | [`mod@format`] | the first bytes, which tell the format, and the names of those that are not read |
//! | `png`, `jpeg`, `exr` | these, with what a file says of its colours, its windows and its scans |
//! | `netpbm` | PBM, PGM, PPM, PAM and PFM |
//! | `rest` | WebP, TIFF, BMP, TGA, QOI and Radiance HDR |
//!
//! Memory is counted by what a header says, before it is taken: see [`Room`].

mod exr;
pub mod format;
mod jpeg;
mod netpbm;
mod png;
mod rest;

use crate::error::Fault;
use crate::shield;
use format::Format;
pub use image::metadata::Orientation;

/// The longest edge.
pub const LONGEST_EDGE: u32 = 65_535;

/// A decoded picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples of a pixel: 1 grey, 2 grey and opacity, 3 colour, 4 colour and opacity.
    pub channels: usize,
    /// Row by row from the top.
    pub samples: Samples,
    /// What the file says of its samples.
    pub curve: Curve,
    /// How the file says that it is to be turned.
    pub orientation: Orientation,
    /// What the file holds and is left out, for warnings.
    pub notes: Vec<String>,
}

/// The samples of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 0 to 255.
    U8(Vec<u8>),
    /// 0 to `most`.
    U16 {
        /// The samples.
        values: Vec<u16>,
        /// What stands for 1.
        most: u16,
    },
    /// Intensities, all finite.
    F32(Vec<f32>),
}

/// How samples stand for linear intensities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// That of sRGB (IEC 61966-2-1); also where a file says nothing.
    Srgb,
    /// They are intensities.
    Linear,
    /// Intensities are samples to this power.
    Power(f64),
}

/// How much memory a picture may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// For all pictures, in bytes.
    pub most: u64,
    /// What is left of it.
    pub left: u64,
    /// What the caller makes of each pixel, in bytes, beside the samples.
    pub made: u64,
}

impl Room {
    /// How many pixels there are, if edges and memory are within bounds: `each` bytes a pixel while it
    /// is decoded.
    fn pixels(&self, width: u64, height: u64, each: u64) -> Result<usize, Fault> {
        let edges = 1..=u64::from(LONGEST_EDGE);
        if !edges.contains(&width) || !edges.contains(&height) {
            let message = format!("has {width} x {height} pixels; edges are 1 to {LONGEST_EDGE}");
            return Err(Fault::file(message));
        }
        // Both edges have 16 bits: this cannot overflow.
        let need = (width * height).saturating_mul(each.saturating_add(self.made));
        if need > self.left {
            let mib = |bytes: u64| bytes.div_ceil(1 << 20);
            let of = match self.left == self.most {
                true => String::new(),
                false => format!(", of which {} MiB are left", self.left >> 20),
            };
            let message = format!(
                "has {width} x {height} pixels, which take {} MiB to read; pictures may take {} MiB \
                 in all{of}: make it smaller",
                mib(need),
                mib(self.most)
            );
            return Err(Fault::file(message));
        }
        usize::try_from(width * height).map_err(|_| Fault::file("is larger than the address space"))
    }
}

/// The picture in a file given as its bytes, of which the first tell the format.
///
/// # Errors
/// What is none of the formats that are read (its own is named, if it is known), is broken or too
/// large, or holds numbers that are not finite. A decoder that panics is an error, too.
pub fn decode(bytes: &[u8], room: Room) -> Result<Raster, Fault> {
    let format = format::of(bytes)?;
    let decode = || match format {
        Format::Png => png::decode(bytes, room),
        Format::Jpeg => jpeg::decode(bytes, room),
        Format::Exr => exr::decode(bytes, room),
        Format::Netpbm => netpbm::decode(bytes, room),
        Format::WebP | Format::Tiff | Format::Bmp | Format::Tga | Format::Qoi | Format::Hdr => {
            rest::decode(bytes, format, room)
        }
    };
    let raster = shield::shielded(decode).unwrap_or_else(|panic| {
        Err(Fault::file(format!("the {} is broken ({panic})", format.name())))
    })?;
    raster.checked()
}

impl Raster {
    /// Refuses numbers that are not finite.
    fn checked(self) -> Result<Raster, Fault> {
        if let Samples::F32(values) = &self.samples
            && let Some(at) = values.iter().position(|value| !value.is_finite())
        {
            let at = at / self.channels;
            let (x, y) = (at % self.width as usize, at / self.width as usize);
            let message = format!("the texel in column {x} and row {y} is not finite");
            return Err(Fault::file(message));
        }
        Ok(self)
    }

    /// Whether any pixel is not opaque.
    pub fn is_transparent(&self) -> bool {
        fn below<T: Copy + PartialOrd>(values: &[T], channels: usize, opaque: T) -> bool {
            values.chunks_exact(channels).any(|pixel| pixel[channels - 1] < opaque)
        }
        let channels = self.channels;
        channels.is_multiple_of(2)
            && match &self.samples {
                Samples::U8(values) => below(values, channels, 255),
                Samples::U16 { values, most } => below(values, channels, *most),
                Samples::F32(values) => below(values, channels, 1.0),
            }
    }
}

/// Memory for `count` things, or an error.
fn reserved<T>(count: usize) -> Result<Vec<T>, Fault> {
    let mut all = Vec::new();
    all.try_reserve_exact(count).map_err(|_| Fault::file("there is no memory for its pixels"))?;
    Ok(all)
}

/// `count` zeros, or an error.
fn zeros<T: Clone + Default>(count: usize) -> Result<Vec<T>, Fault> {
    let mut all = reserved(count)?;
    all.resize(count, T::default());
    Ok(all)
}

/// Samples of two bytes, the high one first.
fn wide(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect()
}

/// A note on an ICC profile, unless it is that of sRGB, whose name stands in it in ASCII or UTF-16.
fn profile_note(profile: &[u8]) -> Option<String> {
    let wide: Vec<u8> = b"sRGB".iter().flat_map(|byte| [0, *byte]).collect();
    let says = |name: &[u8]| profile.windows(name.len()).any(|part| part == name);
    let srgb = says(b"sRGB") || says(&wide);
    (!srgb).then(|| "its ICC profile is left out: its colours are taken as sRGB".to_owned())
}
