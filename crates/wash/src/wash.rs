//! A wash over time.

use std::fmt;
use std::sync::atomic::AtomicBool;

use crate::engine::c97::C97Run;
use crate::engine::pools::Pools;
use crate::engine::{Stop, Task, still_dry_faces};
use crate::params::{C97Params, WashModel};
use crate::pigment::PigmentHandling;
use crate::state::{StateError, WashState};

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

/// A wash: its state, what it does, and its pigments.
#[derive(Debug)]
pub struct Wash {
    pub(crate) state: WashState,
    model: WashModel,
    handlings: Vec<PigmentHandling>,
    /// What the last run kept; `None` if where the water is has changed since.
    kept: Option<C97Run>,
    pool: Option<rayon::ThreadPool>,
}

impl Wash {
    /// A wash from a state, ready to run.
    ///
    /// # Errors
    /// A value of the state or of a pigment is not allowed, or their numbers differ.
    pub fn new(
        state: WashState,
        model: WashModel,
        handlings: Vec<PigmentHandling>,
    ) -> Result<Self, StateError> {
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
        Ok(Self { state, model, handlings, kept: None, pool: None })
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
        self.model = model;
        self.forget();
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
        if config.engine == Engine::Reference || config.threads == 1 {
            return self.run_here(steps, config, 1);
        }
        if config.threads == 0 {
            return self.run_here(steps, config, rayon::current_num_threads());
        }
        let pool = match self.pool.take() {
            Some(pool) if pool.current_num_threads() == config.threads => pool,
            _ => rayon::ThreadPoolBuilder::new()
                .num_threads(config.threads)
                .build()
                .map_err(|error| RunError::Threads { threads: config.threads, message: error.to_string() })?,
        };
        let report = pool.install(|| self.run_here(steps, config, config.threads));
        self.pool = Some(pool);
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
        let WashModel::C97 { params, capillary } = self.model;
        let exchanges = self.handlings.iter().map(PigmentHandling::exchange).collect();
        let task = Task::new(&params, capillary.as_ref(), exchanges);
        let mut kept = match self.kept.take() {
            Some(mut kept) if kept.pools.are_for(config.engine, threads) => {
                kept.pools.take(&mut self.state);
                kept
            }
            _ => {
                still_dry_faces(&mut self.state);
                C97Run::new(match config.engine {
                    Engine::Fast => Pools::new(&mut self.state, &task, threads),
                    Engine::Reference => Pools::plain(&mut self.state, &task),
                })
            }
        };
        let never = AtomicBool::new(false);
        let cancel = config.cancel.unwrap_or(&never);
        let mut ended = Ok(());
        for done in 0..steps {
            match kept.step(&task, cancel) {
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
        kept.pools.give_back(&mut self.state);
        match ended {
            Ok(()) => {
                self.kept = Some(kept);
                Ok(report)
            }
            Err((Stop::Cancelled, steps)) => Err(RunError::Cancelled { steps }),
            Err((Stop::RanAway, done)) => Err(self.ran_away(done + 1, &params)),
        }
    }

    /// Finds the face that ran away and what most likely drove it.
    fn ran_away(&self, step: u64, params: &C97Params) -> RunError {
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
