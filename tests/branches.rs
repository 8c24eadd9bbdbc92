//! Steps of any size are solved on the branch that begins at the state, or refused.
//!
//! `LEAFWISE_SWEEP` sets the number of random scenes of each test, 48 otherwise.

use leafwise::core::{Integrator, StepError};
use leafwise::prelude::{Registry, SceneDocument};
use leafwise::scene::{ComposedRun, compose};
use proptest::collection::vec;
use proptest::prelude::*;

fn cases() -> u32 {
    let wanted = std::env::var("LEAFWISE_SWEEP").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(48)
}

fn scene(text: &str) -> ComposedRun {
    let document = SceneDocument::parse("scene", text, &Registry::with_builtin()).expect("a scene");
    compose(&document, &Registry::with_builtin())
        .unwrap_or_else(|refusal| panic!("{refusal}\n{text}"))
}

/// The scene's steps, one after the other, until one is refused.
fn steps(run: &ComposedRun) -> (Vec<Vec<f64>>, Option<StepError>) {
    let mut integrator = run.integrator();
    let mut states = vec![integrator.state().to_vec()];
    for _ in 0..run.plan.steps {
        if let Err(error) = integrator.step() {
            return (states, Some(error));
        }
        states.push(integrator.state().to_vec());
    }
    (states, None)
}

/// One step of another length from the scene's initial state.
fn one_step(run: &ComposedRun, h: f64) -> Result<Vec<f64>, StepError> {
    let parameters = run.system.parameter_values();
    let (map, plan) = (run.method.map(), &run.plan);
    let mut integrator = Integrator::new(map, &parameters, plan.epsilon, h, &plan.initial);
    integrator.step()?;
    Ok(integrator.state().to_vec())
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, v| {
        if m.is_nan() || v.is_nan() {
            f64::NAN
        } else {
            m.max(v.abs())
        }
    })
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// Steps of the lengths h/200, 2h/200, … h, each by itself, do not jump as long as they are taken.
fn is_continuous_in_h(run: &ComposedRun, most: f64) {
    let mut last = run.plan.initial.clone();
    for k in 1..=200 {
        let h = run.plan.h * f64::from(k) / 200.0;
        match one_step(run, h) {
            Ok(state) => {
                let jump = distance(&state, &last);
                assert!(jump <= most, "at h = {h}: {last:?} to {state:?}");
                last = state;
            }
            // Beyond a fold there is nothing to compare with.
            Err(_) => return,
        }
    }
}

/// Species of a log-canonical tensor keep their signs, and ln C changes by round-off: what a sum of
/// x and its increment keeps of a species that falls to x' is round-off of x over x'. `noise` is how
/// well x can be met by any solution: α̂ and β̂ keep ln C from one to the other.
fn keeps_leaves(x: &[f64], next: &[f64], exponents: &[f64], noise: &[f64]) -> Result<(), String> {
    let signs = x.iter().zip(next).all(|(x, next)| x * next > 0.0);
    if !signs {
        return Err(format!("{x:?} to {next:?}: a sign changed"));
    }
    let terms = || exponents.iter().zip(x.iter().zip(next));
    let change: f64 = terms().map(|(c, (x, next))| c * libm::log(next / x)).sum();
    let part = |(c, (x, next)): (&f64, (&f64, &f64))| c.abs() * (x / next).abs().max(1.0);
    let met = terms()
        .zip(noise)
        .map(|((c, (x, _)), noise)| (c / x).abs() * noise);
    let bound: f64 = 64.0 * f64::EPSILON * terms().map(part).sum::<f64>() + met.sum::<f64>();
    if change.abs() <= bound {
        return Ok(());
    }
    Err(format!(
        "{x:?} to {next:?}: ln C moved by {change:e}, more than {bound:e}"
    ))
}

