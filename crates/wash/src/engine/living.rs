//! A step of the living wash as passes of row stages.

use std::sync::atomic::AtomicBool;

use super::pools::Pools;
use super::stage::Stage;
use super::world::Found;
use super::{LivingTask, Stop, Task, go_on, substeps};
use crate::carry_packed::substep_speed;
use crate::evaporate::QUANTA;
use crate::relax_implicitly::Relaxation;
use crate::state::{Ledger, WashState};

/// A wash that runs by the living model.
#[derive(Debug)]
pub struct LivingRun {
    pub pools: Pools,
    /// What was found of the step to come, if its slope term is already added.
    begun: Option<Found>,
}

/// Passes over the pores that go with the pigment's.
const MOST_PORE_PASSES_WITH_PIGMENT: usize = 2;

/// What begins a step: notes the largest speed, and the largest that film may drive in it.
const BEGINNING: [Stage; 2] = [Stage::Mobility, Stage::AddSlope];

impl LivingRun {
    pub fn new(pools: Pools) -> Self {
        Self { pools, begun: None }
    }

    /// One step; returns the number of iterations of the relaxation. `state` is what the pools were taken from.
    ///
    /// Unless the run ends here, the next step may be begun already.
    ///
    /// # Source
    /// `fidelity/wash/living.py`, `WashX.step`; its numbers are those of the comments below.
    pub fn step(
        &mut self,
        task: &Task,
        state: &mut WashState,
        ledger: &mut Ledger,
        is_last: bool,
        cancel: &AtomicBool,
    ) -> Result<u32, Stop> {
        let Some(living) = &task.living else { return Ok(0) };
        if !self.pools.are_damp() {
            ledger.contact_carry = fraction_after(ledger.contact_carry, living.creep).0;
            return Ok(0);
        }
        self.pools.settle_down(living.pore_passes);
        self.pools.renew_edges(task);
        // 1: momentum. 2: relaxation, then the water. 3: edge darkening and evaporation.
        let (iterations, water) = self.move_water(task, living, cancel)?;
        go_on(water.outflow, cancel)?;
        // 4: pigment.
        let outflow = f32::from_bits(water.outflow as u32);
        let speed = substep_speed(outflow, living.dispersion, living.diffusion);
        let n = substeps(speed.to_bits() as i32)?;
        let dt = 1.0 / n as f32;
        for _ in 1..n {
            go_on(water.outflow, cancel)?;
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
        let diffusion: Vec<Stage> = (0..living.pore_passes).map(Stage::Diffuse).collect();
        // Many passes over the pores look far beyond a band: further than anything else has to.
        let is_far = living.pore_passes > MOST_PORE_PASSES_WITH_PIGMENT;
        if !is_far {
            stages.extend(&diffusion);
        }
        let (carry, advances) = fraction_after(ledger.contact_carry, living.creep);
        ledger.contact_carry = carry;
        // Where no film can vanish and none creeps, nothing stands between this step and the next.
        let is_unbroken = !is_last && advances == 0 && living.outlasts_a_step(water.thinnest);
        if is_unbroken {
            stages.extend(BEGINNING);
        }
        let mut found = self.pools.pass(task, &stages);
        if is_far {
            let after = self.pools.pass(task, &diffusion);
            found = found.with(after);
        }
        // 6: the contact line.
        for _ in 0..advances {
            self.pools.creep(task, living);
        }
        let dried = self.pools.dry(task, living);
        self.pools.look_again(task, state);
        let film = (water.evaporated + dried) as f64 / QUANTA;
        let pores = found.pores_evaporated as f64 / QUANTA * f64::from(living.pore_depth);
        self.begun = is_unbroken.then_some(found);
        ledger.evaporated += (film + pores) / (living.scale * living.scale);
        Ok(iterations)
    }

    /// Velocities, relaxation, film and evaporation; returns the number of iterations and what was found.
    fn move_water(
        &mut self,
        task: &Task,
        living: &LivingTask,
        cancel: &AtomicBool,
    ) -> Result<(u32, Found), Stop> {
        /// More sub-steps are not made for the sake of what pressure may do: the speed limit holds it.
        const MOST_FOR_PRESSURE: f32 = 64.0;
        let begun = self.begun.take();
        let begun = begun.unwrap_or_else(|| self.pools.pass(task, &BEGINNING));
        let [drive, fastest] = [begun.drive, begun.speed].map(|bits| f32::from_bits(bits as u32));
        let capped = if drive > MOST_FOR_PRESSURE { MOST_FOR_PRESSURE } else { drive };
        let viscosity = 4.0 * task.momentum.viscosity;
        // Not f32::max: a value that is no number must be seen.
        let speed = if capped < viscosity { viscosity } else { capped };
        let n = substeps(speed.to_bits() as i32)?;
        let dt = 1.0 / n as f32;
        let relaxation = |fastest: f32| Relaxation::new(living.compressibility, fastest, living.scale);
        if n == 1 && living.stays_slow(drive, fastest, task.momentum.viscosity) {
            // However the flow turns out, it does not change the relaxation.
            let found = self.relax(task, &relaxation(0.0), living.widenings, &[Stage::AdvanceAlone(dt)]);
            return Ok(found_after(relaxation(0.0), found));
        }
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
        let relaxation = relaxation(f32::from_bits(fastest as u32));
        let found = self.relax(task, &relaxation, living.widenings, &[]);
        Ok(found_after(relaxation, found))
    }

    /// Relaxes the flow after other stages, moves the film and dries it.
    fn relax(&mut self, task: &Task, relaxation: &Relaxation, widenings: usize, before: &[Stage]) -> Found {
        let &Relaxation { compressibility, stiffness, start, ref iterations } = relaxation;
        let mut stages = before.to_vec();
        stages.push(Stage::BeginSolve { start });
        let numbered = iterations.iter().enumerate();
        stages.extend(numbered.map(|(i, &iteration)| Stage::Iterate { number: i + 1, iteration, stiffness }));
        stages.push(Stage::Project { iterations: iterations.len(), stiffness });
        stages.push(Stage::Share(compressibility));
        stages.extend((1..=widenings).map(|number| Stage::WidenShare(number, compressibility)));
        stages.push(Stage::MoveFilm(widenings, compressibility));
        stages.push(Stage::Evaporate);
        self.pools.pass(task, &stages)
    }
}

fn found_after(relaxation: Relaxation, found: Found) -> (u32, Found) {
    (relaxation.iterations.len() as u32, found)
}

impl LivingTask {
    /// Whether flow of at most `fastest` cells a step, which film may drive at `drive`, in one sub-step stays too slow to
    /// change the compressibility.
    fn stays_slow(&self, drive: f32, fastest: f32, viscosity: f32) -> bool {
        // A face keeps some of its speed, since one sub-step is enough for this viscosity; with what film adds that is at most
        // `drive`. Its neighbours give it 4 viscosity · fastest. The squares differ by at most (2 fastest)² / 4, the two
        // corner products by 2 fastest². The factor covers rounding.
        let bound = (drive + 4.0 * viscosity * fastest + 3.0 * fastest * fastest) * 1.0001;
        let raised = Relaxation::new(self.compressibility, bound, self.scale).compressibility;
        raised == self.compressibility as f32
    }

    /// Whether no film vanishes within the step if the thinnest one, bits, soaks in as fast as it can.
    fn outlasts_a_step(&self, thinnest: i32) -> bool {
        // No paper is higher than 1; the factor covers rounding. A film below 0, or none, does not.
        let left = f32::from_bits(thinnest as u32) - self.most_soaked * 1.0001;
        left > self.vanishing.thinnest
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
