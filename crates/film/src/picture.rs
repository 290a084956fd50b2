//! Pictures, stored tile by tile.

use rayon::prelude::*;
use std::fmt;

/// The size of a picture and of its tiles, in pixels.
///
/// Tiles are squares, row-major over the picture; those at the right and lower edge are stored
/// whole, with padding that no encoder reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layout {
    width: u32,
    height: u32,
    tile: u32,
}

/// Why a [`Layout`] cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayoutError {
    /// Width or height is outside 1..=65535.
    Size {
        /// The width asked for.
        width: u32,
        /// The height asked for.
        height: u32,
    },
    /// The side of a tile is outside 1..=64.
    Tile(u32),
    /// The samples cannot be counted in this machine's address space.
    Unaddressable,
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { width, height } => write!(
                f,
                "a picture of {width} x {height} pixels: width and height must be 1 to 65535"
            ),
            Self::Tile(tile) => write!(f, "tiles of {tile} pixels: the side must be 1 to 64"),
            Self::Unaddressable => write!(f, "the picture is larger than the address space"),
        }
    }
}

impl std::error::Error for LayoutError {}

/// The pixels of a picture that a tile covers (without its padding).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// Leftmost pixel.
    pub x: u32,
    /// Topmost pixel.
    pub y: u32,
    /// Pixels across, at most the tile's side.
    pub width: u32,
    /// Pixels down, at most the tile's side.
    pub height: u32,
}

impl Layout {
    /// A picture of `width` x `height` pixels (1..=65535 each) in tiles of `tile` x `tile` pixels
    /// (1..=64).
    pub fn try_new(width: u32, height: u32, tile: u32) -> Result<Self, LayoutError> {
        if !(1..=65535).contains(&width) || !(1..=65535).contains(&height) {
            return Err(LayoutError::Size { width, height });
        }
        if !(1..=64).contains(&tile) {
            return Err(LayoutError::Tile(tile));
        }
        let layout = Self { width, height, tile };
        let tiles = u64::from(layout.columns()) * u64::from(layout.rows());
        let samples = tiles * u64::from(tile) * u64::from(tile) * 3;
        // The largest sample has 4 bytes, and an allocation at most isize::MAX.
        if samples > isize::MAX as u64 / 4 {
            return Err(LayoutError::Unaddressable);
        }
        Ok(layout)
    }

    /// Pixels across.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(self) -> u32 {
        self.height
    }

    /// The side of a tile in pixels.
    pub fn tile(self) -> u32 {
        self.tile
    }

    /// Tiles across.
    pub fn columns(self) -> u32 {
        self.width.div_ceil(self.tile)
    }

    /// Tiles down.
    pub fn rows(self) -> u32 {
        self.height.div_ceil(self.tile)
    }

    /// Tiles in all.
    pub fn tiles(self) -> usize {
        self.columns() as usize * self.rows() as usize
    }

    /// Samples in the chunk of one tile, padding included: `tile * tile * 3`.
    pub fn chunk_len(self) -> usize {
        (self.tile * self.tile * 3) as usize
    }

    /// Samples in all, padding included.
    pub fn len(self) -> usize {
        self.tiles() * self.chunk_len()
    }

    /// False: a layout has at least one pixel.
    pub fn is_empty(self) -> bool {
        false
    }

    /// The pixels of tile `index` (row-major, 0..tiles).
    pub fn tile_rect(self, index: usize) -> TileRect {
        let columns = self.columns() as usize;
        let x = (index % columns) as u32 * self.tile;
        let y = (index / columns) as u32 * self.tile;
        TileRect {
            x,
            y,
            width: self.tile.min(self.width - x),
            height: self.tile.min(self.height - y),
        }
    }
}

/// The type of a picture's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleKind {
    /// 8-bit integers, 0..=255, after the transfer.
    U8,
    /// 16-bit integers, 0..=65535, after the transfer.
    U16,
    /// Linear intensities as 32-bit floats.
    F32,
}

impl SampleKind {
    /// Bytes per sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::F32 => 4,
        }
    }
}

/// The samples of a picture: tiles row-major, in each tile rows of R, G, B triples.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 8-bit samples.
    U8(Vec<u8>),
    /// 16-bit samples.
    U16(Vec<u16>),
    /// 32-bit float samples.
    F32(Vec<f32>),
}

