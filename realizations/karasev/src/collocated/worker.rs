//! α̂ and β̂ at (x, p), with exact tangents through the curve's equations.

use leafwise_core::{Ends, RealizationWorker, StepError};
use nalgebra::DMatrix;

use super::curve::Curve;

/// The trailing Legendre coefficient, relative, whose square is round-off.
pub(super) const SHORT_TAIL: f64 = 1e-9;

/// One thread's evaluator.
pub(super) struct CollocatedWorker {
    pub(super) curve: Curve,
    pub(super) epsilon: f64,
    /// The most nodes an automatic choice takes; `None` when their number is fixed.
    pub(super) most_points: Option<usize>,
    pub(super) z: Vec<f64>,
}

impl CollocatedWorker {
    /// Solves the curve, with more nodes where its tail asks for them.
    fn solve(&mut self) -> Result<(), StepError> {
        let (x, p) = self.z.split_at(self.z.len() / 2);
        loop {
            self.curve.solve(self.epsilon, x, p)?;
            let points = self.curve.rule.points();
            let tail = self.curve.tail();
            match self.most_points {
                Some(most) if tail > SHORT_TAIL && points < most => {
                    self.curve.set_points(points + 1);
                }
                Some(_) if tail > SHORT_TAIL => return Err(StepError::LeftChart { ratio: tail }),
                _ => return Ok(()),
            }
        }
    }
}

impl RealizationWorker for CollocatedWorker {
    fn ends(&mut self, z: &[f64], ends: &mut Ends) -> Result<(), StepError> {
        self.z.copy_from_slice(z);
        self.solve()?;
        let d = z.len() / 2;
        let curve = &self.curve;
        for i in 0..d {
            ends.base[i] = z[i];
            ends.offset[i] = curve.combination(self.epsilon, &curve.rule.end, i);
            ends.increment[i] = -curve.combination(self.epsilon, &curve.rule.weights, i);
        }
        Ok(())
    }

    fn has_tangents(&self) -> bool {
        self.curve.has_slopes()
    }

    fn operations(&self) -> Option<u64> {
        self.curve.operations()
    }

    fn tangents(&mut self, target: &mut [f64], increment: &mut [f64]) -> Result<(), StepError> {
        let d = self.z.len() / 2;
        let q = self.curve.rule.points();
        let p = self.z[d..].to_vec();
        let (jacobian, by_p) = self.curve.linearization(self.epsilon, &p)?;
        // (1 − ε A⊗V_y) dY = 1⊗dx + ε A⊗Π dp.
        let right = DMatrix::from_fn(q * d, 2 * d, |row, column| {
            let (j, i) = (row / d, row % d);
            if column < d {
                return if i == column { 1.0 } else { 0.0 };
            }
            let l = column - d;
            let sum: f64 = (0..q)
                .map(|k| self.curve.rule.matrix[j * q + k] * by_p[k * d * d + i * d + l])
                .sum();
            self.epsilon * sum
        });
        self.curve.count_tangents(2 * d);
        let nodes = jacobian.lu().solve(&right).ok_or(StepError::NonFinite {
            what: "the tangent of the curve",
        })?;
        target.fill(0.0);
        increment.fill(0.0);
        let mut slope = vec![0.0; d * d];
        let mut tensor = vec![0.0; d * d];
        for k in 0..q {
            self.curve.slope_by_y(k, &p, &mut slope, &mut tensor)?;
            let (end, weight) = (
                self.epsilon * self.curve.rule.end[k],
                self.epsilon * self.curve.rule.weights[k],
            );
            for i in 0..d {
                for column in 0..2 * d {
                    let mut change: f64 = (0..d)
                        .map(|l| slope[i * d + l] * nodes[(k * d + l, column)])
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
        Ok(())
    }
}
