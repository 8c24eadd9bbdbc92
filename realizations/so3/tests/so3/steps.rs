//! Claims about Hamilton–Jacobi steps over each realization, on the paper's rigid body.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::common::{
    INERTIA, ThroughChart, UNIT, all, body, distance, flow, largest, norm, state, sum,
};
use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::realization::RealizationData;
use leafwise_core::{Method, PoissonSystem, StepError, StepMap, Walk};
use leafwise_hamilton_jacobi::HamiltonJacobi;
use leafwise_so3::{Chart, So3Exponential, So3Group};
use proptest::prelude::*;

/// The system's one parameter, which the body does not read.
const PARAMETERS: [f64; 1] = [1.5];
const INITIAL: [f64; 3] = [1.0, 3.0, 3.0];

fn method(system: &PoissonSystem, realization: Arc<dyn RealizationData>, m: usize) -> Method {
    let dynamics = Arc::new(HamiltonJacobi::new(m).expect("an even order"));
    let method = Method::compose(system, realization, dynamics).expect("the parts fit");
    assert_eq!(method.path(), "one kernel");
    method
}

fn run(map: &Method, epsilon: f64, time: f64, steps: usize) -> Vec<f64> {
    let h = time / epsilon / steps as f64;
    let mut walk = Walk::new(map, &PARAMETERS, epsilon, h, &INITIAL);
    for _ in 0..steps {
        walk.step().expect("inside the chart");
    }
    walk.state().to_vec()
}

/// The order seen between the two finest step sizes whose errors are above `floor`, and how far it
/// may be from the true one: errors c hᵐ(1 + k h²) give slopes whose excess falls fourfold with
/// every halving, so that three times the last excess is the last change; the change itself leaves
/// room for the next term.
fn measured_order(map: &Method, floor: f64) -> (f64, f64) {
    let time = 2.0;
    let reference = flow(&INITIAL, time);
    let errors: Vec<f64> = (0..7)
        .map(|k| distance(&run(map, 0.5, time, 8 << k), &reference))
        .take_while(|error| *error > floor)
        .collect();
    let slopes: Vec<f64> = errors.windows(2).map(|e| libm::log2(e[0] / e[1])).collect();
    let [.., before, last] = slopes.as_slice() else {
        panic!("three errors above round-off: {errors:?}");
    };
    (*last, (last - before).abs())
}

#[test]
fn hamilton_jacobi_has_order_m_over_each_realization() {
    let system = body();
    for realization in all(&system) {
        for m in [2, 4, 6, 8] {
            let map = method(&system, Arc::clone(&realization), m);
            // The oracle and 10³ steps are good to 1e-14: above 1e-12 a slope to 0.02.
            let (order, tolerance) = measured_order(&map, 1e-12);
            println!(
                "{} m = {m}: order {order:.3} +- {tolerance:.3}",
                realization.describe()
            );
            assert!((order - m as f64).abs() <= tolerance + 0.02, "{order}");
        }
    }
}

/// S_3 belongs to its chart: Karasev's in the Cayley chart leaves the error of S_1.
#[test]
fn karasev_s_third_coefficient_in_the_cayley_chart_gives_order_2() {
    let system = body();
    let [exponential, cayley] = [Chart::Exponential, Chart::Cayley].map(|chart| {
        let realization: Arc<dyn RealizationData> = chart.realize(&system).expect("so(3)*");
        realization
    });
    for (maps, series, expected) in [
        (&cayley, &exponential, 2.0),
        (&exponential, &cayley, 2.0),
        (&cayley, &cayley, 4.0),
        (&exponential, &exponential, 4.0),
    ] {
        let mixed = Arc::new(ThroughChart {
            maps: Arc::clone(maps),
            series: Arc::clone(series),
        });
        let (order, tolerance) = measured_order(&method(&system, mixed, 4), 1e-12);
        println!(
            "maps of {}, S_3 of {}: order {order:.3}",
            maps.describe(),
            series.describe()
        );
        assert!((order - expected).abs() <= tolerance + 0.02, "{order}");
    }
}

