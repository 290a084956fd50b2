//! The picture in tiles. The tiles' size decides nothing but speed.

/// A picture cut into square tiles, row by row; those at the right and lower edges may be cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The left upper pixel: not (0, 0) where this is a part of a larger picture.
    pub origin: [u32; 2],
    /// The tiles' edge in pixels, a power of two up to [`Grid::MAX_EDGE`].
    pub edge: u32,
}

/// The pixels of one tile: `x..x + width`, `y..y + height`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// The left pixel.
    pub x: u32,
    /// The upper pixel.
    pub y: u32,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Grid {
    /// The longest edge: a node's parent is told in 16 bits.
    pub const MAX_EDGE: u32 = 64;

    /// A grid whose tiles have at most `edge` pixels a side, and at most 65,535 nodes a sample with
    /// `max_bounces`, so that an index of a surface within a tile fits into 16 bits.
    pub fn new(size: [u32; 2], edge: u32, max_bounces: u32) -> Grid {
        let mut edge = edge.clamp(1, Self::MAX_EDGE).next_power_of_two();
        while edge > 1 && u64::from(edge * edge) * (u64::from(max_bounces) + 1) > 65_535 {
            edge /= 2;
        }
        Grid { size, origin: [0, 0], edge }
    }

    /// How many tiles a row has.
    pub fn columns(&self) -> usize {
        self.size[0].div_ceil(self.edge) as usize
    }

    /// How many rows of tiles there are.
    pub fn rows(&self) -> usize {
        self.size[1].div_ceil(self.edge) as usize
    }

    /// How many tiles there are.
    pub fn len(&self) -> usize {
        self.columns() * self.rows()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Pixels in a whole tile.
    pub fn tile_pixels(&self) -> usize {
        (self.edge * self.edge) as usize
    }

    /// The pixels of tile `index`, counted from the whole picture's left upper one.
    pub fn rect(&self, index: usize) -> TileRect {
        let x = (index % self.columns()) as u32 * self.edge;
        let y = (index / self.columns()) as u32 * self.edge;
        TileRect {
            x: self.origin[0] + x,
            y: self.origin[1] + y,
            width: self.edge.min(self.size[0] - x),
            height: self.edge.min(self.size[1] - y),
        }
    }
}

impl TileRect {
    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        (self.width * self.height) as usize
    }
}
