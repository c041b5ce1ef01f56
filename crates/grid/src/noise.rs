//! Gradient noise, fractal sums and cellular noise over the plane, tileable at will.
//!
//! Positions are in lattice units. A [`Noise`] may repeat after a whole number of lattice cells in x and y,
//! and then does so exactly.
//!
//! The functions of a point are what the noise is; [`Noise::add_gradient_block`] gives the same numbers for a
//! block of points at a tenth of the cost, because a block meets few lattice cells.

use core::ops::Range;

use crate::random;

/// Sixteen unit vectors, at odd multiples of 11.25°, so that none lies along the lattice or its diagonals.
const GRADIENTS: [[f64; 2]; 16] = {
    // Cosine and sine of 11.25° and of 33.75°.
    const A: f64 = 0.980_785_280_403_230_4;
    const B: f64 = 0.195_090_322_016_128_28;
    const C: f64 = 0.831_469_612_302_545_2;
    const D: f64 = 0.555_570_233_019_602_2;
    [
        [A, B],
        [C, D],
        [D, C],
        [B, A],
        [-B, A],
        [-D, C],
        [-C, D],
        [-A, B],
        [-A, -B],
        [-C, -D],
        [-D, -C],
        [-B, -A],
        [B, -A],
        [D, -C],
        [C, -D],
        [A, -B],
    ]
};

/// Gradient noise of unit gradients reaches the root of 1/2 in the middle of a cell, and no further.
const GRADIENT_SCALE: f64 = core::f64::consts::SQRT_2;

/// One noise over the plane: a seed, and perhaps a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Noise {
    key: u64,
    period: Option<[u32; 2]>,
}

/// How many octaves are summed, and how fast they weaken; each is twice as fine as the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fractal {
    /// Number of octaves.
    pub octaves: u32,
    /// Amplitude of an octave over that of the one before.
    pub gain: f64,
}

/// The two nearest of scattered points, one point to a lattice cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cellular {
    /// Distance to the nearest point.
    pub f1: f64,
    /// Distance to the next.
    pub f2: f64,
    /// 64 random bits of the nearest point.
    pub nearest: u64,
}

/// Equally spaced positions on one axis, in lattice units.
///
/// Sample `j` is at `(first + j) * step + offset`, whatever part of a row is asked for: parts of a row,
/// computed apart, agree to the bit as long as `first` counts from the same place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples {
    /// Number of the first sample.
    pub first: f64,
    /// Distance of two samples, above 0.
    pub step: f64,
    /// Where sample number 0 is.
    pub offset: f64,
}

impl Samples {
    /// Position of sample `j`.
    #[inline]
    pub fn at(&self, j: usize) -> f64 {
        (self.first + j as f64) * self.step + self.offset
    }

    /// The lattice cells that the first `count` samples meet, each with the samples inside it.
    pub fn runs(&self, count: usize) -> impl Iterator<Item = (i64, Range<usize>)> + '_ {
        let mut start = 0;
        core::iter::from_fn(move || {
            if start >= count {
                return None;
            }
            let cell = libm::floor(self.at(start));
            // The guess is off by one where the division rounds; the two loops settle it by the samples
            // themselves.
            let guess = libm::ceil((cell + 1.0 - self.offset) / self.step - self.first);
            let mut end =
                if guess > start as f64 { (guess as usize).clamp(start + 1, count) } else { start + 1 };
            while end > start + 1 && libm::floor(self.at(end - 1)) > cell {
                end -= 1;
            }
            while end < count && libm::floor(self.at(end)) <= cell {
                end += 1;
            }
            let run = start..end;
            start = end;
            Some((cell as i64, run))
        })
    }
}

impl Noise {
    /// Noise without a period.
    pub const fn new(seed: u64, stage: u64) -> Self {
        Self { key: random::key(seed, stage), period: None }
    }

    /// The same noise repeating after `period` lattice cells; a period of 0 counts as 1.
    #[must_use]
    pub const fn tiled(self, period: [u32; 2]) -> Self {
        let x = if period[0] == 0 { 1 } else { period[0] };
        let y = if period[1] == 0 { 1 } else { period[1] };
        Self { period: Some([x, y]), ..self }
    }

    /// 64 random bits of a lattice cell.
    #[inline]
    pub fn bits(&self, cell: [i64; 2]) -> u64 {
        let cell = match self.period {
            None => cell,
            Some([x, y]) => [cell[0].rem_euclid(i64::from(x)), cell[1].rem_euclid(i64::from(y))],
        };
        random::at(self.key, cell)
    }

    #[inline]
    fn slope(&self, corner: [i64; 2]) -> [f64; 2] {
        GRADIENTS[(self.bits(corner) >> 60) as usize]
    }

