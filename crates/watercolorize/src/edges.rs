//! Which stretches of contours are lost in wet paper, which are dragged dry, and which are drawn in ink.

use girtin_grid::Raster;
use girtin_painting::document::EdgeStretch;

use crate::accidents::{Chance, plane};
use crate::settings::PhotoParams;
use crate::shapes::Shape;
use crate::study::Study;
use crate::values::MOST_WASHES;

/// Length between two places of a contour that are looked at, and least length of a stretch, parts of the long edge.
const STEP: f64 = 0.004;
const LEAST: f64 = 0.020;
/// How far from a contour its two sides are looked at, cells.
const BESIDE: f32 = 2.5;
/// Step of the photograph below which a contour is lost, Lab, where nobody looks and where everybody does.
const SOFT: [f32; 2] = [1.6, 0.3];
/// How often contours are lost or dragged by chance: deviations of a noise, over a part of the long edge.
const BY_CHANCE: (f32, f32, f64) = (1.15, 1.25, 0.03);
/// How far paint fades, and how far it is dragged, parts of the long edge.
const FADES: [f32; 2] = [0.004, 0.018];
const DRAGGED: [f32; 2] = [0.004, 0.016];
/// Deviations of that noise from which on the painting's end is dragged.
const BORDER_DRAGGED: f32 = 0.5;
/// Attention from which on no contour is lost by chance.
const KEPT: f32 = 0.7;
/// Step of the photograph from which on a contour is drawn in ink, and at which noise the pen is lifted.
const INKED: (f32, f32) = (3.0, 0.9);

/// What happens to contours.
#[derive(Debug, Default)]
pub struct Edges {
    /// Of each wash: stretches that are not crisp.
    pub soft: [Vec<EdgeStretch>; MOST_WASHES],
    /// Stretches that a pen follows, cells, and how important they are.
    pub inked: Vec<(Vec<[f32; 2]>, f32)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Crisp,
    Lost,
    Dragged,
}

impl Edges {
    /// Decides for the contours of shapes; `labels` tells which shape each cell belongs to, from 1.
    pub fn new(study: &Study, shapes: &[Shape], labels: &Raster<u16>, params: &PhotoParams, seed: u64) -> Self {
        let s = study.mount.long_edge;
        let noise = |name: &str| plane(seed, name, study.mount.size, BY_CHANCE.2 * s);
        let (losing, dragging, lifting) = (noise("lost edges"), noise("dragged edges"), noise("lifted pen"));
        let widths = noise("width of soft edges");
        let (lost, dry) = (params.lost_edges as f32, params.drybrush as f32);
        let mut edges = Self::default();
        let washes = |label: u16| match label.checked_sub(1) {
            Some(shape) => shapes.get(usize::from(shape)).map_or(0, |shape| shape.washes),
            None => 0,
        };
        let is_border = |label: u16| {
            label.checked_sub(1).and_then(|shape| shapes.get(usize::from(shape))).is_some_and(|shape| shape.is_border)
        };
        let label_at = |[x, y]: [f32; 2]| {
            let held = |at: f32, of: usize| (at.max(0.0) as usize).min(of - 1);
            labels.at(held(x, labels.width()), held(y, labels.height()))
        };
        for (number, shape) in shapes.iter().enumerate().skip(1) {
            for ring in &shape.rings {
                let points = evenly(ring, (STEP * s) as f32);
                let mut run: Option<(Kind, [usize; 2], Vec<[f32; 2]>, f32)> = None;
                let mut inked: Vec<[f32; 2]> = Vec::new();
                let mut importance = 0.0;
                for (at, &point) in points.iter().enumerate() {
                    let next = points[(at + 1) % points.len()];
                    let (dx, dy) = (next[0] - point[0], next[1] - point[1]);
                    let size = libm::hypotf(dx, dy).max(1e-6);
                    let normal = [-dy / size * BESIDE, dx / size * BESIDE];
                    let sides = [1.0, -1.0]
                        .map(|way: f32| label_at([point[0] + way * normal[0], point[1] + way * normal[1]]));
                    let is_own = sides.contains(&(number as u16 + 1)) && sides[0] != sides[1];
                    let [a, b] = sides.map(washes);
                    let step = study.steps.sample(point[0], point[1]);
                    let seen = study.attention.sample(point[0], point[1]);
                    let face = study.face.sample(point[0], point[1]);
                    let soft = lost * (SOFT[0] + (SOFT[1] - SOFT[0]) * seen) + 1.5 * face * lost;
                    let chance = |noise: &Raster<f32>, often: f32, from: f32| {
                        seen < KEPT && noise.sample(point[0], point[1]) > from - 0.6 * (often - 1.0)
                    };
                    let kind = if !is_own || a == b {
                        Kind::Crisp
                    } else if sides.into_iter().any(is_border) {
                        // The painting's end is where a brush was lifted: crisp, or dry.
                        if dry > 0.0 && chance(&dragging, dry, BORDER_DRAGGED) { Kind::Dragged } else { Kind::Crisp }
                    } else if lost > 0.0 && (step < soft || chance(&losing, lost, BY_CHANCE.0)) {
                        Kind::Lost
                    } else if dry > 0.0 && chance(&dragging, dry, BY_CHANCE.1) && face < 0.1 {
                        Kind::Dragged
                    } else {
                        Kind::Crisp
                    };
                    let span = [a.min(b), a.max(b)];
                    match &mut run {
                        Some((of, range, path, _)) if *of == kind && *range == span => path.push(point),
                        _ => {
                            edges.end(run.take(), study);
                            let wide = widths.sample(point[0], point[1]);
                            run = (kind != Kind::Crisp).then(|| (kind, span, vec![point], wide));
                        }
                    }
                    let is_line = sides[0] != sides[1] && is_own && step > INKED.0
                        && lifting.sample(point[0], point[1]) < INKED.1;
                    if is_line {
                        inked.push(point);
                        importance += step * (0.4 + seen);
                    }
                    if !inked.is_empty() && (!is_line || at + 1 == points.len()) {
                        let path = core::mem::take(&mut inked);
                        if path.len() > 6 {
                            edges.inked.push((path, importance));
                        }
                        importance = 0.0;
                    }
                }
                edges.end(run.take(), study);
            }
        }
        edges
    }

