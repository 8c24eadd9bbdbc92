//! The Taylor stepper: order, accuracy, dense output, lanes, checkpoints, work and refusals.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use crate::common::{
    LOTKA_VOLTERRA_FLOW, RIGID_BODY_FLOW, distance, heavy_top, lotka_volterra, map, none, orbit,
    pendulum, rigid_body, run, system, try_map,
};
use leafwise_core::diagnostics::fit_slope;
use leafwise_core::{BuildError, Convention, PoissonSystem, StepError, StepMap, Walk};
use std::sync::Arc;

fn taylor(system: &PoissonSystem, tolerance: f64) -> Arc<dyn StepMap> {
    map("taylor", system, &none().with("tolerance", tolerance))
}

/// q̇ = p, ṗ = −q: q = cos t, p = −sin t from (1, 0).
fn oscillator() -> PoissonSystem {
    let pairs = [((1, 2), "-1")];
    system(
        2,
        &pairs,
        "(x1^2 + x2^2)/2",
        &[],
        Convention::HamiltonianFirst,
    )
}

/// q̇ = q², ṗ = −2qp: q = 1/(1 − t) from q = 1.
fn singular() -> PoissonSystem {
    let pairs = [((1, 2), "-1")];
    system(2, &pairs, "x1^2*x2", &[], Convention::HamiltonianFirst)
}

/// Kepler's problem in the plane, by a power and a square root.
fn kepler() -> PoissonSystem {
    system(
        4,
        &[((1, 3), "-1"), ((2, 4), "-1")],
        "(x3^2 + x4^2)/2 - 1/sqrt(x1^2 + x2^2)",
        &[],
        Convention::HamiltonianFirst,
    )
}

/// A particle and a hill on its way, of which the force is 1e-18 at the start.
fn hill() -> PoissonSystem {
    system(
        2,
        &[((1, 2), "-1")],
        "x2^2/2 + 0.3/cosh(10*x1)^2",
        &[],
        Convention::HamiltonianFirst,
    )
}

/// One step t from the start has the error c t^(p+1) while no second substep is taken.
#[test]
fn the_order_is_that_of_the_tolerance() {
    let (start, system) = (LOTKA_VOLTERRA_FLOW.0, lotka_volterra());
    let exact = taylor(&system, 1e-16);
    for (tolerance, order) in [(0.1, 3), (1e-2, 4), (1e-4, 6), (1e-6, 8), (1e-15, 19)] {
        let map = taylor(&system, tolerance);
        assert!(
            map.describe().ends_with(&format!("order {order}")),
            "{}",
            map.describe()
        );
        assert_eq!(map.properties().order, 0, "no order in the step");
        if order > 8 {
            continue;
        }
        let sizes = [0.6, 0.7, 0.8, 0.9, 1.0].map(|part| 0.03 * part);
        let points = sizes.map(|t| {
            let end = run(exact.as_ref(), t, 1, &start);
            (t, distance(&run(map.as_ref(), t, 1, &start), &end))
        });
        let slope = fit_slope(&points, 1e-17).expect("points above round-off");
        println!("order {order}: {:.3}", slope.exponent);
        let expected = (order + 1) as f64;
        assert!(
            (slope.exponent - expected).abs() < 0.3,
            "{order}: {slope:?}"
        );
    }
}

/// Errors of some tens of substeps add up, and those of 50-digit flows are told to a few units of round-off.
#[test]
fn flows_are_reached_to_the_tolerance() {
    for (system, flow) in [
        (rigid_body(), RIGID_BODY_FLOW),
        (lotka_volterra(), LOTKA_VOLTERRA_FLOW),
    ] {
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16] {
            for steps in [1, 7, 100] {
                let map = taylor(&system, tolerance);
                let end = run(map.as_ref(), 1.0 / steps as f64, steps, &flow.0);
                let error = distance(&end, &flow.1);
                println!("{}: {steps} steps, error {error:.1e}", map.describe());
                let round_off = 16.0 * f64::EPSILON;
                assert!(
                    error < 30.0 * tolerance + round_off,
                    "{tolerance:e}: {error:e}"
                );
            }
        }
    }
}

/// A hundred turns of an oscillator: round-off of compensated sums, which add up like a random walk.
#[test]
fn round_off_of_many_turns_stays_small() {
    let map = taylor(&oscillator(), 1e-15);
    for steps in [1, 1000] {
        let t = 200.0 * std::f64::consts::PI;
        let end = run(map.as_ref(), t / steps as f64, steps, &[1.0, 0.0]);
        // T is a double: 200 π itself is 5.7e-14 less or more.
        let exact = [libm::cos(t), -libm::sin(t)];
        let error = distance(&end, &exact);
        println!("{steps} steps: {error:.1e}");
        assert!(error < 1e-13, "{error:e}");
    }
}

