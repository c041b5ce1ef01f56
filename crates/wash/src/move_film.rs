//! The film follows the relaxed flow: p −= B ∇·u, and no cell gives more than it has.
//!
//! B u is the water through a face. Unlimited, a thin film would go below 0; cut off at what each cell holds, it could not
//! be flowed *through* at high resolution, where more passes a cell in a step than it holds, and edges would fade. So
//! what flows in counts too, for as many cells as water may pass in a step.

use multiversion::multiversion;

use crate::region::Run;
use crate::relax_divergence::FlowRows;

/// The share of what the flow asks of each cell of one row that it can give, from what it holds.
///
/// Returns the bits of the largest sum of outflow speeds, and whether any cell is asked for more than it has.
///
/// # Shapes and units
/// Field rows; `share` 0 to 1.
pub fn share(
    share: &mut [f32],
    film: &[f32],
    flow: &FlowRows<'_>,
    compressibility: f32,
    run: Run,
) -> (i32, bool) {
    share_kernel(share, film, flow, compressibility, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn share_kernel(
    share: &mut [f32],
    film: &[f32],
    flow: &FlowRows<'_>,
    compressibility: f32,
    run: Run,
) -> (i32, bool) {
    let (first, n) = (run.first, run.len());
    let (share, p) = (&mut share[first..][..n], &film[first..][..n]);
    let u = &flow.u[first..][..n + 1];
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    let (mut fastest, mut short) = (0, 0u32);
    for i in 0..n {
        let speeds = outflow_speeds([u[i], u[i + 1], v[i], v_below[i]]);
        fastest = fastest.max(speeds.to_bits() as i32);
        let asked = compressibility * speeds;
        let held = if p[i] > 0.0 { p[i] } else { 0.0 };
        let given = held / asked;
        share[i] = if asked > held { given } else { 1.0 };
        short |= u32::from(asked > held);
    }
    (fastest, short != 0)
}

/// Sum of the speeds at which water leaves a cell through its faces: before, after, above, below.
#[inline(always)]
fn outflow_speeds([before, after, above, below]: [f32; 4]) -> f32 {
    // Not f32::max: it would drop a NaN, which must be seen.
    let out = |speed: f32| if speed < 0.0 { 0.0 } else { speed };
    (out(after) + out(-before)) + (out(below) + out(-above))
}

/// Shares of a row and its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct ShareRows<'a> {
    /// Above.
    pub above: &'a [f32],
    /// Here.
    pub here: &'a [f32],
    /// Below.
    pub below: &'a [f32],
}

/// The share of each cell of one row anew, counting what its neighbours let flow in.
///
/// # Guarantees
/// Shares only rise, and never so far that a film would go below 0, however often this is done.
pub fn widen_share(
    wider: &mut [f32],
    shares: &ShareRows<'_>,
    film: &[f32],
    flow: &FlowRows<'_>,
    compressibility: f32,
    run: Run,
) {
    widen_share_kernel(wider, shares, film, flow, compressibility, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn widen_share_kernel(
    wider: &mut [f32],
    shares: &ShareRows<'_>,
    film: &[f32],
    flow: &FlowRows<'_>,
    compressibility: f32,
    run: Run,
) {
    let (first, n) = (run.first, run.len());
    let (wider, p) = (&mut wider[first..][..n], &film[first..][..n]);
    let here = &shares.here[first - 1..][..n + 2];
    let (above, below) = (&shares.above[first..][..n], &shares.below[first..][..n]);
    let u = &flow.u[first..][..n + 1];
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    let into = |speed: f32| if speed > 0.0 { speed } else { 0.0 };
    for i in 0..n {
        let asked = compressibility * outflow_speeds([u[i], u[i + 1], v[i], v_below[i]]);
        let sideways = into(u[i]) * here[i] + into(-u[i + 1]) * here[i + 2];
        let upright = into(v[i]) * above[i] + into(-v_below[i]) * below[i];
        let held = if p[i] > 0.0 { p[i] } else { 0.0 };
        let held = held + compressibility * (sideways + upright);
        let given = held / asked;
        wider[i] = if asked > held { given } else { 1.0 };
    }
}

/// Moves the film of one row: each face carries what the cell upstream can give.
///
/// Without shares every cell gives all it is asked for.
///
/// # Guarantees
/// What leaves a cell enters the next, to rounding; a film that was not below 0 stays so.
pub fn move_film(
    film: &mut [f32],
    shares: Option<&ShareRows<'_>>,
    flow: &FlowRows<'_>,
    compressibility: f32,
    run: Run,
) {
    match shares {
        Some(shares) => move_film_kernel::<true>(film, shares, flow, compressibility, run),
        None => {
            let none = ShareRows { above: flow.v, here: flow.v, below: flow.v };
            move_film_kernel::<false>(film, &none, flow, compressibility, run);
        }
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn move_film_kernel<const LIMITED: bool>(
    film: &mut [f32],
    shares: &ShareRows<'_>,
    flow: &FlowRows<'_>,
    compressibility: f32,
    run: Run,
) {
    let (first, n) = (run.first, run.len());
    let p = &mut film[first..][..n];
    let here = &shares.here[first - 1..][..n + 2];
    let (above, below) = (&shares.above[first..][..n], &shares.below[first..][..n]);
    let u = &flow.u[first..][..n + 1];
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    // Through a face flows what the cell upstream of it gives.
    let through = |speed: f32, before: f32, after: f32| {
        if LIMITED { speed * (if speed > 0.0 { before } else { after }) } else { speed }
    };
    for i in 0..n {
        let k = here[i + 1];
        let sideways = through(u[i], here[i], k) - through(u[i + 1], k, here[i + 2]);
        let upright = through(v[i], above[i], k) - through(v_below[i], k, below[i]);
        let moved = p[i] + compressibility * (sideways + upright);
        // Rounding may undercut 0 by a unit; a film that was below 0 is left to rise.
        let floor = if p[i] < 0.0 { p[i] } else { 0.0 };
        p[i] = if moved < floor { floor } else { moved };
    }
}
