//! A scene that asks for more than it uses, or for less than it needs, is told so, with the line to
//! write instead; that line mends it. Scenes that deserve no warning get none.

use leafwise::core::Structure;
use leafwise::core::diagnostics::StepEquation;
use leafwise::prelude::*;
use leafwise::run::advice::{Advice, AdviceKind, about_the_scene, advise, states_ahead};
use leafwise::run::{Asked, Quiet, run_in_memory};
use leafwise_tests::scenes::{composed, document};

/// A system of the library from a state, with a method.
fn scene(library: &str, initial: &str, method: &str) -> String {
    format!(
        "[system]\nlibrary = \"{library}\"\n[method]\n{method}\n[run]\ninitial = {initial}\n\
         steps = 1000\n"
    )
}

fn body(method: &str) -> String {
    scene("rigid-body", "[1, 3, 3]", method)
}

fn advice(text: &str) -> Vec<Advice> {
    let run = composed(text);
    advise(&run, &Registry::with_builtin(), &states_ahead(&run))
}

fn of_kind(text: &str, kind: AdviceKind) -> Option<Advice> {
    advice(text).into_iter().find(|advice| advice.kind == kind)
}

/// The scene with the line of `[method]` that a warning says.
fn changed(text: &str, advice: &Advice) -> String {
    let line = |line: &str| {
        let (key, value) = line.split_once(" = ").expect("a line");
        (format!("method.{key}"), value.to_owned())
    };
    let overrides: Vec<_> = advice.change.lines().map(line).collect();
    let changed = SceneDocument::parse_with("scene", text, &overrides, &Registry::with_builtin());
    changed.expect("a scene").text
}

/// x after some steps.
fn end(text: &str, steps: usize) -> Vec<f64> {
    let run = composed(text);
    let mut integrator = run.integrator();
    (0..steps).for_each(|_| integrator.step().expect("a step"));
    integrator.state().to_vec()
}

#[test]
fn a_truncation_order_that_no_step_feels_is_reported() {
    let text = body(
        "realization = { name = \"karasev-truncated\", order = 14 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 2 }\ntime-step = 0.01",
    );
    let found = of_kind(&text, AdviceKind::TruncationOrder).expect("a warning");
    let shorter = changed(&text, &found);
    assert_eq!(of_kind(&shorter, AdviceKind::TruncationOrder), None);
    // The same orbit: each of 100 steps differs by less than an ulp of the state, which is smaller
    // than 4.5, and over this short time errors do not grow.
    let (a, b) = (end(&text, 100), end(&shorter, 100));
    let bound = 100.0 * f64::EPSILON * 4.5;
    assert!(
        a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= bound),
        "{a:?} {b:?}"
    );
}

fn order_in(change: &str) -> usize {
    let (_, order) = change.split_once("order = ").expect("an order");
    let digits: String = order.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().expect("a number")
}

