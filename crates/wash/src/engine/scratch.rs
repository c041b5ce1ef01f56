//! Rows that a band keeps for its stages while a pass goes down.

use std::ops::Range;

use girtin_grid::Aligned;

use super::ground::{BEFORE, Ground};
use super::pipeline::ROWS_AT_ONCE;
use super::rows::Rows;
use crate::carry_packed::FluxRows;
use crate::move_film::ShareRows;
use crate::region::{Region, Run};

/// Rows that are kept between a stage and the next two: those that it does at once, and what is still read behind them.
const ROWS_BETWEEN: usize = (ROWS_AT_ONCE + 3).next_power_of_two();

/// No row has this number.
const NONE: usize = usize::MAX;

/// A copy of one row: of all of it where rows are packed, else of its runs and of [`BEFORE`] cells on both sides of them, with
/// 0 elsewhere.
#[derive(Debug)]
pub struct Slot {
    pub values: Aligned<f32>,
    row: usize,
    runs: Vec<Run>,
}

impl Slot {
    fn new(stride: usize) -> Self {
        Self { values: Aligned::zeroed(stride), row: NONE, runs: Vec::new() }
    }

    fn take(&mut self, region: &Region, ground: &Ground, row: usize, field: &Rows<'_, f32>) {
        self.row = row;
        if ground.is_packed() {
            // One long copy is faster than some short ones.
            let cells = field.row(row);
            return self.values[..cells.len()].copy_from_slice(cells);
        }
        let (cells, runs) = (field.row(row), region.runs(row));
        if self.runs != runs {
            for run in &self.runs {
                self.values[run.first - BEFORE..run.end + BEFORE].fill(0.0);
            }
            self.runs.clear();
            self.runs.extend_from_slice(runs);
        }
        for run in runs {
            let columns = run.first - BEFORE..run.end + BEFORE;
            self.values[columns.clone()].copy_from_slice(&cells[columns]);
        }
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
    pub fn take(&mut self, region: &Region, ground: &Ground, row: usize, field: &Rows<'_, f32>) {
        std::mem::swap(&mut self.above, &mut self.here);
        if self.above.row != row - 1 {
            self.above.take(region, ground, row - 1, field);
        }
        self.here.take(region, ground, row, field);
    }
}

/// What [`Stage::Advance`](super::stage::Stage::Advance) keeps.
#[derive(Debug)]
pub struct AdvanceScratch {
    pub u: Ring,
    pub v: Ring,
    pub corner: Aligned<f32>,
    pub corner_below: Aligned<f32>,
    /// The row whose upper corners `corner` holds.
    pub corner_row: usize,
}

/// What a relaxation sweep keeps: corrections of a row and of the one above.
#[derive(Debug)]
pub struct SweepScratch {
    pub delta: Aligned<f32>,
    pub delta_above: Aligned<f32>,
    /// The row of `delta_above`.
    pub above: usize,
}

/// The last few rows of something, by row number.
#[derive(Debug)]
pub struct Recent {
    rows: Vec<Aligned<f32>>,
}

impl Recent {
    /// Holds `count` rows, a power of two.
    fn new(stride: usize, count: usize) -> Self {
        Self { rows: vec![Aligned::zeroed(stride); count.next_power_of_two()] }
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
    is_short: [bool; ROWS_BETWEEN],
}

impl ShareScratch {
    /// Whether any share of a row that was found lately is below 1.
    pub fn is_short(&self, row: usize) -> bool {
        self.is_short[row % ROWS_BETWEEN]
    }

    /// Notes whether any is.
    pub fn note_short(&mut self, row: usize, is_short: bool) {
        self.is_short[row % ROWS_BETWEEN] = is_short;
    }

    /// Shares of a row and its neighbours.
    pub fn around<'a>(&'a self, row: usize, ones: &'a [f32]) -> ShareRows<'a> {
        let of = |row: usize| if self.is_short(row) { self.share.row(row) } else { ones };
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
    /// Fluxes through the faces between the cells of a row, and above it.
    pub across: Aligned<f32>,
    pub above: Aligned<f32>,
    /// Slopes within the cells along the row, and down the sheet within those of the row and, where its runs are others,
    /// of the one below.
    pub slopes_across: Aligned<f32>,
    pub slopes: Aligned<f32>,
    pub slopes_below: Aligned<f32>,
}

/// What the mixing of a pigment by itself keeps.
#[derive(Debug)]
pub struct MixScratch {
    pub across: Aligned<f32>,
    pub above: Aligned<f32>,
    pub below: Aligned<f32>,
    /// The row whose upper faces `above` holds.
    pub above_row: usize,
}

/// What a row of faces does to any pigment.
#[derive(Debug)]
pub struct FluxScratch {
    way: Aligned<f32>,
    lever: Aligned<f32>,
    mixing: Aligned<f32>,
}

impl FluxScratch {
    fn new(stride: usize) -> Self {
        let row = || Aligned::zeroed(stride);
        Self { way: row(), lever: row(), mixing: row() }
    }

