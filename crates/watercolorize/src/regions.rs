//! Shapes whose borders are hard edges: over-segmented, smoothed, and merged wherever the picture changes softly.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use girtin_grid::Raster;
use girtin_grid::morphology::dilated;
use rayon::prelude::*;

/// Regions, by number.
pub type Regions = Raster<u32>;

/// How regions are found.
#[derive(Clone, Copy, Debug)]
pub struct Finding {
    /// How large regions like to be, Lab × cells: a larger one tells fewer apart.
    pub scale: f32,
    /// Least cells of a region.
    pub least_cells: usize,
    /// Radius over which borders are rounded, cells.
    pub rounding: f64,
    /// Root mean square step over a border, Lab, below which two regions are one.
    pub least_step: f32,
}

/// The regions of a Lab picture; `steps` is how much it changes around each cell, see [`steps`].
pub fn regions(lab: &Raster<[f32; 3]>, steps: &Raster<f32>, finding: &Finding) -> Regions {
    let fine = oversegmented(lab, finding.scale, finding.least_cells);
    let (round, _) = voted(&fine, finding.rounding);
    merged(&connected(&round), steps, finding.least_step)
}

/// How much a Lab picture changes over a distance, the most of four directions.
pub fn steps(lab: &Raster<[f32; 3]>, distance: f64) -> Raster<f32> {
    let (width, height) = (lab.width(), lab.height());
    let half = (distance / 2.0).max(1.0);
    let (straight, slant) =
        (libm::round(half) as isize, libm::round(half / core::f64::consts::SQRT_2) as isize);
    let slant = slant.max(1);
    let directions = [(straight, 0), (0, straight), (slant, slant), (slant, -slant)];
    let cells: Vec<f32> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let at = move |x: isize, y: isize| {
                lab.at(x.clamp(0, width as isize - 1) as usize, y.clamp(0, height as isize - 1) as usize)
            };
            (0..width).map(move |x| {
                let (x, y) = (x as isize, y as isize);
                let step = |(dx, dy): (isize, isize)| distance_of(at(x + dx, y + dy), at(x - dx, y - dy));
                directions.map(step).into_iter().fold(0.0f32, f32::max)
            })
        })
        .collect();
    Raster::from_vec(width, height, cells).unwrap_or_else(|| unreachable!("a step for each cell"))
}

fn distance_of(a: [f32; 3], b: [f32; 3]) -> f32 {
    let square: f32 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    square.sqrt()
}

/// Sets of cells that grow together.
struct Sets {
    parent: Vec<u32>,
    size: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect(), size: vec![1; count] }
    }

    fn of(&mut self, mut at: u32) -> u32 {
        while self.parent[at as usize] != at {
            let above = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = above;
            at = above;
        }
        at
    }

    /// Joins two sets; returns the set they are.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (large, small) = if self.size[a as usize] >= self.size[b as usize] { (a, b) } else { (b, a) };
        self.parent[small as usize] = large;
        self.size[large as usize] += self.size[small as usize];
        large
    }

    /// Numbers from 0 in the order of first cells.
    fn numbered(mut self, width: usize, height: usize) -> Regions {
        let mut numbers = vec![u32::MAX; self.parent.len()];
        let mut count = 0;
        Raster::from_fn(width, height, |x, y| {
            let set = self.of((y * width + x) as u32) as usize;
            if numbers[set] == u32::MAX {
                numbers[set] = count;
                count += 1;
            }
            numbers[set]
        })
    }
}

/// Steps of Lab that are told apart when pairs of cells are sorted.
const LEVELS: usize = 1 << 14;

/// Cells joined where they differ less than inside what is joined already.
///
/// # Source
/// Felzenszwalb and Huttenlocher, *Efficient Graph-Based Image Segmentation*, 2004.
fn oversegmented(lab: &Raster<[f32; 3]>, scale: f32, least_cells: usize) -> Regions {
    let (width, height) = (lab.width(), lab.height());
    let mut pairs: Vec<(u32, u32, f32)> = Vec::with_capacity(2 * width * height);
    for y in 0..height {
        for x in 0..width {
            let at = (y * width + x) as u32;
            if x + 1 < width {
                pairs.push((at, at + 1, distance_of(lab.at(x, y), lab.at(x + 1, y))));
            }
            if y + 1 < height {
                pairs.push((at, at + width as u32, distance_of(lab.at(x, y), lab.at(x, y + 1))));
            }
        }
    }
    let pairs = by_step(pairs);
    let mut sets = Sets::new(width * height);
    let mut inner = vec![0.0f32; width * height];
    for &(a, b, step) in &pairs {
        let (a, b) = (sets.of(a), sets.of(b));
        let allowed = |set: u32| inner[set as usize] + scale / sets.size[set as usize] as f32;
        if a != b && step <= allowed(a).min(allowed(b)) {
            let joined = sets.join(a, b);
            inner[joined as usize] = step;
        }
    }
    for &(a, b, _) in &pairs {
        let (a, b) = (sets.of(a), sets.of(b));
        let is_small = |set: u32| (sets.size[set as usize] as usize) < least_cells;
        if a != b && (is_small(a) || is_small(b)) {
            sets.join(a, b);
        }
    }
    sets.numbered(width, height)
}

