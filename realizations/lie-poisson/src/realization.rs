//! The realization data of a linear tensor.

use leafwise_core::realization::{Accuracy, RealizationData, RealizationWorker, SourceSeries};
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_karasev::series::KarasevSeries;

use crate::register::INFO;
use crate::structure::StructureConstants;
use crate::worker::LiePoissonWorker;

/// α = Z/(e^Z − 1) x, β = e^Z α with Z = ε A(p), A_ik = Σ_j c_ij^k p_j.
///
/// Its maps are numbers, exact to round-off while every eigenvalue of Z has an imaginary part
/// below 2π; beyond, a step is refused as `LeftChart`. Real eigenvalues are harmless. The chart is
/// Karasev's, and so is the series.
#[derive(Clone, Debug)]
pub struct LiePoisson {
    dimension: usize,
    structure: StructureConstants,
    series: KarasevSeries,
}

impl LiePoisson {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// Those of [`StructureConstants::new`]: [`BuildError::DoesNotFit`] for a tensor that is not
    /// linear.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let formulas = system.formulas(INFO.name)?;
        Ok(Self {
            dimension: system.dimension(),
            structure: StructureConstants::new(formulas)?,
            series: KarasevSeries::new(formulas.clone()),
        })
    }
}

impl RealizationData for LiePoisson {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn space_dimension(&self) -> usize {
        2 * self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn section(&self, x: &[f64], z: &mut [f64]) {
        z[..x.len()].copy_from_slice(x);
        z[x.len()..].fill(0.0);
    }

    fn worker(&self, parameters: &[f64], epsilon: f64) -> Option<Box<dyn RealizationWorker>> {
        let algebra = self.structure.at(parameters);
        Some(Box::new(LiePoissonWorker::new(algebra, epsilon)))
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        Some(&self.series)
    }
}
