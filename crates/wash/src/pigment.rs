//! How a pigment behaves in water: three numbers, no color.

/// How a pigment settles, stains and granulates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PigmentHandling {
    /// ρ: the denser, the sooner it settles. Fraction of the suspended pigment a step, 0 to 1.
    pub density: f64,
    /// ω: the higher, the less of it is lifted again. At least the density.
    pub staining_power: f64,
    /// γ: how much more of it settles in the paper's valleys, 0 to 1.
    pub granulation: f64,
}

impl PigmentHandling {
    /// What is wrong with the numbers, if anything.
    pub(crate) fn fault(&self) -> Option<String> {
        let Self { density, staining_power, granulation } = *self;
        if !(0.0..=1.0).contains(&density) {
            Some(format!("density {density} is outside 0 to 1"))
        } else if !(staining_power.is_finite() && staining_power > 0.0 && staining_power >= density) {
            Some(format!("staining power {staining_power} is not at least the density {density} and above 0"))
        } else if !(0.0..=1.0).contains(&granulation) {
            Some(format!("granulation {granulation} is outside 0 to 1"))
        } else {
            None
        }
    }

    /// `lifting` times as much as in C97 is lifted.
    pub(crate) fn exchange(&self, lifting: f64) -> Exchange {
        Exchange {
            settling: self.density as f32,
            lifting: (self.density / self.staining_power * lifting) as f32,
            granulation: self.granulation as f32,
        }
    }
}

/// The same as the kernel needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// ρ.
    pub settling: f32,
    /// ρ / ω.
    pub lifting: f32,
    /// γ.
    pub granulation: f32,
}
