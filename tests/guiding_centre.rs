//! Guiding centres in a small tokamak: a tensor by a one-form, stepped by exact Poisson maps.
//!
//! The states at T = 5·10⁵ were computed elsewhere, to the digits that stand here.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::diagnostics::{TensorDefect, Verdict};
use leafwise::core::system::{FormError, TensorSource};
use leafwise::core::{PoissonSystem, StepError};
use leafwise::prelude::Registry;
use leafwise::scene::{ComposedRun, SceneChecks, compose};
use leafwise_tests::scenes::{composed, document};

/// u and μ of an orbit from (1.05, 0, 0, u), and (R, Z, φ, u) at T.
struct Orbit {
    u: &'static str,
    mu: &'static str,
    end: [f64; 4],
}

const TRAPPED: Orbit = Orbit {
    u: "4.306e-4",
    mu: "2.250e-6",
    end: [1.0177448366, 0.0556046772, -14.03413776, 2.21464999e-4],
};
const PASSING: Orbit = Orbit {
    u: "1.623e-3",
    mu: "2.448e-6",
    end: [1.0243555968, -0.0471461424, 772.10064316, 1.586559403e-3],
};

/// The toroidal momentum, and its name in the Cartesian system.
const TOROIDAL: &str = "r2/(2*q0) + q0*u*R/s";

fn run(system: &str, orbit: &Orbit, order: u32, step: f64, steps: usize) -> ComposedRun {
    composed(&format!(
        "[system]\n{system}\n[method]\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\n\
         time-step = {step:?}\n[run]\ninitial = [1.05, 0, 0, {}]\nsteps = {steps}\n\
         record = {{ observables = [\"energy\", \"{TOROIDAL}\"] }}\n",
        orbit.u
    ))
}

fn library(name: &str, orbit: &Orbit) -> String {
    format!("library = \"{name}\"\nparameters = {{ mu = {} }}", orbit.mu)
}

/// The last state, and the values of H and the toroidal momentum after every step.
fn follow(run: &ComposedRun) -> (Vec<f64>, [Vec<f64>; 2]) {
    let formulas = run.system.expressions().expect("formulas");
    let values = run.system.parameter_values();
    let momentum = run
        .plan
        .observables
        .iter()
        .find_map(|observable| match observable {
            compose::Observable::Formula {
                formula: compose::RecordedFormula::Written(expression),
                ..
            } => Some(expression),
            _ => None,
        });
    let kernel = formulas.observable_kernel(&[formulas.hamiltonian(), momentum.expect("recorded")]);
    let kernel = kernel.expect("code");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &values, &[1.0], &[1.0]);
    let mut seen = [Vec::new(), Vec::new()];
    let mut walk = run.walk();
    for step in 0..=run.plan.steps {
        if step > 0 {
            walk.step().expect("a step");
        }
        let mut both = [0.0; 2];
        kernel.evaluate(&mut workspace, walk.state(), &mut both);
        seen[0].push(both[0]);
        seen[1].push(both[1]);
    }
    (walk.state().to_vec(), seen)
}

fn largest_relative(values: &[f64]) -> f64 {
    let first = values[0];
    let drifts = values.iter().map(|value| (value - first).abs());
    drifts.fold(0.0, f64::max) / first.abs()
}

/// Both orbits to 1e-8 of each coordinate, their toroidal momentum to 1e-13, at order 6 and 4000 steps.
#[test]
fn both_orbits_are_reached() {
    for orbit in [TRAPPED, PASSING] {
        let run = run(&library("guiding-centre", &orbit), &orbit, 6, 125.0, 4000);
        let (end, [energy, momentum]) = follow(&run);
        for (found, expected) in end.iter().zip(orbit.end) {
            let error = (found - expected).abs() / expected.abs();
            println!("{found:.12e}: {error:.1e}");
            assert!(error <= 1e-8, "{found} for {expected}");
        }
        let (energy, momentum) = (largest_relative(&energy), largest_relative(&momentum));
        println!("energy {energy:.1e}, toroidal momentum {momentum:.1e}");
        assert!(momentum <= 1e-13, "{momentum:e}");
    }
}

