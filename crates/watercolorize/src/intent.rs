//! What a wash is to look like and where its shapes keep apart, before the sheet below is looked at.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane, within};

use crate::accidents::{noise, smoothstep};
use crate::regions;
use crate::study::{Colors, Plane, Study, TIER};
use crate::tone::lifted;
use crate::walls::Walls;
use crate::washes::WashPlan;

/// Over how much of the long edge a tier of tones is one color.
const TIER_OVER: f64 = 0.2;

/// How far charging turns the hue, radians; chroma, Lab, from which on it turns less.
const TURN: f32 = 0.15;
const MOST_TURNED: f32 = 45.0;
/// How much of its chroma it makes a color richer.
const RICHER: f32 = 0.09;
/// How far it lets dark grays lean, Lab, and which way is warm.
const LEAN: f32 = 2.4;
const WARM: [f32; 2] = [0.35, 0.94];

/// How much darker paint dries where water pools, Lab, and how many times that at most.
const POOLED: f32 = 2.4;
const MOST_POOLED: f32 = 1.8;

/// How much of `stepping` goes into tiers.
const TIERED: f32 = 1.2;

/// What a wash is meant to be.
pub struct Intent {
    /// Where shapes may keep apart.
    pub walls: Walls,
    /// How far the hand strays, cells: colors and shapes alike, the slight misregister of glazes.
    pub stray: Raster<[f32; 2]>,
    /// The walls after that.
    pub strayed: Walls,
    /// The colors that are to be seen when it is dry, Lab.
    pub wanted: Colors,
    /// How much darker than the wash before it is to be, Lab.
    pub meant: Plane,
    /// How flat the photograph is around each cell, 0 to 1.
    pub flat: Plane,
    /// How hard its edges are, 0 to 1.
    pub hardness: Plane,
}

impl Intent {
    /// For wash `index`, which paints down to the lightness `lightest`; the wash before it went down to `before`.
    pub fn new(study: &Study<'_>, plan: &WashPlan, index: usize, lightest: f32, before: f32) -> Self {
        let (params, [width, height]) = (study.params, study.mount.size);
        let source = &study.abstractions[(plan.abstraction + 0.5) as usize];
        let steps = regions::steps(source, study.cells(0.008));
        let walls = Walls::find(study, plan, source, &steps);
        let wanted = wanted(study, plan, index, lightest);
        let even = within(&wanted, &walls.regions, study.cells(plan.flat_over));
        let stepping = (TIERED * params.stepping as f32).min(1.0);
        let flatter = Raster::by_rows(width, height, |x, y| {
            let flat = params.flatness as f32 * plan.flatness * (1.0 - 0.8 * study.exact.at(x, y));
            let flat = flat * (1.0 - 0.8 * smoothstep(steps.at(x, y), 8.0, 20.0));
            mixed(wanted.at(x, y), even.at(x, y), flat * (1.0 - 0.7 * study.graded(x, y)))
        });
        let tiered = tiered(study, &wanted, &even, &walls.regions);
        let mut wanted = Raster::by_rows(width, height, |x, y| {
            // What only fades is one graded wash.
            let much = stepping * study.graded(x, y) * study.forms.at(x, y) * (1.0 - study.exact.at(x, y));
            mixed(flatter.at(x, y), tiered.at(x, y), much)
        });
        charge(study, &mut wanted);
        let meant = wanted.map(|wanted| lacking(wanted, lifted(wanted, before)));
        let first = if index == 0 { 1.5 } else { 1.0 };
        let amplitude = (study.cells(0.0020) * params.wobble * first) as f32;
        let stray = noise::<2>(study.seed, &format!("wobble {index}"), study.mount.size, study.cells(0.025));
        let stray = Raster::by_rows(width, height, |x, y| {
            stray.at(x, y).map(|by| by * amplitude * (1.0 - 0.9 * study.exact.at(x, y)))
        });
        let flat = gaussian_plane(&steps.map(|step| 1.0 - smoothstep(step, 3.0, 8.0)), study.cells(0.006));
        Self {
            strayed: walls.warped(&stray),
            walls,
            stray,
            wanted,
            meant,
            flat,
            hardness: study.hardness(&steps),
        }
    }
}

/// What a wash is to look like, before the sheet below is looked at.
fn wanted(study: &Study<'_>, plan: &WashPlan, index: usize, lightest: f32) -> Colors {
    let (low, part) = (plan.abstraction as usize, plan.abstraction.fract() as f32);
    let last = study.abstractions.len() - 1;
    let (a, b) = (&study.abstractions[low.min(last)], &study.abstractions[(low + 1).min(last)]);
    let mut wanted = Raster::by_rows(a.width(), a.height(), |x, y| {
        let (a, b) = (a.at(x, y), b.at(x, y));
        let color = study.tones.of([0, 1, 2].map(|c: usize| a[c] + part * (b[c] - a[c])));
        if plan.level > 0.0 { lifted(color, lightest) } else { color }
    });
    let wetness = study.params.wetness;
    let soft = if index == 0 { 0.012 * wetness } else { 0.002 * (wetness - 1.0).max(0.0) };
    if soft > 0.0 {
        let blurred = gaussian(&wanted, study.cells(soft));
        let share = if index == 0 { 0.4 } else { 1.0 };
        let cells = wanted.as_mut_slice().iter_mut().zip(blurred.as_slice());
        cells.for_each(|(cell, soft)| *cell = mixed(*cell, *soft, share));
    }
    wanted
}

