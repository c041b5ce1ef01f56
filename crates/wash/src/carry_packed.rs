//! Transport of pigment in the living wash: van Leer's scheme, so that flow does not blur it; a packing limit, so that a
//! rim has a width; diffusion, and mixing by the flow itself, so that wetter paper makes softer edges.

use multiversion::multiversion;

use crate::region::Run;

/// How much a cell's neighbours may still bring into each cell of one row: 1 where it holds no pigment, 0 where it is full.
///
/// # Shapes and units
/// Field rows; `amounts` are those of all pigments, suspended and deposited; `limit` is the amount that fills a cell.
pub fn room(room: &mut [f32], amounts: &[&[f32]], limit: f32, run: Run) {
    let columns = run.first..run.end;
    let room = &mut room[columns.clone()];
    let of = |amount: usize| &amounts[amount][columns.clone()];
    let scale = 1.0 / limit;
    match amounts.len() {
        0 => room.fill(1.0),
        2 => room_kernel(room, [0, 1].map(of), scale),
        4 => room_kernel(room, [0, 1, 2, 3].map(of), scale),
        6 => room_kernel(room, [0, 1, 2, 3, 4, 5].map(of), scale),
        all => {
            sum(room, [0, 1, 2, 3, 4, 5].map(of));
            (6..all - 2).step_by(2).for_each(|next| add(room, [next, next + 1].map(of)));
            finish(room, [all - 2, all - 1].map(of), scale);
        }
    }
}

