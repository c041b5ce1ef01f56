//! Marks of a brush on the dried washes: tones along a form, texture by rule, dark accents, ink.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_plane;

use crate::accents::darks;
use crate::accidents::{Chance, smoothstep};
use crate::rules::{self, Kind, Stroke};
use crate::settings::PhotoParams;
use crate::shapes::Shape;
use crate::study::{Plane, Study};
use crate::tracer::{Trace, Tracing, trace};

/// Most marks of each kind in a picture.
pub const MOST_ACCENTS: f64 = 70.0;
const MOST_INNER: f64 = 120.0;
const MOST_TEXTURE: f64 = 60.0;
const MOST_INK: f64 = 260.0;

/// How much darker than its shape a place is from which on it is worth a tone of its own, Lab L: always, where nobody looks,
/// and in foliage.
const INNER: [f32; 3] = [4.5, 13.0, 12.0];
/// Widths of inner tones, and their least length, parts of the long edge.
const INNER_WIDTHS: [f64; 2] = [0.0028, 0.022];
const INNER_LENGTH: [f32; 2] = [0.014, 0.03];

/// How little something is looked at to have no inner tones: there they would be flecks.
const INNER_ASIDE: f32 = 0.4;

/// Accents are darker than what they mark, Lab L, within these.
const ACCENT: (f32, [f32; 2]) = (6.0, [17.0, 50.0]);
/// Most that they are darker than their ground, Lab L.
const MOST_ACCENT: f32 = 40.0;

/// Attention that a dark is to have, or its length, a part of the long edge: elsewhere it is a fleck.
const ACCENT_SEEN: f32 = 0.5;
const ACCENT_LONG: f32 = 0.045;
/// How many times as long as wide an accent is, and from which attention on it may be shorter.
const ACCENT_SHAPE: f32 = 5.0;
const ACCENT_DOT: f32 = 0.65;
/// Contrast, Lab L, from which on a line is drawn wherever it is.
const ACCENT_STRONG: f32 = 20.0;

/// Width of a pen's line, part of the long edge.
const PEN: f32 = 0.0016;

/// A knife: most lights, their widest, a part of the long edge, how many times as long as wide, and the lightest ground, Lab L.
const MOST_SCRAPED: f64 = 14.0;
const SCRAPED_WIDTH: f32 = 0.0022;
const SCRAPED_SHAPE: f32 = 5.0;
const SCRAPED_BELOW: f32 = 58.0;
/// Most drops of spatter.
const MOST_SPATTER: f64 = 30.0;
/// How many bursts are tried, most attention where they fall, how far their drops fly and how large they are, parts of the
/// long edge, how many a burst has, and how much darker than their ground they are, Lab L.
const BURSTS: usize = 8;
const SPATTER_SEEN: f32 = 0.45;
const SPATTER_FLIES: f32 = 0.07;
const DROP_SIZES: [f32; 2] = [0.0009, 0.0032];
const DROPS: [u64; 2] = [5, 11];
const DROP_STEP: [f32; 2] = [10.0, 24.0];

/// A mark before its color is mixed.
#[derive(Clone, Debug)]
pub struct Gesture {
    /// Points, cells.
    pub points: Vec<[f32; 2]>,
    /// Width at each, cells.
    pub widths: Vec<f32>,
    /// Wanted color at its beginning, Lab.
    pub color: [f32; 3],
    /// And at its end.
    pub end_color: Option<[f32; 3]>,
    /// The document's `side`.
    pub side: f32,
    /// The document's `chisel`.
    pub chisel: Option<f32>,
    /// The document's `dry`.
    pub dry: [f32; 3],
    /// The document's `bristles`: lengths in mm.
    pub bristles: [f32; 3],
    /// The document's `drag`.
    pub drag: [f32; 2],
    /// The document's `scraped`.
    pub scraped: f32,
}

