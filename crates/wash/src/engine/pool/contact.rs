//! The edge of the living wash: where paper becomes wet, where it dries, and what that changes.

use std::ops::Range;

use girtin_grid::Layout;
use rayon::prelude::*;

use super::{DAMP, EVER_DAMP, LivingFields, Pool, STEPS_TO_SHRINK};
use crate::creep::{Crept, Sheet, edge_rows};
use crate::engine::stage::Stage;
use crate::engine::{LivingTask, Task};
use crate::evaporate::QUANTA;
use crate::flow_outward::Edge;
use crate::region::{Run, first_where};
use crate::simulate_capillary_flow::Pores;
use crate::state::{WashState, still_faces};

impl Pool {
    /// Whether there is any water in film or pores.
    pub fn is_damp(&self) -> bool {
        !self.damp.active().is_empty()
    }

    /// Whether it holds a living wash.
    pub fn is_living(&self) -> bool {
        self.living.is_some()
    }

    /// Water that comes closer than this to the first or last row or column calls for a new pool.
    pub fn keep_within(&mut self, rows: [usize; 2], columns: [usize; 2]) {
        let layout = self.state.layout();
        let inner = |range: std::ops::Range<usize>, [first, last]: [usize; 2]| {
            range.start + first..range.end.saturating_sub(last)
        };
        if let Some(living) = &mut self.living {
            living.within = (inner(layout.rows(), rows), inner(layout.columns(), columns));
        }
    }

    /// Whether water has come close to the pool's edge.
    pub fn needs_room(&self) -> bool {
        self.living.as_ref().is_some_and(|living| living.needs_room)
    }

    /// The cells that have been damp since the pool was made: row, first column and end, on the pool's own canvas.
    pub fn ever_damp(&self) -> Vec<[usize; 3]> {
        let Some(LivingFields { damp, .. }) = &self.living else { return Vec::new() };
        let mut runs = Vec::new();
        for y in 0..damp.layout().height() {
            let cells = damp.cells(y);
            let mut x = 0;
            while let Some(first) = (x..cells.len()).find(|&x| cells[x] != 0) {
                let end = (first..cells.len()).find(|&x| cells[x] == 0).unwrap_or(cells.len());
                runs.push([y, first, end]);
                x = end;
            }
        }
        runs
    }

    /// Cells that became wet since this was last asked: row and column of the pool's own canvas.
    pub fn take_joined(&mut self) -> Vec<(usize, usize)> {
        std::mem::take(&mut self.joined)
    }

    /// Notes in which rows all damp cells are under film.
    pub fn note_full(&self, rows: Range<usize>) {
        let Some(living) = &self.living else { return };
        for row in rows {
            let mask = self.state.wet_mask.row(row);
            let is_full = |run: &Run| first_where(mask, run.first..run.end, |wet| wet == 0) == run.end;
            living.facts.note_full(row, self.damp.runs(row).iter().all(is_full));
        }
    }

    /// Begins a step: notes in which rows no pore water can change.
    pub fn settle_down(&mut self, passes: usize) {
        if let Some(living) = &mut self.living {
            living.facts.settle_down(self.damp.active(), passes);
        }
    }

    /// Finds anew where the wet paper ends, if that has changed.
    pub fn renew_edges(&mut self, task: &Task) {
        if self.living.as_ref().is_some_and(|living| living.facts.are_covered(self.damp.active())) {
            return;
        }
        let uncovered = self.pass(task, &[Stage::Cover]).uncovered;
        let (Some(place), Some(living)) = (uncovered, &self.living) else { return };
        let edge = Edge { mask: &self.state.wet_mask, cover: Some(&living.cover) };
        self.outflow.renew(edge, place.rows, place.columns, self.damp_cuts.len() - 1);
    }