#[test]
fn terms_of_the_generating_function_below_the_realization_are_reported() {
    let text = scene(
        "gradient",
        "[0.8, 0.5, -0.4]",
        "realization = { name = \"karasev-truncated\", order = 2 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 8 }\ntime-step = 0.1",
    );
    let found = of_kind(&text, AdviceKind::DynamicsOrder).expect("a warning");
    let shorter = changed(&text, &found);
    assert!(order_in(&found.change) < 8);
    assert_eq!(of_kind(&shorter, AdviceKind::DynamicsOrder), None);
    // Against the exact realization's step both have the same error.
    let exact = end(&text.replace("truncated\", order = 2", "collocated\""), 1);
    let error = |text: &str| {
        let state = end(text, 1);
        let apart = state.iter().zip(&exact).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    let (long, short) = (error(&text), error(&shorter));
    assert!((short / long - 1.0).abs() < 0.5, "{short:e} {long:e}");
    // Over an order that suits it, no term is wasted.
    let suited = text.replace("order = 2", "order = 8");
    assert_eq!(of_kind(&suited, AdviceKind::DynamicsOrder), None);
}

#[test]
fn an_exact_realization_that_costs_no_more_is_reported() {
    let text = body(
        "realization = { name = \"karasev-truncated\", order = 6 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1",
    );
    let found = of_kind(&text, AdviceKind::ExactRealization).expect("a warning");
    assert_eq!(found.change, "realization = \"auto\"");
    assert!(
        found.message.contains("so3-exponential"),
        "{}",
        found.message
    );
    assert_eq!(advice(&changed(&text, &found)), []);
    // No closed form, and collocation is dearer: nothing to say.
    let text = scene(
        "gradient",
        "[0.8, 0.5, -0.4]",
        "realization = { name = \"karasev-truncated\", order = 4 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1",
    );
    assert_eq!(of_kind(&text, AdviceKind::ExactRealization), None);
}

fn step_equation(run: &ComposedRun) -> StepEquation {
    let method = run.method.written().expect("realization and dynamics");
    let parameters = run.system.parameter_values();
    let equation = StepEquation::new(method, &parameters, run.plan.epsilon, run.plan.h);
    equation.expect("maps by themselves")
}

/// y = x: where nothing is solved, nothing else is a solution, and no start is tried.
#[test]
fn a_step_without_an_equation_has_one_solution() {
    let method = "realization = \"karasev-collocated\"\n\
                  dynamics = { name = \"collective\", correction = \"none\" }\ntime-step = 0.5";
    let run = composed(&body(method));
    let (mut solved, mut sought) = (step_equation(&run), step_equation(&run));
    let x = [1.0, 3.0, 3.0];
    let solution = solved.solve(&x, &x).expect("a step");
    assert_eq!(solution.y, x);
    assert_eq!(sought.others(&x, 16, u64::MAX), Ok(Vec::new()));
    assert!(solved.operations().is_some_and(|operations| operations > 0));
    assert_eq!(sought.operations(), solved.operations());
}

#[test]
fn steps_near_the_edge_of_a_truncated_chart_are_reported() {
    let text = |order: usize, time_step: &str| {
        body(&format!(
            "realization = {{ name = \"karasev-truncated\", order = {order} }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {time_step}"
        ))
    };
    let found = of_kind(&text(8, "2.2"), AdviceKind::SeveralSolutions).expect("a warning");
    assert_eq!(found.change, "time-step = 1.1");
    assert_eq!(of_kind(&text(8, "0.1"), AdviceKind::SeveralSolutions), None);
    // As many starts as the operations allow for.
    let run = composed(&text(8, "2.2"));
    let found = |most: u64| -> usize {
        let mut equation = step_equation(&run);
        let others = |x: &Vec<f64>| equation.others(x, 16, most).map_or(0, |found| found.len());
        states_ahead(&run).iter().map(others).sum()
    };
    assert!(found(u64::MAX) > 0);
    assert_eq!(found(0), 0);
    // A run that goes through, with an energy that is wrong by a tenth.
    let found = of_kind(&text(4, "2.0"), AdviceKind::Chart).expect("a warning");
    assert_eq!(found.change, "time-step = 1.0");
    // Order 3 is order 2 on a linear tensor, and no nearer to the edge.
    for order in [2, 3] {
        assert_eq!(of_kind(&text(order, "0.8"), AdviceKind::Chart), None);
    }
    // Inside the chart, where the series is far from its limit.
    let found = of_kind(&text(4, "1.4"), AdviceKind::RealizationDefect).expect("a warning");
    assert_eq!(found.change, "time-step = 0.7");
}

#[test]
fn a_chart_that_is_nearly_used_up_is_reported() {
    let text = |time_step: f64| {
        let method = format!(
            "realization = \"so3-exponential\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {time_step:?}"
        );
        scene("rigid-body", "[4, 0, 0]", &method)
    };
    // An equilibrium: y = x and p = h ∇H = (4h, 0, 0), where the chart's radius is |εp| = 2π.
    let found = of_kind(&text(1.3), AdviceKind::Chart).expect("a warning");
    assert_eq!(found.change, "time-step = 0.65");
    let used = 4.0 * 1.3 / (2.0 * std::f64::consts::PI);
    assert!(
        found.message.contains(&format!("{used:.2} of the way")),
        "{}",
        found.message
    );
    assert_eq!(of_kind(&text(0.2), AdviceKind::Chart), None);
}

/// Operations a step, and how far 32 steps lead from where Gauss's method of order 16 does in 128.
fn cost_and_error(text: &str) -> (f64, f64) {
    let run = composed(text);
    let step = run.plan.epsilon * run.plan.h;
    let method = format!(
        "stepper = {{ name = \"gauss\", stages = 8 }}\ntime-step = {:?}",
        step / 4.0
    );
    let exact = end(&body(&method), 128);
    let mut integrator = run.integrator();
    (0..32).for_each(|_| integrator.step().expect("a step"));
    let apart = integrator
        .state()
        .iter()
        .zip(&exact)
        .map(|(a, b)| (a - b).abs());
    let operations = integrator.statistics().operations_per_step();
    (operations.expect("counted"), apart.fold(0.0, f64::max))
}

#[test]
fn a_stepper_that_is_no_poisson_map_is_reported_where_splitting_is_one_for_no_more() {
    for stepper in ["implicit-midpoint", "gauss", "dormand-prince45"] {
        let text = body(&format!("stepper = \"{stepper}\"\ntime-step = 0.1"));
        let found = of_kind(&text, AdviceKind::NoPoissonMap).expect(stepper);
        let mended = changed(&text, &found);
        let properties = composed(&mended).method.map().properties();
        assert_eq!(properties.structure, Structure::Exact, "{mended}");
        assert_eq!(advice(&mended), [], "{stepper}");
        let ((own, before), (other, after)) = (cost_and_error(&text), cost_and_error(&mended));
        assert!(
            other <= 1.1 * own,
            "{stepper}: {other} operations, not {own}"
        );
        // Both to the 1e-11 of |x| that the advice's own measure tells apart.
        assert!(
            after <= before.max(1e-10),
            "{stepper}: {after:e}, not {before:e}"
        );
    }
    // Gauss methods are Poisson maps of constant tensors; these steppers are Poisson maps.
    let oscillator = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"-1\" }\n\
                      hamiltonian = \"(q^2 + p^2)/2\"\n[method]\nstepper = \"gauss\"\n\
                      time-step = 0.2\n[run]\ninitial = [1, 0]\nsteps = 100\n";
    assert_eq!(of_kind(oscillator, AdviceKind::NoPoissonMap), None);
    for stepper in ["splitting", "spherical-midpoint"] {
        let text = body(&format!("stepper = \"{stepper}\"\ntime-step = 0.2"));
        assert_eq!(advice(&text), [], "{stepper}");
    }
    // No pieces with exact flows: nothing to take instead.
    let gradient = scene(
        "gradient",
        "[0.8, 0.5, -0.4]",
        "stepper = \"rk4\"\ntime-step = 0.1",
    );
    assert_eq!(of_kind(&gradient, AdviceKind::NoPoissonMap), None);
}

#[test]
fn stages_that_no_step_feels_are_reported() {
    let text = |stages: u32, time_step: &str| {
        body(&format!(
            "stepper = {{ name = \"gauss\", stages = {stages} }}\ntime-step = {time_step}"
        ))
    };
    let long = text(8, "0.01");
    let found = of_kind(&long, AdviceKind::Stages).expect("a warning");
    let shorter = changed(&long, &found);
    assert_eq!(of_kind(&shorter, AdviceKind::Stages), None);
    let bound = 100.0 * f64::EPSILON * 4.5;
    let (a, b) = (end(&long, 100), end(&shorter, 100));
    assert!(
        a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= bound),
        "{a:?} {b:?}"
    );
    assert_eq!(of_kind(&text(3, "0.2"), AdviceKind::Stages), None);
}

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

