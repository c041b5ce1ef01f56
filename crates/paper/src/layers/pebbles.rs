//! Rounded bumps of uneven size that meet in creases: cellular noise with weights.

use girtin_grid::random::{mix, stage, unit_f64};

use crate::samples::{Ground, Patch};

girtin_params::parameters! {
    /// Rounded bumps of uneven size that meet in creases, as the felt leaves them; upside down, dimples.
    pub struct Pebbles {
        amount: f64 {
            symbol: "", label: "Amount", unit: "", default: 1.0, hard: (-1.0, 1.0), soft: (-1.0, 1.0),
            acts: Simulation, doc: "Share of the relief. Negative makes dimples.", source: "custom",
        }
        size_mm: f64 {
            symbol: "", label: "Size", unit: "mm", default: 1.2, hard: (0.2, 50.0), soft: (0.4, 5.0),
            acts: Simulation, doc: "Mean distance of two bumps.", source: "custom",
        }
        stretch: f64 {
            symbol: "", label: "Stretch", unit: "", default: 1.0, hard: (0.1, 10.0), soft: (0.5, 2.0),
            acts: Simulation, doc: "Length of bumps along the sheet over that across it.", source: "custom",
        }
        unevenness: f64 {
            symbol: "", label: "Unevenness", unit: "", default: 0.7, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much bumps differ in size and height.", source: "custom",
        }
        crease: f64 {
            symbol: "", label: "Crease width", unit: "", default: 0.3, hard: (0.01, 1.0), soft: (0.05, 0.6),
            acts: Simulation, doc: "How softly bumps run into each other.", source: "custom",
        }
    }
}

/// Points keep this far, in lattice cells, from the border of their own cell.
const INSET: f64 = 0.08;

/// Largest weight of a point: taken from its squared distances.
const MOST_WEIGHT: f64 = 0.15;

/// Weighted squared distances are cut here. Points beyond the 3 × 3 cells searched are at least 1 + INSET
/// away, and 1.08² − 0.15 > 1: so none of them could matter, and the relief has no steps at the borders of
/// cells.
const FARTHEST: f32 = 1.0;

/// One bump, relative to the corner of the lattice cell a point is in.
#[derive(Clone, Copy)]
struct Bump {
    x: f32,
    y: f32,
    weight: f32,
}

impl Pebbles {
    pub(super) fn fill(&self, ground: &Ground, number: usize, patch: &Patch, out: &mut [f32]) {
        let root = libm::sqrt(self.stretch);
        let lattice = ground.lattice([self.size_mm * root, self.size_mm / root]);
        let noise = ground.noise(const { stage("paper pebbles") }, number, &lattice);
        let bump = |cell: [i64; 2], dx: i64, dy: i64| {
            let cell = [cell[0] + dx, cell[1] + dy];
            let [x, y] = noise.point(cell).map(|t| INSET + (1.0 - 2.0 * INSET) * t);
            let weight = MOST_WEIGHT * self.unevenness * (2.0 * unit_f64(mix(noise.bits(cell))) - 1.0);
            Bump { x: (dx as f64 + x) as f32, y: (dy as f64 + y) as f32, weight: weight as f32 }
        };
        let x = patch.x.in_units(lattice.spacing_mm[0], 0.0);
        let y = patch.y.in_units(lattice.spacing_mm[1], 0.0);
        let soft = self.crease as f32;
        let count = patch.x.count;
        let (mut fx, mut first, mut second) = (vec![0.0f32; count], vec![0.0f32; count], vec![0.0f32; count]);
        let runs: Vec<_> = x.runs(count).collect();
        for (cell_x, run) in &runs {
            for (value, j) in fx[run.clone()].iter_mut().zip(run.clone()) {
                *value = (x.at(j) - *cell_x as f64) as f32;
            }
        }
        for (cell_y, lines) in y.runs(patch.y.count) {
            for (cell_x, run) in &runs {
                let cell = [*cell_x, cell_y];
                let bumps: [Bump; 9] =
                    core::array::from_fn(|k| bump(cell, k as i64 % 3 - 1, k as i64 / 3 - 1));
                let fx = &fx[run.clone()];
                for line in lines.clone() {
                    let fy = (y.at(line) - cell_y as f64) as f32;
                    let first = &mut first[..fx.len()];
                    let second = &mut second[..fx.len()];
                    first.fill(FARTHEST);
                    second.fill(FARTHEST);
                    for bump in &bumps {
                        let up = (fy - bump.y) * (fy - bump.y) - bump.weight;
                        for ((first, second), &fx) in first.iter_mut().zip(second.iter_mut()).zip(fx) {
                            let square = (fx - bump.x) * (fx - bump.x) + up;
                            *second = second.min(first.max(square));
                            *first = first.min(square);
                        }
                    }
                    let from = line * count + run.start;
                    for ((value, &first), &second) in out[from..].iter_mut().zip(&*first).zip(&*second) {
                        // The smooth minimum of the two distances: the crease between bumps is a rounded
                        // valley.
                        let near = (soft - (second - first)).max(0.0);
                        *value = near * near / (4.0 * soft) - first;
                    }
                }
            }
        }
    }
}
