//! A few thicknesses of a pigment, evenly far apart in what they do to light.

use girtin_optics::Coefficients;
use girtin_optics::color::encode_srgb;

/// Thicknesses from 0 to `max`, rising, in `count` steps that change the layer's light about equally.
///
/// The interval whose ends differ most is halved, again and again. Intervals are halved in thickness, so a distance is
/// never exactly even; but the greatest is at most about twice the mean.
///
/// # Source
/// Curtis et al. 1997, §6.2: "using a binary subdivision by Manhattan distance in the six-dimensional space of the R and T
/// Kubelka-Munk parameters". W1: which interval is divided, and where, is not said.
///
/// # Shapes and units
/// `max`: thickness, above 0; `count`: 1 gives thickness 0 alone, 2 both ends.
///
/// # Guarantees
/// Strictly rising (`thicknesses_rise`), steps of light even within a small factor (`steps_of_light_are_even`).
///
/// # Deviations
/// D8: R and T are of linear light here, and are encoded before they are compared, because the paper's are those of a
/// screen: even steps of light would leave the darks coarse.
pub fn thickness_steps(paint: &Coefficients, max: f64, count: usize) -> Vec<f64> {
    let mut steps = vec![Step::of(paint, 0.0)];
    if count > 1 {
        steps.push(Step::of(paint, max));
    }
    while steps.len() < count {
        let mut widest = (0, 0.0);
        for (at, pair) in steps.windows(2).enumerate() {
            let distance = pair[0].distance(&pair[1]);
            // Of equals the first, so that the order in which they are halved is no accident.
            if distance > widest.1 {
                widest = (at, distance);
            }
        }
        // A paint that does nothing to light has no widest interval; its thicknesses are halved from the left.
        let at = widest.0;
        let middle = (steps[at].thickness + steps[at + 1].thickness) / 2.0;
        steps.insert(at + 1, Step::of(paint, middle));
    }
    steps.into_iter().map(|step| step.thickness).collect()
}

/// A thickness and what a layer of it does to light.
struct Step {
    thickness: f64,
    light: [f64; 6],
}

impl Step {
    fn of(paint: &Coefficients, thickness: f64) -> Self {
        Self { thickness, light: encoded_light(paint, thickness) }
    }

    fn distance(&self, other: &Self) -> f64 {
        self.light.iter().zip(other.light).map(|(a, b)| (a - b).abs()).sum()
    }
}

/// R and T of a layer, red, green and blue each, as a screen shows them.
fn encoded_light(paint: &Coefficients, thickness: f64) -> [f64; 6] {
    let layer = paint.layer(thickness);
    let ([r, g, b], [tr, tg, tb]) = (layer.reflectance, layer.transmittance);
    [r, g, b, tr, tg, tb].map(encode_srgb)
}

#[cfg(test)]
mod tests {
    use girtin_optics::Library;

    use super::*;

    #[test]
    fn thicknesses_rise() {
        for pigment in Library::builtin().iter() {
            let steps = thickness_steps(&pigment.coefficients, 2.0, 20);
            assert_eq!((steps.len(), steps[0], steps[19]), (20, 0.0, 2.0), "{}", pigment.id);
            assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{}: {steps:?}", pigment.id);
        }
    }

    #[test]
    fn steps_of_light_are_even() {
        for pigment in Library::builtin().iter() {
            let paint = &pigment.coefficients;
            let steps: Vec<Step> = thickness_steps(paint, 2.0, 20)
                .into_iter()
                .map(|thickness| Step::of(paint, thickness))
                .collect();
            let gaps: Vec<f64> = steps.windows(2).map(|pair| pair[0].distance(&pair[1])).collect();
            let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
            let largest = gaps.iter().copied().fold(0.0, f64::max);
            assert!(largest < 1.7 * mean, "{}: {} of {}", pigment.id, largest, mean);
            // Even thicknesses are far from that: a pigment does most of its work in its first tenth.
        }
    }

    #[test]
    fn few_steps_and_paints_that_do_nothing_are_no_trouble() {
        let clear = Coefficients::default();
        assert_eq!(thickness_steps(&clear, 1.0, 1), [0.0]);
        assert_eq!(thickness_steps(&clear, 1.0, 2), [0.0, 1.0]);
        let steps = thickness_steps(&clear, 1.0, 20);
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
