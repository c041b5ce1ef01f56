//! The row stages of which passes are made.

use super::world::Changes;
use crate::mix_pigment::Mixing;
use crate::relax_implicitly::Iteration;

/// What is done to a row. Every stage calls the kernels of one routine; which rows they are given is in `stages/`.
///
/// Both models are lists of these: [`AddSlope`](Self::AddSlope), [`Advance`](Self::Advance),
/// [`Transfer`](Self::Transfer) and [`Diffuse`](Self::Diffuse) are in both; the first five below them C97's only, the
/// rest the living wash's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// Adds the paper's slope to the velocities, and notes the largest speed; the living wash also as far as film can drive
    /// it.
    AddSlope,
    /// Adds the paper's slope to the velocities, and notes nothing.
    AddSlopeAlone,
    /// Advances the velocities by a sub-step of this length; the living wash notes the largest speed.
    Advance(f32),
    /// Advances the velocities by a sub-step of this length, and notes nothing.
    AdvanceAlone(f32),
    /// Exchanges pigment between water and paper.
    Transfer,
    /// Lets pore water creep; the number tells apart passes over the same field.
    Diffuse(usize),

    /// Notes the largest correction that the next relaxation sweep will make, without making it.
    FindCorrection,
    /// A relaxation sweep: the first or the second of its pass.
    Sweep(usize),
    /// The second relaxation sweep of its pass, which can be taken back while no correction of the first has been found to
    /// be above the tolerance.
    GuardedSweep,
    /// Draws water to the edges and notes the largest sum of outflow speeds.
    FlowOutward,
    /// Carries suspended pigment for a sub-step of this length.
    Carry(f32),
    /// Carries suspended pigment for a sub-step of this length, and exchanges it between water and paper.
    CarryAndTransfer(f32),
    /// Soaks water into the pores.
    Absorb,
    /// Wets cells whose pores are full.
    Spread,

    /// Finds how far each cell counts as wet for its neighbours' edges.
    Cover,
    /// Finds the mobility of all faces.
    Mobility,
    /// Finds what faces keep in a sub-step of this length.
    Keep(f32),
    /// Takes the divergence of the flow and begins to solve for what evens it out.
    BeginSolve {
        /// The first guess is the divergence times this.
        start: f32,
    },
    /// One iteration of the solution, numbered from 1.
    Iterate {
        /// Its number.
        number: usize,
        /// Its coefficients.
        iteration: Iteration,
        /// B r².
        stiffness: f32,
    },
    /// Gives the faces the flow that the solution asks for, after so many iterations.
    Project {
        /// Number of the last iteration.
        iterations: usize,
        /// B r².
        stiffness: f32,
    },
    /// Finds the share that each cell can give of what the flow asks; notes the largest sum of outflow speeds.
    Share(f32),
    /// Counts in what flows into each cell, numbered from 1.
    WidenShare(usize, f32),
    /// Moves the film, after so many widenings.
    MoveFilm(usize, f32),
    /// Dries the film.
    Evaporate,
    /// Carries and spreads suspended pigment for a sub-step of this length.
    CarryPacked(f32),
    /// Drops pigment out of thin film.
    Settle,
    /// Dries pores that no film covers.
    EvaporatePores,
    /// Soaks film into the pores.
    AbsorbFilm,

    /// Finds the film from coarser water.
    RefineFilm,
    /// Finds mobility and velocities from coarser water.
    RefineFlow,
    /// Notes the largest sum of outflow speeds.
    NoteOutflow,
    /// Mixes pigment along the rows.
    MixAlong(Mixing),
    /// Mixes pigment across the rows.
    MixDown(Mixing),
}

impl Stage {
    /// Rows above and below its own that the stages before must have done.
    pub fn reach(self) -> usize {
        match self {
            Self::CarryPacked(_) => 2,
            Self::Advance(_)
            | Self::AdvanceAlone(_)
            | Self::FindCorrection
            | Self::Sweep(_)
            | Self::GuardedSweep
            | Self::FlowOutward
            | Self::Diffuse(_)
            | Self::BeginSolve { .. }
            | Self::Iterate { .. }
            | Self::Project { .. }
            | Self::Share(_)
            | Self::WidenShare(..)
            | Self::MoveFilm(..)
            | Self::Settle
            | Self::AbsorbFilm
            | Self::RefineFlow
            | Self::NoteOutflow
            | Self::MixDown(_)
            | Self::Mobility => 1,
            Self::AddSlope
            | Self::AddSlopeAlone
            | Self::Carry(_)
            | Self::CarryAndTransfer(_)
            | Self::Transfer
            | Self::Absorb
            | Self::Spread
            | Self::Cover
            | Self::Keep(_)
            | Self::Evaporate
            | Self::EvaporatePores
            | Self::RefineFilm
            | Self::MixAlong(_) => 0,
        }
    }

    /// Fields that it changes.
    pub fn changes(self) -> Changes {
        match self {
            Self::FindCorrection
            | Self::BeginSolve { .. }
            | Self::Iterate { .. }
            | Self::Share(_)
            | Self::WidenShare(..) => Changes::NOTHING,
            Self::AddSlope
            | Self::AddSlopeAlone
            | Self::Advance(_)
            | Self::AdvanceAlone(_)
            | Self::Project { .. } => Changes::FLOW,
            Self::Sweep(_) | Self::GuardedSweep => Changes::FLOW | Changes::PRESSURE,
            Self::FlowOutward | Self::MoveFilm(..) | Self::Evaporate => Changes::PRESSURE,
            Self::Carry(_) | Self::CarryPacked(_) | Self::MixAlong(_) | Self::MixDown(_) => {
                Changes::SUSPENDED
            }
            Self::CarryAndTransfer(_) | Self::Transfer | Self::Settle => {
                Changes::SUSPENDED | Changes::DEPOSITED
            }
            Self::Absorb | Self::Diffuse(_) | Self::EvaporatePores => Changes::SATURATION,
            Self::AbsorbFilm => Changes::SATURATION | Changes::PRESSURE,
            Self::Spread => Changes::MASK,
            Self::Cover => Changes::COVER,
            Self::Mobility => Changes::MOBILITY,
            Self::Keep(_) => Changes::KEEP,
            Self::RefineFilm => Changes::PRESSURE,
            Self::RefineFlow => Changes::MOBILITY | Changes::FLOW,
            Self::NoteOutflow => Changes::NOTHING,
        }
    }

    /// Whether it works on damp paper, and not only where the paper is wet.
    pub fn is_of_pores(self) -> bool {
        matches!(self, Self::Absorb | Self::Diffuse(_) | Self::Spread | Self::Cover | Self::EvaporatePores)
    }

    /// Whether it reads what only the stage before it in the same pass keeps, or may be taken back together with it.
    pub fn continues(self) -> bool {
        matches!(
            self,
            Self::Iterate { .. }
                | Self::Project { .. }
                | Self::WidenShare(..)
                | Self::MoveFilm(..)
                | Self::GuardedSweep
                | Self::FlowOutward
        )
    }
}
