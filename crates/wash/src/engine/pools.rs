//! Where the water is: pools of it, simulated in parallel.
//!
//! Water that stays where it is and covers little of the sheet is one pool without dry paper
//! ([`Ground`](super::ground::Ground)). Other water far apart is simulated apart: each pool has a state of its own, as small as it can be, so that a stroke on a
//! large sheet lies as close in memory as it would on a small one. Pools share only the maxima that decide on
//! sub-steps and sweeps, so they give the bits of the whole canvas. Where water covers most of the sheet there is one
//! pool, and it is the sheet.

use girtin_grid::{Field, Layout};
use rayon::prelude::*;

use super::pool::{Pool, reach};
use super::stage::Stage;
use super::world::Found;
use super::{LivingTask, Task};
use crate::band_limit::band_limited;
use crate::region::{Region, Run};
use crate::state::WashState;
use crate::tiles::ChangedTiles;
use crate::wash::Engine;

/// The pools of a wash.
#[derive(Debug)]
pub struct Pools {
    threads: usize,
    pools: Vec<Place>,
    /// Whether routines run one by one over the whole canvas, whatever is wet.
    is_reference: bool,
}

/// A pool and where it lies.
#[derive(Debug)]
struct Place {
    pool: Pool,
    lies: Lies,
}

/// What a pool has of the canvas.
#[derive(Debug)]
enum Lies {
    /// All of it, whose state is lent and not copied.
    Whole,
    /// All of it, but without dry paper.
    Packed,
    /// A rectangle.
    Part(Part),
}

/// Runs of cells that see no other water, and the rectangle around them.
#[derive(Debug)]
struct Part {
    around: Rectangle,
    /// Row, first column and end of each, on the canvas.
    runs: Vec<[usize; 3]>,
}

impl Part {
    /// Takes all cells of the rectangle.
    fn take_all(&mut self) {
        let Rectangle { left, top, right, bottom } = self.around;
        self.runs = (top..bottom).map(|y| [y, left, right]).collect();
    }
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

    fn meets(self, other: Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
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
        if task.pores.is_none() && is_worth_packing(state) {
            let pool = Pool::packed(state, task, threads);
            return Self { threads, pools: vec![Place { pool, lies: Lies::Packed }], is_reference: false };
        }
        let sight = (task.edge_kernel / 2.0) as usize;
        let mut parts = parts(&reach(state, task), canvas, sight);
        // Living water moves: it has room to, and is looked at again before it comes within sight of other water.
        let room = task.living.as_ref().map(|_| sight / 2 + 2);
        if let Some(room) = room {
            parts = with_room(parts, canvas, room + ROOM_TO_MOVE);
        }
        let wet: usize = parts.iter().flat_map(|part| &part.runs).map(|[_, first, end]| end - first).sum();
        let around: usize = parts.iter().map(|part| part.around.cells()).sum();
        let band = task.living.as_ref().map_or(0.0, |living| living.slope_band);
        // Copying to and fro pays only where the water is a small part of the canvas.
        let pools = if (2 * wet).max(around) > canvas.width() * canvas.height() {
            let slope_height = band_limited(&state.height, canvas.rows(), canvas.columns(), band);
            vec![Place { pool: Pool::new(lend(state), slope_height, task, threads), lies: Lies::Whole }]
        } else {
            let parts = parts.into_iter().map(|mut part| {
                if room.is_some() {
                    // What lies on dry paper now may be under water soon.
                    part.take_all();
                }
                let Rectangle { left, top, right, bottom } = part.around;
                let (rows, columns) =
                    (Layout::TOP + top..Layout::TOP + bottom, Layout::LEFT + left..Layout::LEFT + right);
                let slope_height = band_limited(&state.height, rows, columns, band);
                let mut pool = Pool::new(cut_out(state, &part), slope_height, task, threads);
                if let Some(room) = room {
                    // Where the canvas ends there is nothing to come close to.
                    pool.keep_within(
                        [if top == 0 { 0 } else { room }, if bottom == canvas.height() { 0 } else { room }],
                        [if left == 0 { 0 } else { room }, if right == canvas.width() { 0 } else { room }],
                    );
                }
                Place { pool, lies: Lies::Part(part) }
            });
            parts.collect()
        };
        Self { threads, pools, is_reference: false }
    }

