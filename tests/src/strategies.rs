//! Random states, tensors and systems.

use proptest::collection::vec;
use proptest::prelude::*;

/// d numbers of size 0.2 to 2 with any signs.
pub fn state(dimension: usize) -> impl Strategy<Value = Vec<f64>> {
    let coordinate =
        (0.2..2.0_f64, any::<bool>()).prop_map(|(v, minus)| if minus { -v } else { v });
    vec(coordinate, dimension)
}

/// d positive numbers of size 0.3 to 2.
pub fn positive_state(dimension: usize) -> impl Strategy<Value = Vec<f64>> {
    vec(0.3..2.0_f64, dimension)
}

/// A decimal of two places in [−1, 1], as formulas write it.
pub fn decimal() -> impl Strategy<Value = f64> {
    (-100..=100_i32).prop_map(|hundredths| f64::from(hundredths) / 100.0)
}

/// A polynomial of degree at most four over `variables`, as text, every coefficient of two decimals.
pub fn polynomial(variables: &'static [&'static str]) -> impl Strategy<Value = String> {
    let term = (decimal(), vec(0..variables.len(), 1..=4));
    vec(term, 1..=6).prop_map(move |terms| {
        let term = |(coefficient, factors): (f64, Vec<usize>)| {
            let factors: Vec<&str> = factors.into_iter().map(|at| variables[at]).collect();
            format!("({coefficient})*{}", factors.join("*"))
        };
        terms.into_iter().map(term).collect::<Vec<_>>().join(" + ")
    })
}
