//! What is wrong with a scene whatever its method.

use leafwise::prelude::*;
use leafwise::run::advice::AdviceKind;
use leafwise::run::{Asked, Quiet, run_in_memory};
use leafwise_tests::scenes::{composed, document};

use super::{scene_end, told_of_kind};

/// A pendulum by constraints, started beside them: the state that is named instead lies on them to round-off, and is the
/// nearest one to first order. Round-off of a start is no news.
#[test]
fn a_start_off_the_constraints_is_told_with_one_on_them() {
    let text = |initial: &str| {
        format!(
            "[system]\nvariables = [\"x\", \"y\", \"px\", \"py\"]\nconvention = \"{{x,H}}\"\n\
             bracket = {{ \"x,px\" = 1, \"y,py\" = 1 }}\nconstraints = [\"x^2+y^2-1\", \"x*px+y*py\"]\n\
             hamiltonian = \"(px^2+py^2)/2 + y\"\n\
             [method]\nrealization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 0.1\n\
             [run]\ninitial = {initial}\nsteps = 10\n"
        )
    };
    for (off, distance) in [("[1, 0.5, 0, 1]", 0.5), ("[0.6, 0.8001, 0.8, -0.6]", 2e-4)] {
        let found = told_of_kind(&text(off), AdviceKind::OffConstraint).expect("told");
        assert!(found.message.contains("x^2+y^2-1 = "), "{}", found.message);
        let (_, state) = found.change.split_once(" = ").expect("a line");
        assert_eq!(
            told_of_kind(&text(state), AdviceKind::OffConstraint),
            None,
            "{state}"
        );
        let (from, to) = (composed(&text(off)), composed(&text(state)));
        let apart = from.plan.initial.iter().zip(&to.plan.initial);
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart <= distance, "{apart} {state}");
    }
    for on in [
        "[0.6, 0.8, 0.8, -0.6]",
        "[1, 0, 0, 1]",
        // cos 1, sin 1, and half a turn's momentum.
        "[0.5403023058681398, 0.8414709848078965, -0.8414709848078965, 0.5403023058681398]",
    ] {
        assert_eq!(
            told_of_kind(&text(on), AdviceKind::OffConstraint),
            None,
            "{on}"
        );
    }
    // What is 1e-16 of terms of 1 has no relative deviation.
    let run = composed(&text("[0.6, 0.8, 0.8, -0.6]"));
    let document = document(&text("[0.6, 0.8, 0.8, -0.6]"), &[]);
    let recorded = run_in_memory(
        &document,
        &run,
        &Registry::with_builtin(),
        Asked::default(),
        &mut Quiet,
    );
    for constraint in &recorded.expect("a run").report.invariants[1..] {
        assert_eq!(constraint.relative, None, "{constraint:?}");
    }
}

/// A step that does not come to `until`, and a method of order 4 across the seam of |q|; neither where there is nothing to say.
#[test]
fn shortened_steps_and_seams_are_told() {
    let text = |potential: &str, order: u32, until: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 + {potential}\"\n[method]\nrealization = \"auto\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = 0.3\n\
             [run]\ninitial = [1, 0.5]\nuntil = {until}\n"
        )
    };
    let shortened = told_of_kind(&text("q^2/2", 2, "10"), AdviceKind::ShortenedStep);
    let shortened = shortened.expect("34 steps");
    let step = 10.0 / 34.0;
    assert_eq!(shortened.change, format!("time-step = {step:?}"));
    let message = "`until` = 10 is not a whole number of steps of 0.3: steps of";
    assert!(
        shortened.message.starts_with(message),
        "{}",
        shortened.message
    );
    let whole = text("q^2/2", 2, "9");
    assert_eq!(told_of_kind(&whole, AdviceKind::ShortenedStep), None);
    for (potential, order, is_told) in [
        ("abs(q)", 4, true),
        ("if(q < 0, q^2, 0)", 4, true),
        ("abs(q)", 2, false),
        ("q^4", 4, false),
    ] {
        let told = told_of_kind(&text(potential, order, "9"), AdviceKind::Seams);
        assert_eq!(told.is_some(), is_told, "{potential}");
    }
}

/// Seams are those of what changes: a magnitude of a parameter has none, a bracket in pieces has.
#[test]
fn seams_of_brackets_are_told_and_of_parameters_not() {
    let text = |bracket: &str, hamiltonian: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nparameters = {{ a = -2 }}\nbracket = {{ \"q,p\" = \"{bracket}\" }}\n\
             convention = \"{{x,H}}\"\nhamiltonian = \"p^2/2 + {hamiltonian}\"\n[method]\nrealization = \"auto\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 0.1\n\
             [run]\ninitial = [1, 0.5]\nsteps = 10\n"
        )
    };
    for (bracket, hamiltonian, told) in [
        ("1", "abs(a)*q^2", None),
        ("1", "if(a > 0, q^2, q^4)", None),
        ("1", "atan2(q, 3)^2", None),
        ("1 + abs(q)", "q^2", Some("the bracket is smooth in pieces")),
        (
            "if(q > 0, 1, 1 + q^2)",
            "q^2",
            Some("the bracket is smooth in pieces"),
        ),
        (
            "1",
            "mod(q, a)",
            Some("the Hamiltonian is smooth in pieces"),
        ),
    ] {
        let found = told_of_kind(&text(bracket, hamiltonian), AdviceKind::Seams);
        let found = found.map(|advice| advice.message);
        match told {
            Some(told) => assert!(found.is_some_and(|message| message.starts_with(told))),
            None => assert_eq!(found, None, "{bracket}, {hamiltonian}"),
        }
    }
}

