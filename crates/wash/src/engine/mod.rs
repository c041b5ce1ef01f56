//! How row kernels become steps.
//!
//! A model is a list of passes, a pass a list of row stages ([`stage`]) that go down the rows together ([`pipeline`]).
//! There is one mechanism for both models, and for both engines: the fast one runs whole passes in bands over the runs
//! of wet cells of each pool; the plain one runs every routine by itself over the whole canvas. They give the same bits.

pub mod c97;
mod pipeline;
mod pool;
pub mod pools;
mod rows;
mod scratch;
mod stage;
mod stages;
mod world;

use std::sync::atomic::{AtomicBool, Ordering};

use crate::params::{C97Params, Capillary};
use crate::pigment::Exchange;
use crate::simulate_capillary_flow::Pores;
use crate::state::WashState;
use crate::update_velocities::Momentum;

/// Sub-steps of one step beyond which a wash is taken to have run away (D4).
pub const MAX_SUBSTEPS: u32 = 10_000;

/// The parameters as kernels need them.
#[derive(Clone, Debug)]
pub struct Task {
    pub momentum: Momentum,
    pub slope_scale: f32,
    pub edge_darkening: f64,
    pub edge_kernel: u32,
    pub relax_rate: f32,
    pub relax_tolerance: f32,
    pub relax_max_sweeps: u32,
    pub exchanges: Vec<Exchange>,
    pub pores: Option<Pores>,
}

impl Task {
    pub fn new(params: &C97Params, capillary: Option<&Capillary>, exchanges: Vec<Exchange>) -> Self {
        Self {
            momentum: Momentum {
                dt: 1.0,
                viscosity: params.viscosity as f32,
                viscous_drag: params.viscous_drag as f32,
            },
            edge_darkening: params.edge_darkening,
            edge_kernel: params.edge_kernel,
            slope_scale: params.slope_scale as f32,
            relax_rate: params.relax_rate as f32,
            relax_tolerance: params.relax_tolerance as f32,
            relax_max_sweeps: params.relax_max_sweeps,
            exchanges,
            pores: capillary.map(Pores::from),
        }
    }

    fn momentum(&self, dt: f32) -> Momentum {
        Momentum { dt, ..self.momentum }
    }
}

/// Why a step did not end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// More than [`MAX_SUBSTEPS`], or a value that is not finite.
    RanAway,
    /// The caller asked for it.
    Cancelled,
}

/// How many sub-steps a largest speed asks for (D4).
///
/// `speed_bits` are those of a value that is not negative or not a number.
fn substeps(speed_bits: i32) -> Result<u32, Stop> {
    let speed = f32::from_bits(speed_bits as u32);
    if speed <= MAX_SUBSTEPS as f32 { Ok((speed.ceil() as u32).max(1)) } else { Err(Stop::RanAway) }
}

/// Ends a sweep or a step early if it has run away or the caller wishes.
fn go_on(largest_bits: i32, cancel: &AtomicBool) -> Result<(), Stop> {
    if !f32::from_bits(largest_bits as u32).is_finite() {
        Err(Stop::RanAway)
    } else if cancel.load(Ordering::Relaxed) {
        Err(Stop::Cancelled)
    } else {
        Ok(())
    }
}

/// Stills every face that touches a dry cell (D5), so that kernels need not look at dry cells again.
pub fn still_dry_faces(state: &mut WashState) {
    let layout = state.layout();
    for row in layout.rows().start..=layout.rows().end {
        let (above, here) = (state.wet_mask.row(row - 1), state.wet_mask.row(row));
        let moves = |faces: &[f32]| faces.iter().fold(0, |any, face| any | face.to_bits()) != 0;
        // Read before writing: pages of untouched paper stay untouched.
        if moves(state.u.row(row)) {
            for (face, both) in state.u.row_mut(row)[1..].iter_mut().zip(here.windows(2)) {
                *face = if both[0] & both[1] != 0 { *face } else { 0.0 };
            }
        }
        if moves(state.v.row(row)) {
            for ((face, above), here) in state.v.row_mut(row).iter_mut().zip(above).zip(here) {
                *face = if above & here != 0 { *face } else { 0.0 };
            }
        }
    }
}
