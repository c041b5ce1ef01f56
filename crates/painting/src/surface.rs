//! What a painted sheet shows below a millimetre, at any resolution: where a brush touches the tooth of the paper, where
//! grains of pigment settle, where a contour is held.

use girtin_grid::noise::Noise;
use girtin_grid::{Raster, random};

/// Wavelengths of what is finer than the paper's own height, mm.
const FINE_MM: [f64; 4] = [1.5, 0.8, 0.45, 0.25];
/// Wavelength of the clumps that grains gather in, mm.
const CLUMP_MM: f64 = 4.5;
/// How a height and finer unevenness make the tooth that a brush feels.
const TOOTH: [f32; 2] = [0.8, 0.6];
/// How they make the pits where grains settle: mostly finer than the paper, or pebbles would be traced as worms.
const PITS: [f32; 2] = [-0.5, 0.85];

/// Wavelengths of the unevenness with which grains settle from water that stood, mm, and how strong each is.
const SETTLED_MM: [(f64, f32); 2] = [(2.6, 0.8), (5.5, 0.6)];
const BY_SETTLING: f32 = 0.10;
/// Over which lengths water stands longer here than there, mm.
const STOOD_MM: f64 = 34.0;

/// How amounts follow pits: those above a place's rank settle in it, some in specks, more so in clumps.
const BY_PITS: f32 = 0.40;
const BY_SPECKS: f32 = 0.14;
const BY_CLUMPS: f32 = 0.14;
/// Part of the peaks that a brush misses where it misses most, over which ranks it does, and how much paint is missing.
const MISSED: f32 = 0.014;
const MISSED_OVER: f32 = 0.015;
const MISSED_LESS: f32 = 0.9;
/// From which rank of pits on there are specks, where grains are scarce, and how much lower where they clump.
const SPECKS_FROM: [f32; 2] = [0.90, 0.14];
/// Least and most that grain makes of an amount.
const GRAIN: [f32; 2] = [0.3, 2.5];

/// The fine structure of some rows of samples.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Rank of each sample's height as a brush feels it, 0 to 1: a brush of dryness d touches what is above d.
    pub tooth: Raster<f32>,
    /// Rank of each sample as a pit, 0 to 1.
    pits: Raster<f32>,
    /// Rank of each sample's surroundings as a place where grains gather, 0 to 1.
    clumps: Raster<f32>,
    /// How much more settles at a sample than around, mean 0 and deviation about 1.
    settled: Raster<f32>,
    /// What holds a contour or lets it go, mean 0 and deviation about 1.
    pub pins: Raster<f32>,
}

/// Mean and deviation of a paper's height at some resolution.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Mean.
    pub mean: f32,
    /// Standard deviation.
    pub deviation: f32,
}

impl Level {
    /// Of these heights.
    pub fn of(heights: &Raster<f32>) -> Self {
        let count = heights.as_slice().len().max(1) as f64;
        let mean = heights.as_slice().iter().map(|&h| f64::from(h)).sum::<f64>() / count;
        let square = |&h: &f32| (f64::from(h) - mean) * (f64::from(h) - mean);
        let variance = heights.as_slice().iter().map(square).sum::<f64>() / count;
        Self { mean: mean as f32, deviation: libm::sqrt(variance).max(1e-4) as f32 }
    }
}

impl Surface {
    /// Of samples with these heights, `per_mm` of them a millimetre, the first one's corner at `origin`, mm.
    pub fn new(heights: &Raster<f32>, level: Level, per_mm: f64, origin: [f64; 2], seed: u64) -> Self {
        let [width, rows] = [heights.width(), heights.height()];
        let noise = |stage: &str| Noise::new(seed, random::stage(stage));
        let octaves: Vec<(Noise, f64, f32)> =
            FINE_MM.iter().map(|&mm| (noise(&format!("tooth {mm}")), mm, seen(mm, per_mm))).collect();
        let clumping = noise("clumps");
        let place = |x: usize, y: usize| {
            [origin[0] + (x as f64 + 0.5) / per_mm, origin[1] + (y as f64 + 0.5) / per_mm]
        };
        // A brush feels all of it but the finest, grains settle in the finest.
        let sum = |octaves: &[(Noise, f64, f32)]| {
            let power: f32 = octaves.iter().map(|(_, _, seen)| seen * seen).sum::<f32>().max(0.05);
            let scale = SPECKLE / power.sqrt();
            Raster::by_rows(width, rows, |x, y| {
                let at = place(x, y);
                let octave = |(noise, mm, seen): &(Noise, f64, f32)| {
                    if *seen > 0.0 { seen * speckle(noise, at.map(|at| 2.0 * at / mm)) } else { 0.0 }
                };
                scale * octaves.iter().map(octave).sum::<f32>()
            })
        };
        let (unevenness, fine) = (sum(&octaves[..3]), sum(&octaves[1..]));
        let standing = heights.map(|h| (h - level.mean) / level.deviation);
        let both = |weights: [f32; 2], finer: &Raster<f32>| {
            let norm = 1.0 / (weights[0] * weights[0] + weights[1] * weights[1]).sqrt();
            Raster::by_rows(width, rows, |x, y| {
                rank(norm * (weights[0] * standing.row(y)[x] + weights[1] * finer.row(y)[x]))
            })
        };
        Self {
            tooth: both(TOOTH, &unevenness),
            pits: both(PITS, &fine),
            clumps: Raster::by_rows(width, rows, |x, y| {
                rank(GRADIENT * clumping.gradient(place(x, y).map(|at| at / CLUMP_MM)) as f32)
            }),
            settled: {
                let noises = SETTLED_MM.map(|(mm, share)| (noise(&format!("settled {mm}")), mm, share));
                let standing_water = noise("standing water");
                let norm = SPECKLE / noises.iter().map(|(.., share)| share * share).sum::<f32>().sqrt();
                Raster::by_rows(width, rows, |x, y| {
                    let at = place(x, y);
                    let value = |(noise, mm, share): &(Noise, f64, f32)| {
                        share * speckle(noise, at.map(|at| 2.0 * at / mm))
                    };
                    let stood = GRADIENT * standing_water.gradient(at.map(|at| at / STOOD_MM)) as f32;
                    let stood = ((stood + 0.4) / 1.6).clamp(0.0, 1.4);
                    norm * stood * noises.iter().map(value).sum::<f32>()
                })
            },
            pins: Raster::by_rows(width, rows, |x, y| 0.6 * standing.row(y)[x] + 0.8 * unevenness.row(y)[x]),
        }
    }

