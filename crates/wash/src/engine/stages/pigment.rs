//! Rows for the routines that move pigment.

use super::water::flow_rows;
use crate::engine::world::World;
use crate::move_pigment::{SuspendedRows, carry};
use crate::transfer_pigment::transfer;

impl World<'_> {
    pub fn carry(&mut self, row: usize, dt: f32) {
        let runs = self.wet_runs(row);
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        for (suspended, ring) in self.suspended.iter_mut().zip(&mut self.scratch.suspended) {
            ring.take(self.wet, row, suspended);
            let (g, below) = suspended.row_mut_and_below(row);
            let old = SuspendedRows { above: &ring.above.values, here: &ring.here.values, below };
            for &run in runs {
                carry(g, &old, &flow, dt, run);
            }
        }
    }

    pub fn transfer(&mut self, row: usize) {
        let runs = self.wet_runs(row);
        let (height, mask) = (self.height.row(row), self.mask.row(row));
        let pigments = self.suspended.iter_mut().zip(&mut self.deposited).zip(&self.task.exchanges);
        for ((suspended, deposited), &exchange) in pigments {
            for &run in runs {
                transfer(suspended.row_mut(row), deposited.row_mut(row), height, mask, exchange, run);
            }
        }
    }
}
