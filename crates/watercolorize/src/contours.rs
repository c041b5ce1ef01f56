//! Masses drawn as a hand draws them: polygons of long, decided runs, with corners, and arcs where a thing is round.
//!
//! A mass is drawn a little into those that are painted after it, so that no gap stays between two shapes, and those lie over
//! it with a contour of their own: neighbours share one.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_plane;
use rayon::prelude::*;

use crate::accidents::smoothstep;
use crate::masses::{Mass, Masses};

/// How far a mass is drawn into those painted after it: parts of the long edge, more than the hand strays, and cells at least.
const UNDER: f64 = 0.0065;
const LEAST_UNDER: f64 = 3.0;

/// Blur of a mass before it is cut, parts of the long edge, more where nobody looks; at most a part of its width, so that
/// thin things keep theirs; and at least so many cells, so that cells are not seen.
const BLUR: f64 = 0.0021;
const BLUR_ASIDE: f64 = 0.0050;
const BLUR_OF_WIDTH: f64 = 0.28;
const LEAST_BLUR: f64 = 0.7;

/// How far the hand strays from the contour, parts of the long edge, more where nobody looks; and at most a part of a mass's
/// width.
const STRAY: f64 = 0.0013;
const STRAY_ASIDE: f64 = 0.0024;
const STRAY_OF_WIDTH: f64 = 0.22;
const LEAST_STRAY: f64 = 0.9;
/// How much farther it strays between masses that differ by less than so much, Lab, up to twice as far.
const PALE: [f32; 2] = [22.0, 6.0];
const STRAY_PALE: f64 = 1.0;

/// Shortest run that the hand makes, parts of the long edge, more where nobody looks.
const RUN: f64 = 0.008;
const RUN_ASIDE: f64 = 0.015;
/// How much farther than usual the hand strays to leave out a shorter one.
const LEFT_OUT: f32 = 1.7;

/// Turns below this are rounded a little, radians: by at most this part of a run, and parts of the long edge.
const BLUNT: f32 = 1.25;
const ROUNDED: f32 = 0.22;
const ROUNDING: f64 = 0.0055;

/// A run is a bow if it rises by more than this part of the straying, if what is left is less than this part of its rise,
/// and if it turns by less than this at its ends, radians.
const BOW: f32 = 0.28;
const BOW_LEFT: f32 = 0.6;
const BOW_TURN: f32 = 1.2;
/// Length from which on a single bow is drawn, parts of the long edge; shorter ones are drawn only beside others.
const SINGLE_BOW: f64 = 0.045;
/// How far a bow may be from the polygon that draws it, cells.
const FLAT: f32 = 0.1;

/// Area below which a ring is left out, cells.
const LEAST_RING: f32 = 6.0;

/// A mass as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Which mass.
    pub mass: usize,
    /// Closed polygons, filled by the even-odd rule: cells from the raster's corner, to a hundredth. They may go a few cells
    /// beyond the raster.
    pub rings: Vec<Vec<[f32; 2]>>,
}

type Point = [f32; 2];

/// All masses in the order in which they are painted over each other, large ones first.
///
/// The first is the whole raster: it is the ground of the others. `looseness` is 1 for the usual hand, more for one that
/// strays further and leaves out more.
///
/// # Guarantees
/// The same for any number of threads.
pub fn contours(masses: &Masses, long_edge: f64, looseness: f32) -> Vec<Contour> {
    let mut order: Vec<usize> = (0..masses.masses.len()).collect();
    order.sort_by(|&a, &b| masses.masses[b].area.total_cmp(&masses.masses[a].area).then(a.cmp(&b)));
    let mut place = vec![0u32; order.len()];
    order.iter().enumerate().for_each(|(at, &mass)| place[mass] = at as u32);
    let places = masses.labels.map(|label| place[label as usize]);
    order
        .par_iter()
        .map(|&mass| {
            let rings = if place[mass] == 0 {
                let [right, bottom] = [places.width() as f32, places.height() as f32];
                vec![vec![[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]]]
            } else {
                let pen = Pen::new(masses, mass, long_edge, looseness);
                rings(&places, place[mass], &masses.masses[mass], &pen)
            };
            Contour { mass, rings }
        })
        .collect()
}

