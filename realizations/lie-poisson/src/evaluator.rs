//! α, β and their tangents as numbers.

use std::array::from_fn;
use std::collections::BTreeMap;
use std::sync::Arc;

use leafwise_core::StepError;
use leafwise_core::evaluator::{Evaluator, is_same, one_by_one};
use leafwise_core::solver::{
    DenseFactors, elimination_operations, product, substitution_operations,
};

use crate::chart::{SINGULAR, check_chart, spectral_bound};
use crate::even_part::{Fraction, fractions, needed};
use crate::structure::LieAlgebra;

/// One thread's evaluator for fixed parameters and ε.
///
/// It evaluates α, β = x + f(W) x ∓ ½ Z x with W = Z²/4 and f of [`even_part`](crate::even_part). The increment
/// α − β = −Z x is exact up to one product. Tangents differentiate the fractions: with y = (1 + sW)⁻¹ x, ∂_p of W(1 +
/// sW)⁻¹x is (1 + sW)⁻¹ ∂_p W y, and A(p) v = Π(v) p.
///
/// Matrices are row-major, in memory that is kept from point to point.
pub struct LiePoissonEvaluator {
    algebra: LieAlgebra,
    epsilon: f64,
    known: BTreeMap<usize, Arc<[Fraction]>>,
    /// The last point, and whether all of it was computed.
    last: Point,
    is_known: bool,
    room: Room,
    operations: u64,
}

/// The last point z = (x, p) with its matrices and resolvents, from which tangents are computed.
struct Point {
    z: Vec<f64>,
    map: Vec<f64>,
    quarter_square: Vec<f64>,
    /// Those of the fractions, and room of further ones of earlier points.
    resolvents: Vec<Resolvent>,
    count: usize,
}

/// r, s, 1 + sW and y = (1 + sW)⁻¹ x.
struct Resolvent {
    weight: f64,
    shift: f64,
    factors: DenseFactors,
    solution: Vec<f64>,
}

/// Room for a vector, matrices and two of them side by side.
struct Room {
    vector: Vec<f64>,
    matrix: Vec<f64>,
    tensor: Vec<f64>,
    through: Vec<f64>,
    pair: Vec<f64>,
}

impl Point {
    fn new(d: usize) -> Self {
        Self {
            z: vec![0.0; 2 * d],
            map: vec![0.0; d * d],
            quarter_square: vec![0.0; d * d],
            resolvents: Vec::new(),
            count: 0,
        }
    }

    fn x(&self) -> &[f64] {
        &self.z[..self.z.len() / 2]
    }

    fn resolvents(&self) -> &[Resolvent] {
        &self.resolvents[..self.count]
    }

    /// Factors 1 + sW and solves for y, in `matrix`; the pivots depend on no units.
    fn resolve(&mut self, fraction: &Fraction, matrix: &mut [f64]) -> Result<(), StepError> {
        let d = self.z.len() / 2;
        if self.count == self.resolvents.len() {
            self.resolvents.push(Resolvent::new(d));
        }
        let (x, resolvent) = (&self.z[..d], &mut self.resolvents[self.count]);
        resolvent.weight = fraction.weight;
        resolvent.shift = fraction.shift;
        for (entry, w) in matrix.iter_mut().zip(&self.quarter_square) {
            *entry = w * fraction.shift;
        }
        matrix.iter_mut().step_by(d + 1).for_each(|v| *v += 1.0);
        if !resolvent.factors.factor_of_sizes(matrix, x) {
            return Err(SINGULAR);
        }
        resolvent.solution.copy_from_slice(x);
        resolvent.factors.solve(&mut resolvent.solution);
        self.count += 1;
        Ok(())
    }
}

impl Resolvent {
    fn new(d: usize) -> Self {
        Self {
            weight: 0.0,
            shift: 0.0,
            factors: DenseFactors::new(d),
            solution: vec![0.0; d],
        }
    }
}

impl Room {
    fn new(d: usize) -> Self {
        let matrix = || vec![0.0; d * d];
        Self {
            vector: vec![0.0; d],
            matrix: matrix(),
            tensor: matrix(),
            through: matrix(),
            pair: vec![0.0; 2 * d * d],
        }
    }
}

fn scale(numbers: &mut [f64], factor: f64) {
    numbers.iter_mut().for_each(|v| *v *= factor);
}

