//! Strokes along a mask: what a pointed brush would draw of it.
//!
//! In the order data flows: pieces of the mask; their middle lines (`skeleton`); lines as long as they go on (`joining`);
//! each smoothed, cut where it turns sharply, its few points placed where it bends.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_weights;
use girtin_grid::distance::distance_to;

mod joining;
mod skeleton;

/// What is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracing {
    /// Shortest stroke, its own width included, cells.
    pub least_length: f32,
    /// Least and most width of a stroke, cells.
    pub widths: [f32; 2],
    /// How far the hand smooths over the line, standard deviation in cells.
    pub smoothing: f32,
}

/// A stroke along a mask.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Points of its path, cells, 4 to 14 of them, the heavy end first. A Catmull-Rom spline goes through them.
    pub points: Vec<[f32; 2]>,
    /// Width at each point, cells: what the photograph has, before any pressure.
    pub widths: Vec<f32>,
    /// Mean of the field along it.
    pub contrast: f32,
    /// Contrast times the root of its area: how much would be missing without it.
    pub score: f32,
    /// Length of its path, cells.
    pub length: f32,
}

/// Fewest and most points of a stroke.
const POINTS: [usize; 2] = [4, 14];
/// How far a stroke may run from the smoothed line, a part of its width, and at least cells.
const TOLERANCE: [f32; 2] = [0.12, 0.35];
/// Longest step between points over the one before or after it: a spline swings out where they are uneven.
const EVEN: f32 = 3.0;
/// How far ends are lengthened, parts of the width there: thinning takes about a half. The light end runs out further.
const LENGTHENED: [f32; 2] = [0.55, 0.7];
/// Smallest piece of a mask, parts of the least length times a cell.
const CRUMB: f32 = 1.3;
/// Longest gap that a line goes on after, parts of the least length.
const GAP: f32 = 1.6;
/// Widths behind and ahead, and cells, over which a turn is measured, and from which on a line is cut there, radians.
const CORNER: [f32; 2] = [1.0, 6.0];
const SHARP: f32 = 1.05;
/// A piece whose middle line is shorter than so many widths is a blob.
const BLOB: f32 = 0.9;
/// A line of more cells than this whose ends meet, but for the cells of a fork, is a ring.
const RING: usize = 16;
/// Length over width of the stroke that a round blob becomes, and where it points: as a right hand puts it, radians.
const DAB: f32 = 1.8;
const DAB_SLANT: f32 = -0.6;
/// The part of length times width that a stroke covers.
const COVERED: f32 = 0.75;

/// Strokes along a mask, in the order of their pieces, row after row.
///
/// Every piece is thinned to its middle line. Lines are cut where they fork, unless two branches continue each other; they
/// go on after short gaps with contrast in them, and end at sharp corners. Round pieces become short thick strokes.
///
/// # Shapes and units
/// `field`: contrast of the mask's cells, of the same size; from it a stroke has its contrast.
///
/// # Panics
/// The sizes differ.
pub fn trace(mask: &Raster<bool>, field: &Raster<f32>, settings: &Tracing) -> Vec<Trace> {
    lines(mask, field, settings).iter().filter_map(|line| line.stroke(field, settings)).collect()
}

