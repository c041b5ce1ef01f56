//! Edges as a painter sees them: where a lens or a scaled picture runs from one color into another, either is chosen.
//!
//! Otherwise every silhouette has a seam of in-between colors, which becomes a thin shape of its own, a halo.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian;

use crate::masses::steps;
use crate::texture::slope;

/// Widest seam, a part of the long edge, to either side of its middle.
const REACH: f64 = 0.0045;
/// Step, Lab, from which on there is an edge.
const EDGE: f32 = 5.0;
/// Part of the step at a cell below which the seam has ended.
const ENDED: f32 = 0.30;
/// Blur before directions are taken, a part of the long edge.
const CALM: f64 = 0.0016;

/// The Lab photograph with the colors of each seam replaced by that of the nearer, in color, of its two sides.
///
/// # Source
/// Kramer and Bruckner, *Iterations of a non-linear transformation for enhancement of digital images*, 1975: the value of
/// the nearer of two extremes. Here along the slope, to the ends of the ramp.
pub fn crisp(lab: &Raster<[f32; 3]>, long_edge: f64) -> Raster<[f32; 3]> {
    let steps = steps(lab, long_edge);
    let calm = gaussian(lab, CALM * long_edge);
    let channels = [0, 1, 2].map(|c: usize| calm.map(|color| color[c]));
    let reach = (REACH * long_edge).max(2.0) as usize;
    let (width, height) = (lab.width(), lab.height());
    Raster::by_rows(width, height, |x, y| {
        let own = lab.at(x, y);
        let here = steps.at(x, y);
        if here < EDGE {
            return own;
        }
        // The direction in which colors change most.
        let [mut xx, mut xy, mut yy] = [0.0f32; 3];
        for channel in &channels {
            let [gx, gy] = slope(channel, x, y);
            xx += gx * gx;
            xy += gx * gy;
            yy += gy * gy;
        }
        let angle = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
        let (dx, dy) = (libm::cosf(angle), libm::sinf(angle));
        let end = |way: f32| {
            let mut cell = (x, y);
            let mut before = here;
            for step in 1..=reach {
                let far = way * step as f32;
                let (u, v) = (x as f32 + 0.5 + far * dx, y as f32 + 0.5 + far * dy);
                if u < 0.0 || v < 0.0 || u >= width as f32 || v >= height as f32 {
                    break;
                }
                let next = (u as usize, v as usize);
                let there = steps.at(next.0, next.1);
                // Another edge begins.
                if there > 1.05 * before && there < here {
                    break;
                }
                cell = next;
                before = there;
                if there < ENDED * here {
                    break;
                }
            }
            lab.at(cell.0, cell.1)
        };
        let [one, two] = [end(1.0), end(-1.0)];
        let apart =
            |other: [f32; 3]| -> f32 { (0..3).map(|c| (own[c] - other[c]) * (own[c] - other[c])).sum() };
        if apart(one) <= apart(two) { one } else { two }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp from dark to light, so many cells wide, across 400.
    fn ramp(wide: f32) -> Raster<[f32; 3]> {
        Raster::from_fn(400, 60, |x, _| {
            let part = ((x as f32 - 200.0) / wide + 0.5).clamp(0.0, 1.0);
            [20.0 + 60.0 * part, 0.0, 30.0 * part]
        })
    }

    #[test]
    fn a_seam_becomes_an_edge() {
        for wide in [3.0, 5.0, 8.0] {
            let crisp = crisp(&ramp(wide), 1000.0);
            let between = (0..400).filter(|&x| (26.0..74.0).contains(&crisp.at(x, 30)[0])).count();
            assert!(between <= 1, "{wide}: {between}");
            assert!(crisp.at(190, 30)[0] < 30.0 && crisp.at(210, 30)[0] > 70.0);
        }
    }

    #[test]
    fn a_thin_line_and_a_gradient_stay() {
        let line =
            Raster::from_fn(200, 60, |x, _| [if (99..102).contains(&x) { 20.0 } else { 80.0 }, 0.0, 0.0]);
        let drawn = crisp(&line, 1000.0);
        assert!(drawn.at(100, 30)[0] < 25.0 && drawn.at(90, 30)[0] > 75.0);
        let gradient = Raster::from_fn(200, 60, |x, _| [20.0 + 0.3 * x as f32, 0.0, 0.0]);
        assert_eq!(crisp(&gradient, 1000.0), gradient);
    }
}
