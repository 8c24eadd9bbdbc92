//! How far a step is from a Poisson map.

use nalgebra::DMatrix;

use super::sampled_defect::sample;
use super::{one_step, round_off};
use crate::error::{BuildError, StepError};
use crate::solver::{StepMap, Stepper};
use crate::system::{PoissonSystem, TensorMatrix};

/// DΦ Π(x) DΦᵀ − Π(Φ(x)) for a step map Φ, with the exact tangent map through the solve. The tangent is
/// DΦ = (D α̂∘L)(y) · (D β̂∘L)(y)⁻¹ at the solution y of β̂(L(y)) = x. It may also be taken by differences; the
/// defect is then marked as such.
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
    /// DΦ, row-major; empty where the defect is measured along a few directions.
    pub tangent: Vec<f64>,
    /// Φ(x).
    pub next: Vec<f64>,
    /// Where DΦ was taken by differences, the part of the norm that may be their error; `None` where
    /// it is exact.
    pub floor: Option<f64>,
    defect: DMatrix<f64>,
    /// b.
    bounds: DMatrix<f64>,
    relative_floor: Option<f64>,
}

impl Defect {
    /// A [`relative`](Self::relative) defect up to this is round-off: products of up to a dozen
    /// factors, a few dozen of them, and the solve.
    pub const ROUND_OFF: f64 = 256.0 * f64::EPSILON;

    /// (Σ_{i<j} (defect_ij/b_ij)²)^{1/2} with b = F|Π||DΦ|ᵀ + |DΦ||Π|Fᵀ + |Π∘Φ|: the defect in units of round-off.
    /// Each entry is measured in units of what round-off may put into it, u b_ij. A row of DΦ is known to u times the
    /// whole row (F), entries of Π to u times what their arguments put into them. No units of the coordinates change
    /// it. Returns `None` where the tensor vanishes at both ends.
    pub fn relative(&self) -> Option<f64> {
        self.relative_in(self)
    }

    /// [`relative`](Self::relative) with the b of another step from the same state: for orders. Where a coordinate or
    /// an entry of Π is 0 at the state, it holds what the step puts into it alone. A step's own b then falls with the
    /// step.
    pub fn relative_in(&self, other: &Self) -> Option<f64> {
        over_pairs(&self.defect, &other.bounds)
    }

    /// [`floor`](Self::floor) in the units of [`relative`](Self::relative); 0 for an exact tangent.
    pub fn relative_floor(&self) -> Option<f64> {
        self.relative_floor
    }
}

/// Of antisymmetric matrices, which hold every pair twice.
fn over_pairs(matrix: &DMatrix<f64>, bounds: &DMatrix<f64>) -> Option<f64> {
    let relative = round_off::relative(matrix, bounds);
    relative.map(|r| std::f64::consts::FRAC_1_SQRT_2 * r)
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
        let stepper = self.stepper.as_mut();
        let mut increment = vec![0.0; x.len()];
        one_step::increment(stepper, x, &mut increment)?;
        let tangent = one_step::tangent(stepper, x.len()).ok_or(StepError::NoTangent)?;
        self.defect(x, &increment, &tangent, None)
    }

    /// Measures the defect with DΦ by differences of cold steps, for maps over systems that offer no derivatives. The
    /// [`Defect::floor`] says how small a defect can be told from none.
    ///
    /// # Errors
    /// The solver's [`StepError`], from `x` or from a state near it.
    pub fn measure_by_differences(&mut self, x: &[f64]) -> Result<Defect, StepError> {
        let stepper = self.stepper.as_mut();
        let mut increment = vec![0.0; x.len()];
        one_step::increment(stepper, x, &mut increment)?;
        let [tangent, error] = one_step::tangent_by_differences(stepper, x)?;
        self.defect(x, &increment, &tangent, Some(&error))
    }

    /// Measures the defect along the directions of a few random covectors alone, by differences: for steps on more than
    /// [`MOST_MEASURED`](super::MOST_MEASURED) coordinates. Norms are of these, and no entries are known. `None` where the
    /// tensor couples many coordinates to one another: it then takes all of them.
    ///
    /// # Errors
    /// The solver's [`StepError`], from `x` or from a state near it.
    pub fn measure_sampled(&mut self, x: &[f64]) -> Result<Option<Defect>, StepError> {
        let Some(sampled) = sample(self.stepper.as_mut(), x, &mut self.tensor)? else {
            return Ok(None);
        };
        let norm = |m: &DMatrix<f64>| libm::sqrt(m.iter().map(|v| v * v).sum::<f64>() / 2.0);
        Ok(Some(Defect {
            norm: norm(&sampled.defect),
            scale: norm(&sampled.bounds),
            tangent: Vec::new(),
            next: sampled.next,
            floor: Some(norm(&sampled.floor)),
            relative_floor: over_pairs(&sampled.floor, &sampled.bounds),
            defect: sampled.defect,
            bounds: sampled.bounds,
        }))
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
        // E Π DΦᵀ + DΦ Π Eᵀ, the two of them transposes up to a sign.
        let floor = error.map(|error| {
            let one = error * (&before * tangent.transpose()).abs();
            &one + one.transpose()
        });
        let sizes = round_off::sizes_along(x, &next, tangent);
        let rows = round_off::of_rows(tangent, &sizes, &sizes);
        let one = rows * self.tensor.sizes(x, &sizes)? * tangent.abs().transpose();
        let bounds = &one + one.transpose() + self.tensor.sizes(&next, &sizes)?;
        Ok(Defect {
            norm: norm(&defect),
            scale: norm(&after),
            relative_floor: match &floor {
                Some(floor) => over_pairs(floor, &bounds),
                None => over_pairs(&defect, &bounds).map(|_| 0.0),
            },
            tangent: tangent.transpose().as_slice().to_vec(),
            next,
            floor: floor.as_ref().map(norm),
            defect,
            bounds,
        })
    }
}