    /// What grain makes of the amount of a pigment at a sample that granulates so strongly.
    pub fn grain(&self, x: usize, y: usize, granulation: f32) -> f32 {
        let (pit, clump) = (self.pits.row(y)[x], self.clumps.row(y)[x]);
        let gathering = ((clump - 0.2) / 0.8).clamp(0.0, 1.0);
        let from = SPECKS_FROM[0] - SPECKS_FROM[1] * gathering * gathering * (3.0 - 2.0 * gathering);
        let specks = ((pit - from) / 0.2).clamp(0.0, 1.0);
        // Grains are many where they clump and hardly any elsewhere.
        let gathered = clump * clump * clump;
        let more = BY_PITS * (0.4 + 1.2 * clump) * (pit - 0.5)
            + BY_SPECKS * gathered * specks
            + BY_CLUMPS * (clump - 0.5)
            + BY_SETTLING * self.settled.row(y)[x];
        // Peaks that the brush went over without touching them.
        let peak = (self.tooth.row(y)[x] - (1.0 - MISSED * (0.3 + gathered))) / MISSED_OVER;
        let more = more - MISSED_LESS * peak.clamp(0.0, 1.0);
        (1.0 + granulation * more).clamp(GRAIN[0], GRAIN[1])
    }
}

/// Random values at the points of a lattice, smoothly between them: −1 to 1. Gradient noise is 0 at all of them, and what is
/// left of it at the finest scales that are seen is worms.
fn speckle(noise: &Noise, [x, y]: [f64; 2]) -> f32 {
    let (column, row) = (libm::floor(x), libm::floor(y));
    let ease = |t: f64| (t * t * (3.0 - 2.0 * t)) as f32;
    let (u, v) = (ease(x - column), ease(y - row));
    let value = |dx: i64, dy: i64| {
        let bits = noise.bits([column as i64 + dx, row as i64 + dy]);
        2.0 * random::unit_f64(random::mix(bits)) as f32 - 1.0
    };
    let above = value(0, 0) + u * (value(1, 0) - value(0, 0));
    let below = value(0, 1) + u * (value(1, 1) - value(0, 1));
    above + v * (below - above)
}

/// What makes the deviation of such values 1.
const SPECKLE: f32 = 2.6;

/// What makes the deviation of gradient noise 1.
const GRADIENT: f32 = 3.6;

/// How much is seen of a wavelength, 0 to 1: what is finer than samples is not, so a finer picture shows more of the same.
fn seen(mm: f64, per_mm: f64) -> f32 {
    (((mm * per_mm - 1.5) / 1.2).clamp(0.0, 1.0)) as f32
}

/// The part of a normal distribution that is below a value.
fn rank(value: f32) -> f32 {
    1.0 / (1.0 + libm::expf(-1.702 * value))
}

#[cfg(test)]
mod tests {
    use girtin_paper::{HeightSource, Papers, Sheet};

    use super::*;

    fn surface(per_mm: f64) -> Surface {
        let paper = Sheet::new(Papers::builtin().get("cold-press").unwrap(), 3);
        let heights = paper.height_field(160, 120, per_mm, [0.0, 0.0]);
        Surface::new(&heights, Level::of(&heights), per_mm, [0.0, 0.0], 3)
    }

    #[test]
    fn a_dry_brush_touches_the_part_of_the_paper_that_its_dryness_says() {
        for per_mm in [2.0, 4.0, 11.8] {
            let tooth = surface(per_mm).tooth;
            for dryness in [0.3, 0.5, 0.7] {
                let above = tooth.as_slice().iter().filter(|&&t| t > dryness).count();
                let share = above as f32 / tooth.as_slice().len() as f32;
                assert!((share - (1.0 - dryness)).abs() < 0.08, "{per_mm} a mm, {dryness}: {share}");
            }
        }
    }

    #[test]
    fn grain_keeps_the_amount_and_grows_with_granulation() {
        let surface = surface(3.0);
        let deviation = |granulation: f32| {
            let values: Vec<f32> =
                (0..120 * 160).map(|at| surface.grain(at % 160, at / 160, granulation)).collect();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            assert!((mean - 1.0).abs() < 0.05, "{granulation}: {mean}");
            values.iter().map(|v| (v - mean) * (v - mean)).sum::<f32>() / values.len() as f32
        };
        assert_eq!(deviation(0.0), 0.0);
        assert!(deviation(1.0) > 3.0 * deviation(0.5));
    }
}
