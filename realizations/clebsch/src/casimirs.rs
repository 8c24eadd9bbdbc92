//! Quadratic Casimirs of a linear tensor, found exactly, and what rounding adds to them.

use std::collections::BTreeMap;

use leafwise_core::two_sum;
use leafwise_expression::Rational;

use crate::constants::Constants;
use crate::least::Rows;

/// Σ c x_i x_j over these ((i, j), c) with i ≤ j.
pub type Square = BTreeMap<(usize, usize), Rational>;

/// A basis of the homogeneous quadratic C with Σ_j Π_ij ∂_j C = 0 for every i.
pub fn quadratic_casimirs(constants: &Constants) -> Vec<Square> {
    let d = constants.dimension();
    let name = |i: usize, j: usize| (i.min(j), i.max(j));
    let mut solved: BTreeMap<(usize, usize), Square> = BTreeMap::new();
    for i in 0..d {
        // Σ_jk c_ij^k x_k ∂_j C, monomial by monomial.
        let mut equations: BTreeMap<(usize, usize), Square> = BTreeMap::new();
        for j in 0..d {
            for (k, c) in constants.bracket(i, j) {
                for l in 0..d {
                    let twice = Rational::from_integer(if j == l { 2 } else { 1 });
                    let equation = equations.entry(name(*k, l)).or_default();
                    *equation.entry(name(j, l)).or_default() += &(c * &twice);
                }
            }
        }
        for equation in equations.into_values() {
            eliminate(&mut solved, equation);
        }
    }
    let unknowns = (0..d).flat_map(|i| (i..d).map(move |j| (i, j)));
    let free = unknowns.filter(|unknown| !solved.contains_key(unknown));
    let basis = free.map(|free| {
        let bound = solved.iter().filter_map(|(pivot, equation)| {
            let c = equation.get(&free)?;
            Some((*pivot, -c))
        });
        bound.chain([(free, Rational::one())]).collect()
    });
    basis.collect()
}

/// Adds an equation Σ c u = 0 to a reduced system: each of its equations has a pivot with c = 1 where all others have 0.
fn eliminate(solved: &mut BTreeMap<(usize, usize), Square>, mut equation: Square) {
    let add = |to: &mut Square, factor: &Rational, other: &Square| {
        for (unknown, c) in other {
            let entry = to.entry(*unknown).or_default();
            *entry += &(factor * c);
            if entry.is_zero() {
                to.remove(unknown);
            }
        }
    };
    equation.retain(|_, c| !c.is_zero());
    let known: Vec<_> = equation
        .iter()
        .filter(|(unknown, _)| solved.contains_key(unknown))
        .map(|(unknown, c)| (*unknown, -c))
        .collect();
    for (unknown, factor) in known {
        add(&mut equation, &factor, &solved[&unknown]);
    }
    let Some((pivot, c)) = equation.iter().next().map(|(at, c)| (*at, c.recip())) else {
        return;
    };
    equation.values_mut().for_each(|entry| *entry *= &c);
    for other in solved.values_mut() {
        if let Some(c) = other.get(&pivot) {
            let factor = -c;
            add(other, &factor, &equation);
        }
    }
    solved.insert(pivot, equation);
}

/// Casimirs as numbers, for [`hold`](Self::hold).
#[derive(Clone, Debug)]
pub struct Held {
    squares: Vec<Vec<(usize, usize, f64)>>,
}

/// Casimirs that are held; further ones are left to rounding.
const MOST: usize = 4;

/// Variables of an algebra.
const WIDEST: usize = 36;

impl Held {
    /// These.
    pub fn of(squares: &[Square]) -> Self {
        let numbers = |square: &Square| {
            let terms = square.iter();
            terms.map(|((i, j), c)| (*i, *j, c.to_f64())).collect()
        };
        Self {
            squares: squares.iter().take(MOST).map(numbers).collect(),
        }
    }

    /// Takes off the change of the Casimirs by rounding, with the smallest change of the `increment`. That change is
    /// some 1e-16 of them, and its mean would show. Returns the largest such change, as a part of Σ |c x_i x_j| at the
    /// end.
    pub fn hold(&self, x: &[f64], low: &[f64], increment: &mut [f64]) -> f64 {
        match (self.squares.len(), x.len()) {
            (0, _) => 0.0,
            (1..=2, 0..=6) => self.hold_in::<2, 6>(x, low, increment),
            _ => self.hold_in::<MOST, WIDEST>(x, low, increment),
        }
    }

    fn hold_in<const C: usize, const D: usize>(
        &self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
    ) -> f64 {
        let mut rows = Rows::<C, D>::new(self.squares.len(), x.len());
        let mut growth = [0.0; C];
        let mut held = 0.0_f64;
        for ((square, row), growth) in self.squares.iter().zip(&mut rows.rows).zip(&mut growth) {
            *growth = grown(square, x, low, increment);
            let mut size = 0.0;
            for (i, j, c) in square {
                let (first, second) = (x[*i] + increment[*i], x[*j] + increment[*j]);
                row[*i] += c * second;
                row[*j] += c * first;
                size += (c * first * second).abs();
            }
            let part = growth.abs() / size;
            held = held.max(if size > 0.0 { part } else { 0.0 });
        }
        rows.factor();
        rows.solve(&mut growth);
        growth.iter_mut().for_each(|growth| *growth = -*growth);
        if !growth.iter().all(|growth| growth.is_finite()) {
            return 0.0;
        }
        rows.add_combination(&growth, increment);
        held
    }
}

/// C(x + low + δ) − C(x + low), rounded once or so: Σ c ((x_i + δ_i) δ_j + x_j δ_i).
pub fn grown(square: &[(usize, usize, f64)], x: &[f64], low: &[f64], delta: &[f64]) -> f64 {
    let (mut sum, mut rest) = (0.0, 0.0);
    for &(i, j, c) in square {
        let (moved, cut) = two_sum(x[i], delta[i]);
        let mut add = |a: f64, b: f64| {
            let (product, error) = two_product(a, b);
            let (product, scaling) = scaled(c, product);
            let (next, lost) = two_sum(sum, product);
            sum = next;
            rest += lost + scaling + c * error;
        };
        if i == j {
            // 2x + δ = x + (x + δ), both parts of which are known.
            let (both, error) = two_sum(x[i], moved);
            add(both, delta[i]);
            rest += c * (error + cut) * delta[i];
        } else {
            add(moved, delta[j]);
            add(x[j], delta[i]);
            rest += c * cut * delta[j];
        }
        rest += c * (low[i] * delta[j] + low[j] * delta[i]);
    }
    sum + rest
}

/// c a as a sum of two doubles; of c = ±1, the most frequent, at once.
fn scaled(c: f64, a: f64) -> (f64, f64) {
    if c.abs() == 1.0 {
        (c * a, 0.0)
    } else {
        two_product(c, a)
    }
}

/// a b as a sum of two doubles (T. J. Dekker, Numerische Mathematik 18 (1971)).
fn two_product(a: f64, b: f64) -> (f64, f64) {
    const SPLIT: f64 = 134_217_729.0;
    let halves = |v: f64| {
        let shifted = SPLIT * v;
        let high = shifted - (shifted - v);
        (high, v - high)
    };
    let (product, (a_high, a_low), (b_high, b_low)) = (a * b, halves(a), halves(b));
    let error = a_high * b_high - product + a_high * b_low + a_low * b_high + a_low * b_low;
    (product, error)
}
