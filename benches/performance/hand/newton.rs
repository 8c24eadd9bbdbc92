//! Realization and Hamilton–Jacobi for one dimension and one trajectory: the step solver's method,
//! with nothing left to be decided at run time but what the orbit decides.
//!
//! It takes the same evaluations and rounds alike, so that orbits have the same bits as the
//! library's. It does not look whether its solution is on the branch that begins at the state.

/// The largest relative remainder that ends a solve.
const LARGEST_REMAINDER: f64 = f64::EPSILON / 1024.0;
/// How much larger than the observed convergence constant the true one may be.
const SAFETY: f64 = 16.0;
/// Below this a correction is too much round-off to observe the constant by: it bounds it.
const OBSERVABLE: f64 = 4.0 * f64::EPSILON;
/// The smallest constant that a decision relies on.
const LEAST_CONSTANT: f64 = 1.0 / 16.0;
/// A first correction whose spread is larger by this than where the constant was last observed is followed by another.
const OUTGROWN: f64 = 16.0;
/// How many times the size of a state what a step adds to it may be and still serve as a scale.
const MOST_GROWTH: f64 = 1024.0;
/// An old Jacobian does not serve a component that is smaller than this part of what it was,
const HALVED: f64 = 0.5;
/// unless it moved by less than this part of its scale.
const NOISE: f64 = 1e-6;
/// Levels of differences of the extrapolated start.
const LEVELS: usize = 12;

/// base, β̂ − base and α̂ − β̂ at y, and what tells whether y has left the chart.
pub struct Residual<const D: usize> {
    pub base: [f64; D],
    pub offset: [f64; D],
    pub increment: [f64; D],
    /// The largest entries of a guard's two sides.
    pub guard: [f64; 2],
}

/// The same with D(β̂∘L) and D((α̂ − β̂)∘L).
pub struct Full<const D: usize> {
    pub residual: Residual<D>,
    pub target: [[f64; D]; D],
    pub change: [[f64; D]; D],
}

/// The formulas of a method.
pub trait Formulas<const D: usize> {
    /// How many evaluations without Jacobians cost one with.
    const MOST_CHORDS: u32;
    /// Whether there is a series to start from.
    const HAS_SERIES: bool = false;
    /// 2 Σ tᵏ Y_k(x) for odd k.
    #[inline(always)]
    fn odd(&self, _: &[f64; D]) -> [f64; D] {
        unreachable!("asked for where there is a series")
    }
    fn residual(&self, y: &[f64; D]) -> Residual<D>;
    fn full(&self, y: &[f64; D]) -> Full<D>;
}

/// One trajectory.
pub struct Trajectory<F, const D: usize> {
    formulas: F,
    pub x: [f64; D],
    low: [f64; D],
    anchor: [f64; D],
    /// The factors of D(β̂∘L), reciprocals on the diagonal.
    factors: [[f64; D]; D],
    slope: [[f64; D]; D],
    change: [[f64; D]; D],
    scale: [f64; D],
    anchored: bool,
    /// The solution of the step before.
    before: Option<[f64; D]>,
    differences: [[f64; D]; LEVELS],
    filled: usize,
    order: usize,
    constant: f64,
    first: f64,
    seen: f64,
    pub evaluations: u64,
}

impl<F: Formulas<D>, const D: usize> Trajectory<F, D> {
    /// Whether every step begins with a Jacobian of its own.
    const BEGINS_ANEW: bool = F::HAS_SERIES && D <= 3;

    pub fn new(formulas: F, x: [f64; D]) -> Self {
        Self {
            formulas,
            x,
            low: [0.0; D],
            anchor: [0.0; D],
            factors: [[0.0; D]; D],
            slope: [[0.0; D]; D],
            change: [[0.0; D]; D],
            scale: [0.0; D],
            anchored: false,
            before: None,
            differences: [[0.0; D]; LEVELS],
            filled: 0,
            order: 0,
            constant: f64::INFINITY,
            first: f64::INFINITY,
            seen: 0.0,
            evaluations: 0,
        }
    }

