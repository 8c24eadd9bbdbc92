use proptest::prelude::*;

use super::{Monomial, Polynomial, Ring};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::bounded::{Bounded, BoundedNumbers};
use crate::expression::{Binary, Expression, Function, Side};
use crate::rational::Rational;
use crate::special::Special;
use crate::syntax::{Formula, Scope};

pub(super) fn formula(text: &str) -> Expression {
    let scope = Scope::new()
        .with_variables(&["x", "y"])
        .with_parameters(&["a", "b"]);
    let parsed = Formula::parse(text).expect(text);
    parsed.resolve(&scope, None).expect(text).expect(text)
}

pub(super) fn element(ring: &mut Ring, formula: &Expression) -> Result<Polynomial, AlgebraError> {
    formula.evaluate_in(ring, &mut |ring: &mut Ring, i| Ok(ring.variable(i)))
}

/// A value with its derivative along one variable.
#[derive(Clone, Copy)]
struct Dual(Bounded, Bounded);

/// f and ∂f/∂x_v at a point by the chain rule on numbers, with a table of derivatives of its own.
struct DualNumbers<'a> {
    numbers: BoundedNumbers,
    point: &'a [f64],
    along: usize,
}

impl DualNumbers<'_> {
    fn of(&mut self, formula: &Expression) -> Dual {
        let zero = Bounded::exact(0.0);
        let n = |value: f64| Bounded::exact(value);
        match formula {
            Expression::Constant(value) => Dual(self.numbers.constant(value), zero),
            Expression::Pi => Dual(self.numbers.pi(), zero),
            Expression::Variable(at) => {
                let slope = if *at == self.along { 1.0 } else { 0.0 };
                Dual(n(self.point[*at]), n(slope))
            }
            Expression::Parameter(at) => Dual(self.numbers.parameter(*at), zero),
            Expression::Sum(terms) => terms.iter().fold(Dual(zero, zero), |sum, term| {
                let term = self.of(term);
                Dual(
                    self.numbers.add(&sum.0, &term.0),
                    self.numbers.add(&sum.1, &term.1),
                )
            }),
            Expression::Product(factors) => {
                let one = Dual(n(1.0), zero);
                factors.iter().fold(one, |product, factor| {
                    let factor = self.of(factor);
                    self.product(product, factor)
                })
            }
            Expression::Negate(inner) => {
                let inner = self.of(inner);
                Dual(self.numbers.negate(&inner.0), self.numbers.negate(&inner.1))
            }
            Expression::Quotient(above, below) => {
                let (above, below) = (self.of(above), self.of(below));
                let inverse = self.power(below, -1.0);
                self.product(above, inverse)
            }
            Expression::Power(base, exponent) => {
                let (base, exponent) = (self.of(base), self.of(exponent));
                self.power(base, exponent.0.value)
            }
            Expression::Apply(function, argument) => {
                let u = self.of(argument);
                let value = self.numbers.apply(*function, &u.0).expect("a number");
                let slope = self.slope(*function, u.0, value);
                Dual(value, self.numbers.multiply(&slope, &u.1))
            }
            Expression::Binary(function, pair) => {
                let [a, b] = pair.each_ref().map(|part| self.of(part));
                let value = self.numbers.apply_two(*function, &a.0, &b.0);
                let value = value.expect("a number");
                let of = |parts: [Bounded; 2]| parts.map(|slope| Dual(slope, zero));
                let [by_a, by_b] = match function {
                    // x dy − y dx over r².
                    Binary::Atan2 => {
                        let square = self.product(a, a).0;
                        let radius = self.numbers.multiply(&b.0, &b.0);
                        let radius = self.numbers.add(&square, &radius);
                        let opposite = self.numbers.negate(&a.0);
                        let [up, across] =
                            [b.0, opposite].map(|above| self.numbers.divide(&above, &radius));
                        of([up.expect("a number"), across.expect("a number")])
                    }
                    Binary::Mod => {
                        let quotient = self.numbers.divide(&a.0, &b.0).expect("a number");
                        let whole = self.numbers.apply(Function::Floor, &quotient);
                        of([n(1.0), self.numbers.negate(&whole.expect("a number"))])
                    }
                };
                let parts = [(by_a, a.1), (by_b, b.1)]
                    .map(|(slope, inner)| self.numbers.multiply(&slope.0, &inner));
                Dual(value, self.numbers.add(&parts[0], &parts[1]))
            }
            Expression::Lookup(lookup, point) => {
                let point: Vec<Dual> = point.iter().map(|part| self.of(part)).collect();
                let at: Vec<Bounded> = point.iter().map(|part| part.0).collect();
                let mut of = |lookup| self.numbers.look_up(lookup, &at).expect("a number");
                let value = of(*lookup);
                let slopes = (0..at.len()).map(|axis| lookup.derivative(axis).map(&mut of));
                let slopes: Vec<Option<Bounded>> = slopes.collect();
                let mut slope = Bounded::exact(0.0);
                for (part, outer) in point.iter().zip(slopes) {
                    let outer = outer.unwrap_or(Bounded::exact(0.0));
                    let inner = self.numbers.multiply(&outer, &part.1);
                    slope = self.numbers.add(&slope, &inner);
                }
                Dual(value, slope)
            }
            Expression::Where(parts) => {
                let [c, a, b] = parts.each_ref().map(|part| self.of(part));
                let mut kept =
                    |side, a: Bounded| self.numbers.kept(side, &c.0, &a).expect("a number");
                let [above, below] = [(Side::Above, a), (Side::Below, b)]
                    .map(|(side, part)| [kept(side, part.0), kept(side, part.1)]);
                Dual(
                    self.numbers.add(&above[0], &below[0]),
                    self.numbers.add(&above[1], &below[1]),
                )
            }
            Expression::Shared(shared) => self.of(shared),
        }
    }

    fn product(&mut self, a: Dual, b: Dual) -> Dual {
        let left = self.numbers.multiply(&a.1, &b.0);
        let right = self.numbers.multiply(&a.0, &b.1);
        Dual(
            self.numbers.multiply(&a.0, &b.0),
            self.numbers.add(&left, &right),
        )
    }

    fn power(&mut self, base: Dual, exponent: f64) -> Dual {
        let power = |numbers: &mut BoundedNumbers, exponent: f64| {
            let small = exponent.abs() <= 64.0 && exponent == libm::trunc(exponent);
            if small {
                numbers.integer_power(&base.0, exponent as i64)
            } else {
                numbers.power(&base.0, &Bounded::exact(exponent))
            }
        };
        let value = power(&mut self.numbers, exponent).expect("a number");
        let lower = power(&mut self.numbers, exponent - 1.0).expect("a number");
        let slope = self.numbers.multiply(&Bounded::exact(exponent), &lower);
        Dual(value, self.numbers.multiply(&slope, &base.1))
    }

    /// f′(u), from textbook formulas.
    fn slope(&mut self, function: Function, u: Bounded, value: Bounded) -> Bounded {
        let numbers = &mut self.numbers;
        let one = Bounded::exact(1.0);
        let square = numbers.multiply(&u, &u);
        let [above, below] = [1, -1].map(|sign| {
            let parts = [
                (Rational::one(), one),
                (Rational::from_integer(sign), square),
            ];
            numbers.combine(&parts)
        });
        let root = |numbers: &mut BoundedNumbers, inside: Bounded| {
            let root = numbers.apply(Function::Sqrt, &inside).expect("a number");
            numbers.divide(&one, &root).expect("a number")
        };
        match function {
            Function::Exp => value,
            Function::Ln => numbers.divide(&one, &u).expect("a number"),
            Function::Sqrt => {
                let half = root(numbers, u);
                numbers.scale(&Rational::new(1, 2), &half)
            }
            Function::Sin => numbers.apply(Function::Cos, &u).expect("a number"),
            Function::Cos => {
                let sine = numbers.apply(Function::Sin, &u).expect("a number");
                numbers.negate(&sine)
            }
            Function::Sinh => numbers.apply(Function::Cosh, &u).expect("a number"),
            Function::Cosh => numbers.apply(Function::Sinh, &u).expect("a number"),
            Function::Tan | Function::Tanh => {
                let even = match function {
                    Function::Tan => Function::Cos,
                    _ => Function::Cosh,
                };
                let even = numbers.apply(even, &u).expect("a number");
                let square = numbers.multiply(&even, &even);
                numbers.divide(&one, &square).expect("a number")
            }
            Function::Asin => root(numbers, below),
            Function::Acos => {
                let slope = root(numbers, below);
                numbers.negate(&slope)
            }
            Function::Asinh => root(numbers, above),
            Function::Acosh => {
                let inside = numbers.negate(&below);
                root(numbers, inside)
            }
            Function::Atan => numbers.divide(&one, &above).expect("a number"),
            Function::Atanh => numbers.divide(&one, &below).expect("a number"),
            Function::Abs => Bounded::exact(Function::Sign.apply(u.value)),
            Function::Sign | Function::Floor => Bounded::exact(0.0),
            Function::Erf | Function::Erfc => {
                let pi = numbers.pi();
                let sign = if function == Function::Erf { -2 } else { 2 };
                let bell = numbers.scale(&-Rational::one(), &square);
                let bell = numbers.apply(Function::Exp, &bell).expect("a number");
                let root = root(numbers, pi);
                let bell = numbers.multiply(&bell, &root);
                numbers.scale(&Rational::from_integer(-sign), &bell)
            }
            Function::Gamma => {
                let digamma = Function::Special(Special::LnGamma, 1);
                let digamma = numbers.apply(digamma, &u).expect("a number");
                numbers.multiply(&value, &digamma)
            }
            Function::Log10 | Function::Log2 => {
                let base = if function == Function::Log10 {
                    10.0
                } else {
                    2.0
                };
                let below = numbers.multiply(&u, &Bounded::exact(libm::log(base)));
                numbers.divide(&one, &below).expect("a number")
            }
            // J₁′ = J₀ − J₁/x.
            Function::Special(Special::J1, 0) => {
                let other = Function::Special(Special::J0, 0);
                let other = numbers.apply(other, &u).expect("a number");
                let part = numbers.divide(&value, &u).expect("a number");
                numbers.subtract(&other, &part)
            }
            // E′ = (E − K)/(2m).
            Function::Special(Special::EllipticE, 0) => {
                let other = Function::Special(Special::EllipticK, 0);
                let other = numbers.apply(other, &u).expect("a number");
                let difference = numbers.subtract(&value, &other);
                let half = numbers.divide(&difference, &u).expect("a number");
                numbers.scale(&Rational::new(1, 2), &half)
            }
            Function::Special(special, order) => {
                let next = Function::Special(special, order + 1);
                numbers.apply(next, &u).expect("a number")
            }
        }
    }
}

