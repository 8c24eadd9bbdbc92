//! Derivatives of trajectories: tangents and covectors against each other, and against differences of whole runs.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

mod lattices;

use leafwise::core::Registry;
use leafwise::core::gradient::{Gradient, GradientError, Plan, Trajectory, Way};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};

const GOES_ON: &(dyn Fn() -> bool + Sync) = &|| true;

const RIGID_BODY: &str = "library = \"rigid-body\"";

/// Hénon and Heiles' system with two numbers of its own.
const HENON_HEILES: &str = "variables = [\"q1\", \"q2\", \"p1\", \"p2\"]
bracket = { \"q1,p1\" = \"1\", \"q2,p2\" = \"1\" }
convention = \"{x,H}\"
parameters = { a = 1.0, b = 1.0 }
hamiltonian = \"(p1^2 + p2^2)/2 + (q1^2 + a*q2^2)/2 + b*(q1^2*q2 - q2^3/3)\"";

/// Long enough to be stepped by templates.
const LATTICE: &str = "library = \"volterra-lattice\"\nfamilies = { x = 100 }";

/// A Hamilton–Jacobi method, in closed form or truncated; splittings, composed or not; stages that solve.
const METHODS: [(&str, &str); 6] = [
    (
        RIGID_BODY,
        "dynamics = { name = \"hamilton-jacobi\", order = 4 }",
    ),
    (
        "library = \"heavy-top\"",
        "realization = { name = \"karasev-truncated\", order = 4 }\ndynamics = { name = \"hamilton-jacobi\", order = 4 }",
    ),
    (RIGID_BODY, "stepper = \"splitting\""),
    (
        HENON_HEILES,
        "stepper = \"splitting\"\ncomposition = \"kahan-li-6\"",
    ),
    (
        RIGID_BODY,
        "dynamics = { name = \"hamilton-jacobi\", order = 2 }\ncomposition = \"suzuki-4\"",
    ),
    (
        "library = \"lotka-volterra-periodic\"",
        "dynamics = { name = \"hamilton-jacobi\", order = 4 }",
    ),
];

/// A map along leaves.
const FORCED: (&str, &str) = (
    "library = \"rigid-body\"\nparameters = { k = 1e-3 }\ndamping = { rate = \"k\" }",
    "dynamics = \"one-form\"",
);

fn composed(system: &str, method: &str) -> ComposedRun {
    let initial = match system {
        s if s.contains("heavy-top") => "[0.5, 1.0, 1.5, 0.6, 0.0, 0.8]",
        s if s.contains("q1") => "[0.1, 0.15, 0.2, 0.1]",
        s if s.contains("lattice") => "{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }",
        s if s.contains("lotka") => "[1.0, 1.9, 0.5]",
        _ => "[1.0, 3.0, 3.0]",
    };
    let text = format!(
        "[system]\n{system}\n[method]\n{method}\ntime-step = 0.05\n[run]\ninitial = {initial}\nsteps = 1\n"
    );
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("scene", &text, &registry)
        .unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    compose(&document, &registry).unwrap_or_else(|refusal| panic!("{refusal}\n{text}"))
}

fn trajectory<'a>(run: &'a ComposedRun, parameters: &'a [f64]) -> Trajectory<'a> {
    Trajectory {
        map: run.method.map(),
        parameters,
        epsilon: run.plan.epsilon,
        h: run.plan.h,
        goes_on: GOES_ON,
    }
}

/// Covectors of every sample, of no symmetry.
fn cotangents(plan: Plan, d: usize) -> Vec<f64> {
    (0..plan.samples() * d)
        .map(|i| libm::sin(1.0 + 0.7 * i as f64))
        .collect()
}

fn pulled(at: &Trajectory<'_>, initial: &[f64], plan: Plan, way: Way) -> Gradient {
    let reached = at.run(initial, plan).expect("a run");
    let cotangents = cotangents(plan, initial.len());
    at.pull(initial, &reached, &cotangents, plan, (true, Some(way)))
        .expect("a gradient")
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Σ w·(DΦᵏ v + ∂_λΦᵏ μ) = g_x·v + g_λ·μ for every v and μ: by tangents of all directions the gradient itself. Each of the
/// 10³ steps rounds products of the size of the gradient: a few dozen roundings each, of random signs, 40 √1000 u, and
/// what a run back is off by, as much again.
#[test]
fn covectors_and_tangents_agree_to_round_off_after_a_thousand_steps() {
    for (system, method) in METHODS.into_iter().chain([FORCED]) {
        let run = composed(system, method);
        let (parameters, initial) = (run.system.parameter_values(), &run.plan.initial);
        let (d, count) = (initial.len(), parameters.len());
        let at = trajectory(&run, &parameters);
        let plan = Plan {
            steps: 1000,
            every: 250,
        };
        let (mut tangents, mut by_parameters) = (Vec::new(), Vec::new());
        for k in 0..d + count {
            tangents.extend((0..d).map(|i| if i == k { 1.0 } else { 0.0 }));
            by_parameters.extend((0..count).map(|i| if d + i == k { 1.0 } else { 0.0 }));
        }
        let directions = (&tangents[..], &by_parameters[..]);
        let pushed = at.push(initial, directions, plan).expect("tangents");
        let cotangents = cotangents(plan, d);
        let expected: Vec<f64> = (0..d + count)
            .map(|k| {
                let samples = pushed.tangents.chunks_exact((d + count) * d);
                let pairs = samples.zip(cotangents.chunks_exact(d));
                pairs.map(|(all, w)| dot(&all[k * d..][..d], w)).sum()
            })
            .collect();
        for way in [Way::Back, Way::Checkpoints] {
            let gradient = pulled(&at, initial, plan, way);
            let found = [gradient.initial, gradient.parameters].concat();
            let error = distance(&found, &expected) / largest(&expected);
            println!(
                "{system} {method} {way:?}: {error:.1e}, {}",
                gradient.growth
            );
            assert!(error <= 2500.0 * UNIT_ROUNDOFF, "{found:?} {expected:?}");
        }
    }
}

/// Differences of order 6: of a function whose phases turn by r when its argument changes by one, they are wrong by
/// about (2rδ)⁶/30 of its derivative, and by its own error over rδ.
fn differences(point: &[f64], delta: f64, function: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let slope = |k: usize, delta: f64| {
        let [above, below] = [delta, -delta].map(|delta| {
            let mut point = point.to_vec();
            point[k] += delta;
            (function(&point), point[k])
        });
        (above.0 - below.0) / (above.1 - below.1)
    };
    let sixth =
        |k| (64.0 * slope(k, delta) - 20.0 * slope(k, 2.0 * delta) + slope(k, 4.0 * delta)) / 45.0;
    (0..point.len()).map(sixth).collect()
}

/// r is about 50 after 5 units of time: 1e-15 and 1e-14/(50 δ).
#[test]
fn gradients_are_those_of_differences_after_a_hundred_steps() {
    for (system, method) in METHODS.into_iter().chain([FORCED]) {
        let run = composed(system, method);
        let (parameters, initial) = (run.system.parameter_values(), run.plan.initial.clone());
        let d = initial.len();
        let plan = Plan {
            steps: 100,
            every: 25,
        };
        let function = |point: &[f64]| {
            let at = trajectory(&run, &point[d..]);
            let reached = at.run(&point[..d], plan).expect("a run");
            dot(&reached.samples, &cotangents(plan, d))
        };
        let at = trajectory(&run, &parameters);
        let gradient = pulled(&at, &initial, plan, Way::Back);
        let found = [gradient.initial, gradient.parameters].concat();
        let expected = differences(&[initial, parameters].concat(), 3e-5, function);
        let error = distance(&found, &expected) / largest(&expected);
        println!("{system} {method}: {error:.1e}");
        assert!(error <= 1e-10, "{found:?} {expected:?}");
    }
}

/// 10⁵ steps of the rigid body: r is 8·10⁴, δ = 3e-7 leaves 1e-9 of the derivative and 1e-11/(rδ) of the runs' error.
#[test]
fn the_rigid_body_s_gradient_after_1e5_steps_is_that_of_differences_to_1e_8() {
    let (system, method) = METHODS[0];
    let run = composed(system, method);
    let (parameters, initial) = (run.system.parameter_values(), &run.plan.initial);
    let plan = Plan {
        steps: 100_000,
        every: 100_000,
    };
    let mut w = vec![0.0; 6];
    w[3..].copy_from_slice(&[0.3, -0.8, 0.5]);
    let function = |point: &[f64]| {
        let reached = trajectory(&run, &point[3..]).run(&point[..3], plan);
        let reached = reached.expect("a run");
        let (state, beyond) = reached.end(3);
        dot(&w[3..], state) + dot(&w[3..], beyond)
    };
    let at = trajectory(&run, &parameters);
    let reached = at.run(initial, plan).expect("a run");
    let gradient = at
        .pull(initial, &reached, &w, plan, (true, None))
        .expect("a gradient");
    assert_eq!(gradient.way, Way::Back);
    let found = [gradient.initial, gradient.parameters].concat();
    let expected = differences(
        &[initial.clone(), parameters.clone()].concat(),
        3e-7,
        function,
    );
    let error = distance(&found, &expected) / largest(&expected);
    println!(
        "{error:.1e}, miss {:.1e}, {}",
        gradient.miss, gradient.growth
    );
    assert!(error <= 1e-8, "{found:?} {expected:?}");
}

/// 10⁶ steps and as many back. An increment of the size h rounds by u h: after n steps the energy is off by u h √n and
/// the phase by u h² n^{3/2}, each way; and what is compared are doubles. The way back begins anew at 64 states that the run
/// keeps, so that n = 10⁶/64: 5e-13 for h = 0.05, in place of 3e-10. The shear and three standard deviations, of which the
/// largest of 64 is one, are a factor of a dozen.
#[test]
fn a_million_steps_and_back_return_the_initial_state_to_what_increments_round() {
    let (system, method) = METHODS[0];
    let run = composed(system, method);
    let (parameters, initial) = (run.system.parameter_values(), &run.plan.initial);
    let plan = Plan {
        steps: 1_000_000,
        every: 1_000_000,
    };
    let at = trajectory(&run, &parameters);
    for h in [0.005, 0.05] {
        let at = Trajectory {
            epsilon: 1.0,
            h,
            ..at
        };
        let miss = pulled(&at, initial, plan, Way::Back).miss;
        let rounds = UNIT_ROUNDOFF * (1.0 + h * h * libm::pow(1e6 / 64.0, 1.5));
        println!(
            "h = {h}: miss {miss:.1e}, {:.1} u (1 + h² n^1.5)",
            miss / rounds
        );
        assert!(miss <= 16.0 * rounds && miss <= 1e-11);
    }
}

/// Operations of a run and its gradient, by the initial state and all parameters, over those of the run: the run, the run
/// back, and one gradient in reverse mode. A step that solves has it from one evaluation with Jacobians, which the solves
/// after it share, and the gradient of the equation by the parameters. The flows of a splitting share their functions with their
/// pull-back: of the rigid body's rotations these are most of the work. Flows of polynomials of degree two have none: a gradient
/// by two coordinates and two parameters takes nearly twice the operations of the flow.
#[test]
fn operations_of_a_gradient() {
    for (system, method) in METHODS {
        let run = composed(system, method);
        let (parameters, initial) = (run.system.parameter_values(), &run.plan.initial);
        let plan = Plan {
            steps: 2000,
            every: 2000,
        };
        let at = trajectory(&run, &parameters);
        let mut walk = run.walk();
        walk.advance(plan.steps).expect("a run");
        let forward = walk.statistics().operations.expect("they are counted");
        let back = pulled(&at, initial, plan, Way::Back).operations;
        let ratio = 1.0 + back.expect("they are counted") as f64 / forward as f64;
        println!("{system} {method}: {ratio:.2} runs");
        let most = if system == HENON_HEILES { 4.0 } else { 3.0 };
        assert!(ratio <= most, "{system} {method}: {ratio}");
    }
}

/// Hénon and Heiles' motion of energy 1/6 is chaotic: covectors grow by e^{λt}; that of a small energy is not, and they
/// grow like t.
#[test]
fn a_chaotic_motion_shows_in_how_covectors_grow() {
    let run = composed(METHODS[3].0, METHODS[3].1);
    let parameters = run.system.parameter_values();
    let at = trajectory(&run, &parameters);
    let plan = Plan {
        steps: 20_000,
        every: 20_000,
    };
    let pulled = |initial: &[f64]| {
        let reached = at.run(initial, plan).expect("a run");
        let cotangents = cotangents(plan, 4);
        let gradient = at.pull(initial, &reached, &cotangents, plan, (false, None));
        let gradient = gradient.expect("a gradient");
        (gradient.growth, gradient.way)
    };
    let calm = pulled(&[0.05, 0.05, 0.1, 0.05]);
    // p1 of the energy 1/6 at q = (0, −0.1), p2 = 0.
    let potential = 0.01 / 2.0 + 0.001 / 3.0;
    let momentum = libm::sqrt(2.0 * (1.0 / 6.0 - potential));
    let wild = pulled(&[0.0, -0.1, momentum, 0.0]);
    println!("calm {calm:?}, wild {wild:?}");
    // The largest exponent of this energy is between 0.1 and 0.15 over long times, and finite times scatter about it.
    assert!(!calm.0.is_large() && calm.1 == Way::Back, "{calm:?}");
    assert!(wild.0.is_large() && wild.1 == Way::Back, "{wild:?}");
    assert!((0.06..0.25).contains(&wild.0.rate()), "{wild:?}");
    assert!(wild.0.to_string().contains("no digit"), "{}", wild.0);
    let initial = &[0.0, -0.1, momentum, 0.0];
    let tangents = at.push(initial, (&[1.0, 0.0, 0.0, 0.0], &[]), plan);
    let growth = tangents.expect("tangents").growth;
    assert!(
        growth.is_large() && (growth.rate() / wild.0.rate() - 1.0).abs() < 0.2,
        "{growth}"
    );
}

/// What is not known is refused, with what to take instead.
#[test]
fn what_has_no_derivative_is_refused() {
    let plan = Plan {
        steps: 10,
        every: 10,
    };
    let found = |method: &str, by_parameters: bool, way: Option<Way>| {
        let run = composed(RIGID_BODY, method);
        let (parameters, initial) = (run.system.parameter_values(), &run.plan.initial);
        let at = trajectory(&run, &parameters);
        let reached = at.run(initial, plan).expect("a run");
        let cotangents = cotangents(plan, 3);
        at.pull(initial, &reached, &cotangents, plan, (by_parameters, way))
            .map(|gradient| gradient.way)
    };
    let numbers = "realization = \"karasev-collocated\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let refused = found(numbers, true, None).expect_err("numbers");
    assert!(
        matches!(refused, GradientError::NoParameters { .. }),
        "{refused}"
    );
    assert!(refused.to_string().contains("splitting"), "{refused}");
    assert_eq!(found(numbers, false, None), Ok(Way::Back));
    let runge_kutta = "stepper = \"rk4\"";
    let refused = found(runge_kutta, false, Some(Way::Back)).expect_err("not self-adjoint");
    assert!(
        matches!(refused, GradientError::NotSelfAdjoint { .. }),
        "{refused}"
    );
    assert_eq!(found(runge_kutta, false, None), Ok(Way::Checkpoints));
    let noisy = format!("{LATTICE}\nnoise = [{{ hamiltonian = \"x[i]\", strength = \"0.1\" }}]");
    let noisy = composed(&noisy, METHODS[0].1);
    let (parameters, initial) = (noisy.system.parameter_values(), &noisy.plan.initial);
    let at = trajectory(&noisy, &parameters);
    let refused = at.push(initial, (&vec![1.0; initial.len()], &[]), plan);
    let refused = refused.expect_err("steps that are drawn anew");
    assert!(
        matches!(refused, GradientError::NoTangent { .. }),
        "{refused}"
    );
}
