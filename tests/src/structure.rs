//! The tensor and the Casimirs under one step.

use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::{PoissonSystem, StepError, StepMap};
use leafwise_expression::{Graph, Term};
use nalgebra::DMatrix;

use crate::methods::{evaluate, observe};
use crate::numbers::{UNIT_ROUNDOFF, largest};

/// How far one step is from a Poisson map that keeps every Casimir, in units of the round-off it
/// must have: u times the largest summand and the conditioning of the solve, which is that of DΦ.
#[derive(Clone, Copy, Debug)]
pub struct StructureError {
    /// ‖DΦ Π DΦᵀ − Π∘Φ‖ over u · largest summand · κ(DΦ).
    pub tensor: f64,
    /// max |C(Φ(x)) − C(x)| over u · Σ|∂ᵢC xᵢ| · κ(DΦ).
    pub casimirs: f64,
}

/// One step of εh = `time_step` from `x`.
///
/// # Errors
/// The solver's [`StepError`].
///
/// # Panics
/// When a formula has no code.
pub fn structure_error(
    system: &PoissonSystem,
    map: &dyn StepMap,
    time_step: f64,
    x: &[f64],
) -> Result<StructureError, StepError> {
    let d = x.len();
    let parameters = system.parameter_values();
    let mut instrument =
        TensorDefect::new(system, map, &parameters, 1.0, time_step).expect("a tensor with code");
    let defect = instrument.measure(x)?;
    let tangent = DMatrix::from_row_slice(d, d, &defect.tangent);
    let inverse = tangent
        .clone()
        .try_inverse()
        .expect("a step is a diffeomorphism");
    let conditioning = tangent.norm() * inverse.norm() / d as f64;
    let formulas = system.expressions().expect("formulas");
    let entries: Vec<_> = formulas.tensor().values().collect();
    let entries = observe(system, &entries, x);
    let mut sizes = DMatrix::zeros(d, d);
    for (&(i, j), value) in formulas.tensor().keys().zip(entries) {
        sizes[(i, j)] = value.abs();
        sizes[(j, i)] = value.abs();
    }
    let summand = (tangent.abs() * sizes * tangent.transpose().abs()).norm();
    let mut casimirs = 0.0_f64;
    for casimir in formulas.casimirs() {
        let mut graph = Graph::new();
        let inputs: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let value = casimir
            .expression
            .evaluate_in(&mut graph, &mut |_, at| Ok(inputs[at].clone()))
            .expect("code");
        let mut outputs = vec![value.clone()];
        for i in 0..d {
            outputs.push(graph.derivative(&value, i).expect("code"));
        }
        let [before, after] = [x, &defect.next].map(|x| evaluate(system, &graph, &outputs, x));
        let size: f64 = (0..d).map(|i| (before[1 + i] * x[i]).abs()).sum();
        let error = (after[0] - before[0]).abs() / (UNIT_ROUNDOFF * size * conditioning);
        casimirs = largest([casimirs, error]);
    }
    Ok(StructureError {
        tensor: defect.norm / (UNIT_ROUNDOFF * summand * conditioning),
        casimirs,
    })
}