/// The derivative in the ring, evaluated as it stands, against the chain rule on numbers. `None` where
/// the ring refuses or there is no number to compare.
fn disagreement(formula: &Expression, point: &[f64; 2], parameters: &[f64; 2]) -> Option<String> {
    let mut ring = Ring::limited(2, 100_000);
    let f = element(&mut ring, formula).ok()?;
    let numbers = BoundedNumbers {
        parameters: parameters.to_vec(),
    };
    for along in 0..2 {
        let derivative = ring.derivative(&f, along).ok()?;
        let mut duals = DualNumbers {
            numbers: numbers.clone(),
            point,
            along,
        };
        let expected = duals.of(formula);
        let back = [(&f, expected.0), (&derivative, expected.1)];
        for (element, expected) in back {
            let value = ring
                .formula(element)
                .evaluate_in(&mut numbers.clone(), &mut |_, i| {
                    Ok(Bounded::exact(point[i]))
                })
                .expect("numbers");
            let bound = expected.error + value.error;
            if !expected.value.is_finite() || !bound.is_finite() {
                return None;
            }
            // NaN counts as far.
            let near = (value.value - expected.value).abs() <= 2.0 * bound;
            if !near {
                return Some(format!(
                    "{value:?} for {expected:?}, of {:?}",
                    ring.formula(element)
                ));
            }
        }
    }
    None
}

