//! Rows for the mixing of pigment that is finer than its water.

use crate::carry_packed::clear_closed;
use crate::engine::world::World;
use crate::mix_pigment::{Faces, Mixing, gather_down, mix_along, mixed_down};

impl World<'_> {
    pub fn mix_along(&mut self, row: usize, mixing: Mixing) {
        let runs = self.wet_runs(row);
        let Some(living) = &self.living else { return };
        let faces = Faces { speed: self.u.row(row), mobility: living.mobility_u.row(row) };
        self.scratch.mix(self.suspended.len());
        for (suspended, kept) in self.suspended.iter_mut().zip(&mut self.scratch.mix) {
            for &run in runs {
                mix_along(suspended.row_mut(row), faces, &mut kept.across, mixing, run);
            }
        }
    }

    pub fn mix_down(&mut self, row: usize, mixing: Mixing) {
        let (runs, runs_above) = (self.wet_runs(row), self.wet_runs(row - 1));
        let Some(living) = &self.living else { return };
        let faces = |row: usize| Faces { speed: self.v.row(row), mobility: living.mobility_v.row(row) };
        self.scratch.mix(self.suspended.len());
        for (suspended, kept) in self.suspended.iter_mut().zip(&mut self.scratch.mix) {
            for &run in runs {
                if kept.above_row != row {
                    let (above, here) = (suspended.row(row - 1), suspended.row(row));
                    mixed_down(&mut kept.above, above, here, faces(row), mixing, run);
                } else if runs != runs_above {
                    // Nothing comes from cells that are dry in the row above; there no flux was found.
                    let columns = run.first..run.end;
                    clear_closed(&mut kept.above[columns.clone()], &faces(row).mobility[columns]);
                }
                let (here, below) = (suspended.row(row), suspended.row(row + 1));
                mixed_down(&mut kept.below, here, below, faces(row + 1), mixing, run);
                gather_down(suspended.row_mut(row), &kept.above, &kept.below, run);
            }
            std::mem::swap(&mut kept.above, &mut kept.below);
            kept.above_row = row + 1;
        }
    }
}
