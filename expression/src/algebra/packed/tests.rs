use proptest::prelude::*;

use super::{Summand, sum_of_products};
use crate::algebra::tests::{element, formula};
use crate::algebra::{Coefficient, CoefficientRing, Monomial, Polynomial, Ring, Symbol};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;

/// Σ cᵢ aᵢ bᵢ by the sums' own operations, one after the other.
fn one_by_one(summands: &[Summand<'_>]) -> Polynomial {
    let products = summands.iter().map(|(c, a, b)| (c.clone(), a.product(b)));
    Polynomial::combine(&products.collect::<Vec<_>>())
}

/// Π sᵢ^kᵢ.
fn monomial(powers: &[(Symbol, i32)]) -> Monomial {
    let one = Monomial::one();
    powers.iter().fold(one, |m, &(s, k)| m.shifted(s, k))
}

type WrittenTerm = (Vec<(Symbol, i32)>, Vec<(Symbol, i32)>, Rational);

fn written(terms: &[WrittenTerm]) -> Polynomial {
    Polynomial::collect(terms.iter().map(|(m, n, c)| {
        let coefficient = Coefficient::term(monomial(n), c.clone());
        (monomial(m), coefficient)
    }))
}

/// Sums with powers of `symbols` symbols of the state and as many of the parameters, times a monomial
/// of all of them.
fn sum_of(
    symbols: Symbol,
    exponent: i32,
    number: impl Strategy<Value = Rational> + Clone,
) -> impl Strategy<Value = Polynomial> {
    let powers = prop::collection::vec((0..symbols, -exponent..exponent + 1), 0..4);
    let terms = prop::collection::vec((powers.clone(), powers.clone(), number), 1..24);
    (terms, powers.clone(), powers).prop_map(|(terms, m, n)| {
        let common = Coefficient::term(monomial(&n), Rational::one());
        written(&terms).times_term(&monomial(&m), &common)
    })
}

/// Numbers whose common denominators and sums of products always fit.
fn short_number() -> impl Strategy<Value = Rational> + Clone {
    (-9..10_i64, 1..7_i64).prop_map(|(a, b)| Rational::new(a, b))
}

/// Numbers of at most so many bits over one denominator of the first primes.
fn number_of(bits: u32) -> impl Strategy<Value = Rational> + Clone {
    let most = 1_i64 << bits;
    (
        -most..most,
        prop_oneof![Just(1), Just(2), Just(6), Just(35)],
    )
        .prop_map(|(a, b)| Rational::new(a, b))
}

/// c, a and b of Σ c a b: of short and of long numbers, of small and of large exponents.
fn parts_of_any_size() -> impl Strategy<Value = Vec<(Rational, Polynomial, Polynomial)>> {
    (1..58_u32, 1..12_i32).prop_flat_map(|(bits, exponent)| {
        let a = sum_of(4, exponent, number_of(bits));
        let b = sum_of(8, 2, number_of(bits));
        prop::collection::vec((number_of(bits), a, b), 1..4)
    })
}

/// Σ cᵢ aᵢ bᵢ with a sum that cancels in part.
fn summands(parts: &[(Rational, Polynomial, Polynomial)]) -> Vec<Summand<'_>> {
    let all = parts.iter().map(|(c, a, b)| (c.clone(), a, b));
    // c a b − c b a = 0.
    let first = &parts[0];
    all.chain([(-&first.0, &first.2, &first.1)]).collect()
}

/// What does not fit is left to the operations one by one: numbers past 127 bits, monomials past 63.
#[test]
fn sums_that_do_not_fit_are_not_packed() {
    let ring = Ring::new(70);
    let sum = |symbols: std::ops::Range<usize>, last: Rational| {
        let mut terms: Vec<_> = symbols
            .map(|i| (Rational::one(), ring.variable(i)))
            .collect();
        terms.push((
            last,
            Polynomial::constant(Coefficient::from_rational(&Rational::one())),
        ));
        Polynomial::combine(&terms)
    };
    let is_packed = |f: &Polynomial| {
        let found = sum_of_products(&[(Rational::one(), f, f)]);
        found.map(|f| f.terms().len())
    };
    let two_to = |n: i64| Rational::from_integer(2).powi(n);
    // (1 + Σ xᵢ)² has exponents 0 … 2: 3³⁹ < 2⁶³ < 3⁴⁰ monomials.
    assert_eq!(is_packed(&sum(0..39, Rational::one())), Some(40 * 41 / 2));
    assert_eq!(is_packed(&sum(0..40, Rational::one())), None);
    // (2⁶¹ + Σ_{i<9} xᵢ)² is bounded by 10·2¹²², that with 2⁶² by 10·2¹²⁴.
    assert_eq!(is_packed(&sum(0..9, two_to(61))), Some(55));
    assert_eq!(is_packed(&sum(0..9, two_to(62))), None);
    assert_eq!(is_packed(&sum(0..9, two_to(200))), None);
    assert_eq!(is_packed(&sum(0..9, two_to(-64))), None);
    // Symbols by 256.
    let far = sum(0..9, Rational::one());
    let shifted = |at: Symbol| {
        far.times_term(
            &Monomial::power(at, 1),
            &Coefficient::from_rational(&Rational::one()),
        )
    };
    assert_eq!(is_packed(&shifted(255)), Some(55));
    assert_eq!(is_packed(&shifted(256)), None);
}