    /// The whole canvas as one pool whose routines run one by one.
    pub fn reference(state: &mut WashState, task: &Task) -> Self {
        let band = task.living.as_ref().map_or(0.0, |living| living.slope_band);
        let canvas = state.layout();
        let slope_height = band_limited(&state.height, canvas.rows(), canvas.columns(), band);
        let place = Place { pool: Pool::reference(lend(state), slope_height, task), lies: Lies::Whole };
        Self { threads: 1, pools: vec![place], is_reference: true }
    }

    /// Whether they were made for this engine and so many threads.
    pub fn are_for(&self, engine: Engine, threads: usize) -> bool {
        self.is_reference == (engine == Engine::Reference) && self.threads == threads
    }

    /// Takes the water again after [`Pools::give_back`]; where it is wet must not have changed meanwhile.
    pub fn take(&mut self, state: &mut WashState) {
        for Place { pool, lies } in &mut self.pools {
            match lies {
                Lies::Whole => *pool.state() = lend(state),
                Lies::Packed => pool.gather(state),
                Lies::Part(part) => copy(state, part, pool.state(), Direction::OutOfCanvas),
            }
        }
    }

    /// Gives the water back to the state.
    pub fn give_back(&mut self, state: &mut WashState) {
        for Place { pool, lies } in &mut self.pools {
            match lies {
                Lies::Whole => *state = lend(pool.state()),
                Lies::Packed => pool.scatter(state),
                Lies::Part(part) if pool.is_living() => {
                    // Where there was water once, be it dry now.
                    let Rectangle { left, top, .. } = part.around;
                    let ever = pool.ever_damp().into_iter();
                    part.runs = ever.map(|[y, first, end]| [y + top, first + left, end + left]).collect();
                    copy(state, part, pool.state(), Direction::IntoCanvas);
                }
                Lies::Part(part) => copy(state, part, pool.state(), Direction::IntoCanvas),
            }
        }
    }

    /// Marks the tiles in which water is, and those in which it came since this was last done.
    pub fn mark_tiles(&mut self, changed: &mut ChangedTiles, canvas: Layout) {
        for Place { pool, lies } in &mut self.pools {
            let (left, top) = match lies {
                Lies::Part(part) => (part.around.left, part.around.top),
                Lies::Whole | Lies::Packed => (0, 0),
            };
            let columns = |run: Run| {
                // Runs may be widened beyond the canvas.
                let cells = |column: usize| (column + left).saturating_sub(Layout::LEFT).min(canvas.width());
                (cells(run.first), cells(run.end))
            };
            let [wet, damp] = pool.runs();
            for (runs, pigment) in [(wet, true), (damp, false)] {
                for (row, run) in runs {
                    let (first, end) = columns(run);
                    changed.mark(row - Layout::TOP + top, first, end, pigment);
                }
            }
            for (y, x) in pool.take_joined() {
                changed.mark(y + top, x + left, x + left + 1, true);
            }
        }
    }

    /// A bound on the slope term of every wet face.
    pub fn steepest(&self) -> f32 {
        self.pools.iter().map(|place| place.pool.steepest()).fold(0.0, f32::max)
    }

    /// Runs a pass over all pools.
    pub fn pass(&mut self, task: &Task, stages: &[Stage]) -> Found {
        if !self.is_reference {
            return self.pass_over(task, stages);
        }
        // Routine by routine.
        let routines = stages.chunk_by(|_, next| next.continues());
        routines.map(|routine| self.pass_over(task, routine)).fold(Found::default(), Found::with)
    }

