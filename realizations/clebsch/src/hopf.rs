//! Hopf's map J(q₀, q₁, p₀, p₁) = (½(q₀q₁ + p₀p₁), ½(q₀p₁ − p₀q₁), ¼(q₀² + p₀² − q₁² − p₁²)).

use leafwise_core::two_sum;
use leafwise_expression::{Arithmetic, Graph, Rational, Term};

/// The factors of J: x_k = Σ factor z_a z_b.
const PRODUCTS: [&[(i64, usize, usize)]; 3] = [
    &[(2, 0, 1), (2, 2, 3)],
    &[(2, 0, 3), (-2, 2, 1)],
    &[(1, 0, 0), (1, 2, 2), (-1, 1, 1), (-1, 3, 3)],
];

/// Quarters: what the factors are multiples of.
fn quarters(factor: i64) -> Rational {
    Rational::new(factor, 4)
}

/// J(z) as code.
pub fn image(graph: &mut Graph, z: &[Term]) -> Vec<Term> {
    let component = |products: &&[(i64, usize, usize)]| {
        let terms = products.iter().map(|(factor, a, b)| {
            let product = graph.multiply(&z[*a], &z[*b]);
            (quarters(*factor), product)
        });
        let terms: Vec<_> = terms.collect();
        graph.combine(&terms)
    };
    PRODUCTS.iter().map(component).collect()
}

/// J(z + δ) − J(z) as code: products of δ with z + δ/2, in which J(z) does not stand.
pub fn change(graph: &mut Graph, z: &[Term], delta: &[Term]) -> Vec<Term> {
    let half = Rational::new(1, 2);
    let pairs = z.iter().zip(delta);
    let middle: Vec<Term> = pairs
        .map(|(z, delta)| {
            graph.combine(&[(Rational::one(), z.clone()), (half.clone(), delta.clone())])
        })
        .collect();
    let component = |products: &&[(i64, usize, usize)]| {
        let mut terms = Vec::new();
        for (factor, a, b) in *products {
            terms.push((quarters(*factor), graph.multiply(&middle[*a], &delta[*b])));
            terms.push((quarters(*factor), graph.multiply(&delta[*a], &middle[*b])));
        }
        graph.combine(&terms)
    };
    PRODUCTS.iter().map(component).collect()
}

/// DJ(z)ᵀ w as code.
pub fn pull_back(graph: &mut Graph, z: &[Term], w: &[Term]) -> Vec<Term> {
    let mut sums = vec![Vec::new(); z.len()];
    for (products, w) in PRODUCTS.iter().zip(w) {
        for (factor, a, b) in *products {
            sums[*a].push((quarters(*factor), graph.multiply(&z[*b], w)));
            sums[*b].push((quarters(*factor), graph.multiply(&z[*a], w)));
        }
    }
    sums.iter().map(|sum| graph.combine(sum)).collect()
}

/// J(z).
pub fn image_of(z: &[f64]) -> [f64; 3] {
    PRODUCTS.map(|products| {
        let terms = products.iter();
        let sum: f64 = terms
            .map(|(factor, a, b)| *factor as f64 * (z[*a] * z[*b]))
            .sum();
        0.25 * sum
    })
}

/// DJ(z), three rows of four numbers. Its rows are orthogonal, of the length |z|/2.
pub fn slopes_of(z: &[f64]) -> [[f64; 4]; 3] {
    PRODUCTS.map(|products| {
        let mut row = [0.0; 4];
        for (factor, a, b) in products {
            row[*a] += 0.25 * *factor as f64 * z[*b];
            row[*b] += 0.25 * *factor as f64 * z[*a];
        }
        row
    })
}

/// A z with J(z) = x, the larger of its two complex numbers real.
pub fn section(x: &[f64]) -> [f64; 4] {
    let length = libm::hypot(libm::hypot(x[0], x[1]), x[2]);
    if length == 0.0 {
        return [0.0; 4];
    }
    let large = libm::sqrt(2.0 * (length + x[2].abs()));
    let [along, across] = [2.0 * x[0] / large, 2.0 * x[1] / large];
    match x[2] >= 0.0 {
        true => [large, along, 0.0, across],
        false => [along, large, -across, 0.0],
    }
}

/// a b as a sum of two doubles (T. J. Dekker, Numerische Mathematik 18 (1971)).
fn two_product(a: f64, b: f64) -> (f64, f64) {
    const SPLIT: f64 = 134_217_729.0;
    let halves = |v: f64| {
        let shifted = SPLIT * v;
        let high = shifted - (shifted - v);
        (high, v - high)
    };
    let (product, (a_high, a_low), (b_high, b_low)) = (a * b, halves(a), halves(b));
    let error = a_high * b_high - product + a_high * b_low + a_low * b_high + a_low * b_low;
    (product, error)
}

/// |x + low + δ|² − |x + low|² = Σ (2x + 2 low + δ)δ, rounded once or so.
pub fn grown(x: &[f64], low: &[f64], delta: &[f64]) -> f64 {
    let (mut sum, mut rest) = (0.0, 0.0);
    for ((x, low), delta) in x.iter().zip(low).zip(delta) {
        for (product, error) in [two_product(2.0 * x, *delta), two_product(*delta, *delta)] {
            let (next, lost) = two_sum(sum, product);
            sum = next;
            rest += lost + error;
        }
        rest += 2.0 * low * delta;
    }
    sum + rest
}