/// The increment of one cold step.
fn increment(map: &Method, epsilon: f64, h: f64, x: &[f64]) -> Result<Vec<f64>, StepError> {
    let mut increment = vec![0.0; 3];
    let mut outcome = [Ok(())];
    map.stepper(1, &PARAMETERS, epsilon, h)
        .increment(x, &[0.0; 3], &mut increment, &mut outcome);
    let [outcome] = outcome;
    outcome.map(|()| increment)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// The step's tensor defect and the change of |x|² in one step, against 64 u of the largest
    /// summand; the solve's matrix is within ½ of the identity at these steps, its condition below
    /// 4.
    #[test]
    fn every_step_is_a_poisson_map_to_round_off(
        x in state(),
        t in 0.01..0.2_f64,
        m in prop::sample::select(vec![2_usize, 4, 6, 8]),
    ) {
        let system = body();
        for realization in all(&system) {
            let map = method(&system, Arc::clone(&realization), m);
            let mut instrument =
                TensorDefect::new(&system, &map, &PARAMETERS, 0.5, 2.0 * t).expect("a tensor");
            let defect = instrument.measure(&x).expect("inside the chart");
            let size = largest(&defect.tangent);
            let bound = 64.0 * UNIT * 4.0 * size * size * defect.scale;
            prop_assert!(defect.norm <= bound, "{}: {:e}", map.describe(), defect.norm);
            let change = increment(&map, 0.5, 2.0 * t, &x).expect("inside the chart");
            let casimir: f64 = x.iter().map(|x| x * x).sum();
            // |x + δ|² − |x|² without cancellation.
            let growth: f64 = x.iter().zip(&change).map(|(x, d)| d * (2.0 * x + d)).sum();
            prop_assert!(growth.abs() <= 64.0 * UNIT * casimir, "{growth:e}");
        }
    }

    /// One map in two sets of coordinates, over one step.
    #[test]
    fn the_group_steps_as_the_cotangent_bundle_does(
        x in state(),
        t in 0.01..0.3_f64,
        m in prop::sample::select(vec![2_usize, 4, 6]),
    ) {
        let system = body();
        for chart in [Chart::Exponential, Chart::Cayley] {
            let flat = chart.realize(&system).expect("so(3)*");
            let group = Arc::new(So3Group::new(&system, chart).expect("so(3)*"));
            let expected = increment(&method(&system, flat, m), 1.0, t, &x).expect("a step");
            let found = increment(&method(&system, group, m), 1.0, t, &x).expect("a step");
            // The residual is formed from numbers of the size of x.
            let error = distance(&found, &expected) / largest(&x);
            prop_assert!(error <= 64.0 * UNIT, "{chart:?}: {error:e}");
        }
    }
}

#[test]
fn the_casimir_and_the_tensor_are_kept() {
    let system = body();
    let casimir = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    const STEPS: usize = 10_000;
    for realization in all(&system) {
        for m in [2, 8] {
            let map = method(&system, Arc::clone(&realization), m);
            let mut instrument =
                TensorDefect::new(&system, &map, &PARAMETERS, 1.0, 0.1).expect("a tensor");
            let defect = instrument.measure(&INITIAL).expect("inside the chart");
            let mut walk = Walk::new(&map, &PARAMETERS, 1.0, 0.1, &INITIAL);
            let mut drift = 0.0_f64;
            for _ in 0..STEPS {
                walk.step().expect("inside the chart");
                let change = casimir(walk.state()) - casimir(&INITIAL);
                drift = drift.max(change.abs() / casimir(&INITIAL));
            }
            println!(
                "{} m = {m}: tensor defect {:.1e} of {:.1}, Casimir {drift:.1e} over {STEPS} \
                 steps, {:.2} evaluations a step of {}",
                realization.describe(),
                defect.norm,
                defect.scale,
                walk.statistics().evaluations_per_step(),
                map.newton().expect("one kernel").operations(),
            );
            assert!(defect.norm <= 64.0 * UNIT * 4.0 * defect.scale);
            assert!(drift <= 64.0 * UNIT);
        }
    }
}

