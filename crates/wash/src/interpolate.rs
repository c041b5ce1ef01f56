//! Coarse values between coarse cells: what fine cells see of water that is simulated on a coarser grid.

use multiversion::multiversion;

/// Fine cells along a coarse one, at most.
pub const MOST_FACTOR: usize = 8;

/// How much of the coarse values before, in and after a coarse cell each of its fine ones sees, along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    factor: usize,
    weights: [[f32; 3]; MOST_FACTOR],
}

impl Taps {
    fn new(factor: usize, weights: impl Fn(f64) -> [f64; 3]) -> Self {
        let mut taps = Self { factor, weights: [[0.0; 3]; MOST_FACTOR] };
        for (i, taps) in taps.weights.iter_mut().take(factor).enumerate() {
            *taps = weights(i as f64).map(|weight| weight as f32);
        }
        taps
    }

    /// From centres of cells to centres of cells, linearly.
    pub fn centers(factor: usize) -> Self {
        Self::new(factor, |i| {
            let off = (i + 0.5) / factor as f64 - 0.5;
            [(-off).max(0.0), 1.0 - off.abs(), off.max(0.0)]
        })
    }

    /// From faces to faces along the axis across them, linearly: this keeps the divergence.
    pub fn faces(factor: usize) -> Self {
        Self::new(factor, |i| [0.0, 1.0 - i / factor as f64, i / factor as f64])
    }

    /// From centres to centres by the quadratic spline, whose contours are round where a mask has stairs.
    pub fn spline(factor: usize) -> Self {
        Self::new(factor, |i| {
            let off = (i + 0.5) / factor as f64 - 0.5;
            [0.5 * (0.5 - off) * (0.5 - off), 0.75 - off * off, 0.5 * (0.5 + off) * (0.5 + off)]
        })
    }

    /// Fine cells along a coarse one.
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// The weights of a fine cell, by its place in the coarse one.
    pub fn of(&self, place: usize) -> [f32; 3] {
        self.weights[place]
    }
}

/// A row between three coarse ones: the one before, the one in which it lies, and the one after.
///
/// # Shapes and units
/// All rows begin at the same cell.
pub fn blend(between: &mut [f32], coarse: [&[f32]; 3], weights: [f32; 3]) {
    blend_kernel(between, coarse, weights);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn blend_kernel(between: &mut [f32], coarse: [&[f32]; 3], weights: [f32; 3]) {
    let n = between.len();
    let [before, here, after] = coarse.map(|row| &row[..n]);
    let [w_before, w_here, w_after] = weights;
    for i in 0..n {
        between[i] = w_before * before[i] + w_here * here[i] + w_after * after[i];
    }
}

/// The fine values of a row of coarse cells.
///
/// # Shapes and units
/// `coarse` has one cell more at both ends; `fine` is as long as the coarse cells between them are fine.
pub fn expand(fine: &mut [f32], coarse: &[f32], taps: &Taps) {
    match taps.factor {
        2 => expand_kernel::<2>(fine, coarse, taps),
        3 => expand_kernel::<3>(fine, coarse, taps),
        4 => expand_kernel::<4>(fine, coarse, taps),
        5 => expand_kernel::<5>(fine, coarse, taps),
        6 => expand_kernel::<6>(fine, coarse, taps),
        7 => expand_kernel::<7>(fine, coarse, taps),
        8 => expand_kernel::<8>(fine, coarse, taps),
        factor => unreachable!("{factor} fine cells along a coarse one"),
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn expand_kernel<const FACTOR: usize>(fine: &mut [f32], coarse: &[f32], taps: &Taps) {
    let mut weights = [[0.0f32; FACTOR]; 3];
    for (side, weights) in weights.iter_mut().enumerate() {
        for (weight, taps) in weights.iter_mut().zip(&taps.weights) {
            *weight = taps[side];
        }
    }
    let [w_before, w_here, w_after] = weights;
    for (fine, around) in fine.chunks_exact_mut(FACTOR).zip(coarse.windows(3)) {
        let [before, here, after] = [around[0], around[1], around[2]];
        for i in 0..FACTOR {
            fine[i] = w_before[i] * before + w_here[i] * here + w_after[i] * after;
        }
    }
}

/// Writes film where the mask is wet and 0 elsewhere; returns the bits of the thinnest that is wet.
pub fn put_where_wet(out: &mut [f32], film: &[f32], mask: &[u8]) -> i32 {
    put_where_wet_kernel(out, film, mask)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn put_where_wet_kernel(out: &mut [f32], film: &[f32], mask: &[u8]) -> i32 {
    let n = out.len();
    let (film, mask) = (&film[..n], &mask[..n]);
    let mut thinnest = i32::MAX;
    for i in 0..n {
        out[i] = if mask[i] != 0 { film[i] } else { 0.0 };
        let seen = if mask[i] != 0 { film[i] } else { f32::INFINITY };
        thinnest = thinnest.min(seen.to_bits() as i32);
    }
    thinnest
}

/// Writes values times a factor where faces are open and 0 elsewhere.
pub fn put_where_open(out: &mut [f32], values: &[f32], factor: f32, mobility: &[f32]) {
    put_where_open_kernel(out, values, factor, mobility);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn put_where_open_kernel(out: &mut [f32], values: &[f32], factor: f32, mobility: &[f32]) {
    let n = out.len();
    let (values, mobility) = (&values[..n], &mobility[..n]);
    for i in 0..n {
        out[i] = if mobility[i] > 0.0 { factor * values[i] } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_linear_stays_linear() {
        for factor in 2..=MOST_FACTOR {
            let coarse: Vec<f32> = (0..7).map(|x| x as f32).collect();
            let mut fine = vec![0.0; 5 * factor];
            expand(&mut fine, &coarse, &Taps::centers(factor));
            for (i, &value) in fine.iter().enumerate() {
                let wanted = 1.0 + (i as f32 + 0.5) / factor as f32 - 0.5;
                assert!((value - wanted).abs() < 1e-5, "{factor}: {value} is not {wanted}");
            }
            expand(&mut fine, &coarse, &Taps::faces(factor));
            for (i, &value) in fine.iter().enumerate() {
                let wanted = 1.0 + i as f32 / factor as f32;
                assert!((value - wanted).abs() < 1e-5, "{factor}: {value} is not {wanted}");
            }
            expand(&mut fine, &coarse, &Taps::spline(factor));
            assert!((fine.iter().sum::<f32>() / fine.len() as f32 - 3.0).abs() < 1e-5);
        }
    }

    #[test]
    fn interpolated_faces_keep_the_divergence() {
        let factor = 4;
        let coarse = [0.0, 1.0, 3.0, -2.0, 0.0, 0.0];
        let mut fine = vec![0.0; 4 * factor];
        expand(&mut fine, &coarse, &Taps::faces(factor));
        for x in 0..3 * factor {
            let wanted = (coarse[x / factor + 2] - coarse[x / factor + 1]) / factor as f32;
            assert!((fine[x + 1] - fine[x] - wanted).abs() < 1e-6, "{x}");
        }
    }
}
