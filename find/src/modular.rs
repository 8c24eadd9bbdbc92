//! Null spaces over ℚ of many equations, by null spaces modulo primes: numbers on the way stay short, and only the basis becomes rational.

use dashu_int::ops::{BitTest, UnsignedAbs};
use dashu_int::{IBig, UBig};
use leafwise_expression::Rational;

/// Primes that are tried; 256 of 31 bits hold fractions of 1190 digits.
const MOST_PRIMES: usize = 256;

/// A row's entries by their columns.
pub(crate) type Row = Vec<(usize, Rational)>;

/// A basis of the c with A c = 0, that of the reduced row echelon form. Each vector has 1 at a free unknown, where the others have 0. `None` where
/// it needs longer fractions than are tried.
///
/// What is found is a basis: modulo a prime the null space has at least its dimension over ℚ, and every vector is multiplied with A exactly.
pub(crate) fn null_space(rows: &[Row], unknowns: usize) -> Option<Vec<Vec<Rational>>> {
    let mut known: Option<Residues> = None;
    for prime in primes().take(MOST_PRIMES) {
        let Some(found) = null_space_modulo(rows, unknowns, prime) else {
            continue;
        };
        if found.free.is_empty() {
            return Some(Vec::new());
        }
        known = Some(match known {
            // A prime with more free unknowns, or other ones, divides a minor.
            Some(known) if known.free.len() < found.free.len() => known,
            Some(known) if known.free == found.free => known.with(&found, prime),
            _ => Residues::of(&found, prime),
        });
        let vectors = known.as_ref().and_then(Residues::rational);
        if let Some(vectors) = vectors
            && vectors
                .iter()
                .all(|v| rows.iter().all(|row| is_zero(row, v)))
        {
            return Some(vectors);
        }
    }
    None
}

fn is_zero(row: &Row, v: &[Rational]) -> bool {
    let mut sum = Rational::zero();
    for (at, entry) in row {
        if !v[*at].is_zero() {
            sum += &(entry * &v[*at]);
        }
    }
    sum.is_zero()
}

/// Primes below 2³¹, the largest first.
fn primes() -> impl Iterator<Item = u64> {
    let is_prime = |n: &u64| {
        (3..)
            .step_by(2)
            .take_while(|q| q * q <= *n)
            .all(|q| !n.is_multiple_of(q))
    };
    (1..1_u64 << 31).rev().step_by(2).filter(is_prime)
}

/// A null space modulo a prime: its free unknowns, and a vector for each.
struct Modular {
    free: Vec<usize>,
    vectors: Vec<Vec<u64>>,
}

/// `None` where the prime divides a denominator.
fn null_space_modulo(rows: &[Row], unknowns: usize, prime: u64) -> Option<Modular> {
    // Rows by their pivots, with 1 there.
    let mut pivots: Vec<Option<Vec<u64>>> = vec![None; unknowns];
    for row in rows {
        let mut rest = vec![0; unknowns];
        for (at, entry) in row {
            rest[*at] = (rest[*at] + residue(entry, prime)?) % prime;
        }
        for at in 0..unknowns {
            if rest[at] == 0 {
                continue;
            }
            match &pivots[at] {
                Some(pivot) => subtract(&mut rest, pivot, at, prime),
                None => {
                    let unit = inverse(rest[at], prime);
                    for entry in &mut rest[at..] {
                        *entry = *entry * unit % prime;
                    }
                    pivots[at] = Some(rest);
                    break;
                }
            }
        }
        if pivots.iter().all(Option::is_some) {
            break;
        }
    }
    for at in (0..unknowns).rev() {
        let (above, below) = pivots.split_at_mut(at);
        if let Some(pivot) = &below[0] {
            for row in above.iter_mut().flatten().filter(|row| row[at] != 0) {
                subtract(row, pivot, at, prime);
            }
        }
    }
    let free: Vec<usize> = (0..unknowns).filter(|at| pivots[*at].is_none()).collect();
    let vector = |&own: &usize| -> Vec<u64> {
        let entry = |(at, pivot): (usize, &Option<Vec<u64>>)| match pivot {
            Some(row) => (prime - row[own]) % prime,
            None => u64::from(at == own),
        };
        pivots.iter().enumerate().map(entry).collect()
    };
    let vectors = free.iter().map(vector).collect();
    Some(Modular { free, vectors })
}

/// row ← row − row[at] pivot.
fn subtract(row: &mut [u64], pivot: &[u64], at: usize, prime: u64) {
    let factor = prime - row[at];
    for (entry, step) in row[at..].iter_mut().zip(&pivot[at..]) {
        if *step != 0 {
            *entry = (*entry + factor * step) % prime;
        }
    }
}

