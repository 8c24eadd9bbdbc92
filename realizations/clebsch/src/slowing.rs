//! Which multiples of Casimirs are taken off H, so that z moves slowly along the fibres of J.
//!
//! H − Σ μ_j C_j moves x as H does, and z by ż = A(w)z with w = ∇H − Σ μ_j ∇C_j and A(w) = −Ω Σ_k w_k S_k. Over so(3)*, where
//! |A(w)| is |w| times a number, μ is in the middle of the extreme coefficients of the squares in H: of all states the fastest is
//! then slowest. Elsewhere μ makes the mean of −tr A(w)², or of |A(w)|² where that has no sign, least over states that the motion
//! comes by.

use leafwise_core::lift::Slowing;
use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

use crate::casimirs::Square;
use crate::forms::{Forms, product};
use crate::least::Gram;

/// Casimirs that multiples are found of.
const MOST: usize = 4;

/// What is saved of the mean square of A(w) must be more than this part of it.
const WORTH: f64 = 0.05;

/// What the motion of z is made of.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// S_k.
    pub forms: &'a Forms,
    /// Ω, row-major.
    pub omega: &'a [Rational],
    /// Quadratic Casimirs.
    pub casimirs: &'a [Square],
    /// Whether |A(w)| is |w| times a number.
    pub is_round: bool,
}

/// Σ μ_j C_j over the coordinates `places` of the system.
pub fn taken(motion: &Motion<'_>, slowing: &mut Slowing<'_>, places: &[usize]) -> Polynomial {
    let casimirs = motion.casimirs;
    if motion.is_round
        && casimirs.len() == 1
        && let Some(taken) = in_the_middle(slowing, places)
    {
        return taken;
    }
    let factors = least_motion(motion, slowing, places);
    let ring = &mut slowing.ring;
    let mut sum = Polynomial::zero();
    for (casimir, factor) in casimirs.iter().zip(factors) {
        let Some(factor) = Rational::from_f64(rounded(factor)) else {
            continue;
        };
        for ((i, j), c) in casimir {
            let [x, y] = [i, j].map(|at| ring.variable(places[*at]));
            let product = ring.multiply(&x, &y);
            let term = ring.scale(&(c * &factor), &product);
            sum = ring.add(&sum, &term);
        }
    }
    sum
}

/// μ|x|² with μ the mean of the smallest and the largest coefficient of an x_i² in H, at the parameters' values; `None` where H
/// has no normal form.
fn in_the_middle(slowing: &mut Slowing<'_>, places: &[usize]) -> Option<Polynomial> {
    let values = slowing.system.parameter_values();
    let hamiltonian = slowing.hamiltonian.as_ref()?;
    let ring: &mut Ring = &mut slowing.ring;
    let mut found: Vec<(f64, Polynomial)> = Vec::new();
    let mut spin = Polynomial::zero();
    for at in places {
        let x = ring.variable(*at);
        let square = ring.multiply(&x, &x);
        let [(monomial, _)] = square.terms() else {
            return None;
        };
        let own = hamiltonian.terms().iter().find(|(m, _)| m == monomial);
        let own = own.map_or_else(Polynomial::zero, |(_, c)| Polynomial::constant(c.clone()));
        let value = match own.as_constant() {
            None => 0.0,
            Some(c) => ring.coefficient_formula(&c).evaluate(&[], &values),
        };
        found.push((value, own));
        spin = ring.add(&spin, &square);
    }
    if !found.iter().all(|(value, _)| value.is_finite()) {
        return None;
    }
    found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let ends = ring.add(&found[0].1, &found[found.len() - 1].1);
    let mean = ring.scale(&Rational::new(1, 2), &ends);
    Some(ring.multiply(&mean, &spin))
}

