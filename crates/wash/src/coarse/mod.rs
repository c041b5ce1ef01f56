//! Water coarse, pigment fine: a cheap living wash for previews and large prints.
//!
//! The water – its flow, film and pores, where it creeps and dries – is a [`Wash`] of its own without pigment. Pigment, the
//! edge of the wet paper as it is seen, and the grain that pigment settles in are finer by a whole factor. Water is
//! nearly all of a step's cost, so a step costs a part of what it would with all of it fine; and a print made so is the
//! painting made at the coarse resolution, with fine edges and grain.
//!
//! Fine cells see the flow linearly between coarse faces, which keeps its divergence, and the film linearly between
//! coarse cells. The fine wet mask begins as it is drawn; a coarse cell is wet as soon as any fine one in it is. Then it
//! follows the water: where that creeps, to the smoothed edge of the coarse cells, frayed by the grain; where it dries,
//! by the rule of the wash with the film that the fine cell sees.

mod shore;

use std::sync::atomic::AtomicBool;

use girtin_grid::{Field, Layout, Raster};

use crate::edit::{Patch, Taken};
use crate::engine::fine::move_pigment;
use crate::engine::pool::Pool;
use crate::engine::stages::refine::CoarseWater;
use crate::engine::{REFERENCE, Stop, Task};
use crate::interpolate::MOST_FACTOR;
use crate::mix_pigment::Mixing;
use crate::params::{LivingParams, WashModel};
use crate::pigment::PigmentHandling;
use crate::state::{Ledger, StateError, WashState};
use crate::tiles::Tile;
use crate::wash::{RunConfig, RunError, RunReport, Wash};
use shore::{Front, Shore};

/// A living wash whose pigment is finer than its water.
///
/// ```
/// use girtin_grid::Raster;
/// use girtin_wash::{CoarseWash, LivingParams, Patch, PigmentHandling, RunConfig, WashState};
///
/// let rose = PigmentHandling { density: 0.02, staining_power: 5.5, granulation: 0.81 };
/// let paper = WashState::dry(&Raster::new(64, 48, 0.5), 1);
/// let mut wash = CoarseWash::new(paper, LivingParams::default(), vec![rose], 4)?;
/// let stroke = Raster::new(40, 24, 0.5);
/// let patch = Patch { x: 12, y: 12, amounts: &stroke };
/// wash.wet(patch);
/// wash.add_water(patch);
/// let added = wash.add_pigment(0, patch);
/// wash.run(20, &RunConfig::default())?;
/// assert!((wash.state().pigment_totals()[0] - added).abs() < 1e-6 * added);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CoarseWash {
    /// Water without pigment.
    water: Wash,
    /// Pigment, and what it sees of the water; it never runs by itself.
    fine: Wash,
    factor: usize,
    params: LivingParams,
    shore: Shore,
    /// What the last run kept; `None` if where the pigment is wet has changed since.
    kept: Option<Kept>,
    pool: Option<rayon::ThreadPool>,
}

/// A run of the fine cells, kept from call to call.
#[derive(Debug)]
struct Kept {
    pool: Pool,
    threads: usize,
}

impl CoarseWash {
    /// A wash from a fine state, `factor` of whose cells lie along one of the water's.
    ///
    /// Film and pore water of the state are meant over the water's cells. A state without [`Ledger`] has
    /// 4 · `factor` cells a millimetre, so that water has 4.
    ///
    /// # Errors
    /// The factor is not 2 to 8; else as [`Wash::new`].
    pub fn new(
        mut state: WashState,
        params: LivingParams,
        handlings: Vec<PigmentHandling>,
        factor: usize,
    ) -> Result<Self, StateError> {
        if !(2..=MOST_FACTOR).contains(&factor) {
            let allowed = "a whole number from 2 to 8";
            return Err(StateError::Number { name: "factor", value: factor as f64, allowed });
        }
        let ledger = *state.ledger.get_or_insert(Ledger::new(REFERENCE * factor as f64));
        let model = WashModel::Living(params);
        let fine = Wash::new(state, model, handlings)?;
        let state = fine.state();
        let size = [state.layout().width(), state.layout().height()];
        let mut water = WashState::dry(&means(&state.height, factor), 0);
        let cells_per_mm = ledger.cells_per_mm / factor as f64;
        water.ledger = Some(Ledger { cells_per_mm, contact_carry: 0.0, ..ledger });
        let mut shore = Shore::new(water.layout(), factor);
        shore.look(&state.wet_mask);
        for [x, y] in shore.holding() {
            water.wet_mask.cells_mut(y)[x] = 1;
        }
        let pores = means(&state.saturation, factor);
        for y in 0..water.layout().height() {
            water.saturation.cells_mut(y).copy_from_slice(pores.row(y));
        }
        let share = 1.0 / (factor * factor) as f32;
        for y in 0..size[1] {
            for x in (0..size[0]).filter(|&x| state.wet_mask.cells(y)[x] != 0) {
                water.pressure.cells_mut(y / factor)[x / factor] += share * state.pressure.cells(y)[x];
                for (coarse, fine, at) in
                    [(&mut water.u, &state.u, x % factor), (&mut water.v, &state.v, y % factor)]
                {
                    if at == 0 {
                        coarse.cells_mut(y / factor)[x / factor] += share * fine.cells(y)[x];
                    }
                }
            }
        }
        shore.draw(&water.wet_mask);
        let water = Wash::new(water, model, Vec::new())?;
        Ok(Self { water, fine, factor, params, shore, kept: None, pool: None })
    }

