//! A raster with a dry border, laid out for row kernels.
//!
//! Every field of a wash has the same [`Layout`], be it of cells, of faces between columns (one more column) or of
//! faces between rows (one more row). Around the canvas lies a border of zeros, wide enough that a kernel may look
//! at the neighbours of any cell without asking where the canvas ends.
//!
//! Fields are allocated zeroed and never filled, so the pages of paper that nothing touches cost no memory.

use std::ops::Range;

use crate::aligned::Aligned;

/// Where the cells of a canvas lie in memory.
///
/// Rows and columns of a [`Field`] count from the border's corner: the canvas begins at row [`Layout::TOP`] and
/// column [`Layout::LEFT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    width: usize,
    height: usize,
    stride: usize,
}

impl Layout {
    /// Columns of border before the canvas: whole vectors, so that a run of cells may be widened to them.
    pub const LEFT: usize = 16;
    /// Rows of border before the canvas.
    pub const TOP: usize = 1;
    /// Columns of border after the canvas, the last row face's included.
    const RIGHT: usize = 24;
    /// Rows of border after the canvas, the last column face's included.
    const BOTTOM: usize = 2;
    /// Values in a page of memory. Rows a whole number of pages apart would share cache sets: 15 % at 2048².
    const PAGE: usize = 1024;

    /// The layout of a canvas of `width` × `height` cells.
    pub fn new(width: usize, height: usize) -> Self {
        let stride = (Self::LEFT + width + Self::RIGHT).next_multiple_of(16);
        let stride = if stride.is_multiple_of(Self::PAGE) { stride + 16 } else { stride };
        Self { width, height, stride }
    }

    /// Columns of the canvas.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the canvas.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Values from one row to the next.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The field rows that hold the canvas.
    pub fn rows(&self) -> Range<usize> {
        Self::TOP..Self::TOP + self.height
    }

    /// The field columns that hold the canvas.
    pub fn columns(&self) -> Range<usize> {
        Self::LEFT..Self::LEFT + self.width
    }

    /// Number of rows, those of the border included.
    pub fn row_count(&self) -> usize {
        Self::TOP + self.height + Self::BOTTOM
    }

    fn len(&self) -> usize {
        self.row_count() * self.stride
    }
}

/// Values on a canvas and its border, row-major.
#[derive(Debug, PartialEq)]
pub struct Field<T> {
    layout: Layout,
    data: Aligned<T>,
}

impl<T: Copy + Default> Field<T> {
    /// A field of zeros.
    pub fn zeroed(layout: Layout) -> Self {
        Self { layout, data: Aligned::zeroed(layout.len()) }
    }
}

impl<T: Copy + Default> Clone for Field<T> {
    fn clone(&self) -> Self {
        Self { layout: self.layout, data: self.data.clone() }
    }
}

impl<T: Copy> Field<T> {
    /// Where the cells lie.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Number of rows, those of the border included.
    pub fn row_count(&self) -> usize {
        self.layout.row_count()
    }

    /// All values, row after row, with the border.
    pub fn values(&self) -> &[T] {
        &self.data
    }

    /// The same, to change.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// One row of the field with its border.
    ///
    /// # Panics
    /// The field has no such row.
    pub fn row(&self, row: usize) -> &[T] {
        &self.data[row * self.layout.stride..][..self.layout.stride]
    }

