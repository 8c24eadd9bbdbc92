//! First and second derivatives of the ends at (x, p), exact through the curve's equations.

use leafwise_core::StepError;

use super::curve::{Curve, Linearization};

/// The linearized equations (1 − ε A⊗V_y) dY = 1⊗dx + ε A⊗Π dp and their solution, in memory that is
/// kept from point to point.
#[derive(Default)]
pub(super) struct CurveTangent {
    linearization: Option<Linearization>,
    /// dY for dx and dp: q d rows of 2d columns.
    nodes: Vec<f64>,
    /// Multipliers μ of the curve's equations; V's second derivatives along ν at a node.
    multipliers: Vec<f64>,
    weight: Vec<f64>,
    by_yy: Vec<f64>,
    by_yp: Vec<f64>,
    /// V_yy dY at a node, d × 2d.
    image: Vec<f64>,
    /// A row of 2d numbers.
    row: Vec<f64>,
}

impl CurveTangent {
    /// Whether the tangent is that of the last point.
    pub(super) fn is_known(&self) -> bool {
        self.linearization.is_some()
    }

    /// Forgets the point.
    pub(super) fn clear(&mut self, curve: &mut Curve) {
        if let Some(room) = self.linearization.take() {
            curve.give_back(room);
        }
    }

    /// Solves the linearized equations at the curve's nodes.
    pub(super) fn solve(
        &mut self,
        curve: &mut Curve,
        epsilon: f64,
        p: &[f64],
    ) -> Result<(), StepError> {
        let (q, d) = (curve.rule.points(), p.len());
        let size = q * d;
        let mut linearization = curve.linearize(epsilon, p)?;
        self.nodes.resize(2 * d * size, 0.0);
        for (row, values) in self.nodes.chunks_exact_mut(2 * d).enumerate() {
            let (j, i) = (row / d, row % d);
            let (by_x, by_p) = values.split_at_mut(d);
            by_x.fill(0.0);
            by_x[i] = 1.0;
            by_p.fill(-0.0);
            let tensors = linearization.by_p.chunks_exact(d).skip(i).step_by(d);
            for (a, tensor) in curve.rule.matrix[j * q..][..q].iter().zip(tensors) {
                for (sum, entry) in by_p.iter_mut().zip(tensor) {
                    *sum += a * entry;
                }
            }
            by_p.iter_mut().for_each(|sum| *sum *= epsilon);
        }
        curve.count_tangents(2 * d);
        let is_regular = linearization.factor();
        let factors = &linearization.factors;
        factors.solve_columns(&mut self.nodes, 2 * d);
        if !is_regular {
            curve.give_back(linearization);
            return Err(SINGULAR);
        }
        self.linearization = Some(linearization);
        Ok(())
    }

    /// Dβ̂ and D(α̂ − β̂) at the point of [`solve`](Self::solve), row-major d × 2d.
    ///
    /// # Errors
    /// [`StepError::NoTangent`] before a point was solved.
    pub(super) fn ends(
        &mut self,
        curve: &Curve,
        epsilon: f64,
        target: &mut [f64],
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let linearization = self.linearization.as_ref().ok_or(StepError::NoTangent)?;
        let q = curve.rule.points();
        let d = curve.nodes.len() / q;
        self.row.resize(2 * d, 0.0);
        target.fill(0.0);
        increment.fill(0.0);
        for k in 0..q {
            let slope = &linearization.by_y[k * d * d..][..d * d];
            let tensor = &linearization.by_p[k * d * d..][..d * d];
            let (end, weight) = (epsilon * curve.rule.end[k], epsilon * curve.rule.weights[k]);
            let node = &self.nodes[k * d * 2 * d..][..d * 2 * d];
            let targets = target.chunks_exact_mut(2 * d);
            let ends = targets.zip(increment.chunks_exact_mut(2 * d));
            for (i, (target, increment)) in ends.enumerate() {
                product(slope[i * d..][..d].iter(), node, &mut self.row);
                for (change, entry) in self.row[d..].iter_mut().zip(&tensor[i * d..]) {
                    *change += entry;
                }
                let ends = target.iter_mut().zip(increment);
                for ((target, increment), change) in ends.zip(&self.row) {
                    *target += end * change;
                    *increment -= weight * change;
                }
            }
        }
        for i in 0..d {
            target[i * 2 * d + i] += 1.0;
        }
        Ok(())
    }

