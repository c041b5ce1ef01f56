//! A plain rectangle of values.

use rayon::prelude::*;

/// Values on a rectangle of cells, row-major, without padding: `data[y * width + x]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// A raster filled with one value.
    pub fn new(width: usize, height: usize, value: T) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// A raster of given values, or `None` if their number is not `width * height`.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Option<Self> {
        (Some(data.len()) == width.checked_mul(height)).then_some(Self { width, height, data })
    }

    /// A raster whose values are a function of the cell.
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> T) -> Self {
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            data.extend((0..width).map(|x| value(x, y)));
        }
        Self { width, height, data }
    }

    /// [`Raster::from_fn`] on all threads.
    pub fn by_rows(width: usize, height: usize, value: impl Fn(usize, usize) -> T + Sync) -> Self
    where
        T: Send,
    {
        let cells = (0..width * height).into_par_iter().with_min_len(width.max(1));
        let data = cells.map(|cell| value(cell % width, cell / width)).collect();
        Self { width, height, data }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row after row.
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// All values, row after row, to change.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// The values themselves.
    pub fn into_vec(self) -> Vec<T> {
        self.data
    }

    /// One row.
    ///
    /// # Panics
    /// `y` is not below the height.
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// One row, to change.
    ///
    /// # Panics
    /// `y` is not below the height.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }

    /// One value.
    ///
    /// # Panics
    /// The cell is outside.
    pub fn at(&self, x: usize, y: usize) -> T {
        assert!(x < self.width, "column {x} of {}", self.width);
        self.data[y * self.width + x]
    }

    /// A raster of the same size with every value changed.
    pub fn map<U: Copy>(&self, change: impl FnMut(T) -> U) -> Raster<U> {
        Raster {
            width: self.width,
            height: self.height,
            data: self.data.iter().copied().map(change).collect(),
        }
    }
}

impl Raster<f32> {
    /// The value at a point in cell units (cell centers at half-integers), linear between cells, the border
    /// continued outward; 0 on an empty raster.
    pub fn sample(&self, x: f32, y: f32) -> f32 {
        if self.data.is_empty() {
            return 0.0;
        }
        let (x, y) =
            ((x - 0.5).clamp(0.0, (self.width - 1) as f32), (y - 0.5).clamp(0.0, (self.height - 1) as f32));
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(self.width - 1), (y0 + 1).min(self.height - 1));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let row = |y: usize| {
            let row = self.row(y);
            row[x0] + fx * (row[x1] - row[x0])
        };
        let (top, bottom) = (row(y0), row(y1));
        top + fy * (bottom - top)
    }

    /// The mean of every block of `factor` × `factor` cells; blocks cut by the border take what they have.
    ///
    /// # Panics
    /// `factor` is 0.
    #[must_use]
    pub fn box_reduced(&self, factor: usize) -> Self {
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        Self::from_fn(width, height, |x, y| {
            let (x1, y1) = (((x + 1) * factor).min(self.width), ((y + 1) * factor).min(self.height));
            let cells = ((x1 - x * factor) * (y1 - y * factor)) as f32;
            let sum: f32 = (y * factor..y1).map(|y| self.row(y)[x * factor..x1].iter().sum::<f32>()).sum();
            sum / cells
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_number_of_values_is_refused() {
        assert!(Raster::from_vec(2, 2, vec![0u8; 3]).is_none());
        assert!(Raster::from_vec(usize::MAX, 2, vec![0u8; 3]).is_none());
    }

    #[test]
    fn samples_are_exact_at_centers_and_continue_outside() {
        let raster = Raster::from_fn(3, 2, |x, y| (x + 10 * y) as f32);
        assert_eq!(raster.sample(1.5, 1.5), 11.0);
        assert_eq!(raster.sample(1.0, 0.5), 0.5);
        assert_eq!(raster.sample(-9.0, 99.0), 10.0);
    }

    #[test]
    fn box_reduction_keeps_the_mean() {
        let raster = Raster::from_fn(4, 2, |x, y| (x + y) as f32);
        assert_eq!(raster.box_reduced(2).as_slice(), &[1.0, 3.0]);
        assert_eq!(raster.box_reduced(3).width(), 2);
    }
}
