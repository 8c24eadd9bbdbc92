//! Contact systems: order, the contact form, damping and drives against closed forms and other formulations, relaxation of a gas.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::diagnostics::TensorDefect;
use leafwise::core::{Registry, Structure};
use leafwise::scene::{SceneDocument, compose};
use leafwise_tests::scenes::{composed, end, until};

const OSCILLATOR: &str = "variables = [\"q\", \"p\", \"s\"]\nbracket = \"contact\"\nhamiltonian = \"p^2/2 + q^2/2 + 0.2*s\"";

fn hamilton_jacobi(order: usize) -> String {
    format!("realization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}")
}

/// q of q″ + 0.2 q′ + q = 0 from q = 1, q′ = 0.
fn damped(t: f64) -> f64 {
    let omega = libm::sqrt(0.99);
    libm::exp(-0.1 * t) * (libm::cos(omega * t) + 0.1 / omega * libm::sin(omega * t))
}

/// Errors fall by 2ᵐ when the step is halved, to a third of an order beside terms of the next even one. The numbers are those of
/// another program, with the homogeneous system written out.
#[test]
fn the_damped_oscillator_has_the_order_of_its_parts() {
    let known = [
        (2, [1.8e-3, 4.5e-4, 1.1e-4]),
        (4, [1.9e-6, 1.2e-7, 7.6e-9]),
        (6, [2.2e-9, 3.4e-11, 5.3e-13]),
    ];
    for (order, known) in known {
        let errors = [200, 400, 800].map(|steps| {
            let run = until(
                OSCILLATOR,
                &hamilton_jacobi(order),
                "[1, 0, 0]",
                (20.0, steps),
            );
            let properties = run.method.map().properties();
            assert_eq!(properties.structure, Structure::Contact);
            assert_eq!(properties.order, order);
            (end(&run)[0] - damped(20.0)).abs()
        });
        println!("order {order}: {errors:?}");
        for (error, known) in errors.iter().zip(known) {
            assert!((0.9..1.1).contains(&(error / known)), "{error:e} {known:e}");
        }
        for halved in errors.windows(2) {
            let slope = libm::log2(halved[0] / halved[1]);
            assert!((slope - order as f64).abs() < 0.3, "{order}: {slope}");
        }
    }
}

/// DΦᵀ(ds − p·dq) at x_1 is a multiple of ds − p·dq at x_0, for an H that is not quadratic and names s in a product.
#[test]
fn a_step_multiplies_the_contact_form() {
    let system = "variables = [\"q1\", \"q2\", \"p1\", \"p2\", \"s\"]\nbracket = \"contact\"\n\
        hamiltonian = \"p1^2/2 + p2^2/2 - cos(q1 - q2) + 0.3*s*p1 + 0.1*s^2 + q1^4/4\"";
    for (method, h) in [
        (hamilton_jacobi(2), 0.2),
        (hamilton_jacobi(4), 0.2),
        (hamilton_jacobi(6), 0.1),
        ("stepper = \"implicit-midpoint\"".to_owned(), 0.2),
        ("stepper = { name = \"gauss\", stages = 3 }".to_owned(), 0.2),
    ] {
        let run = until(system, &method, "[0.4, -0.3, 0.5, 0.7, 0.2]", (h, 1));
        let map = run.method.map();
        assert_eq!(map.properties().structure, Structure::Contact, "{method}");
        let parameters = run.system.parameter_values();
        let mut differential = map.differential(&parameters, run.plan.epsilon, run.plan.h);
        let x = &run.plan.initial;
        let mut increment = vec![0.0; x.len()];
        differential
            .step(x, &vec![0.0; x.len()], &mut increment)
            .expect("a step");
        let form = |x: &[f64]| vec![-x[2], -x[3], 0.0, 0.0, 1.0, 0.0];
        let there: Vec<f64> = x.iter().zip(&increment).map(|(x, dx)| x + dx).collect();
        assert_eq!(there[5], 1.0, "r");
        let mut pulled = form(&there);
        differential.pull(&mut pulled, &mut []).expect("a tangent");
        let factor = pulled[4];
        let defects = pulled
            .iter()
            .zip(form(x))
            .map(|(own, form)| (own - factor * form).abs());
        let defect = defects.fold(0.0, f64::max);
        println!("{method}: factor {factor}, defect {defect:.1e}");
        assert!(defect <= 8.0 * f64::EPSILON, "{defect:e}");
        assert!((factor - 1.0).abs() > 1e-3, "H names s");
        // And its inverse carries covectors back.
        let mut forth = pulled.clone();
        differential
            .pull_inverse(&mut forth, &mut [])
            .expect("a tangent");
        let back = forth.iter().zip(form(&there)).map(|(a, b)| (a - b).abs());
        assert!(back.fold(0.0, f64::max) <= 64.0 * f64::EPSILON);
    }
}

