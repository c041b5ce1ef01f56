//! Where the painting ends on its sheet.

use girtin_grid::Raster;
use rayon::prelude::*;

use crate::accidents::{Chance, plane, smoothstep};
use crate::contours::around;
use crate::mount::{Border, Mounting};
use crate::study::Study;

/// How far before the photograph's border a shape ends, parts of the long edge: the least, and up to how much more where
/// nobody looks.
const INSET: [f32; 2] = [0.008, 0.055];
/// How far a vignette's and a deckled edge stray, and over which lengths, parts of the long edge.
const STRAYS: (f32, f64) = (0.007, 0.025);
const DECKLE: (f32, f64) = (0.004, 0.008);
/// Brush marks that end a shape: how many, and their least and most length and width, parts of the long edge.
const MARKS: usize = 22;
const LENGTHS: [f32; 2] = [0.03, 0.12];
const WIDTHS: [f32; 2] = [0.010, 0.030];
/// Corners of a taped sheet that stay open: how far along and how far in, parts of the long edge.
const CORNER: [[f32; 2]; 2] = [[0.14, 0.30], [0.07, 0.15]];
/// How much smaller the second and the third are.
const SMALLER: [f32; 4] = [1.0, 0.65, 0.0, 0.0];

/// What stays bare around the painting, as rings in cells; none without a margin.
pub fn border(study: &Study, labels: &Raster<u16>, mounting: &Mounting, seed: u64) -> Vec<Vec<[f32; 2]>> {
    if mounting.margin <= 0.0 {
        return Vec::new();
    }
    let (mount, s) = (&study.mount, study.mount.long_edge as f32);
    let size = mount.size;
    let inside = mount.distance().map(|beyond| -beyond);
    let noise = |name: &str, sigma: f64| plane(seed, name, size, study.cells(sigma));
    let mut chance = Chance::new(seed, "border");
    let (mut painted, marks) = match mounting.border {
        Border::Vignette => {
            let most = labels.as_slice().iter().max().map_or(0, |&label| usize::from(label));
            let insets: Vec<f32> = (0..=most)
                .map(|_| {
                    let far = chance.unit();
                    far * far.sqrt()
                })
                .collect();
            let strays = noise("border", STRAYS.1);
            let painted = Raster::by_rows(size[0], size[1], |x, y| {
                let aside = 1.0 - smoothstep(study.near_focus.at(x, y), 0.25, 0.75);
                let inset = INSET[0] + INSET[1] * aside * insets[usize::from(labels.at(x, y))];
                inside.at(x, y) > s * (inset + STRAYS.0 * strays.at(x, y))
            });
            (painted, MARKS)
        }
        Border::Taped => {
            let open = corners(study, &mut chance);
            let strays = noise("border", STRAYS.1);
            let painted = Raster::by_rows(size[0], size[1], |x, y| {
                let inside = inside.at(x, y);
                let corner = open.iter().map(|corner| corner.open(x, y)).fold(-9.0f32, f32::max);
                inside > 0.0 && corner + 0.12 * strays.at(x, y) - 0.7 * study.attention.at(x, y) < 0.0
            });
            (painted, MARKS / 2)
        }
        Border::Deckle => {
            let strays = noise("border", DECKLE.1);
            let wide = noise("border, wide", 4.0 * DECKLE.1);
            let painted = Raster::by_rows(size[0], size[1], |x, y| {
                inside.at(x, y) > s * DECKLE.0 * (0.7 * strays.at(x, y) + wide.at(x, y))
            });
            (painted, 0)
        }
    };
    stroked(&mut painted, study, marks, &mut chance);
    if mounting.border == Border::Taped {
        let cells = painted.as_mut_slice().par_iter_mut().zip(inside.as_slice());
        cells.for_each(|(painted, &inside)| *painted &= inside > 0.0);
    }
    let bare = painted.map(|painted| !painted);
    around(&bare, f64::from(s), 0.5)
}

