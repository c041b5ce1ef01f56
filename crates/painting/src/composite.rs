//! Pigment becomes color: what a wash left on the paper, over what lay there before.

use girtin_grid::Raster;
use girtin_optics::kubelka_munk::glaze_row;
use girtin_optics::{Coefficients, LinearRgb};
use girtin_wash::WashState;
use rayon::prelude::*;

use crate::area::Coverage;

/// Lays a wash over a ground, in place.
///
/// Suspended and deposited pigment count alike: what is still in the water is seen as well.
///
/// # Source
/// Curtis et al. 1997, §5.2, one mixed layer over what is below; D8: in linear light.
///
/// # Panics
/// The ground has another size than the wash.
pub fn lay_over(state: &WashState, paints: &[Coefficients], ground: &mut Raster<LinearRgb>) {
    let layout = state.layout();
    assert_eq!(
        (ground.width(), ground.height()),
        (layout.width(), layout.height()),
        "sizes of wash and ground"
    );
    if layout.width() == 0 {
        return;
    }
    ground.as_mut_slice().par_chunks_mut(layout.width()).enumerate().for_each(|(y, ground)| {
        let amounts: Vec<Vec<f32>> = state
            .suspended
            .iter()
            .zip(&state.deposited)
            .map(|(g, d)| g.cells(y).iter().zip(d.cells(y)).map(|(g, d)| g + d).collect())
            .collect();
        if amounts.iter().flatten().any(|&amount| amount > 0.0) {
            let amounts: Vec<&[f32]> = amounts.iter().map(Vec::as_slice).collect();
            glaze_row(paints, &amounts, ground);
        }
    });
}

/// Covers the ground with opaque color.
pub fn print(ground: &mut Raster<LinearRgb>, color: LinearRgb, coverage: &Coverage) {
    for y in 0..coverage.amount.height() {
        let cells = &mut ground.row_mut(coverage.y + y)[coverage.x..];
        for (cell, &covered) in cells.iter_mut().zip(coverage.amount.row(y)) {
            let below = cell.0;
            *cell = LinearRgb([0, 1, 2].map(|c| below[c] + f64::from(covered) * (color.0[c] - below[c])));
        }
    }
}

/// The picture as it is shown: sRGB bytes.
pub fn encode(linear: &Raster<LinearRgb>) -> Raster<[u8; 3]> {
    let bytes: Vec<[u8; 3]> = linear.as_slice().par_iter().map(|color| color.to_srgb().to_bytes()).collect();
    Raster::from_vec(linear.width(), linear.height(), bytes)
        .unwrap_or_else(|| unreachable!("one color for each pixel"))
}
