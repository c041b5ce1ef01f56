//! What one band sees of a pool while a pass goes down its rows.

use std::ops::{BitOr, Range};

use girtin_grid::Field;

use super::Task;
use super::rows::Rows;
use super::scratch::Scratch;
use super::stage::Stage;
use crate::flow_outward::Outflow;
use crate::region::{Region, Run};

/// Which fields a pass changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Changes(u8);

impl Changes {
    pub const NOTHING: Self = Self(0);
    pub const MASK: Self = Self(1);
    pub const FLOW: Self = Self(2);
    pub const PRESSURE: Self = Self(4);
    pub const SATURATION: Self = Self(8);
    pub const SUSPENDED: Self = Self(16);
    pub const DEPOSITED: Self = Self(32);

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

/// What the stages of a pass noted; nothing of it depends on an order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Bits of the largest speed after the slope.
    pub speed: i32,
    /// Bits of the largest correction of each of a pass's sweeps.
    pub corrections: [i32; 2],
    /// Bits of the largest correction of the sweep to come.
    pub next_correction: i32,
    /// Bits of the largest sum of outflow speeds of a cell.
    pub outflow: i32,
    /// Where cells became wet: row, first column and end.
    pub grown: Vec<(usize, usize, usize)>,
}

impl Found {
    pub fn with(mut self, other: Self) -> Self {
        let Self { speed, corrections, next_correction, outflow, grown } = other;
        self.speed = self.speed.max(speed);
        self.corrections = [0, 1].map(|i| self.corrections[i].max(corrections[i]));
        self.next_correction = self.next_correction.max(next_correction);
        self.outflow = self.outflow.max(outflow);
        self.grown.extend(grown);
        self
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
    pub wet: &'a Region,
    pub damp: &'a Region,
    pub outflow: &'a Outflow,
    pub height: &'a Field<f32>,
    pub mask: Rows<'a, u8>,
    pub u: Rows<'a, f32>,
    pub v: Rows<'a, f32>,
    pub pressure: Rows<'a, f32>,
    pub saturation: Rows<'a, f32>,
    pub suspended: Vec<Rows<'a, f32>>,
    pub deposited: Vec<Rows<'a, f32>>,
    pub scratch: &'a mut Scratch,
    pub found: Found,
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

    /// Does a stage's work on a row.
    pub fn work(&mut self, stage: Stage, row: usize) {
        match stage {
            Stage::AddSlope => self.add_slope(row),
            Stage::Advance(dt) => self.advance(row, dt),
            Stage::FindCorrection => self.find_correction(row),
            Stage::Sweep(slot) => self.sweep(row, slot),
            Stage::FlowOutward => self.flow_outward(row),
            Stage::Carry(dt) => self.carry(row, dt),
            Stage::Transfer => self.transfer(row),
            Stage::Absorb => self.absorb(row),
            Stage::Diffuse(slot) => self.diffuse(row, slot),
            Stage::Spread => self.spread(row),
        }
    }
}
