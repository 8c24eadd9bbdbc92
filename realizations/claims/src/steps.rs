//! The tensor and the Casimirs under one step; measured orders.

use std::sync::Arc;

use leafwise_core::diagnostics::{Slope, TensorDefect, fit_slope};
use leafwise_core::{Integrator, Method, PoissonSystem, RealizationData, StepError, StepMap};
use leafwise_expression::{Graph, Kernel, Term};
use leafwise_hamilton_jacobi::HamiltonJacobi;
use nalgebra::DMatrix;

use crate::{UNIT_ROUNDOFF, largest};

/// `hamilton-jacobi` of order m over a realization.
///
/// # Panics
/// When the parts do not fit.
pub fn method(system: &PoissonSystem, realization: &Arc<dyn RealizationData>, m: usize) -> Method {
    let dynamics = HamiltonJacobi::new(m).expect("an even order");
    Method::compose(system, Arc::clone(realization), Arc::new(dynamics)).expect("the parts fit")
}

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
    let formulas: Vec<_> = system
        .expressions()
        .expect("formulas")
        .tensor()
        .values()
        .collect();
    let entries = evaluate(
        &system
            .expressions()
            .expect("formulas")
            .observable_kernel(&formulas)
            .expect("code"),
        &parameters,
        x,
    );
    let mut sizes = DMatrix::zeros(d, d);
    for (&(i, j), value) in system
        .expressions()
        .expect("formulas")
        .tensor()
        .keys()
        .zip(entries)
    {
        sizes[(i, j)] = value.abs();
        sizes[(j, i)] = value.abs();
    }
    let summand = (tangent.abs() * sizes * tangent.transpose().abs()).norm();
    let mut casimirs = 0.0_f64;
    for casimir in system.expressions().expect("formulas").casimirs() {
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
        let kernel = Kernel::compile(&graph, &outputs, parameters.len(), d);
        let (before, after) = (
            evaluate(&kernel, &parameters, x),
            evaluate(&kernel, &parameters, &defect.next),
        );
        let size: f64 = (0..d).map(|i| (before[1 + i] * x[i]).abs()).sum();
        let error = (after[0] - before[0]).abs() / (UNIT_ROUNDOFF * size * conditioning);
        casimirs = largest([casimirs, error]);
    }
    Ok(StructureError {
        tensor: defect.norm / (UNIT_ROUNDOFF * summand * conditioning),
        casimirs,
    })
}

fn evaluate(kernel: &Kernel, parameters: &[f64], x: &[f64]) -> Vec<f64> {
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
    let mut values = vec![0.0; kernel.outputs()];
    kernel.evaluate(&mut workspace, x, &mut values);
    values
}

/// The state after `steps` steps of total time `time`.
///
/// # Errors
/// The first step's error.
pub fn run(
    system: &PoissonSystem,
    map: &dyn StepMap,
    time: f64,
    steps: usize,
    initial: &[f64],
) -> Result<Vec<f64>, StepError> {
    let parameters = system.parameter_values();
    let mut integrator = Integrator::new(map, &parameters, 1.0, time / steps as f64, initial);
    for _ in 0..steps {
        integrator.step()?;
    }
    Ok(integrator.state().to_vec())
}

/// The slope of the error after `time` over the step size, for each number of steps given; errors
/// within a hundred roundings a step of the reference are dropped. `None` with under three left.
///
/// # Panics
/// When a step fails.
pub fn measured_order(
    system: &PoissonSystem,
    map: &dyn StepMap,
    initial: &[f64],
    time: f64,
    steps: &[usize],
) -> Option<Slope> {
    let reference = flow(system, initial, time, 64);
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&steps| {
            let state = run(system, map, time, steps, initial).expect("a step");
            (time / steps as f64, crate::distance(&state, &reference))
        })
        .collect();
    fit_slope(&points, 1e3 * UNIT_ROUNDOFF * largest(reference))
}

/// Whether a slope is that of order m of a self-adjoint method: even orders lie 2 apart, and the
/// next term of the error moves the slope by less than a quarter of that.
pub fn is_even_order(slope: Slope, m: usize) -> bool {
    (slope.exponent - m as f64).abs() < 0.5
}

/// The flow of ẋ = X_H(x) by extrapolation of Gragg's modified midpoint rule in eight columns
/// (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, section II.9): an oracle
/// that shares only the compiled vector field with the methods under test.
///
/// # Panics
/// When the vector field has no code.
pub fn flow(system: &PoissonSystem, initial: &[f64], time: f64, steps: usize) -> Vec<f64> {
    const COLUMNS: usize = 8;
    let kernel = system
        .expressions()
        .expect("formulas")
        .vector_field_kernel()
        .expect("a field with code");
    let parameters = system.parameter_values();
    let field = |x: &[f64]| evaluate(&kernel, &parameters, x);
    let plus = |x: &[f64], h: f64, v: &[f64]| -> Vec<f64> {
        x.iter().zip(v).map(|(x, v)| x + h * v).collect()
    };
    let step = time / steps as f64;
    let mut x = initial.to_vec();
    for _ in 0..steps {
        let mut table: Vec<Vec<f64>> = Vec::with_capacity(COLUMNS);
        for row in 0..COLUMNS {
            let count = 2 * (row + 1);
            let h = step / count as f64;
            let (mut before, mut here) = (x.clone(), plus(&x, h, &field(&x)));
            for _ in 1..count {
                let next = plus(&before, 2.0 * h, &field(&here));
                before = std::mem::replace(&mut here, next);
            }
            let mut value = plus(&before, h, &field(&here));
            value
                .iter_mut()
                .zip(&here)
                .for_each(|(v, h)| *v = 0.5 * (*v + h));
            // T_{j,k+1} = T_{j,k} + (T_{j,k} − T_{j−1,k})/((n_j/n_{j−k})² − 1), in place.
            for k in 0..row {
                let ratio = (row + 1) as f64 / (row - k) as f64;
                let factor = 1.0 / (ratio * ratio - 1.0);
                let lower = std::mem::replace(&mut table[k], value.clone());
                value = (value.iter().zip(&lower))
                    .map(|(v, l)| v + factor * (v - l))
                    .collect();
            }
            table.push(value);
        }
        x.clone_from(&table[COLUMNS - 1]);
    }
    x
}

/// x⁺ = x + h X_H((x + x⁺)/2), solved by fixed-point iteration on the vector field alone.
///
/// # Panics
/// When the vector field has no code.
pub fn implicit_midpoint(system: &PoissonSystem, h: f64, x: &[f64]) -> Vec<f64> {
    let kernel = system
        .expressions()
        .expect("formulas")
        .vector_field_kernel()
        .expect("code");
    let parameters = system.parameter_values();
    let mut next = x.to_vec();
    for _ in 0..100 {
        let middle: Vec<f64> = x.iter().zip(&next).map(|(a, b)| 0.5 * (a + b)).collect();
        let field = evaluate(&kernel, &parameters, &middle);
        next = x.iter().zip(&field).map(|(x, f)| x + h * f).collect();
    }
    next
}
