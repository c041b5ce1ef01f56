//! Separable Gaussian weights.

/// Normalised weights of a Gaussian of standard deviation `sigma` at the whole numbers −radius…radius.
///
/// `sigma` 0 gives all the weight to the middle.
pub fn gaussian_weights(sigma: f64, radius: usize) -> Vec<f32> {
    let weight = |tap: usize| {
        let distance = tap.abs_diff(radius) as f64;
        if sigma > 0.0 {
            libm::exp(-distance * distance / (2.0 * sigma * sigma))
        } else {
            f64::from(u8::from(tap == radius))
        }
    };
    let weights: Vec<f64> = (0..=2 * radius).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| (weight / sum) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_symmetric_and_sum_to_one() {
        let weights = gaussian_weights(2.5, 5);
        assert_eq!(weights.len(), 11);
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        assert!(weights.iter().eq(weights.iter().rev()));
        assert_eq!(gaussian_weights(0.0, 1), [0.0, 1.0, 0.0]);
    }
}