/// The lines that become strokes: a point a cell, smooth, without sharp corners.
pub(crate) fn lines(mask: &Raster<bool>, field: &Raster<f32>, settings: &Tracing) -> Vec<Line> {
    assert_eq!((mask.width(), mask.height()), (field.width(), field.height()), "mask and field of one size");
    let (mask, pieces, piece_of) = without_crumbs(mask, CRUMB * settings.least_length);
    let half_widths = distance_to(&mask.map(|there| !there));
    let found = joining::joined(skeleton::Skeleton::of(&mask).branches(), &half_widths);
    let raw = |cells: &Vec<[u32; 2]>| {
        // To the middles of the cells beyond the edge it is half a cell further; lines of even width are half a cell off.
        let width = |cell: &[u32; 2]| 2.0 * half_widths.at(cell[0] as usize, cell[1] as usize) - 0.5;
        let ends = [cells[0], cells[cells.len() - 1]];
        let closed = cells.len() > RING && (0..2).all(|k| ends[0][k].abs_diff(ends[1][k]) < 4);
        Line {
            points: cells.iter().copied().map(point).collect(),
            widths: cells.iter().map(width).map(|width| width.min(1e3)).collect(),
            closed,
        }
    };
    let piece = |cells: &Vec<[u32; 2]>| piece_of.at(cells[0][0] as usize, cells[0][1] as usize) as usize;
    let all: Vec<(usize, Line)> = found.iter().map(|cells| (piece(cells), raw(cells))).collect();
    let mut longest = vec![0.0f32; pieces.len()];
    let mut thickest = vec![0.0f32; pieces.len()];
    for (piece, line) in &all {
        longest[*piece] = longest[*piece].max(line.points.len() as f32);
        thickest[*piece] = line.widths.iter().fold(thickest[*piece], |most, &width| most.max(width));
    }
    let is_blob = |piece: usize| longest[piece] < BLOB * thickest[piece];
    let drawn = all.into_iter().filter(|&(piece, _)| !is_blob(piece)).map(|(_, line)| line).collect();
    let drawn = joining::bridged(drawn, field, GAP * settings.least_length);
    let mut lines: Vec<Line> =
        drawn.into_iter().flat_map(|line| line.smoothed(settings).cut_at_corners()).collect();
    lines
        .extend(pieces.iter().enumerate().filter(|&(piece, _)| is_blob(piece)).map(|(_, piece)| piece.dab()));
    lines.retain(|line| line.length() + line.widths[0] >= settings.least_length);
    lines
}

/// What a piece of a mask sums up to.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    cells: f64,
    /// Sums of columns and rows.
    sums: [f64; 2],
    /// Sums of their squares and products: columns, rows, both.
    squares: [f64; 3],
}

impl Piece {
    fn add(&mut self, x: usize, y: usize) {
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        self.cells += 1.0;
        self.sums = [self.sums[0] + x, self.sums[1] + y];
        self.squares = [self.squares[0] + x * x, self.squares[1] + y * y, self.squares[2] + x * y];
    }

    /// The short thick stroke that covers as much, along the longer axis.
    fn dab(&self) -> Line {
        let [x, y] = self.sums.map(|sum| sum / self.cells);
        let [xx, yy, xy] =
            [(0, x * x), (1, y * y), (2, x * y)].map(|(k, of)| self.squares[k] / self.cells - of);
        let spread = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
        let slenderness = ((xx + yy + spread + 0.2) / (xx + yy - spread + 0.2)).sqrt() as f32;
        let along = 0.5 * libm::atan2(2.0 * xy, xx - yy) as f32;
        let along = if slenderness > 1.3 { along } else { DAB_SLANT };
        let slenderness = slenderness.max(DAB);
        let width = (self.cells as f32 / (COVERED * slenderness)).sqrt();
        let reach = 0.5 * (slenderness - 1.0) * width;
        let (cos, sin) = (libm::cosf(along), libm::sinf(along));
        let count = (2.0 * reach).max(4.0) as usize;
        let place = |k: usize| {
            let t = reach * (2.0 * k as f32 / count as f32 - 1.0);
            [x as f32 + t * cos, y as f32 + t * sin]
        };
        Line { points: (0..=count).map(place).collect(), widths: vec![width; count + 1], closed: false }
    }
}

/// The mask without pieces of fewer than `least` cells; the other pieces, and to which a cell belongs.
fn without_crumbs(mask: &Raster<bool>, least: f32) -> (Raster<bool>, Vec<Piece>, Raster<u32>) {
    let (width, height) = (mask.width(), mask.height());
    let mut kept = mask.clone();
    let mut piece_of = Raster::new(width, height, u32::MAX);
    let mut pieces: Vec<Piece> = Vec::new();
    let mut cells: Vec<[usize; 2]> = Vec::new();
    for y in 0..height {
        for x in 0..width {
            if !mask.at(x, y) || piece_of.at(x, y) != u32::MAX {
                continue;
            }
            let number = pieces.len() as u32;
            cells.clear();
            cells.push([x, y]);
            piece_of.row_mut(y)[x] = number;
            let mut piece = Piece::default();
            let mut next = 0;
            while let Some(&[x, y]) = cells.get(next) {
                next += 1;
                piece.add(x, y);
                for v in y.saturating_sub(1)..(y + 2).min(height) {
                    for u in x.saturating_sub(1)..(x + 2).min(width) {
                        if mask.at(u, v) && piece_of.at(u, v) == u32::MAX {
                            piece_of.row_mut(v)[u] = number;
                            cells.push([u, v]);
                        }
                    }
                }
            }
            if (cells.len() as f32) < least {
                // Its number goes to the next one; no line asks for it, and it is not found again.
                cells.iter().for_each(|&[x, y]| kept.row_mut(y)[x] = false);
            } else {
                pieces.push(piece);
            }
        }
    }
    (kept, pieces, piece_of)
}