/// The samples of one tile: `tile` rows of `tile` R, G, B triples.
#[derive(Debug)]
pub enum SamplesMut<'a> {
    /// 8-bit samples.
    U8(&'a mut [u8]),
    /// 16-bit samples.
    U16(&'a mut [u16]),
    /// 32-bit float samples.
    F32(&'a mut [f32]),
}

/// One tile of a picture, borrowed for writing.
#[derive(Debug)]
pub struct TileMut<'a> {
    /// The tile's place in the row-major order of tiles.
    pub index: usize,
    /// Its samples, padding included.
    pub samples: SamplesMut<'a>,
}

impl TileMut<'_> {
    /// Takes over the samples of another tile, or of the same tile of another picture.
    ///
    /// # Panics
    /// If the two tiles have samples of different types or sizes.
    pub fn copy_from(&mut self, other: &TileMut<'_>) {
        match (&mut self.samples, &other.samples) {
            (SamplesMut::U8(to), SamplesMut::U8(from)) => to.copy_from_slice(from),
            (SamplesMut::U16(to), SamplesMut::U16(from)) => to.copy_from_slice(from),
            (SamplesMut::F32(to), SamplesMut::F32(from)) => to.copy_from_slice(from),
            _ => panic!("samples of different types"),
        }
    }

    /// Takes over the samples that `picture` has in the same place.
    ///
    /// # Panics
    /// If the picture has samples of another type, or tiles of another size or number.
    pub fn copy_from_picture(&mut self, picture: &Picture) {
        let chunk = picture.layout.chunk_len();
        let place = self.index * chunk..(self.index + 1) * chunk;
        match (&mut self.samples, &picture.samples) {
            (SamplesMut::U8(to), Samples::U8(from)) => to.copy_from_slice(&from[place]),
            (SamplesMut::U16(to), Samples::U16(from)) => to.copy_from_slice(&from[place]),
            (SamplesMut::F32(to), Samples::F32(from)) => to.copy_from_slice(&from[place]),
            _ => panic!("samples of different types"),
        }
    }
}

/// Memory for a picture could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfMemory {
    /// Bytes asked for.
    pub bytes: usize,
}

impl fmt::Display for OutOfMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no memory for a picture of {} bytes: make the picture smaller", self.bytes)
    }
}

impl std::error::Error for OutOfMemory {}

/// A picture in tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    layout: Layout,
    samples: Samples,
}

fn zeros<T: Copy + Default>(len: usize) -> Result<Vec<T>, OutOfMemory> {
    let mut samples = Vec::new();
    samples.try_reserve_exact(len).map_err(|_| OutOfMemory { bytes: len * size_of::<T>() })?;
    samples.resize(len, T::default());
    Ok(samples)
}

impl Picture {
    /// A black picture. Memory that the allocator refuses is an error, not an abort.
    pub fn try_new(layout: Layout, kind: SampleKind) -> Result<Self, OutOfMemory> {
        let len = layout.len();
        let samples = match kind {
            SampleKind::U8 => Samples::U8(zeros(len)?),
            SampleKind::U16 => Samples::U16(zeros(len)?),
            SampleKind::F32 => Samples::F32(zeros(len)?),
        };
        Ok(Self { layout, samples })
    }

    /// The picture's size and tiles.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// The type of its samples.
    pub fn kind(&self) -> SampleKind {
        match self.samples {
            Samples::U8(_) => SampleKind::U8,
            Samples::U16(_) => SampleKind::U16,
            Samples::F32(_) => SampleKind::F32,
        }
    }

    /// All samples, tile by tile, padding included.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Bytes of memory that the samples take.
    pub fn memory(&self) -> usize {
        self.layout.len() * self.kind().bytes()
    }