/// Sums with negative powers, and what is derived through their inverses.
#[test]
fn quotients_by_sums_with_negative_powers_are_right() {
    for text in [
        "1/(1 - 2/x)",
        "1/(2 - 1/x)",
        "1/(1 + 2/x)",
        "1/(x - 2*y/x)",
        "1/(1 - 1/x^2)",
        "1/(2 + exp(-x))",
        "1/(1 - exp(-x/9))",
        "sqrt(1 - 1/x^2)",
        "(1 - 1/x)^(1/3)",
        "asin(1/x)",
        "acos(1/x)",
        "atanh(1/x)",
        "ln(3 - 2/x)",
        "1/(2*y + 3*x*y)",
        "1/(x + y + x*y)",
        "x*y/(x + y + 3*x*y)^2",
        "1/(a*x + (a + b)*x*y + b/y)",
        "sqrt(1 + 1/cos(x))/(1 + tan(y)/x)",
    ] {
        let found = disagreement(&formula(text), &[1.7, 2.3], &[1.3, 0.6]);
        assert_eq!(found, None, "{text}");
    }
    let mut ring = Ring::new(2);
    let difference = formula("1/(1 - 2/x) - x/(x - 2)");
    assert_eq!(element(&mut ring, &difference), Ok(Polynomial::zero()));
}

