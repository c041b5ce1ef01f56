//! Mobility: how freely water moves through each face of the living wash.
//!
//! Under a deep film it moves freely, under a thin one the paper holds it, and to dry paper nothing flows.

use multiversion::multiversion;

use crate::region::Run;
use crate::update_velocities::FilmRows;

/// What a film must be like to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Depth from which on it moves freely.
    pub flowing: f32,
    /// What a vanishing film keeps of its speed in a step.
    pub least: f32,
}

impl Film {
    /// Whether all water moves freely where no film is thinner than this one.
    pub fn is_free(&self, thinnest: f32) -> bool {
        // As the kernel finds it for two such cells.
        (thinnest + thinnest) * (0.5 / self.flowing) >= 1.0
    }

    /// Whether a film this deep holds all its pigment, as [`settle`](crate::settle) finds it.
    pub fn holds_pigment(&self, thinnest: f32) -> bool {
        thinnest * (1.0 / self.flowing) >= 1.0
    }
}

/// What the faces before and above the cells of one row keep of their speed in a step.
///
/// # Shapes and units
/// Field rows; 0 beside a dry cell, 1 under a film of the flowing depth.
pub fn mobility(mobility_u: &mut [f32], mobility_v: &mut [f32], rows: &FilmRows<'_>, film: Film, run: Run) {
    mobility_kernel(mobility_u, mobility_v, rows, film, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn mobility_kernel(m_u: &mut [f32], m_v: &mut [f32], rows: &FilmRows<'_>, film: Film, run: Run) {
    // One face more than cells: the last one touches dry paper or the canvas' edge, but its 0 must be written.
    let (first, n) = (run.first, run.len() + 1);
    let (m_u, m_v) = (&mut m_u[first..][..n], &mut m_v[first..][..n]);
    let (p, p_above) = (&rows.film[first - 1..][..n + 1], &rows.film_above[first..][..n]);
    let (m, m_above) = (&rows.mask[first - 1..][..n + 1], &rows.mask_above[first..][..n]);
    let (scale, range) = (0.5 / film.flowing, 1.0 - film.least);
    let smooth = |sum: f32| {
        let t = sum * scale;
        let t = if t < 1.0 { t } else { 1.0 };
        let t = if t > 0.0 { t } else { 0.0 };
        film.least + range * (t * t * (3.0 - 2.0 * t))
    };
    for i in 0..n {
        let free = smooth(p[i] + p[i + 1]);
        m_u[i] = if m[i] & m[i + 1] != 0 { free } else { 0.0 };
    }
    for i in 0..n {
        let free = smooth(p_above[i] + p[i + 1]);
        m_v[i] = if m_above[i] & m[i + 1] != 0 { free } else { 0.0 };
    }
}

/// What faces keep in a sub-step: the mobility to the power of the sub-step's length.
///
/// # Guarantees
/// Within 1e-6 of the power; 0 stays 0 and 1 stays 1. Plain arithmetic, so the same bits everywhere.
pub fn keep(keep: &mut [f32], mobility: &[f32], dt: f32, run: Run) {
    keep_kernel(keep, mobility, dt, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn keep_kernel(keep: &mut [f32], mobility: &[f32], dt: f32, run: Run) {
    let (first, n) = (run.first, run.len() + 1);
    let (keep, mobility) = (&mut keep[first..][..n], &mobility[first..][..n]);
    for i in 0..n {
        let m = mobility[i];
        let power = exp2(dt * log2(m));
        keep[i] = if m >= 1.0 {
            1.0
        } else if m > 0.0 {
            power
        } else {
            0.0
        };
    }
}

/// Logarithm of a positive number, by the series of the area tangent around 1.
#[inline(always)]
fn log2(x: f32) -> f32 {
    // x = 2^e · f with f in [√½, √2).
    const SQRT_HALF: i32 = 0x3f35_04f3;
    let bits = x.to_bits() as i32;
    let e = (bits - SQRT_HALF) >> 23;
    let f = f32::from_bits((bits - (e << 23)) as u32);
    let s = (f - 1.0) / (f + 1.0);
    let s2 = s * s;
    // 2 / (k ln 2)
    let series = 2.885_39 + s2 * (0.961_796_7 + s2 * (0.577_078 + s2 * (0.412_198_6 + s2 * 0.320_598_9)));
    e as f32 + s * series
}

/// 2 to the power of a number from −100 to 0, by the Taylor series around the middle of a whole step.
#[inline(always)]
fn exp2(x: f32) -> f32 {
    let x = if x > -100.0 { x } else { -100.0 };
    let whole = (x + 100.0) as i32 - 100; // floor, since x + 100 is not negative
    let z = (x - whole as f32 - 0.5) * core::f32::consts::LN_2;
    let series = 1.0
        + z * (1.0
            + z * (0.5
                + z * (1.0 / 6.0
                    + z * (1.0 / 24.0 + z * (1.0 / 120.0 + z * (1.0 / 720.0 + z * (1.0 / 5040.0)))))));
    series * core::f32::consts::SQRT_2 * f32::from_bits(((whole + 127) << 23) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_those_of_libm() {
        for i in 1..=2000 {
            let m = i as f32 / 2000.0;
            for n in [1.0f32, 2.0, 3.0, 7.0, 64.0] {
                let found = exp2(1.0 / n * log2(m));
                let wanted = libm::pow(f64::from(m), f64::from(1.0 / n));
                assert!((f64::from(found) / wanted - 1.0).abs() < 1e-6, "{m}^(1/{n}): {found}, {wanted}");
            }
        }
    }
}
