//! Steps of any size are solved on the branch that begins at the state, or refused.
//!
//! `LEAFWISE_SWEEP` sets the number of random scenes of each test, 48 otherwise.

mod history;
mod lattices;
mod log_canonical;
mod midpoints;

use leafwise::core::{StepError, Walk};
use leafwise::scene::ComposedRun;
use leafwise_tests::numbers::{distance, largest};
use leafwise_tests::scenes::composed;
use proptest::prelude::*;

fn cases() -> u32 {
    let wanted = std::env::var("LEAFWISE_SWEEP").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(48)
}

/// The scene's steps, one after the other, until one is refused.
fn steps(run: &ComposedRun) -> (Vec<Vec<f64>>, Option<StepError>) {
    let mut integrator = run.walk();
    let mut states = vec![integrator.state().to_vec()];
    for _ in 0..run.plan.steps {
        if let Err(error) = integrator.step() {
            return (states, Some(error));
        }
        states.push(integrator.state().to_vec());
    }
    (states, None)
}

/// One step of another length from the scene's initial state.
fn one_step(run: &ComposedRun, h: f64) -> Result<Vec<f64>, StepError> {
    let parameters = run.system.parameter_values();
    let (map, plan) = (run.method.map(), &run.plan);
    let mut integrator = Walk::new(map, &parameters, plan.epsilon, h, &plan.initial);
    integrator.step()?;
    Ok(integrator.state().to_vec())
}

/// Steps of the lengths h/200, 2h/200, … h, each by itself, do not jump as long as they are taken.
fn is_continuous_in_h(run: &ComposedRun, most: f64) {
    let mut last = run.plan.initial.clone();
    for k in 1..=200 {
        let h = run.plan.h * f64::from(k) / 200.0;
        match one_step(run, h) {
            Ok(state) => {
                let jump = distance(&state, &last);
                assert!(jump <= most, "at h = {h}: {last:?} to {state:?}");
                last = state;
            }
            // Beyond a fold there is nothing to compare with.
            Err(_) => return,
        }
    }
}

/// x⁴/4 + 0.666 y²z² + z² on so(3)*: the midpoint rule keeps |x|².
#[test]
fn an_overflowed_stage_is_no_solution() {
    let run = composed(
        r#"
[system]
variables = ["x", "y", "z"]
bracket = { lie-algebra = "so3" }
hamiltonian = "x^4/4 + 0.666*y^2*z^2 + z^2"
[method]
stepper = "implicit-midpoint"
time-step = 0.4
[run]
initial = [-1.11, 0.798, 1.412]
steps = 3
"#,
    );
    let (states, _) = steps(&run);
    let square = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    for state in &states {
        let drift = (square(state) / square(&states[0]) - 1.0).abs();
        assert!(drift <= 64.0 * f64::EPSILON, "{state:?}");
    }
}

/// The energy is kept on every branch; the state only on one.
#[test]
fn an_energy_preserving_step_does_not_jump_to_another_branch() {
    let run = composed(
        r#"
[system]
variables = ["x", "y", "z"]
bracket = { "x,y" = "-0.802*z - 0.488*x - 1.326*y", "y,z" = "1.542*x - 0.02*y - 0.488*z - 1.611*x^2", "z,x" = "-3.238*y - 0.02*x - 1.326*z" }
hamiltonian = "0.2895*x*x + 0.1549*x*y + 0.0858*y*y + 0.4574*y*z + 0.9279*z*z"
[method]
stepper = "energy-preserving"
time-step = 1.0901642301095895
[run]
initial = [0.8821, -0.4933, 1.2292]
steps = 1
"#,
    );
    // |ẋ| is about 5 there; near the fold, at 99 % of this step, the branch moves faster.
    is_continuous_in_h(&run, 0.3);
    let (states, error) = steps(&run);
    let is_refused = matches!(error, Some(StepError::OtherBranch { reached }) if reached > 0.9);
    assert!(is_refused, "{:?}, {error:?}", states.last());
}

/// Collective integrators over realizations of low order: the stages of a component that is the
/// round-off of larger ones never settle by themselves.
#[test]
fn collective_steps_of_three_waves_converge_at_every_small_step() {
    for (realization, integrator) in [
        (
            "{ name = \"karasev-collocated\", points = 2 }",
            "stormer-verlet",
        ),
        (
            "{ name = \"karasev-collocated\", points = 1 }",
            "stormer-verlet",
        ),
        ("{ name = \"karasev-truncated\", order = 1 }", "gauss"),
        ("{ name = \"karasev-truncated\", order = 2 }", "gauss"),
    ] {
        for t in [
            0.15, 0.11, 0.1, 0.09, 0.05, 0.03, 0.025, 0.0125, 0.01, 0.003,
        ] {
            for initial in [
                [0.375, 0.5, 0.625, 0.625, 1.0],
                [0.4, 0.31, 0.52, 0.77, 0.9],
                [0.51, -0.43, 0.7, 0.35, 1.3],
            ] {
                let run = composed(&format!(
                    "[system]\nlibrary = \"three-wave\"\n[method]\nrealization = {realization}\n\
                     dynamics = {{ name = \"collective\", integrator = \"{integrator}\" }}\n\
                     time-step = {t:?}\n[run]\ninitial = {initial:?}\nsteps = 10\n"
                ));
                let (states, error) = steps(&run);
                assert_eq!(
                    error,
                    None,
                    "{realization} + {integrator}, t = {t}, {initial:?}, step {}",
                    states.len()
                );
            }
        }
    }
}
