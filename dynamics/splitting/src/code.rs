//! Flows as straight-line code.

use leafwise_expression::graph::lift;
use leafwise_expression::{
    AlgebraError, Arithmetic, Function, Graph, Polynomial, Rational, Ring, Term,
};

use crate::entire::{EXPONENTIAL_MINUS_1, PHI_1, STUMPFF_1, STUMPFF_2};
use crate::flow::Motion;
use crate::piece::Piece;
use crate::schedule::Flow;

/// x(t) − x for the flow of a piece from the state `x` over the time `time`, coordinate by
/// coordinate; each of the size of the motion, formed without cancellation.
///
/// # Errors
/// [`AlgebraError`] where an adjoined function has no code.
pub fn flow_increment(
    graph: &mut Graph,
    ring: &Ring,
    piece: &Piece,
    time: &Term,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let square = graph.multiply(time, time);
    let mut wanted: Vec<Vec<(Term, Polynomial)>> = Vec::new();
    for motion in piece.motions() {
        match motion {
            Motion::Polynomial(series) => {
                let mut power = graph.one();
                let mut sum = Vec::with_capacity(series.len());
                for (k, term) in (1_i64..).zip(series) {
                    power = graph.multiply(&power, time);
                    power = graph.scale(&Rational::new(1, k), &power);
                    sum.push((power.clone(), term.clone()));
                }
                wanted.push(sum);
            }
            Motion::Exponential { base, rate } => {
                wanted.push(vec![(graph.one(), base.clone())]);
                wanted.push(vec![(time.clone(), rate.clone())]);
            }
            Motion::Affine { velocity, rate } => {
                wanted.push(vec![(time.clone(), velocity.clone())]);
                wanted.push(vec![(time.clone(), rate.clone())]);
            }
            Motion::Rotation {
                frequency,
                sine,
                versine,
            } => {
                let half = graph.scale(&Rational::new(1, 2), time);
                wanted.push(vec![(graph.one(), sine.clone())]);
                wanted.push(vec![(graph.one(), versine.clone())]);
                wanted.push(vec![(half, frequency.clone())]);
            }
            Motion::Oscillation {
                velocity,
                acceleration,
                square: lambda,
            } => {
                wanted.push(vec![(time.clone(), velocity.clone())]);
                wanted.push(vec![(square.clone(), acceleration.clone())]);
                wanted.push(vec![(square.clone(), lambda.clone())]);
            }
        }
    }
    let mut code = lift(graph, ring, &wanted, x)?.into_iter();
    let mut next = || code.next().expect("one term for each polynomial");
    let mut increment = Vec::with_capacity(x.len());
    for motion in piece.motions() {
        let first = next();
        increment.push(match motion {
            Motion::Polynomial(_) => first,
            Motion::Exponential { .. } => {
                let factor = graph.apply_analytic(EXPONENTIAL_MINUS_1, 0, &next());
                graph.multiply(&first, &factor)
            }
            Motion::Affine { .. } => {
                let factor = graph.apply_analytic(PHI_1, 0, &next());
                graph.multiply(&first, &factor)
            }
            Motion::Rotation { .. } => {
                // sin θ = 2 sin(θ/2) cos(θ/2), 1 − cos θ = 2 sin²(θ/2).
                let (second, half_angle) = (next(), next());
                let sine = graph.apply(Function::Sin, &half_angle)?;
                let cosine = graph.apply(Function::Cos, &half_angle)?;
                let twice = graph.scale(&Rational::from_integer(2), &sine);
                let (odd, even) = (
                    graph.multiply(&twice, &cosine),
                    graph.multiply(&twice, &sine),
                );
                let (odd, even) = (graph.multiply(&first, &odd), graph.multiply(&second, &even));
                graph.add(&odd, &even)
            }
            Motion::Oscillation { .. } => {
                let (second, argument) = (next(), next());
                let odd = graph.apply_analytic(STUMPFF_1, 0, &argument);
                let even = graph.apply_analytic(STUMPFF_2, 0, &argument);
                let (odd, even) = (graph.multiply(&first, &odd), graph.multiply(&second, &even));
                graph.add(&odd, &even)
            }
        });
    }
    Ok(increment)
}

/// The product of flows of `pieces`, each over its part of the time: its increment Φ(x) − x, the sum of
/// the flows'.
///
/// # Errors
/// Those of [`flow_increment`].
///
/// # Panics
/// Where a part is not finite.
pub fn product_increment(
    graph: &mut Graph,
    ring: &Ring,
    pieces: &[Piece],
    flows: &[Flow],
    time: &Term,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let mut state = x.to_vec();
    let mut sums: Vec<Vec<(Rational, Term)>> = vec![Vec::new(); x.len()];
    for flow in flows {
        let part = Rational::from_f64(flow.part).expect("a part of the time is finite");
        let time = graph.scale(&part, time);
        let increment = flow_increment(graph, ring, &pieces[flow.piece], &time, &state)?;
        for ((value, sum), change) in state.iter_mut().zip(&mut sums).zip(increment) {
            *value = graph.add(value, &change);
            sum.push((Rational::one(), change));
        }
    }
    Ok(sums.iter().map(|sum| graph.combine(sum)).collect())
}
