//! How row kernels become steps.
//!
//! A model is a list of passes, a pass a list of row stages ([`stage`]) that go down the rows together ([`pipeline`]).
//! There is one mechanism for both models, and for both engines: the fast one runs whole passes in bands over the runs
//! of wet cells of each pool; the reference runs every routine by itself over the whole canvas. They give the same bits.

pub mod c97;
mod crew;
pub mod living;
mod facts;
pub mod ground;
mod pipeline;
pub mod fine;
pub mod pool;
pub mod pools;
mod rows;
mod scratch;
mod stage;
pub mod stages;
mod world;

use std::sync::atomic::{AtomicBool, Ordering};

use crate::creep;
use crate::dry::Vanishing;
use crate::mobility::Film;
use crate::params::{C97Params, Capillary, LivingParams};
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
    /// K, cells.
    pub edge_kernel: f64,
    pub relax_rate: f32,
    pub relax_tolerance: f32,
    pub relax_max_sweeps: u32,
    pub exchanges: Vec<Exchange>,
    pub pores: Option<Pores>,
    /// What the living wash needs besides; `None` for C97.
    pub living: Option<LivingTask>,
}

/// The parameters of the living wash in cells.
#[derive(Clone, Debug)]
pub struct LivingTask {
    /// r: cells to a reference cell of 0.25 mm.
    pub scale: f64,
    /// Cells over which the slope term sees the mean height.
    pub slope_band: f64,
    /// What a tilted board adds to u and v in a step.
    pub pull: [f32; 2],
    pub compressibility: f64,
    /// r².
    pub stiffness: f32,
    pub speed_limit: f32,
    pub film: Film,
    pub evaporation: f32,
    pub pore_evaporation: f32,
    pub pore_depth: f32,
    /// The most film that soaks in in a step.
    pub most_soaked: f32,
    pub rim_exponent: u32,
    /// Pigment diffusion, cells² per step.
    pub diffusion: f32,
    /// Cells over which flow mixes pigment.
    pub dispersion: f32,
    /// Whether pigment is mixed by itself after it is carried; else while it is.
    pub is_mixed_apart: bool,
    pub packing_limit: f32,
    /// How often what flows into thin film is counted in.
    pub widenings: usize,
    pub settling: f32,
    /// Passes of capillary diffusion in a step.
    pub pore_passes: usize,
    pub vanishing: Vanishing,
    pub contact: creep::Edge,
    /// Cells that an edge may advance in a step.
    pub creep: f64,
}

/// Reference cells a millimetre: r = 1.
pub const REFERENCE: f64 = 4.0;
/// What a board that stands upright adds to the velocity of water in a step, reference cells.
const GRAVITY: f64 = 0.2;
/// How often what flows into thin film is counted in, a reference cell: as far as water may pass in a step, there and back.
const WIDENINGS: f64 = 2.0;

impl Task {
    /// C97's task.
    pub fn c97(params: &C97Params, capillary: Option<&Capillary>, exchanges: Vec<Exchange>) -> Self {
        Self {
            momentum: Momentum {
                dt: 1.0,
                viscosity: params.viscosity as f32,
                viscous_drag: params.viscous_drag as f32,
            },
            edge_darkening: params.edge_darkening,
            edge_kernel: f64::from(params.edge_kernel),
            slope_scale: params.slope_scale as f32,
            relax_rate: params.relax_rate as f32,
            relax_tolerance: params.relax_tolerance as f32,
            relax_max_sweeps: params.relax_max_sweeps,
            exchanges,
            pores: capillary.map(Pores::from),
            living: None,
        }
    }

    /// The living wash's task: millimetres become cells.
    pub fn living(params: &LivingParams, cells_per_mm: f64, exchanges: Vec<Exchange>) -> Self {
        let scale = cells_per_mm / REFERENCE;
        let area = scale * scale;
        // The living wash's own passes are at the limit of stability, a quarter.
        let passes = libm::ceil(area).max(1.0);
        let steepness = GRAVITY * libm::sin(params.tilt.to_radians()) * scale;
        let toward = params.tilt_toward.to_radians();
        let [least, most] = params.capacity;
        Self {
            momentum: Momentum {
                dt: 1.0,
                viscosity: (params.viscosity * cells_per_mm * cells_per_mm) as f32,
                viscous_drag: params.viscous_drag as f32,
            },
            slope_scale: (params.slope_scale * area) as f32,
            edge_darkening: params.edge_darkening,
            edge_kernel: params.edge_width * cells_per_mm,
            relax_rate: 0.0,
            relax_tolerance: 0.0,
            relax_max_sweeps: 0,
            exchanges,
            pores: Some(Pores::living(params, 0.25 * area / passes)),
            living: Some(LivingTask {
                scale,
                slope_band: params.slope_band * cells_per_mm,
                pull: [libm::cos(toward), libm::sin(toward)].map(|part| (steepness * part) as f32),
                compressibility: params.compressibility,
                stiffness: area as f32,
                speed_limit: (params.speed_limit * cells_per_mm) as f32,
                film: Film { flowing: params.flowing_film as f32, least: params.least_mobility as f32 },
                evaporation: params.evaporation as f32,
                pore_evaporation: params.pore_evaporation as f32,
                pore_depth: params.pore_depth as f32,
                most_soaked: (params.pore_depth * params.absorption) as f32,
                rim_exponent: params.rim_exponent,
                diffusion: (params.pigment_diffusion * cells_per_mm * cells_per_mm) as f32,
                dispersion: (params.pigment_dispersion * cells_per_mm) as f32,
                is_mixed_apart: false,
                packing_limit: params.packing_limit as f32,
                widenings: libm::ceil(WIDENINGS * scale).max(1.0) as usize,
                settling: params.settling as f32,
                pore_passes: passes as usize,
                vanishing: Vanishing {
                    thinnest: (2.0 * params.drying_film) as f32,
                    refilling: params.wetting_film as f32,
                },
                contact: creep::Edge {
                    wetting: params.wetting_film as f32,
                    pinning: params.pinning as f32,
                    roughness: params.pin_roughness as f32,
                    share: params.creep_share as f32,
                    capacity: least as f32,
                    capacity_range: (most - least) as f32,
                },
                creep: params.creep_speed * cells_per_mm,
            }),
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
