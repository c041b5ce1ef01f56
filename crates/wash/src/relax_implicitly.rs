//! Relaxation of the living wash: one implicit solve in place of C97's sweeps, so that its cost and its effect are known
//! at any resolution.
//!
//! C97 lets pressure spread for as many sweeps as it takes; n sweeps at rate ξ are a step of compressibility B = nξ. Here
//! B is given: (1 − B r² ∇·m∇) q = ∇·u, then u += B r² m∇q, with m the mobility of faces. It is solved by Chebyshev's
//! iteration on the known spectrum [1, 1 + 8 B r²], which needs no reductions, so any number of threads gives the same
//! bits.

use multiversion::multiversion;

use crate::region::Run;
use crate::relax_divergence::FlowRows;

/// Error of the solution that is allowed, relative. A tenth of this moves pigment by less than 3 ‰ and takes half as many
/// iterations more; water is kept in any case, for it follows the flow that comes out.
const TOLERANCE: f64 = 1e-2;
/// More iterations are never made.
const MOST_ITERATIONS: u32 = 400;
/// The flow stays below 1/√this of the speed of waves √B.
const MACH: f64 = 2.0;

/// One iteration: q₊ = q + carry (q − q₋) + gain (∇·u − A q).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// How much of the last change is carried on.
    pub carry: f32,
    /// How much of the residual is added.
    pub gain: f32,
}

/// How a relaxation is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxation {
    /// B, raised where the flow would outrun the waves.
    pub compressibility: f32,
    /// B r².
    pub stiffness: f32,
    /// q begins as the divergence times this.
    pub start: f32,
    /// All iterations.
    pub iterations: Vec<Iteration>,
}

impl Relaxation {
    /// The relaxation of flow whose fastest face moves `fastest` cells a step, `scale` cells to a reference cell.
    pub fn new(compressibility: f64, fastest: f32, scale: f64) -> Self {
        let speed = f64::from(fastest) / scale;
        let compressibility = compressibility.max(MACH * speed * speed);
        let b = compressibility * scale * scale;
        // The spectrum's middle and half width.
        let (middle, half) = (1.0 + 4.0 * b, 4.0 * b);
        let sigma = middle / half;
        let root = libm::sqrt(1.0 + 8.0 * b);
        let rate = (root - 1.0) / (root + 1.0);
        // The error is at most 2 rateⁿ.
        let count = libm::ceil(libm::log(TOLERANCE / 2.0) / libm::log(rate)).max(0.0);
        let count = if count < f64::from(MOST_ITERATIONS) { count as u32 } else { MOST_ITERATIONS };
        let mut rho = 1.0 / sigma;
        let mut iterations = vec![Iteration { carry: 0.0, gain: (1.0 / middle) as f32 }];
        for _ in 0..count {
            let next = 1.0 / (2.0 * sigma - rho);
            iterations.push(Iteration { carry: (next * rho) as f32, gain: (2.0 * next / half) as f32 });
            rho = next;
        }
        Self {
            compressibility: compressibility as f32,
            stiffness: b as f32,
            start: (1.0 / middle) as f32,
            iterations,
        }
    }
}

