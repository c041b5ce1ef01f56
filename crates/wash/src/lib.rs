//! One wash of watercolor over time: water, pigment and the paper's pores, with no notion of color.
//!
//! The simulation of Curtis et al. 1997, §4: a wash is three layers of cells. Water flows over the wet paper and
//! carries suspended pigment; pigment settles and is lifted again; water soaks into the pores, creeps and wets new
//! paper.
//!
//! In the order data flows:
//! - [`params`]: what a wash is asked to do, a row per parameter;
//! - [`pigment`]: how a pigment settles, stains and granulates;
//! - [`state`]: every field at one moment;
//! - [`wash`]: a state that runs; [`edit`]: water and pigment poured on and lifted between steps;
//! - [`coarse`]: a cheap living wash, its water coarser than its pigment;
//! - `region`: which cells are worth visiting;
//! - one module of row kernels per routine of the paper, in the order of its main loop: [`update_velocities`],
//!   [`relax_divergence`], [`flow_outward`], [`move_pigment`], [`transfer_pigment`], [`simulate_capillary_flow`];
//! - `engine`: the two ways to run them, which give the same bits: a plain one, and a fast one that works only where
//!   water is.
//!
//! Deviations D1 to D7 from the printed paper are explained in `docs/paper-notes.md`.
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
