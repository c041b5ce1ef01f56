//! Patches gathered into regions, a matte each.
//!
//! Curtis et al. 1997 had their mattes made by hand in a paint program, §6.2; these are made from the picture alone.
//! In the order data flows:
//! - [`merge`]: neighbouring patches become regions, the most alike first;
//! - [`mod@color_name`], [`mod@place_name`]: words for a region's color and for where it lies;
//! - [`soften`]: regions of a reduced picture become mattes of the whole one, with edges that follow its colors.

use girtin_grid::Raster;
use girtin_optics::{Lab, LinearRgb};
use girtin_params::parameters;
use rayon::prelude::*;

use crate::superpixels::{LabPixel, SuperpixelConfig, superpixels};

pub mod merge;
pub mod color_name;
pub mod place_name;
pub mod soften;

use color_name::color_name;
use merge::merge;
use place_name::place_name;
use soften::{coverage, reduced};

/// A region of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Matte {
    /// Name; that of its file without the ending.
    pub name: String,
    /// How much of each pixel it covers, 0 to 1.
    pub coverage: Raster<f32>,
}

parameters! {
    /// The parameters of automatic mattes.
    pub struct MattesParams {
        regions: u32 {
            symbol: "", label: "Regions", unit: "1", default: 12, hard: (1.0, 200.0), soft: (2.0, 30.0),
            acts: Simulation, doc: "How many mattes at most. Fewer are made where the picture has fewer things to tell apart.", source: "custom",
        }
        min_share: f64 {
            symbol: "", label: "Least share", unit: "of the picture", default: 0.005, hard: (0.0, 1.0), soft: (0.0, 0.05),
            acts: Simulation, doc: "A smaller region joins the neighbour that is most like it.", source: "custom",
        }
        min_difference: f64 {
            symbol: "", label: "Least difference", unit: "ΔE", default: 8.0, hard: (0.0, 200.0), soft: (2.0, 30.0),
            acts: Simulation, doc: "Regions that differ less are one.", source: "custom",
        }
        edge_weight: f64 {
            symbol: "", label: "Edges", unit: "1", default: 0.5, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much the contrast along the border counts, as against the color of the whole. More keeps a sky together that pales to the horizon.", source: "custom",
        }
        lightness_weight: f64 {
            symbol: "", label: "Lightness", unit: "1", default: 0.6, hard: (0.0, 2.0), soft: (0.2, 1.0),
            acts: Simulation, doc: "How much a difference of lightness counts. Less keeps light and shade of a thing together.", source: "custom",
        }
        size_power: f64 {
            symbol: "", label: "Size", unit: "1", default: 0.4, hard: (0.0, 1.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "How much sooner small regions join than large ones.", source: "custom; 1/2 is Ward's rule",
        }
        superpixels: u32 {
            symbol: "", label: "Patches", unit: "1", default: 1500, hard: (1.0, 100000.0), soft: (300.0, 5000.0),
            acts: Simulation, doc: "Of how many patches regions are made. More follow finer outlines.", source: "custom",
        }
        compactness: f64 {
            symbol: "m", label: "Compactness", unit: "ΔE", default: 5.0, hard: (0.0, 200.0), soft: (1.0, 40.0),
            acts: Simulation, doc: "How much patches keep together rather than to one color. Less follows outlines more closely.", source: "Achanta et al. 2012; value custom",
        }
        iterations: u32 {
            symbol: "", label: "Iterations", unit: "1", default: 10, hard: (1.0, 100.0), soft: (4.0, 20.0),
            acts: Simulation, doc: "How often patches and colors are fitted to each other.", source: "Achanta et al. 2012",
        }
        plan_edge: u32 {
            symbol: "", label: "Long edge", unit: "pixels", default: 1000, hard: (16.0, 8000.0), soft: (400.0, 2000.0),
            acts: Simulation, doc: "Regions are found in a picture reduced to this, and their edges fitted to the whole one.", source: "custom",
        }
        edge_color: f64 {
            symbol: "", label: "Edge color", unit: "ΔE", default: 8.0, hard: (0.1, 200.0), soft: (2.0, 30.0),
            acts: Simulation, doc: "How near in color a pixel must be to belong to a region beside it. More makes softer edges.", source: "Kopf et al. 2007; value custom",
        }
    }
}

/// Regions of a picture, from which its mattes are made one by one: all at once are large.
#[derive(Clone, Debug)]
pub struct MattePlan {
    names: Vec<String>,
    /// Region of each pixel of the reduced picture.
    regions: Raster<u32>,
    /// Its colors.
    colors: Raster<LabPixel>,
    edge_color: f64,
}

impl MattePlan {
    /// Finds the regions of a picture, largest first.
    ///
    /// # Cost
    /// One pass over the picture; all else at the size of the plan.
    pub fn new(picture: &Raster<LinearRgb>, params: &MattesParams) -> Self {
        let small = reduced(picture, params.plan_edge as usize);
        let labs: Vec<LabPixel> = small.as_slice().par_iter().map(|color| lab_pixel(*color)).collect();
        let colors = Raster::from_vec(small.width(), small.height(), labs)
            .unwrap_or_else(|| Raster::new(small.width(), small.height(), [0.0; 3]));
        let weighted = colors.map(|[l, a, b]| [l * params.lightness_weight as f32, a, b]);
        let config = SuperpixelConfig {
            count: params.superpixels,
            compactness: params.compactness,
            iterations: params.iterations,
        };
        let patches = superpixels(&weighted, &config);
        let (regions, count) = merge(&weighted, &patches, params);
        let (regions, means) = by_area(&regions, count, &colors);
        let names = means
            .iter()
            .enumerate()
            .map(|(at, mean)| format!("{:02}-{}-{}", at + 1, place_name(mean.place), color_name(mean.color)));
        Self { names: names.collect(), regions, colors, edge_color: params.edge_color }
    }

    /// Names of the mattes: their order by area, and words for where they lie and for their color, `03-top-dark-blue`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// One matte at the size of the picture the plan was made from.
    ///
    /// # Panics
    /// There is no such region.
    pub fn matte(&self, picture: &Raster<LinearRgb>, region: usize) -> Matte {
        let coverage = coverage(picture, &self.colors, &self.regions, region as u32, self.edge_color);
        Matte { name: self.names[region].clone(), coverage }
    }
}

/// Finds the regions of a picture and makes a matte of each, largest first.
///
/// # Guarantees
/// Coverages add up to 1 in every pixel to rounding (`mattes_add_up_to_one`); the same for any number of threads.
///
/// # Cost
/// Four bytes a pixel and matte; [`MattePlan`] makes them one by one.
pub fn mattes(picture: &Raster<LinearRgb>, params: &MattesParams) -> Vec<Matte> {
    let plan = MattePlan::new(picture, params);
    (0..plan.names.len()).map(|region| plan.matte(picture, region)).collect()
}

/// A color that is compared; what is no number counts as black.
fn lab_pixel(color: LinearRgb) -> LabPixel {
    let sane = LinearRgb(color.0.map(|channel| if channel > 0.0 { channel.min(1.0) } else { 0.0 }));
    let Lab { l, a, b } = sane.to_lab();
    [l as f32, a as f32, b as f32]
}

/// Means over a region.
struct Means {
    color: Lab,
    /// Parts of the picture's width and height.
    place: [f64; 2],
}

/// Regions numbered by falling area, of equals the first in reading order, and the means of each.
fn by_area(regions: &Raster<u32>, count: usize, colors: &Raster<LabPixel>) -> (Raster<u32>, Vec<Means>) {
    let (width, height) = (regions.width(), regions.height());
    let mut sums = vec![([0.0f64; 3], 0u64); count];
    let mut places = vec![[0u64; 2]; count];
    for (at, (&region, color)) in regions.as_slice().iter().zip(colors.as_slice()).enumerate() {
        let (sum, pixels) = &mut sums[region as usize];
        sum.iter_mut().zip(color).for_each(|(sum, &channel)| *sum += f64::from(channel));
        *pixels += 1;
        let place = &mut places[region as usize];
        place.iter_mut().zip([at % width, at / width]).for_each(|(sum, at)| *sum += at as u64);
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&region| std::cmp::Reverse(sums[region].1));
    let mut rank = vec![0; count];
    order.iter().enumerate().for_each(|(at, &region)| rank[region] = at as u32);
    let mean = |&region: &usize| {
        let (sum, pixels) = sums[region];
        let pixels = pixels.max(1) as f64;
        let [l, a, b] = sum.map(|sum| sum / pixels);
        let [x, y] = places[region].map(|sum| sum as f64 / pixels + 0.5);
        Means { color: Lab { l, a, b }, place: [x / width as f64, y / height as f64] }
    };
    (regions.map(|region| rank[region as usize]), order.iter().map(mean).collect())
}

#[cfg(test)]
mod tests;
