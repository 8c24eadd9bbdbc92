//! Hamiltonians that name the time: exactly Poisson maps of the declared order on the phase space extended by the time and
//! its energy, of which the scene sees its own coordinates.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::scene::ComposedRun;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::orders::measure;
use leafwise_tests::scenes::{end, until};

/// x″ = −x − 0.1 cos t under the literature's convention.
const OSCILLATOR: &str = "variables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
                          hamiltonian = \"p^2/2 + q^2/2 + 0.1*q*cos(t)\"";

/// A spin in a constant field along z and one that turns about it: x′ = b(t) × x.
const SPIN: &str = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\nparameters = { w = 1.7 }\n\
                    hamiltonian = \"z + 0.4*(x*cos(w*t) + y*sin(w*t))\"\n\
                    casimirs = { spin = \"x^2 + y^2 + z^2\" }";

fn scene(system: &str, method: &str, initial: &[f64], time: f64, steps: usize) -> ComposedRun {
    until(system, method, &format!("{initial:?}"), (time, steps))
}

/// x = A cos t + B sin t − t sin(t)/20 from (A, B), which may be (0, 0): every coordinate then begins at 0, the time's as well.
fn oscillator_at(t: f64, [a, b]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = (libm::sin(t), libm::cos(t));
    let x = a * cos + b * sin - t * sin / 20.0;
    let v = -a * sin + b * cos - sin / 20.0 - t * cos / 20.0;
    [x, v]
}

/// In the frame that turns with the field, y′ = (0.4, 0, 1 − w) × y: a rotation about a fixed axis (I. I. Rabi,
/// Physical Review 51, 652 (1937)).
fn spin_at(t: f64, x: [f64; 3]) -> [f64; 3] {
    let w = 1.7;
    let axis = [0.4, 0.0, 1.0 - w];
    let rate = libm::sqrt(axis.iter().map(|a| a * a).sum());
    let n = axis.map(|a| a / rate);
    let (sin, cos) = (libm::sin(rate * t), libm::cos(rate * t));
    let along: f64 = n.iter().zip(&x).map(|(n, x)| n * x).sum();
    let cross = [
        n[1] * x[2] - n[2] * x[1],
        n[2] * x[0] - n[0] * x[2],
        n[0] * x[1] - n[1] * x[0],
    ];
    let y: Vec<f64> = (0..3)
        .map(|i| x[i] * cos + cross[i] * sin + n[i] * along * (1.0 - cos))
        .collect();
    let (sin, cos) = (libm::sin(w * t), libm::cos(w * t));
    [y[0] * cos - y[1] * sin, y[0] * sin + y[1] * cos, y[2]]
}

fn assert_order(
    name: &str,
    (system, method): (&str, &str),
    (initial, exact): (&[f64], &[f64]),
    time: f64,
    (order, steps): (f64, &[usize]),
) {
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&steps| {
            let run = scene(system, method, initial, time, steps);
            (time / steps as f64, distance(&end(&run), exact))
        })
        .collect();
    // Rounding of hundreds of compensated steps, and of the closed form.
    let round_off = 32.0 * UNIT_ROUNDOFF * largest(exact);
    let found = measure(&points, round_off, 2.0)
        .unwrap_or_else(|| panic!("{name}: too few errors above round-off: {points:?}"));
    println!("{name} {method}: {found}");
    assert!(
        found.is(order, 2.0),
        "{name} {method}: {found}, not {order}"
    );
}

fn hamilton_jacobi(order: usize) -> String {
    format!("dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}")
}

