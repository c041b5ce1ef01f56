//! Kubelka-Munk: light in a layer of paint, in a stack of layers, and in a mixture.
//!
//! R, T, K and S are [`Layer::reflectance`], [`Layer::transmittance`], [`Coefficients::absorption`] and
//! [`Coefficients::scattering`], as in Curtis et al. 1997, §5.

use crate::color::{LinearRgb, Srgb, decode_srgb};

/// Thickest layer that is told from an infinite one. Keeps products with coefficients finite.
const MAX_THICKNESS: f64 = 1e12;

/// How near to 0, to 1 and to each other reflectances over black and white may come before inversion (D8).
const APPEARANCE_MARGIN: f64 = 1e-5;

/// How strongly a pigment absorbs and scatters linear light, red, green and blue, at unit concentration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// K, fraction of light absorbed per unit of thickness; finite, not negative.
    pub absorption: [f64; 3],
    /// S, fraction of light scattered back per unit of thickness; finite, not negative.
    pub scattering: [f64; 3],
}

/// K and S as C97's figure 5 prints them. They were fitted to a monitor, so reflectances made of them are encoded
/// colors, not linear light (D8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// K as printed; finite, not negative.
    pub absorption: [f64; 3],
    /// S as printed; finite, not negative.
    pub scattering: [f64; 3],
}

/// What a layer, or a stack of layers, does to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// R, fraction of light sent back upward when lit from above.
    pub reflectance: [f64; 3],
    /// Fraction of light sent back downward when lit from below. In one homogeneous layer it is `reflectance`; in a
    /// stack of different layers it is not, and composition is only associative with both.
    pub reflectance_from_below: [f64; 3],
    /// T, fraction of light let through, the same both ways.
    pub transmittance: [f64; 3],
}

/// Colors over white and black that no layer of paint can show.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{channel} is {over_white:.6} over white and {over_black:.6} over black; paint needs 0 < black < white < 1"
)]
pub struct ImpossibleAppearance {
    /// `red`, `green` or `blue`.
    pub channel: &'static str,
    /// The channel over white.
    pub over_white: f64,
    /// The channel over black.
    pub over_black: f64,
}

impl ImpossibleAppearance {
    /// What to change.
    pub fn hint(&self) -> String {
        let Self { channel, over_white, over_black } = *self;
        if over_white.is_nan() || over_black.is_nan() {
            format!("give {channel} a number over white and over black")
        } else if over_white <= over_black && over_black <= 0.0 {
            format!("not even a dark paint reflects nothing: raise {channel} over white above 0")
        } else if over_white <= over_black && over_white >= 1.0 {
            format!("not even an opaque white covers black in one thin layer: lower {channel} over black")
        } else if over_white <= over_black {
            format!(
                "the ground shows through a thin layer: make {channel} over white brighter than over black"
            )
        } else if over_black <= 0.0 {
            format!("all paint scatters a little: raise {channel} over black slightly above 0")
        } else {
            format!("all paint absorbs a little: lower {channel} over white slightly below 1")
        }
    }
}

