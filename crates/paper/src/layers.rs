//! What a sheet's relief is a sum of.
//!
//! Each layer is a function of position, in units of its own; [`crate::sheet`] brings it to mean 0 and
//! deviation 1 and adds it with its amount. In every layer high is up: a positive amount raises what the
//! layer is named for, a negative one presses it in.

mod fibers;
mod laid;
mod pebbles;
mod tooth;
mod weave;

pub use fibers::Fibers;
pub use laid::Laid;
pub use pebbles::Pebbles;
pub use tooth::Tooth;
pub use weave::Weave;

use crate::samples::{Ground, Patch};

/// One layer of a sheet's relief.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Layer {
    /// Soft irregular relief.
    Tooth(Tooth),
    /// Rounded bumps, or dimples.
    Pebbles(Pebbles),
    /// Lines of the mould.
    Laid(Laid),
    /// Threads over and under each other.
    Weave(Weave),
    /// Single fibers.
    Fibers(Fibers),
}

impl Layer {
    /// Its share of the relief; negative is upside down.
    pub fn amount(&self) -> f64 {
        match self {
            Self::Tooth(tooth) => tooth.amount,
            Self::Pebbles(pebbles) => pebbles.amount,
            Self::Laid(laid) => laid.amount,
            Self::Weave(weave) => weave.amount,
            Self::Fibers(fibers) => fibers.amount,
        }
    }

    /// Writes the layer's values at the points of `patch`, row after row. `number` is the layer's place in
    /// its recipe, so that two layers of a kind differ.
    pub(crate) fn fill(&self, ground: &Ground, number: usize, patch: &Patch, out: &mut [f32]) {
        debug_assert_eq!(out.len(), patch.x.count * patch.y.count);
        out.fill(0.0);
        match self {
            Self::Tooth(tooth) => tooth.fill(ground, number, patch, out),
            Self::Pebbles(pebbles) => pebbles.fill(ground, number, patch, out),
            Self::Laid(laid) => laid.fill(ground, number, patch, out),
            Self::Weave(weave) => weave.fill(ground, number, patch, out),
            Self::Fibers(fibers) => fibers.fill(ground, number, patch, out),
        }
    }
}

/// The rows of a patch: the number of each and its values.
fn rows<'a>(patch: &Patch, out: &'a mut [f32]) -> impl Iterator<Item = (usize, &'a mut [f32])> {
    out.chunks_exact_mut(patch.x.count.max(1)).enumerate()
}

/// A smooth ridge on 0..=1, from 0 over 1 back to 0, flat at both ends.
fn ridge(t: f32) -> f32 {
    let x = 2.0 * t - 1.0;
    let y = 1.0 - x * x;
    y * y
}

/// The larger of two numbers, rounded off where they differ by less than `soft` (above 0).
fn soft_max(a: f32, b: f32, soft: f32) -> f32 {
    let near = (soft - (a - b).abs()).max(0.0);
    a.max(b) + near * near / (4.0 * soft)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soft_max_is_the_larger_where_they_are_apart() {
        assert_eq!(soft_max(1.0, 3.0, 0.5), 3.0);
        assert_eq!(soft_max(2.0, 2.0, 0.4), 2.1);
    }

    #[test]
    fn a_ridge_starts_and_ends_flat() {
        assert_eq!((ridge(0.0), ridge(0.5), ridge(1.0)), (0.0, 1.0, 0.0));
    }
}