/// The room beside amounts of few pigments, in one loop: their rows come from far away, and the more of them are asked for at
/// once the less is waited for each.
#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn room_kernel<const N: usize>(room: &mut [f32], amounts: [&[f32]; N], scale: f32) {
    let n = room.len();
    let amounts = amounts.map(|amounts| &amounts[..n]);
    for i in 0..n {
        let mut others = 0.0;
        for amount in &amounts[..N - 2] {
            others += amount[i];
        }
        let last = amounts[N - 2][i] + amounts[N - 1][i];
        room[i] = left(if N > 2 { others + last } else { last }, scale);
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn sum(sums: &mut [f32], amounts: [&[f32]; 6]) {
    let n = sums.len();
    let [a, b, c, d, e, f] = amounts.map(|amounts| &amounts[..n]);
    for i in 0..n {
        sums[i] = ((((a[i] + b[i]) + c[i]) + d[i]) + e[i]) + f[i];
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add(sums: &mut [f32], amounts: [&[f32]; 2]) {
    let n = sums.len();
    let [a, b] = amounts.map(|amounts| &amounts[..n]);
    for i in 0..n {
        sums[i] = (sums[i] + a[i]) + b[i];
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn finish(room: &mut [f32], amounts: [&[f32]; 2], scale: f32) {
    let n = room.len();
    let [a, b] = amounts.map(|amounts| &amounts[..n]);
    for i in 0..n {
        room[i] = left(room[i] + (a[i] + b[i]), scale);
    }
}

/// What all pigment in a cell leaves of its room.
#[inline(always)]
fn left(all: f32, scale: f32) -> f32 {
    let full = all * scale;
    let full = full * full;
    let left = 1.0 - full * full;
    if left > 0.0 { left } else { 0.0 }
}

/// How far a sub-step carries and spreads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Length of the sub-step, steps.
    pub dt: f32,
    /// Diffusion in a sub-step, cells².
    pub diffusion: f32,
    /// Cells over which flow mixes what it carries, in its own direction.
    pub dispersion: f32,
}

/// What decides on how much goes through faces of one kind, but the pigment itself; all rows begin at the first face.
#[derive(Clone, Copy, Debug)]
pub struct FaceRows<'a> {
    /// Room in the cells before and after.
    pub room: [&'a [f32]; 2],
    /// Velocity through the face.
    pub speed: &'a [f32],
    /// Mobility of the face, 0 beside dry cells; `None` if it is 1 everywhere.
    pub mobility: Option<&'a [f32]>,
}

/// What faces of one kind and row do to any pigment, to be found once for all of them.
#[derive(Clone, Copy, Debug)]
pub struct FluxRows<'a> {
    /// How far water goes through the face in a sub-step, as far as there is room where it goes.
    pub way: &'a [f32],
    /// How far from the middle of its cell what goes through lies on average.
    pub lever: &'a [f32],
    /// How much is exchanged.
    pub mixing: &'a [f32],
}

/// Finds [`FluxRows`] of as many faces as there is place for: way, lever and mixing.
///
/// # Guarantees
/// Way and mixing are 0 where the mobility is.
pub fn prepare(found: [&mut [f32]; 3], faces: &FaceRows<'_>, spread: Spread) {
    match faces.mobility {
        Some(mobility) => prepare_kernel::<false>(found, faces, mobility, spread),
        None => prepare_kernel::<true>(found, faces, faces.speed, spread),
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn prepare_kernel<const FREE: bool>(
    found: [&mut [f32]; 3],
    faces: &FaceRows<'_>,
    mobility: &[f32],
    spread: Spread,
) {
    let Spread { dt, diffusion, dispersion } = spread;
    let [way, lever, mixing] = found;
    let n = way.len();
    let (lever, mixing) = (&mut lever[..n], &mut mixing[..n]);
    let [room_before, room_after] = faces.room.map(|room| &room[..n]);
    let (speed, mobility) = (&faces.speed[..n], &mobility[..n]);
    for i in 0..n {
        let (before, after) = (room_before[i], room_after[i]);
        let far = if FREE || mobility[i] > 0.0 { speed[i] * dt } else { 0.0 };
        way[i] = far * if far > 0.0 { after } else { before };
        lever[i] = 0.5 * (1.0 - far.abs());
        mixing[i] = if FREE { diffusion } else { diffusion * mobility[i] } + dispersion * far.abs();
    }
}

/// Slopes within cells of one row, which lie between others along the axis.
///
/// # Source
/// van Leer 1974, second order with his limiter: the harmonic mean of the differences on both sides.
pub fn slopes(slopes: &mut [f32], cells: [&[f32]; 3]) {
    slopes_kernel(slopes, cells);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn slopes_kernel(slopes: &mut [f32], cells: [&[f32]; 3]) {
    let n = slopes.len();
    let [before, here, after] = cells.map(|cells| &cells[..n]);
    for i in 0..n {
        slopes[i] = slope(here[i] - before[i], after[i] - here[i]);
    }
}

/// Takes values and divides in any case, so that no branch keeps loops from being vectors.
#[inline(always)]
fn slope(rise: f32, next: f32) -> f32 {
    let product = rise * next;
    let mean = 2.0 * product / (rise + next);
    if product > 0.0 { mean } else { 0.0 }
}

/// What goes through a face: the slope within the upstream cell says what lies near the face.
#[inline(always)]
fn through([way, lever, mixing]: [f32; 3], [before, after]: [f32; 2], slopes: [f32; 2]) -> f32 {
    // One of the two is 0: a choice between what lies up- and downstream would cost more.
    let forward = if way > 0.0 { way } else { 0.0 };
    let backward = if way < 0.0 { way } else { 0.0 };
    let carried = forward * (before + lever * slopes[0]) + backward * (after - lever * slopes[1]);
    carried + mixing * (before - after)
}

/// Pigment through faces of one row in a sub-step, from the cells before and after them and the slopes there.
pub fn flux(flux: &mut [f32], rows: &FluxRows<'_>, cells: [&[f32]; 2], slopes: [&[f32]; 2]) {
    flux_kernel(flux, rows, cells, slopes);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn flux_kernel(flux: &mut [f32], rows: &FluxRows<'_>, cells: [&[f32]; 2], slopes: [&[f32]; 2]) {
    let n = flux.len();
    let (way, lever, mixing) = (&rows.way[..n], &rows.lever[..n], &rows.mixing[..n]);
    let [before, after] = cells.map(|cells| &cells[..n]);
    let [slope_before, slope_after] = slopes.map(|slopes| &slopes[..n]);
    for i in 0..n {
        let (cells, slopes) = ([before[i], after[i]], [slope_before[i], slope_after[i]]);
        flux[i] = through([way[i], lever[i], mixing[i]], cells, slopes);
    }
}

/// As [`flux`], by the plain upstream scheme, which blurs what it carries: for pigment that flow mixes at least as much, and
/// that is mixed by itself afterwards ([`Mixing`](crate::mix_pigment::Mixing)).
pub fn flux_upstream(flux: &mut [f32], way: &[f32], cells: [&[f32]; 2]) {
    flux_upstream_kernel(flux, way, cells);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn flux_upstream_kernel(flux: &mut [f32], way: &[f32], cells: [&[f32]; 2]) {
    let n = flux.len();
    let (way, [before, after]) = (&way[..n], cells.map(|cells| &cells[..n]));
    for i in 0..n {
        flux[i] = way[i] * if way[i] > 0.0 { before[i] } else { after[i] };
    }
}

/// Sets the flux through faces without mobility to 0.
pub fn clear_closed(flux: &mut [f32], mobility: &[f32]) {
    for (flux, &mobility) in flux.iter_mut().zip(mobility) {
        *flux = if mobility > 0.0 { *flux } else { 0.0 };
    }
}

/// Adds what flows through the four faces of each cell of one row, and finds what flows down.
///
/// All in one loop: what flows down is needed once more, for the row below, and so is the slope that decides on it.
///
/// # Shapes and units
/// Rows that begin at the run's first cell. `across`: flux through the faces between cells, one more than cells. `down`:
/// flux through the faces above the row, and then through those below it, which `faces` describes. `slopes`: within the
/// cells of the row down the sheet, and then within those of the row below. `below`: amounts in the next two rows.
///
/// # Guarantees
/// Amounts stay ≥ 0 while the sub-steps are as short as [`substep_speed`] asks for.
pub fn gather(
    suspended: &mut [f32],
    down: &mut [f32],
    slopes: &mut [f32],
    across: &[f32],
    faces: &FluxRows<'_>,
    below: [&[f32]; 2],
) {
    gather_kernel(suspended, down, slopes, across, faces, below);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_kernel(
    suspended: &mut [f32],
    down: &mut [f32],
    slopes: &mut [f32],
    across: &[f32],
    faces: &FluxRows<'_>,
    [below, far]: [&[f32]; 2],
) {
    let n = suspended.len();
    let (down, slopes) = (&mut down[..n], &mut slopes[..n]);
    let (before, after) = (&across[..n], &across[1..][..n]);
    let (way, lever, mixing) = (&faces.way[..n], &faces.lever[..n], &faces.mixing[..n]);
    let (below, far) = (&below[..n], &far[..n]);
    for i in 0..n {
        let cells = [suspended[i], below[i]];
        let slope_below = slope(cells[1] - cells[0], far[i] - cells[1]);
        let leaving = through([way[i], lever[i], mixing[i]], cells, [slopes[i], slope_below]);
        suspended[i] = gathered(cells[0], [before[i], after[i], down[i], leaving]);
        (down[i], slopes[i]) = (leaving, slope_below);
    }
}

/// As [`gather`], by the plain upstream scheme.
pub fn gather_upstream(suspended: &mut [f32], down: &mut [f32], across: &[f32], way: &[f32], below: &[f32]) {
    gather_upstream_kernel(suspended, down, across, way, below);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_upstream_kernel(
    suspended: &mut [f32],
    down: &mut [f32],
    across: &[f32],
    way: &[f32],
    below: &[f32],
) {
    let n = suspended.len();
    let (down, way, below) = (&mut down[..n], &way[..n], &below[..n]);
    let (before, after) = (&across[..n], &across[1..][..n]);
    for i in 0..n {
        let leaving = way[i] * if way[i] > 0.0 { suspended[i] } else { below[i] };
        suspended[i] = gathered(suspended[i], [before[i], after[i], down[i], leaving]);
        down[i] = leaving;
    }
}

/// An amount with what flows through the faces before and after, above and below.
#[inline(always)]
fn gathered(amount: f32, [before, after, above, below]: [f32; 4]) -> f32 {
    let moved = amount + ((before - after) + (above - below));
    if moved > 0.0 { moved } else { 0.0 } // rounding may undercut 0 by one unit
}

/// The speed that decides on sub-steps: van Leer's scheme needs half the upwind step, mixing and diffusion their own.
pub fn substep_speed(outflow: f32, dispersion: f32, diffusion: f32) -> f32 {
    (2.0 + 2.0 * dispersion) * outflow + 4.0 * diffusion
}