/// The contours of a mask as a hand draws them: rings of its shapes and of their holes, all that are large enough.
pub fn around(mask: &Raster<bool>, long_edge: f64, looseness: f32) -> Vec<Vec<[f32; 2]>> {
    let pen = Pen::broad(long_edge, looseness);
    let pad = 2;
    let padded = Raster::from_fn(mask.width() + 2 * pad, mask.height() + 2 * pad, |x, y| {
        let held = |at: usize, of: usize| at.saturating_sub(pad).min(of - 1);
        let is_edge = x == 0 || y == 0 || x + 1 == mask.width() + 2 * pad || y + 1 == mask.height() + 2 * pad;
        f32::from(u8::from(!is_edge && mask.at(held(x, mask.width()), held(y, mask.height()))))
    });
    let drawn = |ring: &Vec<Point>| (area(ring).abs() > LEAST_RING).then(|| drawn(ring, &pen)).flatten();
    let mut rings: Vec<Vec<Point>> =
        traced(&gaussian_plane(&padded, pen.blur)).iter().filter_map(drawn).collect();
    for point in rings.iter_mut().flatten() {
        *point = point.map(|at| libm::roundf(100.0 * (at - pad as f32)) / 100.0);
    }
    rings
}

/// How a mass is drawn, cells and radians.
#[derive(Clone, Copy, Debug)]
struct Pen {
    under: isize,
    blur: f64,
    stray: f32,
    run: f32,
    rounding: f32,
    single_bow: f32,
}

impl Pen {
    /// For something wide that nobody looks at.
    fn broad(long_edge: f64, looseness: f32) -> Self {
        let loose = f64::from(looseness);
        Self {
            under: 0,
            blur: ((BLUR + BLUR_ASIDE) * long_edge * loose).max(LEAST_BLUR),
            stray: ((STRAY + STRAY_ASIDE) * long_edge * loose) as f32,
            run: ((RUN + RUN_ASIDE) * long_edge * loose) as f32,
            rounding: (ROUNDING * long_edge) as f32,
            single_bow: (SINGLE_BOW * long_edge) as f32,
        }
    }

    fn new(masses: &Masses, number: usize, long_edge: f64, looseness: f32) -> Self {
        let mass = &masses.masses[number];
        let (mut all, mut differing) = (1e-6, 0.0);
        for beside in &masses.neighbours[number] {
            let other = masses.masses[beside.mass].mean;
            let square: f32 = mass.mean.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
            all += beside.length as f32;
            differing += beside.length as f32 * square.sqrt();
        }
        let pale = 1.0 + STRAY_PALE * f64::from(smoothstep(differing / all, PALE[0], PALE[1]));
        let (aside, loose) = (f64::from(1.0 - mass.attention.min(1.0)), f64::from(looseness));
        let width = f64::from(mass.width);
        let blur = (BLUR + BLUR_ASIDE * aside) * long_edge * loose;
        let stray = ((STRAY + STRAY_ASIDE * aside) * long_edge * loose * pale)
            .min(STRAY_OF_WIDTH * width + 0.2)
            .max(LEAST_STRAY.min(STRAY_OF_WIDTH * width));
        Self {
            under: (UNDER * long_edge * loose).max(LEAST_UNDER) as isize,
            blur: blur.min(BLUR_OF_WIDTH * width).max(LEAST_BLUR),
            stray: stray as f32,
            run: ((RUN + RUN_ASIDE * aside) * long_edge * loose * pale) as f32,
            rounding: (ROUNDING * long_edge) as f32,
            single_bow: (SINGLE_BOW * long_edge) as f32,
        }
    }
}

