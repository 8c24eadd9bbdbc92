//! The exponential chart R = exp \[q\]×, q = εp: Karasev's realization in closed form.

use leafwise_expression::{Arithmetic, Graph, Rational, Term};

use crate::functions::{COTANGENT, HALF_COSINE, HALF_SINE};
use crate::vector::{cross, dot, times};

/// θ/2π at which the chart is declared left: 1 − 2⁻¹⁰. There c has lost ten bits, since its
/// relative condition in θ² is θ²/(4π² − θ²).
const WALL: (i64, i64) = (1023, 1024);

/// The part of α even in q without x: c (x×q)×q, c = (1 − (θ/2) cot(θ/2))/θ², θ = ‖q‖.
pub(crate) fn even_part(graph: &mut Graph, moment: &[Term], q: &[Term]) -> Vec<Term> {
    let square = dot(graph, q, q);
    let coefficient = graph.apply_analytic(COTANGENT, 0, &square);
    let twice = cross(graph, moment, q);
    times(graph, &coefficient, &twice)
}

/// (cos(θ/2), sin(θ/2) q/θ), the quaternion of exp \[q\]×.
pub(crate) fn quaternion(graph: &mut Graph, q: &[Term]) -> Vec<Term> {
    let square = dot(graph, q, q);
    let sine = graph.apply_analytic(HALF_SINE, 0, &square);
    let mut quaternion = vec![graph.apply_analytic(HALF_COSINE, 0, &square)];
    quaternion.extend(times(graph, &sine, q));
    quaternion
}

/// The chart's radius 2π (1 − 2⁻¹⁰) against the angle, three times each.
pub(crate) fn guard(graph: &mut Graph, angle: Term) -> (Vec<Term>, Vec<Term>) {
    let pi = graph.pi();
    let radius = graph.scale(&Rational::new(2 * WALL.0, WALL.1), &pi);
    (vec![radius; 3], vec![angle; 3])
}
