//! Color separation: how much of each pigment, over what lies there, gives a wanted color.

use girtin_grid::Raster;
use girtin_optics::Coefficients;

/// Most pigments that are mixed in a wash.
pub const MOST: usize = 8;

/// Gain, Lab², that is not worth another round.
const ENOUGH: f32 = 0.05;

/// What a separation may do.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Most of one pigment, thickness.
    pub each: f32,
    /// Most of all together.
    pub total: f32,
    /// How dear pigment is, Lab² a thickness: of two ways to a color the thinner is taken.
    pub thrift: f32,
    /// How strongly a first answer is kept to, Lab² a thickness².
    pub keeping: f32,
    /// Rounds.
    pub rounds: usize,
    /// How much hue and chroma count beside lightness, 0 to 1.
    pub hue: f32,
}

/// Pigments as they are mixed.
#[derive(Clone, Debug)]
pub struct Paints(Vec<([f32; 3], [f32; 3])>);

impl Paints {
    /// These pigments' coefficients, [`MOST`] at most.
    pub fn new<'a>(coefficients: impl IntoIterator<Item = &'a Coefficients>) -> Self {
        let single = |values: [f64; 3]| values.map(|value| value as f32);
        let paints = coefficients.into_iter().take(MOST);
        Self(paints.map(|paint| (single(paint.absorption), single(paint.scattering))).collect())
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The color of a mixture over a ground, linear.
    pub fn over(&self, amounts: &[f32], ground: [f32; 3]) -> [f32; 3] {
        let (absorption, scattering) = self.stir(amounts);
        [0, 1, 2].map(|c| reflected(absorption[c], scattering[c], ground[c]))
    }

    fn stir(&self, amounts: &[f32]) -> ([f32; 3], [f32; 3]) {
        let (mut absorption, mut scattering) = ([0.0; 3], [LEAST_SCATTERING; 3]);
        for ((k, s), &amount) in self.0.iter().zip(amounts) {
            for c in 0..3 {
                absorption[c] += amount * k[c];
                scattering[c] += amount * s[c];
            }
        }
        (absorption, scattering)
    }

    /// Amounts, 0 and more, whose color over `ground` is nearest `wanted`; `start` is a first answer, kept to by
    /// [`Limits::keeping`]. Also what is still wrong, Lab, as it was weighed.
    ///
    /// # Source
    /// Levenberg and Marquardt's least squares in Lab, projected on what is allowed. The derivatives by pigment follow from
    /// those by K and S, of which a mixture's are sums.
    pub fn separate(
        &self,
        wanted: [f32; 3],
        ground: [f32; 3],
        start: Option<&[f32]>,
        limits: &Limits,
    ) -> ([f32; MOST], [f32; 3]) {
        let count = self.len();
        let mut amounts = [0.0f32; MOST];
        match start {
            Some(start) => amounts[..count].copy_from_slice(&start[..count]),
            None => amounts[..count].fill(0.12),
        }
        let first = amounts;
        let keeping = if start.is_some() { limits.keeping } else { 0.0 };
        let cost = |error: &[f32; 3], amounts: &[f32; MOST]| {
            let square: f32 = error.iter().map(|e| e * e).sum();
            let paint: f32 = amounts[..count].iter().sum();
            let moved: f32 = amounts.iter().zip(&first).map(|(a, f)| (a - f) * (a - f)).sum();
            square + 2.0 * limits.thrift * paint + keeping * moved
        };
        let mut damping = 60.0f32;
        let weighed = |amounts: &[f32; MOST]| {
            let (mut error, mut slopes) = self.error_and_slopes(amounts, wanted, ground);
            for lab in slopes.iter_mut().chain([&mut error]) {
                lab[1] *= limits.hue;
                lab[2] *= limits.hue;
            }
            (error, slopes)
        };
        let (mut error, mut slopes) = weighed(&amounts);
        let mut best = cost(&error, &amounts);
        for _ in 0..limits.rounds {
            let mut system = [[0.0f32; MOST + 1]; MOST];
            for i in 0..count {
                let gradient = dot(slopes[i], error) + limits.thrift + keeping * (amounts[i] - first[i]);
                if amounts[i] <= 1e-6 && gradient > 0.0 {
                    system[i][i] = 1.0;
                    continue;
                }
                for j in 0..count {
                    system[i][j] = dot(slopes[i], slopes[j]);
                }
                system[i][i] += damping + keeping;
                system[i][MOST] = gradient;
            }
            let step = solved(system, count);
            let mut next = amounts;
            for i in 0..count {
                next[i] = (amounts[i] - step[i]).clamp(0.0, limits.each);
            }
            let total: f32 = next[..count].iter().sum();
            if total > limits.total {
                next.iter_mut().for_each(|amount| *amount *= limits.total / total);
            }
            let (next_error, next_slopes) = weighed(&next);
            let next_cost = cost(&next_error, &next);
            if next_cost < best {
                let gained = best - next_cost;
                (amounts, error, slopes, best) = (next, next_error, next_slopes, next_cost);
                damping *= 0.4;
                if gained < ENOUGH {
                    break;
                }
            } else {
                damping *= 4.0;
            }
        }
        (amounts, error)
    }

    /// How far a mixture is from a wanted Lab, and its derivatives by each amount.
    fn error_and_slopes(
        &self,
        amounts: &[f32; MOST],
        wanted: [f32; 3],
        ground: [f32; 3],
    ) -> ([f32; 3], [[f32; 3]; MOST]) {
        const NUDGE: f32 = 0.01;
        let (absorption, scattering) = self.stir(&amounts[..self.len()]);
        let (mut color, mut by_k, mut by_s) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let (k, s, below) = (absorption[c], scattering[c], ground[c]);
            color[c] = reflected(k, s, below);
            by_k[c] = (reflected(k + NUDGE, s, below) - color[c]) / NUDGE;
            by_s[c] = (reflected(k, s + NUDGE, below) - color[c]) / NUDGE;
        }
        let (lab, jacobian) = lab_and_slopes(color);
        let mut slopes = [[0.0; 3]; MOST];
        for (slope, (k, s)) in slopes.iter_mut().zip(&self.0) {
            let change = [0, 1, 2].map(|c: usize| by_k[c] * k[c] + by_s[c] * s[c]);
            *slope = jacobian.map(|row| dot(row, change));
        }
        ([0, 1, 2].map(|i: usize| lab[i] - wanted[i]), slopes)
    }
}

