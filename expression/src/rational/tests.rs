use std::collections::HashSet;

use proptest::prelude::*;

use super::*;

/// Whether the value is held in the representation its size demands, in lowest terms.
fn is_canonical(value: &Rational) -> bool {
    let (numerator, denominator) = parts(value);
    let fits = i64::try_from(&numerator).is_ok() && i64::try_from(&denominator).is_ok();
    matches!(value.0, Small(..)) == fits
        && denominator > IBig::ZERO
        && euclid(numerator, denominator).is_one()
}

fn parts(value: &Rational) -> (IBig, IBig) {
    (value.numerator(), IBig::from(value.denominator()))
}

/// The greatest common divisor of `a` and a positive `b`.
fn euclid(a: IBig, b: IBig) -> IBig {
    let (mut a, mut b) = (if a < IBig::ZERO { -a } else { a }, b);
    while !a.is_zero() {
        (a, b) = (&b % &a, a);
    }
    b
}

fn decimal(text: &str) -> Rational {
    Rational::parse_decimal(text).expect("a decimal")
}

/// Numbers of every size, with the edges of the machine words among them.
fn any_rational() -> impl Strategy<Value = Rational> {
    let edge = prop::sample::select(vec![i64::MIN, i64::MIN + 1, -1, 0, 1, 2, i64::MAX]);
    let word = prop_oneof![any::<i64>(), -9i64..10, edge];
    (word.clone(), word.clone(), word.clone(), word, 0u8..6).prop_map(|(a, b, c, d, form)| {
        let nonzero = |value: i64| if value == 0 { 1 } else { value };
        let first = Rational::new(a, nonzero(b));
        let second = Rational::new(c, nonzero(d));
        match form {
            0 => first,
            1 => first * second,
            2 => first + second,
            3 => first.powi(3) * second,
            4 => first.powi(3) + second.powi(4),
            _ => first * Rational::from_integer(10).powi(c % 40),
        }
    })
}

proptest! {
    #[test]
    fn words_are_numerator_and_denominator(
        numerator in any::<i128>(),
        denominator in 1..=i128::MAX,
        by in (0u32..127, 0u32..127),
    ) {
        let edges = [i128::MIN, i128::MIN + 1, 0, 1, i128::MAX];
        for n in edges.into_iter().chain([numerator, numerator >> by.0]) {
            for d in [1, i128::MAX, denominator, (denominator >> by.1).max(1)] {
                let value = Rational::from_words(n, d);
                prop_assert!(is_canonical(&value), "{n}/{d}");
                let (above, below) = parts(&value);
                prop_assert_eq!(&above * IBig::from(d), &below * IBig::from(n));
                let words = (i128::try_from(&above), i128::try_from(&below));
                prop_assert_eq!(value.as_words(), words.0.ok().zip(words.1.ok()));
            }
        }
        prop_assert_eq!(Rational::from_integer(2).powi(127).as_words(), None);
    }

    #[test]
    fn the_divisor_of_words_is_euclids(a in any::<i64>(), b in any::<i64>(), by in 0u32..63) {
        for (a, b) in [(a, b), (a >> by, b), (a << by, b << (by / 2)), (a, a >> by), (i64::MIN, b)] {
            if b != 0 {
                let magnitude = IBig::from(b.unsigned_abs());
                prop_assert_eq!(IBig::from(gcd(a, b)), euclid(IBig::from(a), magnitude));
            }
        }
    }

    #[test]
    fn arithmetic_is_that_of_fractions_and_canonical(a in any_rational(), b in any_rational()) {
        let ((p, q), (r, s)) = (parts(&a), parts(&b));
        for (value, above, below) in [
            (&a + &b, &p * &s + &r * &q, &q * &s),
            (&a - &b, &p * &s - &r * &q, &q * &s),
            (&a * &b, &p * &r, &q * &s),
            (-&a, -&p, q.clone()),
        ] {
            prop_assert!(is_canonical(&value));
            let (numerator, denominator) = parts(&value);
            prop_assert_eq!(numerator * below, denominator * above);
        }
        prop_assert_eq!(a.cmp(&b), (&p * &s).cmp(&(&r * &q)));
        prop_assert_eq!(a.signum(), a.cmp(&Rational::zero()) as i32);
        match a.checked_div(&b) {
            Some(quotient) => {
                prop_assert!(is_canonical(&quotient));
                prop_assert_eq!(quotient * &b, a);
            }
            None => prop_assert!(b.is_zero()),
        }
    }

    #[test]
    fn every_finite_double_survives_the_round_trip(bits in any::<u64>()) {
        let value = f64::from_bits(bits);
        match Rational::from_f64(value) {
            Some(exact) => {
                prop_assert!(is_canonical(&exact));
                prop_assert_eq!(exact.to_f64(), value);
            }
            None => prop_assert!(!value.is_finite()),
        }
    }

    /// The standard library's parser rounds correctly: it is the oracle.
    #[test]
    fn decimals_round_as_the_standard_library_rounds_them(
        whole in "[0-9]{1,25}", fraction in "[0-9]{0,25}", exponent in -360i64..320,
    ) {
        let text = format!("{whole}.{fraction}e{exponent}");
        prop_assert_eq!(decimal(&text).to_f64(), text.parse::<f64>().expect("a double"));
    }

    /// The value rounds to a neighbour that is at least as near as the next double on each side.
    #[test]
    fn quotients_round_to_the_nearest_double(a in any::<i64>(), b in 1i64.., c in any::<i64>()) {
        let exact = Rational::new(a, b) * Rational::new(c, 3);
        let rounded = exact.to_f64();
        let distance = |value: f64| (Rational::from_f64(value).expect("finite") - &exact).abs();
        prop_assert!(distance(rounded) <= distance(rounded.next_up()));
        prop_assert!(distance(rounded) <= distance(rounded.next_down()));
    }

    #[test]
    fn midpoints_of_neighbouring_doubles_go_to_the_even_one(bits in 0u64..0x7fe0_0000_0000_0000) {
        let (low, high) = (f64::from_bits(bits), f64::from_bits(bits + 1));
        let exact = |value| Rational::from_f64(value).expect("finite");
        let midpoint = (exact(low) + exact(high)) * Rational::new(1, 2);
        let even = if bits % 2 == 0 { low } else { high };
        prop_assert_eq!(midpoint.to_f64(), even);
        let nudge = exact(f64::from_bits(1)) * decimal("1e-100");
        prop_assert_eq!((&midpoint + &nudge).to_f64(), high);
        prop_assert_eq!((-(midpoint - nudge)).to_f64(), -low);
    }

    #[test]
    fn equal_numbers_hash_equally(a in any_rational(), b in any_rational()) {
        let there_and_back = (&a + &b) - &b;
        prop_assert_eq!(&there_and_back, &a);
        let set = HashSet::from([a]);
        prop_assert!(set.contains(&there_and_back));
    }
}

