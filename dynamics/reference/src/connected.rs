//! Solutions of a step's equation that are connected with a step of size 0.

use leafwise_core::StepError;
use leafwise_core::solver::Branch;
use leafwise_core::solver::judge::all_finite;

/// A step's equation for unknowns that are 0 for a step of size 0.
pub(crate) trait StepEquation {
    /// Newton's method from the unknowns as they are; returns its evaluations.
    fn solve(&mut self) -> Result<usize, StepError>;
    /// The unknowns.
    fn unknowns(&mut self) -> &mut [f64];
    /// The step's size.
    fn time_step(&mut self) -> &mut f64;
    /// The residual at the unknowns, and its negative Jacobian.
    fn linearize(&mut self) -> Result<(&[f64], &[f64]), StepError>;
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
        sizes: &[f64],
        equation: &mut impl StepEquation,
    ) -> Result<usize, StepError> {
        self.found.copy_from_slice(equation.unknowns());
        let whole = *equation.time_step();
        let mut spent = 0;
        let settled = self.branch.settle(
            &self.nothing,
            sizes,
            solved.clone().map(|_| &self.found[..]),
            &mut spent,
            |part, point, residual, matrix| {
                equation.unknowns().copy_from_slice(point);
                *equation.time_step() = part * whole;
                let (own_residual, own_matrix) = equation.linearize()?;
                residual.copy_from_slice(own_residual);
                matrix.copy_from_slice(own_matrix);
                all_finite(residual, matrix, "a correction of the stages")
            },
        );
        *equation.time_step() = whole;
        equation.unknowns().copy_from_slice(&self.found);
        let spent = spent as usize;
        if settled? {
            return solved.map(|evaluations| evaluations + spent);
        }
        equation.unknowns().copy_from_slice(self.branch.end());
        let evaluations = equation.solve()?;
        self.branch.confirm_end(equation.unknowns())?;
        Ok(evaluations + spent)
    }
}