/// So that a layer of no pigment divides nothing by zero.
const LEAST_SCATTERING: f32 = 1e-5;

/// Kubelka's layer over a ground, one channel: [`Coefficients::layer`] in single precision.
fn reflected(absorption: f32, scattering: f32, ground: f32) -> f32 {
    let a = (absorption + scattering) / scattering;
    let bs = (absorption * (absorption + 2.0 * scattering)).sqrt();
    let b = (bs / scattering).max(1e-4);
    let once = libm::expf(-bs.min(30.0));
    let twice = once * once;
    let below = a * (1.0 - twice) + b * (1.0 + twice);
    let (reflectance, transmittance) = ((1.0 - twice) / below, 2.0 * once * b / below);
    reflectance + transmittance * transmittance * ground / (1.0 - reflectance * ground)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// XYZ of linear sRGB over D65's, row by row.
const TO_XYZ: [[f32; 3]; 3] = [
    [0.433_949_9, 0.376_209_8, 0.189_840_4],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.017_756_6, 0.109_468, 0.872_775_5],
];

/// The way back.
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.079_955, -1.537_139, -0.542_816_1],
    [-0.921_258_6, 1.876_011_1, 0.045_247_5],
    [0.052_887_4, -0.204_025_9, 1.151_138_5],
];

/// CIELAB of linear sRGB, and its derivatives by each channel.
fn lab_and_slopes(color: [f32; 3]) -> ([f32; 3], [[f32; 3]; 3]) {
    let mut f = [0.0f32; 3];
    let mut slope = [0.0f32; 3];
    for i in 0..3 {
        let t = dot(TO_XYZ[i], color);
        if t > 0.008_856 {
            f[i] = libm::cbrtf(t);
            slope[i] = f[i] / (3.0 * t);
        } else {
            f[i] = 7.787 * t + 16.0 / 116.0;
            slope[i] = 7.787;
        }
    }
    let by = |i: usize| TO_XYZ[i].map(|value| value * slope[i]);
    let (x, y, z) = (by(0), by(1), by(2));
    let lab = [116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])];
    let rows = [
        y.map(|y| 116.0 * y),
        [0, 1, 2].map(|c: usize| 500.0 * (x[c] - y[c])),
        [0, 1, 2].map(|c: usize| 200.0 * (y[c] - z[c])),
    ];
    (lab, rows)
}

/// CIELAB of linear sRGB.
pub fn lab(color: [f32; 3]) -> [f32; 3] {
    let f = TO_XYZ.map(|row| {
        let t = dot(row, color);
        if t > 0.008_856 { libm::cbrtf(t) } else { 7.787 * t + 16.0 / 116.0 }
    });
    [116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])]
}

