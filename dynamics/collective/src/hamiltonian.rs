//! The vector field of the collective Hamiltonian.

use leafwise_core::realization::{LagrangianChart, RealizationCode};
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, StepSize, Term};

/// The field of K = H∘α̂_ε∘χ on T*M with ω = dp_i ∧ dxⁱ, and the chart χ.
#[derive(Clone, Debug)]
pub struct CollectiveField {
    /// (x, p) ↦ (−∂K/∂p, ∂K/∂x): ḟ = {K, f} with {xⁱ, p_j} = δ_ij (paper, section 2).
    pub field: SmoothMap,
    /// (x, p) ↦ χ(x, p), `None` where points of S are pairs (x, p).
    pub chart: Option<SmoothMap>,
}

impl CollectiveField {
    /// Compiles the field and its Jacobian for a system, a realization's maps and its chart.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or a derivative has no code.
    pub fn compile(
        system: &SystemFormulas,
        realization: &dyn RealizationCode,
        chart: Option<&dyn LagrangianChart>,
    ) -> Result<Self, BuildError> {
        let (d, parameters) = (system.dimension(), system.parameters().len());
        let mut graph = Graph::new();
        let xp: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let (x, p) = xp.split_at(d);
        let z = match chart {
            None => xp.clone(),
            Some(chart) => chart.point(&mut graph, &epsilon, x, p)?,
        };
        let ends = realization.source_and_target(&mut graph, &epsilon, &z)?;
        let one = leafwise_expression::Rational::one();
        let alpha: Vec<Term> = (0..d)
            .map(|i| {
                let parts = [&ends.base[i], &ends.offset[i], &ends.increment[i]];
                graph.combine(&parts.map(|part| (one.clone(), part.clone())))
            })
            .collect();
        let energy = system
            .hamiltonian()
            .evaluate_in(&mut graph, &mut |_, at| Ok(alpha[at].clone()))?;
        let mut outputs = Vec::with_capacity(2 * d);
        for i in 0..d {
            let slope = graph.derivative(&energy, d + i)?;
            outputs.push(graph.negate(&slope));
        }
        for i in 0..d {
            outputs.push(graph.derivative(&energy, i)?);
        }
        let field = SmoothMap::compile(&mut graph, &outputs, parameters, 2 * d)?;
        let chart = match chart {
            None => None,
            Some(_) => Some(SmoothMap::compile(&mut graph, &z, parameters, 2 * d)?),
        };
        Ok(Self { field, chart })
    }
}