/// det D(β∘L) of m = 2 in the exponential chart at y = x e₁, with p = θ e₁. Across the axis it is
/// 1 + (cθ ∓ ½ e₁×) diag(a, b), a = θ(I₁/I₂ − 1), b = θ(I₁/I₃ − 1), cθ = (1 − (θ/2) cot(θ/2))/θ.
fn determinant(turn: f64) -> f64 {
    let c = (1.0 - 0.5 * turn / libm::tan(0.5 * turn)) / turn;
    let [a, b] = [1, 2].map(|i| turn * (INERTIA[0] / INERTIA[i] - 1.0));
    (1.0 + c * a) * (1.0 + c * b) + 0.25 * a * b
}

/// A body that spins about its first axis stands still, whatever the step; θ = t x1/I1 tells how
/// far its bisection reaches into the chart.
#[test]
fn the_exponential_chart_ends_before_2_pi_with_a_typed_error() {
    let system = body();
    for realization in all(&system) {
        let wall = realization.describe().contains("exponential");
        for m in [2, 4] {
            let map = method(&system, Arc::clone(&realization), m);
            for ratio in [0.5, 0.9, 0.998, 0.9995, 0.99999, 1.0, 1.5, 3.0, 1e3] {
                let x = [ratio * TAU * INERTIA[0] / 0.3, 0.0, 0.0];
                let outcome = increment(&map, 0.1, 3.0, &x);
                match outcome {
                    Ok(change) => {
                        assert!(!wall || ratio < 0.999, "{} {ratio}", map.describe());
                        assert_eq!(change, [0.0; 3]);
                    }
                    Err(StepError::LeftChart { ratio: found }) => {
                        assert!(wall && ratio > 0.999 && found >= 1.0, "{found}");
                    }
                    // The state's own solution y = x lies beyond a fold.
                    Err(StepError::OtherBranch { reached }) if wall && m == 2 && ratio < 1.0 => {
                        let turn = ratio * TAU;
                        assert!(determinant(turn) <= 0.0, "{ratio}: {reached}");
                        assert!(determinant(reached * turn) > 0.0, "{ratio}: {reached}");
                    }
                    // Beyond half a turn; S_3 grows like the cube of the turn, in every chart.
                    Err(StepError::OtherBranch { .. }) => assert!(ratio > 0.5, "{ratio}"),
                    Err(other) => panic!("{} {ratio}: {other}", map.describe()),
                }
            }
        }
    }
}

/// A fast tumbling body: steps of any size are inside the chart or refused.
#[test]
fn a_fast_body_never_gets_a_number_from_outside_the_chart() {
    let system = body();
    let flat: Arc<dyn RealizationData> = Arc::new(So3Exponential::new(&system).expect("so(3)*"));
    let group: Arc<dyn RealizationData> =
        Arc::new(So3Group::new(&system, Chart::Exponential).expect("so(3)*"));
    for realization in [flat, group] {
        let map = method(&system, realization, 2);
        let (mut steps, mut left, mut other) = (0, 0, 0);
        for k in 0..200 {
            let t = 0.05 * f64::from(k + 1);
            let mut stepper = map.stepper(1, &PARAMETERS, 1.0, t);
            let (mut change, mut outcome) = (vec![0.0; 3], [Ok(())]);
            stepper.increment(&INITIAL, &[0.0; 3], &mut change, &mut outcome);
            match &outcome[0] {
                Ok(()) => {
                    steps += 1;
                    let y = stepper.solution(0).expect("a bisection");
                    let omega: Vec<f64> = y.iter().zip(INERTIA).map(|(y, i)| y / i).collect();
                    let angle = t * norm(&omega);
                    assert!(angle < TAU, "t = {t}: {angle}");
                    let next = sum(&INITIAL, &change);
                    let error = (norm(&next) / norm(&INITIAL) - 1.0).abs();
                    assert!(error <= 1e-12, "t = {t}: {error:e}");
                }
                Err(StepError::LeftChart { .. }) => left += 1,
                Err(_) => other += 1,
            }
        }
        println!(
            "{}: {steps} steps, {left} left the chart, {other} did not converge",
            map.describe()
        );
        // The others are refused: beyond the chart, or because the solution that begins at the state ends inside.
        assert!(steps > 0 && left + other > 0);
    }
}
