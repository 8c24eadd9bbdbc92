//! Quadratic Casimirs that are held, and by how much.

use leafwise_clebsch::casimirs::{Held, Square};
use leafwise_core::{PoissonSystem, StepMap, Walk};
use leafwise_expression::Rational;
use leafwise_logarithms::Logarithms;
use leafwise_tests::library;
use leafwise_tests::numbers::UNIT_ROUNDOFF;

use super::common::{gauss, over};

const STAGES: usize = 8;

fn held(
    system: &PoissonSystem,
    method: &dyn StepMap,
    (time_step, steps): (f64, u64),
    x: &[f64],
) -> f64 {
    let parameters = system.parameter_values();
    let mut walk = Walk::new(method, &parameters, 1.0, time_step, x);
    for _ in 0..steps {
        walk.step().expect("a step");
    }
    walk.statistics().held
}

/// Planted growth of |x|² is found, told as a part of it, and taken off.
#[test]
fn what_is_told_is_what_was_taken_off() {
    let one = Rational::one;
    let square: Square = (0..3).map(|i| ((i, i), one())).collect();
    let held = Held::of(&[square]);
    let x = [1.0, 2.0, -2.0];
    for scale in [1.0, libm::exp2(300.0), libm::exp2(-300.0)] {
        for planted in [libm::exp2(-20.0), -libm::exp2(-40.0)] {
            let x = x.map(|x| scale * x);
            let mut increment = [scale * planted, 0.0, 0.0];
            let told = held.hold(&x, &[0.0; 3], &mut increment);
            let growth = planted * (2.0 + planted);
            let expected = (growth / (9.0 + growth)).abs();
            assert!(
                (told - expected).abs() <= 8.0 * UNIT_ROUNDOFF * expected,
                "{told:e}, {expected:e}"
            );
            // Newton's correction leaves the square of what it takes off.
            let left = held.hold(&x, &[0.0; 3], &mut increment);
            assert!(
                left <= told * told + 8.0 * UNIT_ROUNDOFF * told,
                "{left:e} of {told:e}"
            );
        }
    }
}

/// A coordinate of an increment is a form of four products in sums of eight stages: eight roundings after one another. A summand of a
/// Casimir has two factors, and both Casimirs of the top, as that of the body, three summands.
#[test]
fn steps_take_off_their_round_off() {
    for (id, time_step) in [("rigid-body", 0.4), ("heavy-top", 0.2)] {
        let problem = library(id);
        let method = gauss(&problem.system, STAGES);
        let steps = (time_step, 10_000);
        let found = held(&problem.system, &method, steps, &problem.initial);
        let bound = 2.0 * 3.0 * 8.0 * UNIT_ROUNDOFF;
        assert!(found > 0.0 && found <= bound, "{id}: {found:e}, {bound:e}");
    }
}

/// A body spun 2⁶⁰ times as fast takes the same steps in a time as much shorter, and holds the same part of its spin.
#[test]
fn the_part_has_no_unit() {
    let problem = library("rigid-body");
    let method = gauss(&problem.system, STAGES);
    let [found, fast] = [0.0, 60.0].map(|exponent| {
        let scale = libm::exp2(exponent);
        let initial: Vec<f64> = problem.initial.iter().map(|x| scale * x).collect();
        held(&problem.system, &method, (0.4 / scale, 100), &initial)
    });
    assert!(found > 0.0);
    assert_eq!(found.to_bits(), fast.to_bits());
}

#[test]
fn what_has_no_quadratic_casimir_holds_none() {
    let problem = library("lotka-volterra-periodic");
    let realization = Logarithms::realize(&problem.system).expect("a lift");
    let method = over(&problem.system, realization, STAGES);
    assert_eq!(
        held(&problem.system, &method, (0.1, 100), &problem.initial),
        0.0
    );
}
