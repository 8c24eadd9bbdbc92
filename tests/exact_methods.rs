//! Exact realizations agree with each other, and every method over them is a Poisson map.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise::core::diagnostics::{TensorDefect, measure_drift, section_defect};
use leafwise::core::dynamics::Generating;
use leafwise::core::system::SystemInvariants;
use leafwise::core::{
    Evaluator, Method, PartParameters, PoissonSystem, RealizationData, Registry, StepMap, Walk,
};
use leafwise_tests::numbers::{distance, largest};
use leafwise_tests::{Problem, library};

fn realization(
    system: &PoissonSystem,
    name: &str,
    given: PartParameters,
) -> Arc<dyn RealizationData> {
    let registry = Registry::with_builtin();
    let part = registry.realization(name).expect("a built-in part");
    part.build(system, &given).expect("it fits")
}

fn compose(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    (dynamics, given): (&str, PartParameters),
) -> Method {
    let registry = Registry::with_builtin();
    let dynamics = registry
        .dynamics(dynamics)
        .and_then(|part| part.build(&given));
    let dynamics = dynamics.expect("a dynamic approximation");
    Method::compose(system, Arc::clone(realization), dynamics).expect("they fit")
}

fn hamilton_jacobi(order: i64) -> (&'static str, PartParameters) {
    (
        "hamilton-jacobi",
        PartParameters::new().with("order", order),
    )
}

fn collective(integrator: &str, stages: i64) -> (&'static str, PartParameters) {
    let given = PartParameters::new().with("integrator", integrator);
    let given = if integrator == "gauss" {
        given.with("stages", stages)
    } else {
        given
    };
    ("collective", given)
}

/// The step of every method.
const TIME_STEP: f64 = 0.1;

/// A system and an exact realization of it.
struct Case {
    id: &'static str,
    problem: Problem,
    exact: Arc<dyn RealizationData>,
}

impl Case {
    fn compose(&self, dynamics: (&str, PartParameters)) -> Method {
        compose(&self.problem.system, &self.exact, dynamics)
    }
}

/// The four systems with their closed forms, and over collocation; and point vortices, whose
/// Hamilton-Jacobi coefficients are formed as code.
fn cases() -> Vec<Case> {
    let case = |id: &'static str, exact: &str| {
        let problem = library(id);
        let exact = realization(&problem.system, exact, PartParameters::new());
        Case { id, problem, exact }
    };
    vec![
        case("rigid-body", "so3-exponential"),
        case("rigid-body", "lie-poisson"),
        case("rigid-body", "karasev-collocated"),
        case("lotka-volterra-periodic", "log-canonical"),
        case("lotka-volterra-periodic", "karasev-collocated"),
        case("heavy-top", "lie-poisson"),
        case("heavy-top", "karasev-collocated"),
        case("so4", "lie-poisson"),
        case("so4", "karasev-collocated"),
        case("point-vortices", "constant"),
    ]
}

/// 64 u times the largest summand of DΦ Π DΦᵀ; and Casimirs kept to round-off: each of 100 steps moves
/// the state by a few roundings u at random, hence a Casimir by √100 times as much of Σ|∂ᵢC xᵢ|, 64 u in
/// all.
fn assert_poisson(case: &Case, map: &dyn StepMap) {
    let (problem, t) = (&case.problem, TIME_STEP);
    let values = problem.system.parameter_values();
    let mut instrument =
        TensorDefect::new(&problem.system, map, &values, 1.0, t).expect("an instrument");
    let defect = instrument.measure(&problem.initial).expect("a step");
    let stretch = defect.tangent.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
    let bound = 64.0 * f64::EPSILON * defect.scale * stretch * stretch;
    let observer = SystemInvariants::new(&problem.system, &values).expect("invariants");
    let mut integrator = Walk::new(map, &values, 1.0, t, &problem.initial);
    let drifts = measure_drift(&mut integrator, observer, 100).expect("steps");
    let summands = summands(problem);
    let casimirs = drifts.iter().zip(&summands).skip(1);
    let casimirs = largest(casimirs.map(|(d, s)| d.largest / s));
    let name = map.describe();
    println!(
        "{}, {name}: defect {:.1e}, Casimirs {casimirs:.1e}",
        case.id, defect.norm
    );
    assert!(
        defect.norm <= bound,
        "{name}: {:e} > {bound:e}",
        defect.norm
    );
    assert!(casimirs <= 32.0 * f64::EPSILON, "{name}: {casimirs:e}");
}

