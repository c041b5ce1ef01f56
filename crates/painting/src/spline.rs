//! Cells seen smoothly from between them: a uniform cubic B-spline.

use girtin_grid::Raster;

/// A cell with the one before it and the two after it.
pub(crate) fn around(at: usize, of: usize) -> [usize; 4] {
    [at.saturating_sub(1), at, (at + 1).min(of - 1), (at + 2).min(of - 1)]
}

/// Weights of four cells, `part` between the second and the third of them.
pub(crate) fn spline(part: f32) -> [f32; 4] {
    let (t, u) = (part, 1.0 - part);
    let inner = |t: f32| (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
    [u * u * u / 6.0, inner(t), inner(u), t * t * t / 6.0]
}

/// The four rows of cells around a row of samples, and how much it takes of each.
pub(crate) struct Blend {
    pub rows: [usize; 4],
    shares: [f32; 4],
}

impl Blend {
    /// Of a field, for a row of samples at `y`, cells.
    pub fn at(y: f32, of: usize) -> Self {
        let y = (y - 0.5).clamp(0.0, (of - 1) as f32);
        Self { rows: around(y as usize, of), shares: spline(y.fract()) }
    }

    pub fn of(&self, cells: &Raster<f32>) -> Vec<f32> {
        let [a, b, c, d] = self.rows.map(|y| cells.row(y));
        let [p, q, r, s] = self.shares;
        let columns = a.iter().zip(b).zip(c).zip(d);
        columns.map(|(((a, b), c), d)| p * a + q * b + r * c + s * d).collect()
    }
}
