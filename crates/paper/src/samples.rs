//! The fixed lattice of points at which heights are evaluated, and rectangles of it.

use girtin_grid::noise::Samples;

/// Points per mm of the finest lattice that heights are taken from.
///
/// A cell's height is the mean over a whole number of points each way. At 16, 8, 4, 2 and 1 cells per mm
/// these are the *same* points, so that a sheet made at 4 cells per mm equals one made at 8 and reduced, to
/// rounding (`sheet::tests::resolutions_agree`). It bounds the detail, too: grain down to 0.125 mm.
pub(crate) const POINTS_PER_MM: f64 = 16.0;

/// Points each way in a cell, at most; below a quarter of a cell per mm the points lie farther apart.
const MOST_POINTS: f64 = 64.0;

/// Points each way in a cell of a raster with that many cells per mm.
pub(crate) fn points_in_cell(cells_per_mm: f64) -> usize {
    // The tolerance keeps 16 / 3.2 = 5.000000001 from becoming 6.
    libm::ceil(POINTS_PER_MM / cells_per_mm - 1e-6).clamp(1.0, MOST_POINTS) as usize
}

/// Equally spaced points on one axis; point `j` is at `(first + j + 1/2) / per_mm` mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// Number of the first point, counted from 0 mm.
    pub first: f64,
    pub per_mm: f64,
    pub count: usize,
}

impl Axis {
    pub fn mm(&self, j: usize) -> f64 {
        (self.first + j as f64 + 0.5) / self.per_mm
    }

    pub fn start_mm(&self) -> f64 {
        self.mm(0)
    }

    pub fn end_mm(&self) -> f64 {
        self.mm(self.count.saturating_sub(1))
    }

    /// The points whose positions are within `low..=high` mm, and perhaps one more at each end.
    pub fn within(&self, low: f64, high: f64) -> core::ops::Range<usize> {
        let number = |mm: f64| libm::floor(mm * self.per_mm - 0.5 - self.first);
        let start = number(low).clamp(0.0, self.count as f64) as usize;
        let end = (number(high) + 2.0).clamp(start as f64, self.count as f64) as usize;
        start..end
    }

    /// The same points in units of `spacing_mm`.
    pub fn in_units(&self, spacing_mm: f64, offset: f64) -> Samples {
        let step = 1.0 / (self.per_mm * spacing_mm);
        Samples { first: self.first, step, offset: offset + 0.5 * step }
    }
}

/// A rectangle of points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub x: Axis,
    pub y: Axis,
}

/// What a layer needs to know beside its parameters: the seed, and the size of the tile if the sheet is one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
    pub seed: u64,
    pub tile_mm: Option<[f64; 2]>,
}

/// A lattice in mm: the wanted spacing, or the nearest that divides the tile, and then how often it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    pub spacing_mm: [f64; 2],
    pub period: Option<[u32; 2]>,
}

impl Ground {
    pub fn lattice(&self, spacing_mm: [f64; 2]) -> Lattice {
        self.lattice_of_multiples(spacing_mm, [1, 1])
    }

    /// A lattice whose periods are multiples of `of`.
    pub fn lattice_of_multiples(&self, spacing_mm: [f64; 2], of: [u32; 2]) -> Lattice {
        let Some(tile) = self.tile_mm else { return Lattice { spacing_mm, period: None } };
        let mut lattice = Lattice { spacing_mm, period: Some([1, 1]) };
        let mut period = [1; 2];
        for axis in 0..2 {
            let cells = libm::round(tile[axis] / (spacing_mm[axis] * f64::from(of[axis])));
            period[axis] = (cells.clamp(1.0, f64::from(1 << 24)) as u32) * of[axis];
            lattice.spacing_mm[axis] = tile[axis] / f64::from(period[axis]);
        }
        lattice.period = Some(period);
        lattice
    }

    /// Noise of one stage of one layer on a lattice.
    pub fn noise(&self, stage: u64, layer: usize, lattice: &Lattice) -> girtin_grid::noise::Noise {
        let noise = girtin_grid::noise::Noise::new(self.seed, girtin_grid::random::fold(stage, layer as u64));
        match lattice.period {
            Some(period) => noise.tiled(period),
            None => noise,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_resolutions_share_their_points() {
        for (cells_per_mm, points) in
            [(16.0, 1), (8.0, 2), (4.0, 4), (2.0, 8), (1.0, 16), (3.2, 5), (32.0, 1)]
        {
            assert_eq!(points_in_cell(cells_per_mm), points);
        }
        assert_eq!(points_in_cell(1e-9), 64);
    }

    #[test]
    fn a_tile_holds_whole_lattice_cells() {
        let ground = Ground { seed: 0, tile_mm: Some([10.0, 0.1]) };
        let lattice = ground.lattice_of_multiples([0.97, 3.0], [2, 1]);
        assert_eq!(lattice, Lattice { spacing_mm: [1.0, 0.1], period: Some([10, 1]) });
    }

    #[test]
    fn points_within_bounds_are_found() {
        let axis = Axis { first: -20.0, per_mm: 16.0, count: 40 };
        let range = axis.within(0.0, 0.5);
        for j in 0..40 {
            let mm = axis.mm(j);
            assert!(!(0.0..=0.5).contains(&mm) || range.contains(&j), "point {j} at {mm}");
        }
        assert!(range.len() <= 10);
        assert!(axis.within(50.0, 60.0).is_empty());
        assert!(axis.within(-60.0, -50.0).is_empty());
    }
}