const LOG_CANONICAL: [(&str, &[f64]); 3] = [
    (
        r#"
[system]
variables = ["x1", "x2"]
bracket = { log-canonical = [[0, -1], [1, 0]] }
hamiltonian = "0.3*x1*x1 - 0.0558*x1*x2 + 0.013*x2*x2 + 0.169*x1 - 0.204*x2"
[method]
realization = "auto"
dynamics = { name = "hamilton-jacobi", order = 2 }
time-step = 6.40008774264553
[run]
initial = [0.525, 1.8696]
steps = 1
"#,
        &[0.0, 0.0],
    ),
    (
        r#"
[system]
variables = ["x1", "x2", "x3"]
bracket = { log-canonical = [[0, 2, -1], [-2, 0, 1], [1, -1, 0]] }
hamiltonian = "0.3293*x1*x1 + 0.2923*x1*x2 + 0.1364*x1*x3 + 0.2863*x2*x2 + 0.1337*x3*x3 - 0.451*x1 + 0.226*x2 + 0.009*x3"
[method]
realization = "auto"
dynamics = { name = "hamilton-jacobi", order = 4 }
time-step = 1.21
[run]
initial = [1.943, 1.678, 0.536]
steps = 1
"#,
        &[1.0, 1.0, 2.0],
    ),
    (
        r#"
[system]
variables = ["x1", "x2", "x3", "x4"]
bracket = { log-canonical = [[0, 2, 1, 1], [-2, 0, 1, -1], [-1, -1, 0, 1], [-1, 1, -1, 0]] }
hamiltonian = "0.2929*x1*x1 + 0.0089*x1*x3 - 0.0097*x1*x4 + 0.3734*x2*x2 - 0.3271*x2*x4 + 0.3991*x3*x3 - 0.5386*x3*x4 + 0.1985*x4*x4 + 0.402*x1 + 0.314*x2 + 0.39*x3 - 0.045*x4"
[method]
realization = "auto"
dynamics = { name = "hamilton-jacobi", order = 6 }
time-step = 0.2689697438059661
[run]
initial = [1.518, 1.395, 1.797, 0.886]
steps = 1
"#,
        &[0.0, 0.0, 0.0, 0.0],
    ),
];

/// Iterates that overflowed were taken for solutions: corrections were judged against their increments.
#[test]
fn an_iterate_far_off_is_no_solution() {
    for (text, exponents) in LOG_CANONICAL {
        let run = scene(text);
        let (states, _) = steps(&run);
        if let [x, next] = &states[..] {
            keeps_leaves(x, next, exponents, &[]).unwrap_or_else(|why| panic!("{why}\n{text}"));
            assert!(largest(next.iter().copied()) < 100.0, "{next:?}");
        }
    }
}

/// x⁴/4 + 0.666 y²z² + z² on so(3)*: the midpoint rule keeps |x|².
#[test]
fn an_overflowed_stage_is_no_solution() {
    let run = scene(
        r#"
[system]
variables = ["x", "y", "z"]
bracket = { lie-algebra = "so3" }
hamiltonian = "x^4/4 + 0.666*y^2*z^2 + z^2"
[method]
stepper = "implicit-midpoint"
time-step = 0.4
[run]
initial = [-1.11, 0.798, 1.412]
steps = 3
"#,
    );
    let (states, _) = steps(&run);
    let square = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    for state in &states {
        let drift = (square(state) / square(&states[0]) - 1.0).abs();
        assert!(drift <= 64.0 * f64::EPSILON, "{state:?}");
    }
}

/// The energy is kept on every branch; the state only on one.
#[test]
fn an_energy_preserving_step_does_not_jump_to_another_branch() {
    let run = scene(
        r#"
[system]
variables = ["x", "y", "z"]
bracket = { "x,y" = "-0.802*z - 0.488*x - 1.326*y", "y,z" = "1.542*x - 0.02*y - 0.488*z - 1.611*x^2", "z,x" = "-3.238*y - 0.02*x - 1.326*z" }
hamiltonian = "0.2895*x*x + 0.1549*x*y + 0.0858*y*y + 0.4574*y*z + 0.9279*z*z"
[method]
stepper = "energy-preserving"
time-step = 1.0901642301095895
[run]
initial = [0.8821, -0.4933, 1.2292]
steps = 1
"#,
    );
    // |ẋ| is about 5 there; near the fold, at 99 % of this step, the branch moves faster.
    is_continuous_in_h(&run, 0.3);
    let (states, error) = steps(&run);
    let is_refused = matches!(error, Some(StepError::OtherBranch { reached }) if reached > 0.9);
    assert!(is_refused, "{:?}, {error:?}", states.last());
}