impl Gesture {
    /// A wet brush's, of one color.
    pub fn new(points: Vec<[f32; 2]>, widths: Vec<f32>, color: [f32; 3]) -> Self {
        Self {
            points,
            widths,
            color,
            end_color: None,
            side: 0.0,
            chisel: None,
            dry: [0.0, 0.0, 0.6],
            bristles: [0.45, 14.0, 0.0],
            drag: [0.0, 1.0],
            scraped: 0.0,
        }
    }
}

/// What strokes are laid on.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// What was seen.
    pub study: &'a Study,
    /// The shapes.
    pub shapes: &'a [Shape],
    /// Which of them each cell belongs to, from 1; 0 is bare.
    pub labels: &'a Raster<u16>,
    /// Seed of accidents.
    pub seed: u64,
}

impl Sheet<'_> {
    /// The shape at a place.
    pub fn shape_at(&self, [x, y]: [f32; 2]) -> Option<&Shape> {
        let held = |at: f32, of: usize| (at.max(0.0) as usize).min(of - 1);
        let label = self.labels.at(held(x, self.labels.width()), held(y, self.labels.height()));
        label.checked_sub(1).and_then(|shape| self.shapes.get(usize::from(shape)))
    }

    /// The color of the washes at a place, Lab.
    pub fn color_at(&self, place: [f32; 2]) -> [f32; 3] {
        match self.shape_at(place) {
            Some(shape) if shape.washes > 0 => shape.color_at(place),
            _ => [97.0, 0.0, 2.0],
        }
    }

    /// Whether a gesture goes over paint for most of its length: bare paper stays bare.
    pub fn is_free(&self, gesture: &Gesture) -> bool {
        let bare = gesture.points.iter().filter(|&&point| self.is_border(point)).count();
        4 * bare < gesture.points.len()
    }

    /// Whether a place is beyond the painting's end.
    fn is_border(&self, place: [f32; 2]) -> bool {
        let origin = self.study.mount.origin as f32;
        let photo = self.study.mount.photo.map(|cells| cells as f32);
        (0..2).any(|axis| !(origin..origin + photo[axis]).contains(&place[axis]))
            || self.shape_at(place).is_some_and(|shape| shape.is_border)
    }

    fn is_bare(&self, place: [f32; 2]) -> bool {
        self.shape_at(place).is_none_or(|shape| shape.washes == 0)
    }

    /// Mean color of the washes along a path.
    pub fn below(&self, path: &[[f32; 2]]) -> [f32; 3] {
        let mut sum = [0.0f32; 3];
        for &place in path {
            let color = self.color_at(place);
            sum.iter_mut().zip(color).for_each(|(sum, value)| *sum += value);
        }
        sum.map(|sum| sum / path.len().max(1) as f32)
    }

    /// Mean hue of the photograph along a path, Lab a and b.
    fn hue(&self, path: &[[f32; 2]]) -> [f32; 2] {
        let (width, height) = (self.labels.width(), self.labels.height());
        let mut sum = [0.0f32; 2];
        for &[x, y] in path {
            let [_, a, b] = self
                .study
                .lab
                .at((x.max(0.0) as usize).min(width - 1), (y.max(0.0) as usize).min(height - 1));
            sum[0] += a;
            sum[1] += b;
        }
        sum.map(|sum| sum / path.len().max(1) as f32)
    }

    /// Tones along the forms inside shapes, darker than those are.
    pub fn inner_tones(&self, params: &PhotoParams) -> Vec<Gesture> {
        let study = self.study;
        let s = study.mount.long_edge;
        let soft = gaussian_plane(&study.simple.map(|color| color[0]), 0.0018 * s);
        let [width, height] = study.mount.size;
        let tone =
            Raster::by_rows(width, height, |x, y| study.values.of(soft.at(x, y), study.near_focus.at(x, y)));
        let missing = Raster::by_rows(width, height, |x, y| {
            let place = [x as f32 + 0.5, y as f32 + 0.5];
            if self.is_bare(place) { 0.0 } else { self.color_at(place)[0] - tone.at(x, y) }
        });
        let mask = Raster::by_rows(width, height, |x, y| {
            let aside = 1.0 - study.attention.at(x, y);
            let foliage = study.texture.foliage.at(x, y);
            missing.at(x, y) > INNER[0] + INNER[1] * aside + INNER[2] * foliage * aside
        });
        let tracing = Tracing {
            least_length: (0.012 * s) as f32,
            widths: INNER_WIDTHS.map(|width| (width * s) as f32),
            smoothing: (0.0025 * s) as f32,
        };
        let mut found = trace(&mask, &missing, &tracing);
        found.retain(|found| {
            let aside = 1.0 - study.along(&found.points, &study.attention);
            let wide = found.widths.iter().fold(0.0f32, |most, &width| most.max(width));
            aside < INNER_ASIDE
                && found.length > (INNER_LENGTH[0] + INNER_LENGTH[1] * aside) * s as f32
                && found.length > 3.0 * wide
        });
        found.sort_by(|a, b| b.score.total_cmp(&a.score));
        found.truncate((MOST_INNER * params.detail.min(1.5)) as usize);
        let mut chance = Chance::new(self.seed, "inner tones");
        found
            .iter()
            .map(|found| {
                let planned = study.along(&found.points, &tone) - 1.5;
                let seen = study.along(&found.points, &study.attention);
                let [a, b] = study.values.tint(self.hue(&found.points), planned, seen);
                let mut gesture = pressed(found, [planned, a, b], &mut chance);
                self.run_dry(&mut gesture, params, 0.3, &mut chance);
                gesture
            })
            .collect()
    }

    /// Dark marks of a pointed brush.
    pub fn accents(&self, params: &PhotoParams) -> Vec<Gesture> {
        let study = self.study;
        let s = study.mount.long_edge;
        let fine = gaussian_plane(&study.lab.map(|color| color[0]), 0.0009 * s);
        let most = (MOST_ACCENTS * params.accents) as usize;
        let found = darks(&fine, &study.attention, &study.texture.foliage, &study.face, s, most);
        let mut chance = Chance::new(self.seed, "accents");
        found
            .iter()
            .filter(|found| {
                let seen = study.along(&found.points, &study.attention);
                let wide = found.widths.iter().fold(0.0f32, |most, &width| most.max(width));
                let is_line = found.length > ACCENT_SHAPE * wide;
                (seen > ACCENT_SEEN && (is_line || seen > ACCENT_DOT))
                    || (is_line && found.contrast > ACCENT_STRONG)
                    || found.length > ACCENT_LONG * s as f32
            })
            .map(|found| {
                let seen = study.along(&found.points, &study.attention);
                let tone = study.values.of(study.along(&found.points, &fine), seen) - ACCENT.0;
                let ground = self.below(&found.points)[0];
                let tone = tone.clamp(ACCENT.1[0], ACCENT.1[1]).max(ground - MOST_ACCENT);
                let [a, b] = study.values.tint(self.hue(&found.points), tone, seen);
                let mut gesture = pressed(found, [tone, a, b], &mut chance);
                self.run_dry(&mut gesture, params, 0.25, &mut chance);
                gesture
            })
            .collect()
    }

    /// Marks that stand for leaves, grass, water and stone.
    pub fn texture(&self, params: &PhotoParams) -> Vec<Gesture> {
        let study = self.study;
        let s = study.mount.long_edge;
        let [width, height] = study.mount.size;
        let pooled = |plane: &Plane| gaussian_plane(plane, 0.012 * s);
        let at = |x: usize, y: usize| [x as f32 + 0.5, y as f32 + 0.5];
        let is_plant = |[_, a, b]: [f32; 3]| (a < -1.5 && b > 2.0) || (b > 8.0 && a < 6.0 && b < 40.0);
        let lies = |x: usize, y: usize| libm::cosf(study.texture.direction.at(x, y)).abs() > 0.94;
        let here = |x: usize, y: usize| {
            let inside = study.mount.origin;
            let free = (inside..width - inside).contains(&x) && (inside..height - inside).contains(&y);
            if !free || self.is_bare(at(x, y)) || study.face.at(x, y) > 0.05 { 0.0 } else { 1.0 }
        };
        let plant = pooled(&study.lab.map(|color| f32::from(u8::from(is_plant(color)))));
        let coherent = |x: usize, y: usize| {
            study.texture.busy.at(x, y) * smoothstep(study.texture.coherence.at(x, y), 0.35, 0.6)
        };
        let water = pooled(&Raster::by_rows(width, height, |x, y| {
            let low = smoothstep(y as f32 / height as f32, 0.25, 0.5);
            coherent(x, y) * f32::from(u8::from(lies(x, y))) * low * (1.0 - plant.at(x, y))
        }))
        .map(|water| smoothstep(water, 0.3, 0.6));
        let density = |of: &(dyn Fn(usize, usize) -> f32 + Sync)| {
            Raster::by_rows(width, height, |x, y| {
                here(x, y) * (1.0 - 0.8 * study.attention.at(x, y)) * of(x, y).clamp(0.0, 1.0)
            })
        };
        let lightness = study.lab.map(|color| color[0]);
        let most = (MOST_TEXTURE * params.texture) as usize;
        let leaves = density(&|x, y| study.texture.foliage.at(x, y) * smoothstep(plant.at(x, y), 0.3, 0.7));
        let grass = density(&|x, y| {
            coherent(x, y)
                * smoothstep(plant.at(x, y), 0.3, 0.7)
                * smoothstep(y as f32 / height as f32, 0.3, 0.6)
        });
        let hatched = density(&|x, y| coherent(x, y) * (1.0 - plant.at(x, y)) * (1.0 - water.at(x, y)));
        let rippled = Raster::by_rows(width, height, |x, y| here(x, y) * water.at(x, y));
        let ground = |density| rules::Ground {
            density,
            direction: &study.texture.direction,
            lightness: &lightness,
            scale: 1.0,
            seed: self.seed,
            most,
            long_edge: s,
        };
        let mut chance = Chance::new(self.seed, "texture");
        let mut strokes: Vec<Stroke> = rules::foliage(&ground(&leaves));
        strokes.extend(rules::ripples(&rules::Ground { most, ..ground(&rippled) }));
        strokes.extend(rules::grass(&rules::Ground { most: most / 2, ..ground(&grass) }));
        strokes.extend(rules::hatch(&rules::Ground { most: most / 4, ..ground(&hatched) }));
        strokes
            .iter()
            // What is lighter than its ground is left out of a wash, not painted.
            .filter(|stroke| stroke.step < 0.0)
            .map(|stroke| {
                let [l, a, b] = self.below(&stroke.points);
                let color = [(l + stroke.step - 2.0).max(20.0), 1.08 * a, 1.08 * b];
                let (points, widths) = shaped(stroke);
                let mut gesture = Gesture::new(points, widths, color);
                gesture.side = chance.spread(0.28);
                if stroke.kind == Kind::Flat {
                    gesture.chisel = Some(chance.spread(30.0));
                }
                self.run_dry(&mut gesture, params, 0.35, &mut chance);
                gesture
            })
            .collect()
    }

    /// Lines of a pen along the most important contours.
    pub fn ink(&self, inked: &[(Vec<[f32; 2]>, f32)], params: &PhotoParams) -> Vec<Gesture> {
        if params.ink <= 0.0 {
            return Vec::new();
        }
        let s = self.study.mount.long_edge as f32;
        let mut lines: Vec<&(Vec<[f32; 2]>, f32)> = inked.iter().collect();
        lines.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut chance = Chance::new(self.seed, "ink");
        let lines = lines.into_iter().take((MOST_INK * params.ink) as usize);
        lines
            .map(|(path, _)| {
                let count = (path.len() / 3).clamp(3, 40);
                let points: Vec<[f32; 2]> =
                    (0..count).map(|k| path[k * (path.len() - 1) / (count - 1)]).collect();
                let widths = (0..count).map(|_| PEN * s * chance.between([0.7, 1.5])).collect();
                let mut gesture = Gesture::new(points, widths, [12.0, 0.0, -1.0]);
                gesture.dry = [0.0, chance.between([0.0, 0.5]), 0.7];
                gesture
            })
            .collect()
    }

    /// Lights that a knife scrapes out of dry darks: `lights` are those that are left after the ones that are kept bare.
    pub fn scraped(&self, lights: &[Trace], params: &PhotoParams) -> Vec<Gesture> {
        let mut chance = Chance::new(self.seed, "scraped");
        lights
            .iter()
            .filter(|found| {
                let wide = found.widths.iter().fold(0.0f32, |most, &width| most.max(width));
                self.below(&found.points)[0] < SCRAPED_BELOW
                    && found.length > SCRAPED_SHAPE * wide
                    && self.study.along(&found.points, &self.study.face) < 0.05
            })
            .take((MOST_SCRAPED * params.scraped) as usize)
            .map(|found| {
                let mut gesture = pressed(found, [97.0, 0.0, 2.0], &mut chance);
                let thin = SCRAPED_WIDTH * self.study.mount.long_edge as f32;
                gesture.widths.iter_mut().for_each(|width| *width = (0.6 * *width).min(thin));
                gesture.dry = [chance.between([0.1, 0.35]), chance.between([0.4, 0.7]), 0.4];
                gesture.scraped = chance.between([0.45, 0.8]);
                gesture
            })
            .collect()
    }

    /// Drops that were flicked off a loaded brush, a burst or two beside the subject.
    pub fn spatter(&self, params: &PhotoParams) -> Vec<Gesture> {
        let study = self.study;
        let s = study.mount.long_edge as f32;
        let most = (MOST_SPATTER * params.spatter) as usize;
        let mut chance = Chance::new(self.seed, "spatter");
        let (origin, photo) = (study.mount.origin as f32, study.mount.photo.map(|cells| cells as f32));
        let mut drops: Vec<Gesture> = Vec::new();
        for _ in 0..BURSTS {
            if drops.len() >= most {
                break;
            }
            let middle = [0, 1].map(|axis: usize| origin + chance.between([0.08, 0.92]) * photo[axis]);
            let (seen, face) =
                (study.attention.sample(middle[0], middle[1]), study.face.sample(middle[0], middle[1]));
            if seen > SPATTER_SEEN || face > 0.0 || self.is_border(middle) || self.is_bare(middle) {
                continue;
            }
            let [l, a, b] = self.color_at(middle);
            let color = [(l - chance.between(DROP_STEP)).max(20.0), 1.1 * a, 1.1 * b];
            // They fly one way: a fan of drops, the further the smaller.
            let way = chance.between([0.0, core::f32::consts::TAU]);
            for _ in 0..chance.count(DROPS) {
                let far = chance.unit() * SPATTER_FLIES * s;
                let angle = way + chance.spread(0.5);
                let place = [middle[0] + far * libm::cosf(angle), middle[1] + far * libm::sinf(angle)];
                let size = s * chance.between(DROP_SIZES) * (1.2 - 0.6 * far / (SPATTER_FLIES * s));
                if !self.is_border(place) && !self.is_bare(place) {
                    drops.push(Gesture::new(vec![place], vec![size], color));
                }
            }
        }
        drops
    }

    /// Lets a brush run out, now and then.
    fn run_dry(&self, gesture: &mut Gesture, params: &PhotoParams, often: f32, chance: &mut Chance) {
        let face = self.study.along(&gesture.points, &self.study.face);
        if face > 0.1 || chance.unit() > often * params.drybrush as f32 {
            return;
        }
        let wide = gesture.widths.iter().fold(0.0f32, |most, &width| most.max(width))
            / self.study.mount.cells_per_mm as f32;
        gesture.dry = [0.0, chance.between([0.5, 0.95]), chance.between([0.3, 0.7])];
        gesture.bristles = [(0.16 * wide).clamp(0.3, 0.7), chance.between([9.0, 18.0]), 0.25];
        if wide > 2.0 && chance.unit() < 0.4 {
            gesture.drag = [0.9, 0.4 * wide];
        }
    }
}

