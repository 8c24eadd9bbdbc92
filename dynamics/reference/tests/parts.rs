//! The parts: parameters, refusals, failures, checkpoints, lanes.

use crate::common::{
    lotka_volterra, map, none, parts, pendulum, rigid_body, run, spins, system, try_map,
};
use leafwise_core::{BuildError, Convention, Evaluator, PoissonSystem, StepError, Stepper, Walk};

#[test]
fn parameters_out_of_range_are_refused() {
    let system = rigid_body();
    for (part, parameters) in [
        ("gauss", none().with("stages", 0)),
        ("gauss", none().with("stages", 17)),
        ("dop853", none().with("tolerance", 0.0)),
        ("dop853", none().with("tolerance", f64::NAN)),
        ("dormand-prince45", none().with("tolerance", 1.0)),
        ("energy-preserving", none().with("order", 3)),
        ("projection", none().with("base", "euler")),
        ("projection", none().with("stages", -2)),
    ] {
        let error = try_map(part, &system, &parameters).err();
        assert!(
            matches!(error, Some(BuildError::Parameter { .. })),
            "{part}: {error:?}"
        );
    }
    for part in ["rk4", "implicit-midpoint", "spherical-midpoint"] {
        let error = try_map(part, &system, &none().with("order", 2)).err();
        assert!(
            matches!(error, Some(BuildError::UnknownParameter { .. })),
            "{part}: {error:?}"
        );
    }
}

/// Signs, couplings, unequal or missing brackets, and dimensions.
#[test]
fn the_spherical_midpoint_refuses_other_tensors() {
    let of = |d, bracket: &[((usize, usize), &str)]| {
        system(d, bracket, "x1^2", &[], Convention::HamiltonianFirst)
    };
    let others = [
        lotka_volterra(),
        pendulum(),
        of(3, &[((1, 2), "x3"), ((1, 3), "x2"), ((2, 3), "x1")]),
        of(3, &[((1, 2), "x3"), ((1, 3), "-2*x2"), ((2, 3), "x1")]),
        of(3, &[((1, 2), "x3"), ((1, 3), "-x2")]),
        of(
            3,
            &[((1, 2), "x1*x3"), ((1, 3), "-x1*x2"), ((2, 3), "x1^2")],
        ),
        crate::common::heavy_top(),
    ];
    for other in others {
        let error = try_map("spherical-midpoint", &other, &none()).err();
        assert!(
            matches!(error, Some(BuildError::DoesNotFit { .. })),
            "{:?}: {error:?}",
            other.expressions().expect("formulas").tensor()
        );
    }
    let scaled = of(3, &[((1, 2), "3*x3"), ((1, 3), "-3*x2"), ((2, 3), "3*x1")]);
    assert!(try_map("spherical-midpoint", &scaled, &none()).is_ok());
    let beside_one_that_rests = of(4, &[((1, 2), "x3"), ((1, 3), "-x2"), ((2, 3), "x1")]);
    assert!(try_map("spherical-midpoint", &beside_one_that_rests, &none()).is_ok());
}

#[test]
fn a_step_that_cannot_be_taken_is_a_typed_error() {
    let singular = system(
        3,
        &[((1, 2), "x1*x2"), ((2, 3), "x2*x3"), ((1, 3), "-x1*x3")],
        "x1 + 1/x2^2 + x3",
        &[],
        Convention::HamiltonianFirst,
    );
    for (part, parameters, _) in parts() {
        let map = map(part, &singular, &parameters);
        let mut run = Walk::new(map.as_ref(), &[], 1.0, 0.1, &[1.0, 0.0, 0.5]);
        let error = run.step().expect_err("the field divides by zero there");
        assert!(
            matches!(error, StepError::NonFinite { .. }),
            "{part}: {error}"
        );
    }
    let system = spins();
    for part in ["implicit-midpoint", "gauss", "spherical-midpoint"] {
        let map = map(part, &system, &none());
        let start = [0.6, 0.0, 0.8, -0.48, 0.6, 0.64];
        let mut run = Walk::new(map.as_ref(), &[], 1.0, 1e9, &start);
        // A solution of a step this large may exist; where none is found the state is intact.
        if let Err(error) = run.step() {
            assert!(
                matches!(
                    error,
                    StepError::NoConvergence { .. }
                        | StepError::NonFinite { .. }
                        | StepError::OtherBranch { .. }
                ),
                "{part}: {error}"
            );
            assert_eq!(run.state(), start);
        }
    }
}

fn step(stepper: &mut dyn Stepper, x: &mut [f64]) {
    let lanes = x.len() / 3;
    let mut increment = vec![0.0; x.len()];
    let mut outcome = vec![Ok(()); lanes];
    stepper.increment(x, &vec![0.0; x.len()], &mut increment, &mut outcome);
    assert_eq!(outcome, vec![Ok(()); lanes]);
    x.iter_mut().zip(increment).for_each(|(x, i)| *x += i);
}

