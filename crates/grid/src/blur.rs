//! Gaussian weights, blurs of rasters, and blurs that walls stop.

use rayon::prelude::*;

use crate::Raster;
use crate::resize::resized;

/// Normalised weights of a Gaussian of standard deviation `sigma` at the whole numbers −radius…radius.
///
/// `sigma` 0 gives all the weight to the middle.
pub fn gaussian_weights(sigma: f64, radius: usize) -> Vec<f32> {
    let weight = |tap: usize| {
        let distance = tap.abs_diff(radius) as f64;
        if sigma > 0.0 {
            libm::exp(-distance * distance / (2.0 * sigma * sigma))
        } else {
            f64::from(u8::from(tap == radius))
        }
    };
    let weights: Vec<f64> = (0..=2 * radius).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| (weight / sum) as f32).collect()
}

/// Widest blur that is summed tap by tap, cells; a wider one is done on fewer cells.
const WIDEST_TAPS: f64 = 4.0;

/// The raster under a Gaussian of standard deviation `sigma` cells; the border is mirrored.
///
/// # Cost
/// Linear in cells whatever `sigma` is: a wide blur is done on a smaller raster.
pub fn gaussian<const N: usize>(raster: &Raster<[f32; N]>, sigma: f64) -> Raster<[f32; N]> {
    let (width, height) = (raster.width(), raster.height());
    if sigma < 0.2 || width == 0 || height == 0 {
        return raster.clone();
    }
    if sigma > WIDEST_TAPS && width.min(height) >= 8 {
        let small = resized(raster, width.div_ceil(2), height.div_ceil(2));
        // Shrinking and growing have blurred by half a cell already.
        let left = (sigma * sigma - 0.5).max(0.0);
        return resized(&gaussian(&small, libm::sqrt(left) / 2.0), width, height);
    }
    let radius = libm::ceil(3.0 * sigma) as usize;
    let weights = gaussian_weights(sigma, radius);
    let along: Vec<[f32; N]> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let row = raster.row(y);
            let padded: Vec<[f32; N]> =
                (0..width + 2 * radius).map(|x| row[mirrored(x as isize - radius as isize, width)]).collect();
            let mut sums = vec![[0.0; N]; width];
            for (&weight, shifted) in weights.iter().zip(padded.windows(width)) {
                add(&mut sums, shifted, weight);
            }
            sums
        })
        .collect();
    let row = |y: isize| &along[mirrored(y, height) * width..][..width];
    let mut blurred = Raster::new(width, height, [0.0; N]);
    blurred.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, sums)| {
        for (tap, &weight) in weights.iter().enumerate() {
            add(sums, row((y + tap) as isize - radius as isize), weight);
        }
    });
    blurred
}

/// [`gaussian`] of a raster of single values.
pub fn gaussian_plane(raster: &Raster<f32>, sigma: f64) -> Raster<f32> {
    gaussian(&raster.map(|value| [value]), sigma).map(|[value]| value)
}

fn add<const N: usize>(sums: &mut [[f32; N]], row: &[[f32; N]], weight: f32) {
    for (sum, value) in sums.iter_mut().zip(row) {
        for (sum, value) in sum.iter_mut().zip(value) {
            *sum += weight * value;
        }
    }
}

/// The place of a cell beyond the border, mirrored into the raster as often as it takes.
fn mirrored(at: isize, size: usize) -> usize {
    let period = 2 * size as isize;
    let at = at.rem_euclid(period);
    (if at < size as isize { at } else { period - 1 - at }) as usize
}

/// Columns that are swept together, for the cache's sake.
const STRIP: usize = 32;

/// The raster blurred by `sigma` cells within each region only: nothing passes between cells of different `regions`.
///
/// # Source
/// Gastal and Oliveira, *Domain Transform for Edge-Aware Image and Video Processing*, 2011, the recursive filter, with
/// walls for distances without end.
///
/// # Panics
/// The sizes differ.
pub fn within<const N: usize, L: Copy + PartialEq + Sync>(
    raster: &Raster<[f32; N]>,
    regions: &Raster<L>,
    sigma: f64,
) -> Raster<[f32; N]> {
    const ROUNDS: u32 = 3;
    let (width, height) = (raster.width(), raster.height());
    assert_eq!((width, height), (regions.width(), regions.height()), "sizes of raster and regions");
    let mut blurred = raster.clone();
    if sigma < 0.2 || width == 0 || height == 0 {
        return blurred;
    }
    for round in 1..=ROUNDS {
        let share = libm::sqrt(3.0) * f64::from(1u32 << (ROUNDS - round));
        let sigma = sigma * share / libm::sqrt(f64::from((1u32 << (2 * ROUNDS)) - 1));
        let keep = libm::exp(-core::f64::consts::SQRT_2 / sigma) as f32;
        let rows = blurred.as_mut_slice().par_chunks_mut(width).zip(regions.as_slice().par_chunks(width));
        rows.for_each(|(row, regions)| {
            for x in 1..width {
                if regions[x] == regions[x - 1] {
                    let before = row[x - 1];
                    lean(&mut row[x], &before, keep);
                }
            }
            for x in (1..width).rev() {
                if regions[x] == regions[x - 1] {
                    let after = row[x];
                    lean(&mut row[x - 1], &after, keep);
                }
            }
        });
        let strips: Vec<Raster<[f32; N]>> = (0..width.div_ceil(STRIP))
            .into_par_iter()
            .map(|strip| sweep_columns(&blurred, regions, strip * STRIP, keep))
            .collect();
        blurred.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (cells, strip) in row.chunks_mut(STRIP).zip(&strips) {
                cells.copy_from_slice(strip.row(y));
            }
        });
    }
    blurred
}