    /// D²(λ·α̂), row-major 2d × 2d.
    ///
    /// Here α̂ = x + ε Σ_k e_k V_k with e_k = W_k(0). Multipliers μ_j of the curve's equations solve (1 − ε A⊗V_y)ᵀ μ =
    /// (ε e_k V_yᵀ λ)_k. The first-order terms then cancel. The rest is Σ_k ν_k·D²V_k along dY_k and dp. Its factors
    /// are ν_k = ε (e_k λ + Σ_j A_jk μ_j).
    ///
    /// # Errors
    /// [`StepError::NoTangent`] before a point was solved, or for a system without second derivatives.
    pub(super) fn source_hessian(
        &mut self,
        curve: &mut Curve,
        epsilon: f64,
        p: &[f64],
        covector: &[f64],
        hessian: &mut [f64],
    ) -> Result<(), StepError> {
        let (q, d) = (curve.rule.points(), p.len());
        let size = q * d;
        let start = |curve: &Curve, k: usize| curve.rule.end[k] - curve.rule.weights[k];
        let linearization = self.linearization.as_mut().ok_or(StepError::NoTangent)?;
        self.multipliers.resize(size, 0.0);
        for (row, value) in self.multipliers.iter_mut().enumerate() {
            let (k, l) = (row / d, row % d);
            let slope = linearization.by_y[k * d * d..][..d * d].iter();
            let column = slope.skip(l).step_by(d);
            let along: f64 = column.zip(covector).map(|(v, c)| v * c).sum();
            *value = epsilon * start(curve, k) * along;
        }
        curve.count_hessian();
        if !linearization.factor_transpose(size) {
            return Err(SINGULAR);
        }
        linearization.factors.solve(&mut self.multipliers);
        self.weight.resize(d, 0.0);
        self.by_yy.resize(d * d, 0.0);
        self.by_yp.resize(d * d, 0.0);
        self.image.resize(2 * d * d, 0.0);
        self.row.resize(2 * d, 0.0);
        hessian.fill(0.0);
        for k in 0..q {
            for (i, weight) in self.weight.iter_mut().enumerate() {
                let multipliers = self.multipliers.iter().skip(i).step_by(d);
                let column = curve.rule.matrix.iter().skip(k).step_by(q);
                let through: f64 = column.zip(multipliers).map(|(a, m)| a * m).sum();
                *weight = epsilon * (start(curve, k) * covector[i] + through);
            }
            let node = &curve.nodes[k * d..][..d];
            let at = (node, p, &self.weight[..]);
            curve
                .field
                .curvatures(at, &mut self.by_yy, &mut self.by_yp)?;
            self.add_node(k, hessian);
        }
        Ok(())
    }

    /// Adds ν_k·D²V_k along dY_k and dp.
    fn add_node(&mut self, k: usize, hessian: &mut [f64]) {
        let d = self.weight.len();
        let node = &self.nodes[k * d * 2 * d..][..d * 2 * d];
        for (row, image) in self.by_yy.chunks(d).zip(self.image.chunks_exact_mut(2 * d)) {
            product(row.iter(), node, image);
        }
        for row in 0..2 * d {
            let along = || node.iter().skip(row).step_by(2 * d);
            product(along(), &self.image, &mut self.row);
            let entries = hessian[row * 2 * d..][..2 * d].iter_mut();
            entries
                .zip(&self.row)
                .for_each(|(entry, sum)| *entry += sum);
            let mixed = &mut self.row[..d];
            product(along(), &self.by_yp, mixed);
            for (column, mixed) in mixed.iter().enumerate() {
                hessian[row * 2 * d + d + column] += mixed;
                hessian[(d + column) * 2 * d + row] += mixed;
            }
        }
    }
}

/// A row times a matrix, from its first row to the last.
fn product<'a>(row: impl Iterator<Item = &'a f64>, matrix: &[f64], result: &mut [f64]) {
    result.fill(-0.0);
    for (factor, entries) in row.zip(matrix.chunks_exact(result.len())) {
        for (sum, entry) in result.iter_mut().zip(entries) {
            *sum += factor * entry;
        }
    }
}

const SINGULAR: StepError = StepError::NonFinite {
    what: "the tangent of the curve",
};
