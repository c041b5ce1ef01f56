//! One pool of water: the passes of a step over its runs of wet cells, in bands of rows.
//!
//! A pass goes down the rows of a band in place. What a row's kernel needs of rows that were already changed is kept
//! in a ring of rows; what it needs of a neighbouring band is saved before the bands start. So bands depend on
//! nothing that another one changes, and their number changes no bit.
//!
//! Passes of a step: slope and velocities; each relaxation sweep; outflow and speeds; pigment and its exchange with
//! the paper; capillary water. Between them stand only the maxima on which the next pass depends.

use girtin_grid::Field;
use rayon::prelude::*;

use super::Task;
use crate::flow_outward::{Outflow, draw_off};
use crate::move_pigment::{SuspendedRows, carry, outflow_speeds};
use crate::region::Region;
use crate::relax_divergence::{CorrectionRows, FlowRows, apply, divergence};
use crate::simulate_capillary_flow::{PoreRows, Pores, absorb, diffuse, spread};
use crate::state::WashState;
use crate::transfer_pigment::transfer;
use crate::update_velocities::{Momentum, SlopeRows, VelocityRows, add_slope, advance, corner_products};

/// Cells below which a second band costs more than it saves.
const CELLS_WORTH_A_BAND: usize = 16384;
/// Bands for each thread: more even out a load that rows share unevenly.
const BANDS_PER_THREAD: usize = 2;

/// A pool: a state, and what is kept of it from step to step.
#[derive(Debug)]
pub struct Pool {
    state: WashState,
    outflow: Outflow,
    /// Bands at most.
    bands: usize,
    wet: Region,
    wet_cuts: Vec<usize>,
    /// Where there is pore water or will be; empty when the capillary layer is off.
    damp: Region,
    damp_cuts: Vec<usize>,
    scratch: Vec<Scratch>,
    /// No slope term of a wet face is larger.
    steepest: f32,
}

/// Rows of one band.
#[derive(Debug)]
struct Scratch {
    u: Ring,
    v: Ring,
    corner: Vec<f32>,
    corner_below: Vec<f32>,
    delta: Vec<f32>,
    delta_above: Vec<f32>,
    suspended: Vec<Ring>,
    saturation: Ring,
    mask_above: Vec<u8>,
    mask_below: Vec<u8>,
}

/// A row before it is changed, the one above, and the one below the band.
#[derive(Debug)]
struct Ring {
    above: Slot,
    here: Slot,
    below_band: Slot,
}

/// A copy of the runs of one row, 0 elsewhere.
#[derive(Debug)]
struct Slot {
    values: Vec<f32>,
    holds: usize,
}

impl Slot {
    fn new(stride: usize) -> Self {
        // Row 0 is border and has no runs.
        Self { values: vec![0.0; stride], holds: 0 }
    }

    fn take(&mut self, region: &Region, row: usize, from: &[f32]) {
        // Runs only grow while a slot lives, so the runs of the row it holds cover all that is not 0.
        if region.runs(self.holds) != region.runs(row) {
            for run in region.runs(self.holds) {
                self.values[run.first..run.end].fill(0.0);
            }
        }
        for run in region.runs(row) {
            self.values[run.first..run.end].copy_from_slice(&from[run.first..run.end]);
        }
        self.holds = row;
    }
}

impl Ring {
    fn new(stride: usize) -> Self {
        Self { above: Slot::new(stride), here: Slot::new(stride), below_band: Slot::new(stride) }
    }

    /// Saves the rows of `field` just outside the band that begins and ends at `cut`.
    fn save_halo(&mut self, region: &Region, cut: &[usize], field: &Field<f32>) {
        self.above.take(region, cut[0] - 1, field.row(cut[0] - 1));
        self.below_band.take(region, cut[1], field.row(cut[1]));
    }

    /// Done with the row: it is now the one above.
    fn turn(&mut self) {
        std::mem::swap(&mut self.above, &mut self.here);
    }
}

impl Scratch {
    fn new(stride: usize, pigments: usize) -> Self {
        let row = || vec![0.0; stride];
        Self {
            u: Ring::new(stride),
            v: Ring::new(stride),
            corner: row(),
            corner_below: row(),
            delta: row(),
            delta_above: row(),
            suspended: (0..pigments).map(|_| Ring::new(stride)).collect(),
            saturation: Ring::new(stride),
            mask_above: vec![0; stride],
            mask_below: vec![0; stride],
        }
    }
}

