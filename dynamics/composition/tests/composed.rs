//! Compositions over Karasev + Hamilton–Jacobi of order 2 on the rigid body.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use crate::common::{distance, gauss, largest, observe, rigid_body, run, step};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::diagnostics::{TensorDefect, fit_slope};
use leafwise_core::registry::Registry;
use leafwise_core::solver::{MapProperties, StepMap, Stepper};
use leafwise_core::{
    BuildError, Method, PartParameters, PoissonSystem, StepError, Structure, Walk,
};
use leafwise_hamilton_jacobi::HamiltonJacobi;
use leafwise_karasev::TruncatedKarasev;

const INITIAL: [f64; 3] = [1.0, 3.0, 3.0];

/// K-HJ of order m over the truncation of order n.
fn base(system: &PoissonSystem, n: usize, m: usize) -> Arc<dyn StepMap> {
    let realization = TruncatedKarasev::new(system, n).expect("an order above 0");
    let dynamics = HamiltonJacobi::new(m).expect("an even order");
    let method = Method::compose(system, Arc::new(realization), Arc::new(dynamics));
    Arc::new(method.expect("the parts fit"))
}

fn composed(base: Arc<dyn StepMap>, name: &str) -> Arc<dyn StepMap> {
    let registry = Registry::with_builtin();
    let part = registry.composition(name).expect("a built-in composition");
    part.build(base, &PartParameters::new())
        .expect("a self-adjoint base")
}

/// The schemes that take any self-adjoint map.
fn of_stages() -> impl Iterator<Item = Scheme> {
    Scheme::all().into_iter().filter(|s| !s.takes_factors())
}

/// The window of step sizes of a claim: errors between the pre-asymptotic range and round-off.
struct Window {
    name: &'static str,
    order: f64,
    time: f64,
    steps: &'static [usize],
}

/// Global errors over `time`, against Gauss's method. Global errors of compensated steps stay near
/// an ulp of the state (3), 4.4e-16 here: points under 20 times that are dropped. At order 8 the
/// window is a decade of steps, at order 10 less than one: three to five points between 1e-7 and
/// 1e-14, where the next term (smaller by h²) bends the slope by up to half an order.
const WINDOWS: [Window; 8] = [
    Window {
        name: "triple-jump",
        order: 4.0,
        time: 2.0,
        steps: &[32, 45, 64, 90, 128, 181],
    },
    Window {
        name: "suzuki-4",
        order: 4.0,
        time: 2.0,
        steps: &[16, 22, 32, 45, 64, 90],
    },
    Window {
        name: "yoshida-6",
        order: 6.0,
        time: 2.0,
        steps: &[24, 32, 45, 64, 90, 128],
    },
    Window {
        name: "kahan-li-6",
        order: 6.0,
        time: 2.0,
        steps: &[16, 22, 32, 45, 64, 90],
    },
    Window {
        name: "suzuki-umeno-8",
        order: 8.0,
        time: 2.0,
        steps: &[11, 16, 22, 32, 45],
    },
    Window {
        name: "kahan-li-8",
        order: 8.0,
        time: 2.0,
        steps: &[8, 11, 16, 22, 32],
    },
    Window {
        name: "kahan-li-10",
        order: 10.0,
        time: 2.0,
        steps: &[12, 14, 16, 19, 22, 26],
    },
    Window {
        name: "sofroniou-spaletta-10",
        order: 10.0,
        time: 2.0,
        steps: &[6, 7, 8, 9, 10, 11, 12],
    },
];

#[test]
fn compositions_have_their_declared_order() {
    let system = rigid_body();
    let base = base(&system, 12, 2);
    for window in &WINDOWS {
        let exact = gauss(&system, &INITIAL, window.time, 200);
        let map = composed(Arc::clone(&base), window.name);
        let points: Vec<(f64, f64)> = window
            .steps
            .iter()
            .map(|&steps| {
                let end =
                    run(&system, map.as_ref(), &INITIAL, window.time, steps).expect("converges");
                (
                    window.time / steps as f64,
                    distance(&end, &exact) / largest(&exact),
                )
            })
            .collect();
        let slope = fit_slope(&points, 20.0 * f64::EPSILON).expect("points above round-off");
        println!("{}: {slope:?} {points:?}", window.name);
        assert!(
            (slope.exponent - window.order).abs() < 0.5,
            "{}: {slope:?}",
            window.name
        );
        assert_eq!(map.properties().order as f64, window.order);
    }
}

#[test]
fn the_declared_order_is_the_larger_of_scheme_and_base() {
    let system = rigid_body();
    for (m, name, expected) in [(2, "suzuki-4", 4), (6, "suzuki-4", 6), (4, "kahan-li-6", 6)] {
        let properties = composed(base(&system, 8, m), name).properties();
        assert_eq!(properties.order, expected);
        assert_eq!(properties.structure, Structure::Order(8));
        assert_eq!(properties.self_adjoint, Some(true));
    }
}

