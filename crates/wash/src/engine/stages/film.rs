//! Rows for the relaxation of the living wash and for the move of its film.

use super::water::flow_rows;
use crate::engine::world::World;
use crate::evaporate::{evaporate, thinnest};
use crate::move_film::{move_film, share, widen_share};
use crate::region::Run;
use crate::relax_implicitly::{Iteration, SolveRows, begin, iterate, project};

impl World<'_> {
    pub fn begin_solve(&mut self, row: usize, start: f32) {
        let runs = self.wet_runs(row);
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let solve = &mut self.scratch.solve;
        let Some(divergence) = &mut solve.divergence else { return };
        for &run in runs {
            begin(divergence.row_mut(row), solve.q[0].row_mut(row), &flow, start, run);
        }
    }

    pub fn iterate(&mut self, row: usize, number: usize, iteration: Iteration, stiffness: f32) {
        let runs = self.wet_runs(row);
        let Some(living) = &self.living else { return };
        let solve = &mut self.scratch.solve;
        let Some(divergence) = &solve.divergence else { return };
        let (done, to_do) = solve.q.split_at_mut(number);
        let (q, next) = (&done[number - 1], to_do[0].row_mut(row));
        // The first iteration carries nothing on, so what was before does not matter.
        let before = &done[number.saturating_sub(2)];
        let rows = SolveRows {
            above: q.row(row - 1),
            here: q.row(row),
            below: q.row(row + 1),
            before: before.row(row),
            divergence: divergence.row(row),
            mobility_u: living.mobility_u.row(row),
            mobility_v: living.mobility_v.row(row),
            mobility_v_below: living.mobility_v.row(row + 1),
        };
        let free_rows = living.facts.is_free(row) && living.facts.is_free(row + 1);
        for &run in runs {
            // All cells of the run are wet, as are those above and below.
            let is_free =
                free_rows && run.all_wet && self.wet.runs(row + 1).iter().any(|below| below.covers(run));
            iterate(next, &rows, iteration, stiffness, run, is_free);
        }
    }

    pub fn project(&mut self, row: usize, iterations: usize, stiffness: f32) {
        let runs = self.wet_runs(row);
        let Some(living) = &self.living else { return };
        let q = &self.scratch.solve.q[iterations];
        let q = [q.row(row - 1), q.row(row)];
        let mobility = [living.mobility_u.row(row), living.mobility_v.row(row)];
        let is_free = living.facts.is_free(row);
        for &run in runs {
            let (u, v) = (self.u.row_mut(row), self.v.row_mut(row));
            project(u, v, q, mobility, stiffness, run, is_free && run.all_wet);
        }
    }

    pub fn share(&mut self, row: usize, compressibility: f32) {
        let runs = self.wet_runs(row);
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let kept = &mut self.scratch.shares[0];
        let mut is_short = false;
        for &run in runs {
            let (fastest, short) =
                share(kept.share.row_mut(row), self.pressure.row(row), &flow, compressibility, run);
            self.found.outflow = self.found.outflow.max(fastest);
            is_short |= short;
        }
        kept.note_short(row, is_short);
    }

    pub fn widen_share(&mut self, row: usize, number: usize, compressibility: f32) {
        let runs = self.wet_runs(row);
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let (before, now) = self.scratch.shares.split_at_mut(number);
        let (before, now) = (&before[number - 1], &mut now[0]);
        // Where no cell of the row fell short none does when more flows in.
        let is_short = before.is_short(row);
        now.note_short(row, is_short);
        if !is_short {
            return;
        }
        let shares = before.around(row, &self.scratch.ones);
        for &run in runs {
            widen_share(now.share.row_mut(row), &shares, self.pressure.row(row), &flow, compressibility, run);
        }
    }

    pub fn move_film(&mut self, row: usize, widenings: usize, compressibility: f32) {
        let runs = self.wet_runs(row);
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let kept = &self.scratch.shares[widenings];
        let is_limited = (row - 1..=row + 1).any(|row| kept.is_short(row));
        let shares = kept.around(row, &self.scratch.ones);
        for &run in runs {
            let shares = is_limited.then_some(&shares);
            move_film(self.pressure.row_mut(row), shares, &flow, compressibility, run);
        }
    }

    pub fn evaporate(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let Some(living) = &self.living else { return };
        let everywhere = living.task.evaporation;
        let spans = self.outflow.spans(row);
        let edge = if spans.is_empty() { &self.scratch.zeros } else { self.outflow.row(row) };
        let (mask, film) = (self.mask.row(row), self.pressure.row_mut(row));
        let (mut evaporated, mut thin) = (0, i32::MAX);
        if everywhere == 0.0 {
            for span in spans {
                let run = Run { first: span.start, end: span.end, all_wet: false };
                evaporated += evaporate(film, edge, mask, 0.0, run).0;
            }
            runs.iter().for_each(|&run| thin = thin.min(thinnest(film, mask, run)));
        } else {
            for &run in runs {
                let (dried, left) = evaporate(film, edge, mask, everywhere, run);
                evaporated += dried;
                thin = thin.min(left);
            }
        }
        self.found.thinnest = self.found.thinnest.min(thin);
        if self.own.contains(&row) {
            self.found.evaporated += evaporated;
            living.facts.note_thinnest(row, thin);
        }
    }
}
