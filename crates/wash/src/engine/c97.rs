//! A step of Curtis et al. 1997 as passes of row stages.

use std::sync::atomic::AtomicBool;

use super::pools::Pools;
use super::stage::Stage;
use super::{Stop, Task, go_on, substeps};

/// A wash that runs by C97.
///
/// The loop of steps is rotated: a step ends before its pigment moves, which then goes down the rows together with the
/// next step's water. [`C97Run::finish`] moves what is left behind.
#[derive(Debug)]
pub struct C97Run {
    pub pools: Pools,
    /// The largest sum of outflow speeds of a cell, when known.
    fastest: Option<f32>,
    /// Whether the last step's pigment has yet to move, in one sub-step.
    is_behind: bool,
    /// Sweeps of the last step, and how many steps in a row took as many.
    sweeps: (u32, u32),
}

/// Steps in a row that took as many sweeps after which the next one is taken to do so as well.
const STEPS_TO_TRUST: u32 = 4;

/// What moves pigment in a step of one sub-step.
const PIGMENT: [Stage; 1] = [Stage::CarryAndTransfer(1.0)];

impl C97Run {
    pub fn new(pools: Pools) -> Self {
        Self { pools, fastest: None, is_behind: false, sweeps: (0, 0) }
    }

    /// One step of C97's MainLoop; returns the number of relaxation sweeps.
    ///
    /// # Source
    /// Curtis et al. 1997, §4.3–4.6.
    pub fn step(&mut self, task: &Task, cancel: &AtomicBool) -> Result<u32, Stop> {
        let (sweeps, outflow) = self.move_water(task, cancel)?;
        self.fastest = Some(f32::from_bits(outflow as u32));
        self.sweeps = if self.sweeps.0 == sweeps { (sweeps, self.sweeps.1 + 1) } else { (sweeps, 1) };
        let n = substeps(outflow)?;
        go_on(outflow, cancel)?;
        if n == 1 && task.pores.is_none() {
            self.is_behind = true;
            return Ok(sweeps);
        }
        let dt = 1.0 / n as f32;
        for _ in 1..n {
            go_on(outflow, cancel)?;
            self.pools.pass(task, &[Stage::Carry(dt)]);
        }
        self.pools.pass(task, &[Stage::CarryAndTransfer(dt)]);
        if task.pores.is_some() {
            self.pools.pass(task, &[Stage::Absorb, Stage::Diffuse(0), Stage::Spread]);
        }
        Ok(sweeps)
    }

    /// Moves the pigment of the last step.
    pub fn finish(&mut self, task: &Task) {
        if std::mem::take(&mut self.is_behind) {
            self.pools.pass(task, &PIGMENT);
        }
    }

    /// Velocities, relaxation and outflow; returns the number of sweeps, and the bits of the largest sum of outflow
    /// speeds after them.
    fn move_water(&mut self, task: &Task, cancel: &AtomicBool) -> Result<(u32, i32), Stop> {
        // The slope cannot push any face past this; the factor covers rounding. Then one sub-step will do and the
        // exact maximum, which would need a pass of its own, is not asked for.
        let steepest = self.pools.steepest();
        let bound = self.fastest.map_or(f32::INFINITY, |fastest| (fastest + steepest) * (1.0 + 1e-5));
        if bound > 1.0 {
            self.finish(task);
            let speed = self.pools.pass(task, &[Stage::AddSlope]).speed;
            let n = substeps(speed)?;
            let dt = 1.0 / n as f32;
            for _ in 1..n {
                go_on(speed, cancel)?;
                self.pools.pass(task, &[Stage::Advance(dt)]);
            }
            go_on(speed, cancel)?;
            return self.relax_divergence(task, vec![Stage::Advance(dt)], cancel);
        }
        let mut stages = Vec::new();
        if std::mem::take(&mut self.is_behind) {
            stages.extend(PIGMENT);
        }
        stages.extend([Stage::AddSlopeAlone, Stage::Advance(1.0)]);
        self.relax_divergence(task, stages, cancel)
    }

    /// Relaxes the flow after other stages; returns as [`C97Run::move_water`].
    ///
    /// Sweeps stop exactly where they would one by one, though two go in a pass. Where the last steps took both as well, the
    /// second is made on trust, and taken back if the first turns out to have been enough. Else what the next sweep will
    /// correct at most is found first, and one that corrects more than the tolerance is sure to be followed by another.
    fn relax_divergence(
        &mut self,
        task: &Task,
        mut stages: Vec<Stage>,
        cancel: &AtomicBool,
    ) -> Result<(u32, i32), Stop> {
        let is_enough = |correction: i32| f32::from_bits(correction as u32) <= task.relax_tolerance;
        let trusted = if self.sweeps.1 >= STEPS_TO_TRUST { self.sweeps.0 } else { 0 };
        let mut sweeps = 0;
        // What the next sweep will correct at most, if that is known.
        let mut correction = None;
        loop {
            let left = task.relax_max_sweeps - sweeps;
            let is_trusted = correction.is_none() && left >= 2 && sweeps + 2 <= trusted;
            if !is_trusted {
                let next = correction.take().unwrap_or_else(|| {
                    stages.push(Stage::FindCorrection);
                    self.pools.pass(task, &std::mem::take(&mut stages)).next_correction
                });
                go_on(next, cancel)?;
                if left == 1 || is_enough(next) {
                    let found = self.pools.pass(task, &[Stage::Sweep(0), Stage::FlowOutward]);
                    return Ok((sweeps + 1, found.outflow));
                }
            }
            let (second, last) = match (is_trusted, left == 2) {
                (true, true) => (Stage::GuardedSweep, Some(Stage::FlowOutward)),
                (true, false) => (Stage::GuardedSweep, None),
                (false, true) => (Stage::Sweep(1), Some(Stage::FlowOutward)),
                (false, false) => (Stage::Sweep(1), Some(Stage::FindCorrection)),
            };
            stages.extend([Stage::Sweep(0), second]);
            stages.extend(last);
            let found = self.pools.pass(task, &std::mem::take(&mut stages));
            go_on(found.corrections[0].max(found.corrections[1]), cancel)?;
            if is_trusted && is_enough(found.corrections[0]) {
                self.pools.take_back();
                return Ok((sweeps + 1, self.pools.pass(task, &[Stage::FlowOutward]).outflow));
            }
            sweeps += 2;
            if left == 2 {
                return Ok((sweeps, found.outflow));
            }
            if is_enough(found.corrections[1]) {
                return Ok((sweeps, self.pools.pass(task, &[Stage::FlowOutward]).outflow));
            }
            correction = (!is_trusted).then_some(found.next_correction);
        }
    }
}