impl Coefficients {
    /// K and S of the paint that, in a layer of thickness 1, shows these colors over white and over black.
    ///
    /// # Source
    /// Curtis et al. 1997, §5.1.
    ///
    /// # Guarantees
    /// `layer(1.0)` shows both colors again to 1e-9 (`appearance_round_trips`).
    ///
    /// # Errors
    /// Unless 0 < over black < over white < 1 in every channel.
    pub fn from_appearance(
        over_white: LinearRgb,
        over_black: LinearRgb,
    ) -> Result<Self, ImpossibleAppearance> {
        let mut coefficients = Self::default();
        for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let (white, black) = (over_white.0[channel], over_black.0[channel]);
            // Written so that NaN is refused too.
            if !(0.0 < black && black < white && white < 1.0) {
                return Err(ImpossibleAppearance { channel: name, over_white: white, over_black: black });
            }
            (coefficients.absorption[channel], coefficients.scattering[channel]) = invert(white, black);
        }
        Ok(coefficients)
    }

    /// The same from colors as a screen shows them; 0 over black and 1 over white are allowed and mean "none that
    /// shows" (D8).
    ///
    /// # Errors
    /// Unless 0 ≤ over black < over white ≤ 1 in every channel; the error's numbers are the encoded ones.
    pub fn from_swatch(over_white: Srgb, over_black: Srgb) -> Result<Self, ImpossibleAppearance> {
        for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let (white, black) = (over_white.0[channel], over_black.0[channel]);
            if !(0.0 <= black && black < white && white <= 1.0) {
                return Err(ImpossibleAppearance { channel: name, over_white: white, over_black: black });
            }
        }
        Ok(Self::from_clamped(over_white.to_linear(), over_black.to_linear()))
    }

    /// K and S for linear light of a pigment of C97's figure 5: at thickness 1 over white and over black the encoded
    /// colors are the published ones, and in between paint composites as light does.
    ///
    /// # Deviations
    /// D8.
    ///
    /// # Guarantees
    /// The published color over white to 1e-6 (`published_colors_are_kept`).
    pub fn linear_from_published(published: &Published) -> Self {
        let encoded = Self { absorption: published.absorption, scattering: published.scattering }.layer(1.0);
        let over = |ground| LinearRgb(encoded.over_ground(ground).0.map(decode_srgb));
        Self::from_clamped(over(LinearRgb::WHITE), over(LinearRgb::BLACK))
    }

    /// Inverts colors that are in order but may touch the ends of their domain (D8).
    fn from_clamped(over_white: LinearRgb, over_black: LinearRgb) -> Self {
        const MARGIN: f64 = APPEARANCE_MARGIN;
        let mut coefficients = Self::default();
        for channel in 0..3 {
            let black = over_black.0[channel].clamp(MARGIN, 1.0 - 2.0 * MARGIN);
            let white = over_white.0[channel].clamp(black + MARGIN, 1.0 - MARGIN);
            (coefficients.absorption[channel], coefficients.scattering[channel]) = invert(white, black);
        }
        coefficients
    }

    /// What a layer of this paint does to light.
    ///
    /// # Source
    /// Curtis et al. 1997, §5.2.
    ///
    /// # Shapes and units
    /// `thickness`: 1 is the swatch; negative and NaN count as 0, infinity as very thick.
    ///
    /// # Guarantees
    /// Finite, R ≥ 0, T ≥ 0 and R + T ≤ 1 to rounding (`layers_make_no_light`); 0 is clear
    /// (`no_thickness_is_clear`); very thick tends to R∞ (`thick_layers_reach_the_masstone`).
    pub fn layer(&self, thickness: f64) -> Layer {
        let thickness = sane(thickness);
        let mut layer = Layer::CLEAR;
        for channel in 0..3 {
            let (reflectance, transmittance) =
                film(self.absorption[channel] * thickness, self.scattering[channel] * thickness);
            layer.reflectance[channel] = reflectance;
            layer.reflectance_from_below[channel] = reflectance;
            layer.transmittance[channel] = transmittance;
        }
        layer
    }
}

/// A thickness with which to compute: 0 for negative ones and NaN, finite for infinite ones.
#[inline]
fn sane(thickness: f64) -> f64 {
    if thickness > 0.0 { thickness.min(MAX_THICKNESS) } else { 0.0 }
}

/// K and S of one channel from its reflectance over white and over black, 0 < black < white < 1.
///
/// # Source
/// Curtis et al. 1997, §5.1.
fn invert(white: f64, black: f64) -> (f64, f64) {
    // As printed, a is near 1/(2 Rb) and its differences cancel. With q = (1 - Rw)(1 - Rb):
    //   a - 1 = q / 2Rb,    a + 1 = (q + 4Rb) / 2Rb,    b = sqrt((a - 1)(a + 1)),
    //   b^2 - (a - Rw)(a - 1) = (1 + Rw)(a - 1), so that coth's argument y has
    //   1/y = z = (1 - Rw)/(1 + Rw) sqrt((q + 4Rb)/q)   and   1 - z^2 = 4(Rw - Rb) / ((1 + Rw)^2 (1 - Rb)).
    let q = (1.0 - white) * (1.0 - black);
    let b = libm::sqrt(q * (q + 4.0 * black)) / (2.0 * black);
    let z = (1.0 - white) / (1.0 + white) * libm::sqrt((q + 4.0 * black) / q);
    let one_less_z = 4.0 * (white - black) / ((1.0 + white) * (1.0 + white) * (1.0 - black)) / (1.0 + z);
    let scattering = 0.5 * libm::log1p(2.0 * z / one_less_z) / b;
    (scattering * q / (2.0 * black), scattering)
}

/// R and T of one channel of a homogeneous layer, from its whole absorption K·x and scattering S·x.
///
/// # Source
/// Curtis et al. 1997, §5.2.
#[inline]
fn film(absorption: f64, scattering: f64) -> (f64, f64) {
    // With m = bSx = sqrt(Kx (Kx + 2Sx)), e = exp(-m) and sinh, cosh times 2e/m, no S is divided by and nothing
    // overflows: R = Sx E / c, T = 2e / c, E = (1 - e^2)/m, c = (Kx + Sx) E + 1 + e^2. E tends to 2 with m to 0.
    let m = libm::sqrt(absorption * (absorption + 2.0 * scattering));
    let less = libm::expm1(-m);
    let e = 1.0 + less;
    let width = if m > 0.0 { -less * (1.0 + e) / m } else { 2.0 };
    let c = (absorption + scattering) * width + 1.0 + e * e;
    (scattering * width / c, 2.0 * e / c)
}

