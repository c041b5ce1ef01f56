//! Colors become paint: what each wash aims at, and how much of each pigment that takes over the washes below.

use crate::separate::{Limits, MOST, Paints, from_lab, lab};
use crate::values::LIGHTEST;

/// How a mix is found: most of each pigment and in all, and how dear paint is, Lab² a thickness.
const LIMITS: Limits = Limits { each: 1.6, total: 2.6, thrift: 1.6, keeping: 0.0, rounds: 12, hue: 1.0 };
/// Least and most reflectance that is aimed at.
const REFLECTANCE: [f32; 2] = [0.004, 0.97];

/// A color in linear light from Lab, D65.
pub fn linear(color: [f32; 3]) -> [f32; 3] {
    from_lab(color).map(|channel| channel.clamp(REFLECTANCE[0], REFLECTANCE[1]))
}

/// A color thinned with water until it is so light, Lab L.
///
/// # Source
/// Beer's law: a thinner film of the same paint has the reflectance to a lower power, and keeps its hue as water does.
pub fn thinned(color: [f32; 3], lightness: f32) -> [f32; 3] {
    if lab(color)[0] >= lightness {
        return color;
    }
    let (mut low, mut high) = (0.0f32, 1.0f32);
    for _ in 0..14 {
        let power = 0.5 * (low + high);
        let thin = color.map(|channel| libm::powf(channel, power));
        if lab(thin)[0] > lightness { low = power } else { high = power }
    }
    color.map(|channel| libm::powf(channel, low))
}

/// The amounts of each wash that together make a color over a ground, so many washes, the first ones thinner; a list a
/// wash.
pub fn glazed(paints: &Paints, wanted: [f32; 3], ground: [f32; 3], washes: usize) -> Vec<Vec<f32>> {
    let mut laid = Vec::new();
    lay(paints, wanted, ground, washes, &mut laid);
    laid
}

/// The same for a glaze: its first washes are those of another color, so many of them, that lies beside it.
pub fn glazed_over(
    paints: &Paints,
    wanted: [f32; 3],
    (first, of_first): ([f32; 3], usize),
    ground: [f32; 3],
    washes: usize,
) -> Vec<Vec<f32>> {
    let mut laid = glazed(paints, first, ground, of_first.min(washes));
    let below = laid.iter().fold(ground, |below, amounts| paints.over(amounts, below));
    lay(paints, wanted, below, washes, &mut laid);
    laid
}

/// Lays washes of a color over those that are laid, until there are so many; `below` is what those look like.
fn lay(paints: &Paints, wanted: [f32; 3], mut below: [f32; 3], washes: usize, laid: &mut Vec<Vec<f32>>) {
    let color = linear(wanted);
    for (wash, &lightest) in LIGHTEST.iter().enumerate().take(washes).skip(laid.len()) {
        let aim = if wash + 1 == washes { color } else { thinned(color, lightest) };
        let (amounts, _) = paints.separate(lab(aim), below, None, &LIMITS);
        let amounts = rounded(paints, &amounts);
        below = paints.over(&amounts, below);
        laid.push(amounts);
    }
}

/// The amounts that make a color over one that lies there already.
pub fn over(paints: &Paints, wanted: [f32; 3], ground: [f32; 3]) -> Vec<f32> {
    let (amounts, _) = paints.separate(lab(linear(wanted)), ground, None, &LIMITS);
    rounded(paints, &amounts)
}

/// As a document keeps them: ten-thousandths.
fn rounded(paints: &Paints, amounts: &[f32; MOST]) -> Vec<f32> {
    amounts[..paints.len()].iter().map(|amount| libm::roundf(amount * 1e4) / 1e4).collect()
}

/// Amounts as a document has them.
pub fn stored(amounts: &[f32]) -> Vec<f64> {
    amounts.iter().map(|&amount| libm::round(f64::from(amount) * 1e4) / 1e4).collect()
}
