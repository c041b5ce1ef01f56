//! A glaze in the making, its water as fine as its pigment or coarser.

use girtin_grid::Field;
use girtin_wash::{
    CoarseWash, Patch, RunConfig, RunError, RunReport, StateError, Taken, Wash, WashModel, WashState,
};

use crate::paint::WaterDetail;
use crate::resolve::{Deed, PlannedGlaze};

/// Cells a millimetre that coarse water has, about.
const COARSE: f64 = 4.0;
/// Cells along one of the water's: fewer gain nothing, more are not simulated.
const FACTORS: std::ops::RangeInclusive<f64> = 2.0..=8.0;

/// A wash that takes a glaze's deeds.
#[derive(Debug)]
pub enum Easel {
    Full(Box<Wash>),
    Coarse(Box<CoarseWash>),
}

/// Does the same with either wash.
macro_rules! either {
    ($self:expr, $wash:ident => $deed:expr) => {
        match $self {
            Self::Full($wash) => $deed,
            Self::Coarse($wash) => $deed,
        }
    };
}

impl Easel {
    /// A wash for a glaze. On a board that leans all water is simulated: what streams down would print the coarse cells.
    pub fn new(state: WashState, glaze: &PlannedGlaze, water: WaterDetail) -> Result<Self, StateError> {
        let leans = glaze.deeds.iter().any(|deed| matches!(deed, Deed::Tilt(degrees, _) if *degrees > 0.0));
        let handlings = glaze.handlings.clone();
        let cells_per_mm = state.ledger.map_or(COARSE, |ledger| ledger.cells_per_mm);
        let factor = (cells_per_mm / COARSE).round().min(*FACTORS.end());
        match glaze.model {
            WashModel::Living(params)
                if water == WaterDetail::Coarse
                    && FACTORS.contains(&factor)
                    && !leans
                    && params.tilt == 0.0 =>
            {
                let wash = CoarseWash::new(state, params, handlings, factor as usize)?;
                Ok(Self::Coarse(Box::new(wash)))
            }
            model => Ok(Self::Full(Box::new(Wash::new(state, model, handlings)?))),
        }
    }

    pub fn state(&self) -> &WashState {
        either!(self, wash => wash.state())
    }

    /// The film that stands on the paper.
    pub fn film(&self) -> &Field<f32> {
        &self.state().pressure
    }

    pub fn is_dry(&self) -> bool {
        match self {
            Self::Full(wash) => wash.is_dry(),
            Self::Coarse(wash) => wash.is_dry(),
        }
    }

    pub fn wet(&mut self, patch: Patch<'_>) {
        either!(self, wash => wash.wet(patch));
    }

    pub fn add_water(&mut self, patch: Patch<'_>) {
        either!(self, wash => wash.add_water(patch));
    }

    pub fn add_pigment(&mut self, pigment: usize, patch: Patch<'_>) -> f64 {
        either!(self, wash => wash.add_pigment(pigment, patch))
    }

    pub fn moisten(&mut self, patch: Patch<'_>) {
        either!(self, wash => wash.moisten(patch));
    }

    pub fn soak(&mut self, patch: Patch<'_>) {
        either!(self, wash => wash.soak(patch));
    }

    pub fn lift(&mut self, fraction: Patch<'_>) -> Vec<f64> {
        either!(self, wash => wash.lift(fraction))
    }

    pub fn blot(&mut self, fraction: Patch<'_>) -> Taken {
        either!(self, wash => wash.blot(fraction))
    }

    pub fn tilt(&mut self, degrees: f64, toward: f64) {
        either!(self, wash => wash.tilt(degrees, toward));
    }

    pub fn dry(&mut self) {
        either!(self, wash => wash.dry());
    }

    pub fn dry_within(&mut self, fraction: Patch<'_>) {
        either!(self, wash => wash.dry_within(fraction));
    }

    pub fn run(&mut self, steps: u64, config: &RunConfig<'_>) -> Result<RunReport, RunError> {
        either!(self, wash => wash.run(steps, config))
    }

    pub fn into_state(self) -> WashState {
        match self {
            Self::Full(wash) => wash.into_state(),
            Self::Coarse(wash) => wash.into_state(),
        }
    }
}
