//! Jacobi's identity of affine tensors, quadratic in their coefficients, solved by Levenberg and Marquardt in doubles and rounded to
//! rationals one coefficient at a time.

use leafwise_expression::Rational;

use crate::identity::Identity;

/// Residuals below this, relative to the square of the coefficients' size, are taken for zero. A proof follows.
const SOLVED: f64 = 1e-11;

/// Residuals at which no further iteration helps.
const ROUND_OFF: f64 = 1e-15;

/// Iterations of the first solve, and of one near a solution.
const MOST_ITERATIONS: usize = 120;
const MOST_NEAR: usize = 40;

/// Iterations in which the sum of squares halves at least.
const PATIENCE: usize = 8;

/// The largest denominator of a coefficient that is rounded.
const MOST_DENOMINATOR: i64 = 1 << 20;

/// A fraction with a denominator up to this one that is as near as this is taken for the coefficient: others that are as near have larger
/// denominators.
const SIMPLE: i64 = 1 << 18;
const NEAR: f64 = 1e-13;

/// The affine space of coefficients c = `origin` + Σ tₖ `directions[k]`.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    pub origin: Vec<Rational>,
    pub directions: Vec<Vec<Rational>>,
}

impl Space {
    /// The part of it in which the coefficient `at` has this value, `None` where there is none.
    fn with(&self, at: usize, value: &Rational) -> Option<Self> {
        let missing = value - &self.origin[at];
        // The sparsest direction fills the fewest entries.
        let with_entry = (0..self.directions.len()).filter(|&k| !self.directions[k][at].is_zero());
        let filled = |k: &usize| self.directions[*k].iter().filter(|e| !e.is_zero()).count();
        let Some(chosen) = with_entry.min_by_key(filled) else {
            return missing.is_zero().then(|| self.clone());
        };
        let pivot = &self.directions[chosen];
        let unit = pivot[at].recip();
        let moved = |from: &[Rational], factor: &Rational| -> Vec<Rational> {
            (from.iter().zip(pivot))
                .map(|(entry, step)| entry + factor * step)
                .collect()
        };
        let directions = self.directions.iter().enumerate();
        Some(Self {
            origin: moved(&self.origin, &(&missing * &unit)),
            directions: directions
                .filter(|(k, _)| *k != chosen)
                .map(|(_, other)| moved(other, &-(&other[at] * &unit)))
                .collect(),
        })
    }

    fn is_free(&self, at: usize) -> bool {
        self.directions
            .iter()
            .any(|direction| !direction[at].is_zero())
    }
}

/// The same in doubles: c = `scale` (`origin` + Σ tₖ `directions[k]`) with orthonormal directions, and the smallest c for the origin.
struct Doubles {
    scale: f64,
    origin: Vec<f64>,
    directions: Vec<Vec<f64>>,
}

impl Doubles {
    fn of(space: &Space) -> Self {
        let doubles = |v: &Vec<Rational>| -> Vec<f64> { v.iter().map(Rational::to_f64).collect() };
        let mut directions: Vec<Vec<f64>> = Vec::new();
        for direction in &space.directions {
            let mut direction = doubles(direction);
            normalize(&mut direction);
            // Twice is enough.
            for _ in 0..2 {
                without(&mut direction, &directions);
            }
            normalize(&mut direction);
            directions.push(direction);
        }
        let mut origin = doubles(&space.origin);
        for _ in 0..2 {
            without(&mut origin, &directions);
        }
        let scale = normalize(&mut origin);
        Self {
            scale,
            origin,
            directions,
        }
    }

    /// c over the scale.
    fn at(&self, t: &[f64]) -> Vec<f64> {
        let mut c = self.origin.clone();
        for (factor, direction) in t.iter().zip(&self.directions) {
            for (entry, step) in c.iter_mut().zip(direction) {
                *entry += factor * step;
            }
        }
        c
    }