#[test]
fn rounding_holds_at_the_ends_of_the_range() {
    let smallest = Rational::from_f64(f64::from_bits(1)).expect("finite");
    let half = &smallest * Rational::new(1, 2);
    assert_eq!(half.to_f64(), 0.0);
    assert_eq!((&half + decimal("1e-400")).to_f64(), f64::from_bits(1));
    assert_eq!((&half - decimal("1e-400")).to_f64(), 0.0);
    assert_eq!((&half + &smallest).to_f64(), f64::from_bits(2));
    assert_eq!(decimal("1e-400").to_f64(), 0.0);
    let largest = Rational::from_f64(f64::MAX).expect("finite");
    let ulp = Rational::from_integer(2).powi(971);
    let overflow = &largest + &ulp * Rational::new(1, 2);
    assert_eq!(overflow.to_f64(), f64::INFINITY);
    assert_eq!((&overflow - Rational::new(1, 3)).to_f64(), f64::MAX);
    assert_eq!(decimal("-1e400").to_f64(), f64::NEG_INFINITY);
}

#[test]
fn decimals_are_exact() {
    assert_eq!(decimal("3"), Rational::from_integer(3));
    assert_eq!(decimal("0.1"), Rational::new(1, 10));
    assert_eq!(decimal("-1.5e-3"), Rational::new(-3, 2000));
    assert_eq!(decimal(".5"), Rational::new(1, 2));
    assert_eq!(decimal("5.E+1"), Rational::from_integer(50));
    assert_eq!(decimal("1e400").numerator(), IBig::from(10).pow(400));
}

#[test]
fn what_is_not_a_decimal_is_a_typed_error() {
    for text in [
        "", ".", "-", "e5", "1e", "1e+", "1e+-5", "1.2.3", "0x10", "1_000", "inf", "١",
    ] {
        let error = Rational::parse_decimal(text).expect_err(text);
        assert!(
            matches!(error, DecimalError::Malformed { .. }),
            "{text}: {error:?}"
        );
    }
    for text in ["1e401", "0e-401", "1e99999999999999999999"] {
        let error = Rational::parse_decimal(text).expect_err(text);
        assert!(
            matches!(error, DecimalError::ExponentOutOfRange { .. }),
            "{text}: {error:?}"
        );
    }
    let long = "1".repeat(DIGIT_LIMIT + 1);
    let error = DecimalError::TooManyDigits {
        digits: DIGIT_LIMIT + 1,
    };
    assert_eq!(Rational::parse_decimal(&long), Err(error));
}

#[test]
fn powers_and_text_are_exact() {
    assert_eq!(Rational::new(-2, 3).powi(-3), Rational::new(-27, 8));
    assert_eq!(Rational::zero().powi(0), Rational::one());
    assert_eq!(
        Rational::from_integer(3).powi(50).to_string(),
        "717897987691852588770249"
    );
    assert_eq!(Rational::new(6, -8).to_string(), "-3/4");
    assert_eq!(
        Rational::new(i64::MIN, -1).to_string(),
        "9223372036854775808"
    );
    assert_eq!(
        Rational::new(1, i64::MIN).to_string(),
        "-1/9223372036854775808"
    );
    assert_eq!(Rational::new(i64::MIN, i64::MIN), Rational::one());
    assert_eq!(Rational::new(i64::MIN, 1).to_i64(), Some(i64::MIN));
    assert_eq!(Rational::new(1, 2).to_i64(), None);
}

#[test]
#[should_panic(expected = "division of a rational number by zero")]
fn division_by_zero_panics_as_documented() {
    let _ = Rational::one() / Rational::zero();
}
