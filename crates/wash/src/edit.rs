//! Water and pigment poured on and lifted between steps.

use girtin_grid::{Field, Raster};

use crate::params::WashModel;
use crate::tiles::Tile;
use crate::wash::Wash;

/// Amounts on a rectangle of cells; what lies off the canvas is ignored.
#[derive(Clone, Copy, Debug)]
pub struct Patch<'a> {
    /// Canvas column of the first amount.
    pub x: usize,
    /// Canvas row of the first amount.
    pub y: usize,
    /// The amounts.
    pub amounts: &'a Raster<f32>,
}

impl<'a> Patch<'a> {
    /// Amounts for the whole canvas.
    pub fn whole(amounts: &'a Raster<f32>) -> Self {
        Self { x: 0, y: 0, amounts }
    }

    /// Calls `each` with canvas column, canvas row and amount of every cell on a canvas of this size.
    pub(crate) fn each(&self, width: usize, height: usize, mut each: impl FnMut(usize, usize, f32)) {
        for row in 0..self.amounts.height().min(height.saturating_sub(self.y)) {
            let amounts = self.amounts.row(row).iter().take(width.saturating_sub(self.x));
            for (column, &amount) in amounts.enumerate() {
                each(self.x + column, self.y + row, amount);
            }
        }
    }
}

/// What was taken off a wash.
#[derive(Clone, Debug, PartialEq)]
pub struct Taken {
    /// Water, in the unit of [`Wash::water_total`].
    pub water: f64,
    /// Each pigment.
    pub pigments: Vec<f64>,
}

impl Wash {
    fn size(&self) -> (usize, usize) {
        (self.state.layout().width(), self.state.layout().height())
    }

    /// Notes that the cells of a patch have changed.
    fn edited(&mut self, patch: &Patch<'_>) {
        let (width, height) = self.size();
        let (first, end) = (patch.x.min(width), (patch.x + patch.amounts.width()).min(width));
        for y in patch.y..(patch.y + patch.amounts.height()).min(height) {
            self.changed.mark(y, first, end, true);
        }
        self.forget();
    }

    /// Wets the paper wherever the amount is above 0.
    ///
    /// A living wash dries again where no water is added.
    pub fn wet(&mut self, patch: Patch<'_>) {
        let (width, height) = self.size();
        let mask = &mut self.state.wet_mask;
        patch.each(width, height, |x, y, amount| {
            if amount > 0.0 {
                mask.cells_mut(y)[x] = 1;
            }
        });
        self.edited(&patch);
    }

    /// Pours water on wet paper: the amount is added to the pressure, or to the film of a living wash.
    ///
    /// Returns how much in all, in the unit of [`Wash::water_total`].
    pub fn add_water(&mut self, patch: Patch<'_>) -> f64 {
        let (width, height) = self.size();
        let is_living = matches!(self.model, WashModel::Living(_));
        let state = &mut self.state;
        let mut added = 0.0;
        patch.each(width, height, |x, y, amount| {
            if amount != 0.0 && state.wet_mask.cells(y)[x] != 0 {
                let film = &mut state.pressure.cells_mut(y)[x];
                let before = *film;
                *film += amount;
                if is_living && *film < 0.0 {
                    *film = before.min(0.0); // no more can be taken than there is
                }
                added += f64::from(*film) - f64::from(before);
            }
        });
        self.edited(&patch);
        added / self.cells_per_unit()
    }

    /// Adds suspended pigment to the water on wet paper; returns how much in all.
    ///
    /// # Panics
    /// There is no such pigment.
    pub fn add_pigment(&mut self, pigment: usize, patch: Patch<'_>) -> f64 {
        let (width, height) = self.size();
        let (mask, suspended) = (&self.state.wet_mask, &mut self.state.suspended[pigment]);
        let mut added = 0.0;
        patch.each(width, height, |x, y, amount| {
            if amount > 0.0 && mask.cells(y)[x] != 0 {
                let cell = &mut suspended.cells_mut(y)[x];
                let before = *cell;
                *cell += amount;
                added += f64::from(*cell) - f64::from(before);
            }
        });
        self.edited(&patch);
        added
    }

