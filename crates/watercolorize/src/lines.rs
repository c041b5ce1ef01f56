//! Thin lines of the photograph: dark ones for ink, light ones for masking fluid.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian_plane, gaussian_weights};
use girtin_grid::morphology::{dilated, eroded};
use girtin_grid::resize::resized;

use crate::abstraction::Flow;
use crate::accidents::smoothstep;
use crate::mount::Mount;
use crate::regions::cleaned;

/// Lines a width apart from what is around them.
#[derive(Clone, Copy, Debug)]
struct Drawing {
    /// Width, a part of the long edge.
    width: f64,
    /// How far a line is followed to each side, a part of the long edge.
    reach: f64,
    /// 1 for light lines, −1 for dark ones.
    sign: f32,
}

/// Parts of the paper under ink from which on and up to which lines count as crowded.
const CROWDED: [f32; 2] = [0.08, 0.2];

/// Difference of Gaussians, averaged along the contour: long, calm lines.
///
/// # Source
/// After Kang, Lee, Chui, *Coherent Line Drawing*, 2007, contours taken for straight.
struct Contours<'a> {
    edges: Raster<f32>,
    flow: &'a Flow,
    /// Weights from the middle on to either side.
    weights: Vec<f32>,
}

impl<'a> Contours<'a> {
    fn of(lightness: &Raster<f32>, flow: &'a Flow, mount: &Mount, drawing: &Drawing) -> Self {
        let sigma = mount.cells(drawing.width);
        let (fine, wide) = (gaussian_plane(lightness, sigma), gaussian_plane(lightness, 1.6 * sigma));
        let edges = Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
            drawing.sign * (fine.at(x, y) - wide.at(x, y))
        });
        let reach = mount.cells(drawing.reach).max(1.0) as usize;
        let weight = |t: usize| libm::expf(-4.0 * (t as f32 / reach as f32) * (t as f32 / reach as f32));
        let weights: Vec<f32> = (0..=reach).map(weight).collect();
        let all = 2.0 * weights.iter().sum::<f32>() - weights[0];
        Self { edges, flow, weights: weights.into_iter().map(|weight| weight / all).collect() }
    }

    /// How clear a line a cell lies on.
    fn at(&self, x: usize, y: usize) -> f32 {
        let [along, _] = self.flow.at(x, y);
        let (cos, sin) = (libm::cosf(along), libm::sinf(along));
        let at = |t: f32| self.edges.sample(x as f32 + 0.5 + t * cos, y as f32 + 0.5 + t * sin);
        let both = |(t, weight): (usize, &f32)| weight * (at(t as f32) + at(-(t as f32)));
        self.weights[0] * at(0.0) + self.weights.iter().enumerate().skip(1).map(both).sum::<f32>()
    }
}

/// How fully each cell is covered by ink; denser where the eye rests. `lab` may be finer than the mount's cells.
pub fn ink(lab: &Raster<[f32; 3]>, mount: &Mount, attention: &Raster<f32>, strength: f32) -> Raster<f32> {
    let flow = Flow::of(lab, mount.cells(0.005));
    let drawing = Drawing { width: 0.0014, reach: 0.011, sign: -1.0 };
    let lines = Contours::of(&lab.map(|lab| lab[0]), &flow, mount, &drawing);
    let loose = |x: usize, y: usize| 1.0 - attention.at(x, y).min(1.0);
    let lines = Raster::by_rows(lab.width(), lab.height(), |x, y| {
        let loose = loose(x, y);
        smoothstep(strength * lines.at(x, y), 0.4 + 0.5 * loose, 1.2 + 0.8 * loose)
    });
    // Where lines are many, as in foliage, a pen draws some of them, thinner.
    let many = gaussian_plane(&lines, mount.cells(0.01));
    let lines = Raster::by_rows(lab.width(), lab.height(), |x, y| {
        let spared = loose(x, y) * smoothstep(many.at(x, y), CROWDED[0], CROWDED[1]);
        (lines.at(x, y) - spared).max(0.0)
    });
    let cell = mount.long_edge as f32 * mount.long_edge as f32;
    let least = attention.map(|exact| 1.6e-4 * cell * (1.6 - exact.min(1.0)));
    kept(&lines, &least)
}

