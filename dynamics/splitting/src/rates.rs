//! Rates of exponentials that are multiples of one.

use leafwise_expression::{Polynomial, Rational};

/// A rate as a small multiple of another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Multiple {
    /// The number of the other rate, or its own.
    pub(crate) of: usize,
    /// 1, −1, 2 or −2.
    pub(crate) factor: i64,
}

/// Each of the `rates` as a multiple of one of them, twice it where there is such a one. From these
/// follow e^{2z} − 1 = u(2 + u) with u = eᶻ − 1 and the mirrored e⁻ᶻ − 1.
pub(crate) fn multiples(rates: &[&Polynomial]) -> Vec<Multiple> {
    let multiple = |rate: &&Polynomial| {
        let of_each = rates.iter().enumerate().filter_map(|(of, other)| {
            let factor = ratio(rate, other)?.to_i64()?;
            (factor.abs() <= 2).then_some(Multiple { of, factor })
        });
        // The first of those with the largest factor.
        of_each.min_by_key(|multiple| (-multiple.factor.abs(), multiple.of))
    };
    rates
        .iter()
        .map(|rate| multiple(rate).expect("a rate is once itself"))
        .collect()
}

/// The rational q with f = q g.
fn ratio(f: &Polynomial, g: &Polynomial) -> Option<Rational> {
    let ([(_, a), ..], [(_, b), ..]) = (f.terms(), g.terms()) else {
        return None;
    };
    let ([(_, a), ..], [(_, b), ..]) = (a.terms(), b.terms()) else {
        return None;
    };
    let ratio = a * &b.recip();
    (g.scaled(&ratio) == *f).then_some(ratio)
}

#[cfg(test)]
mod tests {
    use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

    use super::{Multiple, multiples};

    #[test]
    fn rates_are_reported_as_multiples_of_one() {
        let mut ring = Ring::new(2);
        let (x, y, one) = (ring.variable(0), ring.variable(1), ring.one());
        let rate = ring.add(&x, &one);
        let times = |a: i64, b: i64| rate.scaled(&Rational::new(a, b));
        let of = |of, factor| Multiple { of, factor };
        let told = |rates: &[Polynomial]| multiples(&rates.iter().collect::<Vec<_>>());
        assert_eq!(told(&[times(-1, 1), times(1, 1)]), [of(0, 1), of(0, -1)]);
        assert_eq!(told(&[times(-1, 1), times(1, 2)]), [of(1, -2), of(1, 1)]);
        assert_eq!(told(&[times(1, 1), times(3, 1)]), [of(0, 1), of(1, 1)]);
        assert_eq!(
            told(&[times(2, 3), y, times(-1, 3)]),
            [of(2, -2), of(1, 1), of(2, 1)]
        );
    }
}