    /// One step; `false` where the solve fails.
    #[inline(always)]
    pub fn step(&mut self) -> bool {
        let x = self.x;
        let mut y = x;
        let mut predicted = [0.0; D];
        if F::HAS_SERIES {
            let odd = self.formulas.odd(&x);
            let largest = |v: &[f64; D]| v.iter().fold(0.0, |m: f64, v| larger(m, v.abs()));
            for i in 0..D {
                predicted[i] = match &self.before {
                    Some(before) => (before[i] - x[i]) + odd[i],
                    None if 0.5 * largest(&odd) <= 0.25 * largest(&x) => 0.5 * odd[i],
                    None => 0.0,
                };
            }
        } else {
            for level in &self.differences[..self.order] {
                for i in 0..D {
                    predicted[i] += level[i];
                }
            }
        }
        let mut distance = 0.0;
        let mut outgrown = false;
        let mut allowed = 0.0_f64;
        for i in 0..D {
            y[i] = x[i] + predicted[i];
            allowed = at_least(x[i].abs() + predicted[i].abs(), allowed);
            if Self::BEGINS_ANEW {
                continue;
            }
            let (anchor, scale) = (self.anchor[i], self.scale[i]);
            let away = (y[i] - anchor).abs();
            distance = larger(distance, relative(away, scale));
            outgrown |= y[i].abs() < HALVED * anchor.abs() && away > NOISE * scale;
        }
        let by_old = !Self::BEGINS_ANEW
            && self.anchored
            && !outgrown
            && self.chords(distance, self.first, F::MOST_CHORDS);
        let mut is_newton = !by_old;
        let (mut last, mut spread, mut stuck) = (f64::INFINITY, f64::INFINITY, 0);
        let mut least_grown = f64::INFINITY;
        for evaluation in 0..100 {
            let Residual {
                base,
                offset,
                mut increment,
                guard,
            } = if is_newton {
                self.evaluate_full(&y)
            } else {
                self.formulas.residual(&y)
            };
            self.evaluations += 1;
            let mut correction = [0.0; D];
            let mut grown = 0.0_f64;
            for i in 0..D {
                correction[i] = x[i] - base[i] - offset[i] + self.low[i];
                grown = at_least(increment[i].abs(), grown);
            }
            self.solve(&mut correction);
            least_grown = at_most(grown, least_grown);
            if evaluation > 0 {
                allowed = at_least(least_grown, allowed);
            }
            let mut size = 0.0;
            for i in 0..D {
                let mut reach = 0.0;
                for j in 0..D {
                    reach += self.slope[i][j] * (y[j].abs() + correction[j].abs());
                }
                let own = x[i].abs() + at_most(increment[i].abs(), MOST_GROWTH * allowed);
                self.scale[i] = own + at_most(reach, allowed);
            }
            for i in 0..D {
                size = larger(size, relative(correction[i].abs(), self.scale[i]));
            }
            if !size.is_finite() || !self.anchored {
                return false;
            }
            if evaluation == 0 {
                self.first = size;
            }
            if is_newton {
                distance = 0.0;
            }
            if spread.is_finite() && spread > 0.0 {
                if evaluation == 1 {
                    self.seen = spread;
                }
                let observed = larger(size, OBSERVABLE) / spread;
                let lowered = larger(observed, 0.9 * self.constant);
                if self.constant.is_infinite() {
                    self.constant = observed;
                } else if size > OBSERVABLE || lowered < self.constant {
                    self.constant = lowered;
                }
            }
            let is_stuck = size >= 0.5 * last;
            stuck = if is_stuck { stuck + 1 } else { 0 };
            last = size;
            spread = (2.0 * distance + size) * size;
            let remainder = larger(self.constant, LEAST_CONSTANT) * spread;
            let is_observed = evaluation > 0 || spread <= OUTGROWN * self.seen;
            let noise = if is_newton { 64.0 } else { 4.0 } * f64::EPSILON;
            for i in 0..D {
                y[i] += correction[i];
            }
            if size <= LARGEST_REMAINDER
                || is_observed && SAFETY * remainder <= LARGEST_REMAINDER
                || is_stuck && size <= noise
                || stuck >= 2 && self.is_round_off(&correction)
            {
                let [first, last] = guard;
                if last != 0.0 && last >= first {
                    return false;
                }
                for i in 0..D {
                    let mut first_order = 0.0;
                    for j in 0..D {
                        first_order += self.change[i][j] * correction[j];
                    }
                    increment[i] += first_order;
                }
                if F::HAS_SERIES {
                    self.before = Some(y);
                } else {
                    self.record(&y);
                }
                self.advance(&increment);
                return true;
            }
            distance += size;
            let chord = !is_stuck && self.chords(distance, remainder, F::MOST_CHORDS + 1);
            is_newton = !chord;
        }
        false
    }

    #[inline(always)]
    fn evaluate_full(&mut self, y: &[f64; D]) -> Residual<D> {
        let Full {
            residual,
            target,
            change,
        } = self.formulas.full(y);
        self.anchor = *y;
        self.change = change;
        self.factors = target;
        for i in 0..D {
            for j in 0..D {
                let unit = f64::from(u8::from(i == j));
                self.slope[i][j] = (target[i][j] - unit).abs();
            }
        }
        self.anchored = true;
        if D <= 3 {
            self.invert();
            return residual;
        }
        for k in 0..D {
            let pivot = self.factors[k][k];
            let reciprocal = 1.0 / pivot;
            self.factors[k][k] = reciprocal;
            for row in k + 1..D {
                // Elimination without exchanges serves where partial pivoting makes none.
                self.anchored &= self.factors[row][k].abs() <= pivot.abs();
                let factor = self.factors[row][k] * reciprocal;
                self.factors[row][k] = factor;
                for column in k + 1..D {
                    self.factors[row][column] -= factor * self.factors[k][column];
                }
            }
        }
        residual
    }

