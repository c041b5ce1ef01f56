//! The masses of a picture: things of one color that a painter would draw as one shape.
//!
//! Small segments are merged, the cheapest pair first, and the further the less they are looked at. What is left over gives
//! way: crumbs, strips that are only the lens's blur, islands without direction. Thin lines that stand out stay.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use girtin_grid::Raster;
use girtin_grid::blur::gaussian;

use crate::segments::{Sets, segments};
use crate::texture::slope;

/// How large segments like to be, Lab × cells; and their least area, a part of the long edge squared, and cells.
const SEGMENT: f32 = 3.1;
const LEAST_SEGMENT: f64 = 2.2e-5;
const LEAST_CELLS: f64 = 12.0;

/// Blur before steps are measured, and the distance they are made over, parts of the long edge.
const STEP_BLUR: f64 = 0.0016;
const STEP_OVER: f64 = 0.005;

/// How much more a difference of hue counts than one of tone.
const HUE: f32 = 1.15;
/// How much the difference of two masses counts for the cost of merging them, and how much the step between them.
const BY_COLOR: f32 = 0.6;
const BY_STEP: f32 = 0.4;
/// How much of the difference counts where there is no step, as in a sky; and the step below which there is none, Lab.
const SOFT: f32 = 0.4;
const NO_STEP: f32 = 4.0;
/// Area, of the common one, from which on masses cost so much more where there is a step between them all along: a horizon.
const LARGE: f32 = 5.0;
const CRISP: f32 = 0.6;
/// Parts of a sky cost this much of others: calm, light masses at the top, so large, parts of the long edge squared. What rises
/// into a sky leaves but a neck between its parts, where the step is that of the thing.
const SKY_COST: f32 = 0.25;
const SKY_AREA: f64 = 0.01;
const SKY_BUSY: f32 = 0.25;
const SKY_LIGHT: f32 = 55.0;
/// Area, a part of the long edge squared, at which the cost is the difference; and how it grows with area.
const COMMON: f64 = 1e-3;
const GROWTH: f32 = 0.2;

/// Cost up to which masses merge, Lab: where the eye rests, less where it rests most, more where it does not, there more
/// if all is calm, and in foliage.
const TOLERANCE: f32 = 8.5;
const LESS_AT_FOCUS: f32 = 2.0;
const FOCUS: [f32; 2] = [0.8, 1.0];
const MORE_ASIDE: f32 = 14.0;
const ASIDE_GROWTH: f32 = 1.2;
const MORE_IN_CALM: f32 = 3.5;
const MORE_IN_FOLIAGE: f32 = 4.0;

/// A line is this many times as long as wide, and so much longer where nobody looks, parts of the long edge; it stays beside
/// what differs by so much, Lab, or more in foliage, where lines are many.
const LINE: f32 = 6.0;
const LINE_LENGTH: f32 = 0.012;
const LINE_LENGTH_ASIDE: f32 = 0.018;
const LINE_DIFFERS: f32 = 12.0;
const LINE_DIFFERS_IN_FOLIAGE: f32 = 14.0;

/// Area below which a mass is a crumb, parts of the long edge squared; more where nobody looks, less if it differs by more
/// than so much, Lab.
const CRUMB: f32 = 1.4e-4;
const CRUMB_ASIDE: f32 = 1.5e-3;
const CRUMB_GROWTH: f32 = 1.3;
const STRIKING: f32 = 26.0;
const STRIKING_CRUMB: f32 = 0.45;

/// Width below which a strip may be blur, parts of the long edge; more where nobody looks.
const STRIP: f32 = 0.0075;
const STRIP_ASIDE: f32 = 0.024;
/// How much of a strip's border is with the masses of either side at least, how much of the way between them its color is at
/// least and at most, and how far from that way, Lab, or parts of it.
const BOTH_SIDES: f32 = 0.2;
const ON_THE_WAY: [f32; 2] = [0.04, 0.96];
const OFF_THE_WAY: [f32; 2] = [8.0, 0.38];
/// How far the two sides differ at least, Lab: what lies between pale ones is no halo.
const LEAST_WAY: f32 = 18.0;
/// Steps inside of blur are at least this part of those at its border: it is a slope, and a thing is flat.
const SLOPE: f32 = 0.7;
const STRIP_ROUNDS: usize = 3;