    /// Lifts a fraction of each pigment, from the water and off the paper; returns how much of each.
    pub fn lift(&mut self, fraction: Patch<'_>) -> Vec<f64> {
        let (width, height) = self.size();
        let pigments = self.state.suspended.iter_mut().zip(&mut self.state.deposited);
        let lift = |(suspended, deposited): (&mut Field<f32>, &mut Field<f32>)| {
            let mut lifted = 0.0;
            fraction.each(width, height, |x, y, fraction| {
                lifted += take_part(suspended, x, y, fraction) + take_part(deposited, x, y, fraction);
            });
            lifted
        };
        let lifted = pigments.map(lift).collect();
        self.edited(&fraction);
        lifted
    }

    /// Blots a fraction of the film with the pigment in it, and of the water in the pores below, as a dry cloth does.
    ///
    /// What has settled stays on the paper; see [`Wash::lift`].
    pub fn blot(&mut self, fraction: Patch<'_>) -> Taken {
        let (width, height) = self.size();
        let depth = self.pore_depth();
        let state = &mut self.state;
        let mut water = 0.0;
        let mut pigments = vec![0.0; state.suspended.len()];
        fraction.each(width, height, |x, y, fraction| {
            water += take_part(&mut state.pressure, x, y, fraction);
            water += depth * take_part(&mut state.saturation, x, y, fraction);
            for (taken, suspended) in pigments.iter_mut().zip(&mut state.suspended) {
                *taken += take_part(suspended, x, y, fraction);
            }
        });
        let water = water / self.cells_per_unit();
        if let Some(ledger) = &mut self.state.ledger {
            ledger.blotted += water;
        }
        self.edited(&fraction);
        Taken { water, pigments }
    }

    /// Dries a fraction of film and pore water, as warm air does; where all is dried the pigment settles.
    ///
    /// Given a small fraction step after step it dries fast, given 1 it dries at once.
    pub fn dry_within(&mut self, fraction: Patch<'_>) {
        let (width, height) = self.size();
        let depth = self.pore_depth();
        let state = &mut self.state;
        let mut water = 0.0;
        fraction.each(width, height, |x, y, fraction| {
            water += take_part(&mut state.pressure, x, y, fraction);
            water += depth * take_part(&mut state.saturation, x, y, fraction);
            if fraction >= 1.0 && state.wet_mask.cells(y)[x] != 0 {
                state.leave(x, y);
            }
        });
        let water = water / self.cells_per_unit();
        if let Some(ledger) = &mut self.state.ledger {
            ledger.evaporated += water;
        }
        self.edited(&fraction);
    }

    /// Dries the whole wash: suspended pigment settles where it is, the water is gone and still.
    ///
    /// Pore water stays; see [`Wash::soak`].
    pub fn dry(&mut self) {
        let layout = self.state.layout();
        let state = &mut self.state;
        let mut water = 0.0;
        for y in 0..=layout.height() {
            still(state.u.faces_mut(y));
            still(state.v.faces_mut(y));
        }
        for y in 0..layout.height() {
            for x in 0..layout.width() {
                water += f64::from(state.pressure.cells(y)[x]);
                if state.wet_mask.cells(y)[x] != 0 {
                    state.leave(x, y);
                    self.changed.mark(y, x, x + 1, true);
                }
            }
            still(state.pressure.cells_mut(y));
        }
        let water = water / self.cells_per_unit();
        if let Some(ledger) = &mut self.state.ledger {
            ledger.evaporated += water;
        }
        self.forget();
    }

    /// Sets the water in the pores.
    ///
    /// Returns how much was added, less what was taken, in the unit of [`Wash::water_total`].
    pub fn soak(&mut self, patch: Patch<'_>) -> f64 {
        let (width, height) = self.size();
        let saturation = &mut self.state.saturation;
        let mut added = 0.0;
        patch.each(width, height, |x, y, amount| {
            let before = saturation.cells(y)[x];
            if before != amount {
                let after = amount.max(0.0);
                saturation.cells_mut(y)[x] = after;
                added += f64::from(after) - f64::from(before);
            }
        });
        self.edited(&patch);
        self.pore_depth() * added / self.cells_per_unit()
    }

