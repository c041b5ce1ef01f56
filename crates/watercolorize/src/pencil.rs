//! The drawing under the washes: lines of a pencil.

use crate::accidents::Chance;
use crate::settings::PhotoParams;
use crate::strokes::{Gesture, Sheet};

/// A pencil: most lines, shortest and longest, width, parts of the long edge; turn that ends one, radians; how far it goes
/// beside a contour and past its end, parts of the long edge; and how much darker than its ground it is, Lab L.
const MOST_PENCIL: f64 = 40.0;
const PENCIL_LENGTHS: [f32; 2] = [0.02, 0.30];
const PENCIL: f32 = 0.0013;
/// Darkest ground, Lab L: in darks a pencil is not seen.
const PENCIL_ABOVE: f32 = 60.0;
const PENCIL_CORNER: f32 = 0.8;
const PENCIL_BESIDE: f32 = 0.0014;
const PENCIL_PAST: [f32; 2] = [0.001, 0.008];
const PENCIL_STEP: [f32; 2] = [16.0, 34.0];

impl Sheet<'_> {
    /// The drawing that washes are laid over: lines of a pencil along what is drawn most exactly, in one go each, a little
    /// beside the contour and past its ends.
    pub fn pencil(&self, lines: &[(Vec<[f32; 2]>, f32)], params: &PhotoParams) -> Vec<Gesture> {
        let s = self.study.mount.long_edge as f32;
        let mut chance = Chance::new(self.seed, "pencil");
        let mut drawn: Vec<(f32, Vec<[f32; 2]>)> = Vec::new();
        for (path, _) in lines {
            for run in between_corners(path) {
                let length = run.windows(2).map(|pair| away(pair[0], pair[1])).sum::<f32>();
                if length < PENCIL_LENGTHS[0] * s {
                    continue;
                }
                let seen = self.study.along(run, &self.study.attention);
                if self.below(run)[0] < PENCIL_ABOVE {
                    continue;
                }
                let step = self.study.along(run, &self.study.steps);
                let face = self.study.along(run, &self.study.face);
                drawn.push(((0.2 + seen) * step.min(20.0) * length.sqrt() * (1.0 - face), run.to_vec()));
            }
        }
        drawn.sort_by(|a, b| b.0.total_cmp(&a.0));
        drawn.truncate((MOST_PENCIL * params.pencil) as usize);
        drawn
            .iter()
            .map(|(_, run)| {
                let points = in_one_go(run, PENCIL_LENGTHS[1] * s);
                let beside = chance.spread(PENCIL_BESIDE * s);
                let past = [0, 1].map(|_| chance.between(PENCIL_PAST) * s);
                let points = shifted(&points, beside, past);
                let ground = self.below(&points);
                let tone = (ground[0] - chance.between(PENCIL_STEP)).max(30.0);
                let wide = PENCIL * s;
                let last = (points.len() - 1) as f32;
                let widths = (0..points.len())
                    .map(|at| {
                        let along = at as f32 / last;
                        wide * chance.between([0.8, 1.2])
                            * (4.0 * along + 0.4).min(3.0 * (1.0 - along) + 0.3).min(1.0)
                    })
                    .collect();
                let mut gesture =
                    Gesture::new(points, widths, [tone, 0.6 * ground[1], 0.6 * ground[2] - 1.0]);
                gesture.dry = [0.0, chance.between([0.0, 0.5]), 0.8];
                gesture
            })
            .collect()
    }
}

fn away(a: [f32; 2], b: [f32; 2]) -> f32 {
    libm::hypotf(a[0] - b[0], a[1] - b[1])
}

/// A path cut where it turns sharply.
fn between_corners(path: &[[f32; 2]]) -> Vec<&[[f32; 2]]> {
    const OVER: usize = 3;
    let mut runs = Vec::new();
    let mut from = 0;
    for at in OVER..path.len().saturating_sub(OVER) {
        let (a, b, c) = (path[at - OVER], path[at], path[at + OVER]);
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
        let turn = libm::atan2f(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
        if turn.abs() > PENCIL_CORNER && at > from + OVER {
            runs.push(&path[from..=at]);
            from = at;
        }
    }
    runs.push(&path[from..]);
    runs.retain(|run| run.len() > 2);
    runs
}

/// A path as a hand goes along it: smooth, through few points, not longer than so much.
fn in_one_go(run: &[[f32; 2]], longest: f32) -> Vec<[f32; 2]> {
    let mut smooth = run.to_vec();
    for _ in 0..12 {
        let before = smooth.clone();
        for at in 1..before.len() - 1 {
            smooth[at] =
                [0, 1].map(|k: usize| 0.5 * before[at][k] + 0.25 * (before[at - 1][k] + before[at + 1][k]));
        }
    }
    let mut length = 0.0;
    let mut end = 1;
    while end + 1 < smooth.len() && length < longest {
        length += away(smooth[end], smooth[end - 1]);
        end += 1;
    }
    let count = (end / 5).clamp(3, 12);
    (0..count).map(|k| smooth[k * end / (count - 1)]).collect()
}

/// A path moved to one side, and carried on past both of its ends.
fn shifted(points: &[[f32; 2]], beside: f32, past: [f32; 2]) -> Vec<[f32; 2]> {
    let last = points.len() - 1;
    let along = |at: usize| {
        let (a, b) = (points[at.saturating_sub(1)], points[(at + 1).min(last)]);
        let size = away(a, b).max(1e-6);
        [(b[0] - a[0]) / size, (b[1] - a[1]) / size]
    };
    let beyond = |at: usize| {
        if at == 0 {
            -past[0]
        } else if at == last {
            past[1]
        } else {
            0.0
        }
    };
    (0..points.len())
        .map(|at| {
            let [dx, dy] = along(at);
            let ([x, y], past) = (points[at], beyond(at));
            [x - beside * dy + past * dx, y + beside * dx + past * dy]
        })
        .collect()
}
