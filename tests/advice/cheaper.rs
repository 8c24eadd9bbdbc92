//! A method that takes a fraction of the operations: in coordinates in which the tensor is constant, or by exact flows.

use leafwise::prelude::*;
use leafwise::run::advice::{CheaperMethod, cheaper_method};
use leafwise::scene::compose::ComposedRun;
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

/// Beside a clock and a pace the named method is no worse at its own cost, in the coordinates of the scene.
#[test]
fn what_is_named_cures_beside_a_clock_and_a_pace() {
    let driven = "[system]\nvariables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - cos(q) + 0.1*q*cos(t)\"\n[method]\n\
                  stepper = { name = \"gauss\", stages = 2 }\ntime-step = 0.1\n[run]\ninitial = [0.5, 0]\nsteps = 200\n";
    let paced = "[system]\nvariables = [\"x\", \"y\", \"px\", \"py\"]\nbracket = { canonical = [[\"x\", \"px\"], [\"y\", \"py\"]] }\n\
                 hamiltonian = \"(px^2 + py^2)/2 - 1/sqrt(x^2 + y^2)\"\n[method]\nstepper = { name = \"gauss\", stages = 2 }\n\
                 time-step = 0.05\npace = \"sqrt(x^2 + y^2)\"\n[run]\ninitial = [1, 0, 0, 0.8]\nuntil = 20\n";
    let mut named = 0;
    for text in [driven, paced] {
        let Some(found) = cheaper(text) else {
            continue;
        };
        named += 1;
        let (system, rest) = text.split_once("[method]").expect("a table");
        let (method, rest) = rest.split_once("[run]").expect("a table");
        let pace = method
            .lines()
            .find(|line| line.starts_with("pace"))
            .unwrap_or("");
        let table = found.method.text(found.time_step);
        let other = format!("{system}{table}{pace}\n[run]{rest}");
        let (own, other) = (composed(text), composed(&other));
        let operations = |run: &ComposedRun, steps: u64| {
            let mut walk = run.walk();
            walk.advance(steps).expect("steps");
            (
                walk.statistics().operations.expect("counted") as f64,
                walk.state().to_vec(),
            )
        };
        let ratio = other.plan.h / own.plan.h;
        let (before, own_end) = operations(&own, 64);
        let (after, other_end) = operations(&other, (64.0 / ratio) as u64);
        assert!(
            (after / before - found.part).abs() <= 1e-9,
            "{found} {after} {before}"
        );
        // Both ends are as near to the flow as their errors say, so to one another.
        let [error, of_own] = found.errors;
        let apart = distance(own.own(&own_end), other.own(&other_end));
        assert!(apart <= error + of_own + 3e-11, "{found}: {apart:e}");
    }
    assert!(named >= 1, "{named}");
}

/// The measured part is printed: not "a third" for 1/2.5.
#[test]
fn the_part_is_printed_as_it_was_measured() {
    let found = cheaper(&scene(
        "kepler",
        "[1.0, 0.0, 0.0, 1.0]",
        "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1",
    ))
    .expect("a cheaper method");
    for (part, text) in [
        (0.5, "takes 1/2.0 of the operations"),
        (0.4, "takes 1/2.5 of the operations"),
        (0.3, "takes 1/3.3 of the operations"),
        (1.0 / 23.2, "takes 1/23 of the operations"),
    ] {
        let said = CheaperMethod {
            part,
            ..found.clone()
        }
        .to_string();
        assert!(said.contains(text), "{said}");
    }
}

/// Other methods step neither at one scale of a contact form nor at one energy, and beside errors as large as the motion none is better.
#[test]
fn contact_exact_energy_and_errors_without_meaning_get_no_word() {
    let contact = "[system]\nvariables = [\"q\", \"p\", \"s\"]\nbracket = \"contact\"\nhamiltonian = \"p^2/2 + q^2/2 + 0.2*s\"\n[method]\n\
                   realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1\n[run]\ninitial = [1, 0, 0]\nsteps = 200\n";
    let plain = body(
        "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1",
    );
    let exact = plain.replace("time-step = 0.1", "time-step = 0.1\nenergy = \"exact\"");
    assert_ne!(plain, exact);
    // One step of half of a turn and more.
    let coarse = "[system]\nvariables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 + q^2/2\"\n[method]\n\
                  stepper = { name = \"gauss\", stages = 2 }\ntime-step = 2.5\n[run]\ninitial = [1, 0]\nsteps = 200\n";
    for text in [contact, &exact, coarse] {
        assert_eq!(cheaper(text), None, "{text}");
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
