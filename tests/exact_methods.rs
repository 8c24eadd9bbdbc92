//! Exact realizations agree with each other, and every method over them is a Poisson map.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise::core::diagnostics::{TensorDefect, measure_drift, section_defect};
use leafwise::core::system::SystemObservables;
use leafwise::core::{
    Integrator, Method, PartParameters, PoissonSystem, RealizationData, Registry, StepMap,
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

/// A system, an exact realization, and a step.
struct Case {
    problem: Problem,
    exact: Arc<dyn RealizationData>,
    t: f64,
}

/// The four systems with their closed forms.
fn cases() -> Vec<Case> {
    let case = |id: &str, exact: &str, t: f64| {
        let problem = library(id);
        let exact = realization(&problem.system, exact, PartParameters::new());
        Case { problem, exact, t }
    };
    vec![
        case("rigid-body", "so3-exponential", 0.1),
        case("lotka-volterra-periodic", "log-canonical", 0.05),
        case("heavy-top", "lie-poisson", 0.1),
        case("so4", "lie-poisson", 0.1),
    ]
}

/// 64 u times the largest summand of DΦ Π DΦᵀ, and Casimirs kept to round-off: each step adds a
/// few units in the last place of the state.
fn assert_poisson(problem: &Problem, map: &dyn StepMap, t: f64) {
    let values = problem.system.parameter_values();
    let mut instrument =
        TensorDefect::new(&problem.system, map, &values, 1.0, t).expect("an instrument");
    let defect = instrument.measure(&problem.initial).expect("a step");
    let stretch = defect.tangent.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
    let bound = 64.0 * f64::EPSILON * defect.scale * stretch * stretch;
    let name = map.describe();
    let formulas: Vec<_> = problem
        .system
        .expressions()
        .expect("formulas")
        .casimirs()
        .iter()
        .map(|c| &c.expression)
        .collect();
    let mut observer =
        SystemObservables::new(&problem.system, &formulas, &values).expect("Casimirs");
    let mut integrator = Integrator::new(map, &values, 1.0, t, &problem.initial);
    let steps = 100;
    let drifts = measure_drift(&mut integrator, &mut observer, steps).expect("steps");
    let casimirs = drifts.iter().map(|d| d.relative()).fold(0.0, f64::max);
    println!(
        "{name}: defect {:.1e}, Casimirs {casimirs:.1e}",
        defect.norm
    );
    assert!(
        defect.norm <= bound,
        "{name}: {:e} > {bound:e}",
        defect.norm
    );
    assert!(
        casimirs <= steps as f64 * 4.0 * f64::EPSILON,
        "{name}: {casimirs:e}"
    );
}

#[test]
fn hamilton_jacobi_over_exact_realizations_is_poisson() {
    for Case { problem, exact, t } in cases() {
        for m in [2, 4, 6, 8] {
            assert_poisson(
                &problem,
                &compose(&problem.system, &exact, hamilton_jacobi(m)),
                t,
            );
        }
    }
}

#[test]
fn corrected_collective_methods_over_exact_realizations_are_poisson() {
    for Case { problem, exact, t } in cases() {
        for (integrator, stages) in [
            ("stormer-verlet", 0),
            ("implicit-midpoint", 0),
            ("gauss", 1),
            ("gauss", 2),
            ("gauss", 3),
            ("gauss", 4),
        ] {
            let method = compose(&problem.system, &exact, collective(integrator, stages));
            assert_poisson(&problem, &method, t);
        }
    }
}

#[test]
fn compositions_over_exact_realizations_are_poisson() {
    let registry = Registry::with_builtin();
    for Case { problem, exact, t } in cases() {
        for name in [
            "triple-jump",
            "suzuki-4",
            "yoshida-6",
            "kahan-li-8",
            "suzuki-umeno-8",
        ] {
            let base = Arc::new(compose(&problem.system, &exact, hamilton_jacobi(2)));
            let part = registry.composition(name).expect("a built-in composition");
            let map = part
                .build(base, &PartParameters::new())
                .expect("a self-adjoint base");
            assert_poisson(&problem, map.as_ref(), t);
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
    for m in [2, 4, 8] {
        let steps = charts.clone().map(|(name, given)| {
            let realization = realization(&problem.system, name, given);
            let method = compose(&problem.system, &realization, hamilton_jacobi(m));
            let mut integrator = Integrator::new(&method, &values, 1.0, 0.1, &problem.initial);
            integrator.step().expect("a step");
            (name, integrator.state().to_vec())
        });
        for (name, state) in &steps[1..] {
            let difference = distance(state, &steps[0].1) / largest(state);
            println!("m = {m}: {name} against so3-exponential: {difference:.1e}");
            assert!(
                difference <= 16.0 * f64::EPSILON,
                "m = {m}, {name}: {difference:e}"
            );
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
