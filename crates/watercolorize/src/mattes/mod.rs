//! Patches gathered into regions, a matte each.

use girtin_grid::Raster;

/// A region of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Matte {
    /// Name; that of its file without the ending.
    pub name: String,
    /// How much of each pixel it covers, 0 to 1.
    pub coverage: Raster<f32>,
}
