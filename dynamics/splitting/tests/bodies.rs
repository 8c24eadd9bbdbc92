//! Free rigid bodies as pieces.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use crate::common::{
    Problem, assert_conserved, distance, gauss, largest, library, run, splitting, step,
};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::diagnostics::{TensorDefect, fit_slope};
use leafwise_core::solver::{StepMap, Structure};
use leafwise_core::{BuildError, PartParameters, PoissonSystem};
use proptest::prelude::*;

fn whole(system: &PoissonSystem) -> Result<Arc<dyn StepMap>, BuildError> {
    splitting(system, &PartParameters::new().with("bodies", "whole"))
}

const KINETIC: &str = "m1^2/(2*I1) + m2^2/(2*I2) + m3^2/(2*I3)";

/// The heavy top without its weight: m and a vector that turns with it.
fn body(inertia: [f64; 3], m: [f64; 3], gamma: [f64; 3]) -> Problem {
    let mut problem = library("heavy-top");
    problem.hamiltonian = KINETIC.to_owned();
    for (name, value) in &mut problem.parameters {
        if let Some(axis) = ["I1", "I2", "I3"].iter().position(|axis| axis == name) {
            *value = inertia[axis];
        }
    }
    problem.initial = [m, gamma].concat();
    problem
}

fn length(x: &[f64]) -> f64 {
    libm::sqrt(x.iter().map(|x| x * x).sum())
}

/// An initial state of a body, how long it moves, in how many steps, and where it is then.
struct Known {
    inertia: [f64; 3],
    state: [f64; 6],
    time: f64,
    steps: usize,
    end: [f64; 6],
    /// What the motion makes of an error of one unit of round-off.
    growth: f64,
}

/// Closed forms and Taylor series of the motion's equations (order 40) in arithmetic of 40 digits: m by
/// `mpmath.ellipfun`, the vector by the quadrature of G(κ₁m₁² + κ₂m₂²)/(m₁² + m₂²), its angle about m.
fn known() -> Vec<Known> {
    vec![
        // A thousand periods of m, 10.08 each: 4000 steps each change the energy by a unit or so, at random, and with it a
        // frequency for the rest of T = 1e4: √4000 T units.
        Known {
            inertia: [1.0, 0.75, 1.25],
            state: [0.5, 1.5, 0.6, 0.6, 0.0, 0.8],
            time: 10_081.827_134_517_95,
            steps: 4000,
            end: [
                0.499_999_999_999_643_95,
                1.500_000_000_000_044_5,
                0.600_000_000_000_185_4,
                0.607_411_086_371_578_9,
                0.547_690_310_700_436_8,
                -0.575_401_682_060_243_4,
            ],
            growth: 6e5,
        },
        // Beside the separatrix, to a relative 2e-7 of m₃: the motion goes from one turn to the middle axis.
        Known {
            inertia: [1.0, 0.75, 1.25],
            state: [-2.0, 1.0, 1.2909945778352505, 0.6, -0.3, 0.8],
            time: 8.0,
            steps: 4,
            end: [
                -2.581_973_660_414_791,
                0.005_431_974_465_336_039,
                0.007_036_375_321_863_54,
                0.177_931_226_853_442_5,
                -0.962_005_425_070_968_2,
                -0.364_535_376_396_385_7,
            ],
            growth: 64.0,
        },
        // Nearly symmetric.
        Known {
            inertia: [1.0, 1.000_000_953_674_316_4, 2.0],
            state: [1.5, -0.7, 2.0, 0.6, -0.3, 0.8],
            time: 20.0,
            steps: 10,
            end: [
                1.251_209_066_334_565_5,
                1.083_732_982_730_316_8,
                1.999_999_673_616_132_3,
                0.495_462_126_062_356,
                0.422_632_999_378_011,
                0.816_026_120_583_475_1,
            ],
            growth: 64.0,
        },
        // Moments that differ by a factor of six.
        Known {
            inertia: [0.3, 1.9, 0.8],
            state: [0.4, -0.7, 1.1, 0.6, -0.3, 0.8],
            time: 10.0,
            steps: 20,
            end: [
                -0.165_044_430_098_698_73,
                -0.328_346_088_252_208_7,
                1.313_373_207_592_902_3,
                -0.160_885_718_272_362_8,
                -0.592_749_629_711_895_7,
                0.844_253_316_328_930_1,
            ],
            growth: 128.0,
        },
    ]
}