/// Works on all bands and returns the largest of what they return.
fn each_band<Job: Send>(jobs: Vec<Job>, work: impl Fn(Job) -> i32 + Sync + Send) -> i32 {
    if jobs.len() == 1 {
        jobs.into_iter().map(work).fold(0, i32::max)
    } else {
        jobs.into_par_iter().map(work).reduce(|| 0, i32::max)
    }
}

/// Where water is or, with the capillary layer on, may come: pore water reaches only cells that have some.
pub fn reach(state: &WashState, task: &Task) -> Region {
    if task.pores.is_none() {
        return Region::of(&state.wet_mask, |wet| wet != 0);
    }
    let mut damp = Field::<u8>::zeroed(state.layout());
    for row in state.layout().rows() {
        let (wet, pores) = (state.wet_mask.row(row), state.saturation.row(row));
        if wet.iter().all(|&wet| wet == 0) && pores.iter().all(|&s| s == 0.0) {
            continue;
        }
        for ((damp, &wet), &s) in damp.row_mut(row).iter_mut().zip(wet).zip(pores) {
            *damp = u8::from(wet != 0 || s != 0.0);
        }
    }
    Region::of(&damp, |damp| damp != 0)
}

impl Pool {
    /// Finds where in the pool the water is.
    pub fn new(state: WashState, task: &Task, threads: usize) -> Self {
        let layout = state.layout();
        let bands = if threads == 1 { 1 } else { threads * BANDS_PER_THREAD };
        let mut outflow = Outflow::new(layout, task.edge_darkening, task.edge_kernel);
        outflow.renew(&state.wet_mask, layout.rows(), layout.columns(), bands);
        let wet = Region::of(&state.wet_mask, |wet| wet != 0);
        let damp = if task.pores.is_some() { reach(&state, task) } else { Region::empty() };
        let (wet_cuts, damp_cuts, scratch) = (Vec::new(), Vec::new(), Vec::new());
        let mut pool = Self { state, outflow, bands, wet, wet_cuts, damp, damp_cuts, scratch, steepest: 0.0 };
        for row in pool.wet.active() {
            pool.note_slope(task, row);
        }
        pool.cut(task);
        pool
    }

    /// The state.
    pub fn state(&mut self) -> &mut WashState {
        &mut self.state
    }

    /// A bound on the slope term of every wet face.
    pub fn steepest(&self) -> f32 {
        self.steepest
    }

    /// Shares the rows among bands.
    fn cut(&mut self, task: &Task) {
        let bands = |region: &Region| (region.cells() / CELLS_WORTH_A_BAND).clamp(1, self.bands);
        self.wet_cuts = self.wet.cuts(bands(&self.wet));
        self.damp_cuts = self.damp.cuts(bands(&self.damp));
        let needed = self.wet_cuts.len().max(self.damp_cuts.len()) - 1;
        let stride = self.state.layout().stride();
        while self.scratch.len() < needed {
            self.scratch.push(Scratch::new(stride, task.exchanges.len()));
        }
    }

    /// Raises the bound on the slope term to that of the row's faces.
    fn note_slope(&mut self, task: &Task, row: usize) {
        let (above, here) = (self.state.height.row(row - 1), self.state.height.row(row));
        for run in self.wet.runs(row) {
            for x in run.first..run.end {
                let slope = (here[x] - here[x - 1]).abs().max((here[x] - above[x]).abs());
                self.steepest = self.steepest.max(task.slope_scale * slope);
            }
        }
    }

    /// Adds the slope term to the velocities; returns the bits of the largest speed.
    pub fn slope(&mut self, scale: f32) -> i32 {
        if self.wet.active().is_empty() {
            return 0;
        }
        let WashState { wet_mask, height, u, v, .. } = &mut self.state;
        let bands = u.bands_mut(&self.wet_cuts).into_iter().zip(v.bands_mut(&self.wet_cuts));
        each_band(bands.collect(), |(mut u, mut v)| {
            let mut fastest = 0;
            for row in u.rows() {
                let paper = slope_rows(height, wet_mask, row);
                for &run in self.wet.runs(row) {
                    fastest = fastest.max(add_slope(u.row_mut(row), v.row_mut(row), &paper, scale, run));
                }
            }
            fastest
        })
    }