fn bits(x: &[f64]) -> Vec<u64> {
    x.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    let system = lotka_volterra();
    for (part, parameters, _) in parts() {
        let map = map(part, &system, &parameters);
        let mut x = vec![1.0, 1.9, 0.5];
        let mut through = map.stepper(1, &[], 1.0, 0.1);
        for _ in 0..5 {
            step(through.as_mut(), &mut x);
        }
        let (mut y, memory) = (x.clone(), through.memory());
        let mut resumed = map.stepper(1, &[], 1.0, 0.1);
        resumed.restore(&memory).expect("a memory of this map");
        assert_eq!(resumed.restore(&[0.0; 99]), Err(memory.len()));
        for _ in 0..5 {
            step(through.as_mut(), &mut x);
            step(resumed.as_mut(), &mut y);
        }
        assert_eq!(bits(&x), bits(&y), "{part}");
    }
}

#[test]
fn lanes_have_the_bits_of_single_runs() {
    let system = lotka_volterra();
    let starts = [[1.0, 1.9, 0.5], [0.8, 1.5, 0.7]];
    for (part, parameters, _) in parts() {
        let map = map(part, &system, &parameters);
        let mut together: Vec<f64> = (0..3).flat_map(|c| starts.map(|s| s[c])).collect();
        let mut stepper = map.stepper(2, &[], 1.0, 0.1);
        for _ in 0..3 {
            step(stepper.as_mut(), &mut together);
        }
        for (lane, start) in starts.iter().enumerate() {
            let mut alone = start.to_vec();
            let mut stepper = map.stepper(1, &[], 1.0, 0.1);
            for _ in 0..3 {
                step(stepper.as_mut(), &mut alone);
            }
            let own: Vec<f64> = together.iter().skip(lane).step_by(2).copied().collect();
            assert_eq!(bits(&alone), bits(&own), "{part}");
        }
    }
}

/// x ↦ t/6 (k₁ + 2k₂ + 2k₃ + k₄) by evaluations of the field.
fn classical(system: &PoissonSystem, t: f64, x: &[f64]) -> Vec<f64> {
    let field = system.field_map().expect("a field");
    let mut field = field.evaluator(&[], 1.0, 1.0);
    let (mut sum, mut slope) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    for (node, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let stage = x.iter().zip(&slope).map(|(x, k)| x + node * t * k);
        let stage: Vec<f64> = stage.collect();
        field.values(&stage, &mut slope).expect("a value");
        for (sum, k) in sum.iter_mut().zip(&slope) {
            *sum += t / 6.0 * weight * k;
        }
    }
    sum
}

/// A step is one kernel, of no more operations than four evaluations of the field and 15 d for the sums; or, of a
/// field too long for that, calls. Both are the classical method, to the round-off of some 64 terms a component.
#[test]
fn rk4_is_one_kernel_or_calls() {
    let d = 64;
    let couplings: Vec<String> = (1..=d)
        .flat_map(|i| (i + 1..=d).map(move |j| format!("sin(x{i}*x{j})")))
        .collect();
    let pairs: Vec<((usize, usize), &str)> =
        (1..=d / 2).map(|i| ((2 * i - 1, 2 * i), "1")).collect();
    let long = system(
        d,
        &pairs,
        &couplings.join(" + "),
        &[],
        Convention::HamiltonianFirst,
    );
    for (system, is_kernel) in [(rigid_body(), true), (long, false)] {
        let (d, t) = (system.dimension(), 0.01);
        let x: Vec<f64> = (0..d).map(|i| 0.5 + libm::sin(i as f64)).collect();
        let map = map("rk4", &system, &none());
        assert_eq!(map.abilities().kernels.len(), usize::from(is_kernel));
        let mut stepper = map.stepper(1, &[], 0.5, t / 0.5);
        let mut increment = vec![0.0; d];
        let mut outcome = [Ok(())];
        stepper.increment(&x, &vec![0.0; d], &mut increment, &mut outcome);
        assert_eq!(outcome, [Ok(())]);
        let expected = classical(&system, t, &x);
        let size = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (found, expected) in increment.iter().zip(&expected) {
            let error = (found - expected).abs();
            assert!(error <= 64.0 * f64::EPSILON * size, "d = {d}: {error:e}");
        }
        assert!(stepper.tangent(0).is_some(), "d = {d}: an exact tangent");
        let field = system
            .expressions()
            .expect("formulas")
            .vector_field_kernel();
        let field = field.expect("a field").step_operations().work();
        let found = stepper.statistics().operations.expect("counted");
        if is_kernel {
            let most = 4 * field + 15 * d as u64;
            assert!(found <= most, "{found} operations, calls take {most}");
        }
    }
}

/// A chain of n unit masses and springs with free ends, of which the first is displaced.
fn chain(n: usize) -> (PoissonSystem, Vec<f64>) {
    let kinetic = (1..=n).map(|j| format!("x{}^2/2", n + j));
    let springs = (1..n).map(|j| format!("(x{} - x{j})^2/2", j + 1));
    let energy = kinetic.chain(springs).collect::<Vec<_>>().join(" + ");
    let pairs: Vec<_> = (1..=n).map(|j| ((j, n + j), "-1")).collect();
    let chain = system(2 * n, &pairs, &energy, &[], Convention::HamiltonianFirst);
    let mut start = vec![0.0; 2 * n];
    start[0] = 1.0;
    (chain, start)
}

