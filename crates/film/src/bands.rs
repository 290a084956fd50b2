//! Files made of independent bands of rows, and the bytes kept of bands that did not change.

use crate::still::Compression;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// The bands of the last picture written: their raw rows, and the bytes that they became.
///
/// Pass the same one for frame after frame of an animation. A band whose raw rows equal those of
/// the frame before keeps its bytes; a picture of another size, format or compression starts
/// anew. What is written does not depend on it.
#[derive(Debug, Default)]
pub struct KeptBands {
    key: Option<Key>,
    bands: Vec<Band>,
}

impl KeptBands {
    /// Nothing kept yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets everything and frees the memory.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Bytes of memory held: about the raw size of a picture plus its file's.
    pub fn memory(&self) -> usize {
        let bands = self.bands.iter();
        bands.map(|band| band.raw.capacity() + band.piece.bytes.capacity()).sum()
    }
}

/// What a band's bytes depend on beside its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub codec: Codec,
    pub compression: Compression,
    pub width: u32,
    pub height: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Codec {
    Png8,
    Png16,
    Exr32,
    Exr16,
}

#[derive(Debug, Default)]
struct Band {
    raw: Vec<u8>,
    piece: Piece,
}

/// A band as it stands in the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Piece {
    pub bytes: Arc<Vec<u8>>,
    /// PNG: the Adler-32 of the band's filtered rows.
    pub check: u32,
    /// EXR: the length of each chunk in `bytes`.
    pub lengths: Arc<[u32]>,
}

/// All bands of a picture, in order, and how many were encoded rather than kept.
pub(crate) struct Pieces {
    pub pieces: Vec<Piece>,
    pub encoded: usize,
}

/// The rows of band `index`.
pub(crate) fn rows_of(index: usize, rows: u32, height: u32) -> Range<u32> {
    let start = index as u32 * rows;
    start..height.min(start + rows)
}

/// Encodes the bands of `rows` rows (the last may have fewer) in parallel. `gather` appends the
/// raw bytes of some rows to a buffer; `code` makes a piece of the raw bytes of a band.
pub(crate) fn encode<S: Default>(
    key: Key,
    rows: u32,
    kept: Option<&mut KeptBands>,
    gather: impl Fn(Range<u32>, &mut Vec<u8>) + Sync,
    code: impl Fn(usize, &[u8], &mut S) -> Piece + Sync,
) -> Pieces {
    let count = key.height.div_ceil(rows) as usize;
    let Some(kept) = kept else {
        let pieces = (0..count)
            .into_par_iter()
            .map_init(<(Vec<u8>, S)>::default, |(raw, scratch), index| {
                raw.clear();
                gather(rows_of(index, rows, key.height), raw);
                code(index, raw, scratch)
            })
            .collect();
        return Pieces { pieces, encoded: count };
    };
    if kept.key != Some(key) {
        kept.bands.clear();
        kept.bands.resize_with(count, Band::default);
        kept.key = Some(key);
    }
    let bands = kept.bands.par_iter_mut().enumerate();
    let encoded = bands
        .map_init(<(Vec<u8>, S)>::default, |(raw, scratch), (index, band)| {
            raw.clear();
            gather(rows_of(index, rows, key.height), raw);
            // A band is never empty once it is filled.
            if *raw == band.raw {
                return 0;
            }
            std::mem::swap(raw, &mut band.raw);
            band.piece = code(index, &band.raw, scratch);
            1
        })
        .sum();
    Pieces { pieces: kept.bands.iter().map(|band| band.piece.clone()).collect(), encoded }
}
