//! A sheet of a paper: its height at any place and resolution.

use girtin_grid::Raster;
use girtin_grid::random::{fold, mix};
use rayon::prelude::*;

use crate::HeightSource;
use crate::recipe::Paper;
use crate::samples::{Axis, Ground, Patch, points_in_cell};

/// Heights stay this far from 0 and 1.
pub(crate) const MARGIN: f32 = 1e-3;

/// Points that are evaluated at a time, across and down: what fits the second-level cache.
const BLOCK: [usize; 2] = [512, 128];

/// Points each way that a layer's mean and deviation are taken over.
const CALIBRATION_POINTS: usize = 160;

/// Their distance, mm: many times any feature in all, in step with none.
const CALIBRATION_MM: f64 = 0.731;

/// A sheet of some paper: endless, or a tile that continues itself.
///
/// The height is a function of the place on the sheet in mm, the paper and the seed alone. Which part is
/// asked for, at how many cells per mm and on how many threads, makes no difference.
#[derive(Clone, Debug)]
pub struct Sheet {
    paper: Paper,
    ground: Ground,
    shares: Vec<Share>,
}

/// How a layer's values enter the height: `scale * value + shift`.
#[derive(Clone, Copy, Debug)]
struct Share {
    scale: f32,
    shift: f32,
}

impl Sheet {
    /// An endless sheet.
    #[must_use]
    pub fn new(paper: &Paper, seed: u64) -> Self {
        Self::with_tile(paper, seed, None)
    }

    /// A sheet that repeats every `tile_mm` millimetres without a seam. Features are stretched a little to
    /// fit.
    ///
    /// # Panics
    /// A side of the tile is not a finite number of at least 0.1 mm.
    #[must_use]
    pub fn tiled(paper: &Paper, seed: u64, tile_mm: [f64; 2]) -> Self {
        assert!(tile_mm.iter().all(|side| side.is_finite() && *side >= 0.1), "a tile of {tile_mm:?} mm");
        Self::with_tile(paper, seed, Some(tile_mm))
    }

    fn with_tile(paper: &Paper, seed: u64, tile_mm: Option<[f64; 2]>) -> Self {
        let ground = Ground { seed: mix(fold(0, seed)), tile_mm };
        Self { shares: shares(paper), paper: paper.clone(), ground }
    }

    /// What paper it is of.
    pub fn paper(&self) -> &Paper {
        &self.paper
    }

    /// The size of the tile, if the sheet is one.
    pub fn tile_mm(&self) -> Option<[f64; 2]> {
        self.ground.tile_mm
    }

    /// Relief at the points of a patch: mean 0, deviation 1.
    fn relief(&self, patch: &Patch, layer_values: &mut [f32], relief: &mut [f32]) {
        relief.fill(0.0);
        for (number, (layer, share)) in self.paper.layers().iter().zip(&self.shares).enumerate() {
            layer.fill(&self.ground, number, patch, layer_values);
            for (sum, &value) in relief.iter_mut().zip(&*layer_values) {
                *sum += share.scale * value + share.shift;
            }
        }
    }
}

impl HeightSource for Sheet {
    /// Means over the points of each cell of a fixed lattice (16 to the mm), after the curve that keeps
    /// heights inside (0, 1).
    ///
    /// # Cost
    /// In proportion to square millimetres up to 16 cells per mm, then to cells.
    fn height_field(
        &self,
        width: usize,
        height: usize,
        cells_per_mm: f64,
        origin_mm: [f64; 2],
    ) -> Raster<f32> {
        crate::check_place(cells_per_mm, origin_mm);
        let mut field = Raster::new(width, height, 0.5);
        if width == 0 || height == 0 {
            return field;
        }
        let points = points_in_cell(cells_per_mm);
        let per_mm = cells_per_mm * points as f64;
        let origin = origin_mm.map(|mm| whole_if_near(mm * per_mm));
        let contrast = 2.0 * self.paper.surface.relief as f32;
        let (columns, lines) = ((BLOCK[0] / points).max(1), (BLOCK[1] / points).max(1));
        field.as_mut_slice().par_chunks_mut(width * lines).enumerate().for_each(|(band, cells)| {
            let lines_here = cells.len() / width;
            let y = Axis {
                first: origin[1] + (band * lines * points) as f64,
                per_mm,
                count: lines_here * points,
            };
            let mut values = vec![0.0; columns * points * y.count];
            let mut relief = values.clone();
            for start in (0..width).step_by(columns) {
                let columns_here = columns.min(width - start);
                let x =
                    Axis { first: origin[0] + (start * points) as f64, per_mm, count: columns_here * points };
                let count = x.count * y.count;
                let relief = &mut relief[..count];
                self.relief(&Patch { x, y }, &mut values[..count], relief);
                for value in relief.iter_mut() {
                    *value = 0.5 + 0.5 * into_unit(contrast * *value);
                }
                for (line, block) in relief.chunks_exact(x.count * points).enumerate() {
                    let row = &mut cells[line * width + start..][..columns_here];
                    mean_of_points(block, points, row);
                }
            }
        });
        field
    }
}

