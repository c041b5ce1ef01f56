//! A plan is carried out: each glaze is simulated, then all are laid over each other.

use std::sync::atomic::AtomicBool;

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use girtin_wash::{Ledger, Patch, RunConfig, RunError, StateError, WashModel, WashState};

use crate::area::Coverage;
use crate::composite::lay_over;
use crate::document::{Document, Stock};
use crate::easel::Easel;
use crate::resolve::{Deed, Plan, PlannedGlaze, PlannedRun, ResolveError};

/// How finely water is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WaterDetail {
    /// As finely as pigment.
    #[default]
    Full,
    /// At about 4 cells a millimetre, whatever pigment and grain have: for previews and large prints. Glazes on a board that
    /// leans keep theirs full.
    Coarse,
}

/// How a document is painted.
#[derive(Clone, Copy, Default)]
pub struct PaintConfig<'a> {
    /// Number of threads; 0 takes those of the rayon pool this is called in.
    pub threads: usize,
    /// How finely the water of living washes is simulated. Alone of these it changes the picture, a little.
    pub water: WaterDetail,
    /// Set it to end early.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with steps done and steps in all.
    pub progress: Option<&'a (dyn Fn(u64, u64) + Sync)>,
}

impl std::fmt::Debug for PaintConfig<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PaintConfig").field("threads", &self.threads).finish_non_exhaustive()
    }
}

/// A painted document.
#[derive(Clone, Debug)]
pub struct Painted {
    /// The picture, in linear light.
    pub picture: Raster<LinearRgb>,
    /// Resolution of the picture.
    pub pixels_per_mm: f64,
    /// Height of the paper the washes ran on.
    pub height: Raster<f32>,
    /// What every glaze left, from the paper up.
    pub glazes: Vec<PaintedGlaze>,
}

/// What a glaze left on the paper.
#[derive(Clone, Debug)]
pub struct PaintedGlaze {
    /// The state of its wash.
    pub state: WashState,
    /// Each pigment's balance.
    pub pigments: Vec<PigmentBalance>,
}

/// Where a pigment of a glaze went.
#[derive(Clone, Debug, PartialEq)]
pub struct PigmentBalance {
    /// Id of the pigment.
    pub name: String,
    /// Sum of what was added.
    pub laid: f64,
    /// Sum of what was lifted.
    pub lifted: f64,
    /// Sum of what is there.
    pub total: f64,
}

/// Why a document cannot be painted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PaintError {
    /// It cannot be resolved.
    #[error(transparent)]
    Resolve(#[from] ResolveError),
    /// A glaze's state is not allowed.
    #[error("glaze {}: {source}", glaze + 1)]
    State {
        /// Which glaze, from 0.
        glaze: usize,
        /// What is wrong.
        source: StateError,
    },
    /// A glaze did not run to its end.
    #[error("glaze {}: {source}", glaze + 1)]
    Run {
        /// Which glaze, from 0.
        glaze: usize,
        /// Why.
        source: RunError,
    },
}

impl Document {
    /// Resolves, simulates and composites the document; `open` gives the bytes of a map's file.
    ///
    /// # Errors
    /// The document cannot be resolved, a wash ran away, or the caller cancelled.
    pub fn paint(
        &self,
        stock: &Stock,
        open: &dyn Fn(&str) -> std::io::Result<Vec<u8>>,
        config: &PaintConfig<'_>,
    ) -> Result<Painted, PaintError> {
        let plan = self.resolve(stock, open)?;
        let mut picture = plan.ground.clone();
        let mut glazes = Vec::new();
        let mut done = 0;
        for (index, (glaze, planned)) in self.glazes.iter().zip(&plan.glazes).enumerate() {
            let progress = |steps| {
                if let Some(progress) = config.progress {
                    progress(done + steps, self.steps());
                }
            };
            let (state, balances) = simulate(&plan, planned, index, config, &progress)?;
            done += glaze.steps();
            lay_over(&state, &planned.paints, &mut picture);
            let names = glaze.pigments.iter().zip(balances).zip(state.pigment_totals());
            let pigments = names.map(|((name, [laid, lifted]), total)| PigmentBalance {
                name: name.clone(),
                laid,
                lifted,
                total,
            });
            glazes.push(PaintedGlaze { pigments: pigments.collect(), state });
        }
        Ok(Painted {
            picture: reduced(&picture, self.sheet.cells_per_pixel as usize),
            pixels_per_mm: self.sheet.pixels_per_mm,
            height: plan.height,
            glazes,
        })
    }
}