/// One step forwards and one backwards. A step of Newton's method leaves a few ulps of the state a
/// stage, and stages run back and forth over Σ|γ_i| ≤ 14 steps.
#[test]
fn compositions_are_self_adjoint() {
    let system = rigid_body();
    let parameters = system.parameter_values();
    for scheme in of_stages() {
        let map = Composed::new(base(&system, 6, 2), scheme).expect("a self-adjoint base");
        let there = step(map.stepper(1, &parameters, 1.0, 0.1).as_mut(), &INITIAL);
        let back = step(
            map.stepper(1, &parameters, 1.0, -0.1).as_mut(),
            &there.expect("converges"),
        );
        let defect = distance(&back.expect("converges"), &INITIAL) / largest(INITIAL);
        println!("{}: {defect:.1e}", scheme.info.name);
        let bound = 2.0 * scheme.stages() as f64 * f64::EPSILON;
        assert!(defect <= bound, "{}: {defect:e}", scheme.info.name);
    }
}

/// |x|² over 400 steps: every truncation conserves it on so(3)*, and so does every composition.
///
/// Rounding the end to doubles takes a few ulps of the sum of squares. A stage rounds its increment,
/// of relative size h|γ_i| times the rate (about 1), by a few units u, which adds up as a random
/// walk over steps × s stages; six standard deviations of one u each.
#[test]
fn casimirs_stay_at_round_off() {
    let system = rigid_body();
    let casimir = &system.expressions().expect("formulas").casimirs()[0].expression;
    let (steps, h) = (400, 0.1);
    for scheme in of_stages() {
        let map = Composed::new(base(&system, 6, 2), scheme).expect("a self-adjoint base");
        let end = run(&system, &map, &INITIAL, h * steps as f64, steps).expect("converges");
        let drift = observe(&system, &[casimir], &end)[0] / 19.0 - 1.0;
        let gammas = scheme.coefficients();
        let squares: f64 = gammas.iter().map(|g| g * g).sum();
        let walk = libm::sqrt(steps as f64 * squares) * h * f64::EPSILON / 2.0;
        println!("{}: drift {drift:.1e}, walk {walk:.1e}", scheme.info.name);
        let bound = 4.0 * f64::EPSILON + 6.0 * walk;
        assert!(
            drift.abs() <= bound,
            "{}: {drift:e} > {bound:e}",
            scheme.info.name
        );
    }
}

/// The tangent against central differences of the map itself, and the tensor defect of a map whose
/// truncation leaves O(tⁿ⁺¹).
#[test]
fn the_tangent_is_the_product_of_the_stages_tangents() {
    let system = rigid_body();
    let parameters = system.parameter_values();
    let map = composed(base(&system, 12, 2), "kahan-li-8");
    let mut instrument =
        TensorDefect::new(&system, map.as_ref(), &parameters, 1.0, 0.05).expect("a tensor");
    let defect = instrument.measure(&INITIAL).expect("converges");
    let delta = 1e-5;
    let mut stepper = map.stepper(1, &parameters, 1.0, 0.05);
    for j in 0..3 {
        let ends = [delta, -delta].map(|shift| {
            let mut x = INITIAL;
            x[j] += shift;
            stepper.restart();
            step(stepper.as_mut(), &x).expect("converges")
        });
        for i in 0..3 {
            let slope = (ends[0][i] - ends[1][i]) / (2.0 * delta);
            let error = (slope - defect.tangent[i * 3 + j]).abs();
            // δ² times third derivatives of size h, and ulps of the state over δ.
            assert!(error < 1e-9, "({i}, {j}): {error:e}");
        }
    }
    println!("tensor defect {:.1e} of {:.1e}", defect.norm, defect.scale);
    assert!(defect.norm <= 64.0 * f64::EPSILON * defect.scale);
}

#[test]
fn a_restored_run_continues_to_the_same_bits() {
    let system = rigid_body();
    let parameters = system.parameter_values();
    let map = composed(base(&system, 6, 2), "suzuki-umeno-8");
    let mut whole = Walk::new(map.as_ref(), &parameters, 1.0, 0.1, &INITIAL);
    for _ in 0..20 {
        whole.step().expect("converges");
    }
    let checkpoint = whole.checkpoint();
    let mut resumed = Walk::new(map.as_ref(), &parameters, 1.0, 0.1, &INITIAL);
    resumed.restore(&checkpoint).expect("the same method");
    for _ in 0..20 {
        whole.step().expect("converges");
        resumed.step().expect("converges");
        assert_eq!(whole.checkpoint(), resumed.checkpoint());
    }
    let mut shorter = checkpoint;
    shorter.memory.pop();
    let expected = shorter.memory.len() + 1;
    assert_eq!(resumed.restore(&shorter), Err(expected));
}