    /// t for which c(t) is nearest to `c`.
    fn nearest(&self, c: &[f64]) -> Vec<f64> {
        let along = |direction: &Vec<f64>| dot(c, direction) / self.scale;
        self.directions.iter().map(along).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes away the parts along orthonormal vectors.
fn without(v: &mut [f64], directions: &[Vec<f64>]) {
    for direction in directions {
        let part = dot(v, direction);
        for (entry, step) in v.iter_mut().zip(direction) {
            *entry -= part * step;
        }
    }
}

/// v/|v|, and |v|; 0 stays as it is with the length 1.
fn normalize(v: &mut [f64]) -> f64 {
    let length = libm::sqrt(dot(v, v));
    if length == 0.0 {
        return 1.0;
    }
    for entry in v.iter_mut() {
        *entry /= length;
    }
    length
}

/// The solution of a linear system given by its rows with the right side behind, by pivots in the column.
fn eliminate(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for column in 0..n {
        let pivot =
            (column..n).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))?;
        if rows[pivot][column].abs() < 1e-300 {
            return None;
        }
        rows.swap(column, pivot);
        let lead = rows[column].clone();
        for row in rows.iter_mut().skip(column + 1) {
            let factor = row[column] / lead[column];
            if factor != 0.0 {
                for (entry, above) in row.iter_mut().zip(&lead).skip(column) {
                    *entry -= factor * above;
                }
            }
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| rows[row][k] * x[k]).sum();
        x[row] = (rows[row][n] - known) / rows[row][row];
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}

/// c with B(c, c) = 0 from a start t.
fn solve(
    identity: &Identity,
    space: &Doubles,
    start: Vec<f64>,
    iterations: usize,
) -> Option<Vec<f64>> {
    let residual = |t: &[f64]| {
        let (c, mut r) = (space.at(t), Vec::new());
        identity.bilinear(&c, &c, &mut r);
        r
    };
    let slopes = |t: &[f64]| {
        let c = space.at(t);
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let slope = |direction: &Vec<f64>| -> Vec<f64> {
            identity.bilinear(&c, direction, &mut left);
            identity.bilinear(direction, &c, &mut right);
            left.iter().zip(&right).map(|(a, b)| a + b).collect()
        };
        space.directions.iter().map(slope).collect()
    };
    let scale = |t: &[f64]| norm(&space.at(t));
    let t = least_squares(start, iterations, (&residual, &slopes, &scale))?;
    let c = space.at(&t);
    Some(c.iter().map(|entry| space.scale * entry).collect())
}

fn norm(r: &[f64]) -> f64 {
    r.iter().map(|v| v * v).sum()
}

/// Quadratic equations: their values, their columns of derivatives, and the square of the unknowns' size, all at unknowns t.
pub(crate) type Quadratic<'a> = (
    &'a dyn Fn(&[f64]) -> Vec<f64>,
    &'a dyn Fn(&[f64]) -> Vec<Vec<f64>>,
    &'a dyn Fn(&[f64]) -> f64,
);

/// A zero from a start, by Levenberg and Marquardt with a damping in proportion to the residual.
pub(crate) fn least_squares(
    start: Vec<f64>,
    iterations: usize,
    (residual, slopes_at, scale): Quadratic<'_>,
) -> Option<Vec<f64>> {
    let p = start.len();
    let mut t = start;
    let mut r = residual(&t);
    let mut size = norm(&r);
    let mut damping = 1.0;
    let mut last = f64::INFINITY;
    for iteration in 1..=iterations {
        if iteration % PATIENCE == 0 {
            if size > 0.5 * last {
                break;
            }
            last = size;
        }
        if size <= square(ROUND_OFF * scale(&t)) {
            break;
        }
        let slopes = slopes_at(&t);
        let mut matrix = vec![vec![0.0; p + 1]; p];
        for k in 0..p {
            for l in 0..=k {
                let entry = slopes[k].iter().zip(&slopes[l]).map(|(a, b)| a * b).sum();
                matrix[k][l] = entry;
                matrix[l][k] = entry;
            }
            matrix[k][p] = -slopes[k].iter().zip(&r).map(|(a, b)| a * b).sum::<f64>();
        }
        let lambda = damping * size + 1e-30;
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] += lambda;
        }
        let step = eliminate(matrix)?;
        let trial: Vec<f64> = t.iter().zip(&step).map(|(t, s)| t + s).collect();
        let trial_r = residual(&trial);
        let trial_size = norm(&trial_r);
        if trial_size < size {
            (t, r, size) = (trial, trial_r, trial_size);
            damping *= 0.3;
        } else {
            damping *= 8.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    (size <= square(SOLVED * scale(&t))).then_some(t)
}