    /// Whether no paper is wet; pores may still be damp.
    pub fn is_dry(&self) -> bool {
        self.water.is_dry() && self.fine.is_dry()
    }

    /// Pigment and all that it sees, to keep, with the pore water of the cells of the water in each of their fine ones.
    pub fn into_state(self) -> WashState {
        let (factor, water) = (self.factor, self.water.into_state());
        let mut state = self.fine.into_state();
        for y in 0..state.layout().height() {
            let coarse = water.saturation.cells(y / factor);
            // Read before writing: pages of untouched paper stay untouched.
            if coarse.iter().any(|&saturation| saturation != 0.0) {
                for (x, saturation) in state.saturation.cells_mut(y).iter_mut().enumerate() {
                    *saturation = coarse[x / factor];
                }
            }
        }
        state
    }

    /// Pigment and all that it sees: velocities and film as of the last step. Pore water is in [`CoarseWash::water`].
    pub fn state(&self) -> &WashState {
        self.fine.state()
    }

    /// The water, on its own coarser grid.
    pub fn water(&self) -> &WashState {
        self.water.state()
    }

    /// Fine cells along a cell of the water.
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// The physics.
    pub fn params(&self) -> &LivingParams {
        &self.params
    }

    /// How each pigment behaves.
    pub fn handlings(&self) -> &[PigmentHandling] {
        self.fine.handlings()
    }

    /// Sum of each pigment, suspended and deposited, in fine cells.
    pub fn pigment_totals(&self) -> Vec<f64> {
        self.state().pigment_totals()
    }

    /// The water that is there, as [`Wash::water_total`].
    pub fn water_total(&self) -> f64 {
        self.water.water_total()
    }

    /// Wets the paper wherever the amount is above 0.
    pub fn wet(&mut self, patch: Patch<'_>) {
        self.fine.wet(patch);
        if let Some((at, amounts)) = self.gathered(patch, |_, _, amount| amount.max(0.0)) {
            self.water.wet(Patch { x: at[0], y: at[1], amounts: &amounts });
        }
        self.look_again();
    }

    /// Pours water on wet paper; the film of a cell of the water rises by the mean over its fine cells.
    ///
    /// Returns how much in all, in the unit of [`CoarseWash::water_total`].
    pub fn add_water(&mut self, patch: Patch<'_>) -> f64 {
        let share = 1.0 / (self.factor * self.factor) as f32;
        let mask = &self.fine.state.wet_mask;
        let wet_only =
            |x: usize, y: usize, amount: f32| if mask.cells(y)[x] != 0 { amount * share } else { 0.0 };
        match self.gathered(patch, wet_only) {
            Some((at, amounts)) => self.water.add_water(Patch { x: at[0], y: at[1], amounts: &amounts }),
            None => 0.0,
        }
    }

    /// Adds suspended pigment to the water on wet paper; returns how much in all.
    ///
    /// # Panics
    /// There is no such pigment.
    pub fn add_pigment(&mut self, pigment: usize, patch: Patch<'_>) -> f64 {
        self.fine.add_pigment(pigment, patch)
    }

    /// Lifts a fraction of each pigment, from the water and off the paper; returns how much of each.
    pub fn lift(&mut self, fraction: Patch<'_>) -> Vec<f64> {
        self.fine.lift(fraction)
    }

    /// Dries the whole wash: suspended pigment settles where it is, the water is gone and still.
    ///
    /// Pore water stays; see [`CoarseWash::soak`].
    pub fn dry(&mut self) {
        self.water.dry();
        self.fine.dry();
        self.keep_ledger();
        self.kept = None;
        self.shore = Shore::new(self.water.state().layout(), self.factor);
    }

