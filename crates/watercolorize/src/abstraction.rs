//! Fewer, rounder, flatter shapes: an anisotropic Kuwahara filter.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian;
use girtin_grid::resize::{resized, resized_plane};
use rayon::prelude::*;

/// Sectors around a cell; the flattest of them give its color.
const SECTORS: usize = 8;
/// Orientations that are told apart, over half a turn.
const ORIENTATIONS: usize = 16;
/// Elongations that are told apart.
const ELONGATIONS: usize = 4;
/// Radii that are told apart in a doubling.
const RADII: usize = 4;
/// Largest radius that is filtered cell by cell; a larger one is filtered on half as many.
const LARGEST: f32 = 4.5;
/// Radius below which nothing is abstracted.
const SMALLEST: f32 = 1.0;
/// Variance, Lab², from which a sector counts less.
const VARIANCE: f32 = 4.0;

/// The Lab picture abstracted over a radius that may differ from cell to cell, cells.
///
/// # Source
/// Kyprianidis, Kang, Döllner, *Image and Video Abstraction by Anisotropic Kuwahara Filtering*, 2009, with sharpness 6; wide
/// radii on a smaller raster.
pub fn abstracted(lab: &Raster<[f32; 3]>, radius: &Raster<f32>) -> Raster<[f32; 3]> {
    let (width, height) = (lab.width(), lab.height());
    let largest = radius.as_slice().iter().fold(0.0f32, |most, &r| most.max(r));
    let coarse = (largest > LARGEST && width.min(height) >= 16).then(|| {
        let (w, h) = (width.div_ceil(2), height.div_ceil(2));
        let halved = resized_plane(radius, w, h).map(|r| r / 2.0);
        resized(&abstracted(&resized(lab, w, h), &halved), width, height)
    });
    let mean = radius.as_slice().iter().map(|&r| f64::from(r.min(LARGEST))).sum::<f64>()
        / radius.as_slice().len().max(1) as f64;
    let flow = Flow::of(lab, (0.5 * mean).max(1.5));
    let kernels = Kernels::new();
    let cells: Vec<[f32; 3]> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let (kernels, flow, coarse) = (&kernels, &flow, &coarse);
            (0..width).map(move |x| {
                let r = radius.at(x, y);
                match coarse {
                    Some(coarse) if r >= LARGEST => coarse.at(x, y),
                    Some(coarse) if r > 0.8 * LARGEST => {
                        let part = (r / LARGEST - 0.8) / 0.2;
                        let fine = filtered(lab, x, y, kernels.at(r, flow.at(x, y)));
                        mix(fine, coarse.at(x, y), part)
                    }
                    _ if r < SMALLEST => lab.at(x, y),
                    _ => filtered(lab, x, y, kernels.at(r.min(LARGEST), flow.at(x, y))),
                }
            })
        })
        .collect();
    Raster::from_vec(width, height, cells).unwrap_or_else(|| unreachable!("a color for each cell"))
}

fn mix(a: [f32; 3], b: [f32; 3], part: f32) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] + part * (b[c] - a[c]))
}

/// Where the picture's lines run, and how clearly.
pub struct Flow(Raster<[f32; 2]>);

impl Flow {
    /// Of the structure tensor of a picture's lightness, smoothed over `sigma` cells.
    pub fn of(lab: &Raster<[f32; 3]>, sigma: f64) -> Self {
        let (width, height) = (lab.width(), lab.height());
        let at = |x: isize, y: isize| {
            lab.at(x.clamp(0, width as isize - 1) as usize, y.clamp(0, height as isize - 1) as usize)[0]
        };
        let tensor = Raster::by_rows(width, height, |x, y| {
            let (x, y) = (x as isize, y as isize);
            let sobel = |dx: isize, dy: isize| {
                let side = |s: isize| {
                    at(x + dx * s + dy, y + dy * s + dx)
                        + at(x + dx * s - dy, y + dy * s - dx)
                        + 2.0 * at(x + dx * s, y + dy * s)
                };
                side(1) - side(-1)
            };
            let (gx, gy) = (sobel(1, 0), sobel(0, 1));
            [gx * gx, gx * gy, gy * gy]
        });
        let tensor = gaussian(&tensor, sigma);
        Self(Raster::by_rows(width, height, |x, y| {
            let [e, f, g] = tensor.at(x, y);
            let spread = libm::sqrtf((e - g) * (e - g) + 4.0 * f * f);
            let along = 0.5 * libm::atan2f(2.0 * f, e - g) + core::f32::consts::FRAC_PI_2;
            [along, spread / (e + g + 1e-6)]
        }))
    }

    /// The angle of the line through a cell, and how clear it is, 0 to 1.
    pub fn at(&self, x: usize, y: usize) -> [f32; 2] {
        self.0.at(x, y)
    }
}

/// A neighbour of a cell with its weight in each sector.
type Tap = (isize, isize, [f32; SECTORS]);

/// Kernels for every radius, orientation and elongation.
struct Kernels(Vec<Vec<Tap>>);

