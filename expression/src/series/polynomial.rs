//! Polynomials in one curve parameter with coefficients in any algebra.

use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::expression::{Binary, Function, Side};
use crate::rational::Rational;
use crate::table::Lookup;

/// Σ cⱼ sʲ as its list of coefficients, without trailing zeros.
pub type UnivariateElement<E> = Vec<E>;

/// c·a·b.
type Product<'a, E> = (Rational, &'a UnivariateElement<E>, &'a UnivariateElement<E>);

/// The algebra of polynomials in s over an algebra A; functions and quotients only where the argument does not
/// depend on s.
#[derive(Debug)]
pub struct Univariate<'a, A: Arithmetic> {
    /// The coefficients' algebra.
    pub inner: &'a mut A,
}

impl<A: Arithmetic> Univariate<'_, A> {
    fn trim(&self, mut element: Vec<A::Element>) -> Vec<A::Element> {
        while element.last().is_some_and(|c| self.inner.is_zero(c)) {
            element.pop();
        }
        element
    }

    /// Σ cᵢ aᵢ bᵢ, each power of s at once.
    fn product_columns(&mut self, terms: &[Product<'_, A::Element>]) -> Vec<A::Element> {
        let lengths = terms.iter().map(|(_, a, b)| match (a.len(), b.len()) {
            (0, _) | (_, 0) => 0,
            (a, b) => a + b - 1,
        });
        let product = (0..lengths.max().unwrap_or(0))
            .map(|k| {
                let mut column = Vec::new();
                for (c, a, b) in terms {
                    for (j, x) in a.iter().enumerate().take(k + 1) {
                        let Some(y) = b.get(k - j) else {
                            continue;
                        };
                        if !self.inner.is_zero(x) && !self.inner.is_zero(y) {
                            column.push((c.clone(), x, y));
                        }
                    }
                }
                self.inner.sum_of_products(&column)
            })
            .collect();
        self.trim(product)
    }

    fn constant_part(
        &mut self,
        element: &[A::Element],
        function: &'static str,
    ) -> Result<A::Element, AlgebraError> {
        match element {
            [] => Ok(self.inner.zero()),
            [c] => Ok(c.clone()),
            _ => Err(AlgebraError::NotPolynomial { function }),
        }
    }
}

impl<A: Arithmetic> Arithmetic for Univariate<'_, A> {
    type Element = UnivariateElement<A::Element>;

    fn constant(&mut self, value: &Rational) -> Self::Element {
        if value.is_zero() {
            Vec::new()
        } else {
            vec![self.inner.constant(value)]
        }
    }
    fn pi(&mut self) -> Self::Element {
        vec![self.inner.pi()]
    }
    fn parameter(&mut self, index: usize) -> Self::Element {
        vec![self.inner.parameter(index)]
    }
    fn is_zero(&self, element: &Self::Element) -> bool {
        element.is_empty()
    }
    fn as_rational(&self, element: &Self::Element) -> Option<Rational> {
        match element.as_slice() {
            [] => Some(Rational::zero()),
            [c] => self.inner.as_rational(c),
            _ => None,
        }
    }
    fn is_expanded(&self) -> bool {
        self.inner.is_expanded()
    }
    fn combine(&mut self, terms: &[(Rational, Self::Element)]) -> Self::Element {
        let length = terms.iter().map(|(_, t)| t.len()).max().unwrap_or(0);
        let sum = (0..length)
            .map(|j| {
                let column: Vec<_> = terms
                    .iter()
                    .filter_map(|(c, t)| t.get(j).map(|e| (c.clone(), e.clone())))
                    .collect();
                self.inner.combine(&column)
            })
            .collect();
        self.trim(sum)
    }
    fn multiply(&mut self, a: &Self::Element, b: &Self::Element) -> Self::Element {
        self.product_columns(&[(Rational::one(), a, b)])
    }
    fn sum_of_products(
        &mut self,
        terms: &[(Rational, &Self::Element, &Self::Element)],
    ) -> Self::Element {
        self.product_columns(terms)
    }
    fn divide(
        &mut self,
        a: &Self::Element,
        b: &Self::Element,
    ) -> Result<Self::Element, AlgebraError> {
        let below = self.constant_part(b, "/")?;
        a.iter().map(|c| self.inner.divide(c, &below)).collect()
    }
    fn power(
        &mut self,
        a: &Self::Element,
        b: &Self::Element,
    ) -> Result<Self::Element, AlgebraError> {
        let (base, exponent) = (self.constant_part(a, "^")?, self.constant_part(b, "^")?);
        let value = self.inner.power(&base, &exponent)?;
        Ok(self.trim(vec![value]))
    }
    fn look_up(
        &mut self,
        lookup: Lookup,
        point: &[Self::Element],
    ) -> Result<Self::Element, AlgebraError> {
        let mut constants = Vec::with_capacity(point.len());
        for at in point {
            constants.push(self.constant_part(at, lookup.table().name())?);
        }
        let value = self.inner.look_up(lookup, &constants)?;
        Ok(self.trim(vec![value]))
    }
    fn kept(
        &mut self,
        side: Side,
        c: &Self::Element,
        v: &Self::Element,
    ) -> Result<Self::Element, AlgebraError> {
        let c = self.constant_part(c, "if")?;
        let parts: Result<Vec<_>, _> = v
            .iter()
            .map(|part| self.inner.kept(side, &c, part))
            .collect();
        Ok(self.trim(parts?))
    }
    fn apply_two(
        &mut self,
        function: Binary,
        a: &Self::Element,
        b: &Self::Element,
    ) -> Result<Self::Element, AlgebraError> {
        let a = self.constant_part(a, function.name())?;
        let b = self.constant_part(b, function.name())?;
        let value = self.inner.apply_two(function, &a, &b)?;
        Ok(self.trim(vec![value]))
    }
    fn apply(
        &mut self,
        function: Function,
        a: &Self::Element,
    ) -> Result<Self::Element, AlgebraError> {
        let argument = self.constant_part(a, function.name())?;
        let value = self.inner.apply(function, &argument)?;
        Ok(self.trim(vec![value]))
    }
}