    /// Blots a fraction of the film with the pigment in it, and of the water in the pores below, as a dry cloth does.
    ///
    /// What has settled stays on the paper; see [`CoarseWash::lift`].
    pub fn blot(&mut self, fraction: Patch<'_>) -> Taken {
        let pigments = self.fine.blot(fraction).pigments;
        let water = match self.mean(fraction, |_, _, fraction| fraction.clamp(0.0, 1.0)) {
            Some((at, amounts)) => self.water.blot(Patch { x: at[0], y: at[1], amounts: &amounts }).water,
            None => 0.0,
        };
        self.keep_ledger();
        Taken { water, pigments }
    }

    /// Dries a fraction of film and pore water, as warm air does; where all is dried the pigment settles.
    pub fn dry_within(&mut self, fraction: Patch<'_>) {
        self.fine.dry_within(fraction);
        if let Some((at, amounts)) = self.mean(fraction, |_, _, fraction| fraction.clamp(0.0, 1.0)) {
            self.water.dry_within(Patch { x: at[0], y: at[1], amounts: &amounts });
        }
        self.keep_ledger();
        self.look_again();
    }

    /// Sets the water in the pores, to the mean over each cell of the water.
    ///
    /// Returns how much was added, less what was taken, in the unit of [`CoarseWash::water_total`].
    pub fn soak(&mut self, patch: Patch<'_>) -> f64 {
        let (Some((at, covered)), Some((_, mut amounts))) =
            (self.mean(patch, |_, _, _| 1.0), self.mean(patch, |_, _, amount| amount.max(0.0)))
        else {
            return 0.0;
        };
        let saturation = &self.water.state().saturation;
        for y in 0..amounts.height() {
            for (x, amount) in amounts.row_mut(y).iter_mut().enumerate() {
                *amount += saturation.cells(at[1] + y)[at[0] + x] * (1.0 - covered.row(y)[x]);
            }
        }
        self.water.soak(Patch { x: at[0], y: at[1], amounts: &amounts })
    }

    /// Moistens the paper with so many pore volumes of water: pores fill first, what they cannot hold stands as film.
    ///
    /// Returns how much was added, in the unit of [`CoarseWash::water_total`].
    pub fn moisten(&mut self, patch: Patch<'_>) -> f64 {
        let Some((at, amounts)) = self.mean(patch, |_, _, amount| amount.max(0.0)) else { return 0.0 };
        let [least, most] = self.params.capacity;
        let water = self.water.state();
        let mut overflows = Raster::new(patch.amounts.width(), patch.amounts.height(), 0.0);
        let layout = self.state().layout();
        patch.each(layout.width(), layout.height(), |x, y, amount| {
            let (row, column) = (y / self.factor, x / self.factor);
            let capacity = f64::from(water.height.cells(row)[column]) * (most - least) + least;
            let fill = f64::from(water.saturation.cells(row)[column]) / capacity;
            if amount > 0.0 && fill + f64::from(amount) > 1.0 {
                overflows.row_mut(y - patch.y)[x - patch.x] = 1.0;
            }
        });
        let added = self.water.moisten(Patch { x: at[0], y: at[1], amounts: &amounts });
        self.wet(Patch { amounts: &overflows, ..patch });
        added
    }

    /// Leans the board: water runs down toward an angle, 0 to the right and 90 to the bottom, degrees.
    pub fn tilt(&mut self, degrees: f64, toward: f64) {
        self.water.tilt(degrees, toward);
        if let WashModel::Living(params) = self.water.model() {
            self.params = *params;
        }
    }

    /// The tiles that may have changed since this was last asked, by edits and by running.
    pub fn take_changed_tiles(&mut self) -> Vec<Tile> {
        for tile in self.water.take_changed_tiles() {
            let [first, end] = [tile.x, tile.x + Tile::SIDE].map(|x| x * self.factor);
            for y in (tile.y * self.factor..(tile.y + Tile::SIDE) * self.factor).step_by(Tile::SIDE) {
                if y < self.fine.state().layout().height() {
                    self.fine.changed.mark(y, first, end, false);
                }
            }
        }
        self.fine.take_changed_tiles()
    }

    /// Evaporated and blotted water is the water's.
    fn keep_ledger(&mut self) {
        if let (Some(ledger), Some(water)) = (&mut self.fine.state.ledger, self.water.state().ledger) {
            (ledger.evaporated, ledger.blotted) = (water.evaporated, water.blotted);
        }
    }

    /// Either wet mask was changed by hand.
    fn look_again(&mut self) {
        self.kept = None;
        self.shore.look(&self.fine.state.wet_mask);
        self.shore.draw(&self.water.state.wet_mask);
    }

