//! Seeded unevenness: smooth noise over the sheet, a function of seed, stage and place.

use girtin_grid::blur::gaussian;
use girtin_grid::{Raster, random};
use rayon::prelude::*;

/// Noise of mean 0 and variance 1 whose grains are Gaussians of `sigma` cells; `N` of them at once.
pub fn noise<const N: usize>(
    seed: u64,
    stage: &str,
    [width, height]: [usize; 2],
    sigma: f64,
) -> Raster<[f32; N]> {
    // Wide noise is made on fewer cells; the same grains fall on the same parts of the sheet.
    let coarser = libm::floor(sigma / 3.0).max(1.0);
    let (w, h) = (
        libm::ceil(width as f64 / coarser).max(2.0) as usize,
        libm::ceil(height as f64 / coarser).max(2.0) as usize,
    );
    let key = random::key(seed, random::stage(stage));
    let cells: Vec<[f32; N]> = (0..h)
        .into_par_iter()
        .flat_map_iter(|y| {
            (0..w).map(move |x| {
                core::array::from_fn(|k| {
                    let bits = random::at(key, [(x * N + k) as i64, y as i64]);
                    random::between(bits, -1.0, 1.0) as f32
                })
            })
        })
        .collect();
    let white = Raster::from_vec(w, h, cells).unwrap_or_else(|| unreachable!("a value for each cell"));
    let mut smooth = gaussian(&white, sigma / coarser);
    for k in 0..N {
        let count = smooth.as_slice().len() as f64;
        let values = || smooth.as_slice().iter().map(|cell| f64::from(cell[k]));
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
        let scale = 1.0 / libm::sqrt(variance.max(1e-12));
        smooth
            .as_mut_slice()
            .iter_mut()
            .for_each(|cell| cell[k] = ((f64::from(cell[k]) - mean) * scale) as f32);
    }
    girtin_grid::resize::resized(&smooth, width, height)
}

/// One such noise.
pub fn plane(seed: u64, stage: &str, size: [usize; 2], sigma: f64) -> Raster<f32> {
    noise::<1>(seed, stage, size, sigma).map(|[value]| value)
}

/// Hermite's step from 0 at `low` to 1 at `high`.
pub fn smoothstep(value: f32, low: f32, high: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Accidents one after the other, a function of seed and stage.
#[derive(Clone, Debug)]
pub struct Chance {
    key: u64,
    drawn: u64,
}

impl Chance {
    /// Those of a stage.
    pub fn new(seed: u64, stage: &str) -> Self {
        Self::of(random::key(seed, random::stage(stage)))
    }

    /// Those of a key.
    pub fn of(key: u64) -> Self {
        Self { key, drawn: 0 }
    }

    fn next(&mut self) -> u64 {
        self.drawn += 1;
        random::fold(self.key, self.drawn)
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f32 {
        random::unit_f64(random::mix(self.next())) as f32
    }

    /// Between two values.
    pub fn between(&mut self, [least, most]: [f32; 2]) -> f32 {
        least + self.unit() * (most - least)
    }

    /// About 0, most of it up to `deviation` to either side, never beyond 1.7 of it: the sum of three even ones.
    pub fn spread(&mut self, deviation: f32) -> f32 {
        let sum: f32 = (0..3).map(|_| self.between([-1.0, 1.0])).sum();
        deviation * sum * 0.57
    }

    /// A whole number from one to another.
    pub fn count(&mut self, [least, most]: [u64; 2]) -> u64 {
        least + random::below(self.next(), most - least + 1)
    }
}
