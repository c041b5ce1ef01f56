//! What of a picture looks like an outline.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_weights;
use girtin_optics::LinearRgb;
use girtin_optics::color::encode_srgb;
use rayon::prelude::*;

/// Gradients below this part of the strongest are rounding, not edges.
const LEAST: f32 = 1e-4;

/// Edges of a picture: f_Z, f_G and what f_D is made of.
///
/// # Source
/// Mortensen and Barrett 1995, §2.
///
/// # Deviations
/// Of several channels the one with the strongest gradient counts, pixel by pixel. A flat place, whose Laplacian is 0 as
/// well, is no crossing.
#[derive(Clone, Debug)]
pub struct Edges {
    /// Whether the Laplacian crosses 0 here.
    crossing: Raster<bool>,
    /// Strength of the gradient, 0 to 1.
    magnitude: Raster<f32>,
    /// Unit vector along the edge; 0 where there is none.
    tangent: Raster<[f32; 2]>,
}

/// One channel's edges at a pixel.
#[derive(Clone, Copy)]
struct Edge {
    gradient: [f32; 2],
    square: f32,
    is_crossing: bool,
}

impl Edges {
    /// Edges of a color picture, as a screen shows it.
    ///
    /// # Shapes and units
    /// `smoothing`: standard deviation, pixels.
    pub fn of_color(picture: &Raster<LinearRgb>, smoothing: f64) -> Self {
        let curve = Curve::new();
        let channel = |channel: usize| {
            by_rows(picture, |row, out| {
                out.iter_mut().zip(row).for_each(|(out, color)| *out = curve.encode(color.0[channel]));
            })
        };
        Self::of_channels([0, 1, 2].into_iter().map(channel), [picture.width(), picture.height()], smoothing)
    }

    /// Edges of a grey picture.
    pub fn of_grey(picture: &Raster<f32>, smoothing: f64) -> Self {
        Self::of_channels([picture.clone()], [picture.width(), picture.height()], smoothing)
    }

    fn of_channels(
        channels: impl IntoIterator<Item = Raster<f32>>,
        [width, height]: [usize; 2],
        smoothing: f64,
    ) -> Self {
        let nothing = Edge { gradient: [0.0; 2], square: 0.0, is_crossing: false };
        let mut strongest = Raster::new(width, height, nothing);
        for mut channel in channels {
            channel
                .as_mut_slice()
                .iter_mut()
                .filter(|value| !value.is_finite())
                .for_each(|value| *value = 0.0);
            let channel = smoothed(&channel, smoothing);
            let laplacian = laplacian_of(&channel);
            strongest.as_mut_slice().par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
                let (around, bends) = (Neighbours::new(&channel, y), Neighbours::new(&laplacian, y));
                for (x, kept) in row.iter_mut().enumerate() {
                    let gradient = around.gradient(x);
                    let square = gradient[0] * gradient[0] + gradient[1] * gradient[1];
                    if square > kept.square {
                        *kept = Edge { gradient, square, is_crossing: bends.is_crossing(x) };
                    }
                }
            });
        }
        let most = strongest.as_slice().iter().fold(0.0f32, |most, edge| most.max(edge.square)).sqrt();
        let strength = |edge: Edge| if most > 0.0 { edge.square.sqrt() / most } else { 0.0 };
        Self {
            crossing: strongest.map(|edge| edge.is_crossing && strength(edge) > LEAST),
            magnitude: strongest.map(strength),
            tangent: strongest.map(|edge| {
                let [dx, dy] = edge.gradient;
                let length = edge.square.sqrt();
                if strength(edge) > LEAST { [dy / length, -dx / length] } else { [0.0; 2] }
            }),
        }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.magnitude.width()
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.magnitude.height()
    }

    /// Whether there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.magnitude.as_slice().is_empty()
    }

    /// f_Z: 0 on a zero crossing of the Laplacian, else 1.
    pub(super) fn crossing_cost(&self, pixel: usize) -> f32 {
        f32::from(u8::from(!self.crossing.as_slice()[pixel]))
    }

    /// Strength of the gradient, 0 to 1; f_G is what it lacks to 1.
    pub(super) fn magnitude(&self, pixel: usize) -> f32 {
        self.magnitude.as_slice()[pixel]
    }

    /// D′: the unit vector across the gradient.
    pub(super) fn tangent(&self, pixel: usize) -> [f32; 2] {
        self.tangent.as_slice()[pixel]
    }

    /// The strongest edge within a radius of a point inside the picture; of equals the nearest, then the first.
    pub(super) fn strongest_near(&self, [x, y]: [usize; 2], radius: usize) -> [usize; 2] {
        if self.is_empty() {
            return [x, y];
        }
        let mut best = ([x, y], self.magnitude.at(x, y), 0);
        for row in y.saturating_sub(radius)..(y + radius + 1).min(self.height()) {
            for column in x.saturating_sub(radius)..(x + radius + 1).min(self.width()) {
                let square = column.abs_diff(x).pow(2) + row.abs_diff(y).pow(2);
                let strength = self.magnitude.at(column, row);
                let is_better = strength > best.1 || (strength == best.1 && square < best.2);
                if square <= radius * radius && is_better {
                    best = ([column, row], strength, square);
                }
            }
        }
        best.0
    }
}

