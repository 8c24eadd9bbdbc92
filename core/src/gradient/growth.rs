//! How fast derivatives grow, and what that leaves of their digits.

use std::fmt;

/// Fewer decimal digits than these are a warning.
const DIGITS: f64 = 6.0;

/// By how much vectors, or covectors, grew over a time.
///
/// The derivatives of a map at the states of a run are those of a trajectory within rounding of the exact one.
/// Relative to their size they are wrong by about e^g u, u the unit roundoff. Along regular motions e^g grows like t,
/// along chaotic ones like e^{λt} with the largest Lyapunov exponent λ. After t = ln(1/u)/λ ≈ 37/λ no digit of a
/// gradient is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// g: ln of the largest norm on the way over the norms that were given.
    pub logarithm: f64,
    /// t, positive.
    pub time: f64,
}

impl Growth {
    /// g/t, which tends to the largest Lyapunov exponent; 0 over no time.
    pub fn rate(self) -> f64 {
        if self.time > 0.0 {
            self.logarithm / self.time
        } else {
            0.0
        }
    }

    /// The decimal digits left, −log₁₀(e^g u): 16 at most, negative where none is.
    pub fn digits(self) -> f64 {
        -(self.logarithm.max(0.0) + libm::log(f64::EPSILON / 2.0)) / std::f64::consts::LN_10
    }

    /// Whether so few digits are left that whoever uses the derivative should know.
    pub fn is_large(self) -> bool {
        self.logarithm.is_nan() || self.digits() < DIGITS
    }
}

impl fmt::Display for Growth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (factor, time) = (self.logarithm / std::f64::consts::LN_10, self.time);
        write!(
            f,
            "derivatives grew by 10^{factor:.1} over t = {time}, as e^({:.1e} t): ",
            self.rate()
        )?;
        match self.digits() {
            digits if digits >= 1.0 => write!(f, "about {digits:.0} digits of them are right")?,
            _ => write!(f, "no digit of them is right, as in chaotic motion")?,
        }
        match self.is_large() {
            true => write!(f, "; take a shorter run"),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Growth;

    #[test]
    fn digits_are_those_of_a_double_less_those_of_the_growth() {
        let growth = |logarithm: f64| Growth {
            logarithm,
            time: 10.0,
        };
        for (factor, digits) in [(1e-3, 15.95), (1.0, 15.95), (1e4, 11.95), (1e20, -4.05)] {
            let found = growth(libm::log(factor)).digits();
            assert!((found - digits).abs() < 0.01, "{factor}: {found}");
        }
        assert!(!growth(libm::log(8e9)).is_large() && growth(libm::log(1e10)).is_large());
        assert!(growth(f64::NAN).is_large() && growth(f64::INFINITY).is_large());
        assert_eq!(growth(20.0).rate(), 2.0);
    }

    #[test]
    fn words_say_what_is_left_and_what_to_do() {
        let growth = |logarithm: f64| Growth {
            logarithm,
            time: 100.0,
        };
        let all = [10.0, 30.0, 50.0].map(|logarithm| growth(logarithm).to_string());
        assert_eq!(
            all[0],
            "derivatives grew by 10^4.3 over t = 100, as e^(1.0e-1 t): about 12 digits of them are right"
        );
        assert!(all[1].ends_with("about 3 digits of them are right; take a shorter run"));
        assert!(all[2].contains("no digit of them is right"));
    }
}