impl LiePoissonEvaluator {
    /// An evaluator for an algebra and ε.
    pub fn new(algebra: LieAlgebra, epsilon: f64) -> Self {
        let d = algebra.dimension();
        Self {
            algebra,
            epsilon,
            known: BTreeMap::new(),
            last: Point::new(d),
            is_known: false,
            room: Room::new(d),
            operations: 0,
        }
    }

    fn fractions(&mut self, bound: f64) -> Arc<[Fraction]> {
        let n = needed(bound);
        let known = self.known.entry(n);
        Arc::clone(known.or_insert_with(|| fractions(n).into()))
    }

    /// Computes what the tangents need at z where the last call did not.
    fn know(&mut self, z: &[f64]) -> Result<(), StepError> {
        if self.is_known && is_same(&self.last.z, z) {
            return Ok(());
        }
        self.evaluate(z)
    }

    fn evaluate(&mut self, z: &[f64]) -> Result<(), StepError> {
        self.is_known = false;
        let d = self.algebra.dimension();
        let last = &mut self.last;
        last.z.copy_from_slice(z);
        last.count = 0;
        self.algebra.coadjoint(&z[d..], &mut last.map);
        scale(&mut last.map, self.epsilon);
        product(&last.map, &last.map, d, &mut last.quarter_square);
        scale(&mut last.quarter_square, 0.25);
        let bound = spectral_bound(&last.quarter_square, d);
        check_chart(&last.map, d, bound)?;
        let square = (d * d) as u64;
        self.operations += self.algebra.operations() + 2 * square * d as u64 + square;
        for fraction in self.fractions(bound).iter() {
            self.last.resolve(fraction, &mut self.room.matrix)?;
        }
        let each = 2 * square + elimination_operations(d) + substitution_operations(d);
        self.operations += self.last.count as u64 * each + 4 * square;
        self.is_known = true;
        Ok(())
    }
}

/// Leaves p ↦ ∂_p W y = ¼ ε (Π(Zy) + Z Π(y)) in `room.matrix` and Π(y) in `room.tensor`.
fn write_square_tangent(
    (algebra, epsilon): (&LieAlgebra, f64),
    map: &[f64],
    y: &[f64],
    room: &mut Room,
) {
    let d = y.len();
    algebra.tensor(y, &mut room.tensor);
    product(map, &room.tensor, d, &mut room.through);
    product(map, y, 1, &mut room.vector);
    algebra.tensor(&room.vector, &mut room.matrix);
    for (change, through) in room.matrix.iter_mut().zip(&room.through) {
        *change = (*change + through) * (0.25 * epsilon);
    }
}

impl LiePoissonEvaluator {
    /// x, f(W) x + ½ Z x and −Z x.
    fn ends(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(z)?;
        let (last, d) = (&self.last, self.algebra.dimension());
        let sum = &mut self.room.vector;
        sum.fill(0.0);
        for resolvent in last.resolvents() {
            for (sum, y) in sum.iter_mut().zip(&resolvent.solution) {
                *sum += resolvent.weight * y;
            }
        }
        let (base, rest) = ends.split_at_mut(d);
        let (offset, increment) = rest.split_at_mut(d);
        base.copy_from_slice(last.x());
        product(&last.quarter_square, sum, 1, offset);
        product(&last.map, last.x(), 1, increment);
        for (offset, increment) in offset.iter_mut().zip(increment) {
            *offset += 0.5 * *increment;
            *increment = -*increment;
        }
        Ok(())
    }

