//! More of the same outline: how strong an edge has to be, learned from a path that is right.

use girtin_grid::blur::gaussian_weights;

use super::edges::Edges;

/// Strengths that are told apart.
const BINS: usize = 256;
/// How far a strength vouches for its neighbours, bins.
const SPREAD: f64 = 8.0;

/// What edges of each strength cost.
///
/// # Source
/// Mortensen and Barrett 1995, on-the-fly training: the histogram of what lies under the last piece of path, smoothed and
/// turned upside down, replaces the fixed cost of the gradient's magnitude; the shorter the piece, the less.
#[derive(Clone, Debug)]
pub struct Training {
    cost: Vec<f32>,
}

impl Training {
    /// Learns from the last `length` pixels of a path; nothing of an empty one.
    pub(super) fn new(edges: &Edges, path: &[[usize; 2]], length: usize) -> Option<Self> {
        let length = length.max(1);
        let recent = &path[path.len().saturating_sub(length)..];
        let pixels = recent.iter().filter(|[x, y]| *x < edges.width() && *y < edges.height());
        let mut histogram = [0.0f32; BINS];
        let mut count = 0;
        for [x, y] in pixels {
            histogram[bin(edges.magnitude(y * edges.width() + x))] += 1.0;
            count += 1;
        }
        let radius = (3.0 * SPREAD) as usize;
        let weights = gaussian_weights(SPREAD, radius);
        let smooth = |at: usize| -> f32 {
            let taps = weights.iter().enumerate();
            taps.map(|(tap, weight)| weight * histogram.get((at + tap).wrapping_sub(radius)).unwrap_or(&0.0))
                .sum()
        };
        let smooth: Vec<f32> = (0..BINS).map(smooth).collect();
        let most = smooth.iter().copied().fold(0.0, f32::max);
        let trust = count as f32 / length as f32;
        let cost = |at: usize| {
            let fixed = 1.0 - at as f32 / (BINS - 1) as f32;
            trust * (1.0 - smooth[at] / most) + (1.0 - trust) * fixed
        };
        (count > 0).then(|| Self { cost: (0..BINS).map(cost).collect() })
    }

    /// What replaces f_G.
    pub(super) fn cost(&self, magnitude: f32) -> f32 {
        self.cost[bin(magnitude)]
    }
}

fn bin(magnitude: f32) -> usize {
    ((magnitude * BINS as f32) as usize).min(BINS - 1)
}
