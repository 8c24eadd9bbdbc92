//! Laurent monomials Π symbolᵏ.

use smallvec::SmallVec;

/// The index of a symbol: a variable or an adjoined generator of a ring.
pub type Symbol = u16;

/// Π sᵢ^kᵢ with nonzero integer exponents, sorted by symbol. The empty product is 1.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Monomial(SmallVec<[(Symbol, i16); 6]>);

impl Monomial {
    /// 1.
    pub fn one() -> Self {
        Self::default()
    }

    /// s^exponent.
    pub fn power(symbol: Symbol, exponent: i16) -> Self {
        let mut factors = SmallVec::new();
        if exponent != 0 {
            factors.push((symbol, exponent));
        }
        Self(factors)
    }

    /// Whether this is the empty product.
    pub fn is_one(&self) -> bool {
        self.0.is_empty()
    }

    /// The factors (symbol, exponent), by ascending symbol.
    pub fn factors(&self) -> &[(Symbol, i16)] {
        &self.0
    }

    /// The exponent of `symbol`, 0 where it does not occur.
    pub fn exponent(&self, symbol: Symbol) -> i16 {
        self.0
            .binary_search_by_key(&symbol, |f| f.0)
            .map_or(0, |at| self.0[at].1)
    }

    /// The product of two monomials.
    pub fn multiply(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut product = SmallVec::with_capacity(a.len() + b.len());
        let (mut i, mut j) = (0, 0);
        while i < a.len() && j < b.len() {
            match a[i].0.cmp(&b[j].0) {
                std::cmp::Ordering::Less => {
                    product.push(a[i]);
                    i += 1;
                }
                std::cmp::Ordering::Greater => {
                    product.push(b[j]);
                    j += 1;
                }
                std::cmp::Ordering::Equal => {
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
    pub fn shifted(&self, symbol: Symbol, change: i16) -> Self {
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