/// asinh(1e300 x) has the slope 1/x, and 1e300/√(1 + 1e600 x²) is 0 in doubles; asinh(1e140 x) has it there too.
#[test]
fn a_derivative_that_leaves_the_range_of_doubles_is_reported() {
    let text = |factor: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
             hamiltonian = \"p^2/2 + asinh({factor}*q)\"\n\
             [method]\nstepper = \"rk4\"\ntime-step = 0.01\n\
             [run]\ninitial = [1.5, 0.5]\nsteps = 4\n"
        )
    };
    let found = of_kind(&text("1e300"), AdviceKind::RoundOff).expect("told");
    assert!(
        found.message.contains("by q it is 0, by differences 0.67"),
        "{}",
        found.message
    );
    assert_eq!(of_kind(&text("1e140"), AdviceKind::RoundOff), None);
}

/// cos(kq) with kq = 2e16 and 2e9: round-off of q is 2 radians and 2e-7 of one.
#[test]
fn a_step_that_the_states_round_off_decides_is_reported() {
    let text = |k: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\n\
             hamiltonian = \"p^2/2 + sin({k}*q)/{k}\"\nconvention = \"{{x,H}}\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = 1e-18\n\
             [run]\ninitial = [2.1, 1e-17]\nsteps = 8\n"
        )
    };
    let found = of_kind(&text("1e16"), AdviceKind::RoundOff).expect("a warning");
    assert!(found.message.contains("round-off"), "{}", found.message);
    assert_eq!(of_kind(&text("1e9"), AdviceKind::RoundOff), None);
}