/// While what is too small to look at is told by the field, too.
#[test]
fn what_rests_is_resumed_with_the_same_bits() {
    let (chain, start) = chain(11);
    for part in ["taylor", "dop853", "dormand-prince45"] {
        let map = map(part, &chain, &none().with("tolerance", 1e-8));
        for before in [1, 2, 5, 20] {
            let mut through = Walk::new(map.as_ref(), &[], 1.0, 0.1, &start);
            (0..before).for_each(|_| through.step().expect("a step"));
            let mut resumed = Walk::new(map.as_ref(), &[], 1.0, 0.1, &start);
            resumed.step().expect("a step of another run");
            let checkpoint = through.checkpoint();
            resumed.restore(&checkpoint).expect("a checkpoint of it");
            for _ in 0..20 {
                through.step().expect("a step");
                resumed.step().expect("a step");
                assert_eq!(through.checkpoint(), resumed.checkpoint(), "{part}");
            }
        }
    }
}

/// Two oscillators side by side, the faster one 10⁻⁴⁰ as wide as the other: it keeps its own digits.
#[test]
fn what_is_tiny_keeps_its_digits() {
    let pair = system(
        4,
        &[((1, 3), "-1"), ((2, 4), "-1")],
        "(100*x1^2 + x2^2 + x3^2 + x4^2)/2",
        &[],
        Convention::HamiltonianFirst,
    );
    for (part, tolerance) in [
        ("taylor", 1e-8),
        ("dop853", 1e-6),
        ("dormand-prince45", 1e-6),
    ] {
        let map = map(part, &pair, &none().with("tolerance", tolerance));
        let end = run(map.as_ref(), 0.5, 20, &[1e-40, 1.0, 0.0, 0.0]);
        let error = (end[0] / (1e-40 * libm::cos(100.0)) - 1.0).abs();
        // Of some hundreds of substeps.
        assert!(error < 1000.0 * tolerance, "{part}: {error:e}");
    }
}

/// The [`chain`]: q_j = Σ_k c_k φ_k(j) cos(ω_k t) with
/// φ_k(j) = cos(π k (j + 1/2)/n) and ω_k = 2 sin(π k/(2n)). The j-th begins as t²ʲ: to a pair its error is as large as its motion.
#[test]
fn what_rests_begins_to_move() {
    for n in [4_usize, 11, 50, 200] {
        let (chain, start) = chain(n);
        let time = 5.0;
        let angle = std::f64::consts::PI / n as f64;
        let mode = |k: usize, j: usize| libm::cos(angle * k as f64 * (j as f64 + 0.5));
        let expected = |j: usize| -> f64 {
            let of_mode = |k: usize| {
                let share = if k == 0 { 1.0 } else { 2.0 } / n as f64;
                let frequency = 2.0 * libm::sin(0.5 * angle * k as f64);
                share * mode(k, 0) * mode(k, j) * libm::cos(frequency * time)
            };
            (0..n).map(of_mode).sum()
        };
        for (part, tolerance) in [
            ("dop853", 1e-13),
            ("dop853", 1e-6),
            ("dormand-prince45", 1e-8),
            ("dormand-prince45", 1e-4),
            ("taylor", 1e-15),
            ("taylor", 1e-6),
        ] {
            let map = map(part, &chain, &none().with("tolerance", tolerance));
            let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.1, &start);
            for _ in 0..50 {
                let outcome = walk.step();
                assert_eq!(outcome, Ok(()), "{part} {tolerance:e}, {n}");
            }
            let state = &walk.state()[..n];
            let errors = state
                .iter()
                .enumerate()
                .map(|(j, q)| (q - expected(j)).abs());
            let error = errors.fold(0.0, f64::max);
            // Of some tens of substeps; the closed form is a sum of n cosines.
            let allowed = 50.0 * tolerance + f64::EPSILON * n as f64;
            assert!(error < allowed, "{part} {tolerance:e}, {n}: {error:e}");
        }
    }
}

/// ẍ = −x + t² from rest: x = t² − 2 + 2 cos t begins as t⁴.
#[test]
fn what_is_driven_from_rest_begins_to_move() {
    let ramp = system(
        4,
        &[((1, 2), "-1"), ((3, 4), "-1")],
        "x2^2/2 + x1^2/2 - x1*x3^2 + x4",
        &[],
        Convention::HamiltonianFirst,
    );
    for part in ["dop853", "dormand-prince45"] {
        for tolerance in [1e-4, 1e-8, 1e-12] {
            let map = map(part, &ramp, &none().with("tolerance", tolerance));
            let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.1, &[0.0; 4]);
            for _ in 0..200 {
                assert_eq!(walk.step(), Ok(()), "{part} {tolerance:e}");
            }
            let expected = 400.0 - 2.0 + 2.0 * libm::cos(20.0);
            let error = (walk.state()[0] / expected - 1.0).abs();
            assert!(
                error < 100.0 * tolerance + 1e-14,
                "{part} {tolerance:e}: {error:e}"
            );
        }
    }
}