    /// The inverse by cofactors, of a matrix near the identity.
    #[inline(always)]
    fn invert(&mut self) {
        let a = self.factors;
        let at = |row: usize, column: usize| a[row % D][column % D];
        let minor = at(0, 0) * at(1, 1) - at(0, 1) * at(1, 0);
        if D == 2 {
            let reciprocal = 1.0 / minor;
            let adjugate = [[at(1, 1), -at(0, 1)], [-at(1, 0), at(0, 0)]];
            for row in 0..D {
                for column in 0..D {
                    self.factors[row][column] = adjugate[row % 2][column % 2] * reciprocal;
                }
            }
        } else {
            let cofactor = |row: usize, column: usize| {
                at(row + 1, column + 1) * at(row + 2, column + 2)
                    - at(row + 1, column + 2) * at(row + 2, column + 1)
            };
            let determinant =
                at(0, 0) * cofactor(0, 0) + at(0, 1) * cofactor(0, 1) + at(0, 2) * cofactor(0, 2);
            self.anchored &= determinant > 0.5 * minor && determinant < 2.0 * minor;
            let reciprocal = 1.0 / determinant;
            for row in 0..D {
                for column in 0..D {
                    self.factors[row][column] = cofactor(column, row) * reciprocal;
                }
            }
        }
        self.anchored &= at(0, 0) > 0.5 && at(0, 0) < 2.0;
        self.anchored &= minor > 0.5 * at(0, 0) && minor < 2.0 * at(0, 0);
    }

    #[inline(always)]
    fn solve(&self, right: &mut [f64; D]) {
        if D <= 3 {
            let given = *right;
            for (value, row) in right.iter_mut().zip(&self.factors) {
                *value = row[0] * given[0];
                for column in 1..D {
                    *value += row[column] * given[column];
                }
            }
            return;
        }
        for row in 1..D {
            for column in 0..row {
                right[row] -= self.factors[row][column] * right[column];
            }
        }
        for row in (0..D).rev() {
            for column in row + 1..D {
                right[row] -= self.factors[row][column] * right[column];
            }
            right[row] *= self.factors[row][row];
        }
    }

    /// Whether `most` corrections by a Jacobian taken at `distance` reduce `error` to nothing.
    #[inline(always)]
    fn chords(&self, distance: f64, error: f64, most: u32) -> bool {
        let rate = 2.0 * larger(self.constant, LEAST_CONSTANT) * distance;
        let mut error = SAFETY * error;
        for _ in 0..most {
            error *= rate;
            if error <= LARGEST_REMAINDER {
                return true;
            }
        }
        false
    }

    /// Whether a correction is round-off beside the state as a whole.
    fn is_round_off(&self, correction: &[f64; D]) -> bool {
        largest(correction) / largest(&self.scale) <= 16.0 * f64::EPSILON
    }

    #[inline(always)]
    fn record(&mut self, y: &[f64; D]) {
        let mut carried = [0.0; D];
        for i in 0..D {
            carried[i] = y[i] - self.x[i];
        }
        let highest = (self.order + 1).min(LEVELS - 1);
        let mut errors = [0.0_f64; 3];
        for j in 0..=highest {
            let mut size = 0.0_f64;
            for i in 0..D {
                let before = self.differences[j][i];
                self.differences[j][i] = carried[i];
                size = at_least(carried[i].abs(), size);
                carried[i] -= before;
            }
            let neighbour = (j + 1).wrapping_sub(self.order);
            if neighbour < 3 {
                errors[neighbour] = at_least(size, errors[neighbour]);
            }
        }
        let order = self.order;
        self.filled = (self.filled + 1).min(highest + 1);
        let [lower, own, higher] = errors;
        self.order = if order == 0 || order + 1 < self.filled && higher < own {
            highest
        } else if order > 1 && lower < own {
            order - 1
        } else {
            order
        };
    }

    #[inline(always)]
    fn advance(&mut self, increment: &[f64; D]) {
        for i in 0..D {
            let change = increment[i] + self.low[i];
            let sum = self.x[i] + change;
            let back = sum - self.x[i];
            self.low[i] = (self.x[i] - (sum - back)) + (change - back);
            self.x[i] = sum;
        }
    }
}

/// max |v_i|.
#[inline(always)]
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| larger(m, v.abs()))
}

/// max that keeps NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// The larger of v and `least`, which is a number.
#[inline(always)]
fn at_least(v: f64, least: f64) -> f64 {
    if v > least { v } else { least }
}

/// The smaller of v and `most`, which is a number.
#[inline(always)]
fn at_most(v: f64, most: f64) -> f64 {
    if v < most { v } else { most }
}

/// size/(scale + size), 0 for 0.
#[inline(always)]
fn relative(size: f64, scale: f64) -> f64 {
    if size == 0.0 {
        0.0
    } else {
        size / (scale + size)
    }
}