/// A line before it is a stroke: points and widths, cells, about a cell apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    pub points: Vec<[f32; 2]>,
    pub widths: Vec<f32>,
    /// Its end touches its beginning.
    pub closed: bool,
}

impl Line {
    /// Length, cells.
    pub fn length(&self) -> f32 {
        self.points.windows(2).map(|pair| length(difference(pair[1], pair[0]))).sum()
    }

    /// Mean of a plane along it.
    pub fn contrast(&self, field: &Raster<f32>) -> f32 {
        mean(self.points.iter().map(|&[x, y]| field.sample(x, y)))
    }

    pub fn mean_width(&self) -> f32 {
        mean(self.widths.iter().copied())
    }

    /// The part between two points, the last included.
    pub fn part(&self, first: usize, last: usize) -> Self {
        Self {
            points: self.points[first..=last].to_vec(),
            widths: self.widths[first..=last].to_vec(),
            closed: false,
        }
    }

    /// Which way it runs at one of its points, of length 1.
    pub fn direction(&self, at: usize) -> [f32; 2] {
        let (before, after) = (at.saturating_sub(2), (at + 2).min(self.points.len() - 1));
        let along = difference(self.points[after], self.points[before]);
        let size = length(along).max(1e-6);
        along.map(|part| part / size)
    }

    /// A point a cell, linear between those there are.
    fn even(&self) -> Self {
        let mut even = Self { closed: self.closed, ..Self::default() };
        for (pair, widths) in self.points.windows(2).zip(self.widths.windows(2)) {
            let step = difference(pair[1], pair[0]);
            let count = length(step).round().max(1.0);
            for k in 0..count as usize {
                let part = k as f32 / count;
                even.points.push([pair[0][0] + part * step[0], pair[0][1] + part * step[1]]);
                even.widths.push(widths[0] + part * (widths[1] - widths[0]));
            }
        }
        even.points.extend(self.points.last());
        even.widths.extend(self.widths.last());
        even
    }

    /// The line as a calm hand draws it.
    fn smoothed(&self, settings: &Tracing) -> Self {
        let even = self.even();
        let sigma = settings.smoothing.min(even.points.len() as f32 / 5.0);
        let [xs, ys] = [0, 1].map(|k| {
            let values: Vec<f32> = even.points.iter().map(|point| point[k]).collect();
            smoothed(&values, sigma, even.closed)
        });
        let widths = smoothed(&even.widths, sigma.max(1.0), even.closed);
        let mut line = Self {
            points: xs.into_iter().zip(ys).map(|(x, y)| [x, y]).collect(),
            widths: widths
                .into_iter()
                .map(|width| width.clamp(settings.widths[0], settings.widths[1]))
                .collect(),
            closed: even.closed,
        };
        if line.closed {
            // A ring is closed, and begins where it is thinnest.
            let thinnest = (0..line.widths.len()).min_by(|&a, &b| line.widths[a].total_cmp(&line.widths[b]));
            let thinnest = thinnest.unwrap_or(0);
            line.points.rotate_left(thinnest);
            line.widths.rotate_left(thinnest);
            line.points.push(line.points[0]);
            line.widths.push(line.widths[0]);
        }
        line
    }

    /// Its parts between sharp corners.
    fn cut_at_corners(self) -> Vec<Self> {
        let count = self.points.len();
        let reach = (CORNER[0] * self.mean_width() + CORNER[1]) as usize;
        if count < 2 * reach + 1 {
            return vec![self];
        }
        let turns: Vec<f32> = (0..count)
            .map(|at| {
                if at < reach || at + reach >= count {
                    return 0.0;
                }
                let [before, here, after] = [at - reach, at, at + reach].map(|at| self.points[at]);
                turn(difference(here, before), difference(after, here))
            })
            .collect();
        let mut parts = Vec::new();
        let mut from = 0;
        for at in reach..count - reach {
            let around = &turns[at - reach..=at + reach];
            let is_most = around
                .iter()
                .enumerate()
                .all(|(k, &turn)| turns[at] > turn || k >= reach && turns[at] >= turn);
            if turns[at] > SHARP && is_most {
                parts.push(self.part(from, at));
                from = at;
            }
        }
        if from == 0 {
            return vec![self];
        }
        parts.push(self.part(from, count - 1));
        parts
    }