    /// Moistens the paper of a living wash with so many pore volumes of water: pores fill first, what they cannot hold
    /// stands as film. Of C97 it fills pores only.
    ///
    /// Returns how much was added, in the unit of [`Wash::water_total`].
    pub fn moisten(&mut self, patch: Patch<'_>) -> f64 {
        let (width, height) = self.size();
        let (depth, [least, most]) = (self.pore_depth(), self.capacity());
        let is_living = matches!(self.model, WashModel::Living(_));
        let state = &mut self.state;
        let mut added = 0.0;
        patch.each(width, height, |x, y, amount| {
            if amount <= 0.0 {
                return;
            }
            let capacity = f64::from(state.height.cells(y)[x]) * (most - least) + least;
            let pores = &mut state.saturation.cells_mut(y)[x];
            let before = f64::from(*pores);
            let wanted = before + f64::from(amount) * capacity;
            *pores = wanted.min(capacity.max(before)) as f32;
            added += depth * (f64::from(*pores) - before);
            let over = (wanted - f64::from(*pores)) as f32;
            if is_living && over > 0.0 {
                let film = &mut state.pressure.cells_mut(y)[x];
                let before = f64::from(*film);
                *film += over * depth as f32;
                added += f64::from(*film) - before;
                state.wet_mask.cells_mut(y)[x] = 1;
            }
        });
        self.edited(&patch);
        added / self.cells_per_unit()
    }

    /// The tiles that may have changed since this was last asked, by edits and by running.
    pub fn take_changed_tiles(&mut self) -> Vec<Tile> {
        self.changed.take()
    }
}

/// Takes a fraction of what a cell holds; returns how much.
fn take_part(field: &mut Field<f32>, x: usize, y: usize, fraction: f32) -> f64 {
    let before = field.cells(y)[x];
    // Read before writing: pages of untouched paper stay untouched. A film below 0 has nothing to give.
    if fraction <= 0.0 || before <= 0.0 {
        return 0.0;
    }
    let after = if fraction < 1.0 { before * (1.0 - fraction) } else { 0.0 };
    field.cells_mut(y)[x] = after;
    f64::from(before) - f64::from(after)
}

