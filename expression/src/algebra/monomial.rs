//! Laurent monomials Π symbolᵏ.

use std::cmp::Ordering;

use smallvec::SmallVec;

/// The index of a symbol: a variable or an adjoined generator of a ring.
pub type Symbol = u32;

/// Π sᵢ^kᵢ with nonzero integer exponents, sorted by symbol. The empty product is 1.
///
/// Their [`Ord`] is the order in which sums list their terms. Products do not keep it: who needs the
/// larger of two monomials times a third one takes [`compare`](Self::compare).
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Monomial(SmallVec<[(Symbol, i32); 6]>);

impl Monomial {
    /// 1.
    pub fn one() -> Self {
        Self::default()
    }

    /// s^exponent.
    pub fn power(symbol: Symbol, exponent: i32) -> Self {
        let mut factors = SmallVec::new();
        if exponent != 0 {
            factors.push((symbol, exponent));
        }
        Self(factors)
    }

    /// The product of powers by ascending symbol; exponents may be 0.
    pub(super) fn from_sorted(powers: impl Iterator<Item = (Symbol, i32)>) -> Self {
        Self(powers.filter(|(_, exponent)| *exponent != 0).collect())
    }

    /// Whether this is the empty product.
    pub fn is_one(&self) -> bool {
        self.0.is_empty()
    }

    /// The factors (symbol, exponent), by ascending symbol.
    pub fn factors(&self) -> &[(Symbol, i32)] {
        &self.0
    }

    /// The exponent of `symbol`, 0 where it does not occur.
    pub fn exponent(&self, symbol: Symbol) -> i32 {
        self.0
            .binary_search_by_key(&symbol, |f| f.0)
            .map_or(0, |at| self.0[at].1)
    }

    /// The largest |kᵢ|.
    pub fn largest_exponent(&self) -> u32 {
        let sizes = self.0.iter().map(|f| f.1.unsigned_abs());
        sizes.max().unwrap_or(0)
    }

    /// The lexicographic order of exponents, of either sign, from the last symbol on: m < n exactly
    /// where mk < nk. A generator stands above what it was adjoined for.
    pub fn compare(&self, other: &Self) -> Ordering {
        let (mut a, mut b) = (self.0.iter().rev(), other.0.iter().rev());
        let (mut left, mut right) = (a.next(), b.next());
        loop {
            match (left, right) {
                (None, None) => return Ordering::Equal,
                (Some(&(_, k)), None) => return k.cmp(&0),
                (None, Some(&(_, l))) => return 0.cmp(&l),
                (Some(&(s, k)), Some(&(t, l))) => match s.cmp(&t) {
                    Ordering::Greater => return k.cmp(&0),
                    Ordering::Less => return 0.cmp(&l),
                    Ordering::Equal if k != l => return k.cmp(&l),
                    Ordering::Equal => (left, right) = (a.next(), b.next()),
                },
            }
        }
    }

    /// The product of two monomials, of exponents whose sums fit.
    pub fn multiply(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut product = SmallVec::new();
        let (mut i, mut j) = (0, 0);
        while i < a.len() && j < b.len() {
            match a[i].0.cmp(&b[j].0) {
                Ordering::Less => {
                    product.push(a[i]);
                    i += 1;
                }
                Ordering::Greater => {
                    product.push(b[j]);
                    j += 1;
                }
                Ordering::Equal => {
                    let exponent = a[i].1 + b[j].1;
                    if exponent != 0 {
                        product.push((a[i].0, exponent));
                    }
                    i += 1;
                    j += 1;
                }
            }
        }
        product.extend_from_slice(&a[i..]);
        product.extend_from_slice(&b[j..]);
        Self(product)
    }

    /// 1/m.
    pub fn inverse(&self) -> Self {
        Self(self.0.iter().map(|&(s, e)| (s, -e)).collect())
    }

    /// The same monomial with the exponent of `symbol` changed by `change`.
    pub fn shifted(&self, symbol: Symbol, change: i32) -> Self {
        self.multiply(&Self::power(symbol, change))
    }

    /// Per symbol of either, the smaller exponent (0 where a symbol is absent): the content that
    /// two Laurent monomials share.
    pub fn common(&self, other: &Self) -> Self {
        let mut symbols: SmallVec<[Symbol; 12]> =
            self.0.iter().chain(&other.0).map(|f| f.0).collect();
        symbols.sort_unstable();
        symbols.dedup();
        Self(
            symbols
                .into_iter()
                .map(|s| (s, self.exponent(s).min(other.exponent(s))))
                .filter(|f| f.1 != 0)
                .collect(),
        )
    }

    /// Whether every exponent of `other` is positive and at most the one here.
    pub fn is_multiple_of(&self, other: &Self) -> bool {
        other.0.iter().all(|&(s, e)| e > 0 && self.exponent(s) >= e)
    }
}