/// The rings of the mass that is painted at a place in the order.
fn rings(places: &Raster<u32>, place: u32, mass: &Mass, pen: &Pen) -> Vec<Vec<Point>> {
    let pad = pen.under + libm::ceil(3.0 * pen.blur) as isize + 2;
    let [[left, top], [right, bottom]] = mass.bounds.map(|corner| corner.map(|at| at as isize));
    let (left, top) = (left - pad, top - pad);
    let (width, height) = ((right + pad - left) as usize, (bottom + pad - top) as usize);
    let at = |x: usize, y: usize| {
        let x = (x as isize + left).clamp(0, places.width() as isize - 1) as usize;
        places.row((y as isize + top).clamp(0, places.height() as isize - 1) as usize)[x]
    };
    let mut mask = Raster::from_fn(width, height, |x, y| at(x, y) == place);
    grow(&mut mask, pen.under, |x, y| at(x, y) > place);
    fill_holes(&mut mask, |x, y| at(x, y) > place);
    let plane = |mask: &Raster<bool>| mask.map(|inside| f32::from(u8::from(inside)));
    let draw = |field: &Raster<f32>| {
        let drawn = |ring: &Vec<Point>| {
            let area = area(ring).abs();
            (area > LEAST_RING).then(|| drawn(ring, pen)).flatten()
        };
        traced(field).iter().filter_map(drawn).collect::<Vec<_>>()
    };
    let mut rings = draw(&gaussian_plane(&plane(&mask), pen.blur));
    if rings.is_empty() {
        // Too thin for the blur.
        rings = draw(&gaussian_plane(&plane(&mask), 0.5));
    }
    for point in rings.iter_mut().flatten() {
        let [x, y] = [point[0] + left as f32, point[1] + top as f32];
        *point = [x, y].map(|at| libm::roundf(100.0 * at) / 100.0);
    }
    rings
}

/// Grows a mask by some cells where it may.
fn grow(mask: &mut Raster<bool>, by: isize, may: impl Fn(usize, usize) -> bool) {
    let (width, height) = (mask.width(), mask.height());
    let own = mask.clone();
    let is_inner = |x: usize, y: usize| {
        x > 0
            && y > 0
            && x + 1 < width
            && y + 1 < height
            && own.row(y)[x - 1]
            && own.row(y)[x + 1]
            && own.row(y - 1)[x]
            && own.row(y + 1)[x]
    };
    for y in 0..height {
        for x in (0..width).filter(|&x| own.row(y)[x] && !is_inner(x, y)) {
            for dy in -by..=by {
                for dx in -by..=by {
                    let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                    let is_near = dx * dx + dy * dy <= by * by;
                    if is_near && x < width && y < height && !own.row(y)[x] && may(x, y) {
                        mask.row_mut(y)[x] = true;
                    }
                }
            }
        }
    }
}

/// Fills holes that lie wholly where they may be filled.
fn fill_holes(mask: &mut Raster<bool>, may: impl Fn(usize, usize) -> bool) {
    let (width, height) = (mask.width(), mask.height());
    let mut seen = mask.clone();
    let (mut open, mut hole) = (Vec::new(), Vec::new());
    for start in 0..width * height {
        if seen.as_slice()[start] {
            continue;
        }
        let mut is_filled = true;
        hole.clear();
        open.push(start);
        seen.as_mut_slice()[start] = true;
        while let Some(cell) = open.pop() {
            let (x, y) = (cell % width, cell / width);
            hole.push(cell);
            is_filled &= x > 0 && y > 0 && x + 1 < width && y + 1 < height && may(x, y);
            let sides = [
                (x > 0).then(|| cell - 1),
                (x + 1 < width).then(|| cell + 1),
                (y > 0).then(|| cell - width),
                (y + 1 < height).then(|| cell + width),
            ];
            for side in sides.into_iter().flatten() {
                if !std::mem::replace(&mut seen.as_mut_slice()[side], true) {
                    open.push(side);
                }
            }
        }
        if is_filled {
            hole.iter().for_each(|&cell| mask.as_mut_slice()[cell] = true);
        }
    }
}

/// Value of a blurred mask at its edge.
const EDGE: f32 = 0.5;

