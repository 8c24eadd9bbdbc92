//! Over a realization that computes numbers: the same maps, and what is missing is said.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use crate::common::{
    Cayley, INTEGRATORS, Rotations, distance, karasev, lotka_volterra, method, rigid_body, run,
};
use leafwise_collective::{Collective, SymplecticIntegrator};
use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::{
    Abilities, Accuracy, BuildError, Correction, EndMaps, EndNumbers, Evaluator, Method,
    RealizationData, RealizationMaps, StepError, StepMap,
};
use leafwise_karasev::CollocatedKarasev;

/// A realization with its code forgotten: values and tangents, or values alone.
#[derive(Debug)]
struct Numbers<R> {
    of: R,
    tangents: bool,
}

struct ShortEvaluator {
    of: Box<dyn Evaluator>,
}

impl<R: RealizationData> RealizationData for Numbers<R> {
    fn dimension(&self) -> usize {
        self.of.dimension()
    }
    fn accuracy(&self) -> Accuracy {
        self.of.accuracy()
    }
    fn describe(&self) -> String {
        format!("{}, as numbers", self.of.describe())
    }
    fn section(&self, x: &[f64], z: &mut [f64]) {
        self.of.section(x, z);
    }
    fn abilities(&self) -> Abilities<'_> {
        let tangents = self.tangents;
        let maps = RealizationMaps::new(&self.of, 0).expect("maps");
        Abilities {
            ends: Some(EndMaps::Numbers(EndNumbers::new(
                tangents,
                move |parameters, epsilon| {
                    Box::new(ShortEvaluator {
                        of: maps.evaluator(parameters, epsilon),
                    })
                },
            ))),
            ..self.of.abilities()
        }
    }
}

impl Evaluator for ShortEvaluator {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        self.of.values(z, ends)
    }
    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        self.of.jacobians(z, tangents)
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

const START: [f64; 3] = [1.0, 1.5, -0.7];

/// Values and tangents are enough: stages, solve and end are those of the code, to the round-off that
/// ten steps gather.
#[test]
fn without_second_derivatives_the_map_is_the_same() {
    let system = rigid_body();
    let tangents = true;
    let pairs: [(Arc<dyn RealizationData>, Arc<dyn RealizationData>); 2] = [
        (
            Arc::new(Cayley),
            Arc::new(Numbers {
                of: Cayley,
                tangents,
            }),
        ),
        (
            Arc::new(Rotations),
            Arc::new(Numbers {
                of: Rotations,
                tangents,
            }),
        ),
    ];
    for (code, numbers) in pairs {
        for integrator in INTEGRATORS {
            for correction in [Correction::Bisection, Correction::None] {
                let [expected, found] = [&code, &numbers].map(|realization| {
                    let map = method(&system, realization, integrator, correction);
                    run(&map, 0.1, 10, &START)
                });
                let error = distance(&found, &expected);
                let bound = 10.0 * 8.0 * f64::EPSILON;
                assert!(
                    error <= bound,
                    "{}, {integrator}: {error:e}",
                    numbers.describe()
                );
            }
        }
    }
}

/// The instrument says that it has no tangent; it takes no differences.
#[test]
fn without_second_derivatives_the_tangent_is_not_offered() {
    let system = rigid_body();
    let numbers: Arc<dyn RealizationData> = Arc::new(Numbers {
        of: Cayley,
        tangents: true,
    });
    let gauss = SymplecticIntegrator::Gauss(2);
    let map = method(&system, &numbers, gauss, Correction::Bisection);
    let mut instrument = TensorDefect::new(&system, &map, &[], 1.0, 0.1).expect("a tensor");
    assert_eq!(instrument.measure(&START), Err(StepError::NoTangent));
}

#[test]
fn without_tangents_there_is_no_field() {
    let numbers = Arc::new(Numbers {
        of: Cayley,
        tangents: false,
    });
    let dynamics = Collective::new(SymplecticIntegrator::Gauss(1), Correction::Bisection);
    let dynamics = Arc::new(dynamics.expect("few stages"));
    let error = Method::compose(&rigid_body(), numbers, dynamics).expect_err("no gradient");
    assert!(matches!(error, BuildError::Incompatible { .. }), "{error}");
    assert!(error.to_string().contains("no tangents"), "{error}");
}

/// How many nodes the curve has is part of a checkpoint.
#[test]
fn a_resumed_run_over_collocation_has_the_same_bits() {
    let system = lotka_volterra();
    let collocated = CollocatedKarasev::new(&system, None).expect("a tensor with code");
    let realization: Arc<dyn RealizationData> = Arc::new(collocated);
    for integrator in INTEGRATORS {
        let map = method(&system, &realization, integrator, Correction::Bisection);
        let mut through = map.stepper(1, &[], 1.0, 0.2);
        let mut x = [1.0, 1.9, 0.5];
        for _ in 0..10 {
            crate::common::advance(through.as_mut(), &mut x);
        }
        let mut resumed = map.stepper(1, &[], 1.0, 0.2);
        resumed
            .restore(&through.memory())
            .expect("a memory of this map");
        let mut y = x;
        for _ in 0..10 {
            crate::common::advance(through.as_mut(), &mut x);
            crate::common::advance(resumed.as_mut(), &mut y);
        }
        assert_eq!(x.map(f64::to_bits), y.map(f64::to_bits), "{integrator}");
    }
}

/// Every evaluation of V, of Π and of the energy's derivatives is counted.
#[test]
fn operations_over_numbers_are_counted() {
    let system = lotka_volterra();
    let collocated = CollocatedKarasev::new(&system, Some(4)).expect("a tensor with code");
    let realization: Arc<dyn RealizationData> = Arc::new(collocated);
    let gauss = SymplecticIntegrator::Gauss(2);
    let map = method(&system, &realization, gauss, Correction::Bisection);
    let mut stepper = map.stepper(1, &[], 1.0, 0.1);
    crate::common::advance(stepper.as_mut(), &mut [1.0, 1.9, 0.5]);
    let operations = stepper.statistics().operations.expect("counted");
    assert!(operations > 10_000, "{operations}");
}

/// Stages and y are solved for together, with the Jacobians of the stages taken once a step: the bound is what 100 steps
/// were measured to take, 13 800, and a sixth. With the stages solved for anew at every y a step over such a truncation
/// took three times as much.
#[test]
fn a_corrected_step_is_one_solve() {
    let system = rigid_body();
    let gauss = SymplecticIntegrator::Gauss(2);
    let map = method(&system, &karasev(&system, 6), gauss, Correction::Bisection);
    let mut stepper = map.stepper(1, &[], 1.0, 0.1);
    let mut x = START;
    let mut operations = [0.0; 2];
    for total in &mut operations {
        (0..100).for_each(|_| crate::common::advance(stepper.as_mut(), &mut x));
        *total = stepper.statistics().operations.expect("counted") as f64 / 100.0;
    }
    let step = operations[1] - operations[0];
    println!("{step} operations, {:?}", stepper.statistics());
    assert!(step <= 16_000.0, "{step} operations a step");
}