    /// Keeps a stretch if it is long enough.
    fn end(&mut self, run: Option<(Kind, [usize; 2], Vec<[f32; 2]>, f32)>, study: &Study) {
        let Some((kind, [least, most], path, wide)) = run else { return };
        let s = study.mount.long_edge;
        if (path.len() as f64) * STEP < LEAST {
            return;
        }
        let between = |[low, high]: [f32; 2]| {
            let part = (0.5 + 0.3 * wide).clamp(0.0, 1.0);
            crate::study::hundredths(f64::from(low + part * (high - low)) * s / study.mount.cells_per_mm)
        };
        let (lost_mm, dry_mm) = match kind {
            Kind::Lost => (between(FADES), 0.0),
            Kind::Dragged => (0.0, between(DRAGGED)),
            Kind::Crisp => return,
        };
        let path: Vec<[f64; 2]> = path.iter().step_by(2).map(|&point| study.mm(point)).collect();
        for wash in least..most.min(MOST_WASHES) {
            self.soft[wash].push(EdgeStretch { path: path.clone(), lost_mm, dry_mm });
        }
    }
}

/// Gaps between two wet shapes, which a painter leaves so that they do not run: step of the photograph there, Lab; noise from
/// which on there is one; least and most length; width at most, parts of the long edge; and how many within how far.
const GAP_STEP: f32 = 7.0;
const GAP_CHANCE: f32 = 0.2;
const GAP_LENGTHS: [f64; 2] = [0.010, 0.055];
const GAP_WIDTHS: [f32; 2] = [0.0018, 0.0036];
const MOST_GAPS: f64 = 34.0;
const GAP_ROOM: (f32, usize) = (0.05, 3);

