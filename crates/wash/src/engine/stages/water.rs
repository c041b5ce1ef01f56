//! Rows for the routines that move water.

use crate::engine::ground::Window;
use crate::engine::rows::Rows;
use crate::engine::world::World;
use crate::flow_outward::draw_off;
use crate::move_pigment::outflow_speeds;
use crate::relax_divergence::{AroundRows, FlowRows, WaterRows, divergence, relax};
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

/// The same in a window.
pub fn flow_in<'a>(flow: &FlowRows<'a>, window: &Window) -> FlowRows<'a> {
    FlowRows {
        u: window.here(flow.u),
        v: window.here(flow.v),
        v_below: window.below(flow.v_below),
        mask: window.here(flow.mask),
    }
}

impl World<'_> {
    pub fn flow(&self, row: usize) -> FlowRows<'_> {
        flow_rows(&self.u, &self.v, &self.mask, row)
    }

    pub fn add_slope(&mut self, row: usize) {
        let (mask_above, mask) = (self.mask.row(row - 1), self.mask.row(row));
        let (height_above, height) =
            (self.ground.row(self.slope_height, row - 1), self.ground.row(self.slope_height, row));
        let (film_above, film) = (self.pressure.row(row - 1), self.pressure.row(row));
        let (u, v) = (self.u.row_mut(row), self.v.row_mut(row));
        for window in self.ground.windows(self.wet, row) {
            let run = window.run;
            let (mask_above, mask) = (window.above(mask_above), window.here(mask));
            let (height_above, height) = (window.above(height_above), window.here(height));
            let paper = SlopeRows { height_above, height, mask_above, mask };
            let (u, v) = (window.here_mut(u), window.here_mut(v));
            let scale = self.task.slope_scale;
            let speed = match &self.task.living {
                None => add_slope(u, v, &paper, scale, run),
                Some(living) => {
                    add_slope_tilted(u, v, &paper, scale, living.pull, run);
                    let (film_above, film) = (window.above(film_above), window.here(film));
                    let film = FilmRows { film_above, film, mask_above, mask };
                    let [speed, drive] = drive(u, v, &film, living.stiffness, run);
                    self.found.drive = self.found.drive.max(drive);
                    speed
                }
            };
            self.found.speed = self.found.speed.max(speed);
        }
    }

    pub fn add_slope_alone(&mut self, row: usize) {
        let (mask_above, mask) = (self.mask.row(row - 1), self.mask.row(row));
        let (height_above, height) =
            (self.ground.row(self.slope_height, row - 1), self.ground.row(self.slope_height, row));
        let (u, v) = (self.u.row_mut(row), self.v.row_mut(row));
        for window in self.ground.windows(self.wet, row) {
            let paper = SlopeRows {
                height_above: window.above(height_above),
                height: window.here(height),
                mask_above: window.above(mask_above),
                mask: window.here(mask),
            };
            let (u, v) = (window.here_mut(u), window.here_mut(v));
            add_slope_alone(u, v, &paper, self.task.slope_scale, window.run);
        }
    }

    pub fn advance(&mut self, row: usize, dt: f32, is_noted: bool) {
        let kept = &mut self.scratch.advance;
        kept.u.take(self.wet, self.ground, row, &self.u);
        kept.v.take(self.wet, self.ground, row, &self.v);
        let (u_here, u_below) = self.u.row_mut_and_below(row);
        let (v_here, v_below) = self.v.row_mut_and_below(row);
        let (pressure_above, pressure) = (self.pressure.row(row - 1), self.pressure.row(row));
        let (mask_above, mask) = (self.mask.row(row - 1), self.mask.row(row));
        for (&run, window) in self.wet.runs(row).iter().zip(self.ground.windows(self.wet, row)) {
            let (u_above, u_old) = (window.above(&kept.u.above.values), window.here(&kept.u.here.values));
            let (v_above, v_old) = (window.above(&kept.v.above.values), window.here(&kept.v.here.values));
            let (u_below, v_below) = (window.below(u_below), window.below(v_below));
            // The corners below the last row are those above this one.
            if kept.corner_row != row || !self.wet.is_below_one(row, run) {
                corner_products(window.above_mut(&mut kept.corner), u_above, u_old, v_old, window.run);
            }
            corner_products(window.here_mut(&mut kept.corner_below), u_old, u_below, v_below, window.run);
            let old = VelocityRows {
                u_above,
                u: u_old,
                u_below,
                v_above,
                v: v_old,
                v_below,
                corner: window.above(&kept.corner),
                corner_below: window.here(&kept.corner_below),
                pressure_above: window.above(pressure_above),
                pressure: window.here(pressure),
                mask_above: window.above(mask_above),
                mask: window.here(mask),
            };
            let (u, v) = (window.here_mut(u_here), window.here_mut(v_here));
            let momentum = self.task.momentum(dt);
            match &self.living {
                None => advance(u, v, &old, momentum, window.run),
                Some(living) => {
                    let [keep_u, keep_v] = match &living.keep {
                        Some([keep_u, keep_v]) if dt < 1.0 => [keep_u, keep_v],
                        _ => [&living.mobility_u, &living.mobility_v],
                    };
                    let hold = Hold {
                        keep_u: window.here(keep_u.row(row)),
                        keep_v: window.here(keep_v.row(row)),
                        stiffness: living.task.stiffness,
                        speed_limit: living.task.speed_limit,
                        is_free: dt == 1.0 && living.facts.is_free(row) && run.all_wet,
                    };
                    advance_held(u, v, &old, momentum, &hold, window.run);
                    if is_noted {
                        self.found.advanced = self.found.advanced.max(fastest(u, v, window.run));
                    }
                }
            }
        }
        std::mem::swap(&mut kept.corner, &mut kept.corner_below);
        kept.corner_row = row + 1;
    }

    pub fn find_correction(&mut self, row: usize) {
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let mut largest = self.found.next_correction;
        for window in self.ground.windows(self.wet, row) {
            let delta = window.here_mut(&mut self.scratch.sweeps[0].delta);
            largest =
                largest.max(divergence(delta, &flow_in(&flow, &window), self.task.relax_rate, window.run));
        }
        self.found.next_correction = largest;
    }

    pub fn sweep(&mut self, row: usize, slot: usize) {
        let rate = self.task.relax_rate;
        let kept = &mut self.scratch.sweeps[slot];
        if kept.above != row - 1 {
            let above = flow_rows(&self.u, &self.v, &self.mask, row - 1);
            for window in self.ground.windows(self.wet, row - 1) {
                let delta = window.here_mut(&mut kept.delta_above);
                divergence(delta, &flow_in(&above, &window), rate, window.run);
            }
        }
        let (mask_above, mask) = (self.mask.row(row - 1), self.mask.row(row));
        let (v, v_below) = self.v.row_mut_and_below(row);
        let (u, pressure) = (self.u.row_mut(row), self.pressure.row_mut(row));
        let mut largest = self.found.corrections[slot];
        for window in self.ground.windows(self.wet, row) {
            let (u, v, pressure) = (window.here_mut(u), window.here_mut(v), window.here_mut(pressure));
            let (mask_above, mask) = (window.above(mask_above), window.here(mask));
            let delta = window.here_mut(&mut kept.delta);
            let (v_below, delta_above) = (window.below(v_below), window.above(&kept.delta_above));
            let around = AroundRows { v_below, delta_above, mask_above, mask };
            largest = largest.max(relax(WaterRows { u, v, pressure }, delta, &around, rate, window.run));
        }
        std::mem::swap(&mut kept.delta, &mut kept.delta_above);
        kept.above = row;
        self.found.corrections[slot] = largest;
    }

    pub fn guarded_sweep(&mut self, row: usize) {
        // The first sweep is ahead: what it has found so far decides.
        let is_sure = f32::from_bits(self.found.corrections[0] as u32) > self.task.relax_tolerance;
        if !is_sure && self.own.contains(&row) {
            let place = self.ground.start(row)..self.ground.start(row + 1);
            self.scratch.saved.save(place, [&self.u, &self.v, &self.pressure]);
        }
        self.sweep(row, 1);
    }

    pub fn flow_outward(&mut self, row: usize) {
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let mut fastest = self.found.outflow;
        for window in self.ground.windows(self.wet, row) {
            fastest = fastest.max(outflow_speeds(&flow_in(&flow, &window), window.run));
        }
        self.found.outflow = fastest;
        for (place, amounts) in self.outflow.amounts(row) {
            draw_off(self.pressure.at_mut(place, amounts.len()), amounts);
        }
    }
}