/// m < n says mk < nk for every k, exponents of either sign.
#[test]
fn products_keep_the_order_of_leading_terms() {
    let mut all = Vec::new();
    for (i, j) in (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))) {
        all.push(Monomial::power(0, i).multiply(&Monomial::power(1, j)));
    }
    for (a, b) in all.iter().flat_map(|a| all.iter().map(move |b| (a, b))) {
        let order = a.compare(b);
        assert_eq!(order.is_eq(), a == b);
        assert_eq!(order, b.compare(a).reverse());
        for k in &all {
            assert_eq!(
                a.multiply(k).compare(&b.multiply(k)),
                order,
                "{a:?} {b:?} {k:?}"
            );
        }
    }
}

/// Exponents end at 32 767, those of parameters too, with an error and not with other exponents.
#[test]
fn exponents_that_do_not_fit_are_refused() {
    for text in [
        "(x^1000)^66",
        "(x^1000)^40*x",
        "((a^1000)^66 + x)^2",
        "1/(x^1000)^33",
        "(x^1000)^32*(1/x^500)*(x^500)*x^768",
        "sqrt(1 + x^(-1000))^60*sqrt(1 + x^(-1000))^6",
    ] {
        let mut ring = Ring::limited(2, 1_000_000);
        let found = element(&mut ring, &formula(text));
        assert_eq!(found, Err(AlgebraError::ExpandedExponent), "{text}");
        // The refusal stays: nothing is taken from this ring.
        let x = ring.variable(0);
        assert_eq!(ring.derivative(&x, 0), Err(AlgebraError::ExpandedExponent));
    }
    let mut ring = Ring::new(2);
    let largest = element(&mut ring, &formula("(x^1000)^32*x^767")).expect("it fits");
    assert_eq!(largest.largest_exponent(), 32_767);
}

/// Numbers of a formula end at 65 536 binary digits.
#[test]
fn powers_of_numbers_that_do_not_fit_are_refused() {
    for text in ["((2^1000)^1000)^1000*x", "1e300^1000*x^2"] {
        let mut ring = Ring::new(2);
        let found = element(&mut ring, &formula(text));
        assert_eq!(found, Err(AlgebraError::NumberTooLong), "{text}");
    }
    let mut ring = Ring::new(2);
    assert!(element(&mut ring, &formula("(2^1000)^60*x + 1^1000")).is_ok());
}

/// More symbols than 16 bits number.
#[test]
fn seventy_thousand_parameters_have_symbols() {
    let mut ring = Ring::new(1);
    let x = ring.variable(0);
    for at in [0, 65_535, 69_999] {
        let parameters: Vec<Polynomial> = (0..70_000).map(|i| ring.parameter(i)).collect();
        let product = ring.multiply(&parameters[at], &x);
        assert_eq!(ring.derivative(&product, 0), Ok(parameters[at].clone()));
    }
}

/// sin(x), sin(2x), …, each function a symbol of its own; sin(kx) has the derivative k cos(kx).
#[test]
fn sixty_six_thousand_functions_have_symbols() {
    const COUNT: i64 = 66_000;
    let mut ring = Ring::new(1);
    let x = ring.variable(0);
    let mut of = |function: Function, k: i64| {
        let factor = Rational::from_integer(k);
        let argument = ring.scale(&factor, &x);
        (factor, ring.apply(function, &argument).expect("a function"))
    };
    let sines: Vec<_> = (1..=COUNT).map(|k| of(Function::Sin, k)).collect();
    let last = [1, 65_535, 65_536, COUNT].map(|k| of(Function::Cos, k));
    for (factor, cosine) in last {
        let at = sines
            .iter()
            .position(|(k, _)| *k == factor)
            .expect("a sine");
        let slope = ring.scale(&factor, &cosine);
        assert_eq!(ring.derivative(&sines[at].1, 0), Ok(slope), "{factor}");
    }
}

