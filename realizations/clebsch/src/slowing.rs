//! Which multiples of Casimirs are taken off H, so that z moves slowly along the fibres of J.
//!
//! H − Σ μ_j C_j moves x as H does, and z by ż = −Ω Σ_k w_k S_k z with w = ∇H − Σ μ_j ∇C_j. The iteration for a step contracts as
//! the Jacobian of ż, −Ω (Σ_k w_k S_k + DJᵀ(H″ − Σ μ_j C_j″)DJ), is small. Over so(3)* μ is in the middle of the extreme
//! coefficients of the squares in H: of all states the fastest is then slowest. Elsewhere μ makes the mean square of the Jacobian
//! least over states that the motion comes by, coordinates measured in their sizes.

use leafwise_core::lift::Slowing;
use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

use crate::casimirs::Square;
use crate::forms::Forms;
use crate::least::Gram;

/// Casimirs that multiples are found of.
const MOST: usize = 4;

/// Least reduction of the mean square, as a part of it, for which multiples are taken off: the terms taken off cost
/// operations too.
const WORTH: f64 = 0.2;

/// A z, and the sizes of its coordinates.
pub type Point = (Vec<f64>, Vec<f64>);

/// Motion of z over a system: forms, their brackets, Casimirs and points over states.
#[derive(Clone, Copy)]
pub struct Motion<'a> {
    /// S_k.
    pub forms: &'a Forms,
    /// Ω, row-major.
    pub omega: &'a [Rational],
    /// Quadratic Casimirs.
    pub casimirs: &'a [Square],
    /// A z over a state with the sizes of its coordinates, none of them 0.
    pub over: &'a dyn Fn(&[f64]) -> Option<Point>,
    /// Whether all directions of x are alike: DJ DJᵀ is a multiple of the identity.
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

/// The μ_j that make the mean square of the Jacobian of ż least over states that the motion comes by; 0 where little is saved.
fn least_motion(motion: &Motion<'_>, slowing: &Slowing<'_>, places: &[usize]) -> Vec<f64> {
    let casimirs = &motion.casimirs[..motion.casimirs.len().min(MOST)];
    let mut gram = Gram::<MOST>::new(casimirs.len());
    let mut right = [0.0; MOST];
    let mut whole = 0.0;
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let curvatures = slowing.curvatures(places);
    for (met, curvature) in slowing.met().iter().zip(&curvatures) {
        let of = |all: &[f64]| -> Vec<f64> { places.iter().map(|at| all[*at]).collect() };
        let (x, w) = (of(&met.x), of(&met.slopes));
        let Some((z, sizes)) = (motion.over)(&x) else {
            continue;
        };
        let own = jacobian(motion, (&z, &sizes), &w, curvature);
        let casimirs: Vec<_> = casimirs
            .iter()
            .map(|c| jacobian(motion, (&z, &sizes), &gradient(c, &x), &hessian(c, x.len())))
            .collect();
        whole += dot(&own, &own);
        for (i, first) in casimirs.iter().enumerate() {
            right[i] += dot(first, &own);
            for (j, second) in casimirs.iter().enumerate().take(i + 1) {
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

/// Ω (Σ_k w_k S_k + DJᵀ B DJ) of all copies at z, its rows and columns in units of `sizes`.
fn jacobian(
    motion: &Motion<'_>,
    (z, sizes): (&[f64], &[f64]),
    w: &[f64],
    curvature: &[f64],
) -> Vec<f64> {
    let (v, d, n) = (motion.forms.coordinates(), w.len(), z.len());
    let mut slopes = vec![vec![0.0; n]; d];
    for (k, row) in slopes.iter_mut().enumerate() {
        for (row, z) in row.chunks_exact_mut(v).zip(z.chunks_exact(v)) {
            motion.forms.add_slopes(k, 1.0, z, row);
        }
    }
    let mut inner = vec![0.0; n * n];
    for k in 0..d {
        for a in 0..n {
            let mut unit = vec![0.0; v];
            unit[a % v] = 1.0;
            let mut row = vec![0.0; v];
            motion.forms.add_slopes(k, w[k], &unit, &mut row);
            let from = a - a % v;
            for (entry, own) in inner[a * n + from..][..v].iter_mut().zip(row) {
                *entry += own;
            }
            for l in 0..d {
                let factor = slopes[k][a] * curvature[k * d + l];
                for (entry, slope) in inner[a * n..][..n].iter_mut().zip(&slopes[l]) {
                    *entry += factor * slope;
                }
            }
        }
    }
    let omega: Vec<f64> = motion.omega.iter().map(Rational::to_f64).collect();
    let mut jacobian = vec![0.0; n * n];
    for a in 0..n {
        let from = a - a % v;
        for b in 0..v {
            let entry = omega[(a % v) * v + b];
            for c in 0..n {
                jacobian[a * n + c] += entry * inner[(from + b) * n + c] * sizes[c] / sizes[a];
            }
        }
    }
    jacobian
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

/// The Hessian of C, row-major.
fn hessian(casimir: &Square, d: usize) -> Vec<f64> {
    let mut hessian = vec![0.0; d * d];
    for ((i, j), c) in casimir {
        hessian[i * d + j] += c.to_f64();
        hessian[j * d + i] += c.to_f64();
    }
    hessian
}

/// A number of ten digits in base two near one.
fn rounded(value: f64) -> f64 {
    let (part, exponent) = libm::frexp(value);
    libm::ldexp(libm::round(1024.0 * part), exponent - 10)
}
