//! How much water the paper holds.

use girtin_grid::Raster;

/// Fluid-holding capacity from height: c = h·(c_max − c_min) + c_min.
///
/// # Source
/// Curtis et al. 1997, §4.1.
pub fn capacity(height: &Raster<f32>, c_min: f32, c_max: f32) -> Raster<f32> {
    height.map(|h| h * (c_max - c_min) + c_min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capacity_runs_from_least_to_most() {
        let height = Raster::from_vec(3, 1, vec![0.0, 0.5, 1.0]).unwrap();
        assert_eq!(capacity(&height, 0.25, 0.75).as_slice(), &[0.25, 0.5, 0.75]);
        assert_eq!(capacity(&height, 0.5, 0.5).as_slice(), &[0.5; 3]);
    }
}
