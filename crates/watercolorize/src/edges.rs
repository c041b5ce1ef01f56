//! Which stretches of contours are lost in wet paper, which are dragged dry, and which are drawn in ink.

use girtin_grid::Raster;
use girtin_painting::document::EdgeStretch;

use crate::accidents::plane;
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
const SOFT: [f32; 2] = [1.1, 0.0];
/// How often contours are dragged by chance: deviations of a noise, over a part of the long edge.
const BY_CHANCE: (f32, f64) = (1.6, 0.03);
/// How far paint fades, and how far it is dragged, parts of the long edge.
const FADES: [f32; 2] = [0.004, 0.018];
const DRAGGED: [f32; 2] = [0.006, 0.020];
/// Deviations of a noise beyond which a cloud is lost in the sky.
const CLOUDS: f32 = -0.2;
const CLOUDS_FADE: [f32; 2] = [0.006, 0.020];
/// Deviations of that noise from which on the painting's end is dragged.
const BORDER_DRAGGED: f32 = 0.9;
/// Attention from which on no contour is dragged.
const KEPT: f32 = 0.5;
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

/// A stretch of a contour that is alike all along.
struct Stretch {
    kind: Kind,
    /// Washes of its two sides, fewer first.
    washes: [usize; 2],
    path: Vec<[f32; 2]>,
    /// How wide it is, deviations.
    wide: f32,
    /// Whether both sides are sky.
    is_cloud: bool,
}

impl Edges {
    /// Decides for the contours of shapes; `labels` tells which shape each cell belongs to, from 1.
    pub fn new(
        study: &Study,
        shapes: &[Shape],
        labels: &Raster<u16>,
        params: &PhotoParams,
        seed: u64,
    ) -> Self {
        let s = study.mount.long_edge;
        let noise = |name: &str| plane(seed, name, study.mount.size, BY_CHANCE.1 * s);
        let (dragging, lifting) = (noise("dragged edges"), noise("lifted pen"));
        let widths = noise("width of soft edges");
        let (lost, dry) = (params.lost_edges as f32, params.drybrush as f32);
        let mut edges = Self::default();
        let shape_of = |label: u16| label.checked_sub(1).and_then(|shape| shapes.get(usize::from(shape)));
        let washes = |label: u16| shape_of(label).map_or(0, |shape| shape.washes);
        let is_border = |label: u16| shape_of(label).is_some_and(|shape| shape.is_border);
        let is_sky = |label: u16| shape_of(label).is_some_and(|shape| shape.is_sky);
        let clouds = plane(seed, "clouds", study.mount.size, 0.06 * s);
        let label_at = |[x, y]: [f32; 2]| {
            let held = |at: f32, of: usize| (at.max(0.0) as usize).min(of - 1);
            labels.at(held(x, labels.width()), held(y, labels.height()))
        };
        for (number, shape) in shapes.iter().enumerate().skip(1) {
            for ring in &shape.rings {
                let points = evenly(ring, (STEP * s) as f32);
                let mut run: Option<Stretch> = None;
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
                        if dry > 0.0 && chance(&dragging, dry, BORDER_DRAGGED) {
                            Kind::Dragged
                        } else {
                            Kind::Crisp
                        }
                    } else if lost > 0.0
                        && (step < soft
                            || (sides.into_iter().all(is_sky) && clouds.sample(point[0], point[1]) > CLOUDS))
                    {
                        Kind::Lost
                    } else if dry > 0.0 && chance(&dragging, dry, BY_CHANCE.0) && face < 0.1 {
                        Kind::Dragged
                    } else {
                        Kind::Crisp
                    };
                    let span = [a.min(b), a.max(b)];
                    match &mut run {
                        Some(run) if run.kind == kind && run.washes == span => run.path.push(point),
                        _ => {
                            edges.end(run.take(), study);
                            let wide = widths.sample(point[0], point[1]);
                            run = (kind != Kind::Crisp).then(|| Stretch {
                                kind,
                                washes: span,
                                path: vec![point],
                                wide,
                                is_cloud: sides.into_iter().all(is_sky),
                            });
                        }
                    }
                    let is_line = sides[0] != sides[1]
                        && is_own
                        && step > INKED.0
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
    fn end(&mut self, run: Option<Stretch>, study: &Study) {
        let Some(Stretch { kind, washes: [least, most], path, wide, is_cloud }) = run else { return };
        let s = study.mount.long_edge;
        if (path.len() as f64) * STEP < LEAST {
            return;
        }
        let fades = if is_cloud { CLOUDS_FADE } else { FADES };
        let between = |[low, high]: [f32; 2]| {
            let part = (0.5 + 0.3 * wide).clamp(0.0, 1.0);
            crate::study::hundredths(f64::from(low + part * (high - low)) * s / study.mount.cells_per_mm)
        };
        let (lost_mm, dry_mm) = match kind {
            Kind::Lost => (between(fades), 0.0),
            Kind::Dragged => (0.0, between(DRAGGED)),
            Kind::Crisp => return,
        };
        let path: Vec<[f64; 2]> = path.iter().step_by(2).map(|&point| study.mm(point)).collect();
        for wash in least..most.min(MOST_WASHES) {
            self.soft[wash].push(EdgeStretch { path: path.clone(), lost_mm, dry_mm });
        }
    }
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
