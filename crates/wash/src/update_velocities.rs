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
    add_slope_alone(u, v, paper, scale, run);
    fastest_kernel(u, v, run)
}

/// [`add_slope`] for whoever does not ask for the speed.
pub fn add_slope_alone(u: &mut [f32], v: &mut [f32], paper: &SlopeRows<'_>, scale: f32, run: Run) {
    if run.all_wet {
        add_slope_kernel::<true, false>(u, v, paper, scale, [0.0; 2], run);
        u[run.first] = 0.0; // it touches a dry cell
    } else {
        add_slope_kernel::<false, false>(u, v, paper, scale, [0.0; 2], run);
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn fastest_kernel(u: &[f32], v: &[f32], run: Run) -> i32 {
    let (first, n) = (run.first, run.len());
    let (u, v) = (&u[first..][..n], &v[first..][..n]);
    let bits = |x: f32| x.abs().to_bits() as i32;
    let mut fastest = 0;
    for i in 0..n {
        fastest = fastest.max(bits(u[i]).max(bits(v[i])));
    }
    fastest
}

/// [`add_slope`] on a tilted board: `pull` is what a step adds to u and v.
pub fn add_slope_tilted(
    u: &mut [f32],
    v: &mut [f32],
    paper: &SlopeRows<'_>,
    scale: f32,
    pull: [f32; 2],
    run: Run,
) {
    if run.all_wet {
        add_slope_kernel::<true, true>(u, v, paper, scale, pull, run);
        u[run.first] = 0.0; // it touches a dry cell
    } else {
        add_slope_kernel::<false, true>(u, v, paper, scale, pull, run);
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

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_slope_kernel<const ALL_WET: bool, const TILTED: bool>(
    u: &mut [f32],
    v: &mut [f32],
    paper: &SlopeRows<'_>,
    scale: f32,
    pull: [f32; 2],
    run: Run,
) {
    // u, v, h, m as in §4.3; windows that reach one cell back start one column early.
    let (first, n) = (run.first, run.padded());
    let (u_beyond, v_beyond) = (run.beyond(u), run.beyond(v));
    let (u_row, v_row) = (u, v);
    let (u, v) = (&mut u_row[first..][..n], &mut v_row[first..][..n]);
    let (h_before, h) = (&paper.height[first - 1..][..n], &paper.height[first..][..n]);
    let h_above = &paper.height_above[first..][..n];
    let (m_before, m) = (&paper.mask[first - 1..][..n], &paper.mask[first..][..n]);
    let m_above = &paper.mask_above[first..][..n];
    for i in 0..n {
        let sloped = u[i] - scale * (h[i] - h_before[i]); // D7
        let sloped = if TILTED { sloped + pull[0] } else { sloped };
        u[i] = if ALL_WET || m_before[i] & m[i] != 0 { sloped } else { 0.0 }; // D5
        let sloped = v[i] - scale * (h[i] - h_above[i]);
        let sloped = if TILTED { sloped + pull[1] } else { sloped };
        v[i] = if ALL_WET || m_above[i] & m[i] != 0 { sloped } else { 0.0 };
    }
    if ALL_WET {
        u_beyond.put_back(u_row);
        v_beyond.put_back(v_row);
    }
}

/// Bits of the largest speed of the faces of one row, and of the largest that they may have after a step: what they have, and
/// what the film's own gradient gives them in it.
///
/// C97 counts sub-steps by the speed at the start of a step; a stroke's edge is a cliff of water at high resolution, and
/// is still when the step begins.
///
/// # Shapes and units
/// Field rows; `stiffness` is what a difference in film of 1 adds to a velocity in a step.
pub fn drive(u: &[f32], v: &[f32], film: &FilmRows<'_>, stiffness: f32, run: Run) -> [i32; 2] {
    drive_kernel(u, v, film, stiffness, run)
}

/// Film and wet mask of a row and of the one above.
#[derive(Clone, Copy, Debug)]
pub struct FilmRows<'a> {
    /// Film above.
    pub film_above: &'a [f32],
    /// Film here.
    pub film: &'a [f32],
    /// Wet mask above.
    pub mask_above: &'a [u8],
    /// Wet mask here.
    pub mask: &'a [u8],
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn drive_kernel(u: &[f32], v: &[f32], film: &FilmRows<'_>, stiffness: f32, run: Run) -> [i32; 2] {
    let (first, n) = (run.first, run.len());
    let (u, v) = (&u[first..][..n], &v[first..][..n]);
    let (p, p_above) = (&film.film[first - 1..][..n + 1], &film.film_above[first..][..n]);
    let (m, m_above) = (&film.mask[first - 1..][..n + 1], &film.mask_above[first..][..n]);
    let (mut fastest, mut driven) = (0, 0);
    for i in 0..n {
        // Faces beside dry cells are still.
        let (along, upright) = (u[i].abs(), v[i].abs());
        let across = along + stiffness * (p[i + 1] - p[i]).abs();
        let down = upright + stiffness * (p[i + 1] - p_above[i]).abs();
        let across = if m[i] & m[i + 1] != 0 { across } else { 0.0 };
        let down = if m_above[i] & m[i + 1] != 0 { down } else { 0.0 };
        fastest = fastest.max(along.to_bits() as i32).max(upright.to_bits() as i32);
        driven = driven.max(across.to_bits() as i32).max(down.to_bits() as i32);
    }
    [fastest, driven]
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

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn corner_products_kernel(corner: &mut [f32], u_above: &[f32], u: &[f32], v: &[f32], run: Run) {
    // The last corner lies behind the run.
    let (first, n) = (run.first, Run { end: run.end + 1, ..run }.padded());
    let corner = &mut corner[first..][..n];
    let (u_above, u) = (&u_above[first..][..n], &u[first..][..n]);
    let (v_before, v) = (&v[first - 1..][..n], &v[first..][..n]);
    for i in 0..n {
        corner[i] = 0.25 * (u_above[i] + u[i]) * (v_before[i] + v[i]);
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
    /// Viscosity μ, cells² per step.
    pub viscosity: f32,
    /// Viscous drag κ.
    pub viscous_drag: f32,
}

/// How the living wash holds the water besides.
#[derive(Clone, Copy, Debug)]
pub struct Hold<'a> {
    /// What the faces before each cell keep of their speed in a sub-step.
    pub keep_u: &'a [f32],
    /// The same of the faces above.
    pub keep_v: &'a [f32],
    /// What a difference in film of 1 adds to a velocity in a step.
    pub stiffness: f32,
    /// No face is faster, cells per step.
    pub speed_limit: f32,
    /// The faces keep all of their speed, but for the run's first, which keeps nothing.
    pub is_free: bool,
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
        advance_u_kernel::<true>(u, old, momentum, run);
        advance_v_kernel::<true>(v, old, momentum, run);
        u[run.first] = 0.0; // it touches a dry cell
    } else {
        advance_u_kernel::<false>(u, old, momentum, run);
        advance_v_kernel::<false>(v, old, momentum, run);
    }
}

/// [`advance`] of the living wash: film drives the water, thin film holds it back, and its speed has a limit.
///
/// # Guarantees
/// Faces of which nothing is kept become 0; no face is faster than the limit.
pub fn advance_held(
    u: &mut [f32],
    v: &mut [f32],
    old: &VelocityRows<'_>,
    momentum: Momentum,
    hold: &Hold<'_>,
    run: Run,
) {
    if hold.is_free {
        advance_held_kernel::<true>(u, v, old, momentum, hold, run);
        u[run.first] = 0.0;
    } else {
        advance_held_kernel::<false>(u, v, old, momentum, hold, run);
    }
}

/// Bits of the largest speed in one row.
pub fn fastest(u: &[f32], v: &[f32], run: Run) -> i32 {
    fastest_kernel(u, v, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn advance_held_kernel<const FREE: bool>(
    u_new: &mut [f32],
    v_new: &mut [f32],
    old: &VelocityRows<'_>,
    momentum: Momentum,
    hold: &Hold<'_>,
    run: Run,
) {
    let Momentum { dt, viscosity, viscous_drag } = momentum;
    let (stiffness, limit) = (hold.stiffness, hold.speed_limit);
    let (first, n) = (run.first, run.len());
    let (u_new, v_new) = (&mut u_new[first..][..n], &mut v_new[first..][..n]);
    let corner = &old.corner[first..][..n + 1];
    let corner_below = &old.corner_below[first..][..n + 1];
    let p = &old.pressure[first - 1..][..n + 1];
    let p_above = &old.pressure_above[first..][..n];
    let (keep_u, keep_v) = (&hold.keep_u[first..][..n], &hold.keep_v[first..][..n]);

    // u, v, p as in §4.3.1, grouped as in `advance_kernel`.
    let u = &old.u[first - 1..][..n + 2];
    let (above, below) = (&old.u_above[first..][..n], &old.u_below[first..][..n]);
    for i in 0..n {
        let here = u[i + 1];
        let (before, after) = (u[i] + here, here + u[i + 2]);
        let advection = 0.25 * (before * before - after * after) + (corner[i] - corner_below[i]);
        let laplacian = (u[i] + u[i + 2]) + (above[i] + below[i]) - 4.0 * here;
        let push = advection + viscosity * laplacian + stiffness * (p[i] - p[i + 1]) - viscous_drag * here; // D1
        u_new[i] = held::<FREE>(here + dt * push, keep_u[i], limit);
    }
    let v = &old.v[first - 1..][..n + 2];
    let (above, below) = (&old.v_above[first..][..n], &old.v_below[first..][..n]);
    for i in 0..n {
        let here = v[i + 1];
        let (before, after) = (above[i] + here, here + below[i]);
        let advection = 0.25 * (before * before - after * after) + (corner[i] - corner[i + 1]);
        let laplacian = (v[i] + v[i + 2]) + (above[i] + below[i]) - 4.0 * here;
        let push =
            advection + viscosity * laplacian + stiffness * (p_above[i] - p[i + 1]) - viscous_drag * here;
        v_new[i] = held::<FREE>(here + dt * push, keep_v[i], limit);
    }
}

/// What is kept of a velocity, within the limit.
#[inline(always)]
fn held<const FREE: bool>(velocity: f32, keep: f32, limit: f32) -> f32 {
    let kept = if FREE { velocity } else { velocity * keep };
    let kept = if kept > limit { limit } else { kept };
    let kept = if kept < -limit { -limit } else { kept };
    if FREE || keep > 0.0 { kept } else { 0.0 }
}

// u, v, p as in §4.3.1. Sums are grouped so that mirroring or transposing a wash changes no bit. One kernel with both loops
// has too many slices for the compiler to tell them apart, and is not vectorized.
#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn advance_u_kernel<const ALL_WET: bool>(
    u_row: &mut [f32],
    old: &VelocityRows<'_>,
    momentum: Momentum,
    run: Run,
) {
    let Momentum { dt, viscosity, viscous_drag } = momentum;
    let (first, n) = (run.first, run.padded());
    let beyond = run.beyond(u_row);
    let u_new = &mut u_row[first..][..n];
    let (corner, corner_below) = (&old.corner[first..][..n], &old.corner_below[first..][..n]);
    let (p_before, p) = (&old.pressure[first - 1..][..n], &old.pressure[first..][..n]);
    let (m_before, m) = (&old.mask[first - 1..][..n], &old.mask[first..][..n]);
    let (u_before, u, u_after) = (&old.u[first - 1..][..n], &old.u[first..][..n], &old.u[first + 1..][..n]);
    let (above, below) = (&old.u_above[first..][..n], &old.u_below[first..][..n]);
    for i in 0..n {
        let here = u[i];
        let (before, after) = (u_before[i] + here, here + u_after[i]);
        let advection = 0.25 * (before * before - after * after) + (corner[i] - corner_below[i]);
        let laplacian = (u_before[i] + u_after[i]) + (above[i] + below[i]) - 4.0 * here;
        let push = advection + viscosity * laplacian + (p_before[i] - p[i]) - viscous_drag * here; // D1
        let moved = here + dt * push;
        u_new[i] = if ALL_WET || m_before[i] & m[i] != 0 { moved } else { 0.0 }; // D5
    }
    if ALL_WET {
        beyond.put_back(u_row);
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn advance_v_kernel<const ALL_WET: bool>(
    v_row: &mut [f32],
    old: &VelocityRows<'_>,
    momentum: Momentum,
    run: Run,
) {
    let Momentum { dt, viscosity, viscous_drag } = momentum;
    let (first, n) = (run.first, run.padded());
    let beyond = run.beyond(v_row);
    let v_new = &mut v_row[first..][..n];
    let (corner, corner_after) = (&old.corner[first..][..n], &old.corner[first + 1..][..n]);
    let (p, p_above) = (&old.pressure[first..][..n], &old.pressure_above[first..][..n]);
    let (m, m_above) = (&old.mask[first..][..n], &old.mask_above[first..][..n]);
    let (v_before, v, v_after) = (&old.v[first - 1..][..n], &old.v[first..][..n], &old.v[first + 1..][..n]);
    let (above, below) = (&old.v_above[first..][..n], &old.v_below[first..][..n]);
    for i in 0..n {
        let here = v[i];
        let (before, after) = (above[i] + here, here + below[i]);
        let advection = 0.25 * (before * before - after * after) + (corner[i] - corner_after[i]);
        let laplacian = (v_before[i] + v_after[i]) + (above[i] + below[i]) - 4.0 * here;
        let push = advection + viscosity * laplacian + (p_above[i] - p[i]) - viscous_drag * here;
        let moved = here + dt * push;
        v_new[i] = if ALL_WET || m_above[i] & m[i] != 0 { moved } else { 0.0 };
    }
    if ALL_WET {
        beyond.put_back(v_row);
    }
}