/// A dying species stays positive, or its step is refused.
#[test]
fn no_species_turns_negative() {
    for realization in ["log-canonical", "karasev-collocated"] {
        let run = scene(&format!(
            r#"
[system]
variables = ["x1", "x2"]
bracket = {{ log-canonical = [[0, 1], [-1, 0]] }}
hamiltonian = "0.1438*x1*x1 + 0.6464*x2*x2 + 0.456*x1 - 0.375*x2"
[method]
realization = "{realization}"
dynamics = {{ name = "hamilton-jacobi", order = 6 }}
composition = "suzuki-umeno-8"
time-step = 1.447
[run]
initial = [1.678, 0.749]
steps = 20
"#
        ));
        let (states, _) = steps(&run);
        for state in &states {
            assert!(state.iter().all(|x| *x > 0.0), "{realization}: {state:?}");
        }
    }
}

/// q' + 2.25 sin q' = 3 has the roots 1.05, 3.255 and 5.1; the first is connected with q' = 3.
#[test]
fn a_pendulum_s_long_step_is_on_the_first_branch_or_refused() {
    let run = scene(
        r#"
[system]
variables = ["q", "p"]
bracket = { "q,p" = "-1" }
hamiltonian = "p^2/2 - cos(q)"
[method]
realization = "constant"
dynamics = { name = "hamilton-jacobi", order = 2 }
time-step = 3.0
[run]
initial = [3.0, 0.0]
steps = 1
"#,
    );
    match steps(&run) {
        (_, Some(StepError::OtherBranch { .. })) => {}
        (states, error) => {
            assert_eq!(error, None);
            let middle = 0.5 * (states[0][0] + states[1][0]);
            assert!((middle - 1.05).abs() < 0.01, "{states:?}");
        }
    }
}

/// V(q) as text, V' and V''.
type Potential = (&'static str, fn(f64) -> f64, fn(f64) -> f64);

const POTENTIALS: [Potential; 4] = [
    ("-cos(q)", libm::sin, libm::cos),
    ("q^4/4", |q| q * q * q, |q| 3.0 * q * q),
    (
        "(1 - exp(-q))^2",
        |q| 2.0 * (1.0 - libm::exp(-q)) * libm::exp(-q),
        |q| 2.0 * libm::exp(-q) * (2.0 * libm::exp(-q) - 1.0),
    ),
    (
        "exp(2*q)/4 - q/2",
        |q| 0.5 * libm::exp(2.0 * q) - 0.5,
        |q| libm::exp(2.0 * q),
    ),
];

/// The implicit midpoint rule of p²/2 + V(q): y of y + t²/4 V'(y) = q + t p/2, continued from t = 0;
/// and the smallest derivative of the left side on the way. `None` beyond a fold.
fn midpoint((_, force, slope): Potential, t: f64, q: f64, p: f64) -> Option<(f64, f64)> {
    const PARTS: i32 = 4000;
    let (mut y, mut least) = (q, 1.0_f64);
    for k in 1..=PARTS {
        let t = t * f64::from(k) / f64::from(PARTS);
        let a = 0.25 * t * t;
        for _ in 0..4 {
            let change = (q + 0.5 * t * p - y - a * force(y)) / (1.0 + a * slope(y));
            y += change;
            if change.abs() > 0.05 {
                return None;
            }
        }
        least = least.min(1.0 + a * slope(y));
        if least <= 1e-3 {
            return None;
        }
    }
    Some((y, least))
}

fn canonical(
    potential: Potential,
    method: &str,
    t: f64,
    (q, p): (f64, f64),
    steps: u32,
) -> ComposedRun {
    scene(&format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
         hamiltonian = \"p^2/2 + {}\"\n[method]\n{method}\ntime-step = {t:?}\n\
         [run]\ninitial = [{q:?}, {p:?}]\nsteps = {steps}\n",
        potential.0
    ))
}

const MIDPOINTS: [&str; 3] = [
    "realization = \"constant\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "stepper = \"implicit-midpoint\"",
    "realization = \"karasev-collocated\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
];