/// An island is at most this elongated, has so much of its border with one neighbour, and is smaller than this, parts of
/// the long edge squared, more where nobody looks.
const ISLAND: f32 = 2.0;
const ISLAND_BORDER: f32 = 0.66;
const ISLAND_AREA: f32 = 4e-3;
const ISLAND_AREA_ASIDE: f32 = 7e-3;
/// It joins its neighbour if it differs by less, Lab: where the eye rests, more where it does not, more if it is enclosed,
/// and less where the eye rests most.
const ISLAND_DIFFERS: f32 = 10.0;
const ISLAND_DIFFERS_ASIDE: f32 = 10.0;
const ENCLOSED: f32 = 0.97;
const ISLAND_DIFFERS_ENCLOSED: f32 = 5.0;
const ISLAND_AT_FOCUS: f32 = 0.9;
const ISLAND_DIFFERS_AT_FOCUS: f32 = -7.0;

/// A mass, means over its cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mass {
    /// Cells.
    pub area: f64,
    /// Tone and hue: L, a, b.
    pub mean: [f32; 3],
    /// How exactly it is drawn, 0 to 1.
    pub attention: f32,
    /// How much of it is foliage, 0 to 1.
    pub foliage: f32,
    /// How busy it is, 0 to 1.
    pub busy: f32,
    /// Its middle, cells from the raster's corner.
    pub middle: [f32; 2],
    /// How many times it is as long as wide, by the spread of its cells.
    pub elongation: f32,
    /// Direction it is long in, radians from the rows downward.
    pub direction: f32,
    /// Width it would have if it were a strip, cells: twice its area by its border.
    pub width: f32,
    /// First column and row, and one beyond the last.
    pub bounds: [[usize; 2]; 2],
}

/// A mass beside another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Which.
    pub mass: usize,
    /// Length of the common border, sides of cells.
    pub length: f64,
    /// Mean step of the photograph along it, Lab.
    pub step: f32,
}

/// The masses of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Masses {
    /// Which mass each cell is of.
    pub labels: Raster<u32>,
    /// All masses, in the order of their first cells.
    pub masses: Vec<Mass>,
    /// The neighbours of each, by number.
    pub neighbours: Vec<Vec<Neighbour>>,
}

/// How much the Lab photograph changes at each cell over a short distance, Lab.
pub fn steps(lab: &Raster<[f32; 3]>, long_edge: f64) -> Raster<f32> {
    let calm = gaussian(lab, STEP_BLUR * long_edge);
    let over = (STEP_OVER * long_edge) as f32;
    let channels = [0, 1, 2].map(|c: usize| calm.map(|color| color[c]));
    Raster::by_rows(lab.width(), lab.height(), |x, y| {
        let squares = channels.each_ref().map(|channel| {
            let [gx, gy] = slope(channel, x, y);
            gx * gx + gy * gy
        });
        over * squares.iter().sum::<f32>().sqrt()
    })
}

/// What masses are found in; planes of one size.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'a> {
    /// The planned tone and hue of each cell: L, a, b.
    pub features: &'a Raster<[f32; 3]>,
    /// How much the photograph changes there, see [`steps`].
    pub steps: &'a Raster<f32>,
    /// How exactly it is drawn, 0 to 1.
    pub attention: &'a Raster<f32>,
    /// How much of it is foliage, 0 to 1.
    pub foliage: &'a Raster<f32>,
    /// How busy it is, 0 to 1.
    pub busy: &'a Raster<f32>,
    /// Cells along the long edge.
    pub long_edge: f64,
    /// 1 for the usual number of masses, more for fewer.
    pub coarseness: f32,
}

