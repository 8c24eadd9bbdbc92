//! The γ_i and α_i against the order conditions, in the free associative algebra.
//!
//! A self-adjoint map is exp(hY_1 + h³Y_3 + h⁵Y_5 + …). In the algebra of words over the letters
//! Y_1, Y_3, …, graded by the sum of their indices, the composition has order P exactly when its
//! coefficients are those of exp(Y_1) in every grade up to P (Hairer, Lubich, Wanner, *Geometric
//! Numerical Integration*, section III.5; here without reducing to independent conditions). A map of order 1 is
//! χ_h = exp(hY_1 + h²Y_2 + …) with all grades, and its adjoint χ*_h = χ_{−h}⁻¹ = exp(hY_1 − h²Y_2 + …).

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::collections::BTreeMap;

use leafwise_composition::Scheme;

type Word = Vec<usize>;

/// The words of a grade: compositions of it into odd parts, or with `even` into all.
fn words(grade: usize, even: bool) -> Vec<Word> {
    if grade == 0 {
        return vec![Vec::new()];
    }
    let first = (1..=grade).step_by(if even { 1 } else { 2 });
    first
        .flat_map(|letter| {
            words(grade - letter, even)
                .into_iter()
                .map(move |rest| [vec![letter], rest].concat())
        })
        .collect()
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

/// exp(γY_1 + γ²Y_2 + γ³Y_3 + …): γ^grade / length!; of the adjoint with −Y_2, −Y_4, ….
fn stage(gamma: f64, is_adjoint: bool, words: &[Word]) -> BTreeMap<Word, f64> {
    let coefficient = |word: &Word| {
        let evens = word.iter().filter(|letter| *letter % 2 == 0).count();
        let sign = if is_adjoint && evens % 2 == 1 {
            -1.0
        } else {
            1.0
        };
        sign * libm::pow(gamma, word.iter().sum::<usize>() as f64) / factorial(word.len())
    };
    words.iter().map(|w| (w.clone(), coefficient(w))).collect()
}

fn product(a: &BTreeMap<Word, f64>, b: &BTreeMap<Word, f64>) -> BTreeMap<Word, f64> {
    let coefficient = |word: &Word| -> f64 {
        (0..=word.len())
            .map(|at| a[&word[..at]] * b[&word[at..]])
            .sum()
    };
    a.keys().map(|w| (w.clone(), coefficient(w))).collect()
}

/// By grade, the largest deviation from exp(Y_1), and the same sum over |γ_i| without
/// cancellation: what round-off is relative to.
fn deviations(scheme: &Scheme, last: usize) -> Vec<(f64, f64)> {
    let of_factors = scheme.takes_factors();
    let gammas = scheme.coefficients();
    let words: Vec<Word> = (0..=last)
        .flat_map(|grade| words(grade, of_factors))
        .collect();
    let compose = |gammas: &[f64], alternate: bool| {
        let mut product_so_far = stage(0.0, false, &words);
        for (at, &gamma) in gammas.iter().enumerate() {
            let factor = stage(gamma, alternate && at % 2 == 1, &words);
            product_so_far = product(&product_so_far, &factor);
        }
        product_so_far
    };
    let found = compose(&gammas, of_factors);
    let sizes = compose(&gammas.iter().map(|g| g.abs()).collect::<Vec<_>>(), false);
    let mut worst = vec![(0.0_f64, 0.0_f64); last + 1];
    for (word, value) in &found {
        let expected = if word.iter().all(|letter| *letter == 1) {
            1.0 / factorial(word.len())
        } else {
            0.0
        };
        let slot = &mut worst[word.iter().sum::<usize>()];
        slot.0 = slot.0.max((value - expected).abs());
        slot.1 = slot.1.max(sizes[word]);
    }
    worst
}

#[test]
fn every_scheme_is_symmetric_and_consistent() {
    for scheme in Scheme::all() {
        let gammas = scheme.coefficients();
        let each = if scheme.takes_factors() { 2 } else { 1 };
        assert_eq!(gammas.len(), each * scheme.stages());
        assert_eq!(scheme.parts().len(), 2 * scheme.stages());
        let reversed: Vec<f64> = gammas.iter().rev().copied().collect();
        assert_eq!(gammas, reversed, "{}", scheme.info.name);
        // Rounding each γ_i to a double is at most an ulp of the largest in all, and so is the sum.
        let sum: f64 = gammas.iter().sum();
        assert!((sum - 1.0).abs() <= 1e-15, "{}: {sum:e}", scheme.info.name);
    }
}

/// Round-off: each coefficient of a product of s stages is a sum of at most 2^s products, formed in
/// s levels of at most grade + 1 summands; relative to the sum of sizes that is (s + grade) ulps.
#[test]
fn every_scheme_satisfies_its_order_conditions_and_no_more() {
    for scheme in Scheme::all() {
        let (name, order) = (scheme.info.name, scheme.order);
        let gammas = scheme.coefficients().len();
        let worst = deviations(&scheme, order + 1);
        for (grade, (deviation, size)) in worst.iter().enumerate().take(order + 1) {
            let bound = (gammas + grade) as f64 * f64::EPSILON * size;
            assert!(
                *deviation <= bound,
                "{name}, grade {grade}: {deviation:e} > {bound:e}"
            );
        }
        let (next, size) = worst[order + 1];
        println!("{name}: error of grade {} is {next:.2e}", order + 1);
        let bound = (gammas + order + 1) as f64 * f64::EPSILON * size;
        assert!(
            next > 10.0 * bound,
            "{name} has a higher order than declared"
        );
    }
}