/// How fully each cell is covered by masking fluid: thin light lines on something darker, such as whiskers, and points of
/// light. Never more than leaves the light its own color.
pub fn lights(lab: &Raster<[f32; 3]>, mount: &Mount, attention: &Raster<f32>) -> Raster<f32> {
    let flow = Flow::of(lab, mount.cells(0.004));
    let lightness = lab.map(|lab| lab[0]);
    let drawing = Drawing { width: 0.0013, reach: 0.016, sign: 1.0 };
    let lines = Contours::of(&lightness, &flow, mount, &drawing);
    let around = gaussian_plane(&lightness, mount.cells(0.01));
    let (calm, beside) = (gaussian_plane(&lightness, 0.7), (2.5 * mount.cells(drawing.width)) as f32);
    let lines = Raster::by_rows(lab.width(), lab.height(), |x, y| {
        let [along, clear] = flow.at(x, y);
        let lighter =
            smoothstep(lightness.at(x, y) - around.at(x, y), 2.5, 8.0) * smoothstep(clear, 0.3, 0.6);
        if lighter <= 0.0 {
            return 0.0;
        }
        // Lighter than on both sides: the light side of an edge is no line.
        let (dx, dy) = (-beside * libm::sinf(along), beside * libm::cosf(along));
        let at = |by: f32| calm.sample(x as f32 + 0.5 + by * dx, y as f32 + 0.5 + by * dy);
        let above = smoothstep(calm.at(x, y) - at(1.0).max(at(-1.0)), 1.5, 6.0);
        if above <= 0.0 {
            return 0.0;
        }
        let line = smoothstep(lines.at(x, y), 0.7, 1.8);
        line * lighter * above * (0.35 + 0.65 * smoothstep(attention.at(x, y), 0.0, 0.3))
    });
    let cell = mount.long_edge as f32 * mount.long_edge as f32;
    let lines = kept(&lines, &Raster::new(lab.width(), lab.height(), 8e-5 * cell));
    // Ends fade, and edges are the line's own.
    let lines = drawn_along(&lines, &flow, mount.cells(0.008));
    let points = points(&lightness, mount);
    Raster::by_rows(lab.width(), lab.height(), |x, y| {
        let covered = lines.at(x, y).max(points.at(x, y));
        if covered <= 0.0 {
            return 0.0;
        }
        // Between letters on white it is white anyway.
        let around = around.at(x, y);
        covered * less_paint(calm.at(x, y), around) * (1.0 - smoothstep(around, 78.0, 90.0))
    })
}

/// Points of light, each by itself: smaller than a hundredth of the long edge, and few.
fn points(lightness: &Raster<f32>, mount: &Mount) -> Raster<f32> {
    let radius = mount.cells(0.0035).max(1.0) as usize;
    let least = eroded(lightness, radius);
    let opened = dilated(&least, radius);
    let points = Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
        smoothstep(lightness.at(x, y) - opened.at(x, y), 14.0, 26.0)
    });
    // What is full of them is a texture.
    let many = gaussian_plane(&points, mount.cells(0.02));
    let points = Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
        points.at(x, y) * (1.0 - smoothstep(many.at(x, y), 0.016, 0.05))
    });
    gaussian_plane(&points, 0.6)
}

/// How much less paint lies on a light of one lightness than around it, by Beer's law.
fn less_paint(light: f32, around: f32) -> f32 {
    let density = |light: f32| {
        let root = (light.max(1.0) + 16.0) / 116.0;
        -libm::logf(root * root * root)
    };
    (1.0 - density(light.min(99.0)) / density(around.min(98.0))).max(0.0)
}

/// Lines smoothed along the way they run.
fn drawn_along(lines: &Raster<f32>, flow: &Flow, sigma: f64) -> Raster<f32> {
    let reach = libm::ceil(2.0 * sigma) as usize;
    let weights = gaussian_weights(sigma, reach);
    let near = dilated(lines, 2);
    let drawn = Raster::by_rows(lines.width(), lines.height(), |x, y| {
        if near.at(x, y) <= 0.0 {
            return 0.0;
        }
        let [along, _] = flow.at(x, y);
        let (cos, sin) = (libm::cosf(along), libm::sinf(along));
        let at = |(k, weight): (usize, &f32)| {
            let t = k as f32 - reach as f32;
            weight * lines.sample(x as f32 + 0.5 + t * cos, y as f32 + 0.5 + t * sin)
        };
        weights.iter().enumerate().map(at).sum()
    });
    gaussian_plane(&drawn, 0.6)
}

