//! What a brush leaves where it goes: marks at any resolution.

mod mark;

pub use mark::{PlannedMark, Touch};

/// Hermite's step from 0 at `low` to 1 at `high`, which may be below `low`.
pub(crate) fn smoothstep(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
