//! The part `collective`: parameters, refusals, failures, checkpoints.

use std::sync::Arc;

use crate::common::{Cayley, advance, karasev, lotka_volterra, method, rigid_body};
use leafwise_collective::{Collective, SymplecticIntegrator};
use leafwise_core::{
    Abilities, Accuracy, BuildError, Correction, DynamicApproximation, EndMaps, Method,
    PartParameters, RealizationData, Registry, SourceTarget, Space, StepError, StepMap, Walk,
};
use leafwise_expression::{Graph, Term};

fn build(parameters: &PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
    Registry::with_builtin()
        .dynamics("collective")
        .expect("the part is linked")
        .build(parameters)
}

#[test]
fn parameters_choose_the_integrator() {
    let none = PartParameters::new();
    let named = |name: &str| none.clone().with("integrator", name);
    let described = |parameters: &PartParameters| {
        let dynamics = build(parameters).expect("parameters in range");
        (dynamics.describe(), dynamics.properties().order)
    };
    let expected = |text: &str, order| (text.to_owned(), order);
    assert_eq!(described(&none), expected("collective gauss s = 2", 4));
    assert_eq!(
        described(&none.clone().with("stages", 8)),
        expected("collective gauss s = 8", 16)
    );
    assert_eq!(
        described(&named("stormer-verlet")),
        expected("collective stormer-verlet", 2)
    );
    assert_eq!(
        described(&named("implicit-midpoint").with("correction", "none")),
        expected("collective implicit-midpoint, uncorrected", 2)
    );
}

#[test]
fn parameters_out_of_range_are_refused() {
    let none = PartParameters::new();
    for refused in [
        none.clone().with("stages", 0),
        none.clone().with("stages", 17),
        none.clone().with("stages", -1),
        none.clone().with("integrator", "euler"),
        none.clone().with("correction", "some"),
    ] {
        let error = build(&refused).expect_err("out of range");
        assert!(matches!(error, BuildError::Parameter { .. }), "{error}");
    }
    assert!(matches!(
        build(&none.with("order", 2)),
        Err(BuildError::UnknownParameter { .. })
    ));
    assert!(Collective::new(SymplecticIntegrator::Gauss(17), Correction::None).is_err());
}

/// Points of five coordinates and no chart.
#[derive(Debug)]
struct Foreign;

impl RealizationData for Foreign {
    fn dimension(&self) -> usize {
        3
    }
    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }
    fn describe(&self) -> String {
        "a foreign realization".to_owned()
    }
    fn section(&self, x: &[f64], z: &mut [f64]) {
        z[..3].copy_from_slice(x);
    }
    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            space: Space::Points {
                coordinates: 5,
                chart: None,
            },
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            ..Abilities::default()
        }
    }
}

impl Foreign {
    fn source_and_target(
        &self,
        _graph: &mut Graph,
        _epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        Ok(SourceTarget {
            base: z[..3].to_vec(),
            offset: z[..3].to_vec(),
            increment: z[..3].to_vec(),
            guard: None,
        })
    }
}

#[test]
fn a_realization_without_a_chart_is_refused() {
    let dynamics = build(&PartParameters::new()).expect("defaults");
    let error = Method::compose(&rigid_body(), Arc::new(Foreign), dynamics).expect_err("no chart");
    assert!(matches!(error, BuildError::Incompatible { .. }), "{error}");
    assert!(error.to_string().contains("no symplectic chart"), "{error}");
}

/// A step of t = 30 turns a rigid body many times: no solution is found, and none is made up.
#[test]
fn a_step_without_a_solution_is_a_typed_error() {
    let realization: Arc<dyn RealizationData> = Arc::new(Cayley);
    let system = rigid_body();
    for integrator in crate::common::INTEGRATORS {
        let map = method(&system, &realization, integrator, Correction::Bisection);
        let mut run = Walk::new(&map, &[], 1.0, 30.0, &[1.0, 3.0, 3.0]);
        let error = run.step().expect_err("a step far too large");
        assert!(
            matches!(
                error,
                StepError::NoConvergence { .. }
                    | StepError::NonFinite { .. }
                    | StepError::OtherBranch { .. }
            ),
            "{integrator}: {error}"
        );
        assert_eq!(run.state(), [1.0, 3.0, 3.0]);
    }
}

/// A step over the domain of ln fails as such.
#[test]
fn a_state_outside_the_hamiltonians_domain_is_a_typed_error() {
    let system = lotka_volterra();
    let map = method(
        &system,
        &karasev(&system, 4),
        SymplecticIntegrator::Gauss(2),
        Correction::Bisection,
    );
    let mut run = Walk::new(&map, &[], 1.0, 0.1, &[1.0, -1.9, 0.0]);
    assert!(matches!(run.step(), Err(StepError::NonFinite { .. })));
}

/// The stages start from those of the last step, which a checkpoint holds.
#[test]
fn a_resumed_run_has_the_same_bits() {
    let system = lotka_volterra();
    let realization = karasev(&system, 4);
    for integrator in crate::common::INTEGRATORS {
        for correction in [Correction::Bisection, Correction::None] {
            let map = method(&system, &realization, integrator, correction);
            let mut x = [1.0, 1.9, 0.5];
            let mut through = map.stepper(1, &[], 1.0, 0.1);
            for _ in 0..5 {
                advance(through.as_mut(), &mut x);
            }
            let (mut y, memory) = (x, through.memory());
            let mut resumed = map.stepper(1, &[], 1.0, 0.1);
            resumed.restore(&memory).expect("a memory of this map");
            assert_eq!(resumed.restore(&[]), Err(memory.len()));
            for _ in 0..5 {
                advance(through.as_mut(), &mut x);
                advance(resumed.as_mut(), &mut y);
            }
            assert_eq!(x.map(f64::to_bits), y.map(f64::to_bits));
        }
    }
}
