//! Graphs of one-forms that need not be closed: maps along symplectic leaves.
//!
//! For realization data (S, ω, α, β, σ) with a chart about σ, the points α(y, ξ) and β(y, ξ) lie on one symplectic
//! leaf whatever the covector ξ is. Hence every small one-form ξ(y) gives a map β(y, ξ(y)) ↦ α(y, ξ(y)) along leaves,
//! which keeps all Casimirs. The map is Poisson where ξ is closed (paper, section 2). With ξ = h (dH + η) and
//! β(x, p) = α(x, −p) it is its own adjoint. Its order is then 2 for ẋ = −Π(dH + η), the motion under forces η.

use std::sync::Arc;

use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{
    BuildError, DynamicApproximation, DynamicsProperties, LagrangianBisection, MotionClass,
    OneForm, PoissonSystem, RealizationData,
};
use leafwise_expression::{Arithmetic, Graph, StepSize, Term};

static INFO: PartInfo = PartInfo {
    name: "one-form",
    summary: "graph of h (dH + eta), eta the forces of the system: along symplectic leaves",
    declares: "order 2; self-adjoint; leaf-preserving over an exact realization, not Poisson: every Casimir to round-off",
    domain: "systems with forces; realizations with a cotangent chart",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, section 2; \
                 Bloch, Krishnaprasad, Marsden, Ratiu, The Euler-Poincare equations and double bracket \
                 dissipation, Comm. Math. Phys. 175 (1996)",
    auto: Some(Auto::Forces),
    takes: MotionClass::OnLeaves,
    ..PartInfo::of(PartKind::Dynamics)
};

/// y ↦ (y, h (dH + η)(y)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ForcedGraph;

impl DynamicApproximation for ForcedGraph {
    /// The form is odd in h, so the map is its own adjoint.
    fn properties(&self) -> DynamicsProperties {
        DynamicsProperties {
            is_lagrangian: false,
            takes: MotionClass::OnLeaves,
            ..DynamicsProperties::of_order(2, Some(true))
        }
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        let formulas = system.formulas(INFO.name)?;
        if formulas.forces().is_empty() {
            return Err(BuildError::DoesNotFit {
                part: INFO.name,
                reason: "it has no forces; hamilton-jacobi of order 2 is the same map there, and Poisson".to_owned(),
            });
        }
        let mut graph = Graph::compilable();
        let y: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
        let h = graph.step_size(StepSize::H);
        let form = formulas.one_form(&mut graph, &y)?;
        let components = form.iter().map(|p| graph.multiply(&h, p)).collect();
        graph.unless_refused(())?;
        let form = OneForm::Code { graph, components };
        let parameters = system.parameters().len();
        LagrangianBisection::odd_graph(form, realization, parameters, INFO.name)
    }
}

fn build(parameters: &PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(ForcedGraph))
}

leafwise_core::built_in!(DynamicsPart::new(&INFO, build));
