//! Many pictures in one, in rows, each with its name below.

use girtin_grid::Raster;

use crate::lettering;

/// Pictures on one sheet, sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSheet {
    picture: Raster<[u8; 3]>,
    columns: usize,
    cell: [usize; 2],
    gap: usize,
    letter: usize,
    laid: usize,
}

/// Color of the names.
const TEXT: [u8; 3] = [64, 60, 58];

impl ContactSheet {
    /// An empty sheet for so many pictures of at most `cell` columns and rows.
    pub fn new(count: usize, cell: [usize; 2], ground: [u8; 3]) -> Self {
        let longest = cell[0].max(cell[1]);
        // Names are to be read, and not to be looked at.
        let letter = (longest / 240).max(1);
        let gap = (longest / 32).max(4);
        // Tall pictures side by side, wide ones over each other: the sheet is to be neither tall nor wide.
        let columns = (1..=count.max(1)).min_by_key(|&columns| {
            let rows = count.div_ceil(columns);
            let full = columns * rows - count;
            ((columns * cell[0]).abs_diff(rows * cell[1] * 4 / 3), full)
        });
        let columns = columns.unwrap_or(1);
        let below = gap / 2 + lettering::HEIGHT * letter;
        let height = cell[1] + below;
        let rows = count.div_ceil(columns);
        let size = [columns * (cell[0] + gap) + gap, rows * (height + gap) + gap];
        Self {
            picture: Raster::new(size[0], size[1], ground),
            columns,
            cell: [cell[0], height],
            gap,
            letter,
            laid: 0,
        }
    }

    /// Lays the next picture and writes its name below; what is too large for its place is cut.
    pub fn lay(&mut self, picture: &Raster<[u8; 3]>, name: &str) {
        let (column, row) = (self.laid % self.columns, self.laid / self.columns);
        let [left, top] = [column, row].map(|at| self.gap + at * self.gap);
        let (left, top) = (left + column * self.cell[0], top + row * self.cell[1]);
        let room = self.cell[1] - self.gap / 2 - lettering::HEIGHT * self.letter;
        let (width, height) = (picture.width().min(self.cell[0]), picture.height().min(room));
        for y in 0..height.min(self.picture.height().saturating_sub(top)) {
            let row = &mut self.picture.row_mut(top + y)[left..left + width];
            row.copy_from_slice(&picture.row(y)[..width]);
        }
        lettering::write(&mut self.picture, [left, top + room + self.gap / 2], self.letter, TEXT, name);
        self.laid += 1;
    }

    /// The sheet.
    pub fn into_picture(self) -> Raster<[u8; 3]> {
        self.picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_beside_each_other_with_their_names() {
        let white = [255; 3];
        let mut sheet = ContactSheet::new(6, [60, 40], white);
        for shade in 0..6 {
            sheet.lay(&Raster::new(60, 40, [20 * shade; 3]), "wet-in-wet");
        }
        let picture = sheet.into_picture();
        let count = |color| picture.as_slice().iter().filter(|pixel| **pixel == color).count();
        for shade in 0..6 {
            assert_eq!(count([20 * shade; 3]), 60 * 40, "picture {shade}");
        }
        assert!(count(TEXT) > 6 * 50, "names");
        let sides = picture.width() as f64 / picture.height() as f64;
        assert!((0.5..2.5).contains(&sides), "{sides}");
    }

    #[test]
    fn tall_and_wide_pictures_fit() {
        for (count, cell) in [(1, [1, 1]), (6, [4, 500]), (6, [500, 4]), (5, [40, 60])] {
            let mut sheet = ContactSheet::new(count, cell, [255; 3]);
            for _ in 0..count {
                sheet.lay(&Raster::new(cell[0], cell[1], [0; 3]), "a");
            }
            let picture = sheet.into_picture();
            let black = picture.as_slice().iter().filter(|pixel| **pixel == [0; 3]).count();
            assert_eq!(black, count * cell[0] * cell[1], "{cell:?}");
        }
    }
}
