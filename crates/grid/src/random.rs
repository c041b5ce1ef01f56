//! Numbers that are a function of (seed, stage, place).
//!
//! Nothing here has a state: a random number is asked for by naming what it is for. So it does not matter in
//! which order, or on how many threads, cells are visited, and a picture does not change when another stage
//! draws more.
//!
//! ```
//! use girtin_grid::random::{hash, stage, unit_f64};
//!
//! const JITTER: u64 = stage("jitter");
//! let shift = unit_f64(hash(7, JITTER, [3, -2], 0));
//! assert_eq!(shift, unit_f64(hash(7, JITTER, [3, -2], 0)));
//! assert!((0.0..1.0).contains(&shift));
//! ```

/// 2^64 over the golden ratio, made odd: the increment of SplitMix64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection of 64 bits in which every bit of the argument changes every bit of the result half of the
/// time.
///
/// # Source
/// The finaliser of SplitMix64: Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, 2014,
/// with the constants of David Stafford's "Mix13".
#[inline]
pub const fn mix(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// `key` with one more word in it; the order of the words matters.
#[inline]
pub const fn fold(key: u64, word: u64) -> u64 {
    mix(key.wrapping_add(GOLDEN) ^ word)
}

/// The number of a stage, from its name: FNV-1a, mixed.
///
/// Names, so that two stages cannot take the same number by accident, and none changes when another is added.
pub const fn stage(name: &str) -> u64 {
    let bytes = name.as_bytes();
    let mut bits = 0xcbf2_9ce4_8422_2325;
    let mut at = 0;
    while at < bytes.len() {
        bits = (bits ^ bytes[at] as u64).wrapping_mul(0x0100_0000_01b3);
        at += 1;
    }
    mix(bits)
}

/// The key of one stage under one seed, for [`at`].
#[inline]
pub const fn key(seed: u64, stage: u64) -> u64 {
    fold(fold(0, seed), stage)
}

/// 64 random bits of a cell under a [`key`].
#[inline]
pub const fn at(key: u64, cell: [i64; 2]) -> u64 {
    fold(fold(key, cell[0] as u64), cell[1] as u64)
}

/// 64 random bits, a function of all its arguments.
#[inline]
pub const fn hash(seed: u64, stage: u64, cell: [i64; 2], step: u64) -> u64 {
    fold(at(key(seed, stage), cell), step)
}

/// A number in [0, 1), a multiple of 2^-53, from 64 random bits.
#[inline]
pub const fn unit_f64(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A number in [0, 1), a multiple of 2^-24, from 64 random bits.
#[inline]
pub const fn unit_f32(bits: u64) -> f32 {
    (bits >> 40) as f32 * (1.0 / (1u32 << 24) as f32)
}

/// A number from `low` up to `high`, from 64 random bits; `high` itself only by rounding.
#[inline]
pub const fn between(bits: u64, low: f64, high: f64) -> f64 {
    low + (high - low) * unit_f64(bits)
}

/// A whole number below `count`, from 64 random bits; 0 when `count` is 0.
///
/// The share of each number is off by at most `count` / 2^64.
#[inline]
pub const fn below(bits: u64, count: u64) -> u64 {
    ((bits as u128 * count as u128) >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixing_keeps_the_published_values() {
        // SplitMix64 from seed 0: the state after its first step is the increment.
        assert_eq!(mix(GOLDEN), 0xe220_a839_7b1d_cdaf);
        assert_eq!(mix(GOLDEN.wrapping_mul(2)), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn every_argument_matters_and_so_does_their_order() {
        let one = hash(1, stage("a"), [2, 3], 4);
        for other in [
            hash(2, stage("a"), [2, 3], 4),
            hash(1, stage("b"), [2, 3], 4),
            hash(1, stage("a"), [3, 2], 4),
            hash(1, stage("a"), [-2, 3], 4),
            hash(1, stage("a"), [2, 3], 5),
        ] {
            assert_ne!(one, other);
        }
    }

    #[test]
    fn neighbouring_cells_are_independent_and_uniform() {
        let key = key(0, stage("uniform"));
        let side = 256;
        let value = |x: i64, y: i64| unit_f64(at(key, [x, y])) - 0.5;
        let (mut sum, mut square, mut right, mut below) = (0.0, 0.0, 0.0, 0.0);
        for y in 0..side {
            for x in 0..side {
                let v = value(x, y);
                sum += v;
                square += v * v;
                right += v * value(x + 1, y);
                below += v * value(x, y + 1);
            }
        }
        let cells = (side * side) as f64;
        // Four standard errors of each mean: 0.289, 0.0745 and 1/12 over the root of 65536.
        assert!((sum / cells).abs() < 0.0046, "mean {}", sum / cells);
        assert!((square / cells - 1.0 / 12.0).abs() < 0.0012, "variance {}", square / cells);
        assert!((right / cells).abs() < 0.0014 && (below / cells).abs() < 0.0014);
    }

    #[test]
    fn one_bit_in_changes_half_of_the_bits_out() {
        let mut changed = 0;
        for bit in 0..64 {
            for word in 0..64 {
                changed += (fold(9, word) ^ fold(9, word ^ (1 << bit))).count_ones();
            }
        }
        let mean = f64::from(changed) / 4096.0;
        assert!((mean - 32.0).abs() < 0.5, "{mean} bits");
    }

    #[test]
    fn numbers_stay_in_their_ranges_at_the_extremes() {
        assert_eq!(unit_f64(0), 0.0);
        assert!(unit_f64(u64::MAX) < 1.0);
        assert!(unit_f32(u64::MAX) < 1.0);
        assert_eq!(below(u64::MAX, 6), 5);
        assert_eq!(below(u64::MAX, 0), 0);
        assert_eq!(between(0, -2.0, 3.0), -2.0);
    }
}
