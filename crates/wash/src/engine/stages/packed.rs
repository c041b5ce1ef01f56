//! Rows for the packed transport of pigment.

use girtin_grid::Layout;

use crate::carry_packed::{
    FaceRows, Spread, clear_closed, flux, flux_upstream, gather, gather_upstream, prepare, room, slopes,
};
use crate::engine::rows::Rows;
use crate::engine::scratch::{CarryScratch, FluxScratch};
use crate::engine::world::World;
use crate::region::{Region, Run};

impl World<'_> {
    pub fn carry_packed(&mut self, row: usize, dt: f32) {
        let wet = self.wet;
        let Some(living) = &self.living else { return };
        let runs = wet.runs(row);
        self.scratch.carry(self.suspended.len());
        let scratch = &mut *self.scratch;
        // Room in the rows above, here and below, from the amounts before this sub-step.
        let is_first = scratch.room_row != row;
        let known = if is_first { row - 1 } else { row + 1 };
        for row in known..=row + 1 {
            let amounts: Vec<&[f32]> =
                self.suspended.iter().chain(&self.deposited).map(|field| field.row(row)).collect();
            for &run in wet.runs(row) {
                room(scratch.room.row_mut(row), &amounts, living.task.packing_limit, run);
            }
        }
        scratch.room_row = row + 1;
        let is_upstream = living.task.is_mixed_apart;
        let spread = match is_upstream {
            true => Spread { dt, diffusion: 0.0, dispersion: 0.0 },
            false => Spread { dt, diffusion: living.task.diffusion * dt, dispersion: living.task.dispersion },
        };
        // Facts of a neighbour's rows may be changing.
        let is_free = |row: usize| self.own.contains(&row) && living.facts.is_free(row);
        let (free_row, free_below) = (is_free(row), is_free(row + 1));
        let [of_across, of_above, of_below] = &mut scratch.flux;
        for &run in runs {
            let (faces, room) = (run.first..run.end + 1, scratch.room.row(row));
            let is_free = free_row && run.all_wet;
            let across = FaceRows {
                room: [&room[run.first - 1..], &room[run.first..]],
                speed: &self.u.row(row)[faces.clone()],
                mobility: (!is_free).then_some(&living.mobility_u.row(row)[faces.clone()]),
            };
            prepare(of_across.of_mut(faces), &across, spread);
            if is_free {
                // Nothing is exchanged with the dry cells at its ends.
                of_across.close([run.first, run.end]);
            }
            let columns = run.first..run.end;
            let down = |row: usize, is_free: bool| FaceRows {
                room: [row - 1, row].map(|row| &scratch.room.row(row)[columns.clone()]),
                speed: &self.v.row(row)[columns.clone()],
                mobility: (!is_free).then_some(&living.mobility_v.row(row)[columns.clone()]),
            };
            let is_free = free_below && wet.runs(row + 1).iter().any(|below| below.covers(run));
            prepare(of_below.of_mut(columns.clone()), &down(row + 1, is_free), spread);
            if is_first {
                prepare(of_above.of_mut(columns.clone()), &down(row, false), spread);
            }
        }
        let carrying = Carrying {
            layout: self.height.layout(),
            wet,
            mobility_above: living.mobility_v.row(row),
            flux: &scratch.flux,
            is_first,
            is_upstream,
        };
        for (suspended, kept) in self.suspended.iter_mut().zip(&mut scratch.carry) {
            carrying.carry(row, suspended, kept);
        }
    }
}

/// Everything that decides on fluxes but the pigment itself.
#[derive(Clone, Copy)]
struct Carrying<'a> {
    layout: Layout,
    wet: &'a Region,
    /// Of the faces above the row.
    mobility_above: &'a [f32],
    /// Of the faces between its cells, above and below it.
    flux: &'a [FluxScratch; 3],
    /// Whether the pass begins at this row.
    is_first: bool,
    is_upstream: bool,
}

