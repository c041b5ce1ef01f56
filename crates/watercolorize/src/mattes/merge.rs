//! Neighbouring patches become regions, the most alike first.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};

use girtin_grid::Raster;

use super::MattesParams;
use crate::superpixels::{LabPixel, Superpixels};

/// The region of each pixel, numbered in reading order, and how many there are.
///
/// The pair that differs least is joined first: by mean color and by the contrast along the common border, times a power of
/// the smaller's share of the picture. It goes on while there are more regions than wanted, regions that differ less than is
/// seen, or too small ones; at the end regions of one color are joined that do not touch, as a ground is that shows on both
/// sides of a figure.
pub(super) fn merge(
    picture: &Raster<LabPixel>,
    patches: &Superpixels,
    params: &MattesParams,
) -> (Raster<u32>, usize) {
    let mut graph = Graph::new(picture, patches, params);
    graph.join_neighbours();
    graph.join_apart();
    let mut numbers = BTreeMap::new();
    let regions = patches.labels.map(|patch| {
        let next = numbers.len() as u32;
        *numbers.entry(graph.find(patch)).or_insert(next)
    });
    (regions, numbers.len())
}

/// A region while it is made.
#[derive(Clone, Debug, Default)]
struct Region {
    pixels: u64,
    color: [f64; 3],
    /// Borders with neighbours.
    borders: BTreeMap<u32, Border>,
    /// How often it has changed: what was queued before counts no more.
    version: u32,
}

/// A border of two regions.
#[derive(Clone, Copy, Debug, Default)]
struct Border {
    sides: f64,
    contrast: f64,
}

/// Two regions that may be joined. The queue is of rising cost, then of rising numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    cost: f64,
    regions: [u32; 2],
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
        self.cost.total_cmp(&other.cost).then(self.regions.cmp(&other.regions))
    }
}

struct Graph<'a> {
    params: &'a MattesParams,
    regions: Vec<Region>,
    /// Into which region each was joined; itself while it is one.
    joined: Vec<u32>,
    count: usize,
    pixels: f64,
}

impl<'a> Graph<'a> {
    fn new(picture: &Raster<LabPixel>, patches: &Superpixels, params: &'a MattesParams) -> Self {
        let (width, height) = (picture.width(), picture.height());
        let mut regions = vec![Region::default(); patches.count];
        for (color, &label) in picture.as_slice().iter().zip(patches.labels.as_slice()) {
            let region = &mut regions[label as usize];
            region.pixels += 1;
            region.color.iter_mut().zip(color).for_each(|(sum, &channel)| *sum += f64::from(channel));
        }
        for region in &mut regions {
            region.color = region.color.map(|sum| sum / region.pixels as f64);
        }
        let mut touch = |a: u32, b: u32, contrast: f64| {
            if a != b {
                for (one, other) in [(a, b), (b, a)] {
                    let border = regions[one as usize].borders.entry(other).or_default();
                    border.sides += 1.0;
                    border.contrast += contrast;
                }
            }
        };
        // Contrast is taken over three pixels: an edge that is a little out of focus is an edge.
        for y in 0..height {
            for x in 0..width {
                let label = patches.labels.at(x, y);
                if x + 1 < width {
                    let contrast = distance_of_pixels(
                        picture.at(x.saturating_sub(1), y),
                        picture.at((x + 2).min(width - 1), y),
                    );
                    touch(label, patches.labels.at(x + 1, y), contrast);
                }
                if y + 1 < height {
                    let contrast = distance_of_pixels(
                        picture.at(x, y.saturating_sub(1)),
                        picture.at(x, (y + 2).min(height - 1)),
                    );
                    touch(label, patches.labels.at(x, y + 1), contrast);
                }
            }
        }
        let joined = (0..patches.count as u32).collect();
        Self { params, count: regions.len(), regions, joined, pixels: (width * height) as f64 }
    }

    /// The region that a patch belongs to.
    fn find(&mut self, patch: u32) -> u32 {
        let mut root = patch;
        while self.joined[root as usize] != root {
            root = self.joined[root as usize];
        }
        // Shorten the way for the next one.
        let mut at = patch;
        while self.joined[at as usize] != root {
            at = std::mem::replace(&mut self.joined[at as usize], root);
        }
        root
    }