/// The masses of a picture.
///
/// # Guarantees
/// The same for any number of threads; ties are broken by the order of first cells.
pub fn masses(planes: &Planes) -> Masses {
    let s = planes.long_edge;
    let least = (LEAST_SEGMENT * s * s).max(LEAST_CELLS) as usize;
    let mut labels = segments(planes.features, SEGMENT, least);
    let mut graph = Graph::new(planes, &labels);
    graph.merge_cheapest();
    graph.merge_crumbs();
    labels = graph.relabelled(&labels);
    // Blur may be several strips side by side; those whose neighbours are no strips go first.
    let mut graph = Graph::new(planes, &labels);
    for _ in 0..STRIP_ROUNDS {
        let strips = graph.strips();
        if !strips.contains(&true) {
            break;
        }
        labels = divided(&labels, planes.features, &graph, &strips);
        graph = Graph::new(planes, &labels);
    }
    graph.merge_cheapest();
    graph.merge_crumbs();
    graph.merge_islands();
    labels = graph.relabelled(&labels);
    Graph::new(planes, &labels).finished(labels)
}

/// Sums over a mass's cells.
#[derive(Clone, Copy, Debug)]
struct Patch {
    area: f64,
    mean: [f32; 3],
    attention: f32,
    foliage: f32,
    busy: f32,
    step: f32,
    /// Sums of x, y, xx, xy, yy.
    moments: [f64; 5],
    bounds: [[usize; 2]; 2],
}

impl Patch {
    const NONE: Self = Self {
        area: 0.0,
        mean: [0.0; 3],
        attention: 0.0,
        foliage: 0.0,
        busy: 0.0,
        step: 0.0,
        moments: [0.0; 5],
        bounds: [[usize::MAX; 2], [0; 2]],
    };

    fn with(&self, other: &Self) -> Self {
        let area = self.area + other.area;
        let part = (other.area / area) as f32;
        let mix = |a: f32, b: f32| a + part * (b - a);
        Self {
            area,
            mean: [0, 1, 2].map(|c: usize| mix(self.mean[c], other.mean[c])),
            attention: mix(self.attention, other.attention),
            foliage: mix(self.foliage, other.foliage),
            busy: mix(self.busy, other.busy),
            step: mix(self.step, other.step),
            moments: core::array::from_fn(|k| self.moments[k] + other.moments[k]),
            bounds: [
                [0, 1].map(|k: usize| self.bounds[0][k].min(other.bounds[0][k])),
                [0, 1].map(|k: usize| self.bounds[1][k].max(other.bounds[1][k])),
            ],
        }
    }

    fn middle(&self) -> [f64; 2] {
        [self.moments[0] / self.area, self.moments[1] / self.area]
    }

    /// Variances along and across, cells squared, and the direction along.
    fn spread(&self) -> ([f64; 2], f64) {
        let [x, y] = self.middle();
        let [_, _, xx, xy, yy] = self.moments.map(|sum| sum / self.area);
        // A cell has a spread of its own.
        let own = 1.0 / 12.0;
        let (xx, xy, yy) = ((xx - x * x).max(0.0) + own, xy - x * y, (yy - y * y).max(0.0) + own);
        let apart = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
        let across = ((xx + yy - apart) / 2.0).max(own);
        ([(xx + yy + apart) / 2.0, across], 0.5 * libm::atan2(2.0 * xy, xx - yy))
    }

    fn elongation(&self) -> f32 {
        let ([along, across], _) = self.spread();
        (along / across).sqrt() as f32
    }

    /// Length of a strip of its spread, cells.
    fn length(&self) -> f32 {
        (12.0 * self.spread().0[0]).sqrt() as f32
    }
}

fn difference(a: &Patch, b: &Patch) -> f32 {
    apart(a.mean, b.mean)
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, u, v] = [0, 1, 2].map(|c: usize| a[c] - b[c]);
    (l * l + HUE * HUE * (u * u + v * v)).sqrt()
}

/// A border: sides of cells, the sum of steps over them, and how many of them are no steps.
#[derive(Clone, Copy, Debug, Default)]
struct Border {
    sides: f64,
    steps: f64,
    soft: f64,
}

/// Masses while they merge.
struct Graph {
    patches: Vec<Patch>,
    around: Vec<BTreeMap<u32, Border>>,
    /// What each has merged into.
    sets: Sets,
    /// Sides of cells at the raster's border.
    outer: Vec<f64>,
    square: f64,
    edge: f32,
    coarseness: f32,
}

/// A pair to be merged, the cheapest first out of a heap.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    cost: f32,
    ends: [u32; 2],
    versions: [u32; 2],
}

