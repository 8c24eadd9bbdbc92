//! Solutions of a step's equation that are connected with a step of size 0.

use leafwise_core::StepError;
use leafwise_core::solver::Branch;

/// A step's equation for unknowns that are 0 for a step of size 0.
pub(crate) trait StepEquation {
    /// Newton's method from the unknowns as they are; returns its evaluations.
    fn solve(&mut self) -> Result<usize, StepError>;
    /// The unknowns.
    fn unknowns(&mut self) -> &mut [f64];
    /// Writes the residual at the unknowns, and its negative Jacobian, of a step of this size.
    fn evaluate(
        &mut self,
        time_step: f64,
        residual: &mut [f64],
        matrix: &mut [f64],
    ) -> Result<(), StepError>;
}

/// Room for the path from 0 to a solution.
#[derive(Debug)]
pub(crate) struct Connected {
    branch: Branch,
    found: Vec<f64>,
    nothing: Vec<f64>,
}

impl Connected {
    /// For equations of n unknowns.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            branch: Branch::new(n),
            found: vec![0.0; n],
            nothing: vec![0.0; n],
        }
    }

    /// Makes sure that what was `solved` is the solution that begins at 0, and takes that where another
    /// or none was found. `sizes` is what the unknowns are measured against.
    #[cold]
    pub(crate) fn settle(
        &mut self,
        solved: Result<usize, StepError>,
        time_step: f64,
        sizes: &[f64],
        equation: &mut impl StepEquation,
    ) -> Result<usize, StepError> {
        self.found.copy_from_slice(equation.unknowns());
        let mut spent = 0;
        let path = self.branch.follow(
            &self.nothing,
            sizes,
            solved.is_ok().then_some(&self.found[..]),
            &mut spent,
            |part, point, residual, matrix| {
                equation.unknowns().copy_from_slice(point);
                equation.evaluate(part * time_step, residual, matrix)?;
                let mut values = residual.iter().chain(matrix.iter());
                if values.all(|value| value.is_finite()) {
                    return Ok(());
                }
                Err(StepError::NonFinite {
                    what: "a correction of the stages",
                })
            },
        );
        equation.unknowns().copy_from_slice(&self.found);
        let spent = spent as usize;
        match (path, solved) {
            (Ok(()), Ok(evaluations)) if self.branch.ends_at(&self.found) => {
                Ok(evaluations + spent)
            }
            (Ok(()), _) => {
                equation.unknowns().copy_from_slice(self.branch.end());
                let evaluations = equation.solve()?;
                if self.branch.ends_at(equation.unknowns()) {
                    return Ok(evaluations + spent);
                }
                Err(StepError::OtherBranch { reached: 1.0 })
            }
            (Err(error), Ok(_)) | (Err(error @ StepError::OtherBranch { .. }), Err(_)) => {
                Err(error)
            }
            (Err(_), Err(error)) => Err(error),
        }
    }
}
