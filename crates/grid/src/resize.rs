//! The same raster with more or fewer cells.

use rayon::prelude::*;

use crate::Raster;

/// What a cell of the new raster takes from a row of the old: the first cell, and a weight for each from there.
type Taps = (usize, Vec<f32>);

/// The raster stretched over `width` × `height` cells.
///
/// A smaller one has the mean of what each cell covers; a larger one is linear between the middles of the old cells, the
/// border continued.
///
/// # Panics
/// The old raster is empty and the new one is not.
pub fn resized<const N: usize>(raster: &Raster<[f32; N]>, width: usize, height: usize) -> Raster<[f32; N]> {
    if (width, height) == (raster.width(), raster.height()) {
        return raster.clone();
    }
    let columns: Vec<Taps> = (0..width).map(|x| taps(x, width, raster.width())).collect();
    let rows: Vec<Taps> = (0..height).map(|y| taps(y, height, raster.height())).collect();
    let cells: Vec<[f32; N]> = rows
        .into_par_iter()
        .flat_map_iter(|(first, weights)| {
            let mut mean = vec![[0.0f32; N]; raster.width()];
            for (y, weight) in (first..).zip(weights) {
                for (sum, value) in mean.iter_mut().zip(raster.row(y)) {
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
                }
            }
            let one = |(first, weights): &Taps| {
                let mut sum = [0.0f32; N];
                for (value, weight) in mean[*first..].iter().zip(weights) {
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
                }
                sum
            };
            columns.iter().map(one).collect::<Vec<_>>()
        })
        .collect();
    Raster::from_vec(width, height, cells).unwrap_or_else(|| unreachable!("a value for each cell"))
}

/// [`resized`] of a raster of single values.
pub fn resized_plane(raster: &Raster<f32>, width: usize, height: usize) -> Raster<f32> {
    resized(&raster.map(|value| [value]), width, height).map(|[value]| value)
}

fn taps(at: usize, new: usize, old: usize) -> Taps {
    let scale = old as f64 / new as f64;
    if new >= old {
        let place = ((at as f64 + 0.5) * scale - 0.5).clamp(0.0, (old - 1) as f64);
        let first = (place as usize).min(old.saturating_sub(2));
        let part = (place - first as f64) as f32;
        return (first, if old == 1 { vec![1.0] } else { vec![1.0 - part, part] });
    }
    let (from, to) = (at as f64 * scale, (at + 1) as f64 * scale);
    let (first, end) = (from as usize, (libm::ceil(to) as usize).min(old));
    let covered = |cell: usize| (to.min((cell + 1) as f64) - from.max(cell as f64)).max(0.0);
    let weights: Vec<f64> = (first..end).map(covered).collect();
    let sum: f64 = weights.iter().sum();
    (first, weights.iter().map(|weight| (weight / sum) as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrinking_keeps_the_mean_and_growing_the_line() {
        let raster = Raster::from_fn(10, 6, |x, y| (3 * x + y) as f32);
        let small = resized_plane(&raster, 4, 3);
        let mean =
            |raster: &Raster<f32>| raster.as_slice().iter().sum::<f32>() / raster.as_slice().len() as f32;
        assert!((mean(&small) - mean(&raster)).abs() < 1e-4);
        let large = resized_plane(&raster, 20, 12);
        assert!((large.at(9, 5) - (3.0 * 4.25 + 2.25)).abs() < 1e-4, "{}", large.at(9, 5));
        assert_eq!(large.at(0, 0), raster.at(0, 0));
    }

    #[test]
    fn any_size_becomes_any_size() {
        for (old, new) in [((1, 1), (5, 7)), ((7, 1), (1, 1)), ((3, 5), (5, 3)), ((2, 2), (2, 2))] {
            let even = Raster::new(old.0, old.1, 2.0f32);
            let resized = resized_plane(&even, new.0, new.1);
            assert_eq!((resized.width(), resized.height()), new);
            assert!(resized.as_slice().iter().all(|value| (value - 2.0).abs() < 1e-6));
        }
    }
}
