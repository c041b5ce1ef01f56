//! Rows for the routines that move water.

use girtin_grid::Field;

use crate::engine::rows::Rows;
use crate::engine::world::World;
use crate::flow_outward::draw_off;
use crate::move_pigment::outflow_speeds;
use crate::relax_divergence::{CorrectionRows, FlowRows, apply, divergence};
use crate::update_velocities::{
    FilmRows, Hold, SlopeRows, VelocityRows, add_slope, add_slope_alone, add_slope_tilted, advance,
    advance_held, corner_products, drive, fastest,
};

/// The faces around the cells of a row. Takes the fields and not the world, whose other fields may be changed meanwhile.
pub fn flow_rows<'a>(
    u: &'a Rows<'_, f32>,
    v: &'a Rows<'_, f32>,
    mask: &'a Rows<'_, u8>,
    row: usize,
) -> FlowRows<'a> {
    FlowRows { u: u.row(row), v: v.row(row), v_below: v.row(row + 1), mask: mask.row(row) }
}

fn slope_rows<'a>(height: &'a Field<f32>, mask: &'a Rows<'_, u8>, row: usize) -> SlopeRows<'a> {
    SlopeRows {
        height_above: height.row(row - 1),
        height: height.row(row),
        mask_above: mask.row(row - 1),
        mask: mask.row(row),
    }
}

impl World<'_> {
    pub fn flow(&self, row: usize) -> FlowRows<'_> {
        flow_rows(&self.u, &self.v, &self.mask, row)
    }

    pub fn add_slope(&mut self, row: usize) {
        let paper = slope_rows(self.slope_height, &self.mask, row);
        let film = FilmRows {
            film_above: self.pressure.row(row - 1),
            film: self.pressure.row(row),
            mask_above: self.mask.row(row - 1),
            mask: self.mask.row(row),
        };
        for &run in self.wet_runs(row) {
            let scale = self.task.slope_scale;
            let (u, v) = (self.u.row_mut(row), self.v.row_mut(row));
            let speed = match &self.task.living {
                None => add_slope(u, v, &paper, scale, run),
                Some(living) => {
                    add_slope_tilted(u, v, &paper, scale, living.pull, run);
                    drive(u, v, &film, living.stiffness, run)
                }
            };
            self.found.speed = self.found.speed.max(speed);
        }
    }

    pub fn add_slope_alone(&mut self, row: usize) {
        let paper = slope_rows(self.slope_height, &self.mask, row);
        for &run in self.wet_runs(row) {
            add_slope_alone(self.u.row_mut(row), self.v.row_mut(row), &paper, self.task.slope_scale, run);
        }
    }

    pub fn advance(&mut self, row: usize, dt: f32, is_noted: bool) {
        let runs = self.wet_runs(row);
        let kept = &mut self.scratch.advance;
        kept.u.take(self.wet, row, &self.u);
        kept.v.take(self.wet, row, &self.v);
        // The corners below the last row are those above this one, if both have the same runs.
        let corners_known = kept.corner_row == row && runs == self.wet.runs(row - 1);
        let (u_here, u_below) = self.u.row_mut_and_below(row);
        let (v_here, v_below) = self.v.row_mut_and_below(row);
        for &run in runs {
            let (u_above, u_old, v_old) = (&kept.u.above.values, &kept.u.here.values, &kept.v.here.values);
            if !corners_known {
                corner_products(&mut kept.corner, u_above, u_old, v_old, run);
            }
            corner_products(&mut kept.corner_below, u_old, u_below, v_below, run);
            let old = VelocityRows {
                u_above,
                u: u_old,
                u_below,
                v_above: &kept.v.above.values,
                v: v_old,
                v_below,
                corner: &kept.corner,
                corner_below: &kept.corner_below,
                pressure_above: self.pressure.row(row - 1),
                pressure: self.pressure.row(row),
                mask_above: self.mask.row(row - 1),
                mask: self.mask.row(row),
            };
            let momentum = self.task.momentum(dt);
            match &self.living {
                None => advance(u_here, v_here, &old, momentum, run),
                Some(living) => {
                    let [keep_u, keep_v] = match &living.keep {
                        Some([keep_u, keep_v]) if dt < 1.0 => [keep_u, keep_v],
                        _ => [&living.mobility_u, &living.mobility_v],
                    };
                    let hold = Hold {
                        keep_u: keep_u.row(row),
                        keep_v: keep_v.row(row),
                        stiffness: living.task.stiffness,
                        speed_limit: living.task.speed_limit,
                        is_free: dt == 1.0 && living.facts.is_free(row) && run.all_wet,
                    };
                    advance_held(u_here, v_here, &old, momentum, &hold, run);
                    if is_noted {
                        self.found.advanced = self.found.advanced.max(fastest(u_here, v_here, run));
                    }
                }
            }
        }
        std::mem::swap(&mut kept.corner, &mut kept.corner_below);
        kept.corner_row = row + 1;
    }

    pub fn find_correction(&mut self, row: usize) {
        let mut largest = self.found.next_correction;
        for &run in self.wet_runs(row) {
            let delta = &mut self.scratch.sweeps[0].delta;
            let flow = flow_rows(&self.u, &self.v, &self.mask, row);
            largest = largest.max(divergence(delta, &flow, self.task.relax_rate, run));
        }
        self.found.next_correction = largest;
    }

    pub fn sweep(&mut self, row: usize, slot: usize) {
        let (wet, rate) = (self.wet, self.task.relax_rate);
        let kept = &mut self.scratch.sweeps[slot];
        if kept.above != row - 1 {
            let above = flow_rows(&self.u, &self.v, &self.mask, row - 1);
            for &run in wet.runs(row - 1) {
                divergence(&mut kept.delta_above, &above, rate, run);
            }
        }
        let u_here = self.u.row_mut(row);
        let (v_here, v_below) = self.v.row_mut_and_below(row);
        let (mask_above, mask) = (self.mask.row(row - 1), self.mask.row(row));
        let mut largest = self.found.corrections[slot];
        for &run in wet.runs(row) {
            let flow = FlowRows { u: u_here, v: v_here, v_below, mask };
            largest = largest.max(divergence(&mut kept.delta, &flow, rate, run));
            let correction =
                CorrectionRows { delta_above: &kept.delta_above, delta: &kept.delta, mask_above, mask };
            apply(u_here, v_here, self.pressure.row_mut(row), &correction, run);
        }
        std::mem::swap(&mut kept.delta, &mut kept.delta_above);
        kept.above = row;
        self.found.corrections[slot] = largest;
    }

    pub fn guarded_sweep(&mut self, row: usize) {
        // The first sweep is a row ahead: what it has found so far decides.
        let is_sure = f32::from_bits(self.found.corrections[0] as u32) > self.task.relax_tolerance;
        if !is_sure && self.own.contains(&row) {
            self.scratch.saved.save(row, [&self.u, &self.v, &self.pressure]);
        }
        self.sweep(row, 1);
    }

    pub fn flow_outward(&mut self, row: usize) {
        let mut fastest = self.found.outflow;
        for &run in self.wet_runs(row) {
            fastest = fastest.max(outflow_speeds(&self.flow(row), run));
        }
        self.found.outflow = fastest;
        for span in self.outflow.spans(row) {
            let pressure = &mut self.pressure.row_mut(row)[span.clone()];
            draw_off(pressure, &self.outflow.row(row)[span.clone()]);
        }
    }
}
