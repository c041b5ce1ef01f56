//! Water and pigment poured on and lifted between steps.

use girtin_grid::{Field, Raster};

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
    fn each(&self, width: usize, height: usize, mut each: impl FnMut(usize, usize, f32)) {
        for row in 0..self.amounts.height().min(height.saturating_sub(self.y)) {
            let amounts = self.amounts.row(row).iter().take(width.saturating_sub(self.x));
            for (column, &amount) in amounts.enumerate() {
                each(self.x + column, self.y + row, amount);
            }
        }
    }
}

impl Wash {
    fn size(&self) -> (usize, usize) {
        (self.state.layout().width(), self.state.layout().height())
    }

    /// Wets the paper wherever the amount is above 0.
    pub fn wet(&mut self, patch: Patch<'_>) {
        let (width, height) = self.size();
        let mask = &mut self.state.wet_mask;
        patch.each(width, height, |x, y, amount| {
            if amount > 0.0 {
                mask.cells_mut(y)[x] = 1;
            }
        });
        self.forget();
    }

    /// Pours water on wet paper: the amount is added to the pressure.
    pub fn add_water(&mut self, patch: Patch<'_>) {
        let (width, height) = self.size();
        let state = &mut self.state;
        patch.each(width, height, |x, y, amount| {
            if amount != 0.0 && state.wet_mask.cells(y)[x] != 0 {
                state.pressure.cells_mut(y)[x] += amount;
            }
        });
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
        added
    }

    /// Lifts a fraction of each pigment, from the water and off the paper; returns how much of each.
    pub fn lift(&mut self, fraction: Patch<'_>) -> Vec<f64> {
        let (width, height) = self.size();
        let pigments = self.state.suspended.iter_mut().zip(&mut self.state.deposited);
        let lift = |(suspended, deposited): (&mut Field<f32>, &mut Field<f32>)| {
            let mut lifted = 0.0;
            fraction.each(width, height, |x, y, fraction| {
                let fraction = fraction.clamp(0.0, 1.0);
                for field in [&mut *suspended, &mut *deposited] {
                    let before = field.cells(y)[x];
                    // Read before writing: pages of untouched paper stay untouched.
                    if fraction > 0.0 && before > 0.0 {
                        let after = before * (1.0 - fraction);
                        field.cells_mut(y)[x] = after;
                        lifted += f64::from(before) - f64::from(after);
                    }
                }
            });
            lifted
        };
        pigments.map(lift).collect()
    }

    /// Dries the whole wash: suspended pigment settles where it is, the water is gone and still.
    ///
    /// Pore water stays; see [`Wash::soak`].
    pub fn dry(&mut self) {
        let height = self.state.layout().height();
        let state = &mut self.state;
        for y in 0..=height {
            still(state.u.faces_mut(y));
            still(state.v.faces_mut(y));
        }
        for y in 0..height {
            still(state.pressure.cells_mut(y));
            if state.wet_mask.cells(y).iter().any(|&wet| wet != 0) {
                state.wet_mask.cells_mut(y).fill(0);
            }
            for (suspended, deposited) in state.suspended.iter_mut().zip(&mut state.deposited) {
                for x in 0..state.height.cells(y).len() {
                    let settling = suspended.cells(y)[x];
                    if settling > 0.0 {
                        deposited.cells_mut(y)[x] += settling;
                        suspended.cells_mut(y)[x] = 0.0;
                    }
                }
            }
        }
        self.forget();
    }

    /// Sets the water in the pores.
    pub fn soak(&mut self, patch: Patch<'_>) {
        let (width, height) = self.size();
        let saturation = &mut self.state.saturation;
        patch.each(width, height, |x, y, amount| {
            if saturation.cells(y)[x] != amount {
                saturation.cells_mut(y)[x] = amount.max(0.0);
            }
        });
        self.forget();
    }
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
        Wash::new(WashState::dry(&Raster::new(20, 10, 0.5), 1), WashModel::default(), vec![handling]).unwrap()
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
}
