//! Rows for the routines that move pore water.

use crate::engine::world::{Place, World};
use crate::simulate_capillary_flow::{FillRows, PoreRows, absorb, diffuse, diffuse_conducting, fill, spread};

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
        if self.living.as_ref().is_some_and(|living| living.facts.is_quiet(row)) {
            return;
        }
        let runs = self.damp_runs(row);
        let kept = self.scratch.pores(slot);
        kept.ring.take(self.damp, self.ground, row, &self.saturation);
        let (here, below) = self.saturation.row_mut_and_below(row);
        let old = PoreRows {
            above: &kept.ring.above.values,
            here: &kept.ring.here.values,
            below,
            height_above: self.height.row(row - 1),
            height: self.height.row(row),
            height_below: self.height.row(row + 1),
        };
        let Some(living) = &self.living else {
            for &run in runs {
                diffuse(here, &old, pores, run);
            }
            return;
        };
        // How full rows are before this pass: those above and below are kept from row to row.
        let known = if kept.fill_row == row { row + 1 } else { row - 1 };
        for near in known..=row + 1 {
            let saturation = match near {
                near if near < row => old.above,
                near if near == row => old.here,
                _ => old.below,
            };
            for &run in self.damp.runs(near) {
                fill(kept.fill.row_mut(near), saturation, self.height.row(near), pores, run);
            }
        }
        kept.fill_row = row + 1;
        let fill = FillRows {
            above: kept.fill.row(row - 1),
            here: kept.fill.row(row),
            below: kept.fill.row(row + 1),
        };
        let mut is_stirred = false;
        for &run in runs {
            is_stirred |= diffuse_conducting(here, &old, &fill, pores, run);
        }
        if is_stirred && self.own.contains(&row) {
            living.facts.note_stirred(row);
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
