//! α, β and their tangents as numbers.

use std::collections::BTreeMap;
use std::sync::Arc;

use leafwise_core::StepError;
use leafwise_core::evaluator::{Evaluator, is_same, one_by_one};
use leafwise_core::realization::RealizationEvaluator;
use leafwise_core::solver::judge::larger;
use leafwise_core::solver::{DenseFactors, elimination_operations, substitution_operations};
use nalgebra::{DMatrix, DVector, Schur};

use crate::even_part::{Fraction, LARGEST, fractions, needed};
use crate::structure::LieAlgebra;

/// Iterations of the eigenvalue solver for each eigenvalue, ten times what it takes.
const MOST_ITERATIONS: usize = 30;

/// What the eigenvalue solver takes for 0, beside the norm: 2⁻³⁶. On multiple pairs it stalls at a
/// thousand roundings, and that near the wall α has lost all digits.
const NEGLIGIBLE: f64 = 1.0 / 68_719_476_736.0;

/// Bases in which the eigenvalue solver is tried: in one out of a thousand it goes in circles.
const MOST_BASES: usize = 8;

/// One thread's evaluator for fixed parameters and ε.
///
/// α, β = x + f(W) x ∓ ½ Z x with W = Z²/4 and f of [`even_part`](crate::even_part): the increment
/// α − β = −Z x is exact up to one product. Tangents differentiate the fractions: with
/// y = (1 + sW)⁻¹ x, ∂_p of W(1 + sW)⁻¹x is (1 + sW)⁻¹ ∂_p W y, and A(p) v = Π(v) p.
pub struct LiePoissonEvaluator {
    algebra: LieAlgebra,
    epsilon: f64,
    known: BTreeMap<usize, Arc<[Fraction]>>,
    last: Option<Point>,
    operations: u64,
}

/// What the tangents need of the last point z = (x, p).
struct Point {
    z: Vec<f64>,
    x: DVector<f64>,
    map: DMatrix<f64>,
    quarter_square: DMatrix<f64>,
    resolvents: Vec<Resolvent>,
}

/// r, s, 1 + sW and y = (1 + sW)⁻¹ x.
struct Resolvent {
    weight: f64,
    shift: f64,
    factors: Factors,
    solution: DVector<f64>,
}

/// Factors of a matrix over the algebra's dual, pivots chosen whatever the units of its coordinates.
struct Factors(DenseFactors);

impl Factors {
    /// Those of a matrix that is solved for unknowns of about these sizes; `None` where it is singular.
    fn of(matrix: &DMatrix<f64>, sizes: &DVector<f64>) -> Option<Self> {
        let mut factors = DenseFactors::new(matrix.nrows());
        let rows = matrix.transpose();
        let is_regular = factors.factor_of_sizes(rows.as_slice(), sizes.as_slice());
        is_regular.then_some(Self(factors))
    }

    fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut solution = right.clone();
        self.0.solve(solution.as_mut_slice());
        solution
    }

    fn solve_columns(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let mut rows = right.transpose();
        self.0.solve_columns(rows.as_mut_slice(), right.ncols());
        rows.transpose()
    }
}

impl LiePoissonEvaluator {
    /// An evaluator for an algebra and ε.
    pub fn new(algebra: LieAlgebra, epsilon: f64) -> Self {
        Self {
            algebra,
            epsilon,
            known: BTreeMap::new(),
            last: None,
            operations: 0,
        }
    }

    fn fractions(&mut self, bound: f64) -> Arc<[Fraction]> {
        let n = needed(bound);
        let known = self.known.entry(n);
        Arc::clone(known.or_insert_with(|| fractions(n).into()))
    }

    /// What was computed at z, by the last call or anew.
    fn known(&mut self, z: &[f64]) -> Result<Point, StepError> {
        match self.last.take() {
            Some(point) if is_same(&point.z, z) => Ok(point),
            _ => self.evaluate(z),
        }
    }

    fn evaluate(&mut self, z: &[f64]) -> Result<Point, StepError> {
        let (x, p) = z.split_at(z.len() / 2);
        let x = DVector::from_column_slice(x);
        let map = self.algebra.coadjoint(p) * self.epsilon;
        let quarter_square = &map * &map * 0.25;
        let bound = spectral_bound(&quarter_square);
        check_chart(&map, bound)?;
        let d = x.len();
        let square = (d * d) as u64;
        self.operations += self.algebra.operations() + 2 * square * d as u64 + square;
        let mut resolvents = Vec::new();
        for fraction in self.fractions(bound).iter() {
            let matrix = DMatrix::identity(d, d) + &quarter_square * fraction.shift;
            let factors = Factors::of(&matrix, &x).ok_or(SINGULAR)?;
            let solution = factors.solve(&x);
            resolvents.push(Resolvent {
                weight: fraction.weight,
                shift: fraction.shift,
                factors,
                solution,
            });
        }
        let each = 2 * square + elimination_operations(d) + substitution_operations(d);
        self.operations += resolvents.len() as u64 * each + 4 * square;
        Ok(Point {
            z: z.to_vec(),
            x,
            map,
            quarter_square,
            resolvents,
        })
    }
}

