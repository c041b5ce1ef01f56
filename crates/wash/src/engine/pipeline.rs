//! A pass: row stages that go down the rows of a band together.
//!
//! Each stage follows so many rows behind the one before it that what it reads of it is done. Fields are changed in
//! place; what a stage still needs of rows that it has changed it keeps in its scratch, and a band changes copies of its
//! neighbours' rows for itself. So bands depend on nothing that another one changes, and their number changes no bit.

use super::stage::Stage;
use super::world::World;

/// Rows that a stage does before it is the next one's turn.
///
/// One by one, the code of all stages and the branches in it would have to be found anew for every row, and rows that a stage
/// made would have left the nearest cache before the next one has read them as those above and below: a tenth slower in a
/// living wash, a twentieth in C97's.
pub const ROWS_AT_ONCE: usize = 8;

/// Rows below its own that the transport of pigment sees.
const REACH_OF_PIGMENT: usize = 2;

/// Rows that all stages together look beyond a band, on each side.
pub fn depth(stages: &[Stage]) -> usize {
    stages.iter().map(|stage| stage.reach()).sum::<usize>() + 1
}

/// A stage on its way down.
struct Falling {
    stage: Stage,
    /// Rows behind the first stage.
    lag: usize,
    /// Rows that it does: the band's, and as many beyond as later stages need of it.
    first: usize,
    end: usize,
}

/// Runs the stages down the rows of a band.
pub fn descend(stages: &[Stage], world: &mut World<'_>) {
    let (own, active) = (world.own.clone(), world.active.clone());
    let mut beyond: usize = stages.iter().skip(1).map(|stage| stage.reach()).sum();
    let mut lag = 0;
    let mut falling = Vec::with_capacity(stages.len());
    for (i, &stage) in stages.iter().enumerate() {
        if i > 0 {
            lag += stage.reach();
            beyond -= stage.reach();
        }
        let first = own.start.saturating_sub(beyond).max(active.start);
        let end = (own.end + beyond).min(active.end);
        falling.push(Falling { stage, lag, first, end });
    }
    let first = falling.iter().map(|stage| stage.first + stage.lag).min().unwrap_or(0);
    let end = falling.iter().map(|stage| stage.end + stage.lag).max().unwrap_or(0);
    let amounts_ahead = world.amounts_ahead(stages);
    for lead in (first..end).step_by(ROWS_AT_ONCE) {
        for (number, &Falling { stage, lag, first, end }) in falling.iter().enumerate() {
            let rows =
                lead.saturating_sub(lag).max(first)..(lead + ROWS_AT_ONCE).saturating_sub(lag).min(end);
            for row in rows {
                world.work(stage, row);
            }
            // Amounts of pigment in the next rows: one after another stage, so that asking for them goes on all the time.
            let next = lead + ROWS_AT_ONCE + REACH_OF_PIGMENT;
            for amount in (number..amounts_ahead).step_by(falling.len()) {
                (next..next + ROWS_AT_ONCE).for_each(|row| world.look_ahead(amount, row));
            }
        }
    }
}