#[test]
fn the_flow_is_exact() {
    for known in known() {
        let [m, gamma] = [[0, 1, 2], [3, 4, 5]].map(|at| at.map(|i| known.state[i]));
        let problem = body(known.inertia, m, gamma);
        let system = problem.system();
        let map = whole(&system).expect("a body");
        assert_eq!(map.pieces(), 1);
        let end = run(
            &system,
            map.as_ref(),
            &problem.initial,
            known.time,
            known.steps,
        );
        let error = distance(&end.expect("finite"), &known.end) / largest(known.end);
        println!("{:?}: {:.1} units", known.inertia, error / f64::EPSILON);
        assert!(
            error <= known.growth * f64::EPSILON,
            "{:?}: {error:e}",
            known.inertia
        );
    }
}

/// A body with parameters and a state of its own for one kernel.
#[derive(Clone, Debug)]
struct Case {
    inertia: [f64; 3],
    state: [f64; 6],
    /// √max(p, q) t is at most this.
    angle: f64,
}

impl Case {
    fn time(&self) -> f64 {
        let kappa = self.inertia.map(|i| 1.0 / i);
        let spread = kappa.iter().fold(0.0, |most: f64, a| {
            kappa.iter().fold(most, |most, b| most.max((a - b).abs()))
        });
        // Slow differences do not let the body turn by more than three radians either.
        let fastest = kappa.iter().fold(spread, |most, a| most.max(*a));
        self.angle / (length(&self.state[..3]) * fastest)
    }

    fn energy(&self, x: &[f64]) -> f64 {
        (0..3).map(|l| x[l] * x[l] / (2.0 * self.inertia[l])).sum()
    }

    /// The state after the time: the parameters are a kernel's input.
    fn flow(&self, map: &dyn StepMap, time: f64, state: &[f64]) -> Vec<f64> {
        let [a, b, c] = self.inertia;
        let parameters = [a, b, c, 0.3, 1.0];
        step(map.stepper(1, &parameters, 1.0, time).as_mut(), state).expect("within a nutation")
    }
}

fn case() -> impl Strategy<Value = Case> {
    let inertia = prop_oneof![
        prop::array::uniform3(0.3_f64..3.0),
        // Nearly symmetric, or round.
        (0.3_f64..3.0, 0.3_f64..3.0, 0_i32..60, 0_usize..3).prop_map(|(a, b, digits, axis)| {
            let mut inertia = [a * (1.0 + libm::scalbn(1.0, -digits)); 3];
            inertia[axis] = a;
            inertia[(axis + 1) % 3] = if digits % 2 == 0 { a } else { b };
            inertia
        }),
    ];
    let state = prop::array::uniform6(-2.0_f64..2.0);
    (inertia, state, 0.01_f64..2.9, 0_i32..40).prop_map(|(inertia, mut state, angle, near)| {
        // Every other case beside the separatrix of the axis of I₁: m₂²(κ₁ − κ₂) = m₃²(κ₃ − κ₁).
        let ratio = (1.0 / inertia[1] - 1.0 / inertia[0]) / (1.0 / inertia[0] - 1.0 / inertia[2]);
        if near % 2 == 0 && ratio.is_finite() && ratio > 0.0 {
            state[2] = state[1] * libm::sqrt(ratio) * (1.0 + libm::scalbn(1.0, -near));
        }
        Case {
            inertia,
            state,
            angle,
        }
    })
}

