//! Rows that a band keeps for its stages while a pass goes down.

use super::rows::Rows;
use crate::move_film::ShareRows;
use crate::region::{Region, Run};

/// No row has this number.
const NONE: usize = usize::MAX;
/// Cells beside a run that are kept too.
const BESIDE: usize = 2;

/// A copy of the runs of one row and of the cells beside them, 0 elsewhere.
#[derive(Debug)]
pub struct Slot {
    pub values: Vec<f32>,
    row: usize,
    runs: Vec<Run>,
}

impl Slot {
    fn new(stride: usize) -> Self {
        Self { values: vec![0.0; stride], row: NONE, runs: Vec::new() }
    }

    fn take(&mut self, runs: &[Run], row: usize, from: &[f32]) {
        if self.runs != runs {
            for run in &self.runs {
                self.values[run.first - BESIDE..run.end + BESIDE].fill(0.0);
            }
            self.runs.clear();
            self.runs.extend_from_slice(runs);
        }
        for run in runs {
            let columns = run.first - BESIDE..run.end + BESIDE;
            self.values[columns.clone()].copy_from_slice(&from[columns]);
        }
        self.row = row;
    }
}

/// A row before it is changed, and the one above before it was.
#[derive(Debug)]
pub struct Ring {
    pub above: Slot,
    pub here: Slot,
}

impl Ring {
    fn new(stride: usize) -> Self {
        Self { above: Slot::new(stride), here: Slot::new(stride) }
    }

    /// Forgets what it holds: a new pass begins.
    fn begin(&mut self) {
        self.above.row = NONE;
        self.here.row = NONE;
    }

    /// Keeps the row before it is changed; the one above, if this ring has not seen it, was not changed.
    pub fn take(&mut self, region: &Region, row: usize, field: &Rows<'_, f32>) {
        std::mem::swap(&mut self.above, &mut self.here);
        if self.above.row != row - 1 {
            self.above.take(region.runs(row - 1), row - 1, field.row(row - 1));
        }
        self.here.take(region.runs(row), row, field.row(row));
    }
}

/// What [`Stage::Advance`](super::stage::Stage::Advance) keeps.
#[derive(Debug)]
pub struct AdvanceScratch {
    pub u: Ring,
    pub v: Ring,
    pub corner: Vec<f32>,
    pub corner_below: Vec<f32>,
    /// The row whose upper corners `corner` holds.
    pub corner_row: usize,
}

/// What a relaxation sweep keeps: corrections of a row and of the one above.
#[derive(Debug)]
pub struct SweepScratch {
    pub delta: Vec<f32>,
    pub delta_above: Vec<f32>,
    /// The row of `delta_above`.
    pub above: usize,
}

/// The last few rows of something, by row number.
#[derive(Debug)]
pub struct Recent {
    rows: Vec<Vec<f32>>,
}

impl Recent {
    /// Holds `count` rows, a power of two.
    fn new(stride: usize, count: usize) -> Self {
        Self { rows: vec![vec![0.0; stride]; count.next_power_of_two()] }
    }

    /// A row that was made lately.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.rows[row & (self.rows.len() - 1)]
    }

    /// A row to make.
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        let last = self.rows.len() - 1;
        &mut self.rows[row & last]
    }
}

/// What the solution of a relaxation keeps.
#[derive(Debug, Default)]
pub struct SolveScratch {
    pub divergence: Option<Recent>,
    /// q after each iteration, the first guess first.
    pub q: Vec<Recent>,
}

/// What the film's move keeps: shares after each widening.
#[derive(Debug)]
pub struct ShareScratch {
    pub share: Recent,
    /// Whether any share of a row is below 1; if none is, the row is not written.
    pub is_short: [bool; 4],
}

impl ShareScratch {
    /// Shares of a row and its neighbours.
    pub fn around<'a>(&'a self, row: usize, ones: &'a [f32]) -> ShareRows<'a> {
        let of = |row: usize| if self.is_short[row & 3] { self.share.row(row) } else { ones };
        ShareRows { above: of(row - 1), here: of(row), below: of(row + 1) }
    }
}

/// What a pass over the pores keeps.
#[derive(Debug)]
pub struct PoreScratch {
    pub ring: Ring,
    /// How full the last rows were.
    pub fill: Recent,
    /// The row up to which that is known.
    pub fill_row: usize,
}

/// What the packed transport of a pigment keeps.
#[derive(Debug)]
pub struct CarryScratch {
    pub ring: Ring,
    pub across: Vec<f32>,
    pub above: Vec<f32>,
    pub below: Vec<f32>,
    /// The row whose upper faces `above` holds.
    pub above_row: usize,
}

