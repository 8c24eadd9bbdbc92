//! Parts of the plugins in these tests, compiled in: the same operations in the same order.

#![allow(dead_code, reason = "each file uses a part of it")]

use leafwise_core::system::numbers::vector;
use leafwise_core::system::{
    Derivatives, OpaqueSystem, SystemEvaluator, SystemFunction, SystemNumbers,
};
use leafwise_core::{
    Abilities, Accuracy, EndMaps, EndNumbers, Evaluator, MapProperties, PoissonSystem,
    RealizationData, SolverStatistics, StepError, StepMap, Stepper, Structure,
};
use leafwise_example_plugin::Rodrigues;
use leafwise_plugin_sdk::ChartRealization;

/// The realization of the example plugin in Rust: numbers alone.
#[derive(Debug)]
pub struct RodriguesTwin;

impl RealizationData for RodriguesTwin {
    fn dimension(&self) -> usize {
        3
    }
    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }
    fn describe(&self) -> String {
        "rodrigues".to_owned()
    }
    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            ends: Some(EndMaps::Numbers(EndNumbers::new(true, |_, epsilon| {
                Box::new(RodriguesEvaluator { epsilon })
            }))),
            ..Abilities::default()
        }
    }
}

struct RodriguesEvaluator {
    epsilon: f64,
}

impl RodriguesEvaluator {
    fn parts(&self, z: &[f64], base: &mut [f64], even: &mut [f64], odd: &mut [f64]) {
        let (x, p) = z.split_at(3);
        Rodrigues
            .parts(self.epsilon, x, p, even, odd)
            .expect("defined everywhere");
        base.copy_from_slice(x);
        for (even, odd) in even.iter_mut().zip(odd) {
            *even -= *odd;
            *odd *= 2.0;
        }
    }

    fn jacobian(&self, z: &[f64], target: &mut [f64], increment: &mut [f64]) {
        let (x, p) = z.split_at(3);
        let parts = Rodrigues.jacobian(self.epsilon, x, p, target, increment);
        parts.expect("defined everywhere");
        for (even, odd) in target.iter_mut().zip(increment) {
            *even -= *odd;
            *odd *= 2.0;
        }
        (0..3).for_each(|i| target[i * 7] += 1.0);
    }
}

impl Evaluator for RodriguesEvaluator {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        for (z, ends) in z.chunks_exact(6).zip(ends.chunks_exact_mut(9)) {
            let (base, rest) = ends.split_at_mut(3);
            let (even, odd) = rest.split_at_mut(3);
            self.parts(z, base, even, odd);
        }
        Ok(())
    }

    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        for (z, tangents) in z.chunks_exact(6).zip(tangents.chunks_exact_mut(36)) {
            let (target, increment) = tangents.split_at_mut(18);
            self.jacobian(z, target, increment);
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

/// The gyrostat of the C example.
struct Gyrostat;

impl SystemEvaluator for Gyrostat {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        match function {
            SystemFunction::Tensor(v) => cross(y, v, out),
            SystemFunction::TensorTangent(v, w) => cross(w, v, out),
            SystemFunction::Hamiltonian => {
                for (out, y) in out.iter_mut().zip(y.chunks_exact(3)) {
                    let energy =
                        (0..3).fold(0.0, |sum, a| sum + 0.5 * inverse_inertia(a) * y[a] * y[a]);
                    *out = energy - 0.3 * y[2];
                }
            }
            SystemFunction::Gradient => {
                for (out, y) in out.chunks_exact_mut(3).zip(y.chunks_exact(3)) {
                    for a in 0..3 {
                        out[a] = inverse_inertia(a) * y[a] - if a == 2 { 0.3 } else { 0.0 };
                    }
                }
            }
            SystemFunction::Casimirs => {
                for (out, y) in out.iter_mut().zip(y.chunks_exact(3)) {
                    *out = y[0] * y[0] + y[1] * y[1] + y[2] * y[2];
                }
            }
            SystemFunction::Hessian(v) => {
                for (at, out) in out.chunks_exact_mut(3).enumerate() {
                    let v = vector(v, 3, at);
                    (0..3).for_each(|a| out[a] = inverse_inertia(a) * v[a]);
                }
            }
            SystemFunction::CasimirGradients => return Err(StepError::NoTangent),
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

/// y × v at each point.
fn cross(y: &[f64], v: &[f64], out: &mut [f64]) {
    for (at, out) in out.chunks_exact_mut(3).enumerate() {
        let (y, v) = (vector(y, 3, at), vector(v, 3, at));
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            out[a] = y[b] * v[c] - y[c] * v[b];
        }
    }
}

fn inverse_inertia(axis: usize) -> f64 {
    1.0 / [1.0, 0.75, 1.25][axis]
}

/// The gyrostat with the names of `loaded`, at its default parameters.
pub fn gyrostat_twin(loaded: &PoissonSystem) -> PoissonSystem {
    let derivatives = Derivatives {
        tensor: true,
        hamiltonian: true,
        casimirs: false,
    };
    OpaqueSystem {
        name: "gyrostat".to_owned(),
        variables: loaded.variables().to_vec(),
        parameters: loaded.parameters().to_vec(),
        casimirs: vec!["spin".to_owned()],
        numbers: SystemNumbers::new(derivatives, |_| Box::new(Gyrostat)),
    }
    .into()
}

/// Heun's rule of the C fixture `steps` on a system of dimension 3, all lanes with one set of
/// parameters.
pub struct HeunTwin(pub PoissonSystem);

struct Heun {
    evaluator: Box<dyn SystemEvaluator>,
    t: f64,
    weight: f64,
}

impl Heun {
    fn field(&mut self, y: &[f64; 3]) -> [f64; 3] {
        let (mut gradient, mut out) = ([0.0; 3], [0.0; 3]);
        self.evaluator.gradient(y, &mut gradient).expect("formulas");
        self.evaluator
            .tensor(y, &gradient, &mut out)
            .expect("formulas");
        out.map(|v| -v)
    }
}

impl Stepper for Heun {
    fn increment(
        &mut self,
        x: &[f64],
        _: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let (t, w, lanes) = (self.t, self.weight, outcome.len());
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            let start = [0, 1, 2].map(|j| x[j * lanes + lane]);
            let first = self.field(&start);
            let stage = [0, 1, 2].map(|j| start[j] + t * first[j]);
            let second = self.field(&stage);
            for j in 0..3 {
                increment[j * lanes + lane] = t * ((1.0 - w) * first[j] + w * second[j]);
            }
            *outcome = Ok(());
        }
    }
    fn restart(&mut self) {}
    fn statistics(&self) -> SolverStatistics {
        SolverStatistics::default()
    }
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    fn restore(&mut self, _: &[f64]) -> Result<(), usize> {
        Ok(())
    }
}

impl StepMap for HeunTwin {
    fn dimension(&self) -> usize {
        3
    }
    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 2,
            structure: Structure::None,
            self_adjoint: Some(false),
        }
    }
    fn describe(&self) -> String {
        "heun".to_owned()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let own: Vec<f64> = parameters.iter().step_by(lanes).copied().collect();
        Box::new(Heun {
            evaluator: self.0.numbers().expect("formulas").evaluator(&own),
            t: epsilon * h,
            weight: 0.25,
        })
    }
}