impl LiePoissonEvaluator {
    /// p ↦ ∂_p W y = ¼ ε (Π(Zy) + Z Π(y)).
    fn square_tangent(&self, point: &Point, y: &DVector<f64>) -> DMatrix<f64> {
        let image = self.algebra.tensor(&(&point.map * y));
        let through = &point.map * self.algebra.tensor(y);
        (image + through) * (0.25 * self.epsilon)
    }
}

/// After so many sweeps rows and columns of matrices of any units are alike.
const MOST_SWEEPS: usize = 16;

const SINGULAR: StepError = StepError::NonFinite {
    what: "the inverse of a function of the coadjoint map",
};

/// A bound of every eigenvalue, whatever the units of the coordinates: the norm, and where that is large the norm in units
/// that make rows and columns alike.
fn spectral_bound(matrix: &DMatrix<f64>) -> f64 {
    use std::f64::consts::PI;
    let plain = norm(matrix);
    if plain < PI * PI || !plain.is_finite() {
        return plain;
    }
    plain.min(norm(&balanced(matrix)))
}

/// S⁻¹AS with a diagonal S for which the off-diagonal sums of each row and of its column are about the same (E. Osborne, *On
/// pre-conditioning of matrices*, J. ACM 7 (1960)).
fn balanced(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (mut a, d) = (matrix.clone(), matrix.nrows());
    for _ in 0..MOST_SWEEPS {
        for i in 0..d {
            let others = (0..d).filter(|j| *j != i);
            let sums = others.map(|j| (a[(i, j)].abs(), a[(j, i)].abs()));
            let (row, column) = sums.fold((0.0, 0.0), |(r, c), (x, y)| (r + x, c + y));
            let factor = libm::sqrt(row / column);
            if factor.is_finite() && factor > 0.0 {
                a.row_mut(i).iter_mut().for_each(|v| *v /= factor);
                a.column_mut(i).iter_mut().for_each(|v| *v *= factor);
            }
        }
    }
    a
}

/// The smaller of the row sum and the column sum norm: a bound of every eigenvalue.
fn norm(matrix: &DMatrix<f64>) -> f64 {
    let rows = matrix
        .row_iter()
        .map(|row| row.iter().map(|v| v.abs()).sum::<f64>());
    let columns = matrix
        .column_iter()
        .map(|column| column.iter().map(|v| v.abs()).sum::<f64>());
    let largest = |sums: &mut dyn Iterator<Item = f64>| sums.fold(0.0, larger);
    let (rows, columns) = (
        largest(&mut rows.into_iter()),
        largest(&mut columns.into_iter()),
    );
    if rows <= columns { rows } else { columns }
}

/// Refuses Z with an eigenvalue of imaginary part 2π or more: along p ↦ τp one of them met ±2πi.
/// `bound` is a norm of Z²/4, so that |λ| ≤ 2√bound.
fn check_chart(map: &DMatrix<f64>, bound: f64) -> Result<(), StepError> {
    use std::f64::consts::PI;
    if !bound.is_finite() {
        return Err(StepError::NonFinite {
            what: "the coadjoint map",
        });
    }
    if bound > LARGEST {
        return Err(StepError::LeftChart {
            ratio: libm::sqrt(bound / LARGEST),
        });
    }
    if bound < PI * PI {
        return Ok(());
    }
    let widest = widest_frequency(&balanced(map)).ok_or(SINGULAR)?;
    if widest < 2.0 * PI {
        return Ok(());
    }
    Err(StepError::LeftChart {
        ratio: widest / (2.0 * PI),
    })
}

/// The largest |Im λ|, `None` where the solver fails in every basis.
fn widest_frequency(map: &DMatrix<f64>) -> Option<f64> {
    let d = map.nrows();
    // The solver compares an entry with its diagonal neighbours, which eigenvalues near 0 leave
    // without a size: a shift gives them one and moves no imaginary part.
    let mut shifted = map + DMatrix::identity(d, d) * norm(map);
    for basis in 1..=MOST_BASES {
        if let Some(schur) = Schur::try_new(shifted.clone(), NEGLIGIBLE, MOST_ITERATIONS * d) {
            let eigenvalues = schur.complex_eigenvalues();
            return Some(eigenvalues.iter().fold(0.0, |m: f64, v| m.max(v.im.abs())));
        }
        let mirror = DVector::from_fn(d, |i, _| libm::sin((1 + i) as f64 * basis as f64));
        let square = mirror.norm_squared();
        let reflection = DMatrix::identity(d, d) - &mirror * mirror.transpose() * (2.0 / square);
        shifted = &reflection * shifted * &reflection;
    }
    None
}

