//! What one band sees of a pool while a pass goes down its rows.

use std::ops::{BitOr, Range};

use girtin_grid::Field;

use super::facts::RowFacts;
use super::ground::Ground;
use super::rows::Rows;
use super::scratch::Scratch;
use super::stage::Stage;
use super::stages::refine::CoarseWater;
use super::{LivingTask, Task};
use crate::flow_outward::Outflow;
use crate::look_ahead::look_ahead;
use crate::region::{Region, Run};

/// Which fields a pass changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Changes(u16);

impl Changes {
    pub const NOTHING: Self = Self(0);
    pub const MASK: Self = Self(1);
    pub const FLOW: Self = Self(2);
    pub const PRESSURE: Self = Self(4);
    pub const SATURATION: Self = Self(8);
    pub const SUSPENDED: Self = Self(16);
    pub const DEPOSITED: Self = Self(32);
    pub const MOBILITY: Self = Self(64);
    pub const KEEP: Self = Self(128);
    pub const COVER: Self = Self(256);

    pub fn contain(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl BitOr for Changes {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// A rectangle of field rows and columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub rows: Range<usize>,
    pub columns: Range<usize>,
}

impl Place {
    fn around(self, other: Self) -> Self {
        let join = |a: Range<usize>, b: Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self { rows: join(self.rows, other.rows), columns: join(self.columns, other.columns) }
    }

    /// Widens `known` by one run of a row.
    pub fn note(known: &mut Option<Self>, row: usize, run: Run) {
        let place = Self { rows: row..row + 1, columns: run.first..run.end };
        *known = Some(match known.take() {
            Some(known) => known.around(place),
            None => place,
        });
    }
}

/// What the stages of a pass noted; nothing of it depends on an order.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Bits of the largest speed after the slope.
    pub speed: i32,
    /// Bits of the largest speed as far as film can drive it in the step.
    pub drive: i32,
    /// Bits of the largest speed after a sub-step.
    pub advanced: i32,
    /// Bits of the largest correction of each of a pass's sweeps.
    pub corrections: [i32; 2],
    /// Bits of the largest correction of the sweep to come.
    pub next_correction: i32,
    /// Bits of the largest sum of outflow speeds of a cell.
    pub outflow: i32,
    /// Bits of the thinnest film.
    pub thinnest: i32,
    /// Film that evaporated, quanta.
    pub evaporated: i64,
    /// Saturation that evaporated, quanta.
    pub pores_evaporated: i64,
    /// Where cells became wet.
    pub grown: Option<Place>,
    /// Rows in which cells became wet.
    pub grown_rows: Vec<usize>,
    /// Where the cover changed.
    pub uncovered: Option<Place>,
}

impl Default for Found {
    fn default() -> Self {
        Self {
            speed: 0,
            drive: 0,
            advanced: 0,
            corrections: [0; 2],
            next_correction: 0,
            outflow: 0,
            thinnest: i32::MAX,
            evaporated: 0,
            pores_evaporated: 0,
            grown: None,
            grown_rows: Vec::new(),
            uncovered: None,
        }
    }
}

impl Found {
    pub fn with(mut self, other: Self) -> Self {
        let join = |a: Option<Place>, b: Option<Place>| match (a, b) {
            (Some(a), Some(b)) => Some(a.around(b)),
            (a, b) => a.or(b),
        };
        self.grown_rows.extend(other.grown_rows);
        Self {
            speed: self.speed.max(other.speed),
            drive: self.drive.max(other.drive),
            advanced: self.advanced.max(other.advanced),
            corrections: [0, 1].map(|i| self.corrections[i].max(other.corrections[i])),
            next_correction: self.next_correction.max(other.next_correction),
            outflow: self.outflow.max(other.outflow),
            thinnest: self.thinnest.min(other.thinnest),
            evaporated: self.evaporated + other.evaporated,
            pores_evaporated: self.pores_evaporated + other.pores_evaporated,
            grown: join(self.grown, other.grown),
            grown_rows: self.grown_rows,
            uncovered: join(self.uncovered, other.uncovered),
        }
    }
}

/// A band's view of all fields.
#[derive(Debug)]
pub struct World<'a> {
    pub task: &'a Task,
    /// Rows that the band owns.
    pub own: Range<usize>,
    /// Rows outside have nothing to do.
    pub active: Range<usize>,
    pub ground: &'a Ground,
    pub wet: &'a Region,
    pub damp: &'a Region,
    pub outflow: &'a Outflow,
    pub height: &'a Field<f32>,
    /// The height that the slope term sees.
    pub slope_height: &'a Field<f32>,
    pub mask: Rows<'a, u8>,
    pub u: Rows<'a, f32>,
    pub v: Rows<'a, f32>,
    pub pressure: Rows<'a, f32>,
    pub saturation: Rows<'a, f32>,
    pub suspended: Vec<Rows<'a, f32>>,
    pub deposited: Vec<Rows<'a, f32>>,
    /// Fields of the living wash besides.
    pub living: Option<LivingRows<'a>>,
    /// What pigment finer than its water sees of it.
    pub water: Option<&'a CoarseWater>,
    pub scratch: &'a mut Scratch,
    pub found: Found,
}

