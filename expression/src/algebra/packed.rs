//! Sums of products of long polynomials, all their terms in one table.
//!
//! A term (n/D)·m has a monomial m of the state and the parameters and a numerator n over a common denominator D.
//! Exponents eₛ are in lₛ … lₛ + rₛ − 1, with weights wₛ = Π_{t before s} rₜ. The number k(m) = Σ (eₛ − lₛ) wₛ names
//! the monomial. Numbers add: k(m m′) = k(m) + k(m′) up to the constant Σ lₛ wₛ.

use rustc_hash::FxHashMap;

use super::monomial::{Monomial, Symbol};
use super::polynomial::{Coefficient, Polynomial};
use crate::rational::Rational;

/// c·a·b.
pub type Summand<'a> = (Rational, &'a Polynomial, &'a Polynomial);

/// Symbols from here on are not packed.
const MOST_SYMBOLS: usize = 256;

/// Fewer products of terms than this are formed sooner one by one.
const FEWEST_PRODUCTS: usize = 24;

/// Σ cᵢ aᵢ bᵢ, `None` where it is too short for this to pay, or where monomials do not fit 63 bits or
/// sums of numerators 127.
pub fn sum_of_products(summands: &[Summand<'_>]) -> Option<Polynomial> {
    let summands: Vec<&Summand<'_>> = summands
        .iter()
        .filter(|(c, a, b)| !c.is_zero() && !a.is_zero() && !b.is_zero())
        .collect();
    let lengths = || summands.iter().map(|(_, a, b)| (length(a), length(b)));
    let products = lengths().map(|(a, b)| a.saturating_mul(b));
    let is_single = summands.len() == 1 && lengths().all(|(a, b)| a == 1 || b == 1);
    if is_single || products.fold(0, usize::saturating_add) < FEWEST_PRODUCTS {
        return None;
    }
    let layout = Layout::new(&summands)?;
    let mut factors = Vec::with_capacity(summands.len());
    for (c, a, b) in summands {
        let (c, denominator) = c.as_words()?;
        let (mut a, mut b) = (layout.pack(a)?, layout.pack(b)?);
        if a.terms.len() > b.terms.len() {
            std::mem::swap(&mut a, &mut b);
        }
        a.denominator = denominator
            .checked_mul(a.denominator)?
            .checked_mul(b.denominator)?;
        factors.push((c, a, b));
    }
    let denominator = factors
        .iter()
        .try_fold(1, |d, (_, a, _)| least_common_multiple(d, a.denominator))?;
    let mut largest = 0_u128;
    for (c, a, b) in &mut factors {
        a.shift(layout.offset);
        a.scale(c.checked_mul(denominator / a.denominator)?)?;
        // No monomial of a·b arises more often than a has terms.
        let sum = a.largest()?.checked_mul(b.largest()?)?;
        largest = largest.checked_add(sum.checked_mul(a.terms.len() as u128)?)?;
    }
    if largest > i128::MAX.unsigned_abs() {
        return None;
    }
    let longest = factors.iter().map(|(_, _, b)| b.terms.len());
    let mut table = Table::with_room_for(longest.max().unwrap_or(0));
    for (_, a, b) in &factors {
        for &(k, n) in &a.terms {
            table.reserve(b.terms.len());
            for &(l, m) in &b.terms {
                table.add(k.wrapping_add(l), n * m);
            }
        }
    }
    Some(layout.unpack(table, denominator))
}

/// The number of terms, those of coefficients written out.
fn length(f: &Polynomial) -> usize {
    f.terms().iter().map(|(_, c)| c.terms().len()).sum()
}

/// lₛ, rₛ and wₛ of a symbol.
#[derive(Clone, Copy, Default)]
struct Digit {
    least: i64,
    radix: u64,
    weight: u64,
}

/// The digits of one kind of symbols, by symbol; those that occur nowhere have the radix 0.
type Digits = Vec<Digit>;

struct Layout {
    state: Digits,
    parameters: Digits,
    /// The weight of the first digit of the state.
    split: u64,
    /// −Σ lₛ wₛ.
    offset: u64,
}

/// Least and largest exponents, by symbol; `None` where it occurs nowhere.
type Exponents = Vec<Option<(i32, i32)>>;

impl Layout {
    fn new(summands: &[&Summand<'_>]) -> Option<Self> {
        let (mut state, mut parameters) = (Vec::new(), Vec::new());
        for (at, (_, a, b)) in summands.iter().enumerate() {
            let [a, b] = [a, b].map(|f| {
                let outer = exponents(f.terms().iter().map(|(m, _)| m));
                let inner = f.terms().iter().flat_map(|(_, c)| c.terms());
                Some((outer?, exponents(inner.map(|(m, _)| m))?))
            });
            let (a, b) = (a?, b?);
            widen(&mut state, at == 0, &a.0, &b.0);
            widen(&mut parameters, at == 0, &a.1, &b.1);
        }
        let mut weight = 1_u64;
        let mut offset = 0_u64;
        let mut digits = |ranges: Vec<Option<(i64, i64)>>| -> Option<Digits> {
            let mut digits = Vec::with_capacity(ranges.len());
            for range in ranges {
                let Some((least, most)) = range else {
                    digits.push(Digit::default());
                    continue;
                };
                let radix = (most - least) as u64 + 1;
                digits.push(Digit {
                    least,
                    radix,
                    weight,
                });
                offset = offset.wrapping_sub((least as u64).wrapping_mul(weight));
                weight = weight.checked_mul(radix).filter(|w| *w <= 1 << 63)?;
            }
            Some(digits)
        };
        let parameters = digits(parameters)?;
        let state = digits(state)?;
        let split = state
            .iter()
            .find(|d| d.radix > 0)
            .map_or(weight, |d| d.weight);
        Some(Self {
            state,
            parameters,
            split,
            offset,
        })
    }

    /// The terms of f; numbers of monomials without their constant.
    fn pack(&self, f: &Polynomial) -> Option<Packed> {
        let number = |digits: &Digits, m: &Monomial| {
            m.factors().iter().fold(0_u64, |sum, &(symbol, exponent)| {
                let weight = digits[symbol as usize].weight;
                sum.wrapping_add((i64::from(exponent) as u64).wrapping_mul(weight))
            })
        };
        let mut terms = Vec::with_capacity(length(f));
        let mut denominators = Vec::with_capacity(terms.capacity());
        let mut common = 1_i128;
        for (outer, coefficient) in f.terms() {
            let outer = number(&self.state, outer);
            for (inner, value) in coefficient.terms() {
                let (numerator, denominator) = value.as_words()?;
                common = least_common_multiple(common, denominator)?;
                terms.push((
                    outer.wrapping_add(number(&self.parameters, inner)),
                    numerator,
                ));
                denominators.push(denominator);
            }
        }
        for (term, denominator) in terms.iter_mut().zip(denominators) {
            if denominator != common {
                term.1 = term.1.checked_mul(quotient(common, denominator))?;
            }
        }
        Some(Packed {
            terms,
            denominator: common,
        })
    }

    fn unpack(&self, table: Table, denominator: i128) -> Polynomial {
        let mut sums: Vec<(u64, i128)> = table.into_sums().collect();
        let outer = ranked(&self.state, sums.iter().map(|(k, _)| k - k % self.split));
        let inner = ranked(&self.parameters, sums.iter().map(|(k, _)| k % self.split));
        for (k, _) in &mut sums {
            let rest = *k % self.split;
            *k = u64::from(outer.ranks[&(*k - rest)]) << 32 | u64::from(inner.ranks[&rest]);
        }
        sums.sort_unstable_by_key(|(rank, _)| *rank);
        let of_one_state = sums.chunk_by(|(a, _), (b, _)| a >> 32 == b >> 32);
        let terms = of_one_state.map(|sums| {
            let coefficient = sums.iter().map(|&(rank, numerator)| {
                let monomial = inner.monomials[rank as u32 as usize].clone();
                (monomial, Rational::from_words(numerator, denominator))
            });
            let monomial = outer.monomials[(sums[0].0 >> 32) as usize].clone();
            (monomial, Coefficient::from_sorted(coefficient.collect()))
        });
        Polynomial::from_sorted(terms.collect())
    }
}

/// Monomials in their [`Ord`], and where each number's stands.
struct Ranked {
    monomials: Vec<Monomial>,
    ranks: FxHashMap<u64, u32>,
}

fn ranked(digits: &Digits, numbers: impl Iterator<Item = u64>) -> Ranked {
    let mut ranks: FxHashMap<u64, u32> = numbers.map(|k| (k, 0)).collect();
    let mut known: Vec<(u128, u64)> = ranks.keys().map(|&k| (place(digits, k), k)).collect();
    known.sort_unstable();
    for (rank, (_, number)) in known.iter().enumerate() {
        ranks.insert(*number, rank as u32);
    }
    Ranked {
        monomials: known.iter().map(|(_, k)| monomial(digits, *k)).collect(),
        ranks,
    }
}

/// The symbols that occur with their exponents in a monomial of this number.
fn powers(digits: &Digits, number: u64) -> impl DoubleEndedIterator<Item = (usize, i64, &Digit)> {
    let digits = digits.iter().enumerate().filter(|(_, d)| d.radix > 0);
    digits.map(move |(symbol, digit)| {
        let exponent = match digit.radix {
            1 => digit.least,
            radix => digit.least + (number / digit.weight % radix) as i64,
        };
        (symbol, exponent, digit)
    })
}

fn monomial(digits: &Digits, number: u64) -> Monomial {
    Monomial::from_sorted(
        powers(digits, number).map(|(symbol, exponent, _)| (symbol as Symbol, exponent as i32)),
    )
}

/// A number that grows with the monomial. In the order of lists of factors an exponent 0 comes after all others where
/// a factor follows, and before them where none does.
fn place(digits: &Digits, number: u64) -> u128 {
    let (mut sum, mut weight, mut is_followed) = (0_u128, 1_u128, false);
    for (_, exponent, digit) in powers(digits, number).rev() {
        // r + 2 ≤ 2r for r ≥ 2, and Π r ≤ 2⁶³: the sum has 126 bits.
        if digit.radix > 1 {
            let rank = match exponent {
                0 if is_followed => digit.radix + 1,
                0 => 0,
                _ => (exponent - digit.least) as u64 + 1,
            };
            sum += u128::from(rank) * weight;
            weight *= u128::from(digit.radix + 2);
        }
        is_followed |= exponent != 0;
    }
    sum
}

/// The exponents that occur, `None` past [`MOST_SYMBOLS`].
fn exponents<'a>(monomials: impl Iterator<Item = &'a Monomial>) -> Option<Exponents> {
    let mut found: Vec<(usize, i32, i32)> = Vec::new();
    let mut count = 0;
    for monomial in monomials {
        count += 1;
        for &(symbol, exponent) in monomial.factors() {
            let symbol = symbol as usize;
            if symbol >= found.len() {
                if symbol >= MOST_SYMBOLS {
                    return None;
                }
                found.resize(symbol + 1, (0, i32::MAX, i32::MIN));
            }
            let (terms, least, most) = &mut found[symbol];
            *terms += 1;
            (*least, *most) = (exponent.min(*least), exponent.max(*most));
        }
    }
    let ranges = found.into_iter().map(|(terms, least, most)| match terms {
        0 => None,
        _ if terms == count => Some((least, most)),
        _ => Some((least.min(0), most.max(0))),
    });
    Some(ranges.collect())
}

/// Widens the ranges by those of products of a and b. A symbol that is new has the power 0 in all
/// products before.
fn widen(ranges: &mut Vec<Option<(i64, i64)>>, is_first: bool, a: &Exponents, b: &Exponents) {
    let length = ranges.len().max(a.len()).max(b.len());
    ranges.resize(length, None);
    for (symbol, range) in ranges.iter_mut().enumerate() {
        let [a, b] = [a, b].map(|f| f.get(symbol).copied().flatten());
        if range.is_none() && a.is_none() && b.is_none() {
            continue;
        }
        let (a, b) = (a.unwrap_or((0, 0)), b.unwrap_or((0, 0)));
        let least = i64::from(a.0) + i64::from(b.0);
        let most = i64::from(a.1) + i64::from(b.1);
        let new = if is_first { (least, most) } else { (0, 0) };
        let (l, m) = range.unwrap_or(new);
        *range = Some((l.min(least), m.max(most)));
    }
}

/// Σ (n/D) m as pairs of k(m) and n.
struct Packed {
    terms: Vec<(u64, i128)>,
    denominator: i128,
}

impl Packed {
    fn shift(&mut self, offset: u64) {
        for (k, _) in &mut self.terms {
            *k = k.wrapping_add(offset);
        }
    }

    fn scale(&mut self, factor: i128) -> Option<()> {
        if factor != 1 {
            for (_, n) in &mut self.terms {
                *n = n.checked_mul(factor)?;
            }
        }
        Some(())
    }

    fn largest(&self) -> Option<u128> {
        self.terms.iter().map(|(_, n)| n.unsigned_abs()).max()
    }
}

/// a/b of a multiple a of b.
fn quotient(a: i128, b: i128) -> i128 {
    match (u64::try_from(a), u64::try_from(b)) {
        (Ok(a), Ok(b)) => i128::from(a / b),
        _ => a / b,
    }
}

/// The least common multiple of positive numbers, `None` where it does not fit.
fn least_common_multiple(a: i128, b: i128) -> Option<i128> {
    if a == b || b == 1 {
        return Some(a);
    }
    if let (Ok(a), Ok(b)) = (u64::try_from(a), u64::try_from(b))
        && a % b == 0
    {
        return Some(i128::from(a));
    }
    let (mut divisor, mut rest) = (a, b);
    while rest != 0 {
        (divisor, rest) = (rest, divisor % rest);
    }
    (a / divisor).checked_mul(b)
}

/// Sums by number, at the place that a product with 2⁶⁴/φ gives, or the next free one.
struct Table {
    /// As many as a power of two, at most half of them taken.
    places: Vec<(u64, i128)>,
    taken: usize,
    /// 64 − log₂ of the number of places.
    shift: u32,
}

/// Of a free place: no number of a monomial has 64 bits.
const FREE: u64 = u64::MAX;

impl Table {
    fn with_room_for(sums: usize) -> Self {
        let places = (2 * sums).next_power_of_two().max(16);
        Self {
            places: vec![(FREE, 0); places],
            taken: 0,
            shift: 64 - places.trailing_zeros(),
        }
    }

    /// Grows until so many new numbers fit.
    fn reserve(&mut self, sums: usize) {
        if 2 * (self.taken + sums) <= self.places.len() {
            return;
        }
        let mut larger = Self::with_room_for(self.taken + sums);
        for &(number, value) in self.places.iter().filter(|(number, _)| *number != FREE) {
            larger.add(number, value);
        }
        *self = larger;
    }

    fn add(&mut self, number: u64, value: i128) {
        let last = self.places.len() - 1;
        let mut at = (number.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> self.shift) as usize;
        loop {
            let place = &mut self.places[at & last];
            if place.0 == number {
                place.1 += value;
                return;
            }
            if place.0 == FREE {
                *place = (number, value);
                self.taken += 1;
                return;
            }
            at += 1;
        }
    }

    /// The sums other than 0.
    fn into_sums(self) -> impl Iterator<Item = (u64, i128)> {
        let places = self.places.into_iter();
        places.filter(|(number, value)| *number != FREE && *value != 0)
    }
}

#[cfg(test)]
mod tests;
