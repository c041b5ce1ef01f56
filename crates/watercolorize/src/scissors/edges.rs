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
    /// Edges of a color picture, as a screen shows it. `smoothing`: standard deviation, pixels.
    pub fn of_color(picture: &Raster<LinearRgb>, smoothing: f64) -> Self {
        let channel = |channel: usize| picture.map(|color| encode_srgb(color.0[channel]) as f32);
        Self::of_channels(&[channel(0), channel(1), channel(2)], smoothing)
    }

    /// Edges of a grey picture.
    pub fn of_grey(picture: &Raster<f32>, smoothing: f64) -> Self {
        Self::of_channels(std::slice::from_ref(picture), smoothing)
    }

    fn of_channels(channels: &[Raster<f32>], smoothing: f64) -> Self {
        let (width, height) = channels.first().map_or((0, 0), |channel| (channel.width(), channel.height()));
        let nothing = Edge { gradient: [0.0; 2], square: 0.0, is_crossing: false };
        let mut strongest = Raster::new(width, height, nothing);
        for channel in channels {
            let channel =
                smoothed(&channel.map(|value| if value.is_finite() { value } else { 0.0 }), smoothing);
            let laplacian = laplacian_of(&channel);
            strongest.as_mut_slice().par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
                for (x, kept) in row.iter_mut().enumerate() {
                    let [dx, dy] = gradient_at(&channel, x, y);
                    let square = dx * dx + dy * dy;
                    if square > kept.square {
                        let is_crossing = is_crossing(&laplacian, x, y);
                        *kept = Edge { gradient: [dx, dy], square, is_crossing };
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

/// The value at a place that may lie one beyond the border, which is continued outward.
fn at(raster: &Raster<f32>, x: usize, y: usize, dx: isize, dy: isize) -> f32 {
    let clamp = |at: usize, by: isize, end: usize| at.saturating_add_signed(by).min(end - 1);
    raster.row(clamp(y, dy, raster.height()))[clamp(x, dx, raster.width())]
}

/// Sobel's gradient: its direction is nearer to the truth than that of plain differences.
fn gradient_at(raster: &Raster<f32>, x: usize, y: usize) -> [f32; 2] {
    let at = |dx, dy| at(raster, x, y, dx, dy);
    let side = |d: isize| at(d, -1) + 2.0 * at(d, 0) + at(d, 1);
    let level = |d: isize| at(-1, d) + 2.0 * at(0, d) + at(1, d);
    [(side(1) - side(-1)) / 8.0, (level(1) - level(-1)) / 8.0]
}

fn laplacian_of(raster: &Raster<f32>) -> Raster<f32> {
    Raster::from_fn(raster.width(), raster.height(), |x, y| {
        let at = |dx, dy| at(raster, x, y, dx, dy);
        at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1) - 4.0 * at(0, 0)
    })
}

/// Whether the Laplacian is 0 here, or changes its sign toward a neighbour that is farther from 0.
fn is_crossing(laplacian: &Raster<f32>, x: usize, y: usize) -> bool {
    let here = laplacian.at(x, y);
    let neighbours = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    here == 0.0
        || neighbours.into_iter().any(|(dx, dy)| {
            let there = at(laplacian, x, y, dx, dy);
            // Of two equals the left or upper one: an edge is one pixel wide.
            let is_nearer = here.abs() < there.abs() || (here.abs() == there.abs() && dx + dy > 0);
            here * there < 0.0 && is_nearer
        })
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
        let row = raster.row(y);
        for (x, out) in out.iter_mut().enumerate() {
            let tap = |tap: usize| row[(x + tap).saturating_sub(radius).min(width - 1)];
            *out = weights.iter().enumerate().map(|(at, weight)| weight * tap(at)).sum();
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
