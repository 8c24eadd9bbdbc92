//! Exact quotients and square roots of Laurent polynomials.

use std::collections::{BTreeMap, BTreeSet};

use dashu_int::UBig;
use dashu_int::ops::SquareRootRem;

use super::ring::LARGEST_EXPONENT;
use super::{Coefficient, CoefficientRing, Monomial, Polynomial, Symbol, Terms};
use crate::rational::Rational;

/// q with q·g = f, or `None` where there is none with no new pole. In a symbol without negative powers in f and g, be
/// it of the state or a parameter, q has none either.
pub fn quotient(f: &Polynomial, g: &Polynomial) -> Option<Polynomial> {
    let q = divide(f, g, &|a: &Coefficient, b: &Coefficient| {
        divide(a, b, &|a: &Rational, b: &Rational| Some(a * &b.recip()))
    })?;
    let known = |poles: &dyn Fn(&Polynomial) -> BTreeSet<Symbol>| {
        let known: BTreeSet<Symbol> = poles(f).union(&poles(g)).copied().collect();
        poles(&q).is_subset(&known)
    };
    let of_state = |f: &Polynomial| poles(f);
    let of_parameters = |f: &Polynomial| f.terms().iter().flat_map(|(_, c)| poles(c)).collect();
    (known(&of_state) && known(&of_parameters)).then_some(q)
}

/// The symbols with negative powers.
fn poles<C: CoefficientRing>(f: &Terms<C>) -> BTreeSet<Symbol> {
    let factors = f.terms().iter().flat_map(|(m, _)| m.factors());
    factors
        .filter(|(_, exponent)| *exponent < 0)
        .map(|(symbol, _)| *symbol)
        .collect()
}

/// The least and the largest exponents of the symbols of f. Both of a product are the sums of those of
/// its factors.
fn exponents<C: CoefficientRing>(f: &Terms<C>) -> BTreeMap<Symbol, (i64, i64)> {
    let mut found: BTreeMap<Symbol, (i64, i64)> = BTreeMap::new();
    let mut counts: BTreeMap<Symbol, usize> = BTreeMap::new();
    for (monomial, _) in f.terms() {
        for &(symbol, exponent) in monomial.factors() {
            let exponent = i64::from(exponent);
            let (least, most) = found.entry(symbol).or_insert((exponent, exponent));
            (*least, *most) = (exponent.min(*least), exponent.max(*most));
            *counts.entry(symbol).or_insert(0) += 1;
        }
    }
    for (symbol, (least, most)) in &mut found {
        // A term without the symbol has its power 0.
        if counts[symbol] < f.terms().len() {
            (*least, *most) = (0.min(*least), 0.max(*most));
        }
    }
    found
}

/// The exponents that a quotient f/g has, `None` where there is no such quotient.
fn quotient_exponents<C: CoefficientRing>(
    f: &Terms<C>,
    g: &Terms<C>,
) -> Option<BTreeMap<Symbol, (i64, i64)>> {
    let mut range = exponents(f);
    for (symbol, (least, most)) in exponents(g) {
        let own = range.entry(symbol).or_insert((0, 0));
        *own = (own.0 - least, own.1 - most);
    }
    let is_possible = range.values().all(|(least, most)| least <= most);
    is_possible.then_some(range)
}

/// Division with leading terms. Laurent polynomials have no well-ordering, so a quotient has exponents
/// in the range that f and g allow, and a limited number of terms.
fn divide<C: CoefficientRing>(
    f: &Terms<C>,
    g: &Terms<C>,
    divide_coefficients: &dyn Fn(&C, &C) -> Option<C>,
) -> Option<Terms<C>> {
    let (divisor, unit) = g.leading()?;
    if f.terms().is_empty() {
        return Some(f.clone());
    }
    let range = quotient_exponents(f, g)?;
    let mut rest = f.clone();
    let mut terms: Vec<(Monomial, C)> = Vec::new();
    let most = 4 * f.terms().len() + 4;
    while let Some((monomial, coefficient)) = rest.leading() {
        if terms.len() == most {
            return None;
        }
        let monomial = monomial.multiply(&divisor.inverse());
        let is_in_range = range.iter().all(|(symbol, (least, most))| {
            (*least..=*most).contains(&i64::from(monomial.exponent(*symbol)))
        });
        if !is_in_range || monomial.largest_exponent() > LARGEST_EXPONENT {
            return None;
        }
        let coefficient = divide_coefficients(coefficient, unit)?;
        let taken = g.times_term(&monomial, &coefficient);
        rest = Terms::combine(&[(Rational::one(), rest), (-Rational::one(), taken)]);
        terms.push((monomial, coefficient));
    }
    Some(Terms::collect(terms))
}

/// ω with ω² = f and rational coefficients, `None` where there is none; of ±ω the one whose leading
/// coefficient is positive.
pub fn square_root(f: &Polynomial) -> Option<Polynomial> {
    let divide_numbers = |a: &Rational, b: &Rational| Some(a * &b.recip());
    root(
        f,
        &|c: &Coefficient| root(c, &rational_root, &divide_numbers),
        &|a: &Coefficient, b: &Coefficient| divide(a, b, &divide_numbers),
    )
}