    fn tangents(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        self.know(z)?;
        let (last, room, d) = (&self.last, &mut self.room, self.algebra.dimension());
        let (target, increment) = tangents.split_at_mut(2 * d * d);
        self.algebra.tensor(last.x(), &mut room.tensor);
        scale(&mut room.tensor, self.epsilon);
        let rows = target
            .chunks_exact_mut(2 * d)
            .zip(increment.chunks_exact_mut(2 * d));
        for (i, (target, increment)) in rows.enumerate() {
            for k in 0..d {
                let (by_x, by_p) = (last.map[i * d + k], room.tensor[i * d + k]);
                target[k] = 0.5 * by_x + 0.0;
                target[d + k] = 0.5 * by_p;
                increment[k] = -by_x;
                increment[d + k] = -by_p;
            }
            target[i] += 1.0;
        }
        for resolvent in last.resolvents() {
            let algebra = (&self.algebra, self.epsilon);
            write_square_tangent(algebra, &last.map, &resolvent.solution, room);
            for (i, pair) in room.pair.chunks_exact_mut(2 * d).enumerate() {
                pair[..d].copy_from_slice(&last.quarter_square[i * d..][..d]);
                pair[d..].copy_from_slice(&room.matrix[i * d..][..d]);
            }
            resolvent.factors.solve_columns(&mut room.pair, 2 * d);
            for (sum, solved) in target.iter_mut().zip(&room.pair) {
                *sum += solved * resolvent.weight;
            }
        }
        let (n, resolvents) = (d as u64, last.count as u64);
        let each = 2 * n * n * n + 8 * n * n + 2 * n * substitution_operations(d);
        let tensors = (2 * resolvents + 1) * self.algebra.operations();
        self.operations += resolvents * each + tensors;
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

    /// D²(λ·α), row-major, by those of the fractions. Let μ = (1 + sW)⁻ᵀλ and y = (1 + sW)⁻¹x. Then D²(λ·W(1 + sW)⁻¹x)
    /// along v and w is μ·(∂²_vw W y + ∂_v W ∂_w y + ∂_w W ∂_v y). Here ∂_v y = (1 + sW)⁻¹(v_x − s ∂_v W y). And
    /// μ·∂_v W u = −¼ ε v_p·(A(μ)Z + A(Zᵀμ)) u since μ·A(v)a = −v·A(μ)a.
    fn hessian(
        &mut self,
        z: &[f64],
        covector: &[f64],
        hessian: &mut [f64],
    ) -> Result<(), StepError> {
        self.know(z)?;
        let (last, room, epsilon) = (&self.last, &mut self.room, self.epsilon);
        let (algebra, d) = (&self.algebra, self.algebra.dimension());
        let square = || vec![0.0; d * d];
        let [mut inverse, mut along, mut slope, mut through, mut twice] = from_fn(|_| square());
        let [mut mixed, mut by_pp, mut mu] = [square(), square(), vec![0.0; d]];
        algebra.coadjoint(covector, &mut mixed);
        scale(&mut mixed, 0.5 * epsilon);
        for resolvent in last.resolvents() {
            let (r, s, y) = (resolvent.weight, resolvent.shift, &resolvent.solution);
            inverse.fill(0.0);
            inverse.iter_mut().step_by(d + 1).for_each(|v| *v = 1.0);
            resolvent.factors.solve_columns(&mut inverse, d);
            product(covector, &inverse, d, &mut mu);
            algebra.coadjoint(&mu, &mut along);
            write_square_tangent((algebra, epsilon), &last.map, y, room);
            product(&inverse, &room.matrix, d, &mut through);
            scale(&mut through, -s);
            product(&along, &room.tensor, d, &mut twice);
            scale(&mut twice, -0.25 * epsilon * epsilon);
            product(&mu, &last.map, d, &mut room.vector);
            algebra.coadjoint(&room.vector, &mut room.matrix);
            product(&along, &last.map, d, &mut slope);
            for (slope, image) in slope.iter_mut().zip(&room.matrix) {
                *slope = (*slope + image) * (-0.25 * epsilon);
            }
            product(&slope, &through, d, &mut room.matrix);
            for (twice, image) in twice.iter_mut().zip(&room.matrix) {
                *twice += image;
            }
            product(&slope, &inverse, d, &mut room.matrix);
            for (mixed, image) in mixed.iter_mut().zip(&room.matrix) {
                *mixed += image * r;
            }
            for (at, by_pp) in by_pp.iter_mut().enumerate() {
                *by_pp += (twice[at] + twice[at % d * d + at / d]) * r;
            }
        }
        let (n, resolvents) = (d as u64, last.count as u64);
        let inverse = elimination_operations(d) + n * substitution_operations(d);
        let each = 12 * n * n * n + 12 * n * n + inverse + 5 * self.algebra.operations();
        self.operations += resolvents * each;
        let entry = |row: usize, column: usize| match (row < d, column < d) {
            (true, true) => 0.0,
            (true, false) => mixed[(column - d) * d + row],
            (false, true) => mixed[(row - d) * d + column],
            (false, false) => by_pp[(row - d) * d + column - d],
        };
        for (at, value) in hessian.iter_mut().enumerate() {
            *value = entry(at / (2 * d), at % (2 * d));
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}
