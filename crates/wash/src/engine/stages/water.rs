//! Rows for the routines that move water.

use girtin_grid::Field;

use crate::engine::ground::Window;
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

/// The same in a window.
pub fn flow_in<'a>(
    u: &'a Rows<'_, f32>,
    v: &'a Rows<'_, f32>,
    mask: &'a Rows<'_, u8>,
    window: &Window,
) -> FlowRows<'a> {
    let &Window { here, below, len, .. } = window;
    FlowRows { u: u.at(here, len), v: v.at(here, len), v_below: v.at(below, len), mask: mask.at(here, len) }
}

fn slope_in<'a>(height: &'a Field<f32>, mask: &'a Rows<'_, u8>, window: &Window) -> SlopeRows<'a> {
    let &Window { above, here, len, .. } = window;
    SlopeRows {
        height_above: &height.values()[above..][..len],
        height: &height.values()[here..][..len],
        mask_above: mask.at(above, len),
        mask: mask.at(here, len),
    }
}

impl World<'_> {
    pub fn flow(&self, row: usize) -> FlowRows<'_> {
        flow_rows(&self.u, &self.v, &self.mask, row)
    }

    pub fn add_slope(&mut self, row: usize) {
        for window in self.wet_windows(row) {
            let Window { run, above, here, len, .. } = window;
            let paper = slope_in(self.slope_height, &self.mask, &window);
            let scale = self.task.slope_scale;
            let (u, v) = (self.u.at_mut(here, len), self.v.at_mut(here, len));
            let speed = match &self.task.living {
                None => add_slope(u, v, &paper, scale, run),
                Some(living) => {
                    add_slope_tilted(u, v, &paper, scale, living.pull, run);
                    let film = FilmRows {
                        film_above: self.pressure.at(above, len),
                        film: self.pressure.at(here, len),
                        mask_above: self.mask.at(above, len),
                        mask: self.mask.at(here, len),
                    };
                    let [speed, drive] = drive(u, v, &film, living.stiffness, run);
                    self.found.drive = self.found.drive.max(drive);
                    speed
                }
            };
            self.found.speed = self.found.speed.max(speed);
        }
    }

    pub fn add_slope_alone(&mut self, row: usize) {
        for window in self.wet_windows(row) {
            let Window { run, here, len, .. } = window;
            let paper = slope_in(self.slope_height, &self.mask, &window);
            let (u, v) = (self.u.at_mut(here, len), self.v.at_mut(here, len));
            add_slope_alone(u, v, &paper, self.task.slope_scale, run);
        }
    }

    pub fn advance(&mut self, row: usize, dt: f32, is_noted: bool) {
        let kept = &mut self.scratch.advance;
        kept.u.take(self.wet, self.ground, row, &self.u);
        kept.v.take(self.wet, self.ground, row, &self.v);
        // The corners below the last row are those above this one, if both have the same runs.
        let corners_known = kept.corner_row == row && self.wet.runs(row) == self.wet.runs(row - 1);
        for window in self.ground.windows(self.wet, row) {
            let Window { run, above, here, below, len, .. } = window;
            let (u_here, u_below) = self.u.at_mut_and_below(here, below, len);
            let (v_here, v_below) = self.v.at_mut_and_below(here, below, len);
            let (u_above, u_old) = (window.of(&kept.u.above.values), window.of(&kept.u.here.values));
            let (v_above, v_old) = (window.of(&kept.v.above.values), window.of(&kept.v.here.values));
            if !corners_known {
                corner_products(window.of_mut(&mut kept.corner), u_above, u_old, v_old, run);
            }
            corner_products(window.of_mut(&mut kept.corner_below), u_old, u_below, v_below, run);
            let old = VelocityRows {
                u_above,
                u: u_old,
                u_below,
                v_above,
                v: v_old,
                v_below,
                corner: window.of(&kept.corner),
                corner_below: window.of(&kept.corner_below),
                pressure_above: self.pressure.at(above, len),
                pressure: self.pressure.at(here, len),
                mask_above: self.mask.at(above, len),
                mask: self.mask.at(here, len),
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
                        keep_u: keep_u.at(here, len),
                        keep_v: keep_v.at(here, len),
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
        for window in self.wet_windows(row) {
            let delta = window.of_mut(&mut self.scratch.sweeps[0].delta);
            let flow = flow_in(&self.u, &self.v, &self.mask, &window);
            largest = largest.max(divergence(delta, &flow, self.task.relax_rate, window.run));
        }
        self.found.next_correction = largest;
    }

    pub fn sweep(&mut self, row: usize, slot: usize) {
        let rate = self.task.relax_rate;
        let kept = &mut self.scratch.sweeps[slot];
        if kept.above != row - 1 {
            for window in self.ground.windows(self.wet, row - 1) {
                let above = flow_in(&self.u, &self.v, &self.mask, &window);
                divergence(window.of_mut(&mut kept.delta_above), &above, rate, window.run);
            }
        }
        let mut largest = self.found.corrections[slot];
        for window in self.ground.windows(self.wet, row) {
            let Window { run, above, here, below, len, .. } = window;
            let (v, v_below) = self.v.at_mut_and_below(here, below, len);
            let (u, pressure) = (self.u.at_mut(here, len), self.pressure.at_mut(here, len));
            let (mask_above, mask) = (self.mask.at(above, len), self.mask.at(here, len));
            let delta = window.of_mut(&mut kept.delta);
            largest = largest.max(divergence(delta, &FlowRows { u, v, v_below, mask }, rate, run));
            let delta_above = window.of(&kept.delta_above);
            apply(u, v, pressure, &CorrectionRows { delta_above, delta, mask_above, mask }, run);
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
        let mut fastest = self.found.outflow;
        for window in self.wet_windows(row) {
            let flow = flow_in(&self.u, &self.v, &self.mask, &window);
            fastest = fastest.max(outflow_speeds(&flow, window.run));
        }
        self.found.outflow = fastest;
        for (place, amounts) in self.outflow.amounts(row) {
            draw_off(self.pressure.at_mut(place, amounts.len()), amounts);
        }
    }
}
