//! Where the eye rests: what is drawn exactly, and what loosely.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane};
use girtin_grid::morphology::dilated;
use girtin_grid::resize::{resized, resized_plane};

use crate::accidents::smoothstep;
use crate::segments::segments;
use crate::texture::slope;

/// Blur before sharpness is measured, and over how much it is pooled: a third of a head, so that a face is one detailed
/// area instead of two eyes; parts of the long edge.
const CALM: f64 = 0.0015;
const POOLED: f64 = 0.03;
/// What stands out is what differs between these blurs, parts of the long edge; and how much strong color stands out, parts
/// of its chroma.
const STANDING_OUT: [f64; 2] = [0.02, 0.16];
const COLORFUL: f32 = 0.35;
/// How much a place counts that does not stand out at all, and one far from the middle; and how wide the middle is, parts of
/// width and height.
const UNREMARKABLE: f32 = 0.35;
const OFF_CENTER: f32 = 0.35;
const MIDDLE: [f32; 2] = [0.36, 0.40];
/// Over how much of the long edge the score is averaged, and the ranks from which on and up to which attention grows.
const AVERAGED: f64 = 0.02;
const ATTENDED: [f32; 2] = [0.55, 0.95];
/// How much attention is left for all else where there is a face.
const BESIDE_A_FACE: f32 = 0.75;
/// Last blur of attention, a part of the long edge.
const SOFT: f64 = 0.012;

/// Where the photograph lies in a raster that goes on around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// First column and row.
    pub origin: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

/// How exactly each cell is drawn, 0 loose to 1 exact, from the Lab photograph on its sheet.
///
/// Sharp, outstanding and central parts are drawn exactly, and `faces` (0 to 1, of the sheet) above all. Beyond the
/// photograph's `area` its border goes on.
///
/// # Panics
/// The area is empty or not within the raster, or the sizes of the rasters differ.
pub fn attention(lab: &Raster<[f32; 3]>, area: Area, faces: &Raster<f32>, long_edge: f64) -> Raster<f32> {
    let ([left, top], [width, height]) = (area.origin, area.size);
    let photo = Raster::by_rows(width, height, |x, y| lab.at(left + x, top + y));
    let calm = gaussian_plane(&photo.map(|[l, ..]| l), CALM * long_edge);
    let energy = Raster::by_rows(width, height, |x, y| {
        let [gx, gy] = slope(&calm, x, y);
        gx * gx + gy * gy
    });
    let sharp = gaussian_plane(&energy, POOLED * long_edge);
    let [near, far] = STANDING_OUT.map(|sigma| gaussian(&photo, sigma * long_edge));
    let outstanding = ranks(&Raster::by_rows(width, height, |x, y| {
        let square: f32 = near.at(x, y).iter().zip(far.at(x, y)).map(|(a, b)| (a - b) * (a - b)).sum();
        let [_, a, b] = photo.at(x, y);
        square.sqrt() + COLORFUL * (a * a + b * b).sqrt()
    }));
    let score = Raster::by_rows(width, height, |x, y| {
        let off = |at: usize, of: usize, wide: f32| {
            let off = ((at as f32 + 0.5) / of as f32 - 0.5) / wide;
            off * off
        };
        let center = libm::expf(-0.5 * (off(x, width, MIDDLE[0]) + off(y, height, MIDDLE[1])));
        // The root of the root mean square, as little contrast is much of it where all else is flat.
        let sharp = sharp.at(x, y).max(0.0).sqrt().sqrt();
        sharp * (UNREMARKABLE + outstanding.at(x, y)) * (OFF_CENTER + (1.0 - OFF_CENTER) * center)
    });
    let rank = ranks(&gaussian_plane(&score, AVERAGED * long_edge));
    let others = if faces.as_slice().iter().any(|&face| face > 0.5) { BESIDE_A_FACE } else { 1.0 };
    let exact = Raster::by_rows(width, height, |x, y| {
        let seen = others * smoothstep(rank.at(x, y), ATTENDED[0], ATTENDED[1]);
        seen.max(faces.at(left + x, top + y))
    });
    let exact = gaussian_plane(&exact, SOFT * long_edge);
    Raster::by_rows(lab.width(), lab.height(), |x, y| {
        let [x, y] = [(x, left, width), (y, top, height)]
            .map(|(at, first, count)| at.saturating_sub(first).min(count - 1));
        exact.at(x, y).clamp(0.0, 1.0)
    })
}