fn constant() -> impl Strategy<Value = Expression> {
    (1..9_i64, 1..4_i64, any::<bool>()).prop_map(|(a, b, negative)| {
        let a = if negative { -a } else { a };
        Expression::Constant(Rational::new(a, b))
    })
}

/// Formulas of two variables and parameters with all that the ring adjoins: quotients by sums, powers of
/// shifted coordinates, roots, functions of functions.
fn random_formula() -> impl Strategy<Value = Expression> {
    let leaf = prop_oneof![
        4 => (0..2_usize).prop_map(Expression::Variable),
        1 => (0..2_usize).prop_map(Expression::Parameter),
        2 => constant(),
        1 => Just(Expression::Pi),
    ];
    leaf.prop_recursive(4, 24, 3, |inner| {
        let boxed = inner.clone().prop_map(Box::new);
        let exponent = prop_oneof![
            4 => (-3..5_i64).prop_map(Rational::from_integer),
            2 => (-3..4_i64, 2..4_i64).prop_map(|(p, q)| Rational::new(p, q)),
        ];
        let exponent = prop_oneof![
            5 => exponent.prop_map(Expression::Constant),
            1 => (0..2_usize).prop_map(Expression::Parameter),
        ];
        prop_oneof![
            3 => prop::collection::vec(inner.clone(), 2..4).prop_map(Expression::Sum),
            2 => prop::collection::vec(inner.clone(), 2..4).prop_map(Expression::Product),
            1 => boxed.clone().prop_map(Expression::Negate),
            3 => (boxed.clone(), boxed.clone()).prop_map(|(a, b)| Expression::Quotient(a, b)),
            3 => (boxed.clone(), exponent).prop_map(|(a, e)| Expression::Power(a, Box::new(e))),
            2 => (0..Function::ALL.len(), boxed).prop_map(|(f, a)| Expression::Apply(Function::ALL[f], a)),
            1 => (0..Binary::ALL.len(), inner.clone(), inner.clone())
                .prop_map(|(f, a, b)| Expression::Binary(Binary::ALL[f].1, Box::new([a, b]))),
            1 => (inner.clone(), inner.clone(), inner).prop_map(|(c, a, b)| Expression::Where(Box::new([c, a, b]))),
        ]
    })
}

/// Σ c m with exponents −2 … 2 and nonzero rational c.
fn laurent() -> impl Strategy<Value = Vec<(i64, [i32; 3])>> {
    prop::collection::vec((1..7_i64, prop::array::uniform3(-2..3_i32)), 1..5)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn derivatives_are_those_of_the_chain_rule(
        formula in random_formula(),
        point in prop::array::uniform2(0.3_f64..3.0),
        parameters in prop::array::uniform2(0.3_f64..3.0),
    ) {
        let found = disagreement(&formula, &point, &parameters);
        prop_assert!(found.is_none(), "{}", found.unwrap_or_default());
    }

    /// f · 1/f = 1 for sums in x, y and exp(x); to round-off where powers are negative, for which the
    /// relations do not decide every identity.
    #[test]
    fn an_inverse_times_its_sum_is_one(terms in laurent(), shift in 0..3_i32) {
        let mut ring = Ring::limited(2, 1_000_000);
        let (x, y) = (ring.variable(0), ring.variable(1));
        let e = ring.apply(Function::Exp, &x).expect("a function");
        let mut parts = Vec::new();
        for (coefficient, exponents) in &terms {
            let mut product = ring.one();
            for (base, exponent) in [&x, &y, &e].into_iter().zip(exponents) {
                let exponent = i64::from(exponent + shift);
                let power = ring.integer_power(base, exponent).expect("a power");
                product = ring.multiply(&product, &power);
            }
            parts.push((Rational::from_integer(*coefficient), product));
        }
        let f = ring.combine(&parts);
        let one = ring.one();
        let inverse = ring.divide(&one, &f).expect("coefficients are positive");
        let product = ring.multiply(&f, &inverse);
        prop_assert_eq!(ring.refusal(), None);
        if shift == 2 {
            prop_assert_eq!(&product, &one);
        }
        let mut numbers = BoundedNumbers { parameters: Vec::new() };
        let value = ring
            .formula(&product)
            .evaluate_in(&mut numbers, &mut |_, i| Ok(Bounded::exact([0.7, 1.3][i])))
            .expect("numbers");
        prop_assert!((value.value - 1.0).abs() <= value.error, "{value:?}");
    }
}
