//! A low-pass filter that knows where the paper is wet.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_weights;
use rayon::prelude::*;

/// The Gaussian mean of `values` over the cells where `mask` is 1; 0 where it is 0.
///
/// # Source
/// Curtis et al. 1997, §6.2, "a low-pass filter on the difference". W3: which, and what it does at the edge of the wet paper, is
/// not said. Weights of dry cells are left out: else everything along the edge would seem to lack half its pigment.
///
/// # Shapes and units
/// `sigma`: cells, 0 leaves `values` as they are; `mask`: 0 or 1.
pub(super) fn low_pass(values: &Raster<f32>, mask: &Raster<f32>, sigma: f64) -> Raster<f32> {
    let (width, height) = (values.width(), values.height());
    let masked: Vec<f32> =
        values.as_slice().iter().zip(mask.as_slice()).map(|(value, mask)| value * mask).collect();
    let masked = Raster::from_vec(width, height, masked).unwrap_or_else(|| values.clone());
    if sigma <= 0.0 || width == 0 {
        return masked;
    }
    let weights = gaussian_weights(sigma, (3.0 * sigma).ceil() as usize);
    let (mut mean, weight) = (blurred(&masked, &weights), blurred(mask, &weights));
    let cells = mean.as_mut_slice().iter_mut().zip(weight.as_slice()).zip(mask.as_slice());
    for ((mean, weight), mask) in cells {
        *mean = if *mask > 0.0 { *mean / weight } else { 0.0 };
    }
    mean
}

/// Blurred along rows, then along columns; nothing lies outside.
fn blurred(values: &Raster<f32>, weights: &[f32]) -> Raster<f32> {
    let (width, height) = (values.width(), values.height());
    let radius = weights.len() / 2;
    let mut along = Raster::new(width, height, 0.0f32);
    along.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let row = values.row(y);
        for (x, out) in out.iter_mut().enumerate() {
            let (first, end) = (x.saturating_sub(radius), (x + radius + 1).min(width));
            let taps = &weights[first + radius - x..];
            *out = row[first..end].iter().zip(taps).map(|(value, weight)| value * weight).sum();
        }
    });
    let mut both = Raster::new(width, height, 0.0f32);
    both.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for row in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            let weight = weights[row + radius - y];
            out.iter_mut().zip(along.row(row)).for_each(|(out, value)| *out += weight * value);
        }
    });
    both
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_region_stays_flat_up_to_its_edge() {
        let mask = Raster::from_fn(30, 20, |x, y| f32::from(u8::from((5..22).contains(&x) && y > 3)));
        let values = Raster::from_fn(30, 20, |x, _| if x < 22 { 0.4 } else { 9.0 });
        let found = low_pass(&values, &mask, 3.0);
        for y in 0..20 {
            for x in 0..30 {
                assert!((found.at(x, y) - 0.4 * mask.at(x, y)).abs() < 1e-5, "{x}, {y}");
            }
        }
    }

    #[test]
    fn fine_detail_goes_and_coarse_stays() {
        let mask = Raster::new(64, 64, 1.0);
        let checks = Raster::from_fn(64, 64, |x, y| ((x + y) % 2) as f32);
        let found = low_pass(&checks, &mask, 2.0);
        assert!(found.as_slice().iter().all(|value| (value - 0.5).abs() < 0.03));
        let half = Raster::from_fn(64, 64, |x, _| f32::from(u8::from(x < 32)));
        let found = low_pass(&half, &mask, 2.0);
        assert!(found.at(20, 9) > 0.999 && found.at(44, 9) < 0.001);
    }
}