/// A constant of 1e300 beside terms of 1, and one of 1e3.
#[test]
fn an_energy_below_its_own_round_off_is_reported() {
    let text = |constant: &str| {
        format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\"]\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"{constant} + x^2/2 + y^2/4 + z^2/6\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = 0.05\n[run]\ninitial = [1, 3, 3]\nsteps = 100\n"
        )
    };
    let found = of_kind(&text("1e300"), AdviceKind::RoundOff).expect("a warning");
    assert!(found.change.contains("constant"), "{}", found.change);
    assert_eq!(of_kind(&text("1e3"), AdviceKind::RoundOff), None);
}

#[test]
fn the_scenes_of_the_gallery_deserve_no_warning() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    for entry in std::fs::read_dir(folder).expect("the gallery") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a scene");
        assert_eq!(advice(&text), [], "{}", path.display());
        let about = about_the_scene(&document(&text, &[]), &composed(&text));
        assert_eq!(about, [], "{}", path.display());
    }
}

/// What a whole run in memory tells.
fn told(text: &str) -> Vec<Advice> {
    let registry = Registry::with_builtin();
    let (document, run) = (document(text, &[]), composed(text));
    let recorded = run_in_memory(&document, &run, &registry, Asked::default(), &mut Quiet);
    recorded.expect("a run").report.advice
}

fn told_of_kind(text: &str, kind: AdviceKind) -> Option<Advice> {
    told(text).into_iter().find(|advice| advice.kind == kind)
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

/// All coordinates at the end of the scene's steps.
fn scene_end(text: &str) -> Vec<f64> {
    leafwise_tests::scenes::end(&composed(text))
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

/// Energies that are right and near 0 where an orbit begins or waits, on lattices without recorded states, and with the
/// time; the same methods with errors of a hundredth and more are told.
#[test]
fn an_energy_is_judged_by_what_it_is_along_the_whole_orbit() {
    let duffing = |step: f64, steps: u64| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 - q^2/2 + q^4/4\"\n\
             [method]\nrealization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\n\
             time-step = {step:?}\n[run]\ninitial = [1e-6, 0.0]\nsteps = {steps}\n"
        )
    };
    let kicks = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
                 hamiltonian = \"p^2/2 + 0.5*cos(q)*exp(-(sin(pi*(t-0.5))/0.05)^2)\"\n\
                 [method]\nstepper = \"dop853\"\ntime-step = 0.1\n[run]\ninitial = [1.0, 0.0]\nsteps = 100\n";
    let slope = |step: f64, well: &str| {
        format!(
            "[system]\nfamilies = {{ q = 100, p = 100 }}\nparameters = {{ h = 0.1 }}\nbracket = {{ \"q[i],p[i]\" = 1 }}\n\
             convention = \"{{x,H}}\"\nboundary = \"periodic\"\nhamiltonian = \"sum(i, p[i]^2/2 + h*q[i]{well})\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = {step:?}\n\
             [run]\ninitial = {{ \"q[i]\" = \"0.3*sin(2*pi*i/N)\", \"p[i]\" = \"0\" }}\nsteps = 200\n"
        )
    };
    for right in [duffing(0.05, 1200), kicks.to_owned(), slope(0.1, "")] {
        assert_eq!(
            told_of_kind(&right, AdviceKind::EnergyError),
            None,
            "{right}"
        );
    }
    for wrong in [duffing(0.9, 70), slope(0.25, " + 10*q[i]^4 - 0.030375")] {
        let found = told_of_kind(&wrong, AdviceKind::EnergyError);
        assert!(found.is_some(), "{wrong}");
    }
}

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