/// Rows of u, v and pressure as they were.
#[derive(Debug, Default)]
pub struct Saved {
    /// Numbers of the rows.
    pub rows: Vec<usize>,
    /// The three rows of each, one after the other.
    pub values: Vec<f32>,
}

impl Saved {
    /// Keeps a row.
    pub fn save(&mut self, row: usize, fields: [&Rows<'_, f32>; 3]) {
        self.rows.push(row);
        for field in fields {
            self.values.extend_from_slice(field.row(row));
        }
    }
}

/// Scratch of one band.
#[derive(Debug)]
pub struct Scratch {
    stride: usize,
    pub advance: AdvanceScratch,
    pub sweeps: [SweepScratch; 2],
    /// Rows before a sweep that may have to be taken back.
    pub saved: Saved,
    /// A ring per pigment.
    pub suspended: Vec<Ring>,
    /// One per pass over the pores.
    pub pores: Vec<PoreScratch>,
    pub solve: SolveScratch,
    /// One for the first shares and one for each widening.
    pub shares: Vec<ShareScratch>,
    /// Packed transport of each pigment.
    pub carry: Vec<CarryScratch>,
    /// Mixing of each pigment by itself.
    pub mix: Vec<CarryScratch>,
    /// Room in each cell for more pigment.
    pub room: Recent,
    /// The row up to which `room` is known.
    pub room_row: usize,
    /// Fractions of pigment that settle.
    pub fraction: Vec<f32>,
    /// Water between coarse rows, and between their cells.
    pub refined: [Vec<f32>; 2],
    /// A row of zeros.
    pub zeros: Vec<f32>,
    /// A row of ones.
    pub ones: Vec<f32>,
}

impl Scratch {
    pub fn new(stride: usize, pigments: usize) -> Self {
        let row = || vec![0.0; stride];
        let sweep = || SweepScratch { delta: row(), delta_above: row(), above: NONE };
        Self {
            stride,
            advance: AdvanceScratch {
                u: Ring::new(stride),
                v: Ring::new(stride),
                corner: row(),
                corner_below: row(),
                corner_row: NONE,
            },
            sweeps: [sweep(), sweep()],
            saved: Saved::default(),
            suspended: (0..pigments).map(|_| Ring::new(stride)).collect(),
            pores: Vec::new(),
            solve: SolveScratch::default(),
            shares: Vec::new(),
            carry: Vec::new(),
            mix: Vec::new(),
            room: Recent::new(stride, 4),
            room_row: NONE,
            fraction: row(),
            refined: [row(), row()],
            zeros: row(),
            ones: vec![1.0; stride],
        }
    }

    /// A new pass begins: rows kept from the last one are out of date.
    pub fn begin(&mut self) {
        self.advance.u.begin();
        self.advance.v.begin();
        self.advance.corner_row = NONE;
        self.sweeps.iter_mut().for_each(|sweep| sweep.above = NONE);
        self.suspended.iter_mut().for_each(Ring::begin);
        for pores in &mut self.pores {
            pores.ring.begin();
            pores.fill_row = NONE;
        }
        self.saved.rows.clear();
        self.saved.values.clear();
        self.room_row = NONE;
        for carry in self.carry.iter_mut().chain(&mut self.mix) {
            carry.ring.begin();
            carry.above_row = NONE;
        }
    }

    /// Makes room for a solution of so many iterations and for so many widenings of shares.
    pub fn make_room(&mut self, iterations: usize, widenings: usize) {
        if iterations > 0 {
            let SolveScratch { divergence, q } = &mut self.solve;
            // The divergence of a row is asked for until the last iteration has passed it.
            let lag = iterations + 2;
            if divergence.as_ref().is_none_or(|divergence| divergence.rows.len() < lag) {
                *divergence = Some(Recent::new(self.stride, lag));
            }
            while q.len() <= iterations {
                q.push(Recent::new(self.stride, 4));
            }
        }
        while self.shares.len() <= widenings {
            self.shares.push(ShareScratch { share: Recent::new(self.stride, 4), is_short: [true; 4] });
        }
    }

    /// Packed transport of so many pigments.
    pub fn carry(&mut self, pigments: usize) {
        for carry in [&mut self.carry, &mut self.mix] {
            while carry.len() < pigments {
                let row = || vec![0.0; self.stride];
                carry.push(CarryScratch {
                    ring: Ring::new(self.stride),
                    across: row(),
                    above: row(),
                    below: row(),
                    above_row: NONE,
                });
            }
        }
    }

    /// What a pass over the pores keeps.
    pub fn pores(&mut self, slot: usize) -> &mut PoreScratch {
        while self.pores.len() <= slot {
            let fill = Recent::new(self.stride, 4);
            self.pores.push(PoreScratch { ring: Ring::new(self.stride), fill, fill_row: NONE });
        }
        &mut self.pores[slot]
    }
}
