//! A wash over time.

use std::fmt;
use std::sync::atomic::AtomicBool;

use crate::engine::c97::C97Run;
use crate::engine::living::LivingRun;
use crate::engine::pools::Pools;
use crate::engine::{REFERENCE, Stop, Task, still_dry_faces};
use crate::params::{C97Params, WashModel};
use crate::pigment::PigmentHandling;
use crate::state::{Ledger, StateError, WashState};
use crate::tiles::ChangedTiles;

/// Which engine runs the row kernels. Both give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Only where water is, in parallel.
    #[default]
    Fast,
    /// Routine by routine over the whole canvas, on one thread.
    Reference,
}

/// How a wash is run; nothing here changes a bit of the result.
#[derive(Clone, Copy, Default)]
pub struct RunConfig<'a> {
    /// Engine.
    pub engine: Engine,
    /// Number of threads; 0 takes those of the rayon pool this is called in.
    pub threads: usize,
    /// Set it to end the run early.
    pub cancel: Option<&'a AtomicBool>,
    /// Called after every step with the number of steps done.
    pub progress: Option<&'a (dyn Fn(u64) + Sync)>,
}

impl fmt::Debug for RunConfig<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { engine, threads, .. } = self;
        f.debug_struct("RunConfig").field("engine", engine).field("threads", threads).finish_non_exhaustive()
    }
}

impl RunConfig<'_> {
    /// Does work on the threads that are asked for, and tells it how many they are; a pool of them is kept in `kept`.
    pub(crate) fn on_threads<T: Send>(
        &self,
        kept: &mut Option<rayon::ThreadPool>,
        work: impl FnOnce(usize) -> Result<T, RunError> + Send,
    ) -> Result<T, RunError> {
        let threads = self.threads;
        if self.engine == Engine::Reference || threads == 1 {
            return work(1);
        }
        if threads == 0 {
            // On a thread of the pool, lest every pass be handed over to it.
            return rayon::scope(|_| work(rayon::current_num_threads()));
        }
        let pool = match kept.take() {
            Some(pool) if pool.current_num_threads() == threads => pool,
            _ => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|error| RunError::Threads { threads, message: error.to_string() })?,
        };
        let done = pool.install(|| work(threads));
        *kept = Some(pool);
        done
    }
}

/// What a run did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunReport {
    /// Steps done.
    pub steps: u64,
    /// Relaxation sweeps of all steps.
    pub sweeps_total: u64,
}

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The water ran away: a value is not finite or asks for more sub-steps than are reasonable (D4).
    #[error("the water ran away in step {step}: `{field}` is {value} at column {x}, row {y}; see `{likely}`")]
    RanAway {
        /// The step, from 1.
        step: u64,
        /// Field of the fastest face.
        field: &'static str,
        /// Its velocity, cells per step.
        value: f32,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The parameter or field that most likely did it.
        likely: &'static str,
    },
    /// The caller asked for it. The state may be amid a step and is good for looking at only.
    #[error("cancelled after {steps} steps")]
    Cancelled {
        /// Whole steps done.
        steps: u64,
    },
    /// No threads could be had.
    #[error("cannot start {threads} threads: {message}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// Why not.
        message: String,
    },
}

/// A run of either model, kept from call to call.
#[derive(Debug)]
enum Running {
    C97(C97Run),
    Living(LivingRun),
}

impl Running {
    fn pools(&mut self) -> &mut Pools {
        match self {
            Self::C97(run) => &mut run.pools,
            Self::Living(run) => &mut run.pools,
        }
    }

    /// Whether no paper is wet, if the pools know.
    fn is_dry(&self) -> Option<bool> {
        match self {
            Self::C97(run) => run.pools.is_dry(),
            Self::Living(run) => run.pools.is_dry(),
        }
    }
}

/// A wash: its state, what it does, and its pigments.
#[derive(Debug)]
pub struct Wash {
    pub(crate) state: WashState,
    pub(crate) model: WashModel,
    handlings: Vec<PigmentHandling>,
    /// What the last run kept; `None` if where the water is has changed since.
    kept: Option<Running>,
    pub(crate) changed: ChangedTiles,
    pool: Option<rayon::ThreadPool>,
}

