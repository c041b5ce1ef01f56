//! The row stages of which passes are made.

use super::world::Changes;

/// What is done to a row. Every stage calls the kernels of one routine; which rows they are given is in `stages/`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// Adds the paper's slope to the velocities and notes the fastest.
    AddSlope,
    /// Advances the velocities by a sub-step of this length.
    Advance(f32),
    /// Notes the largest correction that the next relaxation sweep will make, without making it.
    FindCorrection,
    /// A relaxation sweep: the first or the second of its pass.
    Sweep(usize),
    /// Draws water to the edges and notes the largest sum of outflow speeds.
    FlowOutward,
    /// Carries suspended pigment for a sub-step of this length.
    Carry(f32),
    /// Exchanges pigment between water and paper.
    Transfer,
    /// Soaks water into the pores.
    Absorb,
    /// Lets pore water creep; the number tells apart passes over the same field.
    Diffuse(usize),
    /// Wets cells whose pores are full.
    Spread,
}

impl Stage {
    /// Rows above and below its own that the stages before must have done.
    pub fn reach(self) -> usize {
        match self {
            Self::AddSlope | Self::Carry(_) | Self::Transfer | Self::Absorb | Self::Spread => 0,
            Self::Advance(_)
            | Self::FindCorrection
            | Self::Sweep(_)
            | Self::FlowOutward
            | Self::Diffuse(_) => 1,
        }
    }

    /// Fields that it changes.
    pub fn changes(self) -> Changes {
        match self {
            Self::FindCorrection => Changes::NOTHING,
            Self::AddSlope | Self::Advance(_) => Changes::FLOW,
            Self::Sweep(_) => Changes::FLOW | Changes::PRESSURE,
            Self::FlowOutward => Changes::PRESSURE,
            Self::Carry(_) => Changes::SUSPENDED,
            Self::Transfer => Changes::SUSPENDED | Changes::DEPOSITED,
            Self::Absorb | Self::Diffuse(_) => Changes::SATURATION,
            Self::Spread => Changes::MASK,
        }
    }

    /// Whether it works on damp paper, and not only where the paper is wet.
    pub fn is_of_pores(self) -> bool {
        matches!(self, Self::Absorb | Self::Diffuse(_) | Self::Spread)
    }
}
