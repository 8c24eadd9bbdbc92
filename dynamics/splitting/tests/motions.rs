//! Which fields move a coordinate in closed form, and that numbers at one point rule out no such motion.

use leafwise_core::SystemFormulas;
use leafwise_expression::{Arithmetic, Function, Polynomial, Rational, Ring};
use leafwise_splitting::field::Field;
use leafwise_splitting::flow::{Motion, coordinate_flow};
use leafwise_splitting::probe::Probe;
use proptest::prelude::*;

use crate::common::library;

const D: usize = 3;

/// A system of three variables that moves about `near`.
fn about(near: &[f64; D]) -> SystemFormulas {
    let system = library("rigid-body").system();
    let formulas = system.formulas("motions").expect("formulas");
    formulas.with_near(near).expect("three coordinates")
}

/// A factor of a velocity.
#[derive(Clone, Copy, Debug)]
enum Factor {
    One,
    Variable(usize),
    Inverse(usize),
    Of(Function, usize),
}

/// c·a·b.
type Summand = (i64, Factor, Factor);

fn polynomial(ring: &mut Ring, summands: &[Summand]) -> Polynomial {
    let factor = |ring: &mut Ring, factor: Factor| match factor {
        Factor::One => ring.one(),
        Factor::Variable(i) => ring.variable(i),
        Factor::Inverse(i) => {
            let (one, x) = (ring.one(), ring.variable(i));
            ring.divide(&one, &x).expect("x is not 0")
        }
        Factor::Of(function, i) => {
            let x = ring.variable(i);
            ring.apply(function, &x).expect("a generator")
        }
    };
    let mut sum = Vec::new();
    for (scale, a, b) in summands {
        let (a, b) = (factor(ring, *a), factor(ring, *b));
        sum.push((Rational::from_integer(*scale), ring.multiply(&a, &b)));
    }
    ring.combine(&sum)
}

fn motion(probe: &Probe, field: &[Vec<Summand>; D], index: usize) -> Option<Motion> {
    let mut ring = Ring::new(D);
    let components = field.iter().enumerate();
    let field: Field = components
        .map(|(i, summands)| (i, polynomial(&mut ring, summands)))
        .collect();
    let flow = coordinate_flow(&mut ring, probe, &field, index).expect("within the algebra");
    flow.map(|flow| flow.motion)
}

/// Every kind of motion, beside fields that have none: x′ = x², x″ = −sin x, and a polynomial of degree 9.
#[test]
fn motions_are_found_and_others_are_ruled_out() {
    use Factor::{Of, One, Variable};
    let (x, y, z) = (Variable(0), Variable(1), Variable(2));
    let probe = Probe::of(&about(&[0.7, -0.4, 1.3]));
    let kind = |field: [Vec<Summand>; D]| match motion(&probe, &field, 0) {
        None => "none",
        Some(Motion::Polynomial(_)) => "polynomial",
        Some(Motion::Exponential { .. }) => "exponential",
        Some(Motion::Affine { .. }) => "affine",
        Some(Motion::Rotation { .. }) => "rotation",
        Some(Motion::Oscillation { .. }) => "oscillation",
    };
    // x″ = 2yy′ with y = t: degree 3.
    assert_eq!(
        kind([vec![(1, y, y)], vec![(1, One, One)], vec![]]),
        "polynomial"
    );
    assert_eq!(kind([vec![(1, x, z)], vec![], vec![]]), "exponential");
    assert_eq!(
        kind([vec![(1, x, z), (1, y, One)], vec![], vec![]]),
        "affine"
    );
    let turn = |by| [vec![(1, by, y)], vec![(-1, by, x)], vec![]];
    assert_eq!(kind(turn(z)), "rotation");
    assert_eq!(
        kind([vec![(1, y, One)], vec![(1, z, x)], vec![]]),
        "oscillation"
    );
    assert_eq!(kind([vec![(1, x, x)], vec![], vec![]]), "none");
    let pendulum = [
        vec![(1, y, One)],
        vec![(-1, Of(Function::Sin, 0), One)],
        vec![],
    ];
    assert_eq!(kind(pendulum), "none");
    // The Riccati equation behind a coordinate at rest.
    assert_eq!(
        kind([vec![(1, y, One)], vec![(1, y, y), (1, z, One)], vec![]]),
        "none"
    );
}

fn factor() -> impl Strategy<Value = Factor> {
    prop_oneof![
        3 => Just(Factor::One),
        6 => (0..D).prop_map(Factor::Variable),
        1 => (0..D).prop_map(Factor::Inverse),
        1 => (prop_oneof![Just(Function::Sin), Just(Function::Exp), Just(Function::Sqrt)], 0..D)
            .prop_map(|(function, i)| Factor::Of(function, i)),
    ]
}

fn component() -> impl Strategy<Value = Vec<Summand>> {
    prop::collection::vec((-2_i64..3, factor(), factor()), 0..3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    /// The same motions with the numbers as without: at NaN they rule out nothing.
    #[test]
    fn numbers_rule_out_no_motion(
        field in [component(), component(), component()],
        near in [0.2_f64..2.0, 0.2_f64..2.0, 0.2_f64..2.0],
    ) {
        let (probe, blind) = (Probe::of(&about(&near)), Probe::of(&about(&[f64::NAN; D])));
        for index in 0..D {
            let (with, without) = (motion(&probe, &field, index), motion(&blind, &field, index));
            prop_assert_eq!(with, without);
        }
    }
}