impl Wash {
    /// A wash from a state, ready to run.
    ///
    /// # Errors
    /// A value of the state or of a pigment is not allowed, or their numbers differ.
    ///
    /// A living wash whose state has no [`Ledger`] has 4 cells a millimetre.
    pub fn new(
        mut state: WashState,
        model: WashModel,
        handlings: Vec<PigmentHandling>,
    ) -> Result<Self, StateError> {
        if matches!(model, WashModel::Living(_)) {
            state.ledger.get_or_insert(Ledger::new(REFERENCE));
        }
        state.check()?;
        let (suspended, deposited) = (state.suspended.len(), state.deposited.len());
        if suspended != handlings.len() || deposited != handlings.len() {
            return Err(StateError::Pigments { suspended, deposited, handlings: handlings.len() });
        }
        if let Some((pigment, fault)) =
            handlings.iter().enumerate().find_map(|(k, handling)| Some((k, handling.fault()?)))
        {
            return Err(StateError::Handling { pigment, fault });
        }
        let changed = ChangedTiles::new(state.layout());
        Ok(Self { state, model, handlings, kept: None, changed, pool: None })
    }

    /// The state.
    pub fn state(&self) -> &WashState {
        &self.state
    }

    /// The state, to keep.
    pub fn into_state(self) -> WashState {
        self.state
    }

    /// The physics.
    pub fn model(&self) -> &WashModel {
        &self.model
    }

    /// How each pigment behaves.
    pub fn handlings(&self) -> &[PigmentHandling] {
        &self.handlings
    }

    /// Changes the physics from the next step on.
    pub fn set_model(&mut self, model: WashModel) {
        if matches!(model, WashModel::Living(_)) {
            self.state.ledger.get_or_insert(Ledger::new(REFERENCE));
        }
        self.model = model;
        self.forget();
    }

    /// Leans the board: water runs down toward an angle, 0 to the right and 90 to the bottom, degrees. Only a living
    /// wash does.
    pub fn tilt(&mut self, degrees: f64, toward: f64) {
        if let WashModel::Living(params) = &mut self.model {
            params.tilt = degrees.clamp(0.0, 90.0);
            params.tilt_toward = toward;
            self.forget();
        }
    }

    /// How deep a film the water of full pores would make.
    pub(crate) fn pore_depth(&self) -> f64 {
        match &self.model {
            WashModel::C97 { .. } => 1.0,
            WashModel::Living(params) => f64::from(params.pore_depth as f32),
        }
    }

    /// Capacity of the paper's deepest valleys and highest peaks.
    pub(crate) fn capacity(&self) -> [f64; 2] {
        match &self.model {
            WashModel::C97 { capillary, .. } => capillary.unwrap_or_default().capacity,
            WashModel::Living(params) => params.capacity,
        }
    }

    /// Cells that hold one unit of [`Wash::water_total`].
    pub(crate) fn cells_per_unit(&self) -> f64 {
        match &self.model {
            WashModel::C97 { .. } => 1.0,
            WashModel::Living(_) => (self.cells_per_mm() / REFERENCE).powi(2),
        }
    }

    /// Forgets where the water was and how fast; the next run looks again.
    pub(crate) fn forget(&mut self) {
        self.kept = None;
    }