/// Gaps of bare paper along contours where both sides are painted, near the focus first: outlines in cells.
pub fn gaps(
    study: &Study,
    shapes: &[Shape],
    labels: &Raster<u16>,
    params: &PhotoParams,
    seed: u64,
) -> Vec<Vec<[f32; 2]>> {
    let s = study.mount.long_edge;
    let chances = plane(seed, "gaps", study.mount.size, 0.02 * s);
    let mut chance = Chance::new(seed, "gaps");
    let tone = |[x, y]: [f32; 2]| {
        let held = |at: f32, of: usize| (at.max(0.0) as usize).min(of - 1);
        let label = labels.at(held(x, labels.width()), held(y, labels.height()));
        let shape = label.checked_sub(1).map(|shape| &shapes[usize::from(shape)]);
        shape.filter(|shape| shape.washes > 0 && !shape.is_sky).map(|shape| shape.color_at([x, y])[0])
    };
    let mut found: Vec<(f32, Vec<[f32; 2]>)> = Vec::new();
    for shape in shapes.iter().skip(1).filter(|shape| shape.washes > 0) {
        for ring in &shape.rings {
            let points = evenly(ring, (0.5 * STEP * s) as f32);
            let mut run: Vec<([f32; 2], [f32; 2])> = Vec::new();
            let mut importance = 0.0;
            let most = (GAP_LENGTHS[1] / (0.5 * STEP)) as usize;
            for (at, &point) in points.iter().enumerate() {
                let next = points[(at + 1) % points.len()];
                let (dx, dy) = (next[0] - point[0], next[1] - point[1]);
                let size = libm::hypotf(dx, dy).max(1e-6);
                let normal = [-dy / size, dx / size];
                let side = |way: f32| tone([0, 1].map(|k: usize| point[k] + way * BESIDE * normal[k]));
                let seen = study.attention.sample(point[0], point[1]);
                let is_gap = chances.sample(point[0], point[1]) > GAP_CHANCE
                    && study.steps.sample(point[0], point[1]) > GAP_STEP
                    && study.face.sample(point[0], point[1]) < 0.05
                    && study.texture.foliage.sample(point[0], point[1]) < 0.6;
                let lighter = match (side(1.0), side(-1.0)) {
                    (Some(one), Some(two)) if is_gap && (one - two).abs() > 3.0 => {
                        Some(if one > two { 1.0 } else { -1.0 })
                    }
                    _ => None,
                };
                if let Some(way) = lighter {
                    run.push((point, normal.map(|part| way * part)));
                    importance += 0.15 + seen * seen;
                }
                let ends = lighter.is_none() || at + 1 == points.len() || run.len() > most;
                if ends && !run.is_empty() {
                    if run.len() as f64 * 0.5 * STEP > GAP_LENGTHS[0] {
                        let width = chance.between(GAP_WIDTHS) * s as f32;
                        found.push((importance * chance.between([0.5, 1.0]), sliver(&run, width)));
                    }
                    run.clear();
                    importance = 0.0;
                }
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept: Vec<Vec<[f32; 2]>> = Vec::new();
    let room = GAP_ROOM.0 * s as f32;
    for (_, gap) in found {
        if kept.len() as f64 >= MOST_GAPS * params.lights {
            break;
        }
        let [x, y] = gap[gap.len() / 4];
        let near = |other: &&Vec<[f32; 2]>| {
            let [u, v] = other[other.len() / 4];
            libm::hypotf(x - u, y - v) < room
        };
        if kept.iter().filter(near).count() < GAP_ROOM.1 {
            kept.push(gap);
        }
    }
    kept
}

/// The outline of a gap along points with the directions of its lighter side: widest before its middle, open at neither end.
fn sliver(run: &[([f32; 2], [f32; 2])], width: f32) -> Vec<[f32; 2]> {
    let count = run.len().max(2) - 1;
    let edge = |by: &dyn Fn(f32) -> f32| -> Vec<[f32; 2]> {
        let points = run.iter().enumerate();
        points
            .map(|(at, (point, normal))| {
                let off = by(at as f32 / count as f32);
                [0, 1].map(|k: usize| point[k] + off * normal[k])
            })
            .collect()
    };
    let full = |along: f32| width * libm::powf((4.0 * along * (1.0 - along)).max(0.0), 0.4);
    let mut outline = edge(&|along| full(along));
    let mut back = edge(&|along| -0.25 * full(along));
    back.reverse();
    outline.extend(back);
    outline
}

/// Points along a ring, evenly.
fn evenly(ring: &[[f32; 2]], step: f32) -> Vec<[f32; 2]> {
    let mut points = Vec::new();
    let mut left = 0.0;
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = libm::hypotf(dx, dy);
        while left < length {
            let part = left / length;
            points.push([a[0] + part * dx, a[1] + part * dy]);
            left += step;
        }
        left -= length;
    }
    points
}