    /// Gradient noise: −1 to 1, mean 0, zero at every lattice point, its second derivatives continuous.
    ///
    /// # Source
    /// Ken Perlin, *Improving Noise*, SIGGRAPH 2002, with sixteen gradients. Its standard deviation is 0.30.
    pub fn gradient(&self, [x, y]: [f64; 2]) -> f64 {
        let (cell_x, cell_y) = (libm::floor(x), libm::floor(y));
        let (fx, fy) = (x - cell_x, y - cell_y);
        let (i, j) = (cell_x as i64, cell_y as i64);
        let corner = |di: i64, dj: i64| {
            let [a, b] = self.slope([i + di, j + dj]);
            a * (fx - di as f64) + b * (fy - dj as f64)
        };
        let (u, v) = (ease(fx), ease(fy));
        let top = corner(0, 0) + u * (corner(1, 0) - corner(0, 0));
        let bottom = corner(0, 1) + u * (corner(1, 1) - corner(0, 1));
        GRADIENT_SCALE * (top + v * (bottom - top))
    }

    /// Adds `weight` × [`gradient`](Self::gradient) at `(x.at(i), y.at(j))` to each `out[j * width + i]`, in
    /// single precision.
    ///
    /// # Guarantees
    /// A value depends on its position only, to the bit, not on the block it is in
    /// (`a_block_is_the_same_in_parts`).
    ///
    /// # Panics
    /// `width` is 0, or the length of `out` is no multiple of it.
    pub fn add_gradient_block(&self, x: &Samples, y: &Samples, width: usize, weight: f32, out: &mut [f32]) {
        assert!(width > 0 && out.len().is_multiple_of(width), "{} values in rows of {width}", out.len());
        // What depends on x alone: the columns of lattice points, and each sample's place between two of
        // them.
        let mut columns: Vec<i64> = Vec::new();
        let mut runs = Vec::new();
        let mut places = vec![(0.0f32, 0.0f32); width];
        for (i, run) in x.runs(width) {
            if columns.last() != Some(&i) {
                columns.push(i);
            }
            columns.push(i + 1);
            for (place, at) in places[run.clone()].iter_mut().zip(run.clone()) {
                let t = (x.at(at) - i as f64) as f32;
                *place = (t, t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
            }
            runs.push((columns.len() - 2, run));
        }
        let mut lines = vec![[0.0f32; 2]; columns.len()];
        for (j, rows) in y.runs(out.len() / width) {
            let slopes: Vec<_> =
                columns.iter().map(|&i| (self.slope([i, j]), self.slope([i, j + 1]))).collect();
            for row in rows {
                let fy = y.at(row) - j as f64;
                let v = ease(fy);
                // Within a lattice cell each column of points contributes a line in fx: level + slope·fx.
                for (line, ([a, b], [c, d])) in lines.iter_mut().zip(&slopes) {
                    let level = b * fy + v * (d * (fy - 1.0) - b * fy);
                    *line = [(GRADIENT_SCALE * level) as f32, (GRADIENT_SCALE * (a + v * (c - a))) as f32];
                }
                let values = &mut out[row * width..][..width];
                for (left, run) in &runs {
                    let ([l0, l1], [r0, r1]) = (lines[*left], lines[left + 1]);
                    for (value, &(t, u)) in values[run.clone()].iter_mut().zip(&places[run.clone()]) {
                        let (left, right) = (l0 + l1 * t, r0 + r1 * (t - 1.0));
                        *value += weight * (left + u * (right - left));
                    }
                }
            }
        }
    }

    /// Octave `number` of a fractal sum, and how its lattice is shifted, so that the octaves' lattice points,
    /// where gradient noise is always zero, do not fall on each other. Its period is in its own, finer
    /// lattice.
    pub fn octave(&self, number: u32) -> (Self, [f64; 2]) {
        let key = random::fold(self.key, u64::from(number));
        let period = self.period.map(|period| period.map(|cells| cells.saturating_mul(1 << number.min(31))));
        let bits = random::mix(key);
        (Self { key, period }, [random::unit_f64(bits), random::unit_f64(random::mix(bits))])
    }

    /// A fractal sum of gradient noise: −1 to 1, mean 0; the first octave has wavelength 1.
    ///
    /// # Source
    /// Fractional Brownian motion as in Ebert et al., *Texturing & Modeling*, chapter 2.
    pub fn fbm(&self, [x, y]: [f64; 2], fractal: Fractal) -> f64 {
        let (mut sum, mut total, mut weight, mut scale) = (0.0, 0.0, 1.0, 1.0);
        for number in 0..fractal.octaves {
            let (noise, [dx, dy]) = self.octave(number);
            sum += weight * noise.gradient([x * scale + dx, y * scale + dy]);
            total += weight;
            weight *= fractal.gain;
            scale *= 2.0;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }

    /// The random point of a lattice cell, relative to the cell's corner, each coordinate in [0, 1).
    #[inline]
    pub fn point(&self, cell: [i64; 2]) -> [f64; 2] {
        let bits = self.bits(cell);
        // Two halves of one hash: 32 bits are plenty for a position.
        const SCALE: f64 = 1.0 / (1u64 << 32) as f64;
        [(bits >> 32) as f64 * SCALE, (bits as u32) as f64 * SCALE]
    }

    /// Cellular noise: how far the nearest and the next of the scattered points are.
    ///
    /// # Source
    /// Steven Worley, *A Cellular Texture Basis Function*, SIGGRAPH 1996, with one point to a cell. Two rings
    /// of cells are searched: with one point in each cell F2 is below 1.81, so a third ring, 2 away, cannot
    /// matter (`cellular_noise_equals_a_wider_search`).
    pub fn cellular(&self, p: [f64; 2]) -> Cellular {
        self.cellular_within(p, 2)
    }

    fn cellular_within(&self, [x, y]: [f64; 2], rings: i64) -> Cellular {
        let (i, j) = (libm::floor(x) as i64, libm::floor(y) as i64);
        let (mut first, mut second, mut nearest) = (f64::INFINITY, f64::INFINITY, 0);
        for cell_y in j - rings..=j + rings {
            for cell_x in i - rings..=i + rings {
                let cell = [cell_x, cell_y];
                let [px, py] = self.point(cell);
                let (dx, dy) = (cell_x as f64 + px - x, cell_y as f64 + py - y);
                let square = dx * dx + dy * dy;
                if square < first {
                    second = first;
                    first = square;
                    nearest = random::mix(self.bits(cell));
                } else if square < second {
                    second = square;
                }
            }
        }
        Cellular { f1: libm::sqrt(first), f2: libm::sqrt(second), nearest }
    }
}

/// 6t⁵ − 15t⁴ + 10t³: from 0 to 1 with first and second derivatives 0 at both ends.
#[inline]
fn ease(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const NOISE: Noise = Noise::new(11, random::stage("test"));

    /// Points that no lattice or its halves can be in step with.
    fn scattered(count: usize) -> impl Iterator<Item = [f64; 2]> {
        (0..count).map(|k| {
            let k = k as f64;
            [k * 0.618_033_988_749 - 300.0, (k * 0.754_877_666_246) % 977.0 - 400.0]
        })
    }

    fn mean_and_deviation(values: impl Iterator<Item = f64>) -> (f64, f64) {
        let (mut count, mut sum, mut square) = (0.0, 0.0, 0.0);
        for value in values {
            count += 1.0;
            sum += value;
            square += value * value;
        }
        let mean = sum / count;
        (mean, libm::sqrt(square / count - mean * mean))
    }

    #[test]
    fn gradient_noise_is_zero_at_lattice_points() {
        for [x, y] in scattered(500) {
            assert_eq!(NOISE.gradient([libm::floor(x), libm::floor(y)]), 0.0);
        }
    }

    #[test]
    fn gradient_noise_has_its_mean_and_deviation() {
        let (mean, deviation) = mean_and_deviation(scattered(200_000).map(|p| NOISE.gradient(p)));
        assert!(mean.abs() < 0.01, "mean {mean}");
        assert!((deviation - 0.305).abs() < 0.01, "deviation {deviation}");
    }

    #[test]
    fn gradient_noise_has_no_favoured_direction() {
        let change = |dx: f64, dy: f64| {
            mean_and_deviation(
                scattered(100_000).map(|[x, y]| NOISE.gradient([x + dx, y + dy]) - NOISE.gradient([x, y])),
            )
            .1
        };
        let d = 0.3 * core::f64::consts::FRAC_1_SQRT_2;
        let (along, across, diagonal) = (change(0.3, 0.0), change(0.0, 0.3), change(d, d));
        assert!((along / across - 1.0).abs() < 0.05, "{along} {across}");
        assert!((along / diagonal - 1.0).abs() < 0.08, "{along} {diagonal}");
    }

    #[test]
    fn fractal_sums_stay_in_range_and_reduce_to_one_octave() {
        let fractal = Fractal { octaves: 5, gain: 0.5 };
        for p in scattered(20_000) {
            assert!(NOISE.fbm(p, fractal).abs() <= 1.0);
        }
        let (one, [dx, dy]) = NOISE.octave(0);
        let p = [3.7, -1.2];
        let single = NOISE.fbm(p, Fractal { octaves: 1, gain: 0.5 });
        assert_eq!(single, one.gradient([p[0] + dx, p[1] + dy]));
        assert_eq!(NOISE.fbm(p, Fractal { octaves: 0, gain: 0.5 }), 0.0);
    }

    #[test]
    fn cellular_noise_equals_a_wider_search() {
        for p in scattered(5_000) {
            assert_eq!(NOISE.cellular(p), NOISE.cellular_within(p, 4));
        }
    }

    #[test]
    fn cellular_noise_has_its_mean() {
        // One uniform point to a cell: more even than a Poisson process, whose mean F1 is 0.5.
        let (mean, _) = mean_and_deviation(scattered(100_000).map(|p| NOISE.cellular(p).f1));
        assert!((mean - 0.43).abs() < 0.01, "{mean}");
    }

    #[test]
    fn seeds_and_stages_give_other_noise() {
        let p = [0.4, 0.7];
        assert_ne!(NOISE.gradient(p), Noise::new(12, random::stage("test")).gradient(p));
        assert_ne!(NOISE.gradient(p), Noise::new(11, random::stage("other")).gradient(p));
    }

    #[test]
    fn a_block_is_the_same_in_parts() {
        let x = Samples { first: -371.0, step: 0.217, offset: 0.31 };
        let y = Samples { first: 12.0, step: 0.31, offset: 0.0 };
        let mut whole = vec![0.0; 97 * 9];
        NOISE.add_gradient_block(&x, &y, 97, 0.7, &mut whole);
        for (cut_x, cut_y) in [(1, 1), (50, 4), (96, 8)] {
            let (right, below) = (
                Samples { first: x.first + cut_x as f64, ..x },
                Samples { first: y.first + cut_y as f64, ..y },
            );
            let width = 97 - cut_x;
            let mut part = vec![0.0; width * (9 - cut_y)];
            NOISE.add_gradient_block(&right, &below, width, 0.7, &mut part);
            for (line, row) in part.chunks(width).enumerate() {
                assert_eq!(row, &whole[(line + cut_y) * 97 + cut_x..][..width]);
            }
        }
    }

    proptest! {
        #[test]
        fn gradient_noise_is_in_range_and_continuous(x in -1e4..1e4f64, y in -1e4..1e4f64) {
            let value = NOISE.gradient([x, y]);
            prop_assert!(value.abs() <= 1.0);
            // Its slope is below 4 everywhere.
            prop_assert!((NOISE.gradient([x + 1e-6, y - 1e-6]) - value).abs() < 8e-6);
        }

        #[test]
        fn cellular_noise_is_in_range_and_continuous(x in -1e4..1e4f64, y in -1e4..1e4f64) {
            let here = NOISE.cellular([x, y]);
            prop_assert!(here.f1 <= here.f2 && here.f2 < 1.81);
            let there = NOISE.cellular([x + 1e-6, y]);
            prop_assert!((here.f1 - there.f1).abs() <= 1.001e-6 && (here.f2 - there.f2).abs() <= 1.001e-6);
        }

        #[test]
        fn tiles_repeat_exactly(i in -64_i32..64, j in -64_i32..64, px in 1_u32..9, py in 1_u32..9) {
            let tiled = NOISE.tiled([px, py]);
            // Eighths are exact, so the two positions are a whole period apart to the bit.
            let p = [f64::from(i) / 8.0, f64::from(j) / 8.0];
            let q = [p[0] + f64::from(px), p[1] - f64::from(py)];
            prop_assert_eq!(tiled.gradient(p), tiled.gradient(q));
            let (p_cell, q_cell) = (tiled.cellular(p), tiled.cellular(q));
            prop_assert!((p_cell.f1 - q_cell.f1).abs() < 1e-12 && (p_cell.f2 - q_cell.f2).abs() < 1e-12);
            let fractal = Fractal { octaves: 4, gain: 0.6 };
            prop_assert!((tiled.fbm(p, fractal) - tiled.fbm(q, fractal)).abs() < 1e-12);
        }

        #[test]
        fn blocks_are_the_points(
            first in -500..500_i32, step in 0.01..2.5f64, offset in -3.0..3.0f64, step_y in 0.01..2.5f64,
        ) {
            let x = Samples { first: f64::from(first), step, offset };
            let y = Samples { first: 3.0, step: step_y, offset: -offset };
            let mut block = vec![1.0; 40 * 5];
            NOISE.add_gradient_block(&x, &y, 40, 0.5, &mut block);
            for (at, value) in block.iter().enumerate() {
                let expected = 1.0 + 0.5 * NOISE.gradient([x.at(at % 40), y.at(at / 40)]);
                prop_assert!((f64::from(*value) - expected).abs() < 2e-6);
            }
        }
    }
}