impl Carrying<'_> {
    fn carry(&self, row: usize, suspended: &mut Rows<'_, f32>, kept: &mut CarryScratch) {
        let runs = self.wet.runs(row);
        let [across, above, below] = self.flux;
        if self.is_first {
            self.begin(row, suspended, above, kept);
        } else if runs != self.wet.runs(row - 1) {
            // Nothing flows from cells that are dry in the row above; there no flux was found.
            for run in runs {
                let columns = run.first..run.end;
                clear_closed(&mut kept.above[columns.clone()], &self.mobility_above[columns]);
            }
        }
        let runs_below = self.wet.runs(row + 1);
        if !self.is_upstream && runs != runs_below {
            let cells = self.around(row + 1).map(|row| suspended.row(row));
            find_slopes(&mut kept.slopes_below, cells, runs_below);
        }
        let cells = suspended.row(row);
        for &run in runs {
            self.across(cells, across, kept, run);
        }
        let is_inside = self.layout.rows().contains(&(row + 2));
        let [amounts, next, far] = suspended.row_mut_and_two_below(row);
        // Beyond the canvas' edge lies what lies at it: no slope there.
        let far = if is_inside { far } else { &*next };
        for run in runs {
            let columns = run.first..run.end;
            let (amounts, down) = (&mut amounts[columns.clone()], &mut kept.above[columns.clone()]);
            let (across, faces) = (&kept.across[run.first..=run.end], below.of(columns.clone()));
            if self.is_upstream {
                gather_upstream(amounts, down, across, faces.way, &next[columns]);
            } else {
                let below = [&next[columns.clone()], &far[columns.clone()]];
                gather(amounts, down, &mut kept.slopes[columns], across, &faces, below);
            }
        }
        if runs != runs_below {
            std::mem::swap(&mut kept.slopes, &mut kept.slopes_below);
        }
    }

    /// What comes from above, and the slopes within the cells of the first row.
    fn begin(&self, row: usize, suspended: &Rows<'_, f32>, faces: &FluxScratch, kept: &mut CarryScratch) {
        let runs = self.wet.runs(row);
        if !self.is_upstream {
            let slopes = [(&mut kept.slopes_below, row - 1), (&mut kept.slopes, row)];
            for (slopes, row) in slopes {
                find_slopes(slopes, self.around(row).map(|row| suspended.row(row)), runs);
            }
        }
        for run in runs {
            let columns = run.first..run.end;
            let (out, rows) = (&mut kept.above[columns.clone()], faces.of(columns.clone()));
            let cells = [row - 1, row].map(|row| &suspended.row(row)[columns.clone()]);
            if self.is_upstream {
                flux_upstream(out, rows.way, cells);
            } else {
                let slopes = [&kept.slopes_below, &kept.slopes].map(|slopes| &slopes[columns.clone()]);
                flux(out, &rows, cells, slopes);
            }
        }
    }

    /// A row between those beside it, or itself where those are beyond the canvas' edge: no slope there.
    fn around(&self, row: usize) -> [usize; 3] {
        [self.inside(row, row.saturating_sub(1)), row, self.inside(row, row + 1)]
    }

    /// Fluxes through the faces before each cell of a run and behind its last.
    fn across(&self, cells: &[f32], between: &FluxScratch, kept: &mut CarryScratch, run: Run) {
        let faces = run.first..run.end + 1;
        let (out, rows) = (&mut kept.across[faces.clone()], between.of(faces));
        let beside = [&cells[run.first - 1..], &cells[run.first..]];
        if self.is_upstream {
            return flux_upstream(out, rows.way, beside);
        }
        let kept_slopes = &mut kept.slopes_across;
        let beside_each = [run.first - 2, run.first - 1, run.first].map(|first| &cells[first..]);
        slopes(&mut kept_slopes[run.first - 1..run.end + 1], beside_each);
        // Nor at the ends of the row.
        let columns = self.layout.columns();
        kept_slopes[columns.start] = 0.0;
        kept_slopes[columns.end - 1] = 0.0;
        flux(out, &rows, beside, [&kept_slopes[run.first - 1..], &kept_slopes[run.first..]]);
    }

    /// The row beyond another one if it is on the canvas, else that one.
    fn inside(&self, beside: usize, far: usize) -> usize {
        if self.layout.rows().contains(&far) { far } else { beside }
    }
}

/// Slopes within the cells of the middle one of three rows.
fn find_slopes(out: &mut [f32], cells: [&[f32]; 3], runs: &[Run]) {
    for run in runs {
        let columns = run.first..run.end;
        slopes(&mut out[columns.clone()], cells.map(|cells| &cells[columns.clone()]));
    }
}
