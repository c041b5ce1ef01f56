//! What is known of whole rows of a living wash, so that work which would change nothing is left out.
//!
//! Most of a wash, most of the time, is a film deep enough to flow freely over pores that are full: there mobility is 1,
//! nothing settles and nothing soaks in or creeps. Every fact here is such that the work it saves would have left every
//! bit as it is. A fact is written by the band that owns the row and read by any in later passes only.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering::Relaxed};

/// Facts of all rows of a pool.
#[derive(Debug)]
pub struct RowFacts {
    /// Bits of the thinnest film of each row, as of the last pass that dried or soaked it; minimal where not known.
    thinnest: Vec<AtomicI32>,
    /// Mobility was last found when the film here and above was deep.
    free: Vec<AtomicBool>,
    /// All damp cells are under film.
    full: Vec<AtomicBool>,
    /// The cover is known to be 1 in all runs.
    covered: Vec<AtomicBool>,
    /// Pore water changed in this step, or may in the next.
    stirred: Vec<AtomicBool>,
    /// No pore water changes in this step.
    quiet: Vec<bool>,
}

/// A film that is not known: thinner than any.
const UNKNOWN: i32 = i32::MIN;

impl RowFacts {
    /// Nothing is known of so many rows.
    pub fn new(rows: usize) -> Self {
        let flags = |value: bool| (0..rows).map(|_| AtomicBool::new(value)).collect();
        Self {
            thinnest: (0..rows).map(|_| AtomicI32::new(UNKNOWN)).collect(),
            free: flags(false),
            full: flags(false),
            covered: flags(false),
            stirred: flags(true),
            quiet: vec![false; rows],
        }
    }

    /// Cells of the row became wet or dry, or their film was changed by more than a pass.
    pub fn forget(&self, row: usize) {
        self.thinnest[row].store(UNKNOWN, Relaxed);
        self.free[row].store(false, Relaxed);
        self.covered[row].store(false, Relaxed);
        self.stirred[row].store(true, Relaxed);
        // The faces above the row below are between both.
        if let Some(below) = self.free.get(row + 1) {
            below.store(false, Relaxed);
        }
    }

    /// Notes the thinnest film of a row.
    pub fn note_thinnest(&self, row: usize, bits: i32) {
        self.thinnest[row].store(bits, Relaxed);
    }

    /// The thinnest film of a row; below 0 if it is not known.
    pub fn thinnest(&self, row: usize) -> f32 {
        match self.thinnest[row].load(Relaxed) {
            UNKNOWN => -1.0,
            bits => f32::from_bits(bits as u32),
        }
    }

    /// Whether the mobility that was last found for a row is still that of deep film.
    pub fn is_free(&self, row: usize) -> bool {
        self.free[row].load(Relaxed)
    }

    /// Notes whether mobility was found under deep film.
    pub fn note_free(&self, row: usize, is_free: bool) {
        self.free[row].store(is_free, Relaxed);
    }

    /// Whether all damp cells of a row are under film.
    pub fn is_full(&self, row: usize) -> bool {
        self.full[row].load(Relaxed)
    }

    /// Notes whether all damp cells of a row are under film.
    pub fn note_full(&self, row: usize, is_full: bool) {
        self.full[row].store(is_full, Relaxed);
    }

    /// Whether the cover of a full row is known.
    pub fn is_covered(&self, row: usize) -> bool {
        self.covered[row].load(Relaxed)
    }

    /// Whether the cover of all of these rows is known.
    pub fn are_covered(&self, mut rows: Range<usize>) -> bool {
        rows.all(|row| self.is_full(row) && self.is_covered(row))
    }

    /// Notes that the cover of a full row is known.
    pub fn note_covered(&self, row: usize) {
        self.covered[row].store(true, Relaxed);
    }

    /// Notes that pore water of a row changed, or that film could soak in.
    pub fn note_stirred(&self, row: usize) {
        self.stirred[row].store(true, Relaxed);
    }

    /// Whether no pore water of a row changes in this step.
    pub fn is_quiet(&self, row: usize) -> bool {
        self.quiet[row]
    }

    /// Begins a step with so many passes over the pores: rows are quiet that nothing stirred as far as water may come.
    pub fn settle_down(&mut self, active: Range<usize>, passes: usize) {
        self.quiet.fill(false);
        let mut calm = 0;
        // `calm` rows up to the one at hand were not stirred.
        for row in active.start..active.end + passes {
            let is_stirred = row < active.end && (self.stirred[row].load(Relaxed) || !self.is_full(row));
            calm = if is_stirred { 0 } else { calm + 1 };
            let middle = row.checked_sub(passes).filter(|middle| active.contains(middle));
            // Beyond the first active row there is nothing to stir.
            if let Some(middle) = middle {
                self.quiet[middle] = calm > (2 * passes).min(row - active.start);
            }
        }
        for row in active {
            self.stirred[row].store(false, Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_quiet_where_nothing_is_stirred_as_far_as_water_may_come() {
        for passes in 1..4 {
            let mut facts = RowFacts::new(40);
            (0..40).for_each(|row| facts.note_full(row, true));
            facts.settle_down(5..30, passes);
            assert!((0..40).all(|row| !facts.is_quiet(row)), "nothing is known at first");
            facts.note_stirred(17);
            facts.settle_down(5..30, passes);
            for row in 5..30 {
                assert_eq!(facts.is_quiet(row), row.abs_diff(17) > passes, "row {row}, {passes} passes");
            }
            facts.settle_down(5..30, passes);
            assert!((5..30).all(|row| facts.is_quiet(row)));
        }
    }
}
