//! A part of one huge picture, to be rendered by itself and merged with the others.

use reflet_pack::TransferCurve;
use std::fmt;
use std::str::FromStr;

/// Which part is asked for: column and row, counted from 1, of so many columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileChoice {
    column: u32,
    row: u32,
    columns: u32,
    rows: u32,
}

impl FromStr for TileChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "write column,row/columns x rows, as in 3,2/8x6, counted from 1";
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            text.parse().ok().filter(|n: &u32| digits && (1..=65_535).contains(n))
        };
        let (place, grid) = text.split_once('/').ok_or(FORM)?;
        let (column, row) = place.split_once(',').ok_or(FORM)?;
        let (columns, rows) = grid.split_once(['x', 'X']).ok_or(FORM)?;
        let numbers = (number(column), number(row), number(columns), number(rows));
        let (Some(column), Some(row), Some(columns), Some(rows)) = numbers else {
            return Err(FORM.to_owned());
        };
        if column > columns || row > rows {
            return Err(format!(
                "there is no tile {column},{row} in {columns}x{rows} tiles; {FORM}"
            ));
        }
        Ok(TileChoice { column, row, columns, rows })
    }
}

impl fmt::Display for TileChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}/{}x{}", self.column, self.row, self.columns, self.rows)
    }
}

impl TileChoice {
    /// The pixels that it is of a picture of `size`.
    ///
    /// # Errors
    /// There are more tiles than pixels along a side.
    pub fn of(self, size: [u32; 2], transfer: TransferCurve) -> Result<Tile, String> {
        let [width, height] = size;
        if self.columns > width || self.rows > height {
            return Err(format!(
                "--tile {self}: a picture of {width}x{height} pixels has no {}x{} tiles; take fewer",
                self.columns, self.rows
            ));
        }
        // In 64 bits no product overflows.
        let cut =
            |edge: u32, i: u32, n: u32| (u64::from(edge) * u64::from(i) / u64::from(n)) as u32;
        let x = cut(width, self.column - 1, self.columns);
        let y = cut(height, self.row - 1, self.rows);
        let right = cut(width, self.column, self.columns);
        let low = cut(height, self.row, self.rows);
        Ok(Tile { origin: [x, y], size: [right - x, low - y], transfer })
    }
}

/// The pixels of a part, and what must be known to make a file of whole samples from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// The left upper pixel.
    pub origin: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The curve of the scene's files with whole samples.
    pub transfer: TransferCurve,
}

impl fmt::Display for Tile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Tile { origin: [x, y], size: [width, height], transfer } = self;
        let transfer = match transfer {
            TransferCurve::Srgb => "srgb",
            TransferCurve::Linear => "linear",
        };
        write!(f, "x={x} y={y} width={width} height={height} transfer={transfer}")
    }
}

impl Tile {
    /// Reads what [`Tile`]'s text says.
    pub(crate) fn told(text: &str) -> Option<Tile> {
        let mut words = text.split(' ').map(|word| word.split_once('='));
        let mut number = |key: &str| -> Option<u32> {
            let (k, v) = words.next()??;
            (k == key).then(|| v.parse().ok())?
        };
        let origin = [number("x")?, number("y")?];
        let size = [number("width")?, number("height")?];
        let transfer = match words.next()?? {
            ("transfer", "srgb") => TransferCurve::Srgb,
            ("transfer", "linear") => TransferCurve::Linear,
            _ => return None,
        };
        Some(Tile { origin, size, transfer })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (size, grid) in
            [([17, 9], "4x3"), ([5, 5], "5x5"), ([640, 361], "7x2"), ([1, 1], "1x1")]
        {
            let [width, height] = size.map(|n| n as usize);
            let mut seen = vec![0; width * height];
            let (columns, rows) = grid.split_once('x').unwrap();
            for row in 1..=rows.parse::<u32>().unwrap() {
                for column in 1..=columns.parse::<u32>().unwrap() {
                    let choice: TileChoice = format!("{column},{row}/{grid}").parse().unwrap();
                    let tile = choice.of(size, TransferCurve::Srgb).unwrap();
                    assert_eq!(Tile::told(&tile.to_string()), Some(tile));
                    for y in tile.origin[1]..tile.origin[1] + tile.size[1] {
                        for x in tile.origin[0]..tile.origin[0] + tile.size[0] {
                            seen[y as usize * width + x as usize] += 1;
                        }
                    }
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{size:?} {grid}");
        }
    }

    #[test]
    fn what_is_no_tile_is_refused() {
        for bad in ["", "1", "1,1", "1,1/2", "0,1/2x2", "3,1/2x2", "1,3/2x2", "1,1/0x2", "a,1/2x2"]
        {
            assert!(bad.parse::<TileChoice>().is_err(), "{bad}");
        }
        let many: TileChoice = "1,1/9x1".parse().unwrap();
        assert!(many.of([8, 8], TransferCurve::Srgb).is_err());
        assert_eq!(Tile::told("x=1 y=2 width=3"), None);
    }
}
