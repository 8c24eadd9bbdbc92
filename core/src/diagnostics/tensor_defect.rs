//! How far a step is from a Poisson map.

use nalgebra::DMatrix;

use crate::error::{BuildError, StepError};
use crate::solver::{StepMap, Stepper};
use crate::system::{PoissonSystem, TensorMatrix};

/// DΦ Π(x) DΦᵀ − Π(Φ(x)) for a step map Φ, with the exact tangent map through the solve:
/// DΦ = (D α̂∘L)(y) · (D β̂∘L)(y)⁻¹ at the solution y of β̂(L(y)) = x.
pub struct TensorDefect {
    stepper: Box<dyn Stepper>,
    tensor: TensorMatrix,
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

impl Defect {
    /// The defect relative to Π(Φ(x)) and to what DΦ makes of round-off in Π, the square of its
    /// largest entry; `None` where the tensor vanishes.
    pub fn relative(&self) -> Option<f64> {
        let stretch = self.tangent.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
        let scale = self.scale * stretch * stretch;
        (scale > 0.0).then(|| self.norm / scale)
    }
}

impl TensorDefect {
    /// The instrument for a step map with these parameters and step sizes.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor has no code.
    pub fn new(
        system: &PoissonSystem,
        map: &dyn StepMap,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Result<Self, BuildError> {
        Ok(Self {
            stepper: map.stepper(1, parameters, epsilon, h),
            tensor: TensorMatrix::new(system, parameters)?,
        })
    }

    /// Takes one step from `x`, cold, and measures it.
    ///
    /// # Errors
    /// The solver's [`StepError`]; [`StepError::NoTangent`] for a map that offers no exact tangent.
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
        let rows = self.stepper.tangent(0).ok_or(StepError::NoTangent)?;
        let tangent = DMatrix::from_row_slice(d, d, &rows);
        let (before, after) = (self.tensor.at(x)?, self.tensor.at(&next)?);
        let defect = &tangent * before * tangent.transpose() - &after;
        let norm = |m: &DMatrix<f64>| libm::sqrt(m.iter().map(|v| v * v).sum::<f64>() / 2.0);
        Ok(Defect {
            norm: norm(&defect),
            scale: norm(&after),
            tangent: rows,
            next,
        })
    }
}
