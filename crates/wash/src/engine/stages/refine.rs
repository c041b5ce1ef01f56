//! Rows for pigment that is finer than its water: what the fine cells see of the coarse ones.

use girtin_grid::{Aligned, Field, Layout};

use crate::engine::world::World;
use crate::interpolate::{Taps, blend, expand, put_where_open, put_where_wet};
use crate::mobility::mobility;
use crate::move_pigment::outflow_speeds;
use crate::region::Run;
use crate::update_velocities::FilmRows;

/// Water that is simulated on a coarser grid than its pigment.
#[derive(Debug)]
pub struct CoarseWater {
    /// From centres to centres.
    pub centers: Taps,
    /// From faces to faces along the flow; in fine cells a step.
    pub faces: Taps,
    /// Film, carried on beyond the wet cells.
    pub film: Field<f32>,
    /// Velocities, coarse cells a step.
    pub u: Field<f32>,
    pub v: Field<f32>,
}

impl CoarseWater {
    pub fn new(layout: Layout, factor: usize) -> Self {
        let field = || Field::<f32>::zeroed(layout);
        Self {
            centers: Taps::centers(factor),
            faces: Taps::faces(factor),
            film: field(),
            u: field(),
            v: field(),
        }
    }

    /// Writes what the faces or cells of a fine row see of a coarse field into the scratch rows, and returns it for the
    /// columns of the run and one more.
    fn row<'a>(
        &self,
        field: &Field<f32>,
        [down, across]: [&Taps; 2],
        row: usize,
        run: Run,
        [coarse, fine]: &'a mut [Aligned<f32>; 2],
    ) -> &'a [f32] {
        let factor = self.centers.factor();
        let (at, place) = ((row - Layout::TOP) / factor + Layout::TOP, (row - Layout::TOP) % factor);
        let (first, end) = ((run.first - Layout::LEFT) / factor, (run.end - Layout::LEFT) / factor + 1);
        // A coarse cell more at both ends.
        let columns = Layout::LEFT + first - 1..Layout::LEFT + end + 1;
        let rows = [at - 1, at, at + 1].map(|row| &field.row(row)[columns.clone()]);
        let coarse = &mut coarse[..columns.len()];
        blend(coarse, rows, down.of(place));
        expand(&mut fine[..(end - first) * factor], coarse, across);
        &fine[run.first - Layout::LEFT - first * factor..][..run.len() + 1]
    }
}

impl World<'_> {
    pub fn refine_film(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let (Some(water), Some(living)) = (self.water, &self.living) else { return };
        let mask = self.mask.row(row);
        let mut thinnest = i32::MAX;
        for &run in runs {
            let columns = run.first..run.end;
            let taps = [&water.centers, &water.centers];
            let film = water.row(&water.film, taps, row, run, &mut self.scratch.refined);
            let out = &mut self.pressure.row_mut(row)[columns.clone()];
            thinnest = thinnest.min(put_where_wet(out, film, &mask[columns]));
        }
        if self.own.contains(&row) {
            living.facts.note_thinnest(row, thinnest);
        }
    }

    pub fn refine_flow(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let (Some(water), Some(living)) = (self.water, &mut self.living) else { return };
        let factor = water.centers.factor() as f32;
        let film = FilmRows {
            film_above: self.pressure.row(row - 1),
            film: self.pressure.row(row),
            mask_above: self.mask.row(row - 1),
            mask: self.mask.row(row),
        };
        let (mobility_u, mobility_v) = (living.mobility_u.row_mut(row), living.mobility_v.row_mut(row));
        for &run in runs {
            mobility(mobility_u, mobility_v, &film, living.task.film, run);
            // The faces behind the last cell and below it touch dry paper: their 0 is written too.
            let faces = run.first..run.end + 1;
            let mut put = |field, taps, mobility: &[f32], out: &mut [f32]| {
                let speed = water.row(field, taps, row, run, &mut self.scratch.refined);
                put_where_open(&mut out[faces.clone()], speed, factor, &mobility[faces.clone()]);
            };
            put(&water.u, [&water.centers, &water.faces], mobility_u, self.u.row_mut(row));
            put(&water.v, [&water.faces, &water.centers], mobility_v, self.v.row_mut(row));
        }
    }

    pub fn note_outflow(&mut self, row: usize) {
        for &run in self.wet_runs(row) {
            self.found.outflow = self.found.outflow.max(outflow_speeds(&self.flow(row), run));
        }
    }
}
