//! `TransferPigment`: pigment settles on the paper and is lifted off it again.

use multiversion::multiversion;

use crate::pigment::Exchange;
use crate::region::Run;

/// Exchanges pigment between the water and the paper of each wet cell of one row.
///
/// # Source
/// Curtis et al. 1997, §4.5, `TransferPigment`.
///
/// # Shapes and units
/// `suspended`, `deposited`: cells, amount of one pigment. `height`: cells, 0 < h < 1.
///
/// # Guarantees
/// suspended + deposited is kept to rounding (`pigment_is_kept`); both stay ≥ 0; dry cells are untouched.
///
/// # Deviations
/// None.
pub fn transfer(
    suspended: &mut [f32],
    deposited: &mut [f32],
    height: &[f32],
    mask: &[u8],
    exchange: Exchange,
    run: Run,
) {
    if run.all_wet {
        transfer_kernel::<true>(suspended, deposited, height, mask, exchange, run);
    } else {
        transfer_kernel::<false>(suspended, deposited, height, mask, exchange, run);
    }
}

/// What is in the water and on the paper of one cell, afterwards.
#[inline(always)]
pub fn exchanged(g: f32, d: f32, h: f32, exchange: Exchange) -> [f32; 2] {
    let Exchange { settling, lifting, granulation } = exchange;
    let down = g * (1.0 - h * granulation) * settling;
    let up = d * (1.0 + (h - 1.0) * granulation) * lifting;
    // Neither the water nor the paper takes more than 1. By `max`, for an `if` in an `if` becomes two masks.
    let room = (1.0 - d).max(0.0);
    let down = if d + down > 1.0 { room } else { down };
    let room = (1.0 - g).max(0.0);
    let up = if g + up > 1.0 { room } else { up };
    // Of the one goes what comes to the other.
    let net = down - up;
    let (settled, left) = (d + net, g - net);
    let settled = if settled > 0.0 { settled } else { 0.0 };
    let left = if left > 0.0 { left } else { 0.0 };
    [left, settled]
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn transfer_kernel<const ALL_WET: bool>(
    suspended: &mut [f32],
    deposited: &mut [f32],
    height: &[f32],
    mask: &[u8],
    exchange: Exchange,
    run: Run,
) {
    let (first, n) = (run.first, run.padded());
    let (g_beyond, d_beyond) = (run.beyond(suspended), run.beyond(deposited));
    let (g, d) = (&mut suspended[first..][..n], &mut deposited[first..][..n]);
    let (h, m) = (&height[first..][..n], &mask[first..][..n]);
    for i in 0..n {
        let [left, settled] = exchanged(g[i], d[i], h[i], exchange);
        d[i] = if ALL_WET || m[i] != 0 { settled } else { d[i] };
        g[i] = if ALL_WET || m[i] != 0 { left } else { g[i] };
    }
    if ALL_WET {
        g_beyond.put_back(suspended);
        d_beyond.put_back(deposited);
    }
}