/// Marks of a brush across the painting's end.
fn stroked(painted: &mut Raster<bool>, study: &Study, marks: usize, chance: &mut Chance) {
    let (width, height) = (painted.width(), painted.height());
    let s = study.mount.long_edge as f32;
    let is_rim = |x: usize, y: usize| {
        painted.at(x, y)
            && (!painted.at(x + 1, y)
                || !painted.at(x - 1, y)
                || !painted.at(x, y + 1)
                || !painted.at(x, y - 1))
    };
    let rim: Vec<[usize; 2]> = (1..height - 1)
        .flat_map(|y| (1..width - 1).map(move |x| [x, y]))
        .filter(|&[x, y]| is_rim(x, y))
        .collect();
    if rim.is_empty() {
        return;
    }
    for _ in 0..marks {
        let [x, y] = rim[((chance.unit() * rim.len() as f32) as usize).min(rim.len() - 1)];
        let coherent = study.texture.coherence.at(x, y) > 0.5;
        let own = if coherent { study.texture.direction.at(x, y) } else { 0.0 };
        let angle = own + chance.spread(0.4);
        let (length, wide) = (s * chance.between(LENGTHS), s * chance.between(WIDTHS));
        let way = if chance.unit() < 0.5 { 1.0 } else { -1.0 };
        let (cos, sin) = (libm::cosf(angle), libm::sinf(angle));
        let bow = chance.spread(0.06) * length;
        let reach = length as usize / 2 + wide as usize + 2;
        for v in y.saturating_sub(reach)..(y + reach).min(height) {
            for u in x.saturating_sub(reach)..(x + reach).min(width) {
                let (dx, dy) = (u as f32 - x as f32, v as f32 - y as f32);
                let along = way * (dx * cos + dy * sin) / length + 0.5;
                if !(0.0..=1.0).contains(&along) {
                    continue;
                }
                let across = -dx * sin + dy * cos - bow * libm::sinf(core::f32::consts::PI * along);
                // A flat brush: cut where it is set down, torn where it is lifted.
                let press = (9.0 * (along + 0.08)).min(3.0 * (1.06 - along)).clamp(0.1, 1.0);
                if across.abs() < 0.5 * wide * libm::powf(press, 0.7) {
                    painted.row_mut(v)[u] = true;
                }
            }
        }
    }
}

/// A corner that stays open.
struct Corner {
    at: [f32; 2],
    inward: [f32; 2],
    reach: [f32; 2],
}

impl Corner {
    /// Above 0 where it is open.
    fn open(&self, x: usize, y: usize) -> f32 {
        let part = [x as f32, y as f32];
        let part = [0, 1].map(|axis: usize| {
            (((part[axis] - self.at[axis]) * self.inward[axis]).max(0.0)) / self.reach[axis].max(1e-3)
        });
        1.0 - libm::powf(part[0], 1.3) - libm::powf(part[1], 1.3)
    }
}

/// The corners that are looked at least.
fn corners(study: &Study, chance: &mut Chance) -> Vec<Corner> {
    let (mount, s) = (&study.mount, study.mount.long_edge as f32);
    let [left, top] = [mount.origin as f32; 2];
    let [right, bottom] = [left + mount.photo[0] as f32, top + mount.photo[1] as f32];
    let mut all: Vec<(f32, [f32; 2], [f32; 2])> = [
        ([left, top], [1.0, 1.0]),
        ([right, top], [-1.0, 1.0]),
        ([left, bottom], [1.0, -1.0]),
        ([right, bottom], [-1.0, -1.0]),
    ]
    .into_iter()
    .map(|(at, inward)| {
        let middle = [0, 1].map(|axis: usize| at[axis] + 0.1 * s * inward[axis]);
        let seen = study.near_focus.sample(middle[0], middle[1]);
        (seen + 0.15 * chance.unit(), at, inward)
    })
    .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let smaller = SMALLER.iter().zip(all).filter(|(smaller, _)| **smaller > 0.0);
    smaller
        .map(|(smaller, (_, at, inward))| Corner {
            at,
            inward,
            reach: CORNER.map(|range| smaller * s * chance.between(range)),
        })
        .collect()
}