    /// One row of the field with its border, to change.
    ///
    /// # Panics
    /// The field has no such row.
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.data[row * self.layout.stride..][..self.layout.stride]
    }

    /// The cells of row `y` of the canvas; for faces between rows, `y` goes up to the height.
    ///
    /// # Panics
    /// `y` is above the height.
    pub fn cells(&self, y: usize) -> &[T] {
        &self.row(Layout::TOP + y)[self.layout.columns()]
    }

    /// The same, to change.
    ///
    /// # Panics
    /// `y` is above the height.
    pub fn cells_mut(&mut self, y: usize) -> &mut [T] {
        let columns = self.layout.columns();
        &mut self.row_mut(Layout::TOP + y)[columns]
    }

    /// The faces between columns of row `y` of the canvas: one more than there are cells.
    ///
    /// # Panics
    /// `y` is not below the height.
    pub fn faces(&self, y: usize) -> &[T] {
        &self.row(Layout::TOP + y)[Layout::LEFT..][..self.layout.width + 1]
    }

    /// The same, to change.
    ///
    /// # Panics
    /// `y` is not below the height.
    pub fn faces_mut(&mut self, y: usize) -> &mut [T] {
        let width = self.layout.width;
        &mut self.row_mut(Layout::TOP + y)[Layout::LEFT..][..width + 1]
    }

    /// Cuts the field between rows: band `i` holds the rows `cuts[i]..cuts[i + 1]`.
    ///
    /// # Panics
    /// `cuts` does not rise, or goes past the field's end.
    pub fn bands_mut(&mut self, cuts: &[usize]) -> Vec<Band<'_, T>> {
        let stride = self.layout.stride;
        let Some((&first, _)) = cuts.split_first() else { return Vec::new() };
        let mut rest = &mut self.data[first * stride..];
        cuts.windows(2)
            .map(|cut| {
                let (band, after) = std::mem::take(&mut rest).split_at_mut((cut[1] - cut[0]) * stride);
                rest = after;
                Band { first: cut[0], stride, data: band }
            })
            .collect()
    }
}

/// Neighbouring rows of a field, to change while other bands are changed elsewhere.
#[derive(Debug)]
pub struct Band<'a, T> {
    first: usize,
    stride: usize,
    data: &'a mut [T],
}

impl<T: Copy> Band<'_, T> {
    /// The field rows of the band.
    pub fn rows(&self) -> Range<usize> {
        self.first..self.first + self.data.len() / self.stride
    }

    /// One row, by its number in the field.
    ///
    /// # Panics
    /// The band does not hold the row.
    pub fn row(&self, row: usize) -> &[T] {
        &self.data[(row - self.first) * self.stride..][..self.stride]
    }

    /// One row to change, by its number in the field.
    ///
    /// # Panics
    /// The band does not hold the row.
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.data[(row - self.first) * self.stride..][..self.stride]
    }

    /// One row to change and the one below it, if the band holds that too.
    ///
    /// # Panics
    /// The band does not hold the row.
    pub fn row_mut_and_below(&mut self, row: usize) -> (&mut [T], Option<&[T]>) {
        let (here, below) = self.data[(row - self.first) * self.stride..].split_at_mut(self.stride);
        (here, (below.len() >= self.stride).then(|| &below[..self.stride]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_never_a_whole_number_of_pages_apart() {
        for width in [1, 984, 1000, 2008, 2048, 4096, 8192] {
            assert_ne!(Layout::new(width, 1).stride() % 1024, 0, "{width}");
        }
    }

    #[test]
    fn canvas_and_border_do_not_overlap() {
        let layout = Layout::new(3, 2);
        let mut field = Field::<f32>::zeroed(layout);
        for y in 0..2 {
            field.faces_mut(y).fill(1.0);
        }
        field.cells_mut(2).fill(2.0);
        assert_eq!(field.data.iter().sum::<f32>(), 2.0 * 4.0 + 3.0 * 2.0);
        assert_eq!(field.row(Layout::TOP)[Layout::LEFT - 1..][..6], [0.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn bands_share_no_row_and_miss_none() {
        let layout = Layout::new(2, 5);
        let mut field = Field::<f32>::zeroed(layout);
        let cuts = [1, 3, 3, 6];
        for mut band in field.bands_mut(&cuts) {
            for row in band.rows() {
                let (here, below) = band.row_mut_and_below(row);
                here[0] += row as f32;
                assert_eq!(below.is_some(), row != 2 && row != 5);
            }
        }
        let firsts: Vec<f32> = (0..8).map(|row| field.row(row)[0]).collect();
        assert_eq!(firsts, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 0.0]);
    }
}
