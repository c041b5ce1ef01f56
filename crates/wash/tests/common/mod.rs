//! What the tests of both models need.

use girtin_grid::Layout;
use girtin_wash::WashState;

/// A number in 0..1 that looks random and depends on nothing but its arguments.
pub fn random(seed: u64, a: usize, b: usize) -> f32 {
    let mut x = seed ^ (a as u64) << 32 ^ b as u64;
    for _ in 0..3 {
        x = (x ^ (x >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x ^= x >> 29;
    }
    (x >> 40) as f32 / (1u64 << 24) as f32
}

/// The bits of every field of the canvas, named.
fn bits(state: &WashState) -> Vec<(&'static str, Vec<u32>)> {
    let height = state.layout().height();
    let mut all = vec![(
        "wet_mask",
        (0..height).flat_map(|y| state.wet_mask.cells(y).iter().map(|&m| u32::from(m))).collect(),
    )];
    let fields =
        [("u", &state.u), ("v", &state.v), ("pressure", &state.pressure), ("saturation", &state.saturation)];
    let pigments = state
        .suspended
        .iter()
        .map(|g| ("suspended", g))
        .chain(state.deposited.iter().map(|d| ("deposited", d)));
    for (name, field) in fields.into_iter().chain(pigments) {
        all.push((name, (0..=height).flat_map(|y| field.faces_or_border(y)).collect()));
    }
    all
}

trait AllBits {
    fn faces_or_border(&self, y: usize) -> Vec<u32>;
}

impl AllBits for girtin_grid::Field<f32> {
    fn faces_or_border(&self, y: usize) -> Vec<u32> {
        self.row(Layout::TOP + y)[Layout::LEFT..][..self.layout().width() + 1]
            .iter()
            .map(|x| x.to_bits())
            .collect()
    }
}

/// Fails where two states differ in a bit.
pub fn same(a: &WashState, b: &WashState, what: &str) {
    for ((name, a), (_, b)) in bits(a).iter().zip(&bits(b)) {
        let at = a.iter().zip(b).position(|(a, b)| a != b);
        assert_eq!(
            at,
            None,
            "{what}: `{name}` differs: {:?}",
            at.map(|i| (f32::from_bits(a[i]), f32::from_bits(b[i])))
        );
    }
}