    /// Lets film creep over the edge.
    pub fn creep(&mut self, task: &Task, living_task: &LivingTask) {
        let WashState { wet_mask, pressure, saturation, height, .. } = &mut self.state;
        let sheet = Sheet { mask: wet_mask, film: pressure, saturation, height };
        let contact = &living_task.contact;
        let rows = edge_rows(&self.wet, wet_mask.layout());
        let look = |row: usize| {
            let mut crept = Vec::new();
            sheet.creep_row(contact, &self.wet, row, &mut crept);
            crept
        };
        let crept: Vec<Crept> = if self.wet_cuts.len() > 2 {
            rows.into_par_iter().flat_map_iter(look).collect()
        } else {
            rows.flat_map(look).collect()
        };
        let Some(living) = &mut self.living else { return };
        let mut joined = Vec::new();
        for Crept { row, x, film, joins } in crept {
            pressure.row_mut(row)[x] = film;
            living.facts.forget(row);
            if joins {
                wet_mask.row_mut(row)[x] = 1;
                living.damp.row_mut(row)[x] = DAMP | EVER_DAMP;
                // Where full pores counted as covered already, what dries at the edge is to be found anew all the same.
                living.cover.row_mut(row)[x] = 0.0;
                self.joined.push((row - Layout::TOP, x - Layout::LEFT));
                living.needs_room |= !(living.within.0.contains(&row) && living.within.1.contains(&x));
                if joined.last() != Some(&row) {
                    joined.push(row);
                }
            }
        }
        for &row in &joined {
            self.look_at_row(task, row);
            self.look_at_damp_row(row);
        }
        self.forget_rows(&joined);
        if let Some(living) = &mut self.living {
            living.changed_rows.extend(joined);
        }
    }

    /// Finds anew the damp cells of a row.
    fn look_at_damp_row(&mut self, row: usize) {
        if self.is_reference {
            return;
        }
        let Some(living) = &self.living else { return };
        for row in row..=(row + 1).min(self.state.layout().rows().end - 1) {
            self.damp.rescan(&living.damp, row, |damp| damp & DAMP != 0);
        }
    }

    /// Forgets what was known of rows whose cells became wet or dry.
    fn forget_rows(&self, rows: &[usize]) {
        for &row in rows {
            if let Some(living) = &self.living {
                living.facts.forget(row);
            }
            self.note_full(row..row + 1);
        }
    }

    /// Cells whose film is gone leave the wet paper; returns the water that evaporated with it, quanta.
    pub fn dry(&mut self, task: &Task, living_task: &LivingTask) -> i64 {
        let Some(pores) = &task.pores else { return 0 };
        let gone = self.vanished(living_task.vanishing);
        let mut lost = 0;
        for &[row, x] in &gone {
            lost += self.leave(row, x, pores, living_task.pore_depth);
        }
        let mut gone: Vec<usize> = gone.into_iter().map(|[row, _]| row).collect();
        gone.dedup();
        if let Some(living) = &mut self.living {
            living.changed_rows.extend(&gone);
        }
        for &row in &gone {
            self.look_at_row(task, row);
        }
        self.forget_rows(&gone);
        lost
    }

    /// A cell leaves the wet paper; returns the water that its pores cannot take, quanta.
    fn leave(&mut self, row: usize, x: usize, pores: &Pores, depth: f32) -> i64 {
        let (x, y) = (x - Layout::LEFT, row - Layout::TOP);
        let state = &mut self.state;
        let film = state.pressure.cells(y)[x];
        let saturation = &mut state.saturation.cells_mut(y)[x];
        let room = depth * (pores.capacity(state.height.cells(y)[x]) - *saturation).max(0.0);
        let soaked = if film < room { film.max(0.0) } else { room };
        let filled = *saturation + soaked / depth;
        let lost = f64::from(film) - f64::from(depth) * (f64::from(filled) - f64::from(*saturation));
        *saturation = filled;
        state.leave(x, y);
        if let Some(living) = &mut self.living {
            // Nothing remembers that its faces moved.
            still_faces(&mut living.mobility_u, &mut living.mobility_v, x, y);
        }
        (lost * QUANTA) as i64
    }

    /// After a step: bands follow what became wet or dry, and paper that has dried wholly is let go.
    pub fn look_again(&mut self, task: &Task) {
        let Some(living) = &mut self.living else { return };
        living.steps += 1;
        let shrinks = living.steps.is_multiple_of(STEPS_TO_SHRINK) && !self.is_reference;
        let changed = !living.changed_rows.is_empty();
        living.changed_rows.clear();
        if shrinks {
            for row in self.damp.active() {
                let damp = living.damp.row_mut(row);
                let (mask, saturation) = (self.state.wet_mask.row(row), self.state.saturation.row(row));
                for run in self.damp.runs(row) {
                    for x in run.first..run.end {
                        let is_damp = mask[x] != 0 || saturation[x] != 0.0;
                        damp[x] = damp[x] & EVER_DAMP | if is_damp { DAMP | EVER_DAMP } else { 0 };
                    }
                }
            }
            self.damp.shrink(&living.damp, |damp| damp & DAMP != 0);
            self.wet.shrink(&self.state.wet_mask, |wet| wet != 0);
            self.note_full(self.damp.active());
        }
        if changed || shrinks {
            self.cut(task);
        }
    }
}