/// How many colors the things that attention keeps to differ in, Lab × cells, and their least area, parts of the long edge
/// squared.
const THING: f32 = 23.5;
const LEAST_THING: f64 = 2e-4;
/// Parts of the picture up to which a thing has one attention, and from which on its own parts differ.
const LARGE: [f32; 2] = [0.05, 0.25];
/// A thing's attention is its mean times this; a large thing's is at most this much above its mean.
const RAISED: f32 = 1.25;
const ABOVE_MEAN: f32 = 0.15;
/// How far attention reaches around a thing, and its blur, parts of the long edge.
const AROUND: f64 = 0.008;
const SOFT_AROUND: f64 = 0.006;

/// Attention that keeps to things: it does not end within one, and reaches a little around it.
///
/// `flat` is the photograph in flat colors, see [`flattened`](crate::simplify::flattened); it may be smaller.
pub fn snapped(attention: &Raster<f32>, flat: &Raster<[f32; 3]>, long_edge: f64) -> Raster<f32> {
    let (width, height) = (attention.width(), attention.height());
    // Half the cells each way are enough for things of this size.
    let (w, h) = (width.div_ceil(2), height.div_ceil(2));
    let edge = 0.5 * long_edge;
    let things = segments(&resized(flat, w, h), THING / 2.0, (LEAST_THING * edge * edge) as usize);
    let exact = resized_plane(attention, w, h);
    let count = things.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
    let (mut cells, mut sums) = (vec![0u32; count], vec![0.0f64; count]);
    for (&thing, &exact) in things.as_slice().iter().zip(exact.as_slice()) {
        cells[thing as usize] += 1;
        sums[thing as usize] += f64::from(exact);
    }
    let all = (w * h) as f32;
    let snapped = Raster::by_rows(w, h, |x, y| {
        let thing = things.at(x, y) as usize;
        let mean = (sums[thing] / f64::from(cells[thing])) as f32;
        let large = smoothstep(cells[thing] as f32 / all, LARGE[0], LARGE[1]);
        let whole = (RAISED * mean).min(1.0);
        whole + large * (exact.at(x, y).min(mean + ABOVE_MEAN) - whole)
    });
    let around = dilated(&snapped, libm::round(AROUND * edge) as usize);
    let soft = gaussian_plane(&around, SOFT_AROUND * edge);
    resized_plane(&soft, width, height).map(|exact| exact.clamp(0.0, 1.0))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A checkered square of a strong color on a calm ground.
    fn photo() -> Raster<[f32; 3]> {
        Raster::from_fn(220, 160, |x, y| {
            if (90..130).contains(&x) && (60..100).contains(&y) {
                [if (x / 4 + y / 4) % 2 == 0 { 30.0 } else { 70.0 }, 40.0, 20.0]
            } else {
                [80.0, 0.0, 0.0]
            }
        })
    }

    const AREA: Area = Area { origin: [10, 10], size: [200, 140] };

    #[test]
    fn the_eye_rests_on_what_stands_out_and_most_on_faces() {
        let none = Raster::new(220, 160, 0.0);
        let exact = attention(&photo(), AREA, &none, 200.0);
        assert!(exact.at(110, 80) > 0.95, "{}", exact.at(110, 80));
        assert!(exact.at(20, 20) < 0.05 && exact.at(0, 0) < 0.05);
        let face = Raster::from_fn(220, 160, |x, y| f32::from(u8::from(x > 170 && y > 110)));
        let with = attention(&photo(), AREA, &face, 200.0);
        assert!(with.at(190, 130) > 0.95 && (with.at(110, 80) - 0.75).abs() < 0.05);
        assert_eq!(with.at(219, 130), with.at(209, 130));
    }

    #[test]
    fn attention_fills_a_thing() {
        let flat = Raster::from_fn(300, 200, |x, _| if x < 40 { [30.0, 0.0, 0.0] } else { [70.0, 0.0, 0.0] });
        let exact = Raster::from_fn(300, 200, |x, y| f32::from(u8::from(x < 30 && y > 20)));
        let snapped = snapped(&exact, &flat, 300.0);
        assert!(snapped.at(36, 100) > 0.45, "{}", snapped.at(36, 100));
        assert!(snapped.at(200, 100) < 0.05);
    }
}