/// Between the ends of substeps the polynomial is as good as there, and asks for nothing.
#[test]
fn records_within_a_substep_are_on_the_solution() {
    for (system, start) in [
        (rigid_body(), vec![1.0, 3.0, 3.0]),
        (lotka_volterra(), vec![1.0, 1.9, 0.5]),
        (pendulum(), vec![1.0, 0.5, 0.3, 0.2]),
        (kepler(), vec![0.5, 0.0, 0.0, 1.7]),
        (heavy_top(), vec![1.0, 0.5, 3.0, 0.3, 0.2, 0.9]),
    ] {
        let exact = taylor(&system, 1e-16);
        for tolerance in [1e-5, 1e-10] {
            let map = taylor(&system, tolerance);
            let states = orbit(map.as_ref(), 0.01, 300, &start);
            let truth = orbit(exact.as_ref(), 0.01, 300, &start);
            let pairs = states.iter().zip(&truth);
            let error = pairs.fold(0.0_f64, |most, (a, b)| most.max(distance(a, b)));
            println!("{}: {error:.1e}", map.describe());
            assert!(error < 100.0 * tolerance, "{error:e}");
            let evaluations = |steps: usize| {
                let mut walk = Walk::new(map.as_ref(), &[], 1.0, 3.0 / steps as f64, &start);
                (0..steps).for_each(|_| walk.step().expect("a step"));
                walk.statistics().evaluations
            };
            assert_eq!(evaluations(1), evaluations(300), "no jet for a record");
        }
    }
}

fn bits(x: &[f64]) -> Vec<u64> {
    x.iter().map(|v| v.to_bits()).collect()
}

/// Within substeps and at their ends, forwards and backwards.
#[test]
fn a_restored_run_has_the_same_bits() {
    let steps = [(0.01, 0), (0.01, 3), (0.01, 40), (1.3, 2), (-0.01, 17)];
    // Looks shorten substeps about the hill, between t = 1 and 3.
    let across = (5..35).map(|before| (0.1, before));
    let cases = steps.map(|steps| (lotka_volterra(), vec![1.0, 1.9, 0.5], steps));
    let across = across.map(|steps| (hill(), vec![-2.0, 1.0], steps));
    for (system, start, (h, before)) in cases.into_iter().chain(across) {
        let map = taylor(&system, 1e-9);
        let mut through = Walk::new(map.as_ref(), &[], 1.0, h, &start);
        (0..before).for_each(|_| through.step().expect("a step"));
        let mut resumed = Walk::new(map.as_ref(), &[], 1.0, h, &vec![2.0; start.len()]);
        resumed.step().expect("a step of another run");
        resumed
            .restore(&through.checkpoint())
            .expect("a checkpoint of this map");
        for _ in 0..30 {
            through.step().expect("a step");
            resumed.step().expect("a step");
            assert_eq!(through.checkpoint(), resumed.checkpoint());
        }
    }
}

/// As many lanes as take the kernel of many and as few as take that of one.
fn check_lanes(map: &dyn StepMap, start: impl Fn(usize) -> Vec<f64>, h: f64) {
    let d = map.dimension();
    for lanes in [1, 2, 7, 19] {
        let mut together: Vec<f64> = (0..d)
            .flat_map(|c| (0..lanes).map(move |lane| (lane, c)))
            .map(|(lane, c)| start(lane)[c])
            .collect();
        let mut stepper = map.stepper(lanes, &[], 1.0, h);
        let zero = vec![0.0; d * lanes];
        let mut increment = zero.clone();
        for _ in 0..40 {
            let mut outcome = vec![Ok(()); lanes];
            stepper.increment(&together, &zero, &mut increment, &mut outcome);
            assert_eq!(outcome, vec![Ok(()); lanes]);
            together
                .iter_mut()
                .zip(&increment)
                .for_each(|(x, i)| *x += i);
        }
        for lane in 0..lanes {
            let mut alone = start(lane);
            let mut stepper = map.stepper(1, &[], 1.0, h);
            for _ in 0..40 {
                let mut increment = vec![0.0; d];
                stepper.increment(&alone, &zero[..d], &mut increment, &mut [Ok(())]);
                alone.iter_mut().zip(&increment).for_each(|(x, i)| *x += i);
            }
            let own: Vec<f64> = together.iter().skip(lane).step_by(lanes).copied().collect();
            assert_eq!(bits(&alone), bits(&own), "lane {lane} of {lanes}");
        }
    }
}

#[test]
fn lanes_have_the_bits_of_single_runs() {
    let body = |lane: usize| vec![1.0, 3.0 - 0.1 * lane as f64, 0.3 * lane as f64];
    check_lanes(taylor(&rigid_body(), 1e-8).as_ref(), body, 0.17);
    // Each comes to the hill at another time.
    let before_the_hill = |lane: usize| vec![-2.0 - 0.1 * lane as f64, 1.0];
    check_lanes(taylor(&hill(), 1e-8).as_ref(), before_the_hill, 0.1);
}

