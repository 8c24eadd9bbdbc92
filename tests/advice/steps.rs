//! Steps that are too long and tolerances that are too loose.

use leafwise::run::advice::AdviceKind;

use super::{body, changed, end, of_kind, scene_end, told_of_kind};

/// A body that turns by 1.6 a unit of time: the midpoint rule errs by (t·1.6)²/12 of the motion.
#[test]
fn a_step_that_is_too_long_for_its_order_is_reported() {
    for (method, time_step) in [
        ("stepper = \"implicit-midpoint\"", 1.4),
        ("stepper = \"splitting\"", 1.4),
        (
            "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
            1.0,
        ),
    ] {
        let mut text = body(&format!("{method}\ntime-step = {time_step:?}"));
        let mut halvings = 0;
        while let Some(found) = of_kind(&text, AdviceKind::CoarseStep) {
            text = changed(&text, &found);
            halvings += 1;
        }
        assert!((1..=3).contains(&halvings), "{halvings}: {text}");
    }
}

/// A body in a strong field: substeps of dormand-prince45 within a ten-thousandth lead astray within four steps.
/// What the warning says, as often as it says it, brings the error from as much as the motion, 1.6, to a tenth of it.
#[test]
fn a_tolerance_that_is_too_loose_is_reported() {
    let text = |stepper: &str| {
        format!(
            "[system]\nvariables = [\"l1\", \"l2\", \"l3\", \"p1\", \"p2\", \"p3\"]\n\
             bracket = {{ lie-algebra = \"se3\" }}\n\
             hamiltonian = \"1.29*l1^2 + 0.43*l2^2 + 1.29*l3^2 + 0.88*p1^2 + 1.78*p2^2 + 1.96*p3^2 + 2*sin(p2*l2) \
             - 0.52*p1/(2.98 + p2)\"\n\
             [method]\nstepper = {stepper}\ntime-step = 1.3\n\
             [run]\ninitial = [-1.1, 1.74, 1.68, 1.99, -0.83, -1.8]\nsteps = 4\n"
        )
    };
    let expected = end(&text("{ name = \"dop853\", tolerance = 1e-13 }"), 4);
    let error = |text: &str| {
        let apart = end(text, 4).into_iter().zip(&expected);
        apart.fold(0.0_f64, |most, (x, exact)| most.max((x - exact).abs()))
    };
    let mut text = text("{ name = \"dormand-prince45\", tolerance = 1e-4 }");
    assert!(error(&text) > 1.0, "{}", error(&text));
    let mut tightened = 0;
    while let Some(found) = of_kind(&text, AdviceKind::CoarseStep) {
        assert!(found.message.contains("tolerance"), "{}", found.message);
        text = changed(&text, &found);
        tightened += 1;
    }
    assert!((1..=3).contains(&tightened), "{tightened}");
    assert!(error(&text) < 0.16, "{}", error(&text));
}

/// A logarithmic wall that no double resolves leaves errors of 2e-3 at every tolerance, a hundred thousand times what
/// is asked; the same motion without the wall has them within it.
#[test]
fn errors_that_outgrow_a_tolerance_are_reported() {
    let text = |wall: &str| {
        format!(
            "[system]\nvariables = [\"l1\", \"l2\", \"l3\", \"p1\", \"p2\", \"p3\"]\nconvention = \"{{x,H}}\"\n\
             bracket = {{ lie-algebra = \"se3\" }}\n\
             hamiltonian = \"0.95*l1^2 + 1.29*l2^2 + 0.74*l3^2 + 1.65*p1^2 + 0.44*p2^2 + 1.39*p3^2 \
             - 0.39*(exp(-p2) + atan(p3)) {wall}\"\n\
             [method]\nstepper = {{ name = \"dop853\", tolerance = 1e-8 }}\ntime-step = 1.6\n\
             [run]\ninitial = [1.28, 1.1, -0.56, -0.05, 1.65, -1.83]\nsteps = 4\n"
        )
    };
    let found = of_kind(&text("+ 0.01*ln(l2)"), AdviceKind::CoarseStep).expect("told");
    assert!(found.message.contains("outgrow"), "{}", found.message);
    assert_eq!(of_kind(&text(""), AdviceKind::CoarseStep), None);
}

/// x″ = x³ − x′/10 runs away to infinity at t = 1.33: the last steps are far too long, and forces leave the energy no say. What is
/// told does not depend on what is recorded, and the step that is asked for, as often as it is asked for, is right.
#[test]
fn the_last_step_is_judged_whatever_is_recorded() {
    let text = |every: u64| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 - q^4/4\"\nforces = [\"0.1*p\", 0]\n\
             [method]\nrealization = \"auto\"\ntime-step = 0.02\n\
             [run]\ninitial = [1, 1]\nsteps = 65\nrecord = {{ every = {every} }}\n"
        )
    };
    let coarse = |every| told_of_kind(&text(every), AdviceKind::CoarseStep);
    let found = coarse(1).expect("told");
    assert_eq!(coarse(7), Some(found.clone()));
    assert_eq!(coarse(1_000_000), Some(found.clone()));
    // The same force as a field of its own, over so short steps that nothing is left to err.
    let end_of = |step: f64| {
        let text = text(1).replace("time-step = 0.02", &format!("time-step = {step:?}"));
        let steps = libm::round(1.3 / step);
        scene_end(&text.replace("steps = 65", &format!("steps = {steps}")))[0]
    };
    let (exact, first) = (end_of(1.0 / 8192.0 / 10.0), end_of(0.02));
    let (mut step, mut found) = (0.02, Some(found));
    while let Some(advice) = found {
        let (_, asked) = advice.change.split_once(" = ").expect("a line");
        step = asked.parse().expect("a number");
        let shorter = text(1).replace("time-step = 0.02", &advice.change);
        let shorter = shorter.replace(
            "steps = 65",
            &format!("steps = {}", libm::round(1.3 / step)),
        );
        found = told_of_kind(&shorter, AdviceKind::CoarseStep);
    }
    assert!(step >= 0.02 / 64.0, "{step}");
    let (before, after) = ((first - exact).abs(), (end_of(step) - exact).abs());
    assert!(before > 0.3 * exact, "{before} of {exact}");
    assert!(after < 0.1 * exact, "{after} of {exact} with {step}");
}