/// Who follows it pays no more: operations as a run of so many steps counts them, what a first step prepares included once.
#[test]
fn an_exact_realization_is_named_where_a_whole_run_of_it_costs_no_more() {
    let cart = |realization: &str, steps: u64| {
        format!(
            "[system]\nvariables = [\"X\", \"x\", \"y\", \"P\", \"px\", \"py\"]\nparameters = {{ M = 2.0, m = 1.0, g = 9.81 }}\n\
             bracket = {{ \"X,P\" = 1, \"x,px\" = 1, \"y,py\" = 1 }}\nconvention = \"{{x,H}}\"\n\
             constraints = [\"(x-X)^2 + y^2 - 1\", \"(x-X)*(px/m - P/M) + y*py/m\"]\n\
             hamiltonian = \"P^2/(2*M) + (px^2+py^2)/(2*m) + m*g*y\"\n\
             [method]\nrealization = {realization}\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\n\
             time-step = 0.00125\n[run]\ninitial = [0, 0.8, -0.6, 0, 0, 0]\nsteps = {steps}\n"
        )
    };
    let truncated = "{ name = \"karasev-truncated\", order = 4 }";
    let operations = |realization: &str, steps: u64| {
        let mut integrator = composed(&cart(realization, steps)).integrator();
        integrator.advance(steps).expect("steps");
        integrator.statistics().operations.expect("counted")
    };
    let mut outcomes = [0, 0];
    for steps in [8, 100, 400] {
        let is_told = told_of_kind(&cart(truncated, steps), AdviceKind::ExactRealization).is_some();
        let [own, exact] =
            [truncated, "\"auto\""].map(|realization| operations(realization, steps));
        assert!(!is_told || exact <= own, "{steps}: {exact} against {own}");
        outcomes[usize::from(exact > own)] += 1;
    }
    assert!(outcomes.iter().all(|count| *count > 0), "{outcomes:?}");
}

/// A spinning particle that a scene's own realization throws off its leaves, away from where it begins or by little from
/// there on. What is told to write instead keeps them.
#[test]
fn a_part_that_claims_to_be_exact_is_told_where_an_orbit_belies_it() {
    let text = |lie: &str| {
        let axes = ["x", "y", "z"];
        let alpha: Vec<String> = (0..3)
            .map(|i| {
                let [own, next, other] = [0, 1, 2].map(|k| axes[(i + k) % 3]);
                let lie = if i == 0 { lie } else { "" };
                format!(
                    "\"{own} - epsilon*({next}*p_{other} - {other}*p_{next})/2 \
                     + epsilon^2/4*p_{own}*(p_x*x + p_y*y + p_z*z){lie}\""
                )
            })
            .collect();
        format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\"]\nhamiltonian = \"0.5*x^2 + y^2/4 + z^2/6\"\n\
             bracket = {{ \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }}\ncasimirs = {{ spin = \"x^2+y^2+z^2\" }}\n\
             [method]\nrealization = {{ name = \"closed-form\", alpha = [{}] }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = 0.1\n\
             [run]\ninitial = [1.0, 0.5, -0.7]\nsteps = 500\n",
            alpha.join(", ")
        )
    };
    let away = "((x-1)^2 + (y-0.5)^2 + (z+0.7)^2)";
    for lie in [
        format!(" + epsilon^2*p_x^2*(tanh(500*({away} - 0.5)) + 1)"),
        format!(" + 1e-9*epsilon^2*p_x^2*{away}^4"),
        format!(" + 1e-11*epsilon*p_x*y*{away}"),
    ] {
        let found = told_of_kind(&text(&lie), AdviceKind::CasimirDrift).expect("told");
        assert!(found.message.contains("spin"), "{}", found.message);
        assert_eq!(
            told_of_kind(&changed(&text(&lie), &found), AdviceKind::CasimirDrift),
            None
        );
    }
    let lie = format!(" + epsilon^2*p_x^2*(tanh(500*({away} - 0.5)) + 1)");
    let found = told_of_kind(&text(&lie), AdviceKind::BrokenClaim).expect("told");
    assert_eq!(
        told_of_kind(&changed(&text(&lie), &found), AdviceKind::BrokenClaim),
        None
    );
    assert_eq!(told(&text("")), []);
}
