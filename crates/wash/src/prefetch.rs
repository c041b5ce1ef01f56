//! Asks for the memory of rows that will be needed soon.
//!
//! The processor foresees a walk along a row, but not a jump to the next row of a narrow stroke, which lies pages away.
//! Asking two rows ahead hides that: scattered strokes cost 1.5 to 2 times less. Rows wider than [`FORESEEN`] are left
//! to the processor, which does better alone.

#![expect(unsafe_code, reason = "the prefetch instruction is only offered as an unsafe function")]

use crate::region::Run;

/// Cells of a run from which on the processor needs no help.
const FORESEEN: usize = 384;
/// Values in a line of cache.
const LINE: usize = 16;

/// Asks for the runs of one row of a field.
pub fn runs(row: &[f32], runs: &[Run]) {
    for run in runs.iter().filter(|run| run.len() < FORESEEN) {
        for value in row[run.first..run.end].iter().step_by(LINE) {
            line(value);
        }
    }
}

fn line(value: &f32) {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    // SAFETY: the instruction is a hint: it changes no memory and faults on no address, and this one is valid.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast());
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    let _ = value;
}