    /// Means over the water's cells of what the patch says of their fine ones; 0 where it says nothing.
    fn mean(
        &self,
        patch: Patch<'_>,
        value: impl Fn(usize, usize, f32) -> f32,
    ) -> Option<([usize; 2], Raster<f32>)> {
        let (at, mut sums) = self.gathered(patch, value)?;
        let size = [self.state().layout().width(), self.state().layout().height()];
        let along = |at: usize, size: usize| self.factor.min(size - at * self.factor);
        for y in 0..sums.height() {
            for (x, sum) in sums.row_mut(y).iter_mut().enumerate() {
                *sum /= (along(at[0] + x, size[0]) * along(at[1] + y, size[1])) as f32;
            }
        }
        Some((at, sums))
    }

    /// Sums over the water's cells, and where the first of them lies; `None` if the patch is off the canvas.
    fn gathered(
        &self,
        patch: Patch<'_>,
        value: impl Fn(usize, usize, f32) -> f32,
    ) -> Option<([usize; 2], Raster<f32>)> {
        let layout = self.state().layout();
        let first = [patch.x / self.factor, patch.y / self.factor];
        let cells = |at: usize, first: usize, count: usize, size: usize| {
            (at + count).min(size).div_ceil(self.factor).saturating_sub(first)
        };
        let width = cells(patch.x, first[0], patch.amounts.width(), layout.width());
        let height = cells(patch.y, first[1], patch.amounts.height(), layout.height());
        if width == 0 || height == 0 {
            return None;
        }
        let mut sums = Raster::new(width, height, 0.0);
        patch.each(layout.width(), layout.height(), |x, y, amount| {
            sums.row_mut(y / self.factor - first[1])[x / self.factor - first[0]] += value(x, y, amount);
        });
        Some((first, sums))
    }

    /// Runs `steps` steps.
    ///
    /// Nothing of `config` changes a bit of the result, nor does cutting a run in two. The reference engine runs the water
    /// only.
    ///
    /// # Errors
    /// As [`Wash::run`].
    pub fn run(&mut self, steps: u64, config: &RunConfig<'_>) -> Result<RunReport, RunError> {
        let mut pool = self.pool.take();
        let report = config.on_threads(&mut pool, |threads| {
            // The water is run from within the pool, or on this thread alone.
            let here = RunConfig { threads: if threads == 1 { 1 } else { 0 }, ..*config };
            self.run_here(steps, &here, threads)
        });
        self.pool = pool;
        report
    }

    fn run_here(
        &mut self,
        steps: u64,
        config: &RunConfig<'_>,
        threads: usize,
    ) -> Result<RunReport, RunError> {
        let mut report = RunReport::default();
        if steps == 0 {
            return Ok(report);
        }
        let exchange = |handling: &PigmentHandling| handling.exchange(self.params.lifting);
        let exchanges = self.fine.handlings().iter().map(exchange).collect();
        // Pores are the water's business.
        let mut task =
            Task { pores: None, ..Task::living(&self.params, self.fine.cells_per_mm(), exchanges) };
        if let Some(living) = &mut task.living {
            living.is_mixed_apart = living.dispersion >= Mixing::LEAST;
        }
        let lend = |state: &mut WashState| std::mem::replace(state, WashState::empty(Layout::new(0, 0), 0));
        let mut ledger = self.fine.state.ledger.take();
        let state = lend(&mut self.fine.state);
        let mut pool = match self.kept.take() {
            Some(Kept { mut pool, threads: before }) if before == threads => {
                *pool.state() = state;
                pool
            }
            _ => {
                let mut pool = Pool::new(state, None, &task, threads);
                *pool.water() = Some(CoarseWater::new(self.water.state().layout(), self.factor));
                pool
            }
        };
        self.mark_tiles(&pool);
        let mut ended = Ok(());
        for done in 0..steps {
            let carry = ledger.as_mut().map(|ledger| &mut ledger.contact_carry);
            match self.step(&mut pool, &task, carry, config) {
                Ok(sweeps) => report.sweeps_total += sweeps,
                Err(error) => {
                    ended = Err((error, done));
                    break;
                }
            }
            report.steps = done + 1;
            if let Some(progress) = config.progress {
                progress(report.steps);
            }
        }
        self.fine.state = lend(pool.state());
        self.fine.state.ledger = ledger;
        self.keep_ledger();
        self.mark_tiles(&pool);
        match ended {
            Ok(()) => {
                self.kept = Some(Kept { pool, threads });
                Ok(report)
            }
            Err((Ended::Water(error), done)) => Err(at_step(error, done)),
            Err((Ended::Pigment(Stop::Cancelled), steps)) => Err(RunError::Cancelled { steps }),
            Err((Ended::Pigment(Stop::RanAway), done)) => Err(self.fine.ran_away(done + 1)),
        }
    }