impl Eq for Pair {}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        let tie = || other.ends.cmp(&self.ends).then(other.versions.cmp(&self.versions));
        other.cost.total_cmp(&self.cost).then_with(tie)
    }
}

impl Graph {
    fn new(planes: &Planes, labels: &Raster<u32>) -> Self {
        let (width, height) = (labels.width(), labels.height());
        let count = labels.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
        let mut sums = vec![[0.0f64; 7]; count];
        let mut patches = vec![Patch::NONE; count];
        let mut outer = vec![0.0; count];
        let mut sides: Vec<(u64, [f32; 2])> = Vec::new();
        for y in 0..height {
            let row = labels.row(y);
            for (x, &label) in row.iter().enumerate() {
                let patch = &mut patches[label as usize];
                let [l, a, b] = planes.features.row(y)[x];
                let means = [
                    l,
                    a,
                    b,
                    planes.attention.row(y)[x],
                    planes.foliage.row(y)[x],
                    planes.busy.row(y)[x],
                    planes.steps.row(y)[x],
                ];
                sums[label as usize].iter_mut().zip(means).for_each(|(sum, value)| *sum += f64::from(value));
                patch.area += 1.0;
                let (u, v) = (x as f64 + 0.5, y as f64 + 0.5);
                let moments = [u, v, u * u, u * v, v * v];
                patch.moments.iter_mut().zip(moments).for_each(|(sum, value)| *sum += value);
                patch.bounds[0] = [patch.bounds[0][0].min(x), patch.bounds[0][1].min(y)];
                patch.bounds[1] = [patch.bounds[1][0].max(x + 1), patch.bounds[1][1].max(y + 1)];
                let ends = [x == 0, x + 1 == width, y == 0, y + 1 == height];
                outer[label as usize] += ends.iter().filter(|end| **end).count() as f64;
                let mut side = |x1: usize, y1: usize| {
                    let other = labels.row(y1)[x1];
                    if other != label {
                        let (low, high) = (label.min(other), label.max(other));
                        let steps = [planes.steps.row(y)[x], planes.steps.row(y1)[x1]];
                        sides.push((u64::from(low) << 32 | u64::from(high), steps));
                    }
                };
                if x + 1 < width {
                    side(x + 1, y);
                }
                if y + 1 < height {
                    side(x, y + 1);
                }
            }
        }
        for (patch, sums) in patches.iter_mut().zip(&sums) {
            let [l, a, b, attention, foliage, busy, step] = sums.map(|sum| (sum / patch.area) as f32);
            patch.mean = [l, a, b];
            (patch.attention, patch.foliage, patch.busy, patch.step) = (attention, foliage, busy, step);
        }
        let mut around: Vec<BTreeMap<u32, Border>> = vec![BTreeMap::new(); count];
        sides.sort_by_key(|side| side.0);
        for same in sides.chunk_by(|a, b| a.0 == b.0) {
            let steps = same.iter().map(|(_, [a, b])| f64::from(a.max(*b))).sum();
            let soft = same.iter().filter(|(_, [a, b])| a.max(*b) < NO_STEP).count() as f64;
            let border = Border { sides: same.len() as f64, steps, soft };
            let (low, high) = ((same[0].0 >> 32) as u32, same[0].0 as u32);
            around[low as usize].insert(high, border);
            around[high as usize].insert(low, border);
        }
        let s = planes.long_edge;
        Self {
            patches,
            around,
            sets: Sets::new(count),
            outer,
            square: s * s,
            edge: s as f32,
            coarseness: planes.coarseness,
        }
    }

    fn alive(&mut self, mass: u32) -> bool {
        self.sets.of(mass) == mass
    }

    /// Whether a mass is a thin line that stands out from another beside it.
    fn is_line_on(&self, line: u32, other: u32) -> bool {
        let (line, other) = (&self.patches[line as usize], &self.patches[other as usize]);
        line.area < other.area
            && line.elongation() > LINE
            && line.length() > (LINE_LENGTH + LINE_LENGTH_ASIDE * (1.0 - line.attention)) * self.edge
            && difference(line, other) > LINE_DIFFERS + LINE_DIFFERS_IN_FOLIAGE * line.foliage
    }