/// The tangents of a step are those of differences.
#[test]
fn tangents_are_those_of_the_contact_map() {
    let run = until(OSCILLATOR, &hamilton_jacobi(4), "[0.4, 0.7, 0.2]", (0.3, 1));
    let map = run.method.map();
    let parameters = run.system.parameter_values();
    let step = |x: &[f64]| {
        let mut walk = leafwise::core::Walk::new(map, &parameters, 1.0, 0.3, x);
        walk.step().expect("a step");
        (walk.state().to_vec(), walk.tangent(0).expect("tangents"))
    };
    let x = &run.plan.initial;
    let (_, matrix) = step(x);
    let delta = 1e-6;
    for j in 0..3 {
        let [ahead, behind] = [delta, -delta].map(|delta| {
            let mut x = x.clone();
            x[j] += delta;
            step(&x).0
        });
        for i in 0..3 {
            let slope = (ahead[i] - behind[i]) / (2.0 * delta);
            assert!((slope - matrix[4 * i + j]).abs() < 1e-9, "{i} {j}");
        }
    }
}

/// A driven Duffing oscillator against the same equations as a canonical system with a force.
#[test]
fn drives_and_friction_as_by_forces() {
    let contact = "variables = [\"q\", \"p\", \"s\"]\nbracket = \"contact\"\n\
        hamiltonian = \"p^2/2 - q^2/2 + q^4/4 + 0.2*s - 0.3*q*cos(1.2*t)\"";
    let forced = "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - q^2/2 + q^4/4\"\n\
        forces = [\"0.2*p - 0.3*cos(1.2*t)\", \"0\"]";
    let run = until(contact, &hamilton_jacobi(6), "[1, 0.2, 0]", (20.0, 1000));
    let other = until(
        forced,
        "realization = \"auto\"\ndynamics = \"one-form\"\ncomposition = \"suzuki-4\"",
        "[1, 0.2]",
        (20.0, 4000),
    );
    let (own, other) = (end(&run), end(&other));
    println!("{own:?} {other:?}");
    for i in 0..2 {
        assert!((own[i] - other[i]).abs() < 1e-7, "{own:?} {other:?}");
    }
}

/// An ideal gas at constant volume takes up heat by Newton's law: U = e^{2S/3} V^{−2/3} for all time, and its
/// temperature T = 2U/3 relaxes to T₀ like e^{−2κt/3}.
#[test]
fn a_gas_relaxes_on_its_equilibrium_states() {
    let gas = "variables = [\"S\", \"V\", \"T\", \"mP\", \"U\"]\nbracket = { contact = [[\"S\", \"T\"], [\"V\", \"mP\"]] }\n\
        parameters = { kappa = 0.5, T0 = 2.0 }\n\
        define = { tau = \"2/3*exp(2*S/3)*V^(-2/3)\" }\n\
        hamiltonian = \"-kappa*(tau - T0)/tau*(T - tau)\"";
    let initial = "{ S = 0, V = 1, T = \"2/3\", mP = \"-2/3\", U = 1 }";
    for (steps, tolerance) in [(100, 1e-6), (200, 1e-7)] {
        let run = until(gas, &hamilton_jacobi(4), initial, (3.0, steps));
        let x = end(&run);
        let temperature = 2.0 + (2.0 / 3.0 - 2.0) * libm::exp(-1.0);
        let state = libm::exp(2.0 * x[0] / 3.0);
        println!("{x:?} {temperature}");
        assert!((x[2] - temperature).abs() < tolerance, "T {}", x[2]);
        assert!((x[4] - state).abs() < tolerance, "U {} {state}", x[4]);
        assert!((x[3] + 2.0 / 3.0 * state).abs() < tolerance, "-P {}", x[3]);
    }
}

