//! Where the eye rests: what is drawn exactly, and what loosely.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane};

use crate::accidents::smoothstep;
use crate::mount::Mount;

/// How much a step of hue counts for sharpness, as against one of lightness.
const HUE: f32 = 0.3;

/// How exactly each cell is drawn, 0 loose to 1 exact, from the Lab photograph on its sheet.
///
/// Sharp, outstanding and central parts are drawn exactly; sharpness is pooled over a third of a head, so that a face is one
/// detailed area instead of two eyes.
pub fn attention(lab: &Raster<[f32; 3]>, mount: &Mount) -> Raster<f32> {
    let [width, height] = mount.size;
    let calm = gaussian(lab, mount.cells(0.0012));
    let at = |x: usize, y: usize| calm.at(x.min(width - 1), y.min(height - 1));
    let energy = Raster::by_rows(width, height, |x, y| {
        let square = |a: [f32; 3], b: [f32; 3]| {
            let [l, u, v] = [0, 1, 2].map(|c: usize| 0.5 * (a[c] - b[c]));
            l * l + HUE * (u * u + v * v)
        };
        square(at(x + 1, y), at(x.saturating_sub(1), y)) + square(at(x, y + 1), at(x, y.saturating_sub(1)))
    });
    let sharp = gaussian_plane(&energy, mount.cells(0.028));
    let (near, far) = (gaussian(lab, mount.cells(0.02)), gaussian(lab, mount.cells(0.15)));
    let outstanding = Raster::by_rows(width, height, |x, y| {
        let square: f32 = near.at(x, y).iter().zip(far.at(x, y)).map(|(a, b)| (a - b) * (a - b)).sum();
        square.sqrt()
    });
    let outstanding = ranks(&outstanding);
    let score = Raster::by_rows(width, height, |x, y| {
        let central = |at: usize, of: usize, photo: usize| {
            let off = (at as f32 - of as f32 / 2.0) / photo as f32;
            off * off
        };
        let off = central(x, width, mount.photo[0]) + central(y, height, mount.photo[1]);
        let center = libm::expf(-off / (2.0 * 0.38 * 0.38));
        // The root of the root mean square, as little contrast is much of it where all else is flat.
        let sharp = sharp.at(x, y).max(0.0).sqrt().sqrt();
        sharp * (0.35 + outstanding.at(x, y)) * (0.45 + 0.55 * center)
    });
    let exact = ranks(&score).map(|rank| smoothstep(rank, 0.38, 0.9));
    gaussian_plane(&exact, mount.cells(0.018)).map(|exact| (1.08 * exact).min(1.0))
}

/// The part of all values that are lower, 0 to 1.
pub fn ranks(values: &Raster<f32>) -> Raster<f32> {
    const QUANTILES: usize = 128;
    let mut sample: Vec<f32> = values.as_slice().iter().copied().step_by(7).collect();
    sample.sort_by(f32::total_cmp);
    let quantile = |k: usize| sample[(sample.len() - 1) * k / QUANTILES];
    let bounds: Vec<f32> = (0..=QUANTILES).map(quantile).collect();
    values.map(|value| {
        let above = bounds.partition_point(|&bound| bound <= value);
        let Some(below) = above.checked_sub(1) else { return 0.0 };
        let (low, high) = (bounds[below], bounds[above.min(QUANTILES)]);
        let part = if high > low { (value - low) / (high - low) } else { 0.0 };
        ((below as f32 + part) / QUANTILES as f32).min(1.0)
    })
}

/// The values that parts of all values are below; 0 where there is none.
pub fn quantiles<const N: usize>(values: impl Iterator<Item = f32>, parts: [f64; N]) -> [f32; N] {
    let mut sorted: Vec<f32> = values.collect();
    sorted.sort_unstable_by(f32::total_cmp);
    parts.map(|part| {
        let at = (sorted.len().saturating_sub(1)) as f64 * part;
        sorted.get(at as usize).copied().unwrap_or(0.0)
    })
}
