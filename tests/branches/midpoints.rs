//! The implicit midpoint rule of p²/2 + V(q), against solutions continued from small steps.

use super::*;

/// q' + 2.25 sin q' = 3 has the roots 1.05, 3.255 and 5.1; the first is connected with q' = 3.
#[test]
fn a_pendulum_s_long_step_is_on_the_first_branch_or_refused() {
    let run = composed(
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
pub(super) type Potential = (&'static str, fn(f64) -> f64, fn(f64) -> f64);

pub(super) const POTENTIALS: [Potential; 4] = [
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
pub(super) fn midpoint((_, force, slope): Potential, t: f64, q: f64, p: f64) -> Option<(f64, f64)> {
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

pub(super) fn canonical(
    potential: Potential,
    method: &str,
    t: f64,
    (q, p): (f64, f64),
    steps: u32,
) -> ComposedRun {
    composed(&format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
         hamiltonian = \"p^2/2 + {}\"\n[method]\n{method}\ntime-step = {t:?}\n\
         [run]\ninitial = [{q:?}, {p:?}]\nsteps = {steps}\n",
        potential.0
    ))
}

pub(super) const MIDPOINTS: [&str; 3] = [
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
        let mut integrator = run.walk();
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
        let run = composed(&format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
             hamiltonian = \"p^2/2 + {quartic:?}*q^4/4 + exp(-q/{width:?})\"\n[method]\n\
             realization = \"constant\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\n\
             time-step = {t:?}\n[run]\ninitial = [8.0, -1.0]\nsteps = 1\n"
        ));
        let force = |q: f64| quartic * q * q * q - libm::exp(-q / width) / width;
        let slope = |q: f64| 3.0 * quartic * q * q + libm::exp(-q / width) / (width * width);
        let mut integrator = run.walk();
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
