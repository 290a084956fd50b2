//! One picture to the bytes of one file.

use crate::bands::KeptBands;
use crate::format::Format;
use crate::picture::Picture;
use crate::transfer::Transfer;
use crate::{exr, netpbm, png, qoi};
use std::io::{self, ErrorKind, IoSlice, Write};
use std::sync::Arc;

/// How much time a smaller file is worth. Lossless in every case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Compression {
    /// PNG: filters and Huffman codes, a few milliseconds a megapixel. EXR: not compressed.
    #[default]
    Fast,
    /// PNG: matches of moderate effort. EXR: ZIP by 16 lines, least effort.
    Balanced,
    /// PNG: the most effort. EXR: ZIP by 16 lines, the most effort.
    Small,
}

/// How a still is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StillOptions<'a> {
    /// For PNG and EXR.
    pub compression: Compression,
    /// What integer samples went through: PNG and QOI say it. Float samples are intensities.
    pub transfer: Transfer,
    /// For JPEG, 1..=100.
    pub jpeg_quality: u8,
    /// Keys and values to carry along, for PNG (text chunks) and EXR (string attributes). Other
    /// formats leave them out. A key is 1 to 79 bytes of printable ASCII without a space at either
    /// end or two in a row; a value holds no NUL.
    pub text: &'a [(&'a str, &'a str)],
}

impl Default for StillOptions<'_> {
    /// Fast, the curve of sRGB, JPEG of quality 90, no text.
    fn default() -> Self {
        Self {
            compression: Compression::Fast,
            transfer: Transfer::Srgb,
            jpeg_quality: 90,
            text: &[],
        }
    }
}

/// The bytes of a file, in parts that may be shared with [`KeptBands`].
#[derive(Clone, Debug, Default)]
pub struct Encoded {
    pub(crate) parts: Vec<Arc<Vec<u8>>>,
    /// Bands that were encoded; 0 for formats without bands.
    pub bands_encoded: usize,
    /// Bands whose bytes were kept from the frame before.
    pub bands_kept: usize,
}

impl Encoded {
    pub(crate) fn whole(bytes: Vec<u8>) -> Self {
        Self { parts: vec![Arc::new(bytes)], bands_encoded: 0, bands_kept: 0 }
    }

    pub(crate) fn from_parts(parts: Vec<Arc<Vec<u8>>>, bands: usize, bands_encoded: usize) -> Self {
        Self { parts, bands_encoded, bands_kept: bands - bands_encoded }
    }

    /// Bytes in all.
    pub fn len(&self) -> usize {
        self.parts.iter().map(|part| part.len()).sum()
    }

    /// True if there are no bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bytes in one piece.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.len());
        for part in &self.parts {
            bytes.extend_from_slice(part);
        }
        bytes
    }

    /// Writes all bytes, many parts at a time where the sink can.
    pub fn write_to(&self, sink: &mut impl Write) -> io::Result<()> {
        // Linux takes up to 1024 at a time.
        for parts in self.parts.chunks(512) {
            let mut slices: Vec<IoSlice<'_>> =
                parts.iter().map(|part| IoSlice::new(part)).collect();
            let mut rest = slices.as_mut_slice();
            IoSlice::advance_slices(&mut rest, 0);
            while !rest.is_empty() {
                match sink.write_vectored(rest) {
                    Ok(0) => {
                        return Err(io::Error::new(
                            ErrorKind::WriteZero,
                            "the sink takes no more bytes",
                        ));
                    }
                    Ok(written) => IoSlice::advance_slices(&mut rest, written),
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(())
    }
}

fn invalid(message: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, message)
}

fn check_text(text: &[(&str, &str)]) -> io::Result<()> {
    for (key, value) in text {
        let printable = key.bytes().all(|b| (0x20..0x7f).contains(&b));
        let spaced = key.trim() != *key || key.contains("  ");
        if key.is_empty() || key.len() > 79 || !printable || spaced {
            return Err(invalid(format!(
                "the text key {key:?} must be 1 to 79 printable ASCII characters without a space \
                 at either end or two in a row"
            )));
        }
        if value.contains('\0') {
            return Err(invalid(format!("the text of key {key:?} holds a NUL")));
        }
    }
    Ok(())
}

/// Encodes `picture` in a still format, in parallel on the current rayon pool where the format
/// allows it. `kept` serves PNG and EXR; others leave it alone.
///
/// # Errors
/// `InvalidInput` if `format` is a film, the picture's samples are not [`Format::sample_kind`], or
/// a text cannot be carried; what else a format cannot hold, in its words.
pub fn encode_still(
    picture: &Picture,
    format: Format,
    options: &StillOptions<'_>,
    kept: Option<&mut KeptBands>,
) -> io::Result<Encoded> {
    if picture.kind() != format.sample_kind() {
        return Err(invalid(format!(
            "{format} takes {:?} samples, but the picture has {:?}",
            format.sample_kind(),
            picture.kind()
        )));
    }
    check_text(options.text)?;
    match format {
        Format::Png | Format::Png16 => Ok(png::encode(picture, options, kept)),
        Format::Exr | Format::Exr16 => exr::encode(picture, format, options, kept),
        Format::Qoi => Ok(Encoded::whole(qoi::encode(picture, options.transfer))),
        Format::Jpeg => jpeg(picture, options.jpeg_quality).map(Encoded::whole),
        Format::Ppm => Ok(Encoded::whole(netpbm::ppm(picture))),
        Format::Pfm => Ok(Encoded::whole(netpbm::pfm(picture))),
        film => Err(invalid(format!("{film} is a film: its frames go through a FilmWriter"))),
    }
}

/// Rows of a tiled picture for the JPEG encoder.
struct Rows<'a>(&'a Picture);

impl jpeg_encoder::ImageBuffer for Rows<'_> {
    fn get_jpeg_color_type(&self) -> jpeg_encoder::JpegColorType {
        jpeg_encoder::JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.0.layout().width() as u16
    }

    fn height(&self) -> u16 {
        self.0.layout().height() as u16
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        for piece in self.0.row_pieces::<u8>(u32::from(y)) {
            for pixel in piece.chunks_exact(3) {
                let (luma, blue, red) = jpeg_encoder::rgb_to_ycbcr(pixel[0], pixel[1], pixel[2]);
                buffers[0].push(luma);
                buffers[1].push(blue);
                buffers[2].push(red);
            }
        }
    }
}

fn jpeg(picture: &Picture, quality: u8) -> io::Result<Vec<u8>> {
    if !(1..=100).contains(&quality) {
        return Err(invalid(format!("a JPEG quality of {quality}: it is 1 to 100")));
    }
    let mut bytes = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, quality);
    // Sharp edges between saturated colours are what renders are made of.
    encoder.set_sampling_factor(jpeg_encoder::SamplingFactor::R_4_4_4);
    encoder
        .encode_image(Rows(picture))
        .map_err(|error| io::Error::other(format!("JPEG: {error}")))?;
    Ok(bytes)
}