    /// The stroke along it, heavy end first, if there is one.
    pub fn stroke(&self, field: &Raster<f32>, settings: &Tracing) -> Option<Trace> {
        if self.points.len() < 2 {
            return None;
        }
        let contrast = self.contrast(field);
        let mut line = self.clone();
        let half = line.points.len() / 2;
        // Where both halves are as wide, the one with more contrast is heavier.
        let weight = |points: &[[f32; 2]], widths: &[f32]| {
            let width = mean(widths.iter().copied());
            width
                * (1.0
                    + 0.1 * mean(points.iter().map(|&[x, y]| field.sample(x, y))) / contrast.abs().max(1e-3))
        };
        if weight(&line.points[..half], &line.widths[..half])
            < weight(&line.points[half..], &line.widths[half..])
        {
            line.points.reverse();
            line.widths.reverse();
        }
        line.lengthen();
        let chosen = line.chosen();
        let points: Vec<[f32; 2]> = chosen.iter().map(|&at| line.points[at]).collect();
        let widths: Vec<f32> =
            chosen.iter().map(|&at| line.widths[at].clamp(settings.widths[0], settings.widths[1])).collect();
        let length = Line { points: points.clone(), ..Line::default() }.length();
        let score = contrast * (length * mean(widths.iter().copied())).sqrt();
        Some(Trace { points, widths, contrast, score, length })
    }

    /// Lets both ends reach out to where the mask ends, and a bit further.
    fn lengthen(&mut self) {
        if self.closed {
            return;
        }
        let last = self.points.len() - 1;
        let mut ends = [[0.0; 2]; 2];
        for ((end, at), by) in ends.iter_mut().zip([0, last]).zip(LENGTHENED) {
            // The last cells of a middle line turn into a corner of the mask.
            let back = if at == 0 { last.min(5) } else { last - last.min(5) };
            let out = difference(self.points[at], self.points[back]);
            let by = by * self.widths[at] / length(out).max(1e-6);
            *end = [self.points[at][0] + by * out[0], self.points[at][1] + by * out[1]];
        }
        self.points.insert(0, ends[0]);
        self.widths.insert(0, self.widths[0]);
        self.points.push(ends[1]);
        self.widths.push(self.widths[last + 1]);
        *self = self.even();
    }

    /// Which of its points a stroke goes through: the ends, and from there on always the one furthest off.
    ///
    /// # Source
    /// Douglas and Peucker 1973, with widths as a third coordinate, and never steps too uneven for a spline.
    fn chosen(&self) -> Vec<usize> {
        let last = self.points.len() - 1;
        let tolerance = (TOLERANCE[0] * self.mean_width()).max(TOLERANCE[1]);
        // A ring's ends are one place: the furthest point from it comes first.
        let mut chosen = vec![0, last];
        while chosen.len() < POINTS[1].min(last + 1) {
            let furthest = chosen.windows(2).filter_map(|ends| self.furthest(ends[0], ends[1])).fold(
                None,
                |most: Option<(usize, f32)>, one| {
                    if most.is_some_and(|most| most.1 >= one.1) { most } else { Some(one) }
                },
            );
            let next = match furthest {
                Some((at, off)) if off > tolerance => at,
                _ => match self.uneven(&chosen, chosen.len() < POINTS[0]) {
                    Some(at) => at,
                    None => break,
                },
            };
            let place = chosen.partition_point(|&at| at < next);
            chosen.insert(place, next);
        }
        chosen
    }

