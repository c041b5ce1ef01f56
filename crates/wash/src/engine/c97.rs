//! A step of Curtis et al. 1997 as passes of row stages.

use std::sync::atomic::AtomicBool;

use super::pools::Pools;
use super::stage::Stage;
use super::world::Found;
use super::{Stop, Task, go_on, substeps};

/// A wash that runs by C97.
#[derive(Debug)]
pub struct C97Run {
    pub pools: Pools,
    /// The largest sum of outflow speeds of a cell, when known.
    fastest: Option<f32>,
}

impl C97Run {
    pub fn new(pools: Pools) -> Self {
        Self { pools, fastest: None }
    }

    /// One step of C97's MainLoop; returns the number of relaxation sweeps.
    ///
    /// # Source
    /// Curtis et al. 1997, §4.3–4.6.
    pub fn step(&mut self, task: &Task, cancel: &AtomicBool) -> Result<u32, Stop> {
        let first_correction = self.update_velocities(task, cancel)?;
        let (sweeps, outflow) = self.relax_divergence(task, first_correction, cancel)?;
        self.fastest = Some(f32::from_bits(outflow as u32));
        let n = substeps(outflow)?;
        let dt = 1.0 / n as f32;
        for _ in 1..n {
            go_on(outflow, cancel)?;
            self.pools.pass(task, &[Stage::Carry(dt)]);
        }
        go_on(outflow, cancel)?;
        self.pools.pass(task, &[Stage::Carry(dt), Stage::Transfer]);
        if task.pores.is_some() {
            self.pools.pass(task, &[Stage::Absorb, Stage::Diffuse(0), Stage::Spread]);
        }
        Ok(sweeps)
    }

    /// Returns the bits of the largest correction that the first relaxation sweep will make.
    fn update_velocities(&mut self, task: &Task, cancel: &AtomicBool) -> Result<i32, Stop> {
        // The slope cannot push any face past this; the factor covers rounding. Then one sub-step will do and the
        // exact maximum, which would need a pass of its own, is not asked for.
        let steepest = self.pools.steepest();
        let bound = self.fastest.map_or(f32::INFINITY, |fastest| (fastest + steepest) * (1.0 + 1e-5));
        if bound <= 1.0 {
            let stages = [Stage::AddSlope, Stage::Advance(1.0), Stage::FindCorrection];
            return Ok(self.pools.pass(task, &stages).next_correction);
        }
        let speed = self.pools.pass(task, &[Stage::AddSlope]).speed;
        let n = substeps(speed)?;
        let dt = 1.0 / n as f32;
        for _ in 1..n {
            go_on(speed, cancel)?;
            self.pools.pass(task, &[Stage::Advance(dt)]);
        }
        go_on(speed, cancel)?;
        Ok(self.pools.pass(task, &[Stage::Advance(dt), Stage::FindCorrection]).next_correction)
    }

    /// Returns the number of sweeps, and the bits of the largest sum of outflow speeds after them.
    ///
    /// Sweeps stop exactly where they would one by one: what the next sweep will correct at most is known before it is
    /// made, and a sweep that leaves more than the tolerance is sure to be followed by another, so two go in a pass.
    fn relax_divergence(
        &mut self,
        task: &Task,
        first_correction: i32,
        cancel: &AtomicBool,
    ) -> Result<(u32, i32), Stop> {
        const TWO: [Stage; 2] = [Stage::Sweep(0), Stage::Sweep(1)];
        let is_enough = |correction: i32| f32::from_bits(correction as u32) <= task.relax_tolerance;
        let mut correction = first_correction;
        let mut sweeps = 0;
        loop {
            go_on(correction, cancel)?;
            let left = task.relax_max_sweeps - sweeps;
            if left == 1 || is_enough(correction) {
                let found = self.pools.pass(task, &[Stage::Sweep(0), Stage::FlowOutward]);
                return Ok((sweeps + 1, found.outflow));
            }
            sweeps += 2;
            if left == 2 {
                let found = self.pools.pass(task, &[TWO[0], TWO[1], Stage::FlowOutward]);
                go_on(found.corrections[1], cancel)?;
                return Ok((sweeps, found.outflow));
            }
            let Found { corrections, next_correction, .. } =
                self.pools.pass(task, &[TWO[0], TWO[1], Stage::FindCorrection]);
            go_on(corrections[1], cancel)?;
            if is_enough(corrections[1]) {
                return Ok((sweeps, self.pools.pass(task, &[Stage::FlowOutward]).outflow));
            }
            correction = next_correction;
        }
    }
}