/// Eight lanes of which one fails at every step: the others have the bits they have alone.
#[test]
fn a_lane_does_not_depend_on_its_neighbours() {
    let system = rigid_body();
    let parameters = system.parameter_values();
    let map = composed(base(&system, 6, 2), "kahan-li-6");
    let lanes = 8;
    let many: Vec<f64> = parameters.iter().flat_map(|p| vec![*p; lanes]).collect();
    let mut wide = map.stepper(lanes, &many, 1.0, 0.1);
    let start = |lane: usize| {
        INITIAL.map(|v| {
            if lane == 3 {
                f64::NAN
            } else {
                v + lane as f64 / 10.0
            }
        })
    };
    let mut x = vec![0.0; 3 * lanes];
    for lane in 0..lanes {
        (0..3).for_each(|i| x[i * lanes + lane] = start(lane)[i]);
    }
    let mut alone: Vec<_> = (0..lanes)
        .map(|lane| (map.stepper(1, &parameters, 1.0, 0.1), start(lane).to_vec()))
        .collect();
    for _ in 0..4 {
        let mut increment = vec![0.0; 3 * lanes];
        let mut outcome = vec![Ok(()); lanes];
        wide.increment(&x, &vec![0.0; 3 * lanes], &mut increment, &mut outcome);
        for (lane, (stepper, state)) in alone.iter_mut().enumerate() {
            assert_eq!(outcome[lane].is_err(), lane == 3);
            if let Ok(next) = step(stepper.as_mut(), state) {
                *state = next;
            }
            for i in 0..3 {
                let at = i * lanes + lane;
                if lane == 3 {
                    assert_eq!(increment[at], 0.0);
                } else {
                    x[at] += increment[at];
                    assert_eq!(x[at].to_bits(), state[i].to_bits());
                }
            }
        }
    }
    assert_eq!(wide.statistics().steps, 32);
    assert_eq!(wide.statistics().failures, 4);
    assert!(wide.statistics().evaluations_per_step() > 9.0);
}

/// Explicit Euler, whose adjoint is implicit.
struct Euler;

impl StepMap for Euler {
    fn dimension(&self) -> usize {
        3
    }
    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 1,
            structure: Structure::None,
            self_adjoint: None,
        }
    }
    fn describe(&self) -> String {
        "euler".to_owned()
    }
    fn stepper(&self, _: usize, _: &[f64], _: f64, _: f64) -> Box<dyn Stepper> {
        unreachable!("a refused map is never stepped")
    }
}

#[test]
fn a_map_that_is_not_known_to_be_self_adjoint_is_refused() {
    for scheme in Scheme::all() {
        let refusal = Composed::new(Arc::new(Euler), scheme).err();
        let (composition, map) = (scheme.info.name, "euler".to_owned());
        let expected = if scheme.takes_factors() {
            BuildError::NoFactors {
                composition,
                map,
                is_self_adjoint: false,
            }
        } else {
            BuildError::NotComposable { composition, map }
        };
        assert_eq!(refusal, Some(expected));
        assert_eq!(Scheme::find(scheme.info.name), Some(scheme));
    }
}

#[test]
fn a_map_without_factors_is_refused_where_they_are_needed() {
    let system = rigid_body();
    let registry = Registry::with_builtin();
    for (name, orders) in [("blanes-moan-4", "order 4"), ("blanes-moan-6", "order 6")] {
        let part = registry.composition(name).expect("a built-in composition");
        assert!(part.info.declares.starts_with(orders));
        let refusal = part.build(base(&system, 4, 2), &PartParameters::new());
        let message = registry.explain(&refusal.err().expect("no factors"));
        assert!(message.starts_with(name), "{message}");
        // Nothing that splits is linked here: what is named is there.
        let advised = "; take a composition of self-adjoint maps, such as suzuki-4 or kahan-li-6";
        assert!(message.ends_with(advised), "{message}");
    }
}

#[test]
fn a_composition_takes_no_parameter() {
    let registry = Registry::with_builtin();
    let part = registry
        .composition("suzuki-4")
        .expect("a built-in composition");
    let parameters = PartParameters::new().with("order", 4);
    let refusal = part.build(base(&rigid_body(), 4, 2), &parameters).err();
    assert!(
        matches!(refusal, Some(BuildError::UnknownParameter { .. })),
        "{refusal:?}"
    );
}

/// A composition is a self-adjoint map, so it can be composed again: Suzuki's fractal.
#[test]
fn compositions_nest() {
    let system = rigid_body();
    let map = composed(composed(base(&system, 8, 2), "suzuki-4"), "triple-jump");
    assert_eq!(map.properties().order, 4);
    let end: Result<Vec<f64>, StepError> = run(&system, map.as_ref(), &INITIAL, 1.0, 10);
    let exact = gauss(&system, &INITIAL, 1.0, 100);
    assert!(distance(&end.expect("converges"), &exact) < 1e-3);
}