    /// Notes that pigment may change wherever cells are wet.
    fn mark_tiles(&mut self, pool: &Pool) {
        let [wet, _] = pool.runs();
        for (row, run) in wet {
            self.fine.changed.mark(row - Layout::TOP, run.first - Layout::LEFT, run.end - Layout::LEFT, true);
        }
    }

    /// One step; returns the relaxation's iterations.
    fn step(
        &mut self,
        pool: &mut Pool,
        task: &Task,
        carry: Option<&mut f64>,
        config: &RunConfig<'_>,
    ) -> Result<u64, Ended> {
        let water = self.water.run(1, &RunConfig { progress: None, ..*config });
        let sweeps = water.map_err(Ended::Water)?.sweeps_total;
        self.shore.follow(&self.water.state().wet_mask);
        let (Some(living), Some(mut lent)) = (&task.living, pool.water().take()) else { return Ok(sweeps) };
        let thinnest = self.shore.carry_on(self.water.state(), &mut lent.film);
        // Between faces nothing is faster than the faces.
        let fastest = self.factor as f32 * self.shore.fastest(self.water.state());
        let flow = |water: &mut WashState, lent: &mut CoarseWater| {
            std::mem::swap(&mut water.u, &mut lent.u);
            std::mem::swap(&mut water.v, &mut lent.v);
        };
        flow(&mut self.water.state, &mut lent);
        *pool.water() = Some(lent);
        let never = AtomicBool::new(false);
        let moved = move_pigment(pool, task, fastest, config.cancel.unwrap_or(&never));
        let Some(mut lent) = pool.water().take() else { return Ok(sweeps) };
        flow(&mut self.water.state, &mut lent);
        // The contact line.
        let water_task = Task::living(&self.params, self.water.cells_per_mm(), Vec::new());
        let carry = carry.map_or(0.0, |carry| {
            let sum = *carry + living.creep;
            *carry = sum.fract();
            sum - sum.fract()
        });
        let is_banded = pool.is_banded();
        if let Some(pores) = &water_task.pores {
            for _ in 0..carry as u64 {
                let WashState { wet_mask: mask, height, .. } = &*pool.state();
                let reached = self.shore.reached(
                    &Front {
                        water: self.water.state(),
                        film: &lent.film,
                        centers: &lent.centers,
                        mask,
                        height,
                        contact: &living.contact,
                        pores,
                    },
                    is_banded,
                );
                self.shore.join(&reached);
                for &[row, x] in &reached {
                    let (y, x) = (row - Layout::TOP, x - Layout::LEFT);
                    self.fine.changed.mark(y, x, x + 1, true);
                }
                pool.join(&reached);
            }
        }
        *pool.water() = Some(lent);
        // Where the water is gone altogether no cell stays wet, whatever its height.
        let gone = if !self.shore.is_wet() {
            pool.all_wet()
        } else if thinnest < living.vanishing.thinnest {
            pool.vanished(living.vanishing)
        } else {
            Vec::new()
        };
        self.shore.leave(&gone);
        pool.leave_dry(&gone);
        pool.follow_edge(task);
        match moved {
            Ok(()) => Ok(sweeps),
            Err(stop) => Err(Ended::Pigment(stop)),
        }
    }
}

/// Why a step did not end.
enum Ended {
    Water(RunError),
    Pigment(Stop),
}

/// The error of a step that was run by itself, as one of many.
fn at_step(error: RunError, done: u64) -> RunError {
    match error {
        RunError::RanAway { field, value, x, y, likely, .. } => {
            RunError::RanAway { step: done + 1, field, value, x, y, likely }
        }
        RunError::Cancelled { .. } => RunError::Cancelled { steps: done },
        other => other,
    }
}

/// Means over blocks of so many cells, of those that are on the canvas.
fn means(field: &Field<f32>, factor: usize) -> Raster<f32> {
    let layout = field.layout();
    let (width, height) = (layout.width(), layout.height());
    Raster::from_fn(width.div_ceil(factor), height.div_ceil(factor), |x, y| {
        let columns = x * factor..((x + 1) * factor).min(width);
        let rows = y * factor..((y + 1) * factor).min(height);
        let cells = rows.len() * columns.len();
        let sum: f64 = rows
            .map(|y| field.cells(y)[columns.clone()].iter().map(|&value| f64::from(value)).sum::<f64>())
            .sum();
        (sum / cells as f64) as f32
    })
}
