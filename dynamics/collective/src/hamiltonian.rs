//! The vector field of the collective Hamiltonian, as code.

use leafwise_core::realization::{ChartCode, MapCode};
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, Rational, StepSize, Term};

/// (x, p) ↦ (−∂K/∂p, ∂K/∂x) for K = H∘α̂_ε∘χ on T*M with ω = dp_i ∧ dxⁱ: the Hamiltonian vector
/// field of K. Functions move as ḟ = {K, f} with {xⁱ, p_j} = δ_ij (paper, section 2). The map χ is
/// the identity where `chart` is `None`.
///
/// # Errors
/// [`BuildError::Algebra`] where a formula or a derivative has no code.
pub fn collective_field(
    system: &SystemFormulas,
    realization: &MapCode<'_>,
    chart: Option<&ChartCode<'_>>,
) -> Result<SmoothMap, BuildError> {
    let (d, parameters) = (system.dimension(), system.parameters().len());
    let mut graph = Graph::new();
    let xp: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
    let epsilon = graph.step_size(StepSize::Epsilon);
    let z = match chart {
        None => xp,
        Some(chart) => chart(&mut graph, &epsilon, &xp[..d], &xp[d..])?,
    };
    let ends = realization(&mut graph, &epsilon, &z)?;
    let alpha: Vec<Term> = (0..d)
        .map(|i| {
            let parts = [&ends.base[i], &ends.offset[i], &ends.increment[i]];
            graph.combine(&parts.map(|part| (Rational::one(), part.clone())))
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
    SmoothMap::compile(graph, &outputs, parameters, 2 * d)
}