/// a/b modulo the prime, `None` where it divides b.
fn residue(value: &Rational, prime: u64) -> Option<u64> {
    let below = &value.denominator() % prime;
    if below == 0 {
        return None;
    }
    let numerator = value.numerator();
    let above = &numerator.unsigned_abs() % prime;
    let above = match value.is_negative() {
        true => (prime - above) % prime,
        false => above,
    };
    Some(above * inverse(below, prime) % prime)
}

/// 1/a = a^(p − 2).
fn inverse(a: u64, prime: u64) -> u64 {
    let (mut power, mut exponent, mut product) = (a % prime, prime - 2, 1);
    while exponent > 0 {
        if exponent % 2 == 1 {
            product = product * power % prime;
        }
        power = power * power % prime;
        exponent /= 2;
    }
    product
}

/// Vectors modulo a product of primes.
struct Residues {
    free: Vec<usize>,
    modulus: UBig,
    vectors: Vec<Vec<UBig>>,
}

impl Residues {
    fn of(found: &Modular, prime: u64) -> Self {
        let vector = |v: &Vec<u64>| v.iter().map(|entry| UBig::from(*entry)).collect();
        Self {
            free: found.free.clone(),
            modulus: UBig::from(prime),
            vectors: found.vectors.iter().map(vector).collect(),
        }
    }

    /// The numbers that are these modulo the product and those modulo the prime.
    fn with(mut self, found: &Modular, prime: u64) -> Self {
        let unit = inverse(&self.modulus % prime, prime);
        let entries = self.vectors.iter_mut().flatten();
        for (entry, new) in entries.zip(found.vectors.iter().flatten()) {
            let missing = (new + prime - &*entry % prime) % prime * unit % prime;
            *entry += &self.modulus * missing;
        }
        self.modulus *= prime;
        self
    }

    /// The fractions with numerators and denominators of at most half of the modulus' digits, if all entries are some.
    fn rational(&self) -> Option<Vec<Vec<Rational>>> {
        let most = UBig::ONE << (self.modulus.bit_len().saturating_sub(2) / 2);
        let entry = |value: &UBig| fraction(value, &self.modulus, &most);
        let vector = |v: &Vec<UBig>| v.iter().map(entry).collect();
        self.vectors.iter().map(vector).collect()
    }
}

/// The fraction a/b that is the number modulo the modulus, with |a| and b at most this large: a step of Euclid's algorithm.
fn fraction(value: &UBig, modulus: &UBig, most: &UBig) -> Option<Rational> {
    let (mut r, mut next) = (modulus.clone(), value.clone());
    let (mut t, mut below) = (IBig::ZERO, IBig::ONE);
    while next > *most {
        let whole = &r / &next;
        let rest = &r - &whole * &next;
        (r, next) = (next, rest);
        let further = &t - IBig::from(whole) * &below;
        (t, below) = (below, further);
    }
    let denominator = below.clone().unsigned_abs();
    if denominator == UBig::ZERO || denominator > *most {
        return None;
    }
    let size = Rational::from(next) * Rational::from(denominator).recip();
    Some(match below < IBig::ZERO {
        true => -size,
        false => size,
    })
}

#[cfg(test)]
mod tests {
    use leafwise_expression::algebra::Elimination;

    use super::*;

    /// The same basis as by exact elimination, of drawn equations of every rank with fractions of up to twenty digits.
    #[test]
    fn null_spaces_are_those_of_exact_elimination() {
        let mut state = 7_u64;
        let mut next = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            i64::try_from((state >> 33) % below).expect("31 bits")
        };
        let mut count = 0;
        for case in 0..60 {
            let unknowns = 1 + case % 9;
            let rank = case / 9 % (unknowns + 1);
            // Combinations of `rank` rows.
            let basis: Vec<Vec<Rational>> = (0..rank)
                .map(|_| {
                    let entry = |_| match next(3) {
                        0 => Rational::zero(),
                        _ => Rational::new(next(1 << 20) - (1 << 19), 1 + next(1 << 20)),
                    };
                    (0..unknowns).map(entry).collect()
                })
                .collect();
            let rows: Vec<Row> = (0..2 * unknowns)
                .map(|_| {
                    let factors: Vec<Rational> = basis
                        .iter()
                        .map(|_| Rational::from_integer(next(9) - 4))
                        .collect();
                    let entry = |at: usize| {
                        let parts = basis.iter().zip(&factors);
                        parts.fold(Rational::zero(), |sum, (row, f)| sum + &row[at] * f)
                    };
                    (0..unknowns).map(|at| (at, entry(at))).collect()
                })
                .collect();
            let mut exact = Elimination::new(unknowns);
            rows.iter().for_each(|row| exact.add(row.iter().cloned()));
            let expected = exact.solutions().expect("homogeneous").directions;
            assert_eq!(null_space(&rows, unknowns), Some(expected), "case {case}");
            count += 1;
        }
        assert_eq!(count, 60);
    }
}
