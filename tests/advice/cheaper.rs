//! A method that takes a fraction of the operations: in coordinates in which the tensor is constant, or by exact flows.

use leafwise::prelude::*;
use leafwise::run::advice::{CheaperMethod, cheaper_method};
use leafwise_tests::gauss::flow;
use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::composed;

use super::{body, scene};

fn cheaper(text: &str) -> Option<CheaperMethod> {
    cheaper_method(&composed(text), &Registry::with_builtin())
}

/// Operations of a scene to a time, and its distance from the flow there.
fn cost_and_error(text: &str, time: f64) -> (f64, f64) {
    let run = composed(text);
    let steps = libm::round(time / (run.plan.epsilon * run.plan.h)) as u64;
    let mut walk = run.walk();
    walk.advance(steps).expect("steps");
    let operations = walk.statistics().operations.expect("counted");
    let end = flow(&run.system, &run.plan.initial, time, 512);
    (operations as f64, distance(walk.state(), &end))
}

#[test]
fn what_takes_half_of_the_operations_or_less_is_named() {
    let species = "[1.0, 0.5, 1.5]";
    for (text, time) in [
        (
            scene(
                "lotka-volterra-periodic",
                species,
                "realization = { name = \"karasev-truncated\", order = 8 }\n\
                 dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.05",
            ),
            3.2,
        ),
        (
            body("stepper = { name = \"gauss\", stages = 2 }\ntime-step = 0.1"),
            6.4,
        ),
        (
            scene(
                "heavy-top",
                "[0.1, 0.2, 1.0, 0.1, 0.2, 0.9]",
                "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1",
            ),
            6.4,
        ),
    ] {
        let found = cheaper(&text).unwrap_or_else(|| panic!("{text}"));
        let (_, rest) = text.split_once("[method]").expect("a table");
        let (_, rest) = rest.split_once("[run]").expect("a table");
        let (system, _) = text.split_once("[method]").expect("a table");
        let table = found.method.text(found.time_step);
        let named = format!("{system}{table}[run]{rest}");
        let ((own, before), (other, after)) =
            (cost_and_error(&text, time), cost_and_error(&named, time));
        assert!(
            found.part <= 0.5 && (other / own - found.part).abs() <= 1e-9,
            "{found} {other} {own}"
        );
        let [error, of_own] = found.errors;
        // The largest at four times, this the last of them, as far as the advice's own measure tells: to 1e-11 of |x| = 3.
        let known = 3e-11;
        assert!(
            after <= error + known && before <= of_own + known,
            "{found}: {after:e} {before:e}"
        );
        // The next word is another: what is named is not undercut by as much again.
        assert!(
            cheaper(&named).is_none_or(|again| again.part > 0.25),
            "{found}"
        );
    }
}

/// Where H is a sum of pieces with exact flows, compositions of these take a quarter of Hamilton–Jacobi's operations or less.
#[test]
fn splitting_is_named_where_it_is_many_times_cheaper() {
    for (system, initial) in [
        ("heavy-top", "[0.1, 0.2, 1.0, 0.1, 0.2, 0.9]"),
        ("kepler", "[1.0, 0.0, 0.0, 1.0]"),
    ] {
        let method = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1";
        let found = cheaper(&scene(system, initial, method)).expect("a cheaper method");
        assert!(found.method.to_string().contains("splitting"), "{found}");
        assert!(found.part <= 0.25, "{found}");
    }
}

#[test]
fn what_is_not_undercut_gets_no_word() {
    // Exact flows; a tensor without a lift.
    let whole = body("stepper = { name = \"splitting\", bodies = \"whole\" }\ntime-step = 0.1");
    let gradient = scene(
        "gradient",
        "[0.8, 0.5, -0.4]",
        "realization = { name = \"karasev-truncated\", order = 4 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1",
    );
    for text in [whole, gradient] {
        assert_eq!(cheaper(&text), None, "{text}");
    }
}