impl LiePoissonEvaluator {
    /// x, f(W) x + ½ Z x and −Z x.
    fn ends(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        self.last = None;
        let point = self.evaluate(z)?;
        let d = point.x.len();
        let mut sum = DVector::zeros(d);
        for resolvent in &point.resolvents {
            sum.axpy(resolvent.weight, &resolvent.solution, 1.0);
        }
        let even = &point.quarter_square * sum;
        let image = &point.map * &point.x;
        for i in 0..d {
            ends[i] = point.x[i];
            ends[d + i] = even[i] + 0.5 * image[i];
            ends[2 * d + i] = -image[i];
        }
        self.last = Some(point);
        Ok(())
    }

    fn tangents(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        let point = self.known(z)?;
        let d = point.x.len();
        let tensor = self.algebra.tensor(&point.x) * self.epsilon;
        let mut by_x = DMatrix::identity(d, d) + &point.map * 0.5;
        let mut by_p = &tensor * 0.5;
        for resolvent in &point.resolvents {
            let y = &resolvent.solution;
            let change = self.square_tangent(&point, y);
            by_p += resolvent.factors.solve_columns(&change) * resolvent.weight;
            by_x += resolvent.factors.solve_columns(&point.quarter_square) * resolvent.weight;
        }
        let (n, resolvents) = (d as u64, point.resolvents.len() as u64);
        let each = 2 * n * n * n + 8 * n * n + 2 * n * substitution_operations(d);
        let tensors = (2 * resolvents + 1) * self.algebra.operations();
        self.operations += resolvents * each + tensors;
        let (target, increment) = tangents.split_at_mut(2 * d * d);
        for i in 0..d {
            for k in 0..d {
                target[2 * d * i + k] = by_x[(i, k)];
                target[2 * d * i + d + k] = by_p[(i, k)];
                increment[2 * d * i + k] = -point.map[(i, k)];
                increment[2 * d * i + d + k] = -tensor[(i, k)];
            }
        }
        self.last = Some(point);
        Ok(())
    }
}

impl Evaluator for LiePoissonEvaluator {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        one_by_one(2 * self.algebra.dimension(), z, ends, |z, ends| {
            self.ends(z, ends)
        })
    }

    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        one_by_one(2 * self.algebra.dimension(), z, tangents, |z, tangents| {
            self.tangents(z, tangents)
        })
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    /// Shared by several trajectories it would factor at each point twice, for values and for Jacobians.
    fn is_pointwise(&self) -> bool {
        false
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}

impl RealizationEvaluator for LiePoissonEvaluator {
    /// With μ = (1 + sW)⁻ᵀλ and y = (1 + sW)⁻¹x, D²(λ·W(1 + sW)⁻¹x) along v and w is
    /// μ·(∂²_vw W y + ∂_v W ∂_w y + ∂_w W ∂_v y), ∂_v y = (1 + sW)⁻¹(v_x − s ∂_v W y), and
    /// μ·∂_v W u = −¼ ε v_p·(A(μ)Z + A(Zᵀμ)) u since μ·A(v)a = −v·A(μ)a.
    fn source_hessian(
        &mut self,
        z: &[f64],
        covector: &[f64],
        hessian: &mut [f64],
    ) -> Result<(), StepError> {
        let point = self.known(z)?;
        let (d, epsilon) = (point.x.len(), self.epsilon);
        let coadjoint = |v: &DVector<f64>| self.algebra.coadjoint(v.as_slice());
        let lambda = DVector::from_column_slice(covector);
        let mut mixed = coadjoint(&lambda) * (0.5 * epsilon);
        let mut by_pp = DMatrix::zeros(d, d);
        for resolvent in &point.resolvents {
            let (r, s, y) = (resolvent.weight, resolvent.shift, &resolvent.solution);
            let inverse = resolvent.factors.solve_columns(&DMatrix::identity(d, d));
            let mu = inverse.transpose() * &lambda;
            let along = coadjoint(&mu);
            let slope = (&along * &point.map + coadjoint(&(point.map.transpose() * &mu)))
                * (-0.25 * epsilon);
            let through_p = &inverse * self.square_tangent(&point, y) * -s;
            let twice = (&along * self.algebra.tensor(y)) * (-0.25 * epsilon * epsilon)
                + &slope * through_p;
            by_pp += (&twice + twice.transpose()) * r;
            mixed += slope * inverse * r;
        }
        let (n, resolvents) = (d as u64, point.resolvents.len() as u64);
        let inverse = elimination_operations(d) + n * substitution_operations(d);
        let each = 12 * n * n * n + 12 * n * n + inverse + 5 * self.algebra.operations();
        self.operations += resolvents * each;
        let entry = |row: usize, column: usize| match (row < d, column < d) {
            (true, true) => 0.0,
            (true, false) => mixed[(column - d, row)],
            (false, true) => mixed[(row - d, column)],
            (false, false) => by_pp[(row - d, column - d)],
        };
        for (at, value) in hessian.iter_mut().enumerate() {
            *value = entry(at / (2 * d), at % (2 * d));
        }
        self.last = Some(point);
        Ok(())
    }

    fn has_source_hessian(&self) -> bool {
        true
    }
}
