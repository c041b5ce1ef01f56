//! Cheapest paths from a seed.

use std::sync::OnceLock;

use super::ScissorsParams;
use super::edges::Edges;
use super::training::Training;

/// What a step of local cost 1 costs in whole numbers.
const SCALE: f32 = 1024.0;
/// Most that a step may cost, and what one onto a closed pixel costs. Local costs are at most 1.5 of a weight of 1 each.
const MOST: u32 = 4 * 1024;
/// Entries of the table of arc cosines from −1 to 1.
const ARCS: usize = 2049;

/// Columns and rows to each of the neighbours.
const NEIGHBOURS: [[isize; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
/// No way back: the pixel has not been reached, or is the seed.
const NOWHERE: u8 = u8::MAX;

/// The paths from one seed, found as far as they were asked for.
///
/// # Source
/// Mortensen and Barrett 1995, §3: Dijkstra's search whose active list is kept in buckets, one for each whole cost, so that
/// no list has to be sorted.
#[derive(Clone, Debug)]
pub struct LiveWire {
    seed: usize,
    /// Cost of the cheapest path known to each pixel.
    cost: Vec<u32>,
    /// Toward which neighbour it goes back.
    back: Vec<u8>,
    is_done: Vec<bool>,
    /// Pixels by their cost, modulo the number of buckets. A pixel may stand in a dearer bucket too, and is skipped there.
    buckets: Vec<Vec<u32>>,
    /// Cost that is being looked at.
    at: u32,
    waiting: usize,
}

impl LiveWire {
    /// A wire from a seed inside the picture; nothing is searched yet.
    pub(super) fn new(edges: &Edges, [x, y]: [usize; 2]) -> Self {
        let pixels = edges.width() * edges.height();
        let seed = y * edges.width() + x;
        let mut wire = Self {
            seed,
            cost: vec![u32::MAX; pixels],
            back: vec![NOWHERE; pixels],
            is_done: vec![false; pixels],
            buckets: vec![Vec::new(); MOST as usize + 1],
            at: 0,
            waiting: 0,
        };
        if let Some(cost) = wire.cost.get_mut(seed) {
            *cost = 0;
            wire.buckets[0].push(seed as u32);
            wire.waiting = 1;
        }
        wire
    }

    /// The path from the seed to a point inside the picture; pixels of `closed` are gone through only for want of others.
    pub(super) fn path_to(
        &mut self,
        edges: &Edges,
        params: &ScissorsParams,
        training: Option<&Training>,
        closed: &[[usize; 2]],
        [x, y]: [usize; 2],
    ) -> Vec<[usize; 2]> {
        let width = edges.width();
        let goal = y * width + x;
        let links = Links::new(edges, params, training, closed);
        while !self.is_done[goal] && self.waiting > 0 {
            self.search_bucket(&links);
        }
        let mut path = vec![[x, y]];
        let mut pixel = goal;
        while pixel != self.seed && self.back[pixel] != NOWHERE {
            pixel = toward(pixel, NEIGHBOURS[self.back[pixel] as usize], width);
            path.push([pixel % width, pixel / width]);
        }
        path.reverse();
        path
    }

    /// Goes on from one pixel of the cheapest bucket, or to the next bucket.
    fn search_bucket(&mut self, links: &Links<'_>) {
        let buckets = self.buckets.len();
        let Some(pixel) = self.buckets[self.at as usize % buckets].pop() else {
            self.at += 1;
            return;
        };
        self.waiting -= 1;
        let pixel = pixel as usize;
        if self.is_done[pixel] || self.cost[pixel] != self.at {
            return;
        }
        self.is_done[pixel] = true;
        let (x, y) = (pixel % links.width, pixel / links.width);
        for (number, &[dx, dy]) in NEIGHBOURS.iter().enumerate() {
            let is_inside = x.checked_add_signed(dx).is_some_and(|x| x < links.width)
                && y.checked_add_signed(dy).is_some_and(|y| y < links.height);
            if !is_inside {
                continue;
            }
            let next = toward(pixel, [dx, dy], links.width);
            if self.is_done[next] {
                continue;
            }
            let cost = self.at.saturating_add(links.cost(pixel, next, number));
            if cost < self.cost[next] {
                self.cost[next] = cost;
                self.back[next] = ((number + 4) % 8) as u8;
                self.buckets[cost as usize % buckets].push(next as u32);
                self.waiting += 1;
            }
        }
    }
}

/// The neighbour of a pixel; both lie inside.
fn toward(pixel: usize, [dx, dy]: [isize; 2], width: usize) -> usize {
    pixel.wrapping_add_signed(dx + dy * width as isize)
}

/// What it costs to go from a pixel to its neighbour.
struct Links<'a> {
    edges: &'a Edges,
    training: Option<&'a Training>,
    weights: [f32; 3],
    closed: Vec<bool>,
    arcs: &'static [f32],
    width: usize,
    height: usize,
}

impl<'a> Links<'a> {
    fn new(
        edges: &'a Edges,
        params: &ScissorsParams,
        training: Option<&'a Training>,
        closed: &[[usize; 2]],
    ) -> Self {
        let width = edges.width();
        let mut marks = Vec::new();
        if !closed.is_empty() {
            marks.resize(width * edges.height(), false);
            closed.iter().for_each(|[x, y]| marks[y * width + x] = true);
        }
        let weights = [params.crossing_weight, params.direction_weight, params.magnitude_weight];
        Self {
            edges,
            training,
            weights: weights.map(|weight| weight as f32),
            closed: marks,
            arcs: arcs(),
            width,
            height: edges.height(),
        }
    }

    /// l(p, q) = ω_Z f_Z(q) + ω_D f_D(p, q) + ω_G f_G(q), f_G being √½ as dear to the side as over a corner.
    fn cost(&self, from: usize, to: usize, number: usize) -> u32 {
        if self.closed.get(to) == Some(&true) {
            return MOST;
        }
        const CORNER: f32 = std::f32::consts::FRAC_1_SQRT_2;
        let is_corner = number % 2 == 1;
        let [dx, dy] = NEIGHBOURS[number].map(|step| step as f32 * if is_corner { CORNER } else { 1.0 });
        let along = |pixel: usize| {
            let [tx, ty] = self.edges.tangent(pixel);
            tx * dx + ty * dy
        };
        // The link is taken in the direction in which the edge of p runs, so that d_p ≥ 0; d_q then tells whether the edge
        // of q runs the same way.
        let (p, q) = (along(from), along(to));
        let (d_p, d_q) = if p >= 0.0 { (p, q) } else { (-p, -q) };
        let direction = (self.arc(d_p) + self.arc(d_q)) / std::f32::consts::PI;
        let magnitude = self.edges.magnitude(to);
        let magnitude = self.training.map_or(1.0 - magnitude, |training| training.cost(magnitude));
        let [z, d, g] = self.weights;
        let cost = z * self.edges.crossing_cost(to)
            + d * direction
            + g * magnitude * if is_corner { 1.0 } else { CORNER };
        ((cost * SCALE) as u32).clamp(1, MOST)
    }

    fn arc(&self, cosine: f32) -> f32 {
        let half = (ARCS / 2) as f32;
        self.arcs[(((cosine + 1.0) * half + 0.5) as usize).min(ARCS - 1)]
    }
}

/// Arc cosines: two a link would be most of the search.
fn arcs() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let half = (ARCS / 2) as f64;
        (0..ARCS).map(|at| libm::acos(at as f64 / half - 1.0) as f32).collect()
    })
}

/// Costs of all pixels.
#[cfg(test)]
pub(super) fn costs(wire: &LiveWire) -> &[u32] {
    &wire.cost
}

/// Costs of all pixels, found by going over all links until nothing changes.
#[cfg(test)]
pub(super) fn relaxed_costs(edges: &Edges, params: &ScissorsParams, [x, y]: [usize; 2]) -> Vec<u32> {
    let links = Links::new(edges, params, None, &[]);
    let (width, height) = (links.width, links.height);
    let mut costs = vec![u32::MAX; width * height];
    costs[y * width + x] = 0;
    loop {
        let before = costs.clone();
        for from in 0..width * height {
            for (number, &[dx, dy]) in NEIGHBOURS.iter().enumerate() {
                let (x, y) = ((from % width).checked_add_signed(dx), (from / width).checked_add_signed(dy));
                if let (Some(x), Some(y)) = (x, y)
                    && x < width
                    && y < height
                {
                    let to = y * width + x;
                    costs[to] = costs[to].min(costs[from].saturating_add(links.cost(from, to, number)));
                }
            }
        }
        if costs == before {
            return costs;
        }
    }
}
