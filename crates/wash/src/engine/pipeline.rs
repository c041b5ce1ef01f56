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

/// Runs the stages down the rows of a band.
pub fn descend(stages: &[Stage], world: &mut World<'_>) {
    let reach = |i: usize| stages[i].reach();
    // How far behind the first stage each one is, and how many rows beyond the band later ones need of it.
    let lags: Vec<usize> = (0..stages.len()).map(|i| (1..=i).map(reach).sum()).collect();
    let beyond: Vec<usize> = (0..stages.len()).map(|i| (i + 1..stages.len()).map(reach).sum()).collect();
    let (Some(&last_lag), Some(&first_beyond)) = (lags.last(), beyond.first()) else { return };
    let active = world.active.clone();
    for lead in world.own.start.saturating_sub(first_beyond)..world.own.end + last_lag {
        for (i, stage) in stages.iter().enumerate() {
            let Some(row) = lead.checked_sub(lags[i]) else { continue };
            let rows = world.own.start.saturating_sub(beyond[i])..world.own.end + beyond[i];
            if rows.contains(&row) && active.contains(&row) {
                world.work(*stage, row);
            }
        }
    }
}