/// The heavy top's body, its middle axis that of I₁ when it is formed: cases have others too.
fn one_map() -> Arc<dyn StepMap> {
    static MAP: std::sync::OnceLock<Arc<dyn StepMap>> = std::sync::OnceLock::new();
    let form = || whole(&body([1.0, 0.75, 1.25], [1.0; 3], [1.0; 3]).system()).expect("a body");
    Arc::clone(MAP.get_or_init(form))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Gauss's method of order 12, good to 1e-14: over at most three radians errors of the state grow by e³ = 20 at most. |m|, |n|
    /// and m·n are kept by rotations, whatever their angle; the energy as the state is right.
    #[test]
    fn bodies_of_any_moments_move_exactly(case in case()) {
        let map = one_map();
        let problem = body(case.inertia, [0, 1, 2].map(|i| case.state[i]), [3, 4, 5].map(|i| case.state[i]));
        let time = case.time();
        let end = case.flow(map.as_ref(), time, &case.state);
        let exact = gauss(&problem.system(), &case.state, time, 40);
        let error = distance(&end, &exact) / largest(&exact);
        prop_assert!(error <= 512.0 * f64::EPSILON, "{:e}", error);
        let product = |x: &[f64], i: usize, j: usize| -> f64 { (0..3).map(|l| x[3 * i + l] * x[3 * j + l]).sum() };
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let change = (product(&end, i, j) - product(&case.state, i, j)).abs();
            let size = length(&case.state[3 * i..][..3]) * length(&case.state[3 * j..][..3]);
            prop_assert!(change <= 16.0 * f64::EPSILON * size, "{} {}: {:e}", i, j, change / size);
        }
        let energy = case.energy(&case.state);
        let change = (case.energy(&end) - energy).abs();
        prop_assert!(change <= 64.0 * f64::EPSILON * energy, "{:e}", change / energy);
    }

    /// φ_s ∘ φ_t = φ_{s+t}, backwards too.
    #[test]
    fn flows_are_a_group(case in case(), part in -0.9_f64..0.9) {
        let case = Case { angle: 0.5 * case.angle, ..case };
        let map = one_map();
        let time = case.time();
        let whole = case.flow(map.as_ref(), time, &case.state);
        let first = case.flow(map.as_ref(), part * time, &case.state);
        let second = case.flow(map.as_ref(), time - part * time, &first);
        let error = distance(&second, &whole) / largest(&whole);
        prop_assert!(error <= 512.0 * f64::EPSILON, "{:e}", error);
    }

    /// DΦ Π DΦᵀ = Π∘Φ: right tangents, for Π.
    #[test]
    fn flows_are_poisson_maps(case in case()) {
        let map = one_map();
        let problem = body(case.inertia, [0, 1, 2].map(|i| case.state[i]), [3, 4, 5].map(|i| case.state[i]));
        let system = problem.system();
        let mut instrument = TensorDefect::new(&system, map.as_ref(), &system.parameter_values(), 1.0, case.time())
            .expect("a tensor");
        let defect = instrument.measure(&case.state).expect("finite");
        let growth = largest(&defect.tangent).max(1.0);
        let bound = 256.0 * f64::EPSILON * defect.scale * growth * growth;
        prop_assert!(defect.norm <= bound, "{:e} > {:e}", defect.norm, bound);
    }
}

/// On the separatrix m₂ = A₂ tanh(λt) from m₂ = 0: the closed form, whose errors the motion itself lets grow by e^{λt}.
#[test]
fn the_separatrix_is_no_exception() {
    // a₁ = a₃ = 1/2, a₂ = −1, so that p = q where m₁² = m₃²; the axes in the order of the moments.
    let (inertia, state) = ([2.0, 1.0, 2.0 / 3.0], [1.0, 0.0, 1.0, 0.3, -0.4, 0.5]);
    let problem = body(inertia, [1.0, 0.0, 1.0], [0.3, -0.4, 0.5]);
    let map = whole(&problem.system()).expect("a body");
    let lambda = libm::sqrt(0.5);
    for time in [0.3, 1.0, 2.0, 3.4] {
        let mut stepper = map.stepper(1, &problem.system().parameter_values(), 1.0, time);
        let end = step(stepper.as_mut(), &state).expect("finite");
        let (tanh, sech) = (libm::tanh(lambda * time), 1.0 / libm::cosh(lambda * time));
        // m₂′ = (κ₃ − κ₁) m₁m₃ = −m₁m₃.
        let exact = [sech, -libm::sqrt(2.0) * tanh, sech];
        let error = distance(&end[..3], &exact);
        println!("{time}: {error:e}");
        assert!(
            error <= 4.0 * libm::exp(lambda * time) * f64::EPSILON,
            "{time}: {error:e}"
        );
        assert!(
            stepper
                .tangent(0)
                .expect("a tangent")
                .iter()
                .all(|d| d.is_finite())
        );
    }
}

/// A body at rest, a round one and one that turns about an axis have flows and tangents as any other.
#[test]
fn nothing_divides_by_what_may_vanish() {
    for (inertia, m) in [
        ([1.0, 0.75, 1.25], [0.0; 3]),
        ([1.0, 0.75, 1.25], [0.0, 0.0, 1.5]),
        ([1.0, 0.75, 1.25], [1.5, 0.0, 0.0]),
        ([1.0; 3], [0.3, -0.5, 1.0]),
        ([2.0, 2.0, 1.0], [0.0, 0.0, -2.0]),
    ] {
        let problem = body(inertia, m, [0.6, 0.0, 0.8]);
        let system = problem.system();
        let values = system.parameter_values();
        let map = whole(&system).expect("a body");
        let mut instrument =
            TensorDefect::new(&system, map.as_ref(), &values, 1.0, 0.7).expect("a tensor");
        let defect = instrument.measure(&problem.initial).expect("finite");
        assert!(
            defect.norm <= 32.0 * f64::EPSILON,
            "{m:?}: {:e}",
            defect.norm
        );
        let exact = gauss(&system, &problem.initial, 0.7, 20);
        let error = distance(&defect.next, &exact);
        assert!(error <= 16.0 * f64::EPSILON, "{m:?}: {error:e}");
    }
}

