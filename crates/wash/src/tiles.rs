//! Which tiles of a canvas have changed.

use girtin_grid::Layout;

/// A square of cells of the canvas, cut off at its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First column of cells.
    pub x: usize,
    /// First row of cells.
    pub y: usize,
    /// Whether pigment may have changed, and so the picture; else only water has, in the pores.
    pub pigment: bool,
}

impl Tile {
    /// Cells along each side.
    pub const SIDE: usize = 64;
}

/// What may have changed in a tile.
const WATER: u8 = 1;
const PIGMENT: u8 = 2;

/// The tiles of a canvas that have changed since they were last asked for.
#[derive(Clone, Debug)]
pub(crate) struct ChangedTiles {
    columns: usize,
    changes: Vec<u8>,
}

impl ChangedTiles {
    pub fn new(layout: Layout) -> Self {
        let [columns, rows] = [layout.width(), layout.height()].map(|cells| cells.div_ceil(Tile::SIDE));
        Self { columns, changes: vec![0; columns * rows] }
    }

    /// Marks the tiles of cells `first..end` of row `y` of the canvas.
    pub fn mark(&mut self, y: usize, first: usize, end: usize, pigment: bool) {
        let change = if pigment { WATER | PIGMENT } else { WATER };
        if first < end {
            let row = y / Tile::SIDE * self.columns;
            let tiles = first / Tile::SIDE..((end - 1) / Tile::SIDE + 1).min(self.columns);
            self.changes[row..][tiles].iter_mut().for_each(|tile| *tile |= change);
        }
    }

    /// The tiles that were marked, row by row; none is any more.
    pub fn take(&mut self) -> Vec<Tile> {
        let columns = self.columns;
        let changed = self.changes.iter_mut().enumerate().filter(|(_, change)| **change != 0);
        let tile = |(at, change): (usize, &mut u8)| {
            let pigment = std::mem::take(change) & PIGMENT != 0;
            Tile { x: at % columns * Tile::SIDE, y: at / columns * Tile::SIDE, pigment }
        };
        changed.map(tile).collect()
    }
}