/// Colors as they are where what is soft is laid wash over wash: flat within tiers of tones, whose borders stray and follow
/// the large forms.
fn tiered(study: &Study<'_>, wanted: &Colors, even: &Colors, regions: &regions::Regions) -> Colors {
    let tier = TIER * study.tones.range;
    let tiers = Raster::by_rows(wanted.width(), wanted.height(), |x, y| {
        let light = 0.75 * even.at(x, y)[0] + 0.25 * wanted.at(x, y)[0] + study.stray_tone.at(x, y);
        (regions.at(x, y), libm::floorf(light / tier) as i32)
    });
    within(wanted, &tiers, study.cells(TIER_OVER))
}

/// Lets hues drift and water pool, the same way in every wash, or the later ones would take back what the first ones did.
fn charge(study: &Study<'_>, wanted: &mut Colors) {
    let (params, freedom) = (study.params, study.params.freedom());
    let charge = (params.charging * freedom.min(1.0)) as f32;
    let pooled = POOLED * (params.turbulence * freedom) as f32;
    for y in 0..wanted.height() {
        for (x, cell) in wanted.row_mut(y).iter_mut().enumerate() {
            let exact = study.exact.at(x, y);
            let pool = pooled * study.pools.at(x, y).clamp(-MOST_POOLED, MOST_POOLED);
            // Only what is soft was wet for so long.
            cell[0] -= pool * study.graded(x, y) * (1.0 - exact) * seen_of_light(cell[0]);
            *cell = charged(*cell, study.drift.at(x, y), charge * (1.0 - 0.85 * exact));
        }
    }
}

/// How much of an unevenness shows on a color so light: little on white, and in the darkest.
fn seen_of_light(l: f32) -> f32 {
    smoothstep(100.0 - l, 3.0, 20.0) * smoothstep(l, 5.0, 30.0)
}

/// A color as it is after others were dropped in beside it: its hue turns to its neighbors', it is richer or grayer, and
/// what has little hue leans to a warm or a cool one. How light it is stays.
fn charged([l, a, b]: [f32; 3], [turn, lean]: [f32; 2], much: f32) -> [f32; 3] {
    let chroma = libm::hypotf(a, b);
    // Orange and brown do not turn green, as nobody's hair does, and yellow hardly orange.
    let warm = smoothstep(a.max(0.4 * b) / chroma.max(1.0), 0.0, 0.35);
    let yellow = smoothstep(b / chroma.max(1.0), 0.6, 0.95);
    let turn = if turn > 0.0 { turn * (1.0 - 0.75 * warm) } else { turn * (1.0 - 0.5 * yellow) };
    // A blue sky has no violet clouds.
    let turn = turn * (1.0 - 0.6 * smoothstep(-b / chroma.max(1.0), 0.5, 0.9));
    let turn = (much * TURN * turn * (MOST_TURNED / chroma.max(1.0)).min(1.0)).clamp(-0.5, 0.5);
    let (sin, cos) = libm::sincosf(turn);
    let richer = 1.0 + much * RICHER * lean.clamp(-2.0, 2.0);
    // Darks are alive with it; of light grays hardly any color, or they turn to mottle.
    let dark = 1.0 - smoothstep(l, 18.0, 50.0);
    let gray = 1.0 - smoothstep(chroma, 6.0, 20.0);
    let light = smoothstep(100.0 - l, 3.0, 20.0);
    let lean = much * LEAN * lean * gray * (0.12 + 0.88 * dark) * light;
    let (a, b) = (richer * (cos * a - sin * b), richer * (sin * a + cos * b));
    [l, a + WARM[0] * lean, b + WARM[1] * lean]
}

/// How much is missing from a color to a darker or other one, Lab.
pub fn lacking(wanted: [f32; 3], under: [f32; 3]) -> f32 {
    let chroma = libm::hypotf(under[1] - wanted[1], under[2] - wanted[2]);
    // What is to be lighter cannot be mended: graying it would only darken it more.
    let mended = 1.0 - smoothstep(wanted[0] - under[0], 2.0, 12.0);
    (under[0] - wanted[0]).max(0.0) + 0.35 * chroma * mended
}

/// A color a part of the way from one to another.
pub fn mixed(a: [f32; 3], b: [f32; 3], part: f32) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] + part * (b[c] - a[c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hue([_, a, b]: [f32; 3]) -> f32 {
        libm::atan2f(b, a).to_degrees()
    }

    #[test]
    fn charging_leaves_light_as_it_is_brown_brown_and_skies_blue() {
        let [brown, green, blue] = [[45.0, 12.0, 25.0], [50.0, -25.0, 15.0], [55.0, -4.0, -38.0]];
        for turn in [-2.0, -1.0, 1.0, 2.0] {
            let turned = |color: [f32; 3]| {
                let charged = charged(color, [turn, 0.0], 1.0);
                assert_eq!(charged[0], color[0]);
                (hue(charged) - hue(color)) * turn.signum()
            };
            assert!(turn < 0.0 || turned(brown) < 6.0, "{turn}");
            assert!(turned(green) > 4.0 && (1.0..8.0).contains(&turned(blue)), "{turn}");
        }
    }

    #[test]
    fn pools_show_on_no_white() {
        assert_eq!((seen_of_light(98.0), seen_of_light(60.0), seen_of_light(2.0)), (0.0, 1.0, 0.0));
    }

    #[test]
    fn charging_lets_darks_lean_and_hardly_light_grays() {
        let lean = |l: f32| charged([l, 0.0, 0.0], [0.0, 1.0], 1.0)[2];
        assert!(lean(15.0) > 2.0 && lean(80.0) < 0.6);
    }
}