    /// The tiles in order. The vector serves as a sequential iterator, and through
    /// `into_par_iter` as an indexed parallel one. To shade one tile of several pictures at once,
    /// take the tiles of each and zip them.
    pub fn tiles_mut(&mut self) -> Vec<TileMut<'_>> {
        let chunk = self.layout.chunk_len();
        fn tiles<'a, T>(
            samples: &'a mut [T],
            chunk: usize,
            wrap: impl Fn(&'a mut [T]) -> SamplesMut<'a>,
        ) -> Vec<TileMut<'a>> {
            let chunks = samples.chunks_exact_mut(chunk).enumerate();
            chunks.map(|(index, samples)| TileMut { index, samples: wrap(samples) }).collect()
        }
        match &mut self.samples {
            Samples::U8(samples) => tiles(samples, chunk, SamplesMut::U8),
            Samples::U16(samples) => tiles(samples, chunk, SamplesMut::U16),
            Samples::F32(samples) => tiles(samples, chunk, SamplesMut::F32),
        }
    }

    /// The tiles as an indexed parallel iterator.
    pub fn par_tiles_mut(&mut self) -> rayon::vec::IntoIter<TileMut<'_>> {
        self.tiles_mut().into_par_iter()
    }

    /// The R, G, B triples of row `y` (0..height), left to right, in pieces of one tile each.
    ///
    /// # Panics
    /// If the picture's samples are not of the type asked for, or `y` is outside the picture.
    pub fn row_pieces<T: Sample>(&self, y: u32) -> impl Iterator<Item = &[T]> {
        assert!(y < self.layout.height, "row {y} is outside the picture");
        let samples = T::of(&self.samples).expect("samples of another type");
        let layout = self.layout;
        let tile = layout.tile as usize;
        let columns = layout.columns() as usize;
        let chunk = layout.chunk_len();
        let first =
            (y / layout.tile) as usize * columns * chunk + (y % layout.tile) as usize * tile * 3;
        let width = layout.width as usize;
        (0..columns).map(move |column| {
            let start = first + column * chunk;
            let pixels = tile.min(width - column * tile);
            &samples[start..start + pixels * 3]
        })
    }

    /// Overwrites the pixels of row `y` from column `x` on with R, G, B triples.
    ///
    /// # Panics
    /// If the picture's samples are not of the type given, or the pixels are outside the picture.
    pub fn set_row<T: Sample>(&mut self, x: u32, y: u32, triples: &[T]) {
        let layout = self.layout;
        let end = x as usize + triples.len() / 3;
        assert!(y < layout.height && end <= layout.width as usize, "outside the picture");
        let samples = T::of_mut(&mut self.samples).expect("samples of another type");
        let tile = layout.tile as usize;
        let first = (y / layout.tile) as usize * layout.columns() as usize * layout.chunk_len()
            + (y % layout.tile) as usize * tile * 3;
        let (mut x, mut rest) = (x as usize, triples);
        while !rest.is_empty() {
            let (piece, tail) = rest.split_at(rest.len().min((tile - x % tile) * 3));
            let start = first + x / tile * layout.chunk_len() + x % tile * 3;
            samples[start..start + piece.len()].copy_from_slice(piece);
            x += piece.len() / 3;
            rest = tail;
        }
    }

    /// Copies row `y` (0..height) into `row`, `width` R, G, B triples.
    ///
    /// # Panics
    /// If the picture's samples are not of the type asked for, `y` is outside the picture, or
    /// `row` is not `3 * width` long.
    pub fn row<T: Sample>(&self, y: u32, row: &mut [T]) {
        assert_eq!(row.len(), self.layout.width as usize * 3);
        let mut rest = row;
        for piece in self.row_pieces::<T>(y) {
            let (head, tail) = rest.split_at_mut(piece.len());
            head.copy_from_slice(piece);
            rest = tail;
        }
    }
}

/// A type of sample: `u8`, `u16` or `f32`.
pub trait Sample: Copy + Send + Sync + 'static {
    /// The samples, if they are of this type.
    fn of(samples: &Samples) -> Option<&[Self]>;
    /// The samples for writing, if they are of this type.
    fn of_mut(samples: &mut Samples) -> Option<&mut [Self]>;
}

impl Sample for u8 {
    fn of(samples: &Samples) -> Option<&[Self]> {
        match samples {
            Samples::U8(samples) => Some(samples),
            _ => None,
        }
    }
    fn of_mut(samples: &mut Samples) -> Option<&mut [Self]> {
        match samples {
            Samples::U8(samples) => Some(samples),
            _ => None,
        }
    }
}

impl Sample for u16 {
    fn of(samples: &Samples) -> Option<&[Self]> {
        match samples {
            Samples::U16(samples) => Some(samples),
            _ => None,
        }
    }
    fn of_mut(samples: &mut Samples) -> Option<&mut [Self]> {
        match samples {
            Samples::U16(samples) => Some(samples),
            _ => None,
        }
    }
}

impl Sample for f32 {
    fn of(samples: &Samples) -> Option<&[Self]> {
        match samples {
            Samples::F32(samples) => Some(samples),
            _ => None,
        }
    }
    fn of_mut(samples: &mut Samples) -> Option<&mut [Self]> {
        match samples {
            Samples::F32(samples) => Some(samples),
            _ => None,
        }
    }
}