/// What the living wash keeps of each cell and face in a step.
#[derive(Debug)]
pub struct LivingRows<'a> {
    pub task: &'a LivingTask,
    pub mobility_u: Rows<'a, f32>,
    pub mobility_v: Rows<'a, f32>,
    /// What faces keep in a sub-step, if a step has several; else they keep their mobility.
    pub keep: Option<[Rows<'a, f32>; 2]>,
    pub cover: Rows<'a, f32>,
    pub facts: &'a RowFacts,
}

impl<'a> World<'a> {
    /// The runs of wet cells of a row.
    pub fn wet_runs(&self, row: usize) -> &'a [Run] {
        let wet: &'a Region = self.wet;
        wet.runs(row)
    }

    /// The runs of damp cells of a row.
    pub fn damp_runs(&self, row: usize) -> &'a [Run] {
        let damp: &'a Region = self.damp;
        damp.runs(row)
    }

    /// How many amounts of pigment such stages had better ask for ahead of time: in water and on paper.
    ///
    /// Other fields are few and read by several stages; asking for them gains nothing.
    pub fn amounts_ahead(&self, stages: &[Stage]) -> usize {
        let carries = stages.iter().any(|stage| matches!(stage, Stage::CarryPacked(_)));
        if carries { self.suspended.len() + self.deposited.len() } else { 0 }
    }

    /// Asks for a row of one of these amounts, where it is wet and the band's own.
    pub fn look_ahead(&self, amount: usize, row: usize) {
        let Some(amounts) = self.suspended.iter().chain(&self.deposited).nth(amount) else { return };
        if self.own.contains(&row) {
            let amounts = amounts.row(row);
            self.wet.runs(row).iter().for_each(|run| look_ahead(&amounts[run.first..run.end]));
        }
    }

    /// Does a stage's work on a row.
    pub fn work(&mut self, stage: Stage, row: usize) {
        match stage {
            Stage::AddSlope => self.add_slope(row),
            Stage::AddSlopeAlone => self.add_slope_alone(row),
            Stage::Advance(dt) => self.advance(row, dt, true),
            Stage::AdvanceAlone(dt) => self.advance(row, dt, false),
            Stage::FindCorrection => self.find_correction(row),
            Stage::Sweep(slot) => self.sweep(row, slot),
            Stage::GuardedSweep => self.guarded_sweep(row),
            Stage::FlowOutward => self.flow_outward(row),
            Stage::Carry(dt) => self.carry(row, dt),
            Stage::CarryAndTransfer(dt) => self.carry_and_transfer(row, dt),
            Stage::Transfer => self.transfer(row),
            Stage::Absorb => self.absorb(row),
            Stage::Diffuse(slot) => self.diffuse(row, slot),
            Stage::Spread => self.spread(row),
            Stage::Cover => self.cover(row),
            Stage::Mobility => self.mobility(row),
            Stage::Keep(dt) => self.keep(row, dt),
            Stage::BeginSolve { start } => self.begin_solve(row, start),
            Stage::Iterate { number, iteration, stiffness } => {
                self.iterate(row, number, iteration, stiffness)
            }
            Stage::Project { iterations, stiffness } => self.project(row, iterations, stiffness),
            Stage::Share(compressibility) => self.share(row, compressibility),
            Stage::WidenShare(number, compressibility) => self.widen_share(row, number, compressibility),
            Stage::MoveFilm(widenings, compressibility) => self.move_film(row, widenings, compressibility),
            Stage::Evaporate => self.evaporate(row),
            Stage::CarryPacked(dt) => self.carry_packed(row, dt),
            Stage::Settle => self.settle(row),
            Stage::EvaporatePores => self.evaporate_pores(row),
            Stage::AbsorbFilm => self.absorb_film(row),
            Stage::RefineFilm => self.refine_film(row),
            Stage::RefineFlow => self.refine_flow(row),
            Stage::NoteOutflow => self.note_outflow(row),
            Stage::MixAlong(mixing) => self.mix_along(row, mixing),
            Stage::MixDown(mixing) => self.mix_down(row, mixing),
        }
    }
}
