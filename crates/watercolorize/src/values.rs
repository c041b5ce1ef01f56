//! The value plan: a photograph's tones become a few values in a lifted key, and its colors calmer ones.

use crate::accidents::smoothstep;
use crate::attention::quantiles;
use crate::settings::PhotoParams;

/// Planned lightness, Lab, below which a place is darkened by the first wash, the second, and so on: what is lighter than
/// the first is paper.
pub const LEVELS: [f32; MOST_WASHES] = [93.5, 76.0, 54.0, 36.0];
/// Most washes.
pub const MOST_WASHES: usize = 4;
/// The lightest that each wash dries.
pub const LIGHTEST: [f32; MOST_WASHES] = [78.0, 58.0, 36.0, 8.0];

/// Parts of the photograph that are darker than the tones which are planned.
const PARTS: [f64; 5] = [0.01, 0.12, 0.5, 0.8, 0.92];
/// What those tones become, Lab L, and how far each is lifted at most. Darks lifted by half of this were a cliff of one
/// heavy dark.
const GOALS: [f32; 5] = [20.0, 36.0, 66.0, 88.0, 97.0];
const LIFTS: [f32; 5] = [8.0, 18.0, 21.0, 24.0, 26.0];
/// How far a tone may be lowered.
const LOWERED: f32 = 2.0;
/// Blackest and whitest tone.
const ENDS: [f32; 2] = [16.0, 99.0];

/// How much lighter darks are where nobody looks, and how much darker at the focus, Lab L; and which tones are darks.
const AWAY: (f32, [f32; 2]) = (8.0, [60.0, 20.0]);
const FOCUS: (f32, [f32; 2]) = (7.0, [56.0, 28.0]);

/// How colorful things are: always, more of it at the focus if they have some color, and more if they have much.
const CHROMA: [f32; 3] = [0.69, 0.20, 0.34];
const SOME_CHROMA: [f32; 2] = [4.0, 20.0];
const MUCH_CHROMA: [f32; 2] = [16.0, 52.0];
const MOST_CHROMA: f32 = 1.08;
/// Neutral darks lean to blue and a little to red, Lab.
const COOL: [f32; 2] = [1.2, -3.6];

/// How much lighter colorful things count when whites are chosen, Lab L a Lab C above the least: they are no paper.
const COLORFUL: (f32, f32) = (0.28, 6.0);
/// The same of faces.
const FACE: f32 = 4.5;

/// A photograph's tones and what they become.
#[derive(Clone, Debug)]
pub struct Values {
    curve: [(f32, f32); 7],
    chroma: f32,
    cool: f32,
}

impl Values {
    /// For a photograph of these tones, Lab L.
    pub fn new(params: &PhotoParams, lightness: impl Iterator<Item = f32>) -> Self {
        let found = quantiles(lightness, PARTS);
        let key = params.key as f32;
        let mut curve = [(0.0, ENDS[0]); 7];
        let mut before = ENDS[0];
        for k in 0..5 {
            let tone = found[k];
            // A dark key lowers what a light one lifts.
            let lowered = LOWERED + (-key * LIFTS[k]).max(0.0);
            let goal = if key < 0.0 { tone - lowered } else { GOALS[k] };
            let goal = goal.clamp(tone - lowered, tone + (key * LIFTS[k]).max(0.0));
            before = goal.max(before + 0.01);
            curve[k + 1] = (tone.max(curve[k].0 + 1e-3), before);
        }
        curve[6] = (101.0f32.max(curve[5].0 + 1e-3), ENDS[1].max(before));
        Self { curve, chroma: params.chroma as f32, cool: params.cool_darks as f32 }
    }

    /// The planned lightness of a tone where attention is so strong, 0 to 1.
    pub fn of(&self, lightness: f32, attention: f32) -> f32 {
        let above = self.curve.iter().position(|&(tone, _)| tone >= lightness).unwrap_or(6).max(1);
        let [(x0, y0), (x1, y1)] = [self.curve[above - 1], self.curve[above]];
        let planned = y0 + (y1 - y0) * ((lightness - x0) / (x1 - x0)).clamp(0.0, 1.0);
        let attention = attention.clamp(0.0, 1.0);
        let planned = planned + (1.0 - attention) * AWAY.0 * smoothstep(planned, AWAY.1[0], AWAY.1[1]);
        planned - attention * FOCUS.0 * smoothstep(planned, FOCUS.1[0], FOCUS.1[1])
    }

    /// The planned hue and chroma, Lab a and b, of something that is planned so light.
    pub fn tint(&self, [a, b]: [f32; 2], planned: f32, attention: f32) -> [f32; 2] {
        let chroma = libm::hypotf(a, b);
        let strong = CHROMA[0]
            + CHROMA[1]
                * smoothstep(attention, 0.2, 0.9)
                * smoothstep(chroma, SOME_CHROMA[0], SOME_CHROMA[1])
            + CHROMA[2] * smoothstep(chroma, MUCH_CHROMA[0], MUCH_CHROMA[1]);
        let strong = strong.min(MOST_CHROMA) * (1.0 - 0.12 * smoothstep(planned, 55.0, 30.0)) * self.chroma;
        let cool = self.cool
            * smoothstep(planned, 70.0, 30.0)
            * smoothstep(chroma, 14.0, 3.0)
            * smoothstep(a, -4.0, 0.0);
        [a * strong + cool * COOL[0], b * strong + cool * COOL[1]]
    }

    /// How many washes darken something of this planned color: 0 is paper.
    pub fn washes(&self, [planned, a, b]: [f32; 3], face: f32) -> usize {
        let colorful = COLORFUL.0 * (libm::hypotf(a, b) - COLORFUL.1).max(0.0);
        let first = planned - colorful - FACE * face < LEVELS[0];
        usize::from(first) + LEVELS[1..].iter().filter(|&&level| planned < level).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values() -> Values {
        Values::new(&PhotoParams::default(), (0..1000).map(|k| 0.08 * k as f32))
    }

    #[test]
    fn the_key_is_lifted_and_the_order_of_tones_is_kept() {
        let values = values();
        let tones: Vec<f32> = (0..=100).map(|l| values.of(l as f32, 0.5)).collect();
        assert!(tones.windows(2).all(|pair| pair[0] <= pair[1] + 1e-4), "{tones:?}");
        assert!(values.of(40.0, 0.5) > 55.0);
        assert!(values.of(10.0, 1.0) < values.of(10.0, 0.0));
    }

    #[test]
    fn light_things_are_paper_unless_they_are_colorful() {
        let values = values();
        assert_eq!(values.washes([96.0, 0.0, 2.0], 0.0), 0);
        assert_eq!(values.washes([96.0, 20.0, 30.0], 0.0), 1);
        assert_eq!(values.washes([30.0, 0.0, 0.0], 0.0), 4);
    }

    #[test]
    fn one_tone_is_planned_too() {
        let values = Values::new(&PhotoParams::default(), core::iter::repeat_n(50.0, 10));
        assert!(values.of(50.0, 0.0).is_finite() && values.of(0.0, 0.0) <= values.of(100.0, 0.0));
    }
}
