//! Strokes that model what masses leave flat: laid along the form from broad brushes to narrow ones, each one color.
//!
//! A stroke begins where the washes planned so far differ most from what is seen, follows the structure there, and ends
//! where its color fits less well than what lies there already.
//!
//! # Source
//! Hertzmann, *Painterly rendering with curved brush strokes of multiple sizes*, 1998. Here a stroke is a shape of its
//! wash, as wide as what it stands for, and never goes over a silhouette.

use girtin_grid::Raster;

use crate::accidents::{Chance, smoothstep};
use crate::settings::PhotoParams;
use crate::shapes::Shape;
use crate::strokes::outlined;
use crate::study::{Colors, Study};
use crate::tracer::Trace;

/// A brush: its width, a part of the long edge; the difference from which on it is taken up, Lab, where the eye rests and
/// how much more aside; most strokes; and the least attention it is taken up for.
struct Brush {
    width: f64,
    differs: [f32; 2],
    most: f64,
    seen: f32,
}

const BRUSHES: [Brush; 4] = [
    Brush { width: 0.040, differs: [6.0, 3.0], most: 240.0, seen: 0.0 },
    Brush { width: 0.020, differs: [6.0, 5.0], most: 420.0, seen: 0.0 },
    Brush { width: 0.010, differs: [7.0, 9.0], most: 420.0, seen: 0.15 },
    Brush { width: 0.0055, differs: [8.0, 14.0], most: 300.0, seen: 0.6 },
];

/// The same where all is calm and nobody looks: there single strokes are lozenges.
const IN_CALM: f32 = 4.5;

/// Blur of what is seen by a brush, a part of its width.
const SEEN_OVER: f64 = 0.22;
/// Step of the photograph beyond which a cell is the edge of something, Lab.
const EDGE: f32 = 14.0;
/// Step between two points, and lengths of a stroke, widths: the shortest, and how much more aside.
const STEP: f32 = 0.45;
const LONGEST: f32 = 11.0;
const SHORTEST: [f32; 2] = [2.1, 0.9];
/// Attention below which a stroke shorter than so many widths is left out unless it joins one of its color, no further away
/// than this, Lab.
const LONELY: (f32, f32) = (0.55, 5.0);
const JOINED: f32 = 5.0;
/// How little a place is busy where even a long stroke is to join one.
const CALM: f32 = 0.25;
/// Part of a stroke over which the brush is lifted.
const TIPS: [f32; 2] = [0.15, 0.8];
/// Narrowest stroke that a brush makes, a part of its width.
const NARROWEST: f32 = 0.35;
/// How far a stroke keeps its own way.
const INERTIA: f32 = 0.45;
/// How far a stroke turns to either side of its middle, radians.
const TURNS: f32 = 0.6;
/// Difference of color, Lab, that no stroke goes over.
const SILHOUETTE: f32 = 17.0;
/// How wide the blur at one is, a part of the long edge.
const SILHOUETTE_OVER: f32 = 0.008;
/// Hue counts so much of tone.
const HUE: f32 = 0.7;
/// Steps of tone that strokes are mixed in, Lab L: those of one tone join.
const MIXED: f32 = 4.0;
/// Coherence of the structure from which on strokes follow it, and how far they stray where there is none, radians.
const FOLLOWED: [f32; 2] = [0.15, 0.45];
const STRAYS: f32 = 0.5;

/// How far apart feathers are, how long and wide they are, parts of the long edge; between which differences of tone, Lab L,
/// and up to which step of the photograph.
const FEATHERS_PITCH: f32 = 0.011;
const FEATHER_LENGTHS: [f32; 2] = [0.012, 0.040];
const FEATHER_WIDTHS: [f32; 2] = [0.0025, 0.008];
const FEATHERED: [f32; 2] = [4.0, 32.0];
const FEATHERED_STEP: f32 = 16.0;

type Point = [f32; 2];

