//! A choice left open takes, of the exact realizations that fit, the one that costs the fewest operations.

use std::sync::Arc;

use leafwise::core::{
    Accuracy, DynamicApproximation, Method, PartKind, PartParameters, RealizationData, Walk,
};
use leafwise::prelude::*;
use leafwise::systems;
use leafwise_tests::methods::run;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{Problem, library};

/// A body that turns freely in n dimensions: {m_ij, m_kl} = δ_ik m_jl − δ_il m_jk − δ_jk m_il + δ_jl m_ik,
/// H = ½ Σ m_ij²/(i + j).
fn body(n: usize) -> Problem {
    let planes: Vec<(usize, usize)> = (1..=n)
        .flat_map(|i| (i + 1..=n).map(move |j| (i, j)))
        .collect();
    let entry = |i: usize, j: usize, sign: i32| match i.cmp(&j) {
        std::cmp::Ordering::Less => format!("{sign:+}*m{i}_{j}"),
        std::cmp::Ordering::Greater => format!("{:+}*m{j}_{i}", -sign),
        std::cmp::Ordering::Equal => String::new(),
    };
    let mut bracket = Vec::new();
    for (at, (i, j)) in planes.iter().enumerate() {
        for (k, l) in &planes[at + 1..] {
            let terms = [
                (i == k, (*j, *l, 1)),
                (i == l, (*j, *k, -1)),
                (j == k, (*i, *l, -1)),
                (j == l, (*i, *k, 1)),
            ];
            let terms = terms.into_iter().filter(|(is_there, _)| *is_there);
            let sum: String = terms.map(|(_, (a, b, sign))| entry(a, b, sign)).collect();
            if !sum.is_empty() {
                bracket.push((format!("m{i}_{j},m{k}_{l}"), format!("0{sum}")));
            }
        }
    }
    let names: Vec<String> = planes.iter().map(|(i, j)| format!("m{i}_{j}")).collect();
    let squares = planes
        .iter()
        .map(|(i, j)| format!("m{i}_{j}^2/{}", 2 * (i + j)));
    let hamiltonian = squares.collect::<Vec<_>>().join(" + ");
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let bracket: Vec<(&str, &str)> = (bracket.iter())
        .map(|(key, entry)| (key.as_str(), entry.as_str()))
        .collect();
    Problem {
        system: from_formulas(&names, &[], &bracket, &hamiltonian, &[]),
        initial: (0..planes.len())
            .map(|i| libm::sin(1.7 * i as f64 + 0.3))
            .collect(),
        time_step: 0.1,
    }
}

/// Operations of 32 steps.
fn operations(problem: &Problem, method: &Method) -> Option<u64> {
    let parameters = problem.system.parameter_values();
    let step = problem.time_step;
    let mut integrator = Walk::new(method, &parameters, 1.0, step, &problem.initial);
    for _ in 0..32 {
        integrator.step().ok()?;
    }
    integrator.statistics().operations
}

/// The methods of the dynamics over the exact realizations that `auto` chooses from, those that fit, by name. Realizations in other
/// charts are other maps, which err by more for what they save, and are taken by name alone.
fn over_exact(
    problem: &Problem,
    dynamics: &Arc<dyn DynamicApproximation>,
) -> Vec<(&'static str, Method)> {
    let registry = Registry::with_builtin();
    let system = &problem.system;
    let closed_forms = registry.exact_realizations();
    let composed = |name: &str| {
        let realization = registry.realization(name).ok()?;
        let realization = realization.build(system, &PartParameters::new()).ok()?;
        let is_exact = realization.accuracy() == Accuracy::Exact;
        let is_tried = closed_forms.iter().any(|(info, _)| info.name == name);
        let is_wanted = is_exact && (is_tried || realization.abilities().lift.is_some());
        let method = Method::compose(system, realization, Arc::clone(dynamics)).ok();
        method.filter(|_| is_wanted)
    };
    let parts = registry.parts().into_iter();
    let names = parts.filter(|info| info.kind == PartKind::Realization);
    names
        .filter_map(|info| Some((info.name, composed(info.name)?)))
        .collect()
}

