//! Watercolor paper: seeded height fields in millimetres.
//!
//! In the order data flows:
//! - [`recipe`]: a [`Paper`], what kind of paper it is, from TOML;
//! - [`library`]: the [`Papers`] by name, built in or the user's;
//! - [`layers`]: the values of one [`Layer`](layers::Layer) of relief (tooth, pebbles, laid lines, weave,
//!   fibers) at points of the sheet;
//! - [`sheet`]: a [`Sheet`] of paper, whose height between 0 and 1 is known at any place and resolution;
//! - [`scan`]: a [`ScannedSheet`], the same from a picture of real paper;
//! - [`capacity()`]: how much water a cell holds, from its height;
//! - [`raking_light()`]: the luminance of a sheet lit from the side, to look at it.
//!
//! ```
//! use girtin_paper::{HeightSource, Papers, RakingLight, Sheet, capacity, raking_light};
//!
//! let papers = Papers::builtin();
//! let sheet = Sheet::new(papers.get("Cold Press")?, 7);
//! // 10 mm × 5 mm of it, at 4 cells per mm.
//! let height = sheet.height_field(40, 20, 4.0, [0.0, 0.0]);
//! assert!(height.as_slice().iter().all(|&h| 0.0 < h && h < 1.0));
//! let holds = capacity(&height, 0.3, 0.9);
//! assert!(holds.at(3, 5) > 0.3);
//! let seen = raking_light(&height, 4.0, &RakingLight::default());
//! assert_eq!((seen.width(), seen.height()), (40, 20));
//! # Ok::<(), girtin_paper::UnknownPaper>(())
//! ```
#![forbid(unsafe_code)]

pub mod capacity;
pub mod layers;
pub mod library;
pub mod raking_light;
pub mod recipe;
mod samples;
pub mod scan;
pub mod sheet;

pub use capacity::capacity;
pub use library::{Papers, UnknownPaper};
pub use raking_light::{RakingLight, raking_light};
pub use recipe::Paper;
pub use scan::{ScanError, ScanOptions, ScannedSheet};
pub use sheet::Sheet;

use girtin_grid::Raster;

/// Something with a height at every place, in mm.
pub trait HeightSource {
    /// Heights, above 0 and below 1, of `width` × `height` cells; `origin_mm` is the upper left corner of the
    /// first. A cell's height is the mean over the cell.
    ///
    /// # Panics
    /// `cells_per_mm` is not a finite number above 0, or `origin_mm` is not finite.
    fn height_field(
        &self,
        width: usize,
        height: usize,
        cells_per_mm: f64,
        origin_mm: [f64; 2],
    ) -> Raster<f32>;
}

fn check_place(cells_per_mm: f64, origin_mm: [f64; 2]) {
    assert!(cells_per_mm.is_finite() && cells_per_mm > 0.0, "{cells_per_mm} cells per mm");
    assert!(origin_mm.iter().all(|mm| mm.is_finite()), "an origin at {origin_mm:?} mm");
}