    /// Runs `steps` steps.
    ///
    /// Nothing of `config` changes a bit of the result, nor does cutting a run in two.
    ///
    /// # Errors
    /// The water ran away, or the caller cancelled.
    pub fn run(&mut self, steps: u64, config: &RunConfig<'_>) -> Result<RunReport, RunError> {
        let mut pool = self.pool.take();
        let report = config.on_threads(&mut pool, |threads| self.run_here(steps, config, threads));
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
        let task = self.task();
        // Pools borrow the whole state; this is none of their business.
        let mut ledger = self.state.ledger.take();
        let canvas = self.state.layout();
        let kept = self.kept.take();
        let kept = kept.and_then(|mut kept| kept.pools().are_for(config.engine, threads).then_some(kept));
        let mut running = match kept {
            Some(mut kept) => {
                kept.pools().take(&mut self.state);
                kept
            }
            None => {
                still_dry_faces(&mut self.state);
                let pools = match config.engine {
                    Engine::Fast => Pools::new(&mut self.state, &task, threads),
                    Engine::Reference => Pools::reference(&mut self.state, &task),
                };
                match self.model {
                    WashModel::C97 { .. } => Running::C97(C97Run::new(pools)),
                    WashModel::Living(_) => Running::Living(LivingRun::new(pools)),
                }
            }
        };
        let never = AtomicBool::new(false);
        let cancel = config.cancel.unwrap_or(&never);
        let mut ended = Ok(());
        running.pools().mark_tiles(&mut self.changed, canvas);
        for done in 0..steps {
            let stepped = match &mut running {
                Running::C97(run) => run.step(&task, cancel),
                Running::Living(run) => {
                    let ledger = ledger.get_or_insert(Ledger::new(REFERENCE));
                    run.step(&task, &mut self.state, ledger, done + 1 == steps, cancel)
                }
            };
            match stepped {
                Ok(sweeps) => report.sweeps_total += u64::from(sweeps),
                Err(stop) => {
                    ended = Err((stop, done));
                    break;
                }
            }
            report.steps = done + 1;
            if let Some(progress) = config.progress {
                progress(report.steps);
            }
        }
        if let (Running::C97(run), Ok(())) = (&mut running, &ended) {
            run.finish(&task);
        }
        running.pools().mark_tiles(&mut self.changed, canvas);
        running.pools().give_back(&mut self.state);
        self.state.ledger = ledger;
        match ended {
            Ok(()) => {
                self.kept = Some(running);
                Ok(report)
            }
            Err((Stop::Cancelled, steps)) => Err(RunError::Cancelled { steps }),
            Err((Stop::RanAway, done)) => Err(self.ran_away(done + 1)),
        }
    }

    /// The parameters as kernels need them.
    fn task(&self) -> Task {
        let exchanges =
            |lifting: f64| self.handlings.iter().map(|handling| handling.exchange(lifting)).collect();
        match &self.model {
            WashModel::C97 { params, capillary } => Task::c97(params, capillary.as_ref(), exchanges(1.0)),
            WashModel::Living(params) => Task::living(params, self.cells_per_mm(), exchanges(params.lifting)),
        }
    }

    /// Cells a millimetre of paper; 4 if the state does not say.
    pub fn cells_per_mm(&self) -> f64 {
        self.state.ledger.map_or(REFERENCE, |ledger| ledger.cells_per_mm)
    }

    /// Whether no paper is wet; pores may still be damp.
    pub fn is_dry(&self) -> bool {
        if let Some(is_dry) = self.kept.as_ref().and_then(Running::is_dry) {
            return is_dry;
        }
        let layout = self.state.layout();
        layout.rows().all(|row| self.state.wet_mask.row(row).iter().all(|&wet| wet == 0))
    }

    /// The water that is there.
    ///
    /// Of a living wash that is film and pore water, film × reference cells (0.25 mm square), so that
    /// it means the same at any resolution; with what evaporated and was blotted it makes up what was poured on. Of C97's
    /// see [`WashState::water_total`].
    pub fn water_total(&self) -> f64 {
        match &self.model {
            WashModel::C97 { .. } => self.state.water_total(),
            WashModel::Living(_) => self.state.film_and_pores(self.pore_depth()) / self.cells_per_unit(),
        }
    }

    /// Finds the face that ran away and what most likely drove it.
    pub(crate) fn ran_away(&self, step: u64) -> RunError {
        let mut worst = ("u", 0.0f32, 0, 0);
        for (name, field) in [("u", &self.state.u), ("v", &self.state.v)] {
            for y in 0..=self.state.layout().height() {
                for (x, &value) in field.faces(y).iter().enumerate() {
                    // A value that is no number is worse than any other, and the first one is enough.
                    if value.abs() > worst.1.abs() || (value.is_nan() && !worst.1.is_nan()) {
                        worst = (name, value, x, y);
                    }
                }
            }
        }
        let pressure = (0..self.state.layout().height())
            .flat_map(|y| self.state.pressure.cells(y))
            .fold(0.0f32, |most, p| if p.abs() <= most { most } else { p.abs() });
        let params = match self.model {
            WashModel::C97 { params, .. } => params,
            WashModel::Living(_) => C97Params { viscosity: 0.0, ..C97Params::default() },
        };
        let likely = if params.viscosity > 0.25 {
            "viscosity"
        } else if params.relax_rate > 0.25 {
            "relax_rate"
        } else if params.slope_scale > 2.0 && pressure < 100.0 {
            "slope_scale"
        } else {
            "pressure"
        };
        let (field, value, x, y) = worst;
        RunError::RanAway { step, field, value, x, y, likely }
    }
}