impl Layer {
    /// No layer: nothing is reflected and everything let through.
    pub const CLEAR: Self =
        Self { reflectance: [0.0; 3], reflectance_from_below: [0.0; 3], transmittance: [1.0; 3] };

    /// This layer on top of another, as one.
    ///
    /// # Source
    /// Kubelka 1954; Curtis et al. 1997, §5.2. C97 builds stacks from the ground up, where only the reflectance from
    /// above is needed; with that from below any order of building gives the same (`over_is_associative`).
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        let mut stack = self;
        for channel in 0..3 {
            let (t1, t2) = (self.transmittance[channel], below.transmittance[channel]);
            let (r1, r2) = (self.reflectance_from_below[channel], below.reflectance[channel]);
            let between = 1.0 / bounces(r1, r2);
            stack.reflectance[channel] += t1 * t1 * r2 * between;
            stack.reflectance_from_below[channel] =
                below.reflectance_from_below[channel] + t2 * t2 * r1 * between;
            stack.transmittance[channel] = t1 * t2 * between;
        }
        stack
    }

    /// The color seen when this layer lies on a ground that lets no light through.
    pub fn over_ground(self, ground: LinearRgb) -> LinearRgb {
        let mut seen = self.reflectance;
        for (channel, seen) in seen.iter_mut().enumerate() {
            let (t, r) = (self.transmittance[channel], self.reflectance_from_below[channel]);
            *seen += t * t * ground.0[channel] / bounces(r, ground.0[channel]);
        }
        LinearRgb(seen)
    }
}

/// 1 - R1 R2, the divisor that sums all bounces between two layers. Where it would round to 0, R1 is 1 and T1 is 0 to
/// rounding, so that the floor changes nothing but 0/0.
#[inline]
fn bounces(r1: f64, r2: f64) -> f64 {
    (1.0 - r1 * r2).max(f64::EPSILON)
}

/// The paint that results from stirring amounts of paints together, and the thickness of its layer.
///
/// # Source
/// Curtis et al. 1997, §5.2: K and S are means weighted by amount, the thickness is the sum of amounts.
///
/// # Shapes and units
/// Amounts are thicknesses; negative and NaN count as 0. Of nothing, the mixture absorbs and scatters nothing.
pub fn mixture<'a>(parts: impl IntoIterator<Item = (&'a Coefficients, f64)>) -> (Coefficients, f64) {
    let (mut sum, thickness) = stir(parts);
    if thickness > 0.0 {
        for channel in 0..3 {
            sum.absorption[channel] /= thickness;
            sum.scattering[channel] /= thickness;
        }
    }
    (sum, thickness)
}

/// The sums of K·x and S·x: the coefficients that a layer of thickness 1 has to have to be the same.
fn stir<'a>(parts: impl IntoIterator<Item = (&'a Coefficients, f64)>) -> (Coefficients, f64) {
    let mut sum = Coefficients::default();
    let mut thickness = 0.0;
    for (paint, amount) in parts {
        let amount = sane(amount);
        thickness += amount;
        for channel in 0..3 {
            sum.absorption[channel] += amount * paint.absorption[channel];
            sum.scattering[channel] += amount * paint.scattering[channel];
        }
    }
    (sum, thickness)
}

/// The color of one glaze of mixed paints over a ground: [`mixture`], [`Coefficients::layer`] and
/// [`Layer::over_ground`] at once.
///
/// # Cost
/// Three exponentials and square roots, six multiplications a paint; nothing is allocated.
pub fn glaze<'a>(parts: impl IntoIterator<Item = (&'a Coefficients, f64)>, ground: LinearRgb) -> LinearRgb {
    let (sum, thickness) = stir(parts);
    if thickness > 0.0 { sum.layer(1.0).over_ground(ground) } else { ground }
}

/// Lays one glaze over a row of pixels, in place.
///
/// # Shapes and units
/// `amounts`: one row of thicknesses for each of `paints`, each as long as `ground`.
///
/// # Guarantees
/// Each pixel is [`glaze`]'s, bit for bit (`a_row_is_its_pixels`); pixels without paint are untouched.
///
/// # Panics
/// A row of amounts is missing or of another length.
pub fn glaze_row(paints: &[Coefficients], amounts: &[&[f32]], ground: &mut [LinearRgb]) {
    assert_eq!(paints.len(), amounts.len(), "one row of amounts for each paint");
    for row in amounts {
        assert_eq!(row.len(), ground.len(), "one amount for each pixel");
    }
    for (x, pixel) in ground.iter_mut().enumerate() {
        let parts = paints.iter().zip(amounts).map(|(paint, row)| (paint, f64::from(row[x])));
        *pixel = glaze(parts, *pixel);
    }
}

#[cfg(test)]
mod tests;
