//! What kind of surface each part of the photograph is: busy or calm, with a direction or without.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane};

use crate::accidents::smoothstep;

/// What is finer than this is texture, and over how much of the photograph it is pooled; parts of the long edge.
const FINE: f64 = 0.010;
const POOLED: f64 = 0.014;
/// Root mean square of texture, L, from which on a part is busy, and from which on it is as busy as can be.
const BUSY: [f32; 2] = [3.5, 9.0];
/// Over how much of the photograph slopes are compared for coherence, a part of the long edge.
const COMPARED: f64 = 0.018;
/// Squared slope, (L per cell)², below which noise has no direction.
const NOISE: f32 = 0.5;
/// Coherence above which what is busy is no foliage, and below which it is.
const DIRECTED: [f32; 2] = [0.55, 0.25];

/// Blur before directions are taken, over how much they are averaged, and how many times wider and how much lighter their
/// surroundings count; parts of the long edge.
const CALM: f64 = 0.003;
const AROUND: f64 = 0.012;
const WIDER: f64 = 4.0;
const SURROUNDINGS: f32 = 0.15;
/// How much every place leans to the horizontal, (L per cell)²: hardly, but where nothing else is.
const HORIZONTAL: f32 = 0.6 / 64.0;

/// How busy the photograph is and where its structures run.
#[derive(Clone, Debug)]
pub struct Texture {
    /// How much fine change there is, 0 to 1.
    pub busy: Raster<f32>,
    /// How much of the change around goes one way, 0 to 1.
    pub coherence: Raster<f32>,
    /// Busy without a direction, as foliage is, 0 to 1.
    pub foliage: Raster<f32>,
    /// Direction along the structure, radians from the rows downward, from 0 to π.
    pub direction: Raster<f32>,
}

/// The texture of the Lab photograph, `long_edge` cells long.
pub fn texture(lab: &Raster<[f32; 3]>, long_edge: f64) -> Texture {
    let (width, height) = (lab.width(), lab.height());
    let lightness = lab.map(|[l, ..]| l);
    let busy = busy(&lightness, long_edge);
    let coherence = gaussian(&tensor(&lightness), COMPARED * long_edge).map(|[a, b, c]| {
        let spread = ((a - c) * (a - c) + 4.0 * b * b).sqrt();
        spread / (a + c + NOISE)
    });
    let foliage = Raster::by_rows(width, height, |x, y| {
        busy.at(x, y) * smoothstep(coherence.at(x, y), DIRECTED[0], DIRECTED[1])
    });
    Texture { busy, coherence, foliage, direction: direction(&lightness, long_edge) }
}

/// How much fine change there is, 0 to 1.
pub fn busy(lightness: &Raster<f32>, long_edge: f64) -> Raster<f32> {
    let smooth = gaussian_plane(lightness, FINE * long_edge);
    let squares = Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
        let fine = lightness.at(x, y) - smooth.at(x, y);
        fine * fine
    });
    let energy = gaussian_plane(&squares, POOLED * long_edge);
    energy.map(|energy| smoothstep(energy.max(0.0).sqrt(), BUSY[0], BUSY[1]))
}

/// Where structures run. A flat place takes the direction of its surroundings, and in the end the horizontal.
fn direction(lightness: &Raster<f32>, long_edge: f64) -> Raster<f32> {
    let slopes = tensor(&gaussian_plane(lightness, CALM * long_edge));
    let near = gaussian(&slopes, AROUND * long_edge);
    let far = gaussian(&near, AROUND * libm::sqrt(WIDER * WIDER - 1.0) * long_edge);
    Raster::by_rows(near.width(), near.height(), |x, y| {
        let (near, far) = (near.at(x, y), far.at(x, y));
        let [a, b, c] = [0, 1, 2].map(|k: usize| near[k] + SURROUNDINGS * far[k]);
        let across = 0.5 * libm::atan2f(2.0 * b, a - c - HORIZONTAL);
        across + core::f32::consts::FRAC_PI_2
    })
}

/// Products of the slopes at each cell: xx, xy, yy.
fn tensor(lightness: &Raster<f32>) -> Raster<[f32; 3]> {
    Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
        let [gx, gy] = slope(lightness, x, y);
        [gx * gx, gx * gy, gy * gy]
    })
}

/// The slope of a raster at a cell, per cell: Sobel's, the border continued.
pub(crate) fn slope(plane: &Raster<f32>, x: usize, y: usize) -> [f32; 2] {
    let columns = [x.saturating_sub(1), x, (x + 1).min(plane.width() - 1)];
    let rows = [y.saturating_sub(1), y, (y + 1).min(plane.height() - 1)].map(|y| plane.row(y));
    let down = |x: usize| rows[0][x] + 2.0 * rows[1][x] + rows[2][x];
    let along = |y: usize| rows[y][columns[0]] + 2.0 * rows[y][columns[1]] + rows[y][columns[2]];
    [(down(columns[2]) - down(columns[0])) / 8.0, (along(2) - along(0)) / 8.0]
}

#[cfg(test)]
mod tests {
    use core::f32::consts::PI;

    use super::*;

    fn away(a: f32, b: f32) -> f32 {
        let off = (a - b).rem_euclid(PI);
        off.min(PI - off)
    }

    #[test]
    fn stripes_have_their_direction_and_are_no_foliage() {
        for angle in [0.0f32, 0.6, 1.5, 2.4] {
            let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
            let lab = Raster::from_fn(160, 120, |x, y| {
                [50.0 + 25.0 * libm::sinf(0.9 * (y as f32 * cos - x as f32 * sin)), 0.0, 0.0]
            });
            let texture = texture(&lab, 160.0 * 4.0);
            assert!(away(texture.direction.at(80, 60), angle) < 0.05, "{angle}");
            assert!(texture.busy.at(80, 60) > 0.9 && texture.foliage.at(80, 60) < 0.1);
            assert!(texture.coherence.at(80, 60) > 0.8);
        }
    }

    #[test]
    fn specks_are_foliage_and_a_flat_place_is_horizontal() {
        let lab = Raster::from_fn(160, 120, |x, y| {
            let bits = girtin_grid::random::at(1, [x as i64 / 2, y as i64 / 2]);
            let speck = girtin_grid::random::between(bits, 30.0, 75.0) as f32;
            [if x < 80 { 60.0 } else { speck }, 0.0, 0.0]
        });
        let texture = texture(&lab, 640.0);
        assert!(texture.foliage.at(130, 60) > 0.7, "{}", texture.foliage.at(130, 60));
        assert!(texture.busy.at(20, 60) < 0.01);
        let flat = super::texture(&Raster::new(40, 30, [50.0, 3.0, 3.0]), 40.0);
        assert!(away(flat.direction.at(20, 15), 0.0) < 1e-3, "{}", flat.direction.at(20, 15));
    }
}