/// Runs one glaze; returns its state, and what was laid and lifted of each pigment.
fn simulate(
    plan: &Plan,
    glaze: &PlannedGlaze,
    index: usize,
    config: &PaintConfig<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(WashState, Vec<[f64; 2]>), PaintError> {
    let pigments = glaze.handlings.len();
    let mut state = WashState::dry(&plan.height, pigments);
    if matches!(glaze.model, WashModel::Living(_)) {
        state.ledger = Some(Ledger::new(plan.cells_per_mm));
    }
    let mut wash = Easel::new(state, glaze, config.water)
        .map_err(|source| PaintError::State { glaze: index, source })?;
    let mut balances = vec![[0.0; 2]; pigments];
    let mut done = 0;
    for deed in &glaze.deeds {
        match deed {
            Deed::Wet(coverage) => wash.wet(patch(coverage)),
            Deed::Water(coverage) => {
                wash.add_water(patch(coverage));
            }
            Deed::Pigment(coverage, amounts) => {
                for (pigment, &amount) in amounts.iter().enumerate() {
                    let amounts = coverage.amount.map(|covered| covered * amount as f32);
                    balances[pigment][0] +=
                        wash.add_pigment(pigment, Patch { amounts: &amounts, ..patch(coverage) });
                }
            }
            Deed::Lift(coverage) => {
                for (balance, lifted) in balances.iter_mut().zip(wash.lift(patch(coverage))) {
                    balance[1] += lifted;
                }
            }
            Deed::Dry([base, slope]) => {
                let height = &plan.height;
                let state = wash.state();
                let damp = Raster::from_fn(height.width(), height.height(), |x, y| {
                    let wet = f64::from(state.wet_mask.cells(y)[x]);
                    (wet * (base + slope * f64::from(height.at(x, y))).max(0.0)) as f32
                });
                wash.dry();
                wash.soak(Patch::whole(&damp));
            }
            Deed::Moisten(coverage) => {
                wash.moisten(patch(coverage));
            }
            Deed::Blot(coverage) => {
                for (balance, blotted) in balances.iter_mut().zip(wash.blot(patch(coverage)).pigments) {
                    balance[1] += blotted;
                }
            }
            Deed::Tilt(degrees, toward) => wash.tilt(*degrees, *toward),
            Deed::DryWithin(coverage) => wash.dry_within(patch(coverage)),
            Deed::Run(planned) => {
                let report = |steps| progress(done + steps);
                let run = RunConfig {
                    threads: config.threads,
                    cancel: config.cancel,
                    progress: Some(&report),
                    ..RunConfig::default()
                };
                run_for(&mut wash, planned, &run)
                    .map_err(|source| PaintError::Run { glaze: index, source: counted_from(done, source) })?;
                done += u64::from(planned.steps);
            }
        }
    }
    Ok((wash.into_state(), balances))
}

/// Steps between looks at whether a wash is dry.
const STEPS_TO_LOOK: u64 = 8;

/// Lets a wash run as planned.
fn run_for(wash: &mut Easel, planned: &PlannedRun, config: &RunConfig<'_>) -> Result<(), RunError> {
    let steps = u64::from(planned.steps);
    // Water is fed before every step; dryness need not be looked for as often.
    let stride = match (&planned.feed, planned.until_dry) {
        (Some(_), _) => 1,
        (None, true) => STEPS_TO_LOOK,
        (None, false) => steps.max(1),
    };
    let mut done = 0;
    while done < steps && !(planned.until_dry && wash.is_dry()) {
        if let Some((feed, level)) = &planned.feed {
            let pressure = wash.film();
            let thirsty = Raster::from_fn(feed.amount.width(), feed.amount.height(), |x, y| {
                let full = pressure.cells(feed.y + y)[feed.x + x] >= *level;
                if full { 0.0 } else { feed.amount.at(x, y) }
            });
            wash.add_water(Patch { amounts: &thirsty, ..patch(feed) });
        }
        let now = stride.min(steps - done);
        let report = |step| {
            if let Some(progress) = config.progress {
                progress(done + step);
            }
        };
        wash.run(now, &RunConfig { progress: Some(&report), ..*config })
            .map_err(|source| counted_from(done, source))?;
        done += now;
    }
    Ok(())
}

/// The error with its steps counted from the glaze's first.
fn counted_from(before: u64, error: RunError) -> RunError {
    match error {
        RunError::RanAway { step, field, value, x, y, likely } => {
            RunError::RanAway { step: before + step, field, value, x, y, likely }
        }
        RunError::Cancelled { steps } => RunError::Cancelled { steps: before + steps },
        other => other,
    }
}

fn patch(coverage: &Coverage) -> Patch<'_> {
    Patch { x: coverage.x, y: coverage.y, amounts: &coverage.amount }
}

/// The mean color of every block of `factor` × `factor` cells, in linear light.
fn reduced(picture: &Raster<LinearRgb>, factor: usize) -> Raster<LinearRgb> {
    if factor == 1 {
        return picture.clone();
    }
    let weight = 1.0 / (factor * factor) as f64;
    Raster::from_fn(picture.width() / factor, picture.height() / factor, |x, y| {
        let mut sum = [0.0; 3];
        for row in y * factor..(y + 1) * factor {
            for color in &picture.row(row)[x * factor..(x + 1) * factor] {
                sum.iter_mut().zip(color.0).for_each(|(sum, channel)| *sum += channel);
            }
        }
        LinearRgb(sum.map(|sum| sum * weight))
    })
}
