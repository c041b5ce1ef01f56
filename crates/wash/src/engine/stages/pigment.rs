//! Rows for the routines that move pigment.

use super::water::{flow_in, flow_rows};
use crate::engine::world::World;
use crate::move_pigment::{PaperRows, SuspendedRows, carry, carry_and_transfer};
use crate::transfer_pigment::transfer;

impl World<'_> {
    pub fn carry(&mut self, row: usize, dt: f32) {
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        for (suspended, ring) in self.suspended.iter_mut().zip(&mut self.scratch.suspended) {
            ring.take(self.wet, self.ground, row, suspended);
            let (amounts, below) = suspended.row_mut_and_below(row);
            for window in self.ground.windows(self.wet, row) {
                let old = SuspendedRows {
                    above: window.above(&ring.above.values),
                    here: window.here(&ring.here.values),
                    below: window.below(below),
                };
                carry(window.here_mut(amounts), &old, &flow_in(&flow, &window), dt, window.run);
            }
        }
    }

    pub fn carry_and_transfer(&mut self, row: usize, dt: f32) {
        let flow = flow_rows(&self.u, &self.v, &self.mask, row);
        let height = self.ground.row(self.height, row);
        let pigments = self.suspended.iter_mut().zip(&mut self.deposited).zip(&self.task.exchanges);
        for (((suspended, deposited), &exchange), ring) in pigments.zip(&mut self.scratch.suspended) {
            ring.take(self.wet, self.ground, row, suspended);
            let (suspended, below) = suspended.row_mut_and_below(row);
            let deposited = deposited.row_mut(row);
            for window in self.ground.windows(self.wet, row) {
                let old = SuspendedRows {
                    above: window.above(&ring.above.values),
                    here: window.here(&ring.here.values),
                    below: window.below(below),
                };
                let paper = PaperRows { height: window.here(height), exchange };
                let (g, d) = (window.here_mut(suspended), window.here_mut(deposited));
                carry_and_transfer(g, d, &paper, &old, &flow_in(&flow, &window), dt, window.run);
            }
        }
    }

    pub fn transfer(&mut self, row: usize) {
        let (height, mask) = (self.ground.row(self.height, row), self.mask.row(row));
        let pigments = self.suspended.iter_mut().zip(&mut self.deposited).zip(&self.task.exchanges);
        for ((suspended, deposited), &exchange) in pigments {
            let (suspended, deposited) = (suspended.row_mut(row), deposited.row_mut(row));
            for window in self.ground.windows(self.wet, row) {
                let (g, d) = (window.here_mut(suspended), window.here_mut(deposited));
                transfer(g, d, window.here(height), window.here(mask), exchange, window.run);
            }
        }
    }
}