/// A change of the state from outside begins a new series there.
#[test]
fn a_state_from_elsewhere_begins_anew() {
    let map = taylor(&rigid_body(), 1e-10);
    let mut stepper = map.stepper(1, &[], 1.0, 0.01);
    let mut step = |x: &[f64; 3]| {
        let mut increment = [0.0; 3];
        let mut outcome = [Ok(())];
        stepper.increment(x, &[0.0; 3], &mut increment, &mut outcome);
        assert_eq!(outcome, [Ok(())]);
        increment
    };
    let first = step(&[1.0, 3.0, 3.0]);
    step(&[2.0, 0.1, -1.0]);
    assert_eq!(bits(&step(&[1.0, 3.0, 3.0])), bits(&first));
}

/// q = 1/(1 − t): the step that would cross t = 1 is refused, those before are taken.
#[test]
fn a_motion_that_ends_is_reported() {
    let map = taylor(&singular(), 1e-12);
    for (h, steps) in [(0.3, 3), (2.0, 0), (0.009, 111)] {
        let mut walk = Walk::new(map.as_ref(), &[], 1.0, h, &[1.0, 1.0]);
        (0..steps).for_each(|_| walk.step().expect("before the end"));
        let (q, t) = (walk.state()[0], walk.time());
        // The condition of q = 1/(1 − t) is its own size.
        assert!((q * (1.0 - t) - 1.0).abs() < 1e-10 * q, "{q}");
        match walk.step() {
            Err(StepError::Singularity { percent }) => {
                let expected = 100.0 * (1.0 - t) / h;
                assert!((percent - expected).abs() < 1e-3, "{percent} {expected}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_state_without_a_series_is_refused() {
    let map = taylor(&kepler(), 1e-12);
    let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.1, &[0.0; 4]);
    let error = walk.step();
    assert!(
        matches!(error, Err(StepError::NonFinite { .. })),
        "{error:?}"
    );
}

#[test]
fn numbers_and_tolerances_out_of_range_are_refused() {
    let numbers = rigid_body().without_formulas("numbers").expect("numbers");
    let error = try_map("taylor", &numbers, &none()).err();
    assert!(
        matches!(error, Some(BuildError::NotOffered { .. })),
        "{error:?}"
    );
    for tolerance in [0.0, 1e-17, 0.2, f64::NAN] {
        let given = none().with("tolerance", tolerance);
        let error = try_map("taylor", &rigid_body(), &given).err();
        assert!(
            matches!(error, Some(BuildError::Parameter { .. })),
            "{error:?}"
        );
    }
}

/// Equilibria and components at rest are no divisions by 0.
#[test]
fn what_rests_stays() {
    let map = taylor(&rigid_body(), 1e-12);
    for start in [[0.0; 3], [0.0, 2.0, 0.0]] {
        assert_eq!(run(map.as_ref(), 0.5, 10, &start), start);
    }
    let end = run(taylor(&oscillator(), 1e-12).as_ref(), 0.1, 10, &[0.0, 1.0]);
    let exact = [libm::sin(1.0), libm::cos(1.0)];
    assert!(distance(&end, &exact) < 1e-12);
}

/// Kepler's problem in other units of time, where x_19 is 10^380 or 10^−380 of itself.
#[test]
fn series_are_in_units_of_the_step() {
    let start = [0.5, 0.0, 0.0, 1.7];
    let exact = run(taylor(&kepler(), 1e-15).as_ref(), 0.05, 60, &start);
    for unit in [1e-20, 1e20] {
        let faster = system(
            4,
            &[((1, 3), "-1"), ((2, 4), "-1")],
            &format!("{unit:e}*((x3^2 + x4^2)/2 - 1/sqrt(x1^2 + x2^2))"),
            &[],
            Convention::HamiltonianFirst,
        );
        let map = taylor(&faster, 1e-15);
        let end = run(map.as_ref(), 0.05 / unit, 60, &start);
        let error = distance(&end, &exact);
        // Round-off of some tens of substeps, magnified by the motion.
        assert!(error < 1e-13, "{unit:e}: {error:e}");
    }
}

/// Prey falls from 300 to 1e-41: against the logarithms of both species, which an explicit pair steps.
#[test]
fn what_nearly_dies_out_keeps_its_digits_and_its_sign() {
    let species = system(
        2,
        &[((1, 2), "x1*x2")],
        "1.5*ln(x2) - x2 + 3*ln(x1) - x1",
        &[],
        Convention::HamiltonianSecond,
    );
    let logarithms = system(
        2,
        &[((1, 2), "1")],
        "1.5*x2 - exp(x2) + 3*x1 - exp(x1)",
        &[],
        Convention::HamiltonianSecond,
    );
    let exact = map("dop853", &logarithms, &none().with("tolerance", 1e-14));
    for prey in [20.0, 200.0, 300.0] {
        let end = run(exact.as_ref(), 1e-3, 1000, &[libm::log(prey), 0.0]);
        for tolerance in [1e-15, 1e-10, 1e-6] {
            let map = taylor(&species, tolerance);
            let states = orbit(map.as_ref(), 1e-3, 1000, &[prey, 1.0]);
            assert!(states.iter().all(|x| x[0] > 0.0), "{prey}, {tolerance:e}");
            let last = states.last().expect("a state");
            for (x, u) in last.iter().zip(&end) {
                let error = (libm::log(*x) - u).abs();
                println!("{prey} {tolerance:e}: {x:e} off by {error:.1e}");
                // Of a hundred substeps, and the round-off of logarithms of size 90.
                assert!(
                    error < 100.0 * tolerance + 1e-11,
                    "{prey}, {tolerance:e}: {error:e}"
                );
            }
        }
    }
    // In one step of 0.2 the digits are lost in the sum.
    let map = taylor(&species, 1e-15);
    let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.2, &[300.0, 1.0]);
    let error = walk.step();
    assert_eq!(error, Err(StepError::LostSign { coordinate: 1 }));
}

/// q̇ = 1 − cos q, of which little but round-off is left at q = 1e-7, and two bodies that circle each other far from the
/// origin, where their distance has lost five digits: looks see the field's round-off, and take no more substeps for it.
#[test]
fn round_off_of_the_field_is_no_residual() {
    let flat = system(
        2,
        &[((1, 2), "-1")],
        "x2*(1 - cos(x1))",
        &[],
        Convention::HamiltonianFirst,
    );
    let map = taylor(&flat, 1e-15);
    let mut walk = Walk::new(map.as_ref(), &[], 1.0, 1.0, &[1e-7, 1.0]);
    (0..10).for_each(|_| walk.step().expect("a step"));
    let evaluations = walk.statistics().evaluations;
    assert!(evaluations <= 10, "{evaluations} jets");
    let expected = 1e-7 / (1.0 - 0.5e-7 * 10.0);
    assert!((walk.state()[0] - expected).abs() < 10.0 * f64::EPSILON);
    let bodies = system(
        8,
        &[
            ((1, 5), "-1"),
            ((2, 6), "-1"),
            ((3, 7), "-1"),
            ((4, 8), "-1"),
        ],
        "(x5^2 + x6^2 + x7^2 + x8^2)/2 - 1/sqrt((x1 - x3)^2 + (x2 - x4)^2)",
        &[],
        Convention::HamiltonianFirst,
    );
    let map = taylor(&bodies, 1e-15);
    let jets = |offset: f64| {
        let start = [0.5 + offset, 0.0, -0.5 + offset, 0.0, 0.0, 0.6, 0.0, -0.6];
        let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.5, &start);
        (0..40).for_each(|_| walk.step().expect("a step"));
        walk.statistics().evaluations
    };
    let (near, far) = (jets(0.0), jets(1e5));
    println!("{near} jets about the origin, {far} far from it");
    assert!(
        5 * far <= 6 * near,
        "{near} jets about the origin, {far} far from it"
    );
}

/// Operations of a jet and of all that a substep takes: p(p + 1)/2 products and sums for each of three products of
/// two series, one factor a coefficient, and 4pd for the polynomial and its slope at the end, where it is looked at.
#[test]
fn work_is_pinned() {
    let cases = [
        (rigid_body(), vec![1.0, 3.0, 3.0]),
        (lotka_volterra(), vec![1.0, 1.9, 0.5]),
    ];
    let found: Vec<u64> = cases
        .iter()
        .map(|(system, start)| {
            let map = taylor(system, 1e-15);
            let mut walk = Walk::new(map.as_ref(), &[], 1.0, 1e-6, start);
            walk.step().expect("a step");
            let statistics = walk.statistics();
            assert_eq!(statistics.evaluations, 1);
            statistics.operations.expect("counted")
        })
        .collect();
    println!("{found:?}");
    let (p, d) = (19, 3);
    let others = 4 * p * d + 28 * d + 30;
    let products = d * (p * (p + 1) / 2 + p * (p - 1) / 2);
    // 28 signs, and the field again, of 6 operations; of Lotka–Volterra three sums of two coefficients, one of them times a
    // number.
    assert_eq!(found, [products + p * d + others + 28 + 6, 1626]);
    assert!(found[1] <= products + 4 * p * d + others + 20, "{found:?}");
}
