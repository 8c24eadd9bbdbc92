//! The damped precession of one spin in a field that does not move, in closed form.
//!
//! With g = ∂H/∂s at rest, {s1,s2} = −κ s3 and the damping λ a of a spin s the motion is
//!
//! - ds/dt = κ g × s + λ a κ² (g × s) × s.
//!
//! S = |s| is constant. The spin turns about g by the angle κ t |g|. The part z = s·g/|g| obeys
//! dz/dt = −λ a κ² |g| (S² − z²), whose solution is a hyperbolic tangent. With q = κ t g, b = λ a κ, n = |q| and N = |b| S n
//! this is
//!
//! - p = q × s;
//! - s(t) − s = (sin n/n p + (cosh N − cos n)/n² q × p + b sinh N/N p × s)/(1 + E);
//! - E = cosh N − 1 − b (q·s) sinh N/N.
//!
//! Everything is even in n and N: nothing is divided by a field. Every summand is a product with p. So a spin along its
//! field rests to the last bit. No error of S² enters along s, where its roundings about 1 would all go one way.

use leafwise_expression::pairs::{EXPONENTIAL_MINUS_1, SINE, VERSINE};
use leafwise_expression::{AlgebraError, Arithmetic, Function, Graph, Rational, Term};

/// Added to the square of an angle before its root is taken: 2⁻³⁰⁰, which changes no number but those about 0. The inverse is squared
/// and cubed in derivatives, where spins rest too.
const SMALLEST: f64 = f64::from_bits((1023 - 300) << 52);

fn cross(graph: &mut Graph, a: &[Term], b: &[Term]) -> Vec<Term> {
    let component = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (left, right) = (graph.multiply(&a[j], &b[k]), graph.multiply(&a[k], &b[j]));
        graph.subtract(&left, &right)
    };
    (0..3).map(component).collect()
}

fn dot(graph: &mut Graph, a: &[Term], b: &[Term]) -> Term {
    let products = a.iter().zip(b).map(|(a, b)| graph.multiply(a, b));
    let products: Vec<(Rational, Term)> = products.map(|p| (Rational::one(), p)).collect();
    graph.combine(&products)
}

/// s(t) − s for the rotation vector `q` = κ t ∂H/∂s, and for the `damping` b = λ a κ where there is one.
///
/// # Errors
/// [`AlgebraError`] where a function has no code.
pub(super) fn increment(
    graph: &mut Graph,
    s: &[Term],
    q: &[Term],
    damping: Option<&Term>,
) -> Result<Vec<Term>, AlgebraError> {
    let tiny = Rational::from_f64(SMALLEST).expect("a finite number");
    let (one, tiny) = (graph.one(), graph.constant(&tiny));
    let square = dot(graph, q, q);
    let square = graph.add(&square, &tiny);
    let angle = graph.apply(Function::Sqrt, &square)?;
    let inverse = graph.divide(&one, &square)?;
    let sine = graph.apply_analytic(SINE, 0, &angle);
    let versine = graph.apply_analytic(VERSINE, 0, &angle);
    let first = graph.multiply(&sine, &angle);
    let first = graph.multiply(&first, &inverse);
    let second = graph.multiply(&versine, &inverse);
    let turned = cross(graph, q, s);
    let twice = cross(graph, q, &turned);
    let Some(b) = damping else {
        let parts = [(&first, &turned), (&second, &twice)];
        return Ok((0..3).map(|i| combined(graph, &parts, i)).collect());
    };
    let size = dot(graph, s, s);
    let along = dot(graph, q, s);
    let b2 = graph.multiply(b, b);
    let argument = graph.multiply(&b2, &size);
    let argument = graph.multiply(&argument, &square);
    let argument = graph.add(&argument, &tiny);
    let argument = graph.apply(Function::Sqrt, &argument)?;
    // With u = e^N − 1: sinh N = u (2 + u)/2(1 + u), cosh N − 1 = u²/2(1 + u), without cancellation.
    let u = graph.apply_analytic(EXPONENTIAL_MINUS_1, 0, &argument);
    let half = Rational::new(1, 2);
    let above = graph.add(&one, &u);
    let ratio = graph.divide(&u, &above)?;
    let ratio = graph.scale(&half, &ratio);
    let two_more = graph.add(&one, &above);
    let hyperbolic = graph.multiply(&ratio, &two_more);
    let hyperbolic = graph.divide(&hyperbolic, &argument)?;
    let growth = graph.multiply(&ratio, &u);
    let pull = graph.multiply(b, &hyperbolic);
    let toward = graph.multiply(&along, &pull);
    let excess = graph.subtract(&growth, &toward);
    let below = graph.add(&one, &excess);
    let scale = graph.divide(&one, &below)?;
    let raised = graph.multiply(&growth, &inverse);
    let second = graph.add(&second, &raised);
    let aside = cross(graph, &turned, s);
    let parts = [(&first, &turned), (&second, &twice), (&pull, &aside)];
    let component = |i: usize| {
        let sum = combined(graph, &parts, i);
        graph.multiply(&scale, &sum)
    };
    Ok((0..3).map(component).collect())
}

/// Σ c v_i over factors c and vectors v.
fn combined(graph: &mut Graph, parts: &[(&Term, &Vec<Term>)], i: usize) -> Term {
    let products = parts.iter();
    let products = products.map(|(c, v)| (Rational::one(), graph.multiply(c, &v[i])));
    let products: Vec<(Rational, Term)> = products.collect();
    graph.combine(&products)
}
