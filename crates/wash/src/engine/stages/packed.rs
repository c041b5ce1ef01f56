//! Rows for the packed transport of pigment.

use girtin_grid::Layout;

use crate::carry_packed::{FaceRows, Spread, clear_closed, flux, flux_upstream, gather, room};
use crate::engine::rows::Rows;
use crate::engine::scratch::{CarryScratch, Recent};
use crate::engine::world::{LivingRows, World};
use crate::region::{Region, Run};

impl World<'_> {
    pub fn carry_packed(&mut self, row: usize, dt: f32) {
        let wet = self.wet;
        let Some(living) = &self.living else { return };
        self.scratch.carry(self.suspended.len());
        let layout = self.height.layout();
        let scratch = &mut *self.scratch;
        // Room in the rows above, here and below, from the amounts before this sub-step.
        let known = if scratch.room_row == row { row + 1 } else { row - 1 };
        for row in known..=row + 1 {
            let amounts: Vec<&[f32]> =
                self.suspended.iter().chain(&self.deposited).map(|field| field.row(row)).collect();
            for &run in wet.runs(row) {
                room(scratch.room.row_mut(row), &amounts, living.task.packing_limit, run);
            }
        }
        scratch.room_row = row + 1;
        let spread = Spread { dt, diffusion: living.task.diffusion * dt, dispersion: living.task.dispersion };
        for (suspended, kept) in self.suspended.iter_mut().zip(&mut scratch.carry) {
            let faces = Faces { layout, wet, living, u: &self.u, v: &self.v, room: &scratch.room, spread };
            faces.carry(row, suspended, kept);
        }
    }
}

/// Everything that decides on fluxes but the pigment itself.
#[derive(Clone, Copy)]
struct Faces<'a> {
    layout: Layout,
    wet: &'a Region,
    living: &'a LivingRows<'a>,
    u: &'a Rows<'a, f32>,
    v: &'a Rows<'a, f32>,
    room: &'a Recent,
    spread: Spread,
}

impl Faces<'_> {
    fn carry(&self, row: usize, suspended: &mut Rows<'_, f32>, kept: &mut CarryScratch) {
        let runs = self.wet.runs(row);
        kept.ring.take(self.wet, row, suspended);
        // Beyond the canvas' edge lies what lies at it: no slope there.
        let columns = self.layout.columns();
        let here = &mut kept.ring.here.values;
        here[columns.start - 1] = here[columns.start];
        here[columns.end] = here[columns.end - 1];
        let (above, here) = (&kept.ring.above.values[..], &kept.ring.here.values[..]);
        if kept.above_row != row {
            let far = suspended.row(self.inside(row - 1, row.saturating_sub(2)));
            let below = suspended.row(row + 1);
            for &run in runs {
                self.down(row, [far, above, here, below], &mut kept.above, run);
            }
        } else if runs != self.wet.runs(row - 1) {
            // Nothing flows from cells that are dry in the row above; there no flux was found.
            for &run in runs {
                let columns = run.first..run.end;
                let mobility = &self.living.mobility_v.row(row)[columns.clone()];
                clear_closed(&mut kept.above[columns], mobility);
            }
        }
        let below = suspended.row(row + 1);
        let far_below = suspended.row(self.inside(row + 1, row + 2));
        let far_above = if self.layout.rows().contains(&(row - 1)) { above } else { here };
        for &run in runs {
            self.down(row + 1, [far_above, here, below, far_below], &mut kept.below, run);
            self.across(row, here, &mut kept.across, run);
        }
        let amounts = suspended.row_mut(row);
        for run in runs {
            let columns = run.first..run.end;
            gather(
                &mut amounts[columns.clone()],
                &kept.across[run.first..=run.end],
                &kept.above[columns.clone()],
                &kept.below[columns],
            );
        }
        std::mem::swap(&mut kept.above, &mut kept.below);
        kept.above_row = row + 1;
    }

    /// The row two away from a face if it is on the canvas, else the one beside the face.
    fn inside(&self, beside: usize, far: usize) -> usize {
        if self.layout.rows().contains(&far) { far } else { beside }
    }

    /// Fluxes through the faces above row `row`; cells are those of rows −2, −1, 0 and +1 from it.
    fn down(&self, row: usize, cells: [&[f32]; 4], out: &mut [f32], run: Run) {
        let columns = run.first..run.end;
        let faces = FaceRows {
            cells: cells.map(|cells| &cells[columns.clone()]),
            room: [row - 1, row].map(|row| &self.room.row(row)[columns.clone()]),
            speed: &self.v.row(row)[columns.clone()],
            mobility: &self.living.mobility_v.row(row)[columns.clone()],
        };
        self.flux(&mut out[columns], &faces);
    }

    /// Fluxes through the faces before each cell of a run and behind its last.
    fn across(&self, row: usize, cells: &[f32], out: &mut [f32], run: Run) {
        let faces = run.first..run.end + 1;
        let room = self.room.row(row);
        let rows = FaceRows {
            cells: [run.first - 2, run.first - 1, run.first, run.first + 1].map(|first| &cells[first..]),
            room: [&room[run.first - 1..], &room[run.first..]],
            speed: &self.u.row(row)[faces.clone()],
            mobility: &self.living.mobility_u.row(row)[faces.clone()],
        };
        self.flux(&mut out[faces], &rows);
    }

    fn flux(&self, out: &mut [f32], faces: &FaceRows<'_>) {
        if self.living.task.is_mixed_apart {
            flux_upstream(out, faces, self.spread);
        } else {
            flux(out, faces, self.spread);
        }
    }
}