/// The relative energy error of steps of order 4 is at most 1.2e-7, the same over the first and the last tenth of
/// 5000 steps, some 60 bounces or transits; a drift of one sign would be ten times as large at the end.
#[test]
fn the_energy_error_does_not_grow() {
    for orbit in [TRAPPED, PASSING] {
        let run = run(&library("guiding-centre", &orbit), &orbit, 4, 500.0, 5000);
        let (_, [energy, _]) = follow(&run);
        let error = largest_relative(&energy);
        let largest = |steps: &[f64]| {
            let errors = steps.iter().map(|value| (value - energy[0]).abs());
            errors.fold(0.0, f64::max)
        };
        let tenth = energy.len() / 10;
        let growth = largest(&energy[energy.len() - tenth..]) / largest(&energy[..tenth]);
        println!("energy {error:.2e}, growth {growth:.4}");
        assert!(error <= 1.2e-7, "{error:e}");
        assert!((0.95..1.05).contains(&growth), "{growth}");
    }
}

/// DΦ Π DΦᵀ − Π∘Φ of a step, along the orbit, relative to Π.
#[test]
fn a_step_is_a_poisson_map() {
    let orbit = PASSING;
    for (order, step) in [(2, 125.0), (4, 500.0), (6, 125.0)] {
        let run = run(&library("guiding-centre", &orbit), &orbit, order, step, 20);
        let mut defect = TensorDefect::new(
            &run.system,
            run.method.map(),
            &run.system.parameter_values(),
            run.plan.epsilon,
            run.plan.h,
        )
        .expect("code");
        let mut walk = run.walk();
        for _ in 0..20 {
            let found = defect.measure(walk.state()).expect("a tangent");
            let relative = found.relative().expect("a tensor that is not 0");
            assert!(relative <= 1e-12, "order {order}: {relative:e}");
            walk.step().expect("a step");
        }
    }
}

/// ϑ and ϑ + df have one tensor. What differs is round-off, which the flow of T/10 = 5·10⁴ magnifies little.
#[test]
fn a_gauge_change_leaves_the_orbit() {
    let orbit = TRAPPED;
    let own = run(&library("guiding-centre", &orbit), &orbit, 6, 125.0, 400);
    // f = R² Z u + Z cos φ + u² R.
    let text = format!(
        "variables = [\"R\", \"Z\", \"phi\", \"u\"]\nparameters = {{ mu = {}, q0 = 2 }}\n\
         define = {{ r2 = \"(R - 1)^2 + Z^2\", s = \"sqrt(q0^2 + r2)\", B = \"s/(q0*R)\" }}\n\
         bracket = {{ one-form = [\"Z/(2*R) - u*Z/s + 2*R*Z*u + u^2\", \
         \"-ln(R)/2 + u*(R - 1)/s + R^2*u + cos(phi)\", \"r2/(2*q0) + q0*u*R/s - Z*sin(phi)\", \
         \"R^2*Z + 2*u*R\"] }}\nhamiltonian = \"u^2/2 + mu*B\"",
        orbit.mu
    );
    let changed = run(&text, &orbit, 6, 125.0, 400);
    let (one, other) = (follow(&own).0, follow(&changed).0);
    for (a, b) in one.iter().zip(&other) {
        assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}");
    }
}

/// In Cartesian coordinates the orbit turns about the axis as it goes: at steps of 125 the error is that of
/// x and y, 64 times less at half the step.
#[test]
fn cartesian_coordinates_have_the_same_orbit() {
    let orbit = TRAPPED;
    let system = library("guiding-centre-cartesian", &orbit);
    let steps = 400;
    let end = |step: f64, steps: usize| {
        let run = run(&system, &orbit, 6, step, steps);
        let (end, [_, momentum]) = follow(&run);
        assert!(largest_relative(&momentum) <= 1e-13);
        end
    };
    let own = run(
        &library("guiding-centre", &orbit),
        &orbit,
        6,
        62.5,
        2 * steps,
    );
    let own = follow(&own).0;
    let expected = [
        own[0] * libm::cos(own[2]),
        own[0] * libm::sin(own[2]),
        own[1],
        own[3],
    ];
    let error = |found: &[f64]| {
        let errors = found
            .iter()
            .zip(expected)
            .map(|(a, b)| (a - b).abs() / b.abs());
        errors.fold(0.0, f64::max)
    };
    let coarse = error(&end(125.0, steps));
    let fine = error(&end(62.5, 2 * steps));
    let finest = error(&end(31.25, 4 * steps));
    println!("{coarse:.1e} {fine:.1e} {finest:.1e}");
    assert!(finest <= 1e-8, "{finest:e}");
    assert!(coarse / fine > 32.0, "{coarse:e} {fine:e}");
}

