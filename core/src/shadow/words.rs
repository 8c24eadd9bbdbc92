//! Series of words in letters that do not commute, cut at a degree: the free algebra in which products of
//! exponentials have logarithms.

use std::collections::BTreeMap;
use std::fmt::Debug;

use leafwise_expression::Rational;

/// The letters of a word, first to last.
pub(super) type Word = Vec<u8>;

/// Coefficients of words: exact where the parts of a step are short fractions, doubles where they are roots of order
/// conditions.
pub(super) trait Coefficient: Clone + Debug {
    /// The double itself.
    fn of(value: f64) -> Self;
    /// Whether nothing is left.
    fn is_zero(&self) -> bool;
    /// a + b.
    fn plus(&self, other: &Self) -> Self;
    /// a·b.
    fn times(&self, other: &Self) -> Self;
    /// a·p/q.
    fn part(&self, p: i64, q: i64) -> Self;
    /// Its exact value.
    fn rational(&self) -> Option<Rational>;
}

impl Coefficient for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn is_zero(&self) -> bool {
        *self == 0.0
    }
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
    fn part(&self, p: i64, q: i64) -> Self {
        self * p as Self / q as Self
    }
    fn rational(&self) -> Option<Rational> {
        Rational::from_f64(*self)
    }
}

impl Coefficient for Rational {
    fn of(value: f64) -> Self {
        Self::from_f64(value).unwrap_or_else(Self::zero)
    }
    fn is_zero(&self) -> bool {
        Self::is_zero(self)
    }
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
    fn part(&self, p: i64, q: i64) -> Self {
        self * &Self::new(p, q)
    }
    fn rational(&self) -> Option<Rational> {
        Some(self.clone())
    }
}

/// Σ c_w w over words of a degree of at most `most`, a letter's degree being that of its place in `degrees`.
#[derive(Clone, Debug)]
pub(super) struct Series<'a, C> {
    pub degrees: &'a [usize],
    pub most: usize,
    pub terms: BTreeMap<Word, C>,
}

impl<'a, C: Coefficient> Series<'a, C> {
    /// 0.
    fn zero(degrees: &'a [usize], most: usize) -> Self {
        Self {
            degrees,
            most,
            terms: BTreeMap::new(),
        }
    }

    /// 1.
    pub fn one(degrees: &'a [usize], most: usize) -> Self {
        let mut one = Self::zero(degrees, most);
        one.terms.insert(Word::new(), C::of(1.0));
        one
    }

    /// Σ c_i·(letter i).
    fn linear(letters: &[(u8, C)], degrees: &'a [usize], most: usize) -> Self {
        let mut sum = Self::zero(degrees, most);
        for (letter, coefficient) in letters {
            if degrees[usize::from(*letter)] <= most {
                sum.add(vec![*letter], coefficient.clone());
            }
        }
        sum
    }

    /// The degree of a word.
    pub fn degree(&self, word: &[u8]) -> usize {
        word.iter().map(|at| self.degrees[usize::from(*at)]).sum()
    }

    fn add(&mut self, word: Word, coefficient: C) {
        let sum = match self.terms.get(&word) {
            Some(known) => known.plus(&coefficient),
            None => coefficient,
        };
        if sum.is_zero() {
            self.terms.remove(&word);
        } else {
            self.terms.insert(word, sum);
        }
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.degrees, self.most);
        let others = other.terms.iter();
        let others: Vec<_> = others.map(|(v, c)| (v, c, self.degree(v))).collect();
        for (u, a) in &self.terms {
            let room = self.most - self.degree(u);
            for (v, b, _) in others.iter().filter(|(_, _, degree)| *degree <= room) {
                product.add([u.as_slice(), v.as_slice()].concat(), a.times(b));
            }
        }
        product
    }

    fn scaled(mut self, p: i64, q: i64) -> Self {
        let terms = self.terms.values_mut();
        terms.for_each(|coefficient| *coefficient = coefficient.part(p, q));
        self
    }

    fn plus(mut self, other: &Self) -> Self {
        for (word, coefficient) in &other.terms {
            self.add(word.clone(), coefficient.clone());
        }
        self
    }

    /// The product with exp(Σ c_i·(letter i)) on the right.
    pub fn times_exponential(&self, letters: &[(u8, C)]) -> Self {
        let exponent = Self::linear(letters, self.degrees, self.most);
        let (mut sum, mut power) = (self.clone(), self.clone());
        for k in 1.. {
            power = power.times(&exponent).scaled(1, k);
            if power.terms.is_empty() {
                break;
            }
            sum = sum.plus(&power);
        }
        sum
    }

    /// ln of a series 1 + u: Σ_k (−1)^{k+1} uᵏ/k.
    pub fn logarithm(mut self) -> Self {
        self.terms.remove(&Word::new());
        let (mut sum, mut power) = (self.clone(), self.clone());
        for k in 2.. {
            power = power.times(&self);
            if power.terms.is_empty() {
                break;
            }
            let sign = if k % 2 == 0 { -1 } else { 1 };
            sum = sum.plus(&power.clone().scaled(sign, k));
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::{Coefficient, Series};
    use leafwise_expression::Rational;

    /// Dynkin's coefficients: ln(eᴬ eᴮ) = A + B + [A, B]/2 + ([A, [A, B]] + [B, [B, A]])/12 − …
    #[test]
    fn the_logarithm_of_a_product_is_that_of_baker_campbell_and_hausdorff() {
        let degrees = [1, 1];
        let one = Rational::one();
        let series = Series::<Rational>::one(&degrees, 3)
            .times_exponential(&[(0, one.clone())])
            .times_exponential(&[(1, one)])
            .logarithm();
        let of = |word: &[u8]| {
            let found = series.terms.get(word);
            found.map_or(0.0, |c| c.rational().expect("exact").to_f64())
        };
        assert_eq!([of(&[0]), of(&[1])], [1.0, 1.0]);
        assert_eq!([of(&[0, 1]), of(&[1, 0])], [0.5, -0.5]);
        let twelfth = Rational::new(1, 12).to_f64();
        // [A, [A, B]] = AAB − 2 ABA + BAA.
        assert_eq!(
            [of(&[0, 0, 1]), of(&[0, 1, 0]), of(&[1, 0, 0])],
            [twelfth, -2.0 * twelfth, twelfth]
        );
        assert_eq!(
            [of(&[1, 1, 0]), of(&[1, 0, 1]), of(&[0, 1, 1])],
            [twelfth, -2.0 * twelfth, twelfth]
        );
        assert_eq!(of(&[0, 0]), 0.0);
    }
}