    /// The point between two furthest from the straight line between them, and how far it is.
    fn furthest(&self, first: usize, last: usize) -> Option<(usize, f32)> {
        let (from, to) = (self.points[first], self.points[last]);
        let along = difference(to, from);
        let square = (along[0] * along[0] + along[1] * along[1]).max(1e-6);
        let off = |at: usize| {
            let by = difference(self.points[at], from);
            let part = ((by[0] * along[0] + by[1] * along[1]) / square).clamp(0.0, 1.0);
            let [dx, dy] = [by[0] - part * along[0], by[1] - part * along[1]];
            // An edge is half as far off as the width.
            let wider = 0.5
                * (self.widths[at] - self.widths[first] - part * (self.widths[last] - self.widths[first]));
            (dx * dx + dy * dy + 0.5 * wider * wider).sqrt()
        };
        // Not right beside the ends: two points there would be one corner.
        (first + 2..last.saturating_sub(1)).map(|at| (at, off(at))).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The middle of the longest step that is much longer than one beside it; of the longest step if `any`.
    fn uneven(&self, chosen: &[usize], any: bool) -> Option<usize> {
        let steps: Vec<usize> = chosen.windows(2).map(|ends| ends[1] - ends[0]).collect();
        let is_uneven = |&k: &usize| {
            let beside =
                [k.checked_sub(1), Some(k + 1)].into_iter().flatten().filter_map(|k| steps.get(k)).min();
            any || beside.is_some_and(|&beside| steps[k] as f32 > EVEN * beside as f32)
        };
        let longest = (0..steps.len())
            .filter(|&k| steps[k] > 1)
            .filter(is_uneven)
            .max_by_key(|&k| (steps[k], chosen.len() - k))?;
        Some(chosen[longest] + steps[longest] / 2)
    }
}

/// The middle of a cell.
fn point([x, y]: [u32; 2]) -> [f32; 2] {
    [x as f32 + 0.5, y as f32 + 0.5]
}

/// The way from `b` to `a`.
fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn length([x, y]: [f32; 2]) -> f32 {
    (x * x + y * y).sqrt()
}

/// How far one turns from a direction to another, radians, 0 to π.
fn turn(a: [f32; 2], b: [f32; 2]) -> f32 {
    libm::atan2f((a[0] * b[1] - a[1] * b[0]).abs(), a[0] * b[0] + a[1] * b[1])
}

pub(crate) fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0f32));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// A row of values under a Gaussian. The ends of a line stay where they are: it goes on turned by half a circle.
fn smoothed(values: &[f32], sigma: f32, closed: bool) -> Vec<f32> {
    let radius = libm::ceilf(3.0 * sigma) as usize;
    let weights = gaussian_weights(f64::from(sigma), radius);
    let count = values.len() as isize;
    let last = count - 1;
    let at = |k: isize| {
        if closed {
            return values[k.rem_euclid(count) as usize];
        }
        let inside = |k: isize| values[k.clamp(0, last) as usize];
        match k {
            k if k < 0 => 2.0 * values[0] - inside(-k),
            k if k > last => 2.0 * values[last as usize] - inside(2 * last - k),
            k => values[k as usize],
        }
    };
    let one = |k: isize| {
        weights.iter().enumerate().map(|(tap, weight)| weight * at(k + tap as isize - radius as isize)).sum()
    };
    (0..count).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: Tracing = Tracing { least_length: 8.0, widths: [1.0, 16.0], smoothing: 2.5 };

    fn traced(width: usize, height: usize, mask: impl Fn(f32, f32) -> bool) -> Vec<Trace> {
        let mask = Raster::from_fn(width, height, |x, y| mask(x as f32 + 0.5, y as f32 + 0.5));
        let field = mask.map(|there| if there { 20.0f32 } else { 0.0 });
        let found = trace(&mask, &field, &SETTINGS);
        for trace in &found {
            assert!((2..=POINTS[1]).contains(&trace.points.len()), "{} points", trace.points.len());
            assert_eq!(trace.points.len(), trace.widths.len());
        }
        found
    }

    /// Distance of a place from a line between two others.
    fn off([x, y]: [f32; 2], from: [f32; 2], to: [f32; 2]) -> f32 {
        let along = difference(to, from);
        let by = difference([x, y], from);
        let part = ((by[0] * along[0] + by[1] * along[1]) / (along[0] * along[0] + along[1] * along[1]))
            .clamp(0.0, 1.0);
        length([by[0] - part * along[0], by[1] - part * along[1]])
    }

    #[test]
    fn a_plus_is_two_strokes() {
        let found = traced(81, 81, |x, y| {
            let (dx, dy) = ((x - 40.5).abs(), (y - 40.5).abs());
            dx.min(dy) < 2.0 && dx.max(dy) < 32.0
        });
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found.iter().all(|trace| (60.0..72.0).contains(&trace.length)), "{found:?}");
    }

    #[test]
    fn lines_that_cross_at_a_slant_stay_two() {
        let ends = [([10.0, 20.0], [190.0, 60.0]), ([10.0, 60.0], [190.0, 20.0])];
        let found = traced(200, 80, |x, y| ends.iter().any(|&(from, to)| off([x, y], from, to) < 1.6));
        assert_eq!(found.len(), 2, "{found:?}");
        for trace in &found {
            let is_one =
                ends.iter().any(|&(from, to)| trace.points.iter().all(|&point| off(point, from, to) < 4.0));
            assert!(is_one && trace.length > 170.0, "{trace:?}");
        }
    }

    #[test]
    fn a_long_line_goes_on_over_gaps_with_contrast() {
        let bow = |x: f32| 30.0 + 14.0 * libm::sinf(x / 70.0);
        let gap = |x: f32| (x as usize % 60) < 6;
        let mask = Raster::from_fn(240, 60, |x, y| {
            let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
            (10.0..230.0).contains(&x) && (y - bow(x)).abs() < 1.6 && !gap(x)
        });
        let weak =
            Raster::from_fn(
                240,
                60,
                |x, y| if (y as f32 + 0.5 - bow(x as f32)).abs() < 2.0 { 9.0f32 } else { 0.0 },
            );
        let one = trace(&mask, &weak, &SETTINGS);
        assert_eq!(one.len(), 1, "{one:?}");
        assert!((215.0..250.0).contains(&one[0].length), "{}", one[0].length);
        let strong = mask.map(|there| if there { 9.0f32 } else { 0.0 });
        assert_eq!(trace(&mask, &strong, &SETTINGS).len(), 4, "nothing in the gaps");
    }

    #[test]
    fn a_wedge_begins_at_its_heavy_end() {
        let found = traced(120, 30, |x, y| (10.0..110.0).contains(&x) && (y - 15.0).abs() < 0.06 * x);
        assert_eq!(found.len(), 1);
        let trace = &found[0];
        assert!(
            trace.points[0][0] > 90.0 && trace.points.last().is_some_and(|point| point[0] < 20.0),
            "{trace:?}"
        );
        assert!(trace.widths[0] > 2.0 * trace.widths[trace.widths.len() - 1], "{:?}", trace.widths);
    }

    #[test]
    fn widths_are_those_of_the_mask() {
        for width in [1.0f32, 3.0, 6.0, 9.0] {
            let found = traced(100, 40, |x, y| (20.0..80.0).contains(&x) && (y - 20.0).abs() <= 0.5 * width);
            assert_eq!(found.len(), 1);
            let middle = found[0].widths[found[0].widths.len() / 2];
            assert!((middle - width).abs() < 1.1, "{middle} for {width}");
        }
    }

    #[test]
    fn a_blob_is_a_short_thick_stroke_and_a_crumb_nothing() {
        let found =
            traced(60, 40, |x, y| length([x - 20.0, y - 20.0]) < 7.0 || length([x - 50.0, y - 10.0]) < 1.6);
        assert_eq!(found.len(), 1, "{found:?}");
        let trace = &found[0];
        assert!((1.2..2.6).contains(&(trace.length / trace.widths[1])), "{trace:?}");
    }

    #[test]
    fn a_corner_is_two_strokes_and_a_ring_closes() {
        let ell = traced(80, 80, |x, y| {
            (x - 20.0).abs() < 2.0 && (18.0..70.0).contains(&y)
                || (y - 20.0).abs() < 2.0 && (18.0..70.0).contains(&x)
        });
        assert_eq!(ell.len(), 2, "{ell:?}");
        let ring = traced(80, 80, |x, y| (length([x - 40.0, y - 40.0]) - 25.0).abs() < 2.0);
        assert_eq!(ring.len(), 1, "{ring:?}");
        let (first, last) = (ring[0].points[0], ring[0].points[ring[0].points.len() - 1]);
        assert!(length(difference(first, last)) < 2.0 && ring[0].length > 140.0, "{ring:?}");
    }

    #[test]
    fn strokes_run_through_their_line() {
        let wave = |x: f32| 40.0 + 22.0 * libm::sinf(x / 28.0);
        let found = traced(260, 80, |x, y| (10.0..250.0).contains(&x) && (y - wave(x)).abs() < 2.2);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].points.len() > 7, "more points where it bends: {}", found[0].points.len());
        let inner = &found[0].points[1..found[0].points.len() - 1];
        assert!(inner.iter().all(|&[x, y]| (y - wave(x)).abs() < 2.5), "{inner:?}");
    }

    #[test]
    fn nothing_gives_nothing() {
        for (width, height) in [(0, 0), (1, 1), (30, 1)] {
            assert_eq!(traced(width, height, |_, _| false), []);
            let _ = traced(width, height, |_, _| true);
        }
    }
}
