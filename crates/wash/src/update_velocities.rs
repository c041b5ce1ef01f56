//! `UpdateVelocities`: water moves by its own momentum, viscosity, pressure, drag and the slope of the paper.

use multiversion::multiversion;

use crate::region::Run;

/// Runs the paper's slope into one row of velocities and returns the bits of the largest speed there.
///
/// # Source
/// Curtis et al. 1997, §4.3.1, `UpdateVelocities`, first line: (u, v) ← (u, v) − ∇h.
///
/// # Shapes and units
/// Field rows. `u`: faces before each cell; `v`: faces above each cell; `height`: cells, 0 < h < 1.
///
/// # Guarantees
/// Faces that touch a dry cell become 0 (`dry_faces_stay_still`).
///
/// # Deviations
/// D5, D7.
pub fn add_slope(u: &mut [f32], v: &mut [f32], paper: &SlopeRows<'_>, scale: f32, run: Run) -> i32 {
    if run.all_wet {
        add_slope_kernel::<true>(u, v, paper, scale, run)
    } else {
        add_slope_kernel::<false>(u, v, paper, scale, run)
    }
}

/// What [`add_slope`] reads: this row and the one above.
#[derive(Clone, Copy, Debug)]
pub struct SlopeRows<'a> {
    /// Paper height above.
    pub height_above: &'a [f32],
    /// Paper height here.
    pub height: &'a [f32],
    /// Wet mask above.
    pub mask_above: &'a [u8],
    /// Wet mask here.
    pub mask: &'a [u8],
}

#[multiversion(targets("x86_64+avx2"))]
fn add_slope_kernel<const ALL_WET: bool>(
    u: &mut [f32],
    v: &mut [f32],
    paper: &SlopeRows<'_>,
    scale: f32,
    run: Run,
) -> i32 {
    // u, v, h, m as in §4.3; windows that reach one cell back start one column early.
    let (first, n) = (run.first, run.len());
    let skip = usize::from(ALL_WET); // the first face of an all-wet run touches a dry cell
    let (u, v) = (&mut u[first..][..n], &mut v[first..][..n]);
    let (h, h_above) = (&paper.height[first - 1..][..n + 1], &paper.height_above[first..][..n]);
    let (m, m_above) = (&paper.mask[first - 1..][..n + 1], &paper.mask_above[first..][..n]);
    let mut fastest = 0;
    for i in skip..n {
        let sloped = u[i] - scale * (h[i + 1] - h[i]); // D7
        u[i] = if ALL_WET || m[i] & m[i + 1] != 0 { sloped } else { 0.0 }; // D5
        fastest = fastest.max(u[i].abs().to_bits() as i32);
    }
    for i in 0..n {
        let sloped = v[i] - scale * (h[i + 1] - h_above[i]);
        v[i] = if ALL_WET || m_above[i] & m[i + 1] != 0 { sloped } else { 0.0 };
        fastest = fastest.max(v[i].abs().to_bits() as i32);
    }
    fastest
}

/// Products of the two velocities at the corners above and before each cell of one row, the last corner included.
///
/// Both momentum equations need them: (uv) differs downward for u and sideways for v.
///
/// # Source
/// Curtis et al. 1997, §4.3.1: (uv) at i ± ½, j ± ½, each velocity the mean of its two faces at the corner.
///
/// # Shapes and units
/// Field rows; `corner[x]` lies above and before cell x.
pub fn corner_products(corner: &mut [f32], u_above: &[f32], u: &[f32], v: &[f32], run: Run) {
    corner_products_kernel(corner, u_above, u, v, run);
}

#[multiversion(targets("x86_64+avx2"))]
fn corner_products_kernel(corner: &mut [f32], u_above: &[f32], u: &[f32], v: &[f32], run: Run) {
    let (first, n) = (run.first, run.len() + 1);
    let corner = &mut corner[first..][..n];
    let (u_above, u) = (&u_above[first..][..n], &u[first..][..n]);
    let v = &v[first - 1..][..n + 1];
    for i in 0..n {
        corner[i] = 0.25 * (u_above[i] + u[i]) * (v[i] + v[i + 1]);
    }
}

