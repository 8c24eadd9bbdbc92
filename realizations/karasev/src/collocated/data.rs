//! Karasev's realization data, numerically exact.

use std::sync::Arc;

use leafwise_core::{
    Accuracy, BuildError, LagrangianBisection, MapProperties, PoissonSystem, RealizationData,
    RealizationWorker, SourceSeries, StepMap,
};

use leafwise_expression::Kernel;

use super::curve::Curve;
use super::field::Field;
use super::fused::{FusedStep, OneForm};
use super::worker::CollocatedWorker;
use crate::series::KarasevSeries;

/// K_ε = (S ⊂ T*M, ω_M, α_ε, β_ε, σ) by collocation at q Gauss nodes, for any tensor with values
/// of Π(y)p; its tangents where the tensor has first derivatives.
///
/// With a fixed q the bracket defect of α̂ is O(ε^{2q}); the automatic choice adds nodes until the
/// defect is at round-off for the step at hand.
#[derive(Clone, Debug)]
pub struct CollocatedKarasev {
    field: Field,
    points: Option<usize>,
    /// Where the tensor is a formula.
    series: Option<KarasevSeries>,
}

/// Where the automatic choice starts, and where it gives up: the curve is then too long for its
/// chart.
pub(super) const FEWEST_POINTS: usize = 3;
const MOST_POINTS: usize = 24;

impl CollocatedKarasev {
    pub(super) fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.field.kernels()
    }

    /// The realization at `points` nodes, or at as many as the step needs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor has no code.
    pub fn new(system: &PoissonSystem, points: Option<usize>) -> Result<Self, BuildError> {
        let formulas = system.expressions();
        Ok(Self {
            field: Field::of(system)?,
            points,
            series: formulas.map(|formulas| KarasevSeries::new(formulas.clone())),
        })
    }

    pub(super) fn curve(&self, parameters: &[f64]) -> Curve {
        Curve::new(
            &self.field,
            parameters,
            self.points.unwrap_or(FEWEST_POINTS),
        )
    }

    pub(super) fn most_points(&self) -> Option<usize> {
        if self.points.is_some() {
            None
        } else {
            Some(MOST_POINTS)
        }
    }
}

impl RealizationData for CollocatedKarasev {
    fn dimension(&self) -> usize {
        self.field.dimension
    }

    fn space_dimension(&self) -> usize {
        2 * self.field.dimension
    }

    fn accuracy(&self) -> Accuracy {
        match self.points {
            None => Accuracy::Exact,
            Some(q) => Accuracy::Order(2 * q - 1),
        }
    }

    fn describe(&self) -> String {
        match self.points {
            None => format!(
                "{} (as many nodes as needed)",
                crate::register::COLLOCATED.name
            ),
            Some(q) => format!("{} q = {q}", crate::register::COLLOCATED.name),
        }
    }

    fn section(&self, x: &[f64], z: &mut [f64]) {
        z[..x.len()].copy_from_slice(x);
        z[x.len()..].fill(0.0);
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        self.series
            .as_ref()
            .map(|series| series as &dyn SourceSeries)
    }

    fn worker(&self, parameters: &[f64], epsilon: f64) -> Option<Box<dyn RealizationWorker>> {
        let curve = self.curve(parameters);
        let d = self.field.dimension;
        let worker = CollocatedWorker::new(curve, epsilon, self.most_points(), d);
        Some(Box::new(worker))
    }

    fn fuse(
        self: Arc<Self>,
        system: &PoissonSystem,
        bisection: Arc<dyn LagrangianBisection>,
        properties: MapProperties,
    ) -> Option<Result<Box<dyn StepMap>, BuildError>> {
        // Only the graph of a one-form says p at x̂.
        let form = OneForm::of(system, &bisection)?;
        let fused = form.map(|form| FusedStep::new(self, form, properties));
        Some(fused.map(|fused| Box::new(fused) as Box<dyn StepMap>))
    }
}