fn lean<const N: usize>(value: &mut [f32; N], toward: &[f32; N], keep: f32) {
    for (value, toward) in value.iter_mut().zip(toward) {
        *value += keep * (toward - *value);
    }
}

/// The columns from `first`, swept down and up.
fn sweep_columns<const N: usize, L: Copy + PartialEq>(
    raster: &Raster<[f32; N]>,
    regions: &Raster<L>,
    first: usize,
    keep: f32,
) -> Raster<[f32; N]> {
    let (height, end) = (raster.height(), (first + STRIP).min(raster.width()));
    let width = end - first;
    let cells: Vec<[f32; N]> = (0..height).flat_map(|y| raster.row(y)[first..end].iter().copied()).collect();
    let mut strip =
        Raster::from_vec(width, height, cells).unwrap_or_else(|| unreachable!("a value for each cell"));
    let mut one_step = |from: usize, to: usize| {
        for x in 0..width {
            if regions.at(first + x, from) == regions.at(first + x, to) {
                let toward = strip.at(x, from);
                lean(&mut strip.row_mut(to)[x], &toward, keep);
            }
        }
    };
    (1..height).for_each(|y| one_step(y - 1, y));
    (1..height).rev().for_each(|y| one_step(y, y - 1));
    strip
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_symmetric_and_sum_to_one() {
        let weights = gaussian_weights(2.5, 5);
        assert_eq!(weights.len(), 11);
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        assert!(weights.iter().eq(weights.iter().rev()));
        assert_eq!(gaussian_weights(0.0, 1), [0.0, 1.0, 0.0]);
    }

    fn spread(raster: &Raster<f32>) -> f64 {
        let (mut sum, mut square) = (0.0, 0.0);
        let middle = (raster.width() / 2) as f64;
        for y in 0..raster.height() {
            for (x, &value) in raster.row(y).iter().enumerate() {
                sum += f64::from(value);
                square += f64::from(value) * (x as f64 - middle) * (x as f64 - middle);
            }
        }
        (square / sum).sqrt()
    }

    #[test]
    fn a_point_becomes_a_gaussian_of_the_width_asked_for() {
        let mut point = Raster::new(129, 129, 0.0f32);
        point.row_mut(64)[64] = 1.0;
        for sigma in [0.7, 2.0, 3.9, 6.0, 13.0] {
            let blurred = gaussian_plane(&point, sigma);
            let sum: f32 = blurred.as_slice().iter().sum();
            assert!((sum - 1.0).abs() < 0.02, "{sigma}: {sum}");
            assert!((spread(&blurred) / sigma - 1.0).abs() < 0.08, "{sigma}: {}", spread(&blurred));
        }
    }

    #[test]
    fn an_even_raster_stays_even_up_to_the_border() {
        for (width, height) in [(1, 1), (1, 40), (33, 2), (50, 70)] {
            let even = Raster::new(width, height, [0.25f32]);
            for sigma in [0.5, 3.0, 30.0] {
                let blurred = gaussian(&even, sigma);
                assert!(blurred.as_slice().iter().all(|[v]| (v - 0.25).abs() < 1e-5), "{width} {sigma}");
            }
        }
    }

    #[test]
    fn nothing_passes_a_wall() {
        let regions = Raster::from_fn(40, 30, |x, _| u8::from(x >= 17));
        let raster = Raster::from_fn(40, 30, |x, y| [if x >= 17 { 5.0 } else { ((x + y) % 3) as f32 }]);
        let blurred = within(&raster, &regions, 6.0);
        for y in 0..30 {
            for x in 0..40 {
                let [value] = blurred.at(x, y);
                if x >= 17 {
                    assert_eq!(value, 5.0);
                } else {
                    assert!((value - 1.0).abs() < 0.35, "{x} {y} {value}");
                }
            }
        }
    }
}
