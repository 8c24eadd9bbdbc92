//! A dynamic approximation by the coefficients of its generating function.

use std::sync::Arc;

use leafwise_expression::{DifferentialAlgebra, Expression, Graph, Ring};

use crate::bisection::LagrangianBisection;
use crate::diagnostics::same_motion::other_motion;
use crate::dimensions::Dimensions;
use crate::dynamics::{
    Correction, DynamicApproximation, DynamicsProperties, Generating, GeneratingCode,
    GeneratingFunction,
};
use crate::error::BuildError;
use crate::one_form::OneForm;
use crate::realization::RealizationData;
use crate::system::PoissonSystem;

/// The most characters of a difference that a message holds.
const LONGEST: usize = 80;

/// Operations of the longest code that is compared with an expansion.
const MOST_NODES: usize = 1 << 18;

/// S_l and dS_l for l = 1, 3, ….
type Coefficients<E> = (Vec<E>, Vec<Vec<E>>);

/// graph(dŜ), Ŝ_{ε,h} = Σ_{l odd} ε^{l−1} hˡ S_l by formulas of the coordinates and the system's parameters.
#[derive(Clone, Debug)]
pub struct FormulaDynamics {
    /// The part's name.
    pub name: &'static str,
    /// The order m that is claimed.
    pub order: usize,
    /// Whether the induced map is self-adjoint over a realization with β̂(x, p) = α̂(x, −p).
    pub self_adjoint: Option<bool>,
    /// Whether β̂(L(y)) = x is solved.
    pub correction: Correction,
    /// The dimensions that it serves.
    pub dimensions: Dimensions,
    /// S_1, S_3, ….
    pub coefficients: Vec<Expression>,
}

impl FormulaDynamics {
    /// Ŝ over a system: expanded, or as code where an expansion cancels.
    fn generating(&self, system: &PoissonSystem) -> Result<Generating, BuildError> {
        let d = system.dimension();
        let mut ring = Ring::new(d);
        let (coefficients, gradients) = self.coefficients_in(&mut ring, d)?;
        let function = GeneratingFunction {
            ring,
            coefficients,
            gradients,
        };
        let Some(formulas) = system.expressions() else {
            return Ok(Generating::Polynomials(function));
        };
        let mut graph = Graph::limited(MOST_NODES);
        let (coefficients, gradients) = self.coefficients_in(&mut graph, d)?;
        if graph.unless_refused(()).is_err() {
            return Ok(Generating::Polynomials(function));
        }
        let code = GeneratingCode {
            graph,
            coefficients,
            gradients,
        };
        Ok(match function.rounds_as(&code, formulas)? {
            true => Generating::Polynomials(function),
            false => Generating::Code(code),
        })
    }

    /// S_l and dS_l for l = 1, 3, ….
    fn coefficients_in<A: DifferentialAlgebra>(
        &self,
        algebra: &mut A,
        d: usize,
    ) -> Result<Coefficients<A::Element>, BuildError> {
        let mut coefficients = Vec::with_capacity(self.coefficients.len());
        let mut gradients = Vec::with_capacity(self.coefficients.len());
        for formula in &self.coefficients {
            if let Some(index) = formula.variables().last().filter(|index| **index >= d) {
                return Err(BuildError::DoesNotFit {
                    part: self.name,
                    reason: format!("it names x{}, and this system has dimension {d}", index + 1),
                });
            }
            let s = formula.evaluate_in(algebra, &mut |algebra, at| Ok(algebra.coordinate(at)))?;
            gradients.push(algebra.differential(&s, d)?);
            coefficients.push(s);
        }
        Ok((coefficients, gradients))
    }

    /// S_1 = H in every chart, up to a Casimir: what {S_1, x} and {H, x} differ by is not of an order in h.
    fn check_first(&self, system: &PoissonSystem) -> Result<(), BuildError> {
        let (Some(formulas), Some(first)) = (system.expressions(), self.coefficients.first())
        else {
            return Ok(());
        };
        let Some(other) = other_motion(formulas, first) else {
            return Ok(());
        };
        let parameters = system.parameters().iter();
        let parameters: Vec<String> = parameters.map(|known| known.name.clone()).collect();
        let mut difference = other.difference.written(system.variables(), &parameters);
        if difference.chars().count() > LONGEST {
            difference = difference.chars().take(LONGEST).chain(['…']).collect();
        }
        Err(BuildError::DoesNotFit {
            part: self.name,
            reason: format!(
                "it follows another motion: S_1 - H = {difference}, which moves {}; S_1 is H, up to a Casimir",
                system.variables()[other.coordinate]
            ),
        })
    }
}

impl DynamicApproximation for FormulaDynamics {
    fn properties(&self) -> DynamicsProperties {
        DynamicsProperties {
            correction: self.correction,
            ..DynamicsProperties::of_order(self.order, self.self_adjoint)
        }
    }

    fn describe(&self) -> String {
        format!("{} m = {}", self.name, self.order)
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        self.dimensions.check(self.name, system.dimension())?;
        self.check_first(system)?;
        let form = OneForm::Differential(self.generating(system)?);
        let parameters = system.parameters().len();
        LagrangianBisection::odd_graph(form, realization, parameters, &self.describe())
    }
}
