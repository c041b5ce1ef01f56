//! A step of pigment that is finer than its water, as passes of row stages.

use std::sync::atomic::AtomicBool;

use super::pool::Pool;
use super::stage::Stage;
use super::{Stop, Task, go_on, substeps};
use crate::carry_packed::substep_speed;
use crate::mix_pigment::Mixing;

/// Carries, exchanges and settles the pigment of a pool whose water lies ready
/// ([`CoarseWater`](super::stages::refine::CoarseWater)). No face is faster than `fastest`.
///
/// # Source
/// `fidelity/wash/living.py`, `WashX.step`, part 4; where flow mixes pigment enough, by a scheme that needs no limiter and
/// fewer sub-steps, and mixes apart.
pub fn move_pigment(pool: &mut Pool, task: &Task, fastest: f32, cancel: &AtomicBool) -> Result<(), Stop> {
    let Some(living) = &task.living else { return Ok(()) };
    let found = pool.pass(task, &[Stage::RefineFilm, Stage::RefineFlow, Stage::NoteOutflow]).outflow;
    go_on(found, cancel)?;
    let outflow = f32::from_bits(found as u32);
    // No cell gives away more than it holds.
    let speed = if living.is_mixed_apart {
        outflow
    } else {
        substep_speed(outflow, living.dispersion, living.diffusion)
    };
    let n = substeps(speed.to_bits() as i32)?;
    let dt = 1.0 / n as f32;
    for _ in 1..n {
        go_on(found, cancel)?;
        pool.pass(task, &[Stage::CarryPacked(dt)]);
    }
    let mut stages = vec![Stage::CarryPacked(dt)];
    if living.is_mixed_apart {
        let mixing = Mixing::after_carrying(living.diffusion, living.dispersion, dt);
        let passes = mixing.passes(fastest).max(1.0);
        let mixing = mixing.part(passes);
        stages.extend([Stage::MixAlong(mixing), Stage::MixDown(mixing)]);
        for _ in 1..passes as u32 {
            pool.pass(task, &stages);
            stages.retain(|stage| !matches!(stage, Stage::CarryPacked(_)));
        }
    }
    stages.extend([Stage::Transfer, Stage::Settle]);
    pool.pass(task, &stages);
    Ok(())
}
