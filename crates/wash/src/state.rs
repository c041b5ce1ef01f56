//! Everything a wash is made of at one moment.

use girtin_grid::{Field, Layout, Raster};

/// The state of a wash.
///
/// All fields have the canvas's [`Layout`]: `u` uses one column more, `v` one row more.
#[derive(Clone, Debug, PartialEq)]
pub struct WashState {
    /// M: 1 where the paper is wet, else 0.
    pub wet_mask: Field<u8>,
    /// h: height of the paper, 0 to 1.
    pub height: Field<f32>,
    /// u: velocity through the face before each cell, cells per step.
    pub u: Field<f32>,
    /// v: velocity through the face above each cell, cells per step.
    pub v: Field<f32>,
    /// p: pressure of the water.
    pub pressure: Field<f32>,
    /// s: water in the pores of the paper.
    pub saturation: Field<f32>,
    /// g: pigment in the water, a field per pigment.
    pub suspended: Vec<Field<f32>>,
    /// d: pigment on the paper, a field per pigment.
    pub deposited: Vec<Field<f32>>,
    /// What a living wash keeps besides.
    pub ledger: Option<Ledger>,
}

/// What a living wash knows besides its fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ledger {
    /// Cells a millimetre of paper.
    pub cells_per_mm: f64,
    /// Part of a cell that edges have yet to advance.
    pub contact_carry: f64,
    /// Water that evaporated, film × reference cells (0.25 mm square).
    pub evaporated: f64,
    /// Water that was blotted, film × reference cells.
    pub blotted: f64,
}

impl Ledger {
    /// Cells a millimetre that are allowed.
    pub const CELLS_PER_MM: std::ops::RangeInclusive<f64> = 0.1..=256.0;

    /// Nothing has happened yet.
    pub fn new(cells_per_mm: f64) -> Self {
        Self { cells_per_mm, contact_carry: 0.0, evaporated: 0.0, blotted: 0.0 }
    }

    /// What is wrong with it, if anything.
    fn check(&self) -> Result<(), StateError> {
        let Self { cells_per_mm, contact_carry, evaporated, blotted } = *self;
        let number = |name, value: f64, is_allowed: bool, allowed| {
            if is_allowed { Ok(()) } else { Err(StateError::Number { name, value, allowed }) }
        };
        // Below 0 where a film that was below 0 at the start has dried.
        let amount = -1e12..=1e12;
        number("cells_per_mm", cells_per_mm, Self::CELLS_PER_MM.contains(&cells_per_mm), "from 0.1 to 256")?;
        number("contact_carry", contact_carry, (0.0..1.0).contains(&contact_carry), "from 0 to below 1")?;
        number("evaporated", evaporated, amount.contains(&evaporated), "from -1e12 to 1e12")?;
        number("blotted", blotted, amount.contains(&blotted), "from -1e12 to 1e12")
    }
}

/// What is wrong with a state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StateError {
    /// A value is not a number, infinite, or outside what the field allows.
    #[error("`{field}` is {value} at column {x}, row {y}{}; it must be {allowed}", pigment.map_or(String::new(), |k| format!(" of pigment {}", k + 1)))]
    Value {
        /// Name of the field.
        field: &'static str,
        /// Which pigment's, from 0.
        pigment: Option<usize>,
        /// Column of the canvas, from 0.
        x: usize,
        /// Row of the canvas, from 0.
        y: usize,
        /// What was found.
        value: f32,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A number of a living wash is not allowed.
    #[error("`{name}` is {value}; it must be {allowed}")]
    Number {
        /// Its name.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The number of pigments is not that of the pigment fields.
    #[error(
        "the state holds {suspended} suspended and {deposited} deposited pigments, and {handlings} named"
    )]
    Pigments {
        /// Suspended fields.
        suspended: usize,
        /// Deposited fields.
        deposited: usize,
        /// Handlings given.
        handlings: usize,
    },
    /// A pigment's numbers are not allowed.
    #[error("pigment {}: {fault}", pigment + 1)]
    Handling {
        /// Which pigment, from 0.
        pigment: usize,
        /// What is wrong.
        fault: String,
    },
    /// A field has another size than the wet mask.
    #[error("`{field}` is {width} × {height} cells, the wet mask is not")]
    Size {
        /// Name of the field.
        field: &'static str,
        /// Columns found.
        width: usize,
        /// Rows found.
        height: usize,
    },
}

impl WashState {
    /// Dry paper of the given height with no pigment, ready for `pigments` of them.
    pub fn dry(height: &Raster<f32>, pigments: usize) -> Self {
        let mut state = Self::empty(Layout::new(height.width(), height.height()), pigments);
        for y in 0..height.height() {
            state.height.cells_mut(y).copy_from_slice(height.row(y));
        }
        state
    }

    /// All fields 0: not yet paper, but room for a state that is being read. Costs no memory until written.
    pub fn empty(layout: Layout, pigments: usize) -> Self {
        let field = || Field::<f32>::zeroed(layout);
        Self {
            wet_mask: Field::<u8>::zeroed(layout),
            height: field(),
            u: field(),
            v: field(),
            pressure: field(),
            saturation: field(),
            suspended: (0..pigments).map(|_| field()).collect(),
            deposited: (0..pigments).map(|_| field()).collect(),
            ledger: None,
        }
    }

    /// Where the cells lie.
    pub fn layout(&self) -> Layout {
        self.wet_mask.layout()
    }

