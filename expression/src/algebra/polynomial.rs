//! Sparse Laurent polynomials with exact coefficients.

use rustc_hash::FxHashMap;

use super::monomial::{Monomial, Symbol};
use crate::rational::Rational;

/// Coefficients of a polynomial: an exact commutative ring over ℚ.
pub trait CoefficientRing: Clone + PartialEq + std::fmt::Debug {
    /// The rational number `value`.
    fn from_rational(value: &Rational) -> Self;
    /// Whether this is 0.
    fn is_zero(&self) -> bool;
    /// a ← a + b.
    fn accumulate(&mut self, other: &Self);
    /// a·b.
    fn product(&self, other: &Self) -> Self;
    /// c·a.
    fn scaled(&self, factor: &Rational) -> Self;
    /// The largest exponent in it, 0 of a number.
    fn largest_exponent(&self) -> u32;
}

impl CoefficientRing for Rational {
    fn from_rational(value: &Rational) -> Self {
        value.clone()
    }
    fn is_zero(&self) -> bool {
        Rational::is_zero(self)
    }
    fn accumulate(&mut self, other: &Self) {
        *self += other;
    }
    fn product(&self, other: &Self) -> Self {
        self * other
    }
    fn scaled(&self, factor: &Rational) -> Self {
        self * factor
    }
    fn largest_exponent(&self) -> u32 {
        0
    }
}

/// Σ c·m over Laurent monomials m, sorted by monomial, no zero coefficient: a normal form, so
/// that equality is equality of terms.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Terms<C> {
    terms: Vec<(Monomial, C)>,
}

impl<C> Default for Terms<C> {
    fn default() -> Self {
        Self { terms: Vec::new() }
    }
}

impl<C: CoefficientRing> Terms<C> {
    /// 0.
    pub fn zero() -> Self {
        Self::default()
    }

    /// c·m.
    pub fn term(monomial: Monomial, coefficient: C) -> Self {
        if coefficient.is_zero() {
            return Self::zero();
        }
        Self {
            terms: vec![(monomial, coefficient)],
        }
    }

    /// The monomial s.
    pub fn symbol(symbol: Symbol) -> Self {
        Self::term(
            Monomial::power(symbol, 1),
            C::from_rational(&Rational::one()),
        )
    }

    /// The constant c.
    pub fn constant(coefficient: C) -> Self {
        Self::term(Monomial::one(), coefficient)
    }

    /// The terms (monomial, coefficient), in the monomials' [`Ord`].
    pub fn terms(&self) -> &[(Monomial, C)] {
        &self.terms
    }

    /// Whether this is 0.
    pub fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// The largest term by [`Monomial::compare`]: the product of two leading terms leads the product.
    pub fn leading(&self) -> Option<&(Monomial, C)> {
        self.terms.iter().max_by(|a, b| a.0.compare(&b.0))
    }

    /// The largest size of an exponent, of coefficients too.
    pub fn largest_exponent(&self) -> u32 {
        let terms = self.terms.iter();
        let sizes = terms.map(|(m, c)| m.largest_exponent().max(c.largest_exponent()));
        sizes.max().unwrap_or(0)
    }

    /// The constant this is, if no monomial but 1 occurs.
    pub fn as_constant(&self) -> Option<C> {
        match self.terms.as_slice() {
            [] => Some(C::from_rational(&Rational::zero())),
            [(m, c)] if m.is_one() => Some(c.clone()),
            _ => None,
        }
    }

    /// The sum of terms that stand in the monomials' [`Ord`], each monomial once, none with the
    /// coefficient 0.
    pub(super) fn from_sorted(terms: Vec<(Monomial, C)>) -> Self {
        debug_assert!(terms.is_sorted_by(|a, b| a.0 < b.0));
        debug_assert!(terms.iter().all(|(_, c)| !c.is_zero()));
        Self { terms }
    }

    /// The terms collected from any order, with repetitions.
    pub fn collect(terms: impl IntoIterator<Item = (Monomial, C)>) -> Self {
        let mut sums: FxHashMap<Monomial, C> = FxHashMap::default();
        for (monomial, coefficient) in terms {
            match sums.entry(monomial) {
                std::collections::hash_map::Entry::Occupied(mut entry) => {
                    entry.get_mut().accumulate(&coefficient);
                }
                std::collections::hash_map::Entry::Vacant(entry) => {
                    entry.insert(coefficient);
                }
            }
        }
        Self::sorted(sums.into_iter().filter(|(_, c)| !c.is_zero()).collect())
    }

    /// The sum of terms with different monomials, none with the coefficient 0.
    pub(super) fn sorted(mut terms: Vec<(Monomial, C)>) -> Self {
        terms.sort_unstable_by(|a, b| a.0.cmp(&b.0));
        Self::from_sorted(terms)
    }