    fn keep_apart(&self, a: u32, b: u32) -> bool {
        self.is_line_on(a, b) || self.is_line_on(b, a)
    }

    /// Cost of a merger; it is made if this is 1 at most.
    fn cost(&self, a: u32, b: u32, border: Border) -> f32 {
        let (one, other) = (&self.patches[a as usize], &self.patches[b as usize]);
        let step = (border.steps / border.sides) as f32;
        let smaller = (one.area.min(other.area) / (COMMON * self.square)) as f32;
        let hard = 1.0 - (1.0 - SOFT) * (border.soft / border.sides) as f32;
        let cost = (BY_COLOR * hard * difference(one, other) + BY_STEP * step) * libm::powf(smaller, GROWTH);
        let seen = one.attention.max(other.attention).min(1.0);
        let aside = 1.0 - seen;
        let focus = ((seen - FOCUS[0]) / (FOCUS[1] - FOCUS[0])).max(0.0);
        let tolerance = TOLERANCE - LESS_AT_FOCUS * focus
            + MORE_ASIDE * libm::powf(aside, ASIDE_GROWTH)
            + MORE_IN_CALM * aside * (1.0 - one.busy.max(other.busy))
            + MORE_IN_FOLIAGE * aside * one.foliage.min(other.foliage);
        let sky = if self.is_sky(one) && self.is_sky(other) { SKY_COST } else { 1.0 };
        let crisp =
            if smaller > LARGE { 1.0 + CRISP * (1.0 - (border.soft / border.sides) as f32) } else { 1.0 };
        sky * crisp * cost / (tolerance * self.coarseness)
    }

    fn is_sky(&self, mass: &Patch) -> bool {
        mass.bounds[0][1] == 0
            && mass.area > SKY_AREA * self.square
            && mass.busy < SKY_BUSY
            && mass.mean[0] > SKY_LIGHT
    }