impl Kernels {
    fn new() -> Self {
        let count = Self::radius_index(LARGEST) + 1;
        let all = (0..count * ORIENTATIONS * ELONGATIONS).into_par_iter().map(|index| {
            let (shape, elongation) = (index / ELONGATIONS, index % ELONGATIONS);
            let (radius, orientation) = (shape / ORIENTATIONS, shape % ORIENTATIONS);
            let radius = SMALLEST * libm::exp2f(radius as f32 / RADII as f32);
            let angle = core::f32::consts::PI * orientation as f32 / ORIENTATIONS as f32;
            kernel(radius, angle, (elongation as f32 + 0.5) / ELONGATIONS as f32)
        });
        Self(all.collect())
    }

    fn radius_index(radius: f32) -> usize {
        (libm::log2f(radius / SMALLEST) * RADII as f32 + 0.5) as usize
    }

    fn at(&self, radius: f32, [along, clear]: [f32; 2]) -> &[Tap] {
        let turns = (along / core::f32::consts::PI).rem_euclid(1.0);
        let orientation = (turns * ORIENTATIONS as f32 + 0.5) as usize % ORIENTATIONS;
        let elongation = ((clear * ELONGATIONS as f32) as usize).min(ELONGATIONS - 1);
        &self.0[(Self::radius_index(radius) * ORIENTATIONS + orientation) * ELONGATIONS + elongation]
    }
}

fn kernel(radius: f32, angle: f32, clear: f32) -> Vec<Tap> {
    let (long, short) = (radius * (1.0 + clear), radius / (1.0 + clear));
    let (cos, sin) = (libm::cosf(angle), libm::sinf(angle));
    let reach = libm::ceilf(long) as isize;
    let mut taps = Vec::new();
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let (x, y) = (dx as f32, dy as f32);
            let (u, v) = ((cos * x + sin * y) / long, (cos * y - sin * x) / short);
            let distance = u * u + v * v;
            if distance > 1.0 {
                continue;
            }
            let weight = libm::expf(-2.0 * distance);
            let mut sectors = [weight / SECTORS as f32; SECTORS];
            if distance > 1e-6 {
                sectors = [0.0; SECTORS];
                let turn = libm::atan2f(v, u) / core::f32::consts::TAU;
                let place = turn.rem_euclid(1.0) * SECTORS as f32;
                let part = place - libm::floorf(place);
                sectors[place as usize % SECTORS] = weight * (1.0 - part);
                sectors[(place as usize + 1) % SECTORS] = weight * part;
            }
            taps.push((dx, dy, sectors));
        }
    }
    taps
}

fn filtered(lab: &Raster<[f32; 3]>, x: usize, y: usize, kernel: &[Tap]) -> [f32; 3] {
    let (right, bottom) = (lab.width() as isize - 1, lab.height() as isize - 1);
    let cells = lab.as_slice();
    let (mut weights, mut squares) = ([0.0f32; SECTORS], [0.0f32; SECTORS]);
    let mut sums = [[0.0f32; SECTORS]; 3];
    for (dx, dy, sectors) in kernel {
        let at = (y as isize + dy).clamp(0, bottom) * (right + 1) + (x as isize + dx).clamp(0, right);
        let [l, a, b] = cells[at as usize];
        let square = l * l + a * a + b * b;
        for k in 0..SECTORS {
            let weight = sectors[k];
            weights[k] += weight;
            squares[k] += weight * square;
            sums[0][k] += weight * l;
            sums[1][k] += weight * a;
            sums[2][k] += weight * b;
        }
    }
    let (mut all, mut mean) = (0.0, [0.0; 3]);
    for k in (0..SECTORS).filter(|&k| weights[k] > 1e-9) {
        let color = [0, 1, 2].map(|c: usize| sums[c][k] / weights[k]);
        let square: f32 = color.iter().map(|value| value * value).sum();
        let ratio = (squares[k] / weights[k] - square).max(0.0) / VARIANCE;
        let flat = 1.0 / (1.0 + ratio * ratio * ratio);
        all += flat;
        mean.iter_mut().zip(color).for_each(|(mean, value)| *mean += flat * value);
    }
    mean.map(|value| value / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_goes_and_edges_stay() {
        let lab = Raster::from_fn(64, 48, |x, y| {
            let noise = ((x * 7919 + y * 104_729) % 13) as f32 - 6.0;
            [if x < 32 { 20.0 } else { 80.0 } + noise, 0.0, 0.0]
        });
        let calm = abstracted(&lab, &Raster::new(64, 48, 4.0));
        for y in 8..40 {
            assert!((calm.at(29, y)[0] - 20.0).abs() < 5.0, "{}", calm.at(29, y)[0]);
            assert!((calm.at(34, y)[0] - 80.0).abs() < 5.0);
        }
        let spread = |raster: &Raster<[f32; 3]>| {
            (8..40).map(|y| (raster.at(12, y)[0] - 20.0).powi(2)).sum::<f32>() / 32.0
        };
        assert!(spread(&calm) < 0.5 * spread(&lab), "{} {}", spread(&calm), spread(&lab));
    }

    #[test]
    fn any_size_and_radius_is_filtered() {
        for (width, height) in [(1, 1), (1, 30), (17, 3), (40, 40)] {
            let lab = Raster::new(width, height, [50.0, 10.0, -10.0]);
            for radius in [0.0, 1.0, 4.4, 20.0] {
                let flat = abstracted(&lab, &Raster::new(width, height, radius));
                assert!(
                    flat.as_slice().iter().all(|c| (c[0] - 50.0).abs() < 1e-3 && (c[2] + 10.0).abs() < 1e-3)
                );
            }
        }
    }
}