/// The μ_j that make the mean of |A(w)|² least over states that the motion comes by; 0 where little is saved.
fn least_motion(motion: &Motion<'_>, slowing: &Slowing<'_>, places: &[usize]) -> Vec<f64> {
    let casimirs = &motion.casimirs[..motion.casimirs.len().min(MOST)];
    let d = places.len();
    let metric = metric(motion);
    let dot = |a: &[f64], b: &[f64]| -> f64 {
        let rows = metric.chunks_exact(d).zip(a);
        rows.map(|(row, a)| a * row.iter().zip(b).map(|(m, b)| m * b).sum::<f64>())
            .sum()
    };
    let mut gram = Gram::<MOST>::new(casimirs.len());
    let mut right = [0.0; MOST];
    let mut whole = 0.0;
    for met in slowing.met() {
        let of = |all: &[f64]| -> Vec<f64> { places.iter().map(|at| all[*at]).collect() };
        let (x, w) = (of(&met.x), of(&met.slopes));
        let gradients: Vec<_> = casimirs.iter().map(|c| gradient(c, &x)).collect();
        whole += dot(&w, &w);
        for (i, first) in gradients.iter().enumerate() {
            right[i] += dot(first, &w);
            for (j, second) in gradients.iter().enumerate().take(i + 1) {
                gram.entries[i][j] += dot(first, second);
            }
        }
    }
    let mut factors = right;
    gram.factor();
    gram.solve(&mut factors);
    let saved: f64 = factors.iter().zip(&right).map(|(a, b)| a * b).sum();
    let is_worth = saved > WORTH * whole && factors.iter().all(|factor| factor.is_finite());
    match is_worth {
        true => factors[..casimirs.len()].to_vec(),
        false => vec![0.0; casimirs.len()],
    }
}

/// ∇C(x).
fn gradient(casimir: &Square, x: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; x.len()];
    for ((i, j), c) in casimir {
        let c = c.to_f64();
        gradient[*i] += c * x[*j];
        gradient[*j] += c * x[*i];
    }
    gradient
}

/// −tr A_k A_l where that is positive semidefinite, tr A_kᵀA_l otherwise; A_k = Ω S_k.
fn metric(motion: &Motion<'_>) -> Vec<f64> {
    let (n, d) = (motion.forms.coordinates(), motion.forms.count());
    let matrices = (0..d).map(|k| product(n, motion.omega, &motion.forms.matrix(k)));
    let matrices: Vec<Vec<f64>> = matrices
        .map(|matrix| matrix.iter().map(Rational::to_f64).collect())
        .collect();
    let of = |entry: &dyn Fn(&[f64], usize, usize) -> f64| {
        let mut metric = vec![0.0; d * d];
        for k in 0..d {
            for l in 0..d {
                let places = (0..n).flat_map(|a| (0..n).map(move |b| (a, b)));
                metric[k * d + l] = places
                    .map(|(a, b)| matrices[k][a * n + b] * entry(&matrices[l], a, b))
                    .sum();
            }
        }
        metric
    };
    let turning = of(&|matrix, a, b| -matrix[b * n + a]);
    match is_semidefinite(turning.clone(), d) {
        true => turning,
        false => of(&|matrix, a, b| matrix[a * n + b]),
    }
}

/// Whether a symmetric matrix has no negative eigenvalue beyond rounding.
fn is_semidefinite(mut matrix: Vec<f64>, d: usize) -> bool {
    let size = (0..d).fold(0.0_f64, |most, i| most.max(matrix[i * d + i].abs()));
    let least = 1e-9 * size;
    for j in 0..d {
        let pivot = matrix[j * d + j];
        if pivot < -least {
            return false;
        }
        for i in j + 1..d {
            let entry = matrix[i * d + j];
            if pivot <= least {
                if entry.abs() > least {
                    return false;
                }
                continue;
            }
            for k in j + 1..d {
                matrix[i * d + k] -= entry / pivot * matrix[j * d + k];
            }
        }
    }
    size > 0.0
}

/// A number of ten digits in base two near one.
fn rounded(value: f64) -> f64 {
    let (part, exponent) = libm::frexp(value);
    libm::ldexp(libm::round(1024.0 * part), exponent - 10)
}
