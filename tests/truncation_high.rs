//! High truncation orders: n = 20 on so(3)*, n = 14 on Lotka–Volterra, against closed forms.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::expression::{Arithmetic, Rational};
use leafwise_tests::coefficients::natural_size;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::{coefficients, library};

/// B_0 … B_last with B_1 = −½, from Σ_{j≤k} C(k+1, j) B_j = 0.
fn bernoulli(last: usize) -> Vec<Rational> {
    let mut numbers = vec![Rational::one()];
    for k in 1..=last {
        let mut binomial = Rational::one();
        let mut sum = Rational::zero();
        for (j, number) in numbers.iter().enumerate() {
            sum += &(&binomial * number);
            binomial = &binomial * &Rational::new((k + 1 - j) as i64, j as i64 + 1);
        }
        numbers.push(-(&sum * &Rational::new(1, k as i64 + 1)));
    }
    numbers
}

fn rationals(values: &[(i64, i64)]) -> Vec<Rational> {
    values.iter().map(|&(n, d)| Rational::new(n, d)).collect()
}

/// Exact and compiled coefficients at a point, to `order`, against `expected`.
fn check(name: &str, id: &str, order: usize, point: [&[Rational]; 2], expected: &[Rational]) {
    let system = library(id).system;
    let (ring, exact) = coefficients::exact(&system, order, point[0], point[1]);
    let exact: Option<Vec<Rational>> = exact.iter().map(|value| ring.as_rational(value)).collect();
    assert_eq!(
        exact.as_deref(),
        Some(expected),
        "{name}: exactly, every order to {order}"
    );
    let [x, p] = point.map(|values| values.iter().map(Rational::to_f64).collect::<Vec<_>>());
    let compiled = coefficients::compiled(&system, order, &x, &p);
    check_compiled(name, &compiled, expected, x.len());
}

/// α = Σ_k (B_k/k!) (εA)ᵏ x with A y = Π(y)p = y × p.
#[test]
fn on_so3_the_coefficients_are_bernoulli_numbers_to_n_20() {
    const ORDER: usize = 20;
    let (x, p) = (
        rationals(&[(2, 1), (3, 1), (-1, 2)]),
        rationals(&[(1, 3), (2, 5), (-3, 4)]),
    );
    let cross = |y: &[Rational]| -> Vec<Rational> {
        let minor = |i: usize, j: usize| &(&y[i] * &p[j]) - &(&y[j] * &p[i]);
        vec![minor(1, 2), minor(2, 0), minor(0, 1)]
    };
    let numbers = bernoulli(ORDER);
    assert_eq!(
        numbers[20],
        Rational::new(-174_611, 330),
        "B_20 of the tables"
    );
    let mut expected: Vec<Rational> = Vec::new();
    let (mut power, mut factorial) = (x.clone(), Rational::one());
    for k in 0..=ORDER {
        let weight = &numbers[k] * &factorial.recip();
        expected.extend(power.iter().map(|y| y * &weight));
        power = cross(&power);
        factorial = &factorial * &Rational::from_integer(k as i64 + 1);
    }
    check("so(3)*", "rigid-body", ORDER, [&x, &p], &expected);
}

/// The compiled coefficients against exact ones, by their natural size: errors of α̂ in units of
/// the state. Two roundings of α̂ itself: 4 u.
fn check_compiled(name: &str, found: &[f64], expected: &[Rational], d: usize) {
    let expected: Vec<f64> = expected.iter().map(Rational::to_f64).collect();
    let mut worst = 0.0_f64;
    for k in 0..expected.len() / d {
        let (found, exact) = (&found[k * d..][..d], &expected[k * d..][..d]);
        let error = distance(found, exact) / natural_size(&expected, d, k);
        assert!(
            error <= 4.0 * UNIT_ROUNDOFF,
            "{name} order {k}: {error:.1e} {found:?} {exact:?}"
        );
        worst = worst.max(error);
    }
    println!("{name}: compiled coefficients within {worst:.1e}");
}

/// Power series in ε as lists of coefficients.
fn product(a: &[Rational], b: &[Rational]) -> Vec<Rational> {
    let term = |k: usize| {
        (0..=k).fold(Rational::zero(), |mut sum, j| {
            sum += &(&a[j] * &b[k - j]);
            sum
        })
    };
    (0..a.len().min(b.len())).map(term).collect()
}

/// exp(u) for a series with u_0 = 0: k e_k = Σ j u_j e_{k−j}.
fn exponential(u: &[Rational]) -> Vec<Rational> {
    let mut e = vec![Rational::one()];
    for k in 1..u.len() {
        let mut sum = Rational::zero();
        for j in 1..=k {
            sum += &(&(&Rational::from_integer(j as i64) * &u[j]) * &e[k - j]);
        }
        e.push(&sum * &Rational::new(1, k as i64));
    }
    e
}

/// 1/f for a series with f_0 ≠ 0.
fn reciprocal(f: &[Rational]) -> Vec<Rational> {
    let lead = f[0].recip();
    let mut inverse = vec![lead.clone()];
    for k in 1..f.len() {
        let mut sum = Rational::zero();
        for j in 1..=k {
            sum += &(&f[j] * &inverse[k - j]);
        }
        inverse.push(-(&sum * &lead));
    }
    inverse
}

/// On the paper's Lotka–Volterra the curve is logistic. With w_i = Y_i p_i the sum c is constant,
/// w_1′ = 2ε w_1 (c − w_1) and w_3′ = −2ε w_3 (c − w_3); the means ∫ w_i = μ_i = x_i p_i fix the
/// constants:
///
/// α_1 = (c/p_1) (e^{2εμ_1} − 1)/(e^{2εc} − 1),
/// α_3 = (c/p_3) (1 − e^{−2εμ_3})/(1 − e^{−2εc}),
/// α_2 = (c − α_1 p_1 − α_3 p_3)/p_2.
///
/// (The realization x_i exp(−½ Σ_j a_ij x_j p_j) of the same tensor belongs to another chart: it
/// agrees with Karasev's to first order only.)
#[test]
fn on_lotka_volterra_the_coefficients_are_the_logistic_closed_form_s_to_n_14() {
    const ORDER: usize = 14;
    let (x, p) = (
        rationals(&[(1, 2), (3, 4), (2, 5)]),
        rationals(&[(1, 3), (4, 5), (-1, 2)]),
    );
    let mu: Vec<Rational> = x.iter().zip(&p).map(|(x, p)| x * p).collect();
    let c = &(&mu[0] + &mu[1]) + &mu[2];
    // (e^{2εa} − 1)/ε.
    let growth = |a: &Rational| -> Vec<Rational> {
        let mut u = vec![Rational::zero(); ORDER + 2];
        u[1] = a * &Rational::from_integer(2);
        exponential(&u)[1..].to_vec()
    };
    let first = product(&growth(&mu[0]), &reciprocal(&growth(&c)));
    let third = product(&growth(&-&mu[2]), &reciprocal(&growth(&-&c)));
    let mut expected = Vec::new();
    for k in 0..=ORDER {
        let (first, third) = (&c * &first[k], &c * &third[k]);
        let whole = if k == 0 { c.clone() } else { Rational::zero() };
        let second = &(&whole - &first) - &third;
        expected.extend(
            [first, second, third]
                .iter()
                .zip(&p)
                .map(|(w, p)| w * &p.recip()),
        );
    }
    check(
        "Lotka-Volterra",
        "lotka-volterra",
        ORDER,
        [&x, &p],
        &expected,
    );
}
