//! One wash of watercolor over time: water, pigment and the paper's pores, with no notion of color.
//!
//! A wash is three layers of cells. Water flows over the wet paper and carries suspended pigment; pigment settles and is
//! lifted again; water soaks into the pores, creeps and wets new paper. There are two models of that: the simulation of
//! Curtis et al. 1997, §4, exactly, and Girtin's own, the *living wash*, which has its lengths in millimetres, one amount of
//! water in film and pores, and dries by itself.
//!
//! In the order data flows:
//! - [`params`]: what a wash is asked to do, a row per parameter;
//! - [`pigment`]: how a pigment settles, stains and granulates;
//! - [`state`]: every field at one moment;
//! - [`wash`]: a state that runs; [`edit`]: water and pigment poured on and lifted between steps; [`tiles`]: what changed;
//! - [`coarse`]: a cheap living wash, its water coarser than its pigment;
//! - `region`: which cells are worth visiting; `band_limit`: the paper as the water feels it; `look_ahead`: rows to come;
//! - one module of row kernels per routine, in the order of a step. Of both models: [`update_velocities`],
//!   [`flow_outward`], [`transfer_pigment`], [`simulate_capillary_flow`]. Of the paper's alone: [`relax_divergence`],
//!   [`move_pigment`]. Of the living wash: [`mobility`], [`relax_implicitly`], [`move_film`], [`evaporate`],
//!   [`carry_packed`], [`settle`], [`creep`], [`dry`]; and of coarse water `interpolate` and `mix_pigment`;
//! - `engine`: a model is a list of passes over the rows. There are two ways to run them, which give the same bits: the
//!   reference, and a fast one that works only where water is.
//!
//! Deviations D1 to D7 from the printed paper, and what the living wash does beyond it, L1 to L14, are explained in
//! `docs/paper-notes.md`.
//!
//! ```
//! use girtin_grid::Raster;
//! use girtin_wash::{PigmentHandling, RunConfig, Wash, WashModel, WashState};
//!
//! let mut state = WashState::dry(&Raster::new(32, 32, 0.5), 1);
//! for y in 8..24 {
//!     state.wet_mask.cells_mut(y)[8..24].fill(1);
//!     state.pressure.cells_mut(y)[8..24].fill(0.7);
//!     state.suspended[0].cells_mut(y)[8..24].fill(0.4);
//! }
//! let ultramarine = PigmentHandling { density: 0.01, staining_power: 3.1, granulation: 0.91 };
//! let mut wash = Wash::new(state, WashModel::default(), vec![ultramarine])?;
//! wash.run(300, &RunConfig::default())?; // until it is dry
//! let d = &wash.state().deposited[0];
//! assert!(d.cells(16)[8] > d.cells(16)[16], "the edge is darker");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod params;
pub mod pigment;
pub mod state;
pub mod wash;
pub mod edit;
pub mod tiles;
pub mod coarse;

mod band_limit;
mod look_ahead;

#[doc(hidden)] // for the benches, which run row kernels by themselves
#[expect(clippy::len_without_is_empty, reason = "a run has at least one cell")]
pub mod region;

pub mod mobility;
pub mod update_velocities;
pub mod relax_divergence;
pub mod relax_implicitly;
pub mod move_film;
pub mod flow_outward;
pub mod evaporate;
pub mod interpolate;
pub mod move_pigment;
pub mod carry_packed;
pub mod mix_pigment;
pub mod transfer_pigment;
pub mod settle;
pub mod simulate_capillary_flow;
pub mod creep;
pub mod dry;

mod engine;

pub use coarse::CoarseWash;
pub use edit::{Patch, Taken};
pub use params::{C97Params, Capillary, LivingParams, WashModel};
pub use pigment::PigmentHandling;
pub use state::{Ledger, StateError, WashState};
pub use tiles::Tile;
pub use wash::{Engine, RunConfig, RunError, RunReport, Wash};
