//! How far a step is from a Poisson map.

use leafwise_expression::{Kernel, Workspace};
use nalgebra::DMatrix;

use crate::error::{BuildError, StepError};
use crate::method::Method;
use crate::solver::{StepMap, Stepper};
use crate::system::PoissonSystem;

/// DΦ Π(x) DΦᵀ − Π(Φ(x)) for the map Φ of a [`Method`], with the exact tangent map through the
/// solve: DΦ = (D α̂∘L)(y) · (D β̂∘L)(y)⁻¹ at the solution y of β̂(L(y)) = x.
pub struct TensorDefect<'a> {
    method: &'a Method,
    stepper: Box<dyn Stepper>,
    tangent: Workspace,
    tensor: Kernel,
    tensor_workspace: Workspace,
    entries: Vec<(usize, usize)>,
}

/// The defect of one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Defect {
    /// The Frobenius norm over i < j.
    pub norm: f64,
    /// The same of Π(Φ(x)), to judge it against.
    pub scale: f64,
    /// DΦ, row-major.
    pub tangent: Vec<f64>,
    /// Φ(x).
    pub next: Vec<f64>,
}

impl<'a> TensorDefect<'a> {
    /// The instrument for a method with these parameters and step sizes.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor has no code.
    pub fn new(
        system: &PoissonSystem,
        method: &'a Method,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Result<Self, BuildError> {
        let formulas: Vec<_> = system.tensor().values().collect();
        let tensor = system.observable_kernel(&formulas)?;
        let mut tensor_workspace = tensor.workspace(1);
        tensor.prepare(&mut tensor_workspace, parameters, &[epsilon], &[h]);
        let tangent = method.newton().workspace(parameters, epsilon, h);
        Ok(Self {
            method,
            stepper: method.stepper(1, parameters, epsilon, h),
            tangent,
            tensor,
            tensor_workspace,
            entries: system.tensor().keys().copied().collect(),
        })
    }

    /// Takes one step from `x`, cold, and measures it.
    ///
    /// # Errors
    /// The solver's [`StepError`].
    pub fn measure(&mut self, x: &[f64]) -> Result<Defect, StepError> {
        let d = x.len();
        let mut increment = vec![0.0; d];
        let mut outcome = [Ok(())];
        self.stepper.restart();
        self.stepper
            .increment(x, &vec![0.0; d], &mut increment, &mut outcome);
        let [outcome] = outcome;
        outcome?;
        let next: Vec<f64> = x.iter().zip(&increment).map(|(x, i)| x + i).collect();
        let y = self.stepper.solution(0);
        let (target, change) = self.method.newton().tangents(&mut self.tangent, &y);
        let target = DMatrix::from_row_slice(d, d, &target);
        let change = DMatrix::from_row_slice(d, d, &change);
        let inverse = target.lu().try_inverse().ok_or(StepError::NonFinite {
            what: "the inverse of the target map's tangent",
        })?;
        let tangent = DMatrix::identity(d, d) + change * inverse;
        let (before, after) = (self.tensor_at(x), self.tensor_at(&next));
        let defect = &tangent * before * tangent.transpose() - &after;
        let norm = |m: &DMatrix<f64>| libm::sqrt(m.iter().map(|v| v * v).sum::<f64>() / 2.0);
        Ok(Defect {
            norm: norm(&defect),
            scale: norm(&after),
            tangent: tangent.transpose().as_slice().to_vec(),
            next,
        })
    }

    fn tensor_at(&mut self, x: &[f64]) -> DMatrix<f64> {
        let mut values = vec![0.0; self.entries.len()];
        self.tensor
            .evaluate(&mut self.tensor_workspace, x, &mut values);
        let mut matrix = DMatrix::zeros(x.len(), x.len());
        for (&(i, j), value) in self.entries.iter().zip(values) {
            matrix[(i, j)] = value;
            matrix[(j, i)] = -value;
        }
        matrix
    }
}