    fn pass_over(&mut self, task: &Task, stages: &[Stage]) -> Found {
        self.each(|pool| {
            let found = pool.pass(task, stages);
            pool.grow(task, &found.grown_rows, found.grown.as_ref());
            found
        })
        .into_iter()
        .fold(Found::default(), Found::with)
    }

    /// Works on all pools; results are in their order.
    fn each<T: Send>(&mut self, work: impl Fn(&mut Pool) -> T + Sync + Send) -> Vec<T> {
        let pools = &mut self.pools;
        if self.threads == 1 || pools.len() == 1 {
            pools.iter_mut().map(|place| work(&mut place.pool)).collect()
        } else {
            pools.par_iter_mut().map(|place| work(&mut place.pool)).collect()
        }
    }

    /// Whether no paper is wet, if that is known without looking at all of it.
    pub fn is_dry(&self) -> Option<bool> {
        let is_wet = |place: &Place| {
            let [mut wet, _] = place.pool.runs();
            wet.next().is_some()
        };
        (!self.is_reference).then(|| !self.pools.iter().any(is_wet))
    }

    /// Whether there is any water in film or pores.
    pub fn are_damp(&self) -> bool {
        self.pools.iter().any(|place| place.pool.is_damp())
    }

    /// Takes back the guarded sweep of the last pass, and what followed it.
    pub fn take_back(&mut self) {
        self.pools.iter_mut().for_each(|place| place.pool.take_back());
    }

    /// Begins a step with so many passes over the pores.
    pub fn settle_down(&mut self, passes: usize) {
        self.pools.iter_mut().for_each(|place| place.pool.settle_down(passes));
    }

    /// Finds anew where the wet paper ends.
    pub fn renew_edges(&mut self, task: &Task) {
        self.each(|pool| pool.renew_edges(task));
    }

    /// Lets film creep over the edge.
    pub fn creep(&mut self, task: &Task, living: &LivingTask) {
        self.each(|pool| pool.creep(task, living));
    }

    /// Dries cells whose film is gone; returns the water that evaporated with it, quanta.
    pub fn dry(&mut self, task: &Task, living: &LivingTask) -> i64 {
        self.each(|pool| pool.dry(task, living)).into_iter().sum()
    }

    /// After a step: follows what became wet or dry. The pools are made anew where water has moved too far.
    pub fn look_again(&mut self, task: &Task, state: &mut WashState) {
        self.each(|pool| pool.look_again(task));
        if self.pools.iter().any(|place| place.pool.needs_room()) {
            self.give_back(state);
            *self = Self::new(state, task, self.threads);
        }
    }
}

/// Whether so little of the canvas is wet that copying to and fro pays.
fn is_worth_packing(state: &WashState) -> bool {
    let canvas = state.layout();
    let wet = (0..canvas.height()).flat_map(|y| state.wet_mask.cells(y)).filter(|wet| **wet != 0).count();
    2 * wet <= canvas.width() * canvas.height()
}

/// Cells that living water may move before its pool is made anew.
const ROOM_TO_MOVE: usize = 16;

/// Parts with so many cells around them; those that come to lie over each other are one.
fn with_room(parts: Vec<Part>, canvas: Layout, room: usize) -> Vec<Part> {
    let mut apart: Vec<Part> = Vec::new();
    for mut part in parts {
        let Rectangle { left, top, right, bottom } = part.around;
        part.around = Rectangle {
            left: left.saturating_sub(room),
            top: top.saturating_sub(room),
            right: (right + room).min(canvas.width()),
            bottom: (bottom + room).min(canvas.height()),
        };
        // A part that grew around one may now touch another.
        while let Some(at) = apart.iter().position(|other| other.around.meets(part.around)) {
            let other = apart.swap_remove(at);
            part.around = part.around.around(other.around);
            part.runs.extend(other.runs);
        }
        apart.push(part);
    }
    apart
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