    /// How much two regions differ, ΔE; by color alone where they do not touch.
    fn difference(&self, [a, b]: [u32; 2]) -> f64 {
        let (one, other) = (&self.regions[a as usize], &self.regions[b as usize]);
        let colors = distance(one.color, other.color);
        match one.borders.get(&b) {
            Some(border) => {
                let edge = border.contrast / border.sides;
                colors + self.params.edge_weight * (edge - colors)
            }
            None => colors,
        }
    }

    fn share(&self, region: u32) -> f64 {
        self.regions[region as usize].pixels as f64 / self.pixels
    }

    fn pair(&self, regions: [u32; 2]) -> Pair {
        let smaller = self.share(regions[0]).min(self.share(regions[1]));
        let cost = self.difference(regions) * libm::pow(smaller, self.params.size_power);
        Pair { cost, regions, versions: regions.map(|region| self.regions[region as usize].version) }
    }

    fn join_neighbours(&mut self) {
        let mut queue = BinaryHeap::new();
        for a in 0..self.regions.len() as u32 {
            for &b in self.regions[a as usize].borders.range(a + 1..).map(|(b, _)| b) {
                queue.push(Reverse(self.pair([a, b])));
            }
        }
        // What is passed over in one round may be the only choice of a region in the next.
        let mut passed: Vec<Pair> = Vec::new();
        while let Some(Reverse(pair)) = queue.pop() {
            let is_current = |at: usize| {
                let region = pair.regions[at];
                self.joined[region as usize] == region
                    && self.regions[region as usize].version == pair.versions[at]
            };
            if !is_current(0) || !is_current(1) {
                continue;
            }
            if !self.is_to_join(pair.regions) {
                passed.push(pair);
                continue;
            }
            let kept = self.join(pair.regions);
            for &other in self.regions[kept as usize].borders.keys() {
                queue.push(Reverse(self.pair([kept.min(other), kept.max(other)])));
            }
            queue.extend(passed.drain(..).map(Reverse));
        }
    }

    /// Whether two regions that touch are one.
    fn is_to_join(&self, regions: [u32; 2]) -> bool {
        self.count > self.params.regions as usize
            || self.difference(regions) < self.params.min_difference
            || regions.iter().any(|&region| self.share(region) < self.params.min_share)
    }

    /// Joins regions of one color that do not touch, the most alike first.
    fn join_apart(&mut self) {
        loop {
            let left: Vec<u32> =
                (0..self.regions.len() as u32).filter(|&at| self.joined[at as usize] == at).collect();
            let pairs =
                left.iter().enumerate().flat_map(|(at, &a)| left[at + 1..].iter().map(move |&b| [a, b]));
            let apart = pairs.filter(|[a, b]| !self.regions[*a as usize].borders.contains_key(b));
            let nearest = apart
                .map(|regions| (self.difference(regions), regions))
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            match nearest {
                Some((difference, regions)) if difference < self.params.min_difference => {
                    self.join(regions);
                }
                _ => return,
            }
        }
    }

    /// Joins two regions; the larger one keeps its number, so that few borders change theirs.
    fn join(&mut self, [a, b]: [u32; 2]) -> u32 {
        let is_first = self.regions[a as usize].borders.len() >= self.regions[b as usize].borders.len();
        let (kept, gone) = if is_first { (a, b) } else { (b, a) };
        let taken = std::mem::take(&mut self.regions[gone as usize]);
        self.joined[gone as usize] = kept;
        self.count -= 1;
        for (&neighbour, border) in taken.borders.iter().filter(|(neighbour, _)| **neighbour != kept) {
            self.regions[neighbour as usize].borders.remove(&gone);
            for (one, other) in [(kept, neighbour), (neighbour, kept)] {
                let whole = self.regions[one as usize].borders.entry(other).or_default();
                whole.sides += border.sides;
                whole.contrast += border.contrast;
            }
        }
        let region = &mut self.regions[kept as usize];
        region.borders.remove(&gone);
        let pixels = region.pixels + taken.pixels;
        let part = taken.pixels as f64 / pixels as f64;
        for (mean, other) in region.color.iter_mut().zip(taken.color) {
            *mean += part * (other - *mean);
        }
        region.pixels = pixels;
        region.version += 1;
        kept
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn distance_of_pixels(a: LabPixel, b: LabPixel) -> f64 {
    distance(a.map(f64::from), b.map(f64::from))
}
