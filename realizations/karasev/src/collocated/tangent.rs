//! First and second derivatives of the ends at (x, p), exact through the curve's equations.

use leafwise_core::StepError;
use nalgebra::{DMatrix, DVector};

use super::curve::{Curve, Linearization};

/// The linearized equations (1 − ε A⊗V_y) dY = 1⊗dx + ε A⊗Π dp and their solution.
pub(super) struct CurveTangent {
    linearization: Linearization,
    /// dY for dx and dp, q d × 2d.
    nodes: DMatrix<f64>,
}

impl CurveTangent {
    pub(super) fn solve(curve: &mut Curve, epsilon: f64, p: &[f64]) -> Result<Self, StepError> {
        let (q, d) = (curve.rule.points(), p.len());
        let linearization = curve.linearization(epsilon, p)?;
        let right = DMatrix::from_fn(q * d, 2 * d, |row, column| {
            let (j, i) = (row / d, row % d);
            if column < d {
                return if i == column { 1.0 } else { 0.0 };
            }
            let l = column - d;
            let sum: f64 = (0..q)
                .map(|k| curve.rule.matrix[j * q + k] * linearization.by_p[k * d * d + i * d + l])
                .sum();
            epsilon * sum
        });
        curve.count_tangents(2 * d);
        let lu = linearization.matrix.clone().lu();
        let nodes = lu.solve(&right).ok_or(SINGULAR)?;
        Ok(Self {
            linearization,
            nodes,
        })
    }

    /// Dβ̂ and D(α̂ − β̂), row-major d × 2d.
    pub(super) fn ends(
        &self,
        curve: &Curve,
        epsilon: f64,
        target: &mut [f64],
        increment: &mut [f64],
    ) {
        let q = curve.rule.points();
        let d = self.nodes.ncols() / 2;
        target.fill(0.0);
        increment.fill(0.0);
        for k in 0..q {
            let slope = &self.linearization.by_y[k * d * d..][..d * d];
            let tensor = &self.linearization.by_p[k * d * d..][..d * d];
            let (end, weight) = (epsilon * curve.rule.end[k], epsilon * curve.rule.weights[k]);
            for i in 0..d {
                for column in 0..2 * d {
                    let mut change: f64 = (0..d)
                        .map(|l| slope[i * d + l] * self.nodes[(k * d + l, column)])
                        .sum();
                    if column >= d {
                        change += tensor[i * d + column - d];
                    }
                    target[i * 2 * d + column] += end * change;
                    increment[i * 2 * d + column] -= weight * change;
                }
            }
        }
        for i in 0..d {
            target[i * 2 * d + i] += 1.0;
        }
    }

    /// D²(λ·α̂), row-major 2d × 2d.
    ///
    /// α̂ = x + ε Σ_k e_k V_k with e_k = W_k(0). With multipliers μ_j of the curve's equations,
    /// (1 − ε A⊗V_y)ᵀ μ = (ε e_k V_yᵀ λ)_k, the first-order terms cancel and what is left is
    /// Σ_k ν_k·D²V_k, ν_k = ε (e_k λ + Σ_j A_jk μ_j), along dY_k and dp.
    pub(super) fn source_hessian(
        &self,
        curve: &mut Curve,
        epsilon: f64,
        p: &[f64],
        covector: &[f64],
        hessian: &mut [f64],
    ) -> Result<(), StepError> {
        let (q, d) = (curve.rule.points(), p.len());
        let start = |curve: &Curve, k: usize| curve.rule.end[k] - curve.rule.weights[k];
        let right = DVector::from_fn(q * d, |row, _| {
            let (k, l) = (row / d, row % d);
            let slope = &self.linearization.by_y[k * d * d..][..d * d];
            let along: f64 = (0..d).map(|i| slope[i * d + l] * covector[i]).sum();
            epsilon * start(curve, k) * along
        });
        curve.count_hessian();
        let adjoint = self.linearization.matrix.transpose().lu();
        let multipliers = adjoint.solve(&right).ok_or(SINGULAR)?;
        let mut sum = DMatrix::zeros(2 * d, 2 * d);
        let mut by_yy = vec![0.0; d * d];
        let mut by_yp = vec![0.0; d * d];
        for k in 0..q {
            let weight: Vec<f64> = (0..d)
                .map(|i| {
                    let through: f64 = (0..q)
                        .map(|j| curve.rule.matrix[j * q + k] * multipliers[j * d + i])
                        .sum();
                    epsilon * (start(curve, k) * covector[i] + through)
                })
                .collect();
            let node = curve.nodes[k * d..][..d].to_vec();
            curve
                .field
                .curvatures((&node, p, &weight), &mut by_yy, &mut by_yp)?;
            let along = self.nodes.rows(k * d, d);
            let by_yy = DMatrix::from_row_slice(d, d, &by_yy);
            sum += along.transpose() * by_yy * along;
            let mixed = along.transpose() * DMatrix::from_row_slice(d, d, &by_yp);
            let mut right = sum.columns_mut(d, d);
            right += &mixed;
            let mut below = sum.rows_mut(d, d);
            below += mixed.transpose();
        }
        hessian.copy_from_slice(sum.as_slice());
        Ok(())
    }
}

const SINGULAR: StepError = StepError::NonFinite {
    what: "the tangent of the curve",
};