/// Linear sRGB of CIELAB; channels may lie outside 0 to 1.
pub fn from_lab([l, a, b]: [f32; 3]) -> [f32; 3] {
    let y = (l + 16.0) / 116.0;
    let xyz = [y + a / 500.0, y, y - b / 200.0]
        .map(|f| if f > 0.206_896_6 { f * f * f } else { (f - 16.0 / 116.0) / 7.787 });
    FROM_XYZ.map(|row| dot(row, xyz))
}

/// The same of a whole raster.
pub fn in_lab(colors: &Raster<[f32; 3]>) -> Raster<[f32; 3]> {
    Raster::by_rows(colors.width(), colors.height(), |x, y| lab(colors.at(x, y)))
}

/// Solves a small symmetric system by Gauss's elimination; the last column is the right side.
fn solved(mut system: [[f32; MOST + 1]; MOST], count: usize) -> [f32; MOST] {
    for k in 0..count {
        let pivot = system[k];
        if pivot[k].abs() < 1e-12 {
            continue;
        }
        for row in system.iter_mut().take(count).skip(k + 1) {
            let factor = row[k] / pivot[k];
            for j in (k..count).chain([MOST]) {
                row[j] -= factor * pivot[j];
            }
        }
    }
    let mut solution = [0.0; MOST];
    for k in (0..count).rev() {
        let known: f32 = (k + 1..count).map(|j| system[k][j] * solution[j]).sum();
        if system[k][k].abs() > 1e-12 {
            solution[k] = (system[k][MOST] - known) / system[k][k];
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use girtin_optics::{Library, LinearRgb};

    use super::*;

    const LIMITS: Limits = Limits { each: 2.0, total: 3.0, thrift: 0.01, keeping: 0.0, rounds: 30, hue: 1.0 };

    fn paints() -> (Vec<Coefficients>, Paints) {
        let library = Library::builtin();
        let names = ["hansa-yellow", "quinacridone-rose", "phthalo-blue", "burnt-umber"];
        let coefficients: Vec<_> = names.iter().map(|name| library.get(name).unwrap().coefficients).collect();
        (coefficients.clone(), Paints::new(&coefficients))
    }

    #[test]
    fn colors_and_lab_are_those_of_optics() {
        let (coefficients, paints) = paints();
        for amounts in [[0.0, 0.0, 0.0, 0.0], [0.4, 0.1, 0.0, 0.2], [0.0, 1.5, 0.3, 0.0]] {
            let ground = LinearRgb([0.9, 0.8, 0.7]);
            let parts = coefficients.iter().zip(amounts.map(f64::from));
            let exact = girtin_optics::kubelka_munk::glaze(parts, ground);
            let found = paints.over(&amounts, [0.9, 0.8, 0.7]);
            let worst = found.iter().zip(exact.0).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
            assert!(worst < 2e-3, "{amounts:?}: {worst}");
            let (exact, found) = (exact.to_lab(), lab(found));
            assert!((exact.l - f64::from(found[0])).abs() < 0.3, "{} {}", exact.l, found[0]);
        }
    }

    #[test]
    fn lab_goes_both_ways() {
        for color in [[0.02, 0.5, 0.9], [0.9, 0.01, 0.2], [0.001, 0.001, 0.002]] {
            let back = from_lab(lab(color));
            assert!(back.iter().zip(color).all(|(a, b)| (a - b).abs() < 2e-4), "{color:?} {back:?}");
        }
    }

    #[test]
    fn a_mixture_s_color_is_found_again() {
        let (_, paints) = paints();
        for amounts in [[0.3f32, 0.0, 0.2, 0.1], [0.0, 0.5, 0.0, 0.4], [0.6, 0.6, 0.1, 0.0]] {
            let ground = [0.9, 0.88, 0.8];
            let wanted = lab(paints.over(&amounts, ground));
            let (_, error) = paints.separate(wanted, ground, None, &LIMITS);
            assert!(error.iter().all(|e| e.abs() < 1.0), "{amounts:?} {error:?}");
        }
    }

    #[test]
    fn limits_hold() {
        let (_, paints) = paints();
        let limits = Limits { each: 0.5, total: 0.9, ..LIMITS };
        let (amounts, _) = paints.separate([0.0, 0.0, 0.0], [0.9; 3], None, &limits);
        assert!(amounts.iter().all(|a| (0.0..=0.5).contains(a)));
        assert!(amounts.iter().sum::<f32>() < 0.901);
    }
}