/// Past half a nutation, and past 64 radians about m, a step is refused.
#[test]
fn steps_that_are_too_long_are_refused() {
    for (m, time, expected) in [
        ([0.5, 1.0, 1.5], 2.0, true),
        ([0.5, 1.0, 1.5], 20.0, false),
        ([0.5, 1.0, 1.5], -20.0, false),
        ([1e-3, 1e-3, 50.0], 1.0, true),
        ([1e-3, 1e-3, 50.0], 3.0, false),
        ([f64::NAN, 0.0, 0.0], 0.1, false),
    ] {
        let problem = body([1.0, 0.999, 1.001], m, [0.6, 0.0, 0.8]);
        let slow = body([1.0, 0.75, 1.25], m, [0.6, 0.0, 0.8]);
        let problem = if m[2] > 10.0 { problem } else { slow };
        let map = whole(&problem.system()).expect("a body");
        let values = problem.system().parameter_values();
        let end = step(
            map.stepper(1, &values, 1.0, time).as_mut(),
            &problem.initial,
        );
        assert_eq!(end.is_ok(), expected, "{m:?} {time}: {end:?}");
    }
}

/// T + V of the heavy top.
#[test]
fn compositions_over_body_and_weight_have_their_orders() {
    let problem = library("heavy-top");
    let system = problem.system();
    let exact = gauss(&system, &problem.initial, 1.0, 200);
    let base = whole(&system).expect("a body and its weight");
    assert_eq!((base.pieces(), base.properties().order), (2, 2));
    assert_eq!(base.properties().structure, Structure::Exact);
    for (name, order, steps) in [
        ("", 2.0, [32, 45, 64, 90, 128]),
        ("blanes-moan-6", 6.0, [3, 4, 5, 6, 8]),
        ("nystrom-6", 6.0, [3, 4, 5, 6, 8]),
        ("suzuki-umeno-8", 8.0, [6, 7, 8, 9, 10]),
    ] {
        let map = match Scheme::find(name) {
            None => Arc::clone(&base),
            Some(scheme) => Arc::new(Composed::new(Arc::clone(&base), scheme).expect("two pieces")),
        };
        let points = steps.map(|steps| {
            let end = run(&system, map.as_ref(), &problem.initial, 1.0, steps).expect("finite");
            (1.0 / steps as f64, distance(&end, &exact) / largest(&exact))
        });
        let slope = fit_slope(&points, 20.0 * f64::EPSILON).expect("points above round-off");
        println!("{name}: {} {points:?}", slope.exponent);
        assert!(
            (slope.exponent - order).abs() < 0.5,
            "{name}: {}",
            slope.exponent
        );
    }
}

/// Casimirs over 2,000 steps, as of other splittings; and the energy of a body alone, whose flow is its motion.
#[test]
fn casimirs_stay_at_round_off() {
    for id in ["rigid-body", "heavy-top", "se3", "so4"] {
        let problem = library(id);
        let system = problem.system();
        let formulas = system.expressions().expect("formulas");
        let energy = (id == "rigid-body").then(|| formulas.hamiltonian());
        let map = whole(&system).expect("a body");
        assert_conserved(&problem, map.as_ref(), energy.as_slice());
    }
}

/// Bodies of the library, with what is left beside them; so(4) is a body with a vector, one component of which has a sign, and
/// another one.
#[test]
fn bodies_are_found() {
    for (id, pieces) in [("rigid-body", 1), ("heavy-top", 2), ("se3", 2), ("so4", 3)] {
        let problem = library(id);
        let system = problem.system();
        let map = whole(&system).expect("a body");
        assert_eq!(map.pieces(), pieces, "{id}");
        let exact = gauss(&system, &problem.initial, 0.5, 100);
        let composed = Composed::new(map, Scheme::find("suzuki-umeno-8").expect("a scheme"));
        let end = run(
            &system,
            &composed.expect("self-adjoint"),
            &problem.initial,
            0.5,
            40,
        );
        let error = distance(&end.expect("finite"), &exact) / largest(&exact);
        assert!(error <= 1e-13, "{id}: {error:e}");
    }
}

