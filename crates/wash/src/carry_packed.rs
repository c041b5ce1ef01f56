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

#[multiversion(targets("x86_64+avx2"))]
fn add(sum: &mut [f32], amount: &[f32]) {
    for (sum, amount) in sum.iter_mut().zip(amount) {
        *sum += amount;
    }
}

#[multiversion(targets("x86_64+avx2"))]
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

/// What faces of one kind see along their axis: two cells on each side, and how fast water goes from one to the other.
#[derive(Clone, Copy, Debug)]
pub struct FaceRows<'a> {
    /// Pigment in the cells two, and one before the face, one and two after.
    pub cells: [&'a [f32]; 4],
    /// Room in the cells before and after.
    pub room: [&'a [f32]; 2],
    /// Velocity through the face.
    pub speed: &'a [f32],
    /// Mobility of the face, 0 beside dry cells.
    pub mobility: &'a [f32],
}

/// Pigment through `count` faces of one row in a sub-step; all rows begin at the first of them.
///
/// # Source
/// van Leer 1974, second order with his limiter.
pub fn flux(flux: &mut [f32], faces: &FaceRows<'_>, spread: Spread) {
    flux_kernel(flux, faces, spread);
}

#[multiversion(targets("x86_64+avx2"))]
fn flux_kernel(flux: &mut [f32], faces: &FaceRows<'_>, spread: Spread) {
    let Spread { dt, diffusion, dispersion } = spread;
    let n = flux.len();
    let [far_before, before, after, far_after] = faces.cells.map(|cells| &cells[..n]);
    let [room_before, room_after] = faces.room.map(|room| &room[..n]);
    let (speed, mobility) = (&faces.speed[..n], &faces.mobility[..n]);
    for i in 0..n {
        let cells = [far_before[i], before[i], after[i], far_after[i]];
        let way = speed[i] * dt;
        let carried = carried(cells, [room_before[i], room_after[i]], way);
        let mixing = diffusion * mobility[i] + dispersion * way.abs();
        let both = carried + mixing * (before[i] - after[i]);
        flux[i] = if mobility[i] > 0.0 { both } else { 0.0 };
    }
}

/// As [`flux`], by the plain upstream scheme, which blurs what it carries: for pigment that flow mixes at least as much, and
/// that is mixed by itself afterwards ([`Mixing`](crate::mix_pigment::Mixing)).
pub fn flux_upstream(flux: &mut [f32], faces: &FaceRows<'_>, spread: Spread) {
    flux_upstream_kernel(flux, faces, spread.dt);
}

#[multiversion(targets("x86_64+avx2"))]
fn flux_upstream_kernel(flux: &mut [f32], faces: &FaceRows<'_>, dt: f32) {
    let n = flux.len();
    let [_, before, after, _] = faces.cells;
    let (before, after) = (&before[..n], &after[..n]);
    let [room_before, room_after] = faces.room;
    let (room_before, room_after) = (&room_before[..n], &room_after[..n]);
    let (speed, mobility) = (&faces.speed[..n], &faces.mobility[..n]);
    for i in 0..n {
        let way = speed[i] * dt;
        // One of the two is 0: a choice between what lies up- and downstream would keep the loop from being vectors.
        let forward = 0.5 * (way.abs() + way) * room_after[i];
        let backward = 0.5 * (way.abs() - way) * room_before[i];
        let carried = forward * before[i] - backward * after[i];
        flux[i] = if mobility[i] > 0.0 { carried } else { 0.0 };
    }
}

/// What goes `way` cells through a face. Takes values and divides in any case, so that no branch keeps the loop from
/// being vectors.
#[inline(always)]
fn carried(
    [far_before, before, after, far_after]: [f32; 4],
    [room_before, room_after]: [f32; 2],
    way: f32,
) -> f32 {
    let forward = way > 0.0;
    // Upstream, downstream, and what lies farther upstream.
    let up = if forward { before } else { after };
    let down = if forward { after } else { before };
    let far = if forward { far_before } else { far_after };
    let room = if forward { room_after } else { room_before };
    let (rise, next) = (up - far, down - up);
    let product = rise * next;
    let mean = 2.0 * product / (rise + next);
    let slope = if product > 0.0 { mean } else { 0.0 };
    way * (up + 0.5 * (1.0 - way.abs()) * slope) * room
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

#[multiversion(targets("x86_64+avx2"))]
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
