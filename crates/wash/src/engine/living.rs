//! A step of the living wash as passes of row stages.

use std::sync::atomic::AtomicBool;

use super::pools::Pools;
use super::stage::Stage;
use super::{Stop, Task, go_on, substeps};
use crate::carry_packed::substep_speed;
use crate::evaporate::QUANTA;
use crate::relax_implicitly::Relaxation;
use crate::state::{Ledger, WashState};

/// A wash that runs by the living model.
#[derive(Debug)]
pub struct LivingRun {
    pub pools: Pools,
}

impl LivingRun {
    pub fn new(pools: Pools) -> Self {
        Self { pools }
    }

    /// One step; returns the number of iterations of the relaxation. `state` is what the pools were taken from.
    ///
    /// # Source
    /// `fidelity/wash/living.py`, `WashX.step`; its numbers are those of the comments below.
    pub fn step(
        &mut self,
        task: &Task,
        state: &mut WashState,
        ledger: &mut Ledger,
        cancel: &AtomicBool,
    ) -> Result<u32, Stop> {
        let Some(living) = &task.living else { return Ok(0) };
        if !self.pools.are_damp() {
            ledger.contact_carry = fraction_after(ledger.contact_carry, living.creep).0;
            return Ok(0);
        }
        self.pools.settle_down(living.pore_passes);
        // 1: momentum.
        let fastest = self.update_velocities(task, cancel)?;
        // 2: relaxation, then the water. 3: edge darkening and evaporation.
        let relaxation =
            Relaxation::new(living.compressibility, f32::from_bits(fastest as u32), living.scale);
        let iterations = relaxation.iterations.len();
        let (found, film_evaporated) = self.relax(task, &relaxation, living.widenings);
        // 4: pigment.
        go_on(found, cancel)?;
        let outflow = f32::from_bits(found as u32);
        let speed = substep_speed(outflow, living.dispersion, living.diffusion);
        let n = substeps(speed.to_bits() as i32)?;
        let dt = 1.0 / n as f32;
        for _ in 1..n {
            go_on(found, cancel)?;
            self.pools.pass(task, &[Stage::CarryPacked(dt)]);
        }
        // 5: pores.
        let mut stages = vec![
            Stage::CarryPacked(dt),
            Stage::Transfer,
            Stage::Settle,
            Stage::EvaporatePores,
            Stage::AbsorbFilm,
        ];
        stages.extend((0..living.pore_passes).map(Stage::Diffuse));
        let found = self.pools.pass(task, &stages);
        // 6: the contact line.
        let (carry, advances) = fraction_after(ledger.contact_carry, living.creep);
        ledger.contact_carry = carry;
        for _ in 0..advances {
            self.pools.creep(task, living);
        }
        let dried = self.pools.dry(task, living, found.thinnest, advances > 0);
        self.pools.look_again(task, state);
        let film = (film_evaporated + dried) as f64 / QUANTA;
        let pores = found.pores_evaporated as f64 / QUANTA * f64::from(living.pore_depth);
        ledger.evaporated += (film + pores) / (living.scale * living.scale);
        Ok(iterations as u32)
    }

    /// Returns the bits of the largest speed.
    fn update_velocities(&mut self, task: &Task, cancel: &AtomicBool) -> Result<i32, Stop> {
        /// More sub-steps are not made for the sake of what pressure may do: the speed limit holds it.
        const MOST_FOR_PRESSURE: f32 = 64.0;
        let found = self.pools.pass(task, &[Stage::Mobility, Stage::AddSlope]);
        let drive = f32::from_bits(found.speed as u32);
        let drive = if drive > MOST_FOR_PRESSURE { MOST_FOR_PRESSURE } else { drive };
        let viscosity = 4.0 * task.momentum.viscosity;
        // Not f32::max: a value that is no number must be seen.
        let speed = if drive < viscosity { viscosity } else { drive };
        let n = substeps(speed.to_bits() as i32)?;
        let dt = 1.0 / n as f32;
        let mut stages = vec![Stage::Advance(dt)];
        if n > 1 {
            stages.insert(0, Stage::Keep(dt));
        }
        let mut fastest = 0;
        for _ in 0..n {
            go_on(fastest, cancel)?;
            fastest = self.pools.pass(task, &stages).advanced;
            stages = vec![Stage::Advance(dt)];
        }
        go_on(fastest, cancel)?;
        Ok(fastest)
    }

    /// Returns the bits of the largest sum of outflow speeds, and the film that evaporated.
    fn relax(&mut self, task: &Task, relaxation: &Relaxation, widenings: usize) -> (i32, i64) {
        let &Relaxation { compressibility, stiffness, start, ref iterations } = relaxation;
        self.pools.renew_edges(task);
        let mut stages = vec![Stage::BeginSolve { start }];
        let numbered = iterations.iter().enumerate();
        stages.extend(numbered.map(|(i, &iteration)| Stage::Iterate { number: i + 1, iteration, stiffness }));
        stages.push(Stage::Project { iterations: iterations.len(), stiffness });
        stages.push(Stage::Share(compressibility));
        stages.extend((1..=widenings).map(|number| Stage::WidenShare(number, compressibility)));
        stages.push(Stage::MoveFilm(widenings, compressibility));
        stages.push(Stage::Evaporate);
        let found = self.pools.pass(task, &stages);
        (found.outflow, found.evaporated)
    }
}

/// What is left of a sum after its whole part, and the whole part.
fn fraction_after(carry: f64, add: f64) -> (f64, u32) {
    let mut sum = carry + add;
    let mut whole = 0;
    while sum >= 1.0 {
        sum -= 1.0;
        whole += 1;
    }
    (sum, whole)
}
