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
    find::<ALL_WET>(delta, flow, rate, run)
}

#[inline(always)]
fn find<const ALL_WET: bool>(delta: &mut [f32], flow: &FlowRows<'_>, rate: f32, run: Run) -> i32 {
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

/// One relaxation sweep of one row: finds its corrections and applies them to its pressure and to the faces before and
/// above its cells; returns the bits of the largest |δ|.
///
/// # Source
/// Curtis et al. 1997, §4.3.2, `RelaxDivergence`, gathered by face.
///
/// # Shapes and units
/// Field rows; `delta` receives the row's corrections, which the row below needs.
///
/// # Guarantees
/// Faces that touch a dry cell become 0; pressure of dry cells is untouched.
///
/// # Deviations
/// D2, D5.
pub fn relax(water: WaterRows<'_>, delta: &mut [f32], around: &AroundRows<'_>, rate: f32, run: Run) -> i32 {
    let WaterRows { u, v, pressure } = water;
    if run.all_wet {
        let largest = relax_kernel::<true>(u, v, pressure, delta, around, rate, run);
        u[run.first] = 0.0; // it touches a dry cell
        largest
    } else {
        relax_kernel::<false>(u, v, pressure, delta, around, rate, run)
    }
}

/// The water of one row.
#[derive(Debug)]
pub struct WaterRows<'a> {
    /// Horizontal velocity.
    pub u: &'a mut [f32],
    /// Vertical velocity at the upper faces.
    pub v: &'a mut [f32],
    /// Pressure.
    pub pressure: &'a mut [f32],
}

/// What [`relax`] reads besides: of the rows beside, and which cells are wet.
#[derive(Clone, Copy, Debug)]
pub struct AroundRows<'a> {
    /// Vertical velocity at the lower faces.
    pub v_below: &'a [f32],
    /// δ above; its values over dry cells are never used.
    pub delta_above: &'a [f32],
    /// Wet mask above.
    pub mask_above: &'a [u8],
    /// Wet mask here.
    pub mask: &'a [u8],
}

// One kernel for both, for on a short run a call costs as much as its cells.
#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn relax_kernel<const ALL_WET: bool>(
    u: &mut [f32],
    v: &mut [f32],
    pressure: &mut [f32],
    delta: &mut [f32],
    around: &AroundRows<'_>,
    rate: f32,
    run: Run,
) -> i32 {
    let &AroundRows { v_below, mask, .. } = around;
    let largest = find::<ALL_WET>(delta, &FlowRows { u, v, v_below, mask }, rate, run);
    apply::<ALL_WET>(u, v, pressure, delta, around, run);
    largest
}

#[inline(always)]
fn apply<const ALL_WET: bool>(
    u: &mut [f32],
    v: &mut [f32],
    pressure: &mut [f32],
    delta: &[f32],
    around: &AroundRows<'_>,
    run: Run,
) {
    let (first, n) = (run.first, run.padded());
    let (u_beyond, v_beyond, p_beyond) = (run.beyond(u), run.beyond(v), run.beyond(pressure));
    let (u_row, v_row, p_row) = (u, v, pressure);
    let (u, v, p) = (&mut u_row[first..][..n], &mut v_row[first..][..n], &mut p_row[first..][..n]);
    let (delta_before, delta) = (&delta[first - 1..][..n], &delta[first..][..n]);
    let delta_above = &around.delta_above[first..][..n];
    let (m_before, m) = (&around.mask[first - 1..][..n], &around.mask[first..][..n]);
    let m_above = &around.mask_above[first..][..n];
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