/// Where H jumps the energy is off by the jump, and its error says nothing: of a wall in q, of a pulse in t, of an angle's
/// cut. Of a smooth H that is followed badly the motion is not reliable.
#[test]
fn jumps_of_the_energy_are_told_as_such() {
    let message = |hamiltonian: &str, h: f64| {
        let text = format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = 1 }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"{hamiltonian}\"\n[method]\nstepper = \"splitting\"\ntime-step = {h}\n\
             [run]\ninitial = [-1, 1]\nsteps = 40\n"
        );
        let (document, run) = (document(&text, &[]), composed(&text));
        let registry = Registry::with_builtin();
        let recorded = run_in_memory(&document, &run, &registry, Asked::default(), &mut Quiet);
        let advice = recorded.expect("a run").report.advice.into_iter();
        let mut energy = advice.filter(|advice| advice.kind == AdviceKind::EnergyError);
        energy.next().map(|advice| advice.message)
    };
    for (hamiltonian, jump) in [
        ("p^2/2 + heaviside(q)", "by 1.0:"),
        ("p^2/2 + 3*heaviside(t - 0.5)*q", "by 1.5:"),
        ("p^2/2 + floor(2*q)", "by 1.0:"),
    ] {
        let found = message(hamiltonian, 0.05).expect(hamiltonian);
        assert!(
            found.contains(&format!("H itself jumps on the way, {jump}")),
            "{found}"
        );
    }
    let smooth = message("p^2/2 + 2*(q^2 - 4)^2", 0.15).expect("an error");
    assert!(smooth.contains("not reliable"), "{smooth}");
    assert_eq!(message("p^2/2 + max(q, 0)^2", 0.01), None);
}

/// {a, b} = 1 without a convention: b is the momentum where H is a square of it alone, or by its name. The convention that
/// is named instead turns the motion round.
#[test]
fn backward_time_is_told_whatever_the_names_are() {
    let text = |names: [&str; 2], hamiltonian: &str, sign: &str, more: &str| {
        let [a, b] = names;
        format!(
            "[system]\nvariables = [\"{a}\", \"{b}\"]\nbracket = {{ \"{a},{b}\" = \"{sign}1\" }}\nhamiltonian = \"{hamiltonian}\"\n\
             {more}\n[method]\nrealization = \"auto\"\ntime-step = 0.01\n[run]\ninitial = [1, 0.5]\nsteps = 10\n"
        )
    };
    for (names, hamiltonian, position) in [
        (["theta", "L"], "L^2/2 - cos(theta)", 0),
        (["phi", "J"], "J^2/3 + cos(phi)", 0),
        (["x", "v"], "(x^2 + v^2)/2", 0),
        (["x", "p"], "p^2/2 + x^4", 0),
        (["q", "v"], "(q^2 + v^2)/2", 0),
    ] {
        let found = told_of_kind(&text(names, hamiltonian, "", ""), AdviceKind::BackwardTime);
        let found = found.unwrap_or_else(|| panic!("{names:?}"));
        let moved = |text: &str| scene_end(text)[position] - 1.0;
        let forward = text(names, hamiltonian, "", &found.change);
        assert!(moved(&text(names, hamiltonian, "", "")) < 0.0, "{names:?}");
        assert!(moved(&forward) > 0.0, "{names:?}");
        assert_eq!(told_of_kind(&forward, AdviceKind::BackwardTime), None);
        let turned = text(names, hamiltonian, "-", "");
        assert_eq!(told_of_kind(&turned, AdviceKind::BackwardTime), None);
    }
    // The momentum first: {L, theta} = −1.
    let turned = text(["L", "theta"], "L^2/2 - cos(theta)", "-", "");
    assert!(told_of_kind(&turned, AdviceKind::BackwardTime).is_some());
    // Neither is a momentum: a vortex, a guiding centre, squares of both.
    for hamiltonian in [
        "-ln(x^2 + y^2)/2",
        "x^2/2 + y^2/3",
        "x*y",
        "exp(x) + exp(y)",
    ] {
        let text = text(["x", "y"], hamiltonian, "", "");
        assert_eq!(
            told_of_kind(&text, AdviceKind::BackwardTime),
            None,
            "{hamiltonian}"
        );
    }
}
