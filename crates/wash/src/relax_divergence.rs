//! `RelaxDivergence`: pressure evens out what flows into each cell and what flows out.

use multiversion::multiversion;

use crate::region::Run;

/// The correction δ of each cell of one row; returns the bits of the largest |δ|.
///
/// # Source
/// Curtis et al. 1997, §4.3.2, `RelaxDivergence`.
///
/// # Shapes and units
/// Field rows, from the velocities before the sweep.
///
/// # Guarantees
/// 0 in dry cells.
///
/// # Deviations
/// D2, D5.
pub fn divergence(delta: &mut [f32], flow: &FlowRows<'_>, rate: f32, run: Run) -> i32 {
    if run.all_wet {
        divergence_kernel::<true>(delta, flow, rate, run)
    } else {
        divergence_kernel::<false>(delta, flow, rate, run)
    }
}

/// The faces around the cells of one row, and which cells are wet.
#[derive(Clone, Copy, Debug)]
pub struct FlowRows<'a> {
    /// Horizontal velocity of the row.
    pub u: &'a [f32],
    /// Vertical velocity at the row's upper faces.
    pub v: &'a [f32],
    /// Vertical velocity at the row's lower faces.
    pub v_below: &'a [f32],
    /// Wet mask of the row.
    pub mask: &'a [u8],
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn divergence_kernel<const ALL_WET: bool>(
    delta: &mut [f32],
    flow: &FlowRows<'_>,
    rate: f32,
    run: Run,
) -> i32 {
    let (first, n) = (run.first, run.padded());
    let delta = &mut delta[first..][..n];
    let (u, u_after) = (&flow.u[first..][..n], &flow.u[first + 1..][..n]);
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    let m = &flow.mask[first..][..n];
    let mut largest = 0;
    for i in 0..n {
        let correction = -rate * ((u_after[i] - u[i]) + (v_below[i] - v[i])); // D2
        delta[i] = if ALL_WET || m[i] != 0 { correction } else { 0.0 };
        largest = largest.max(delta[i].abs().to_bits() as i32);
    }
    largest
}

/// Applies the corrections to the pressure of one row and to the faces before and above its cells.
///
/// # Source
/// Curtis et al. 1997, §4.3.2, `RelaxDivergence`, gathered by face.
///
/// # Shapes and units
/// Field rows; `delta_above` is that of the row above.
///
/// # Guarantees
/// Faces that touch a dry cell become 0; pressure of dry cells is untouched.
///
/// # Deviations
/// D2, D5.
pub fn apply(u: &mut [f32], v: &mut [f32], pressure: &mut [f32], correction: &CorrectionRows<'_>, run: Run) {
    if run.all_wet {
        apply_kernel::<true>(u, v, pressure, correction, run);
        u[run.first] = 0.0; // it touches a dry cell
    } else {
        apply_kernel::<false>(u, v, pressure, correction, run);
    }
}

/// The corrections of a row and the one above it, and which cells are wet.
#[derive(Clone, Copy, Debug)]
pub struct CorrectionRows<'a> {
    /// δ above; its values over dry cells are never used.
    pub delta_above: &'a [f32],
    /// δ here.
    pub delta: &'a [f32],
    /// Wet mask above.
    pub mask_above: &'a [u8],
    /// Wet mask here.
    pub mask: &'a [u8],
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn apply_kernel<const ALL_WET: bool>(
    u: &mut [f32],
    v: &mut [f32],
    pressure: &mut [f32],
    correction: &CorrectionRows<'_>,
    run: Run,
) {
    let (first, n) = (run.first, run.padded());
    let (u_beyond, v_beyond, p_beyond) = (run.beyond(u), run.beyond(v), run.beyond(pressure));
    let (u_row, v_row, p_row) = (u, v, pressure);
    let (u, v, p) = (&mut u_row[first..][..n], &mut v_row[first..][..n], &mut p_row[first..][..n]);
    let (delta_before, delta) = (&correction.delta[first - 1..][..n], &correction.delta[first..][..n]);
    let delta_above = &correction.delta_above[first..][..n];
    let (m_before, m) = (&correction.mask[first - 1..][..n], &correction.mask[first..][..n]);
    let m_above = &correction.mask_above[first..][..n];
    for i in 0..n {
        let raised = p[i] + delta[i];
        p[i] = if ALL_WET || m[i] != 0 { raised } else { p[i] };
        let relaxed = v[i] + (delta_above[i] - delta[i]);
        v[i] = if ALL_WET || m_above[i] & m[i] != 0 { relaxed } else { 0.0 }; // D5
        let relaxed = u[i] + (delta_before[i] - delta[i]);
        u[i] = if ALL_WET || m_before[i] & m[i] != 0 { relaxed } else { 0.0 };
    }
    if ALL_WET {
        u_beyond.put_back(u_row);
        v_beyond.put_back(v_row);
        p_beyond.put_back(p_row);
    }
}