    /// Merges two masses; returns the one they are.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let kept = self.sets.join(a, b);
        let gone = if kept == a { b } else { a };
        self.patches[kept as usize] = self.patches[kept as usize].with(&self.patches[gone as usize]);
        self.outer[kept as usize] += self.outer[gone as usize];
        self.around[kept as usize].remove(&gone);
        for (other, border) in std::mem::take(&mut self.around[gone as usize]) {
            if other == kept {
                continue;
            }
            self.around[other as usize].remove(&gone);
            let both = self.around[kept as usize].entry(other).or_default();
            both.sides += border.sides;
            both.steps += border.steps;
            both.soft += border.soft;
            let both = *both;
            self.around[other as usize].insert(kept, both);
        }
        kept
    }

    fn merge_cheapest(&mut self) {
        let mut heap = BinaryHeap::new();
        let mut versions = vec![0u32; self.patches.len()];
        for (a, around) in self.around.iter().enumerate() {
            for (&b, &border) in around.range(a as u32 + 1..) {
                let cost = self.cost(a as u32, b, border);
                if cost <= 1.0 {
                    heap.push(Pair { cost, ends: [a as u32, b], versions: [0; 2] });
                }
            }
        }
        while let Some(Pair { ends: [a, b], versions: then, .. }) = heap.pop() {
            let now = [a, b].map(|mass| versions[mass as usize]);
            if now != then || !self.alive(a) || !self.alive(b) || self.keep_apart(a, b) {
                continue;
            }
            let kept = self.join(a, b);
            versions[a as usize] += 1;
            versions[b as usize] += 1;
            for (&other, &border) in &self.around[kept as usize] {
                let cost = self.cost(kept, other, border);
                if cost <= 1.0 {
                    let ends = [kept.min(other), kept.max(other)];
                    heap.push(Pair { cost, ends, versions: ends.map(|mass| versions[mass as usize]) });
                }
            }
        }
    }

    /// All masses there are, the smallest first.
    fn smallest_first(&mut self) -> Vec<u32> {
        let mut all: Vec<u32> = (0..self.patches.len() as u32).filter(|&mass| self.alive(mass)).collect();
        all.sort_by(|&a, &b| {
            self.patches[a as usize].area.total_cmp(&self.patches[b as usize].area).then(a.cmp(&b))
        });
        all
    }

    /// The neighbour that is most alike, and by how much it differs.
    fn likest(&self, mass: u32) -> Option<(u32, f32)> {
        let own = &self.patches[mass as usize];
        let differing = self.around[mass as usize]
            .keys()
            .map(|&other| (other, difference(own, &self.patches[other as usize])));
        differing.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
    }

    /// Crumbs join what is most like them.
    fn merge_crumbs(&mut self) {
        for mass in self.smallest_first() {
            if !self.alive(mass) {
                continue;
            }
            let own = self.patches[mass as usize];
            let aside = 1.0 - own.attention.min(1.0);
            let mut least = (CRUMB + CRUMB_ASIDE * libm::powf(aside, CRUMB_GROWTH)) * self.coarseness;
            let Some((other, differs)) = self.likest(mass) else { continue };
            if differs > STRIKING {
                least *= STRIKING_CRUMB;
            }
            let is_crumb = own.area < f64::from(least) * self.square;
            if is_crumb && !self.keep_apart(mass, other) {
                self.join(mass, other);
            }
        }
    }

    /// Sides of all borders of a mass.
    fn perimeter(&self, mass: u32) -> f64 {
        self.around[mass as usize].values().map(|border| border.sides).sum()
    }

    /// Which masses are strips between a lighter and a darker side: the lens's blur, and no things.
    fn strips(&self) -> Vec<bool> {
        (0..self.patches.len() as u32)
            .map(|mass| {
                let own = &self.patches[mass as usize];
                let all = self.perimeter(mass);
                let widest = (STRIP + STRIP_ASIDE * (1.0 - own.attention)) * self.edge;
                if 2.0 * own.area > f64::from(widest) * all || all == 0.0 {
                    return false;
                }
                self.is_between(mass, all)
            })
            .collect()
    }

    /// Whether a mass's color lies between those of its two sides, and it slopes from one to the other; `all` is its border.
    fn is_between(&self, mass: u32, all: f64) -> bool {
        let own = &self.patches[mass as usize];
        // The two sides: the larger masses that are lighter, and those that are darker.
        let (mut shares, mut sides, mut steps) = ([0.0f32; 2], [[0.0f32; 3]; 2], 0.0);
        for (&other, border) in &self.around[mass as usize] {
            let other = &self.patches[other as usize];
            // What is as thin may be a strip itself.
            if other.area < own.area {
                continue;
            }
            let side = usize::from(other.mean[0] > own.mean[0]);
            let share = (border.sides / all) as f32;
            shares[side] += share;
            steps += (border.steps / all) as f32;
            sides[side].iter_mut().zip(other.mean).for_each(|(sum, value)| *sum += share * value);
        }
        if shares.iter().any(|&share| share < BOTH_SIDES)
            || own.step * (shares[0] + shares[1]) < SLOPE * steps
        {
            return false;
        }
        let [from, to] = [0, 1].map(|side: usize| sides[side].map(|sum| sum / shares[side]));
        let way = [0, 1, 2].map(|c: usize| to[c] - from[c]);
        let off = [0, 1, 2].map(|c: usize| own.mean[c] - from[c]);
        let square: f32 = way.iter().map(|value| value * value).sum();
        let part = way.iter().zip(off).map(|(a, b)| a * b).sum::<f32>() / square.max(1e-6);
        let on_way = [0, 1, 2].map(|c: usize| from[c] + part * way[c]);
        square > LEAST_WAY * LEAST_WAY
            && (ON_THE_WAY[0]..=ON_THE_WAY[1]).contains(&part)
            && apart(own.mean, on_way) < OFF_THE_WAY[0].max(OFF_THE_WAY[1] * square.sqrt())
    }

    /// Islands without direction join what is around them.
    fn merge_islands(&mut self) {
        for mass in self.smallest_first() {
            if !self.alive(mass) {
                continue;
            }
            let own = self.patches[mass as usize];
            let aside = 1.0 - own.attention.min(1.0);
            let largest = f64::from((ISLAND_AREA + ISLAND_AREA_ASIDE * aside) * self.coarseness);
            if own.area > largest * self.square || own.elongation() > ISLAND {
                continue;
            }
            let all = self.perimeter(mass) + self.outer[mass as usize];
            let most = self.around[mass as usize]
                .iter()
                .max_by(|a, b| a.1.sides.total_cmp(&b.1.sides).then(b.0.cmp(a.0)));
            let Some((&other, border)) = most else { continue };
            let share = (border.sides / all) as f32;
            let mut differs = ISLAND_DIFFERS + ISLAND_DIFFERS_ASIDE * aside;
            if share > ENCLOSED {
                differs += ISLAND_DIFFERS_ENCLOSED;
            }
            if own.attention > ISLAND_AT_FOCUS {
                differs += ISLAND_DIFFERS_AT_FOCUS;
            }
            let is_like = difference(&own, &self.patches[other as usize]) < differs * self.coarseness;
            if share > ISLAND_BORDER && is_like {
                self.join(mass, other);
            }
        }
    }

    /// The labels after merging, numbered from 0 in the order of first cells.
    fn relabelled(&mut self, labels: &Raster<u32>) -> Raster<u32> {
        renumbered(&labels.map(|label| self.sets.of(label)))
    }

    fn finished(self, labels: Raster<u32>) -> Masses {
        let mass = |(number, patch): (usize, &Patch)| {
            let (_, direction) = patch.spread();
            let border = self.perimeter(number as u32).max(1.0);
            Mass {
                area: patch.area,
                mean: patch.mean,
                attention: patch.attention,
                foliage: patch.foliage,
                busy: patch.busy,
                middle: patch.middle().map(|at| at as f32),
                elongation: patch.elongation(),
                direction: direction as f32,
                width: (2.0 * patch.area / border) as f32,
                bounds: patch.bounds,
            }
        };
        let neighbour = |(&mass, border): (&u32, &Border)| Neighbour {
            mass: mass as usize,
            length: border.sides,
            step: (border.steps / border.sides) as f32,
        };
        Masses {
            labels,
            masses: self.patches.iter().enumerate().map(mass).collect(),
            neighbours: self.around.iter().map(|around| around.iter().map(neighbour).collect()).collect(),
        }
    }
}