#[test]
fn what_is_no_body_is_refused() {
    for (id, hamiltonian) in [
        ("lotka-volterra", None),
        ("heavy-top", Some("m1^2/(2*I1) + chi3*gamma3")),
        ("heavy-top", Some("gamma1^2 + 2*gamma2^2 + m1*m2")),
        // so(2, 1).
        ("three-wave", None),
    ] {
        let mut problem = library(id);
        if let Some(hamiltonian) = hamiltonian {
            problem.hamiltonian = hamiltonian.to_owned();
        }
        let refusal = whole(&problem.system()).err();
        println!("{refusal:?}");
        assert!(
            matches!(&refusal, Some(BuildError::DoesNotFit { part: "splitting", reason }) if reason.contains("so(3)")),
            "{id}: {refusal:?}"
        );
    }
    let system = library("heavy-top").system();
    let refusal = splitting(&system, &PartParameters::new().with("bodies", "all")).err();
    let expected =
        matches!(&refusal, Some(BuildError::Parameter { parameter, .. }) if parameter == "bodies");
    assert!(expected, "{refusal:?}");
}

/// Operations of the flow of a body alone and with a vector, and of Strang's product about three axes instead.
#[test]
fn the_flow_takes_so_many_operations() {
    let operations = |system: &PoissonSystem, bodies: &str| {
        let parameters = PartParameters::new().with("bodies", bodies);
        let map = splitting(system, &parameters).expect("splits");
        let (_, kernel) = map.abilities().kernels[0];
        kernel.step_operations().total()
    };
    let alone = library("rigid-body").system();
    let with_vector = body([1.0, 0.75, 1.25], [1.0; 3], [1.0; 3]).system();
    let counted = [
        operations(&alone, "whole"),
        operations(&with_vector, "whole"),
        operations(&with_vector, "axes"),
    ];
    assert_eq!(counted, [168, 559, 104]);
}

#[test]
fn lanes_have_the_bits_they_have_alone() {
    let problem = library("heavy-top");
    let system = problem.system();
    let parameters = system.parameter_values();
    let map = whole(&system).expect("a body");
    for lanes in [2, 8, 11] {
        let many: Vec<f64> = parameters.iter().flat_map(|p| vec![*p; lanes]).collect();
        let mut wide = map.stepper(lanes, &many, 1.0, 0.1);
        let x: Vec<f64> = (0..6 * lanes)
            .map(|at| problem.initial[at / lanes] + (at % lanes) as f64 / 16.0)
            .collect();
        let (mut increment, mut outcome) = (vec![0.0; 6 * lanes], vec![Ok(()); lanes]);
        wide.increment(&x, &vec![0.0; 6 * lanes], &mut increment, &mut outcome);
        for lane in 0..lanes {
            let own: Vec<f64> = x.iter().skip(lane).step_by(lanes).copied().collect();
            let mut alone = map.stepper(1, &parameters, 1.0, 0.1);
            let end = step(alone.as_mut(), &own).expect("finite");
            for i in 0..6 {
                let at = i * lanes + lane;
                assert_eq!((x[at] + increment[at]).to_bits(), end[i].to_bits());
            }
            assert_eq!(alone.tangent(0), wide.tangent(lane));
        }
    }
}

/// m alone turns another way to the same end.
#[test]
fn a_body_alone_moves_as_one_with_a_vector() {
    let alone = library("rigid-body");
    let map = whole(&alone.system()).expect("a body");
    for (m, time) in [
        ([1.0, 3.0, 3.0], 0.2),
        ([1.0, 3.0, 3.0], 1.2),
        ([1.0, 3.0, 3.0], -1.2),
        ([0.0; 3], 1.0),
        ([0.0, 0.0, 2.0], 1.0),
        ([2.0, 0.0, 1e-9], 1.5),
    ] {
        let system = alone.system();
        let exact = gauss(&system, &m, time, 100);
        let mut instrument =
            TensorDefect::new(&system, map.as_ref(), &system.parameter_values(), 1.0, time)
                .expect("a tensor");
        let defect = instrument.measure(&m).expect("finite");
        let size = largest(&exact).max(f64::MIN_POSITIVE);
        let error = distance(&defect.next, &exact) / size;
        let growth = largest(&defect.tangent);
        println!("{m:?} {time}: {error:.1e} {:.1e}", defect.norm);
        assert!(error <= 16.0 * f64::EPSILON, "{m:?} {time}: {error:e}");
        assert!(defect.norm <= 32.0 * f64::EPSILON * growth * growth * defect.scale.max(1.0));
    }
}