/// r of 10⁵ steps would be e^2000; steps begin at r = 1.
#[test]
fn long_runs_do_not_overflow() {
    let system = OSCILLATOR.replace("0.2*s", "0.2*s - q");
    let x = end(&until(
        &system,
        &hamilton_jacobi(4),
        "[3, 0, 0]",
        (1e4, 100_000),
    ));
    // At rest at q = 1, where s′ = −H = 0.
    assert!((x[0] - 1.0).abs() < 1e-14 && x[1].abs() < 1e-14, "{x:?}");
    assert!((x[2] - 2.5).abs() < 1e-12, "{x:?}");
}

/// Every step of the homogeneous system written out keeps its tensor, also where r and P have grown ten-thousandfold: DΦ is taken in coordinates
/// of like sizes. A dozen products of 16 factors are wrong by 64 units of round-off at most.
#[test]
fn tangents_of_grown_momenta_keep_the_tensor() {
    let run = until(
        "variables = [\"q\", \"P\", \"s\", \"r\"]\nbracket = { \"q,P\" = 1, \"s,r\" = -1 }\nconvention = \"{x,H}\"\n\
         hamiltonian = \"P^2/(2*r) + r*q^2/2 + 0.2*r*s + 0.1*P*s\"",
        &hamilton_jacobi(2),
        "[1, 0, 0, 1]",
        (60.0, 600),
    );
    let values = run.system.parameter_values();
    let mut instrument =
        TensorDefect::new(&run.system, run.method.map(), &values, 1.0, 0.1).expect("a tensor");
    let mut walk = run.walk();
    let mut largest = 0.0_f64;
    for _ in 0..600 {
        let defect = instrument.measure(walk.state()).expect("a defect");
        largest = largest.max(defect.relative().expect("a tensor that is not 0"));
        walk.advance(1).expect("a step");
    }
    println!("largest defect {largest:e}, r = {:e}", walk.state()[3]);
    assert!(
        walk.state()[3] > 1e4 && largest <= 64.0 * f64::EPSILON,
        "{largest:e}"
    );
}

#[test]
fn what_it_does_not_stand_beside_is_refused() {
    let registry = Registry::with_builtin();
    let rest =
        "[method]\nrealization = \"auto\"\ntime-step = 0.1\n[run]\ninitial = INITIAL\nsteps = 2\n";
    for (system, initial, message) in [
        (
            format!("{OSCILLATOR}\nforces = [\"p\", \"0\", \"0\"]"),
            "[1, 0, 0]",
            "forces",
        ),
        (
            format!("{OSCILLATOR}\ncasimirs = {{ c = \"q\" }}"),
            "[1, 0, 0]",
            "Casimirs",
        ),
        (
            OSCILLATOR.replace("\"s\"]", "\"s\", \"z\"]"),
            "[1, 0, 0, 0]",
            "no variable is the momentum or the coordinate of `z`",
        ),
        (
            OSCILLATOR.replace(", \"s\"]", "]").replace("0.2*s", "q"),
            "[1, 0]",
            "one variable in addition to its pairs",
        ),
    ] {
        let text = format!("[system]\n{system}\n{}", rest.replace("INITIAL", initial));
        let said = match SceneDocument::parse("refused.toml", &text, &registry) {
            Err(problems) => problems.to_string(),
            Ok(document) => compose(&document, &registry)
                .err()
                .expect(message)
                .to_string(),
        };
        assert!(said.contains(message), "{said}");
    }
    let run = composed(&format!(
        "[system]\n{OSCILLATOR}\n{}",
        rest.replace("INITIAL", "[1, 0, 0]")
    ));
    assert_eq!(run.names(), ["q", "p", "s"]);
}
