//! Lines of the mould: fine laid lines along the sheet, chain lines across it.

use girtin_grid::random::stage;

use super::{ridge, rows};
use crate::samples::{Ground, Patch};

girtin_params::parameters! {
    /// Lines of the mould: fine laid lines along the sheet, chain lines across it.
    pub struct Laid {
        amount: f64 {
            symbol: "", label: "Amount", unit: "", default: 1.0, hard: (-1.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "Share of the relief. Negative presses the lines in.", source: "custom",
        }
        line_mm: f64 {
            symbol: "", label: "Line distance", unit: "mm", default: 1.1, hard: (0.3, 10.0), soft: (0.6, 2.0),
            acts: Simulation, doc: "Distance of two laid lines.", source: "handmade sheets: 7 to 12 lines a cm",
        }
        chain_mm: f64 {
            symbol: "", label: "Chain distance", unit: "mm", default: 25.0, hard: (2.0, 200.0), soft: (15.0, 40.0),
            acts: Simulation, doc: "Distance of two chain lines.", source: "handmade sheets: about an inch",
        }
        chain_width_mm: f64 {
            symbol: "", label: "Chain width", unit: "mm", default: 1.2, hard: (0.2, 20.0), soft: (0.5, 3.0),
            acts: Simulation, doc: "Width of a chain line.", source: "custom",
        }
        chain: f64 {
            symbol: "", label: "Chain", unit: "", default: 0.7, hard: (-2.0, 2.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "Height of chain lines over that of laid lines.", source: "custom",
        }
        wander_mm: f64 {
            symbol: "", label: "Wander", unit: "mm", default: 0.25, hard: (0.0, 2.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "How far lines stray from straight.", source: "custom",
        }
        unevenness: f64 {
            symbol: "", label: "Unevenness", unit: "", default: 0.5, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much lines vary in height along their way.", source: "custom",
        }
    }
}

/// Gradient noise reaches about this far in practice: three deviations.
const REACH: f64 = 0.9;

impl Laid {
    pub(super) fn fill(&self, ground: &Ground, number: usize, patch: &Patch, out: &mut [f32]) {
        let lines = ground.lattice([self.chain_mm, self.line_mm]);
        let [chain_mm, line_mm] = lines.spacing_mm;
        // Lines stray slowly along their way, each almost as its neighbours do; they vary in height faster.
        let drift_lattice = ground.lattice([35.0, 6.0]);
        let drift = ground.noise(const { stage("paper laid drift") }, number, &drift_lattice);
        let height_lattice = ground.lattice([4.0, self.line_mm]);
        let heights = ground.noise(const { stage("paper laid height") }, number, &height_lattice);

        let drift_x = patch.x.in_units(drift_lattice.spacing_mm[0], 0.0);
        let drift_y = patch.y.in_units(drift_lattice.spacing_mm[1], 0.0);
        let height_x = patch.x.in_units(height_lattice.spacing_mm[0], 0.0);
        let height_y = patch.y.in_units(height_lattice.spacing_mm[1], 0.0);
        let strays = (self.wander_mm / (REACH * line_mm)) as f32;
        let varies = (self.unevenness / REACH) as f32;
        let half_chain = (chain_mm / (0.5 * self.chain_width_mm.min(chain_mm))) as f32;

        let (mut stray, mut vary) = (vec![0.0; out.len()], vec![1.0; out.len()]);
        drift.add_gradient_block(&drift_x, &drift_y, patch.x.count, strays, &mut stray);
        heights.add_gradient_block(&height_x, &height_y, patch.x.count, varies, &mut vary);
        let columns: Vec<f32> = (0..patch.x.count)
            .map(|i| {
                let u = patch.x.mm(i) / chain_mm;
                (u - libm::floor(u)) as f32
            })
            .collect();
        for (j, row) in rows(patch, out) {
            let here = j * patch.x.count..;
            let v = patch.y.mm(j) / line_mm;
            let v = (v - libm::floor(v)) as f32;
            for (((value, &stray), &vary), &u) in
                row.iter_mut().zip(&stray[here.clone()]).zip(&vary[here]).zip(&columns)
            {
                let t = v + stray;
                let line = ridge(t - floor(t)) * vary;
                let t = u + 0.02 * stray;
                let d = ((t - floor(t)) - 0.5) * half_chain;
                let chain = (1.0 - d * d).max(0.0);
                *value = line + self.chain as f32 * chain * chain * vary;
            }
        }
    }
}

/// Largest whole number not above `t`, for |t| below 2^31: exact in any rounding, and inlined.
fn floor(t: f32) -> f32 {
    let whole = t as i32 as f32;
    if whole > t { whole - 1.0 } else { whole }
}
