//! The edge of pigment that is finer than its water: where its cells become wet and where they dry.

use girtin_grid::Layout;
use rayon::prelude::*;

use super::{LivingFields, Pool, STEPS_TO_SHRINK};
use crate::dry::{Vanishing, vanished};
use crate::engine::Task;
use crate::engine::stages::refine::CoarseWater;
use crate::settle::AroundRows;
use crate::state::{WashState, still_faces};

impl Pool {
    /// The water that its cells see.
    pub fn water(&mut self) -> &mut Option<CoarseWater> {
        &mut self.water
    }

    /// Whether work is worth sharing.
    pub fn is_banded(&self) -> bool {
        self.wet_cuts.len() > 2
    }

    /// Cells become wet.
    pub fn join(&mut self, cells: &[[usize; 2]]) {
        for &[row, x] in cells {
            self.state.wet_mask.row_mut(row)[x] = 1;
        }
        self.note_changed(cells.iter().map(|&[row, _]| row));
    }

    /// The cells whose film is gone.
    pub fn vanished(&self, vanishing: Vanishing) -> Vec<[usize; 2]> {
        let WashState { wet_mask, pressure, height, .. } = &self.state;
        let Some(LivingFields { facts, .. }) = &self.living else { return Vec::new() };
        let look = |row: usize| {
            let film = AroundRows {
                above: pressure.row(row - 1),
                here: pressure.row(row),
                below: pressure.row(row + 1),
                mask_above: wet_mask.row(row - 1),
                mask: wet_mask.row(row),
                mask_below: wet_mask.row(row + 1),
            };
            let mut gone = Vec::new();
            for &run in self.wet.runs(row) {
                vanished(&mut gone, &film, height.row(row), vanishing, run);
            }
            gone.into_iter().map(move |x| [row, x])
        };
        // No paper is higher than 1.
        let is_deep = |row: &usize| facts.thinnest(*row) >= vanishing.thinnest;
        let rows: Vec<usize> = self.wet.active().filter(|row| !is_deep(row)).collect();
        if self.is_banded() && rows.len() > 1 {
            rows.into_par_iter().flat_map_iter(look).collect()
        } else {
            rows.into_iter().flat_map(look).collect()
        }
    }

    /// All wet cells.
    pub fn all_wet(&self) -> Vec<[usize; 2]> {
        let mask = &self.state.wet_mask;
        let rows = self.wet.active();
        let runs = rows.flat_map(|row| self.wet.runs(row).iter().map(move |run| (row, run.first..run.end)));
        runs.flat_map(|(row, columns)| columns.map(move |x| [row, x]))
            .filter(|&[row, x]| mask.row(row)[x] != 0)
            .collect()
    }

    /// Cells leave the wet paper: their pigment settles.
    pub fn leave_dry(&mut self, cells: &[[usize; 2]]) {
        let state = &mut self.state;
        for &[row, x] in cells {
            let (x, y) = (x - Layout::LEFT, row - Layout::TOP);
            state.leave(x, y);
            if let Some(living) = &mut self.living {
                still_faces(&mut living.mobility_u, &mut living.mobility_v, x, y);
            }
        }
        self.note_changed(cells.iter().map(|&[row, _]| row));
    }

    fn note_changed(&mut self, rows: impl Iterator<Item = usize>) {
        let Some(living) = &mut self.living else { return };
        for row in rows {
            if living.changed_rows.last() != Some(&row) {
                living.facts.forget(row);
                living.changed_rows.push(row);
            }
        }
    }

    /// After a step: runs and bands follow what became wet or dry.
    pub fn follow_edge(&mut self, task: &Task) {
        let Some(living) = &mut self.living else { return };
        living.steps += 1;
        let shrinks = living.steps.is_multiple_of(STEPS_TO_SHRINK);
        let mut rows = std::mem::take(&mut living.changed_rows);
        if rows.is_empty() && !shrinks {
            return;
        }
        let last = self.state.layout().rows().end - 1;
        rows.sort_unstable();
        // The row below asks whether this one is wet throughout.
        let mut next = 0;
        for row in rows.into_iter().flat_map(|row| row..=(row + 1).min(last)) {
            if row >= next {
                self.wet.rescan(&self.state.wet_mask, row, |wet| wet != 0);
                next = row + 1;
            }
        }
        if shrinks {
            self.wet.shrink(&self.state.wet_mask, |wet| wet != 0);
        }
        self.cut(task);
    }
}
