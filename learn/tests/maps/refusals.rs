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

/// An oscillator in units of q and p by any powers of two: what is learned is the same to round-off, or refused where the ratio is above 1e6, with both
/// columns named. In units that the message names the same pairs are learned.
#[test]
fn unlike_units_are_named() {
    let mut draws = Draws(18);
    let unit = Place::new(&oscillator(1.0, 1.0), "constant", "[1, 0]");
    let pairs = unit.pairs(&draws.in_box(60, &[(-1.0, 1.0); 2]), 0.3);
    let (mut learned, mut refused) = (0, 0);
    for (q, p) in [(0, 0), (8, 8), (-9, 9), (12, -12), (40, 32), (-60, -60)]
        .into_iter()
        .chain([
            (-30, 0),
            (0, -30),
            (25, 0),
            (14, -14),
            (60, -60),
            (-100, -10),
        ])
    {
        let [q, p] = [q, p].map(|k| libm::ldexp(1.0, k));
        let scaled = |states: &[f64]| -> Vec<f64> {
            let states = states.chunks(2);
            states.flat_map(|x| [q * x[0], p * x[1]]).collect()
        };
        let place = Place::new(&oscillator(q, p), "constant", "[1, 0]");
        let pairs = (scaled(&pairs.0), scaled(&pairs.1));
        match place.learn(0.3, &pairs, &polynomials(2, 2)) {
            Ok(own) => {
                let squares = own.functions.iter().filter(|f| f.is_determined);
                for function in squares {
                    let scale = match function.formula.as_str() {
                        "q^2" => q * q,
                        "p^2" => p * p,
                        _ => continue,
                    };
                    // Ŝ/h = tan(h/2)/h (q² + p²) in the units of action.
                    let expected = libm::tan(0.15) / 0.3;
                    let found = function.generating * scale;
                    // A column of equations that counts 2^−19 loses as many digits: 2^−33.
                    assert!((found - expected).abs() < 1e-9, "{q} {p} {function:?}");
                }
                learned += 1;
            }
            Err(LearnError::UnlikeUnits {
                large,
                spread,
                small,
                size,
                unit,
            }) => {
                let expected = if q > p { ["q", "p"] } else { ["p", "q"] };
                assert_eq!([&large[..], &small[..]], expected);
                assert!(size < 10.0 * unit * spread && unit * spread <= size * 1.001);
                let [q, p] = if q > p { [q, p / unit] } else { [q / unit, p] };
                let cured = |states: &[f64]| -> Vec<f64> {
                    let states = states.chunks(2);
                    let own = [&large[..] == "q", &large[..] == "p"];
                    let by = own.map(|is_large| if is_large { 1.0 } else { unit });
                    states.flat_map(|x| [x[0] / by[0], x[1] / by[1]]).collect()
                };
                let place = Place::new(&oscillator(q, p), "constant", "[1, 0]");
                let pairs = (cured(&pairs.0), cured(&pairs.1));
                let again = place.learn(0.3, &pairs, &polynomials(2, 2));
                assert!(again.is_ok(), "{q} {p}");
                refused += 1;
            }
            Err(other) => panic!("{q} {p}: {other}"),
        }
    }
    assert_eq!((learned, refused), (5, 7));
}

/// q/a and p/b of an oscillator as the coordinates: {q, p} = ab.
fn oscillator(a: f64, b: f64) -> String {
    format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"{:e}\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"(q^2*{:e} + p^2*{:e})/2\"\n",
        a * b,
        1.0 / (a * a),
        1.0 / (b * b)
    )
}
