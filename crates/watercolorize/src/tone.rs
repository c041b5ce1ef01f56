//! What a watercolor makes of a photograph's tones: paper for whites, no dead blacks, tints of the darks first.

use crate::accidents::smoothstep;
use crate::settings::PhotoParams;

/// `low` and more: softly so within `width` of it.
fn soft_floor(value: f32, low: f32, width: f32) -> f32 {
    let z = (value - low) / width;
    let soft = if z > 20.0 { z } else { libm::log1pf(libm::expf(z)) };
    low + width * soft
}

/// Tones of a painting, from those of a photograph.
#[derive(Clone, Copy, Debug)]
pub struct Tones {
    key: f32,
    chroma: f32,
    darkest: f32,
}

impl Tones {
    /// As the parameters ask.
    pub fn new(params: &PhotoParams) -> Self {
        Self { key: params.key as f32, chroma: params.chroma as f32, darkest: params.darkest as f32 }
    }

    /// The Lab that is painted for a Lab of the photograph.
    pub fn of(&self, [l, a, b]: [f32; 3]) -> [f32; 3] {
        let chroma = libm::hypotf(a, b);
        let light = 100.0 - 0.975 * (100.0 - l);
        let light =
            light + self.key * ((100.0 - light) / 60.0).clamp(0.0, 1.0) * (light / 40.0).clamp(0.0, 1.0);
        // Neutral darks lean to blue violet: a black from the tube is dead.
        let dark = (1.0 - smoothstep(chroma, 3.0, 12.0)) * (1.0 - smoothstep(light, 15.0, 60.0));
        let tinted = dark * self.chroma.min(1.0);
        [soft_floor(light, self.darkest, 3.0), a * self.chroma + 0.8 * tinted, b * self.chroma - 3.0 * tinted]
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
