//! The plain engine: routine by routine, over the whole canvas, on one thread.

use std::sync::atomic::AtomicBool;

use girtin_grid::Field;

use super::{Stop, Task, go_on, substeps};
use crate::flow_outward::{Outflow, draw_off};
use crate::move_pigment::{SuspendedRows, carry, outflow_speeds};
use crate::region::Region;
use crate::relax_divergence::{CorrectionRows, FlowRows, apply, divergence};
use crate::simulate_capillary_flow::{PoreRows, absorb, diffuse, spread};
use crate::state::WashState;
use crate::transfer_pigment::transfer;
use crate::update_velocities::{SlopeRows, VelocityRows, add_slope, advance, corner_products};

/// η(1 − M′)M of the state's mask.
pub fn outflow(state: &WashState, task: &Task) -> Outflow {
    let layout = state.layout();
    let mut outflow = Outflow::new(layout, task.edge_darkening, task.edge_kernel);
    outflow.renew(&state.wet_mask, layout.rows(), layout.columns(), 1);
    outflow
}

/// One step of C97's MainLoop; returns the number of relaxation sweeps.
///
/// # Source
/// Curtis et al. 1997, §4.3–4.6.
pub fn step(
    state: &mut WashState,
    task: &Task,
    outflow: &mut Outflow,
    cancel: &AtomicBool,
) -> Result<u32, Stop> {
    let canvas = Region::whole(state.layout());
    update_velocities(state, task, &canvas, cancel)?;
    let sweeps = relax_divergence(state, task, &canvas, cancel)?;
    flow_outward(state, outflow);
    move_pigment(state, &canvas, cancel)?;
    transfer_pigment(state, task, &canvas);
    simulate_capillary_flow(state, task, &canvas, outflow);
    Ok(sweeps)
}

fn update_velocities(
    state: &mut WashState,
    task: &Task,
    canvas: &Region,
    cancel: &AtomicBool,
) -> Result<(), Stop> {
    let WashState { wet_mask, height, u, v, pressure, .. } = state;
    let mut fastest = 0;
    for row in canvas.active() {
        let paper = SlopeRows {
            height_above: height.row(row - 1),
            height: height.row(row),
            mask_above: wet_mask.row(row - 1),
            mask: wet_mask.row(row),
        };
        for &run in canvas.runs(row) {
            let bits = add_slope(u.row_mut(row), v.row_mut(row), &paper, task.slope_scale, run);
            fastest = fastest.max(bits);
        }
    }
    let n = substeps(fastest)?;
    let stride = u.layout().stride();
    let (mut corner, mut corner_below) = (vec![0.0; stride], vec![0.0; stride]);
    for _ in 0..n {
        go_on(fastest, cancel)?;
        let (u_old, v_old) = (u.clone(), v.clone());
        for row in canvas.active() {
            for &run in canvas.runs(row) {
                corner_products(&mut corner, u_old.row(row - 1), u_old.row(row), v_old.row(row), run);
                corner_products(
                    &mut corner_below,
                    u_old.row(row),
                    u_old.row(row + 1),
                    v_old.row(row + 1),
                    run,
                );
                let old = VelocityRows {
                    u_above: u_old.row(row - 1),
                    u: u_old.row(row),
                    u_below: u_old.row(row + 1),
                    v_above: v_old.row(row - 1),
                    v: v_old.row(row),
                    v_below: v_old.row(row + 1),
                    corner: &corner,
                    corner_below: &corner_below,
                    pressure_above: pressure.row(row - 1),
                    pressure: pressure.row(row),
                    mask_above: wet_mask.row(row - 1),
                    mask: wet_mask.row(row),
                };
                advance(u.row_mut(row), v.row_mut(row), &old, task.momentum(1.0 / n as f32), run);
            }
        }
    }
    Ok(())
}

