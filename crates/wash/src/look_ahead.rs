//! Asks for rows that a pass will come to, so that it waits less for memory.

use multiversion::multiversion;
use multiversion::target::match_target;

use crate::region::VECTOR;

/// Asks for the lines of memory that hold some values; reads and changes nothing. Does nothing on processors other than x86-64
/// with AVX2.
///
/// Not into the nearest cache: the rows to come of all pigments would push out of it what is at hand, and half of the gain.
#[multiversion(targets("x86_64+avx2"))]
pub fn look_ahead(values: &[f32]) {
    match_target! {
        "x86_64+avx2" => {
            use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
            for line in values.chunks(VECTOR) {
                _mm_prefetch::<_MM_HINT_T1>(line.as_ptr().cast());
            }
        },
        _ => {
            let _ = (values, VECTOR);
        },
    }
}
