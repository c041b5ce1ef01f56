//! Diffusion and mixing of pigment by themselves, first along the rows and then across them: so they may go twice as far at
//! a time as both at once, and what carries pigment needs fewer sub-steps.

use multiversion::multiversion;

use crate::region::Run;

/// How much is mixed through a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixing {
    /// Diffusion where the film is deep, cells².
    pub diffusion: f32,
    /// Of each cell a step of the face's velocity, cells.
    pub dispersion: f32,
    /// The same, for each cell a step once more.
    pub quickened: f32,
}

impl Mixing {
    /// What is left to mix in a step after the plain upstream scheme carried pigment in sub-steps of `dt`: at velocity v
    /// that blurs by |v| (1 − |v| dt) / 2.
    ///
    /// # Panics
    /// Never; but the dispersion must be at least [`Mixing::LEAST`].
    pub fn after_carrying(diffusion: f32, dispersion: f32, dt: f32) -> Self {
        Self { diffusion, dispersion: dispersion - Self::LEAST, quickened: 0.5 * dt }
    }

    /// Dispersion, cells, below which the upstream scheme blurs more than flow mixes.
    pub const LEAST: f32 = 0.5;

    /// In how many parts it must be done where no face is faster: half a cell² is the limit of positive amounts.
    pub fn passes(&self, fastest: f32) -> f32 {
        (2.0 * (self.diffusion + fastest * (self.dispersion + fastest * self.quickened))).ceil()
    }

    /// One of so many parts.
    pub fn part(&self, passes: f32) -> Self {
        let Self { diffusion, dispersion, quickened } = *self;
        let part = 1.0 / passes;
        Self { diffusion: part * diffusion, dispersion: part * dispersion, quickened: part * quickened }
    }
}

/// Velocity and mobility of the faces of a row.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// Velocity, cells a step.
    pub speed: &'a [f32],
    /// Mobility, 0 beside dry cells.
    pub mobility: &'a [f32],
}

/// Suspended pigment of one row mixes along it.
///
/// # Shapes and units
/// Field rows; the faces are those before the cells; `flux` is room for them.
///
/// # Guarantees
/// Pigment is kept to rounding; amounts stay ≥ 0 in as many passes as [`Mixing::passes`].
pub fn mix_along(suspended: &mut [f32], faces: Faces<'_>, flux: &mut [f32], mixing: Mixing, run: Run) {
    let columns = run.first..run.end + 1;
    let flux = &mut flux[columns.clone()];
    let cells = [&suspended[run.first - 1..run.end], &suspended[columns.clone()]];
    mixed(flux, cells, &faces.speed[columns.clone()], &faces.mobility[columns], mixing);
    gain(&mut suspended[run.first..run.end], &flux[..run.len()], &flux[1..]);
}

/// What mixes through the faces above the cells of one row, from the row above to here.
///
/// # Shapes and units
/// Field rows; the faces are those above the cells of `here`.
pub fn mixed_down(flux: &mut [f32], above: &[f32], here: &[f32], faces: Faces<'_>, mixing: Mixing, run: Run) {
    let columns = run.first..run.end;
    let [above, here, speed, mobility] =
        [above, here, faces.speed, faces.mobility].map(|row| &row[columns.clone()]);
    mixed(&mut flux[columns], [above, here], speed, mobility, mixing);
}

/// Adds what comes through the faces above the cells of one row, less what goes through those below.
pub fn gather_down(suspended: &mut [f32], above: &[f32], below: &[f32], run: Run) {
    let columns = run.first..run.end;
    gain(&mut suspended[columns.clone()], &above[columns.clone()], &below[columns]);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn mixed(flux: &mut [f32], cells: [&[f32]; 2], speed: &[f32], mobility: &[f32], mixing: Mixing) {
    let n = flux.len();
    let [before, after] = cells;
    let (before, after) = (&before[..n], &after[..n]);
    let (speed, mobility) = (&speed[..n], &mobility[..n]);
    let Mixing { diffusion, dispersion, quickened } = mixing;
    for i in 0..n {
        let speed = speed[i].abs();
        let mixing = diffusion * mobility[i] + speed * (dispersion + quickened * speed);
        flux[i] = mixing * (before[i] - after[i]);
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gain(suspended: &mut [f32], comes: &[f32], goes: &[f32]) {
    let n = suspended.len();
    let (comes, goes) = (&comes[..n], &goes[..n]);
    for i in 0..n {
        let moved = suspended[i] + (comes[i] - goes[i]);
        suspended[i] = if moved > 0.0 { moved } else { 0.0 }; // rounding may undercut 0 by one unit
    }
}
