//! Rows for the other routines that only the living wash has.

use crate::engine::world::{Place, World};
use crate::evaporate::{cover, evaporate_pores, thinnest};
use crate::mobility::{keep, mobility};
use crate::region::Run;
use crate::settle::{AroundRows, fractions, settle};
use crate::simulate_capillary_flow::absorb_film;
use crate::update_velocities::FilmRows;

impl World<'_> {
    pub fn cover(&mut self, row: usize) {
        let runs = self.damp_runs(row);
        let (Some(living), Some(pores)) = (&mut self.living, &self.task.pores) else { return };
        let (exponent, facts) = (living.task.rim_exponent, living.facts);
        if facts.is_full(row) && facts.is_covered(row) {
            return;
        }
        let (saturation, height, mask) = (self.saturation.row(row), self.height.row(row), self.mask.row(row));
        for &run in runs {
            let changed = cover(living.cover.row_mut(row), saturation, height, mask, pores, exponent, run);
            if changed {
                Place::note(&mut self.found.uncovered, row, run);
            }
        }
        if facts.is_full(row) {
            facts.note_covered(row);
        }
    }

    pub fn mobility(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let Some(living) = &mut self.living else { return };
        let facts = living.facts;
        let film = living.task.film;
        let is_free = [row - 1, row].iter().all(|&row| {
            // Facts of a neighbour's rows may be changing; its rows themselves this band has for itself.
            let of_run = |&run: &Run| thinnest(self.pressure.row(row), self.mask.row(row), run);
            film.is_free(match self.own.contains(&row) {
                true => facts.thinnest(row),
                false => f32::from_bits(self.wet.runs(row).iter().map(of_run).min().unwrap_or(-1) as u32),
            })
        });
        if is_free && facts.is_free(row) {
            return;
        }
        let rows = FilmRows {
            film_above: self.pressure.row(row - 1),
            film: self.pressure.row(row),
            mask_above: self.mask.row(row - 1),
            mask: self.mask.row(row),
        };
        for &run in runs {
            mobility(living.mobility_u.row_mut(row), living.mobility_v.row_mut(row), &rows, film, run);
        }
        facts.note_free(row, is_free);
    }

    pub fn keep(&mut self, row: usize, dt: f32) {
        let runs = self.wet_runs(row);
        let Some(living) = &mut self.living else { return };
        let Some([keep_u, keep_v]) = &mut living.keep else { return };
        for &run in runs {
            keep(keep_u.row_mut(row), living.mobility_u.row(row), dt, run);
            keep(keep_v.row_mut(row), living.mobility_v.row(row), dt, run);
        }
    }

    pub fn settle(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let Some(living) = &self.living else { return };
        if living.task.film.holds_pigment(living.facts.thinnest(row)) {
            return;
        }
        let film = AroundRows {
            above: self.pressure.row(row - 1),
            here: self.pressure.row(row),
            below: self.pressure.row(row + 1),
            mask_above: self.mask.row(row - 1),
            mask: self.mask.row(row),
            mask_below: self.mask.row(row + 1),
        };
        let fraction = &mut self.scratch.fraction;
        for &run in runs {
            let (flowing, rate) = (living.task.film.flowing, living.task.settling);
            if fractions(fraction, &film, flowing, rate, run) {
                for (suspended, deposited) in self.suspended.iter_mut().zip(&mut self.deposited) {
                    settle(suspended.row_mut(row), deposited.row_mut(row), fraction, run);
                }
            }
        }
    }

    pub fn evaporate_pores(&mut self, row: usize) {
        let runs = self.damp_runs(row);
        let Some(living) = self.living.as_ref().filter(|living| !living.facts.is_full(row)) else { return };
        let mut evaporated = 0;
        for &run in runs {
            let saturation = self.saturation.row_mut(row);
            evaporated += evaporate_pores(saturation, self.mask.row(row), living.task.pore_evaporation, run);
        }
        if self.own.contains(&row) {
            self.found.pores_evaporated += evaporated;
        }
    }

    pub fn absorb_film(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let (Some(living), Some(pores)) = (&self.living, &self.task.pores) else { return };
        if living.facts.is_quiet(row) {
            return;
        }
        let (height, mask) = (self.height.row(row), self.mask.row(row));
        let (mut thinnest, mut has_room) = (i32::MAX, false);
        for &run in runs {
            let (saturation, film) = (self.saturation.row_mut(row), self.pressure.row_mut(row));
            let (of_run, roomy) =
                absorb_film(saturation, film, height, mask, pores, living.task.pore_depth, run);
            thinnest = thinnest.min(of_run);
            has_room |= roomy;
        }
        if self.own.contains(&row) {
            living.facts.note_thinnest(row, thinnest);
            if has_room {
                living.facts.note_stirred(row);
            }
        }
    }
}
