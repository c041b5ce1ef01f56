//! `SimulateCapillaryFlow`: water soaks into the paper, creeps through its pores and wets new cells.

use multiversion::multiversion;

use crate::params::{Capillary, LivingParams};
use crate::region::Run;

/// The capillary layer's numbers as the kernels need them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pores {
    absorption: f32,
    min_diffusing: f32,
    min_receiving: f32,
    wetting_threshold: f32,
    least: f32,
    range: f32,
    /// Part of a difference that flows in a pass: a quarter is the limit of stability.
    part: f32,
}

impl Pores {
    /// The pores of the living wash; each of `passes` moves as much as that many in a step should.
    pub fn living(params: &LivingParams, part: f64) -> Self {
        let [least, most] = params.capacity;
        Self {
            absorption: params.absorption as f32,
            min_diffusing: params.min_diffusing as f32,
            min_receiving: params.min_receiving as f32,
            wetting_threshold: f32::INFINITY,
            least: least as f32,
            range: (most - least) as f32,
            part: part as f32,
        }
    }

    /// How much water paper of this height holds.
    #[inline(always)]
    pub fn capacity(&self, height: f32) -> f32 {
        height * self.range + self.least
    }
}

impl From<&Capillary> for Pores {
    fn from(capillary: &Capillary) -> Self {
        let [least, most] = capillary.capacity;
        Self {
            absorption: capillary.absorption as f32,
            min_diffusing: capillary.min_diffusing as f32,
            min_receiving: capillary.min_receiving as f32,
            wetting_threshold: capillary.wetting_threshold as f32,
            least: least as f32,
            range: (most - least) as f32,
            part: 0.25,
        }
    }
}

