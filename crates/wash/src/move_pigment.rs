//! `MovePigment`: the water carries suspended pigment along.

use multiversion::multiversion;

use crate::pigment::Exchange;
use crate::region::Run;
use crate::relax_divergence::FlowRows;
use crate::transfer_pigment::exchanged;

/// Bits of the largest sum of outflow speeds of a cell of one row.
///
/// No |u| or |v| of the row's faces is larger, since every moving face takes water out of one cell.
///
/// # Source
/// D4: the sub-steps are short enough that no cell gives away more than it holds.
pub fn outflow_speeds(flow: &FlowRows<'_>, run: Run) -> i32 {
    outflow_speeds_kernel(flow, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn outflow_speeds_kernel(flow: &FlowRows<'_>, run: Run) -> i32 {
    let (first, n) = (run.first, run.padded());
    let (u, u_after) = (&flow.u[first..][..n], &flow.u[first + 1..][..n]);
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    let mut fastest = 0;
    for i in 0..n {
        // Not f32::max: it would drop a NaN, which must be seen.
        let out = |speed: f32| if speed < 0.0 { 0.0 } else { speed };
        let sum = (out(u_after[i]) + out(-u[i])) + (out(v_below[i]) + out(-v[i]));
        fastest = fastest.max(sum.to_bits() as i32);
    }
    fastest
}

/// Suspended pigment of a row and its neighbours before the sub-step.
#[derive(Clone, Copy, Debug)]
pub struct SuspendedRows<'a> {
    /// Above.
    pub above: &'a [f32],
    /// Here.
    pub here: &'a [f32],
    /// Below.
    pub below: &'a [f32],
}

/// Moves suspended pigment of one row with the water for one sub-step.
///
/// # Source
/// Curtis et al. 1997, §4.4, `MovePigment`, gathered by face.
///
/// # Shapes and units
/// Field rows; `suspended` receives the new amounts; `dt` in steps.
///
/// # Guarantees
/// What leaves a cell through a face enters the next, from the same rounded flux (`pigment_is_kept`); amounts stay ≥ 0
/// while `dt` times [`outflow_speeds`] is at most 1; dry cells are untouched.
///
/// # Deviations
/// D3, D4.
pub fn carry(suspended: &mut [f32], old: &SuspendedRows<'_>, flow: &FlowRows<'_>, dt: f32, run: Run) {
    if run.all_wet {
        carry_kernel::<true>(suspended, old, flow, dt, run);
    } else {
        carry_kernel::<false>(suspended, old, flow, dt, run);
    }
}

/// What a cell holds afterwards, by what is before, after, above and below it and the speeds of its faces there.
#[inline(always)]
fn carried(here: f32, [before, after, above, below]: [f32; 4], speeds: [f32; 4], dt: f32) -> f32 {
    // Through a face flows what the cell upstream of it holds.
    let flux = |speed: f32, before: f32, after: f32| (if speed > 0.0 { before } else { after }) * speed * dt;
    let [u, u_after, v, v_below] = speeds;
    let sideways = flux(u, before, here) - flux(u_after, here, after);
    let downward = flux(v, above, here) - flux(v_below, here, below);
    let moved = here + (sideways + downward);
    if moved > 0.0 { moved } else { 0.0 } // rounding may undercut 0 by one unit
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn carry_kernel<const ALL_WET: bool>(
    suspended: &mut [f32],
    old: &SuspendedRows<'_>,
    flow: &FlowRows<'_>,
    dt: f32,
    run: Run,
) {
    let (first, n) = (run.first, run.padded());
    let beyond = run.beyond(suspended);
    let g_new = &mut suspended[first..][..n];
    let (g_before, g) = (&old.here[first - 1..][..n], &old.here[first..][..n]);
    let g_after = &old.here[first + 1..][..n];
    let (above, below) = (&old.above[first..][..n], &old.below[first..][..n]);
    let (u, u_after) = (&flow.u[first..][..n], &flow.u[first + 1..][..n]);
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    let m = &flow.mask[first..][..n];
    for i in 0..n {
        let (here, around) = (g[i], [g_before[i], g_after[i], above[i], below[i]]);
        let moved = carried(here, around, [u[i], u_after[i], v[i], v_below[i]], dt);
        g_new[i] = if ALL_WET || m[i] != 0 { moved } else { here };
    }
    if ALL_WET {
        beyond.put_back(suspended);
    }
}

/// [`carry`] and then [`transfer`](crate::transfer_pigment::transfer): a call and a pass over the pigment less.
pub fn carry_and_transfer(
    suspended: &mut [f32],
    deposited: &mut [f32],
    paper: &PaperRows<'_>,
    old: &SuspendedRows<'_>,
    flow: &FlowRows<'_>,
    dt: f32,
    run: Run,
) {
    if run.all_wet {
        carry_and_transfer_kernel::<true>(suspended, deposited, paper, old, flow, dt, run);
    } else {
        carry_and_transfer_kernel::<false>(suspended, deposited, paper, old, flow, dt, run);
    }
}

/// The paper of one row.
#[derive(Clone, Copy, Debug)]
pub struct PaperRows<'a> {
    /// Its height.
    pub height: &'a [f32],
    /// How the pigment is exchanged.
    pub exchange: Exchange,
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn carry_and_transfer_kernel<const ALL_WET: bool>(
    suspended: &mut [f32],
    deposited: &mut [f32],
    paper: &PaperRows<'_>,
    old: &SuspendedRows<'_>,
    flow: &FlowRows<'_>,
    dt: f32,
    run: Run,
) {
    let (first, n) = (run.first, run.padded());
    let (g_beyond, d_beyond) = (run.beyond(suspended), run.beyond(deposited));
    let (g_new, d) = (&mut suspended[first..][..n], &mut deposited[first..][..n]);
    let h = &paper.height[first..][..n];
    let (g_before, g) = (&old.here[first - 1..][..n], &old.here[first..][..n]);
    let g_after = &old.here[first + 1..][..n];
    let (above, below) = (&old.above[first..][..n], &old.below[first..][..n]);
    let (u, u_after) = (&flow.u[first..][..n], &flow.u[first + 1..][..n]);
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    let m = &flow.mask[first..][..n];
    for i in 0..n {
        let (here, around) = (g[i], [g_before[i], g_after[i], above[i], below[i]]);
        let moved = carried(here, around, [u[i], u_after[i], v[i], v_below[i]], dt);
        let [left, settled] = exchanged(moved, d[i], h[i], paper.exchange);
        d[i] = if ALL_WET || m[i] != 0 { settled } else { d[i] };
        g_new[i] = if ALL_WET || m[i] != 0 { left } else { here };
    }
    if ALL_WET {
        g_beyond.put_back(suspended);
        d_beyond.put_back(deposited);
    }
}
