//! A sheet to paint a living wash on at any scale, with shapes in millimetres, and measures of what dried on it.

use girtin::grid::Raster;
use girtin::optics::Library;
use girtin::painting::handling_of;
use girtin::paper::{HeightSource, Papers, Sheet};
use girtin::wash::{Ledger, Patch, RunConfig, Wash, WashModel, WashState};

/// A wash on cold-press paper, `scale` times as fine as the reference of 4 cells a millimetre.
pub struct Easel {
    pub wash: Wash,
    pub scale: usize,
    pub height: Raster<f32>,
}

/// Water tapers over half a millimetre inside a mark.
fn taper(depth_mm: f64) -> f64 {
    let t = (depth_mm / 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Easel {
    pub fn new(seed: u64, scale: usize, size_mm: [usize; 2], pigments: &[&str]) -> Self {
        let sheet = Sheet::new(Papers::builtin().get("cold-press").unwrap(), seed);
        let [width, height] = size_mm.map(|side| side * 4 * scale);
        let height = sheet.height_field(width, height, (4 * scale) as f64, [0.0, 0.0]);
        let mut state = WashState::dry(&height, pigments.len());
        state.ledger = Some(Ledger::new((4 * scale) as f64));
        let library = Library::builtin();
        let handlings = pigments.iter().map(|name| handling_of(library.get(name).unwrap())).collect();
        let wash = Wash::new(state, WashModel::living(), handlings).unwrap();
        Self { wash, scale, height }
    }

    pub fn cells_per_mm(&self) -> f64 {
        (4 * self.scale) as f64
    }

    /// An amount for every cell, from its place in millimetres from the middle.
    pub fn map(&self, amount: impl Fn(f64, f64) -> f64) -> Raster<f32> {
        let (width, height) = (self.height.width(), self.height.height());
        let mm = |cell: usize, cells: usize| (cell as f64 + 0.5 - 0.5 * cells as f64) / self.cells_per_mm();
        Raster::from_fn(width, height, |x, y| amount(mm(x, width), mm(y, height)) as f32)
    }

    /// Moistens the whole sheet with so many pore volumes.
    pub fn moisten(&mut self, pore_volumes: f64) {
        let everywhere = self.map(|_, _| pore_volumes);
        self.wash.moisten(Patch::whole(&everywhere));
    }

    /// A mark: `depth` is how far inside it a place lies, millimetres; water tapers there, pigment does not.
    pub fn mark(&mut self, depth: impl Fn(f64, f64) -> f64, film: f64, pigments: &[f64]) {
        let inside = self.map(|x, y| f64::from(u8::from(depth(x, y) > 0.0)));
        self.wash.wet(Patch::whole(&inside));
        let water = self.map(|x, y| film * taper(depth(x, y)));
        self.wash.add_water(Patch::whole(&water));
        for (pigment, &amount) in pigments.iter().enumerate() {
            self.wash.add_pigment(pigment, Patch::whole(&inside.map(|inside| inside * amount as f32)));
        }
    }

    /// A brush stroke.
    pub fn stroke(&mut self, stroke: Stroke) {
        self.mark(|x, y| stroke.depth(x, y), 0.7, &[0.45]);
    }

    pub fn run(&mut self, steps: u64) {
        self.wash.run(steps, &RunConfig { threads: 1, ..RunConfig::default() }).unwrap();
    }

    /// Runs until no film is left; returns the steps that took, to five.
    pub fn run_until_dry(&mut self, most: u64) -> Option<u64> {
        let is_wet = |wash: &Wash| {
            let mask = &wash.state().wet_mask;
            (0..mask.layout().height()).any(|y| mask.cells(y).contains(&1))
        };
        let mut steps = 0;
        while is_wet(&self.wash) {
            if steps >= most {
                return None;
            }
            self.run(5);
            steps += 5;
        }
        Some(steps)
    }

    /// All pigment of each cell, in the water and on the paper.
    pub fn amount(&self) -> Raster<f64> {
        let state = self.wash.state();
        let fields = || state.suspended.iter().chain(&state.deposited);
        Raster::from_fn(self.height.width(), self.height.height(), |x, y| {
            fields().map(|field| f64::from(field.cells(y)[x])).sum()
        })
    }
}

/// A stroke along the middle of the sheet with round ends, millimetres.
#[derive(Clone, Copy)]
pub struct Stroke {
    pub straight: f64,
    pub thickness: f64,
}

impl Stroke {
    /// How far inside it a place lies.
    pub fn depth(self, x: f64, y: f64) -> f64 {
        0.5 * self.thickness - (x.abs() - 0.5 * self.straight).max(0.0).hypot(y)
    }
}

pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, n), value| (sum + value, n + 1));
    sum / count as f64
}

/// Blurs by a Gaussian, deviations in cells along and across rows; beyond its edges the raster is mirrored.
pub fn blurred(raster: &Raster<f64>, [across, along]: [f64; 2]) -> Raster<f64> {
    let (width, height) = (raster.width(), raster.height());
    let weights = |sigma: f64| -> Vec<f64> {
        let reach = (4.0 * sigma).round() as i64;
        let weight = |d: i64| if d == 0 { 1.0 } else { (-0.5 * (d as f64 / sigma).powi(2)).exp() };
        let total: f64 = (-reach..=reach).map(weight).sum();
        (-reach..=reach).map(|d| weight(d) / total).collect()
    };
    let mirrored = |at: i64, count: usize| {
        let at = at.rem_euclid(2 * count as i64) as usize;
        at.min(2 * count - 1 - at)
    };
    let taps = |weights: &[f64], at: usize, count: usize, value: &dyn Fn(usize) -> f64| -> f64 {
        let first = at as i64 - (weights.len() / 2) as i64;
        weights.iter().zip(first..).map(|(weight, at)| weight * value(mirrored(at, count))).sum()
    };
    let weights = [weights(across), weights(along)];
    let rows = Raster::from_fn(width, height, |x, y| taps(&weights[0], x, width, &|x| raster.at(x, y)));
    Raster::from_fn(width, height, |x, y| taps(&weights[1], y, height, &|y| rows.at(x, y)))
}

/// How far each cell is from the nearest one that is not inside, cells; beyond the edges nothing is inside.
///
/// # Source
/// Felzenszwalb, Huttenlocher 2012, *Distance Transforms of Sampled Functions*, along columns by counting.
pub fn depth(inside: &Raster<bool>) -> Raster<f64> {
    let (width, height) = (inside.width(), inside.height());
    let mut upright = Raster::new(width, height, 0.0f64);
    for x in 0..width {
        let mut count = 0.0f64;
        for y in 0..height {
            count = if inside.at(x, y) { count + 1.0 } else { 0.0 };
            upright.row_mut(y)[x] = count;
        }
        count = 0.0;
        for y in (0..height).rev() {
            count = if inside.at(x, y) { count + 1.0 } else { 0.0 };
            upright.row_mut(y)[x] = upright.at(x, y).min(count);
        }
    }
    Raster::from_fn(width, height, |x, y| {
        // No farther sideways than the nearest that is known.
        let mut nearest = upright.at(x, y);
        let mut sideways = 1;
        while (sideways as f64) < nearest {
            let ends = [x.checked_sub(sideways), Some(x + sideways).filter(|&x| x < width)];
            for end in ends {
                let there = end.map_or(0.0, |x| upright.at(x, y));
                nearest = nearest.min((sideways as f64).hypot(there));
            }
            sideways += 1;
        }
        nearest
    })
}
