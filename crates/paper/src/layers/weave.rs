//! Threads over and under each other, as in canvas and linen.

use girtin_grid::random::stage;

use super::{rows, soft_max};
use crate::samples::{Ground, Lattice, Patch};

girtin_params::parameters! {
    /// Threads over and under each other, as in canvas and linen: a plain weave of uneven yarn.
    pub struct Weave {
        amount: f64 {
            symbol: "", label: "Amount", unit: "", default: 1.0, hard: (-1.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "Share of the relief.", source: "custom",
        }
        thread_mm: [f64; 2] {
            symbol: "", label: "Thread distances", unit: "mm", default: [0.7, 0.8], hard: (0.25, 10.0), soft: (0.4, 2.0),
            acts: Simulation, doc: "Distances of two threads: of those down the sheet, of those across it.",
            source: "artists' cotton duck: 12 to 16 threads a cm",
        }
        bend: f64 {
            symbol: "", label: "Bend", unit: "", default: 0.7, hard: (0.0, 1.0), soft: (0.3, 0.9),
            acts: Simulation, doc: "How far threads rise and sink over their own thickness.", source: "custom",
        }
        wander: f64 {
            symbol: "", label: "Wander", unit: "threads", default: 0.25, hard: (0.0, 0.45), soft: (0.0, 0.4),
            acts: Simulation, doc: "How far threads stray from straight.", source: "custom",
        }
        slubs: f64 {
            symbol: "", label: "Slubs", unit: "", default: 0.4, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How unevenly thick the yarn is.", source: "custom",
        }
    }
}

/// Threads cross softly over this much of their height.
const CONTACT: f32 = 0.25;

/// Noise of deviation 0.3 to a change in thickness.
const SWELL: f64 = 1.5;

impl Weave {
    pub(super) fn fill(&self, ground: &Ground, number: usize, patch: &Patch, out: &mut [f32]) {
        // Over and under alternate, so a tile holds an even number of threads.
        let threads = ground.lattice_of_multiples(self.thread_mm, [2, 2]);
        let [down_mm, across_mm] = threads.spacing_mm;
        // A thread strays and swells slowly along its way and independently of its neighbours but one.
        let strays = [ground.lattice([2.2 * down_mm, 9.0]), ground.lattice([9.0, 2.2 * across_mm])];
        let swells = [ground.lattice([1.3 * down_mm, 5.0]), ground.lattice([5.0, 1.3 * across_mm])];
        let noise = |stage: u64, lattice: &Lattice, base: f32, weight: f64| {
            let x = patch.x.in_units(lattice.spacing_mm[0], 0.0);
            let y = patch.y.in_units(lattice.spacing_mm[1], 0.0);
            let mut block = vec![base; out.len()];
            let noise = ground.noise(stage, number, lattice);
            noise.add_gradient_block(&x, &y, patch.x.count, weight as f32, &mut block);
            block
        };
        let wavy = [
            noise(const { stage("paper weave down") }, &strays[0], 0.0, self.wander),
            noise(const { stage("paper weave across") }, &strays[1], 0.0, self.wander),
        ];
        let thick = [
            noise(const { stage("paper weave down swells") }, &swells[0], 1.0, SWELL * self.slubs),
            noise(const { stage("paper weave across swells") }, &swells[1], 1.0, SWELL * self.slubs),
        ];
        let bend = self.bend as f32;
        let columns: Vec<f32> = (0..patch.x.count).map(|i| within_two(patch.x.mm(i) / down_mm)).collect();
        for (j, row) in rows(patch, out) {
            let v0 = within_two(patch.y.mm(j) / across_mm);
            for (i, value) in row.iter_mut().enumerate() {
                let at = j * patch.x.count + i;
                // +2 keeps both above 0, where truncation is the floor.
                let (u, v) = (columns[i] + wavy[0][at] + 2.0, v0 + wavy[1][at] + 2.0);
                let (column, line) = (u as i32, v as i32);
                let (fu, fv) = (2.0 * (u - column as f32) - 1.0, 2.0 * (v - line as f32) - 1.0);
                let (down, across) = (1.0 - fu * fu, 1.0 - fv * fv);
                let over = if (column + line) & 1 == 0 { bend } else { -bend };
                // At a thread's border its own height jumps between ±bend; the other thread is higher there,
                // as bend is at most 1, so the larger of the two has no step.
                *value = soft_max(
                    down * thick[0][at] + over * across,
                    across * thick[1][at] - over * down,
                    CONTACT,
                );
            }
        }
    }
}

/// `t` modulo 2, computed before precision is lost.
fn within_two(t: f64) -> f32 {
    (t - 2.0 * libm::floor(0.5 * t)) as f32
}
