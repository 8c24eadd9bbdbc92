//! The Euclidean norm.

/// ‖a − b‖, the Euclidean norm; in units of the largest difference, so that nothing overflows.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    norm_of(a.iter().zip(b).map(|(a, b)| a - b))
}

/// ‖a‖.
pub(super) fn norm(a: &[f64]) -> f64 {
    norm_of(a.iter().copied())
}

fn norm_of(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = values.clone().fold(0.0_f64, |m, v| {
        if m.is_nan() || v.is_nan() {
            f64::NAN
        } else {
            m.max(v.abs())
        }
    });
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * libm::sqrt(values.map(|v| v / largest * (v / largest)).sum())
}

#[cfg(test)]
mod tests {
    use super::distance;

    #[test]
    fn distances_neither_overflow_nor_lose_what_is_not_a_number() {
        // A quotient, a product, a sum, a root and a product, each rounded once.
        for size in [1e200, 1e-200] {
            let found = distance(&[3.0 * size, 4.0 * size], &[0.0, 0.0]);
            assert!(
                (found / (5.0 * size) - 1.0).abs() <= 4.0 * f64::EPSILON,
                "{found:e}"
            );
        }
        assert_eq!(distance(&[1.0], &[1.0]), 0.0);
        assert!(distance(&[f64::NAN, 1.0], &[0.0, 0.0]).is_nan());
        assert!(distance(&[1.0, f64::NAN, 2.0], &[0.0; 3]).is_nan());
    }
}
