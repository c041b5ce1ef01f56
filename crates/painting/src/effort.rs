//! How long work takes, about, told before it begins.
//!
//! What runs until it is dry, and how often fast water needs sub-steps, is known only afterwards: so there are two
//! figures, the least and the most that are likely.

use girtin_wash::WashModel;

use crate::document::{Document, Event, Glaze};
use crate::memory::wet_cells;

/// What a wet cell costs in a step on one thread, ns: once, for every sweep of relaxation, and for every pigment.
const STEP_NS: f64 = 2.0;
const SWEEP_NS: f64 = 0.6;
const PIGMENT_NS: f64 = 1.5;
/// The same of a step of the living wash at 4 cells a millimetre.
const LIVING_NS: f64 = 7.0;
const LIVING_PIGMENT_NS: f64 = 2.0;
/// How much longer such a step takes where water is fast and pores fill.
const LIVING_HARD: f64 = 3.0;
/// Steps after which the first washes are dry.
const SOON_DRY: u32 = 100;

/// Seconds that a wet cell's step takes on one thread: the least and the most that are likely.
pub fn of_step(model: &WashModel, cells_per_mm: f64, pigments: usize) -> [f64; 2] {
    let pigments = pigments as f64;
    match model {
        WashModel::C97 { params, .. } => [1, params.relax_max_sweeps.max(1)]
            .map(|sweeps| 1e-9 * (STEP_NS + SWEEP_NS * f64::from(sweeps) + PIGMENT_NS * pigments)),
        WashModel::Living(_) => {
            // Sub-steps and iterations grow with the cells a millimetre.
            let ns = (LIVING_NS + LIVING_PIGMENT_NS * pigments) * (cells_per_mm / 4.0).max(1.0);
            [1.0, LIVING_HARD].map(|times| 1e-9 * times * ns)
        }
    }
}

/// Seconds that simulating a document's glazes takes on one thread, all water as fine as the pigment: the least and the
/// most that are likely. `None` if it has more cells than are simulated.
pub fn of_document(document: &Document) -> Option<[f64; 2]> {
    let size = document.cells().ok()?;
    let mut seconds = [0.0; 2];
    for glaze in &document.glazes {
        let step = of_step(&glaze.model, document.cells_per_mm(), glaze.pigments.len());
        let cells = wet_cells(glaze, size, document.cells_per_mm()) as f64;
        for ((seconds, step), steps) in seconds.iter_mut().zip(step).zip(steps(glaze)) {
            *seconds += step * cells * f64::from(steps);
        }
    }
    Some(seconds)
}

/// The fewest and the most steps of a glaze.
fn steps(glaze: &Glaze) -> [u32; 2] {
    let each = glaze.events.iter().map(|event| match event {
        Event::Run { steps, until_dry: true, .. } => [(*steps).min(SOON_DRY), *steps],
        Event::Run { steps, .. } => [*steps; 2],
        _ => [0; 2],
    });
    each.fold([0; 2], |sum, steps| [0, 1].map(|i| sum[i] + steps[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stock;

    #[test]
    fn more_cells_pigments_and_steps_take_longer() {
        let seconds = |scale: u32, pigments: &str, steps: u32, more: &str| {
            let text = format!(
                "format = 1\n[sheet]\nsize = [30, 20]\ncells_per_pixel = 1\npixels_per_mm = {scale}\n[[glaze]]\n\
                 pigments = [{pigments}]\n[[glaze.events]]\ndo = 'wet'\narea = {{ shape = 'everywhere' }}\n\
                 [[glaze.events]]\ndo = 'run'\nsteps = {steps}\n{more}"
            );
            of_document(&Document::from_toml("test.toml", &text, &Stock::builtin()).unwrap()).unwrap()
        };
        let [least, most] = seconds(4, "'french-ultramarine'", 200, "");
        assert!(0.0 < least && least < most && most < 10.0, "{least} to {most} s");
        for [less, more] in [
            seconds(8, "'french-ultramarine'", 200, ""),
            seconds(4, "'french-ultramarine', 'burnt-umber'", 200, ""),
            seconds(4, "'french-ultramarine'", 300, ""),
        ] {
            assert!(less > least && more > most);
        }
        let [soon, late] = seconds(4, "'french-ultramarine'", 200, "until = 'dry'\n");
        assert!(soon < least && late == most, "it may be dry before");
    }
}
