//! graph(dŜ) as a Lagrangian bisection.

use std::sync::Arc;

use leafwise_core::dynamics::Generating;
use leafwise_core::{
    BuildError, DynamicApproximation, GraphOfDifferential, LagrangianBisection, PoissonSystem,
    RealizationData,
};

use crate::coefficients::first_order;
use crate::form::shortest;
use crate::numbers::GraphOfEnergy;

/// The Hamilton–Jacobi approximation of even order m (paper, section 4.2 and Algorithm 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HamiltonJacobi {
    order: usize,
}

impl HamiltonJacobi {
    /// Order m, even and at least 2.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] for an odd order, with both neighbours named, and for 0.
    pub fn new(order: usize) -> Result<Self, BuildError> {
        if order == 0 || order % 2 == 1 {
            let expected = match order {
                0 | 1 => "the order m is even and at least 2".to_owned(),
                odd => format!(
                    "the order m is even, since even coefficients of S vanish: take {} or {}",
                    odd - 1,
                    odd + 1
                ),
            };
            return Err(BuildError::Parameter {
                part: crate::register::INFO.name,
                parameter: "order".to_owned(),
                value: order.to_string(),
                expected,
            });
        }
        Ok(Self { order })
    }
}

impl DynamicApproximation for HamiltonJacobi {
    fn order(&self) -> usize {
        self.order
    }

    /// S is odd in h (paper, Proposition 1), so the map is its own adjoint.
    fn self_adjoint(&self) -> Option<bool> {
        Some(true)
    }

    fn describe(&self) -> String {
        format!("{} m = {}", crate::register::INFO.name, self.order)
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<Arc<dyn LagrangianBisection>, BuildError> {
        if let Some(opaque) = system.opaque() {
            if self.order > 2 {
                let missing = "formulas of the system for an order above 2";
                return Err(opaque.not_offered(crate::register::INFO.name, missing));
            }
            let graph = GraphOfEnergy::new(system, realization, &self.describe())?;
            return Ok(Arc::new(graph));
        }
        let generating = match realization.series() {
            Some(series) => shortest(system, series, self.order)?,
            None if self.order == 2 => Generating::Polynomials(first_order(system)?),
            None => {
                return Err(BuildError::Incompatible {
                    dynamics: self.describe(),
                    realization: realization.describe(),
                    reason: "it offers no series of its source map; order 2, with S = h H alone, \
                             needs none"
                        .to_owned(),
                });
            }
        };
        let parameters = system.parameters().len();
        let graph =
            GraphOfDifferential::new(generating, realization, parameters, &self.describe())?;
        Ok(Arc::new(graph))
    }
}