/// Zeroes what is not 0 yet: pages of untouched paper stay untouched.
fn still(values: &mut [f32]) {
    values.iter_mut().filter(|value| **value != 0.0).for_each(|value| *value = 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PigmentHandling, RunConfig, WashModel, WashState};

    fn wash() -> Wash {
        let handling = PigmentHandling { density: 0.05, staining_power: 2.0, granulation: 0.5 };
        Wash::new(WashState::dry(&Raster::new(20, 10, 0.5), 1), WashModel::c97(), vec![handling]).unwrap()
    }

    #[test]
    fn pigment_goes_where_the_paper_is_wet_and_nowhere_else() {
        let mut wash = wash();
        wash.wet(Patch { x: 15, y: 5, amounts: &Raster::new(9, 9, 1.0) });
        wash.add_pigment(0, Patch::whole(&Raster::new(20, 10, 0.5)));
        assert_eq!(wash.state().pigment_totals(), [5.0 * 5.0 * 0.5]);
    }

    #[test]
    fn what_is_lifted_is_what_is_missing() {
        let mut wash = wash();
        wash.wet(Patch::whole(&Raster::new(20, 10, 1.0)));
        wash.add_water(Patch::whole(&Raster::new(20, 10, 0.3)));
        wash.add_pigment(0, Patch::whole(&Raster::new(20, 10, 0.5)));
        wash.run(10, &RunConfig::default()).unwrap();
        let before = wash.state().pigment_totals()[0];
        let lifted = wash.lift(Patch { x: 2, y: 2, amounts: &Raster::new(5, 4, 0.7) })[0];
        assert!(lifted > 0.0);
        assert!((before - lifted - wash.state().pigment_totals()[0]).abs() < 1e-6);
    }

    #[test]
    fn a_dried_wash_keeps_its_pigment_and_can_be_wetted_again() {
        let mut wash = wash();
        wash.wet(Patch { x: 3, y: 3, amounts: &Raster::new(6, 4, 1.0) });
        wash.add_water(Patch::whole(&Raster::new(20, 10, 0.5)));
        wash.add_pigment(0, Patch::whole(&Raster::new(20, 10, 0.5)));
        wash.run(5, &RunConfig::default()).unwrap();
        wash.dry();
        assert_eq!(wash.state().max_speed(), 0.0);
        assert_eq!(wash.state().water_total(), 0.0);
        assert!((wash.state().pigment_totals()[0] - 12.0).abs() < 1e-5);
        wash.wet(Patch::whole(&Raster::new(20, 10, 1.0)));
        wash.run(5, &RunConfig::default()).unwrap();
        assert!((wash.state().pigment_totals()[0] - 12.0).abs() < 1e-5);
    }

    fn living() -> Wash {
        let handling = PigmentHandling { density: 0.05, staining_power: 2.0, granulation: 0.5 };
        let state = WashState::dry(&Raster::new(90, 70, 0.5), 1);
        let mut wash = Wash::new(state, WashModel::living(), vec![handling]).unwrap();
        wash.moisten(Patch { x: 10, y: 10, amounts: &Raster::new(40, 30, 0.6) });
        let stroke = Raster::new(20, 12, 1.0);
        let stroke = Patch { x: 15, y: 15, amounts: &stroke };
        wash.wet(stroke);
        wash.add_water(stroke);
        wash.add_pigment(0, Patch { amounts: &Raster::new(20, 12, 0.5), ..stroke });
        wash
    }

    #[test]
    fn water_is_accounted_for_whatever_is_done() {
        let mut wash = living();
        let mut poured = wash.water_total();
        let balance = |wash: &Wash, poured: f64, after: &str| {
            let ledger = wash.state().ledger.unwrap();
            let found = wash.water_total() + ledger.evaporated + ledger.blotted;
            assert!((found / poured - 1.0).abs() < 1e-5, "after {after}: {found} of {poured}");
        };
        wash.run(20, &RunConfig::default()).unwrap();
        balance(&wash, poured, "running");
        let blotted = wash.blot(Patch { x: 18, y: 0, amounts: &Raster::new(6, 40, 0.7) });
        assert!(blotted.water > 0.0 && blotted.pigments[0] > 0.0);
        balance(&wash, poured, "blotting");
        poured += wash.moisten(Patch { x: 60, y: 20, amounts: &Raster::new(50, 60, 1.4) });
        balance(&wash, poured, "moistening");
        wash.run(20, &RunConfig::default()).unwrap();
        wash.dry_within(Patch { x: 0, y: 0, amounts: &Raster::new(30, 30, 0.1) });
        wash.dry_within(Patch { x: 30, y: 0, amounts: &Raster::new(9, 70, 1.0) });
        balance(&wash, poured, "drying");
        wash.run(20, &RunConfig::default()).unwrap();
        poured += wash.soak(Patch { x: 0, y: 60, amounts: &Raster::new(90, 10, 0.3) });
        wash.dry();
        balance(&wash, poured, "drying it all");
        wash.run(20, &RunConfig::default()).unwrap();
        balance(&wash, poured, "running on");
    }

    #[test]
    fn tiles_are_named_once_and_only_where_something_happens() {
        let mut wash = living();
        let tiles = wash.take_changed_tiles();
        assert!(tiles.contains(&Tile { x: 0, y: 0, pigment: true }));
        assert_eq!(wash.take_changed_tiles(), []);
        wash.run(3, &RunConfig::default()).unwrap();
        assert_eq!(wash.take_changed_tiles(), [Tile { x: 0, y: 0, pigment: true }]);
        // Far from the water.
        wash.lift(Patch { x: 80, y: 66, amounts: &Raster::new(3, 2, 0.5) });
        assert_eq!(wash.take_changed_tiles(), [Tile { x: 64, y: 64, pigment: true }]);
        wash.dry();
        wash.take_changed_tiles();
        wash.run(3, &RunConfig::default()).unwrap();
        assert_eq!(wash.take_changed_tiles(), [Tile { x: 0, y: 0, pigment: false }], "the pores are damp");
        wash.dry_within(Patch::whole(&Raster::new(90, 70, 1.0)));
        wash.take_changed_tiles();
        wash.run(3, &RunConfig::default()).unwrap();
        assert_eq!(wash.take_changed_tiles(), [], "all is dry");
    }
}
