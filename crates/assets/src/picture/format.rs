//! Which format a picture has, by its first bytes.

use crate::error::Fault;

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// OpenEXR.
    Exr,
    /// PBM, PGM, PPM, PAM and PFM.
    Netpbm,
    /// WebP.
    WebP,
    /// TIFF.
    Tiff,
    /// Windows bitmaps.
    Bmp,
    /// Truevision Targa.
    Tga,
    /// Quite OK Image.
    Qoi,
    /// Radiance HDR.
    Hdr,
}

/// The names of those that are read, for messages.
pub const READ: &str = "PNG, JPEG, EXR, HDR, TIFF, WebP, BMP, TGA, QOI, PNM or PFM";

impl Format {
    /// What to call it.
    pub fn name(self) -> &'static str {
        match self {
            Format::Png => "PNG",
            Format::Jpeg => "JPEG",
            Format::Exr => "EXR",
            Format::Netpbm => "PNM",
            Format::WebP => "WebP",
            Format::Tiff => "TIFF",
            Format::Bmp => "BMP",
            Format::Tga => "TGA",
            Format::Qoi => "QOI",
            Format::Hdr => "HDR",
        }
    }
}

/// First bytes, and what begins with them.
const READ_HERE: [(&[u8], Format); 19] = [
    (b"\x89PNG\r\n\x1a\n", Format::Png),
    (b"\xff\xd8", Format::Jpeg),
    (b"\x76\x2f\x31\x01", Format::Exr),
    (b"P1", Format::Netpbm),
    (b"P2", Format::Netpbm),
    (b"P3", Format::Netpbm),
    (b"P4", Format::Netpbm),
    (b"P5", Format::Netpbm),
    (b"P6", Format::Netpbm),
    (b"P7", Format::Netpbm),
    (b"PF", Format::Netpbm),
    (b"Pf", Format::Netpbm),
    (b"II*\0", Format::Tiff),
    (b"MM\0*", Format::Tiff),
    (b"II+\0", Format::Tiff),
    (b"MM\0+", Format::Tiff),
    (b"qoif", Format::Qoi),
    (b"#?RADIANCE", Format::Hdr),
    (b"#?RGBE", Format::Hdr),
];

/// First bytes of what is met among pictures and is not read.
const FOREIGN: [(&[u8], &str); 46] = [
    (b"GIF8", "a GIF"),
    (b"8BPS", "a Photoshop file (PSD)"),
    (b"gimp xcf", "a GIMP file (XCF)"),
    (b"\xff\x0a", "a JPEG XL file"),
    (b"\0\0\0\x0cJXL \r\n\x87\n", "a JPEG XL file"),
    (b"\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 file"),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 file"),
    (b"\xabKTX 11", "a KTX texture"),
    (b"\xabKTX 20", "a KTX2 texture"),
    (b"DDS ", "a DDS texture"),
    (b"\x13\xab\xa1\x5c", "an ASTC texture"),
    (b"PVR\x03", "a PVR texture"),
    (b"sB\x13\0", "a Basis texture"),
    (b"%PDF", "a PDF document"),
    (b"%!PS", "a PostScript document"),
    (b"<svg", "an SVG drawing"),
    (b"<?xml", "an XML document (perhaps an SVG drawing)"),
    (b"<!DOCTYPE", "a web page"),
    (b"<!doctype", "a web page"),
    (b"<html", "a web page"),
    (b"PK\x03\x04", "a zip archive"),
    (b"PK\x05\x06", "a zip archive"),
    (b"\x1f\x8b", "a gzip file"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard file"),
    (b"BZh", "a bzip2 file"),
    (b"\xfd7zXZ\0", "an xz file"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive"),
    (b"Rar!", "a RAR archive"),
    (b"\0\0\x01\0", "a Windows icon (ICO)"),
    (b"icns", "a macOS icon (ICNS)"),
    (b"farbfeld", "a farbfeld picture"),
    (b"\x8aMNG", "an MNG animation"),
    (b"\x8bJNG", "a JNG picture"),
    (b"SDPX", "a DPX picture"),
    (b"XPDS", "a DPX picture"),
    (b"\x80\x2a\x5f\xd7", "a Cineon picture"),
    (b"FLIF", "a FLIF picture"),
    (b"BPG\xfb", "a BPG picture"),
    (b"II\xbc\x01", "a JPEG XR picture"),
    (b"SIMPLE  =", "a FITS file"),
    (b"\x1a\x45\xdf\xa3", "a Matroska or WebM film"),
    (b"DKIF", "an IVF film"),
    (b"YUV4MPEG2", "a Y4M film"),
    (b"BLENDER", "a Blender file"),
    (b"glTF", "a glTF model"),
    (b"version https://git-lfs", "a pointer of Git LFS in place of the file (run git lfs pull)"),
];

/// The format of a file given as its bytes.
///
/// # Errors
/// It is none of those that are read; what it is instead, if that is known.
pub fn of(bytes: &[u8]) -> Result<Format, Fault> {
    if let Some((_, format)) = READ_HERE.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Ok(*format);
    }
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Ok(Format::WebP);
    }
    // The length of the second head tells a bitmap from a text that begins so.
    if bytes.starts_with(b"BM") && matches!(bytes.get(14..18), Some([12..=124, 0, 0, 0])) {
        return Ok(Format::Bmp);
    }
    let foreign = foreign(bytes);
    if foreign.is_none() && is_tga(bytes) {
        return Ok(Format::Tga);
    }
    Err(Fault::file(match foreign {
        Some(what) => format!("is {what}, which is not read as a picture: save it as {READ}"),
        None => format!("is no picture of a known format: save it as {READ}"),
    }))
}

