//! A pass: row stages that go down the rows of a band together.
//!
//! Each stage follows so many rows behind the one before it that what it reads of it is done. Fields are changed in
//! place; what a stage still needs of rows that it has changed it keeps in its scratch, and a band changes copies of its
//! neighbours' rows for itself. So bands depend on nothing that another one changes, and their number changes no bit.

use super::stage::Stage;
use super::world::World;

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
    for lead in first..end {
        for &Falling { stage, lag, first, end } in &falling {
            // Below the first row it wraps, and is past the end.
            let row = lead.wrapping_sub(lag);
            if row >= first && row < end {
                world.work(stage, row);
            }
        }
    }
}