fn dynamics(name: &str, parameter: &str, value: i64) -> Arc<dyn DynamicApproximation> {
    let registry = Registry::with_builtin();
    let given = PartParameters::new().with(parameter, value);
    let part = registry.dynamics(name).expect("a part");
    part.build(&given).expect("its parameters")
}

/// Above so many coordinates the operations of code and of numbers are not compared. Those of code hold a dense Jacobian, which
/// machine code makes in a fraction of the time: 32 steps of `charges`, with 30 coordinates, take 18 ms by code of 3.7 million operations,
/// and 79 ms by numbers of 1.6 million.
const MOST_COMPARED: usize = 24;

/// What is taken, and what it and every other cost.
fn assert_cheapest(what: &str, problem: &Problem, dynamics: &Arc<dyn DynamicApproximation>) {
    let registry = Registry::with_builtin();
    let taken = registry.exact_realization_under(dynamics, &problem.system, false);
    let taken = taken.unwrap_or_else(|| panic!("{what}: none fits"));
    let has_code = |realization: &dyn RealizationData| realization.abilities().code().is_some();
    let is_large =
        problem.system.dimension() > MOST_COMPARED && has_code(taken.realization.as_ref());
    let all: Vec<(&str, Option<u64>)> = over_exact(problem, dynamics)
        .iter()
        .filter(|(_, method)| !is_large || has_code(method.realization()))
        .map(|(name, method)| (*name, operations(problem, method)))
        .collect();
    let own = all.iter().find(|(name, _)| *name == taken.info.name);
    let own = own.and_then(|(_, count)| *count).expect("counted steps");
    let least = all.iter().filter_map(|(_, count)| *count).min();
    assert_eq!(Some(own), least, "{what}: {} of {all:?}", taken.info.name);
}

#[test]
fn auto_takes_the_exact_realization_of_the_fewest_operations() {
    let second = dynamics("hamilton-jacobi", "order", 2);
    for n in [3, 4, 5, 6] {
        assert_cheapest(&format!("so({n})"), &body(n), &second);
    }
    for entry in systems::all() {
        assert_cheapest(entry.id, &library(entry.id), &second);
    }
}

/// Over coordinates in which the tensor is constant nothing is solved for the start of a step.
#[test]
fn auto_takes_a_lift_under_dynamics_that_step_there() {
    for id in ["rigid-body", "lotka-volterra", "lotka-volterra-periodic"] {
        for stages in [2, 4] {
            let dynamics = dynamics("collective", "stages", stages);
            let problem = library(id);
            assert_cheapest(id, &problem, &dynamics);
            let taken = Registry::with_builtin();
            let taken = taken.exact_realization_under(&dynamics, &problem.system, false);
            assert!(taken.is_some_and(|exact| exact.realization.abilities().lift.is_some()));
        }
    }
    // Their coordinates are no positions and momenta.
    let verlet = PartParameters::new().with("integrator", "stormer-verlet");
    let registry = Registry::with_builtin();
    let verlet = registry
        .dynamics("collective")
        .expect("a part")
        .build(&verlet);
    let system = library("rigid-body").system;
    let taken = registry.exact_realization_under(&verlet.expect("an integrator"), &system, false);
    assert!(taken.is_some_and(|exact| exact.realization.abilities().lift.is_none()));
}

/// In the chart of the tensor's exponential all are one map: the choice is one of cost alone.
#[test]
fn exact_realizations_of_a_linear_tensor_take_the_same_steps() {
    let problem = body(5);
    let methods = over_exact(&problem, &dynamics("hamilton-jacobi", "order", 4));
    assert!(methods.len() >= 2);
    let ends = methods.iter().map(|(name, method)| {
        let end = run(
            &problem.system,
            method,
            (1.0, problem.time_step),
            8,
            &problem.initial,
        );
        (name, end.unwrap_or_else(|error| panic!("{name}: {error}")))
    });
    let ends: Vec<_> = ends.collect();
    // Each step is known to the rounding of the state and of the sums over its ten coordinates.
    let bound = 8.0 * 64.0 * UNIT_ROUNDOFF * largest(&problem.initial);
    for (name, end) in &ends[1..] {
        let apart = distance(end, &ends[0].1);
        assert!(apart <= bound, "{name}: {apart:e}, {bound:e}");
    }
}
