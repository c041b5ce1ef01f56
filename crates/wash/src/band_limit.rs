//! The paper as the water feels it: without grain finer than the flow can tell.

use std::ops::Range;

use girtin_grid::{Field, Layout};

/// The mean height over a window of `width` cells around each cell of a part of the canvas.
///
/// The slope term sees this at high resolution: grain below a reference cell would push the flow the harder the finer it
/// is resolved. What lies outside the canvas is left out of the mean. Returns `None` where the window is one cell.
pub fn band_limited(
    height: &Field<f32>,
    rows: Range<usize>,
    columns: Range<usize>,
    width: f64,
) -> Option<Field<f32>> {
    if width <= 1.0 {
        return None;
    }
    let canvas = (height.layout().rows(), height.layout().columns());
    let weights = Window::new(width);
    let mut limited = Field::<f32>::zeroed(Layout::new(columns.len(), rows.len()));
    // Rows of the window, each meaned sideways once.
    let reach = weights.reach();
    let mut sideways = std::collections::VecDeque::new();
    let mut next = rows.start.saturating_sub(reach).max(canvas.0.start);
    let mut first = next;
    for row in rows.clone() {
        while next < (row + reach + 1).min(canvas.0.end) {
            sideways.push_back(weights.along(height.row(next), columns.clone(), &canvas.1));
            next += 1;
        }
        while first + reach < row {
            sideways.pop_front();
            first += 1;
        }
        let mut sums = vec![0.0f64; columns.len()];
        let mut total = 0.0;
        for (at, means) in (first..).zip(&sideways) {
            let weight = weights.at(at.abs_diff(row));
            total += weight;
            sums.iter_mut().zip(means).for_each(|(sum, mean)| *sum += weight * mean);
        }
        let out = limited.cells_mut(row - rows.start);
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out = (sum / total) as f32);
    }
    Some(limited)
}

/// A box whose ends may cover cells in part.
struct Window {
    whole: usize,
    part: f64,
}

impl Window {
    fn new(width: f64) -> Self {
        let half = (width - 1.0) / 2.0;
        Self { whole: half as usize, part: half.fract() }
    }

    fn reach(&self) -> usize {
        self.whole + usize::from(self.part > 0.0)
    }

    fn at(&self, distance: usize) -> f64 {
        if distance <= self.whole { 1.0 } else { self.part }
    }

    fn along(&self, row: &[f32], columns: Range<usize>, canvas: &Range<usize>) -> Vec<f64> {
        let mean = |x: usize| {
            let window =
                x.saturating_sub(self.reach()).max(canvas.start)..(x + self.reach() + 1).min(canvas.end);
            let (mut sum, mut total) = (0.0, 0.0);
            for at in window {
                let weight = self.at(at.abs_diff(x));
                sum += weight * f64::from(row[at]);
                total += weight;
            }
            sum / total
        };
        columns.map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_of_two_cells_weighs_a_quarter_a_half_a_quarter() {
        let mut height = Field::<f32>::zeroed(Layout::new(5, 1));
        height.cells_mut(0).copy_from_slice(&[0.0, 0.0, 1.0, 0.0, 0.0]);
        let (rows, columns) = (height.layout().rows(), height.layout().columns());
        let limited = band_limited(&height, rows, columns, 2.0).unwrap();
        assert_eq!(limited.cells(0), [0.0, 0.25, 0.5, 0.25, 0.0]);
    }

    #[test]
    fn a_part_is_cut_out_of_the_whole() {
        let mut height = Field::<f32>::zeroed(Layout::new(30, 20));
        for y in 0..20 {
            for x in 0..30 {
                height.cells_mut(y)[x] = ((x * 7 + y * 13) % 11) as f32 / 11.0;
            }
        }
        let (rows, columns) = (height.layout().rows(), height.layout().columns());
        let whole = band_limited(&height, rows, columns, 3.5).unwrap();
        let part =
            band_limited(&height, Layout::TOP + 4..Layout::TOP + 9, Layout::LEFT..Layout::LEFT + 12, 3.5);
        let part = part.unwrap();
        for y in 0..5 {
            assert_eq!(part.cells(y), &whole.cells(y + 4)[..12]);
        }
    }
}