    /// That of some faces.
    pub fn of(&self, faces: Range<usize>) -> FluxRows<'_> {
        FluxRows {
            way: &self.way[faces.clone()],
            lever: &self.lever[faces.clone()],
            mixing: &self.mixing[faces],
        }
    }

    /// Closes two faces.
    pub fn close(&mut self, faces: [usize; 2]) {
        for face in faces {
            (self.way[face], self.mixing[face]) = (0.0, 0.0);
        }
    }

    /// That of some faces, to be found.
    pub fn of_mut(&mut self, faces: Range<usize>) -> [&mut [f32]; 3] {
        [&mut self.way, &mut self.lever, &mut self.mixing].map(|row| &mut row[faces.clone()])
    }
}

/// Rows of u, v and pressure as they were.
#[derive(Debug, Default)]
pub struct Saved {
    /// Where the rows lie.
    pub places: Vec<Range<usize>>,
    /// The three fields of each, one after the other.
    pub values: Vec<f32>,
}

impl Saved {
    /// Keeps a row.
    pub fn save(&mut self, place: Range<usize>, fields: [&Rows<'_, f32>; 3]) {
        for field in fields {
            self.values.extend_from_slice(field.at(place.start, place.len()));
        }
        self.places.push(place);
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
    /// What faces do to all of them: those between the cells of a row, above and below it.
    pub flux: [FluxScratch; 3],
    /// Mixing of each pigment by itself.
    pub mix: Vec<MixScratch>,
    /// Room in each cell for more pigment.
    pub room: Recent,
    /// The row up to which `room` is known.
    pub room_row: usize,
    /// Fractions of pigment that settle.
    pub fraction: Aligned<f32>,
    /// Water between coarse rows, and between their cells.
    pub refined: [Aligned<f32>; 2],
    /// A row of zeros.
    pub zeros: Aligned<f32>,
    /// A row of ones.
    pub ones: Vec<f32>,
}

impl Scratch {
    pub fn new(stride: usize, pigments: usize) -> Self {
        let row = || Aligned::zeroed(stride);
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
            flux: [(); 3].map(|()| FluxScratch::new(stride)),
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
        self.saved.places.clear();
        self.saved.values.clear();
        self.room_row = NONE;
        self.mix.iter_mut().for_each(|mix| mix.above_row = NONE);
    }

    /// Makes room for a solution of so many iterations and for so many widenings of shares.
    pub fn make_room(&mut self, iterations: usize, widenings: usize) {
        if iterations > 0 {
            let SolveScratch { divergence, q } = &mut self.solve;
            // The divergence of a row is asked for until the last iteration has passed it.
            let lag = iterations + 1 + ROWS_AT_ONCE;
            if divergence.as_ref().is_none_or(|divergence| divergence.rows.len() < lag) {
                *divergence = Some(Recent::new(self.stride, lag));
            }
            while q.len() <= iterations {
                q.push(Recent::new(self.stride, ROWS_BETWEEN));
            }
        }
        while self.shares.len() <= widenings {
            let share = Recent::new(self.stride, ROWS_BETWEEN);
            self.shares.push(ShareScratch { share, is_short: [true; ROWS_BETWEEN] });
        }
    }

    /// Packed transport of so many pigments.
    pub fn carry(&mut self, pigments: usize) {
        let row = || Aligned::zeroed(self.stride);
        self.carry.resize_with(pigments.max(self.carry.len()), || CarryScratch {
            across: row(),
            above: row(),
            slopes_across: row(),
            slopes: row(),
            slopes_below: row(),
        });
    }

    /// Mixing of so many pigments.
    pub fn mix(&mut self, pigments: usize) {
        let row = || Aligned::zeroed(self.stride);
        self.mix.resize_with(pigments.max(self.mix.len()), || MixScratch {
            across: row(),
            above: row(),
            below: row(),
            above_row: NONE,
        });
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