/// Pairs in the order of their steps, in time linear in pairs.
fn by_step(pairs: Vec<(u32, u32, f32)>) -> Vec<(u32, u32, f32)> {
    let level = |step: f32| ((step * 100.0) as usize).min(LEVELS - 1);
    let mut starts = vec![0usize; LEVELS + 1];
    pairs.iter().for_each(|pair| starts[level(pair.2) + 1] += 1);
    for k in 0..LEVELS {
        starts[k + 1] += starts[k];
    }
    let mut sorted = vec![(0, 0, 0.0); pairs.len()];
    for pair in pairs {
        let start = &mut starts[level(pair.2)];
        sorted[*start] = pair;
        *start += 1;
    }
    sorted
}

/// Regions that hang together by the sides of their cells.
pub fn connected<L: Copy + PartialEq>(labels: &Raster<L>) -> Regions {
    let (width, height) = (labels.width(), labels.height());
    let mut sets = Sets::new(width * height);
    for y in 0..height {
        for x in 0..width {
            let (at, own) = ((y * width + x) as u32, labels.at(x, y));
            if x + 1 < width && labels.at(x + 1, y) == own {
                let (a, b) = (sets.of(at), sets.of(at + 1));
                if a != b {
                    sets.join(a, b);
                }
            }
            if y + 1 < height && labels.at(x, y + 1) == own {
                let (a, b) = (sets.of(at), sets.of(at + width as u32));
                if a != b {
                    sets.join(a, b);
                }
            }
        }
    }
    sets.numbered(width, height)
}

/// Labels rounded off, each cell to the label of most cells around it by a Gaussian's weights, and how far inside its
/// shape the middle of each cell then is, cells, 8 at most.
pub fn voted<L: Copy + PartialEq + Send + Sync>(labels: &Raster<L>, sigma: f64) -> (Raster<L>, Raster<f32>) {
    voted_in_parts(labels, None, sigma)
}

/// [`voted`], with cells at borders voting for both sides as their color in the Lab picture is mixed of them: borders then
/// run between cells as the picture shows them.
pub fn voted_as_seen<L: Copy + PartialEq + Send + Sync>(
    labels: &Raster<L>,
    lab: &Raster<[f32; 3]>,
    sigma: f64,
) -> (Raster<L>, Raster<f32>) {
    let (width, height) = (labels.width(), labels.height());
    let beside = Raster::by_rows(width, height, |x, y| beside(labels, lab, x, y));
    voted_in_parts(labels, Some(&beside), sigma)
}

/// Distance between the colors of two sides, Lab, from which and up to which a cell's own color tells how it is shared.
const TOLD_APART: [f32; 2] = [8.0, 20.0];

/// How far to each side the colors of two shapes are looked for, cells.
const SIDE: isize = 2;