#[test]
fn a_driven_oscillator_has_the_declared_orders_against_its_closed_form() {
    let time = 10.0;
    let cases = [
        (2, [80, 113, 160, 226, 320]),
        (4, [40, 57, 80, 113, 160]),
        (6, [28, 40, 57, 80, 113]),
        (8, [20, 28, 40, 57, 80]),
    ];
    for initial in [[1.0, 0.5], [0.0, 0.0]] {
        let exact = oscillator_at(time, initial);
        let name = format!("driven oscillator from {initial:?}");
        let ends = (&initial[..], &exact[..]);
        for (order, steps) in cases {
            let method = hamilton_jacobi(order);
            let of = (OSCILLATOR, method.as_str());
            assert_order(&name, of, ends, time, (order as f64, &steps));
        }
        for method in [
            "stepper = \"splitting\"",
            "stepper = \"implicit-midpoint\"",
            "dynamics = \"collective\"",
        ] {
            let (order, steps) = match method.contains("collective") {
                true => (4.0, [40, 57, 80, 113, 160]),
                false => (2.0, [80, 113, 160, 226, 320]),
            };
            assert_order(&name, (OSCILLATOR, method), ends, time, (order, &steps));
        }
    }
}

/// −e = ∫ ∂H/∂t dt begins with the fourth power of t: a series about 0 knows no size of it in its first terms.
#[test]
fn a_series_may_begin_at_zero() {
    let time = 10.0;
    let exact = oscillator_at(time, [0.0, 0.0]);
    for (tolerance, most) in [(1e-8, 1e-8), (1e-15, 256.0 * UNIT_ROUNDOFF)] {
        let method = format!("stepper = {{ name = \"taylor\", tolerance = {tolerance:e} }}");
        let run = scene(OSCILLATOR, &method, &[0.0, 0.0], time, 100);
        let error = distance(&end(&run), &exact) / largest(exact);
        println!("taylor {tolerance:e}: {error:.1e}");
        assert!(error <= most, "{tolerance:e}: {error:e}");
    }
}

#[test]
fn a_spin_in_a_turning_field_has_them_against_rabis() {
    let (initial, time) = ([0.6, 0.0, 0.8], 8.0);
    let exact = spin_at(time, initial);
    let cases = [
        (2, [80, 113, 160, 226, 320]),
        (4, [40, 57, 80, 113, 160]),
        (6, [28, 40, 57, 80, 113]),
    ];
    for (order, steps) in cases {
        let method = hamilton_jacobi(order);
        let of = (SPIN, method.as_str());
        assert_order("spin", of, (&initial, &exact), time, (order as f64, &steps));
    }
}

/// H + e = H − ∫ ∂H/∂t dt: with H and the integral from the closed form, ∂H/∂t = −0.1 q sin t by Simpson's rule over 4000
/// intervals, whose error is below 1e-12 here.
#[test]
fn the_reported_energy_is_the_balance_of_the_closed_form() {
    let (initial, time) = ([1.0, 0.5], 10.0);
    let h = |t: f64| {
        let [q, p] = oscillator_at(t, initial);
        p * p / 2.0 + q * q / 2.0 + 0.1 * q * libm::cos(t)
    };
    let power = |t: f64| -0.1 * oscillator_at(t, initial)[0] * libm::sin(t);
    let intervals = 4000;
    let width = time / f64::from(intervals);
    let weight = |k: i32| match k {
        0 => 1.0,
        k if k == intervals => 1.0,
        k => f64::from(2 + 2 * (k % 2)),
    };
    let work: f64 = (0..=intervals)
        .map(|k| weight(k) * power(f64::from(k) * width) * width / 3.0)
        .sum();
    let run = scene(OSCILLATOR, &hamilton_jacobi(8), &initial, time, 400);
    let mut observer = run.invariants().expect("code");
    let mut walk = run.walk();
    let mut balance = [0.0; 1];
    observer.evaluate(walk.state(), &mut balance);
    assert!((balance[0] - h(0.0)).abs() <= 4.0 * UNIT_ROUNDOFF);
    walk.advance(run.plan.steps).expect("every step");
    observer.evaluate(walk.state(), &mut balance);
    // H itself has moved by far more than the balance.
    assert!((h(time) - h(0.0)).abs() > 0.1, "{} {}", h(time), h(0.0));
    assert!(
        (balance[0] - (h(time) - work)).abs() < 1e-11,
        "{}",
        balance[0]
    );
}

