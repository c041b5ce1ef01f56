//! Rows for the routines that move pore water.

use crate::engine::world::{Place, World};
use crate::simulate_capillary_flow::{PoreRows, absorb, diffuse, spread};

impl World<'_> {
    pub fn absorb(&mut self, row: usize) {
        let Some(pores) = &self.task.pores else { return };
        for &run in self.damp_runs(row) {
            let saturation = self.saturation.row_mut(row);
            absorb(saturation, self.height.row(row), self.mask.row(row), pores, run);
        }
    }

    pub fn diffuse(&mut self, row: usize, slot: usize) {
        let Some(pores) = &self.task.pores else { return };
        let runs = self.damp_runs(row);
        let ring = self.scratch.pores(slot);
        ring.take(self.damp, row, &self.saturation);
        let (here, below) = self.saturation.row_mut_and_below(row);
        let old = PoreRows {
            above: &ring.above.values,
            here: &ring.here.values,
            below,
            height_above: self.height.row(row - 1),
            height: self.height.row(row),
            height_below: self.height.row(row + 1),
        };
        for &run in runs {
            diffuse(here, &old, pores, run);
        }
    }

    pub fn spread(&mut self, row: usize) {
        let Some(pores) = &self.task.pores else { return };
        for &run in self.damp_runs(row) {
            let grown = spread(self.mask.row_mut(row), self.saturation.row(row), pores, run);
            if grown && self.own.contains(&row) {
                Place::note(&mut self.found.grown, row, run);
                self.found.grown_rows.push(row);
            }
        }
    }
}
