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
    /// Columns and rows of the canvas, or `None` for the whole canvas, whose state is then lent and not copied.
    part: Option<Rectangle>,
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

    fn overlaps(self, other: Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }
}

impl Fast {
    /// Finds the pools of a state, and takes their water: the state has it back after [`Fast::give_back`].
    pub fn new(state: &mut WashState, task: &Task, threads: usize) -> Self {
        let canvas = state.layout();
        let parts = parts(&reach(state, task), canvas, task.edge_kernel as usize / 2);
        let cells: usize = parts.iter().map(|part| part.cells()).sum();
        let place = |part: Option<Rectangle>, state| Place { pool: Pool::new(state, task, threads), part };
        // Copying to and fro pays only where the water is a small part of the canvas.
        let pools = if 2 * cells > canvas.width() * canvas.height() {
            vec![place(None, lend(state))]
        } else {
            parts.into_iter().map(|part| place(Some(part), cut_out(state, part))).collect()
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
                Some(part) => copy(state, *part, pool.state(), Direction::OutOfCanvas),
            }
        }
    }

    /// Gives the water back to the state.
    pub fn give_back(&mut self, state: &mut WashState) {
        for Place { pool, part } in &mut self.pools {
            match part {
                None => *state = lend(pool.state()),
                Some(part) => copy(state, *part, pool.state(), Direction::IntoCanvas),
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
            self.largest(|pool| {
                pool.carry(task, 1.0 / n as f32, substep == n);
                0
            });
        }
        if let Some(pores) = &task.pores {
            self.largest(|pool| {
                pool.simulate_capillary_flow(task, pores);
                0
            });
        }
        Ok(sweeps)
    }

    fn update_velocities(&mut self, task: &Task, cancel: &AtomicBool) -> Result<(), Stop> {
        // The slope cannot push any face past this; the factor covers rounding. Then one sub-step will do and the
        // exact maximum, which would need a pass of its own, is not asked for.
        let steepest = self.pools.iter().map(|place| place.pool.steepest()).fold(0.0, f32::max);
        let bound = self.fastest.map_or(f32::INFINITY, |fastest| (fastest + steepest) * (1.0 + 1e-5));
        if bound <= 1.0 {
            self.largest(|pool| {
                pool.advance(task.momentum(1.0), Some(task.slope_scale));
                0
            });
            return go_on(0, cancel);
        }
        let fastest = self.largest(|pool| pool.slope(task.slope_scale));
        let n = substeps(fastest)?;
        for _ in 0..n {
            go_on(fastest, cancel)?;
            self.largest(|pool| {
                pool.advance(task.momentum(1.0 / n as f32), None);
                0
            });
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

/// Disjoint rectangles that hold all runs, those of different rectangles farther apart than `apart` cells.
fn parts(reach: &Region, canvas: Layout, apart: usize) -> Vec<Rectangle> {
    // Tiles so large that water in tiles that do not touch cannot see each other's edge (D6).
    let tile = (apart + 1).max(64);
    let (columns, rows) = (canvas.width().div_ceil(tile), canvas.height().div_ceil(tile));
    let mut boxes: Vec<Option<Rectangle>> = vec![None; columns * rows];
    for row in reach.active() {
        let y = row - Layout::TOP;
        for run in reach.runs(row) {
            let (left, right) = (run.first - Layout::LEFT, (run.end - Layout::LEFT).min(canvas.width()));
            for column in left / tile..=(right - 1) / tile {
                let piece = Rectangle {
                    left: left.max(column * tile),
                    top: y,
                    right: right.min((column + 1) * tile),
                    bottom: y + 1,
                };
                let slot = &mut boxes[y / tile * columns + column];
                *slot = Some(slot.map_or(piece, |known| known.around(piece)));
            }
        }
    }
    let mut parts: Vec<Rectangle> = Vec::new();
    for start in 0..boxes.len() {
        let Some(mut part) = boxes[start].take() else { continue };
        let mut next = vec![start];
        while let Some(at) = next.pop() {
            let (column, row) = (at % columns, at / columns);
            for y in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
                for x in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                    if let Some(piece) = boxes[y * columns + x].take() {
                        part = part.around(piece);
                        next.push(y * columns + x);
                    }
                }
            }
        }
        // A part that reaches around another takes it in; then it may reach around yet another.
        while let Some(other) = parts.iter().position(|other| other.overlaps(part)) {
            part = part.around(parts.swap_remove(other));
        }
        parts.push(part);
    }
    parts
}

/// A state of the part alone.
fn cut_out(canvas: &mut WashState, part: Rectangle) -> WashState {
    let layout = Layout::new(part.right - part.left, part.bottom - part.top);
    let mut state = WashState::empty(layout, canvas.suspended.len());
    for y in 0..layout.height() {
        state.height.cells_mut(y).copy_from_slice(&canvas.height.cells(part.top + y)[part.left..part.right]);
    }
    copy(canvas, part, &mut state, Direction::OutOfCanvas);
    state
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    OutOfCanvas,
    IntoCanvas,
}

/// Copies all fields but the height between a canvas and a state of a part of it.
fn copy(canvas: &mut WashState, part: Rectangle, state: &mut WashState, direction: Direction) {
    let (width, height) = (part.right - part.left, part.bottom - part.top);
    fn rows<T: Copy>(
        (canvas, part): (&mut Field<T>, Rectangle),
        state: &mut Field<T>,
        (width, height): (usize, usize),
        direction: Direction,
    ) {
        for y in 0..height {
            let canvas = &mut canvas.row_mut(Layout::TOP + part.top + y)[Layout::LEFT + part.left..][..width];
            let state = &mut state.row_mut(Layout::TOP + y)[Layout::LEFT..][..width];
            match direction {
                Direction::OutOfCanvas => state.copy_from_slice(canvas),
                Direction::IntoCanvas => canvas.copy_from_slice(state),
            }
        }
    }
    rows((&mut canvas.wet_mask, part), &mut state.wet_mask, (width, height), direction);
    // The faces at the part's rim are 0: they touch dry cells.
    rows((&mut canvas.u, part), &mut state.u, (width, height), direction);
    rows((&mut canvas.v, part), &mut state.v, (width, height), direction);
    rows((&mut canvas.pressure, part), &mut state.pressure, (width, height), direction);
    rows((&mut canvas.saturation, part), &mut state.saturation, (width, height), direction);
    let suspended = canvas.suspended.iter_mut().zip(&mut state.suspended);
    for (canvas, state) in suspended.chain(canvas.deposited.iter_mut().zip(&mut state.deposited)) {
        rows((canvas, part), state, (width, height), direction);
    }
}
