//! Weights of pairs: their ratios count, and pairs of weight 0 do not.

use leafwise_learn::{LearnError, Learned, StatePairs, learn};

use crate::support::{Draws, Place, RIGID_BODY, polynomials};

/// Everything that is reported of pairs with these weights.
fn learned(
    body: &Place,
    pairs: &(Vec<f64>, Vec<f64>),
    weights: Option<&[f64]>,
    degree: usize,
) -> Result<Learned, LearnError> {
    let pairs = StatePairs::new(3, &pairs.0, &pairs.1, weights)?;
    learn(
        &body.system,
        &body.realization,
        (1.0, 0.3),
        &pairs,
        &polynomials(3, degree),
    )
}

/// Numbers, functions and advice, to the last bit.
fn report(mut learned: Learned) -> String {
    let leverage = learned.leverage(&[0.6, 0.5, 0.6]);
    format!(
        "{:?}",
        (
            (learned.pairs, learned.equations, learned.determined),
            (learned.motion, learned.residual, learned.noise),
            (learned.off_leaf, learned.one_step, learned.step_error),
            (learned.energy_error, learned.hamiltonian_error),
            (learned.largest_leverage, leverage),
            (learned.hamiltonian, learned.functions, learned.advice),
        )
    )
}

/// Noisy pairs of a rigid body.
fn noisy(body: &Place, count: usize) -> (Vec<f64>, Vec<f64>) {
    let mut draws = Draws(11);
    let mut pairs = body.pairs(&draws.on_spheres(count), 0.3);
    draws.noisy(&mut pairs.1, 1e-3);
    pairs
}

#[test]
fn equal_weights_of_any_size_are_none() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let pairs = noisy(&body, 60);
    let none = report(learned(&body, &pairs, None, 2).expect("pairs"));
    for weight in [1.0, 1e6, 1e-6, 1e-300] {
        let own = learned(&body, &pairs, Some(&[weight; 60]), 2).expect("pairs");
        assert_eq!(report(own), none, "weight {weight}");
    }
}

/// 400 pairs of which 360 have weight 0, however wrong they are, are the 40 others alone. So are 40 pairs too few for a degree.
#[test]
fn pairs_of_weight_0_are_left_out() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let few = noisy(&body, 40);
    let (mut before, mut after, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    let mut draws = Draws(12);
    for (k, (x, next)) in few.0.chunks(3).zip(few.1.chunks(3)).enumerate() {
        for _ in 0..9 {
            before.extend((0..3).map(|_| draws.between(-9.0, 9.0)));
            after.extend((0..3).map(|_| draws.between(-9.0, 9.0)));
        }
        weights.extend([0.0; 9]);
        before.extend(x);
        after.extend(next);
        weights.push(1.0 + (k % 3) as f64);
    }
    let own: Vec<f64> = weights.iter().copied().filter(|w| *w > 0.0).collect();
    assert_eq!((weights.len(), own.len()), (400, 40));
    let all = (before, after);
    let found = learned(&body, &all, Some(&weights), 2).expect("pairs");
    let alone = learned(&body, &few, Some(&own), 2).expect("pairs");
    assert_eq!(report(found), report(alone));
    let Err(error) = learned(&body, &all, Some(&weights), 6) else {
        panic!("80 equations for 83 coefficients");
    };
    let said = error.to_string();
    assert!(said.contains("40 pairs give 80 equations for 83"), "{said}");
}
