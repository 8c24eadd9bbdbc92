//! Realizations and generating functions of too many terms, too near their edge, or not what they claim to be.

use leafwise::core::diagnostics::StepEquation;
use leafwise::prelude::*;
use leafwise::run::advice::{AdviceKind, states_ahead};
use leafwise_tests::scenes::composed;

use super::{advice, body, changed, end, of_kind, scene, told, told_of_kind};

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
        let mut walk = composed(&cart(realization, steps)).walk();
        walk.advance(steps).expect("steps");
        walk.statistics().operations.expect("counted")
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
