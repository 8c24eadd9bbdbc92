//! Every extreme of `leafwise stress`, and random states and steps of any size.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::collections::BTreeSet;

use leafwise::core::StepMap;
use leafwise::stress::{StressOptions, cases};
use leafwise_tests::{library, method};
use proptest::collection::vec;
use proptest::prelude::*;

/// Runs all cases of a family and asserts that each is met.
fn assert_met(family: &str) {
    let mut count = 0;
    for case in cases().filter(|case| case.family == family) {
        let outcome = case.run(&StressOptions::SHORT);
        println!("{}: {}", case.id(), outcome.measured);
        assert!(
            outcome.is_met,
            "{}\n  asked: {}\n  expected: {}\n  measured: {}",
            case.id(),
            case.asked,
            case.expected,
            outcome.measured
        );
        count += 1;
    }
    assert!(count > 0, "`{family}` is a family of cases");
}

macro_rules! families {
    ($($test:ident: $family:literal,)*) => {
        $(#[test]
        fn $test() {
            assert_met($family);
        })*

        #[test]
        fn no_family_is_left_out() {
            let tested = BTreeSet::from([$($family),*]);
            let known: BTreeSet<&str> = cases().map(|case| case.family).collect();
            assert_eq!(tested, known);
        }
    };
}

families! {
    without_a_tensor_or_a_hamiltonian_nothing_moves: "trivial",
    where_the_tensor_loses_rank_equilibria_stay_to_the_bit: "degenerate",
    zero_components_are_no_reason_to_fail: "zeros",
    near_degenerate_points_relative_accuracy_is_kept: "nearly-degenerate",
    steps_of_any_size_are_solved_or_refused: "steps",
    states_of_any_size_give_numbers_or_errors: "sizes",
    what_is_not_a_number_is_refused: "not-numbers",
    no_key_of_a_scene_takes_a_fault: "scene-fields",
    stiff_parameters_are_solved_or_refused: "stiff",
    an_orbit_that_underflows_stays_positive: "underflow",
    high_orders_agree_with_closed_forms: "orders",
    any_dimension_serves: "dimensions",
    narrow_waves_and_fine_steps_are_solved: "lattices",
    chaotic_orbits_are_reversible: "chaos",
    a_casimir_drifts_like_a_random_walk: "long",
}

#[test]
fn every_case_has_a_name_of_its_own_and_says_what_it_expects() {
    let mut ids = BTreeSet::new();
    for case in cases() {
        assert!(ids.insert(case.id()), "{} twice", case.id());
        assert!(
            case.asked.len() > 10 && case.expected.len() > 10,
            "{}",
            case.id()
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Any state and any step of any size: a finite increment, or an error and no increment.
    #[test]
    fn no_step_is_silently_garbage(
        which in 0..4_usize,
        x in vec((-300.0..300.0_f64, any::<bool>()), 6),
        t in (-12.0..12.0_f64, any::<bool>()),
    ) {
        let number = |(exponent, minus): (f64, bool)| {
            libm::exp10(exponent) * if minus { -1.0 } else { 1.0 }
        };
        let id = ["rigid-body", "lotka-volterra", "heavy-top", "gradient"][which];
        let problem = library(id);
        let x: Vec<f64> = x.into_iter().take(problem.initial.len()).map(number).collect();
        let method = method(&problem.system, 3, 2);
        let mut increment = vec![f64::NAN; x.len()];
        let mut outcome = [Ok(())];
        let parameters = problem.system.parameter_values();
        let mut stepper = method.stepper(1, &parameters, 1.0, number(t));
        stepper.increment(&x, &vec![0.0; x.len()], &mut increment, &mut outcome);
        match &outcome[0] {
            Ok(()) => prop_assert!(increment.iter().all(|i| i.is_finite()), "{increment:?}"),
            Err(error) => {
                prop_assert!(increment.iter().all(|i| *i == 0.0), "{error}: {increment:?}");
            }
        }
    }
}