/// The other label that a cell belongs to, and how much of the cell it has.
fn beside<L: Copy + PartialEq>(labels: &Raster<L>, lab: &Raster<[f32; 3]>, x: usize, y: usize) -> (L, f32) {
    let (width, height) = (labels.width() as isize, labels.height() as isize);
    let own = labels.at(x, y);
    let (x, y) = (x as isize, y as isize);
    let at = |dx: isize, dy: isize| {
        let (x, y) = ((x + dx).clamp(0, width - 1), (y + dy).clamp(0, height - 1));
        (x as usize, y as usize)
    };
    let across = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| at(dx, dy));
    let Some(other) = across.map(|(x, y)| labels.at(x, y)).into_iter().find(|label| *label != own) else {
        return (own, 0.0);
    };
    let (mut sides, mut counts) = ([[0.0f32; 3]; 2], [0.0f32; 2]);
    for dy in -SIDE..=SIDE {
        for dx in -SIDE..=SIDE {
            let (x, y) = at(dx, dy);
            let label = labels.at(x, y);
            // Cells at the border itself are mixed; they count little.
            let weight = if dx.abs().max(dy.abs()) < SIDE { 0.1 } else { 1.0 };
            for (side, _) in [own, other].iter().enumerate().filter(|(_, of)| **of == label) {
                counts[side] += weight;
                sides[side].iter_mut().zip(lab.at(x, y)).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
    let [own, far] = [0, 1].map(|side: usize| sides[side].map(|sum| sum / counts[side].max(1e-6)));
    let apart = distance_of(own, far);
    let trust = ((apart - TOLD_APART[0]) / (TOLD_APART[1] - TOLD_APART[0])).clamp(0.0, 1.0);
    let color = lab.at(x as usize, y as usize);
    let along: f32 = (0..3).map(|c| (color[c] - own[c]) * (far[c] - own[c])).sum();
    (other, trust * (along / (apart * apart).max(1e-6)).clamp(0.0, 1.0))
}

/// [`voted`]; `beside` is another label of each cell, and what part of the cell's vote it has.
fn voted_in_parts<L: Copy + PartialEq + Send + Sync>(
    labels: &Raster<L>,
    beside: Option<&Raster<(L, f32)>>,
    sigma: f64,
) -> (Raster<L>, Raster<f32>) {
    let (width, height) = (labels.width(), labels.height());
    let sigma = sigma.max(0.3);
    let radius = libm::ceil(2.0 * sigma) as usize;
    let weights = girtin_grid::blur::gaussian_weights(sigma, radius);
    // Farther inside the label cannot lose its vote.
    let near = near_borders(labels, libm::ceil(1.5 * sigma) as usize);
    // Across a straight border the difference of two votes grows so with distance.
    let to_cells = (sigma * libm::sqrt(2.0 * core::f64::consts::PI) / 2.0) as f32;
    let cells: Vec<(L, f32)> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let (weights, near) = (&weights, &near);
            let mut votes: Vec<(L, f32)> = Vec::new();
            (0..width)
                .map(move |x| {
                    if near.at(x, y) == 0 {
                        return (labels.at(x, y), FARTHEST);
                    }
                    votes.clear();
                    for (dy, wy) in weights.iter().enumerate() {
                        let y = (y + dy).saturating_sub(radius).min(height - 1);
                        for (dx, wx) in weights.iter().enumerate() {
                            let x = (x + dx).saturating_sub(radius).min(width - 1);
                            let mut cast =
                                |label: L, weight: f32| match votes.iter_mut().find(|vote| vote.0 == label) {
                                    Some(vote) => vote.1 += weight,
                                    None => votes.push((label, weight)),
                                };
                            let (other, part) =
                                beside.map_or((labels.at(x, y), 0.0), |beside| beside.at(x, y));
                            cast(labels.at(x, y), wx * wy * (1.0 - part));
                            if part > 0.0 {
                                cast(other, wx * wy * part);
                            }
                        }
                    }
                    let mut best = votes[0];
                    let mut second = 0.0f32;
                    for vote in &votes[1..] {
                        if vote.1 > best.1 {
                            second = best.1;
                            best = *vote;
                        } else {
                            second = second.max(vote.1);
                        }
                    }
                    (best.0, ((best.1 - second) * to_cells).min(FARTHEST))
                })
                .collect::<Vec<_>>()
        })
        .collect();
    let raster = |x: usize, y: usize| cells[y * width + x];
    (
        Raster::by_rows(width, height, |x, y| raster(x, y).0),
        Raster::by_rows(width, height, |x, y| raster(x, y).1),
    )
}

/// Distances from an edge beyond this are not told apart.
pub const FARTHEST: f32 = 8.0;

/// Cells with another label within `radius`, to the sides or up and down.
fn near_borders<L: Copy + PartialEq + Send + Sync>(labels: &Raster<L>, radius: usize) -> Raster<u8> {
    let (width, height) = (labels.width(), labels.height());
    let border = Raster::by_rows(width, height, |x, y| {
        let own = labels.at(x, y);
        let differs = |x: usize, y: usize| x < width && y < height && labels.at(x, y) != own;
        let before = |x: usize, y: usize| labels.at(x, y) != own;
        u8::from(
            differs(x + 1, y)
                || differs(x, y + 1)
                || (x > 0 && before(x - 1, y))
                || (y > 0 && before(x, y - 1)),
        )
    });
    dilated(&border, radius)
}

/// A border between two regions: its cells, and the squares of what they step.
#[derive(Clone, Copy, Debug, Default)]
struct Border {
    cells: u32,
    squares: f32,
}

impl Border {
    /// Root mean square: a border that is hard in part is one.
    fn mean(self) -> f32 {
        (self.squares / self.cells as f32).sqrt()
    }
}

/// Two regions by how soft their border is; the softest comes first out of a heap.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    step: f32,
    a: u32,
    b: u32,
}

impl Eq for Pair {}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        other.step.total_cmp(&self.step).then(other.a.cmp(&self.a)).then(other.b.cmp(&self.b))
    }
}

