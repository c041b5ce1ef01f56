//! Where the water is: pools of it, simulated in parallel.
//!
//! Water far apart is simulated apart: each pool has a state of its own, as small as it can be, so that a stroke on a
//! large sheet lies as close in memory as it would on a small one. Pools share only the maxima that decide on
//! sub-steps and sweeps, so they give the bits of the whole canvas. Where water covers most of the sheet there is one
//! pool, and it is the sheet.

use girtin_grid::{Field, Layout};
use rayon::prelude::*;

use super::Task;
use super::pool::{Pool, reach};
use super::stage::Stage;
use super::world::Found;
use crate::region::Region;
use crate::state::WashState;
use crate::wash::Engine;

/// The pools of a wash.
#[derive(Debug)]
pub struct Pools {
    threads: usize,
    pools: Vec<Place>,
    /// Whether routines run one by one over the whole canvas, whatever is wet.
    is_plain: bool,
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

impl Pools {
    /// Finds the pools of a state, and takes their water: the state has it back after [`Pools::give_back`].
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
        Self { threads, pools, is_plain: false }
    }

    /// The whole canvas as one pool whose routines run one by one.
    pub fn plain(state: &mut WashState, task: &Task) -> Self {
        let place = Place { pool: Pool::plain(lend(state), task), part: None };
        Self { threads: 1, pools: vec![place], is_plain: true }
    }

    /// Whether they were made for this engine and so many threads.
    pub fn are_for(&self, engine: Engine, threads: usize) -> bool {
        self.is_plain == (engine == Engine::Reference) && self.threads == threads
    }

    /// Takes the water again after [`Pools::give_back`]; where it is wet must not have changed meanwhile.
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

    /// A bound on the slope term of every wet face.
    pub fn steepest(&self) -> f32 {
        self.pools.iter().map(|place| place.pool.steepest()).fold(0.0, f32::max)
    }

    /// Runs a pass over all pools.
    pub fn pass(&mut self, task: &Task, stages: &[Stage]) -> Found {
        if self.is_plain {
            // Routine by routine.
            let routines = stages.chunks(1).map(|routine| self.pass_over(task, routine));
            return routines.collect::<Vec<_>>().into_iter().fold(Found::default(), Found::with);
        }
        self.pass_over(task, stages)
    }

    fn pass_over(&mut self, task: &Task, stages: &[Stage]) -> Found {
        let pass = |place: &mut Place| {
            let found = place.pool.pass(task, stages);
            place.pool.grow(task, &found.grown);
            found
        };
        if self.threads == 1 || self.pools.len() == 1 {
            self.pools.iter_mut().map(pass).fold(Found::default(), Found::with)
        } else {
            self.pools.par_iter_mut().map(pass).reduce(Found::default, Found::with)
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