    /// One sub-step of the velocities, after the slope term if `slope_scale` is given.
    pub fn advance(&mut self, momentum: Momentum, slope_scale: Option<f32>) {
        if self.wet.active().is_empty() {
            return;
        }
        let WashState { wet_mask, height, u, v, pressure, .. } = &mut self.state;
        let (wet, cuts) = (&self.wet, &self.wet_cuts);
        for (scratch, cut) in self.scratch.iter_mut().zip(cuts.windows(2)) {
            scratch.u.save_halo(wet, cut, u);
            scratch.v.save_halo(wet, cut, v);
        }
        let add_slope = |u: &mut [f32], v: &mut [f32], row| {
            if let (Some(scale), false) = (slope_scale, wet.runs(row).is_empty()) {
                let paper = slope_rows(height, wet_mask, row);
                for &run in wet.runs(row) {
                    add_slope(u, v, &paper, scale, run);
                }
            }
        };
        let bands = u.bands_mut(cuts).into_iter().zip(v.bands_mut(cuts)).zip(&mut self.scratch);
        each_band(bands.collect(), |((mut u, mut v), scratch)| {
            let rows = u.rows();
            let Scratch { u: old_u, v: old_v, corner, corner_below, .. } = scratch;
            add_slope(&mut old_u.above.values, &mut old_v.above.values, rows.start - 1);
            add_slope(&mut old_u.below_band.values, &mut old_v.below_band.values, rows.end);
            add_slope(u.row_mut(rows.start), v.row_mut(rows.start), rows.start);
            for row in rows.clone() {
                if row + 1 < rows.end {
                    add_slope(u.row_mut(row + 1), v.row_mut(row + 1), row + 1);
                }
                let (u_here, u_below) = u.row_mut_and_below(row);
                let (v_here, v_below) = v.row_mut_and_below(row);
                let u_below = u_below.unwrap_or(&old_u.below_band.values);
                let v_below = v_below.unwrap_or(&old_v.below_band.values);
                old_u.here.take(wet, row, u_here);
                old_v.here.take(wet, row, v_here);
                let corners_known = row > rows.start && wet.runs(row) == wet.runs(row - 1);
                for &run in wet.runs(row) {
                    let (u_above, u_old, v_old) =
                        (&old_u.above.values, &old_u.here.values, &old_v.here.values);
                    if !corners_known {
                        corner_products(corner, u_above, u_old, v_old, run);
                    }
                    corner_products(corner_below, u_old, u_below, v_below, run);
                    let old = VelocityRows {
                        u_above,
                        u: u_old,
                        u_below,
                        v_above: &old_v.above.values,
                        v: v_old,
                        v_below,
                        corner,
                        corner_below,
                        pressure_above: pressure.row(row - 1),
                        pressure: pressure.row(row),
                        mask_above: wet_mask.row(row - 1),
                        mask: wet_mask.row(row),
                    };
                    advance(u_here, v_here, &old, momentum, run);
                }
                std::mem::swap(corner, corner_below);
                old_u.turn();
                old_v.turn();
            }
            0
        });
    }

