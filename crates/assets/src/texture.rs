//! Pictures to texels in linear intensities.
//!
//! Samples of 8 and 16 bits go through the curve that their file tells of, that of sRGB (IEC
//! 61966-2-1) where it tells of none; floats are taken as they are. Grey becomes three equal numbers.
//! Transparency, primaries and profiles are left out, which a note says.

use crate::error::{AssetError, Fault};
use crate::picture::{self, Curve, Orientation, Raster, Room, Samples};
use reflet_scene::Texture;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The memory that all textures of a scene may take, and what decoding one takes beside them, in
/// bytes: 8,192 x 8,192 texels fit.
pub const MOST_BYTES: u64 = 1 << 30;

/// The most texels of a scene.
pub const MOST_TEXELS: u64 = MOST_BYTES / TEXEL;

/// What a texel takes.
const TEXEL: u64 = size_of::<[f32; 3]>() as u64;

/// How samples become numbers, and whether a picture is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Encoding {
    /// As the file says of itself.
    #[default]
    Told,
    /// Colours in sRGB, whatever the file says of itself (as glTF has it).
    Srgb,
    /// Numbers that are no colours: as they are, whatever the file says of itself.
    Linear,
}

/// A picture that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Read {
    /// Its texels.
    pub texture: Arc<Texture>,
    /// Whether a pixel of the file is not opaque, which the texels do not tell.
    pub transparent: bool,
    /// What the file says and is left out; with [`Encoding::Told`] transparency, too.
    pub notes: Vec<String>,
}

/// The texture in a file given as its bytes, of which the first tell the format, as it says of
/// itself.
///
/// # Errors
/// What is no picture that is read, is broken or too large, or holds numbers that are not finite;
/// where the decoder does not tell a place, of the whole file.
pub fn decode(bytes: &[u8]) -> Result<Texture, Fault> {
    read(bytes, Encoding::Told).map(|read| Arc::unwrap_or_clone(read.texture))
}

/// The same, with samples taken for what the caller knows them to be, and what is left out.
///
/// # Errors
/// As [`decode`].
pub fn read(bytes: &[u8], encoding: Encoding) -> Result<Read, Fault> {
    within(bytes, encoding, Room { most: MOST_BYTES, left: MOST_BYTES, made: TEXEL })
}

fn within(bytes: &[u8], encoding: Encoding, room: Room) -> Result<Read, Fault> {
    let mut raster = picture::decode(bytes, room)?;
    let transparent = raster.is_transparent();
    let mut notes = std::mem::take(&mut raster.notes);
    match encoding {
        Encoding::Told if transparent => notes.push("its transparency is left out".to_owned()),
        Encoding::Told => {}
        Encoding::Srgb => raster.curve = Curve::Srgb,
        Encoding::Linear => raster.curve = Curve::Linear,
    }
    if encoding != Encoding::Told {
        raster.orientation = Orientation::NoTransforms;
        notes.clear();
    }
    let texture = Arc::new(texels(&raster)?);
    Ok(Read { texture, transparent, notes })
}

/// sRGB to linear, of a sample in 0..=1.
pub(crate) fn linear(sample: f64) -> f32 {
    let linear = match sample <= 0.04045 {
        true => sample / 12.92,
        false => libm::pow((sample + 0.055) / 1.055, 2.4),
    };
    linear as f32
}

/// The intensities of all samples up to `most`.
fn table(curve: Curve, most: u16) -> Vec<f32> {
    let samples = (0..=most).map(|sample| f64::from(sample) / f64::from(most));
    match curve {
        Curve::Srgb => samples.map(linear).collect(),
        Curve::Linear => samples.map(|sample| sample as f32).collect(),
        Curve::Power(power) => samples.map(|sample| libm::pow(sample, power) as f32).collect(),
    }
}

fn texels(raster: &Raster) -> Result<Texture, Fault> {
    match &raster.samples {
        Samples::U8(values) => {
            let table = table(raster.curve, 255);
            turned(raster, values, |sample| table[usize::from(sample)])
        }
        Samples::U16 { values, most } => {
            let table = table(raster.curve, *most);
            turned(raster, values, |sample| table[usize::from(sample)])
        }
        Samples::F32(values) => turned(raster, values, |sample| sample),
    }
}

/// Texels, with the picture turned as its file says.
fn turned<T: Copy>(
    raster: &Raster,
    values: &[T],
    number: impl Fn(T) -> f32,
) -> Result<Texture, Fault> {
    let (w, h) = (raster.width as usize, raster.height as usize);
    let mut texels: Vec<[f32; 3]> = Vec::new();
    let memory = |_| Fault::file("there is no memory for its texels");
    texels.try_reserve_exact(w * h).map_err(memory)?;
    let across = matches!(
        raster.orientation,
        Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH
    );
    let (width, height) = if across { (h, w) } else { (w, h) };
    let channels = raster.channels;
    for y in 0..height {
        for x in 0..width {
            let (column, row) = match raster.orientation {
                Orientation::NoTransforms => (x, y),
                Orientation::FlipHorizontal => (w - 1 - x, y),
                Orientation::Rotate180 => (w - 1 - x, h - 1 - y),
                Orientation::FlipVertical => (x, h - 1 - y),
                Orientation::Rotate90FlipH => (y, x),
                Orientation::Rotate90 => (y, h - 1 - x),
                Orientation::Rotate270FlipH => (w - 1 - y, h - 1 - x),
                Orientation::Rotate270 => (w - 1 - y, x),
            };
            let pixel = &values[(row * w + column) * channels..][..channels];
            texels.push(match *pixel {
                [r, g, b] | [r, g, b, _] => [number(r), number(g), number(b)],
                [grey, ..] => [number(grey); 3],
                [] => [0.0; 3],
            });
        }
    }
    Ok(Texture { width: width as u32, height: height as u32, texels })
}

/// The memory of a scene's textures: those that are alive count.
#[derive(Debug)]
pub struct Budget {
    most: u64,
    held: Mutex<Vec<Weak<Texture>>>,
}

impl Default for Budget {
    fn default() -> Self {
        Self::new(MOST_BYTES)
    }
}

impl Budget {
    /// Of so many bytes.
    pub fn new(most: u64) -> Self {
        Self { most, held: Mutex::default() }
    }

    /// The texture in a file of this name given as its bytes, counted for as long as it lives.
    ///
    /// # Errors
    /// As [`decode`], with the file's name; and what is larger than what is left.
    pub fn texture(
        &self,
        name: &Path,
        bytes: &[u8],
        encoding: Encoding,
    ) -> Result<Read, AssetError> {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        held.retain(|texture| texture.strong_count() > 0);
        let alive = held.iter().filter_map(Weak::upgrade);
        let taken: u64 = alive.map(|texture| texture.texels.len() as u64 * TEXEL).sum();
        let room = Room { most: self.most, left: self.most.saturating_sub(taken), made: TEXEL };
        let read =
            within(bytes, encoding, room).map_err(|fault| AssetError::broken(name, fault))?;
        held.push(Arc::downgrade(&read.texture));
        Ok(read)
    }
}