/// The root's leading term is that of f; each next one is the leading term of what its square leaves,
/// over twice the first.
fn root<C: CoefficientRing>(
    f: &Terms<C>,
    root_of_coefficient: &dyn Fn(&C) -> Option<C>,
    divide_coefficients: &dyn Fn(&C, &C) -> Option<C>,
) -> Option<Terms<C>> {
    let (monomial, coefficient) = f.leading()?;
    let mut half = Monomial::one();
    for &(symbol, exponent) in monomial.factors() {
        if exponent % 2 != 0 {
            return None;
        }
        half = half.multiply(&Monomial::power(symbol, exponent / 2));
    }
    let first = root_of_coefficient(coefficient)?;
    let twice = first.scaled(&Rational::from_integer(2));
    let mut found = Terms::term(half.clone(), first);
    for _ in 0..f.terms().len() {
        let square = found.product(&found);
        let rest = Terms::combine(&[(Rational::one(), f.clone()), (-Rational::one(), square)]);
        let Some((monomial, coefficient)) = rest.leading() else {
            return Some(found);
        };
        let next = Terms::term(
            monomial.multiply(&half.inverse()),
            divide_coefficients(coefficient, &twice)?,
        );
        found = Terms::combine(&[(Rational::one(), found), (Rational::one(), next)]);
    }
    None
}

fn rational_root(r: &Rational) -> Option<Rational> {
    let (above, rest_above) = UBig::try_from(r.numerator()).ok()?.sqrt_rem();
    let (below, rest_below) = r.denominator().sqrt_rem();
    if !rest_above.is_zero() || !rest_below.is_zero() {
        return None;
    }
    let (above, below) = (i64::try_from(above).ok()?, i64::try_from(below).ok()?);
    Some(Rational::new(above, below))
}

#[cfg(test)]
mod tests {
    use crate::{Arithmetic, Rational, Ring};

    use super::{quotient, square_root};

    /// (Σ x + y + z + 1/x)ⁿ over itself but one factor, and over something that does not divide it, which
    /// shows at the first exponent out of range.
    #[test]
    fn a_quotient_is_found_or_refused_without_a_search() {
        let mut ring = Ring::new(3);
        let [x, y, z] = [0, 1, 2].map(|i| ring.variable(i));
        let one = ring.one();
        let pole = ring.divide(&one, &x).expect("a monomial");
        let sum = [&y, &z, &pole]
            .iter()
            .fold(x.clone(), |sum, f| ring.add(&sum, f));
        let mut power = sum.clone();
        for _ in 0..9 {
            let next = ring.multiply(&power, &sum);
            assert_eq!(quotient(&next, &power), Some(sum.clone()));
            assert_eq!(quotient(&next, &sum), Some(power.clone()));
            let other = ring.add(&sum, &one);
            assert_eq!(quotient(&next, &other), None);
            power = next;
        }
    }

    #[test]
    fn squares_of_monomials_have_roots() {
        let mut ring = Ring::new(2);
        let (x, a) = (ring.variable(0), ring.parameter(0));
        let scaled = ring.scale(&Rational::new(3, 4), &x);
        let monomial = ring.divide(&scaled, &a).expect("a parameter");
        let square = ring.multiply(&monomial, &monomial);
        assert_eq!(square_root(&square), Some(monomial.clone()));
        assert_eq!(square_root(&ring.negate(&square)), None);
        assert_eq!(square_root(&monomial), None);
        assert_eq!(
            square_root(&ring.scale(&Rational::from_integer(2), &square)),
            None
        );
        let y = ring.variable(1);
        assert_eq!(square_root(&ring.add(&x, &y)), None);
    }

    #[test]
    fn squares_of_sums_have_roots() {
        let mut ring = Ring::new(2);
        let [x, y] = [0, 1].map(|i| ring.variable(i));
        let parameters = [0, 1].map(|i| ring.parameter(i));
        let one = ring.one();
        let [a, b] = parameters.map(|p| ring.divide(&one, &p).expect("a parameter"));
        // (1/a − 1/b) x + y.
        let difference = ring.subtract(&a, &b);
        let product = ring.multiply(&difference, &x);
        let sum = ring.add(&product, &y);
        let square = ring.multiply(&sum, &sum);
        let root = square_root(&square).expect("a square");
        assert!(root == sum || root == ring.negate(&sum));
        assert_eq!(square_root(&ring.add(&square, &one)), None);
        assert_eq!(square_root(&ring.negate(&square)), None);
    }

    #[test]
    fn a_product_divided_by_a_factor_is_the_other() {
        let mut ring = Ring::new(3);
        let [x, y, z] = [0, 1, 2].map(|i| ring.variable(i));
        let a = ring.parameter(0);
        let ax = ring.multiply(&a, &x);
        let f = ring.combine(&[
            (Rational::new(2, 3), ax),
            (-Rational::one(), y.clone()),
            (Rational::one(), z.clone()),
        ]);
        let g = ring.subtract(&x, &y);
        let product = ring.multiply(&f, &g);
        assert_eq!(quotient(&product, &g), Some(f.clone()));
        assert_eq!(quotient(&product, &f), Some(g.clone()));
        assert_eq!(quotient(&f, &g), None);
    }

    #[test]
    fn a_quotient_has_no_new_pole() {
        let mut ring = Ring::new(2);
        let [x, y] = [0, 1].map(|i| ring.variable(i));
        assert_eq!(quotient(&y, &x), None);
        let inverse = ring.divide(&y, &x).expect("a Laurent monomial");
        assert_eq!(quotient(&inverse, &y), ring.integer_power(&x, -1).ok());
        // x + 1/a, where a may be 0.
        let (a, one) = (ring.parameter(0), ring.one());
        let product = ring.multiply(&a, &x);
        assert_eq!(quotient(&ring.add(&product, &one), &a), None);
    }
}
