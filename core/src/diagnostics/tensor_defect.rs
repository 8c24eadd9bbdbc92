//! How far a step is from a Poisson map.

use nalgebra::DMatrix;

use super::differences::jacobian_by_differences;
use crate::error::{BuildError, StepError};
use crate::solver::{StepMap, Stepper};
use crate::system::{PoissonSystem, TensorMatrix};

/// DΦ Π(x) DΦᵀ − Π(Φ(x)) for a step map Φ, with the exact tangent map through the solve:
/// DΦ = (D α̂∘L)(y) · (D β̂∘L)(y)⁻¹ at the solution y of β̂(L(y)) = x; or, marked as such, with
/// differences.
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
    /// Where DΦ was taken by differences, the part of the norm that may be their error; `None` where
    /// it is exact.
    pub floor: Option<f64>,
}

impl Defect {
    /// A [`relative`](Self::relative) defect up to this is round-off: products of up to a dozen
    /// factors, a few dozen of them, and the solve.
    pub const ROUND_OFF: f64 = 256.0 * f64::EPSILON;

    /// The defect relative to Π(Φ(x)) and to what DΦ makes of round-off in Π, the square of its
    /// largest entry; `None` where the tensor vanishes.
    pub fn relative(&self) -> Option<f64> {
        self.in_units(self.norm)
    }

    /// [`floor`](Self::floor) in the units of [`relative`](Self::relative); 0 for an exact tangent.
    pub fn relative_floor(&self) -> Option<f64> {
        self.in_units(self.floor.unwrap_or(0.0))
    }

    fn in_units(&self, norm: f64) -> Option<f64> {
        let stretch = self.tangent.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
        let scale = self.scale * stretch * stretch;
        (scale > 0.0).then(|| norm / scale)
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

    /// Takes one step from `x`, cold, and measures it by the exact tangent map.
    ///
    /// # Errors
    /// The solver's [`StepError`]; [`StepError::NoTangent`] for a map that offers no exact tangent.
    pub fn measure(&mut self, x: &[f64]) -> Result<Defect, StepError> {
        let mut increment = vec![0.0; x.len()];
        step(self.stepper.as_mut(), x, &mut increment)?;
        let tangent = self.stepper.tangent(0).ok_or(StepError::NoTangent)?;
        let tangent = DMatrix::from_row_slice(x.len(), x.len(), &tangent);
        self.defect(x, &increment, &tangent, None)
    }

    /// The same with DΦ by differences of cold steps, for maps over systems that offer no derivatives:
    /// [`Defect::floor`] says how small a defect can be told from none.
    ///
    /// # Errors
    /// The solver's [`StepError`], from `x` or from a state near it.
    pub fn measure_by_differences(&mut self, x: &[f64]) -> Result<Defect, StepError> {
        let d = x.len();
        let stepper = self.stepper.as_mut();
        let mut increment = vec![0.0; d];
        step(stepper, x, &mut increment)?;
        // Differences of increments: those of states would bring the states' round-off.
        let change = jacobian_by_differences(x, d, |at, out| step(stepper, at, out))?;
        let tangent = DMatrix::identity(d, d) + change.jacobian;
        self.defect(x, &increment, &tangent, Some(&change.error))
    }

    fn defect(
        &mut self,
        x: &[f64],
        increment: &[f64],
        tangent: &DMatrix<f64>,
        error: Option<&DMatrix<f64>>,
    ) -> Result<Defect, StepError> {
        let next: Vec<f64> = x.iter().zip(increment).map(|(x, i)| x + i).collect();
        let (before, after) = (self.tensor.at(x)?, self.tensor.at(&next)?);
        let defect = tangent * &before * tangent.transpose() - &after;
        let norm = |m: &DMatrix<f64>| libm::sqrt(m.iter().map(|v| v * v).sum::<f64>() / 2.0);
        // |E Π DΦᵀ + DΦ Π Eᵀ|, the two of them transposes up to a sign.
        let floor = error.map(|error| 2.0 * norm(&(error * (&before * tangent.transpose()).abs())));
        Ok(Defect {
            norm: norm(&defect),
            scale: norm(&after),
            tangent: tangent.transpose().as_slice().to_vec(),
            next,
            floor,
        })
    }
}

/// Φ(x) − x, cold.
fn step(stepper: &mut dyn Stepper, x: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
    let mut outcome = [Ok(())];
    stepper.restart();
    stepper.increment(x, &vec![0.0; x.len()], increment, &mut outcome);
    let [outcome] = outcome;
    outcome
}