/// A traced stroke as a hand makes it: set down, pressed, lifted off slowly.
fn pressed(found: &Trace, color: [f32; 3], chance: &mut Chance) -> Gesture {
    let count = found.points.len();
    let widths = found.widths.iter().enumerate().map(|(at, width)| {
        let along = at as f32 / (count - 1).max(1) as f32;
        width * pressed_at(along)
    });
    let widths = widths.collect();
    let mut gesture = Gesture::new(found.points.clone(), widths, color);
    gesture.side = chance.spread(0.22);
    gesture
}

/// The same as an outline, for what is left out of washes: lights.
pub fn outline(found: &Trace) -> Vec<[f32; 2]> {
    outlined(found, pressed_at)
}

/// Width along a stroke as a part of the most: set down, pressed, lifted off slowly.
fn pressed_at(along: f32) -> f32 {
    libm::powf((7.0 * (along + 0.06)).min(2.4 * (1.04 - along)).clamp(0.12, 1.0), 0.7)
}

/// An outline whose width is so much of the trace's along it.
pub fn outlined(found: &Trace, pressure: impl Fn(f32) -> f32) -> Vec<[f32; 2]> {
    let count = found.points.len();
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let fine = 4 * (count - 1).max(1);
    for step in 0..=fine {
        let at = step as f32 / fine as f32;
        let position = at * (count - 1) as f32;
        let (k, part) = (
            (position as usize).min(count.saturating_sub(2)),
            position - (position as usize).min(count.saturating_sub(2)) as f32,
        );
        let point = |k: usize| found.points[k.min(count - 1)];
        let before = point(k.saturating_sub(1));
        let (a, b, after) = (point(k), point(k + 1), point(k + 2));
        let through = |c: usize| {
            0.5 * (2.0 * a[c]
                + (b[c] - before[c]) * part
                + (2.0 * before[c] - 5.0 * a[c] + 4.0 * b[c] - after[c]) * part * part
                + (3.0 * a[c] - before[c] - 3.0 * b[c] + after[c]) * part * part * part)
        };
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let size = libm::hypotf(dx, dy).max(1e-6);
        let width = found.widths[k] + part * (found.widths[(k + 1).min(count - 1)] - found.widths[k]);
        let half = 0.5 * width * pressure(at);
        let (x, y) = (through(0), through(1));
        left.push([x - dy / size * half, y + dx / size * half]);
        right.push([x + dy / size * half, y - dx / size * half]);
    }
    right.reverse();
    left.extend(right);
    left
}