/// Wet cells of one row soak water into the paper.
///
/// # Source
/// Curtis et al. 1997, §4.6, `SimulateCapillaryFlow`, first loop; capacity c = h(c_max − c_min) + c_min, §4.1.
///
/// # Shapes and units
/// Field rows; `saturation` and capacity in the same amount of water.
///
/// # Guarantees
/// A cell never soaks up more than its capacity; dry cells are untouched.
pub fn absorb(saturation: &mut [f32], height: &[f32], mask: &[u8], pores: &Pores, run: Run) {
    absorb_kernel(saturation, height, mask, *pores, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn absorb_kernel(saturation: &mut [f32], height: &[f32], mask: &[u8], pores: Pores, run: Run) {
    let (first, n) = (run.first, run.len());
    let (s, h, m) = (&mut saturation[first..][..n], &height[first..][..n], &mask[first..][..n]);
    for i in 0..n {
        let room = pores.capacity(h[i]) - s[i];
        let soaked = if room < pores.absorption { room } else { pores.absorption };
        let soaked = if soaked > 0.0 { soaked } else { 0.0 };
        s[i] = if m[i] != 0 { s[i] + soaked } else { s[i] };
    }
}

/// Wet cells of one row soak film into the paper: what the pores gain the film loses.
///
/// Returns the bits of the thinnest film that is left, and whether any pores had room.
///
/// # Shapes and units
/// Field rows; `depth` is the film that one unit of saturation makes.
///
/// # Guarantees
/// Neither pores nor film give or take more than they can; dry cells are untouched.
pub fn absorb_film(
    saturation: &mut [f32],
    film: &mut [f32],
    height: &[f32],
    mask: &[u8],
    pores: &Pores,
    depth: f32,
    run: Run,
) -> (i32, bool) {
    absorb_film_kernel(saturation, film, height, mask, *pores, depth, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn absorb_film_kernel(
    saturation: &mut [f32],
    film: &mut [f32],
    height: &[f32],
    mask: &[u8],
    pores: Pores,
    depth: f32,
    run: Run,
) -> (i32, bool) {
    let (first, n) = (run.first, run.len());
    let (s, p) = (&mut saturation[first..][..n], &mut film[first..][..n]);
    let (h, m) = (&height[first..][..n], &mask[first..][..n]);
    let per_depth = 1.0 / depth;
    let (mut thinnest, mut roomy) = (i32::MAX, 0u32);
    for i in 0..n {
        let smaller = |a: f32, b: f32| if a < b { a } else { b };
        let room = pores.capacity(h[i]) - s[i];
        let soaked = smaller(smaller(room, pores.absorption), p[i] * per_depth);
        let soaked = if soaked > 0.0 { soaked } else { 0.0 };
        let filled = s[i] + soaked;
        let left = p[i] - depth * (filled - s[i]);
        // Rounding may undercut 0 by a unit; a film that was below 0 stays.
        let floor = smaller(p[i], 0.0);
        let left = if left < floor { floor } else { left };
        let is_wet = m[i] != 0;
        s[i] = if is_wet { filled } else { s[i] };
        p[i] = if is_wet { left } else { p[i] };
        let seen = if is_wet { left.to_bits() as i32 } else { i32::MAX };
        thinnest = if seen < thinnest { seen } else { thinnest };
        roomy |= u32::from(is_wet & (room > 0.0));
    }
    (thinnest, roomy != 0)
}

/// Saturation and paper height of a row and its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct PoreRows<'a> {
    /// Saturation above.
    pub above: &'a [f32],
    /// Saturation here.
    pub here: &'a [f32],
    /// Saturation below.
    pub below: &'a [f32],
    /// Height above.
    pub height_above: &'a [f32],
    /// Height here.
    pub height: &'a [f32],
    /// Height below.
    pub height_below: &'a [f32],
}

/// Water creeps between the cells of one row and their neighbours.
///
/// # Source
/// Curtis et al. 1997, §4.6, `SimulateCapillaryFlow`, second loop, gathered by face.
///
/// # Shapes and units
/// Field rows; `saturation` receives the new amounts.
///
/// # Guarantees
/// What leaves a cell enters its neighbour, from the same rounded amount (`pore_water_is_kept`).
///
/// # Deviations
/// D5.
pub fn diffuse(saturation: &mut [f32], old: &PoreRows<'_>, pores: &Pores, run: Run) {
    diffuse_kernel(saturation, old, *pores, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn diffuse_kernel(saturation: &mut [f32], old: &PoreRows<'_>, pores: Pores, run: Run) {
    let (first, n) = (run.first, run.len());
    let out = &mut saturation[first..][..n];
    let s = &old.here[first - 1..][..n + 2];
    let h = &old.height[first - 1..][..n + 2];
    let (above, below) = (&old.above[first..][..n], &old.below[first..][..n]);
    let (h_above, h_below) = (&old.height_above[first..][..n], &old.height_below[first..][..n]);
    // What flows from a cell holding `from` to a neighbour holding `to` with capacity `room` + `to`.
    let creep = |from: f32, to: f32, height: f32| {
        let (excess, room) = (from - to, pores.capacity(height) - to);
        let flow = (if excess < room { excess } else { room }) * pores.part;
        let flows = (from > pores.min_diffusing) & (from > to) & (to > pores.min_receiving) & (flow > 0.0);
        if flows { flow } else { 0.0 }
    };
    for i in 0..n {
        let here = s[i + 1];
        let gain =
            |there: f32, its_height: f32| creep(there, here, h[i + 1]) - creep(here, there, its_height);
        let sideways = gain(s[i], h[i]) + gain(s[i + 2], h[i + 2]);
        let upright = gain(above[i], h_above[i]) + gain(below[i], h_below[i]);
        out[i] = here + (sideways + upright);
    }
}

/// How full the pores of each cell of one row are.
///
/// # Shapes and units
/// Field rows; `fill` is saturation over capacity.
pub fn fill(fill: &mut [f32], saturation: &[f32], height: &[f32], pores: &Pores, run: Run) {
    fill_kernel(fill, saturation, height, *pores, run);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn fill_kernel(fill: &mut [f32], saturation: &[f32], height: &[f32], pores: Pores, run: Run) {
    let (first, n) = (run.first, run.len());
    let fill = &mut fill[first..][..n];
    let (s, h) = (&saturation[first..][..n], &height[first..][..n]);
    for i in 0..n {
        fill[i] = s[i] / pores.capacity(h[i]);
    }
}

/// How full the pores of a row and its neighbours are.
#[derive(Clone, Copy, Debug)]
pub struct FillRows<'a> {
    /// Above.
    pub above: &'a [f32],
    /// Here.
    pub here: &'a [f32],
    /// Below.
    pub below: &'a [f32],
}

/// [`diffuse`] of the living wash: the fuller the pores, the better they conduct.
///
/// Without that, the paper beside a stroke changes abruptly at the least damp from holding its edge to drawing it out.
/// Returns whether any amount changed.
///
/// # Source
/// Conductivity of unsaturated soil falls with a high power of its saturation; the fourth of the two cells' mean here.
///
/// # Guarantees
/// What leaves a cell enters its neighbour, from the same rounded amount.
pub fn diffuse_conducting(
    saturation: &mut [f32],
    old: &PoreRows<'_>,
    fill: &FillRows<'_>,
    pores: &Pores,
    run: Run,
) -> bool {
    diffuse_conducting_kernel(saturation, old, fill, *pores, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn diffuse_conducting_kernel(
    saturation: &mut [f32],
    old: &PoreRows<'_>,
    fill: &FillRows<'_>,
    pores: Pores,
    run: Run,
) -> bool {
    let (first, n) = (run.first, run.len());
    let out = &mut saturation[first..][..n];
    let s = &old.here[first - 1..][..n + 2];
    let h = &old.height[first - 1..][..n + 2];
    let f = &fill.here[first - 1..][..n + 2];
    let (above, below) = (&old.above[first..][..n], &old.below[first..][..n]);
    let (h_above, h_below) = (&old.height_above[first..][..n], &old.height_below[first..][..n]);
    let (f_above, f_below) = (&fill.above[first..][..n], &fill.below[first..][..n]);
    let mut changed = 0;
    for i in 0..n {
        let here = [s[i + 1], h[i + 1], f[i + 1]];
        let sideways =
            gain(&pores, here, [s[i], h[i], f[i]]) + gain(&pores, here, [s[i + 2], h[i + 2], f[i + 2]]);
        let upright = gain(&pores, here, [above[i], h_above[i], f_above[i]])
            + gain(&pores, here, [below[i], h_below[i], f_below[i]]);
        let now = here[0] + (sideways + upright);
        changed |= now.to_bits() ^ here[0].to_bits();
        out[i] = now;
    }
    changed != 0
}

/// What a cell gains from a neighbour, or loses to it; each is its saturation, height and fill.
#[inline(always)]
fn gain(pores: &Pores, [s, h, f]: [f32; 3], [s_there, h_there, f_there]: [f32; 3]) -> f32 {
    let inward = s_there > s;
    let (from, to) = if inward { (s_there, s) } else { (s, s_there) };
    let (excess, room) = (from - to, pores.capacity(if inward { h } else { h_there }) - to);
    let flow = (if excess < room { excess } else { room }) * pores.part;
    let full = 0.5 * (f + f_there);
    let full = if full < 1.0 { full } else { 1.0 };
    let full = full * full;
    let flow = flow * (full * full);
    let flows = (from > pores.min_diffusing) & (to > pores.min_receiving) & (flow > 0.0);
    let flow = if flows { flow } else { 0.0 };
    if inward { flow } else { -flow }
}

/// Cells of one row whose paper is full enough become wet; returns whether any did.
///
/// # Source
/// Curtis et al. 1997, §4.6, `SimulateCapillaryFlow`, third loop.
pub fn spread(mask: &mut [u8], saturation: &[f32], pores: &Pores, run: Run) -> bool {
    spread_kernel(mask, saturation, pores.wetting_threshold, run)
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn spread_kernel(mask: &mut [u8], saturation: &[f32], threshold: f32, run: Run) -> bool {
    let (first, n) = (run.first, run.len());
    let (m, s) = (&mut mask[first..][..n], &saturation[first..][..n]);
    let mut grown = 0;
    for i in 0..n {
        let wet = u8::from(s[i] > threshold);
        grown |= wet & !m[i];
        m[i] |= wet;
    }
    grown != 0
}