/// Σ|∂ᵢI xᵢ| of the energy and every Casimir.
fn summands(problem: &Problem) -> Vec<f64> {
    let (system, x) = (&problem.system, &problem.initial);
    let map = system.invariants_map().expect("code");
    let mut slopes = vec![0.0; map.outputs() * x.len()];
    map.evaluator(&system.parameter_values(), 1.0, 1.0)
        .jacobians(x, &mut slopes)
        .expect("a Jacobian");
    let sum = |row: &[f64]| row.iter().zip(x).map(|(slope, x)| (slope * x).abs()).sum();
    slopes.chunks(x.len()).map(sum).collect()
}

#[test]
fn hamilton_jacobi_over_exact_realizations_is_poisson() {
    for case in cases() {
        for m in [2, 4, 6, 8] {
            assert_poisson(&case, &case.compose(hamilton_jacobi(m)));
        }
    }
}

/// Ŝ is expanded where sums cancel, and code where they do not.
#[test]
fn the_shorter_form_of_the_generating_function_is_taken() {
    for (id, exact, is_code) in [
        ("rigid-body", "so3-exponential", false),
        ("lotka-volterra-periodic", "log-canonical", false),
        ("heavy-top", "lie-poisson", false),
        ("magnetic", "karasev-collocated", true),
        ("point-vortices", "constant", true),
    ] {
        let problem = library(id);
        let exact = realization(&problem.system, exact, PartParameters::new());
        let method = compose(&problem.system, &exact, hamilton_jacobi(6));
        let generating = method.bisection().generating_function().expect("a graph");
        assert_eq!(matches!(generating, Generating::Code(_)), is_code, "{id}");
    }
}

#[test]
fn corrected_collective_methods_over_exact_realizations_are_poisson() {
    for case in cases() {
        for (integrator, stages) in [
            ("stormer-verlet", 0),
            ("implicit-midpoint", 0),
            ("gauss", 1),
            ("gauss", 2),
            ("gauss", 3),
            ("gauss", 4),
        ] {
            assert_poisson(&case, &case.compose(collective(integrator, stages)));
        }
    }
}

#[test]
fn compositions_over_exact_realizations_are_poisson() {
    let registry = Registry::with_builtin();
    for case in cases() {
        for name in [
            "triple-jump",
            "suzuki-4",
            "yoshida-6",
            "kahan-li-8",
            "suzuki-umeno-8",
        ] {
            let base = Arc::new(case.compose(hamilton_jacobi(2)));
            let part = registry.composition(name).expect("a built-in composition");
            let map = part
                .build(base, &PartParameters::new())
                .expect("a self-adjoint base");
            assert_poisson(&case, map.as_ref());
        }
    }
}

/// Charts of one realization give one map: a step differs by the round-off of its solve.
#[test]
fn realizations_of_so3_in_the_exponential_chart_are_one() {
    let problem = library("rigid-body");
    let values = problem.system.parameter_values();
    let exponential = PartParameters::new().with("chart", "exponential");
    let charts = [
        ("so3-exponential", PartParameters::new()),
        ("so3-group", exponential),
        ("lie-poisson", PartParameters::new()),
        ("karasev-collocated", PartParameters::new()),
    ];
    for dynamics in [
        hamilton_jacobi(2),
        hamilton_jacobi(4),
        hamilton_jacobi(8),
        collective("stormer-verlet", 0),
        collective("implicit-midpoint", 0),
        collective("gauss", 2),
        collective("gauss", 4),
    ] {
        let steps = charts.clone().map(|(name, given)| {
            let realization = realization(&problem.system, name, given);
            let method = compose(&problem.system, &realization, dynamics.clone());
            let mut integrator = Walk::new(&method, &values, 1.0, TIME_STEP, &problem.initial);
            integrator.step().expect("a step");
            (method.describe(), integrator.state().to_vec())
        });
        for (name, state) in &steps[1..] {
            let difference = distance(state, &steps[0].1) / largest(state);
            println!("{name} against so3-exponential: {difference:.1e}");
            assert!(difference <= 16.0 * f64::EPSILON, "{name}: {difference:e}");
        }
    }
}

#[test]
fn sigma_is_a_section_of_every_realization() {
    for Case { problem, exact, .. } in cases() {
        let values = problem.system.parameter_values();
        let defect = section_defect(exact.as_ref(), &values, 0.7, &problem.initial)
            .expect("maps")
            .expect("in the chart");
        // β̂ − x and α̂ − β̂ are products with p = 0.
        assert!(defect <= f64::EPSILON, "{}: {defect:e}", exact.describe());
    }
}