/// What a file is that is not read.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    if bytes.is_empty() {
        return Some("an empty file");
    }
    if bytes.get(4..8) == Some(b"ftyp") {
        return Some(match bytes.get(8..12) {
            Some(b"avif" | b"avis") => "an AVIF picture",
            Some(b"heic" | b"heix" | b"hevc" | b"heim" | b"heis" | b"mif1" | b"msf1") => {
                "a HEIC picture"
            }
            Some(b"crx ") => "a raw photograph (CR3)",
            Some(b"jp2 " | b"jpx ") => "a JPEG 2000 file",
            _ => "an MP4 film",
        });
    }
    if bytes.starts_with(b"RIFF") {
        return Some("a RIFF file (AVI or WAV)");
    }
    // After a byte-order mark and blanks, as texts may begin.
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let begins = |magic: &[u8]| bytes.starts_with(magic) || text.starts_with(magic);
    FOREIGN.iter().find(|(magic, _)| begins(magic)).map(|(_, what)| *what)
}

/// Whether this may be a TGA, which has no first bytes of its own: the fields of its head agree with
/// each other (Truevision TGA, version 2.0).
fn is_tga(bytes: &[u8]) -> bool {
    let Some(&[_, mapped, kind, rest @ ..]) = bytes.first_chunk::<18>() else { return false };
    let [.., depth, about] = rest;
    let entry = rest[4];
    // A Windows cursor begins like a picture without a colour map, whose place then holds a count.
    let plain = mapped == 1 || rest[..5] == [0; 5];
    let agree = match (mapped, kind) {
        (1, 1 | 9) => matches!(entry, 15 | 16 | 24 | 32) && matches!(depth, 8 | 16),
        (0, 2 | 10) => matches!(depth, 15 | 16 | 24 | 32),
        (1, 2 | 10) => matches!(entry, 15 | 16 | 24 | 32) && matches!(depth, 15 | 16 | 24 | 32),
        (0, 3 | 11) => matches!(depth, 8 | 16),
        _ => false,
    };
    plain && agree && about & 0xc0 == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_read_is_named() {
        let is = |bytes: &[u8]| of(bytes).unwrap_err().message;
        assert!(is(b"GIF89a").starts_with("is a GIF, which is not read"));
        assert!(is(b"\0\0\0\x1cftypavif\0\0\0\0").starts_with("is an AVIF picture"));
        assert!(is(b"\0\0\0\x18ftypheic\0\0\0\0").starts_with("is a HEIC picture"));
        assert!(is(b"\xef\xbb\xbf\n <svg>").starts_with("is an SVG drawing"));
        assert!(is(b"PK\x03\x04").starts_with("is a zip archive"));
        assert!(is(b"").starts_with("is an empty file"));
        assert!(is(b"hello, world; this is no picture").starts_with("is no picture of a known"));
        for (magic, what) in FOREIGN {
            assert!(is(magic).contains(what), "{what}");
        }
    }

    #[test]
    fn no_format_hides_behind_another() {
        for (magic, format) in READ_HERE {
            assert_eq!(of(magic).unwrap(), format);
        }
        assert_eq!(of(b"RIFF\0\0\0\0WEBPVP8 ").unwrap(), Format::WebP);
        let mut tga = [0; 18];
        (tga[2], tga[12], tga[14], tga[16]) = (2, 1, 1, 24);
        assert_eq!(of(&tga).unwrap(), Format::Tga);
    }
}
