//! A raster stretched over another number of cells.

use girtin_grid::Raster;

/// The raster on `width` × `height` cells: the mean of what a cell covers where they are fewer, linear where they are more.
///
/// # Guarantees
/// Of the same size it is the same (`the_same_size_is_the_same`).
pub(super) fn stretched(raster: &Raster<f32>, width: usize, height: usize) -> Raster<f32> {
    if (raster.width(), raster.height()) == (width, height) {
        return raster.clone();
    }
    let columns = spans(raster.width(), width);
    let rows = spans(raster.height(), height);
    let wide: Vec<f32> = (0..raster.height())
        .flat_map(|y| {
            let row = raster.row(y);
            columns.iter().map(move |span| span.mean(|x| row[x]))
        })
        .collect();
    Raster::from_fn(width, height, |x, y| rows[y].mean(|row| wide[row * width + x]))
}

/// Cells that make up one, each with its weight; the weights add up to 1.
struct Span {
    first: usize,
    weights: Vec<f32>,
}

impl Span {
    fn mean(&self, value: impl Fn(usize) -> f32) -> f32 {
        self.weights.iter().enumerate().map(|(at, weight)| weight * value(self.first + at)).sum()
    }
}

/// Of how many cells out of `from` each of `to` cells is made.
fn spans(from: usize, to: usize) -> Vec<Span> {
    let scale = from as f64 / to as f64;
    // A tent as wide as a cell of the coarser of the two.
    let reach = scale.max(1.0);
    let span = |at: usize| {
        let center = (at as f64 + 0.5) * scale;
        let first = (center - reach).floor().max(0.0) as usize;
        let end = ((center + reach).ceil() as usize).min(from).max(first + 1);
        let tent = |cell: usize| (1.0 - (cell as f64 + 0.5 - center).abs() / reach).max(0.0);
        let sum: f64 = (first..end).map(tent).sum();
        Span { first, weights: (first..end).map(|cell| (tent(cell) / sum) as f32).collect() }
    };
    (0..to).map(span).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_size_is_the_same() {
        let raster = Raster::from_fn(5, 4, |x, y| (x * y) as f32);
        assert_eq!(stretched(&raster, 5, 4), raster);
    }

    #[test]
    fn a_slope_stays_a_slope_and_a_flat_flat() {
        let slope = Raster::from_fn(40, 30, |x, _| x as f32 + 0.5);
        for (width, height) in [(20, 15), (80, 60), (33, 30), (1, 1)] {
            let found = stretched(&slope, width, height);
            for x in width / 5..width - width / 5 {
                let wanted = (x as f32 + 0.5) * 40.0 / width as f32;
                assert!((found.at(x, height / 2) - wanted).abs() < 0.05 * wanted, "{x} of {width}");
            }
            let flat = stretched(&Raster::new(40, 30, 0.7), width, height);
            assert!(flat.as_slice().iter().all(|value| (value - 0.7).abs() < 1e-6));
        }
    }
}