    /// Σ cᵢ fᵢ.
    pub fn combine(parts: &[(Rational, Self)]) -> Self {
        let parts: Vec<&(Rational, Self)> = parts
            .iter()
            .filter(|(factor, part)| !factor.is_zero() && !part.is_zero())
            .collect();
        if let [(factor, part)] = parts.as_slice() {
            return part.scaled(factor);
        }
        Self::collect(parts.into_iter().flat_map(|(factor, part)| {
            let terms = part.terms.iter();
            terms.map(move |(m, c)| (m.clone(), c.scaled(factor)))
        }))
    }

    /// f·g.
    pub fn product(&self, other: &Self) -> Self {
        if let [(m, c)] = self.terms.as_slice() {
            return other.times_term(m, c);
        }
        if let [(m, c)] = other.terms.as_slice() {
            return self.times_term(m, c);
        }
        Self::collect(self.terms.iter().flat_map(|(m, c)| {
            other
                .terms
                .iter()
                .map(move |(n, d)| (m.multiply(n), c.product(d)))
        }))
    }

    /// f·(c·m).
    pub fn times_term(&self, monomial: &Monomial, coefficient: &C) -> Self {
        let terms = self.terms.iter();
        if monomial.is_one() {
            let terms = terms.map(|(m, c)| (m.clone(), c.product(coefficient)));
            return Self {
                terms: terms.filter(|(_, c)| !c.is_zero()).collect(),
            };
        }
        let terms = terms.map(|(m, c)| (m.multiply(monomial), c.product(coefficient)));
        Self::sorted(terms.filter(|(_, c)| !c.is_zero()).collect())
    }

    /// c·f.
    pub fn scaled(&self, factor: &Rational) -> Self {
        if factor.is_zero() {
            return Self::zero();
        }
        if factor.is_one() {
            return self.clone();
        }
        Self {
            terms: self
                .terms
                .iter()
                .map(|(m, c)| (m.clone(), c.scaled(factor)))
                .collect(),
        }
    }

    /// The monomial that divides every term, exponents of either sign included; 1 for 0.
    pub fn content(&self) -> Monomial {
        let mut terms = self.terms.iter();
        let Some((first, _)) = terms.next() else {
            return Monomial::one();
        };
        terms.fold(first.clone(), |common, (m, _)| common.common(m))
    }

    /// The symbols that occur.
    pub fn symbols(&self) -> Vec<Symbol> {
        let mut symbols: Vec<Symbol> = self
            .terms
            .iter()
            .flat_map(|(m, _)| m.factors().iter().map(|f| f.0))
            .collect();
        symbols.sort_unstable();
        symbols.dedup();
        symbols
    }
}

/// A function of the parameters alone: a Laurent polynomial over ℚ in the parameters and in
/// constants formed from them.
pub type Coefficient = Terms<Rational>;

/// A function of the state: a Laurent polynomial in the variables and the adjoined generators,
/// whose coefficients are functions of the parameters.
pub type Polynomial = Terms<Coefficient>;

impl CoefficientRing for Coefficient {
    fn from_rational(value: &Rational) -> Self {
        Self::constant(value.clone())
    }
    fn is_zero(&self) -> bool {
        Terms::is_zero(self)
    }
    fn accumulate(&mut self, other: &Self) {
        if let ([(m, c)], [(n, d)]) = (self.terms.as_mut_slice(), other.terms.as_slice())
            && m == n
        {
            c.accumulate(d);
            if c.is_zero() {
                self.terms.clear();
            }
            return;
        }
        let (mut left, mut right) = (
            self.terms.drain(..).peekable(),
            other.terms.iter().peekable(),
        );
        let mut merged = Vec::with_capacity(left.len() + right.len());
        while let (Some((m, _)), Some((n, _))) = (left.peek(), right.peek()) {
            let order = m.cmp(n);
            if order.is_gt() {
                merged.extend(right.next().cloned());
                continue;
            }
            merged.extend(left.next());
            if order.is_eq()
                && let (Some((_, sum)), Some((_, d))) = (merged.last_mut(), right.next())
            {
                sum.accumulate(d);
                if sum.is_zero() {
                    merged.pop();
                }
            }
        }
        merged.extend(left);
        merged.extend(right.cloned());
        self.terms = merged;
    }
    fn product(&self, other: &Self) -> Self {
        Terms::product(self, other)
    }
    fn scaled(&self, factor: &Rational) -> Self {
        Terms::scaled(self, factor)
    }
    fn largest_exponent(&self) -> u32 {
        Terms::largest_exponent(self)
    }
}