    /// One relaxation sweep; returns the bits of the largest correction.
    pub fn sweep(&mut self, rate: f32) -> i32 {
        if self.wet.active().is_empty() {
            return 0;
        }
        let WashState { wet_mask, u, v, pressure, .. } = &mut self.state;
        let (wet, cuts) = (&self.wet, &self.wet_cuts);
        for (scratch, cut) in self.scratch.iter_mut().zip(cuts.windows(2)) {
            let above = cut[0] - 1;
            let flow = FlowRows {
                u: u.row(above),
                v: v.row(above),
                v_below: v.row(cut[0]),
                mask: wet_mask.row(above),
            };
            for &run in wet.runs(above) {
                divergence(&mut scratch.delta_above, &flow, rate, run);
            }
            scratch.v.below_band.take(wet, cut[1], v.row(cut[1]));
        }
        let bands = u.bands_mut(cuts).into_iter().zip(v.bands_mut(cuts)).zip(pressure.bands_mut(cuts));
        each_band(bands.zip(&mut self.scratch).collect(), |(((mut u, mut v), mut pressure), scratch)| {
            let Scratch { delta, delta_above, v: old_v, .. } = scratch;
            let mut largest = 0;
            let rows = u.rows();
            for row in rows.clone() {
                let (v_here, v_below) = v.row_mut_and_below(row);
                let (u_here, v_below) = (u.row_mut(row), v_below.unwrap_or(&old_v.below_band.values));
                let mask = wet_mask.row(row);
                for &run in wet.runs(row) {
                    let flow = FlowRows { u: u_here, v: v_here, v_below, mask };
                    largest = largest.max(divergence(delta, &flow, rate, run));
                    let correction =
                        CorrectionRows { delta_above, delta, mask_above: wet_mask.row(row - 1), mask };
                    apply(u_here, v_here, pressure.row_mut(row), &correction, run);
                }
                std::mem::swap(delta, delta_above);
            }
            largest
        })
    }

    /// Draws water to the edges; returns the bits of the largest sum of outflow speeds of a cell.
    pub fn flow_outward(&mut self) -> i32 {
        let WashState { wet_mask, u, v, pressure, .. } = &mut self.state;
        let outflow = &self.outflow;
        each_band(pressure.bands_mut(&self.wet_cuts), |mut pressure| {
            let mut fastest = 0;
            let rows = pressure.rows();
            for row in rows.clone() {
                let flow = flow_rows(u, v, wet_mask, row);
                for &run in self.wet.runs(row) {
                    fastest = fastest.max(outflow_speeds(&flow, run));
                }
                for span in outflow.spans(row) {
                    draw_off(&mut pressure.row_mut(row)[span.clone()], &outflow.row(row)[span.clone()]);
                }
            }
            fastest
        })
    }

    /// Moves pigment by one sub-step of length `dt`, and after the last exchanges it with the paper.
    pub fn carry(&mut self, task: &Task, dt: f32, last: bool) {
        if self.wet.active().is_empty() {
            return;
        }
        let WashState { wet_mask, height, u, v, suspended, deposited, .. } = &mut self.state;
        let (wet, cuts) = (&self.wet, &self.wet_cuts);
        for (scratch, cut) in self.scratch.iter_mut().zip(cuts.windows(2)) {
            for (ring, suspended) in scratch.suspended.iter_mut().zip(suspended.iter()) {
                ring.save_halo(wet, cut, suspended);
            }
        }
        // The bands of each pigment, then the pigments of each band.
        let mut suspended: Vec<_> = suspended.iter_mut().map(|g| g.bands_mut(cuts).into_iter()).collect();
        let mut deposited: Vec<_> = deposited.iter_mut().map(|d| d.bands_mut(cuts).into_iter()).collect();
        let bands = cuts.windows(2).zip(&mut self.scratch).map(|(cut, scratch)| {
            let g: Vec<_> = suspended.iter_mut().filter_map(Iterator::next).collect();
            let d: Vec<_> = deposited.iter_mut().filter_map(Iterator::next).collect();
            (cut[0]..cut[1], g, d, scratch)
        });
        each_band(bands.collect(), |(rows, mut suspended, mut deposited, scratch)| {
            for row in rows.clone() {
                let flow = flow_rows(u, v, wet_mask, row);
                for (k, ring) in scratch.suspended.iter_mut().enumerate() {
                    let (g, below) = suspended[k].row_mut_and_below(row);
                    ring.here.take(wet, row, g);
                    let old = SuspendedRows {
                        above: &ring.above.values,
                        here: &ring.here.values,
                        below: below.unwrap_or(&ring.below_band.values),
                    };
                    for &run in wet.runs(row) {
                        carry(g, &old, &flow, dt, run);
                        if last {
                            let d = deposited[k].row_mut(row);
                            transfer(g, d, height.row(row), wet_mask.row(row), task.exchanges[k], run);
                        }
                    }
                    ring.turn();
                }
            }
            0
        });
    }

