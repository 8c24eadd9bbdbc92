//! The γ_i and α_i against the order conditions, in the free associative algebra.
//!
//! A self-adjoint map is exp(hY_1 + h³Y_3 + h⁵Y_5 + …). In the algebra of words over the letters
//! Y_1, Y_3, …, graded by the sum of their indices, the composition has order P exactly when its
//! coefficients are those of exp(Y_1) in every grade up to P (Hairer, Lubich, Wanner, *Geometric
//! Numerical Integration*, section III.5; here without reducing to independent conditions). A map of order 1 is
//! χ_h = exp(hY_1 + h²Y_2 + …) with all grades, and its adjoint χ*_h = χ_{−h}⁻¹ = exp(hY_1 − h²Y_2 + …).
//!
//! Schemes for two pieces of a kind satisfy fewer conditions, in words over the pieces A and B themselves: modulo
//! [B, [B, [B, A]]] = 0, or up to a grade that depends on the number of Bs.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::collections::BTreeMap;

use leafwise_composition::Scheme;
use leafwise_core::Pieces;

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

/// The letters of words over two pieces.
const A: usize = 0;
const B: usize = 1;

/// The product over the flows of the pieces, χ and χ* in turn, as a sum over `words`, which contain every part of theirs;
/// the flow of the piece `first` is the first factor.
fn flows(coefficients: &[f64], first: usize, words: &[Word]) -> BTreeMap<Word, f64> {
    let mut found: BTreeMap<Word, f64> = words.iter().map(|w| (w.clone(), 0.0)).collect();
    found.insert(Vec::new(), 1.0);
    let mut follow = |letter: usize, time: f64| {
        let before = found.clone();
        for (word, value) in &mut found {
            // Σ_k time^k/k! of the words that end with so many letters more.
            let (mut weight, mut shorter) = (1.0, word.len());
            *value = 0.0;
            for k in 1.. {
                *value += weight * before[&word[..shorter]];
                if shorter == 0 || word[shorter - 1] != letter {
                    break;
                }
                shorter -= 1;
                weight *= time / k as f64;
            }
        }
    };
    for (at, alpha) in coefficients.iter().enumerate() {
        let pair = if at % 2 == 0 {
            [first, 1 - first]
        } else {
            [1 - first, first]
        };
        for letter in pair {
            follow(letter, *alpha);
        }
    }
    found
}

/// The words up to a length that `counts`.
fn kept(length: usize, counts: impl Fn(&Word) -> bool) -> Vec<Word> {
    let mut words = vec![Vec::new()];
    let mut at = 0;
    while at < words.len() {
        let word = words[at].clone();
        let longer = [A, B].map(|letter| [word.clone(), vec![letter]].concat());
        words.extend(
            longer
                .into_iter()
                .filter(|w| w.len() <= length && counts(w)),
        );
        at += 1;
    }
    words
}

/// Modulo [B, [B, [B, A]]] = BBBA − 3 BBAB + 3 BABB − ABBB: words without BBBA are left.
fn modulo_the_bracket(mut elements: BTreeMap<Word, f64>) -> BTreeMap<Word, f64> {
    let leading = [B, B, B, A];
    let place = |word: &Word| word.windows(4).position(|part| part == leading);
    while let Some((word, at)) = elements.keys().find_map(|w| Some((w.clone(), place(w)?))) {
        let value = elements.remove(&word).expect("a word found");
        for (instead, factor) in [
            ([B, B, A, B], 3.0),
            ([B, A, B, B], -3.0),
            ([A, B, B, B], 1.0),
        ] {
            let word = [&word[..at], &instead, &word[at + 4..]].concat();
            *elements.entry(word).or_default() += factor * value;
        }
    }
    elements
}

/// The largest coefficient of the product less exp(A + B).
fn defect(scheme: &Scheme, first: usize, words: &[Word], reduce: bool) -> f64 {
    let found = flows(&scheme.coefficients(), first, words);
    let mut rest: BTreeMap<Word, f64> = found
        .into_iter()
        .map(|(word, value)| {
            let exact = 1.0 / factorial(word.len());
            (word, value - exact)
        })
        .collect();
    if reduce {
        rest = modulo_the_bracket(rest);
    }
    rest.values()
        .fold(0.0, |largest, value| value.abs().max(largest))
}

/// The sizes of products reach 3; a word of 10 letters over 30 flows sums some hundred of them.
const OF_PIECES: f64 = 1e-14;

#[test]
fn schemes_for_momenta_and_positions_have_their_order_modulo_the_bracket_alone() {
    for scheme in Scheme::all() {
        let Pieces::Nystrom { kick_first } = scheme.pieces else {
            continue;
        };
        let (name, order) = (scheme.info.name, scheme.order);
        let first = if kick_first { B } else { A };
        let of_length = |length| kept(length, |_| true);
        let found = defect(&scheme, first, &of_length(order), true);
        let next = defect(&scheme, first, &of_length(order + 1), true);
        let whole = defect(&scheme, first, &of_length(order), false);
        println!("{name}: {found:.1e}, next {next:.1e}, without the bracket {whole:.1e}");
        assert!(found <= OF_PIECES, "{name}: {found:e}");
        assert!(next > 1e-9, "{name} has a higher order than declared");
        // Of grade 4 and less a symmetric scheme errs by brackets of grade 3 alone, none of which vanishes.
        assert_eq!(whole > 1e-9, order > 4, "{name}: {whole:e}");
    }
}

/// perturbed-n-m-k: one B up to grade n, two up to m, three and more up to k; the last is the order where none is named.
#[test]
fn schemes_for_perturbations_have_an_order_for_each_power_of_them() {
    let grades = [
        ("perturbed-8-2", [8, 2, 2]),
        ("perturbed-10-4", [10, 4, 4]),
        ("perturbed-8-6-4", [8, 6, 4]),
        ("perturbed-10-6-4", [10, 6, 4]),
    ];
    let tested = Scheme::all()
        .into_iter()
        .filter(|s| s.pieces == Pieces::Perturbed);
    assert_eq!(tested.count(), grades.len());
    for (name, orders) in grades {
        let scheme = Scheme::find(name).expect("a scheme");
        assert_eq!(scheme.order, orders[2]);
        let words = |orders: [usize; 3]| {
            kept(orders[0].max(orders[1]), move |word| {
                match word.iter().filter(|letter| **letter == B).count() {
                    0 => true,
                    count => word.len() <= orders[count.min(3) - 1],
                }
            })
        };
        let found = defect(&scheme, A, &words(orders), false);
        println!("{name}: {found:.1e}");
        assert!(found <= OF_PIECES, "{name}: {found:e}");
        for power in 0..3 {
            // One grade higher, or two: of grade 3 with three Bs there is BBB alone.
            let mut more = orders;
            more[power] += 2;
            let next = defect(&scheme, A, &words(more), false);
            assert!(next > 1e-13, "{name}: more than declared, {power}");
        }
    }
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
    let any = |scheme: &Scheme| scheme.pieces == Pieces::Any;
    for scheme in Scheme::all().into_iter().filter(any) {
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
