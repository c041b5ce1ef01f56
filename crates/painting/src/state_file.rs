//! The state of a wash as an `.npz` file, for NumPy and back.
//!
//! ```python
//! state = dict(np.load("state.npz"))
//! state["suspended"][0, 20:40, 20:40] = 0.7
//! np.savez("state.npz", **state)
//! ```
//!
//! | key | shape | if missing |
//! |---|---|---|
//! | `wet_mask` | (H, W), bool or uint8 | refused |
//! | `height` | (H, W) | 0.5 |
//! | `u`, `v` | (H, W + 1), (H + 1, W) | 0 |
//! | `pressure`, `saturation` | (H, W) | 0 |
//! | `suspended`, `deposited` | (pigments, H, W) | 0, as many as the other has |
//! | `cells_per_mm`, `contact_carry`, `evaporated`, `blotted` | (), float64 | 4, 0, 0, 0 |
//!
//! The numbers of the last row are those of a living wash ([`Ledger`]); a state with any of them is one. They are read as
//! float32 too, and as arrays of one number.
//!
//! Numbers are float32 or float64, of either byte order, in C or Fortran order, stored or deflated. They are written
//! as float32, little-endian, C order, stored; equal states give equal bytes. Without pigments, `suspended` and
//! `deposited` are not written.
//!
//! The array headers are read here and not by a crate for `.npy`: those at hand reserve the memory that a header
//! claims before they have seen the data, or overflow on its product, and a state file may come from anywhere.
//! Here nothing is reserved that the packed data could not fill, and memory is touched only where values are not 0.

use girtin_wash::Ledger;

mod error;
pub(crate) mod npy;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use error::StateFileError;
pub use read::{Limits, read, read_within};
pub use write::write;

/// An array of a state file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Key {
    WetMask,
    Height,
    U,
    V,
    Pressure,
    Saturation,
    Suspended,
    Deposited,
}

impl Key {
    /// In the order in which they are written.
    const ALL: [Self; 8] = [
        Self::WetMask,
        Self::Height,
        Self::U,
        Self::V,
        Self::Pressure,
        Self::Saturation,
        Self::Suspended,
        Self::Deposited,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::WetMask => "wet_mask",
            Self::Height => "height",
            Self::U => "u",
            Self::V => "v",
            Self::Pressure => "pressure",
            Self::Saturation => "saturation",
            Self::Suspended => "suspended",
            Self::Deposited => "deposited",
        }
    }

    /// Whether there is an array of the canvas for every pigment.
    fn is_of_pigments(self) -> bool {
        matches!(self, Self::Suspended | Self::Deposited)
    }

    /// Rows and columns of the array on a canvas of that many: faces are one more than cells.
    fn rows_and_columns(self, rows: usize, columns: usize) -> [usize; 2] {
        match self {
            Self::U => [rows, columns + 1],
            Self::V => [rows + 1, columns],
            _ => [rows, columns],
        }
    }
}

/// A number that a state of the living wash has besides its arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LedgerKey {
    CellsPerMm,
    ContactCarry,
    Evaporated,
    Blotted,
}

impl LedgerKey {
    /// In the order in which they are written.
    const ALL: [Self; 4] = [Self::CellsPerMm, Self::ContactCarry, Self::Evaporated, Self::Blotted];

    fn name(self) -> &'static str {
        match self {
            Self::CellsPerMm => "cells_per_mm",
            Self::ContactCarry => "contact_carry",
            Self::Evaporated => "evaporated",
            Self::Blotted => "blotted",
        }
    }

    fn of(self, ledger: &mut Ledger) -> &mut f64 {
        match self {
            Self::CellsPerMm => &mut ledger.cells_per_mm,
            Self::ContactCarry => &mut ledger.contact_carry,
            Self::Evaporated => &mut ledger.evaporated,
            Self::Blotted => &mut ledger.blotted,
        }
    }
}
