//! The fast engine: only where water is, in parallel.
//!
//! Water far apart is simulated apart: each pool has a state of its own, as small as it can be, so that a stroke on a
//! large sheet lies as close in memory as it would on a small one. Pools share only the maxima that decide on
//! sub-steps and sweeps, so they give the bits of the whole canvas. Where water covers most of the sheet there is one
//! pool, and it is the sheet.

use std::sync::atomic::AtomicBool;

use girtin_grid::{Field, Layout};
use rayon::prelude::*;

use super::pool::{Pool, reach};
use super::{Stop, Task, go_on, substeps};
use crate::region::Region;
use crate::state::WashState;

/// The pools of a wash.
#[derive(Debug)]
pub struct Fast {
    threads: usize,
    pools: Vec<Place>,
    /// The largest sum of outflow speeds of a cell, when known.
    fastest: Option<f32>,
}

/// A pool and where it lies.
#[derive(Debug)]
struct Place {
    pool: Pool,
    /// `None` for the whole canvas, whose state is then lent and not copied.
    part: Option<Part>,
}

/// Runs of cells that see no other water, and the rectangle around them.
#[derive(Debug)]
struct Part {
    around: Rectangle,
    /// Row, first column and end of each, on the canvas.
    runs: Vec<[usize; 3]>,
}

/// A rectangle of cells of the canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rectangle {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

impl Rectangle {
    fn cells(self) -> usize {
        (self.right - self.left) * (self.bottom - self.top)
    }

    fn around(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

impl Fast {
    /// Finds the pools of a state, and takes their water: the state has it back after [`Fast::give_back`].
    pub fn new(state: &mut WashState, task: &Task, threads: usize) -> Self {
        let canvas = state.layout();
        let parts = parts(&reach(state, task), canvas, task.edge_kernel as usize / 2);
        let wet: usize = parts.iter().flat_map(|part| &part.runs).map(|[_, first, end]| end - first).sum();
        let around: usize = parts.iter().map(|part| part.around.cells()).sum();
        let place = |part: Option<Part>, state| Place { pool: Pool::new(state, task, threads), part };
        // Copying to and fro pays only where the water is a small part of the canvas.
        let pools = if (2 * wet).max(around) > canvas.width() * canvas.height() {
            vec![place(None, lend(state))]
        } else {
            let parts = parts.into_iter().map(|part| {
                let own = cut_out(state, &part);
                place(Some(part), own)
            });
            parts.collect()
        };
        Self { threads, pools, fastest: None }
    }

    /// How many threads the pools are for.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Takes the water again after [`Fast::give_back`]; where it is wet must not have changed meanwhile.
    pub fn take(&mut self, state: &mut WashState) {
        for Place { pool, part } in &mut self.pools {
            match part {
                None => *pool.state() = lend(state),
                Some(part) => copy(state, part, pool.state(), Direction::OutOfCanvas),
            }
        }
    }

    /// Gives the water back to the state.
    pub fn give_back(&mut self, state: &mut WashState) {
        for Place { pool, part } in &mut self.pools {
            match part {
                None => *state = lend(pool.state()),
                Some(part) => copy(state, part, pool.state(), Direction::IntoCanvas),
            }
        }
    }

    /// Works on all pools and returns the largest of what they return.
    fn largest(&mut self, work: impl Fn(&mut Pool) -> i32 + Sync + Send) -> i32 {
        let pools = &mut self.pools;
        if self.threads == 1 || pools.len() == 1 {
            pools.iter_mut().map(|place| work(&mut place.pool)).fold(0, i32::max)
        } else {
            pools.par_iter_mut().map(|place| work(&mut place.pool)).reduce(|| 0, i32::max)
        }
    }

    /// Works on all pools.
    fn each(&mut self, work: impl Fn(&mut Pool) + Sync + Send) {
        self.largest(|pool| {
            work(pool);
            0
        });
    }

    /// One step of C97's MainLoop; returns the number of relaxation sweeps.
    ///
    /// # Source
    /// Curtis et al. 1997, §4.3–4.6.
    pub fn step(&mut self, task: &Task, cancel: &AtomicBool) -> Result<u32, Stop> {
        self.update_velocities(task, cancel)?;
        let sweeps = self.relax_divergence(task, cancel)?;
        let fastest = self.largest(Pool::flow_outward);
        self.fastest = Some(f32::from_bits(fastest as u32));
        let n = substeps(fastest)?;
        for substep in 1..=n {
            go_on(fastest, cancel)?;
            self.each(|pool| pool.carry(task, 1.0 / n as f32, substep == n));
        }
        if let Some(pores) = &task.pores {
            self.each(|pool| pool.simulate_capillary_flow(task, pores));
        }
        Ok(sweeps)
    }

    fn update_velocities(&mut self, task: &Task, cancel: &AtomicBool) -> Result<(), Stop> {
        // The slope cannot push any face past this; the factor covers rounding. Then one sub-step will do and the
        // exact maximum, which would need a pass of its own, is not asked for.
        let steepest = self.pools.iter().map(|place| place.pool.steepest()).fold(0.0, f32::max);
        let bound = self.fastest.map_or(f32::INFINITY, |fastest| (fastest + steepest) * (1.0 + 1e-5));
        if bound <= 1.0 {
            self.each(|pool| pool.advance(task.momentum(1.0), Some(task.slope_scale)));
            return go_on(0, cancel);
        }
        let fastest = self.largest(|pool| pool.slope(task.slope_scale));
        let n = substeps(fastest)?;
        for _ in 0..n {
            go_on(fastest, cancel)?;
            self.each(|pool| pool.advance(task.momentum(1.0 / n as f32), None));
        }
        Ok(())
    }

    fn relax_divergence(&mut self, task: &Task, cancel: &AtomicBool) -> Result<u32, Stop> {
        let mut sweeps = 0;
        loop {
            let largest = self.largest(|pool| pool.sweep(task.relax_rate));
            sweeps += 1;
            go_on(largest, cancel)?;
            if f32::from_bits(largest as u32) <= task.relax_tolerance || sweeps >= task.relax_max_sweeps {
                return Ok(sweeps);
            }
        }
    }
}

/// The state, leaving one without cells.
fn lend(state: &mut WashState) -> WashState {
    std::mem::replace(state, WashState::empty(Layout::new(0, 0), 0))
}

/// All runs, parted so that those of different parts are farther apart than `apart` cells.
fn parts(reach: &Region, canvas: Layout, apart: usize) -> Vec<Part> {
    // Tiles so large that water in tiles that do not touch cannot see each other's edge (D6); not smaller, lest a
    // sheet full of specks fall into too many parts.
    let tile = (apart + 1).max(32);
    let (columns, rows) = (canvas.width().div_ceil(tile), canvas.height().div_ceil(tile));
    const DRY: usize = usize::MAX;
    const UNKNOWN: usize = usize::MAX - 1;
    let mut part_of = vec![DRY; columns * rows];
    let runs = || {
        reach.active().flat_map(|row| {
            // Runs may be widened beyond the canvas.
            let end = |end: usize| (end - Layout::LEFT).min(canvas.width());
            reach.runs(row).iter().map(move |run| [row - Layout::TOP, run.first - Layout::LEFT, end(run.end)])
        })
    };
    for [row, first, end] in runs() {
        part_of[row / tile * columns..][first / tile..=(end - 1) / tile].fill(UNKNOWN);
    }
    let mut count = 0;
    for start in 0..part_of.len() {
        if part_of[start] != UNKNOWN {
            continue;
        }
        part_of[start] = count;
        let mut next = vec![start];
        while let Some(at) = next.pop() {
            let (column, row) = (at % columns, at / columns);
            for y in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
                for x in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                    if part_of[y * columns + x] == UNKNOWN {
                        part_of[y * columns + x] = count;
                        next.push(y * columns + x);
                    }
                }
            }
        }
        count += 1;
    }
    let nowhere = Rectangle { left: usize::MAX, top: usize::MAX, right: 0, bottom: 0 };
    let mut parts: Vec<Part> = (0..count).map(|_| Part { around: nowhere, runs: Vec::new() }).collect();
    for [row, first, end] in runs() {
        // All tiles of a run touch, so the first one knows its part.
        let part = &mut parts[part_of[row / tile * columns + first / tile]];
        part.around = part.around.around(Rectangle { left: first, top: row, right: end, bottom: row + 1 });
        part.runs.push([row, first, end]);
    }
    parts
}

