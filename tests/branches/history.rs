//! A step does not depend on the steps before it by more than round-off.

use leafwise::core::{Method, PartParameters, Registry, StepMap};
use leafwise_tests::opaque::with_derivatives;

use super::lattices::chain;
use super::midpoints::{MIDPOINTS, POTENTIALS, canonical};
use super::*;

/// Every step of the run beside one that begins at the same state without history: what is taken is the same, and where
/// the run goes on a fresh start does, unless it `may_refuse`.
fn forgets(map: &dyn StepMap, run: &ComposedRun, may_refuse: bool) -> Result<(), TestCaseError> {
    let parameters = run.system.parameter_values();
    let plan = &run.plan;
    let begin = || Walk::new(map, &parameters, plan.epsilon, plan.h, &plan.initial);
    let mut integrator = begin();
    for _ in 0..plan.steps {
        let before = integrator.checkpoint();
        let went_on = integrator.step().map(|()| integrator.state().to_vec());
        let mut fresh = begin();
        let mut cold = fresh.checkpoint();
        (cold.state, cold.compensation) = (before.state.clone(), before.compensation);
        fresh.restore(&cold).expect("the same method");
        let began = fresh.step().map(|()| fresh.state().to_vec());
        match (went_on, began) {
            (Ok(a), Ok(b)) => {
                let size = largest(a.iter().chain(&before.state).copied());
                prop_assert!(distance(&a, &b) <= 1e-9 * (1.0 + size), "{a:?} or {b:?}");
            }
            (Ok(a), Err(error)) => prop_assert!(may_refuse, "{a:?} or {error}"),
            (Err(_), _) => break,
        }
    }
    Ok(())
}

/// {q, p} = −(1 + c q²), by collocation.
fn collocated(which: usize, c: f64, order: i64, t: f64, (q, p): (f64, f64)) -> ComposedRun {
    composed(&format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1 - {c:?}*q^2\" }}\n\
         hamiltonian = \"p^2/2 + {}\"\n[method]\nrealization = \"karasev-collocated\"\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = {t:?}\n\
         [run]\ninitial = [{q:?}, {p:?}]\nsteps = 8\n",
        POTENTIALS[which].0
    ))
}

/// The same over the numbers of the system.
fn over_numbers(run: &ComposedRun) -> Method {
    let registry = Registry::with_builtin();
    let system = with_derivatives(&run.system);
    let realization = registry
        .realization("karasev-collocated")
        .expect("built in");
    let realization = realization
        .build(&system, &PartParameters::new())
        .expect("it fits");
    let dynamics = registry.dynamics("hamilton-jacobi").expect("built in");
    let dynamics = dynamics.build(&PartParameters::new().with("order", 2));
    let method = Method::compose(&system, realization, dynamics.expect("an even order"));
    method.expect("a method")
}

/// Pendulums whose iteration alone comes to one solution from the state and to another from where earlier steps lead.
#[test]
fn a_chain_between_two_solutions_takes_the_one_of_its_state() {
    let start = (0.0, -2.6193094841087126, 0.0);
    let run = chain(POTENTIALS[0], 2.5096463425161213, start, 40);
    forgets(run.method.map(), &run, false).unwrap_or_else(|why| panic!("{why}"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn a_step_does_not_depend_on_its_history(
        (which, q, p) in (0..4_usize, -1.5..1.5_f64, -1.5..1.5_f64),
        (t, method) in (0.3..5.0_f64, 0..2_usize),
    ) {
        let run = canonical(POTENTIALS[which], MIDPOINTS[method], t, (q, p), 40);
        forgets(run.method.map(), &run, false)?;
    }

    #[test]
    fn a_collocated_step_over_formulas_does_not_depend_on_its_history(
        (which, q, p) in (0..4_usize, -1.5..1.5_f64, -1.5..1.5_f64),
        (t, c, order) in (0.3..5.0_f64, 0.0..0.3_f64, 1..3_i64),
    ) {
        let run = collocated(which, c, 2 * order, t, (q, p));
        // Iterations without Jacobians converge for shorter steps only.
        forgets(run.method.map(), &run, t > 1.0)?;
    }

    #[test]
    fn a_collocated_step_over_numbers_does_not_depend_on_its_history(
        (which, q, p) in (0..4_usize, -1.5..1.5_f64, -1.5..1.5_f64),
        (t, c) in (0.3..5.0_f64, 0.0..0.3_f64),
    ) {
        let run = collocated(which, c, 2, t, (q, p));
        forgets(&over_numbers(&run), &run, t > 1.0)?;
    }

    #[test]
    fn a_step_of_a_chain_does_not_depend_on_its_history(
        (which, q, p) in (0..4_usize, -1.5..1.5_f64, -3.0..3.0_f64),
        (t, d) in (0.3..3.5_f64, 0.0..0.3_f64),
    ) {
        let run = chain(POTENTIALS[which], t, (q, p, d), 40);
        forgets(run.method.map(), &run, false)?;
    }
}