/// The mean of each cell's points: `block` holds the `points` rows of points of one row of cells.
fn mean_of_points(block: &[f32], points: usize, row: &mut [f32]) {
    let stride = row.len() * points;
    row.fill(0.0);
    for line in block.chunks_exact(stride) {
        for (cell, values) in row.iter_mut().zip(line.chunks_exact(points)) {
            *cell += values.iter().sum::<f32>();
        }
    }
    let share = 1.0 / (points * points) as f32;
    for cell in row {
        *cell = (*cell * share).clamp(MARGIN, 1.0 - MARGIN);
    }
}

/// −1 to 1, rising, slope 1 at 0: the Padé approximant of tanh, which reaches 1 at 3 with slope 0.
#[inline]
pub(crate) fn into_unit(z: f32) -> f32 {
    let z = z.clamp(-3.0, 3.0);
    let square = z * z;
    z * (27.0 + square) / (27.0 + 9.0 * square)
}

/// The whole number next to `x` if that is what it was meant to be: cells then fall on the very same points
/// whatever part of the sheet is asked for.
fn whole_if_near(x: f64) -> f64 {
    let whole = libm::round(x);
    if (x - whole).abs() < 1e-6 { whole } else { x }
}

/// How each layer is brought to its share of a relief of mean 0 and deviation 1.
///
/// Taken once over widely spread points of an endless sheet of one seed: a function of the recipe only, never
/// of the part of a sheet that is asked for, so that crops and resolutions agree.
fn shares(paper: &Paper) -> Vec<Share> {
    let axis = Axis { first: 0.0, per_mm: 1.0 / CALIBRATION_MM, count: CALIBRATION_POINTS };
    let patch = Patch { x: axis, y: axis };
    let ground = Ground { seed: 0, tile_mm: None };
    let total = libm::sqrt(paper.layers().iter().map(|layer| layer.amount() * layer.amount()).sum());
    let mut values = vec![0.0; CALIBRATION_POINTS * CALIBRATION_POINTS];
    let share = |(number, layer): (usize, &crate::layers::Layer)| {
        layer.fill(&ground, number, &patch, &mut values);
        let count = values.len() as f64;
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / count;
        let square =
            values.iter().map(|&v| (f64::from(v) - mean) * (f64::from(v) - mean)).sum::<f64>() / count;
        // A layer without any relief (fibers so few that no point met one) adds nothing.
        let scale = if square > 1e-12 { layer.amount() / (total * libm::sqrt(square)) } else { 0.0 };
        Share { scale: scale as f32, shift: (-mean * scale) as f32 }
    };
    paper.layers().iter().enumerate().map(share).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::library::Papers;

    fn sheet(name: &str, seed: u64) -> Sheet {
        Sheet::new(Papers::builtin().get(name).unwrap(), seed)
    }

    fn deviation(field: &Raster<f32>) -> f64 {
        let count = field.as_slice().len() as f64;
        let mean = field.as_slice().iter().map(|&h| f64::from(h)).sum::<f64>() / count;
        libm::sqrt(
            field.as_slice().iter().map(|&h| (f64::from(h) - mean) * (f64::from(h) - mean)).sum::<f64>()
                / count,
        )
    }

    fn rms(a: &Raster<f32>, b: &Raster<f32>) -> f64 {
        assert_eq!((a.width(), a.height()), (b.width(), b.height()));
        let squares =
            a.as_slice().iter().zip(b.as_slice()).map(|(&a, &b)| f64::from(a - b) * f64::from(a - b));
        libm::sqrt(squares.sum::<f64>() / a.as_slice().len() as f64)
    }

    /// The distance down the sheet, mm, at which heights are half as much alike as at one place.
    fn correlation_mm(field: &Raster<f32>, cells_per_mm: f64) -> f64 {
        let mean = field.as_slice().iter().sum::<f32>() / field.as_slice().len() as f32;
        let alike = |lag: usize| {
            let rows = 0..field.height() - lag;
            let count = (rows.len() * field.width()) as f64;
            let row = |y| {
                let pairs = field.row(y).iter().zip(field.row(y + lag));
                pairs.map(|(a, b)| f64::from((a - mean) * (b - mean))).sum::<f64>()
            };
            rows.map(row).sum::<f64>() / count
        };
        let half = 0.5 * alike(0);
        let (mut lag, mut before) = (1, alike(0));
        loop {
            let now = alike(lag);
            if now < half {
                return ((lag - 1) as f64 + (before - half) / (before - now)) / cells_per_mm;
            }
            (lag, before) = (lag + 1, now);
        }
    }

    #[test]
    fn papers_have_their_deviation_and_grain() {
        // Name, deviation of height at 4 cells per mm, half-correlation in mm at 16.
        let expected = [
            ("smooth", 0.03..0.055, 0.12..0.3),
            ("hot-press", 0.07..0.11, 0.15..0.35),
            ("fine-grain", 0.12..0.19, 0.2..0.32),
            ("cold-press", 0.15..0.2, 0.3..0.55),
            ("rough", 0.175..0.23, 0.6..1.2),
            ("laid", 0.09..0.14, 0.15..0.35),
            ("canvas", 0.1..0.16, 0.12..0.3),
            ("japanese", 0.07..0.12, 0.1..0.3),
        ];
        assert_eq!(expected.len(), Papers::builtin().iter().count());
        for (name, deviations, grains) in expected {
            let sheet = sheet(name, 3);
            let coarse = sheet.height_field(256, 256, 4.0, [0.0, 0.0]);
            let mean = coarse.as_slice().iter().sum::<f32>() / coarse.as_slice().len() as f32;
            assert!((mean - 0.5).abs() < 0.03, "{name}: mean {mean}");
            let deviation = deviation(&coarse);
            assert!(deviations.contains(&deviation), "{name}: deviation {deviation}");
            let grain = correlation_mm(&sheet.height_field(512, 512, 16.0, [0.0, 0.0]), 16.0);
            assert!(grains.contains(&grain), "{name}: half-correlation {grain} mm");
        }
    }

    #[test]
    fn rougher_papers_go_farther_up_and_down() {
        let deviations = ["smooth", "hot-press", "cold-press", "rough"]
            .map(|name| deviation(&sheet(name, 9).height_field(200, 200, 4.0, [0.0, 0.0])));
        assert!(deviations.is_sorted(), "{deviations:?}");
    }

    #[test]
    fn cold_press_uses_most_of_the_range() {
        let mut heights = sheet("cold-press", 1).height_field(300, 300, 4.0, [0.0, 0.0]).into_vec();
        heights.sort_by(f32::total_cmp);
        let (low, high) = (heights[heights.len() / 100], heights[heights.len() * 99 / 100]);
        assert!((0.07..0.17).contains(&low) && (0.81..0.93).contains(&high), "{low} to {high}");
    }

    #[test]
    fn resolutions_agree() {
        for paper in Papers::builtin().iter() {
            let sheet = Sheet::new(paper, 5);
            let at = |cells: usize, cells_per_mm| sheet.height_field(cells, cells, cells_per_mm, [3.0, -2.0]);
            let four = at(60, 4.0);
            // The same points, added up in another order.
            for (finer, cells_per_mm) in [(2, 8.0), (4, 16.0)] {
                let error = rms(&at(60 * finer, cells_per_mm).box_reduced(finer), &four);
                assert!(error < 1e-6, "{}: {error} from {cells_per_mm}", paper.id);
            }
            // Other points: what is left is the grain between them.
            let deviation = deviation(&four);
            for (cells, cells_per_mm, finer) in [(180, 12.0, 3), (300, 20.0, 5), (480, 32.0, 8)] {
                let error = rms(&at(cells, cells_per_mm).box_reduced(finer), &four);
                assert!(error < 0.02 * deviation, "{}: {error} of {deviation} from {cells_per_mm}", paper.id);
            }
        }
    }

    #[test]
    fn fine_resolutions_show_grain_below_a_quarter_millimetre() {
        let field = sheet("cold-press", 2).height_field(320, 320, 16.0, [0.0, 0.0]);
        let coarse = field.box_reduced(4);
        let grain = Raster::from_fn(320, 320, |x, y| field.at(x, y) - coarse.at(x / 4, y / 4));
        assert!(deviation(&grain) > 0.02, "{}", deviation(&grain));
    }

    #[test]
    fn crops_are_the_same_cells() {
        for paper in Papers::builtin().iter() {
            let sheet = Sheet::new(paper, 8);
            let whole = sheet.height_field(170, 90, 4.0, [-11.0, 3.5]);
            let crop = sheet.height_field(37, 29, 4.0, [-11.0 + 133.0 / 4.0, 3.5 + 61.0 / 4.0]);
            for y in 0..29 {
                assert_eq!(crop.row(y), &whole.row(y + 61)[133..], "{}", paper.id);
            }
        }
    }

    #[test]
    fn a_tile_continues_itself() {
        for paper in Papers::builtin().iter() {
            let sheet = Sheet::tiled(paper, 4, [20.0, 12.0]);
            let here = sheet.height_field(80, 48, 4.0, [0.0, 0.0]);
            for origin in [[20.0, 0.0], [0.0, -12.0], [-40.0, 36.0]] {
                let there = sheet.height_field(80, 48, 4.0, origin);
                let error = rms(&here, &there);
                assert!(error < 1e-4, "{}: {error} at {origin:?}", paper.id);
            }
            // Not because it is level: the next cell row is another one.
            let shifted = sheet.height_field(80, 48, 4.0, [0.0, 0.5]);
            assert!(rms(&here, &shifted) > 0.1 * deviation(&here), "{}", paper.id);
        }
    }

    #[test]
    fn seeds_differ_and_the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
        for paper in Papers::builtin().iter() {
            let make = |seed, threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| Sheet::new(paper, seed).height_field(150, 210, 5.3, [0.1, 0.2]))
            };
            let one = make(1, 1);
            assert_eq!(one, make(1, 4), "{}", paper.id);
            assert!(rms(&one, &make(2, 2)) > 0.5 * deviation(&one), "{}", paper.id);
        }
    }

    #[test]
    fn sizes_without_cells_are_empty() {
        let sheet = sheet("rough", 0);
        for (width, height) in [(0, 0), (0, 5), (5, 0)] {
            assert!(sheet.height_field(width, height, 4.0, [0.0, 0.0]).as_slice().is_empty());
        }
    }

    #[test]
    fn the_curve_rises_from_minus_one_to_one() {
        assert_eq!((into_unit(-9.0), into_unit(0.0), into_unit(3.0)), (-1.0, 0.0, 1.0));
        let values: Vec<f32> = (-400..=400).map(|k| into_unit(k as f32 / 100.0)).collect();
        // To rounding, where it runs level into its ends.
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1] + 2.0 * f32::EPSILON));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn heights_are_inside_zero_and_one(
            paper in 0..7_usize, seed: u64, width in 1..20_usize, height in 1..20_usize,
            cells_per_mm in 0.3..40.0f64, x in -1e5..1e5f64, y in -1e5..1e5f64,
        ) {
            let papers = Papers::builtin();
            let sheet = Sheet::new(papers.iter().nth(paper).unwrap(), seed);
            let field = sheet.height_field(width, height, cells_per_mm, [x, y]);
            prop_assert_eq!((field.width(), field.height()), (width, height));
            prop_assert!(field.as_slice().iter().all(|&h| 0.0 < h && h < 1.0));
        }
    }
}
