//! The differential of a step that solves x = y + offset(y) and returns x₊ = x + increment(y).
//!
//! With O = D offset and I = D increment at the solution y:
//!
//! - DΦ = 1 + I (1 + O)⁻¹;
//! - DΦ⁻¹ = 1 − I (1 + O + I)⁻¹.
//!
//! Linear iterations solve as the step does, at its rate: u ← v − O u, for covectors z ← Iᵀw − Oᵀz. By parameters
//!
//!   ∂_λΦ = ∂_λ increment − I (1 + O)⁻¹ ∂_λ offset.

use std::sync::Arc;

use super::fields::Fields;
use super::slopes::{LatticeSlopes, SlopesAlong};
use super::stages::MethodFields;
use crate::error::StepError;
use crate::solver::judge::Verdict;
use crate::solver::{CorrectionMethod, Differential, Iteration, Stepper, one_step};

/// The budget of a solve: a rate of 24/25 comes to round-off.
const MOST_ITERATIONS: usize = 1000;

/// Which slopes are known of the last step.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Known {
    Nothing,
    ByState,
    ByParameters,
}

/// The differential of [`ImplicitSweeps`](super::ImplicitSweeps).
pub(super) struct SolvedSweeps {
    stepper: Box<dyn Stepper>,
    fields: MethodFields,
    /// None where a formula has no derivative.
    along: Option<SlopesAlong>,
    known: Known,
    /// Tangents or covectors of all fields.
    moved: Fields,
    /// u, or z.
    solution: Vec<f64>,
    slopes: Vec<f64>,
    iteration: Iteration,
}

impl SolvedSweeps {
    pub(super) fn new(
        stepper: Box<dyn Stepper>,
        slopes: &Arc<LatticeSlopes>,
        fields: MethodFields,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
    ) -> Self {
        let stages = (0..slopes.stages()).map(|stage| (stage, h));
        let along = SlopesAlong::new(slopes, stages, parameters, epsilon);
        let moved = slopes.empty_fields();
        Self {
            stepper,
            fields,
            along,
            known: Known::Nothing,
            solution: vec![0.0; moved.get(fields.y).len()],
            moved,
            slopes: vec![0.0; parameters.len()],
            iteration: Iteration::new(CorrectionMethod::Residual, 0),
        }
    }

    /// The slopes at the solution of the last step.
    fn find(&mut self, by_parameters: bool) -> Result<&mut SlopesAlong, StepError> {
        let along = self.along.as_mut().ok_or(StepError::NoTangent)?;
        let wanted = match by_parameters {
            true => Known::ByParameters,
            false => Known::ByState,
        };
        if self.known < wanted {
            let y = self.stepper.solution(0).ok_or(StepError::NoTangent)?;
            along
                .fields_mut()
                .get_mut(self.fields.y)
                .copy_from_slice(&y);
            along.run(by_parameters);
            self.known = wanted;
        }
        Ok(along)
    }

    /// v' = v + I u + ∂_λincrement μ, u = v − O u − ∂_λoffset μ.
    fn push_one(&mut self, tangent: &mut [f64], mu: &[f64]) -> Result<(), StepError> {
        self.find(!mu.is_empty())?;
        let Self {
            along,
            fields,
            moved,
            solution,
            iteration,
            ..
        } = self;
        let along = along.as_mut().ok_or(StepError::NoTangent)?;
        solution.copy_from_slice(tangent);
        iteration.begin(MOST_ITERATIONS, |_| 0.0);
        loop {
            moved.clear();
            moved.get_mut(fields.y).copy_from_slice(solution);
            along.push(moved, mu);
            let next = tangent.iter().zip(moved.get(fields.offset));
            let next = next.map(|(v, offset)| v - offset);
            if take(iteration, solution, tangent, next)? == Verdict::Converged {
                break;
            }
        }
        let changes = moved.get(fields.increment);
        tangent.iter_mut().zip(changes).for_each(|(v, i)| *v += i);
        Ok(())
    }

    /// z = Iᵀa − Oᵀz, a = w', or a = w' − z through the inverse; w = w' + z, or w' − z. To g comes ∂_λincrementᵀa −
    /// ∂_λoffsetᵀz, or less that.
    fn pull_one(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
        is_inverse: bool,
    ) -> Result<(), StepError> {
        self.find(!gradient.is_empty())?;
        let Self {
            along,
            fields,
            moved,
            solution,
            slopes,
            iteration,
            ..
        } = self;
        let along = along.as_mut().ok_or(StepError::NoTangent)?;
        let begin = |moved: &mut Fields, z: &[f64]| {
            moved.clear();
            let offsets = moved.get_mut(fields.offset).iter_mut();
            offsets.zip(z).for_each(|(to, z)| *to = -z);
            let increments = moved.get_mut(fields.increment).iter_mut();
            for ((to, w), z) in increments.zip(&*covector).zip(z) {
                *to = if is_inverse { w - z } else { *w };
            }
        };
        solution.fill(0.0);
        iteration.begin(MOST_ITERATIONS, |_| 0.0);
        loop {
            begin(moved, solution);
            along.pull(moved, &mut []);
            let next = moved.get(fields.y).iter().copied();
            if take(iteration, solution, covector, next)? == Verdict::Converged {
                break;
            }
        }
        if !gradient.is_empty() {
            begin(moved, solution);
            slopes.fill(0.0);
            along.pull(moved, slopes);
        }
        let sign = if is_inverse { -1.0 } else { 1.0 };
        let changes = [(covector, &*solution), (gradient, &*slopes)];
        for (to, change) in changes {
            to.iter_mut()
                .zip(change)
                .for_each(|(to, c)| *to += sign * c);
        }
        Ok(())
    }
}

/// Takes the next iterate of a solve whose right-hand side has the size of `given`.
fn take(
    iteration: &mut Iteration,
    solution: &mut [f64],
    given: &[f64],
    next: impl Iterator<Item = f64>,
) -> Result<Verdict, StepError> {
    for ((own, next), given) in solution.iter_mut().zip(next).zip(given) {
        iteration.take(next - *own, next.abs() + given.abs());
        *own = next;
    }
    iteration.judge()
}

impl Differential for SolvedSweeps {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.known = Known::Nothing;
        one_step(self.stepper.as_mut(), x, low, increment)
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        let (d, count) = (self.solution.len(), self.slopes.len());
        for (at, tangent) in tangents.chunks_exact_mut(d).enumerate() {
            let own = match parameters {
                [] => &[],
                all => &all[at * count..][..count],
            };
            self.push_one(tangent, own)?;
        }
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        self.pull_one(covector, gradient, false)
    }

    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        self.pull_one(covector, gradient, true)
    }

    fn knows_parameters(&self) -> bool {
        self.along
            .as_ref()
            .is_some_and(SlopesAlong::knows_parameters)
    }

    fn operations(&self) -> Option<u64> {
        let own = self.along.as_ref().map_or(0, SlopesAlong::operations);
        Some(self.stepper.statistics().operations? + own)
    }
}