fn square(v: f64) -> f64 {
    v * v
}

/// A sparse rational c in the space with B(c, c) = 0, `None` where none is found from `starts` starts.
pub(crate) fn sparse_solution(
    identity: &Identity,
    space: &Space,
    starts: usize,
) -> Option<Vec<Rational>> {
    let doubles = Doubles::of(space);
    let p = space.directions.len();
    let mut phase = 0.25_f64;
    for start in 0..if p == 0 { 1 } else { starts } {
        let t = match start {
            // The smallest c.
            0 => vec![0.0; p],
            _ => (0..p)
                .map(|_| {
                    phase = (phase + 0.618_033_988_749_894_9) % 1.0;
                    2.0 * phase - 1.0
                })
                .collect(),
        };
        if let Some(c) = solve(identity, &doubles, t, MOST_ITERATIONS) {
            return simplified(identity, space.clone(), c);
        }
    }
    None
}

/// A sparse rational solution near one in doubles.
///
/// Coefficients are set to 0 one after the other, the smallest first, as long as the identity can still be solved. Those that
/// stay free are rounded to simple fractions.
fn simplified(identity: &Identity, mut space: Space, mut c: Vec<f64>) -> Option<Vec<Rational>> {
    let mut order: Vec<usize> = (0..c.len()).collect();
    order.sort_by(|&a, &b| c[a].abs().total_cmp(&c[b].abs()));
    for at in order {
        if let Some(smaller) = restricted(identity, &space, &c, at, &Rational::zero()) {
            (space, c) = smaller;
        }
    }
    while let Some(at) = (0..c.len()).find(|&at| space.is_free(at)) {
        let values = fractions(c[at]);
        let smaller = values
            .iter()
            .find_map(|value| restricted(identity, &space, &c, at, value))?;
        (space, c) = smaller;
    }
    Some(space.origin).filter(|c| identity.holds(c))
}

/// The solution in the part of the space where the coefficient `at` has this value, near `c`.
fn restricted(
    identity: &Identity,
    space: &Space,
    c: &[f64],
    at: usize,
    value: &Rational,
) -> Option<(Space, Vec<f64>)> {
    if !space.is_free(at) {
        return None;
    }
    let space = space.with(at, value)?;
    let doubles = Doubles::of(&space);
    let start = doubles.nearest(c);
    let c = solve(identity, &doubles, start, MOST_NEAR)?;
    Some((space, c))
}

/// Convergents of the continued fraction of v, the simplest first, but one that is v to round-off before all others.
pub(crate) fn fractions(v: f64) -> Vec<Rational> {
    let mut found = Vec::new();
    let (mut rest, mut last, mut next) = (v, (0_i64, 1_i64), (1_i64, 0_i64));
    for _ in 0..24 {
        let whole = libm::floor(rest);
        if whole.abs() > 1e9 {
            break;
        }
        let whole_number = whole as i64;
        let convergent = (
            whole_number.saturating_mul(next.0).saturating_add(last.0),
            whole_number.saturating_mul(next.1).saturating_add(last.1),
        );
        if convergent.1.abs() > MOST_DENOMINATOR || convergent.1 == 0 {
            break;
        }
        found.push(Rational::new(convergent.0, convergent.1));
        (last, next) = (next, convergent);
        let part = rest - whole;
        if part.abs() < 1e-9 {
            break;
        }
        rest = 1.0 / part;
    }
    let is_near = |r: &Rational| (r.to_f64() - v).abs() <= NEAR * v.abs().max(1.0);
    let is_simple = |r: &Rational| r.denominator() <= SIMPLE.unsigned_abs().into();
    if let Some(at) = found.iter().position(|r| is_near(r) && is_simple(r)) {
        let simple = found.remove(at);
        found.insert(0, simple);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fraction_itself_comes_first() {
        for (above, below) in [(1, 1), (-3, 7), (51, 100), (0, 1), (355, 113)] {
            let found = fractions(f64::from(above) / f64::from(below));
            assert_eq!(
                found.first(),
                Some(&Rational::new(above.into(), below.into()))
            );
        }
    }
}
