//! Pairs that nothing is learned from say why.

use leafwise_learn::{LearnError, LearnOptions, StatePairs};

use crate::support::{Draws, Place, RIGID_BODY, logarithms, polynomials};

fn refused(options: &LearnOptions, before: &[f64], after: &[f64]) -> String {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let pairs = (before.to_vec(), after.to_vec());
    match body.learn(0.5, &pairs, options) {
        Ok(_) => panic!("refused"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn pairs_that_determine_nothing_are_refused() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let (before, after) = body.pairs(&Draws(7).on_spheres(20), 0.5);
    let four = polynomials(3, 4);
    let said = refused(&polynomials(3, 6), &before, &after);
    assert!(
        said.contains("20 pairs give 40 equations for 83 coefficients: give 42 pairs or more"),
        "{said}"
    );
    let said = refused(&four, &before, &before);
    assert!(said.contains("no pair moves"), "{said}");
    let mut odd = after.clone();
    odd[31] = f64::NAN;
    let said = refused(&four, &before, &odd);
    assert!(said.contains("pair 11 holds NaN after the step"), "{said}");
    let said = refused(&four, &before, &after[..57]);
    assert!(
        said.contains("give as many states after a step as before it"),
        "{said}"
    );
    let said = refused(&polynomials(3, 25), &before, &after);
    assert!(said.contains("the degree 25 is outside 1 to 24"), "{said}");
    let said = refused(
        &LearnOptions {
            ridge: -1.0,
            ..four.clone()
        },
        &before,
        &after,
    );
    assert!(
        said.contains("the ridge is a number of 0 or more"),
        "{said}"
    );
    let said = refused(&logarithms(3, 2), &before, &after);
    assert!(
        said.contains("ln x is a function of the basis")
            || said.contains("ln y is")
            || said.contains("ln z is"),
        "{said}"
    );
}

/// No H moves a state at rest of a tensor that is 0 there, and weights are numbers of which some count.
#[test]
fn weights_and_shapes_are_checked() {
    let weights =
        |weights: &[f64]| match StatePairs::new(1, &[1.0, 2.0], &[2.0, 3.0], Some(weights)) {
            Err(error @ LearnError::Weights { .. }) => error.to_string(),
            other => panic!("{other:?}"),
        };
    assert!(weights(&[1.0]).contains("there are 1"));
    assert!(weights(&[1.0, -1.0]).contains("one is -1.0"));
    assert!(weights(&[0.0, 0.0]).contains("all are 0"));
    assert!(matches!(
        StatePairs::new(2, &[1.0], &[1.0], None),
        Err(LearnError::Shape { .. })
    ));
    assert!(matches!(
        StatePairs::new(2, &[], &[], None),
        Err(LearnError::Shape { .. })
    ));
}

/// Only Casimirs in the basis: a singular problem.
#[test]
fn a_basis_of_casimirs_is_singular() {
    let text = "[system]\nvariables = [\"q\", \"p\", \"c\"]\nbracket = { \"q,p\" = \"0\" }\nhamiltonian = \"q\"\n";
    let place = Place::new(text, "constant", "[1, 0, 0]");
    let learned = place.learn(
        0.1,
        &(vec![0.0; 3], vec![1.0, 0.0, 0.0]),
        &polynomials(3, 1),
    );
    assert!(matches!(learned, Err(LearnError::Singular)));
}