/// A stroke of a rule with as many points as its shape needs.
fn shaped(stroke: &Stroke) -> (Vec<[f32; 2]>, Vec<f32>) {
    const POINTS: usize = 7;
    let count = stroke.points.len();
    let at = |position: f32| {
        let k = (position as usize).min(count.saturating_sub(2));
        let part = position - k as f32;
        let (a, b) = (stroke.points[k], stroke.points[(k + 1).min(count - 1)]);
        [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
    };
    let places = (0..POINTS).map(|k| k as f32 / (POINTS - 1) as f32);
    places
        .map(|along| (at(along * (count - 1) as f32), stroke.width * pressure(stroke.kind, along).max(0.06)))
        .unzip()
}

/// Width along a stroke as a part of the most.
fn pressure(kind: Kind, s: f32) -> f32 {
    match kind {
        Kind::Leaf => libm::powf(libm::sinf(core::f32::consts::PI * libm::powf(s, 0.56)).max(0.0), 0.78),
        Kind::Drop => smoothstep(s, -0.02, 0.05).sqrt() * libm::powf(1.0 - s, 0.55),
        Kind::Tail => libm::powf(s / 0.06 + 0.12, 0.6).min(1.0) * (1.0 - 0.93 * smoothstep(s, 0.55, 1.0)),
        Kind::Hair => libm::powf(1.0 - s, 0.8) * (0.55 + s / 0.08).min(1.0),
        Kind::Flat => 1.0,
    }
}