/// A power that all terms of one product have and none of another, whichever comes first.
#[test]
fn products_with_different_common_powers_are_packed() {
    let one = Coefficient::from_rational(&Rational::one());
    let f = written(&[-2, -1, 0, 1, 2, 3].map(|k| (vec![(0, k)], vec![(0, -k)], Rational::one())));
    for power in [-3, 2] {
        let of_state = f.times_term(&Monomial::power(1, power), &one);
        let of_parameters = Coefficient::term(Monomial::power(1, power), Rational::one());
        let of_parameters = f.times_term(&Monomial::one(), &of_parameters);
        for g in [&of_state, &of_parameters] {
            let products = [(&f, &f), (g, &f), (g, g)].map(|(a, b)| (Rational::one(), a, b));
            for order in [[0, 1, 2], [1, 0, 2], [2, 1, 0]] {
                let summands = order.map(|at| products[at].clone());
                let found = sum_of_products(&summands);
                assert_eq!(found, Some(one_by_one(&summands)));
            }
        }
    }
}

/// Relations of a sine with its cosine, of roots and of inverses: normal forms of sums of products are
/// those of the products' sums. A limit that products reach, such a sum reaches.
#[test]
fn sums_of_products_are_sums_of_products() {
    let texts = [
        "sin(x) + cos(x) + sqrt(1 + y)*cos(x)^1 + a*y/x - 3/7",
        "cos(x)*sin(x) - b*cos(x) + sqrt(1 + y) + 2*x*y^2 - 1/(x + a*y)",
        "1/(x + a*y) + x^3 - y/3 + cos(x)*y^2 + 5*a*b*sqrt(1 + y)",
    ];
    let products = |ring: &mut Ring, by_one: bool| {
        let elements =
            texts.map(|text| element(ring, &formula(text)).unwrap_or_else(|_| Polynomial::zero()));
        let [f, g, h] = &elements;
        let c = |a, b| Rational::new(a, b);
        let terms = [
            (c(1, 3), f, g),
            (c(-2, 1), g, h),
            (c(5, 7), h, h),
            (c(-1, 3), g, f),
        ];
        if by_one {
            let products = terms.map(|(c, a, b)| (c, ring.multiply(a, b)));
            ring.combine(&products)
        } else {
            ring.sum_of_products(&terms)
        }
    };
    let mut ring = Ring::limited(2, 10_000);
    let sum = products(&mut ring, false);
    assert_eq!(sum, products(&mut ring, true));
    assert!(sum.terms().len() > 20);
    assert_eq!(ring.refusal(), None);
    for by_one in [true, false] {
        let mut ring = Ring::limited(2, 100);
        products(&mut ring, by_one);
        assert_eq!(ring.refusal(), Some(&AlgebraError::ExpansionTooLong));
    }
}

proptest! {
    /// Terms, their order and their numbers.
    #[test]
    fn packed_sums_are_those_formed_one_by_one(
        parts in prop::collection::vec((short_number(), sum_of(5, 6, short_number()), sum_of(5, 6, short_number())), 1..5),
    ) {
        let summands = summands(&parts);
        let products = summands.iter().map(|(c, a, b)| if c.is_zero() { 0 } else { a.terms().len() * b.terms().len() });
        let found = sum_of_products(&summands);
        // Long enough, and they fit.
        prop_assert!(found.is_some() || products.sum::<usize>() < 64, "{summands:?}");
        if let Some(found) = found {
            prop_assert_eq!(found, one_by_one(&summands));
        }
    }

    #[test]
    fn packed_sums_of_any_size_are_those_formed_one_by_one(parts in parts_of_any_size()) {
        let summands = summands(&parts);
        let found = sum_of_products(&summands);
        // Four of five cases may be too large; more end the test.
        prop_assume!(found.is_some());
        prop_assert_eq!(found, Some(one_by_one(&summands)));
    }

    /// Terms in common, some of which cancel.
    #[test]
    fn accumulated_coefficients_are_collected(
        a in sum_of(3, 2, short_number()),
        b in sum_of(3, 2, short_number()),
        shared in sum_of(3, 2, short_number()),
    ) {
        let of_parameters = |f: &Polynomial| {
            let terms = f.terms().iter().flat_map(|(m, c)| c.terms().iter().map(|t| (m.clone(), t.1.clone())));
            Coefficient::collect(terms)
        };
        let [a, b, shared] = [a, b, shared].map(|f| of_parameters(&f));
        let a = Coefficient::combine(&[(Rational::one(), a), (Rational::one(), shared.clone())]);
        let b = Coefficient::combine(&[(Rational::one(), b), (-Rational::one(), shared)]);
        let mut sum = a.clone();
        sum.accumulate(&b);
        prop_assert_eq!(sum, Coefficient::collect(a.terms().iter().chain(b.terms()).cloned()));
    }
}
