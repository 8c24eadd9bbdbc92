//! Chains, solved without Jacobians: pendulums at every site, each with a midpoint rule of its own.

use super::midpoints::{POTENTIALS, Potential, midpoint};
use super::*;

const SITES: usize = 24;

/// p²/2 + V(q) at every site, at t; at site i (q + d cos(2πi/N), p) to begin with.
pub(super) fn chain(
    potential: Potential,
    t: f64,
    (q, p, d): (f64, f64, f64),
    steps: u32,
) -> ComposedRun {
    let site = potential.0.replace('q', "q[i]");
    composed(&format!(
        "[system]\nfamilies = {{ q = {SITES}, p = {SITES} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
         hamiltonian = \"sum(i, p[i]^2/2 + {site})\"\n[method]\nrealization = \"constant\"\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {t:?}\n[run]\n\
         initial = {{ \"q[i]\" = \"{q:?} + {d:?}*cos(2*pi*i/N)\", \"p[i]\" = \"{p:?}\" }}\nsteps = {steps}\n"
    ))
}

/// At some sites, the positions before and in the middle of a step, and the latter continued from small steps; `None` beyond
/// a fold.
fn middles(
    potential: Potential,
    t: f64,
    before: &[f64],
    after: &[f64],
) -> Vec<(f64, f64, Option<f64>)> {
    let site = |i: usize| {
        let continued = midpoint(potential, t, before[i], before[SITES + i]);
        let middle = 0.5 * (before[i] + after[i]);
        (before[i], middle, continued.map(|(y, _)| y))
    };
    [0, 5, 11, 18].map(site).to_vec()
}

/// Away from a long way's end the iteration alone leads to another solution: from (0, 2.52) at t = 5/2 to
/// q' = 4.7 beyond the fold, for q' = 1.588.
#[test]
fn a_chain_s_long_step_is_on_the_first_branch_or_refused() {
    let mut taken = 0;
    for (q, p, t) in [
        (0.0, 2.5, 2.5),
        (0.0, 2.52, 2.5),
        (0.0, 2.6, 2.5),
        (0.0, -2.72542646005853, 2.472694515668075),
        (-0.5, 3.0, 2.4),
        (3.0, 0.0, 3.0),
    ] {
        let run = chain(POTENTIALS[0], t, (q, p, 0.0), 1);
        match steps(&run) {
            (_, Some(StepError::OtherBranch { .. } | StepError::NoConvergence { .. })) => {}
            (states, error) => {
                assert_eq!(error, None);
                for (_, y, expected) in middles(POTENTIALS[0], t, &states[0], &states[1]) {
                    let expected = expected.expect("the branch goes on");
                    assert!(
                        (y - expected).abs() < 1e-6,
                        "{q} {p} {t}: {y} for {expected}"
                    );
                }
                taken += 1;
            }
        }
    }
    assert!(taken >= 3, "{taken}");
    // The branch folds at 97 % of this step: beyond there are solutions, but none of them begins at the state.
    let (_, error) = steps(&chain(POTENTIALS[0], 2.5, (0.0, 2.8, 0.0), 1));
    let folds = matches!(error, Some(StepError::OtherBranch { reached }) if reached > 0.9 && reached < 0.97118);
    assert!(folds, "{error:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    /// What is taken is continued from small steps at every site, or lies on a branch without a fold at this t.
    #[test]
    fn steps_of_chains_are_those_continued_from_small_ones(
        (which, q, p) in (0..4_usize, -2.0..2.0_f64, -3.0..3.0_f64),
        (t, d) in (0.3..3.5_f64, 0.0..0.3_f64),
    ) {
        let potential = POTENTIALS[which];
        let run = chain(potential, t, (q, p, d), 10);
        let mut integrator = run.walk();
        for _ in 0..10 {
            let before = integrator.state().to_vec();
            if integrator.step().is_err() {
                break;
            }
            for (q, y, expected) in middles(potential, t, &before, integrator.state()) {
                let is_continued = expected.is_some_and(|other| (y - other).abs() <= 1e-6 * (1.0 + y.abs()));
                let slope = |k: i32| 1.0 + 0.25 * t * t * potential.2(q + (y - q) * f64::from(k) / 1000.0);
                let has_no_fold = (0..=1000).all(|k| slope(k) > 0.0);
                prop_assert!(is_continued || has_no_fold, "{before:?}, from {q}: {y} for {expected:?}");
            }
        }
    }
}