/// The whole time in Cartesian coordinates, to 1e-8.
#[test]
#[ignore = "half a minute"]
fn cartesian_coordinates_reach_the_end() {
    let orbit = TRAPPED;
    let system = library("guiding-centre-cartesian", &orbit);
    let (end, _) = follow(&run(&system, &orbit, 6, 31.25, 16_000));
    let [r, z, phi, u] = orbit.end;
    for (found, expected) in end
        .iter()
        .zip([r * libm::cos(phi), r * libm::sin(phi), z, u])
    {
        let error = (found - expected).abs() / expected.abs();
        println!("{found:.12e}: {error:.1e}");
        assert!(error <= 1e-8, "{found} for {expected}");
    }
}

/// Two million steps without growth.
#[test]
#[ignore = "minutes"]
fn the_energy_error_does_not_grow_over_a_million_steps() {
    for orbit in [TRAPPED, PASSING] {
        let run = run(
            &library("guiding-centre", &orbit),
            &orbit,
            4,
            500.0,
            1_000_000,
        );
        let (_, [energy, momentum]) = follow(&run);
        let error = largest_relative(&energy);
        let tenth = energy.len() / 10;
        let last = largest_relative(&[&energy[..1], &energy[energy.len() - tenth..]].concat());
        let first = largest_relative(&energy[..tenth]);
        println!(
            "energy {error:.3e}, growth {:.5}, momentum {:.1e}",
            last / first,
            largest_relative(&momentum)
        );
        assert!(
            error <= 1.2e-7 && last / first < 1.01,
            "{error:e} {first:e} {last:e}"
        );
    }
}

/// `auto` takes an exact realization, and checks prove Jacobi's identity by the making of the tensor.
#[test]
fn the_tensor_is_poisson_by_construction() {
    for name in ["guiding-centre", "guiding-centre-cartesian"] {
        let run = run(&library(name, &TRAPPED), &TRAPPED, 4, 125.0, 1);
        let properties = run.method.map().properties();
        println!("{properties:?}");
        let formulas = run.system.expressions().expect("formulas");
        assert!(matches!(formulas.source(), TensorSource::OneForm));
        let checks = SceneChecks::of(&run.system, &run.near).expect("code");
        assert_eq!(checks.jacobi.verdict, Verdict::ByConstruction);
    }
}

/// Where the parallel velocity is so large that b·B* = 0 the form has no inverse: a step across is refused with
/// the Pfaffian's values, and a start there with its value.
#[test]
fn a_step_across_a_degenerate_place_names_the_pfaffian() {
    let scene = |initial: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ one-form = [\"p^2/2\", 0] }}\n\
             hamiltonian = \"q\"\n[method]\nstepper = \"rk4\"\ntime-step = 0.3\n[run]\n\
             initial = {initial}\nsteps = 50\n"
        )
    };
    // p' = −1/p: p = √(1 − 2t) ends at t = 1/2.
    let run = composed(&scene("[0, 1]"));
    let mut walk = run.walk();
    let mut error = None;
    for _ in 0..50 {
        error = walk.step().err();
        if error.is_some() {
            break;
        }
    }
    match error {
        Some(StepError::Pole {
            denominator,
            before,
            after,
        }) => {
            println!("{denominator}: {before} {after}");
            assert!(before * after < 0.0);
        }
        other => panic!("{other:?}"),
    }
    let registry = Registry::with_builtin();
    let document = document(&scene("[1, 0]"), &[]);
    let refusal = compose(&document, &registry).err().expect("refused");
    assert!(
        refusal.message.contains("its Pfaffian is"),
        "{}",
        refusal.message
    );
}

/// In Rust: sizes, and the motion of p dq.
#[test]
fn forms_are_written_in_rust_too() {
    use leafwise::core::SystemBuilder;
    let mut plane = SystemBuilder::new();
    let [q, p] = plane.variables(["q", "p"]);
    plane.hamiltonian(p * p / 2 + q * q / 2);
    let system = plane.build().expect("two variables");
    let formulas = system.expressions().expect("formulas").clone();
    let short = formulas.clone().with_one_form(&[p.into()]);
    let expected = FormError::Components {
        dimension: 2,
        found: 1,
    };
    assert_eq!(short.err(), Some(expected));
    let system: PoissonSystem = formulas
        .with_one_form(&[p.into(), 0.into()])
        .expect("p dq")
        .into();
    let mut field = vec![0.0; 2];
    let values = system.field_values().expect("code");
    use leafwise::core::Evaluator as _;
    let mut evaluator = values.evaluator(&[], 1.0, 1.0);
    evaluator.values(&[0.5, 2.0], &mut field).expect("values");
    assert_eq!(field, [2.0, -0.5]);
}
