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
    // Two fields at a time: the last two in one go with the rest of the arithmetic.
    let (sums, last) = amounts.split_at(amounts.len().saturating_sub(2));
    let mut sums = sums.iter();
    match (sums.next(), last) {
        (None, [g, d]) => finish_room::<false>(room, &g[columns.clone()], &d[columns], 1.0 / limit),
        (Some(first), [g, d]) => {
            room.copy_from_slice(&first[columns.clone()]);
            sums.for_each(|amount| add(room, &amount[columns.clone()]));
            finish_room::<true>(room, &g[columns.clone()], &d[columns], 1.0 / limit);
        }
        _ => room.fill(1.0),
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add(sum: &mut [f32], amount: &[f32]) {
    for (sum, amount) in sum.iter_mut().zip(amount) {
        *sum += amount;
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn finish_room<const MORE: bool>(room: &mut [f32], g: &[f32], d: &[f32], scale: f32) {
    let n = room.len();
    let (g, d) = (&g[..n], &d[..n]);
    for i in 0..n {
        let all = if MORE { room[i] + (g[i] + d[i]) } else { g[i] + d[i] };
        let full = all * scale;
        let full = full * full;
        let left = 1.0 - full * full;
        room[i] = if left > 0.0 { left } else { 0.0 };
    }
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

/// [`flux`] together with the slopes in the cells after the faces: `cells` are those before and after the faces and
/// one farther.
pub fn flux_and_slopes(
    flux: &mut [f32],
    slopes_after: &mut [f32],
    rows: &FluxRows<'_>,
    cells: [&[f32]; 3],
    slopes_before: &[f32],
) {
    flux_and_slopes_kernel(flux, slopes_after, rows, cells, slopes_before);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn flux_and_slopes_kernel(
    flux: &mut [f32],
    slopes_after: &mut [f32],
    rows: &FluxRows<'_>,
    cells: [&[f32]; 3],
    slopes_before: &[f32],
) {
    let n = flux.len();
    let (slopes_before, slopes_after) = (&slopes_before[..n], &mut slopes_after[..n]);
    let (way, lever, mixing) = (&rows.way[..n], &rows.lever[..n], &rows.mixing[..n]);
    let [before, after, far] = cells.map(|cells| &cells[..n]);
    for i in 0..n {
        let slope = slope(after[i] - before[i], far[i] - after[i]);
        let cells = [before[i], after[i]];
        flux[i] = through([way[i], lever[i], mixing[i]], cells, [slopes_before[i], slope]);
        slopes_after[i] = slope;
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

/// Adds what flows through the four faces of each cell of one row.
///
/// # Shapes and units
/// Rows that begin at the run's first cell; `across` has one face more.
///
/// # Guarantees
/// Amounts stay ≥ 0 while the sub-steps are as short as [`substep_speed`] asks for.
pub fn gather(suspended: &mut [f32], across: &[f32], above: &[f32], below: &[f32]) {
    gather_kernel(suspended, across, above, below);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_kernel(suspended: &mut [f32], across: &[f32], above: &[f32], below: &[f32]) {
    let n = suspended.len();
    let (across, above, below) = (&across[..n + 1], &above[..n], &below[..n]);
    for i in 0..n {
        let gained = (across[i] - across[i + 1]) + (above[i] - below[i]);
        let moved = suspended[i] + gained;
        suspended[i] = if moved > 0.0 { moved } else { 0.0 }; // rounding may undercut 0 by one unit
    }
}

/// The speed that decides on sub-steps: van Leer's scheme needs half the upwind step, mixing and diffusion their own.
pub fn substep_speed(outflow: f32, dispersion: f32, diffusion: f32) -> f32 {
    (2.0 + 2.0 * dispersion) * outflow + 4.0 * diffusion
}
