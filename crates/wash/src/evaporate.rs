//! Evaporation: the film dries everywhere and fastest along its edge, and damp pores dry too.
//!
//! What evaporates is counted in whole quanta, so its sum does not depend on the order in which cells are added.

use multiversion::multiversion;

use crate::region::Run;
use crate::simulate_capillary_flow::Pores;

/// Quanta in one unit of water over one cell: fine enough for f32 amounts, coarse enough that a cell's fits an i32.
pub const QUANTA: f64 = (1u32 << 28) as f64;

/// The film of one row evaporates; returns how much, in quanta, and the bits of the thinnest film that is left.
///
/// # Shapes and units
/// Field rows; `edge` is what dries at the edge besides ([`Outflow`](crate::flow_outward::Outflow)), 0 where there is
/// none; `everywhere` is film a step.
///
/// # Guarantees
/// No film is taken below 0; dry cells are untouched.
pub fn evaporate(film: &mut [f32], edge: &[f32], mask: &[u8], everywhere: f32, run: Run) -> (i64, i32) {
    evaporate_kernel(film, edge, mask, everywhere, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn evaporate_kernel(film: &mut [f32], edge: &[f32], mask: &[u8], everywhere: f32, run: Run) -> (i64, i32) {
    let (first, n) = (run.first, run.len());
    let (p, edge, m) = (&mut film[first..][..n], &edge[first..][..n], &mask[first..][..n]);
    let mut quanta = 0;
    for i in 0..n {
        let held = if p[i] > 0.0 { p[i] } else { 0.0 };
        let dries = everywhere + edge[i];
        let dries = if dries < held { dries } else { held };
        let left = if m[i] != 0 { p[i] - dries } else { p[i] };
        quanta += in_quanta(p[i] - left);
        p[i] = left;
    }
    (quanta, thinnest_kernel(film, mask, run))
}

/// Bits of the thinnest film of one row.
pub fn thinnest(film: &[f32], mask: &[u8], run: Run) -> i32 {
    thinnest_kernel(film, mask, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn thinnest_kernel(film: &[f32], mask: &[u8], run: Run) -> i32 {
    let (first, n) = (run.first, run.len());
    let (p, m) = (&film[first..][..n], &mask[first..][..n]);
    let mut thinnest = i32::MAX;
    for i in 0..n {
        let bits = p[i].to_bits() as i32;
        let seen = if m[i] != 0 { bits } else { i32::MAX };
        thinnest = if seen < thinnest { seen } else { thinnest };
    }
    thinnest
}

/// An amount of water in quanta, rounded.
///
/// Adding 2²⁴ to an amount below 16 leaves no digit finer than a quantum in an f64, and the amount as the lowest bits of its
/// pattern: whole vectors do that, while a checked conversion to an integer goes value by value.
#[inline(always)]
fn in_quanta(amount: f32) -> i64 {
    const SHIFT: f64 = (1u64 << 24) as f64;
    let bits = (f64::from(amount) + SHIFT).to_bits() as i64;
    bits - SHIFT.to_bits() as i64
}

/// The pores of one row evaporate where no film covers them; returns how much, in quanta of saturation.
///
/// # Shapes and units
/// Field rows; `amount` is saturation a step.
pub fn evaporate_pores(saturation: &mut [f32], mask: &[u8], amount: f32, run: Run) -> i64 {
    evaporate_pores_kernel(saturation, mask, amount, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn evaporate_pores_kernel(saturation: &mut [f32], mask: &[u8], amount: f32, run: Run) -> i64 {
    let (first, n) = (run.first, run.len());
    let (s, m) = (&mut saturation[first..][..n], &mask[first..][..n]);
    let mut quanta = 0;
    for i in 0..n {
        let dries = if amount < s[i] { amount } else { s[i] };
        let left = if m[i] == 0 { s[i] - dries } else { s[i] };
        quanta += in_quanta(s[i] - left);
        s[i] = left;
    }
    quanta
}

/// How far each cell of one row counts as wet for its neighbours' edges: wholly under film, and the more the fuller its
/// pores are beside it. Returns whether any value changed.
///
/// # Shapes and units
/// Field rows; `cover` 0 to 1; `exponent` says how nearly full the pores must be.
pub fn cover(
    cover: &mut [f32],
    saturation: &[f32],
    height: &[f32],
    mask: &[u8],
    pores: &Pores,
    exponent: u32,
    run: Run,
) -> bool {
    let mut any = 0;
    for (i, cover) in cover[run.first..run.end].chunks_mut(COVER_CHUNK).enumerate() {
        let first = run.first + i * COVER_CHUNK;
        let columns = first..first + cover.len();
        let rows = [&saturation[columns.clone()], &height[columns.clone()]];
        any |= cover_kernel(cover, rows, &mask[columns], *pores, exponent);
    }
    any != 0
}

/// Cells whose powers are taken at a time.
const COVER_CHUNK: usize = 64;

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn cover_kernel(
    cover: &mut [f32],
    [saturation, height]: [&[f32]; 2],
    mask: &[u8],
    pores: Pores,
    exponent: u32,
) -> u32 {
    let n = cover.len();
    let (s, h, m) = (&saturation[..n], &height[..n], &mask[..n]);
    let (mut base, mut power) = ([0.0f32; COVER_CHUNK], [1.0f32; COVER_CHUNK]);
    for i in 0..n {
        let fill = s[i] / pores.capacity(h[i]);
        base[i] = if fill < 1.0 { fill } else { 1.0 };
    }
    // By squaring: whole vectors at a time for each binary digit of the exponent.
    let mut left = exponent;
    while left > 0 {
        if left & 1 != 0 {
            power.iter_mut().zip(&base).for_each(|(power, base)| *power *= base);
        }
        base.iter_mut().for_each(|base| *base *= *base);
        left >>= 1;
    }
    let mut changed = 0;
    for i in 0..n {
        let now = if m[i] != 0 { 1.0 } else { power[i] };
        changed |= now.to_bits() ^ cover[i].to_bits();
        cover[i] = now;
    }
    changed
}
