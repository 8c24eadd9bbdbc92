//! A scene that asks for more than it uses, or for less than it needs, is told so, with the line to
//! write instead; that line mends it. Scenes that deserve no warning get none.

use leafwise::core::Structure;
use leafwise::core::diagnostics::StepEquation;
use leafwise::prelude::*;
use leafwise::run::{advice::Advice, advice::AdviceKind, advice::advise, advice::states_ahead};
use leafwise_tests::scenes::composed;

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
    }
}