fn relax_divergence(
    state: &mut WashState,
    task: &Task,
    canvas: &Region,
    cancel: &AtomicBool,
) -> Result<u32, Stop> {
    let WashState { wet_mask, u, v, pressure, .. } = state;
    let mut delta = Field::<f32>::zeroed(u.layout());
    let mut sweeps = 0;
    loop {
        let mut largest = 0;
        for row in canvas.active() {
            for &run in canvas.runs(row) {
                let flow = FlowRows {
                    u: u.row(row),
                    v: v.row(row),
                    v_below: v.row(row + 1),
                    mask: wet_mask.row(row),
                };
                largest = largest.max(divergence(delta.row_mut(row), &flow, task.relax_rate, run));
            }
        }
        for row in canvas.active() {
            for &run in canvas.runs(row) {
                let correction = CorrectionRows {
                    delta_above: delta.row(row - 1),
                    delta: delta.row(row),
                    mask_above: wet_mask.row(row - 1),
                    mask: wet_mask.row(row),
                };
                apply(u.row_mut(row), v.row_mut(row), pressure.row_mut(row), &correction, run);
            }
        }
        sweeps += 1;
        go_on(largest, cancel)?;
        if f32::from_bits(largest as u32) <= task.relax_tolerance || sweeps >= task.relax_max_sweeps {
            return Ok(sweeps);
        }
    }
}

fn flow_outward(state: &mut WashState, outflow: &Outflow) {
    for row in state.layout().rows() {
        for span in outflow.spans(row) {
            draw_off(&mut state.pressure.row_mut(row)[span.clone()], &outflow.row(row)[span.clone()]);
        }
    }
}

fn move_pigment(state: &mut WashState, canvas: &Region, cancel: &AtomicBool) -> Result<(), Stop> {
    let WashState { wet_mask, u, v, suspended, .. } = state;
    let flow =
        |row| FlowRows { u: u.row(row), v: v.row(row), v_below: v.row(row + 1), mask: wet_mask.row(row) };
    let mut fastest = 0;
    for row in canvas.active() {
        for &run in canvas.runs(row) {
            fastest = fastest.max(outflow_speeds(&flow(row), run));
        }
    }
    let n = substeps(fastest)?;
    for suspended in suspended {
        for _ in 0..n {
            go_on(fastest, cancel)?;
            let old = suspended.clone();
            for row in canvas.active() {
                for &run in canvas.runs(row) {
                    let rows = SuspendedRows {
                        above: old.row(row - 1),
                        here: old.row(row),
                        below: old.row(row + 1),
                    };
                    carry(suspended.row_mut(row), &rows, &flow(row), 1.0 / n as f32, run);
                }
            }
        }
    }
    Ok(())
}

fn transfer_pigment(state: &mut WashState, task: &Task, canvas: &Region) {
    let WashState { wet_mask, height, suspended, deposited, .. } = state;
    for ((suspended, deposited), &exchange) in suspended.iter_mut().zip(deposited).zip(&task.exchanges) {
        for row in canvas.active() {
            for &run in canvas.runs(row) {
                let (g, d) = (suspended.row_mut(row), deposited.row_mut(row));
                transfer(g, d, height.row(row), wet_mask.row(row), exchange, run);
            }
        }
    }
}

fn simulate_capillary_flow(state: &mut WashState, task: &Task, canvas: &Region, outflow: &mut Outflow) {
    let Some(pores) = &task.pores else { return };
    let WashState { wet_mask, height, saturation, .. } = state;
    for row in canvas.active() {
        for &run in canvas.runs(row) {
            absorb(saturation.row_mut(row), height.row(row), wet_mask.row(row), pores, run);
        }
    }
    let old = saturation.clone();
    let mut grown = false;
    for row in canvas.active() {
        for &run in canvas.runs(row) {
            let rows = PoreRows {
                above: old.row(row - 1),
                here: old.row(row),
                below: old.row(row + 1),
                height_above: height.row(row - 1),
                height: height.row(row),
                height_below: height.row(row + 1),
            };
            diffuse(saturation.row_mut(row), &rows, pores, run);
            grown |= spread(wet_mask.row_mut(row), saturation.row(row), pores, run);
        }
    }
    if grown {
        let layout = wet_mask.layout();
        outflow.renew(wet_mask, layout.rows(), layout.columns(), 1);
    }
}