    /// Moves pore water, wets new cells, and looks again at what that changed.
    pub fn simulate_capillary_flow(&mut self, task: &Task, pores: &Pores) {
        if self.damp.active().is_empty() {
            return;
        }
        let grown = self.creep(pores);
        let Some(&(mut first_row, mut first, mut end)) = grown.first() else { return };
        let mut last_row = first_row;
        for &(row, from, to) in &grown {
            (first_row, last_row) = (first_row.min(row), last_row.max(row));
            (first, end) = (first.min(from), end.max(to));
            // The row below asks whether this one is wet throughout.
            for row in row..=(row + 1).min(self.state.layout().rows().end - 1) {
                self.wet.rescan(&self.state.wet_mask, row, |wet| wet != 0);
                self.note_slope(task, row);
            }
        }
        self.cut(task);
        self.outflow.renew(
            &self.state.wet_mask,
            first_row..last_row + 1,
            first..end,
            self.wet_cuts.len() - 1,
        );
    }

    /// Moves pore water; returns the rows where new cells became wet, with the columns to look at.
    fn creep(&mut self, pores: &Pores) -> Vec<(usize, usize, usize)> {
        let WashState { wet_mask, height, saturation, .. } = &mut self.state;
        let (damp, cuts) = (&self.damp, &self.damp_cuts);
        for (scratch, cut) in self.scratch.iter_mut().zip(cuts.windows(2)) {
            scratch.saturation.save_halo(damp, cut, saturation);
            scratch.mask_above.copy_from_slice(wet_mask.row(cut[0] - 1));
            scratch.mask_below.copy_from_slice(wet_mask.row(cut[1]));
        }
        let absorb_row = |s: &mut [f32], mask: &[u8], row| {
            for &run in damp.runs(row) {
                absorb(s, height.row(row), mask, pores, run);
            }
        };
        let bands = saturation.bands_mut(cuts).into_iter().zip(wet_mask.bands_mut(cuts));
        let work = |((mut saturation, mut mask), scratch): (
            (girtin_grid::field::Band<'_, f32>, _),
            &mut Scratch,
        )| {
            let mask: &mut girtin_grid::field::Band<'_, u8> = &mut mask;
            let rows = saturation.rows();
            let ring = &mut scratch.saturation;
            absorb_row(&mut ring.above.values, &scratch.mask_above, rows.start - 1);
            absorb_row(&mut ring.below_band.values, &scratch.mask_below, rows.end);
            absorb_row(saturation.row_mut(rows.start), mask.row(rows.start), rows.start);
            let mut grown = Vec::new();
            for row in rows.clone() {
                if row + 1 < rows.end {
                    absorb_row(saturation.row_mut(row + 1), mask.row(row + 1), row + 1);
                }
                let (here, below) = saturation.row_mut_and_below(row);
                ring.here.take(damp, row, here);
                let old = PoreRows {
                    above: &ring.above.values,
                    here: &ring.here.values,
                    below: below.unwrap_or(&ring.below_band.values),
                    height_above: height.row(row - 1),
                    height: height.row(row),
                    height_below: height.row(row + 1),
                };
                for &run in damp.runs(row) {
                    diffuse(here, &old, pores, run);
                    if spread(mask.row_mut(row), here, pores, run) {
                        grown.push((row, run.first, run.end));
                    }
                }
                ring.turn();
            }
            grown
        };
        let jobs: Vec<_> = bands.zip(&mut self.scratch).collect();
        if jobs.len() == 1 {
            jobs.into_iter().flat_map(work).collect()
        } else {
            jobs.into_par_iter().flat_map_iter(work).collect()
        }
    }
}

fn slope_rows<'a>(height: &'a Field<f32>, mask: &'a Field<u8>, row: usize) -> SlopeRows<'a> {
    SlopeRows {
        height_above: height.row(row - 1),
        height: height.row(row),
        mask_above: mask.row(row - 1),
        mask: mask.row(row),
    }
}

fn flow_rows<'a>(u: &'a Field<f32>, v: &'a Field<f32>, mask: &'a Field<u8>, row: usize) -> FlowRows<'a> {
    FlowRows { u: u.row(row), v: v.row(row), v_below: v.row(row + 1), mask: mask.row(row) }
}