#[test]
fn auto_keeps_the_exact_realization_of_the_scenes_own_tensor() {
    let log_canonical = "variables = [\"x\", \"y\"]\nbracket = { \"x,y\" = \"x*y\" }\n\
                         hamiltonian = \"x + y - ln(x) - ln(y) + x*sin(t)/8\"";
    for (system, initial, expected) in [
        (OSCILLATOR, vec![1.0, 0.5], "constant"),
        (
            SPIN,
            vec![0.6, 0.0, 0.8],
            "direct-sum of so3-exponential and constant",
        ),
        (
            log_canonical,
            vec![1.2, 0.7],
            "direct-sum of log-canonical and constant",
        ),
    ] {
        let run = scene(system, &hamilton_jacobi(4), &initial, 1.0, 10);
        let realization = run.method.written().expect("a method").realization();
        assert_eq!(realization.describe(), expected);
        assert_eq!(run.names().len(), initial.len());
        assert_eq!(run.dimension(), initial.len() + 2);
    }
}

/// The time itself is exact: each step adds ε·h in compensated arithmetic.
#[test]
fn the_time_of_the_state_is_that_of_the_steps() {
    let run = scene(SPIN, &hamilton_jacobi(4), &[0.6, 0.0, 0.8], 100.0, 1000);
    let mut walk = run.walk();
    for _ in 0..run.plan.steps {
        walk.step().expect("a step");
        let t = walk.state()[3];
        assert!((t - walk.time()).abs() <= 2.0 * f64::EPSILON * t, "{t:?}");
    }
}

/// A charge in the plane and a uniform field B(t), which comes with an electric one: by the one-form (v + A)·dx, by canonical
/// momenta p = v + A, A = B/2 (−y, x), and with the definition that both use.
#[test]
fn a_one_form_that_names_the_time_moves_by_its_change() {
    let define = "define = { half = \"(1 + 0.2*t)/2\" }\nconvention = \"{x,H}\"";
    let form = format!(
        "variables = [\"x\", \"y\", \"vx\", \"vy\"]\n{define}\n\
         bracket = {{ one-form = [\"vx - half*y\", \"vy + half*x\", 0, 0] }}\nhamiltonian = \"(vx^2 + vy^2)/2\""
    );
    let canonical = format!(
        "variables = [\"x\", \"y\", \"px\", \"py\"]\n{define}\nbracket = {{ \"x,px\" = 1, \"y,py\" = 1 }}\n\
         hamiltonian = \"((px + half*y)^2 + (py - half*x)^2)/2\""
    );
    let time = 5.0;
    let [x, y, vx, vy] = [0.3, -0.2, 0.7, 1.1];
    let ends = |order: usize, steps: usize| {
        let method = hamilton_jacobi(order);
        let form = end(&scene(&form, &method, &[x, y, vx, vy], time, steps));
        let start = [x, y, vx - 0.5 * y, vy + 0.5 * x];
        let mut canonical = end(&scene(&canonical, &method, &start, time, steps));
        let half = (1.0 + 0.2 * time) / 2.0;
        canonical[2] += half * canonical[1];
        canonical[3] -= half * canonical[0];
        (form, canonical)
    };
    let (_, exact) = ends(8, 400);
    let points: Vec<(f64, f64)> = [25, 35, 50, 71, 100]
        .map(|steps| (time / steps as f64, distance(&ends(4, steps).0, &exact)))
        .to_vec();
    let found = measure(&points, 1e-12, 2.0).expect("errors above round-off");
    assert!(found.is(4.0, 2.0), "{found}");
    let (form, _) = ends(8, 400);
    // Of two maps of order 8 with errors of (1/80)⁸, and round-off of hundreds of steps.
    let error = distance(&form, &exact);
    assert!(error <= 1e-12, "{error:e}");
}
