//! What a watercolor makes of a photograph's tones: paper for whites, no dead blacks, tints of the darks first.

use crate::accidents::smoothstep;
use crate::attention::quantiles;
use crate::settings::PhotoParams;

/// `low` and more: softly so within `width` of it.
fn soft_floor(value: f32, low: f32, width: f32) -> f32 {
    let z = (value - low) / width;
    let soft = if z > 20.0 { z } else { libm::log1pf(libm::expf(z)) };
    low + width * soft
}

/// Median lightness, Lab, below which a photograph is painted in a lighter key, and how much of what it is below.
const DARK: f32 = 55.0;
const LIGHTER: f32 = 0.07;

/// Lightness of whites, Lab, below which a photograph's lightest hundredth is lifted, and by how much of what it is below.
const WHITES: f32 = 92.0;
const LIFTED: f32 = 0.18;

/// Lightness, Lab, from which on and up to which tones pass into paper, and by how much they are lighter there.
const TO_PAPER: [f32; 2] = [76.0, 94.0];
const LIGHTS: f32 = 2.5;

/// Tones of a painting, from those of a photograph.
#[derive(Clone, Copy, Debug)]
pub struct Tones {
    key: f32,
    chroma: f32,
    darkest: f32,
    whites: f32,
    /// The photograph's darks, Lab L.
    pub darks: f32,
    /// How far its lights are from them, Lab.
    pub range: f32,
}

impl Tones {
    /// As the parameters ask, for the lightness of a photograph's cells, Lab.
    pub fn new(params: &PhotoParams, lightness: impl Iterator<Item = f32>) -> Self {
        let light = quantiles(lightness, [0.03, 0.5, 0.97, 0.99]);
        Self {
            key: params.key as f32 + LIGHTER * (DARK - light[1]).max(0.0),
            chroma: params.chroma as f32,
            darkest: params.darkest as f32,
            whites: LIFTED * (WHITES - light[3]).max(0.0),
            darks: light[0],
            range: (light[2] - light[0]).clamp(20.0, 100.0),
        }
    }

    /// The Lab that is painted for a Lab of the photograph.
    pub fn of(&self, [l, a, b]: [f32; 3]) -> [f32; 3] {
        let chroma = libm::hypotf(a, b);
        let light = 100.0 - 0.975 * (100.0 - l);
        let up = (light / WHITES).min(1.0);
        let light = light + self.whites * up * up;
        let light =
            light + self.key * ((100.0 - light) / 60.0).clamp(0.0, 1.0) * (light / 40.0).clamp(0.0, 1.0);
        let light = (light + LIGHTS * smoothstep(light, TO_PAPER[0], TO_PAPER[1])).min(l.max(98.5));
        // Neutral darks lean to blue violet: a black from the tube is dead.
        let dark = (1.0 - smoothstep(chroma, 3.0, 12.0)) * (1.0 - smoothstep(light, 15.0, 60.0));
        let tinted = dark * self.chroma.min(1.0);
        [soft_floor(light, self.darkest, 3.0), a * self.chroma + 0.6 * tinted, b * self.chroma - 3.2 * tinted]
    }
}

/// What a wash lays that goes down to a lightness only: nothing darker, and of darks their tint.
pub fn lifted([l, a, b]: [f32; 3], lightest: f32) -> [f32; 3] {
    let light = soft_floor(l, lightest, 5.0);
    let up = (light - l).max(0.0);
    let chroma = libm::hypotf(a, b);
    let mut richer = 1.0 + 0.25 * (up / 60.0).min(1.0) * smoothstep(chroma, 4.0, 12.0);
    // A light color cannot be as rich as a dark one, unless it is a yellow of the photograph's own.
    let yellow = (b / chroma.max(1e-6)).max(0.0) * (1.0 - up / 25.0).max(0.0);
    let richest = (105.0 - light) * 2.3 * (1.0 + yellow * yellow);
    richer *= (richest / (chroma * richer).max(1e-6)).min(1.0);
    let cool = (1.0 - smoothstep(chroma, 3.0, 10.0)) * (up / 50.0).min(1.0);
    [light, a * richer, b * richer - 3.0 * cool]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tones(lights: &[f32]) -> Tones {
        Tones::new(&PhotoParams::default(), lights.iter().copied())
    }

    #[test]
    fn tones_rise_with_the_photograph_s_and_end_in_paper() {
        for lights in [&[5.0, 50.0, 97.0][..], &[2.0, 10.0, 30.0], &[70.0, 75.0, 80.0], &[]] {
            let tones = tones(lights);
            let painted: Vec<f32> = (0..=100).map(|l| tones.of([l as f32, 0.0, 0.0])[0]).collect();
            assert!(painted.windows(2).all(|pair| pair[0] <= pair[1]), "{painted:?}");
            assert!(painted[0] > 8.0 && painted[94] >= 97.0 && painted[100] <= 100.5, "{painted:?}");
        }
    }

    #[test]
    fn a_dark_photograph_is_painted_lighter() {
        let [dark, light] = [&[1.0, 12.0, 60.0][..], &[5.0, 60.0, 98.0]].map(tones);
        assert!(dark.of([40.0, 0.0, 0.0])[0] > light.of([40.0, 0.0, 0.0])[0] + 2.0);
    }
}
