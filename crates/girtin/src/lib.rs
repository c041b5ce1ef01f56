//! Watercolor with simulated water and pigment.
//!
//! Girtin's rooms, in the order data flows:
//! - [`grid`]: fields on a raster, noise and seeded random numbers;
//! - [`params`]: what a parameter is, a row each;
//! - [`optics`]: pigments, and what color they give in layers;
//! - [`paper`]: sheets with grain, defined in millimetres;
//! - [`wash`]: water and pigment over time;
//! - [`painting`]: a document of glazes; resolved, simulated, developed into a picture; and its files;
//! - [`watercolorize`]: a photograph becomes a painting.
//!
//! # A wash by hand
//!
//! ```
//! use girtin::grid::Raster;
//! use girtin::optics::{Library, LinearRgb};
//! use girtin::painting::{composite, handling_of};
//! use girtin::paper::{HeightSource, Papers, Sheet};
//! use girtin::wash::{Patch, RunConfig, Wash, WashModel, WashState};
//!
//! // Paper: a sheet of cold press, 16 mm wide, at 4 cells a millimetre.
//! let sheet = Sheet::new(Papers::builtin().get("cold-press")?, 7);
//! let height = sheet.height_field(64, 48, 4.0, [0.0, 0.0]);
//!
//! // Water and pigment on it, for sixty steps.
//! let pigments = Library::builtin();
//! let ultramarine = pigments.get("french ultramarine")?;
//! let mut wash = Wash::new(WashState::dry(&height, 1), WashModel::default(), vec![handling_of(ultramarine)])?;
//! wash.wet(Patch { x: 8, y: 8, amounts: &Raster::new(48, 32, 1.0) });
//! wash.add_water(Patch::whole(&Raster::new(64, 48, 0.6)));
//! wash.add_pigment(0, Patch::whole(&Raster::new(64, 48, 0.5)));
//! wash.run(60, &RunConfig::default())?;
//!
//! // What it looks like on white paper.
//! let mut picture = Raster::new(64, 48, LinearRgb::WHITE);
//! composite::lay_over(wash.state(), &[ultramarine.coefficients], &mut picture);
//! let bare = picture.at(2, 2);
//! let painted = picture.at(32, 24);
//! assert_eq!(bare, LinearRgb::WHITE);
//! assert!(painted.0[2] > painted.0[0], "ultramarine is blue");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub use girtin_grid as grid;

pub use girtin_params as params;

pub use girtin_optics as optics;

pub use girtin_paper as paper;

pub use girtin_wash as wash;

pub use girtin_painting as painting;

pub use girtin_watercolorize as watercolorize;