    /// Sum of each pigment, suspended and deposited.
    pub fn pigment_totals(&self) -> Vec<f64> {
        self.suspended.iter().zip(&self.deposited).map(|(g, d)| total(g) + total(d)).collect()
    }

    /// Water in the pores, plus the pressure over wet paper, which is what water poured on becomes.
    pub fn water_total(&self) -> f64 {
        let over_wet: f64 = (0..self.layout().height())
            .map(|y| {
                let wet = self.wet_mask.cells(y).iter().zip(self.pressure.cells(y));
                wet.filter(|(wet, _)| **wet != 0).map(|(_, &p)| f64::from(p)).sum::<f64>()
            })
            .sum();
        total(&self.saturation) + over_wet
    }

    /// A cell leaves the wet paper: its pigment settles, its water is gone and its faces stand still.
    pub(crate) fn leave(&mut self, x: usize, y: usize) {
        self.wet_mask.cells_mut(y)[x] = 0;
        self.pressure.cells_mut(y)[x] = 0.0;
        for (suspended, deposited) in self.suspended.iter_mut().zip(&mut self.deposited) {
            deposited.cells_mut(y)[x] += suspended.cells(y)[x];
            suspended.cells_mut(y)[x] = 0.0;
        }
        still_faces(&mut self.u, &mut self.v, x, y);
    }

    /// Film, and the film that the water in the pores would make, over all cells.
    pub(crate) fn film_and_pores(&self, pore_depth: f64) -> f64 {
        total(&self.pressure) + pore_depth * total(&self.saturation)
    }

    /// The largest |u| or |v|.
    pub fn max_speed(&self) -> f32 {
        let largest = |row: &[f32]| row.iter().fold(0, |m: i32, x| m.max(x.abs().to_bits() as i32));
        let rows = self.layout().rows();
        let bits = rows.map(|row| largest(self.u.row(row)).max(largest(self.v.row(row)))).max();
        f32::from_bits(bits.unwrap_or(0) as u32)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// Fields differ in size; a value is not finite or not allowed.
    pub fn check(&self) -> Result<(), StateError> {
        if let Some(ledger) = &self.ledger {
            ledger.check()?;
        }
        let layout = self.layout();
        let size = |field: &'static str, found: Layout| {
            if found == layout {
                Ok(())
            } else {
                Err(StateError::Size { field, width: found.width(), height: found.height() })
            }
        };
        for y in 0..layout.height() {
            if let Some(x) = self.wet_mask.cells(y).iter().position(|&m| m > 1) {
                let value = f32::from(self.wet_mask.cells(y)[x]);
                return Err(StateError::Value {
                    field: "wet_mask",
                    pigment: None,
                    x,
                    y,
                    value,
                    allowed: "0 or 1",
                });
            }
        }
        for (name, field, limits) in [
            ("height", &self.height, Limits::UNIT),
            ("u", &self.u, Limits::FINITE),
            ("v", &self.v, Limits::FINITE),
            ("pressure", &self.pressure, Limits::FINITE),
            ("saturation", &self.saturation, Limits::AMOUNT),
        ] {
            size(name, field.layout())?;
            limits.check(name, None, field)?;
        }
        for (name, fields) in [("suspended", &self.suspended), ("deposited", &self.deposited)] {
            for (pigment, field) in fields.iter().enumerate() {
                size(name, field.layout())?;
                Limits::AMOUNT.check(name, Some(pigment), field)?;
            }
        }
        Ok(())
    }
}

/// Stills the four faces of a cell.
pub(crate) fn still_faces(u: &mut Field<f32>, v: &mut Field<f32>, x: usize, y: usize) {
    u.faces_mut(y)[x..x + 2].fill(0.0);
    v.cells_mut(y)[x] = 0.0;
    v.cells_mut(y + 1)[x] = 0.0;
}

fn total(field: &Field<f32>) -> f64 {
    // Row sums first: the order is fixed, and long sums lose less.
    (0..field.layout().height()).map(|y| field.cells(y).iter().map(|&x| f64::from(x)).sum::<f64>()).sum()
}

/// What values a field allows.
struct Limits {
    least: f32,
    most: f32,
    allowed: &'static str,
}

impl Limits {
    const FINITE: Self = Self { least: f32::MIN, most: f32::MAX, allowed: "a finite number" };
    const AMOUNT: Self = Self { least: 0.0, most: f32::MAX, allowed: "a finite number, 0 or more" };
    const UNIT: Self = Self { least: 0.0, most: 1.0, allowed: "from 0 to 1" };

    fn check(
        &self,
        name: &'static str,
        pigment: Option<usize>,
        field: &Field<f32>,
    ) -> Result<(), StateError> {
        let layout = field.layout();
        // One row and one column more than the canvas: faces. The border of other fields is 0, which all allow.
        for y in 0..=layout.height() {
            let row = &field.row(Layout::TOP + y)[Layout::LEFT..][..layout.width() + 1];
            let inside = |value: f32| value >= self.least && value <= self.most;
            if !row.iter().fold(true, |all, &value| all & inside(value)) {
                let x = row.iter().position(|&value| !inside(value)).unwrap_or(0);
                return Err(StateError::Value {
                    field: name,
                    pigment,
                    x,
                    y,
                    value: row[x],
                    allowed: self.allowed,
                });
            }
        }
        Ok(())
    }
}
