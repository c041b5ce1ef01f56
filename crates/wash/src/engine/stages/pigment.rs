//! Rows for the routines that move pigment.

use super::water::flow_in;
use crate::engine::ground::Window;
use crate::engine::world::World;
use crate::move_pigment::{SuspendedRows, carry};
use crate::transfer_pigment::transfer;

impl World<'_> {
    pub fn carry(&mut self, row: usize, dt: f32) {
        for (suspended, ring) in self.suspended.iter_mut().zip(&mut self.scratch.suspended) {
            ring.take(self.wet, self.ground, row, suspended);
            for window in self.ground.windows(self.wet, row) {
                let flow = flow_in(&self.u, &self.v, &self.mask, &window);
                let (g, below) = suspended.at_mut_and_below(window.here, window.below, window.len);
                let (above, here) = (window.of(&ring.above.values), window.of(&ring.here.values));
                carry(g, &SuspendedRows { above, here, below }, &flow, dt, window.run);
            }
        }
    }

    pub fn transfer(&mut self, row: usize) {
        let pigments = self.suspended.iter_mut().zip(&mut self.deposited).zip(&self.task.exchanges);
        for ((suspended, deposited), &exchange) in pigments {
            for Window { run, here, len, .. } in self.ground.windows(self.wet, row) {
                let (height, mask) = (&self.height.values()[here..][..len], self.mask.at(here, len));
                transfer(
                    suspended.at_mut(here, len),
                    deposited.at_mut(here, len),
                    height,
                    mask,
                    exchange,
                    run,
                );
            }
        }
    }
}