/// Regions merged, the softest border first, while its root mean square step is below `least`.
fn merged(regions: &Regions, steps: &Raster<f32>, least: f32) -> Regions {
    let (width, height) = (regions.width(), regions.height());
    let count = regions.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
    let mut borders: Vec<BTreeMap<u32, Border>> = vec![BTreeMap::new(); count];
    for y in 0..height {
        for x in 0..width {
            let own = regions.at(x, y);
            for (x1, y1) in [(x + 1, y), (x, y + 1)] {
                if x1 >= width || y1 >= height || regions.at(x1, y1) == own {
                    continue;
                }
                let other = regions.at(x1, y1);
                let step = 0.5 * (steps.at(x, y) + steps.at(x1, y1));
                for (a, b) in [(own, other), (other, own)] {
                    let border = borders[a as usize].entry(b).or_default();
                    border.cells += 1;
                    border.squares += step * step;
                }
            }
        }
    }
    let mut heap: BinaryHeap<Pair> = BinaryHeap::new();
    for (a, around) in borders.iter().enumerate() {
        let after = around.range(a as u32 + 1..);
        heap.extend(after.map(|(&b, border)| Pair { step: border.mean(), a: a as u32, b }));
    }
    let mut sets = Sets::new(count);
    while let Some(Pair { step, a, b }) = heap.pop() {
        if step >= least {
            break;
        }
        // A pair that has merged or changed since it was pushed is stale.
        let current = borders[a as usize].get(&b).is_some_and(|border| border.mean() == step);
        if !current {
            continue;
        }
        let kept = sets.join(a, b);
        let gone = if kept == a { b } else { a };
        borders[kept as usize].remove(&gone);
        for (other, border) in std::mem::take(&mut borders[gone as usize]) {
            if other == kept {
                continue;
            }
            borders[other as usize].remove(&gone);
            let both = borders[kept as usize].entry(other).or_default();
            both.cells += border.cells;
            both.squares += border.squares;
            let both = *both;
            borders[other as usize].insert(kept, both);
            heap.push(Pair { step: both.mean(), a: kept.min(other), b: kept.max(other) });
        }
    }
    let merged = regions.map(|region| sets.of(region));
    connected(&merged)
}

/// The same regions with few numbers, 1 to 255, no two near each other alike; 0 is where `painted` is not.
pub fn colored(regions: &Regions, painted: &Raster<u8>) -> Raster<u8> {
    let (width, height) = (regions.width(), regions.height());
    let pieces = connected(&Raster::by_rows(width, height, |x, y| {
        if painted.at(x, y) == 0 { 0 } else { regions.at(x, y) + 1 }
    }));
    let count = pieces.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
    let mut near: Vec<BTreeMap<u32, ()>> = vec![BTreeMap::new(); count];
    let mut is_painted = vec![false; count];
    const REACH: isize = 2;
    for y in 0..height as isize {
        for x in 0..width as isize {
            let own = pieces.at(x as usize, y as usize);
            is_painted[own as usize] = painted.at(x as usize, y as usize) != 0;
            for (dx, dy) in [(REACH, 0), (0, REACH), (REACH, REACH), (REACH, -REACH), (1, 0), (0, 1)] {
                let (x, y) = (x + dx, y + dy);
                if x < width as isize && y >= 0 && y < height as isize {
                    let other = pieces.at(x as usize, y as usize);
                    if other != own {
                        near[own as usize].insert(other, ());
                        near[other as usize].insert(own, ());
                    }
                }
            }
        }
    }
    let mut colors = vec![0u8; count];
    for piece in (0..count).filter(|&piece| is_painted[piece]) {
        let mut taken = [false; 256];
        near[piece].keys().for_each(|&other| taken[colors[other as usize] as usize] = true);
        colors[piece] = (1..=255).find(|&color| !taken[color]).unwrap_or(255) as u8;
    }
    pieces.map(|piece| colors[piece as usize])
}

/// The mask without islands of fewer cells than `least` has on average over them, and with holes filled of fewer than
/// `least_hole` has.
pub fn cleaned(mask: &Raster<u8>, least: &Raster<f32>, least_hole: Option<&Raster<f32>>) -> Raster<u8> {
    let mut mask = mask.clone();
    for (value, least) in [(1u8, Some(least)), (0, least_hole)] {
        let Some(least) = least else { continue };
        let pieces = connected(&mask);
        let count = pieces.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
        let (mut cells, mut wanted) = (vec![0u32; count], vec![0.0f32; count]);
        for (&piece, &least) in pieces.as_slice().iter().zip(least.as_slice()) {
            cells[piece as usize] += 1;
            wanted[piece as usize] += least;
        }
        for (cell, &piece) in mask.as_mut_slice().iter_mut().zip(pieces.as_slice()) {
            let n = cells[piece as usize] as f32;
            if *cell == value && n * n < wanted[piece as usize] {
                *cell = 1 - value;
            }
        }
    }
    mask
}