/// The closed curves on which a field is at [`EDGE`], the inside to their right; the field's border counts as outside.
///
/// # Source
/// Lorensen and Cline, *Marching Cubes*, 1987, in the plane.
fn traced(field: &Raster<f32>) -> Vec<Vec<Point>> {
    const NONE: u32 = u32::MAX;
    let (width, height) = (field.width(), field.height());
    if width < 3 || height < 3 {
        return Vec::new();
    }
    let at = |x: usize, y: usize| {
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height { 0.0 } else { field.row(y)[x] }
    };
    // The sides between cells: to the right of a cell, and below it.
    let side = |x: usize, y: usize, below: usize| (2 * (y * width + x) + below) as u32;
    let mut next = vec![NONE; 2 * width * height];
    for y in 0..height - 1 {
        for x in 0..width - 1 {
            let corners = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            let inside = corners.map(|value| usize::from(value > EDGE));
            let case = inside[0] | inside[1] << 1 | inside[2] << 2 | inside[3] << 3;
            if case == 0 || case == 15 {
                continue;
            }
            let [top, right, bottom, left] =
                [side(x, y, 0), side(x + 1, y, 1), side(x, y + 1, 0), side(x, y, 1)];
            let is_middle_inside = corners.iter().sum::<f32>() > 4.0 * EDGE;
            let pairs: &[(u32, u32)] = &match (case, is_middle_inside) {
                (1, _) => [(top, left); 2],
                (2, _) => [(right, top); 2],
                (3, _) => [(right, left); 2],
                (4, _) => [(bottom, right); 2],
                (5, true) => [(top, right), (bottom, left)],
                (5, false) => [(top, left), (bottom, right)],
                (6, _) => [(bottom, top); 2],
                (7, _) => [(bottom, left); 2],
                (8, _) => [(left, bottom); 2],
                (9, _) => [(top, bottom); 2],
                (10, true) => [(left, top), (right, bottom)],
                (10, false) => [(right, top), (left, bottom)],
                (11, _) => [(right, bottom); 2],
                (12, _) => [(left, right); 2],
                (13, _) => [(top, right); 2],
                _ => [(left, top); 2],
            };
            pairs.iter().for_each(|&(from, to)| next[from as usize] = to);
        }
    }
    let point = |side: u32| {
        let (cell, below) = ((side / 2) as usize, side % 2 == 1);
        let (x, y) = (cell % width, cell / width);
        let (a, b) = (at(x, y), if below { at(x, y + 1) } else { at(x + 1, y) });
        let part = ((EDGE - a) / (b - a)).clamp(0.0, 1.0);
        let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
        if below { [x, y + part] } else { [x + part, y] }
    };
    let mut rings = Vec::new();
    for start in 0..next.len() {
        let mut ring = Vec::new();
        let mut here = start as u32;
        while next[here as usize] != NONE {
            ring.push(point(here));
            here = std::mem::replace(&mut next[here as usize], NONE);
        }
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    rings
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn plus(a: Point, b: Point, times: f32) -> Point {
    [a[0] + times * b[0], a[1] + times * b[1]]
}

fn dot(a: Point, b: Point) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(a: Point) -> f32 {
    dot(a, a).sqrt()
}

/// Area of a ring, negative if it goes the other way.
fn area(ring: &[Point]) -> f32 {
    let corner = ring.first().copied().unwrap_or_default();
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    0.5 * pairs.map(|(&a, &b)| cross(minus(a, corner), minus(b, corner))).sum::<f32>()
}

/// Distance of a point from a stretch.
fn distance(point: Point, from: Point, to: Point) -> f32 {
    let (along, off) = (minus(to, from), minus(point, from));
    let part = (dot(off, along) / dot(along, along).max(1e-12)).clamp(0.0, 1.0);
    length(plus(off, along, -part))
}

/// A ring as a hand draws it; none if nothing is left of it.
fn drawn(ring: &[Point], pen: &Pen) -> Option<Vec<Point>> {
    let corners = left_out(ring, corners(ring, pen.stray), pen);
    if corners.len() < 3 {
        return None;
    }
    let polygon = || corners.iter().map(|&corner| ring[corner]).collect::<Vec<_>>();
    let drawn = with_runs(ring, &corners, pen);
    let drawn = if crosses_itself(&drawn) { polygon() } else { drawn };
    (area(&drawn).abs() > 1.0).then_some(drawn)
}

/// The points of a ring between which it strays from a straight run by no more than `stray`.
///
/// # Source
/// Douglas and Peucker 1973, begun at the two points that are farthest apart, nearly.
fn corners(ring: &[Point], stray: f32) -> Vec<usize> {
    let farthest = |from: Point| {
        let off = |k: usize| length(minus(ring[k], from));
        (0..ring.len()).max_by(|&a, &b| off(a).total_cmp(&off(b)).then(b.cmp(&a))).unwrap_or(0)
    };
    let first = farthest(ring[0]);
    let second = farthest(ring[first]);
    let mut kept = vec![false; ring.len()];
    kept[first] = true;
    kept[second] = true;
    let mut open = vec![(first, second), (second, first)];
    while let Some((from, to)) = open.pop() {
        let Some((worst, off)) = worst(ring, from, to) else { continue };
        if off > stray {
            kept[worst] = true;
            open.extend([(from, worst), (worst, to)]);
        }
    }
    (0..ring.len()).filter(|&k| kept[k]).collect()
}

/// The point between two of a ring that is farthest from the straight run, and how far.
fn worst(ring: &[Point], from: usize, to: usize) -> Option<(usize, f32)> {
    let (a, b) = (ring[from], ring[to]);
    let off = |k: usize| (k, distance(ring[k], a, b));
    between(ring.len(), from, to).map(off).max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}

/// The places between two of a ring.
fn between(count: usize, from: usize, to: usize) -> impl Iterator<Item = usize> + Clone {
    let steps = (to + count - from) % count;
    let steps = if steps == 0 { count } else { steps };
    (1..steps).map(move |step| (from + step) % count)
}

/// The corners without those that make short runs, if leaving them out strays little.
fn left_out(ring: &[Point], mut corners: Vec<usize>, pen: &Pen) -> Vec<usize> {
    // Cost of a corner: how far the ring is from the run without it, and how short the runs at it are.
    let least = |corners: &[usize]| {
        let count = corners.len();
        let cost = |k: usize| {
            let [before, own, after] = [k + count - 1, k, k + 1].map(|k| corners[k % count]);
            let run = length(minus(ring[own], ring[before])).min(length(minus(ring[after], ring[own])));
            let (_, off) = worst(ring, before, after)?;
            // Shorter runs may cost more.
            let short = (2.0 * (1.0 - run / pen.run)).clamp(0.0, 1.0);
            let allowed = pen.stray * (1.0 + (LEFT_OUT - 1.0) * short);
            (off < allowed).then_some((k, off / allowed))
        };
        (0..count).filter_map(cost).min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
    };
    while corners.len() > 4 {
        let Some((k, _)) = least(&corners) else { break };
        corners.remove(k);
    }
    corners
}

/// A stretch between two corners.
#[derive(Clone, Copy, Debug)]
struct Run {
    from: Point,
    to: Point,
    /// The line through it that fits best: a point and a direction.
    through: Point,
    along: Point,
    /// How far it rises over the line between its ends, to the right if positive; 0 if it is drawn straight.
    rise: f32,
}

/// Part of a run at each end that does not count for its line: corners are rounded by the blur.
const ENDS: f32 = 0.15;

impl Run {
    fn new(ring: &[Point], from: usize, to: usize, pen: &Pen) -> Self {
        let (a, b) = (ring[from], ring[to]);
        let chord = minus(b, a);
        let long = length(chord).max(1e-6);
        let along = [chord[0] / long, chord[1] / long];
        let right = [-along[1], along[0]];
        let places = || {
            between(ring.len(), from, to).map(|k| {
                let off = minus(ring[k], a);
                (dot(off, along) / long, dot(off, right))
            })
        };
        // Rise of the parabola through both ends, by least squares.
        let (mut up, mut down) = (0.0f32, 1e-6f32);
        places().for_each(|(t, off)| {
            let bow = 4.0 * t * (1.0 - t);
            up += bow * off;
            down += bow * bow;
        });
        let rise = up / down;
        // The line that fits best, of offsets over the chord.
        let inner = || places().filter(|(t, _)| (ENDS..=1.0 - ENDS).contains(t));
        let n = inner().count() as f32;
        let (mut offset, mut slant) = (0.0, 0.0);
        if n >= 3.0 {
            let (t, off) = inner().fold((0.0, 0.0), |sum, (t, off)| (sum.0 + t / n, sum.1 + off / n));
            let (tt, to) = inner()
                .fold((1e-6, 0.0), |sum, (u, v)| (sum.0 + (u - t) * (u - t), sum.1 + (u - t) * (v - off)));
            slant = to / tt;
            offset = off + (0.5 - t) * slant;
        }
        let missed = |expected: &dyn Fn(f32) -> f32| {
            let square = |(t, off): (f32, f32)| (off - expected(t)) * (off - expected(t));
            (inner().map(square).sum::<f32>() / n.max(1.0)).sqrt()
        };
        let by_line = missed(&|t| offset + slant * (t - 0.5));
        let by_bow = missed(&|t| rise * 4.0 * t * (1.0 - t));
        let is_bow = rise.abs() > BOW * pen.stray && by_bow < BOW_LEFT * by_line;
        let leaning = plus(along, right, slant / long);
        let norm = length(leaning);
        Self {
            from: a,
            to: b,
            through: plus(plus(a, chord, 0.5), right, offset),
            along: [leaning[0] / norm, leaning[1] / norm],
            rise: if is_bow { rise } else { 0.0 },
        }
    }

    fn length(&self) -> f32 {
        length(minus(self.to, self.from))
    }

    /// The place on its line that is nearest to a point.
    fn nearest(&self, point: Point) -> Point {
        plus(self.through, self.along, dot(minus(point, self.through), self.along))
    }

    /// Turn from this run to the next, radians, positive to the right.
    fn turn(&self, next: &Self) -> f32 {
        libm::atan2f(cross(self.along, next.along), dot(self.along, next.along))
    }

    /// Where the lines of two runs cross.
    fn crossing(&self, next: &Self) -> Option<Point> {
        let sine = cross(self.along, next.along);
        let part = cross(minus(next.through, self.through), next.along) / sine;
        (sine.abs() > LEAST_SINE).then(|| plus(self.through, self.along, part))
    }
}

/// Sine of the angle below which two lines have no crossing to speak of.
const LEAST_SINE: f32 = 0.2;

/// How many times the straying a corner may be off the contour: a flat brush overshoots a little.
const OVERSHOOT: f32 = 0.0;

/// The polygon of runs: straight ones meet where their lines cross, bows are drawn round, blunt corners are cut.
fn with_runs(ring: &[Point], corners: &[usize], pen: &Pen) -> Vec<Point> {
    let count = corners.len();
    let mut runs: Vec<Run> =
        (0..count).map(|k| Run::new(ring, corners[k], corners[(k + 1) % count], pen)).collect();
    // A bow is one beside others that bend as it does, or a long one; others are a shaky hand.
    let is_bow: Vec<bool> = (0..count)
        .map(|k| {
            let (before, own, after) = (&runs[(k + count - 1) % count], &runs[k], &runs[(k + 1) % count]);
            let bends = |turn: f32| turn.abs() < BOW_TURN && turn * own.rise < 0.0;
            let goes_on = |other: &Run, turn: f32| other.rise * own.rise > 0.0 && bends(turn);
            own.rise != 0.0
                && (own.length() > pen.single_bow
                    || goes_on(before, before.turn(own))
                    || goes_on(after, own.turn(after)))
        })
        .collect();
    runs.iter_mut().zip(&is_bow).filter(|(_, is_bow)| !**is_bow).for_each(|(run, _)| run.rise = 0.0);
    // Where runs meet.
    let meeting: Vec<Point> = (0..count)
        .map(|k| {
            let (before, after) = (&runs[(k + count - 1) % count], &runs[k]);
            let corner = after.from;
            match (before.rise == 0.0, after.rise == 0.0) {
                (true, true) => {
                    let near = |point: &Point| {
                        length(minus(*point, corner)) < OVERSHOOT * pen.stray + pen.blur as f32
                    };
                    before.crossing(after).filter(near).unwrap_or_else(|| {
                        let (a, b) = (before.nearest(corner), after.nearest(corner));
                        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
                    })
                }
                _ => corner,
            }
        })
        .collect();
    let mut points = Vec::new();
    for k in 0..count {
        let (before, run) = (&runs[(k + count - 1) % count], &runs[k]);
        let (from, to) = (meeting[k], meeting[(k + 1) % count]);
        let coming = minus(from, meeting[(k + count - 1) % count]);
        let going = minus(to, from);
        let turn = libm::atan2f(cross(coming, going), dot(coming, going)).abs();
        if before.rise == 0.0 && run.rise == 0.0 && turn < BLUNT {
            let cut = |run: Point| ROUNDED.min(pen.rounding / length(run).max(1e-3));
            points.push(plus(from, coming, -cut(coming)));
            points.push(plus(from, going, cut(going)));
        } else {
            points.push(from);
        }
        if run.rise != 0.0 {
            let long = length(going).max(1e-6);
            let right = [-going[1] / long, going[0] / long];
            let pieces = libm::ceilf((run.rise.abs() / FLAT).sqrt()).clamp(2.0, 8.0) as usize;
            for piece in 1..pieces {
                let t = piece as f32 / pieces as f32;
                points.push(plus(plus(from, going, t), right, run.rise * 4.0 * t * (1.0 - t)));
            }
        }
    }
    points.dedup_by(|b, a| length(minus(*a, *b)) < 0.05);
    points
}

/// Whether two stretches of a ring cross.
fn crosses_itself(ring: &[Point]) -> bool {
    let count = ring.len();
    let stretch = |k: usize| (ring[k], ring[(k + 1) % count]);
    let sides = |(a, b): (Point, Point), p: Point| cross(minus(b, a), minus(p, a)) > 0.0;
    (0..count).any(|i| {
        let one = stretch(i);
        let (low, high) = (one.0[0].min(one.1[0]), one.0[0].max(one.1[0]));
        (i + 2..count).filter(|&j| (j + 1) % count != i).any(|j| {
            let other = stretch(j);
            if other.0[0].max(other.1[0]) < low || other.0[0].min(other.1[0]) > high {
                return false;
            }
            sides(one, other.0) != sides(one, other.1) && sides(other, one.0) != sides(other, one.1)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::masses::{Planes, masses, steps};

    fn drawn(features: &Raster<[f32; 3]>, attention: f32, long_edge: f64) -> (Masses, Vec<Contour>) {
        let plane = |value: f32| Raster::new(features.width(), features.height(), value);
        let (attention, calm) = (plane(attention), plane(0.0));
        let found = masses(&Planes {
            features,
            steps: &steps(features, long_edge),
            attention: &attention,
            foliage: &calm,
            busy: &calm,
            long_edge,
            coarseness: 1.0,
        });
        let contours = contours(&found, long_edge, 1.0);
        (found, contours)
    }

    #[test]
    fn two_halves_share_a_straight_contour() {
        let halves = Raster::from_fn(300, 200, |x, _| [if x < 130 { 30.0 } else { 70.0 }, 0.0, 0.0]);
        let (_, contours) = drawn(&halves, 0.3, 300.0);
        let [ground, half] = &contours[..] else { panic!("{contours:?}") };
        assert_eq!((ground.mass, half.mass), (1, 0));
        assert_eq!(ground.rings[0].len(), 4);
        let [ring] = &half.rings[..] else { panic!("{:?}", half.rings) };
        assert!(ring.len() <= 8, "{ring:?}");
        let border: Vec<_> = ring.iter().filter(|point| point[0] > 60.0).collect();
        assert!(border.iter().all(|point| (point[0] - 130.0).abs() < 0.3), "{ring:?}");
    }

    #[test]
    fn a_slanting_edge_is_one_run() {
        let slanted =
            Raster::from_fn(400, 300, |x, y| [if 10 * x + 3 * y < 1900 { 30.0 } else { 70.0 }, 0.0, 0.0]);
        let (_, contours) = drawn(&slanted, 1.0, 400.0);
        let ring = &contours[1].rings[0];
        assert!(ring.len() <= 8, "{ring:?}");
        let inside = ring.iter().filter(|point| point[0] > 50.0 && (0.0..300.0).contains(&point[1]));
        inside.for_each(|[x, y]| assert!((10.0 * x + 3.0 * y - 1905.0).abs() < 8.0, "{x} {y}"));
    }

    #[test]
    fn a_disc_stays_round() {
        for (radius, attention) in [(20.0f32, 1.0), (60.0, 0.5), (110.0, 0.0)] {
            let disc = Raster::from_fn(400, 300, |x, y| {
                let (x, y) = (x as f32 + 0.5 - 200.0, y as f32 + 0.5 - 150.0);
                [if x * x + y * y < radius * radius { 30.0 } else { 80.0 }, 0.0, 0.0]
            });
            let (_, contours) = drawn(&disc, attention, 1100.0);
            let [ring] = &contours[1].rings[..] else { panic!("{contours:?}") };
            assert!((12..90).contains(&ring.len()), "{}", ring.len());
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                for part in [0.0, 0.5] {
                    let [x, y] = [0, 1].map(|k: usize| a[k] + part * (b[k] - a[k]));
                    let off = libm::hypotf(x - 200.0, y - 150.0) - radius;
                    assert!(off.abs() < 1.0, "radius {radius}: {off} {ring:?}");
                }
            }
        }
    }

    #[test]
    fn a_mast_keeps_its_width() {
        let mast = Raster::from_fn(400, 300, |x, y| {
            [if (198..202).contains(&x) && y > 80 { 25.0 } else { 80.0 }, 0.0, 0.0]
        });
        let (found, contours) = drawn(&mast, 0.0, 1100.0);
        assert_eq!(found.masses.len(), 2);
        let area: f32 = contours[1].rings.iter().map(|ring| area(ring).abs()).sum();
        // The ring goes a few cells beyond the raster.
        assert!((0.9..1.15).contains(&(area / (4.0 * 219.0))), "{area}");
    }

    #[test]
    fn nothing_is_left_unpainted_and_threads_do_not_matter() {
        let picture = Raster::from_fn(200, 150, |x, y| {
            let bits = girtin_grid::random::at(5, [(x as i64 + y as i64 / 3) / 23, y as i64 / 31]);
            [girtin_grid::random::between(bits, 5.0, 95.0) as f32, 0.0, 0.0]
        });
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| drawn(&picture, 0.4, 600.0))
        };
        let (found, contours) = with(1);
        assert_eq!(with(3).1, contours);
        assert!(found.masses.len() > 10);
        assert_eq!(contours.iter().filter(|contour| contour.rings.is_empty()).count(), 0);
        assert!(contours.iter().flat_map(|contour| &contour.rings).all(|ring| !crosses_itself(ring)));
    }

    #[test]
    fn rings_go_around_what_is_inside() {
        let ring = Raster::from_fn(40, 40, |x, y| {
            let off = x.abs_diff(20).max(y.abs_diff(20));
            f32::from(u8::from((5..14).contains(&off)))
        });
        let rings = traced(&ring);
        let mut areas: Vec<f32> = rings.iter().map(|ring| area(ring)).collect();
        areas.sort_by(f32::total_cmp);
        assert_eq!(areas.len(), 2);
        assert!((areas[0] + 80.5).abs() < 1.5 && (areas[1] - 728.5).abs() < 1.5, "{areas:?}");
    }
}
