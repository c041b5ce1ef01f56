//! Rows that a band keeps for its stages while a pass goes down.

use super::rows::Rows;
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

/// Scratch of one band.
#[derive(Debug)]
pub struct Scratch {
    stride: usize,
    pub advance: AdvanceScratch,
    pub sweeps: [SweepScratch; 2],
    /// A ring per pigment.
    pub suspended: Vec<Ring>,
    /// A ring per pass over the pores.
    pub pores: Vec<Ring>,
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
            suspended: (0..pigments).map(|_| Ring::new(stride)).collect(),
            pores: Vec::new(),
        }
    }

    /// A new pass begins: rows kept from the last one are out of date.
    pub fn begin(&mut self) {
        self.advance.u.begin();
        self.advance.v.begin();
        self.advance.corner_row = NONE;
        self.sweeps.iter_mut().for_each(|sweep| sweep.above = NONE);
        self.suspended.iter_mut().chain(&mut self.pores).for_each(Ring::begin);
    }

    /// The ring of a pass over the pores.
    pub fn pores(&mut self, slot: usize) -> &mut Ring {
        while self.pores.len() <= slot {
            self.pores.push(Ring::new(self.stride));
        }
        &mut self.pores[slot]
    }
}
