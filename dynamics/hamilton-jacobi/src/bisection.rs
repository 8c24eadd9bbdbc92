//! graph(dŜ) as a Lagrangian bisection.

use std::sync::Arc;

use leafwise_core::dynamics::{
    BisectionCode, DynamicApproximation, GeneratingFunction, LagrangianBisection,
};
use leafwise_core::{BuildError, PoissonSystem, RealizationData};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Term};

use crate::coefficients::generating_function;

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
        let series = realization
            .series()
            .ok_or_else(|| BuildError::Incompatible {
                dynamics: self.describe(),
                realization: realization.describe(),
                reason: "it offers no series of its source map in a cotangent chart".to_owned(),
            })?;
        let generating = generating_function(system, series, self.order)?;
        Ok(Arc::new(GraphOfDifferential {
            generating,
            realization: Arc::clone(realization),
        }))
    }
}

/// y ↦ χ(y, dŜ_{ε,h}(y)), χ the realization's chart about σ; (y, dŜ(y)) itself on T*M.
#[derive(Clone, Debug)]
struct GraphOfDifferential {
    generating: GeneratingFunction,
    realization: Arc<dyn RealizationData>,
}

impl LagrangianBisection for GraphOfDifferential {
    fn code(&self) -> Option<&dyn BisectionCode> {
        Some(self)
    }

    fn generating_function(&self) -> Option<&GeneratingFunction> {
        Some(&self.generating)
    }
}

impl BisectionCode for GraphOfDifferential {
    fn point(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        h: &Term,
        y: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        // ε^{l−1} hˡ for l = 1, 3, …
        let time = graph.multiply(epsilon, h);
        let square = graph.multiply(&time, &time);
        let mut power = h.clone();
        let mut outputs: Vec<Vec<(Term, Polynomial)>> = vec![Vec::new(); y.len()];
        for gradient in &self.generating.gradients {
            for (output, component) in outputs.iter_mut().zip(gradient) {
                output.push((power.clone(), component.clone()));
            }
            power = graph.multiply(&power, &square);
        }
        let p = lift(graph, &self.generating.ring, &outputs, y)?;
        match self.realization.chart() {
            None => Ok(y.iter().cloned().chain(p).collect()),
            Some(chart) => chart.point(graph, epsilon, y, &p),
        }
    }
}
