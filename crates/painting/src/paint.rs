//! A plan is carried out: each glaze is simulated, then all are laid over each other.

use std::sync::atomic::AtomicBool;

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use girtin_wash::{Ledger, Patch, RunConfig, RunError, StateError, WashModel, WashState};

use crate::area::Coverage;
use crate::develop::Development;
use crate::document::{Document, Glaze, Stock};
use crate::dried::Dried;
use crate::easel::Easel;
use crate::maps::Maps;
use crate::resolve::{Deed, PlannedGlaze, PlannedRun, PlannedSheet, ResolveError};

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
#[derive(Debug)]
pub struct Painted {
    /// The sheet.
    pub sheet: PlannedSheet,
    /// What every glaze left, from the paper up.
    pub glazes: Vec<PaintedGlaze>,
}

impl Painted {
    /// To be seen.
    pub fn development(&self) -> Development<'_> {
        self.development_of(self.glazes.len())
    }

    /// The first so many glazes, to be seen.
    pub fn development_of(&self, glazes: usize) -> Development<'_> {
        let glazes = &self.glazes[..glazes.min(self.glazes.len())];
        Development::new(&self.sheet, glazes.iter().map(|glaze| (&glaze.dried, &glaze.plan)))
    }

    /// The picture, in linear light.
    pub fn picture(&self) -> Raster<LinearRgb> {
        self.development().picture()
    }
}

/// What a glaze left on the paper.
#[derive(Clone, Debug)]
pub struct PaintedGlaze {
    /// Its pigments and its outline.
    pub plan: PlannedGlaze,
    /// The state of its wash.
    pub state: WashState,
    /// What of it is seen.
    pub dried: Dried,
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
    /// Resolves and simulates the document.
    ///
    /// # Errors
    /// The document cannot be resolved, a wash ran away, or the caller cancelled.
    pub fn paint(
        &self,
        stock: &Stock,
        maps: &dyn Maps,
        config: &PaintConfig<'_>,
    ) -> Result<Painted, PaintError> {
        let plan = self.resolve(stock, maps)?;
        let mut glazes = Vec::new();
        let mut done = 0;
        for (index, (glaze, planned)) in self.glazes.iter().zip(plan.glazes).enumerate() {
            let progress = |steps, _| {
                if let Some(progress) = config.progress {
                    progress(done + steps, self.steps());
                }
            };
            let config = PaintConfig { progress: Some(&progress), ..*config };
            glazes.push(paint_glaze(&plan.sheet, glaze, planned, index, &config)?);
            done += glaze.steps();
        }
        Ok(Painted { sheet: plan.sheet, glazes })
    }
}

/// Simulates one glaze on dry paper; `index` is its number, from 0, for errors.
///
/// # Errors
/// The wash ran away, or the caller cancelled.
pub fn paint_glaze(
    sheet: &PlannedSheet,
    glaze: &Glaze,
    mut plan: PlannedGlaze,
    index: usize,
    config: &PaintConfig<'_>,
) -> Result<PaintedGlaze, PaintError> {
    let progress = |steps| {
        if let Some(progress) = config.progress {
            progress(steps, glaze.steps());
        }
    };
    let (state, balances) = simulate(sheet, &plan, index, config, &progress)?;
    let marked = plan.figures.as_ref().map_or_else(Vec::new, |figures| figures.marked(sheet.cells_per_mm));
    let names = glaze.pigments.iter().zip(balances).zip(state.pigment_totals());
    let pigments = names.enumerate().map(|(pigment, ((name, [laid, lifted]), total))| {
        // Marks lie where they are made.
        let marked = marked.get(pigment).copied().unwrap_or(0.0);
        PigmentBalance { name: name.clone(), laid: laid + marked, lifted, total: total + marked }
    });
    let paper = (!sheet.samples_are_cells).then_some(&sheet.height);
    let laid = if plan.outline.is_some() { laid_by(&plan, &sheet.height) } else { Vec::new() };
    plan.deeds = Vec::new(); // done, and large
    let mut dried = Dried::new(&state, plan.outline.as_ref(), &laid, paper);
    if let Some(fill) = plan.figures.as_ref().and_then(|figures| figures.fill.as_ref()) {
        fill.complete(&mut dried.amounts);
    }
    Ok(PaintedGlaze { pigments: pigments.collect(), plan, state, dried })
}

/// What a plan brushes on of each pigment, water or not.
fn laid_by(plan: &PlannedGlaze, height: &Raster<f32>) -> Vec<Raster<f32>> {
    let mut laid = vec![Raster::new(height.width(), height.height(), 0.0f32); plan.handlings.len()];
    for deed in &plan.deeds {
        let Deed::Pigment(coverage, amounts) = deed else { continue };
        for (laid, &amount) in laid.iter_mut().zip(amounts) {
            for y in 0..coverage.amount.height() {
                let row = &mut laid.row_mut(coverage.y + y)[coverage.x..];
                let covered = coverage.amount.row(y);
                row.iter_mut().zip(covered).for_each(|(laid, covered)| *laid += covered * amount as f32);
            }
        }
    }
    laid
}

/// Runs one glaze; returns its state, and what was laid and lifted of each pigment.
fn simulate(
    plan: &PlannedSheet,
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
