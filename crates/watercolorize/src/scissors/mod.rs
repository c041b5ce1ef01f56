//! A matte cut out by hand, along the outlines of the picture.
//!
//! A seed is set on an outline, and wherever the pointer goes, the wire from the seed to it lies along the cheapest path,
//! which is one along edges. Mortensen and Barrett's *Intelligent Scissors for Image Composition*, SIGGRAPH 1995, by which
//! Curtis et al. 1997, §6.1, select regions; [`training`] and [`cooling`] are of the same paper.
//!
//! In the order data flows:
//! - [`edges`]: what of a picture looks like an outline;
//! - [`training`]: more of the same outline;
//! - [`live_wire`]: cheapest paths from a seed;
//! - [`cooling`]: a part of the wire that has not moved for a while becomes fast;
//! - [`outline`]: a closed path becomes a matte.
//!
//! ```
//! use girtin_grid::Raster;
//! use girtin_watercolorize::scissors::{Scissors, ScissorsParams, outline};
//!
//! let disc = Raster::from_fn(60, 60, |x, y| if (x as f32 - 30.0).hypot(y as f32 - 30.0) < 20.0 { 1.0 } else { 0.0 });
//! let mut scissors = Scissors::of_grey(&disc, ScissorsParams::default());
//! scissors.seed([10, 30]);
//! let wire = scissors.path_to([50, 30]);
//! assert!(wire.iter().all(|&[x, y]| ((x as f32 - 30.0).hypot(y as f32 - 30.0) - 20.0).abs() < 1.5));
//! let path = scissors.boundary(&[[10, 30], [30, 10], [50, 30], [30, 50]]);
//! let matte = outline::matte(&path, 60, 60);
//! assert_eq!((matte.at(30, 30), matte.at(2, 2)), (1.0, 0.0));
//! ```

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use girtin_params::parameters;

pub mod edges;
pub mod training;
pub mod live_wire;
pub mod cooling;
pub mod outline;

pub use cooling::Cooling;

use edges::Edges;
use live_wire::LiveWire;
use training::Training;

parameters! {
    /// The parameters of the scissors.
    pub struct ScissorsParams {
        crossing_weight: f64 {
            symbol: "ω_Z", label: "Zero crossing", unit: "1", default: 0.43, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much the wire keeps to the very middle of an edge.", source: "Mortensen and Barrett 1995",
        }
        direction_weight: f64 {
            symbol: "ω_D", label: "Direction", unit: "1", default: 0.43, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much the wire keeps to the direction of an edge.", source: "Mortensen and Barrett 1995",
        }
        magnitude_weight: f64 {
            symbol: "ω_G", label: "Contrast", unit: "1", default: 0.14, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much the wire prefers strong edges.", source: "Mortensen and Barrett 1995",
        }
        smoothing: f64 {
            symbol: "σ", label: "Smoothing", unit: "pixels", default: 1.0, hard: (0.0, 20.0), soft: (0.5, 4.0),
            acts: Simulation, doc: "Detail finer than this is no edge. It is the standard deviation of a Gaussian.", source: "custom",
        }
        training_length: u32 {
            symbol: "t", label: "Training", unit: "pixels", default: 64, hard: (1.0, 10000.0), soft: (16.0, 128.0),
            acts: Simulation, doc: "How much of the last wire says what the outline looks like.", source: "Mortensen and Barrett 1995; value custom",
        }
    }
}

/// Scissors on a picture.
#[derive(Clone, Debug)]
pub struct Scissors {
    edges: Edges,
    params: ScissorsParams,
    training: Option<Training>,
    wire: Option<LiveWire>,
}

impl Scissors {
    /// Scissors on a color picture; an edge in any channel is one.
    pub fn new(picture: &Raster<LinearRgb>, params: ScissorsParams) -> Self {
        Self { edges: Edges::of_color(picture, params.smoothing), params, training: None, wire: None }
    }

    /// Scissors on a grey picture.
    pub fn of_grey(picture: &Raster<f32>, params: ScissorsParams) -> Self {
        Self { edges: Edges::of_grey(picture, params.smoothing), params, training: None, wire: None }
    }

    /// The nearest point inside the picture.
    fn inside(&self, [x, y]: [usize; 2]) -> [usize; 2] {
        [x.min(self.edges.width().saturating_sub(1)), y.min(self.edges.height().saturating_sub(1))]
    }

    /// Sets the point that the wire comes from. A point outside the picture is the nearest one inside.
    pub fn seed(&mut self, point: [usize; 2]) {
        self.wire = Some(LiveWire::new(&self.edges, self.inside(point)));
    }

    /// The wire from the seed to a point, both included; neighbours in it touch by a side or a corner.
    ///
    /// Without a seed it is the point alone; on an empty picture it is empty.
    ///
    /// # Cost
    /// Work is kept: a point nearer than one asked for before costs nothing but its path.
    pub fn path_to(&mut self, point: [usize; 2]) -> Vec<[usize; 2]> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let point = self.inside(point);
        match &mut self.wire {
            Some(wire) => wire.path_to(&self.edges, &self.params, self.training.as_ref(), &[], point),
            None => vec![point],
        }
    }

    /// The closed path through all seeds, in their order and back to the first, which is not repeated.
    ///
    /// What has become path is avoided by what follows, so that two seeds make a loop, not a way there and back.
    pub fn boundary(&self, seeds: &[[usize; 2]]) -> Vec<[usize; 2]> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let seeds: Vec<[usize; 2]> = seeds.iter().map(|&seed| self.inside(seed)).collect();
        let mut path: Vec<[usize; 2]> = Vec::new();
        for (at, &seed) in seeds.iter().enumerate() {
            let next = seeds[(at + 1) % seeds.len()];
            let mut wire = LiveWire::new(&self.edges, seed);
            let segment = wire.path_to(&self.edges, &self.params, self.training.as_ref(), &path, next);
            let end = segment.len().saturating_sub(1).max(usize::from(seeds.len() == 1));
            path.extend(&segment[..end]);
        }
        path
    }

    /// Learns what the outline looks like from the end of a path that is right; the next seed goes by it.
    pub fn train(&mut self, path: &[[usize; 2]]) {
        self.training = Training::new(&self.edges, path, self.params.training_length as usize);
    }

    /// Forgets what was learned.
    pub fn forget(&mut self) {
        self.training = None;
    }

    /// The strongest edge within a radius of a point, pixels; of equals the nearest.
    pub fn snap(&self, point: [usize; 2], radius: usize) -> [usize; 2] {
        self.edges.strongest_near(self.inside(point), radius)
    }
}

#[cfg(test)]
mod tests;
