//! Fields on a raster: what every other room of Girtin stands on.
//!
//! In the order data flows:
//! - [`memory`]: whether there is room for what is about to be allocated;
//! - [`random`]: numbers that are a function of (seed, stage, place);
//! - [`noise`]: gradient noise, fractal sums and cellular noise over the plane, tileable at will;
//! - [`raster`]: a plain rectangle of values, the currency between crates;
//! - [`aligned`]: values that begin where a cache line begins;
//! - [`field`]: a raster with a dry border, laid out for row kernels;
//! - [`blur`]: Gaussian weights; blurs of rasters, and blurs that walls stop;
//! - [`morphology`]: the most and the least around each cell;
//! - [`distance`]: how far each cell is from the edge of a shape;
//! - [`resize`]: the same raster with more or fewer cells.
#![forbid(unsafe_code)]

pub mod memory;
pub mod random;
pub mod noise;
pub mod raster;
pub mod aligned;
pub mod field;
pub mod blur;
pub mod morphology;
pub mod distance;
pub mod resize;

pub use aligned::Aligned;
pub use field::{Field, Layout};
pub use raster::Raster;