/// Labels numbered from 0 in the order of first cells.
fn renumbered(labels: &Raster<u32>) -> Raster<u32> {
    let most = labels.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
    let mut numbers = vec![u32::MAX; most];
    let mut count = 0;
    labels.map(|label| {
        let number = &mut numbers[label as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        *number
    })
}

/// A cell of a strip that a mass beside it may take, the likest first out of a heap.
type Claim = (core::cmp::Reverse<(u32, u32)>, u32);

/// The labels with the cells of strips given to the masses at their sides, each to the likest that it hangs together with.
fn divided(labels: &Raster<u32>, features: &Raster<[f32; 3]>, graph: &Graph, strips: &[bool]) -> Raster<u32> {
    const PER_UNIT: f32 = 256.0;
    let (width, height) = (labels.width(), labels.height());
    let mut divided = labels.clone();
    let mut open: Vec<bool> = labels.as_slice().iter().map(|&label| strips[label as usize]).collect();
    let mut heap: BinaryHeap<Claim> = BinaryHeap::new();
    let mut order = 0;
    let mut claim = |heap: &mut BinaryHeap<Claim>, cell: usize, label: u32| {
        let differs = apart(features.as_slice()[cell], graph.patches[label as usize].mean);
        heap.push((core::cmp::Reverse(((differs * PER_UNIT) as u32, order)), cell as u32));
        order += 1;
        label
    };
    // Who claims, in the order of claims.
    let mut claimants = Vec::new();
    let beside = |cell: usize| {
        let (x, y) = (cell % width, cell / width);
        let sides = [
            (x > 0).then(|| cell - 1),
            (x + 1 < width).then(|| cell + 1),
            (y > 0).then(|| cell - width),
            (y + 1 < height).then(|| cell + width),
        ];
        sides.into_iter().flatten()
    };
    for cell in 0..width * height {
        if open[cell] {
            for other in beside(cell).filter(|&other| !open[other]) {
                claimants.push(claim(&mut heap, cell, labels.as_slice()[other]));
            }
        }
    }
    while let Some((core::cmp::Reverse((_, order)), cell)) = heap.pop() {
        let cell = cell as usize;
        if !std::mem::take(&mut open[cell]) {
            continue;
        }
        let label = claimants[order as usize];
        divided.as_mut_slice()[cell] = label;
        for other in beside(cell).filter(|&other| open[other]) {
            claimants.push(claim(&mut heap, other, label));
        }
    }
    renumbered(&divided)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Masses of a picture of flat colors, all of it looked at as much.
    fn found(features: &Raster<[f32; 3]>, attention: f32, long_edge: f64) -> Masses {
        let plane = |value: f32| Raster::new(features.width(), features.height(), value);
        let (attention, calm) = (plane(attention), plane(0.0));
        masses(&Planes {
            features,
            steps: &steps(features, long_edge),
            attention: &attention,
            foliage: &calm,
            busy: &calm,
            long_edge,
            coarseness: 1.0,
        })
    }

    #[test]
    fn two_flat_halves_are_two_masses() {
        let halves = Raster::from_fn(200, 120, |x, _| [if x < 90 { 30.0 } else { 70.0 }, 0.0, 0.0]);
        let found = found(&halves, 0.5, 200.0);
        assert_eq!(found.masses.len(), 2);
        let [left, right] = [0, 1].map(|k: usize| found.masses[k]);
        assert_eq!((left.area, right.area), (90.0 * 120.0, 110.0 * 120.0));
        assert_eq!((left.middle, right.bounds), ([45.0, 60.0], [[90, 0], [200, 120]]));
        assert!((left.mean[0] - 30.0).abs() < 1e-3);
        let [beside] = found.neighbours[0][..] else { panic!("{:?}", found.neighbours) };
        assert_eq!((beside.mass, beside.length), (1, 120.0));
        assert!(beside.step > 5.0);
    }

    #[test]
    fn a_thin_mast_stays_and_a_crumb_does_not() {
        let sky = Raster::from_fn(300, 300, |x, y| match (x, y) {
            (150..153, 60..240) => [30.0, 0.0, 0.0],
            (40..46, 40..46) => [60.0, 0.0, 0.0],
            _ => [80.0, 0.0, -5.0],
        });
        let found = found(&sky, 0.0, 300.0);
        assert_eq!(found.masses.len(), 2, "{:?}", found.masses);
        let mast = found.masses[1];
        assert!((mast.area - 540.0).abs() < 60.0 && mast.elongation > 20.0, "{mast:?}");
        assert!((mast.direction.abs() - core::f32::consts::FRAC_PI_2).abs() < 0.05);
    }

    #[test]
    fn the_lens_s_blur_is_no_mass() {
        let blurred = Raster::from_fn(300, 200, |x, _| {
            let part = ((x as f32 - 145.0) / 10.0).clamp(0.0, 1.0);
            [20.0 + 60.0 * libm::roundf(3.0 * part) / 3.0, 0.0, 0.0]
        });
        let found = found(&blurred, 0.3, 600.0);
        assert_eq!(found.masses.len(), 2, "{:?}", found.masses);
        assert!((found.masses[0].area / 200.0 - 150.0).abs() < 3.0);
    }

    #[test]
    fn a_pale_island_joins_what_is_around_it() {
        let pale = Raster::from_fn(300, 200, |x, y| {
            let (x, y) = (x as f32 - 150.0, y as f32 - 100.0);
            [if x * x + y * y < 100.0 { 60.0 } else { 72.0 }, 0.0, 0.0]
        });
        assert_eq!(found(&pale, 0.0, 300.0).masses.len(), 1);
        assert_eq!(found(&pale, 1.0, 300.0).masses.len(), 2);
    }

    #[test]
    fn any_number_of_threads_finds_the_same() {
        let picture = Raster::from_fn(160, 120, |x, y| {
            let bits = girtin_grid::random::at(3, [x as i64 / 9, y as i64 / 7]);
            [girtin_grid::random::between(bits, 10.0, 90.0) as f32, 0.0, 5.0]
        });
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| found(&picture, 0.4, 160.0))
        };
        assert_eq!(with(1), with(3));
    }
}