/// Lays strokes over shapes; `labels` tells which of them each cell belongs to, from 1.
pub fn brushwork(
    study: &Study,
    shapes: &[Shape],
    labels: &Raster<u16>,
    params: &PhotoParams,
    seed: u64,
) -> Vec<Shape> {
    let s = study.mount.long_edge;
    let seen = Raster::by_rows(labels.width(), labels.height(), |x, y| {
        let [l, a, b] = study.lab.at(x, y);
        [study.values.of(l, study.near_focus.at(x, y)), a, b]
    });
    let canvas = Raster::by_rows(labels.width(), labels.height(), |x, y| {
        match labels.at(x, y).checked_sub(1).map(|shape| &shapes[usize::from(shape)]) {
            Some(shape) if shape.washes > 0 => {
                let [l, ..] = shape.color_at([x as f32 + 0.5, y as f32 + 0.5]);
                [l, shape.seen[0], shape.seen[1]]
            }
            _ => [97.0, 0.0, 2.0],
        }
    });
    let mut easel = Easel { study, shapes, labels, canvas, seen: Colors::new(0, 0, [0.0; 3]), params };
    let mut chance = Chance::new(seed, "brushwork");
    let mut strokes = Vec::new();
    for brush in &BRUSHES {
        easel.seen = within_things(&seen, study, labels, SEEN_OVER * brush.width * s);
        easel.lay(brush, &mut chance, &mut strokes);
    }
    strokes.extend(easel.feathers(&mut chance));
    strokes
}

struct Easel<'a> {
    study: &'a Study,
    shapes: &'a [Shape],
    labels: &'a Raster<u16>,
    /// What is planned so far: tone, and the photograph's hue.
    canvas: Colors,
    /// What a brush sees.
    seen: Colors,
    params: &'a PhotoParams,
}

/// Colors averaged over a distance, but only over what is of one thing, and little over the blur of a lens at its edge.
fn within_things(colors: &Colors, study: &Study, labels: &Raster<u16>, sigma: f64) -> Colors {
    let weight = |x: usize, y: usize| {
        let step = study.steps.at(x, y) / EDGE;
        0.03 + libm::expf(-step * step)
    };
    let reach = libm::ceil(1.8 * sigma) as usize;
    let kernel: Vec<f32> =
        (0..=reach).map(|off| libm::exp(-0.5 * (off as f64 / sigma) * (off as f64 / sigma)) as f32).collect();
    let (width, height) = (colors.width(), colors.height());
    // Along rows, then along columns, each time among cells of the same label.
    let weighted = Raster::by_rows(width, height, |x, y| {
        let (w, [l, a, b]) = (weight(x, y), colors.at(x, y));
        [w * l, w * a, w * b, w]
    });
    let pass = |from: &Raster<[f32; 4]>, is_row: bool| {
        Raster::by_rows(width, height, |x, y| {
            let own = labels.row(y)[x];
            let mut sum = [0.0f32; 4];
            let (at, of) = if is_row { (x, width) } else { (y, height) };
            for near in at.saturating_sub(reach)..(at + reach + 1).min(of) {
                let (u, v) = if is_row { (near, y) } else { (x, near) };
                if labels.row(v)[u] != own {
                    continue;
                }
                let share = kernel[near.abs_diff(at)];
                let cell = from.row(v)[u];
                (0..4).for_each(|k| sum[k] += share * cell[k]);
            }
            sum
        })
    };
    pass(&pass(&weighted, true), false).map(|[l, a, b, w]| [l / w, a / w, b / w])
}

fn differ(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, u, v] = [0, 1, 2].map(|c: usize| a[c] - b[c]);
    (l * l + HUE * HUE * (u * u + v * v)).sqrt()
}

impl<'a> Easel<'a> {
    fn cell(&self, [x, y]: Point) -> Option<(usize, usize)> {
        let inside =
            x >= 0.0 && y >= 0.0 && x < self.labels.width() as f32 && y < self.labels.height() as f32;
        inside.then_some((x as usize, y as usize))
    }