/// Near y = x the equation nearly holds by chance, or a turning force repeats itself where Newton's
/// method looks: the solutions there are not those continued from small steps.
#[test]
fn a_solution_met_by_chance_is_not_taken() {
    for (which, method, t, q, p) in [
        (
            0,
            0,
            4.561209956075494,
            1.5692060712516864,
            -0.475343586925032,
        ),
        (
            0,
            0,
            4.136538431559499,
            1.5578720864063615,
            -1.6746370122964314,
        ),
        (
            0,
            0,
            4.561209956075494,
            -0.8221159355304236,
            1.4014150460178847,
        ),
        (
            0,
            1,
            4.545881167050726,
            -0.7095563382992329,
            -1.4767927331839221,
        ),
        (0, 2, 4.901374931685486, -1.3173875829614743, 0.0),
        (
            2,
            0,
            4.639098333783533,
            0.7797321911746335,
            1.1424003525513735,
        ),
    ] {
        let potential = POTENTIALS[which];
        let run = canonical(potential, MIDPOINTS[method], t, (q, p), 40);
        let mut integrator = run.integrator();
        let mut compared = 0;
        for _ in 0..40 {
            let before = integrator.state().to_vec();
            if integrator.step().is_err() {
                break;
            }
            let y = 0.5 * (before[0] + integrator.state()[0]);
            if let Some((expected, _)) = midpoint(potential, t, before[0], before[1]) {
                let error = (y - expected).abs();
                assert!(
                    error <= 1e-6 * (1.0 + y.abs()),
                    "{before:?}: {y} for {expected}"
                );
                compared += 1;
            }
        }
        assert!(
            compared > 0 || method == 2,
            "{which} {method}: nothing was taken"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    /// Whatever is taken is the continued solution, to round-off over its distance from a fold;
    /// where that is plain it is taken.
    #[test]
    fn midpoint_steps_are_those_continued_from_small_ones(
        (which, q, p) in (0..4_usize, -2.0..2.0_f64, -2.0..2.0_f64),
        (t, method) in (0.3..5.0_f64, 0..3_usize),
    ) {
        let potential = POTENTIALS[which];
        let run = canonical(potential, MIDPOINTS[method], t, (q, p), 1);
        let expected = midpoint(potential, t, q, p);
        let taken = one_step(&run, run.plan.h);
        if let Ok(next) = &taken {
            // The equation, and where it is not continued from small t (a fold lies between, or t is
            // far beyond 2 over the frequency), a branch without a fold at this t.
            let y = 0.5 * (q + next[0]);
            let stiffness = 0.25 * t * t;
            let equation = y + stiffness * potential.1(y) - q - 0.5 * t * p;
            let size = 1.0 + y.abs() + (stiffness * potential.1(y)).abs() + stiffness * potential.2(y).abs() * y.abs();
            // An iteration without Jacobians ends where corrections of 64 ulps no longer shrink.
            let reached = q.abs() + y.abs() + t * (p.abs() + next[1].abs());
            let stalled = (1.0 + stiffness * potential.2(y).abs()) * reached;
            let ulps = if method == 2 { 64.0 } else { 0.0 };
            let bound = 1e-13 * size + ulps * f64::EPSILON * stalled;
            prop_assert!(equation.abs() <= bound, "{next:?} leaves {equation:e}");
            let momentum = p - t * potential.1(y);
            prop_assert!((next[1] - momentum).abs() <= 1e-13 * size * (1.0 + t), "{next:?}, {momentum}");
            let is_continued = expected.is_some_and(|(other, _)| (y - other).abs() <= 1e-6 * size);
            let slope = |k: i32| 1.0 + stiffness * potential.2(q + (y - q) * f64::from(k) / 1000.0);
            let has_no_fold = (0..=1000).all(|k| slope(k) > 0.0);
            prop_assert!(is_continued || has_no_fold, "{next:?} for {expected:?}");
        }
        match (taken, expected) {
            (Ok(_), _) => {}
            (Err(error), Some((_, least))) => {
                // Iterations without Jacobians converge for shorter steps only.
                let is_far = method == 2 && t > 1.0;
                prop_assert!(least < 0.3 || is_far || t > 2.0, "{error}, least {least}");
            }
            (Err(_), None) => {}
        }
    }

    /// A step does not depend on the steps before it by more than round-off.
    #[test]
    fn a_step_does_not_depend_on_its_history(
        (which, q, p) in (0..4_usize, -1.5..1.5_f64, -1.5..1.5_f64),
        (t, method) in (0.3..5.0_f64, 0..2_usize),
    ) {
        let run = canonical(POTENTIALS[which], MIDPOINTS[method], t, (q, p), 40);
        let mut integrator = run.integrator();
        for _ in 0..40 {
            let before = integrator.checkpoint();
            let went_on = integrator.step().map(|()| integrator.state().to_vec());
            let mut fresh = run.integrator();
            let mut cold = fresh.checkpoint();
            (cold.state, cold.compensation) = (before.state.clone(), before.compensation);
            fresh.restore(&cold).expect("the same method");
            let began = fresh.step().map(|()| fresh.state().to_vec());
            match (went_on, began) {
                (Ok(a), Ok(b)) => {
                    let size = largest(a.iter().chain(&before.state).copied());
                    prop_assert!(distance(&a, &b) <= 1e-9 * (1.0 + size), "{a:?} or {b:?}");
                }
                (Ok(a), Err(error)) => prop_assert!(false, "{a:?} or {error}"),
                (Err(_), _) => break,
            }
        }
    }

    /// One step of a log-canonical system, from tame to extreme: signs, Casimirs and the equation
    /// itself, by an evaluation of its own.
    #[test]
    fn log_canonical_steps_keep_signs_and_casimirs_or_are_refused(
        entries in vec(-2..=2_i32, 3),
        coefficients in vec(-60..=60_i32, 9),
        x in vec(0.3..2.0_f64, 3),
        (order, rate) in (1..=3_i32, 0.3..6.0_f64),
    ) {
        let [a, b, c] = [entries[0], entries[1], entries[2]];
        let pairs = [(1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)];
        let mut terms: Vec<String> = pairs
            .iter()
            .zip(&coefficients)
            .map(|((i, j), k)| format!("({k})/100*x{i}*x{j}"))
            .collect();
        terms.extend((1..=3).map(|i| format!("({})/100*x{i}", coefficients[5 + i])));
        let hamiltonian = terms.join(" + ");
        let gradient: Vec<f64> = (1..=3)
            .map(|i| {
                let of_pairs = pairs.iter().zip(&coefficients).map(|((k, l), factor)| {
                    let mut slope = 0.0;
                    if *k == i {
                        slope += x[l - 1];
                    }
                    if *l == i {
                        slope += x[k - 1];
                    }
                    f64::from(*factor) / 100.0 * slope
                });
                of_pairs.sum::<f64>() + f64::from(coefficients[5 + i]) / 100.0
            })
            .collect();
        let matrix = [[0, a, b], [-a, 0, c], [-b, -c, 0]];
        let speed = largest(matrix.iter().map(|row| {
            let terms = row.iter().zip(&x).zip(&gradient);
            terms.map(|((m, x), g)| f64::from(*m) * x * g).sum::<f64>()
        }));
        prop_assume!(speed > 1e-3);
        let h = rate / speed;
        let run = scene(&format!(
            "[system]\nvariables = [\"x1\", \"x2\", \"x3\"]\nbracket = {{ log-canonical = {matrix:?} }}\n\
             hamiltonian = \"{hamiltonian}\"\n[method]\nrealization = \"log-canonical\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = {} }}\ntime-step = {h:?}\n\
             [run]\ninitial = {x:?}\nsteps = 1\n",
            2 * order
        ));
        let method = run.method.written().expect("a method");
        let parameters = run.system.parameter_values();
        let mut stepper = leafwise::core::StepMap::stepper(method, 1, &parameters, run.plan.epsilon, run.plan.h);
        let (mut increment, mut outcome) = (vec![0.0; 3], [Ok(())]);
        stepper.increment(&x, &[0.0; 3], &mut increment, &mut outcome);
        if outcome[0].is_ok() {
            let next: Vec<f64> = x.iter().zip(&increment).map(|(x, i)| x + i).collect();
            let casimir = [f64::from(c), -f64::from(b), f64::from(a)];
            let y = stepper.solution(0).expect("a solution");
            let mut workers = method.workers(&parameters, run.plan.epsilon, run.plan.h).expect("workers");
            // β̂(L(y)) at y with so many ulps added to each component.
            let mut target = |ulps: f64| -> Vec<f64> {
                let y: Vec<f64> = y.iter().map(|y| y * (1.0 + ulps * f64::EPSILON)).collect();
                let mut z = vec![0.0; 6];
                workers.points.point(&y, &mut z).expect("a point");
                let mut ends = leafwise::core::Ends::new(3);
                workers.maps.ends(&z, &mut ends).expect("ends");
                (0..3).map(|i| ends.base[i] + ends.offset[i]).collect()
            };
            let found = target(0.0);
            let near = [-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0].map(&mut target);
            let noise: Vec<f64> = (0..3)
                .map(|i| largest(near.iter().map(|other| other[i] - found[i])))
                .collect();
            let kept = keeps_leaves(&x, &next, &casimir, &noise);
            prop_assert!(kept.is_ok(), "{}", kept.unwrap_err());
            let away = distance(&found, &x);
            let size = largest(x.iter().chain(&y).copied());
            prop_assert!(away <= 64.0 * (f64::EPSILON * size + largest(noise)), "{away:e}");
        }
    }
}

/// Small first corrections, a constant observed where the field is nearly linear, then a wall: the
/// increments are those of the equation solved by itself, to round-off.
#[test]
fn a_wall_after_a_quiet_stretch_is_solved_to_round_off() {
    for (quartic, width, t) in [
        (1e-10, 0.2, 0.03),
        (3e-11, 0.2, 0.05),
        (1e-10, 0.4, 0.02),
        (1e-9, 0.2, 0.03),
        (1e-10, 0.1, 0.01),
    ] {
        let run = scene(&format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
             hamiltonian = \"p^2/2 + {quartic:?}*q^4/4 + exp(-q/{width:?})\"\n[method]\n\
             realization = \"constant\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\n\
             time-step = {t:?}\n[run]\ninitial = [8.0, -1.0]\nsteps = 1\n"
        ));
        let force = |q: f64| quartic * q * q * q - libm::exp(-q / width) / width;
        let slope = |q: f64| 3.0 * quartic * q * q + libm::exp(-q / width) / (width * width);
        let mut integrator = run.integrator();
        let (mut worst, mut turned) = (0.0_f64, false);
        for _ in 0..(16.0 / t) as usize {
            let (x, low) = (
                integrator.state().to_vec(),
                integrator.compensation().to_vec(),
            );
            integrator.step().expect("a step");
            // d = y − q of d + t²/4 V'(q + d) = t p/2.
            let p = x[1] + low[1];
            let mut d = 0.5 * t * p;
            for _ in 0..60 {
                let y = (x[0] + d) + low[0];
                d += (0.5 * t * p - d - 0.25 * t * t * force(y)) / (1.0 + 0.25 * t * t * slope(y));
            }
            let exact = [2.0 * d, -t * force((x[0] + d) + low[0])];
            for i in 0..2 {
                let (next, rest) = (integrator.state()[i], integrator.compensation()[i]);
                let moved = (next - x[i]) + (rest - low[i]);
                let scale = x[i].abs() + exact[i].abs();
                // Both sides round the argument of V', magnified by V'', and the increment.
                let noise = exact[i].abs() + t * slope(x[0] + d) * x[0].abs();
                let error = (moved - exact[i]).abs() - 4.0 * f64::EPSILON * noise;
                worst = worst.max(error / scale);
            }
            turned |= integrator.state()[1] > 0.5;
        }
        assert!(turned, "it meets the wall");
        assert!(
            worst <= 0.25 * f64::EPSILON,
            "{quartic:e} {width} {t}: {worst:e}"
        );
    }
}

/// Collective integrators over realizations of low order: the stages of a component that is the
/// round-off of larger ones never settle by themselves.
#[test]
fn collective_steps_of_three_waves_converge_at_every_small_step() {
    for (realization, integrator) in [
        (
            "{ name = \"karasev-collocated\", points = 2 }",
            "stormer-verlet",
        ),
        (
            "{ name = \"karasev-collocated\", points = 1 }",
            "stormer-verlet",
        ),
        ("{ name = \"karasev-truncated\", order = 1 }", "gauss"),
        ("{ name = \"karasev-truncated\", order = 2 }", "gauss"),
    ] {
        for t in [
            0.15, 0.11, 0.1, 0.09, 0.05, 0.03, 0.025, 0.0125, 0.01, 0.003,
        ] {
            for initial in [
                [0.375, 0.5, 0.625, 0.625, 1.0],
                [0.4, 0.31, 0.52, 0.77, 0.9],
                [0.51, -0.43, 0.7, 0.35, 1.3],
            ] {
                let run = scene(&format!(
                    "[system]\nlibrary = \"three-wave\"\n[method]\nrealization = {realization}\n\
                     dynamics = {{ name = \"collective\", integrator = \"{integrator}\" }}\n\
                     time-step = {t:?}\n[run]\ninitial = {initial:?}\nsteps = 10\n"
                ));
                let (states, error) = steps(&run);
                assert_eq!(
                    error,
                    None,
                    "{realization} + {integrator}, t = {t}, {initial:?}, step {}",
                    states.len()
                );
            }
        }
    }
}