/// sRGB's curve as a table over the root of light, along which it is nearly straight: its power would be half of the work.
///
/// The root alone will not do: it is steeper in the darks, and wires went astray along them.
struct Curve {
    encoded: Vec<f64>,
}

impl Curve {
    const STEPS: usize = 1024;

    fn new() -> Self {
        let root = |at: usize| at as f64 / Self::STEPS as f64;
        Self { encoded: (0..=Self::STEPS).map(|at| encode_srgb(root(at) * root(at))).collect() }
    }

    fn encode(&self, linear: f64) -> f32 {
        // Written so that what is no number is black.
        let root = if linear > 0.0 { linear.min(1.0).sqrt() * Self::STEPS as f64 } else { 0.0 };
        let at = (root as usize).min(Self::STEPS - 1);
        let (low, high) = (self.encoded[at], self.encoded[at + 1]);
        (low + (root - at as f64) * (high - low)) as f32
    }
}

/// A raster of the same size, made row by row.
fn by_rows<T: Copy + Sync>(raster: &Raster<T>, make: impl Fn(&[T], &mut [f32]) + Sync) -> Raster<f32> {
    let mut made = Raster::new(raster.width(), raster.height(), 0.0f32);
    let rows = made.as_mut_slice().par_chunks_mut(raster.width().max(1));
    rows.enumerate().for_each(|(y, out)| make(raster.row(y), out));
    made
}

/// A row and the two beside it; the border is continued outward.
struct Neighbours<'a> {
    above: &'a [f32],
    row: &'a [f32],
    below: &'a [f32],
}

impl<'a> Neighbours<'a> {
    fn new(raster: &'a Raster<f32>, y: usize) -> Self {
        let below = (y + 1).min(raster.height() - 1);
        Self { above: raster.row(y.saturating_sub(1)), row: raster.row(y), below: raster.row(below) }
    }

    /// The columns beside one.
    fn beside(&self, x: usize) -> (usize, usize) {
        (x.saturating_sub(1), (x + 1).min(self.row.len() - 1))
    }

    /// Sobel's gradient: its direction is nearer to the truth than that of plain differences.
    fn gradient(&self, x: usize) -> [f32; 2] {
        let (left, right) = self.beside(x);
        let side = |x: usize| self.above[x] + 2.0 * self.row[x] + self.below[x];
        let level = |row: &[f32]| row[left] + 2.0 * row[x] + row[right];
        [(side(right) - side(left)) / 8.0, (level(self.below) - level(self.above)) / 8.0]
    }

    fn laplacian(&self, x: usize) -> f32 {
        let (left, right) = self.beside(x);
        self.row[left] + self.row[right] + self.above[x] + self.below[x] - 4.0 * self.row[x]
    }

    /// Whether a Laplacian is 0 here, or changes its sign toward a neighbour that is farther from 0.
    fn is_crossing(&self, x: usize) -> bool {
        let (left, right) = self.beside(x);
        let here = self.row[x];
        // Of two equals the left or upper one: an edge is one pixel wide.
        let to = |there: f32, is_after: bool| {
            let is_nearer = here.abs() < there.abs() || (here.abs() == there.abs() && is_after);
            here * there < 0.0 && is_nearer
        };
        here == 0.0
            || to(self.row[right], true)
            || to(self.below[x], true)
            || to(self.row[left], false)
            || to(self.above[x], false)
    }
}

fn laplacian_of(raster: &Raster<f32>) -> Raster<f32> {
    let mut laplacian = Raster::new(raster.width(), raster.height(), 0.0f32);
    laplacian.as_mut_slice().par_chunks_mut(raster.width().max(1)).enumerate().for_each(|(y, out)| {
        let around = Neighbours::new(raster, y);
        out.iter_mut().enumerate().for_each(|(x, out)| *out = around.laplacian(x));
    });
    laplacian
}

/// Smoothed by a Gaussian, the border continued outward.
fn smoothed(raster: &Raster<f32>, sigma: f64) -> Raster<f32> {
    let (width, height) = (raster.width(), raster.height());
    if sigma <= 0.0 || width == 0 || height == 0 {
        return raster.clone();
    }
    let radius = (3.0 * sigma).ceil() as usize;
    let weights = gaussian_weights(sigma, radius);
    let mut along = raster.clone();
    along.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        // The row continued outward, so that no tap asks where it ends.
        let row = raster.row(y);
        let wide: Vec<f32> =
            (0..width + 2 * radius).map(|x| row[x.saturating_sub(radius).min(width - 1)]).collect();
        for (out, taps) in out.iter_mut().zip(wide.windows(weights.len())) {
            *out = weights.iter().zip(taps).map(|(weight, value)| weight * value).sum();
        }
    });
    let mut both = Raster::new(width, height, 0.0f32);
    both.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (tap, weight) in weights.iter().enumerate() {
            let row = along.row((y + tap).saturating_sub(radius).min(height - 1));
            out.iter_mut().zip(row).for_each(|(out, value)| *out += weight * value);
        }
    });
    both
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_curve() {
        let curve = Curve::new();
        for at in 0..=10_000 {
            let linear = f64::from(at) / 10_000.0;
            let off = (f64::from(curve.encode(linear)) - encode_srgb(linear)).abs();
            assert!(off < 2e-4, "{off} at {linear}");
        }
        assert_eq!((curve.encode(f64::NAN), curve.encode(-1.0), curve.encode(9.0)), (0.0, 0.0, 1.0));
    }
}
