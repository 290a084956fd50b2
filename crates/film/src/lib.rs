//! Colours to files: the transfer from linear intensities to samples, the file formats, and
//! writes that never leave a broken file behind.
//!
//! The way through, one noun a module:
//!
//! 1. [`Layout`] and [`Picture`]: samples stored tile by tile, so that shading writes one
//!    contiguous chunk and several pictures can be shaded together ([`Picture::tiles_mut`]).
//! 2. [`Transfer`] and [`TransferTable`]: linear intensities to samples, exactly.
//! 3. [`Format`]: what the files are called and which samples they hold.
//! 4. [`encode_still`]: a picture to the bytes of a file. PNG and EXR are made of independent
//!    bands of rows; [`KeptBands`] keeps the bytes of bands whose pixels did not change.
//! 5. [`FilmWriter`]: frames to one GIF, APNG, WebP or Y4M stream; [`FilmSink`]: to a file, or to
//!    ffmpeg, which encodes MP4 and Matroska.
//! 6. [`encode_sealed`], [`read_sealed`]: files that say what they were made from, and whether they
//!    are whole; [`decode_still`]: their pictures again.
//! 7. [`Target`]: what `-o OUT` means; [`SafeFile`]: a file that appears under its name only
//!    when it is whole.
//!
//! ```
//! use reflet_film::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let out = folder.path().join("ramp-##.png");
//! let target = Target::parse(out.as_os_str(), None, 2)?;
//! let kind = target.format().sample_kind();
//! let table = TransferTable::new(Transfer::Srgb, kind);
//! let mut picture = Picture::try_new(Layout::try_new(64, 32, 16)?, kind)?;
//! let mut kept = KeptBands::new();
//! for frame in 0..2 {
//!     for mut tile in picture.tiles_mut() {
//!         let grey = [[tile.index as f32 / 8.0; 4]; 16 * 16];
//!         table.encode_tile(&grey, &mut tile.samples);
//!     }
//!     let options = StillOptions::default();
//!     let encoded = encode_still(&picture, target.format(), &options, Some(&mut kept))?;
//!     assert_eq!(encoded.bands_kept, frame as usize);
//!     let mut file = target.open(frame)?;
//!     encoded.write_to(&mut file)?;
//!     file.commit()?;
//! }
//! assert!(folder.path().join("ramp-01.png").exists());
//! # Ok(())
//! # }
//! ```
//!
//! Bytes depend on the pixels and the options alone: never on the number of threads, the size of
//! a tile, the machine, the time, or on what was kept from an earlier frame.

mod bands;
mod decode;
mod exr;
mod ffmpeg;
mod film;
mod format;
mod identity;
mod netpbm;
mod picture;
mod png;
mod qoi;
mod safe;
mod seal;
mod slots;
mod still;
mod target;
mod temporary;
mod transfer;

pub use bands::KeptBands;
pub use decode::{StillHead, decode_still, still_head};
pub use ffmpeg::Ffmpeg;
pub use film::{
    Dither, FilmSink, FilmSpec, FilmWriter, Fps, FpsError, Patch, Pushed, VideoQuality,
};
pub use format::{Format, UnknownFormat};
pub use identity::FileId;
pub use picture::{
    Layout, LayoutError, OutOfMemory, Picture, Sample, SampleKind, Samples, SamplesMut, TileMut,
    TileRect,
};

pub use safe::{Folders, PendingFolders, SafeFile};
pub use seal::{
    CHECK, MANIFEST_ENDING, Sealed, Unsealed, encode_sealed, is_foreign_manifest, manifest_path,
    needs_manifest, read_sealed, texts,
};
pub use still::{Compression, Encoded, StillOptions, encode_still};
pub use target::{Target, TargetError};
pub use temporary::{StrayFile, stray_files};
pub use transfer::{Transfer, TransferTable};
