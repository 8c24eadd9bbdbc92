//! The outer solar system by Kepler's flow and the rest, against an independent program.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use crate::common::{Problem, canonical, splitting, whole};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::solver::StepMap;
use leafwise_core::{PartParameters, Walk};

/// Sun, Jupiter, Saturn, Uranus, Neptune, Pluto in astronomical units and days: masses over the Sun's, places, velocities (Hairer, Lubich, Wanner,
/// Geometric Numerical Integration, section I.2.4).
const MASSES: [f64; 6] = [
    1.000_005_976_82,
    0.000_954_786_104_043,
    0.000_285_583_733_151,
    0.000_043_727_316_454_6,
    0.000_051_775_913_844_9,
    1.0 / 1.3e8,
];
const PLACES: [[f64; 3]; 6] = [
    [0.0; 3],
    [-3.502_365_3, -3.816_984_7, -1.550_796_3],
    [9.075_531_4, -3.045_835_3, -1.648_370_8],
    [8.310_142_0, -16.290_108_6, -7.252_127_8],
    [11.470_766_6, -25.729_482_9, -10.816_945_6],
    [-15.538_735_7, -25.222_559_4, -3.190_238_2],
];
const VELOCITIES: [[f64; 3]; 6] = [
    [0.0; 3],
    [0.005_654_29, -0.004_124_90, -0.001_905_89],
    [0.001_683_18, 0.004_835_25, 0.001_924_62],
    [0.003_541_78, 0.001_371_02, 0.000_550_29],
    [0.002_889_30, 0.001_145_27, 0.000_396_77],
    [0.002_767_25, -0.001_707_02, -0.001_365_04],
];
const GRAVITY: f64 = 2.959_122_082_86e-4;

/// The planets from the Sun and with barycentric momenta, or all six bodies in the frame at rest.
fn outer_solar_system(is_heliocentric: bool) -> Problem {
    let total: f64 = MASSES.iter().sum();
    let drift =
        [0, 1, 2].map(|k| (0..6).map(|i| MASSES[i] * VELOCITIES[i][k]).sum::<f64>() / total);
    let first = usize::from(is_heliocentric);
    let (mut pairs, mut initial) = (Vec::new(), Vec::new());
    let (mut kinetic, mut potential) = (Vec::new(), Vec::new());
    for i in first..6 {
        for k in 0..3 {
            pairs.push([format!("q{i}{k}"), format!("p{i}{k}")]);
            initial.push(PLACES[i][k]);
            let velocity = VELOCITIES[i][k] - if is_heliocentric { drift[k] } else { 0.0 };
            initial.push(MASSES[i] * velocity);
            kinetic.push(format!("p{i}{k}^2/(2*m{i})"));
        }
        if is_heliocentric {
            potential.push(format!("G*m0*m{i}/sqrt(q{i}0^2 + q{i}1^2 + q{i}2^2)"));
        }
        for j in first..i {
            let squares = [0, 1, 2].map(|k| format!("(q{i}{k} - q{j}{k})^2"));
            potential.push(format!("G*m{i}*m{j}/sqrt({})", squares.join(" + ")));
        }
    }
    if is_heliocentric {
        let sums = [0, 1, 2].map(|k| {
            let sum: Vec<String> = (1..6).map(|i| format!("p{i}{k}")).collect();
            format!("({})^2", sum.join(" + "))
        });
        kinetic.push(format!("({})/(2*m0)", sums.join(" + ")));
    }
    let hamiltonian = format!("{} - ({})", kinetic.join(" + "), potential.join(" + "));
    let names: Vec<String> = (0..6).map(|i| format!("m{i}")).collect();
    let mut parameters = vec![("G", GRAVITY)];
    parameters.extend(names.iter().map(String::as_str).zip(MASSES));
    canonical(&pairs, &parameters, hamiltonian, initial)
}

/// The largest change of the energy over 200 000 days, relative to it, looked at as often as the reference does.
fn energy_error(problem: &Problem, map: &dyn StepMap, days: f64, every: u64) -> f64 {
    let system = problem.system();
    let (parameters, steps) = (system.parameter_values(), 200_000.0 / days);
    let energy = system
        .expressions()
        .expect("formulas")
        .hamiltonian()
        .clone();
    let before = energy.evaluate(&problem.initial, &parameters);
    let mut walk = Walk::new(map, &parameters, 1.0, days, &problem.initial);
    let mut most = 0.0_f64;
    for _ in 0..steps as u64 / every {
        walk.advance(every).expect("no collision");
        most = most.max((energy.evaluate(walk.state(), &parameters) / before - 1.0).abs());
    }
    most
}

/// The numbers of an independent program (numpy, Kepler's equation by Newton's method to 10⁻¹⁵), to two digits: Strang's product of Kepler's flow
/// with the rest, and of T + V. Its energy for the first is that of all six bodies in the frame at rest, larger by that of the centre of mass, 2 %.
#[test]
fn the_outer_solar_system_by_kepler_and_the_rest() {
    let problem = outer_solar_system(true);
    let map = whole(&problem.system()).expect("bodies about a centre");
    assert_eq!(map.pieces(), 2);
    for (days, expected) in [(200.0, 3.2e-6), (100.0, 8.5e-7), (50.0, 2.2e-7)] {
        let error = energy_error(&problem, map.as_ref(), days, 5);
        println!("Kepler and rest, {days} days: {error:.2e}");
        assert!((error / expected - 1.0).abs() <= 0.1, "{days}: {error:e}");
    }
    let composed =
        Composed::new(map, Scheme::find("perturbed-8-6-4").expect("a scheme")).expect("two pieces");
    let error = energy_error(&problem, &composed, 100.0, 1);
    println!("perturbed-8-6-4, 100 days: {error:.2e}");
    assert!(error <= 1e-13, "{error:e}");
}

#[test]
fn the_outer_solar_system_by_t_and_v() {
    let problem = outer_solar_system(false);
    // V, T, V as there.
    let order = PartParameters::new().with("pieces", "2 1");
    let map = splitting(&problem.system(), &order).expect("T + V");
    for (days, expected) in [(200.0, 2.0e-3), (100.0, 7.5e-4), (50.0, 2.1e-4)] {
        let error = energy_error(&problem, map.as_ref(), days, 1);
        println!("T + V, {days} days: {error:.2e}");
        assert!((error / expected - 1.0).abs() <= 0.1, "{days}: {error:e}");
    }
}