/// What [`advance`] reads: velocities and corner products of a row and its neighbours before the step.
#[derive(Clone, Copy, Debug)]
pub struct VelocityRows<'a> {
    /// Horizontal velocity above.
    pub u_above: &'a [f32],
    /// Horizontal velocity here.
    pub u: &'a [f32],
    /// Horizontal velocity below.
    pub u_below: &'a [f32],
    /// Vertical velocity above.
    pub v_above: &'a [f32],
    /// Vertical velocity here.
    pub v: &'a [f32],
    /// Vertical velocity below.
    pub v_below: &'a [f32],
    /// Corner products above the row.
    pub corner: &'a [f32],
    /// Corner products below the row.
    pub corner_below: &'a [f32],
    /// Pressure above.
    pub pressure_above: &'a [f32],
    /// Pressure here.
    pub pressure: &'a [f32],
    /// Wet mask above.
    pub mask_above: &'a [u8],
    /// Wet mask here.
    pub mask: &'a [u8],
}

/// How far and how thickly [`advance`] moves the water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum {
    /// Length of the sub-step, steps.
    pub dt: f32,
    /// Viscosity μ.
    pub viscosity: f32,
    /// Viscous drag κ.
    pub viscous_drag: f32,
}

/// Advances the velocities of one row by one sub-step.
///
/// # Source
/// Curtis et al. 1997, §4.3.1, `UpdateVelocities`, equations (1) and (2).
///
/// # Shapes and units
/// Field rows; `u`, `v` receive the new velocities, cells per step.
///
/// # Guarantees
/// Faces that touch a dry cell become 0 (`dry_faces_stay_still`); a mirrored or transposed wash stays mirrored bit
/// for bit (`symmetry_is_kept`).
///
/// # Deviations
/// D1, D5.
pub fn advance(u: &mut [f32], v: &mut [f32], old: &VelocityRows<'_>, momentum: Momentum, run: Run) {
    if run.all_wet {
        advance_kernel::<true>(u, v, old, momentum, run);
    } else {
        advance_kernel::<false>(u, v, old, momentum, run);
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn advance_kernel<const ALL_WET: bool>(
    u_new: &mut [f32],
    v_new: &mut [f32],
    old: &VelocityRows<'_>,
    momentum: Momentum,
    run: Run,
) {
    let Momentum { dt, viscosity, viscous_drag } = momentum;
    let (first, n) = (run.first, run.len());
    let skip = usize::from(ALL_WET);
    let corner = &old.corner[first..][..n + 1];
    let corner_below = &old.corner_below[first..][..n + 1];
    let p = &old.pressure[first - 1..][..n + 1];
    let p_above = &old.pressure_above[first..][..n];
    let m = &old.mask[first - 1..][..n + 1];
    let m_above = &old.mask_above[first..][..n];

    // u, v, p as in §4.3.1. Sums are grouped so that mirroring or transposing a wash changes no bit.
    let u_new = &mut u_new[first..][..n];
    let u = &old.u[first - 1..][..n + 2];
    let (above, below) = (&old.u_above[first..][..n], &old.u_below[first..][..n]);
    for i in skip..n {
        let here = u[i + 1];
        let (before, after) = (u[i] + here, here + u[i + 2]);
        let advection = 0.25 * (before * before - after * after) + (corner[i] - corner_below[i]);
        let laplacian = (u[i] + u[i + 2]) + (above[i] + below[i]) - 4.0 * here;
        let push = advection + viscosity * laplacian + (p[i] - p[i + 1]) - viscous_drag * here; // D1
        let moved = here + dt * push;
        u_new[i] = if ALL_WET || m[i] & m[i + 1] != 0 { moved } else { 0.0 }; // D5
    }
    let v_new = &mut v_new[first..][..n];
    let v = &old.v[first - 1..][..n + 2];
    let (above, below) = (&old.v_above[first..][..n], &old.v_below[first..][..n]);
    for i in 0..n {
        let here = v[i + 1];
        let (before, after) = (above[i] + here, here + below[i]);
        let advection = 0.25 * (before * before - after * after) + (corner[i] - corner[i + 1]);
        let laplacian = (v[i] + v[i + 2]) + (above[i] + below[i]) - 4.0 * here;
        let push = advection + viscosity * laplacian + (p_above[i] - p[i + 1]) - viscous_drag * here;
        let moved = here + dt * push;
        v_new[i] = if ALL_WET || m_above[i] & m[i + 1] != 0 { moved } else { 0.0 };
    }
}