    fn shape(&self, (x, y): (usize, usize)) -> Option<&'a Shape> {
        self.labels.at(x, y).checked_sub(1).map(|shape| &self.shapes[usize::from(shape)])
    }

    /// Whether strokes may be laid at a place.
    fn is_free(&self, cell: (usize, usize)) -> bool {
        let mount = &self.study.mount;
        let inside = (0..2).all(|axis| {
            let at = [cell.0, cell.1][axis];
            (mount.origin..mount.origin + mount.photo[axis]).contains(&at)
        });
        inside && self.shape(cell).is_some_and(|shape| !shape.is_sky)
    }

    fn lay(&mut self, brush: &Brush, chance: &mut Chance, strokes: &mut Vec<Shape>) {
        let s = self.study.mount.long_edge;
        let width = (brush.width * s) as f32;
        let most = (brush.most * self.params.detail.min(1.5)) as usize;
        let step = (0.55 * width).max(2.0) as usize;
        let mut begins: Vec<(f32, usize, usize)> = Vec::new();
        for top in (0..self.labels.height()).step_by(step) {
            for left in (0..self.labels.width()).step_by(step) {
                let cells = (top..(top + step).min(self.labels.height())).step_by(2).flat_map(|y| {
                    (left..(left + step).min(self.labels.width())).step_by(2).map(move |x| (x, y))
                });
                let worst = cells
                    .filter(|&cell| self.is_free(cell))
                    .map(|(x, y)| (self.missing(brush, x, y), x, y))
                    .max_by(|a, b| a.0.total_cmp(&b.0).then((b.2, b.1).cmp(&(a.2, a.1))));
                begins.extend(worst.filter(|worst| worst.0 > 0.0));
            }
        }
        begins.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.2, a.1).cmp(&(b.2, b.1))));
        let mut laid = 0;
        for (_, x, y) in begins {
            if laid >= most {
                break;
            }
            if self.missing(brush, x, y) <= 0.0 {
                continue;
            }
            if let Some(stroke) = self.stroke(width, (x, y), chance) {
                strokes.push(stroke);
                laid += 1;
            }
        }
    }

    /// Strokes from a dark into the light beside it, where a form turns and has a grain: no brush draws there a contour.
    fn feathers(&self, chance: &mut Chance) -> Vec<Shape> {
        let s = self.study.mount.long_edge as f32;
        let pitch = (FEATHERS_PITCH * s).max(2.0) as usize;
        let mut feathers = Vec::new();
        for top in (0..self.labels.height()).step_by(pitch) {
            for left in (0..self.labels.width()).step_by(pitch) {
                let cells = (top..(top + pitch).min(self.labels.height() - 1))
                    .flat_map(|y| (left..(left + pitch).min(self.labels.width() - 1)).map(move |x| (x, y)));
                let own = |(x, y)| self.labels.row(y)[x];
                let edge = cells
                    .into_iter()
                    .find(|&(x, y)| own((x, y)) != own((x + 1, y)) || own((x, y)) != own((x, y + 1)));
                let (lot, bend) = (chance.unit(), chance.spread(0.5));
                let (long, wide) = (chance.between(FEATHER_LENGTHS) * s, chance.between(FEATHER_WIDTHS) * s);
                let Some(edge) = edge else { continue };
                let texture = &self.study.texture;
                let rough = smoothstep(texture.busy.at(edge.0, edge.1), 0.2, 0.8)
                    * smoothstep(texture.coherence.at(edge.0, edge.1), 0.15, 0.4);
                let face = self.study.face.at(edge.0, edge.1);
                if self.study.steps.at(edge.0, edge.1) > FEATHERED_STEP || lot > rough || face > 0.05 {
                    continue;
                }
                feathers.extend(self.feather(edge, bend, long, wide));
            }
        }
        feathers
    }

    fn feather(&self, edge: (usize, usize), bend: f32, long: f32, wide: f32) -> Option<Shape> {
        let at = [edge.0 as f32 + 0.5, edge.1 as f32 + 0.5];
        let [dx, dy] = self.direction(edge, bend);
        let beyond = |way: f32| {
            let cell = self.cell([at[0] + way * dx * wide, at[1] + way * dy * wide])?;
            if self.is_free(cell) { Some((self.shape(cell)?, self.canvas.at(cell.0, cell.1))) } else { None }
        };
        let (ahead, behind) = (beyond(1.0)?, beyond(-1.0)?);
        let way = if ahead.1[0] > behind.1[0] { 1.0 } else { -1.0 };
        let (dark, light) = if way > 0.0 { (behind, ahead) } else { (ahead, behind) };
        let step = light.1[0] - dark.1[0];
        if !(FEATHERED[0]..FEATHERED[1]).contains(&step) || light.0.washes == 0 || dark.0.washes == 0 {
            return None;
        }
        let path: Vec<Point> = (0..5)
            .map(|k| {
                let along = (k as f32 / 4.0 - 0.35) * long;
                let off = 0.4 * bend * along * along / long;
                [at[0] + way * (along * dx) - off * dy, at[1] + way * (along * dy) + off * dx]
            })
            .collect();
        let end = self.cell(path[4])?;
        if !self.is_free(end) || differ(self.canvas.at(end.0, end.1), light.1) > SILHOUETTE {
            return None;
        }
        let pressure = |at: f32| libm::powf((1.0 - at).max(0.0), 0.7) * (0.5 + at / 0.15).min(1.0) + 0.04;
        let trace =
            Trace { points: path.clone(), widths: vec![wide; 5], length: long, contrast: 0.0, score: 0.0 };
        let (from, to) = (path[0], path[4]);
        let washes = dark.0.washes.max(light.0.washes);
        let over = (washes > light.0.washes)
            .then(|| ([light.0.color_at(from), light.0.color_at(to)], light.0.washes));
        Some(Shape {
            rings: vec![outlined(&trace, pressure)],
            colors: [dark.0.color_at(from), dark.0.color_at(from).map(|c| c * 1.02)],
            line: [from, to],
            washes,
            over,
            area: f64::from(0.6 * long * wide),
            laid: Some(libm::atan2f(to[1] - from[1], to[0] - from[0])),
            attention: dark.0.attention,
            seen: dark.0.seen,
            is_sky: false,
            is_border: false,
        })
    }

    /// How much more a place differs from what is seen than is left alone.
    fn missing(&self, brush: &Brush, x: usize, y: usize) -> f32 {
        let seen = self.study.attention.at(x, y);
        if seen < brush.seen {
            return 0.0;
        }
        let face = self.study.face.at(x, y);
        let calm = 1.0 - self.study.texture.busy.at(x, y);
        let left = brush.differs[0] + (brush.differs[1] + IN_CALM * calm) * (1.0 - seen) - 2.0 * face;
        (differ(self.seen.at(x, y), self.canvas.at(x, y)) - left) * (0.5 + seen)
    }

    fn direction(&self, (x, y): (usize, usize), stray: f32) -> Point {
        let texture = &self.study.texture;
        let followed = smoothstep(texture.coherence.at(x, y), FOLLOWED[0], FOLLOWED[1]);
        let angle = texture.direction.at(x, y) + (1.0 - followed) * stray;
        [libm::cosf(angle), libm::sinf(angle)]
    }

    fn stroke(&mut self, width: f32, begin: (usize, usize), chance: &mut Chance) -> Option<Shape> {
        let ground = self.shape(begin)?;
        if ground.washes == 0 && self.params.background < 1.0 {
            return None;
        }
        let face = self.study.face.at(begin.0, begin.1);
        if face > 0.1 && width > 0.014 * self.study.mount.long_edge as f32 {
            return None;
        }
        let base = self.canvas.at(begin.0, begin.1);
        let wanted = self.seen.at(begin.0, begin.1);
        let mixed = base[0] + MIXED * libm::roundf((wanted[0] - base[0]) / MIXED);
        let color = [mixed, wanted[1], wanted[2]];
        let stray = chance.spread(STRAYS);
        let middle = [begin.0 as f32 + 0.5, begin.1 as f32 + 0.5];
        // Into the middle of what is to be painted.
        let [dx, dy] = self.direction(begin, stray);
        let sides = [1.0f32, -1.0].map(|way| self.reach(middle, [-dy * way, dx * way], 0.75 * width, color));
        let off = 0.5 * (sides[0] - sides[1]);
        let middle = [middle[0] - dy * off, middle[1] + dx * off];
        let wide = (sides[0] + sides[1]).min(width * chance.between([0.8, 1.15]));
        if wide < NARROWEST * width {
            return None;
        }
        let mut halves = [1.0f32, -1.0].map(|way| self.walk(middle, way, wide, stray, color));
        if chance.unit() < 0.5 {
            halves.swap(0, 1);
        }
        let [mut path, ahead] = halves;
        path.reverse();
        path.push(middle);
        path.extend(ahead);
        let length = wide * STEP * (path.len() - 1) as f32;
        let seen = self.study.attention.at(begin.0, begin.1);
        if length < (SHORTEST[0] + SHORTEST[1] * (1.0 - seen)) * wide {
            return None;
        }
        // As wide as there is room.
        let mut widths: Vec<f32> = (0..path.len())
            .map(|at| {
                let (a, b) = (path[at.saturating_sub(1)], path[(at + 1).min(path.len() - 1)]);
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let size = libm::hypotf(dx, dy).max(1e-6);
                let normal = [-dy / size, dx / size];
                let room =
                    [1.0f32, -1.0].map(|way| self.room(path[at], normal.map(|n| n * way), 0.5 * wide, color));
                (2.0 * room[0].min(room[1])).max(0.25 * wide)
            })
            .collect();
        for _ in 0..2 {
            let before = widths.clone();
            for at in 0..widths.len() {
                let (a, b) = (before[at.saturating_sub(1)], before[(at + 1).min(before.len() - 1)]);
                widths[at] = 0.5 * before[at] + 0.25 * (a + b);
            }
        }
        let mean = widths.iter().sum::<f32>() / widths.len() as f32;
        let is_short = length < LONELY.1 * wide
            || (seen < 0.7 * LONELY.0 && self.study.texture.busy.at(begin.0, begin.1) < CALM);
        if seen < LONELY.0 && is_short && !self.is_joined(&path, &widths, color) {
            return None;
        }
        if self.is_blur(&path, &widths, color) {
            return None;
        }
        // A pointed brush is lifted slowly, a flat one at once.
        let tip = chance.between(TIPS);
        let pressure = |at: f32| {
            let begun = (0.55 + at / 0.10).min(1.0);
            let lifted = ((1.0 - at) / tip).min(1.0);
            begun * (0.10 + 0.90 * libm::powf(lifted, 0.7))
        };
        let rings = vec![outlined(
            &Trace { points: path.clone(), widths: widths.clone(), length, contrast: 0.0, score: 0.0 },
            pressure,
        )];
        for (at, (&point, &wide)) in path.iter().zip(&widths).enumerate() {
            self.touch(point, 0.5 * wide * pressure(at as f32 / (path.len() - 1) as f32), color);
        }
        let tint = self.study.values.tint([color[1], color[2]], color[0], seen);
        let planned = self.study.values.washes(color, face);
        let washes = planned.clamp(ground.washes.saturating_sub(1), ground.washes + 1);
        let washes = washes.clamp(1, self.params.washes as usize);
        let lab = [color[0].clamp(12.0, 97.0), tint[0], tint[1]];
        let lean = chance.spread(2.0);
        let (from, to) = (path[0], path[path.len() - 1]);
        Some(Shape {
            rings,
            colors: [[lab[0] - 1.5, lab[1], lab[2] + lean], [lab[0] + 1.5, lab[1], lab[2] - lean]],
            line: [from, to],
            washes,
            over: (washes > ground.washes && ground.washes > 0)
                .then(|| ([ground.color_at(from), ground.color_at(to)], ground.washes)),
            area: f64::from(length * mean),
            attention: seen,
            seen: [color[1], color[2]],
            laid: Some(libm::atan2f(to[1] - from[1], to[0] - from[0])),
            is_sky: false,
            is_border: false,
        })
    }

    /// Whether a stroke is but the blur of a lens between two things: on the way from one color to the other.
    fn is_blur(&self, path: &[Point], widths: &[f32], color: [f32; 3]) -> bool {
        let between = (1..path.len().saturating_sub(1)).filter(|&at| {
            let (a, b) = (path[at - 1], path[at + 1]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let size = libm::hypotf(dx, dy).max(1e-6);
            let off = 0.5 * widths[at] + 0.5 * SILHOUETTE_OVER * self.study.mount.long_edge as f32;
            let side = |way: f32| {
                self.cell([path[at][0] - way * off * dy / size, path[at][1] + way * off * dx / size])
                    .map(|(x, y)| self.seen.at(x, y))
            };
            let (Some(one), Some(two)) = (side(1.0), side(-1.0)) else { return false };
            let far = differ(one, two);
            let (first, second) = (differ(one, color), differ(color, two));
            far > SILHOUETTE && first + second < 1.25 * far && first.min(second) > 0.1 * far
        });
        2 * between.count() > path.len()
    }

    /// Whether something of its color lies beside a stroke.
    fn is_joined(&self, path: &[Point], widths: &[f32], color: [f32; 3]) -> bool {
        path.iter().zip(widths).any(|(&[x, y], &wide)| {
            (0..8).any(|k| {
                let angle = k as f32 * core::f32::consts::FRAC_PI_4;
                let place = [x + 0.9 * wide * libm::cosf(angle), y + 0.9 * wide * libm::sinf(angle)];
                self.cell(place).is_some_and(|(u, v)| differ(self.canvas.at(u, v), color) < JOINED)
            })
        })
    }

    /// How far a color fits better than what is there, from a place in a direction.
    fn reach(&self, from: Point, way: Point, most: f32, color: [f32; 3]) -> f32 {
        let mut far = 0.0;
        while far < most {
            let next = far + 1.0;
            let Some(cell) = self.cell([from[0] + next * way[0], from[1] + next * way[1]]) else { break };
            if !self.is_free(cell) || !self.fits(cell, color) {
                break;
            }
            far = next;
        }
        far + 0.5
    }

    /// How far a stroke of a color may spread from a place in a direction: to the next silhouette.
    fn room(&self, from: Point, way: Point, most: f32, color: [f32; 3]) -> f32 {
        let mut far = 0.0;
        while far < most {
            let next = far + 1.0;
            let Some((x, y)) = self.cell([from[0] + next * way[0], from[1] + next * way[1]]) else { break };
            if !self.is_free((x, y)) || differ(self.seen.at(x, y), color) > SILHOUETTE {
                break;
            }
            far = next;
        }
        far.min(most)
    }

    fn fits(&self, (x, y): (usize, usize), color: [f32; 3]) -> bool {
        let seen = self.seen.at(x, y);
        differ(seen, color) < differ(seen, self.canvas.at(x, y)).max(2.5)
    }

    fn walk(&self, from: Point, way: f32, wide: f32, stray: f32, color: [f32; 3]) -> Vec<Point> {
        let mut path = Vec::new();
        let (mut at, mut before, mut turned) = (from, None::<Point>, 0.0);
        let most = (0.5 * LONGEST / STEP) as usize;
        while path.len() < most {
            let Some(cell) = self.cell(at) else { break };
            let [dx, dy] = self.direction(cell, stray);
            let sign = match before {
                Some([bx, by]) if bx * dx + by * dy < 0.0 => -1.0,
                Some(_) => 1.0,
                None => way,
            };
            let own = [sign * dx, sign * dy];
            let kept = before.unwrap_or(own);
            let mixed = [0, 1].map(|k: usize| own[k] + INERTIA * (kept[k] - own[k]));
            let size = libm::hypotf(mixed[0], mixed[1]).max(1e-6);
            let direction = mixed.map(|d| d / size);
            at = [at[0] + STEP * wide * direction[0], at[1] + STEP * wide * direction[1]];
            let Some(cell) = self.cell(at) else { break };
            if !self.is_free(cell) || !self.fits(cell, color) {
                break;
            }
            if let Some([bx, by]) = before {
                turned += libm::atan2f(
                    bx * direction[1] - by * direction[0],
                    bx * direction[0] + by * direction[1],
                );
            }
            if turned.abs() > TURNS {
                break;
            }
            before = Some(direction);
            path.push(at);
        }
        path
    }

    fn touch(&mut self, [x, y]: Point, radius: f32, color: [f32; 3]) {
        let range = |at: f32, of: usize| {
            ((at - radius).max(0.0) as usize)..((at + radius + 1.0).max(0.0) as usize).min(of)
        };
        for v in range(y, self.labels.height()) {
            for u in range(x, self.labels.width()) {
                if libm::hypotf(u as f32 + 0.5 - x, v as f32 + 0.5 - y) <= radius {
                    self.canvas.row_mut(v)[u] = color;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use girtin_painting::Stock;

    use super::*;
    use crate::mount::{Mount, Mounting};
    use crate::painter::Request;

    /// A study of a photograph in grays, and the shapes it is laid on.
    fn strokes_over(gray: impl Fn(usize, usize) -> f32 + Copy) -> Vec<Shape> {
        let photo = Raster::from_fn(300, 200, |x, y| [gray(x, y); 3]);
        let params = PhotoParams::default();
        let mounting = Mounting { margin: 0.0, ..Mounting::default() };
        let request = Request {
            photo: &photo,
            pixels: [300, 200],
            params: &params,
            palette: None,
            paper: "cold-press",
            mounting,
            seed: 3,
            long_edge: 300,
            reserve: None,
            detail_map: None,
            focus: None,
            title: "",
        };
        assert!(Stock::builtin().papers.get(request.paper).is_ok());
        let study = Study::new(&request, Mount::new(request.pixels, 300.0, &mounting));
        let whole = Shape {
            colors: [[60.0, 0.0, 0.0]; 2],
            washes: 2,
            attention: 0.9,
            seen: [0.0; 2],
            ..Shape::bare(vec![vec![[0.0, 0.0], [300.0, 0.0], [300.0, 200.0], [0.0, 200.0]]])
        };
        let labels = Raster::new(study.mount.size[0], study.mount.size[1], 1u16);
        brushwork(&study, &[whole], &labels, &params, 3)
    }

    #[test]
    fn strokes_lie_along_the_stripes_that_they_stand_for() {
        let strokes = strokes_over(|_, y| if y / 12 % 2 == 0 { 0.10 } else { 0.5 });
        assert!(strokes.len() > 5, "{}", strokes.len());
        let along = strokes.iter().filter(|stroke| libm::sinf(stroke.laid.unwrap()).abs() < 0.3).count();
        assert!(10 * along > 9 * strokes.len(), "{along} of {}", strokes.len());
    }

    #[test]
    fn what_is_planned_as_it_is_seen_needs_none() {
        let study_gray = |_: usize, _: usize| 0.28;
        let strokes = strokes_over(study_gray);
        assert!(strokes.len() < 4, "{}", strokes.len());
    }

    #[test]
    fn no_stroke_goes_over_a_silhouette() {
        // Dark to the left, light to the right: a stroke is on one side of the middle, but for its round edge.
        let strokes = strokes_over(|x, _| if x < 150 { 0.03 } else { 0.7 });
        assert!(strokes.len() > 3, "{}", strokes.len());
        for stroke in strokes {
            let columns = stroke.rings[0].iter().map(|point| point[0]);
            let (low, high) = columns.fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(x), high.max(x)));
            assert!(low > 144.0 || high < 156.0, "{low} to {high}");
        }
    }
}
