//! Derivatives of steps in loops.

use leafwise::core::gradient::{Plan, Trajectory, Way};
use leafwise::scene::ComposedRun;
use leafwise_tests::scenes::composed;

use super::{glass, gravity, in_loops};

fn trajectory<'a>(run: &'a ComposedRun, parameters: &'a [f64]) -> Trajectory<'a> {
    Trajectory {
        map: run.method.map(),
        parameters,
        epsilon: run.plan.epsilon,
        h: run.plan.h,
        goes_on: &|| true,
    }
}

const PLAN: Plan = Plan {
    steps: 20,
    every: 10,
};

/// The gradient of a function of the samples, by either way, and the tangent of a direction.
fn derivatives(run: &ComposedRun) -> [Vec<f64>; 3] {
    let parameters = run.system.parameter_values();
    let (at, initial) = (trajectory(run, &parameters), &run.plan.initial);
    let reached = at.run(initial, PLAN).expect("a run");
    let cotangents: Vec<f64> = (0..reached.samples.len())
        .map(|i| libm::sin(1.0 + 0.7 * i as f64))
        .collect();
    let [back, again] = [Way::Back, Way::Checkpoints].map(|way| {
        let pulled = at.pull(initial, &reached, &cotangents, PLAN, (false, Some(way)));
        pulled.expect("a gradient").initial
    });
    let direction: Vec<f64> = (0..initial.len())
        .map(|i| libm::cos(0.3 * i as f64))
        .collect();
    let pushed = at.push(initial, (&direction, &[]), PLAN);
    let tangents = pushed.expect("tangents").tangents;
    let sides = [(&cotangents, &tangents), (&back, &direction)].map(|(a, b)| {
        let products = a.iter().zip(b).map(|(a, b)| a * b);
        products.sum::<f64>()
    });
    assert!(
        (sides[0] - sides[1]).abs() <= 1e-11 * (1.0 + sides[0].abs()),
        "{sides:?}"
    );
    [back, again, tangents]
}

/// Derivatives of runs in loops are those of the system written out: of twenty steps of a splitting and its compositions,
/// each flow x + tX(x) by products with the Hessian, which are loops too.
#[test]
fn derivatives_in_loops_are_those_of_the_system_written_out() {
    for composition in [
        "",
        "composition = \"suzuki-4\"",
        "composition = \"kahan-li-6\"",
    ] {
        let method = format!("stepper = \"splitting\"\n{composition}");
        let [loops, written] = [false, true].map(|is_written| {
            let run = composed(&glass(20, &method, is_written));
            assert_eq!(run.system.opaque().is_some(), !is_written);
            derivatives(&run)
        });
        for (found, expected) in loops.iter().zip(&written) {
            let size = expected.iter().fold(1.0, |size: f64, v| size.max(v.abs()));
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 1e-12 * size,
                    "{composition}: {found} {expected}"
                );
            }
        }
    }
}

/// Masses of bodies stand behind the coordinates: the gradient by them, through the tensor 1/m too, is that of differences of
/// order 6 of whole runs. So it is where H is no sum of pairs but a function of such sums.
#[test]
fn derivatives_by_parameters_of_sites_are_those_of_differences() {
    let method = "stepper = \"splitting\"\ncomposition = \"suzuki-4\"";
    let functions = gravity(17, method).replace(
        "- sum(i<j",
        "+ sum(i, m[i]*cos(x[i] + y[i]))^2 - sqrt(1 + sum(i, m[i]*z[i]^2)) - sum(i<j",
    );
    for text in [gravity(17, method), functions] {
        let run = in_loops(&text);
        let [gradient, ..] = derivatives(&run);
        let parameters = run.system.parameter_values();
        let at = trajectory(&run, &parameters);
        let value = |initial: &[f64]| -> f64 {
            let reached = at.run(initial, PLAN).expect("a run");
            let samples = reached.samples.iter().enumerate();
            samples
                .map(|(i, x)| x * libm::sin(1.0 + 0.7 * i as f64))
                .sum()
        };
        let initial = &run.plan.initial;
        for k in [0, 20, 60, 6 * 17, 6 * 17 + 9] {
            let slope = |delta: f64| {
                let [above, below] = [delta, -delta].map(|delta| {
                    let mut point = initial.clone();
                    point[k] += delta;
                    (value(&point), point[k])
                });
                (above.0 - below.0) / (above.1 - below.1)
            };
            let delta = 1e-3 * initial[k].abs().max(0.05);
            let expected =
                (64.0 * slope(delta) - 20.0 * slope(2.0 * delta) + slope(4.0 * delta)) / 45.0;
            let allowed = 1e-8 * (1.0 + expected.abs());
            assert!(
                (gradient[k] - expected).abs() <= allowed,
                "{k}: {} {expected}",
                gradient[k]
            );
        }
    }
}
