//! Settling: a film drops its pigment as it vanishes.

use multiversion::multiversion;

use crate::region::Run;

/// Film of a row and its neighbours, and which cells are wet.
#[derive(Clone, Copy, Debug)]
pub struct AroundRows<'a> {
    /// Film above.
    pub above: &'a [f32],
    /// Film here.
    pub here: &'a [f32],
    /// Film below.
    pub below: &'a [f32],
    /// Wet mask above.
    pub mask_above: &'a [u8],
    /// Wet mask here.
    pub mask: &'a [u8],
    /// Wet mask below.
    pub mask_below: &'a [u8],
}

/// The fraction of its suspended pigment that each cell of one row drops in a step; returns whether any does.
///
/// A film as deep as `flowing`, in the cell or beside it, holds its pigment.
///
/// # Shapes and units
/// Field rows; `rate` is the fraction where there is no film at all.
pub fn fractions(fraction: &mut [f32], film: &AroundRows<'_>, flowing: f32, rate: f32, run: Run) -> bool {
    fractions_kernel(fraction, film, flowing, rate, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn fractions_kernel(fraction: &mut [f32], film: &AroundRows<'_>, flowing: f32, rate: f32, run: Run) -> bool {
    let (first, n) = (run.first, run.len());
    let fraction = &mut fraction[first..][..n];
    let (p, m) = (&film.here[first - 1..][..n + 2], &film.mask[first - 1..][..n + 2]);
    let (above, below) = (&film.above[first..][..n], &film.below[first..][..n]);
    let (m_above, m_below) = (&film.mask_above[first..][..n], &film.mask_below[first..][..n]);
    let scale = 1.0 / flowing;
    let wet = |film: f32, mask: u8| if mask != 0 { film } else { 0.0 };
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let mut any = 0;
    for i in 0..n {
        let beside = larger(wet(p[i], m[i]), wet(p[i + 2], m[i + 2]));
        let upright = larger(wet(above[i], m_above[i]), wet(below[i], m_below[i]));
        let deepest = larger(larger(p[i + 1], 0.0), larger(beside, upright));
        let bare = 1.0 - deepest * scale;
        let bare = if (bare > 0.0) & (m[i + 1] != 0) { bare } else { 0.0 };
        fraction[i] = rate * bare * bare;
        any |= fraction[i].to_bits();
    }
    any != 0
}

/// Drops a fraction of the suspended pigment of each cell of one row.
///
/// # Guarantees
/// suspended + deposited is kept to rounding.
pub fn settle(suspended: &mut [f32], deposited: &mut [f32], fraction: &[f32], run: Run) {
    settle_kernel(suspended, deposited, fraction, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn settle_kernel(suspended: &mut [f32], deposited: &mut [f32], fraction: &[f32], run: Run) {
    let (first, n) = (run.first, run.len());
    let (g, d) = (&mut suspended[first..][..n], &mut deposited[first..][..n]);
    let fraction = &fraction[first..][..n];
    for i in 0..n {
        let dropped = fraction[i] * g[i];
        d[i] += dropped;
        g[i] -= dropped;
    }
}