/// One of ten steps errs by more than it moves; neither the first nor the last state is near it.
#[test]
fn one_bad_step_is_found_whatever_is_recorded() {
    let text = |every: u64| {
        format!(
            "[system]\nvariables = [\"n1\", \"n2\", \"n3\"]\n\
             bracket = {{ \"n1,n2\" = \"1.233*(2*n3) + 0.0734*n1\", \"n2,n3\" = \"1.35*(2*n1) + 0.0734*n3\", \
             \"n1,n3\" = \"(-1)*(0.7028*(2*n2))\" }}\n\
             hamiltonian = \"1.27*n1^2 + 1.33*n2^2 + (1/9)*n3^2 + 0.1*(n2*n1) + D1\"\n\
             forces = [\"0.3*((-0.379)*(n3*n1) + 1.1*(n2*n3*n3*n1))\", \"2*n3\", \"(-0.257)*n2\"]\n\
             define = {{ D1 = \"(-0.2072)*sin((-1.8862)*(n3*n1) + 0.1035*(n2*n3))\" }}\n\
             [method]\nrealization = \"auto\"\ncomposition = \"kahan-li-10\"\ntime-step = 0.182\n\
             [run]\ninitial = [-2.149, 0.1199, 0.2934]\nsteps = 10\n\
             record = {{ every = {every}, observables = [\"energy\"] }}\n"
        )
    };
    let found = [1, 2, 1_000_000].map(|every| told_of_kind(&text(every), AdviceKind::CoarseStep));
    assert!(found[0].is_some());
    assert!(found.iter().all(|one| *one == found[0]), "{found:?}");
}

/// Chains with one site displaced: far sites move by 1e-20 of it in the first steps, of which no step however short has a
/// digit. Families and variables by their names; short steps are no news, long ones are.
#[test]
fn what_hardly_moves_is_judged_beside_its_kind() {
    let springs = |q: &dyn Fn(usize) -> String, p: &dyn Fn(usize) -> String| {
        let kinetic = (0..8).map(|i| format!("{}^2/2", p(i)));
        let springs = (1..8).map(|i| format!("({} - {})^2/2", q(i), q(i - 1)));
        kinetic.chain(springs).collect::<Vec<_>>().join(" + ")
    };
    let names = |letter: &str| {
        (0..8)
            .map(|i| format!("\"{letter}{i}\""))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let pairs: Vec<String> = (0..8).map(|i| format!("\"q{i},p{i}\" = 1")).collect();
    let single = format!(
        "variables = [{}, {}]\nbracket = {{ {} }}\nconvention = \"{{x,H}}\"\nhamiltonian = \"{}\"",
        names("q"),
        names("p"),
        pairs.join(", "),
        springs(&|i| format!("q{i}"), &|i| format!("p{i}"))
    );
    let families = "families = { q = 8, p = 8 }\nbracket = { \"q[i],p[i]\" = 1 }\nconvention = \"{x,H}\"\nboundary = \"open\"\n\
                    hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\""
        .to_owned();
    let listed = format!("[1{}]", ", 0".repeat(15));
    let field = "{ \"q[i]\" = \"0\", \"p[i]\" = \"0\", \"q[0]\" = 1 }";
    for (system, initial) in [(single, listed.as_str()), (families, field)] {
        for (method, step) in [
            (
                "stepper = \"splitting\"\ncomposition = \"sofroniou-spaletta-10\"",
                0.005,
            ),
            ("stepper = \"splitting\"", 0.01),
            (
                "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }",
                0.02,
            ),
        ] {
            let text = |step: f64| {
                format!(
                    "[system]\n{system}\n[method]\n{method}\ntime-step = {step:?}\n[run]\ninitial = {initial}\nsteps = 200\n"
                )
            };
            assert_eq!(
                told_of_kind(&text(step), AdviceKind::CoarseStep),
                None,
                "{}",
                text(step)
            );
        }
        let long = format!(
            "[system]\n{system}\n[method]\nstepper = \"splitting\"\ntime-step = 0.9\n[run]\ninitial = {initial}\nsteps = 200\n"
        );
        assert!(
            told_of_kind(&long, AdviceKind::CoarseStep).is_some(),
            "{long}"
        );
    }
}

/// A pendulum that a constant force holds at rest, with ω = 3.7: splitting into two kicks errs by all of the motion there is, and so does half
/// a step. Small oscillations about it are what tells: (ωh)²/24 at 0.1, and half a turn and more at 0.8.
#[test]
fn an_equilibrium_is_judged_by_the_motion_about_it() {
    let text = |step: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nparameters = {{ g = 9.81, l = 0.7, F = 2.3 }}\nbracket = {{ \"q,p\" = \"1\" }}\n\
             convention = \"{{x,H}}\"\nhamiltonian = \"p^2/(2*l^2) - g*l*cos(q) - F*q\"\n[method]\nstepper = \"splitting\"\n\
             time-step = {step}\n[run]\ninitial = [0.3413806463577703, 0]\nsteps = 200\n"
        )
    };
    assert_eq!(told_of_kind(&text("0.1"), AdviceKind::CoarseStep), None);
    assert!(told_of_kind(&text("0.8"), AdviceKind::CoarseStep).is_some());
}