/// Lines without those of too few cells.
fn kept(lines: &Raster<f32>, least: &Raster<f32>) -> Raster<f32> {
    let there = lines.map(|line| u8::from(line > 0.3));
    let there = cleaned(&there, least, None);
    let there = gaussian_plane(&there.map(f32::from), 0.7);
    Raster::by_rows(lines.width(), lines.height(), |x, y| {
        (lines.at(x, y) * (1.6 * there.at(x, y)).min(1.0)).clamp(0.0, 1.0)
    })
}

/// A displacement of each cell, cells, by which a hand strays.
pub fn warped<const N: usize>(raster: &Raster<[f32; N]>, by: &Raster<[f32; 2]>) -> Raster<[f32; N]> {
    let (width, height) = (raster.width(), raster.height());
    let by = resized(by, width, height);
    Raster::by_rows(width, height, |x, y| {
        let [dx, dy] = by.at(x, y);
        let (px, py) =
            ((x as f32 + dx).clamp(0.0, (width - 1) as f32), (y as f32 + dy).clamp(0.0, (height - 1) as f32));
        let (x0, y0) = (px as usize, py as usize);
        let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
        let (fx, fy) = (px - x0 as f32, py - y0 as f32);
        let corners = [
            (raster.at(x0, y0), (1.0 - fx) * (1.0 - fy)),
            (raster.at(x1, y0), fx * (1.0 - fy)),
            (raster.at(x0, y1), (1.0 - fx) * fy),
            (raster.at(x1, y1), fx * fy),
        ];
        core::array::from_fn(|k| corners.iter().map(|(value, weight)| value[k] * weight).sum())
    })
}

/// The same for labels: the nearest cell's.
pub fn warped_labels<L: Copy + Send + Sync>(labels: &Raster<L>, by: &Raster<[f32; 2]>) -> Raster<L> {
    let (width, height) = (labels.width(), labels.height());
    Raster::by_rows(width, height, |x, y| {
        let [dx, dy] = by.at(x, y);
        let near =
            |at: usize, by: f32, of: usize| libm::roundf(at as f32 + by).clamp(0.0, (of - 1) as f32) as usize;
        labels.at(near(x, dx, width), near(y, dy, height))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mount::Mounting;

    /// A square photograph of Lab L, on cells half as wide as usual, and the fluid on it.
    fn fluid(light: impl Fn(usize, usize) -> f32) -> Raster<f32> {
        let mount = Mount::new([320, 320], 320.0, &Mounting { margin: 0.0, ..Mounting::default() }).finer();
        let [width, height] = mount.size;
        let lab = Raster::from_fn(width, height, |x, y| [light(x, y), 0.0, 0.0]);
        lights(&lab, &mount, &Raster::new(width, height, 0.5))
    }

    /// A slanting line, three cells wide.
    fn line(x: usize, y: usize) -> bool {
        (x as f32 - 0.5 * y as f32 - 150.0).abs() < 2.0
    }

    #[test]
    fn a_line_gets_as_much_fluid_as_it_is_light() {
        let [white, pale] = [95.0, 60.0].map(|light| {
            let fluid = fluid(|x, y| if line(x, y) { light } else { 40.0 });
            assert!(fluid.at(150, 300) < 0.02, "none beside the line: {}", fluid.at(150, 300));
            fluid.at(300, 300)
        });
        assert!(white > 0.6, "{white}");
        // By Beer's law 42 % less paint is what is as light as that; blurring takes some of it.
        assert!(pale > 0.15 && pale < 0.45, "{pale}");
    }

    #[test]
    fn the_light_side_of_an_edge_gets_none() {
        let fluid = fluid(|x, y| if x as f32 > 0.5 * y as f32 + 150.0 { 90.0 } else { 30.0 });
        // At the sheet's own border, which no picture shows, a corner looks like a point.
        let inner = fluid.as_slice()[4 * fluid.width()..].iter();
        let most = inner.fold(0.0f32, |most, &fluid| most.max(fluid));
        assert!(most < 0.05, "{most}");
    }

    #[test]
    fn a_point_by_itself_gets_some_and_a_texture_of_them_none() {
        let point = |x: usize, y: usize| x % 4 < 2 && y % 4 < 2;
        let one = fluid(|x, y| if point(x, y) && x / 4 == 80 && y / 4 == 80 { 90.0 } else { 45.0 });
        assert!(one.at(321, 321) > 0.3, "{}", one.at(321, 321));
        let many = fluid(|x, y| if point(x, y) { 90.0 } else { 45.0 });
        assert!(many.at(321, 321) < 0.05, "{}", many.at(321, 321));
    }
}