/// The divergence of the flow in one row, and the first guess at q.
pub fn begin(divergence: &mut [f32], q: &mut [f32], flow: &FlowRows<'_>, start: f32, run: Run) {
    begin_kernel(divergence, q, flow, start, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn begin_kernel(divergence: &mut [f32], q: &mut [f32], flow: &FlowRows<'_>, start: f32, run: Run) {
    let (first, n) = (run.first, run.len());
    let (divergence, q) = (&mut divergence[first..][..n], &mut q[first..][..n]);
    let u = &flow.u[first..][..n + 1];
    let (v, v_below) = (&flow.v[first..][..n], &flow.v_below[first..][..n]);
    for i in 0..n {
        divergence[i] = (u[i + 1] - u[i]) + (v_below[i] - v[i]);
        q[i] = start * divergence[i];
    }
}

/// What an iteration reads: q of a row and its neighbours, q one iteration before, and the mobility of all faces.
#[derive(Clone, Copy, Debug)]
pub struct SolveRows<'a> {
    /// q above.
    pub above: &'a [f32],
    /// q here.
    pub here: &'a [f32],
    /// q below.
    pub below: &'a [f32],
    /// q here one iteration before.
    pub before: &'a [f32],
    /// Divergence of the flow.
    pub divergence: &'a [f32],
    /// Mobility of the faces before each cell.
    pub mobility_u: &'a [f32],
    /// Mobility of the faces above.
    pub mobility_v: &'a [f32],
    /// Mobility of the faces below.
    pub mobility_v_below: &'a [f32],
}

/// One iteration for the cells of one row.
///
/// # Shapes and units
/// Field rows; `next` must not be `before`. `stiffness` is B r². `is_free` says that the mobility of all faces around the
/// run's cells is 1, but for those at its ends.
pub fn iterate(
    next: &mut [f32],
    rows: &SolveRows<'_>,
    iteration: Iteration,
    stiffness: f32,
    run: Run,
    is_free: bool,
) {
    if is_free {
        iterate_kernel::<true>(next, rows, iteration, stiffness, run);
        // Nothing flows through the faces at its ends. Their mobility is not read: it would have to come from far away.
        let terms = Terms::new(iteration, stiffness);
        let open = |is_open: bool| f32::from(u8::from(is_open));
        for x in [run.first, run.end - 1] {
            let mobility = [open(x > run.first), open(x + 1 < run.end), 1.0, 1.0];
            next[x] = terms.next::<false>(&rows.around(x, mobility));
        }
    } else {
        iterate_kernel::<false>(next, rows, iteration, stiffness, run);
    }
}

/// What an iteration multiplies with what: q₊ = own q + around (m q of the four neighbours) + gain ∇·u − carry q₋.
///
/// Where all mobilities are 1 nothing is multiplied with them, and their sum is 4: the same bits.
#[derive(Clone, Copy)]
struct Terms {
    own: f32,
    own_if_free: f32,
    around: f32,
    gain: f32,
    carry: f32,
}

/// What an iteration reads for a cell: q here, before and after, above and below; mobility of the faces between; the
/// divergence and q one iteration before.
#[derive(Clone, Copy)]
struct Around {
    q: [f32; 5],
    mobility: [f32; 4],
    divergence: f32,
    before: f32,
}

impl Terms {
    #[inline(always)]
    fn new(Iteration { carry, gain }: Iteration, stiffness: f32) -> Self {
        let (own, around) = (1.0 + carry - gain, gain * stiffness);
        Self { own, own_if_free: own - around * 4.0, around, gain, carry }
    }

    #[inline(always)]
    fn next<const FREE: bool>(self, cell: &Around) -> f32 {
        let [here, left, right, above, below] = cell.q;
        let [m_left, m_right, m_above, m_below] = cell.mobility;
        let (own, sideways, upright) = if FREE {
            (self.own_if_free, left + right, above + below)
        } else {
            let all = (m_left + m_right) + (m_above + m_below);
            let sideways = m_left * left + m_right * right;
            (self.own - self.around * all, sideways, m_above * above + m_below * below)
        };
        let moved = own * here + self.around * (sideways + upright);
        moved + (self.gain * cell.divergence - self.carry * cell.before)
    }
}

impl SolveRows<'_> {
    fn around(&self, x: usize, mobility: [f32; 4]) -> Around {
        Around {
            q: [self.here[x], self.here[x - 1], self.here[x + 1], self.above[x], self.below[x]],
            mobility,
            divergence: self.divergence[x],
            before: self.before[x],
        }
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn iterate_kernel<const FREE: bool>(
    next: &mut [f32],
    rows: &SolveRows<'_>,
    iteration: Iteration,
    stiffness: f32,
    run: Run,
) {
    let terms = Terms::new(iteration, stiffness);
    let (first, n) = (run.first, run.len());
    let next = &mut next[first..][..n];
    let q = &rows.here[first - 1..][..n + 2];
    let (above, below) = (&rows.above[first..][..n], &rows.below[first..][..n]);
    let (before, divergence) = (&rows.before[first..][..n], &rows.divergence[first..][..n]);
    let m_u = &rows.mobility_u[first..][..n + 1];
    let (m_v, m_v_below) = (&rows.mobility_v[first..][..n], &rows.mobility_v_below[first..][..n]);
    for i in 0..n {
        let mobility = if FREE { [1.0; 4] } else { [m_u[i], m_u[i + 1], m_v[i], m_v_below[i]] };
        next[i] = terms.next::<FREE>(&Around {
            q: [q[i + 1], q[i], q[i + 2], above[i], below[i]],
            mobility,
            divergence: divergence[i],
            before: before[i],
        });
    }
}

/// Gives the faces before and above the cells of one row the flow that the solution asks for.
///
/// # Shapes and units
/// Field rows; `q_above` is that of the row above. `stiffness` is B r². `is_free` says that the mobility of all these faces
/// is 1, but for the first.
pub fn project(
    u: &mut [f32],
    v: &mut [f32],
    q: [&[f32]; 2],
    mobility: [&[f32]; 2],
    stiffness: f32,
    run: Run,
    is_free: bool,
) {
    if is_free {
        project_kernel::<true>(u, v, q, mobility, stiffness, run);
        u[run.first] = 0.0; // D5
    } else {
        project_kernel::<false>(u, v, q, mobility, stiffness, run);
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn project_kernel<const FREE: bool>(
    u: &mut [f32],
    v: &mut [f32],
    [q_above, q]: [&[f32]; 2],
    [mobility_u, mobility_v]: [&[f32]; 2],
    stiffness: f32,
    run: Run,
) {
    let (first, n) = (run.first, run.len());
    let (u, v) = (&mut u[first..][..n], &mut v[first..][..n]);
    let (q, q_above) = (&q[first - 1..][..n + 1], &q_above[first..][..n]);
    let (m_u, m_v) = (&mobility_u[first..][..n], &mobility_v[first..][..n]);
    // Times 1 is left out: the same bits.
    let through = |mobility: f32, difference: f32| if FREE { difference } else { mobility * difference };
    for i in 0..n {
        u[i] += stiffness * through(m_u[i], q[i + 1] - q[i]);
        v[i] += stiffness * through(m_v[i], q[i + 1] - q_above[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_grids_need_more_iterations_in_proportion() {
        let count = |scale| Relaxation::new(0.4, 0.0, scale).iterations.len();
        assert_eq!([count(1.0), count(2.0), count(4.0)], [6, 11, 21]);
    }

    #[test]
    fn fast_flow_raises_the_compressibility() {
        assert_eq!(Relaxation::new(0.4, 0.4, 1.0).compressibility, 0.4);
        assert!((Relaxation::new(0.4, 1.0, 1.0).compressibility - 2.0).abs() < 1e-6);
        assert!((Relaxation::new(0.4, 2.0, 2.0).compressibility - 2.0).abs() < 1e-6);
    }
}