/// A state of the part alone; between its runs there is nothing.
fn cut_out(canvas: &mut WashState, part: &Part) -> WashState {
    let Rectangle { left, top, right, bottom } = part.around;
    let mut state = WashState::empty(Layout::new(right - left, bottom - top), canvas.suspended.len());
    for y in top..bottom {
        state.height.cells_mut(y - top).copy_from_slice(&canvas.height.cells(y)[left..right]);
    }
    copy(canvas, part, &mut state, Direction::OutOfCanvas);
    state
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    OutOfCanvas,
    IntoCanvas,
}

/// Copies the runs of all fields but the height between a canvas and a state of a part of it.
fn copy(canvas: &mut WashState, part: &Part, state: &mut WashState, direction: Direction) {
    fn runs<T: Copy>(canvas: &mut Field<T>, part: &Part, state: &mut Field<T>, direction: Direction) {
        for &[y, first, end] in &part.runs {
            let canvas = &mut canvas.cells_mut(y)[first..end];
            let state = &mut state.cells_mut(y - part.around.top)[first - part.around.left..][..end - first];
            match direction {
                Direction::OutOfCanvas => state.copy_from_slice(canvas),
                Direction::IntoCanvas => canvas.copy_from_slice(state),
            }
        }
    }
    runs(&mut canvas.wet_mask, part, &mut state.wet_mask, direction);
    // The faces after and below the last cell are 0: they touch dry cells.
    runs(&mut canvas.u, part, &mut state.u, direction);
    runs(&mut canvas.v, part, &mut state.v, direction);
    runs(&mut canvas.pressure, part, &mut state.pressure, direction);
    runs(&mut canvas.saturation, part, &mut state.saturation, direction);
    let suspended = canvas.suspended.iter_mut().zip(&mut state.suspended);
    for (canvas, state) in suspended.chain(canvas.deposited.iter_mut().zip(&mut state.deposited)) {
        runs(canvas, part, state, direction);
    }
}
