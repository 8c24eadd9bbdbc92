//! Polynomials of the time: their values and slopes, and how far they reach.

/// Σ_{k≥1} x_k tᵏ and Σ_{k≥1} k x_k tᵏ⁻¹; x_k[i] is at (k − 1)d + i.
pub(super) fn polynomial(jet: &[f64], t: f64, change: &mut [f64], slope: &mut [f64]) {
    change.fill(0.0);
    slope.fill(0.0);
    for row in jet.chunks_exact(change.len()).rev() {
        for ((sum, slope), coefficient) in change.iter_mut().zip(&mut *slope).zip(row) {
            *slope = *slope * t + *sum;
            *sum = *sum * t + coefficient;
        }
    }
    for (sum, slope) in change.iter_mut().zip(slope) {
        *slope = *slope * t + *sum;
        *sum *= t;
    }
}

/// ρ e⁻² for ρ = q^(−1/n), the radius of convergence of Σ q_k tᵏ by its term n, to a few thousandths. Logarithm and
/// power are formed by parabolas between powers of 2.
pub(super) fn length(q: f64, n: usize) -> f64 {
    // NaN, of a field that is 0, and 0 itself are below all others.
    let bits = q.max(0.0).to_bits();
    let mantissa = f64::from_bits(bits & ((1 << 52) - 1) | 1.0_f64.to_bits());
    let fraction = (2.024_658 - 0.344_845 * mantissa) * mantissa - 1.674_873;
    let logarithm = (bits >> 52) as f64 - 1023.0 + fraction;
    let power = -logarithm / n as f64 - 2.0 * std::f64::consts::LOG2_E;
    let whole = libm::floor(power);
    let rest = power - whole;
    let fraction = (0.337_189 * rest + 0.657_636) * rest + 1.001_725;
    fraction * f64::from_bits(((whole.clamp(-1022.0, 1023.0) + 1023.0) as u64) << 52)
}

/// The upper half of a double's digits.
pub(super) fn short(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & !((1 << 29) - 1))
}

/// The power of 2 in a length of time, as the unit that a series is written in: it changes no digit of a coefficient.
pub(super) fn unit(time: f64) -> f64 {
    let power = f64::from_bits(time.to_bits() & (2047 << 52));
    if power.is_normal() { power } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::{length, polynomial, short, unit};

    /// Parabolas that err by 0.005 in log₂ q and by 0.2 % in 2ʸ: together 0.2 % and 0.35 %/n.
    #[test]
    fn lengths_are_those_of_the_formula() {
        for n in [2, 3, 7, 20] {
            for k in -900..900 {
                let q = libm::exp2(0.37 * f64::from(k));
                let exact = libm::pow(q, -1.0 / n as f64) * libm::exp(-2.0);
                let off = (length(q, n) / exact - 1.0).abs();
                assert!(off < 0.002 + 0.0036 / n as f64, "{q:e}, {n}: {off:e}");
            }
        }
        assert!(length(0.0, 20) > 1e12 && length(f64::NAN, 2) > 1e12);
    }

    /// Differences of a time and a length are exact as long as it is over 2⁻²⁸ of it.
    #[test]
    fn short_lengths_are_subtracted_exactly() {
        for k in 1..1000 {
            let (time, own) = (
                200.0 + libm::sin(f64::from(k)),
                short(libm::exp(-f64::from(k % 13))),
            );
            let rest = time - own;
            assert_eq!((time - rest).to_bits(), own.to_bits());
        }
    }

    #[test]
    fn units_are_powers_of_two() {
        for (time, expected) in [(0.1, 0.0625), (-0.1, 0.0625), (1.0, 1.0), (7.9, 4.0)] {
            assert_eq!(unit(time), expected);
        }
        for k in -300..300 {
            let time = libm::pow(10.0, f64::from(k));
            assert!((1.0..2.0).contains(&(time / unit(time))), "{time:e}");
        }
        // Times that are not there, or that no series is written for.
        for time in [0.0, f64::NAN, f64::INFINITY, 5e-324] {
            assert_eq!(unit(time), 1.0, "{time:e}");
        }
    }

    /// 3t + 5t² − 2t³ and −t³, with 3 + 10t − 6t² and −3t².
    #[test]
    fn slopes_are_derivatives() {
        let jet = [3.0, 0.0, 5.0, 0.0, -2.0, -1.0];
        let (mut change, mut slope) = ([0.0; 2], [0.0; 2]);
        for t in [-1.5, 0.0, 0.25, 2.0] {
            polynomial(&jet, t, &mut change, &mut slope);
            assert_eq!(change, [((-2.0 * t + 5.0) * t + 3.0) * t, -t * t * t]);
            assert_eq!(slope, [(-6.0 * t + 10.0) * t + 3.0, -3.0 * t * t]);
        }
    }
}
