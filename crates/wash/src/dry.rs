//! Drying: where the film is gone the paper is no longer wet; its pigment settles and the last of its water soaks in.

use multiversion::multiversion;

use crate::region::Run;
use crate::settle::AroundRows;

/// When a film is gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vanishing {
    /// Film that is gone on paper of height 1.
    pub thinnest: f32,
    /// Beside film that stands higher than this a cell stays wet: it will be filled again.
    pub refilling: f32,
}

/// Appends the columns of one row where the film is gone.
pub fn vanished(
    gone: &mut Vec<usize>,
    film: &AroundRows<'_>,
    height: &[f32],
    vanishing: Vanishing,
    run: Run,
) {
    if !any_thin(film.here, film.mask, height, vanishing.thinnest, run) {
        return;
    }
    let wet = |film: &[f32], mask: &[u8], x: usize| if mask[x] != 0 { film[x] } else { 0.0 };
    let is_gone = |&x: &usize| {
        let is_thin = film.mask[x] != 0 && film.here[x] < vanishing.thinnest * height[x];
        let beside = wet(film.here, film.mask, x - 1).max(wet(film.here, film.mask, x + 1));
        let upright = wet(film.above, film.mask_above, x).max(wet(film.below, film.mask_below, x));
        is_thin && beside.max(upright) <= vanishing.refilling
    };
    gone.extend((run.first..run.end).filter(is_gone));
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn any_thin(film: &[f32], mask: &[u8], height: &[f32], thinnest: f32, run: Run) -> bool {
    let (first, n) = (run.first, run.len());
    let (p, m, h) = (&film[first..][..n], &mask[first..][..n], &height[first..][..n]);
    let mut any = 0u32;
    for i in 0..n {
        any |= u32::from((p[i] < thinnest * h[i]) & (m[i] != 0));
    }
    any != 0
}
